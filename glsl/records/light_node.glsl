// Clusters of a light-tree node: texels -> struct. Layout: interface.rs, LIGHT_NODE_TEXELS.
#ifndef RECORDS_LIGHT_NODE_GLSL
#define RECORDS_LIGHT_NODE_GLSL

#include "bindings.glsl"
#include "sampling/octahedral.glsl"

struct LightCluster {
    vec3 centre;  // Of a ball around its lights, scaled units,
    float radius; // and the ball's radius.
    vec3 axis;    // Of a cone around their normals,
    float cos_o;  // and the cosine of half its angle.
    float power;  // Emitted power, in shares of all lights'.
    uint child;   // The light where there is one, otherwise the node below.
    uint count;   // Lights; 0 for no cluster.
};

// Cluster `slot` of the node `node`.
LightCluster fetch_light_cluster(uint node, uint slot) {
    uvec4 t0 = light_nodes_texel(node * LIGHT_NODE_TEXELS + 2u * slot);
    uvec4 t1 = light_nodes_texel(node * LIGHT_NODE_TEXELS + 2u * slot + 1u);
    precise float cos_o = float(t0.w & 0xffffu) * 3.0518043793392844e-5 - 1.0;
    return LightCluster(uintBitsToFloat(t0.xyz), uintBitsToFloat(t0.w & 0xffff0000u), decode_octahedral(t1.x), cos_o,
                        uintBitsToFloat(t1.y), t1.z, t1.w);
}

#endif
