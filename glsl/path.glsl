// The estimator: what happens to a path between two rays.
//
// L(camera ray) = emission at its first hit + sum over bounces of (light sample + emission that the BSDF sample meets), each
// pair combined by multiple importance sampling (Veach 1997). A path makes at most push.max_bounces scatterings; the
// estimate is unbiased for that number. Cost per bounce: one extension ray, at most one shadow ray.
#ifndef PATH_GLSL
#define PATH_GLSL

#include "bindings.glsl"
#include "camera.glsl"
#include "effects.glsl"
#include "path_state.glsl"
#include "sampling/random.glsl"
#include "shading/bsdf.glsl"
#include "shading/interaction.glsl"
#include "shading/light.glsl"

// A shadow ray ends at t = 1 on its light; blockers count up to here. Emitters' keys are lowered by 2^-16 and must not
// shadow each other where two of them meet in one plane.
const float SHADOW_LIMIT = 0.999969482421875; // 1 - 2^-15

// Iterations that shading may spend in loops: the search for a light among at most 2^32.
const uint SHADING_STEPS = 34u;

// Counts of one invocation, added to the counters when it ends.
struct Tally {
    uint steps, rays, paths, nodes, triangles;
};

RandomState random_state(uvec2 pixel, uint sample_index) {
    uint block = sample_index / BLOCK_SAMPLES;
    RandomState state;
    state.pixel = pixel.x | (pixel.y << 16);
    state.replicate = block % push.replicates;
    state.index = (block / push.replicates) * BLOCK_SAMPLES + sample_index % BLOCK_SAMPLES;
    state.sample_index = sample_index;
    return state;
}

void begin_extension(inout Path path, vec3 o, vec3 d, uint skip, inout Tally tally) {
    path.phase = PHASE_EXTENSION;
    path.o = o;
    path.d = d;
    path.skip = skip;
    path.skip_too = NO_INDEX;
    path.traversal = begin_traversal(no_hit(), o, d);
    tally.rays++;
}

void begin_shadow(inout Path path, vec3 o, LightSample light, uint skip, inout Tally tally) {
    path.phase = PHASE_SHADOW;
    path.o = o;
    path.d = light.d;
    path.skip = skip;
    path.skip_too = light.triangle;
    path.traversal = begin_traversal(no_hit_below(SHADOW_LIMIT), o, light.d);
    tally.rays++;
}

// Starts the next sample of the run.
void begin_sample(inout Path path, uvec2 pixel, inout Tally tally) {
    path.bounce = 0u;
    path.specular = true;
    path.extends = false;
    path.wi = vec3(0.0);
    path.pending = vec3(0.0);
    path.throughput = vec3(1.0);
    path.radiance = vec3(0.0);
    path.pdf = 0.0;
    path.eta_scale = 1.0;
    vec3 o, d;
    camera_ray(pixel, random_state(pixel, push.first_sample + path.samples_done), o, d);
    begin_extension(path, o, d, NO_INDEX, tally);
}

// Bits of the magnitude decide: a comparison of floats may be folded away by a driver that assumes there is no NaN.
bool is_counted(vec3 radiance) {
    uvec3 magnitude = floatBitsToUint(radiance) & 0x7fffffffu;
    uint largest = max(max(magnitude.x, magnitude.y), magnitude.z);
    if (largest > 0x7f800000u) {
        atomicAdd(counters[COUNTER_INVALID_NAN], 1u);
        return false;
    }
    if (largest > MAX_SAMPLE_RADIANCE_BITS) {
        atomicAdd(counters[COUNTER_INVALID_INFINITE], 1u);
        return false;
    }
    if (any(greaterThan(floatBitsToUint(radiance), uvec3(0x80000000u)))) {
        atomicAdd(counters[COUNTER_INVALID_NEGATIVE], 1u);
        return false;
    }
    return true;
}

// Ends the sample: its radiance goes to the block's sum, if it is a number; otherwise it is left out and counted.
void end_sample(inout Path path, inout uvec4 open_sum, inout Tally tally) {
    if (is_counted(path.radiance)) {
        precise vec3 sum = uintBitsToFloat(open_sum.rgb) + path.radiance;
        open_sum = uvec4(floatBitsToUint(sum), open_sum.a + 1u);
    }
    tally.paths++;
    path.samples_done++;
    path.phase = PHASE_CAMERA;
}

