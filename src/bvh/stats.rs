//! Figures of a tree, for `-v` and the study.
//!
//! Comes in: a tree and the triangles it was built over. Goes out: [`TreeStats`]. May be assumed: nothing is changed.

use std::fmt;

use super::wide::Child;
use super::{Aabb, Accel, BinaryBvh, WideBvh, collapse, sah};
use crate::interface::{BINARY_NODE_TEXELS, WIDE_CHILDREN, WIDE_NODE_TEXELS};

/// Figures of a tree.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct TreeStats {
    /// `brute`, `binary` or `wide`.
    pub kind: &'static str,
    /// Triangles listed by leaves.
    pub triangles: usize,
    /// Nodes; leaves of a binary tree are nodes, those of a wide one are not.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Levels of inner nodes on the longest way down.
    pub depth: u32,
    /// Expected cost of a ray that meets the root's box, by the surface-area heuristic: for a binary tree in triangle
    /// tests, for a wide one in node visits with the builder's weight of a triangle.
    pub sah_cost: f64,
    /// Expected triangle tests over expected node visits of such a ray; 0 where there is no inner node.
    pub tests_a_visit: f64,
    /// Mean number of children of a wide node, 2 for a binary one; 0 where there is no inner node.
    pub mean_children: f64,
    /// `leaf_sizes[n]` leaves hold `n` triangles.
    pub leaf_sizes: Vec<usize>,
    /// Bytes of the node records.
    pub node_bytes: usize,
}

impl Accel {
    /// Figures of the tree; `triangle_count` is the scene's.
    pub fn stats(&self, triangle_count: usize) -> TreeStats {
        match self {
            Accel::Brute => TreeStats {
                kind: "brute",
                triangles: triangle_count,
                sah_cost: triangle_count as f64,
                ..TreeStats::default()
            },
            Accel::Binary(tree) => binary(tree),
            Accel::Wide(tree) => wide(tree),
        }
    }
}

fn binary(tree: &BinaryBvh) -> TreeStats {
    let mut stats = TreeStats { kind: "binary", depth: tree.depth, nodes: tree.nodes.len(), ..TreeStats::default() };
    let (mut cost, mut tests) = (0.0, 0.0);
    for node in &tree.nodes {
        let area = f64::from(node.bounds.half_area());
        if node.is_leaf() {
            stats.add_leaf(node.count as usize);
            tests += area * f64::from(node.count);
        } else {
            cost += area * f64::from(sah::NODE_COST);
        }
    }
    stats.tests_a_visit = relative(tests, cost);
    stats.sah_cost = relative(cost + tests, tree.nodes.first().map_or(0.0, |root| f64::from(root.bounds.half_area())));
    stats.mean_children = if stats.nodes > stats.leaves { 2.0 } else { 0.0 };
    stats.node_bytes = tree.nodes.len() * BINARY_NODE_TEXELS as usize * 16;
    stats
}

fn wide(tree: &WideBvh) -> TreeStats {
    let mut stats = TreeStats { kind: "wide", depth: tree.depth, nodes: tree.nodes.len(), ..TreeStats::default() };
    let (mut tests, mut children) = (0.0, 0usize);
    let root_area = tree.nodes.first().map_or(0.0, wide_root_area);
    let mut visits = root_area;
    for node in &tree.nodes {
        for slot in 0..WIDE_CHILDREN as usize {
            let area = node.slot_half_area(slot);
            match node.child(slot) {
                None => continue,
                Some(Child::Node(_)) => visits += area,
                Some(Child::Leaf { count, .. }) => {
                    stats.add_leaf(count as usize);
                    tests += area * f64::from(count);
                }
            }
            children += 1;
        }
    }
    stats.tests_a_visit = relative(tests, visits);
    let cost = visits * f64::from(collapse::NODE_COST) + tests * f64::from(collapse::TRIANGLE_COST);
    stats.sah_cost = relative(cost, root_area);
    stats.mean_children = children as f64 / tree.nodes.len().max(1) as f64;
    stats.node_bytes = tree.nodes.len() * WIDE_NODE_TEXELS as usize * 16;
    stats
}

/// Half area of the box around all children of the root.
fn wide_root_area(root: &super::WideNode) -> f64 {
    let used = (0..WIDE_CHILDREN as usize).filter(|&slot| root.child(slot).is_some());
    let bounds = used.map(|slot| root.slot_bounds(slot)).fold(Aabb::EMPTY, Aabb::union);
    f64::from(bounds.half_area())
}

fn relative(value: f64, to: f64) -> f64 {
    if to > 0.0 { value / to } else { 0.0 }
}

impl TreeStats {
    fn add_leaf(&mut self, triangles: usize) {
        if self.leaf_sizes.len() <= triangles {
            self.leaf_sizes.resize(triangles + 1, 0);
        }
        self.leaf_sizes[triangles] += 1;
        self.leaves += 1;
        self.triangles += triangles;
    }
}

impl fmt::Display for TreeStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.kind == "brute" {
            return write!(f, "no tree: {} triangles a ray", self.triangles);
        }
        write!(
            f,
            "{} tree: {} triangles, {} nodes ({:.1} MiB), depth {}, {:.2} children a node, SAH cost {:.2}, {:.2} tests a visit, \
             leaves of",
            self.kind,
            self.triangles,
            self.nodes,
            self.node_bytes as f64 / (1024.0 * 1024.0),
            self.depth,
            self.mean_children,
            self.sah_cost,
            self.tests_a_visit
        )?;
        for (size, leaves) in self.leaf_sizes.iter().enumerate().filter(|(_, leaves)| **leaves > 0) {
            write!(f, " {size}: {leaves}")?;
        }
        Ok(())
    }
}
