//! The list of effects: what a scene may call for, and leaves no code behind where it does not.
//!
//! Goes out: a constant each, an enum, the names for users, the record that an effect alone calls for; `build.rs`
//! writes a switch `HAS_*` each to `effect_switches.glsl`. Why a scene calls for one is `render/effects.rs`'s.

use super::Record;

macro_rules! effects {
    ($($effect:ident, $name:ident = $number:literal, $text:literal: $what:literal, $record:expr;)*) => {
        numbered! { EFFECT_NUMBERS, EFFECT_NAMES, EFFECTS; $($name = $number, $text: $what;)* }

        /// An effect.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum EffectKind {
            $(#[doc = $what] $effect = $number,)*
        }

        impl EffectKind {
            /// Every effect, in the order of their numbers.
            pub const ALL: &[EffectKind] = &[$(EffectKind::$effect),*];

            /// The record that it alone calls for.
            pub const fn record(self) -> Option<Record> {
                match self {
                    $(EffectKind::$effect => $record,)*
                }
            }
        }
    };
}

effects! {
    Emitters, EFFECT_EMITTERS = 0, "emitters": "Effect: triangles that emit.", Some(Record::Lights);
    Sky, EFFECT_SKY = 1, "sky": "Effect: a constant environment.", None;
    Mirror, EFFECT_MIRROR = 2, "mirror": "Effect: perfect mirrors.", None;
    Glass, EFFECT_GLASS = 3, "glass": "Effect: smooth glass.", None;
    SmoothNormals, EFFECT_SMOOTH_NORMALS = 4, "smooth_normals": "Effect: interpolated vertex normals.",
        Some(Record::Corners);
    PixelFilter, EFFECT_PIXEL_FILTER = 5, "pixel_filter": "Effect: a pixel filter other than the box.",
        Some(Record::Filter);
}
