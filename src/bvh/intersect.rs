//! A ray against a box and against a triangle, in f32: the twin of the shader, operation for operation.
//!
//! Comes in: a ray, boxes and triangles within [-1, 1]^3. Goes out: hits ordered by a key that depends on the ray and
//! the triangle alone, so that every tree and no tree return the same hit, bit for bit. May be assumed: no operation is
//! contracted or reordered (Rust never does; the shader says `precise`), and no NaN ever wins.
//!
//! # Boxes
//!
//! `u` = 2^-24, `o` the origin, `reach = max |o| + 1`. A plane at `p` is crossed at `(p - o) * inv ± pad |inv|`. Seen as
//! an error in position (the error in t divided by `inv`), the exact form errs by `u (|o| + 1)` in the difference, as
//! much in the product and as much in the sum: less than `4 u reach`, `pad` itself being below `2^-19 reach`. A
//! quantised plane, `q * (cell * inv) + ((origin - o) * inv ± pad |inv|)`, errs by `u |q cell| <= 3 u` in its first
//! product (`cell` is a power of two, so `cell * inv` is exact), by `3 u (|o| + 1)` in its second term, and by
//! `u (|o| + 1)` in the sum: less than `8 u reach`, contracted or not. Nodes are padded by `2^-19 reach`, triangles by
//! `2^-20 reach`: the difference, `16 u reach`, is more than both errors together. So the computed interval of a node
//! contains that of every triangle below it.
//!
//! # Order of hits
//!
//! A triangle counts only if its own padded box is met (`entry <= exit`, `exit >= 0`), and its key is
//! `max(t, entry)`, times `1 - 2^-16` if it emits. Hence `entry` of each box around it is at most
//! `key / (1 - 2^-16) < key (1 + 2^-15)`, the bound by which boxes are culled: none is left out that holds a hit with
//! the smallest key or one equal to it, and equal keys go to the smaller id.

use crate::named::named;
use glam::Vec3;

pub use crate::interface::NO_HIT_KEY;
use crate::interface::{EMITTER_NEARER, MIN_DIRECTION, NO_INDEX, NODE_PAD, TRIANGLE_PAD};

named! {
    /// Which triangle test decides.
    pub enum Intersector = Watertight {
        /// Watertight test of Woop, Benthin and Wald (JCGT 2013).
        Watertight = "watertight",
        /// Test of Möller and Trumbore (1997): leaks at edges, kept for comparison.
        MollerTrumbore = "moller-trumbore",
    }
}

/// A ray: origin, direction (of any length), and the triangle it must not hit.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin.
    pub origin: Vec3,
    /// Direction; t counts in its lengths.
    pub direction: Vec3,
    /// Id of a triangle to leave out, the one the ray starts on, or [`NO_INDEX`].
    pub skip: u32,
}

impl Ray {
    /// A ray that may hit any triangle.
    pub fn new(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, skip: NO_INDEX }
    }

    /// Whether it can be traced: finite, with a direction other than zero. Other rays hit nothing.
    pub fn is_valid(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite() && self.direction != Vec3::ZERO
    }
}

/// A hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position of the triangle in file order.
    pub id: u32,
    /// What hits are ordered by: `max(t, entry)`, lowered for emitters.
    pub key: f32,
    /// Barycentric coordinate of the second corner.
    pub b1: f32,
    /// Barycentric coordinate of the third corner.
    pub b2: f32,
}

impl Hit {
    /// No hit: loses against any.
    pub const NONE: Hit = Hit { id: NO_INDEX, key: NO_HIT_KEY, b1: 0.0, b2: 0.0 };

    /// Whether it comes before another. False where a key is NaN.
    pub fn precedes(&self, other: &Hit) -> bool {
        self.key < other.key || (self.key == other.key && self.id < other.id)
    }
}

/// A triangle as it is laid out for tracing.
#[derive(Clone, Copy, Debug)]
pub struct TracedTriangle {
    /// Corner positions.
    pub positions: [Vec3; 3],
    /// Position in file order.
    pub id: u32,
    /// Whether its material emits.
    pub emits: bool,
}

/// A ray with what every box and triangle test needs of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepared {
    pub origin: [f32; 3],
    direction: [f32; 3],
    /// Reciprocal direction, clamped.
    pub inverse: [f32; 3],
    /// Padding of nodes in t, by axis.
    pub node_pad: [f32; 3],
    triangle_pad: [f32; 3],
    /// Axes of the watertight test: two sheared ones and the one along which the direction is longest.
    axes: [usize; 3],
    /// Shear along the first two axes and scale along the third.
    shear: [f32; 3],
}

