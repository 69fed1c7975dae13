// Ray-box tests: a node's children against a ray. CPU twin: src/bvh/intersect.rs.
//
// Boxes grow by NODE_PAD of the ray's reach, for nothing: the pad goes into the origin. A box is visited where the ray is
// inside it for some t >= 0 that is not beyond `cull`; its entry is never later than that of any triangle inside.
#ifndef TRACE_BOX_GLSL
#define TRACE_BOX_GLSL

#include "records/node.glsl"
#include "trace/ray.glsl"

// Whether the ray enters the box before `cull`, and where.
bool enters_box(Ray ray, vec3 low, vec3 high, float cull, out float entry) {
    precise float pad = ray.reach * NODE_PAD;
    precise vec3 t_low = (low - (ray.o + pad)) * ray.inv;
    precise vec3 t_high = (high - (ray.o - pad)) * ray.inv;
    bvec3 forward = greaterThanEqual(ray.inv, vec3(0.0));
    vec3 near = mix(t_high, t_low, forward);
    vec3 far = mix(t_low, t_high, forward);
    entry = max(max(near.x, near.y), near.z);
    float leave = min(min(far.x, far.y), far.z);
    return entry <= leave && leave >= 0.0 && entry <= cull;
}

vec4 bytes(uint word) {
    return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 0xffu);
}

// Bits of four children that the ray enters before `cull`, as contributed by their meta bytes: an inner child sets bit
// 24 + (slot ^ octant), so that the highest bit is the nearest octant; a leaf sets one bit a triangle, from its offset on.
uint enter_four(vec3 step, vec3 near_base, vec3 far_base, vec4 near_x, vec4 near_y, vec4 near_z, vec4 far_x, vec4 far_y,
                vec4 far_z, uint meta_word, uint octant, float cull) {
    precise vec4 nx = near_x * step.x + near_base.x;
    precise vec4 ny = near_y * step.y + near_base.y;
    precise vec4 nz = near_z * step.z + near_base.z;
    precise vec4 fx = far_x * step.x + far_base.x;
    precise vec4 fy = far_y * step.y + far_base.y;
    precise vec4 fz = far_z * step.z + far_base.z;
    vec4 entry = max(max(nx, ny), nz);
    vec4 leave = min(min(fx, fy), min(fz, vec4(cull)));
    uvec4 meta = uvec4(meta_word, meta_word >> 8, meta_word >> 16, meta_word >> 24) & 0xffu;
    // Both bits of 0b11000 are set in an inner child's meta alone: a leaf's offset ends at 23.
    uvec4 inner = (meta >> 4) & (meta >> 3) & 1u;
    uvec4 bit = (meta ^ (inner * octant)) & 31u;
    uvec4 bits = (meta >> 5) << bit;
    bvec4 entered = bvec4(uvec4(lessThanEqual(entry, leave)) & uvec4(greaterThanEqual(leave, vec4(0.0))));
    uvec4 taken = mix(uvec4(0u), bits, entered);
    return taken.x | taken.y | taken.z | taken.w;
}

// The children of `node` that the ray enters before `cull`: inner children in bits 24 to 31, triangles in bits 0 to 23.
// `octant` has bit 2, 1, 0 set where x, y, z of the direction is not negative.
uint enter_children(Ray ray, WideNode node, uint octant, float cull) {
    precise float pad = ray.reach * NODE_PAD;
    precise vec3 step = node.cell * ray.inv;
    precise vec3 low_base = (node.origin - (ray.o + pad)) * ray.inv;
    precise vec3 high_base = (node.origin - (ray.o - pad)) * ray.inv;
    bvec3 forward = greaterThanEqual(ray.inv, vec3(0.0));
    vec3 near_base = mix(high_base, low_base, forward);
    vec3 far_base = mix(low_base, high_base, forward);
    uvec2 near_x = forward.x ? node.low_x : node.high_x;
    uvec2 near_y = forward.y ? node.low_y : node.high_y;
    uvec2 near_z = forward.z ? node.low_z : node.high_z;
    uvec2 far_x = forward.x ? node.high_x : node.low_x;
    uvec2 far_y = forward.y ? node.high_y : node.low_y;
    uvec2 far_z = forward.z ? node.high_z : node.low_z;
    return enter_four(step, near_base, far_base, bytes(near_x.x), bytes(near_y.x), bytes(near_z.x), bytes(far_x.x),
                      bytes(far_y.x), bytes(far_z.x), node.meta.x, octant, cull) |
           enter_four(step, near_base, far_base, bytes(near_x.y), bytes(near_y.y), bytes(near_z.y), bytes(far_x.y),
                      bytes(far_y.y), bytes(far_z.y), node.meta.y, octant, cull);
}

#endif
