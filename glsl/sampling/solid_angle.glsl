// The solid angle of a triangle.
#ifndef SAMPLING_SOLID_ANGLE_GLSL
#define SAMPLING_SOLID_ANGLE_GLSL

#include "guards.glsl"
#include "sampling/warp.glsl"

// atan(t) for |t| <= tan(pi / 8), relative error below 3e-7 (the polynomial of Moshier's Cephes library).
float arc_tangent_near_zero(float t) {
    precise float z = t * t;
    precise float tail = (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z;
    precise float angle = tail * t + t;
    return angle;
}

// The angle in [0, pi] of the point (x, y) with y >= 0, of sums, products and quotients alone: Vulkan promises only 4096
// units in the last place of its own atan. Relative error below 1e-6. Not for (0, 0).
float arc_tangent(float y, float x) {
    float across = abs(x);
    bool steep = y > across;
    float low = steep ? across : y;
    float high = steep ? y : across;
    // Within pi / 8 of the diagonal the angle is taken from the diagonal.
    bool diagonal = low > 0.41421356 * high;
    precise float slope = diagonal ? (low - high) / (low + high) : low / high;
    precise float angle = (diagonal ? PI / 4.0 : 0.0) + arc_tangent_near_zero(slope);
    precise float upper = steep ? PI / 2.0 - angle : angle;
    precise float whole = x < 0.0 ? PI - upper : upper;
    return whole;
}

float dot_product(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

vec3 cross_product(vec3 a, vec3 b) {
    precise vec3 product = a.yzx * b.zxy - a.zxy * b.yzx;
    return product;
}

// Solid angle of the triangle v0 v1 v2 seen from p (Van Oosterom and Strackee 1983). Its triple product is made of edges:
// made of the three directions, as the paper has it, it is a difference of nearly equal numbers where the triangle is
// small. The scene's extent of at most 2 keeps every product in range.
float solid_angle(vec3 p, vec3 v0, vec3 v1, vec3 v2) {
    precise vec3 a = v0 - p;
    precise vec3 b = v1 - p;
    precise vec3 c = v2 - p;
    precise vec3 e1 = v1 - v0;
    precise vec3 e2 = v2 - v0;
    float la = sqrt(dot_product(a, a));
    float lb = sqrt(dot_product(b, b));
    float lc = sqrt(dot_product(c, c));
    precise float volume = abs(guarded(GUARD_SOLID_ANGLE_EDGES) ? dot_product(a, cross_product(e1, e2))
                                                                : dot_product(a, cross_product(b, c)));
    precise float rest = la * lb * lc + dot_product(a, b) * lc + dot_product(b, c) * la + dot_product(c, a) * lb;
    precise float omega = 2.0 * arc_tangent(volume, rest);
    return omega;
}

#endif
