//! Triangle, surface and corner records.
//!
//! Comes in: triangles of a scene in leaf order. Goes out: the texels that `glsl/records/triangle.glsl` and
//! `glsl/records/surface.glsl` read; strides and lanes are stated in [`crate::interface`].

use glam::{DVec3, Vec3};

use super::Texel;
use crate::interface::{NO_INDEX, TRIANGLE_EMITS, TRIANGLE_SMOOTH, TRIANGLE_TRAIL_SHIFT};
use crate::scene::{Corners, Triangle};

/// The three texels of a triangle with the file-order number `id`; `pdf_area` is the density of light sampling on it, 0
/// where it does not emit, `trail` its way through the light tree.
pub fn triangle_texels(triangle: &Triangle, id: u32, pdf_area: f32, trail: u32) -> [Texel; 3] {
    let mut flags = trail << TRIANGLE_TRAIL_SHIFT;
    if pdf_area > 0.0 {
        flags |= TRIANGLE_EMITS;
    }
    if triangle.corners != NO_INDEX {
        flags |= TRIANGLE_SMOOTH;
    }
    let [v0, v1, v2] = triangle.positions;
    [with_word(v0, id), with_word(v1, flags), with_word(v2, pdf_area.to_bits())]
}

/// The texel of a triangle's surface: its unit normal, made in f64 so that slivers keep theirs, and its material.
pub fn surface_texel(triangle: &Triangle) -> Texel {
    with_word(geometric_normal(triangle).as_vec3(), triangle.material)
}

/// The four texels of a triangle's corners.
pub fn corners_texels(corners: &Corners) -> [Texel; 4] {
    let [n0, n1, n2] = corners.normals;
    let [uv0, uv1, uv2] = corners.uvs;
    [
        with_word(n0, uv0.x.to_bits()),
        with_word(n1, uv1.x.to_bits()),
        with_word(n2, uv2.x.to_bits()),
        [uv0.y.to_bits(), uv1.y.to_bits(), uv2.y.to_bits(), 0],
    ]
}

/// Unit normal on the front of the triangle: the side from which its positions turn counter-clockwise.
pub fn geometric_normal(triangle: &Triangle) -> DVec3 {
    cross(triangle).normalize_or_zero()
}

/// Area in scaled units, of the positions as the device sees them.
pub fn area(triangle: &Triangle) -> f64 {
    cross(triangle).length() / 2.0
}

fn cross(triangle: &Triangle) -> DVec3 {
    let [v0, v1, v2] = triangle.positions.map(Vec3::as_dvec3);
    (v1 - v0).cross(v2 - v0)
}

/// A texel of a vector and a word.
pub(super) fn with_word(v: Vec3, word: u32) -> Texel {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), word]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sliver() -> Triangle {
        Triangle {
            positions: [Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.5, 1e-7, 0.0)],
            material: 3,
            corners: NO_INDEX,
        }
    }

    #[test]
    fn a_sliver_keeps_its_normal_and_area() {
        assert_eq!(geometric_normal(&sliver()), DVec3::Z);
        assert!((area(&sliver()) - 0.5e-7).abs() < 1e-14);
    }

    #[test]
    fn integers_travel_as_integers() {
        let texels = triangle_texels(&sliver(), 7, 2.0, 9);
        assert_eq!(
            [texels[0][3], texels[1][3], texels[2][3]],
            [7, TRIANGLE_EMITS | 9 << TRIANGLE_TRAIL_SHIFT, 2f32.to_bits()]
        );
        assert_eq!(surface_texel(&sliver())[3], 3);
    }
}
