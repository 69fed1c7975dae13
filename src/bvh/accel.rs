//! What is common to all ways of finding hits.
//!
//! Comes in: a tree, or none. Goes out: the order in which triangles are to be laid out, and the size of the stack that
//! a traversal needs. May be assumed: the order is a permutation of the ids.

use std::borrow::Cow;

use super::{Accel, BinaryBvh, WideBvh};

impl Accel {
    /// No tree.
    pub fn brute() -> Accel {
        Accel::Brute
    }

    /// Leaf order: position `i` holds the triangle with this id. File order where there is no tree.
    pub fn order(&self, triangle_count: usize) -> Cow<'_, [u32]> {
        match self {
            Accel::Brute => Cow::Owned((0..triangle_count as u32).collect()),
            Accel::Binary(tree) => Cow::Borrowed(&tree.order),
            Accel::Wide(tree) => Cow::Borrowed(&tree.order),
        }
    }

    /// Entries that a traversal's stack needs, at least 1. Each level on the way down leaves at most one entry: the
    /// sibling in a binary tree, the rest of the node group in a wide one.
    pub fn stack_entries(&self) -> u32 {
        match self {
            Accel::Brute => 1,
            Accel::Binary(tree) => tree.depth.max(1),
            Accel::Wide(tree) => tree.depth.max(1),
        }
    }
}

impl From<BinaryBvh> for Accel {
    fn from(tree: BinaryBvh) -> Accel {
        Accel::Binary(tree)
    }
}

impl From<WideBvh> for Accel {
    fn from(tree: WideBvh) -> Accel {
        Accel::Wide(tree)
    }
}
