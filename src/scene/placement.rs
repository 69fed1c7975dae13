//! Triangles of a mesh moved to their place in the scene.
//!
//! Comes in: triangles of an OBJ file, the mesh's transform and materials. Goes out: a [`PlacedPart`]: positions and
//! normals in the scene's units, fronts kept where the transform mirrors, and what cannot be placed.

use std::path::Path;

use glam::DVec3;

use super::assemble::{RawCorners, RawTriangle};
use super::number::in_range;
use super::obj_mesh::{ObjCorners, ObjTriangle};
use super::scene_file::MeshEntry;
use crate::Error;
use crate::interface::NO_INDEX;

/// A normal this close to the geometric one shades as the flat triangle does, so the triangle needs none.
const SAME_NORMAL: f64 = 1e-6;

/// The refusal of a triangle that the mesh's transform moves out of range.
pub(super) fn overflow(path: &Path, entry: &MeshEntry, triangle: &ObjTriangle) -> Error {
    let moved = triangle.positions.map(|point| entry.transform.point(point));
    let reach = moved.into_iter().map(|point| point.abs().max_element()).fold(0.0, f64::max);
    let message = format!("the mesh's transform moves a corner to {reach:e}; allowed are coordinates up to 1e100");
    Error::scene(path, entry.line, message)
}

/// Materials of a mesh.
pub(super) enum Materials {
    /// One for all faces.
    Whole(u32),
    /// One for each part of the OBJ file.
    Parts(Vec<u32>),
}

impl Materials {
    fn of_part(&self, part: u32) -> u32 {
        match self {
            Materials::Whole(material) => *material,
            Materials::Parts(materials) => materials[part as usize],
        }
    }
}

/// Triangles of a mesh, placed; `corners` of a triangle count from the part's first.
#[derive(Default)]
pub(super) struct PlacedPart {
    /// Triangles.
    pub triangles: Vec<RawTriangle>,
    /// Corners of the smooth ones.
    pub corners: Vec<RawCorners>,
    /// Triangles left out for want of an area.
    pub degenerate: usize,
    /// Normals of length 0.
    pub zero_normals: usize,
    /// The first triangle with a corner out of range; those after it are not placed.
    pub overflows: Option<ObjTriangle>,
}

impl PlacedPart {
    /// Places triangles of a mesh.
    pub(super) fn of<'c>(
        entry: &MeshEntry,
        triangles: &[ObjTriangle],
        materials: &Materials,
        corners_of: impl Fn(&ObjTriangle) -> Option<&'c ObjCorners>,
    ) -> PlacedPart {
        let mut part = PlacedPart { triangles: Vec::with_capacity(triangles.len()), ..PlacedPart::default() };
        for triangle in triangles {
            let positions = placed(entry, triangle);
            if !positions.into_iter().all(in_range) {
                part.overflows = Some(*triangle);
                break;
            }
            let Some(front) = unit_normal(positions) else {
                part.degenerate += 1;
                continue;
            };
            let placed =
                corners_of(triangle).and_then(|corners| placed_corners(entry, corners, front, &mut part.zero_normals));
            let corners = placed.map_or(NO_INDEX, |corners| {
                part.corners.push(corners);
                (part.corners.len() - 1) as u32
            });
            let material = materials.of_part(triangle.part);
            part.triangles.push(RawTriangle { positions, material, corners });
        }
        part
    }
}

/// Positions in the scene.
fn placed(entry: &MeshEntry, triangle: &ObjTriangle) -> [DVec3; 3] {
    let [a, b, c] = triangle.positions.map(|position| entry.transform.point(position));
    // A mirrored triangle turns the other way round: two corners are swapped to keep its front.
    if entry.transform.mirrors() { [a, c, b] } else { [a, b, c] }
}

/// Unit normal of a triangle of any size, or nothing where its area is zero.
fn unit_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (ab, ac) = (b - a, c - a);
    // Scaled by a power of two, as products of the smallest legal edges would vanish.
    let size = ab.abs().max(ac.abs()).max_element();
    if size == 0.0 {
        return None;
    }
    let scale = super::normalise::power_of_two(-super::normalise::exponent(size));
    (ab * scale).cross(ac * scale).try_normalize()
}

/// The unit vector nearest to `normal` on the side of `front`; both are unit vectors.
fn onto_front(normal: DVec3, front: DVec3) -> DVec3 {
    let height = normal.dot(front);
    if height >= 0.0 {
        return normal;
    }
    (normal - height * front).try_normalize().unwrap_or(front)
}

/// Unit normals on the side of the front, or nothing where all of them are the triangle's own.
fn placed_corners(
    entry: &MeshEntry,
    corners: &ObjCorners,
    front: DVec3,
    zero_normals: &mut usize,
) -> Option<RawCorners> {
    let mut normals = corners.normals.map(|normal| {
        let size = normal.abs().max_element();
        let turned = if size > 0.0 { entry.transform.normal(normal / size).try_normalize() } else { None };
        turned.unwrap_or_else(|| {
            *zero_normals += 1;
            front
        })
    });
    // Normals of the wrong sign are so for the triangle as a whole: turned corner by corner, those of a triangle on a
    // silhouette would point to opposite sides.
    if (normals[0] + normals[1] + normals[2]).dot(front) < 0.0 {
        normals = normals.map(|normal| -normal);
    }
    normals = normals.map(|normal| onto_front(normal, front));
    if normals.iter().all(|&normal| (normal - front).abs().max_element() <= SAME_NORMAL) {
        return None;
    }
    let mut uvs = corners.uvs;
    if entry.transform.mirrors() {
        normals.swap(1, 2);
        uvs.swap(1, 2);
    }
    Some(RawCorners { normals, uvs })
}
