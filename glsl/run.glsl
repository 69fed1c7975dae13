// What the steps of a path read of push constants and of the render's constants, read once, before them: lavapipe reads
// one that stands in a branch lane by lane, as if each had its own.
#ifndef RUN_GLSL
#define RUN_GLSL

#include "bindings.glsl"
#include "constants.glsl"

struct Run {
    uint samples;       // Of this run.
    uint leave_eighths; // Paths are left when fewer eighths of the lanes than this have work.
};
Run run = Run(push.samples, push.leave_eighths);

RenderConstants constants = fetch_constants();

#endif
