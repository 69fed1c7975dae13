//! The default builder: binned surface-area heuristic.
//!
//! Comes in: a range of primitives with its bounds. Goes out: the range cut where the expected cost of a ray is least,
//! `area(left) * count(left) + area(right) * count(right)` (Goldsmith and Salmon 1987; MacDonald and Booth 1990), or
//! the advice to keep it as one leaf. Long ranges are cut between bins (Wald 2007), on all three axes; short ones
//! exactly, between any two centres. May be assumed: the cut depends on the range alone, not on threads.

use glam::Vec4;

use super::primitive::{Bounds, Box4, Primitive, fold};
use super::subdivide::Split;

/// Bins an axis.
const BINS: usize = 16;
/// Longest range that is cut exactly. Sweeping so few centres is cheaper than sweeping all the bins.
const EXACT: usize = 8;
/// Cost of visiting an inner node of the binary tree, in triangle tests.
pub(super) const NODE_COST: f32 = 1.0;

/// Cuts where the surface-area heuristic is least.
pub(super) struct BinnedSah;

impl Split for BinnedSah {
    fn split(&self, primitives: &mut [Primitive], bounds: &Bounds, leaf_triangles: usize) -> Option<usize> {
        let count = primitives.len();
        if count == 2 && leaf_triangles < 2 {
            return Some(1);
        }
        let cut = if count <= EXACT { exact_cut(primitives) } else { binned_cut(primitives, bounds) };
        if count <= leaf_triangles {
            let area = bounds.boxes.half_area();
            let split_cost = cut.as_ref().map_or(f32::INFINITY, |cut| NODE_COST * area + cut.cost);
            if area * count as f32 <= split_cost {
                return None;
            }
        }
        // No cut found: the middle stands in for it (0 is not a cut).
        Some(cut.map_or(0, |cut| cut.carry_out(primitives, bounds)))
    }
}

/// A cut and its cost.
struct Cut {
    axis: usize,
    /// First bin, or first rank, of the second part.
    at: usize,
    /// Sum of half area times count over both parts.
    cost: f32,
}

impl Cut {
    /// Reorders the range; returns the length of the first part.
    fn carry_out(&self, primitives: &mut [Primitive], bounds: &Bounds) -> usize {
        if primitives.len() <= EXACT {
            let axis = self.axis;
            primitives.sort_unstable_by(|a, b| {
                let (a_centre, b_centre) = (a.centre_twice()[axis], b.centre_twice()[axis]);
                a_centre.total_cmp(&b_centre).then(a.id().cmp(&b.id()))
            });
            return self.at;
        }
        let grid = Grid::new(bounds);
        let goes_left = |primitive: &Primitive| grid.bins(primitive)[self.axis] < self.at;
        let (mut left, mut right) = (0, primitives.len());
        loop {
            while left < right && goes_left(&primitives[left]) {
                left += 1;
            }
            while left < right && !goes_left(&primitives[right - 1]) {
                right -= 1;
            }
            if left >= right {
                return left;
            }
            primitives.swap(left, right - 1);
        }
    }
}

/// The map from centres to bins.
struct Grid {
    origin: Vec4,
    scale: Vec4,
}

impl Grid {
    fn new(bounds: &Bounds) -> Grid {
        let extent = bounds.centres.high - bounds.centres.low;
        Grid { origin: bounds.centres.low, scale: Vec4::splat(BINS as f32) / extent }
    }

    /// The bin of a centre on each axis: `BINS * (centre - origin) / extent` rounded down, clamped. Any value, NaN on an axis
    /// without extent included, gives some bin below [`BINS`], the same each time it is asked.
    #[inline(always)]
    fn bins(&self, primitive: &Primitive) -> [usize; 3] {
        let bin = (primitive.centre_twice() - self.origin) * self.scale - Vec4::splat(0.5);
        let bin = bin.min(Vec4::splat((BINS - 1) as f32)).max(Vec4::ZERO);
        // Adding 2^23 leaves the rounded integer in the low bits of the significand: cheaper than a checked conversion.
        let bits = (bin + Vec4::splat(8_388_608.0)).to_array().map(|lane| lane.to_bits() as usize & (BINS - 1));
        [bits[0], bits[1], bits[2]]
    }
}

/// Bounds and counts of the bins of all axes.
#[derive(Clone)]
struct Bins {
    boxes: [[Box4; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    fn fill(primitives: &[Primitive], grid: &Grid) -> Bins {
        let mut bins = Bins { boxes: [[Box4::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };
        for primitive in primitives {
            let index = grid.bins(primitive);
            let bounds = primitive.box4();
            for (axis, bin) in index.into_iter().enumerate() {
                bins.boxes[axis][bin].grow(bounds);
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    fn merge(mut self, other: Bins) -> Bins {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.boxes[axis][bin].grow(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }
}

/// The best cut between bins, if any bin border has primitives on both sides.
fn binned_cut(primitives: &[Primitive], bounds: &Bounds) -> Option<Cut> {
    let grid = Grid::new(bounds);
    let bins = fold(primitives, |chunk| Bins::fill(chunk, &grid), Bins::merge)?;
    let mut best: Option<Cut> = None;
    for axis in 0..3 {
        if bounds.centres.high[axis] <= bounds.centres.low[axis] {
            continue;
        }
        let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
        consider(axis, BINS, |bin| (boxes[bin], counts[bin]), &mut best);
    }
    best
}

/// The best cut of a short range, along any axis, between any two centres.
fn exact_cut(primitives: &[Primitive]) -> Option<Cut> {
    let mut best = None;
    for axis in 0..3 {
        let mut ranked = [(0.0f32, 0usize); EXACT];
        for (index, primitive) in primitives.iter().enumerate() {
            // Insertion in the order that `carry_out` sorts by.
            let centre = primitive.centre_twice()[axis];
            let mut rank = index;
            while rank > 0 {
                let (other_centre, other) = ranked[rank - 1];
                let order = other_centre.total_cmp(&centre).then(primitives[other].id().cmp(&primitive.id()));
                if order.is_le() {
                    break;
                }
                ranked[rank] = ranked[rank - 1];
                rank -= 1;
            }
            ranked[rank] = (centre, index);
        }
        consider(axis, primitives.len(), |rank| (primitives[ranked[rank].1].box4(), 1), &mut best);
    }
    best
}

/// Looks at the cuts between `length` (at most [`BINS`]) parts of an axis, and keeps the cheapest; the first of equals.
#[inline(always)]
fn consider(axis: usize, length: usize, part: impl Fn(usize) -> (Box4, u32), best: &mut Option<Cut>) {
    let mut right_costs = [(0.0f32, 0u32); BINS];
    let (mut bounds, mut count) = (Box4::EMPTY, 0);
    for at in (1..length).rev() {
        let (part_box, part_count) = part(at);
        bounds.grow(part_box);
        count += part_count;
        right_costs[at] = (bounds.half_area() * count as f32, count);
    }
    (bounds, count) = (Box4::EMPTY, 0);
    for (at, &(right_cost, right_count)) in right_costs.iter().enumerate().take(length).skip(1) {
        let (part_box, part_count) = part(at - 1);
        bounds.grow(part_box);
        count += part_count;
        let cost = bounds.half_area() * count as f32 + right_cost;
        if count > 0 && right_count > 0 && best.as_ref().is_none_or(|best| cost < best.cost) {
            *best = Some(Cut { axis, at, cost });
        }
    }
}
