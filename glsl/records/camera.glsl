// Camera record and the pixel filter's table: texels -> values. Layout: interface.rs, CAMERA_TEXELS, FILTER_ENTRIES.
#ifndef RECORDS_CAMERA_GLSL
#define RECORDS_CAMERA_GLSL

#include "bindings.glsl"

struct Camera {
    vec3 origin;
    vec3 forward;     // Unit vector through the picture's centre.
    vec3 right, down; // Change of direction a pixel.
    vec2 size;        // Picture size in pixels.
    uint filter_kind; // FILTER_ value.
};

Camera fetch_camera() {
    uvec4 t0 = camera_texel(0u);
    vec4 t1 = uintBitsToFloat(camera_texel(1u));
    vec4 t2 = uintBitsToFloat(camera_texel(2u));
    vec4 t3 = uintBitsToFloat(camera_texel(3u));
    return Camera(uintBitsToFloat(t0.xyz), t1.xyz, t2.xyz, t3.xyz, vec2(t1.w, t2.w), t0.w);
}

// Entry `index` of the filter's inverse distribution: an offset in pixels.
float fetch_filter(uint index) {
    return uintBitsToFloat(filter_texel(index >> 2)[index & 3u]);
}

#endif
