//! The contract between the CPU and the GPU: every number that both sides must agree on, stated once.
//!
//! Comes in: nothing; this file imports nothing, so that `build.rs` can include it by path and write
//! `interface.glsl` from [`SHADER_CONSTANTS`] and [`PUSH_CONSTANTS`]. Goes out: record strides, binding numbers,
//! specialisation-constant ids, push-constant offsets, flag bits, and the values of enumerations.
//!
//! A record is one or more texels of four `u32` lanes. Lanes that hold a float hold its bits; integers stay
//! integers (a small integer seen as a float would be a denormal, which a device may flush to zero).

// ---- Record strides, in texels (16 bytes each) ------------------------------------------------------------------

/// Binary node: `[lo.xyz, first]`, `[hi.xyz, count]`. `count` 0 is an inner node whose children stand at `first` and
/// `first + 1`; otherwise a leaf of the triangles `first .. first + count`.
pub const BINARY_NODE_TEXELS: u32 = 2;
/// Wide node: the 80-byte compressed node of Ylitie, Karras and Laine (HPG 2017); lanes are listed in
/// `texels/wide_node.rs`.
pub const WIDE_NODE_TEXELS: u32 = 5;
/// Triangle in leaf order: `[v0.xyz, id]`, `[v1.xyz, flags]`, `[v2.xyz, pdf_area]`. `id` is the position in file order,
/// `flags` the `TRIANGLE_*` bits and above them its way through the light tree, `pdf_area` the density per unit area with
/// which light sampling chooses a point on it (with a light tree: once it has chosen the light), 0 where it does not emit.
pub const TRIANGLE_TEXELS: u32 = 3;
/// Surface of a triangle, read once a hit is shaded: `[ng.xyz, material]`; `ng` is the unit geometric normal, the
/// side from which the corners turn counter-clockwise.
pub const SURFACE_TEXELS: u32 = 1;
/// Shading attributes of a triangle's corners: `[n0.xyz, u0]`, `[n1.xyz, u1]`, `[n2.xyz, u2]`, `[v0, v1, v2, 0]`.
pub const CORNERS_TEXELS: u32 = 4;
/// Material: `[reflectance.rgb, kind]`, `[emission.rgb, ior]`.
pub const MATERIAL_TEXELS: u32 = 2;
/// Light (one emissive triangle), all that a light sample needs in one place: `[v0.xyz, cdf_end]`, `[v1.xyz, triangle]`,
/// `[v2.xyz, pdf_area]`, `[ng.xyz, cdf_begin]`, `[emission.rgb, cdf_scale]`. `cdf_begin` and `cdf_end` are the first and the
/// last 32-bit random number of its share, `cdf_scale` one over how many there are; `triangle` is its leaf-order index,
/// `pdf_area` the density per unit area (scaled units) with which a point on it is chosen, or with a light tree, which has
/// shares of its own, one over its area.
pub const LIGHT_TEXELS: u32 = 5;
/// Node of the light tree: `LIGHT_TREE_CHILDREN` clusters of lights, two texels each, `[centre.xyz, spread]`,
/// `[axis, power, child, count]`. `centre` and radius are a ball around them: `spread` has the radius, a float's upper 16
/// bits, above the cosine of half the angle of a cone around their normals, a 16-bit word from -1 to 1. `axis` is that
/// cone's, octahedral (`glsl/sampling/octahedral.glsl`); `power` their share of the scene's, a float; `count` how many they
/// are, 0 for no cluster (only after others); `child` the light where that is 1, otherwise the node below.
pub const LIGHT_NODE_TEXELS: u32 = 8;
/// Camera: `[origin.xyz, filter_kind]`, `[forward.xyz, width]`, `[right.xyz, height]`, `[down.xyz, 0]`. A camera ray
/// through the film point (x, y), in pixels from the upper left corner, has the direction
/// `forward + (x - width / 2) right + (y - height / 2) down`; width and height are floats.
pub const CAMERA_TEXELS: u32 = 4;
/// Entries of the pixel filter's inverse distribution, four floats a texel: offsets from the pixel's centre in
/// pixels, at the probabilities `i / (FILTER_ENTRIES - 1)`.
pub const FILTER_ENTRIES: u32 = 1024;
/// Texels of the table of random numbers of the `table` sampler, a power of two: one pair of numbers a texel, and two
/// more that nothing draws yet.
pub const RANDOM_TABLE_TEXELS: u32 = 1 << 18;
/// Pairs of random numbers that a bounce may draw; the camera has as many.
pub const PAIRS_PER_BOUNCE: u32 = 4;

