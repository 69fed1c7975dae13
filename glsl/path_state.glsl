// The state of a path between any two steps, and how it is kept from one dispatch to the next.
//
// Letters and terms, for the whole renderer: `wo`, `wi` unit vectors away from a surface, towards where the path came from
// and goes to; `o`, `d` a ray's origin and direction; `pdf` a probability density; `throughput` the product of BSDF
// weights along the path; `ng`, `ns` the geometric and shading normal; `u`, `b1`, `b2` random numbers and barycentrics.
#ifndef PATH_STATE_GLSL
#define PATH_STATE_GLSL

#include "bindings.glsl"
#include "effects.glsl"
#include "trace/traversal.glsl"

const uint PHASE_CAMERA = 0u;    // Needs the camera ray of its next sample.
const uint PHASE_EXTENSION = 1u; // Traces the ray that extends the path.
const uint PHASE_SHADOW = 2u;    // Traces the ray to the light sample; the extension ray waits.
const uint PHASE_FINISHED = 3u;  // Has no sample left in this run.

struct Path {
    uint phase;            // PHASE_ value.
    bool specular;         // Whether the last bounce had no density (camera, mirror, glass): emission counts in full.
    bool extends;          // With PHASE_SHADOW: whether an extension ray waits.
    uint samples_done;     // Samples of this run that are finished.
    uint bounce;           // Surface scatterings so far.
    vec3 o, d;             // The ray being traced.
    vec3 wi;               // Direction of the extension ray that waits for the shadow ray.
    vec3 pending;          // Radiance that arrives if the shadow ray is not blocked.
    vec3 throughput;       // Of the extension ray.
    vec3 radiance;         // Gathered by this sample so far.
    float pdf;             // Density of the extension ray's direction.
    uint normal;           // With a light tree: the shading normal that the ray left, octahedral.
    float eta_scale;       // Product of squared relative indices: throughput * eta_scale has no refraction scaling.
    uint skip, skip_too;   // Triangles that the ray cannot hit (leaf order).
    uint cause;            // CAUSE_ value: the first stage of this sample whose numbers were invalid.
    Traversal traversal;
};

// Cursor over the words of a pixel's state.
uint state_word(uint field, uint pixel) {
    return field * (push.tile_width * push.tile_height) + pixel;
}

// Place `at` of list 0 or 1 of pixels.
uint list_word(uint list, uint at) {
    return state_word(PATH_WORDS + STACK_ENTRIES * STACK_ENTRY_WORDS + list, at);
}

void store_vec3(uint field, uint pixel, vec3 v) {
    path_words[state_word(field, pixel)] = floatBitsToUint(v.x);
    path_words[state_word(field + 1u, pixel)] = floatBitsToUint(v.y);
    path_words[state_word(field + 2u, pixel)] = floatBitsToUint(v.z);
}

vec3 load_vec3(uint field, uint pixel) {
    return uintBitsToFloat(uvec3(path_words[state_word(field, pixel)], path_words[state_word(field + 1u, pixel)],
                                 path_words[state_word(field + 2u, pixel)]));
}

void store_uvec2(uint field, uint pixel, uvec2 v) {
    path_words[state_word(field, pixel)] = v.x;
    path_words[state_word(field + 1u, pixel)] = v.y;
}

uvec2 load_uvec2(uint field, uint pixel) {
    return uvec2(path_words[state_word(field, pixel)], path_words[state_word(field + 1u, pixel)]);
}

// Word 0 of a state: phase in bits 0 and 1, then specular, extends, searching, and the cause in bits 5 to 7.
uint pack_flags(Path path) {
    return path.phase | (path.specular ? 4u : 0u) | (path.extends ? 8u : 0u) | (path.traversal.searching ? 16u : 0u) |
           (path.cause << 5);
}

