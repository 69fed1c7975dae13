//! The default builder: binned surface-area heuristic.
//!
//! Comes in: a range of primitives with its bounds. Goes out: the range cut where the expected cost of a ray is least,
//! `area(left) * count(left) + area(right) * count(right)` (Goldsmith and Salmon 1987; MacDonald and Booth 1990), or
//! the advice to keep it as one leaf. Long ranges are cut between bins (Wald 2007), on all three axes; short ones
//! exactly, between any two centres. May be assumed: the cut depends on the range alone, not on threads.

use glam::Vec4;

use super::primitive::{Bounds, Box4, Primitive, fold};
use super::split::{Advice, Parts, Split};

/// Bins an axis.
const BINS: usize = 16;
/// Longest range that is cut exactly. Sweeping so few centres is cheaper than sweeping all the bins.
const EXACT: usize = 8;
/// 2^23: adding it leaves the rounded integer in the low bits of the significand, which is cheaper than a checked conversion.
const TO_BITS: f32 = 8_388_608.0;
/// Cost of visiting an inner node of the binary tree, in triangle tests.
pub(super) const NODE_COST: f32 = 1.0;

/// Cuts where the surface-area heuristic is least.
pub(super) struct BinnedSah;

impl Split for BinnedSah {
    fn split(&self, primitives: &mut [Primitive], bounds: &Bounds, leaf_triangles: usize) -> Advice {
        let count = primitives.len();
        if count == 2 && leaf_triangles < 2 {
            return Advice::Cut(Parts::at(1, primitives));
        }
        let cut = if count <= EXACT { exact_cut(primitives) } else { binned_cut(primitives, bounds) };
        if count <= leaf_triangles {
            let area = bounds.boxes.half_area();
            let split_cost = cut.as_ref().map_or(f32::INFINITY, |cut| NODE_COST * area + cut.cost);
            if area * count as f32 <= split_cost {
                return Advice::Leaf;
            }
        }
        cut.map_or(Advice::NoCut, |cut| Advice::Cut(cut.carry_out(primitives, bounds)))
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
    /// Reorders the range.
    fn carry_out(&self, primitives: &mut [Primitive], bounds: &Bounds) -> Parts {
        if primitives.len() <= EXACT {
            let axis = self.axis;
            primitives.sort_unstable_by(|a, b| {
                let (a_centre, b_centre) = (a.centre_twice_on(axis), b.centre_twice_on(axis));
                a_centre.total_cmp(&b_centre).then(a.id().cmp(&b.id()))
            });
            return Parts::at(self.at, primitives);
        }
        let grid = Grid::new(bounds);
        let goes_left = |primitive: &Primitive| grid.bin(primitive, self.axis) < self.at;
        let (mut left, mut right) = (0, primitives.len());
        let mut parts = [Bounds::empty(); 2];
        loop {
            while left < right && goes_left(&primitives[left]) {
                parts[0].grow(&primitives[left]);
                left += 1;
            }
            while left < right && !goes_left(&primitives[right - 1]) {
                right -= 1;
                parts[1].grow(&primitives[right]);
            }
            if left >= right {
                return Parts { middle: left, bounds: parts };
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
        let bits = (bin + Vec4::splat(TO_BITS)).to_array().map(|lane| lane.to_bits() as usize & (BINS - 1));
        [bits[0], bits[1], bits[2]]
    }

    /// The bin on one axis, the same as that of [`Grid::bins`].
    #[inline(always)]
    fn bin(&self, primitive: &Primitive, axis: usize) -> usize {
        let bin = (primitive.centre_twice_on(axis) - self.origin[axis]) * self.scale[axis] - 0.5;
        (bin.min((BINS - 1) as f32).max(0.0) + TO_BITS).to_bits() as usize & (BINS - 1)
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
            let centre = primitive.centre_twice_on(axis);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::primitive::primitives;
    use crate::interface::NO_INDEX;
    use crate::scene::Triangle;
    use glam::Vec3;

    #[test]
    fn the_bin_on_one_axis_is_that_of_all_three() {
        let hard = [0.0, -0.0, 1e-38, 1.0, 1.5, 15.99, 16.0, 1e30, f32::MAX, -1.0, f32::INFINITY, f32::NAN];
        let points = hard.iter().chain(&[0.03, 0.47, 7.2, 11.0]).enumerate();
        let triangles: Vec<Triangle> = points
            .map(|(i, &x)| Triangle {
                positions: [Vec3::new(x, 16.0 - x, i as f32); 3],
                material: 0,
                corners: NO_INDEX,
            })
            .collect();
        let all = primitives(&triangles);
        let extents = [Vec4::ZERO, Vec4::new(16.0, 1e-40, f32::INFINITY, 0.0), Vec4::splat(f32::NAN)];
        for high in extents.into_iter().chain([Vec4::splat(32.0)]) {
            let centres = Box4 { low: Vec4::ZERO, high };
            let grid = Grid::new(&Bounds { boxes: centres, centres });
            for primitive in &all {
                let bins = grid.bins(primitive);
                assert_eq!(bins, [0, 1, 2].map(|axis| grid.bin(primitive, axis)), "{primitive:?} {high}");
                assert!(bins.iter().all(|&bin| bin < BINS));
            }
        }
    }
}
