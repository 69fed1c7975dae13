// Numerical guards by name, each the cure of a hard case (docs/numerics.md). Renders have them all; tests build kernels with one
// taken out, to show that its hard case then fails. `guarded(...)` is a constant: drivers fold it away.
#ifndef GUARDS_GLSL
#define GUARDS_GLSL

#include "interface.glsl"

layout(constant_id = SPEC_WITHOUT_GUARD) const uint WITHOUT_GUARD = GUARD_NONE;

bool guarded(uint guard) {
    return WITHOUT_GUARD != guard;
}

#endif
