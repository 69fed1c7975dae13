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

// Place `at` of list 0 or 1 of pixels.
uint list_word(uint list, uint at) {
    return list * (push.tile_width * push.tile_height) + at;
}

// Texel `field` of a pixel's state: neighbours have neighbouring ones.
uint state_texel(uint field, uint pixel) {
    return field * (push.tile_width * push.tile_height) + pixel;
}

void store_texel(uint field, uint pixel, uvec4 texel) {
    path_texels[state_texel(field, pixel)] = texel;
}

uvec4 load_texel(uint field, uint pixel) {
    return path_texel(state_texel(field, pixel));
}

// A vector and a word, as a texel.
uvec4 texel_of(vec3 v, uint word) {
    return uvec4(floatBitsToUint(v), word);
}

// The first word of a state, of the fields PATH_NAME_SHIFT.
uint pack_first(Path path) {
    return path.phase | (path.specular ? 1u << PATH_SPECULAR_SHIFT : 0u) | (path.extends ? 1u << PATH_EXTENDS_SHIFT : 0u) |
           (path.traversal.searching ? 1u << PATH_SEARCHING_SHIFT : 0u) | (path.cause << PATH_CAUSE_SHIFT) |
           (path.samples_done << PATH_SAMPLES_SHIFT) | (path.traversal.stack_size << PATH_STACK_SHIFT);
}

// Nothing is kept of a finished pixel: its next run begins anew.
void store_path(Path path, uint pixel) {
    if (path.phase == PHASE_FINISHED) {
        return;
    }
    Traversal traversal = path.traversal;
    Hit best = traversal.best;
    uvec2 floats = floatBitsToUint(vec2(path.pdf, path.eta_scale));
    // PATH_TEXELS fields, and the stack after them.
    store_texel(0u, pixel, uvec4(pack_first(path), path.bounce, floats));
    store_texel(1u, pixel, texel_of(path.o, path.skip));
    store_texel(2u, pixel, texel_of(path.d, path.skip_too));
    store_texel(3u, pixel, texel_of(path.wi, path.normal));
    store_texel(4u, pixel, texel_of(path.pending, floatBitsToUint(best.key)));
    store_texel(5u, pixel, texel_of(path.throughput, best.id));
    store_texel(6u, pixel, texel_of(path.radiance, best.triangle));
    store_texel(7u, pixel, uvec4(floatBitsToUint(vec2(best.b1, best.b2)), traversal.nodes));
    store_texel(8u, pixel, uvec4(traversal.triangles, traversal.queued));
    // Constant bounds keep the stack in registers (traversal.glsl).
    for (uint i = 0u; i < STACK_ENTRIES / STACK_ENTRIES_A_TEXEL; i++) {
        if (i * STACK_ENTRIES_A_TEXEL < traversal.stack_size) {
            store_texel(PATH_TEXELS + i, pixel, uvec4(stack[STACK_ENTRIES_A_TEXEL * i], stack[STACK_ENTRIES_A_TEXEL * i + 1u]));
        }
    }
}

// The state of a pixel that the last dispatch left unfinished. View and storage buffer are one memory, which a compiler may take for
// two, and so move a fetch behind a store. It cannot where every fetch is made before the loop that carries the path, and every
// store after it: so load all of a path before `run_path`, store all of it afterwards, and neither in between.
Path load_path(uint pixel) {
    uvec4 first = load_texel(0u, pixel);
    uvec4 o = load_texel(1u, pixel);
    uvec4 d = load_texel(2u, pixel);
    uvec4 wi = load_texel(3u, pixel);
    uvec4 pending = load_texel(4u, pixel);
    uvec4 throughput = load_texel(5u, pixel);
    uvec4 radiance = load_texel(6u, pixel);
    uvec4 search = load_texel(7u, pixel);
    uvec4 triangles = load_texel(8u, pixel);
    Path path;
    path.phase = first.x & PATH_PHASE_MASK;
    path.specular = (first.x & (1u << PATH_SPECULAR_SHIFT)) != 0u;
    path.extends = (first.x & (1u << PATH_EXTENDS_SHIFT)) != 0u;
    path.cause = (first.x >> PATH_CAUSE_SHIFT) & PATH_CAUSE_MASK;
    path.samples_done = (first.x >> PATH_SAMPLES_SHIFT) & PATH_SAMPLES_MASK;
    path.bounce = first.y;
    path.pdf = uintBitsToFloat(first.z);
    path.eta_scale = uintBitsToFloat(first.w);
    path.o = uintBitsToFloat(o.xyz);
    path.skip = o.w;
    path.d = uintBitsToFloat(d.xyz);
    path.skip_too = d.w;
    path.wi = uintBitsToFloat(wi.xyz);
    path.normal = wi.w;
    path.pending = uintBitsToFloat(pending.xyz);
    path.throughput = uintBitsToFloat(throughput.xyz);
    path.radiance = uintBitsToFloat(radiance.xyz);
    vec2 barycentrics = uintBitsToFloat(search.xy);
    Traversal traversal;
    traversal.best = Hit(uintBitsToFloat(pending.w), throughput.w, radiance.w, barycentrics.x, barycentrics.y);
    traversal.nodes = search.zw;
    traversal.triangles = triangles.xy;
    traversal.queued = triangles.zw;
    // Whatever the buffer holds, no index is past the array.
    traversal.stack_size = min((first.x >> PATH_STACK_SHIFT) & PATH_STACK_MASK, STACK_ENTRIES);
    traversal.searching = (first.x & (1u << PATH_SEARCHING_SHIFT)) != 0u;
    for (uint i = 0u; i < STACK_ENTRIES / STACK_ENTRIES_A_TEXEL; i++) {
        if (i * STACK_ENTRIES_A_TEXEL < traversal.stack_size) {
            uvec4 entries = load_texel(PATH_TEXELS + i, pixel);
            stack[STACK_ENTRIES_A_TEXEL * i] = entries.xy;
            stack[STACK_ENTRIES_A_TEXEL * i + 1u] = entries.zw;
        }
    }
    path.traversal = traversal;
    return path;
}

#endif
