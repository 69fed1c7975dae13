// Material record: texels -> struct. Layout: interface.rs, MATERIAL_TEXELS.
#ifndef RECORDS_MATERIAL_GLSL
#define RECORDS_MATERIAL_GLSL

#include "bindings.glsl"

struct Material {
    uint kind;        // MATERIAL_ value.
    float ior;        // Index of refraction relative to air (glass).
    vec3 reflectance; // Albedo (Lambert) or mirror reflectance, each within [0, 1].
    vec3 emission;    // Radiance emitted from the front, scaled.
};

Material fetch_material(uint index) {
    uvec4 t0 = materials_texel(index * MATERIAL_TEXELS);
    vec4 t1 = uintBitsToFloat(materials_texel(index * MATERIAL_TEXELS + 1u));
    vec4 t2 = uintBitsToFloat(materials_texel(index * MATERIAL_TEXELS + 2u));
    return Material(t0.x, uintBitsToFloat(t0.y), t1.rgb, t2.rgb);
}

#endif
