//! Material kinds and their parameters.

/// A surface material: how it scatters light and what it emits.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the MTL file or scene; empty for faces without a material.
    pub name: String,
    /// How it scatters.
    pub kind: MaterialKind,
    /// Radiance emitted from the geometric front (scaled, linear Rec. 709); zero if it does not emit.
    pub emission: [f32; 3],
}

/// How a surface scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialKind {
    /// Two-sided Lambert reflection.
    Lambert {
        /// Albedo, each channel within [0, 1].
        albedo: [f32; 3],
    },
    /// Perfect two-sided mirror.
    Mirror {
        /// Reflectance, each channel within [0, 1].
        reflectance: [f32; 3],
    },
    /// Smooth colourless dielectric with air outside.
    Glass {
        /// Index of refraction relative to air, above 0.
        ior: f32,
    },
}

impl Material {
    /// Whether any channel of the emission is above zero.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&channel| channel > 0.0)
    }
}
