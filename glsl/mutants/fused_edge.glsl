// The edge function as a driver that fuses would compute it, for tests: included first, it stands in for trace/edge.glsl.
//
// fma(ax, by, -(ay * bx)) rounds once what ax * by - (rounded ay * bx) is. The product's error is computed apart, since no driver
// at hand has a fused operation.
#ifndef TRACE_EDGE_GLSL
#define TRACE_EDGE_GLSL

#include "probes/product_error.glsl"

float edge_function(float ax, float ay, float bx, float by) {
    precise float p = ax * by;
    precise float q = ay * bx;
    float p_error = product_error(ax, by, p);
    precise float difference = p - q;
    precise float back = difference - p;
    precise float rest = (p - (difference - back)) - (q + back);
    precise float e = difference + (rest + p_error);
    return e;
}

#endif
