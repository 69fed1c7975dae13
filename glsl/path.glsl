// The estimator: what happens to a path between two rays.
//
// L(camera ray) = emission at its first hit + sum over bounces of (light sample + emission that the BSDF sample meets), each
// pair combined by multiple importance sampling (Veach 1997). A path makes at most constants.max_bounces scatterings; the
// estimate is unbiased for that number. Cost per bounce: one extension ray, at most one shadow ray.
//
// `advance` is written so that each part stands once: a device that runs its lanes in step (lavapipe above all) pays for
// every branch, taken or not, so a second copy of any of them would cost as much as the first.
#ifndef PATH_GLSL
#define PATH_GLSL

#include "bindings.glsl"
#include "camera.glsl"
#include "effects.glsl"
#include "path_state.glsl"
#include "run.glsl"
#include "sampling/random.glsl"
#include "shading/bsdf.glsl"
#include "shading/interaction.glsl"
#include "shading/light.glsl"
#include "shading/light_tree.glsl"

// Counts of one invocation, added to the counters when it ends.
struct Tally {
    uint steps, rays, paths, nodes, triangles;
    uint invalid; // Of the sample that was left out, 1 + kind + INVALID_KINDS * cause; 0: none was.
};

const uint INFINITY_BITS = 0x7f800000u;

// Whether a radiance or throughput is not a number, larger than the float of the bits `limit`, or negative (as unsigned
// words those are above all others; no stage makes a negative zero). By bits: a driver may fold away a comparison with NaN.
bool is_invalid(vec3 v, uint limit) {
    uvec3 words = floatBitsToUint(v);
    return max(max(words.x, words.y), words.z) > limit;
}

// Notes the first stage of a sample that made an invalid number.
void note_cause(inout Path path, bool invalid, uint cause) {
    path.cause = invalid && path.cause == CAUSE_SUM ? cause : path.cause;
}

// The ray that goes on from a surface, and the one that looks for its light sample.
struct Departure {
    vec3 o;              // Origin of both.
    uint triangle;       // The triangle that they leave, in leaf order.
    vec3 shadow_d;       // Direction of the shadow ray; it ends at t = 1.
    float shadow_limit;  // What it meets counts below this t.
    uint shadow_triangle; // The light's triangle, in leaf order.
    bool casts;          // Whether there is a shadow ray.
};

// Weight of emission that the extension ray meets under the cosine `cosine`.
// `chosen` is the probability with which its light tree, if there is one, would have chosen that light for where the ray started.
float emission_weight(Path path, Interaction it, float cosine, float chosen) {
    if (path.specular || LIGHTS == LIGHTS_BSDF) {
        return 1.0;
    }
    if (LIGHTS == LIGHTS_AREA) {
        return 0.0;
    }
    precise vec3 between = it.p - path.o;
    precise float distance2 = between.x * between.x + between.y * between.y + between.z * between.z;
    precise float pdf_area = it.pdf_area * (LIGHT_PICK == LIGHT_PICK_TREE ? chosen : 1.0);
    return power_heuristic(path.pdf, light_pdf(pdf_area, distance2, cosine));
}

// Survival probability per throughput: a path is at stake once its throughput is below a fifth. Of 1 to 8, 3 to 5 gave the
// least error a ray (docs/performance.md); the larger one makes fewer fireflies.
const float ROULETTE_GAIN = 5.0;

// Russian roulette on the path's next ray: true where it survives, its throughput raised accordingly. The throughput is
// judged without the scaling that refraction brings (it is undone when the path leaves the glass).
bool survives(inout Path path, uint word) {
    float q = 1.0;
    if (ROULETTE == ROULETTE_THROUGHPUT) {
        float scale = guarded(GUARD_ROULETTE_SCALE) ? path.eta_scale : 1.0;
        precise float largest = greater(greater(path.throughput.r, path.throughput.g), path.throughput.b) * scale;
        q = guarded(GUARD_ROULETTE_RANGE) ? lesser(greater(ROULETTE_GAIN * largest, 0.05), 1.0) : ROULETTE_GAIN * largest;
    } else if (ROULETTE == ROULETTE_FIXED) {
        q = constants.roulette_p;
    } else {
        return true;
    }
    if (guarded(GUARD_ROULETTE_WEIGHT)) {
        precise vec3 raised = path.throughput / q;
        path.throughput = raised;
    }
    // Asked this way round, a NaN goes on to where it is counted.
    return !(unit_float(word) >= q);
}

