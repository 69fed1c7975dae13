//! Stage 3: the scene as records of `uvec4` texels. Layouts are stated in [`crate::interface`].

pub mod binary_node;
pub mod wide_node;

/// One texel: four 32-bit lanes; floats travel as their bits.
pub type Texel = [u32; 4];
