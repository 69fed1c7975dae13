// Node records: texels -> struct. Layout: interface.rs, BINARY_NODE_TEXELS; texels/wide_node.rs for the wide node.
#ifndef RECORDS_NODE_GLSL
#define RECORDS_NODE_GLSL

#include "bindings.glsl"

struct BinaryNode {
    vec3 low, high; // Its box.
    uint first;     // Inner: first of two children side by side. Leaf: first triangle in leaf order.
    uint count;     // Triangles of a leaf, 0 for an inner node.
};

struct WideNode {
    vec3 origin;         // Lower corner of the children's grid.
    vec3 cell;           // Cell size of the grid, powers of two.
    uint inner_mask;     // Bit i: the child in slot i is an inner node.
    uint first_child;    // Inner children follow each other in slot order from here,
    uint first_triangle; // the triangles of its leaves from here.
    uvec2 meta;          // A byte a slot, see WideNode::meta in src/bvh/mod.rs.
    uvec2 low_x, low_y, low_z;    // Quantised lower planes, a byte a slot.
    uvec2 high_x, high_y, high_z; // Quantised upper planes.
};

BinaryNode fetch_binary_node(uint index) {
    uvec4 t0 = nodes_texel(index * BINARY_NODE_TEXELS);
    uvec4 t1 = nodes_texel(index * BINARY_NODE_TEXELS + 1u);
    return BinaryNode(uintBitsToFloat(t0.xyz), uintBitsToFloat(t1.xyz), t0.w, t1.w);
}

WideNode fetch_wide_node(uint index) {
    uint first = index * WIDE_NODE_TEXELS;
    uvec4 t0 = nodes_texel(first);
    uvec4 t1 = nodes_texel(first + 1u);
    uvec4 t2 = nodes_texel(first + 2u);
    uvec4 t3 = nodes_texel(first + 3u);
    uvec4 t4 = nodes_texel(first + 4u);
    WideNode node;
    node.origin = uintBitsToFloat(t0.xyz);
    // A biased exponent byte, moved to the exponent's place, is the power of two itself.
    node.cell = uintBitsToFloat((uvec3(t0.w, t0.w >> 8, t0.w >> 16) & 0xffu) << 23);
    node.inner_mask = t0.w >> 24;
    node.first_child = t1.x;
    node.first_triangle = t1.y;
    node.meta = t1.zw;
    node.low_x = t2.xy;
    node.low_y = t2.zw;
    node.low_z = t3.xy;
    node.high_x = t3.zw;
    node.high_y = t4.xy;
    node.high_z = t4.zw;
    return node;
}

#endif
