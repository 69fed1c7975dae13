// Camera: pixel -> ray.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

#include "effects.glsl"
#include "records/camera.glsl"

// Entry of the filter's table below `place`. Held in range as an integer: what a float beyond 2^32, or a NaN, becomes is
// undefined, and a clamp before the conversion would let a NaN through.
uint filter_entry(float place) {
    return guarded(GUARD_INTEGER_CLAMP) ? min(uint(place), FILTER_ENTRIES - 2u) : uint(place);
}

// Offset from the pixel's centre at probability `u`, by linear interpolation of the filter's inverse distribution.
float filter_offset(float u) {
    float place = u * float(FILTER_ENTRIES - 1u);
    uint entry = filter_entry(place);
    float low = fetch_filter(entry);
    float high = fetch_filter(entry + 1u);
    precise float offset = low + (high - low) * (place - float(entry));
    return offset;
}

// Direction, of any length, of a ray through `pixel` of the picture at the place `u` of the unit square in its filter.
vec3 camera_direction(Camera camera, uvec2 pixel, vec2 u) {
    vec2 offset = u - 0.5;
    if (HAS_PIXEL_FILTER != 0u && camera.filter_kind == FILTER_TABLE) {
        offset = vec2(filter_offset(u.x), filter_offset(u.y));
    }
    precise vec2 film = (vec2(pixel) + 0.5 - 0.5 * camera.size) + offset;
    precise vec3 direction = camera.forward + film.x * camera.right + film.y * camera.down;
    return direction;
}

#endif