/// No index: the corners of a flat triangle, the hit of a ray that hit nothing.
pub const NO_INDEX: u32 = 0xffff_ffff;
/// Triangle flag: its material emits (a tie in distance goes to it, design decision 'order of hits').
pub const TRIANGLE_EMITS: u32 = 1;
/// Triangle flag: it has a record of corners, with vertex normals to interpolate.
pub const TRIANGLE_SMOOTH: u32 = 2;
/// A triangle's way through the light tree stands in its flags from this bit on, two bits a level, the root's lowest.
pub const TRIANGLE_TRAIL_SHIFT: u32 = 4;
/// Clusters of a node of the light tree; a level of a trail has two bits, so it is 4.
pub const LIGHT_TREE_CHILDREN: u32 = 4;
/// Deepest light tree: `LIGHT_TREE_CHILDREN` to this power is as many lights as there may be triangles, 2^28.
pub const LIGHT_TREE_LEVELS: u32 = 14;
/// Words that the light tree shares out.
pub const LIGHT_TREE_WORDS: u32 = 1 << 31;
/// Triangles that one child of a wide node may hold.
pub const WIDE_LEAF_TRIANGLES: u32 = 3;
/// Children of a wide node.
pub const WIDE_CHILDREN: u32 = 8;
/// Deepest tree that the shader's stack is ever asked for; builders keep below it.
pub const MAX_TREE_DEPTH: u32 = 64;

// ---- Material kinds ---------------------------------------------------------------------------------------------

/// Two-sided Lambert reflection; `reflectance` is the albedo.
pub const MATERIAL_LAMBERT: u32 = 0;
/// Perfect mirror; `reflectance` scales what it reflects.
pub const MATERIAL_MIRROR: u32 = 1;
/// Smooth dielectric with air outside; `ior` is its index of refraction.
pub const MATERIAL_GLASS: u32 = 2;

/// Pixel filter kind: the sample is uniform over the pixel.
pub const FILTER_BOX: u32 = 0;
/// Pixel filter kind: the sample's offset comes from the filter's table.
pub const FILTER_TABLE: u32 = 1;

// ---- Bindings of the path tracer (descriptor set 0) ---------------------------------------------------------------

/// Records bound as uniform texel buffers, in this order from 0; the storage-buffer twin of binding `b` is
/// `b + STORAGE_TWIN`.
pub const BINDING_NODES: u32 = 0;
/// Triangles in leaf order.
pub const BINDING_TRIANGLES: u32 = 1;
/// Surfaces, one a triangle, in leaf order.
pub const BINDING_SURFACES: u32 = 2;
/// Corners, one a triangle, in leaf order; absent where no triangle is smooth.
pub const BINDING_CORNERS: u32 = 3;
/// Materials.
pub const BINDING_MATERIALS: u32 = 4;
/// Lights, in order of rising `cdf_end`.
pub const BINDING_LIGHTS: u32 = 5;
/// The camera.
pub const BINDING_CAMERA: u32 = 6;
/// The pixel filter's table.
pub const BINDING_FILTER: u32 = 7;
/// The table of random numbers of the `table` sampler.
pub const BINDING_RANDOM: u32 = 8;
/// Nodes of the light tree; absent where lights are chosen from a list.
pub const BINDING_LIGHT_NODES: u32 = 9;
/// Number of record buffers: bindings `0 .. RECORD_BINDINGS`.
pub const RECORD_BINDINGS: u32 = 10;
/// Distance from a record buffer's texel binding to its storage-buffer twin.
pub const STORAGE_TWIN: u32 = 10;
/// Path states of the tile as they are read (a uniform texel buffer, or null).
pub const BINDING_PATHS: u32 = 20;
/// The same buffer as it is written, and read where it has no texel view (storage).
pub const BINDING_PATHS_WRITTEN: u32 = 21;
/// Two lists of pixels of the tile, one after the other, a word a pixel (storage): a dispatch goes on with the pixels of one and
/// puts those that it leaves unfinished into the other.
pub const BINDING_LISTS: u32 = 22;
/// Open sums of the tile, four words a pixel: `[sum.rgb, count]` (storage).
pub const BINDING_SUMS: u32 = 23;
/// Counters of a dispatch (storage), the `COUNTER_*` words.
pub const BINDING_COUNTERS: u32 = 24;
/// Input of a probe kernel, as texels (tests and self-tests only).
pub const BINDING_PROBE_INPUT: u32 = 25;
/// Output of a probe kernel (storage; tests and self-tests only).
pub const BINDING_PROBE_OUTPUT: u32 = 26;

