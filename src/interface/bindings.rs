//! Bindings of the kernels (descriptor set 0).
//!
//! Goes out: numbers, and the list of record buffers, of which `build.rs` declares each in `record_buffers.glsl`, as a
//! texel buffer at its number and as its storage twin at `STORAGE_TWIN` above it.

macro_rules! records {
    ($($record:ident, $name:ident = $number:literal, $glsl:ident, $text:literal, $why:literal: $what:literal;)*) => {
        numbered! { RECORD_NUMBERS, RECORD_NAMES, RECORD_BINDINGS; $($name = $number, $text: $what;)* }

        /// A kind of record.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum Record {
            $(#[doc = $what] $record = $number,)*
        }

        impl Record {
            /// Every kind, in the order of their bindings.
            pub const ALL: &[Record] = &[$(Record::$record),*];

            /// Its binding as texels.
            pub const fn binding(self) -> u32 {
                self as u32
            }

            /// Its buffer's name for users.
            pub const fn name(self) -> &'static str {
                RECORD_NAMES[self as usize]
            }

            /// Its buffer's name in the shaders.
            pub const fn glsl(self) -> &'static str {
                match self {
                    $(Record::$record => stringify!($glsl),)*
                }
            }

            /// What the renderer wants it for.
            pub const fn why(self) -> &'static str {
                match self {
                    $(Record::$record => $why,)*
                }
            }
        }
    };
}

records! {
    Nodes, BINDING_NODES = 0, nodes, "nodes", "boxes of the tree, read at every node visit": "Nodes of the tree.";
    Triangles, BINDING_TRIANGLES = 1, triangles, "triangles", "corner positions, read at every triangle test":
        "Triangles in leaf order.";
    Surfaces, BINDING_SURFACES = 2, surfaces, "surfaces", "normal and material, read once a hit":
        "Surfaces, one a triangle, in leaf order.";
    Corners, BINDING_CORNERS = 3, corners, "corners", "vertex normals, read once a smooth hit":
        "Corners, one a triangle, in leaf order; absent where no triangle is smooth.";
    Materials, BINDING_MATERIALS = 4, materials, "materials", "reflectance and emission, read once a hit": "Materials.";
    Lights, BINDING_LIGHTS = 5, lights, "lights", "emitters and their probabilities, read once a light sample":
        "Lights, in order of rising `cdf_end`.";
    Camera, BINDING_CAMERA = 6, camera, "camera", "pose, picture size, numbers of the render, read once an invocation":
        "The camera, and behind it the numbers of the render.";
    Filter, BINDING_FILTER = 7, filter, "filter", "inverse distribution of the pixel filter, read once a path":
        "The pixel filter's table.";
    Random, BINDING_RANDOM = 8, random, "random", "numbers of the table sampler, read at every bounce":
        "The table of random numbers of the `table` sampler.";
    LightNodes, BINDING_LIGHT_NODES = 9, light_nodes, "light nodes", "clusters of lights, read on the way to a light":
        "Nodes of the light tree; absent where lights are chosen from a list.";
}

numbers! { BINDINGS;
    /// Distance from a record buffer's texel binding to its storage-buffer twin.
    STORAGE_TWIN = RECORD_BINDINGS;
    /// Path states of the tile as they are read (a uniform texel buffer, or null).
    BINDING_PATHS = 2 * RECORD_BINDINGS;
    /// The same buffer as it is written, and read where it has no texel view (storage).
    BINDING_PATHS_WRITTEN = BINDING_PATHS + 1;
    /// Two lists of pixels of the tile, one after the other, a word a pixel (storage): a dispatch goes on with the
    /// pixels of one and puts those that it leaves unfinished into the other.
    BINDING_LISTS = BINDING_PATHS + 2;
    /// Open sums of the tile, four words a pixel: `[sum.rgb, count]` (storage).
    BINDING_SUMS = BINDING_PATHS + 3;
    /// Counters of a dispatch (storage), the `COUNTER_*` words.
    BINDING_COUNTERS = BINDING_PATHS + 4;
    /// Input of a probe kernel, as texels (tests and self-tests only).
    BINDING_PROBE_INPUT = BINDING_PATHS + 5;
    /// Output of a probe kernel (storage; tests and self-tests only).
    BINDING_PROBE_OUTPUT = BINDING_PATHS + 6;
}

/// What the path tracer writes: all of it storage buffers.
pub const WRITTEN_BINDINGS: [u32; 4] = [BINDING_PATHS_WRITTEN, BINDING_LISTS, BINDING_SUMS, BINDING_COUNTERS];
