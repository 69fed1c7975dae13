// Probe for tests: what each record's fetch function makes of the texels that the host packed.
//
// In: push.flags the record's binding number, or RECORD_BINDINGS for the render's constants, push.samples how many
// records. Out: eight texels a record, the fields in the order of the GLSL struct, floats as bits, unused lanes zero.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "bindings.glsl"
#include "constants.glsl"
#include "effects.glsl"
#include "records/camera.glsl"
#include "records/light.glsl"
#include "records/light_node.glsl"
#include "records/material.glsl"
#include "records/node.glsl"
#include "records/surface.glsl"
#include "records/triangle.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

uvec3 bits(vec3 v) {
    return floatBitsToUint(v);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    uvec4 fields[8];
    for (int i = 0; i < 8; i++) {
        fields[i] = uvec4(0u);
    }
    if (push.flags == BINDING_NODES && ACCEL == ACCEL_BINARY) {
        BinaryNode node = fetch_binary_node(index);
        fields[0] = uvec4(bits(node.low), node.first);
        fields[1] = uvec4(bits(node.high), node.count);
    } else if (push.flags == BINDING_NODES) {
        WideNode node = fetch_wide_node(index);
        fields[0] = uvec4(bits(node.origin), node.inner_mask);
        fields[1] = uvec4(bits(node.cell), 0u);
        fields[2] = uvec4(node.first_child, node.first_triangle, node.meta);
        fields[3] = uvec4(node.low_x, node.low_y);
        fields[4] = uvec4(node.low_z, node.high_x);
        fields[5] = uvec4(node.high_y, node.high_z);
    } else if (push.flags == BINDING_TRIANGLES) {
        Triangle triangle = fetch_triangle(index);
        fields[0] = uvec4(bits(triangle.v0), triangle.id);
        fields[1] = uvec4(bits(triangle.v1), triangle.flags);
        fields[2] = uvec4(bits(triangle.v2), floatBitsToUint(triangle.pdf_area));
    } else if (push.flags == BINDING_SURFACES) {
        Surface surface = fetch_surface(index);
        fields[0] = uvec4(bits(surface.ng), surface.material);
    } else if (push.flags == BINDING_CORNERS) {
        Corners corners = fetch_corners(index);
        fields[0] = uvec4(bits(corners.n0), 0u);
        fields[1] = uvec4(bits(corners.n1), 0u);
        fields[2] = uvec4(bits(corners.n2), 0u);
        fields[3] = uvec4(floatBitsToUint(corners.uv0), floatBitsToUint(corners.uv1));
        fields[4] = uvec4(floatBitsToUint(corners.uv2), 0u, 0u);
    } else if (push.flags == BINDING_MATERIALS) {
        Material material = fetch_material(index);
        fields[0] = uvec4(bits(material.reflectance), material.kind);
        fields[1] = uvec4(bits(material.emission), floatBitsToUint(material.ior));
    } else if (push.flags == BINDING_LIGHTS) {
        Light light = fetch_light(index);
        fields[0] = uvec4(bits(light.v0), light.cdf_end);
        fields[1] = uvec4(bits(light.v1), light.triangle);
        fields[2] = uvec4(bits(light.v2), floatBitsToUint(light.pdf_area));
        fields[3] = uvec4(bits(light.ng), light.cdf_begin);
        fields[4] = uvec4(bits(light.emission), floatBitsToUint(light.cdf_scale));
        fields[5] = uvec4(fetch_light_cdf_end(index), 0u, 0u, 0u);
    } else if (push.flags == BINDING_LIGHT_NODES) {
        // A record is a cluster here, of which a node has four.
        LightCluster cluster = fetch_light_cluster(index >> 2, index & 3u);
        fields[0] = uvec4(bits(cluster.centre), floatBitsToUint(cluster.radius));
        fields[1] = uvec4(bits(cluster.axis), floatBitsToUint(cluster.cos_o));
        fields[2] = uvec4(floatBitsToUint(cluster.power), cluster.child, cluster.count, 0u);
    } else if (push.flags == BINDING_CAMERA) {
        Camera camera = fetch_camera();
        fields[0] = uvec4(bits(camera.origin), camera.filter_kind);
        fields[1] = uvec4(bits(camera.forward), floatBitsToUint(camera.size.x));
        fields[2] = uvec4(bits(camera.right), floatBitsToUint(camera.size.y));
        fields[3] = uvec4(bits(camera.down), 0u);
    } else if (push.flags == RECORD_BINDINGS) {
        // No record kind: the render's constants, in the order of their list.
        RenderConstants found = fetch_constants();
        fields[0] = floatBitsToUint(vec4(found.sky_r, found.sky_g, found.sky_b, found.roulette_p));
        fields[1] = uvec4(found.triangle_count, found.light_count, found.max_bounces, found.seed_low);
        fields[2] = uvec4(found.seed_high, 0u, 0u, 0u);
    } else if (push.flags == BINDING_FILTER) {
        fields[0] = uvec4(floatBitsToUint(fetch_filter(index)), 0u, 0u, 0u);
    }
    for (uint i = 0u; i < 8u; i++) {
        probe_output[8u * index + i] = fields[i];
    }
}
