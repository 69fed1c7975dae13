// The edge function of the watertight triangle test.
#ifndef TRACE_EDGE_GLSL
#define TRACE_EDGE_GLSL

// Twice the signed area between the origin, a and b. `precise` keeps a driver from fusing the multiplication with the
// subtraction: one product would be rounded and the other not, and e(a, b) would no longer be -e(b, a).
float edge_function(float ax, float ay, float bx, float by) {
    precise float e = ax * by - ay * bx;
    return e;
}

#endif
