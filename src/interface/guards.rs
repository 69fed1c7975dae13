//! The list of guards: what keeps the hard cases right (render/guard.rs).
//!
//! Goes out: a constant each, the list of them, and an enum. `build.rs` writes the constants to `interface.glsl`.

/// The guards: a constant each, the list of them, and an enum.
macro_rules! guards {
    ($($guard:ident, $name:ident = $number:literal, case $case:literal: $purpose:literal;)*) => {
        $(#[doc = $purpose] #[doc = concat!("(hard case ", $case, ").")] pub const $name: u32 = $number;)*

        /// Every guard: its name and number, the hard case that it cures first of all, and what it does, a sentence
        /// without its end. Those of the host have numbers too, and no shader asks for them.
        pub const GUARDS: &[(&str, u32, u8, &str)] = &[$((stringify!($name), $number, $case, $purpose)),*];

        /// A numerical guard.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        pub enum Guard {
            $(#[doc = $purpose] $guard = $number,)*
        }

        impl Guard {
            /// Every guard, in the order of [`GUARDS`].
            pub const ALL: &[Guard] = &[$(Guard::$guard),*];
        }
    };
}

guards! {
    NodePad, GUARD_NODE_PAD = 1, case 22: "Nodes' boxes grow by a share of the ray's reach";
    TriangleBox, GUARD_TRIANGLE_BOX = 2, case 16:
        "A hit counts only where the ray meets the triangle's own padded box, and not before it";
    DirectionFloor, GUARD_DIRECTION_FLOOR = 3, case 22: "Direction components count as at least 1e-18 in box tests";
    CullSlack, GUARD_CULL_SLACK = 4, case 23: "A box is left out only where it is entered clearly beyond the best hit";
    EmitterNearer, GUARD_EMITTER_NEARER = 5, case 20: "An emitter in the plane of another surface comes first";
    ShadowLimit, GUARD_SHADOW_LIMIT = 6, case 33: "A shadow ray ends a little before its light";
    SpawnOffset, GUARD_SPAWN_OFFSET = 7, case 32: "A ray starts beyond the error of the point that it leaves";
    SkipSource, GUARD_SKIP_SOURCE = 8, case 30: "A ray does not meet the triangle that it leaves";
    SkipLight, GUARD_SKIP_LIGHT = 9, case 33: "A shadow ray does not meet the light that it aims at";
    UnfusedEdges, GUARD_UNFUSED_EDGES = 10, case 13: "Edge functions round both of their products";
    RefuseInvalidRays, GUARD_REFUSE_INVALID_RAYS = 11, case 29: "A ray that is not finite hits nothing, at no cost";
    ExactDeterminant, GUARD_EXACT_DETERMINANT = 12, case 14:
        "Only a determinant of exactly 0 is refused, not a small one";
    InvalidSamples, GUARD_INVALID_SAMPLES = 13, case 1: "A sample that is not a number is left out and counted";
    UnitFloat, GUARD_UNIT_FLOAT = 14, case 61: "Random floats have 24 bits, so that none is 1";
    HashShift, GUARD_HASH_SHIFT = 15, case 62: "The low bits of the hash depend on all of its input";
    BounceDimensions, GUARD_BOUNCE_DIMENSIONS = 16, case 64: "Each bounce draws dimensions of its own";
    RouletteRange, GUARD_ROULETTE_RANGE = 17, case 65: "Survival has a probability within [0.05, 1]";
    RouletteWeight, GUARD_ROULETTE_WEIGHT = 18, case 65: "A survivor is worth more by as much as survival was unlikely";
    RouletteScale, GUARD_ROULETTE_SCALE = 19, case 65: "Roulette judges the throughput without refraction's scaling";
    CompensatedSum, GUARD_COMPENSATED_SUM = 20, case 58: "A sum carries what rounding took from it";
    FresnelProduct, GUARD_FRESNEL_PRODUCT = 21, case 50: "1 - c^2 is (1 - c)(1 + c)";
    TotalReflection, GUARD_TOTAL_REFLECTION = 22, case 51: "Beyond the critical angle all light is reflected";
    RadianceScale, GUARD_RADIANCE_SCALE = 23, case 53: "Radiance scales by 1/eta^2 where it enters a denser medium";
    GeometricSide, GUARD_GEOMETRIC_SIDE = 24, case 34:
        "Directions that the shading normal allows, but the surface hides, carry nothing";
    NormalSide, GUARD_NORMAL_SIDE = 25, case 35: "Normals are turned to the side that is seen";
    HeuristicRatio, GUARD_HEURISTIC_RATIO = 26, case 45: "The heuristic divides before it squares";
    MisWeight, GUARD_MIS_WEIGHT = 27, case 38: "A light sample counts by its share of both strategies";
    LightCosine, GUARD_LIGHT_COSINE = 28, case 43: "A light sends nothing from its back";
    DiscRenormalise, GUARD_DISC_RENORMALISE = 29, case 7: "A point made of sine and cosine is put back on its circle";
    BasisSign, GUARD_BASIS_SIGN = 30, case 55: "The basis around a normal changes form at the equator";
    GgxVectorForm, GUARD_GGX_VECTOR_FORM = 31, case 47: "The GGX distribution is a sum of squares, not a difference";
    GgxCancelledCosines, GUARD_GGX_CANCELLED_COSINES = 32, case 48: "Masking is divided by its cosines on paper";
    SolidAngleEdges, GUARD_SOLID_ANGLE_EDGES = 33, case 39: "The solid angle of a small triangle is made of its edges";
    EdgeMargin, GUARD_EDGE_MARGIN = 34, case 32: "A ray starts off the edges of the triangle that it leaves";
    IntegerClamp, GUARD_INTEGER_CLAMP = 35, case 9: "A float that becomes an index is held in range as an integer";
    Recentre, GUARD_RECENTRE = 36, case 70: "The scene is moved so that its centre is the origin (host)";
    Rescale, GUARD_RESCALE = 37, case 70: "The scene is scaled so that its extent lies in [1, 2) (host)";
    StackDepth, GUARD_STACK_DEPTH = 38, case 26:
        "The traversal stack is as deep as the tree, by the builder's bound (host)";
    DropDegenerate, GUARD_DROP_DEGENERATE = 39, case 18: "Triangles without area are dropped at load (host)";
    LightFloor, GUARD_LIGHT_FLOOR = 40, case 43:
        "Each light below a node of the light tree keeps one word of the node's at least";
    ClusterSpread, GUARD_CLUSTER_SPREAD = 41, case 43:
        "A cluster of lights counts by the best direction that it subtends, not by its centre's";
    ClusterDistance, GUARD_CLUSTER_DISTANCE = 42, case 38:
        "A cluster of lights counts as no nearer than its own radius";
    ClusterShare, GUARD_CLUSTER_SHARE = 43, case 44:
        "A faint cluster beside a bright one keeps a share by how many lights it has";
}
