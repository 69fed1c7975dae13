// Every resource of every kernel, with numbers from the generated interface.glsl. No other file declares one.
//
// The scene's records are read through functions NAME_texel(i), one a buffer; a record's own fetch function (records/) is
// their only caller. Each buffer has two bindings, a uniform texel buffer and its storage-buffer twin; a specialisation
// constant picks one, and the other points at a shared null buffer and is never read. Texel buffers are declared as textures
// without a sampler: SPIR-V deprecates the combination (1.6 forbids it), and newer drivers warn of it.
#ifndef BINDINGS_GLSL
#define BINDINGS_GLSL
#extension GL_EXT_samplerless_texture_functions : require

#include "guards.glsl"
#include "interface.glsl"

layout(constant_id = SPEC_STORAGE_RECORDS) const uint STORAGE_RECORDS = 0u;

#define RECORD_BUFFER(name, number)                                                                                    \
    layout(set = 0, binding = number) uniform utextureBuffer name##_view;                                              \
    layout(set = 0, binding = number + STORAGE_TWIN, std430) readonly buffer name##_block { uvec4 name##_words[]; };   \
    uvec4 name##_texel(uint i) {                                                                                       \
        return STORAGE_RECORDS != 0u ? name##_words[i] : texelFetch(name##_view, int(i));                              \
    }

RECORD_BUFFER(nodes, BINDING_NODES)
RECORD_BUFFER(triangles, BINDING_TRIANGLES)
RECORD_BUFFER(surfaces, BINDING_SURFACES)
RECORD_BUFFER(corners, BINDING_CORNERS)
RECORD_BUFFER(materials, BINDING_MATERIALS)
RECORD_BUFFER(lights, BINDING_LIGHTS)
RECORD_BUFFER(camera, BINDING_CAMERA)
RECORD_BUFFER(filter, BINDING_FILTER)
RECORD_BUFFER(random, BINDING_RANDOM)
RECORD_BUFFER(light_nodes, BINDING_LIGHT_NODES)

// Path states of the tile (path_state.glsl), one buffer under two bindings: written as storage, read as texels. A fetch of four
// lanes costs some drivers as much as one word of storage. Storage is read too where the buffer is too large for a view.
layout(constant_id = SPEC_STORAGE_PATHS) const uint STORAGE_PATHS = 0u;
layout(set = 0, binding = BINDING_PATHS) uniform utextureBuffer paths_view;
layout(set = 0, binding = BINDING_PATHS_WRITTEN, std430) buffer PathStates { uvec4 path_texels[]; };
uvec4 path_texel(uint i) {
    return STORAGE_PATHS != 0u ? path_texels[i] : texelFetch(paths_view, int(i));
}

// Word `list * tile_pixels + place` of the lists of unfinished pixels.
layout(set = 0, binding = BINDING_LISTS, std430) buffer Lists { uint list_words[]; };

// Open sum of each pixel of the tile: radiance sum of the block's samples so far (three floats' bits) and their number.
layout(set = 0, binding = BINDING_SUMS, std430) buffer OpenSums { uvec4 open_sums[]; };

// Counters of a dispatch, the COUNTER_ words.
layout(set = 0, binding = BINDING_COUNTERS, std430) buffer Counters { uint counters[]; };

// Questions to a probe kernel, and its answers (tests and self-tests; no kernel of a render names them).
layout(set = 0, binding = BINDING_PROBE_INPUT, std430) readonly buffer ProbeInput { uvec4 probe_input[]; };
layout(set = 0, binding = BINDING_PROBE_OUTPUT, std430) buffer ProbeOutput { uvec4 probe_output[]; };

layout(push_constant) uniform Push {
    layout(offset = PUSH_TILE_X) uint tile_x;                // Left edge of the tile, in pixels of the whole picture.
    layout(offset = PUSH_TILE_Y) uint tile_y;                // Upper edge of the tile.
    layout(offset = PUSH_TILE_WIDTH) uint tile_width;        // Size of the tile in pixels.
    layout(offset = PUSH_TILE_HEIGHT) uint tile_height;
    layout(offset = PUSH_SLICE_ROW) uint slice_row;          // First row of the tile that this dispatch works on,
    layout(offset = PUSH_SLICE_ROWS) uint slice_rows;        // and how many.
    layout(offset = PUSH_FIRST_SAMPLE) uint first_sample;    // First sample index of the run,
    layout(offset = PUSH_SAMPLES) uint samples;              // and how many; a run never crosses a block's end.
    layout(offset = PUSH_BUDGET) uint budget;                // Steps that an invocation may take in this dispatch.
    layout(offset = PUSH_FLAGS) uint flags;                  // DISPATCH_ bits.
    layout(offset = PUSH_TRIANGLES) uint triangle_count;
    layout(offset = PUSH_LIGHTS) uint light_count;
    layout(offset = PUSH_MAX_BOUNCES) uint max_bounces;      // Surface scatterings a path may have.
    layout(offset = PUSH_REPLICATE) uint replicate;          // Which independently scrambled set of samples the run is of,
    layout(offset = PUSH_FIRST_INDEX) uint first_index;      // and where in it the run's first sample stands.
    layout(offset = PUSH_SEED_LOW) uint seed_low;            // The seed, mixed by the host.
    layout(offset = PUSH_SEED_HIGH) uint seed_high;
    layout(offset = PUSH_ROULETTE_P) float roulette_p;       // Survival probability of the fixed roulette.
    layout(offset = PUSH_SKY_R) float sky_r;                 // Radiance of the constant environment.
    layout(offset = PUSH_SKY_G) float sky_g;
    layout(offset = PUSH_SKY_B) float sky_b;
    layout(offset = PUSH_LISTED_FIRST) uint listed_first;    // A dispatch that goes on takes a list's pixels from here on,
    layout(offset = PUSH_LISTED) uint listed;                // and so many of them.
    layout(offset = PUSH_FILLED) uint filled;                // Pixels that the other list has already.
    layout(offset = PUSH_LEAVE_EIGHTHS) uint leave_eighths;  // Paths are left when fewer eighths of the lanes have work.
} push;

// What the steps of a path read of the push constants, read once, before them: lavapipe reads one that stands in a branch lane by
// lane, as if each had its own.
struct Run {
    uint samples, max_bounces, triangle_count, light_count;
    uint leave_eighths;
    float roulette_p;
    vec3 sky;
};
Run run = Run(push.samples, push.max_bounces, push.triangle_count, push.light_count, push.leave_eighths, push.roulette_p,
              vec3(push.sky_r, push.sky_g, push.sky_b));

#endif
