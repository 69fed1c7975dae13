//! The top-down recursion that both builders share.
//!
//! Comes in: primitives, the largest leaf, and a rule that cuts a range in two. Goes out: the nodes of a binary tree,
//! siblings side by side, a parent before its children, a left subtree before the right one; and the tree's depth.
//! The primitives are left in leaf order. May be assumed: the same tree whatever the number of threads, and at most
//! [`MAX_TREE_DEPTH`] levels of inner nodes whatever the input.
//!
//! # Depth
//!
//! A range of `n` primitives is entered with `levels` left, and `ceil(log2 n) <= levels` always holds: at the root
//! because `n < 2^32` and `levels` is 64; further down because a cut is kept only if the larger part satisfies
//! `ceil(log2 part) <= levels - 1`, and is replaced by a cut in the middle otherwise, whose larger part `ceil(n / 2)`
//! has `ceil(log2 ceil(n / 2)) = ceil(log2 n) - 1`. A range with no level left is thus a single primitive, a leaf.
//!
//! # Place
//!
//! A subtree of `n` primitives has at most `2 n - 2` nodes below its root. They are given that much room in advance,
//! so subtrees are built in parallel into disjoint slices, and where a node stands depends on the input alone. Leaves
//! of several primitives leave gaps, closed by a last pass.

use rayon::iter::ParallelIterator;

use super::median;
use super::primitive::{Bounds, Primitive};
use super::split::{Advice, Parts, Split};
use super::{Aabb, BinaryNode};
use crate::interface::MAX_TREE_DEPTH;

/// Ranges below this length are not worth a task of their own.
const TASK: usize = 1 << 12;

/// Builds the tree of all primitives.
pub(super) fn subdivide(
    primitives: &mut [Primitive],
    leaf_triangles: usize,
    rule: &impl Split,
) -> (Vec<BinaryNode>, u32) {
    if primitives.is_empty() {
        return (Vec::new(), 0);
    }
    let gap = BinaryNode { bounds: Aabb::EMPTY, first: 0, count: 0 };
    // By all threads: most of what it takes is the system's time for fresh memory.
    let mut nodes: Vec<BinaryNode> = rayon::iter::repeat_n(gap, 2 * primitives.len() - 1).collect();
    let (root, below) = nodes.split_at_mut(1);
    let place = Place { node: &mut root[0], below, below_first: 1, first: 0, levels: MAX_TREE_DEPTH };
    let bounds = Bounds::of(primitives);
    let depth = grow(primitives, &bounds, place, leaf_triangles, rule);
    if leaf_triangles > 1 {
        nodes = close_gaps(&nodes);
    }
    (nodes, depth)
}

/// Where a subtree goes.
struct Place<'a> {
    /// Its root.
    node: &'a mut BinaryNode,
    /// Room for the nodes below, and the index of the first.
    below: &'a mut [BinaryNode],
    below_first: u32,
    /// Leaf-order position of its first primitive.
    first: u32,
    /// Levels of inner nodes that it may have.
    levels: u32,
}

fn grow(primitives: &mut [Primitive], bounds: &Bounds, place: Place, leaf_triangles: usize, rule: &impl Split) -> u32 {
    let count = primitives.len();
    place.node.bounds = bounds.boxes.aabb();
    let advice = if count < 2 { Advice::Leaf } else { rule.split(primitives, bounds, leaf_triangles) };
    let Parts { middle, bounds: [left_bounds, right_bounds] } = match advice {
        Advice::Leaf if count <= leaf_triangles.max(1) => {
            place.node.first = place.first;
            place.node.count = count as u32;
            return 0;
        }
        Advice::Cut(parts) if fits(count, parts.middle, place.levels) => parts,
        _ => median::halve(primitives, bounds),
    };
    place.node.first = place.below_first;
    place.node.count = 0;

    let (left, right) = primitives.split_at_mut(middle);
    let (pair, below) = place.below.split_at_mut(2);
    let (left_node, right_node) = pair.split_at_mut(1);
    let (left_below, right_below) = below.split_at_mut(2 * middle - 2);
    let left_place = Place {
        node: &mut left_node[0],
        below: left_below,
        below_first: place.below_first + 2,
        first: place.first,
        levels: place.levels - 1,
    };
    let right_place = Place {
        node: &mut right_node[0],
        below: right_below,
        below_first: place.below_first + 2 * middle as u32,
        first: place.first + middle as u32,
        levels: place.levels - 1,
    };
    let grow_left = || grow(left, &left_bounds, left_place, leaf_triangles, rule);
    let grow_right = || grow(right, &right_bounds, right_place, leaf_triangles, rule);
    let (left_depth, right_depth) =
        if count >= TASK { rayon::join(grow_left, grow_right) } else { (grow_left(), grow_right()) };
    1 + left_depth.max(right_depth)
}

/// Whether both parts are non-empty and can still be divided within the levels left.
fn fits(count: usize, middle: usize, levels: u32) -> bool {
    let larger = middle.max(count.saturating_sub(middle));
    middle > 0 && middle < count && larger.next_power_of_two().trailing_zeros() < levels
}

/// Copies the reachable nodes to the front of a new array, in the same order.
fn close_gaps(nodes: &[BinaryNode]) -> Vec<BinaryNode> {
    let mut packed = Vec::with_capacity(nodes.len());
    packed.push(nodes[0]);
    let mut pending = vec![0usize];
    while let Some(index) = pending.pop() {
        let node = packed[index];
        if node.count == 0 {
            let first = packed.len();
            packed.push(nodes[node.first as usize]);
            packed.push(nodes[node.first as usize + 1]);
            packed[index].first = first as u32;
            pending.push(first + 1);
            pending.push(first);
        }
    }
    packed
}
