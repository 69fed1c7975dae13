// Traversal, a step at a time: where a ray stands in the tree (or in the list of triangles), so that it can stop after any
// step and go on in another dispatch. Extension and shadow rays share it; they differ in one flag.
//
// A step is one node visit or one triangle test; each counts against the budget.
#ifndef TRACE_TRAVERSAL_GLSL
#define TRACE_TRAVERSAL_GLSL

#include "effects.glsl"
#include "records/node.glsl"
#include "run.glsl"
#include "trace/box.glsl"
#include "trace/hit.glsl"
#include "trace/triangle.glsl"

struct Traversal {
    // Wide: first child of a node and, in bits 24 to 31, its children still to visit; bits 0 to 7 hold its inner mask.
    // Binary: x is the node to visit next, as packed by `pack_node`, y whether there is one. Brute: x is the cursor.
    uvec2 nodes;
    // First triangle of a node's leaves, in leaf order, and a bit for each that is still to test.
    uvec2 triangles;
    uvec2 queued;    // The same of the node visited after that one, where TESTS_A_VISIT lets it wait here.
    uint stack_size; // Entries on the stack.
    Hit best;        // Nearest hit so far.
    bool searching;  // Whether there is anything left to do.
};

uvec2 stack[STACK_ENTRIES];
uint stack_overflows = 0u;

const uint INNER_HITS = 0xff000000u;

// A binary node's count and first index in one word: a leaf holds at most 7 triangles.
uint pack_node(BinaryNode node) {
    return (node.count << 29) | node.first;
}

// Begins the search of the ray (o, d) for a hit before `best`.
Traversal begin_traversal(Hit best, vec3 o, vec3 d) {
    Traversal traversal;
    traversal.triangles = uvec2(0u);
    traversal.queued = uvec2(0u);
    traversal.stack_size = 0u;
    traversal.best = best;
    traversal.searching = constants.triangle_count > 0u && is_traceable(o, d);
    traversal.nodes = uvec2(0u);
    if (ACCEL == ACCEL_WIDE) {
        // The root, as the only child of a node that is not there: slot 0 in whatever octant, so every bit of its mask.
        traversal.nodes = uvec2(0u, 0x80000000u);
    } else if (ACCEL == ACCEL_BINARY && traversal.searching) {
        traversal.nodes = uvec2(pack_node(fetch_binary_node(0u)), 1u);
    }
    return traversal;
}

// A stack of at most this many entries lives in registers.
const uint SHIFTED_ENTRIES = 24u;

// A shallow stack has its top at entry 0 and shifts the others: every index is then a constant, and the stack lives in
// registers. Moving a dozen entries is cheaper than one access to an indexed array, which runs lane by lane on CPU devices. A
// deep stack is an indexed array with its top at the end: a shift of that length would no longer be unrolled, and its
// iterations would count against the driver's limit (design section 4) without being steps.
void push_entry(inout Traversal traversal, uvec2 entry) {
    // The builder bounds the depth, so there is always room; the host takes any overflow for a bug.
    if (traversal.stack_size >= STACK_ENTRIES) {
        stack_overflows++;
        return;
    }
    if (STACK_ENTRIES <= SHIFTED_ENTRIES) {
        // Upwards: Mesa does not unroll a loop that counts down.
        uvec2 moved = entry;
        for (uint i = 0u; i < STACK_ENTRIES; i++) {
            uvec2 below = stack[i];
            stack[i] = moved;
            moved = below;
        }
    } else {
        stack[traversal.stack_size] = entry;
    }
    traversal.stack_size++;
}

uvec2 pop_entry(inout Traversal traversal) {
    traversal.stack_size--;
    if (STACK_ENTRIES > SHIFTED_ENTRIES) {
        return stack[traversal.stack_size];
    }
    uvec2 entry = stack[0];
    for (uint i = 0u; i + 1u < STACK_ENTRIES; i++) {
        stack[i] = stack[i + 1u];
    }
    return entry;
}

// A box that the ray enters beyond this holds no hit that comes before `best`.
float cull_distance(Hit best) {
    return guarded(GUARD_CULL_SLACK) ? best.key * CULL_BEYOND : best.key;
}

// Puts a node's triangles in line.
void take_triangles(inout Traversal traversal, uvec2 group) {
    if (TESTS_A_VISIT != 0u && traversal.triangles.y != 0u) {
        traversal.queued = group;
    } else {
        traversal.triangles = group;
    }
}

