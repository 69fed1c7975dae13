// The edge function as a driver that fuses would compute it, for tests: included first, it stands in for trace/edge.glsl.
//
// fma(ax, by, -(ay * bx)) rounds once what ax * by - (rounded ay * bx) is. Products are split into their parts exactly
// (Dekker 1971), since no driver at hand has a fused operation.
#ifndef TRACE_EDGE_GLSL
#define TRACE_EDGE_GLSL

// x as the sum of two numbers of 12 bits each.
vec2 split(float x) {
    precise float shifted = x * 4097.0;
    precise float high = shifted - (shifted - x);
    precise float low = x - high;
    return vec2(high, low);
}

// What rounding took from the product p = x * y.
float product_error(float x, float y, float p) {
    vec2 a = split(x);
    vec2 b = split(y);
    precise float error = ((a.x * b.x - p) + a.x * b.y + a.y * b.x) + a.y * b.y;
    return error;
}

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
