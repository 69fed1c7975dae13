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

#include "record_buffers.glsl"

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

#include "push.glsl"

#endif
