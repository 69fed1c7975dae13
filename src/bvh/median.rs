//! The thesis's builder: longest axis, median, one triangle a leaf.
//!
//! Comes in: a range of primitives. Goes out: its two halves, cut at the median of the centres along the axis where
//! they spread most, found by quick-select. May be assumed: halves differ by at most one primitive, so a tree of `n`
//! triangles is `ceil(log2 n)` levels deep; equal centres are told apart by id, so the halves do not depend on the
//! order in which the primitives came.

use super::primitive::{Bounds, Primitive};
use super::subdivide::Split;

/// Cuts every range at its median.
pub(super) struct Median;

impl Split for Median {
    fn split(&self, primitives: &mut [Primitive], bounds: &Bounds, leaf_triangles: usize) -> Option<usize> {
        (primitives.len() > leaf_triangles).then(|| halve(primitives, bounds))
    }
}

/// Reorders a range so that no centre of its first half lies above one of its second, along the longest axis of the
/// centres' bounds; returns the length of the first half, half of the range rounded down.
pub(super) fn halve(primitives: &mut [Primitive], bounds: &Bounds) -> usize {
    let axis = bounds.longest_axis();
    let middle = primitives.len() / 2;
    if middle > 0 {
        primitives.select_nth_unstable_by(middle, |a, b| {
            let (a_centre, b_centre) = (a.centre_twice()[axis], b.centre_twice()[axis]);
            a_centre.total_cmp(&b_centre).then(a.id().cmp(&b.id()))
        });
    }
    middle
}
