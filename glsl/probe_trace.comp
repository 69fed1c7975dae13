// Probe for tests: the hits of given rays, by the renderer's own traversal.
//
// In: two texels a ray, [o.xyz, skip], [d.xyz, limit]; limit 0 asks for the closest hit, anything else for any hit before it.
// push.samples rays. FUSED_EDGES builds the mutant of a driver that fuses. Out: two texels a ray, [key, id, triangle, stack
// overflows] and [b1, b2, nodes, triangles tested].
#version 460
#extension GL_GOOGLE_include_directive : require

#include "bindings.glsl"
#if FUSED_EDGES
#include "mutants/fused_edge.glsl"
#endif
#include "probes/walk.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    uvec4 t0 = probe_input[2u * index];
    uvec4 t1 = probe_input[2u * index + 1u];
    Ray ray = make_ray(uintBitsToFloat(t0.xyz), uintBitsToFloat(t1.xyz));
    float limit = uintBitsToFloat(t1.w);
    bool shadow = limit > 0.0;
    Hit start = no_hit();
    if (shadow) {
        start = no_hit_below(limit);
    }
    uint nodes, triangles;
    Hit hit = walk(ray, start, t0.w, NO_INDEX, shadow, nodes, triangles).best;
    probe_output[2u * index] = uvec4(floatBitsToUint(hit.key), hit.id, hit.triangle, stack_overflows);
    probe_output[2u * index + 1u] = uvec4(floatBitsToUint(hit.b1), floatBitsToUint(hit.b2), nodes, triangles);
}
