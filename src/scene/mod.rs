//! Stage 1: a checked scene.
//!
//! Comes in: a `.toml` scene or a bare `.obj`, with the OBJ, MTL files they name. Goes out: a [`Scene`], checked once and
//! read-only from here on. Numbers are parsed and transformed in f64; the geometry is then moved to the origin and
//! scaled by a power of two so that its extent lies in [1, 2), the camera and all lengths with it, and radiance is scaled
//! by a power of two so that the brightest emission lies in [1, 2). Both scalings are exact and undone at output.
//!
//! ```text
//! scene_file (toml_source, toml_table) what a .toml scene says, with lines
//! refusals                             all that is wrong in a file, told at once
//! foreign                              other formats, and how they become readable
//! source_text (statements)             the text of OBJ and MTL files, a line a statement
//! obj_scan (obj_points, polygon)       own every refusal of OBJ and MTL; census says what memory they ask for
//! mtl_scan (recipe, number)
//!   → obj_mesh, library                tobj builds triangles in file order; the MTL files, found and read once each
//!   → assemble (need, placement)       meshes placed by their transforms, f64
//!     assigned (looks)                 materials by name, and what of their looks is left out
//!   → normalise                        scaled units, f32
//! ```

mod assemble;
mod assigned;
mod batches;
pub mod camera;
mod census;
mod digest;
mod foreign;
mod library;
mod library_path;
mod load;
mod looks;
pub mod material;
mod mtl_scan;
mod nearest;
mod need;
pub(crate) mod normalise;
mod number;
mod obj_mesh;
mod obj_points;
mod obj_scan;
mod obj_words;
mod placement;
mod polygon;
mod recipe;
mod refusals;
mod scene_file;
mod source_text;
mod statements;
mod toml_source;
mod toml_table;
mod transform;
mod warnings;

use crate::named::named;
use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3};

pub use camera::Camera;
pub use digest::Digest;
pub use foreign::foreign_format;
pub use material::{Material, MaterialKind};

/// A scene in scaled units: everything a renderer needs, nothing that it has to check again.
#[derive(Clone, Debug)]
pub struct Scene {
    /// File name without extension, for default output names.
    pub name: String,
    /// The file that was loaded.
    pub path: PathBuf,
    /// The camera, in scaled units.
    pub camera: Camera,
    /// Picture size and pixel filter.
    pub film: FilmSettings,
    /// What the scene's `[render]` table asks for.
    pub render: RenderDefaults,
    /// Triangles in file order: the index is the triangle's id.
    pub triangles: Vec<Triangle>,
    /// Vertex normals and texture coordinates of the triangles that have normals.
    pub corners: Vec<Corners>,
    /// Materials; [`Triangle::material`] indexes them.
    pub materials: Vec<Material>,
    /// Constant environment radiance (scaled, linear Rec. 709), if the scene calls for one.
    pub sky: Option<[f32; 3]>,
    /// How scaled units relate to the file's.
    pub scaling: Scaling,
    /// What loading left out or ignored, for the user to read.
    pub report: LoadReport,
}

impl Scene {
    /// Refuses a scene of which loading warned, with all of its warnings.
    pub fn deny_warnings(&self) -> crate::Result<()> {
        match self.report.warnings.is_empty() {
            true => Ok(()),
            false => Err(crate::Error::Warnings { warnings: self.report.warnings.clone() }),
        }
    }

    /// Number of triangles whose material emits.
    pub fn emissive_triangles(&self) -> usize {
        self.triangles.iter().filter(|triangle| self.materials[triangle.material as usize].emits()).count()
    }
}

/// One triangle in scaled units. Its front is the side from which the positions turn counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Corner positions.
    pub positions: [Vec3; 3],
    /// Index of its material.
    pub material: u32,
    /// Index into [`Scene::corners`], or [`crate::interface::NO_INDEX`] for a flat triangle.
    pub corners: u32,
}

/// Shading attributes of a smooth triangle's corners.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    /// Unit vertex normals.
    pub normals: [Vec3; 3],
    /// Texture coordinates; zero where the file has none.
    pub uvs: [Vec2; 3],
}

/// `scaled = (file - centre) * 2^length_exponent`, radiance `scaled = file * 2^radiance_exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Centre of the geometry's bounds, in file units.
    pub centre: DVec3,
    /// Power of two that lengths were multiplied by.
    pub length_exponent: i32,
    /// Power of two that radiances were multiplied by.
    pub radiance_exponent: i32,
}

/// Picture size and pixel filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width in pixels, 1 to 16384.
    pub width: u32,
    /// Height in pixels, 1 to 16384.
    pub height: u32,
    /// Pixel filter.
    pub filter: Filter,
}

named! {
    /// Pixel filter; samples are drawn in proportion to it, so that pixels stay independent.
    pub enum Filter = BlackmanHarris {
        /// Uniform over the pixel.
        Box = "box",
        /// Triangle of radius 1 pixel.
        Tent = "tent",
        /// Gaussian of standard deviation 0.5 pixels, cut at radius 1.5.
        Gaussian = "gaussian",
        /// Blackman-Harris window of radius 1.5 pixels.
        BlackmanHarris = "blackman-harris",
    }
}

/// What the scene's `[render]` table asks for; the command line overrides it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderDefaults {
    /// Samples a pixel.
    pub spp: Option<u32>,
    /// Surface scatterings a path may have.
    pub max_bounces: Option<u32>,
}

/// What loading read, left out or ignored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadReport {
    /// Every file beside [`Scene::path`] that the scene names, whether it was read or not, in order and none twice: no
    /// output may take its place. OBJ files; what `mtllib` statements name, also where a material of the scene file
    /// made reading it needless; images in the MTL files that were read. As names may hold blanks and options stand
    /// before them, several readings of one statement are listed: those of its words that end it, from one word to
    /// sixteen.
    pub files: Vec<PathBuf>,
    /// Triangles without area that were removed.
    pub degenerate_triangles: usize,
    /// Warnings, one line each, with file and line where there is one.
    pub warnings: Vec<String>,
    /// What was taken for granted where the scene does not say, one line each.
    pub notes: Vec<String>,
}
