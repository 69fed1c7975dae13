//! Material records. The lanes are stated at [`crate::interface::MATERIAL_TEXELS`]; `glsl/records/material.glsl` reads them.

use super::Texel;
use crate::interface::{MATERIAL_GLASS, MATERIAL_LAMBERT, MATERIAL_MIRROR};
use crate::scene::{Material, MaterialKind};

/// The three texels of a material.
pub fn material_texels(material: &Material) -> [Texel; 3] {
    let (kind, ior, reflectance) = match material.kind {
        MaterialKind::Lambert { albedo } => (MATERIAL_LAMBERT, 1.0, albedo),
        MaterialKind::Mirror { reflectance } => (MATERIAL_MIRROR, 1.0, reflectance),
        MaterialKind::Glass { ior } => (MATERIAL_GLASS, ior, [1.0; 3]),
    };
    [[kind, ior.to_bits(), 0, 0], rgb_texel(reflectance), rgb_texel(material.emission)]
}

fn rgb_texel([r, g, b]: [f32; 3]) -> Texel {
    [r.to_bits(), g.to_bits(), b.to_bits(), 0]
}
