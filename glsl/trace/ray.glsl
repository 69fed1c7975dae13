// A ray with what the box and triangle tests derive from it. The CPU twin is src/bvh/intersect.rs: same operations in the
// same order, so that both find the same hit bit for bit.
#ifndef TRACE_RAY_GLSL
#define TRACE_RAY_GLSL

#include "guards.glsl"

struct Ray {
    vec3 o;           // Origin, scaled units.
    vec3 d;           // Direction, of any length.
    vec3 inv;         // 1 / d, finite.
    vec3 node_pad;    // Padding of nodes' boxes, in t, an axis.
    vec3 o_permuted;  // Origin with the axis of the largest |d| last,
    vec3 inv_permuted; // and so 1 / d,
    vec3 triangle_pad; // and the padding of triangles' own boxes, in t.
    vec3 shear;       // d.x / d.z, d.y / d.z, 1 / d.z in that order of axes.
    bool z_is_x;      // That axis is x,
    bool z_is_y;      // or y; otherwise it is z.
};

// The smaller and the larger of two numbers that are not NaN. min() and max() promise nothing for NaN, and drivers that do
// keep their promise pay for it three times over.
float lesser(float a, float b) {
    return b < a ? b : a;
}

float greater(float a, float b) {
    return b > a ? b : a;
}

vec3 lesser(vec3 a, vec3 b) {
    return mix(a, b, lessThan(b, a));
}

vec3 greater(vec3 a, vec3 b) {
    return mix(a, b, greaterThan(b, a));
}

vec4 lesser(vec4 a, vec4 b) {
    return mix(a, b, lessThan(b, a));
}

vec4 greater(vec4 a, vec4 b) {
    return mix(a, b, greaterThan(b, a));
}

// `v` with the ray's largest axis last, the order kept cyclic (Woop, Benthin and Wald 2013, section 3).
vec3 permute(Ray ray, vec3 v) {
    return ray.z_is_x ? v.yzx : (ray.z_is_y ? v.zxy : v);
}

Ray make_ray(vec3 o, vec3 d) {
    Ray ray;
    ray.o = o;
    ray.d = d;
    // A component of zero would give 0 * inf on a box's plane; the sign stays, and 1 / MIN_DIRECTION overflows nothing.
    vec3 tiny = uintBitsToFloat((floatBitsToUint(d) & 0x80000000u) | floatBitsToUint(MIN_DIRECTION));
    vec3 divisor = guarded(GUARD_DIRECTION_FLOOR) ? mix(tiny, d, greaterThanEqual(abs(d), vec3(MIN_DIRECTION))) : d;
    precise vec3 inv = 1.0 / divisor;
    ray.inv = inv;
    vec3 a = abs(o);
    // Bounds every coordinate difference between origin and scene: the scene is scaled to lie within [-1, 1] on every axis.
    precise float reach = greater(greater(a.x, a.y), a.z) + 1.0;
    precise vec3 node_pad = (reach * (guarded(GUARD_NODE_PAD) ? NODE_PAD : 0.0)) * abs(inv);
    ray.node_pad = node_pad;
    vec3 m = abs(d);
    ray.z_is_x = !(m.y > m.x) && !(m.z > m.x);
    ray.z_is_y = !ray.z_is_x && !(m.z > m.y);
    ray.o_permuted = permute(ray, o);
    ray.inv_permuted = permute(ray, inv);
    precise vec3 triangle_pad = (reach * TRIANGLE_PAD) * abs(ray.inv_permuted);
    ray.triangle_pad = triangle_pad;
    vec3 p = permute(ray, d);
    precise vec3 shear = vec3(p.x / p.z, p.y / p.z, 1.0 / p.z);
    ray.shear = shear;
    return ray;
}

// Whether a ray can be traced: all its numbers finite, its direction not zero. Anything else hits nothing, at no cost.
bool is_traceable(vec3 o, vec3 d) {
    if (!guarded(GUARD_REFUSE_INVALID_RAYS)) {
        return true;
    }
    uvec3 m = max(floatBitsToUint(o) & 0x7fffffffu, floatBitsToUint(d) & 0x7fffffffu);
    return max(max(m.x, m.y), m.z) < 0x7f800000u && (d.x != 0.0 || d.y != 0.0 || d.z != 0.0);
}

#endif