// ---- Counters -----------------------------------------------------------------------------------------------------

/// Pixels whose samples of this run are unfinished when the dispatch ends.
pub const COUNTER_UNFINISHED: u32 = 0;
/// Rays started (extension and shadow).
pub const COUNTER_RAYS: u32 = 1;
/// Paths ended.
pub const COUNTER_PATHS: u32 = 2;
/// Largest number of steps that an invocation took: proves the budget.
pub const COUNTER_MAX_STEPS: u32 = 3;
/// Traversal-stack overflows: proves the depth bound.
pub const COUNTER_STACK_OVERFLOW: u32 = 4;
/// Node visits (one a step of a tree).
pub const COUNTER_NODES: u32 = 5;
/// Triangle tests.
pub const COUNTER_TRIANGLES: u32 = 6;
/// First counter of the samples left out: one a kind, then one a cause.
pub const COUNTER_INVALID: u32 = 7;
/// Number of counters.
pub const COUNTERS: u32 = COUNTER_INVALID + INVALID_COUNTS;

/// Kind of invalid sample: its radiance is not a number.
pub const INVALID_NAN: u32 = 0;
/// Kind of invalid sample: infinite, or too large for the film's fixed-point sums.
pub const INVALID_INFINITE: u32 = 1;
/// Kind of invalid sample: negative.
pub const INVALID_NEGATIVE: u32 = 2;
/// Number of kinds; the causes are counted after them.
pub const INVALID_KINDS: u32 = 3;
/// Kinds and causes.
pub const INVALID_COUNTS: u32 = INVALID_KINDS + CAUSES;

/// Cause of an invalid sample: no stage alone, its terms were valid and their sum is not.
pub const CAUSE_SUM: u32 = 0;
/// Cause: the camera's ray.
pub const CAUSE_CAMERA: u32 = 1;
/// Cause: emission that a ray met, or its weight.
pub const CAUSE_EMISSION: u32 = 2;
/// Cause: the sky.
pub const CAUSE_SKY: u32 = 3;
/// Cause: a light sample.
pub const CAUSE_LIGHT: u32 = 4;
/// Cause: a direction that the Lambert lobe sampled, or its weight.
pub const CAUSE_LAMBERT: u32 = 5;
/// Cause: a direction of a mirror, or its weight.
pub const CAUSE_MIRROR: u32 = 6;
/// Cause: a direction of glass, or its weight.
pub const CAUSE_GLASS: u32 = 7;
/// Number of causes.
pub const CAUSES: u32 = 8;

// ---- Path state of an unfinished pixel: texel `field * tile_pixels + pixel` (glsl/path_state.glsl) -----------------

