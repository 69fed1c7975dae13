// Ray-box tests: a node's children against a ray. CPU twin: src/bvh/intersect.rs.
//
// Boxes grow by NODE_PAD of the ray's reach on every side, which moves each plane's t by ray.node_pad. A box is visited where the ray is
// inside it for some t >= 0 that is not beyond `cull`; its entry is never later than that of any triangle inside.
#ifndef TRACE_BOX_GLSL
#define TRACE_BOX_GLSL

#include "records/node.glsl"
#include "trace/ray.glsl"

// Whether the ray enters the box before `cull`, and where.
bool enters_box(Ray ray, vec3 low, vec3 high, float cull, out float entry) {
    bvec3 forward = greaterThanEqual(ray.inv, vec3(0.0));
    precise vec3 near = (mix(high, low, forward) - ray.o) * ray.inv - ray.node_pad;
    precise vec3 far = (mix(low, high, forward) - ray.o) * ray.inv + ray.node_pad;
    entry = greater(greater(near.x, near.y), near.z);
    float leave = lesser(lesser(far.x, far.y), lesser(far.z, cull));
    return entry <= leave && leave >= 0.0;
}

vec4 bytes(uint word) {
    return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 0xffu);
}

// Bits of four children that the ray enters before `cull`, as contributed by their meta bytes: an inner child sets bit
// 24 + (slot ^ octant), so that the highest bit is the nearest octant; a leaf sets one bit a triangle, from its offset on.
// `octants` is the octant in every byte. The meta bytes are worked on four at a time (Ylitie et al. 2017, section 4).
uint enter_four(vec3 step, vec3 near_base, vec3 far_base, uvec3 near_words, uvec3 far_words, uint meta, uint octants,
                float cull) {
    precise vec4 near_x = bytes(near_words.x) * step.x + near_base.x;
    precise vec4 near_y = bytes(near_words.y) * step.y + near_base.y;
    precise vec4 near_z = bytes(near_words.z) * step.z + near_base.z;
    precise vec4 far_x = bytes(far_words.x) * step.x + far_base.x;
    precise vec4 far_y = bytes(far_words.y) * step.y + far_base.y;
    precise vec4 far_z = bytes(far_words.z) * step.z + far_base.z;
    // From 0 on: a box behind the origin is left before it is entered.
    vec4 entry = greater(greater(near_x, near_y), greater(near_z, vec4(0.0)));
    vec4 leave = lesser(lesser(far_x, far_y), lesser(far_z, vec4(cull)));
    // Both bits of 0b11000 are set in an inner child's meta alone (a leaf's offset ends at 23): 0b111 in those bytes.
    uint inner = (((meta >> 4) & (meta >> 3)) & 0x01010101u) * 7u;
    uint places = (meta ^ (octants & inner)) & 0x1f1f1f1fu;
    uint counts = (meta >> 5) & 0x07070707u;
    uvec4 place = uvec4(places, places >> 8, places >> 16, places >> 24);
    uvec4 bits = uvec4(counts & 0xffu, (counts >> 8) & 0xffu, (counts >> 16) & 0xffu, counts >> 24) << (place & 31u);
    uint taken = entry.x <= leave.x ? bits.x : 0u;
    taken |= entry.y <= leave.y ? bits.y : 0u;
    taken |= entry.z <= leave.z ? bits.z : 0u;
    taken |= entry.w <= leave.w ? bits.w : 0u;
    return taken;
}

// The children of `node` that the ray enters before `cull`: inner children in bits 24 to 31, triangles in bits 0 to 23.
// `octant` has bit 2, 1, 0 set where x, y, z of the direction is not negative.
uint enter_children(Ray ray, WideNode node, uint octant, float cull) {
    precise vec3 step = node.cell * ray.inv;
    precise vec3 base = (node.origin - ray.o) * ray.inv;
    precise vec3 near_base = base - ray.node_pad;
    precise vec3 far_base = base + ray.node_pad;
    bool x = (octant & 4u) != 0u;
    bool y = (octant & 2u) != 0u;
    bool z = (octant & 1u) != 0u;
    uvec2 near_x = x ? node.low_x : node.high_x;
    uvec2 near_y = y ? node.low_y : node.high_y;
    uvec2 near_z = z ? node.low_z : node.high_z;
    uvec2 far_x = x ? node.high_x : node.low_x;
    uvec2 far_y = y ? node.high_y : node.low_y;
    uvec2 far_z = z ? node.high_z : node.low_z;
    uint octants = octant * 0x01010101u;
    return enter_four(step, near_base, far_base, uvec3(near_x.x, near_y.x, near_z.x), uvec3(far_x.x, far_y.x, far_z.x),
                      node.meta.x, octants, cull) |
           enter_four(step, near_base, far_base, uvec3(near_x.y, near_y.y, near_z.y), uvec3(far_x.y, far_y.y, far_z.y),
                      node.meta.y, octants, cull);
}

#endif
