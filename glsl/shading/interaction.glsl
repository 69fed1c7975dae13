// The point that a ray hit: position, normals, material, and where rays that leave it start.
#ifndef SHADING_INTERACTION_GLSL
#define SHADING_INTERACTION_GLSL

#include "effects.glsl"
#include "records/material.glsl"
#include "records/surface.glsl"
#include "records/triangle.glsl"
#include "trace/hit.glsl"

struct Interaction {
    vec3 p;         // Hit point, from barycentrics: its error does not grow with the ray's length.
    vec3 p_error;   // Bound on the error of p and of the neighbours' tests against it, a component.
    vec3 ng;        // Unit geometric normal, on wo's side.
    vec3 ns;        // Unit shading normal, on wo's side of the geometry and with dot(ns, wo) > 0.
    bool front;     // Whether wo is on the front.
    float pdf_area; // Density per unit area of light sampling at p; 0 where the triangle does not emit.
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
    precise float side = surface.ng.x * wo.x + surface.ng.y * wo.y + surface.ng.z * wo.z;
    it.front = side > 0.0;
    it.ng = it.front ? surface.ng : -surface.ng;
    it.ns = it.ng;
    if (HAS_SMOOTH_NORMALS != 0u && (triangle.flags & TRIANGLE_SMOOTH) != 0u) {
        it.ns = shading_normal(hit.triangle, hit.b1, hit.b2, it.ng, it.front, wo);
    }
    it.pdf_area = triangle.pdf_area;
    it.material = fetch_material(surface.material);
    return it;
}

// Start of a ray that leaves on the side of `n` (it.ng or its negative): p moved along n until no error can put it behind
// the surface.
vec3 spawn_origin(Interaction it, vec3 n) {
    precise float distance = abs(n.x) * it.p_error.x + abs(n.y) * it.p_error.y + abs(n.z) * it.p_error.z;
    precise vec3 o = it.p + n * distance;
    return o;
}

#endif
