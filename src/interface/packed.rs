//! Words that hold several fields.
//!
//! Goes out: shift and mask of each field, for both sides. Fields follow one another from bit 0 on; each states the
//! largest value that it must hold, and the program is not compiled where a field is too narrow for it, or a word too
//! short for its fields.

use super::{
    BLOCK_SAMPLES, CAUSES, LIGHT_TREE_CHILDREN, LIGHT_TREE_LEVELS, MATERIAL_GLASS, MAX_TREE_DEPTH, PHASE_FINISHED,
};
use super::{STACK_ENTRIES_A_TEXEL, TRIANGLE_EMITS, TRIANGLE_SMOOTH};

/// Mask of a field of `bits` bits from bit `shift` on, which must hold `most`.
const fn mask(shift: u32, bits: u32, most: u32) -> u32 {
    let mask = (1 << bits) - 1;
    assert!(most <= mask, "a field is too narrow for its largest value");
    assert!(shift + bits <= 32, "a field ends beyond its word");
    mask
}

macro_rules! packed {
    ($list:ident; $($(#[$what:meta])* $shift:ident, $mask:ident: $bits:literal bits for $most:expr;)*) => {
        packed! { @ 0; $($(#[$what])* $shift, $mask: $bits bits for $most;)* }

        /// Shifts and masks of the word's fields, by name.
        pub const $list: &[(&str, u32)] = &[$((stringify!($shift), $shift), (stringify!($mask), $mask)),*];
    };
    (@ $from:expr; $(#[$what:meta])* $shift:ident, $mask:ident: $bits:literal bits for $most:expr; $($rest:tt)*) => {
        $(#[$what])*
        pub const $shift: u32 = $from;
        /// The same field's largest value.
        pub const $mask: u32 = mask($shift, $bits, $most);

        packed! { @ $shift + $bits; $($rest)* }
    };
    (@ $from:expr;) => {};
}

packed! { PATH_WORD;
    /// First word of a path's state: the `PHASE_` value.
    PATH_PHASE_SHIFT, PATH_PHASE_MASK: 3 bits for PHASE_FINISHED;
    /// Whether the last bounce had no density.
    PATH_SPECULAR_SHIFT, PATH_SPECULAR_MASK: 1 bits for 1;
    /// Whether an extension ray waits.
    PATH_EXTENDS_SHIFT, PATH_EXTENDS_MASK: 1 bits for 1;
    /// Whether its ray is still being traced.
    PATH_SEARCHING_SHIFT, PATH_SEARCHING_MASK: 1 bits for 1;
    /// The `CAUSE_` value: room for 32.
    PATH_CAUSE_SHIFT, PATH_CAUSE_MASK: 5 bits for CAUSES - 1;
    /// Samples of the run that are done; a run is within a block.
    PATH_SAMPLES_SHIFT, PATH_SAMPLES_MASK: 5 bits for BLOCK_SAMPLES;
    /// Entries on the traversal stack, which has whole texels.
    PATH_STACK_SHIFT, PATH_STACK_MASK: 7 bits for MAX_TREE_DEPTH + STACK_ENTRIES_A_TEXEL - 1;
}

packed! { TRIANGLE_WORD;
    /// Flags of a triangle: the `TRIANGLE_` bits.
    TRIANGLE_FLAGS_SHIFT, TRIANGLE_FLAGS_MASK: 4 bits for TRIANGLE_EMITS | TRIANGLE_SMOOTH;
    /// Its way through the light tree, two bits a level, the root's lowest.
    TRIANGLE_TRAIL_SHIFT, TRIANGLE_TRAIL_MASK: 28 bits for LIGHT_TREE_CHILDREN.pow(LIGHT_TREE_LEVELS) - 1;
}

packed! { MATERIAL_WORD;
    /// The `MATERIAL_` kind; the bits above it are free.
    MATERIAL_KIND_SHIFT, MATERIAL_KIND_MASK: 8 bits for MATERIAL_GLASS;
}
