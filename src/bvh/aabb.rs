//! Axis-aligned boxes.
//!
//! Comes in: points and boxes. Goes out: boxes, their areas and centres. May be assumed: every operation but
//! [`Aabb::centre`] is exact or rounds monotonically, so that a union contains its parts bit for bit.

use glam::Vec3;

/// An axis-aligned box, closed on all sides; `low > high` is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub low: Vec3,
    /// Upper corner.
    pub high: Vec3,
}

impl Aabb {
    /// The box that contains nothing.
    pub const EMPTY: Aabb = Aabb { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// The smallest box around a triangle's corners.
    pub fn of_triangle(positions: &[Vec3; 3]) -> Aabb {
        let [a, b, c] = *positions;
        Aabb { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    /// The smallest box around both.
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The smallest box around this one and a point.
    pub fn including(self, point: Vec3) -> Aabb {
        Aabb { low: self.low.min(point), high: self.high.max(point) }
    }

    /// Edge lengths; zero for an empty box.
    pub fn extent(self) -> Vec3 {
        (self.high - self.low).max(Vec3::ZERO)
    }

    /// Half of the surface area, the measure of the surface-area heuristic (Goldsmith and Salmon 1987); zero for an
    /// empty box.
    pub fn half_area(self) -> f32 {
        let e = self.extent();
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Surface area; zero for an empty box.
    pub fn area(self) -> f32 {
        2.0 * self.half_area()
    }

    /// Centre, rounded; meaningless for an empty box.
    pub fn centre(self) -> Vec3 {
        (self.low + self.high) * 0.5
    }

    /// Whether no point lies inside.
    pub fn is_empty(self) -> bool {
        !self.low.cmple(self.high).all()
    }

    /// Whether every point of `other` lies inside; an empty box lies inside any.
    pub fn contains(self, other: Aabb) -> bool {
        other.is_empty() || (self.low.cmple(other.low).all() && self.high.cmpge(other.high).all())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_contains_its_parts_and_measures_add_up() {
        let a = Aabb::of_triangle(&[Vec3::ZERO, Vec3::new(1.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 3.0)]);
        let b = Aabb::EMPTY.including(Vec3::splat(-1.0));
        let both = a.union(b);
        assert!(both.contains(a) && both.contains(b) && both.contains(Aabb::EMPTY) && !a.contains(b));
        assert_eq!(both.extent(), Vec3::new(2.0, 3.0, 4.0));
        assert_eq!(both.area(), 52.0);
        assert_eq!(both.centre(), Vec3::new(0.0, 0.5, 1.0));
        assert_eq!(Aabb::EMPTY.half_area(), 0.0);
        assert!(Aabb::EMPTY.is_empty() && !b.is_empty());
    }
}
