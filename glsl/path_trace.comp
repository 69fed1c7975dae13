// The path tracer: an invocation owns a pixel and runs its samples in order until they are done or its step budget is.
//
// In: the scene's records; path states, lists and open sums of the tile. Out: the latter three, and counters. One loop
// serves extension and shadow rays; it is left when too few lanes of the subgroup still trace, so that idle lanes get
// new rays soon. What a pixel computes depends on neither budget nor neighbours.
#version 460
#extension GL_GOOGLE_include_directive : require
#if SUBGROUP_BALLOT
#extension GL_KHR_shader_subgroup_ballot : require
#endif

#include "keep_nan.glsl"
#include "bindings.glsl"
#include "path.glsl"

layout(local_size_x_id = SPEC_WORKGROUP_X, local_size_y_id = SPEC_WORKGROUP_Y) in;

// Lanes of this invocation's subgroup that reach this place together.
uint lanes_here() {
#if SUBGROUP_BALLOT
    uvec4 ballot = subgroupBallot(true);
    return bitCount(ballot.x) + bitCount(ballot.y) + bitCount(ballot.z) + bitCount(ballot.w);
#else
    return 1u;
#endif
}

// Tests the next triangle in line, if there is one and a step for it.
void test_next(inout Path path, Ray ray, bool shadow, inout Tally tally) {
    if (path.traversal.triangles.y != 0u && tally.steps < push.budget) {
        visit_triangle(path.traversal, ray, path.skip, path.skip_too, shadow);
        tally.steps++;
        tally.triangles++;
    }
}

// Traces the path's ray until it is done, the budget is spent, or too few of the `entered` lanes still trace.
void trace(inout Path path, uint entered, inout Tally tally) {
    Ray ray = make_ray(path.o, path.d);
    bool shadow = path.phase == PHASE_SHADOW;
    while (path.traversal.searching && tally.steps < push.budget) {
        if (node_is_due(path.traversal)) {
            visit_node(path.traversal, ray);
            tally.steps++;
            tally.nodes++;
        }
        // In a loop, lanes without a triangle in line wait for those with. A queue lets all test one or two, and visit
        // their next nodes before the rest (render/kernel.rs chooses). Hits do not depend on it.
        if (TESTS_A_VISIT == 0u) {
            while (path.traversal.triangles.y != 0u && tally.steps < push.budget) {
                test_next(path, ray, shadow, tally);
            }
        } else {
            test_next(path, ray, shadow, tally);
            if (TESTS_A_VISIT > 1u) {
                test_next(path, ray, shadow, tally);
            }
        }
        if (path.traversal.triangles.y == 0u && !nodes_left(path.traversal)) {
            path.traversal.searching = false;
        }
        if (lanes_here() * 8u < entered * REFILL_EIGHTHS) {
            break;
        }
    }
}

// Rays and what comes between them, until the pixel's samples are done or the budget is, or so few lanes have samples
// left that their paths had better go on among others.
void run_path(inout Path path, Camera camera, Stream stream, uvec2 pixel, inout uvec4 open_sum, inout Tally tally) {
    uint began = lanes_here();
    while (tally.steps + SHADING_STEPS < push.budget) {
        tally.steps++;
        if (!path.traversal.searching) {
            advance(path, camera, stream, pixel, open_sum, tally);
        }
        // A sample that was left out is counted at the dispatch's end, so there is one of them at most: the next
        // dispatch goes on.
        if (path.phase == PHASE_FINISHED || tally.invalid != 0u) {
            break;
        }
        uint unfinished = lanes_here();
        if (unfinished * 8u < began * run.leave_eighths) {
            break;
        }
        trace(path, unfinished, tally);
    }
}

void main() {
    bool begins = (push.flags & DISPATCH_BEGINS_RUN) != 0u;
    uint fills = (push.flags & DISPATCH_FILLS_FIRST_LIST) != 0u ? 0u : 1u;
    uvec2 place = uvec2(gl_GlobalInvocationID.x, gl_GlobalInvocationID.y + push.slice_row);
    if (!begins) {
        uint at = gl_GlobalInvocationID.y * LIST_ROW + gl_GlobalInvocationID.x;
        if (at >= push.listed) {
            return;
        }
        uint listed = list_words[list_word(1u - fills, push.listed_first + at)];
        place = uvec2(listed % push.tile_width, listed / push.tile_width);
    } else if (place.x >= push.tile_width || gl_GlobalInvocationID.y >= push.slice_rows || place.y >= push.tile_height) {
        return;
    }
    uint tile_pixel = place.y * push.tile_width + place.x;
    uvec2 pixel = place + uvec2(push.tile_x, push.tile_y);
    // A device that runs both sides of a branch fetches a state where a run begins, too: always the first one then,
    // which is in its caches. (As `begins ? 0u : tile_pixel` it would be moved to where `begins` is known.)
    uint loaded = tile_pixel * (1u - min(push.flags & DISPATCH_BEGINS_RUN, 1u));

    Path path;
    uvec4 open_sum;
    if (begins) {
        path.phase = PHASE_CAMERA;
        path.extends = false;
        path.samples_done = 0u;
        path.cause = CAUSE_SUM;
        path.normal = 0u;
        path.traversal = begin_traversal(no_hit(), vec3(0.0), vec3(0.0)); // nothing to search yet
        open_sum = push.first_sample % BLOCK_SAMPLES == 0u ? uvec4(0u) : open_sums[tile_pixel];
    } else {
        path = load_path(loaded);
        open_sum = open_sums[tile_pixel];
    }

    Tally tally = Tally(RESERVED_STEPS, 0u, 0u, 0u, 0u, 0u);
    run_path(path, fetch_camera(), make_stream(pixel.x | (pixel.y << 16)), pixel, open_sum, tally);

    store_path(path, tile_pixel);
    open_sums[tile_pixel] = open_sum;
    if (path.phase != PHASE_FINISHED) {
        list_words[list_word(fills, push.filled + atomicAdd(counters[COUNTER_UNFINISHED], 1u))] = tile_pixel;
    }
    atomicAdd(counters[COUNTER_RAYS], tally.rays);
    atomicAdd(counters[COUNTER_PATHS], tally.paths);
    atomicAdd(counters[COUNTER_NODES], tally.nodes);
    atomicAdd(counters[COUNTER_TRIANGLES], tally.triangles);
    atomicMax(counters[COUNTER_MAX_STEPS], tally.steps);
    if (stack_overflows != 0u) {
        atomicAdd(counters[COUNTER_STACK_OVERFLOW], stack_overflows);
    }
    if (tally.invalid != 0u) {
        uint found = tally.invalid - 1u;
        atomicAdd(counters[COUNTER_INVALID + found % INVALID_KINDS], 1u);
        atomicAdd(counters[COUNTER_INVALID + INVALID_KINDS + found / INVALID_KINDS], 1u);
    }
}
