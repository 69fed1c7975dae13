// Effects and estimator choices as specialisation constants: plain `if`s on them leave no code behind.
//
// An effect that is off draws no random number and never changes the dimensions of those that others draw, so a picture
// made with every effect on equals the one made with the scene's own set.
#ifndef EFFECTS_GLSL
#define EFFECTS_GLSL

#include "interface.glsl"

// Effects of a scene: HAS_NAME for each (render/effects.rs decides them, design section 6).
#include "effect_switches.glsl"

// Choices of the user.
layout(constant_id = SPEC_ACCEL) const uint ACCEL = ACCEL_WIDE;
layout(constant_id = SPEC_STACK_ENTRIES) const uint STACK_ENTRIES = 16u;
layout(constant_id = SPEC_INTERSECTOR) const uint INTERSECTOR = INTERSECTOR_WATERTIGHT;
layout(constant_id = SPEC_SAMPLER) const uint SAMPLER = SAMPLER_SOBOL;
layout(constant_id = SPEC_LIGHTS) const uint LIGHTS = LIGHTS_MIS;
layout(constant_id = SPEC_LIGHT_PICK) const uint LIGHT_PICK = LIGHT_PICK_LIST;
layout(constant_id = SPEC_HEMISPHERE) const uint HEMISPHERE = HEMISPHERE_COSINE;
layout(constant_id = SPEC_ROULETTE) const uint ROULETTE = ROULETTE_THROUGHPUT;
layout(constant_id = SPEC_TESTS_A_VISIT) const uint TESTS_A_VISIT = 0u;
layout(constant_id = SPEC_REFILL_EIGHTHS) const uint REFILL_EIGHTHS = 6u;

#endif