// Visits the next node of the wide tree: its children that the ray enters become the current group.
void visit_wide(inout Traversal traversal, Ray ray) {
    if ((traversal.nodes.y & INNER_HITS) == 0u) {
        traversal.nodes = pop_entry(traversal);
    }
    uint octant = (ray.inv.x >= 0.0 ? 4u : 0u) | (ray.inv.y >= 0.0 ? 2u : 0u) | (ray.inv.z >= 0.0 ? 1u : 0u);
    uint bit = uint(findMSB(traversal.nodes.y));
    uint slot = (bit - 24u) ^ octant;
    uint before = bitCount(traversal.nodes.y & ~(0xffffffffu << slot) & 0xffu);
    uint index = traversal.nodes.x + before;
    traversal.nodes.y &= ~(1u << bit);
    if ((traversal.nodes.y & INNER_HITS) != 0u) {
        push_entry(traversal, traversal.nodes);
    }
    WideNode node = fetch_wide_node(index);
    uint entered = enter_children(ray, node, octant, cull_distance(traversal.best));
    traversal.nodes = uvec2(node.first_child, (entered & INNER_HITS) | node.inner_mask);
    take_triangles(traversal, uvec2(node.first_triangle, entered & ~INNER_HITS));
}

// Visits the next node of the binary tree: a leaf gives its triangles, an inner node its nearer child, the other one goes
// on the stack with its entry distance.
void visit_binary(inout Traversal traversal, Ray ray) {
    float cull = cull_distance(traversal.best);
    if (traversal.nodes.y == 0u) {
        uvec2 entry = pop_entry(traversal);
        traversal.nodes = uvec2(entry.x, uintBitsToFloat(entry.y) <= cull ? 1u : 0u);
        if (traversal.nodes.y == 0u) {
            return;
        }
    }
    uint first = traversal.nodes.x & 0x1fffffffu;
    uint count = traversal.nodes.x >> 29;
    traversal.nodes.y = 0u;
    if (count > 0u) {
        take_triangles(traversal, uvec2(first, (1u << count) - 1u));
        return;
    }
    BinaryNode a = fetch_binary_node(first);
    BinaryNode b = fetch_binary_node(first + 1u);
    float a_entry, b_entry;
    bool a_entered = enters_box(ray, a.low, a.high, cull, a_entry);
    bool b_entered = enters_box(ray, b.low, b.high, cull, b_entry);
    bool a_first = a_entered && (!b_entered || a_entry <= b_entry);
    if (a_entered && b_entered) {
        push_entry(traversal, uvec2(pack_node(a_first ? b : a), floatBitsToUint(a_first ? b_entry : a_entry)));
    }
    if (a_entered || b_entered) {
        traversal.nodes = uvec2(pack_node(a_first ? a : b), 1u);
    }
}

// Puts the next triangles of the list in line, 24 at most.
void visit_brute(inout Traversal traversal) {
    uint count = min(constants.triangle_count - traversal.nodes.x, 24u);
    take_triangles(traversal, uvec2(traversal.nodes.x, (1u << count) - 1u));
    traversal.nodes.x += count;
}

// Whether a node is left to visit.
bool nodes_left(Traversal traversal) {
    if (ACCEL == ACCEL_WIDE) {
        return (traversal.nodes.y & INNER_HITS) != 0u || traversal.stack_size > 0u;
    }
    if (ACCEL == ACCEL_BINARY) {
        return traversal.nodes.y != 0u || traversal.stack_size > 0u;
    }
    return traversal.nodes.x < constants.triangle_count;
}

// Whether the next node may be visited: there is one, and room for its triangles.
bool node_is_due(Traversal traversal) {
    return TESTS_A_VISIT != 0u ? traversal.queued.y == 0u && nodes_left(traversal) : traversal.triangles.y == 0u;
}

// Visits the next node, which is due.
void visit_node(inout Traversal traversal, Ray ray) {
    if (ACCEL == ACCEL_WIDE) {
        visit_wide(traversal, ray);
    } else if (ACCEL == ACCEL_BINARY) {
        visit_binary(traversal, ray);
    } else {
        visit_brute(traversal);
    }
}

// Tests the next triangle in line. With `first_hit_ends` any hit is enough.
void visit_triangle(inout Traversal traversal, Ray ray, uint skip, uint skip_too, bool first_hit_ends) {
    uint index = traversal.triangles.x + uint(findLSB(traversal.triangles.y));
    traversal.triangles.y &= traversal.triangles.y - 1u;
    if (TESTS_A_VISIT != 0u && traversal.triangles.y == 0u) {
        traversal.triangles = traversal.queued;
        traversal.queued.y = 0u;
    }
    bool changed = test_triangle(ray, index, skip, skip_too, traversal.best);
    if (first_hit_ends && changed) {
        traversal.triangles.y = 0u;
        traversal.queued.y = 0u;
        traversal.searching = false;
    }
}

#endif
