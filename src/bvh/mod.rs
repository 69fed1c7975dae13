//! Stage 2: a tree of boxes over the triangles.
//!
//! Comes in: the triangles of a scene. Goes out: an [`Accel`], a binary or wide tree with the order in which its leaves
//! list the triangles, or no tree at all. Trees are built on the CPU, in parallel where it pays.

use crate::named::named;

pub mod aabb;
mod accel;
mod binary;
mod check;
mod collapse;
pub mod intersect;
mod median;
mod primitive;
mod quantise;
mod sah;
mod slots;
mod split;
pub mod stats;
mod subdivide;
pub mod traverse;
mod traverse_wide;
mod wide;

pub use aabb::Aabb;
pub use intersect::{Hit, Intersector, Ray};
pub use stats::TreeStats;
pub use traverse::{Tracer, Work};

/// What finds the hit of a ray.
#[derive(Clone, Debug)]
pub enum Accel {
    /// No tree: every ray tests every triangle, in file order.
    Brute,
    /// Binary tree.
    Binary(BinaryBvh),
    /// Compressed 8-wide tree.
    Wide(WideBvh),
}

/// A binary tree over triangles. Node 0 is the root; there is none where there are no triangles.
#[derive(Clone, Debug, Default)]
pub struct BinaryBvh {
    /// Nodes; siblings stand side by side.
    pub nodes: Vec<BinaryNode>,
    /// Leaf order: position `i` of a leaf's range holds the triangle with id `order[i]`.
    pub order: Vec<u32>,
    /// Levels of inner nodes on the longest way down: a traversal stack of this many entries is enough.
    pub depth: u32,
}

/// A node of the binary tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinaryNode {
    /// Box around every triangle below.
    pub bounds: Aabb,
    /// Inner node: index of the first of its two children. Leaf: first position in leaf order.
    pub first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

/// A compressed 8-wide tree (Ylitie, Karras and Laine, HPG 2017). Node 0 is the root.
#[derive(Clone, Debug, Default)]
pub struct WideBvh {
    /// Nodes; the inner children of a node stand side by side.
    pub nodes: Vec<WideNode>,
    /// Leaf order: position `i` of a leaf's range holds the triangle with id `order[i]`.
    pub order: Vec<u32>,
    /// Levels of nodes on the longest way down: a traversal stack of this many entries is enough.
    pub depth: u32,
}

/// A compressed wide node: eight quantised child boxes in a local grid.
///
/// Child `i` spans `origin + quantised * 2^exponent` per axis, rounded outwards so that it contains its contents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WideNode {
    /// Bits of the f32 grid origin, per axis.
    pub origin: [u32; 3],
    /// Biased f32 exponents of the grid's cell size, per axis (cell size = `f32::from_bits(e << 23)`).
    pub exponent: [u8; 3],
    /// Bit `i`: the child in slot `i` is an inner node.
    pub inner_mask: u8,
    /// Index of the first inner child; the others follow in slot order.
    pub first_child: u32,
    /// First position in leaf order of this node's triangles; its leaves' ranges follow each other in slot order.
    pub first_triangle: u32,
    /// Per slot: 0 empty; inner child `0b001_11sss` (24 + slot); leaf: unary triangle count in bits 5..8 (1 → 001,
    /// 2 → 011, 3 → 111) and in bits 0..5 the offset of its first triangle from `first_triangle` (0 to 23).
    pub meta: [u8; 8],
    /// Quantised lower corners, per axis and slot.
    pub low: [[u8; 8]; 3],
    /// Quantised upper corners, per axis and slot.
    pub high: [[u8; 8]; 3],
}

named! {
    /// Which builder makes the binary tree.
    pub enum Builder = Sah {
        /// Binned surface-area heuristic.
        Sah = "sah",
        /// The thesis's: longest axis, median by quick-select, one triangle a leaf.
        Median = "median",
    }
}
