// With KEEP_NAN, a module that asks for SignedZeroInfNanPreserve of 32-bit floats (SPV_KHR_float_controls): the driver may not
// assume that there is no NaN, so what a stage got wrong reaches the sample's sum, where it is counted. It is a mode of the
// whole module, so no constant can choose it.
#ifndef KEEP_NAN_GLSL
#define KEEP_NAN_GLSL

#if KEEP_NAN
#extension GL_EXT_spirv_intrinsics : require
spirv_execution_mode(extensions = ["SPV_KHR_float_controls"], capabilities = [4466], 4461, 32);
#endif

#endif
