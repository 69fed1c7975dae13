// Light record: texels -> struct. Layout: interface.rs, LIGHT_TEXELS.
#ifndef RECORDS_LIGHT_GLSL
#define RECORDS_LIGHT_GLSL

#include "bindings.glsl"

struct Light {
    uint cdf_end;   // Inclusive upper end of its share of the 32-bit random numbers.
    uint triangle;  // Its triangle, in leaf order.
    float pdf_area; // Probability of the light times density per unit area of a point on it.
};

Light fetch_light(uint index) {
    uvec4 t = lights_texel(index * LIGHT_TEXELS);
    return Light(t.x, t.y, uintBitsToFloat(t.z));
}

#endif
