// What rounding takes from a product, without fma (Dekker 1971): for probes, and for the mutant of the edge function.
#ifndef PROBES_PRODUCT_ERROR_GLSL
#define PROBES_PRODUCT_ERROR_GLSL

// Error of the product p = a * b, exact: both factors in halves of 12 bits.
float product_error(float a, float b, float p) {
    precise float ca = a * 4097.0;
    precise float a_high = ca - (ca - a);
    precise float a_low = a - a_high;
    precise float cb = b * 4097.0;
    precise float b_high = cb - (cb - b);
    precise float b_low = b - b_high;
    precise float error = ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return error;
}

#endif
