//! Blocks of named words: the push constants, and the numbers of a render.
//!
//! Goes out: a struct each, and its fields by name, GLSL type and byte offset, of which `build.rs` writes the shaders'
//! side (`push.glsl`, `constants.glsl`). What differs from dispatch to dispatch is a push constant, of which Vulkan
//! promises 128 bytes; what stays for a render stands in texels behind the camera's, and may grow.

/// A field of a block: its name, its type in GLSL, its offset in bytes.
pub type Field = (&'static str, &'static str, u32);

macro_rules! block {
    ($(#[$doc:meta])* $block:ident, $fields:ident, $bytes:ident; $($(#[$what:meta])* $field:ident: $kind:ident;)*) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $block {
            $($(#[$what])* pub $field: $kind,)*
        }

        /// Size of the block in bytes.
        pub const $bytes: u32 = size_of::<$block>() as u32;

        /// Fields of the block, in order of their offsets.
        pub const $fields: &[Field] =
            &[$((stringify!($field), glsl_type!($kind), std::mem::offset_of!($block, $field) as u32)),*];

        impl $block {
            /// The block as the device reads it.
            pub fn bytes(&self) -> [u8; $bytes as usize] {
                let mut bytes = [0; $bytes as usize];
                $(bytes[std::mem::offset_of!($block, $field)..][..4].copy_from_slice(&self.$field.to_ne_bytes());)*
                bytes
            }
        }
    };
}

macro_rules! glsl_type {
    (u32) => {
        "uint"
    };
    (f32) => {
        "float"
    };
}

block! {
    /// What differs from one dispatch to the next.
    Push, PUSH_FIELDS, PUSH_CONSTANT_BYTES;
    /// Left edge of the tile, in pixels of the whole picture.
    tile_x: u32;
    /// Upper edge of the tile.
    tile_y: u32;
    /// Width of the tile in pixels.
    tile_width: u32;
    /// Height of the tile in pixels.
    tile_height: u32;
    /// First row of the tile that this dispatch works on.
    slice_row: u32;
    /// How many rows it works on.
    slice_rows: u32;
    /// First sample index of the run.
    first_sample: u32;
    /// How many samples the run has; it never crosses a block's end.
    samples: u32;
    /// Steps that an invocation may take in this dispatch.
    budget: u32;
    /// `DISPATCH_` bits; a probe's function.
    flags: u32;
    /// Which independently scrambled set of samples the run is of.
    replicate: u32;
    /// Where in it the run's first sample stands.
    first_index: u32;
    /// A dispatch that goes on takes a list's pixels from here on.
    listed_first: u32;
    /// How many pixels of the list it takes.
    listed: u32;
    /// Pixels that the other list has already.
    filled: u32;
    /// Paths are left when fewer eighths of the lanes than this have work.
    leave_eighths: u32;
}

block! {
    /// What stays the same for a render: texels behind the camera's.
    RenderConstants, CONSTANT_FIELDS, CONSTANT_BYTES;
    /// Radiance of the constant environment, red.
    sky_r: f32;
    /// Green.
    sky_g: f32;
    /// Blue.
    sky_b: f32;
    /// Survival probability of the fixed roulette.
    roulette_p: f32;
    /// Triangles of the scene.
    triangle_count: u32;
    /// Lights of the scene.
    light_count: u32;
    /// Surface scatterings a path may have.
    max_bounces: u32;
    /// The seed, mixed so that neighbouring seeds share no stream: its lower half.
    seed_low: u32;
    /// Its upper half.
    seed_high: u32;
}

/// Push-constant bytes that Vulkan promises.
const PROMISED_BYTES: u32 = 128;

const _: () = assert!(PUSH_CONSTANT_BYTES <= PROMISED_BYTES);