// Weight of emission that the extension ray meets.
float emission_weight(Path path, Interaction it, float cosine) {
    if (path.specular || LIGHTS == LIGHTS_BSDF) {
        return 1.0;
    }
    if (LIGHTS == LIGHTS_AREA || push.light_count == 0u) {
        return 0.0;
    }
    precise vec3 between = it.p - path.o;
    precise float distance2 = between.x * between.x + between.y * between.y + between.z * between.z;
    return power_heuristic(path.pdf, light_pdf(fetch_light(it.light).pdf_area, distance2, cosine));
}

// Russian roulette on the path's next ray: true where it survives, its throughput raised accordingly. The throughput is
// judged without the scaling that refraction brings (it is undone when the path leaves the glass).
bool survives(inout Path path, uint word) {
    float q;
    if (ROULETTE == ROULETTE_THROUGHPUT) {
        if (path.bounce < ROULETTE_FIRST_BOUNCE) {
            return true;
        }
        precise float largest = max(max(path.throughput.r, path.throughput.g), path.throughput.b) * path.eta_scale;
        q = clamp(largest, 0.05, 0.95);
    } else if (ROULETTE == ROULETTE_FIXED) {
        q = push.roulette_p;
    } else {
        return true;
    }
    if (unit_float(word) >= q) {
        return false;
    }
    precise vec3 raised = path.throughput / q;
    path.throughput = raised;
    return true;
}

// A finished extension ray: emission, light sample, next direction.
void shade(inout Path path, uvec2 pixel, inout uvec4 open_sum, inout Tally tally) {
    Hit hit = path.traversal.best;
    if (hit.triangle == NO_INDEX) {
        if (HAS_SKY != 0u) {
            precise vec3 sum = path.radiance + path.throughput * vec3(push.sky_r, push.sky_g, push.sky_b);
            path.radiance = sum;
        }
        end_sample(path, open_sum, tally);
        return;
    }
    vec3 wo = normalize(-path.d);
    Interaction it = make_interaction(hit, wo);
    if (HAS_EMITTERS != 0u && it.light != NO_INDEX && it.front) {
        float weight = emission_weight(path, it, dot(it.ng, wo));
        precise vec3 sum = path.radiance + path.throughput * (it.material.emission * weight);
        path.radiance = sum;
    }
    if (path.bounce >= push.max_bounces) {
        end_sample(path, open_sum, tally);
        return;
    }
    RandomState random = random_state(pixel, push.first_sample + path.samples_done);
    uvec4 directions = random_set(random, SET_DIRECTIONS + 2u * path.bounce);
    uvec4 choices = random_set(random, SET_CHOICES + 2u * path.bounce);
    path.bounce++;

    BsdfSample sampled = sample_bsdf(it, wo, directions, choices);
    vec3 o = spawn_origin(it, sampled.transmitted ? -it.ng : it.ng);
    bool lambert = it.material.kind == MATERIAL_LAMBERT;
    LightSample light = LightSample(vec3(0.0), vec3(0.0), NO_INDEX);
    if (HAS_EMITTERS != 0u && LIGHTS != LIGHTS_BSDF && lambert && push.light_count > 0u) {
        light = sample_light(it, o, directions, choices, tally.steps);
        precise vec3 pending = path.throughput * light.radiance;
        path.pending = pending;
    }
    precise vec3 throughput = path.throughput * sampled.weight;
    path.throughput = throughput;
    path.eta_scale *= sampled.eta_scale;
    path.pdf = sampled.pdf;
    path.specular = !lambert;
    path.wi = sampled.wi;
    bool carries = throughput.r > 0.0 || throughput.g > 0.0 || throughput.b > 0.0;
    path.extends = carries && survives(path, choices.z);

    if (light.radiance.r > 0.0 || light.radiance.g > 0.0 || light.radiance.b > 0.0) {
        begin_shadow(path, o, light, hit.triangle, tally);
    } else if (path.extends) {
        begin_extension(path, o, path.wi, hit.triangle, tally);
    } else {
        end_sample(path, open_sum, tally);
    }
}

// A finished shadow ray: its light arrives if nothing blocked it; the waiting extension ray starts from the same place.
void finish_shadow(inout Path path, inout uvec4 open_sum, inout Tally tally) {
    if (path.traversal.best.triangle == NO_INDEX) {
        precise vec3 sum = path.radiance + path.pending;
        path.radiance = sum;
    }
    if (path.extends) {
        begin_extension(path, path.o, path.wi, path.skip, tally);
    } else {
        end_sample(path, open_sum, tally);
    }
}

#endif