// A finished extension ray: emission, light sample, next direction.
Departure shade(inout Path path, Stream stream, inout Tally tally) {
    Departure departure = Departure(vec3(0.0), NO_INDEX, vec3(0.0), 1.0, NO_INDEX, false);
    path.extends = false;
    Hit hit = path.traversal.best;
    if (hit.triangle == NO_INDEX) {
        if (!is_traceable(path.o, path.d)) {
            // Not a miss: a ray that is no ray. Its sample is left out, and counted.
            path.radiance = vec3(uintBitsToFloat(0x7fc00000u));
            note_cause(path, path.bounce == 0u, CAUSE_CAMERA);
        } else if (HAS_SKY != 0u) {
            precise vec3 sum = path.radiance + path.throughput * vec3(constants.sky_r, constants.sky_g, constants.sky_b);
            path.radiance = sum;
            note_cause(path, is_invalid(sum, MAX_SAMPLE_RADIANCE_BITS), CAUSE_SKY);
        }
        return departure;
    }
    vec3 wo = normalize(-path.d);
    Interaction it = make_interaction(hit, wo);
    bool lambert = it.material.kind == MATERIAL_LAMBERT;
    bool emits = HAS_EMITTERS != 0u && it.pdf_area > 0.0 && it.front;
    bool lit = HAS_EMITTERS != 0u && LIGHTS != LIGHTS_BSDF && lambert && constants.light_count > 0u;
    LightAnswer tree = LightAnswer(0u, LightChoice(0u, 0u, 1u));
    if (LIGHT_PICK == LIGHT_PICK_TREE) {
        LightQuestion question;
        question.met = emits && LIGHTS == LIGHTS_MIS && !path.specular;
        question.trail = it.light_trail;
        question.from = LitPoint(path.o, path.normal);
        question.picks = lit && path.bounce < constants.max_bounces;
        question.word = random_pair(stream, path.samples_done, pair_number(path.bounce + 1u, PAIR_LIGHT_POINT)).x;
        question.lit = LitPoint(spawn_origin(it, it.ng), encode_octahedral(it.ns));
        tree = ask_light_tree(question, tally.steps);
        path.normal = question.lit.normal;
    }
    if (emits) {
        float weight = emission_weight(path, it, dot(it.ng, wo), light_tree_probability(tree.met_words));
        precise vec3 sum = path.radiance + path.throughput * (it.material.emission * weight);
        path.radiance = sum;
        note_cause(path, is_invalid(sum, MAX_SAMPLE_RADIANCE_BITS), CAUSE_EMISSION);
    }
    if (path.bounce >= constants.max_bounces) {
        return departure;
    }
    path.bounce++;
    uvec2 direction = random_pair(stream, path.samples_done, pair_number(path.bounce, PAIR_DIRECTION));
    uvec2 choices = random_pair(stream, path.samples_done, pair_number(path.bounce, PAIR_CHOICES));

    BsdfSample sampled = sample_bsdf(it, wo, direction, choices.x);
    departure.o = spawn_origin(it, sampled.transmitted ? -it.ng : it.ng);
    departure.triangle = hit.triangle;
    if (lit) {
        uvec2 point = random_pair(stream, path.samples_done, pair_number(path.bounce, PAIR_LIGHT_POINT));
        Light light;
        vec2 place = vec2(0.0, unit_float(point.y));
        if (LIGHT_PICK == LIGHT_PICK_TREE) {
            uvec2 digits = random_pair(stream, path.samples_done, pair_number(path.bounce, PAIR_LIGHT_DIGITS));
            light = fetch_light(tree.choice.light);
            precise float chosen = light.pdf_area * light_tree_probability(tree.choice.words);
            light.pdf_area = chosen;
            place.x = place_in_words(tree.choice, unit_float(digits.x));
        } else {
            light = fetch_light(pick_light(point.x, tally.steps));
            place.x = place_in_share(light.cdf_begin, light.cdf_scale, point.x);
        }
        LightSample arriving = sample_light(it, departure.o, light, place);
        precise vec3 pending = path.throughput * arriving.radiance;
        path.pending = pending;
        note_cause(path, is_invalid(pending, MAX_SAMPLE_RADIANCE_BITS), CAUSE_LIGHT);
        // A NaN casts its ray too: it shall reach the sample's sum, where it is counted, not vanish here.
        departure.casts = pending.r != 0.0 || pending.g != 0.0 || pending.b != 0.0;
        departure.shadow_d = arriving.d;
        departure.shadow_limit = arriving.limit;
        departure.shadow_triangle = arriving.triangle;
    }
    precise vec3 throughput = path.throughput * sampled.weight;
    path.throughput = throughput;
    path.eta_scale *= sampled.eta_scale;
    path.pdf = sampled.pdf;
    path.specular = !lambert;
    path.wi = sampled.wi;
    uint lobe_cause = lambert ? CAUSE_LAMBERT : (it.material.kind == MATERIAL_MIRROR ? CAUSE_MIRROR : CAUSE_GLASS);
    bool lobe_fails = is_invalid(throughput, INFINITY_BITS - 1u) || is_invalid(abs(sampled.wi), INFINITY_BITS - 1u);
    note_cause(path, lobe_fails, lobe_cause);
    bool carries = throughput.r != 0.0 || throughput.g != 0.0 || throughput.b != 0.0;
    path.extends = survives(path, choices.y) && carries;
    return departure;
}

