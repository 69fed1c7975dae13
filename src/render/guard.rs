//! The numerical guards by name, and the switch that takes one out.
//!
//! A guard is a line of the shaders (or of the host) without which some hard case goes wrong. To show that, tests and the
//! studies render with one of them out; a user's render never does: [`Tuning`](crate::render::Tuning) is not reachable from
//! the command line.

use crate::interface::*;

/// An enum of the guards, each with the number of its constant.
macro_rules! guards {
    ($($name:ident = $number:ident,)*) => {
        /// A numerical guard; [`GUARDS`] says what each does.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Guard {
            $(#[doc = concat!("[`", stringify!($number), "`]")] $name = $number as isize,)*
        }

        impl Guard {
            /// Every guard.
            pub const ALL: &[Guard] = &[$(Guard::$name),*];
        }
    };
}

guards! {
    NodePad = GUARD_NODE_PAD,
    TriangleBox = GUARD_TRIANGLE_BOX,
    DirectionFloor = GUARD_DIRECTION_FLOOR,
    CullSlack = GUARD_CULL_SLACK,
    EmitterNearer = GUARD_EMITTER_NEARER,
    ShadowLimit = GUARD_SHADOW_LIMIT,
    SpawnOffset = GUARD_SPAWN_OFFSET,
    SkipSource = GUARD_SKIP_SOURCE,
    SkipLight = GUARD_SKIP_LIGHT,
    UnfusedEdges = GUARD_UNFUSED_EDGES,
    RefuseInvalidRays = GUARD_REFUSE_INVALID_RAYS,
    ExactDeterminant = GUARD_EXACT_DETERMINANT,
    InvalidSamples = GUARD_INVALID_SAMPLES,
    UnitFloat = GUARD_UNIT_FLOAT,
    HashShift = GUARD_HASH_SHIFT,
    BounceDimensions = GUARD_BOUNCE_DIMENSIONS,
    RouletteRange = GUARD_ROULETTE_RANGE,
    RouletteWeight = GUARD_ROULETTE_WEIGHT,
    RouletteScale = GUARD_ROULETTE_SCALE,
    CompensatedSum = GUARD_COMPENSATED_SUM,
    FresnelProduct = GUARD_FRESNEL_PRODUCT,
    TotalReflection = GUARD_TOTAL_REFLECTION,
    RadianceScale = GUARD_RADIANCE_SCALE,
    GeometricSide = GUARD_GEOMETRIC_SIDE,
    NormalSide = GUARD_NORMAL_SIDE,
    HeuristicRatio = GUARD_HEURISTIC_RATIO,
    MisWeight = GUARD_MIS_WEIGHT,
    LightCosine = GUARD_LIGHT_COSINE,
    DiscRenormalise = GUARD_DISC_RENORMALISE,
    BasisSign = GUARD_BASIS_SIGN,
    GgxVectorForm = GUARD_GGX_VECTOR_FORM,
    GgxCancelledCosines = GUARD_GGX_CANCELLED_COSINES,
    SolidAngleEdges = GUARD_SOLID_ANGLE_EDGES,
    EdgeMargin = GUARD_EDGE_MARGIN,
    IntegerClamp = GUARD_INTEGER_CLAMP,
    Recentre = GUARD_RECENTRE,
    Rescale = GUARD_RESCALE,
    StackDepth = GUARD_STACK_DEPTH,
    DropDegenerate = GUARD_DROP_DEGENERATE,
}

impl Guard {
    /// The value of the constant `SPEC_WITHOUT_GUARD` that takes it out.
    pub fn number(self) -> u32 {
        self as u32
    }

    /// The hard case that it cures first of all.
    pub fn case(self) -> u8 {
        self.entry().2
    }

    /// What it does, a sentence without its end.
    pub fn purpose(self) -> &'static str {
        self.entry().3
    }

    fn entry(self) -> &'static (&'static str, u32, u8, &'static str) {
        // The numbers count from 1, in the order of the list (a test says so).
        &GUARDS[self as usize - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guards_are_numbered_from_one_in_order() {
        assert_eq!(Guard::ALL.len(), GUARDS.len());
        for ((index, guard), (_, number, case, _)) in Guard::ALL.iter().enumerate().zip(GUARDS) {
            assert!(guard.number() == *number && *number as usize == index + 1 && (1..=80).contains(case));
        }
    }
}
