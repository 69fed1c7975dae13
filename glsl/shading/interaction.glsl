// The point that a ray hit: position, normals, material, and where rays that leave it start.
#ifndef SHADING_INTERACTION_GLSL
#define SHADING_INTERACTION_GLSL

#include "effects.glsl"
#include "guards.glsl"
#include "records/material.glsl"
#include "records/surface.glsl"
#include "records/triangle.glsl"
#include "trace/hit.glsl"
#include "trace/ray.glsl"

struct Interaction {
    vec3 p;         // Hit point, from barycentrics: its error does not grow with the ray's length.
    vec3 inner;     // p, held off the edges of its triangle: where rays that leave start from.
    vec3 p_error;   // Bound on the error of p and of the neighbours' tests against it, a component.
    vec3 ng;        // Unit geometric normal, on wo's side.
    vec3 ns;        // Unit shading normal, on wo's side of the geometry and with dot(ns, wo) > 0.
    bool front;     // Whether wo is on the front.
    float pdf_area; // Density per unit area of light sampling at p, its light tree's choice aside; 0 where the triangle does not emit.
    uint light_trail; // Its triangle's way through the light tree.
    Material material;
};

// Terminator rule: the interpolated normal is turned to wo's geometric side; where it faces away from wo all the same, the
// geometric normal takes its place. Directions that leave through the geometry are the BSDF's to reject (bsdf.glsl).
vec3 shading_normal(uint index, float b1, float b2, vec3 ng, bool front, vec3 wo) {
    Corners corners = fetch_corners(index);
    precise float b0 = 1.0 - b1 - b2;
    precise vec3 interpolated = corners.n0 * b0 + corners.n1 * b1 + corners.n2 * b2;
    precise vec3 ns = interpolated * (front ? 1.0 : -1.0);
    precise float length2 = dot(ns, ns);
    if (!(length2 > 1.0e-12)) {
        return ng;
    }
    ns = ns * inversesqrt(length2);
    return dot(ns, wo) > 0.0 && dot(ns, ng) > 0.0 ? ns : ng;
}

// The hit point held off the edges of its triangle, on which rounding would decide whether a neighbour in the same plane,
// or across a corner, is met at once. A barycentric is the distance from an edge over the height on it: at least
// 4 error / (|e1| + |e2|) keeps a triangle that is no sliver its `error` away from each edge, and moves no point by more than
// a few of these. `p` is the point itself.
vec3 inner_point(vec3 v0, vec3 e1, vec3 e2, float b1, float b2, vec3 p, float error) {
    precise vec3 lengths = abs(e1) + abs(e2);
    precise float length = lengths.x + lengths.y + lengths.z;
    precise float least = length > 16.0 * error ? 4.0 * error / length : 0.25;
    precise float b0 = 1.0 - b1 - b2;
    if (!guarded(GUARD_EDGE_MARGIN) || lesser(lesser(b0, b1), b2) >= least) {
        return p;
    }
    vec3 held = greater(vec3(b0, b1, b2), vec3(least));
    precise float sum = held.x + held.y + held.z;
    precise vec3 inner = v0 + (held.y / sum) * e1 + (held.z / sum) * e2;
    return inner;
}

// What the ray found at `hit`; `wo` is the unit vector back along it.
Interaction make_interaction(Hit hit, vec3 wo) {
    Triangle triangle = fetch_triangle(hit.triangle);
    Surface surface = fetch_surface(hit.triangle);
    precise vec3 e1 = triangle.v1 - triangle.v0;
    precise vec3 e2 = triangle.v2 - triangle.v0;
    precise vec3 p = triangle.v0 + hit.b1 * e1 + hit.b2 * e2;
    Interaction it;
    it.p = p;
    // 2^-21 = 8 units in the last place of each term that p and a neighbour's sheared vertices are made of.
    precise vec3 p_error = (abs(triangle.v0) + abs(e1) + abs(e2)) * 4.76837158203125e-7;
    it.p_error = p_error;
    it.inner = inner_point(triangle.v0, e1, e2, hit.b1, hit.b2, p, greater(greater(p_error.x, p_error.y), p_error.z));
    precise float side = surface.ng.x * wo.x + surface.ng.y * wo.y + surface.ng.z * wo.z;
    it.front = side > 0.0;
    it.ng = it.front || !guarded(GUARD_NORMAL_SIDE) ? surface.ng : -surface.ng;
    it.ns = it.ng;
    if (HAS_SMOOTH_NORMALS != 0u && (triangle.flags & TRIANGLE_SMOOTH) != 0u) {
        it.ns = shading_normal(hit.triangle, hit.b1, hit.b2, it.ng, it.front, wo);
    }
    it.pdf_area = triangle.pdf_area;
    it.light_trail = triangle.flags >> TRIANGLE_TRAIL_SHIFT;
    it.material = fetch_material(surface.material);
    return it;
}

// Start of a ray that leaves on the side of `n` (it.ng or its negative): the inner point moved along n until no error can
// put it behind the surface.
vec3 spawn_origin(Interaction it, vec3 n) {
    precise float distance = abs(n.x) * it.p_error.x + abs(n.y) * it.p_error.y + abs(n.z) * it.p_error.z;
    if (!guarded(GUARD_SPAWN_OFFSET)) {
        return it.inner;
    }
    precise vec3 o = it.inner + n * distance;
    return o;
}

#endif
