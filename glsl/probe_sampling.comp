// Probe for tests: random numbers, warps, Fresnel terms, by the renderer's own functions.
//
// In: push.flags the function (below), push.samples how many calls, one texel of arguments a call. Out: one texel a call.
//   0  random_pair: [x | y << 16, sample, pair, 0] -> two 32-bit words
//   1  unit_float of four words                   -> four floats
//   2  cosine_hemisphere: [u, v, 0, 0]            -> [direction, 0]
//   3  uniform_hemisphere: [u, v, 0, 0]           -> [direction, 0]
//   4  square_to_triangle: [u, v, 0, 0]           -> [b1, b2, 0, 0]
//   5  filter_offset: [u, 0, 0, 0]                -> [offset, 0, 0, 0]
//   6  fresnel_dielectric: [cos_i, eta, 0, 0]     -> [reflectance, cos_t, 0, 0]
//   7  make_basis: [n, 0]                         -> [n . (s x t), |s|^2 - 1, |t|^2 - 1, largest |dot| of two of s, t, n]
//   8  power_heuristic: [a, b, 0, 0]              -> [weight of a, weight of b, 0, 0]
//   9  pick_light: [word, 0, 0, 0]                -> [light, 0, 0, 0]
//  10  pick_light of four words                   -> four lights
//  11  place_in_share: [word, first, scale, 0]    -> [place, 0, 0, 0]; a light's first word, and one over how many it has
#version 460
#extension GL_GOOGLE_include_directive : require

#include "bindings.glsl"
#include "camera.glsl"
#include "path.glsl"
#include "sampling/random.glsl"
#include "sampling/warp.glsl"
#include "shading/fresnel.glsl"
#include "shading/light.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

vec4 basis_errors(vec3 n) {
    vec3 s, t;
    make_basis(n, s, t);
    float crossed = max(max(abs(dot(s, t)), abs(dot(s, n))), abs(dot(t, n)));
    return vec4(dot(cross(s, t), n), dot(s, s) - 1.0, dot(t, t) - 1.0, crossed);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    uvec4 words = probe_input[index];
    vec4 args = uintBitsToFloat(words);
    vec4 result = vec4(0.0);
    if (push.flags == 0u) {
        probe_output[index] = uvec4(random_pair(make_stream(words.x), words.y, words.z), 0u, 0u);
        return;
    } else if (push.flags == 1u) {
        result = vec4(unit_float(words.x), unit_float(words.y), unit_float(words.z), unit_float(words.w));
    } else if (push.flags == 2u) {
        result.xyz = cosine_hemisphere(args.xy);
    } else if (push.flags == 3u) {
        result.xyz = uniform_hemisphere(args.xy);
    } else if (push.flags == 4u) {
        result.xy = square_to_triangle(args.xy);
    } else if (push.flags == 5u) {
        result.x = filter_offset(args.x);
    } else if (push.flags == 6u) {
        float cos_t;
        result.x = fresnel_dielectric(args.x, args.y, cos_t);
        result.y = cos_t;
    } else if (push.flags == 7u) {
        result = basis_errors(args.xyz);
    } else if (push.flags == 8u) {
        result.xy = vec2(power_heuristic(args.x, args.y), power_heuristic(args.y, args.x));
    } else if (push.flags == 9u) {
        uint steps = 0u;
        probe_output[index] = uvec4(pick_light(words.x, steps), steps, 0u, 0u);
        return;
    } else if (push.flags == 10u) {
        uint steps = 0u;
        probe_output[index] = uvec4(pick_light(words.x, steps), pick_light(words.y, steps), pick_light(words.z, steps),
                                    pick_light(words.w, steps));
        return;
    } else if (push.flags == 11u) {
        result.x = place_in_share(words.y, args.z, words.x);
    }
    probe_output[index] = floatBitsToUint(result);
}
