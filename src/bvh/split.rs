//! How a range of primitives is cut in two: what a rule of a builder answers.
//!
//! Comes in: a range of primitives with its bounds. Goes out: that it is a leaf, or its two parts.

use super::primitive::{Bounds, Primitive};

/// A rule that cuts a range in two.
pub(super) trait Split: Sync {
    /// Says what becomes of a range of at least two primitives, and reorders it where that is a cut.
    fn split(&self, primitives: &mut [Primitive], bounds: &Bounds, leaf_triangles: usize) -> Advice;
}

/// What a rule makes of a range.
pub(super) enum Advice {
    /// One leaf is better than any cut.
    Leaf,
    /// The range has been cut.
    Cut(Parts),
    /// No cut was found; the middle stands in for it.
    NoCut,
}

/// A range cut in two.
pub(super) struct Parts {
    /// Length of the first part.
    pub middle: usize,
    /// Bounds of the parts.
    pub bounds: [Bounds; 2],
}

impl Parts {
    /// Of a range whose first `middle` primitives are the first part.
    pub fn at(middle: usize, primitives: &[Primitive]) -> Parts {
        let (left, right) = primitives.split_at(middle);
        Parts { middle, bounds: [Bounds::of(left), Bounds::of(right)] }
    }
}
