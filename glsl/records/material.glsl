// Material record: texels -> struct. Layout: interface.rs, MATERIAL_TEXELS.
#ifndef RECORDS_MATERIAL_GLSL
#define RECORDS_MATERIAL_GLSL

#include "bindings.glsl"

struct Material {
    vec3 reflectance; // Albedo (Lambert) or mirror reflectance, each within [0, 1].
    uint kind;        // MATERIAL_ value.
    vec3 emission;    // Radiance emitted from the front, scaled.
    float ior;        // Index of refraction relative to air (glass).
};

Material fetch_material(uint index) {
    uvec4 t0 = materials_texel(index * MATERIAL_TEXELS);
    vec4 t1 = uintBitsToFloat(materials_texel(index * MATERIAL_TEXELS + 1u));
    return Material(uintBitsToFloat(t0.xyz), t0.w & MATERIAL_KIND_MASK, t1.xyz, t1.w);
}

#endif
