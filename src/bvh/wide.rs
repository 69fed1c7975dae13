//! The compressed 8-wide tree.
//!
//! Comes in: the triangles of a scene and a choice of builder for the binary tree underneath. Goes out: a [`WideBvh`].
//! May be assumed: child boxes contain their contents in exact arithmetic; a node's inner children stand side by side
//! in slot order; the triangles of its leaves follow each other in slot order; and the same tree results whatever the
//! number of threads.

use glam::Vec3;
use rayon::prelude::*;
use std::collections::VecDeque;

use super::collapse::Collapse;
use super::{Aabb, BinaryBvh, Builder, WideBvh, WideNode, slots};
use crate::interface::WIDE_CHILDREN;
use crate::scene::Triangle;

/// Subtrees that are written in parallel: enough to keep threads busy, a fixed number so that the tree is the same
/// whatever theirs.
const PARTS: usize = 128;
const WIDTH: usize = WIDE_CHILDREN as usize;

/// Bit of [`WideNode::meta`] that marks an inner child; the low five bits hold 24 plus its slot.
const META_INNER: u8 = 0b001_11000;

impl WideBvh {
    /// Builds a binary tree of one triangle a leaf and collapses it.
    pub fn build(triangles: &[Triangle], builder: Builder) -> WideBvh {
        WideBvh::collapse(&BinaryBvh::with_leaves(triangles, builder, 1))
    }

    /// Collapses a binary tree of at most [`crate::interface::WIDE_LEAF_TRIANGLES`] triangles a leaf, as the builders
    /// make them.
    pub(super) fn collapse(binary: &BinaryBvh) -> WideBvh {
        if binary.nodes.is_empty() {
            return WideBvh::default();
        }
        let collapse = Collapse::solve(&binary.nodes);
        let source = Source { binary, collapse: &collapse };
        let mut wide = Part::start();
        let mut pending = VecDeque::from([Pending { place: 0, binary: 0, level: 1 }]);
        // Breadth first from the root, until there are enough subtrees to share out ...
        while let Some(next) = if pending.len() < PARTS { pending.pop_front() } else { None } {
            pending.extend(wide.write(&source, next));
        }
        // ... each of which is written on its own, depth first, and appended.
        let parts: Vec<(Pending, Part)> =
            Vec::from(pending).into_par_iter().map(|root| (root, Part::of_subtree(&source, root))).collect();
        for (root, part) in parts {
            wide.append(root, part);
        }
        WideBvh { nodes: wide.nodes, order: wide.order, depth: wide.depth }
    }
}

/// What a wide tree is made from.
struct Source<'a> {
    binary: &'a BinaryBvh,
    collapse: &'a Collapse<'a>,
}

/// A wide node still to be written: where, for which binary node, on which level (the root's is 1).
#[derive(Clone, Copy)]
struct Pending {
    place: u32,
    binary: u32,
    level: u32,
}

/// A tree, or a subtree with indices of its own.
struct Part {
    nodes: Vec<WideNode>,
    order: Vec<u32>,
    depth: u32,
}

impl Part {
    fn start() -> Part {
        Part { nodes: vec![WideNode::default()], order: Vec::new(), depth: 0 }
    }

    fn of_subtree(source: &Source, root: Pending) -> Part {
        let mut part = Part::start();
        let mut pending = vec![Pending { place: 0, ..root }];
        while let Some(next) = pending.pop() {
            let first = pending.len();
            pending.extend(part.write(source, next));
            pending[first..].reverse();
        }
        part
    }