/// Texels of a path state without its traversal stack: phase, flags and counts, `pdf` and `eta_scale`; `o`, `d`, `wi`, `pending`,
/// `throughput` and `radiance`, each with a word of something else; two of where the traversal stands. The stack follows.
pub const PATH_TEXELS: u32 = 9;
/// Entries of the traversal stack in a texel; a stack has whole texels.
pub const STACK_ENTRIES_A_TEXEL: u32 = 2;
/// Lists of pixels.
pub const LISTS: u32 = 2;
/// A dispatch takes the pixels of a list in rows of this many invocations.
pub const LIST_ROW: u32 = 64;

// ---- Specialisation constants ---------------------------------------------------------------------------------------

/// Workgroup width, in invocations (pixels).
pub const SPEC_WORKGROUP_X: u32 = 0;
/// Workgroup height, in invocations (pixels).
pub const SPEC_WORKGROUP_Y: u32 = 1;
/// 1: records are read from storage buffers, 0: from texel buffers.
pub const SPEC_STORAGE_RECORDS: u32 = 2;
/// The `ACCEL_*` value.
pub const SPEC_ACCEL: u32 = 3;
/// Entries of the traversal stack, at least 1; the path tracer's are whole texels.
pub const SPEC_STACK_ENTRIES: u32 = 4;
/// The `INTERSECTOR_*` value.
pub const SPEC_INTERSECTOR: u32 = 5;
/// The `SAMPLER_*` value.
pub const SPEC_SAMPLER: u32 = 6;
/// The `LIGHTS_*` value.
pub const SPEC_LIGHTS: u32 = 7;
/// The `HEMISPHERE_*` value.
pub const SPEC_HEMISPHERE: u32 = 8;
/// The `ROULETTE_*` value.
pub const SPEC_ROULETTE: u32 = 9;
/// Lanes refill when fewer than this many eighths of the subgroup still trace.
pub const SPEC_REFILL_EIGHTHS: u32 = 10;
/// The guard (`GUARD_*`) that a kernel is built without: tests and studies only, a user's render has them all.
pub const SPEC_WITHOUT_GUARD: u32 = 11;
/// Triangles that a lane tests between two node visits of its vector, the rest waiting for the next: 1 or 2, or 0 for all.
pub const SPEC_TESTS_A_VISIT: u32 = 12;
/// The `LIGHT_PICK_*` value.
pub const SPEC_LIGHT_PICK: u32 = 13;
/// 1: path states are read from their storage buffer, 0: from its texel view.
pub const SPEC_STORAGE_PATHS: u32 = 14;
/// First effect switch; effect `e` has the constant `SPEC_EFFECTS + e`, 1 where it is on.
pub const SPEC_EFFECTS: u32 = 32;

/// Effect: triangles that emit.
pub const EFFECT_EMITTERS: u32 = 0;
/// Effect: a constant environment.
pub const EFFECT_SKY: u32 = 1;
/// Effect: perfect mirrors.
pub const EFFECT_MIRROR: u32 = 2;
/// Effect: smooth glass.
pub const EFFECT_GLASS: u32 = 3;
/// Effect: interpolated vertex normals.
pub const EFFECT_SMOOTH_NORMALS: u32 = 4;
/// Effect: a pixel filter other than the box.
pub const EFFECT_PIXEL_FILTER: u32 = 5;
/// Number of effects.
pub const EFFECTS: u32 = 6;

/// No tree: every ray tests every triangle.
pub const ACCEL_BRUTE: u32 = 0;
/// Binary tree.
pub const ACCEL_BINARY: u32 = 1;
/// Compressed 8-wide tree.
pub const ACCEL_WIDE: u32 = 2;

/// Watertight test of Woop, Benthin and Wald (JCGT 2013).
pub const INTERSECTOR_WATERTIGHT: u32 = 0;
/// Test of Möller and Trumbore (1997): leaks at edges, kept for comparison.
pub const INTERSECTOR_MOLLER_TRUMBORE: u32 = 1;

/// Shuffled, Owen-scrambled Sobol' points in padded pairs of dimensions.
pub const SAMPLER_SOBOL: u32 = 0;
/// Independent numbers by a hash.
pub const SAMPLER_INDEPENDENT: u32 = 1;
/// Numbers made by the host and read from a table.
pub const SAMPLER_TABLE: u32 = 2;

