// Probe for self-tests: floats as this device and the renderer's own functions have them.
//
// push.flags is the function; one texel of arguments a call, two texels of answers:
//   0  [a, b, 0, 0]             -> [min(a, b), max(a, b), clamp(a, 0, 1), 0], [lesser(a, b), greater(a, b), 0, 0]
//   1  [a, b, 0, 0]             -> [a b, fma(a, b, -a b), Dekker's error of a b, 0], 0
//   2  [place, 0, 0, 0]         -> [filter_entry(place), 0, 0, 0], [bits of filter_offset(place), 0, 0, 0]
//   3  [first, count, 0, 0]     -> [largest unit_float, how many reach 1, wrong ones, 0] of words (first + i) << 8 | 255, 0
//   4  [pixel, first, count, 0] -> [sums of the upper 16 bits of random_pair's words, 0, 0] of samples first + i, 0
#version 460
#extension GL_GOOGLE_include_directive : require

// What a comparison does with NaN depends on the mode: it is that of the renders that the probe speaks for.
#include "keep_nan.glsl"
#include "bindings.glsl"
#include "camera.glsl"
#include "probes/product_error.glsl"
#include "sampling/random.glsl"
#include "trace/ray.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

uvec3 unit_floats(uint first, uint count) {
    uvec3 result = uvec3(0u);
    for (uint i = 0u; i < count; i++) {
        uint word = (first + i) << 8 | 255u;
        float value = unit_float(word);
        result.x = max(result.x, floatBitsToUint(value));
        result.y += value >= 1.0 ? 1u : 0u;
        result.z += value == float(word >> 8) / 16777216.0 ? 0u : 1u;
    }
    return result;
}

uvec2 random_sums(uint pixel, uint first, uint count) {
    uvec2 sums = uvec2(0u);
    for (uint i = 0u; i < count; i++) {
        sums += random_pair(make_stream(pixel), first + i, 0u) >> 16;
    }
    return sums;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    uvec4 words = probe_input[index];
    float a = uintBitsToFloat(words.x);
    float b = uintBitsToFloat(words.y);
    uvec4 first = uvec4(0u);
    uvec4 second = uvec4(0u);
    if (push.flags == 0u) {
        first.xyz = floatBitsToUint(vec3(min(a, b), max(a, b), clamp(a, 0.0, 1.0)));
        second.xy = floatBitsToUint(vec2(lesser(a, b), greater(a, b)));
    } else if (push.flags == 1u) {
        precise float p = a * b;
        first.xyz = floatBitsToUint(vec3(p, fma(a, b, -p), product_error(a, b, p)));
    } else if (push.flags == 2u) {
        first.x = filter_entry(a);
        second.x = floatBitsToUint(filter_offset(a));
    } else if (push.flags == 3u) {
        first.xyz = unit_floats(words.x, words.y);
    } else if (push.flags == 4u) {
        first.xy = random_sums(words.x, words.y, words.z);
    }
    probe_output[2u * index] = first;
    probe_output[2u * index + 1u] = second;
}
