//! Cones of directions: which way the lights of a cluster shine.
//!
//! Comes in: unit normals and cones. Goes out: a cone that holds them all, how much it spreads, and its octahedral word, of which
//! `glsl/sampling/octahedral.glsl` is the shader's side.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};

/// All directions within `angle` of `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit vector.
    pub axis: DVec3,
    /// Half the opening, in radians, 0 to π; π is every direction.
    pub angle: f64,
}

impl Cone {
    /// One direction, a unit vector.
    pub fn of(axis: DVec3) -> Cone {
        Cone { axis, angle: 0.0 }
    }

    /// A cone that holds both: the smallest, or every direction where their axes are opposite (Conty Estevez and Kulla 2018).
    pub fn union(self, other: Cone) -> Cone {
        let (wide, narrow) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        // Of the chord and not of the cosine: the axes of one flat lamp are a rounding apart.
        let between = 2.0 * ((wide.axis - narrow.axis).length() / 2.0).min(1.0).asin();
        if (between + narrow.angle).min(PI) <= wide.angle {
            return wide;
        }
        let angle = (wide.angle + between + narrow.angle) / 2.0;
        let across = wide.axis.cross(narrow.axis);
        if angle >= PI || across.length_squared() < 1e-24 {
            // Equal axes up to rounding are as good as one; opposite ones leave no room.
            let angle = if between < 1.0 { (narrow.angle.max(wide.angle) + between).min(PI) } else { PI };
            return Cone { axis: wide.axis, angle };
        }
        let turn = DQuat::from_axis_angle(across.normalize(), angle - wide.angle);
        Cone { axis: (turn * wide.axis).normalize(), angle }
    }

    /// The measure of its spread for lights that shine on their front: the integral over the sphere of the cosine of the
    /// angle beyond the cone (the same paper's M_Ω with θ_e = π/2).
    pub fn measure(self) -> f64 {
        let (o, w) = (self.angle, (self.angle + FRAC_PI_2).min(PI));
        let (sin_o, cos_o) = o.sin_cos();
        2.0 * PI * (1.0 - cos_o) + FRAC_PI_2 * (2.0 * w * sin_o - (o - 2.0 * w).cos() - 2.0 * o * sin_o + cos_o)
    }
}

/// The word of a unit vector: 16 bits a coordinate on an octahedron (Meyer et al. 2010).
pub fn encode_octahedral(v: DVec3) -> u32 {
    let p = v / (v.x.abs() + v.y.abs() + v.z.abs());
    let side = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = match p.z < 0.0 {
        true => ((1.0 - p.y.abs()) * side(p.x), (1.0 - p.x.abs()) * side(p.y)),
        false => (p.x, p.y),
    };
    let word = |e: f64| ((e + 1.0) * 32_767.5).round().clamp(0.0, 65_535.0) as u32;
    word(x) | word(y) << 16
}

/// The unit vector of a word.
pub fn decode_octahedral(word: u32) -> DVec3 {
    let coordinate = |word: u32| f64::from(word) / 32_767.5 - 1.0;
    let (x, y) = (coordinate(word & 0xffff), coordinate(word >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    let folded = |e: f64| if e < 0.0 { e + fold } else { e - fold };
    DVec3::new(folded(x), folded(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(i: u32) -> DVec3 {
        let (z, angle) = (f64::from(i % 101) / 50.0 - 1.0, f64::from(i) * 2.399_963);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z).normalize()
    }

    #[test]
    fn a_union_holds_both() {
        for i in 0..3000 {
            let cone = |k: u32| Cone { axis: direction(i * 7 + k), angle: f64::from((i + k) % 40) * 0.05 };
            let (a, b) = (cone(0), cone(13));
            let both = a.union(b);
            for part in [a, b] {
                let reach = part.axis.angle_between(both.axis) + part.angle;
                assert!(both.angle >= PI || reach <= both.angle + 1e-7, "{a:?} {b:?}: {both:?}");
            }
        }
        assert_eq!(Cone::of(DVec3::X).union(Cone::of(-DVec3::X)).angle, PI);
        assert_eq!(Cone::of(DVec3::X).union(Cone::of(DVec3::X)), Cone::of(DVec3::X));
    }

    #[test]
    fn measures_are_those_of_the_integral() {
        // A plane light: the integral of the cosine over a hemisphere. A point light: the sphere.
        assert!((Cone::of(DVec3::X).measure() - PI).abs() < 1e-12);
        assert!((Cone { axis: DVec3::X, angle: PI }.measure() - 4.0 * PI).abs() < 1e-12);
    }

    #[test]
    fn octahedral_words_lose_little() {
        for i in 0..5000 {
            let v = direction(i);
            assert!((decode_octahedral(encode_octahedral(v)) - v).length() < 1e-4, "{v}");
        }
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for v in [axis, -axis] {
                assert!((decode_octahedral(encode_octahedral(v)) - v).length() < 1e-4, "{v}");
            }
        }
    }
}