// A finished pixel keeps its flags alone: the next run begins anew.
void store_path(Path path, uint pixel) {
    path_words[state_word(0u, pixel)] = pack_flags(path);
    if (path.phase == PHASE_FINISHED) {
        return;
    }
    Traversal traversal = path.traversal;
    path_words[state_word(1u, pixel)] = path.samples_done;
    path_words[state_word(2u, pixel)] = path.bounce;
    store_vec3(3u, pixel, path.o);
    store_vec3(6u, pixel, path.d);
    store_vec3(9u, pixel, path.wi);
    store_vec3(12u, pixel, path.pending);
    store_vec3(15u, pixel, path.throughput);
    store_vec3(18u, pixel, path.radiance);
    path_words[state_word(21u, pixel)] = floatBitsToUint(path.pdf);
    path_words[state_word(22u, pixel)] = floatBitsToUint(path.eta_scale);
    path_words[state_word(23u, pixel)] = path.skip;
    path_words[state_word(24u, pixel)] = path.skip_too;
    path_words[state_word(25u, pixel)] = floatBitsToUint(traversal.best.key);
    path_words[state_word(26u, pixel)] = traversal.best.id;
    path_words[state_word(27u, pixel)] = traversal.best.triangle;
    path_words[state_word(28u, pixel)] = floatBitsToUint(traversal.best.b1);
    path_words[state_word(29u, pixel)] = floatBitsToUint(traversal.best.b2);
    store_uvec2(30u, pixel, traversal.nodes);
    store_uvec2(32u, pixel, traversal.triangles);
    if (TESTS_A_VISIT != 0u) {
        store_uvec2(34u, pixel, traversal.queued);
    }
    path_words[state_word(36u, pixel)] = traversal.stack_size;
    if (LIGHT_PICK == LIGHT_PICK_TREE) {
        path_words[state_word(37u, pixel)] = path.normal;
    }
    // Constant bounds keep the stack in registers (traversal.glsl).
    for (uint i = 0u; i < STACK_ENTRIES; i++) {
        if (i < traversal.stack_size) {
            store_uvec2(PATH_WORDS + i * STACK_ENTRY_WORDS, pixel, stack[i]);
        }
    }
}

Path load_path(uint pixel) {
    uint flags = path_words[state_word(0u, pixel)];
    Path path;
    path.phase = flags & 3u;
    path.specular = (flags & 4u) != 0u;
    path.extends = (flags & 8u) != 0u;
    path.cause = (flags >> 5) & 7u;
    path.samples_done = path_words[state_word(1u, pixel)];
    path.bounce = path_words[state_word(2u, pixel)];
    path.o = load_vec3(3u, pixel);
    path.d = load_vec3(6u, pixel);
    path.wi = load_vec3(9u, pixel);
    path.pending = load_vec3(12u, pixel);
    path.throughput = load_vec3(15u, pixel);
    path.radiance = load_vec3(18u, pixel);
    path.pdf = uintBitsToFloat(path_words[state_word(21u, pixel)]);
    path.eta_scale = uintBitsToFloat(path_words[state_word(22u, pixel)]);
    path.skip = path_words[state_word(23u, pixel)];
    path.skip_too = path_words[state_word(24u, pixel)];
    path.normal = 0u;
    if (LIGHT_PICK == LIGHT_PICK_TREE) {
        path.normal = path_words[state_word(37u, pixel)];
    }
    Traversal traversal;
    traversal.best.key = uintBitsToFloat(path_words[state_word(25u, pixel)]);
    traversal.best.id = path_words[state_word(26u, pixel)];
    traversal.best.triangle = path_words[state_word(27u, pixel)];
    traversal.best.b1 = uintBitsToFloat(path_words[state_word(28u, pixel)]);
    traversal.best.b2 = uintBitsToFloat(path_words[state_word(29u, pixel)]);
    traversal.nodes = load_uvec2(30u, pixel);
    traversal.triangles = load_uvec2(32u, pixel);
    traversal.queued = uvec2(0u);
    if (TESTS_A_VISIT != 0u) {
        traversal.queued = load_uvec2(34u, pixel);
    }
    traversal.stack_size = path_words[state_word(36u, pixel)];
    traversal.searching = (flags & 16u) != 0u;
    for (uint i = 0u; i < STACK_ENTRIES; i++) {
        if (i < traversal.stack_size) {
            stack[i] = load_uvec2(PATH_WORDS + i * STACK_ENTRY_WORDS, pixel);
        }
    }
    path.traversal = traversal;
    return path;
}

#endif
