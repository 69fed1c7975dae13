// Warps of the unit square, and the basis that turns them to a normal.
#ifndef SAMPLING_WARP_GLSL
#define SAMPLING_WARP_GLSL

#include "guards.glsl"

const float PI = 3.14159265358979;
const float INV_PI = 0.318309886183791;

// An orthonormal basis around the unit vector n. Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
void make_basis(vec3 n, out vec3 s, out vec3 t) {
    precise float sign_z = n.z >= 0.0 || !guarded(GUARD_BASIS_SIGN) ? 1.0 : -1.0;
    precise float a = -1.0 / (sign_z + n.z);
    precise float b = n.x * n.y * a;
    precise vec3 first = vec3(1.0 + sign_z * n.x * n.x * a, sign_z * b, -sign_z * n.x);
    precise vec3 second = vec3(b, sign_z + n.y * n.y * a, -n.y);
    s = first;
    t = second;
}

// The point at `radius` (which may be negative) in the direction of `circle`, a cosine and a sine. Those are only good to
// 2^-11 on some devices, so the point is put back on its circle.
vec2 disc_point(float radius, vec2 circle) {
    precise float squared = circle.x * circle.x + circle.y * circle.y;
    precise vec2 point = circle * (radius * (guarded(GUARD_DISC_RENORMALISE) ? inversesqrt(squared) : 1.0));
    return point;
}

// Shirley and Chiu's concentric map from the square to the unit disc (1997).
vec2 square_to_disc(vec2 u) {
    vec2 centred = 2.0 * u - 1.0;
    if (centred.x == 0.0 && centred.y == 0.0) {
        return vec2(0.0);
    }
    bool wide = abs(centred.x) > abs(centred.y);
    float radius = wide ? centred.x : centred.y;
    float part = (PI / 4.0) * ((wide ? centred.y : centred.x) / radius);
    float angle = wide ? part : (PI / 2.0) - part;
    return disc_point(radius, vec2(cos(angle), sin(angle)));
}

// `x` where it is above 0, else 0. A NaN stays one, where max() promises nothing: it is to be counted, not hidden.
float not_negative(float x) {
    return x < 0.0 ? 0.0 : x;
}

// A unit direction around +z with density cos / pi (Malley's method).
vec3 cosine_hemisphere(vec2 u) {
    vec2 disc = square_to_disc(u);
    precise float z2 = 1.0 - disc.x * disc.x - disc.y * disc.y;
    return vec3(disc, sqrt(not_negative(z2)));
}

// A unit direction around +z with density 1 / (2 pi).
vec3 uniform_hemisphere(vec2 u) {
    vec2 disc = square_to_disc(u);
    precise float r2 = disc.x * disc.x + disc.y * disc.y;
    precise float scale = sqrt(not_negative(2.0 - r2));
    return vec3(disc * scale, not_negative(1.0 - r2));
}

// Barycentrics (b1, b2) uniform over a triangle.
vec2 square_to_triangle(vec2 u) {
    precise float root = sqrt(u.x);
    precise vec2 b = vec2(root * (1.0 - u.y), root * u.y);
    return b;
}

#endif
