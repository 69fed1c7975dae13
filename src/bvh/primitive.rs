//! What a builder sorts: a triangle's box and id in 32 bytes.
//!
//! Comes in: triangles in file order. Goes out: primitives in the same order, and the bounds of ranges of them. May be
//! assumed: the corners are finite; were one not, trees would still be well formed, only useless.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::Aabb;
use crate::scene::Triangle;

/// Ranges above this length are scanned in parallel, in chunks of [`CHUNK`]; the length alone decides, never the
/// number of threads.
const PARALLEL: usize = 1 << 16;
const CHUNK: usize = 1 << 14;

/// A triangle's box and id. Four-lane vectors keep the box in two registers; the fourth lane of the lower corner holds
/// the bits of the id and takes part in no result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Primitive {
    low: Vec4,
    high: Vec4,
}

impl Primitive {
    /// Of a triangle with its id.
    fn new(id: u32, triangle: &Triangle) -> Primitive {
        let bounds = Aabb::of_triangle(&triangle.positions);
        Primitive { low: bounds.low.extend(f32::from_bits(id)), high: bounds.high.extend(0.0) }
    }

    /// Position of the triangle in file order.
    pub fn id(&self) -> u32 {
        self.low.w.to_bits()
    }

    /// Twice the box's centre; the fourth lane means nothing.
    pub fn centre_twice(&self) -> Vec4 {
        self.low + self.high
    }

    /// The same on one axis.
    pub fn centre_twice_on(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }

    /// The box.
    pub fn box4(&self) -> Box4 {
        Box4 { low: self.low, high: self.high }
    }
}

/// The primitives of all triangles, in file order.
pub(super) fn primitives(triangles: &[Triangle]) -> Vec<Primitive> {
    triangles.par_iter().enumerate().map(|(id, triangle)| Primitive::new(id as u32, triangle)).collect()
}

/// A box in two four-lane registers; the fourth lanes mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    pub low: Vec4,
    pub high: Vec4,
}

impl Box4 {
    /// The box that contains nothing.
    pub const EMPTY: Box4 = Box4 { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    /// Grows to contain another box.
    #[inline(always)]
    pub fn grow(&mut self, other: Box4) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    /// Half of the surface area; zero for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = (self.high - self.low).max(Vec4::ZERO);
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// The same box in three lanes.
    pub fn aabb(&self) -> Aabb {
        Aabb { low: self.low.truncate(), high: self.high.truncate() }
    }
}

/// Bounds of a range of primitives: of their boxes, and of twice their centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub boxes: Box4,
    pub centres: Box4,
}

impl Bounds {
    /// Of a range. Minimum and maximum do not depend on order, so the parallel scan gives the same bits.
    pub fn of(primitives: &[Primitive]) -> Bounds {
        if primitives.len() > PARALLEL {
            return primitives.par_chunks(CHUNK).map(Bounds::scan).reduce(Bounds::empty, Bounds::union);
        }
        Bounds::scan(primitives)
    }

    fn scan(primitives: &[Primitive]) -> Bounds {
        let mut bounds = Bounds::empty();
        for primitive in primitives {
            bounds.grow(primitive);
        }
        bounds
    }

    /// Grows to cover one more primitive.
    #[inline(always)]
    pub fn grow(&mut self, primitive: &Primitive) {
        let centre = primitive.centre_twice();
        self.boxes.grow(primitive.box4());
        self.centres.grow(Box4 { low: centre, high: centre });
    }

    /// Of nothing.
    pub fn empty() -> Bounds {
        Bounds { boxes: Box4::EMPTY, centres: Box4::EMPTY }
    }

    fn union(mut self, other: Bounds) -> Bounds {
        self.boxes.grow(other.boxes);
        self.centres.grow(other.centres);
        self
    }

    /// Axis along which the centres spread most; the lowest of equals.
    pub fn longest_axis(&self) -> usize {
        let e: Vec3 = (self.centres.high - self.centres.low).truncate();
        if e.x >= e.y && e.x >= e.z {
            0
        } else if e.y >= e.z {
            1
        } else {
            2
        }
    }
}

/// Reduces `chunk` over fixed-length chunks of a range, in parallel where the range is long.
pub(super) fn fold<T: Send>(
    primitives: &[Primitive],
    chunk: impl Fn(&[Primitive]) -> T + Sync + Send,
    merge: impl Fn(T, T) -> T + Sync + Send,
) -> Option<T> {
    if primitives.len() > PARALLEL {
        primitives.par_chunks(CHUNK).map(chunk).reduce_with(merge)
    } else {
        Some(chunk(primitives))
    }
}
