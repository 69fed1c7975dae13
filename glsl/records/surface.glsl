// Surface and corner records: what shading needs of a triangle beyond its positions. Layout: interface.rs,
// SURFACE_TEXELS and CORNERS_TEXELS.
#ifndef RECORDS_SURFACE_GLSL
#define RECORDS_SURFACE_GLSL

#include "bindings.glsl"

struct Surface {
    vec3 ng;       // Unit geometric normal, on the front.
    uint material; // Index of the material.
};

struct Corners {
    vec3 n0, n1, n2;    // Unit vertex normals.
    vec2 uv0, uv1, uv2; // Texture coordinates.
};

// The surface of the triangle at `index` in leaf order.
Surface fetch_surface(uint index) {
    uvec4 t = surfaces_texel(index * SURFACE_TEXELS);
    return Surface(uintBitsToFloat(t.xyz), t.w);
}

// The corners of the triangle at `index` in leaf order; only where it has the flag TRIANGLE_SMOOTH.
Corners fetch_corners(uint index) {
    vec4 t0 = uintBitsToFloat(corners_texel(index * CORNERS_TEXELS));
    vec4 t1 = uintBitsToFloat(corners_texel(index * CORNERS_TEXELS + 1u));
    vec4 t2 = uintBitsToFloat(corners_texel(index * CORNERS_TEXELS + 2u));
    vec4 t3 = uintBitsToFloat(corners_texel(index * CORNERS_TEXELS + 3u));
    return Corners(t0.xyz, t1.xyz, t2.xyz, vec2(t0.w, t3.x), vec2(t1.w, t3.y), vec2(t2.w, t3.z));
}

#endif
