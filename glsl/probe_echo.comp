// Copies texels to a storage buffer, for the test of uploads, dispatches and readbacks.
//
// Comes in: texels, and their number as the one push constant. Goes out: the same lanes. Invocation i copies texel i;
// invocations past the end do nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "interface.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

layout(set = 0, binding = BINDING_PROBE_INPUT) uniform utextureBuffer probe_input;
layout(set = 0, binding = BINDING_PROBE_OUTPUT, std430) writeonly buffer ProbeOutput { uvec4 probe_output[]; };
layout(push_constant) uniform Push { uint texels; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < texels) probe_output[i] = texelFetch(probe_input, int(i));
}
