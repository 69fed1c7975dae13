// Triangle record: texels -> struct. Layout: interface.rs, TRIANGLE_TEXELS.
#ifndef RECORDS_TRIANGLE_GLSL
#define RECORDS_TRIANGLE_GLSL

#include "bindings.glsl"

struct Triangle {
    vec3 v0, v1, v2; // Corner positions, in scaled units.
    uint id;         // Position in file order: decides between equal distances.
    uint flags;      // TRIANGLE_ bits.
    float pdf_area;  // Density per unit area of light sampling on it; 0 where it does not emit.
};

// The triangle at `index` in leaf order.
Triangle fetch_triangle(uint index) {
    uvec4 t0 = triangles_texel(index * TRIANGLE_TEXELS);
    uvec4 t1 = triangles_texel(index * TRIANGLE_TEXELS + 1u);
    uvec4 t2 = triangles_texel(index * TRIANGLE_TEXELS + 2u);
    return Triangle(uintBitsToFloat(t0.xyz), uintBitsToFloat(t1.xyz), uintBitsToFloat(t2.xyz), t0.w, t1.w,
                    uintBitsToFloat(t2.w));
}

#endif
