//! Numbers of both sides that are floats: pads and tie-breaks of tracing, for which CPU and GPU find the same hit.
//!
//! Goes out: a constant each; `build.rs` writes them to `interface.glsl` with all their digits.

macro_rules! floats {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: f32 = $value;)*

        /// Every float above, by name.
        pub const SHADER_FLOATS: &[(&str, f32)] = &[$((stringify!($name), $name)),*];
    };
}

floats! {
    /// A triangle's own box grows by this share of the ray's reach, 2^-20; it covers the rounding of the slab test and
    /// of the sheared vertices (docs/decisions.md, 'order of hits').
    TRIANGLE_PAD = 1.0 / 1_048_576.0;
    /// A node's box grows by twice that, 2^-19, so that whatever a triangle's own box admits, every box around it
    /// admits.
    NODE_PAD = 1.0 / 524_288.0;
    /// An emitter's distance counts as this much nearer, 1 - 2^-16, so that a light in the plane of a wall wins the
    /// tie.
    EMITTER_NEARER = 1.0 - 1.0 / 65_536.0;
    /// Boxes are left out only beyond this multiple of the best key, 1 + 2^-15; it exceeds 1 / `EMITTER_NEARER`.
    CULL_BEYOND = 1.0 + 1.0 / 32_768.0;
    /// The key of no hit, 2^100: beyond any hit of a ray with a direction of length 2^-40 or more; a multiple of it is
    /// still finite.
    NO_HIT_KEY = 1.267_650_6e30;
    /// Components of a direction count as at least this in box tests, so that no plane gives 0 * infinity.
    MIN_DIRECTION = 1e-18;
}

const _: () = assert!(NODE_PAD >= 2.0 * TRIANGLE_PAD && CULL_BEYOND * EMITTER_NEARER > 1.0);
