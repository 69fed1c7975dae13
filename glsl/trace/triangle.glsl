// Ray-triangle tests, and what a hit is worth. CPU twin: src/bvh/intersect.rs.
#ifndef TRACE_TRIANGLE_GLSL
#define TRACE_TRIANGLE_GLSL

#include "effects.glsl"
#include "guards.glsl"
#include "records/triangle.glsl"
#include "trace/edge.glsl"
#include "trace/hit.glsl"
#include "trace/ray.glsl"

// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). Every vertex is sheared by the same
// expression, so two triangles see a shared edge alike, and an edge function's sign is right up to a relative error of its
// own vertices: no ray slips between.
// `a`, `b`, `c` are the corners relative to the ray's origin, its largest axis last. Gives t and the barycentrics; false
// where there is no hit.
bool hit_watertight(Ray ray, vec3 a, vec3 b, vec3 c, out float t, out float b1, out float b2) {
    precise float ax = a.x - ray.shear.x * a.z;
    precise float ay = a.y - ray.shear.y * a.z;
    precise float bx = b.x - ray.shear.x * b.z;
    precise float by = b.y - ray.shear.y * b.z;
    precise float cx = c.x - ray.shear.x * c.z;
    precise float cy = c.y - ray.shear.y * c.z;
    float u = edge_function(cx, cy, bx, by);
    float v = edge_function(ax, ay, cx, cy);
    float w = edge_function(bx, by, ax, ay);
    precise float det = u + v + w;
    precise float inv = 1.0 / det;
    precise float distance = (u * (ray.shear.z * a.z) + v * (ray.shear.z * b.z) + w * (ray.shear.z * c.z)) * inv;
    precise float second = v * inv;
    precise float third = w * inv;
    t = distance;
    b1 = second;
    b2 = third;
    float least = lesser(lesser(u, v), w);
    float most = greater(greater(u, v), w);
    bool has_area = guarded(GUARD_EXACT_DETERMINANT) ? det != 0.0 : abs(det) > 1.0e-8;
    return !(least < 0.0 && most > 0.0) && has_area && distance > 0.0;
}

// Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997), two-sided: its edges leak.
bool hit_moller_trumbore(Ray ray, Triangle triangle, out float t, out float b1, out float b2) {
    precise vec3 e1 = triangle.v1 - triangle.v0;
    precise vec3 e2 = triangle.v2 - triangle.v0;
    precise vec3 p = vec3(ray.d.y * e2.z - ray.d.z * e2.y, ray.d.z * e2.x - ray.d.x * e2.z,
                          ray.d.x * e2.y - ray.d.y * e2.x);
    precise float det = e1.x * p.x + e1.y * p.y + e1.z * p.z;
    if (det == 0.0) {
        return false;
    }
    precise float inv = 1.0 / det;
    precise vec3 s = ray.o - triangle.v0;
    precise float first = (s.x * p.x + s.y * p.y + s.z * p.z) * inv;
    precise vec3 q = vec3(s.y * e1.z - s.z * e1.y, s.z * e1.x - s.x * e1.z, s.x * e1.y - s.y * e1.x);
    precise float second = (ray.d.x * q.x + ray.d.y * q.y + ray.d.z * q.z) * inv;
    precise float distance = (e2.x * q.x + e2.y * q.y + e2.z * q.z) * inv;
    precise float sum = first + second;
    t = distance;
    b1 = first;
    b2 = second;
    return first >= 0.0 && first <= 1.0 && second >= 0.0 && sum <= 1.0 && t > 0.0;
}

// Where the ray enters the triangle's own box, grown by TRIANGLE_PAD: a hit outside that box is rounding, not geometry
// (a sliver's edge functions can agree far beyond its tip), and its distance is held between entry and exit. This ties
// every hit to a box that all nodes above contain, so that no tree can lose what brute force finds. `a`, `b`, `c` as above.
bool meets_own_box(Ray ray, vec3 a, vec3 b, vec3 c, out float entry, out float leave) {
    entry = 0.0;
    leave = NO_HIT_KEY;
    if (!guarded(GUARD_TRIANGLE_BOX)) {
        return true;
    }
    vec3 low = lesser(lesser(a, b), c);
    vec3 high = greater(greater(a, b), c);
    bvec3 forward = greaterThanEqual(ray.inv_permuted, vec3(0.0));
    precise vec3 near = mix(high, low, forward) * ray.inv_permuted - ray.triangle_pad;
    precise vec3 far = mix(low, high, forward) * ray.inv_permuted + ray.triangle_pad;
    entry = greater(greater(near.x, near.y), near.z);
    leave = lesser(lesser(far.x, far.y), far.z);
    return entry <= leave && leave >= 0.0;
}

// Tests the triangle at `index` in leaf order and keeps it in `best` if it comes first in the order of hits: smaller key,
// then smaller id. The key depends on the ray and the triangle alone. `skip` and `skip_too` (leaf order) never count: the
// triangle that the ray starts from, and the light that a shadow ray aims at. True where `best` changed.
bool test_triangle(Ray ray, uint index, uint skip, uint skip_too, inout Hit best) {
    Triangle triangle = fetch_triangle(index);
    precise vec3 a = permute(ray, triangle.v0) - ray.o_permuted;
    precise vec3 b = permute(ray, triangle.v1) - ray.o_permuted;
    precise vec3 c = permute(ray, triangle.v2) - ray.o_permuted;
    float t, b1, b2, entry, leave;
    bool hit;
    if (INTERSECTOR == INTERSECTOR_WATERTIGHT) {
        hit = hit_watertight(ray, a, b, c, t, b1, b2);
    } else {
        hit = hit_moller_trumbore(ray, triangle, t, b1, b2);
    }
    bool in_box = meets_own_box(ray, a, b, c, entry, leave);
    bool nearer = guarded(GUARD_EMITTER_NEARER) && (triangle.flags & TRIANGLE_EMITS) != 0u;
    precise float key = lesser(greater(t, entry), leave) * (nearer ? EMITTER_NEARER : 1.0);
    bool first = key < best.key || (key == best.key && triangle.id < best.id);
    bool skipped = (guarded(GUARD_SKIP_SOURCE) && index == skip) || (guarded(GUARD_SKIP_LIGHT) && index == skip_too);
    bool counts = hit && in_box && first && !skipped;
    if (counts) {
        best = Hit(key, triangle.id, index, b1, b2);
    }
    return counts;
}

#endif
