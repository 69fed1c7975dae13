// Probe for self-tests: sums of many samples, by the renderer's own functions.
//
// push.flags is the function:
//   0  a compensated sum (Kahan 1965) of a stream, SUM_STEPS numbers further a dispatch: one texel a call is both in and
//      out, [sum, compensation, numbers taken, 0]; the call's number is the stream's.
//   1  a block of 16 samples as a render sums it (add_sample): the call's number is the block's; its samples' three channels
//      are the streams. Out: the block's open sum.
// Streams: 0 the constant 0.1; 1 uniform in [0, 1); 2 a rare bright path, 10,000 once in 10,000 on average.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "bindings.glsl"
#include "path.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

// The driver's limit on loops is 65,535 iterations (docs/decisions.md, budgets).
const uint SUM_STEPS = 62500u;

float stream_number(uint stream, uint index) {
    float u = float(pcg4d(uvec4(stream, index, 0u, 0u)).x >> 8) * 5.9604644775390625e-8;
    return stream == 0u ? 0.1 : (stream == 1u ? u : (u < 1.0e-4 ? 1.0e4 : 0.0));
}

void sum_stream(uint stream) {
    uvec4 state = probe_output[stream];
    float sum = uintBitsToFloat(state.x);
    float compensation = uintBitsToFloat(state.y);
    for (uint i = 0u; i < SUM_STEPS; i++) {
        float number = stream_number(stream, state.z + i);
        PRECISE float y = guarded(GUARD_COMPENSATED_SUM) ? number - compensation : number;
        PRECISE float t = sum + y;
        PRECISE float kept = t - sum;
        PRECISE float lost = kept - y;
        compensation = lost;
        sum = t;
    }
    probe_output[stream] = uvec4(floatBitsToUint(sum), floatBitsToUint(compensation), state.z + SUM_STEPS, 0u);
}

void sum_block(uint block) {
    uvec4 open_sum = uvec4(0u);
    for (uint i = 0u; i < BLOCK_SAMPLES; i++) {
        uint index = block * BLOCK_SAMPLES + i;
        open_sum =
            add_sample(open_sum, vec3(stream_number(0u, index), stream_number(1u, index), stream_number(2u, index)));
    }
    probe_output[block] = open_sum;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    if (push.flags == 0u) {
        sum_stream(index);
    } else {
        sum_block(index);
    }
}
