//! What the meshes of a scene take once they are placed, known before any is.
//!
//! Comes in: meshes, as often as the scene names them. Goes out: triangles and bytes of memory.

use std::path::Path;

use super::assemble::{RawCorners, RawTriangle};
use super::obj_mesh::ObjMesh;
use super::scene_file::MeshEntry;
use super::{Corners, Triangle};
use crate::{Error, Result};

/// Most triangles: their indices and those of their corners are kept as `u32`.
const MOST_TRIANGLES: u64 = (1 << 31) - 1;

/// What the placed meshes take.
#[derive(Default)]
pub(super) struct Need {
    /// Triangles.
    pub triangles: u64,
    /// Those of them that have normals.
    pub smooth: u64,
}

/// Bytes that a triangle takes at the most at a time: in the scene's own units, then scaled, with its share of the tree
/// that is built over it and of the texels that are made of both.
const TRIANGLE_BYTES: u64 = (size_of::<RawTriangle>() + size_of::<Triangle>()) as u64 + TREE_BYTES;
/// Bytes that the corners of a smooth triangle take beside it.
const CORNERS_BYTES: u64 = (size_of::<RawCorners>() + size_of::<Corners>()) as u64;
/// Bytes of a triangle's share of the tree, while it is built, and of its texels beyond what the raw triangle took.
const TREE_BYTES: u64 = 200;

impl Need {
    /// Adds a mesh. Refuses more triangles than can be numbered.
    pub(super) fn add(&mut self, path: &Path, entry: &MeshEntry, mesh: &ObjMesh) -> Result<()> {
        self.triangles += mesh.triangles.len() as u64;
        self.smooth += mesh.corners.len() as u64;
        if self.triangles > MOST_TRIANGLES {
            let message = format!("more than {MOST_TRIANGLES} triangles; allowed are as many");
            return Err(Error::scene(path, entry.line, message));
        }
        Ok(())
    }

    /// Bytes of memory.
    pub(super) fn bytes(&self) -> u64 {
        self.triangles.saturating_mul(TRIANGLE_BYTES).saturating_add(self.smooth.saturating_mul(CORNERS_BYTES))
    }
}