    /// Writes one node and lists its inner children, in slot order.
    fn write(&mut self, source: &Source, at: Pending) -> impl Iterator<Item = Pending> + use<> {
        self.depth = self.depth.max(at.level);
        let boxes = |node: u32| source.binary.nodes[node as usize].bounds;
        let bounds = boxes(at.binary);
        let mut children = [0; WIDTH];
        let count = source.collapse.children(at.binary, &mut children);
        let mut centres = [Vec3::ZERO; WIDTH];
        for (centre, &child) in centres.iter_mut().zip(&children[..count]) {
            *centre = boxes(child).centre();
        }
        let slots = slots::assign(&centres[..count], bounds.centre());
        let mut by_slot = [None; WIDTH];
        for (&slot, &child) in slots.iter().zip(&children[..count]) {
            by_slot[slot] = Some(child);
        }

        let (first_child, first_triangle) = (self.nodes.len() as u32, self.order.len() as u32);
        let mut node = WideNode { first_child, first_triangle, ..WideNode::default() };
        node.set_grid(bounds);
        let mut inner = [None; WIDTH];
        let mut inner_count = 0;
        for (slot, child) in by_slot.into_iter().enumerate() {
            let Some(child) = child else { continue };
            node.set_box(slot, boxes(child));
            debug_assert!(node.slot_contains(slot, boxes(child)));
            if source.collapse.is_leaf(child) {
                let (first, count) = source.collapse.triangles(child);
                let offset = self.order.len() as u32 - first_triangle;
                node.meta[slot] = (((1u32 << count) - 1) << 5 | offset) as u8;
                self.order.extend_from_slice(&source.binary.order[first as usize..(first + count) as usize]);
            } else {
                node.meta[slot] = META_INNER | slot as u8;
                node.inner_mask |= 1 << slot;
                inner[slot] = Some(Pending { place: first_child + inner_count, binary: child, level: at.level + 1 });
                inner_count += 1;
            }
        }
        self.nodes[at.place as usize] = node;
        self.nodes.resize(self.nodes.len() + inner_count as usize, WideNode::default());
        inner.into_iter().flatten()
    }

    /// Appends a subtree; its root goes to the place kept for it.
    fn append(&mut self, root: Pending, part: Part) {
        // Node `i` of the subtree, `i >= 1`, lands at `node_base + i`.
        let (node_base, order_base) = (self.nodes.len() as u32 - 1, self.order.len() as u32);
        let mut moved = part.nodes.into_iter().map(|mut node| {
            node.first_child += node_base;
            node.first_triangle += order_base;
            node
        });
        if let Some(node) = moved.next() {
            self.nodes[root.place as usize] = node;
        }
        self.nodes.extend(moved);
        self.order.extend(part.order);
        self.depth = self.depth.max(part.depth);
    }
}

/// What a slot of a wide node holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// An inner child: its index in [`WideBvh::nodes`].
    Node(u32),
    /// A leaf: first leaf-order position and number of triangles.
    Leaf {
        /// First position in leaf order.
        first: u32,
        /// Number of triangles, 1 to 3.
        count: u32,
    },
}

impl WideNode {
    /// What a slot (0 to 7) holds; `None` where it is empty.
    pub fn child(&self, slot: usize) -> Option<Child> {
        let meta = self.meta[slot];
        if meta == 0 {
            None
        } else if self.inner_mask >> slot & 1 == 1 {
            let before = u32::from(self.inner_mask) & ((1 << slot) - 1);
            Some(Child::Node(self.first_child + before.count_ones()))
        } else {
            let first = self.first_triangle + u32::from(meta & 31);
            Some(Child::Leaf { first, count: u32::from(meta >> 5).count_ones() })
        }
    }

    /// Half of the surface area of a slot's box.
    pub(super) fn slot_half_area(&self, slot: usize) -> f64 {
        let [x, y, z] = self.slot_extent(slot);
        x * y + y * z + z * x
    }
}

/// Exact bounds of the triangles at some leaf-order positions.
pub(super) fn bounds_of(order: &[u32], triangles: &[Triangle]) -> Aabb {
    order
        .iter()
        .filter_map(|&id| triangles.get(id as usize))
        .fold(Aabb::EMPTY, |bounds, triangle| bounds.union(Aabb::of_triangle(&triangle.positions)))
}
