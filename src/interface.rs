//! The contract between the CPU and the GPU: every number that both sides must agree on, stated once.
//!
//! Comes in: nothing; this file and those below it import nothing, so that `build.rs` can include it by path and write
//! `interface.glsl` from [`SHADER_CONSTANTS`] and [`SHADER_FLOATS`], and blocks, buffers and switches from their lists.
//! Goes out: record strides, binding numbers, specialisation-constant ids, flag bits, and the values of enumerations.
//! Each list is one macro call: a name and its number stand there and nowhere else; what both sides need is made of it.
//!
//! A record is one or more texels of four `u32` lanes. Lanes that hold a float hold its bits; integers stay
//! integers (a small integer seen as a float would be a denormal, which a device may flush to zero).

/// Numbers of both sides: a constant each, and the list of them, by name, that becomes GLSL.
macro_rules! numbers {
    ($list:ident; $($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*

        /// Every number above, by name.
        pub const $list: &[(&str, u32)] = &[$((stringify!($name), $name)),*];
    };
}

/// Things that are numbered from 0 in order and have a name for users: a constant each, how many there are, both lists.
macro_rules! numbered {
    ($list:ident, $names:ident, $count:ident; $($name:ident = $number:literal, $text:literal: $what:literal;)*) => {
        $(#[doc = $what] pub const $name: u32 = $number;)*

        /// How many there are.
        pub const $count: u32 = $list.len() as u32 - 1;
        /// Each number and how many there are, by name.
        pub const $list: &[(&str, u32)] =
            &[$((stringify!($name), $number),)* (stringify!($count), [$($number),*].len() as u32)];
        /// Their names for users, by number.
        pub const $names: [&str; $count as usize] = [$($text),*];

        const _: () = {
            let (numbers, mut place) = ([$($number),*], 0);
            while place < numbers.len() {
                assert!(numbers[place] == place as u32, "numbers count from 0 in order");
                place += 1;
            }
        };
    };
}

#[path = "interface/bindings.rs"]
mod bindings;
#[path = "interface/blocks.rs"]
mod blocks;
#[path = "interface/causes.rs"]
mod causes;
#[path = "interface/effects.rs"]
mod effects;
#[path = "interface/floats.rs"]
mod floats;
#[path = "interface/guards.rs"]
mod guards;
#[path = "interface/packed.rs"]
mod packed;

pub use bindings::*;
pub use blocks::*;
pub use causes::*;
pub use effects::*;
pub use floats::*;
pub use guards::*;
pub use packed::*;

/// The lists of numbers that `build.rs` writes to `interface.glsl`, as `(name, value)`, all `uint`; those of [`GUARDS`]
/// come too.
pub const SHADER_CONSTANTS: &[&[(&str, u32)]] = &[
    NUMBERS,
    RECORD_NUMBERS,
    BINDINGS,
    INVALID_KIND_NUMBERS,
    CAUSE_NUMBERS,
    EFFECT_NUMBERS,
    PATH_WORD,
    TRIANGLE_WORD,
    MATERIAL_WORD,
];

numbers! { NUMBERS;
    // ---- Record strides, in texels (16 bytes each)

    /// Binary node: `[lo.xyz, first]`, `[hi.xyz, count]`. `count` 0 is an inner node whose children stand at `first`
    /// and `first + 1`; otherwise a leaf of the triangles `first .. first + count`.
    BINARY_NODE_TEXELS = 2;
    /// Wide node: the 80-byte compressed node of Ylitie, Karras and Laine (HPG 2017); lanes are listed in
    /// `texels/wide_node.rs`.
    WIDE_NODE_TEXELS = 5;
    /// Triangle in leaf order: `[v0.xyz, id]`, `[v1.xyz, flags]`, `[v2.xyz, pdf_area]`. `id` is the position in file
    /// order, `flags` the `TRIANGLE_*` bits and above them its way through the light tree, `pdf_area` the density per
    /// unit area with which light sampling chooses a point on it (with a light tree: once it has chosen the light), 0
    /// where it does not emit.
    TRIANGLE_TEXELS = 3;
    /// Surface of a triangle, read once a hit is shaded: `[ng.xyz, material]`; `ng` is the unit geometric normal, the
    /// side from which the corners turn counter-clockwise.
    SURFACE_TEXELS = 1;
    /// Shading attributes of a triangle's corners: `[n0.xyz, u0]`, `[n1.xyz, u1]`, `[n2.xyz, u2]`, `[v0, v1, v2, 0]`.
    CORNERS_TEXELS = 4;
    /// Material: `[reflectance.rgb, kind]`, `[emission.rgb, ior]`.
    MATERIAL_TEXELS = 2;
    /// Light (one emissive triangle), all that a light sample needs in one place: `[v0.xyz, cdf_end]`, `[v1.xyz,
    /// triangle]`, `[v2.xyz, pdf_area]`, `[ng.xyz, cdf_begin]`, `[emission.rgb, cdf_scale]`. `cdf_begin` and `cdf_end`
    /// are the first and the last 32-bit random number of its share, `cdf_scale` one over how many there are;
    /// `triangle` is its leaf-order index, `pdf_area` the density per unit area (scaled units) with which a point on it
    /// is chosen, or with a light tree, which has shares of its own, one over its area.
    LIGHT_TEXELS = 5;
    /// Node of the light tree: `LIGHT_TREE_CHILDREN` clusters of lights, two texels each, `[centre.xyz, spread]`,
    /// `[axis, power, child, count]`. `centre` and radius are a ball around them: `spread` has the radius, a float's
    /// upper 16 bits, above the cosine of half the angle of a cone around their normals, a 16-bit word from -1 to 1.
    /// `axis` is that cone's, octahedral (`glsl/sampling/octahedral.glsl`); `power` their share of the scene's, a
    /// float; `count` how many they are, 0 for no cluster (only after others); `child` the light where that is 1,
    /// otherwise the node below.
    LIGHT_NODE_TEXELS = 8;
    /// Camera: `[origin.xyz, filter_kind]`, `[forward.xyz, width]`, `[right.xyz, height]`, `[down.xyz, 0]`. A camera
    /// ray through the film point (x, y), in pixels from the upper left corner, has the direction `forward + (x - width
    /// / 2) right + (y - height / 2) down`; width and height are floats.
    CAMERA_TEXELS = 4;
    /// Entries of the pixel filter's inverse distribution, four floats a texel: offsets from the pixel's centre in
    /// pixels, at the probabilities `i / (FILTER_ENTRIES - 1)`.
    FILTER_ENTRIES = 1024;
    /// Texels of the table of random numbers of the `table` sampler, a power of two: one pair of numbers a texel, and
    /// two more that nothing draws yet.
    RANDOM_TABLE_TEXELS = 1 << 18;
    /// Pairs of random numbers that a bounce may draw; the camera has as many.
    PAIRS_PER_BOUNCE = 4;

    /// No index: the corners of a flat triangle, the hit of a ray that hit nothing.
    NO_INDEX = 0xffff_ffff;
    /// Triangle flag: its material emits (a tie in distance goes to it, design decision 'order of hits').
    TRIANGLE_EMITS = 1;
    /// Triangle flag: it has a record of corners, with vertex normals to interpolate.
    TRIANGLE_SMOOTH = 2;
    /// Clusters of a node of the light tree; a level of a trail has two bits, so it is 4.
    LIGHT_TREE_CHILDREN = 4;
    /// Deepest light tree: `LIGHT_TREE_CHILDREN` to this power is as many lights as there may be triangles, 2^28.
    LIGHT_TREE_LEVELS = 14;
    /// Words that the light tree shares out.
    LIGHT_TREE_WORDS = 1 << 31;
    /// Triangles that one child of a wide node may hold.
    WIDE_LEAF_TRIANGLES = 3;
    /// Children of a wide node.
    WIDE_CHILDREN = 8;
    /// Deepest tree that the shader's stack is ever asked for; builders keep below it.
    MAX_TREE_DEPTH = 64;

    // ---- Material kinds

    /// Two-sided Lambert reflection; `reflectance` is the albedo.
    MATERIAL_LAMBERT = 0;
    /// Perfect mirror; `reflectance` scales what it reflects.
    MATERIAL_MIRROR = 1;
    /// Smooth dielectric with air outside; `ior` is its index of refraction.
    MATERIAL_GLASS = 2;

    /// Pixel filter kind: the sample is uniform over the pixel.
    FILTER_BOX = 0;
    /// Pixel filter kind: the sample's offset comes from the filter's table.
    FILTER_TABLE = 1;

    // ---- Counters

    /// Pixels whose samples of this run are unfinished when the dispatch ends.
    COUNTER_UNFINISHED = 0;
    /// Rays started (extension and shadow).
    COUNTER_RAYS = 1;
    /// Paths ended.
    COUNTER_PATHS = 2;
    /// Largest number of steps that an invocation took: proves the budget.
    COUNTER_MAX_STEPS = 3;
    /// Traversal-stack overflows: proves the depth bound.
    COUNTER_STACK_OVERFLOW = 4;
    /// Node visits (one a step of a tree).
    COUNTER_NODES = 5;
    /// Triangle tests.
    COUNTER_TRIANGLES = 6;
    /// First counter of the samples left out: one a kind, then one a cause.
    COUNTER_INVALID = 7;
    /// Kinds and causes.
    INVALID_COUNTS = INVALID_KINDS + CAUSES;
    /// Number of counters.
    COUNTERS = COUNTER_INVALID + INVALID_COUNTS;

    /// First number of a pair that no purpose of today has: a new purpose's pairs count from here on, for each bounce,
    /// so that those of the others stay.
    FURTHER_PAIRS = PAIRS_PER_BOUNCE * (1 + MAX_BOUNCES);

    // ---- Phases of a path

    /// Needs the camera ray of its next sample.
    PHASE_CAMERA = 0;
    /// Traces the ray that extends the path.
    PHASE_EXTENSION = 1;
    /// Traces the ray to the light sample; the extension ray waits.
    PHASE_SHADOW = 2;
    /// Has no sample left in this run.
    PHASE_FINISHED = 3;

    // ---- Path state of an unfinished pixel: texel `field * tile_pixels + pixel` (glsl/path_state.glsl)

    /// Texels of a path state without its traversal stack: phase, flags and counts, `pdf` and `eta_scale`; `o`, `d`,
    /// `wi`, `pending`, `throughput` and `radiance`, each with a word of something else; two of where the traversal
    /// stands. The stack follows.
    PATH_TEXELS = 9;
    /// Entries of the traversal stack in a texel; a stack has whole texels.
    STACK_ENTRIES_A_TEXEL = 2;
    /// Lists of pixels.
    LISTS = 2;
    /// A dispatch takes the pixels of a list in rows of this many invocations.
    LIST_ROW = 64;

    // ---- Specialisation constants

    /// Workgroup width, in invocations (pixels).
    SPEC_WORKGROUP_X = 0;
    /// Workgroup height, in invocations (pixels).
    SPEC_WORKGROUP_Y = 1;
    /// 1: records are read from storage buffers, 0: from texel buffers.
    SPEC_STORAGE_RECORDS = 2;
    /// The `ACCEL_*` value.
    SPEC_ACCEL = 3;
    /// Entries of the traversal stack, at least 1; the path tracer's are whole texels.
    SPEC_STACK_ENTRIES = 4;
    /// The `INTERSECTOR_*` value.
    SPEC_INTERSECTOR = 5;
    /// The `SAMPLER_*` value.
    SPEC_SAMPLER = 6;
    /// The `LIGHTS_*` value.
    SPEC_LIGHTS = 7;
    /// The `HEMISPHERE_*` value.
    SPEC_HEMISPHERE = 8;
    /// The `ROULETTE_*` value.
    SPEC_ROULETTE = 9;
    /// Lanes refill when fewer than this many eighths of the subgroup still trace.
    SPEC_REFILL_EIGHTHS = 10;
    /// The guard (`GUARD_*`) that a kernel is built without: tests and studies only, a user's render has them all.
    SPEC_WITHOUT_GUARD = 11;
    /// Triangles that a lane tests between two node visits of its vector, the rest waiting for the next: 1 or 2, or 0
    /// for all.
    SPEC_TESTS_A_VISIT = 12;
    /// The `LIGHT_PICK_*` value.
    SPEC_LIGHT_PICK = 13;
    /// 1: path states are read from their storage buffer, 0: from its texel view.
    SPEC_STORAGE_PATHS = 14;
    /// First effect switch; effect `e` has the constant `SPEC_EFFECTS + e`, 1 where it is on.
    SPEC_EFFECTS = 32;

    /// No tree: every ray tests every triangle.
    ACCEL_BRUTE = 0;
    /// Binary tree.
    ACCEL_BINARY = 1;
    /// Compressed 8-wide tree.
    ACCEL_WIDE = 2;

    /// Watertight test of Woop, Benthin and Wald (JCGT 2013).
    INTERSECTOR_WATERTIGHT = 0;
    /// Test of Möller and Trumbore (1997): leaks at edges, kept for comparison.
    INTERSECTOR_MOLLER_TRUMBORE = 1;

    /// Shuffled, Owen-scrambled Sobol' points in padded pairs of dimensions.
    SAMPLER_SOBOL = 0;
    /// Independent numbers by a hash.
    SAMPLER_INDEPENDENT = 1;
    /// Numbers made by the host and read from a table.
    SAMPLER_TABLE = 2;

    /// Light is gathered by next-event estimation and by BSDF sampling, combined by the power heuristic.
    LIGHTS_MIS = 0;
    /// Light is gathered by next-event estimation alone; emission counts at camera rays and after specular bounces.
    LIGHTS_AREA = 1;
    /// Light is gathered by BSDF sampling alone.
    LIGHTS_BSDF = 2;

    /// A light is chosen from a list, with a probability of its own.
    LIGHT_PICK_LIST = 0;
    /// A light is chosen by what it may contribute to the point that is lit, by a descent of the light tree.
    LIGHT_PICK_TREE = 1;

    /// Cosine-weighted directions.
    HEMISPHERE_COSINE = 0;
    /// Directions uniform over the hemisphere.
    HEMISPHERE_UNIFORM = 1;

    /// No Russian roulette.
    ROULETTE_OFF = 0;
    /// A path whose throughput is small survives with a probability in proportion to it.
    ROULETTE_THROUGHPUT = 1;
    /// A path survives with a fixed probability.
    ROULETTE_FIXED = 2;

    /// Samples of a block.
    BLOCK_SAMPLES = 16;
    /// Largest step budget of an invocation in a dispatch: lavapipe ends the loops of a vector, here of
    /// [`BUDGET_LANES`], silently, after 65,535 iterations of all its lanes together.
    MAX_STEP_BUDGET = 8191;
    /// Lanes of a vector for which step budgets of CPU devices are meant; wider ones have less for each lane.
    BUDGET_LANES = 8;
    /// Step budget on CPU devices. A pass on which the last lanes leave a loop counts against the driver's limit
    /// without being a step: a lane alone may use two iterations a step, so half of the largest budget is within the
    /// limit whatever the lanes do.
    CPU_STEP_BUDGET = 4000;
    /// Smallest step budget: enough for one node with all its triangles, and some headway.
    MIN_STEP_BUDGET = 64;
    /// Iterations that shading may spend in loops: the search for a light among at most 2^31, or two descents of the
    /// light tree, for the light that a ray met and for the next light sample, of `LIGHT_TREE_LEVELS` each.
    SHADING_STEPS = 34;
    /// Steps set aside for the loops that load and save the stack, should a driver not unroll them: all lanes of a
    /// vector run them together, 2 x 32 iterations for 8 lanes.
    RESERVED_STEPS = 10;

    /// Dispatch flag: the first dispatch of a run for these pixels; path states are begun, not read.
    DISPATCH_BEGINS_RUN = 1;
    /// Flag: unfinished pixels go into the first list (a dispatch that goes on takes its own from the second), not the
    /// second.
    DISPATCH_FILLS_FIRST_LIST = 2;

    /// Bits of the f32 2^32: a sample of larger radiance (in units of the brightest emission) is left out as infinite,
    /// so that a block sums to at most 2^36, which the film's fixed-point sums hold.
    MAX_SAMPLE_RADIANCE_BITS = 0x4f80_0000;

    /// No guard is out.
    GUARD_NONE = 0;

    // ---- Limits that users meet, too

    /// Largest width and height of a picture, in pixels: a pixel's place is two 16-bit halves of a word.
    MAX_SIDE = 16384;
    /// Most surface scatterings that a path may have.
    MAX_BOUNCES = 65535;
    /// Most replicates a film may have.
    MAX_REPLICATES = 256;

    // ---- Tests and self-tests

    /// Invocations of a workgroup of a probe kernel.
    PROBE_WORKGROUP = 64;
}

// An invocation always has steps left for tracing; a word holds the numbers of all pairs; a pixel's place fits its
// halves.
const _: () = assert!(SHADING_STEPS >= 2 * LIGHT_TREE_LEVELS && SHADING_STEPS >= 31);
const _: () = assert!(SHADING_STEPS + RESERVED_STEPS < MIN_STEP_BUDGET && CPU_STEP_BUDGET <= MAX_STEP_BUDGET);
const _: () = assert!(FURTHER_PAIRS < u32::MAX / 2 && MAX_SIDE <= 1 << 16);
