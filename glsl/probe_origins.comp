// Probe for tests: where rays that leave a surface start, and what they meet, by the renderer's own functions.
//
// In: three texels a ray, push.samples rays: [triangle in leaf order, b1, b2, 0], [wo.xyz, light's triangle in leaf order],
// [d.xyz, 0]. push.flags 0: d is the direction of an extension ray; 1: d is a point on the light, and the ray is a shadow
// ray; 2: as 0, but the ray starts at the bare point. Out: two texels a ray, [origin.xyz, triangle hit in leaf order] and [p.xyz, key].
#version 460
#extension GL_GOOGLE_include_directive : require

#include "bindings.glsl"
#include "path.glsl"
#include "probes/walk.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    uvec4 t0 = probe_input[3u * index];
    uvec4 t1 = probe_input[3u * index + 1u];
    vec3 target = uintBitsToFloat(probe_input[3u * index + 2u].xyz);
    Hit hit = Hit(1.0, 0u, t0.x, uintBitsToFloat(t0.y), uintBitsToFloat(t0.z));
    Interaction it = make_interaction(hit, uintBitsToFloat(t1.xyz));
    bool shadow = push.flags == 1u;
    precise vec3 towards = shadow ? target - it.p : target;
    vec3 o = spawn_origin(it, dot(towards, it.ng) >= 0.0 ? it.ng : -it.ng);
    o = push.flags == 2u ? it.inner : o;
    precise vec3 d = shadow ? target - o : target;
    Hit start = no_hit();
    if (shadow) {
        vec3 ng = fetch_surface(t1.w).ng;
        precise float height = -(d.x * ng.x + d.y * ng.y + d.z * ng.z);
        start = no_hit_below(shadow_limit(height));
    }
    uint nodes, triangles;
    Hit found = walk(make_ray(o, d), start, t0.x, shadow ? t1.w : NO_INDEX, shadow, nodes, triangles).best;
    probe_output[2u * index] = uvec4(floatBitsToUint(o), found.triangle);
    probe_output[2u * index + 1u] = uvec4(floatBitsToUint(it.p), floatBitsToUint(found.key));
}