// A pixel's open sum with one sample more.
uvec4 add_sample(uvec4 open_sum, vec3 radiance) {
    precise vec3 sum = uintBitsToFloat(open_sum.rgb) + radiance;
    return uvec4(floatBitsToUint(sum), open_sum.a + 1u);
}

// Ends the sample: its radiance enters the block's sum if it is a number; otherwise it is left out and counted. Bits of the
// magnitude decide: a comparison of floats may be folded away by a driver that assumes there is no NaN.
void end_sample(inout Path path, inout uvec4 open_sum, inout Tally tally) {
    uvec3 words = floatBitsToUint(path.radiance);
    uvec3 magnitude = words & 0x7fffffffu;
    uint largest = max(max(magnitude.x, magnitude.y), magnitude.z);
    bool nan = largest > 0x7f800000u;
    bool infinite = !nan && largest > MAX_SAMPLE_RADIANCE_BITS;
    bool negative = !nan && !infinite && max(max(words.x, words.y), words.z) > 0x80000000u;
    if ((nan || infinite || negative) && guarded(GUARD_INVALID_SAMPLES)) {
        uint kind = nan ? INVALID_NAN : (infinite ? INVALID_INFINITE : INVALID_NEGATIVE);
        tally.invalid = 1u + kind + INVALID_KINDS * path.cause;
    } else {
        open_sum = add_sample(open_sum, path.radiance);
    }
    tally.paths++;
    path.samples_done++;
}

// Takes the path from a finished ray (or from nothing) to its next one, or to the end of the run.
void advance(inout Path path, Camera camera, Stream stream, uvec2 pixel, inout uvec4 open_sum, inout Tally tally) {
    Departure departure = Departure(path.o, path.skip, vec3(0.0), 1.0, NO_INDEX, false);
    if (path.phase == PHASE_SHADOW && path.traversal.best.triangle == NO_INDEX) {
        precise vec3 sum = path.radiance + path.pending;
        path.radiance = sum;
    }
    if (path.phase == PHASE_EXTENSION) {
        departure = shade(path, stream, tally);
    }

    vec3 d = path.wi;
    uint next = PHASE_EXTENSION;
    if (departure.casts) {
        next = PHASE_SHADOW;
        d = departure.shadow_d;
    } else if (!path.extends) {
        if (path.phase != PHASE_CAMERA) {
            end_sample(path, open_sum, tally);
        }
        if (path.samples_done == run.samples) {
            path.phase = PHASE_FINISHED;
            return;
        }
        uvec2 u = random_pair(stream, path.samples_done, pair_number(0u, PAIR_FILM));
        d = camera_direction(camera, pixel, unit_float2(u));
        departure = Departure(camera.origin, NO_INDEX, vec3(0.0), 1.0, NO_INDEX, false);
        path.bounce = 0u;
        path.specular = true;
        path.throughput = vec3(1.0);
        path.radiance = vec3(0.0);
        path.pdf = 0.0;
        path.eta_scale = 1.0;
        path.cause = CAUSE_SUM;
    }
    path.phase = next;
    path.o = departure.o;
    path.d = d;
    path.skip = departure.triangle;
    path.skip_too = departure.shadow_triangle;
    Hit none = no_hit();
    if (next == PHASE_SHADOW) {
        none = no_hit_below(departure.shadow_limit);
    } else {
        path.skip_too = NO_INDEX;
    }
    path.traversal = begin_traversal(none, path.o, path.d);
    tally.rays++;
}

#endif
