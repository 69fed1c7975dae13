//! Stage 3: the scene as records of `uvec4` texels.
//!
//! Comes in: a [`Scene`] and its [`Accel`]. Goes out: [`TexelData`], one `Vec` of texels a buffer, ready to be copied as it
//! is. Layouts are stated in [`crate::interface`] and nowhere else.

pub mod binary_node;
pub mod camera;
pub mod light;
pub mod light_cone;
pub mod light_tree;
pub mod material;
pub mod random;
pub mod triangle;
pub mod wide_node;

use crate::bvh::Accel;
use crate::error::{Error, Result};
use crate::interface::NO_INDEX;
use crate::scene::{Filter, Scene, Triangle};
use crate::settings::{LightPick, Sampler, Settings};

/// One texel: four 32-bit lanes; floats travel as their bits.
pub type Texel = [u32; 4];

/// Most triangles: the shader's indices of texels are signed words, and a triangle may have four.
const MAX_TRIANGLES: usize = 1 << 28;

/// The records of a scene. An empty `Vec` is a buffer that the scene does not call for.
#[derive(Debug, Default)]
pub struct TexelData {
    /// Nodes of the tree.
    pub nodes: Vec<Texel>,
    /// Triangles in leaf order.
    pub triangles: Vec<Texel>,
    /// Surfaces in leaf order.
    pub surfaces: Vec<Texel>,
    /// Corners in leaf order; empty where no triangle is smooth.
    pub corners: Vec<Texel>,
    /// Materials.
    pub materials: Vec<Texel>,
    /// Lights.
    pub lights: Vec<Texel>,
    /// Nodes of the light tree; empty where lights are chosen from a list.
    pub light_nodes: Vec<Texel>,
    /// The camera.
    pub camera: Vec<Texel>,
    /// The pixel filter's table; empty for the box.
    pub filter: Vec<Texel>,
    /// The table of random numbers; empty for the samplers that compute theirs.
    pub random: Vec<Texel>,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Number of lights.
    pub light_count: u32,
}

/// Refuses triangles of a material or of corners that the scene lacks: a scene that was loaded has none, one made by
/// hand may.
fn check_indices(scene: &Scene) -> Result<()> {
    let lacks = |triangle: &&Triangle| {
        let smooth = triangle.corners != NO_INDEX && triangle.corners as usize >= scene.corners.len();
        triangle.material as usize >= scene.materials.len() || smooth
    };
    match scene.triangles.iter().find(lacks) {
        None => Ok(()),
        Some(triangle) => Err(Error::Internal(format!(
            "a triangle has material {} of {} and corners {} of {}",
            triangle.material,
            scene.materials.len(),
            triangle.corners,
            scene.corners.len()
        ))),
    }
}

impl TexelData {
    /// Packs the scene.
    pub fn pack(scene: &Scene, accel: &Accel, settings: &Settings) -> Result<TexelData> {
        let order = accel.order(scene.triangles.len());
        if order.len() > MAX_TRIANGLES {
            return Err(Error::Limit {
                what: "triangles".into(),
                need: order.len().to_string(),
                have: MAX_TRIANGLES.to_string(),
            });
        }
        check_indices(scene)?;
        let mut data = TexelData::geometry(scene, accel, &order, settings.effective_light_pick())?;
        data.camera = camera::camera_texels(&scene.camera, settings.width, settings.height, settings.filter).to_vec();
        if settings.filter != Filter::Box {
            data.filter = camera::filter_texels(settings.filter);
        }
        data.random = match settings.sampler {
            Sampler::Sobol | Sampler::Independent => Vec::new(),
            Sampler::Table => random::random_table_texels(settings.seed),
        };
        Ok(data)
    }

    fn geometry(scene: &Scene, accel: &Accel, order: &[u32], pick: LightPick) -> Result<TexelData> {
        let lights = light::build_lights(scene, order, pick)?;
        let in_order = || order.iter().map(|&id| (id, &scene.triangles[id as usize]));
        let smooth = !scene.corners.is_empty();
        let corners = |index: u32| match index {
            NO_INDEX => [[0; 4]; 4],
            index => triangle::corners_texels(&scene.corners[index as usize]),
        };
        Ok(TexelData {
            nodes: match accel {
                Accel::Brute => Vec::new(),
                Accel::Binary(tree) => tree.nodes.iter().flat_map(binary_node::pack).collect(),
                Accel::Wide(tree) => tree.nodes.iter().flat_map(wide_node::pack).collect(),
            },
            triangles: in_order()
                .flat_map(|(id, triangle)| {
                    let light = id as usize;
                    triangle::triangle_texels(triangle, id, lights.pdf_area[light], lights.trails[light])
                })
                .collect(),
            surfaces: in_order().map(|(_, triangle)| triangle::surface_texel(triangle)).collect(),
            corners: match smooth {
                true => in_order().flat_map(|(_, triangle)| corners(triangle.corners)).collect(),
                false => Vec::new(),
            },
            materials: scene.materials.iter().flat_map(material::material_texels).collect(),
            triangle_count: order.len() as u32,
            light_count: lights.count,
            lights: lights.texels,
            light_nodes: lights.nodes,
            ..TexelData::default()
        })
    }
}