/// Light is gathered by next-event estimation and by BSDF sampling, combined by the power heuristic.
pub const LIGHTS_MIS: u32 = 0;
/// Light is gathered by next-event estimation alone; emission counts at camera rays and after specular bounces.
pub const LIGHTS_AREA: u32 = 1;
/// Light is gathered by BSDF sampling alone.
pub const LIGHTS_BSDF: u32 = 2;

/// A light is chosen from a list, with a probability of its own.
pub const LIGHT_PICK_LIST: u32 = 0;
/// A light is chosen by what it may contribute to the point that is lit, by a descent of the light tree.
pub const LIGHT_PICK_TREE: u32 = 1;

/// Cosine-weighted directions.
pub const HEMISPHERE_COSINE: u32 = 0;
/// Directions uniform over the hemisphere.
pub const HEMISPHERE_UNIFORM: u32 = 1;

/// No Russian roulette.
pub const ROULETTE_OFF: u32 = 0;
/// A path whose throughput is small survives with a probability in proportion to it.
pub const ROULETTE_THROUGHPUT: u32 = 1;
/// A path survives with a fixed probability.
pub const ROULETTE_FIXED: u32 = 2;

/// Samples of a block.
pub const BLOCK_SAMPLES: u32 = 16;
/// Largest step budget of an invocation in a dispatch: lavapipe ends the loops of a vector, here of [`BUDGET_LANES`], silently, after
/// 65,535 iterations of all its lanes together.
pub const MAX_STEP_BUDGET: u32 = 8191;
/// Lanes of a vector for which step budgets of CPU devices are meant; wider ones have less for each lane.
pub const BUDGET_LANES: u32 = 8;
/// Step budget on CPU devices. A pass on which the last lanes leave a loop counts against the driver's limit without being a
/// step: a lane alone may use two iterations a step, so half of the largest budget is within the limit whatever the lanes do.
pub const CPU_STEP_BUDGET: u32 = 4000;
/// Smallest step budget: enough for one node with all its triangles, and some headway.
pub const MIN_STEP_BUDGET: u32 = 64;

/// Dispatch flag: the first dispatch of a run for these pixels; path states are begun, not read.
pub const DISPATCH_BEGINS_RUN: u32 = 1;
/// Flag: unfinished pixels go into the first list (a dispatch that goes on takes its own from the second), not the second.
pub const DISPATCH_FILLS_FIRST_LIST: u32 = 2;

// ---- Guards: what keeps the hard cases right; render/guard.rs --------------------------------------------------

/// No guard is out.
pub const GUARD_NONE: u32 = 0;

