//! The binary tree.
//!
//! Comes in: the triangles of a scene and a choice of builder. Goes out: a [`BinaryBvh`]. May be assumed: a parent's box
//! is the exact union of its children's, a parent stands before its children, a left subtree before the right one, and
//! there are at most [`MAX_TREE_DEPTH`](crate::interface::MAX_TREE_DEPTH) levels of inner nodes.

use rayon::prelude::*;

use super::median::Median;
use super::primitive::{Primitive, primitives};
use super::sah::BinnedSah;
use super::subdivide::subdivide;
use super::{BinaryBvh, BinaryNode, Builder};
use crate::interface::WIDE_LEAF_TRIANGLES;
use crate::scene::Triangle;

impl BinaryBvh {
    /// Builds the tree that is traversed as it is: up to [`WIDE_LEAF_TRIANGLES`] triangles a leaf where the
    /// surface-area heuristic finds that cheaper, one by the median builder.
    pub fn build(triangles: &[Triangle], builder: Builder) -> BinaryBvh {
        match builder {
            Builder::Sah => BinaryBvh::with_leaves(triangles, builder, WIDE_LEAF_TRIANGLES),
            Builder::Median => BinaryBvh::with_leaves(triangles, builder, 1),
        }
    }

    /// Builds a tree of at most `leaf_triangles` triangles a leaf (0 counts as 1).
    pub fn with_leaves(triangles: &[Triangle], builder: Builder, leaf_triangles: u32) -> BinaryBvh {
        let mut primitives = primitives(triangles);
        let leaf = leaf_triangles as usize;
        let (nodes, depth) = match builder {
            Builder::Sah => subdivide(&mut primitives, leaf, &BinnedSah),
            Builder::Median => subdivide(&mut primitives, leaf, &Median),
        };
        BinaryBvh { nodes, order: primitives.par_iter().map(Primitive::id).collect(), depth }
    }
}

impl BinaryNode {
    /// Whether the node lists triangles rather than children.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}
