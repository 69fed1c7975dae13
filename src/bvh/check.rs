//! The invariants of a tree, checked.
//!
//! Comes in: a tree and the triangles it was built over. Goes out: nothing, or a sentence about the first broken
//! invariant. May be assumed: every node is looked at; it is for tests and self-tests, not for every render.

use super::wide::{Child, bounds_of};
use super::{Aabb, Accel, BinaryBvh, WideBvh};
use crate::interface::{MAX_TREE_DEPTH, WIDE_CHILDREN, WIDE_LEAF_TRIANGLES};
use crate::scene::Triangle;

impl Accel {
    /// Checks that each triangle stands in exactly one leaf, each node below exactly one parent, boxes contain what is
    /// below them, leaves are small, and depth is what it says and within [`MAX_TREE_DEPTH`].
    pub fn check(&self, triangles: &[Triangle]) -> Result<(), String> {
        match self {
            Accel::Brute => Ok(()),
            Accel::Binary(tree) => check_binary(tree, triangles),
            Accel::Wide(tree) => check_wide(tree, triangles),
        }
    }
}

fn require(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}

/// Counts visits, to find what is listed twice or never.
struct Once(Vec<bool>);

impl Once {
    fn visit(&mut self, index: u32, what: &str) -> Result<(), String> {
        let seen = self.0.get_mut(index as usize).ok_or_else(|| format!("{what} {index} is out of range"))?;
        require(!std::mem::replace(seen, true), || format!("{what} {index} is listed twice"))
    }

    fn finish(&self, what: &str) -> Result<(), String> {
        self.0.iter().position(|seen| !seen).map_or(Ok(()), |index| Err(format!("{what} {index} is listed nowhere")))
    }
}

fn check_order(order: &[u32], triangles: &[Triangle]) -> Result<(), String> {
    let mut ids = Once(vec![false; triangles.len()]);
    order.iter().try_for_each(|&id| ids.visit(id, "triangle"))?;
    ids.finish("triangle")
}

fn check_depth(found: u32, stated: u32) -> Result<(), String> {
    require(found == stated, || format!("depth is {found}, stated as {stated}"))?;
    require(found <= MAX_TREE_DEPTH, || format!("depth {found} is above {MAX_TREE_DEPTH}"))
}

fn check_binary(tree: &BinaryBvh, triangles: &[Triangle]) -> Result<(), String> {
    check_order(&tree.order, triangles)?;
    let mut nodes = Once(vec![false; tree.nodes.len()]);
    let mut positions = Once(vec![false; tree.order.len()]);
    let mut pending = if tree.nodes.is_empty() { Vec::new() } else { vec![(0, 0)] };
    let mut depth = 0;
    while let Some((index, level)) = pending.pop() {
        nodes.visit(index, "node")?;
        let node = tree.nodes[index as usize];
        if node.is_leaf() {
            require(node.count <= WIDE_LEAF_TRIANGLES, || format!("leaf {index} holds {}", node.count))?;
            (node.first..node.first + node.count).try_for_each(|position| positions.visit(position, "position"))?;
            let ids = &tree.order[node.first as usize..(node.first + node.count) as usize];
            let exact = bounds_of(ids, triangles);
            require(node.bounds == exact, || format!("leaf {index} has box {:?}, not {exact:?}", node.bounds))?;
        } else {
            depth = depth.max(level + 1);
            require(node.first > index && (node.first as usize) < tree.nodes.len() - 1, || {
                format!("node {index} has children at {}", node.first)
            })?;
            let [left, right] = [node.first, node.first + 1].map(|child| tree.nodes[child as usize].bounds);
            let exact = left.union(right);
            require(node.bounds == exact, || format!("node {index} has box {:?}, not {exact:?}", node.bounds))?;
            pending.extend([(node.first, level + 1), (node.first + 1, level + 1)]);
        }
    }
    nodes.finish("node")?;
    positions.finish("position")?;
    check_depth(depth, tree.depth)
}

fn check_wide(tree: &WideBvh, triangles: &[Triangle]) -> Result<(), String> {
    check_order(&tree.order, triangles)?;
    let mut nodes = Once(vec![false; tree.nodes.len()]);
    let mut positions = Once(vec![false; tree.order.len()]);
    let mut depth = 0;
    if !tree.nodes.is_empty() {
        walk_wide(tree, triangles, (0, 1), &mut nodes, &mut positions, &mut depth)?;
    }
    nodes.finish("node")?;
    positions.finish("position")?;
    check_depth(depth, tree.depth)
}

/// Checks a wide node on its level and all below; returns the exact bounds of the triangles below. Recursion is bounded
/// by `MAX_TREE_DEPTH` levels.
fn walk_wide(
    tree: &WideBvh,
    triangles: &[Triangle],
    (index, level): (u32, u32),
    nodes: &mut Once,
    positions: &mut Once,
    depth: &mut u32,
) -> Result<Aabb, String> {
    nodes.visit(index, "node")?;
    *depth = level.max(*depth);
    require(level <= MAX_TREE_DEPTH, || format!("level {level} is above {MAX_TREE_DEPTH}"))?;
    let node = &tree.nodes[index as usize];
    let mut bounds = Aabb::EMPTY;
    let mut next_position = node.first_triangle;
    for slot in 0..WIDE_CHILDREN as usize {
        let inner = node.inner_mask >> slot & 1 == 1;
        let meta = node.meta[slot];
        require(inner == (meta == 0b001_11000 | slot as u8), || format!("node {index} has meta {meta:#b} in {slot}"))?;
        let exact = match node.child(slot) {
            None => continue,
            Some(Child::Node(child)) => walk_wide(tree, triangles, (child, level + 1), nodes, positions, depth)?,
            Some(Child::Leaf { first, count }) => {
                require(matches!(meta >> 5, 1 | 3 | 7) && meta & 31 <= 21, || {
                    format!("node {index} has meta {meta:#b} in slot {slot}")
                })?;
                require(first == next_position, || format!("node {index}: the leaf in slot {slot} is out of order"))?;
                next_position = first + count;
                (first..next_position).try_for_each(|position| positions.visit(position, "position"))?;
                bounds_of(&tree.order[first as usize..next_position as usize], triangles)
            }
        };
        require(node.slot_contains(slot, exact), || format!("node {index}: slot {slot} does not hold {exact:?}"))?;
        bounds = bounds.union(exact);
    }
    Ok(bounds)
}
