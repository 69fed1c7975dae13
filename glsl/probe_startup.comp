// Start-up probe: what pictures rest on and drivers have got wrong. The host judges the answers (src/render/startup.rs).
//
// In: two texels an invocation, [a, b, c, angle] and [exponent, ...]. Out: three texels an invocation:
//   [NaN flags, loop state, a * b + c, denormal]
//   [sin(angle), cos(angle), a / b, sqrt(a)]
//   [inversesqrt(a), a + b, a * b, smallest normal / 2]
#version 460
#extension GL_GOOGLE_include_directive : require

// The probe runs in the mode of the renders that it speaks for.
#include "keep_nan.glsl"
#include "bindings.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

// The test of end_sample (path.glsl).
uint is_nan(float value) {
    return (floatBitsToUint(value) & 0x7fffffffu) > 0x7f800000u ? 1u : 0u;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    uvec4 t0 = probe_input[2u * index];
    uvec4 t1 = probe_input[2u * index + 1u];
    vec4 args = uintBitsToFloat(t0);
    vec4 special = uintBitsToFloat(t1); // 0, infinity, -1, the smallest normal number
    precise float product = special.x * special.y;
    precise float difference = special.y - special.y;
    precise float quotient = special.x / special.x;
    precise float ratio = special.y / special.y;
    precise float root = sqrt(special.z);
    uint flags = is_nan(product) | is_nan(difference) << 1 | is_nan(quotient) << 2 | is_nan(ratio) << 3 | is_nan(root) << 4;

    // Data carried from one iteration to the next: a counter, or a flag set at the end, would be folded to what it should
    // be.
    uint state = 1u;
    for (uint i = 0u; i < push.budget; i++) {
        state = state * 1664525u + 1013904223u;
    }

    precise float twice_rounded = args.x * args.y + args.z;
    precise float sum = args.x + args.y;
    precise float scaled = args.x * args.y;
    precise float half_of_least = special.w * 0.5;
    precise float denormal = half_of_least * 16777216.0;
    probe_output[3u * index] = uvec4(flags, state, floatBitsToUint(twice_rounded), floatBitsToUint(denormal));
    probe_output[3u * index + 1u] = floatBitsToUint(vec4(sin(args.w), cos(args.w), args.x / args.y, sqrt(args.x)));
    probe_output[3u * index + 2u] =
        uvec4(floatBitsToUint(vec3(inversesqrt(args.x), sum, scaled)), floatBitsToUint(half_of_least));
}