/// The guards: a constant each, the list of them, and an enum.
macro_rules! guards {
    ($($guard:ident, $name:ident = $number:literal, case $case:literal: $purpose:literal;)*) => {
        $(#[doc = $purpose] #[doc = concat!("(hard case ", $case, ").")] pub const $name: u32 = $number;)*

        /// Every guard: its name and number, the hard case that it cures first of all, and what it does, a sentence without
        /// its end. Those of the host have numbers too, and no shader asks for them.
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
    TriangleBox, GUARD_TRIANGLE_BOX = 2, case 16: "A hit counts only where the ray meets the triangle's own padded box, and not before it";
    DirectionFloor, GUARD_DIRECTION_FLOOR = 3, case 22: "Direction components count as at least 1e-18 in box tests";
    CullSlack, GUARD_CULL_SLACK = 4, case 23: "A box is left out only where it is entered clearly beyond the best hit";
    EmitterNearer, GUARD_EMITTER_NEARER = 5, case 20: "An emitter in the plane of another surface comes first";
    ShadowLimit, GUARD_SHADOW_LIMIT = 6, case 33: "A shadow ray ends a little before its light";
    SpawnOffset, GUARD_SPAWN_OFFSET = 7, case 32: "A ray starts beyond the error of the point that it leaves";
    SkipSource, GUARD_SKIP_SOURCE = 8, case 30: "A ray does not meet the triangle that it leaves";
    SkipLight, GUARD_SKIP_LIGHT = 9, case 33: "A shadow ray does not meet the light that it aims at";
    UnfusedEdges, GUARD_UNFUSED_EDGES = 10, case 13: "Edge functions round both of their products";
    RefuseInvalidRays, GUARD_REFUSE_INVALID_RAYS = 11, case 29: "A ray that is not finite hits nothing, at no cost";
    ExactDeterminant, GUARD_EXACT_DETERMINANT = 12, case 14: "Only a determinant of exactly 0 is refused, not a small one";
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
    GeometricSide, GUARD_GEOMETRIC_SIDE = 24, case 34: "Directions that the shading normal allows, but the surface hides, carry nothing";
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
    StackDepth, GUARD_STACK_DEPTH = 38, case 26: "The traversal stack is as deep as the tree, by the builder's bound (host)";
    DropDegenerate, GUARD_DROP_DEGENERATE = 39, case 18: "Triangles without area are dropped at load (host)";
    LightFloor, GUARD_LIGHT_FLOOR = 40, case 43: "Each light below a node of the light tree keeps one word of the node's at least";
    ClusterSpread, GUARD_CLUSTER_SPREAD = 41, case 43: "A cluster of lights counts by the best direction that it subtends, not by its centre's";
    ClusterDistance, GUARD_CLUSTER_DISTANCE = 42, case 38: "A cluster of lights counts as no nearer than its own radius";
    ClusterShare, GUARD_CLUSTER_SHARE = 43, case 44: "A faint cluster beside a bright one keeps a share by how many lights it has";
}

// ---- Push constants: byte offsets ---------------------------------------------------------------------------------

/// Name and byte offset of each push constant; every one is four bytes.
pub const PUSH_CONSTANTS: &[(&str, u32)] = &[
    ("PUSH_TILE_X", 0),
    ("PUSH_TILE_Y", 4),
    ("PUSH_TILE_WIDTH", 8),
    ("PUSH_TILE_HEIGHT", 12),
    ("PUSH_SLICE_ROW", 16),
    ("PUSH_SLICE_ROWS", 20),
    ("PUSH_FIRST_SAMPLE", 24),
    ("PUSH_SAMPLES", 28),
    ("PUSH_BUDGET", 32),
    ("PUSH_FLAGS", 36),
    ("PUSH_TRIANGLES", 40),
    ("PUSH_LIGHTS", 44),
    ("PUSH_MAX_BOUNCES", 48),
    ("PUSH_REPLICATE", 52),
    ("PUSH_FIRST_INDEX", 56),
    ("PUSH_SEED_LOW", 60),
    ("PUSH_SEED_HIGH", 64),
    ("PUSH_ROULETTE_P", 68),
    ("PUSH_SKY_R", 72),
    ("PUSH_SKY_G", 76),
    ("PUSH_SKY_B", 80),
    ("PUSH_LISTED_FIRST", 84),
    ("PUSH_LISTED", 88),
    ("PUSH_FILLED", 92),
    ("PUSH_LEAVE_EIGHTHS", 96),
];
/// Size of the push-constant block in bytes; Vulkan promises 128.
pub const PUSH_CONSTANT_BYTES: u32 = 100;

/// Bits of the f32 2^32: a sample of larger radiance (in units of the brightest emission) is left out as infinite, so that
/// a block sums to at most 2^36, which the film's fixed-point sums hold.
pub const MAX_SAMPLE_RADIANCE_BITS: u32 = 0x4f80_0000;

/// The constants that `build.rs` writes to `interface.glsl`, as `(name, value)`, all `uint`; those of [`GUARDS`] come too.
#[rustfmt::skip]
pub const SHADER_CONSTANTS: &[(&str, u32)] = &[
    ("BINARY_NODE_TEXELS", BINARY_NODE_TEXELS), ("WIDE_NODE_TEXELS", WIDE_NODE_TEXELS),
    ("TRIANGLE_TEXELS", TRIANGLE_TEXELS), ("SURFACE_TEXELS", SURFACE_TEXELS), ("CORNERS_TEXELS", CORNERS_TEXELS),
    ("MATERIAL_TEXELS", MATERIAL_TEXELS), ("LIGHT_TEXELS", LIGHT_TEXELS), ("CAMERA_TEXELS", CAMERA_TEXELS),
    ("LIGHT_NODE_TEXELS", LIGHT_NODE_TEXELS), ("TRIANGLE_TRAIL_SHIFT", TRIANGLE_TRAIL_SHIFT),
    ("LIGHT_TREE_LEVELS", LIGHT_TREE_LEVELS), ("LIGHT_TREE_WORDS", LIGHT_TREE_WORDS),
    ("BINDING_LIGHT_NODES", BINDING_LIGHT_NODES), ("SPEC_LIGHT_PICK", SPEC_LIGHT_PICK),
    ("LIGHT_PICK_LIST", LIGHT_PICK_LIST), ("LIGHT_PICK_TREE", LIGHT_PICK_TREE),
    ("FILTER_ENTRIES", FILTER_ENTRIES), ("RANDOM_TABLE_TEXELS", RANDOM_TABLE_TEXELS), ("PAIRS_PER_BOUNCE", PAIRS_PER_BOUNCE),
    ("NO_INDEX", NO_INDEX), ("TRIANGLE_EMITS", TRIANGLE_EMITS), ("TRIANGLE_SMOOTH", TRIANGLE_SMOOTH),
    ("WIDE_LEAF_TRIANGLES", WIDE_LEAF_TRIANGLES), ("WIDE_CHILDREN", WIDE_CHILDREN),
    ("MATERIAL_LAMBERT", MATERIAL_LAMBERT), ("MATERIAL_MIRROR", MATERIAL_MIRROR), ("MATERIAL_GLASS", MATERIAL_GLASS),
    ("FILTER_BOX", FILTER_BOX), ("FILTER_TABLE", FILTER_TABLE),
    ("BINDING_NODES", BINDING_NODES), ("BINDING_TRIANGLES", BINDING_TRIANGLES),
    ("BINDING_SURFACES", BINDING_SURFACES), ("BINDING_CORNERS", BINDING_CORNERS),
    ("BINDING_MATERIALS", BINDING_MATERIALS), ("BINDING_LIGHTS", BINDING_LIGHTS), ("BINDING_CAMERA", BINDING_CAMERA),
    ("BINDING_FILTER", BINDING_FILTER), ("BINDING_RANDOM", BINDING_RANDOM), ("STORAGE_TWIN", STORAGE_TWIN),
    ("BINDING_PATHS", BINDING_PATHS), ("BINDING_PATHS_WRITTEN", BINDING_PATHS_WRITTEN), ("BINDING_LISTS", BINDING_LISTS),
    ("BINDING_SUMS", BINDING_SUMS), ("BINDING_COUNTERS", BINDING_COUNTERS),
    ("BINDING_PROBE_INPUT", BINDING_PROBE_INPUT), ("BINDING_PROBE_OUTPUT", BINDING_PROBE_OUTPUT),
    ("COUNTER_UNFINISHED", COUNTER_UNFINISHED), ("COUNTER_RAYS", COUNTER_RAYS), ("COUNTER_PATHS", COUNTER_PATHS),
    ("COUNTER_MAX_STEPS", COUNTER_MAX_STEPS), ("COUNTER_STACK_OVERFLOW", COUNTER_STACK_OVERFLOW),
    ("COUNTER_NODES", COUNTER_NODES), ("COUNTER_TRIANGLES", COUNTER_TRIANGLES), ("COUNTER_INVALID", COUNTER_INVALID),
    ("COUNTERS", COUNTERS), ("INVALID_NAN", INVALID_NAN), ("INVALID_INFINITE", INVALID_INFINITE),
    ("INVALID_NEGATIVE", INVALID_NEGATIVE), ("INVALID_KINDS", INVALID_KINDS), ("INVALID_COUNTS", INVALID_COUNTS),
    ("CAUSE_SUM", CAUSE_SUM), ("CAUSE_CAMERA", CAUSE_CAMERA), ("CAUSE_EMISSION", CAUSE_EMISSION),
    ("CAUSE_SKY", CAUSE_SKY), ("CAUSE_LIGHT", CAUSE_LIGHT), ("CAUSE_LAMBERT", CAUSE_LAMBERT),
    ("CAUSE_MIRROR", CAUSE_MIRROR), ("CAUSE_GLASS", CAUSE_GLASS),
    ("PATH_TEXELS", PATH_TEXELS), ("STACK_ENTRIES_A_TEXEL", STACK_ENTRIES_A_TEXEL),
    ("LIST_ROW", LIST_ROW), ("DISPATCH_FILLS_FIRST_LIST", DISPATCH_FILLS_FIRST_LIST),
    ("SPEC_WORKGROUP_X", SPEC_WORKGROUP_X), ("SPEC_WORKGROUP_Y", SPEC_WORKGROUP_Y),
    ("SPEC_STORAGE_RECORDS", SPEC_STORAGE_RECORDS), ("SPEC_STORAGE_PATHS", SPEC_STORAGE_PATHS), ("SPEC_ACCEL", SPEC_ACCEL),
    ("SPEC_STACK_ENTRIES", SPEC_STACK_ENTRIES), ("SPEC_INTERSECTOR", SPEC_INTERSECTOR), ("SPEC_SAMPLER", SPEC_SAMPLER),
    ("SPEC_LIGHTS", SPEC_LIGHTS), ("SPEC_HEMISPHERE", SPEC_HEMISPHERE), ("SPEC_ROULETTE", SPEC_ROULETTE),
    ("SPEC_REFILL_EIGHTHS", SPEC_REFILL_EIGHTHS), ("SPEC_EFFECTS", SPEC_EFFECTS),
    ("SPEC_TESTS_A_VISIT", SPEC_TESTS_A_VISIT),
    ("EFFECT_EMITTERS", EFFECT_EMITTERS), ("EFFECT_SKY", EFFECT_SKY), ("EFFECT_MIRROR", EFFECT_MIRROR),
    ("EFFECT_GLASS", EFFECT_GLASS), ("EFFECT_SMOOTH_NORMALS", EFFECT_SMOOTH_NORMALS),
    ("EFFECT_PIXEL_FILTER", EFFECT_PIXEL_FILTER),
    ("ACCEL_BRUTE", ACCEL_BRUTE), ("ACCEL_BINARY", ACCEL_BINARY), ("ACCEL_WIDE", ACCEL_WIDE),
    ("INTERSECTOR_WATERTIGHT", INTERSECTOR_WATERTIGHT), ("INTERSECTOR_MOLLER_TRUMBORE", INTERSECTOR_MOLLER_TRUMBORE),
    ("SAMPLER_SOBOL", SAMPLER_SOBOL), ("SAMPLER_INDEPENDENT", SAMPLER_INDEPENDENT), ("SAMPLER_TABLE", SAMPLER_TABLE),
    ("LIGHTS_MIS", LIGHTS_MIS), ("LIGHTS_AREA", LIGHTS_AREA), ("LIGHTS_BSDF", LIGHTS_BSDF),
    ("HEMISPHERE_COSINE", HEMISPHERE_COSINE), ("HEMISPHERE_UNIFORM", HEMISPHERE_UNIFORM),
    ("ROULETTE_OFF", ROULETTE_OFF), ("ROULETTE_THROUGHPUT", ROULETTE_THROUGHPUT), ("ROULETTE_FIXED", ROULETTE_FIXED),
    ("BLOCK_SAMPLES", BLOCK_SAMPLES),
    ("DISPATCH_BEGINS_RUN", DISPATCH_BEGINS_RUN), ("MAX_SAMPLE_RADIANCE_BITS", MAX_SAMPLE_RADIANCE_BITS),
    ("SPEC_WITHOUT_GUARD", SPEC_WITHOUT_GUARD), ("GUARD_NONE", GUARD_NONE),
];
