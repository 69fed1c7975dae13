//! The local grid of a wide node.
//!
//! Comes in: the exact boxes of a node and its children. Goes out: the grid (lower corner and cell size) and the
//! children's boxes in whole cells, rounded outwards. May be assumed: `origin + q * cell`, in exact arithmetic, contains
//! the exact box; the comparison is made with the rounding error of the one inexact operation, so it is exact too.
//!
//! The cell size is a power of two per axis, at least [`MIN_EXPONENT`]'s 2^-60, even for a flat box or a cluster of
//! extent 1e-30: the scene's extent is in [1, 2), so 2^-60 is far below a rounding error of any ray's origin, and the
//! products `q * cell / d` stay clear of denormals, which a device may flush to zero.

use std::cmp::Ordering;

use glam::Vec3;

use super::{Aabb, WideNode};

/// Smallest biased exponent of a cell size: 2^-60.
pub(super) const MIN_EXPONENT: u8 = 127 - 60;
/// Largest: 2^127. 255 cells of it span any finite box.
const MAX_EXPONENT: u8 = 254;

/// A grid along one axis.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    origin: f32,
    exponent: u8,
}

impl Grid {
    /// The finest grid from `low` whose 255 cells reach `high`.
    pub fn spanning(low: f32, high: f32) -> Grid {
        // The power of two at or below a 255th of the extent: it, or the next, is the one.
        let wanted = ((f64::from(high) - f64::from(low)) / 255.0) as f32;
        let guess = (wanted.to_bits() >> 23 & 0xff) as u8;
        let mut grid = Grid { origin: low, exponent: guess.clamp(MIN_EXPONENT, MAX_EXPONENT) };
        while grid.exponent < MAX_EXPONENT && grid.up(high) > 255 {
            grid.exponent += 1;
        }
        grid
    }

    /// The grid of a finished node.
    pub fn of(node: &WideNode, axis: usize) -> Grid {
        Grid { origin: f32::from_bits(node.origin[axis]), exponent: node.exponent[axis] }
    }

    fn cell(self) -> f64 {
        f64::from(f32::from_bits(u32::from(self.exponent) << 23))
    }

    /// How `origin + q * cell` compares with `position`, exactly.
    fn compare(self, q: u32, position: f32) -> Ordering {
        // The offset and its rounding error (Knuth's two-sum): their sum is exact. The product has at most 32
        // significant bits, so it is exact too; it can only tie with the rounded offset, never slip past it.
        let (a, b) = (f64::from(position), -f64::from(self.origin));
        let offset = a + b;
        let b_virtual = offset - a;
        let error = (a - (offset - b_virtual)) + (b - b_virtual);
        let product = f64::from(q) * self.cell();
        product.partial_cmp(&offset).unwrap_or(Ordering::Equal).then(0.0f64.total_cmp(&(error + 0.0)))
    }

    /// Last plane at or below a position.
    pub fn down(self, position: f32) -> u32 {
        let q = self.cells(position) as u32;
        if q > 0 && self.compare(q, position).is_gt() { q - 1 } else { q }
    }

    /// First plane at or above a position.
    pub fn up(self, position: f32) -> u32 {
        let cells = self.cells(position);
        let q = (cells as u32).saturating_add(u32::from(cells > f64::from(cells as u32)));
        if self.compare(q, position).is_lt() { q.saturating_add(1) } else { q }
    }

    fn cells(self, position: f32) -> f64 {
        (f64::from(position) - f64::from(self.origin)) / self.cell()
    }

    /// Position of a plane, rounded to f64.
    fn plane(self, q: u8) -> f64 {
        f64::from(self.origin) + f64::from(q) * self.cell()
    }
}

impl WideNode {
    /// Sets the grid to the finest that spans a box.
    pub(super) fn set_grid(&mut self, bounds: Aabb) {
        for axis in 0..3 {
            let grid = Grid::spanning(bounds.low[axis], bounds.high[axis]);
            self.origin[axis] = grid.origin.to_bits();
            self.exponent[axis] = grid.exponent;
        }
    }

    /// Sets the box of a slot, rounded outwards to the grid.
    pub(super) fn set_box(&mut self, slot: usize, bounds: Aabb) {
        for axis in 0..3 {
            let grid = Grid::of(self, axis);
            self.low[axis][slot] = grid.down(bounds.low[axis]).min(255) as u8;
            self.high[axis][slot] = grid.up(bounds.high[axis]).min(255) as u8;
        }
    }

    /// Whether the box of a slot contains another, in exact arithmetic.
    pub fn slot_contains(&self, slot: usize, bounds: Aabb) -> bool {
        (0..3).all(|axis| {
            let grid = Grid::of(self, axis);
            grid.compare(u32::from(self.low[axis][slot]), bounds.low[axis]).is_le()
                && grid.compare(u32::from(self.high[axis][slot]), bounds.high[axis]).is_ge()
        })
    }

    /// The box of a slot, rounded to f32: for figures, not for tests of containment.
    pub fn slot_bounds(&self, slot: usize) -> Aabb {
        let corner = |planes: &[[u8; 8]; 3]| {
            Vec3::from_array(std::array::from_fn(|axis| Grid::of(self, axis).plane(planes[axis][slot]) as f32))
        };
        Aabb { low: corner(&self.low), high: corner(&self.high) }
    }

    /// Edge lengths of the box of a slot.
    pub fn slot_extent(&self, slot: usize) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let grid = Grid::of(self, axis);
            grid.plane(self.high[axis][slot]) - grid.plane(self.low[axis][slot])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_round_outwards_on_hard_intervals() {
        let tiny = f32::from_bits(1);
        let values = [-1.0, -0.1, -1e-20, -tiny, 0.0, tiny, 1e-30, 2f32.powi(-60), 0.1, 1.0 - 1e-7, 1.0, 1e30];
        for low in values {
            for high in values.into_iter().filter(|&high| high >= low) {
                let bounds = Aabb { low: Vec3::splat(low), high: Vec3::splat(high) };
                let mut node = WideNode::default();
                node.set_grid(bounds);
                for inner in values.into_iter().filter(|&inner| inner >= low && inner <= high) {
                    let part = Aabb { low: Vec3::splat(inner), high: Vec3::splat(high) };
                    node.set_box(0, part);
                    assert!(node.slot_contains(0, part), "{inner} in {low} .. {high}");
                    assert!(node.exponent.iter().all(|&exponent| exponent >= MIN_EXPONENT));
                }
            }
        }
    }

    #[test]
    fn the_grid_is_the_finest_that_spans_the_box() {
        let grid = Grid::spanning(0.0, 255.0);
        assert_eq!((grid.cell(), grid.up(255.0), grid.down(254.5), grid.up(254.5)), (1.0, 255, 254, 255));
        assert_eq!(Grid::spanning(0.0, 255.5).cell(), 2.0);
        assert_eq!(Grid::spanning(0.25, 0.25).exponent, MIN_EXPONENT);
    }

    #[test]
    fn undefined_bounds_do_not_hang_or_panic() {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let bounds = Aabb { low: Vec3::splat(value), high: Vec3::splat(-value) };
            let mut node = WideNode::default();
            node.set_grid(bounds);
            node.set_box(3, bounds);
        }
    }
}
