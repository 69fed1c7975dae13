// Light record: texels -> struct. Layout: interface.rs, LIGHT_TEXELS.
#ifndef RECORDS_LIGHT_GLSL
#define RECORDS_LIGHT_GLSL

#include "bindings.glsl"

struct Light {
    vec3 v0, v1, v2; // Corner positions of its triangle.
    uint cdf_begin;  // First of the 32-bit random numbers that choose it,
    uint cdf_end;    // the last one,
    float cdf_scale; // and one over how many there are.
    uint triangle;   // Its triangle, in leaf order.
    float pdf_area;  // Probability of the light times density per unit area of a point on it; the latter alone with a light tree.
    vec3 ng;         // Unit geometric normal; it emits on this side.
    vec3 emission;   // Radiance, scaled.
};

Light fetch_light(uint index) {
    uvec4 t0 = lights_texel(index * LIGHT_TEXELS);
    uvec4 t1 = lights_texel(index * LIGHT_TEXELS + 1u);
    uvec4 t2 = lights_texel(index * LIGHT_TEXELS + 2u);
    uvec4 t3 = lights_texel(index * LIGHT_TEXELS + 3u);
    vec4 t4 = uintBitsToFloat(lights_texel(index * LIGHT_TEXELS + 4u));
    return Light(uintBitsToFloat(t0.xyz), uintBitsToFloat(t1.xyz), uintBitsToFloat(t2.xyz), t3.w, t0.w,
                 t4.w, t1.w, uintBitsToFloat(t2.w), uintBitsToFloat(t3.xyz), t4.rgb);
}

// `cdf_end` of a light alone, for the search.
uint fetch_light_cdf_end(uint index) {
    return lights_texel(index * LIGHT_TEXELS).w;
}

#endif
