// A ray's whole way through the tree, for probes: renders stop and go on, probes ask few enough rays to walk them at once.
#ifndef PROBES_WALK_GLSL
#define PROBES_WALK_GLSL

#include "trace/traversal.glsl"

// The traversal of `ray` for a hit before `start`, ended; with `first_hit_ends` any hit is enough. `nodes` and `triangles` count
// its work.
Traversal walk(Ray ray, Hit start, uint skip, uint skip_too, bool first_hit_ends, out uint nodes, out uint triangles) {
    Traversal traversal = begin_traversal(start, ray.o, ray.d);
    nodes = 0u;
    triangles = 0u;
    while (traversal.searching) {
        if (node_is_due(traversal)) {
            visit_node(traversal, ray);
            nodes++;
        }
        while (traversal.triangles.y != 0u) {
            visit_triangle(traversal, ray, skip, skip_too, first_hit_ends);
            triangles++;
            if (TESTS_A_VISIT != 0u) {
                break;
            }
        }
        if (traversal.triangles.y == 0u && !nodes_left(traversal)) {
            traversal.searching = false;
        }
    }
    return traversal;
}

#endif
