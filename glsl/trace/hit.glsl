// The nearest hit so far, and the order of hits.
#ifndef TRACE_HIT_GLSL
#define TRACE_HIT_GLSL

#include "interface.glsl"
#include "trace/ray.glsl"

struct Hit {
    float key;      // Distance that decides, in units of the ray's direction.
    uint id;        // Triangle in file order: the smaller one wins a tie.
    uint triangle;  // Triangle in leaf order, or NO_INDEX.
    float b1, b2;   // Barycentrics of the second and third corner.
};

// No hit, within reach of any.
Hit no_hit() {
    return Hit(NO_HIT_KEY, NO_INDEX, NO_INDEX, 0.0, 0.0);
}

// No hit yet of a shadow ray: only a hit with a key below `limit` counts.
Hit no_hit_below(float limit) {
    return Hit(limit, 0u, NO_INDEX, 0.0, 0.0);
}

#endif
