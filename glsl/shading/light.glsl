// Next-event estimation: a point on a light, chosen by area, and the weights that combine it with BSDF sampling.
#ifndef SHADING_LIGHT_GLSL
#define SHADING_LIGHT_GLSL

#include "effects.glsl"
#include "guards.glsl"
#include "records/light.glsl"
#include "run.glsl"
#include "sampling/random.glsl"
#include "sampling/warp.glsl"
#include "shading/bsdf.glsl"
#include "shading/interaction.glsl"

// Veach's power heuristic with exponent 2, for the strategy with density `a` against one with density `b`. Dividing first
// keeps the squares from overflowing; 0 against anything is 0, and infinite densities share alike. A NaN stays one.
float power_heuristic(float a, float b) {
    if (a <= 0.0) {
        return 0.0;
    }
    if (!guarded(GUARD_HEURISTIC_RATIO)) {
        precise float squared = a * a / (a * a + b * b);
        return squared;
    }
    if (a == b) {
        return 0.5;
    }
    precise float ratio = b / a;
    precise float weight = 1.0 / (1.0 + ratio * ratio);
    return weight;
}

// Where in a light's share of the random numbers the one stands that chose it, in [0, 1). One number serves for the choice and for
// the point, so that the points of one pixel are spread over all lights together, as over one. A large share's last numbers
// would be rounded to 1.
float place_in_share(uint cdf_begin, float cdf_scale, uint word) {
    precise float place = float(word - cdf_begin) * cdf_scale;
    return guarded(GUARD_UNIT_FLOAT) ? lesser(place, 0.999999940395355) : place;
}

// Density per solid angle of a point on a light seen at squared distance `distance2` under the cosine `cosine`.
float light_pdf(float pdf_area, float distance2, float cosine) {
    precise float pdf = pdf_area * distance2 / cosine;
    return pdf;
}

// Index of the light whose share of the random words holds `word`. Counts its loop's iterations in `steps`.
uint pick_light(uint word, inout uint steps) {
    uint low = 0u;
    uint high = constants.light_count - 1u;
    while (low < high) {
        uint middle = (low + high) >> 1;
        if (word <= fetch_light_cdf_end(middle)) {
            high = middle;
        } else {
            low = middle + 1u;
        }
        steps++;
    }
    return low;
}

// Where a shadow ray towards a light at t = 1 ends, `height` being the distance of its origin from the light's plane. What
// lies in that plane (another triangle of the light, a wall behind it) must not count, and its t errs by the rounding of
// its place over that height: 2^-21 is 8 units in the last place of a scene of extent 1. Beyond a height of 2^-6 the ray
// ends 2^-15 of its length early all the same, by more than an emitter's key is lowered (EMITTER_NEARER).
float shadow_limit(float height) {
    precise float early = height > 9.5367431640625e-7 ? 4.76837158203125e-7 / height : 0.5;
    precise float limit = 1.0 - greater(early, 3.0517578125e-5);
    return guarded(GUARD_SHADOW_LIMIT) ? limit : 1.0;
}

struct LightSample {
    vec3 d;         // From the ray's origin to the point on the light (t = 1 is the light).
    float limit;    // What the shadow ray meets counts below this t.
    vec3 radiance;  // What it would add to the path, if nothing is in between; zero if it cannot.
    uint triangle;  // The light's triangle, in leaf order.
};

// A sample of `light` at the place `u` of the unit square, for the Lambert surface `it`, seen from the ray origin `o`.
LightSample sample_light(Interaction it, vec3 o, Light light, vec2 u) {
    vec2 b = square_to_triangle(u);
    precise vec3 point = light.v0 + b.x * (light.v1 - light.v0) + b.y * (light.v2 - light.v0);
    precise vec3 d = point - o;
    precise float distance2 = d.x * d.x + d.y * d.y + d.z * d.z;
    precise vec3 wi = d * inversesqrt(distance2);
    precise float cos_light = -(wi.x * light.ng.x + wi.y * light.ng.y + wi.z * light.ng.z);
    precise float cos_surface = wi.x * it.ns.x + wi.y * it.ns.y + wi.z * it.ns.z;
    // A point on the light itself gets nothing from it. A NaN anywhere else passes these comparisons and is counted.
    bool from_back = cos_light <= 0.0 && guarded(GUARD_LIGHT_COSINE);
    bool hidden = distance2 == 0.0 || from_back || cos_surface <= 0.0 || behind_geometry(it, wi);
    float pdf = light_pdf(light.pdf_area, distance2, cos_light);
    bool shared_out = LIGHTS == LIGHTS_MIS && guarded(GUARD_MIS_WEIGHT);
    float weight = shared_out ? power_heuristic(pdf, lambert_pdf(cos_surface)) : 1.0;
    precise vec3 radiance = light.emission * it.material.reflectance * (INV_PI * cos_surface * (weight / pdf));
    precise float height = -(d.x * light.ng.x + d.y * light.ng.y + d.z * light.ng.z);
    return LightSample(d, shadow_limit(height), hidden ? vec3(0.0) : radiance, light.triangle);
}

#endif