impl Prepared {
    pub fn new(ray: &Ray) -> Prepared {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let inverse = direction.map(|d| 1.0 / if d.abs() >= MIN_DIRECTION { d } else { MIN_DIRECTION.copysign(d) });
        let reach = origin[0].abs().max(origin[1].abs()).max(origin[2].abs()) + 1.0;
        let padding = |pad: f32| inverse.map(|inverse| pad * inverse.abs());
        let length = direction.map(f32::abs);
        let mut kz = 0;
        if length[1] > length[kz] {
            kz = 1;
        }
        if length[2] > length[kz] {
            kz = 2;
        }
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let shear = [direction[kx] / direction[kz], direction[ky] / direction[kz], 1.0 / direction[kz]];
        Prepared {
            origin,
            direction,
            inverse,
            node_pad: padding(reach * NODE_PAD),
            triangle_pad: padding(reach * TRIANGLE_PAD),
            axes: [kx, ky, kz],
            shear,
        }
    }

    /// Entry and exit of a box grown by a padding that is given in t.
    #[inline]
    fn interval(&self, low: Vec3, high: Vec3, pad: &[f32; 3]) -> (f32, f32) {
        let (mut near, mut far) = ([0.0f32; 3], [0.0f32; 3]);
        for axis in 0..3 {
            let t_low = (low[axis] - self.origin[axis]) * self.inverse[axis];
            let t_high = (high[axis] - self.origin[axis]) * self.inverse[axis];
            let (t_near, t_far) = if self.inverse[axis] >= 0.0 { (t_low, t_high) } else { (t_high, t_low) };
            (near[axis], far[axis]) = (t_near - pad[axis], t_far + pad[axis]);
        }
        (near[0].max(near[1]).max(near[2]), far[0].min(far[1]).min(far[2]))
    }

    /// Whether a node's box is met before `cull`, and where it is entered.
    #[inline]
    pub fn enters(&self, low: Vec3, high: Vec3, cull: f32) -> (bool, f32) {
        let (entry, exit) = self.interval(low, high, &self.node_pad);
        (entry <= exit && exit >= 0.0 && entry <= cull, entry)
    }

    /// The hit of a triangle, if there is one.
    #[inline]
    pub fn hit(&self, triangle: &TracedTriangle, intersector: Intersector) -> Option<Hit> {
        let (t, b1, b2) = match intersector {
            Intersector::Watertight => self.watertight(&triangle.positions)?,
            Intersector::MollerTrumbore => self.moller_trumbore(&triangle.positions)?,
        };
        // Asked this way round, a NaN is refused.
        let is_ahead = t > 0.0;
        if !is_ahead {
            return None;
        }
        let [v0, v1, v2] = triangle.positions;
        let (entry, exit) = self.interval(v0.min(v1).min(v2), v0.max(v1).max(v2), &self.triangle_pad);
        let meets_box = entry <= exit && exit >= 0.0;
        if !meets_box {
            return None;
        }
        let key = t.max(entry).min(exit) * if triangle.emits { EMITTER_NEARER } else { 1.0 };
        Some(Hit { id: triangle.id, key, b1, b2 })
    }

    /// t and barycentrics of the second and third corner, by Woop, Benthin and Wald (JCGT 2013), two-sided. Edge
    /// functions of a shared edge are the same products subtracted the other way round, so no ray passes between.
    #[inline]
    fn watertight(&self, positions: &[Vec3; 3]) -> Option<(f32, f32, f32)> {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let relative = positions.map(|v| {
            let v = v.to_array();
            [v[kx] - self.origin[kx], v[ky] - self.origin[ky], v[kz] - self.origin[kz]]
        });
        let [[ax, ay], [bx, by], [cx, cy]] = relative.map(|[x, y, z]| [x - sx * z, y - sy * z]);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let [az, bz, cz] = relative.map(|[_, _, z]| sz * z);
        let inverse = 1.0 / det;
        let t = (u * az + v * bz + w * cz) * inverse;
        Some((t, v * inverse, w * inverse))
    }

    /// The same by Möller and Trumbore (1997). Only an exactly zero determinant is refused.
    #[inline]
    fn moller_trumbore(&self, positions: &[Vec3; 3]) -> Option<(f32, f32, f32)> {
        let [v0, v1, v2] = positions.map(|v| v.to_array());
        let (e1, e2) = (subtract(v1, v0), subtract(v2, v0));
        let p = cross(self.direction, e2);
        let det = dot(e1, p);
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let s = subtract(self.origin, v0);
        let b1 = dot(s, p) * inverse;
        if !(0.0..=1.0).contains(&b1) {
            return None;
        }
        let q = cross(s, e1);
        let b2 = dot(self.direction, q) * inverse;
        let is_inside = b2 >= 0.0 && b1 + b2 <= 1.0;
        if !is_inside {
            return None;
        }
        Some((dot(e2, q) * inverse, b1, b2))
    }
}

fn subtract(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
