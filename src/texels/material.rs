//! Material records. The lanes are stated at [`crate::interface::MATERIAL_TEXELS`]; `glsl/records/material.glsl` reads them.

use super::Texel;
use super::triangle::with_word;
use crate::interface::{MATERIAL_GLASS, MATERIAL_LAMBERT, MATERIAL_MIRROR};
use crate::scene::{Material, MaterialKind};

/// The two texels of a material.
pub fn material_texels(material: &Material) -> [Texel; 2] {
    let (kind, ior, reflectance) = match material.kind {
        MaterialKind::Lambert { albedo } => (MATERIAL_LAMBERT, 1.0, albedo),
        MaterialKind::Mirror { reflectance } => (MATERIAL_MIRROR, 1.0, reflectance),
        MaterialKind::Glass { ior } => (MATERIAL_GLASS, ior, [1.0; 3]),
    };
    [with_word(reflectance.into(), kind), with_word(material.emission.into(), ior.to_bits())]
}
