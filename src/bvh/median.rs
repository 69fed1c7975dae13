//! The thesis's builder: longest axis, median, one triangle a leaf.
//!
//! Comes in: a range of primitives. Goes out: its two halves, cut at the median of the centres along the axis where
//! they spread most, found by quick-select. May be assumed: halves differ by at most one primitive, so a tree of `n`
//! triangles is `ceil(log2 n)` levels deep; equal centres are told apart by id, so the halves do not depend on the
//! order in which the primitives came.

use super::primitive::{Bounds, Primitive};
use super::split::{Advice, Parts, Split};

/// Cuts every range at its median.
pub(super) struct Median;

impl Split for Median {
    fn split(&self, primitives: &mut [Primitive], bounds: &Bounds, leaf_triangles: usize) -> Advice {
        if primitives.len() > leaf_triangles { Advice::Cut(halve(primitives, bounds)) } else { Advice::Leaf }
    }
}

/// Reorders a range so that no centre of its first half lies above one of its second, along the longest axis of the
/// centres' bounds. The first half is half of the range rounded down.
pub(super) fn halve(primitives: &mut [Primitive], bounds: &Bounds) -> Parts {
    let axis = bounds.longest_axis();
    let middle = primitives.len() / 2;
    if middle > 0 {
        primitives.select_nth_unstable_by(middle, |a, b| {
            let (a_centre, b_centre) = (a.centre_twice_on(axis), b.centre_twice_on(axis));
            a_centre.total_cmp(&b_centre).then(a.id().cmp(&b.id()))
        });
    }
    Parts::at(middle, primitives)
}
