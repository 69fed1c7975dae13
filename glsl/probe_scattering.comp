// Probe for tests: microfacets, solid angles, refraction and light samples, by the renderer's own functions.
//
// In: push.flags the function (below), push.samples how many calls, three texels of arguments a call. Out: two texels a call.
// Directions are in the frame of the normal, z along it.
//   0  ggx_distribution: [h, alpha]                     -> [density]
//   1  sample_ggx: [wo, alpha] [u, v]                   -> [wi, weight] [pdf, value cosine of wi, pdf of wi]
//   2  WEIGHTS weights of sample_ggx: [wo, alpha] [salt] -> [mean, smallest, largest, how many are outside [0, 1 + 1e-5]]
//   3  solid_angle: [v0, p.x] [v1, p.y] [v2, p.z]       -> [solid angle]
//   4  arc_tangent: [y, x]                              -> [angle]
//   5  fresnel_dielectric, refract_through: [wo, eta]   -> [wi, reflectance] [cos_t]
//   6  sample_glass: [wo, ior] [u, front]               -> [wi, weight] [eta_scale, transmitted]
//   7  sample_light: [o, light] [u, v, albedo] [normal] -> [radiance, as a BSDF sample, squared distance]
//   8  disc_point: [radius, cosine, sine]               -> [point]
//   9  ggx_value_cosine, ggx_pdf: [wo, alpha] [wi]      -> [value, value with wo and wi exchanged, pdf of wi]
//  10  reflect_about of wo, b.x times, about normals of its own -> [wi, |wi|^2]
//  11  ask_light_tree for a light: [p, word] [n]       -> words: [light, place, words, steps]
//  12  ask_light_tree of a light: [p, trail] [n]       -> words: [words, steps]
//  13  both at once, `trail` from the first point: [p, word] [n, trail] [p, .] -> words: [light, place, words, words of trail]
//  14  place_in_words: [digits, place, words]          -> [place]
#version 460
#extension GL_GOOGLE_include_directive : require

#include "bindings.glsl"
#include "path.glsl"
#include "sampling/random.glsl"
#include "sampling/solid_angle.glsl"
#include "sampling/warp.glsl"
#include "shading/fresnel.glsl"
#include "shading/light.glsl"
#include "shading/light_tree.glsl"
#include "shading/microfacet.glsl"

layout(local_size_x = PROBE_WORKGROUP) in;

const uint WEIGHTS = 64u;

Interaction flat_interaction(vec3 p, vec3 n, bool front, Material material) {
    Interaction it;
    it.p = p;
    it.inner = p;
    it.p_error = vec3(0.0);
    it.ng = n;
    it.ns = n;
    it.front = front;
    it.pdf_area = 0.0;
    it.light_trail = 0u;
    it.material = material;
    return it;
}

// Mean, smallest, largest, and how many are not numbers of the range: a NaN fails every comparison.
vec4 ggx_weights(vec3 wo, float alpha, uint call, uint salt) {
    vec4 result = vec4(0.0, 2.0, -1.0, 0.0);
    for (uint i = 0u; i < WEIGHTS; i++) {
        MicrofacetSample drawn = sample_ggx(wo, alpha, unit_float2(pcg4d(uvec4(call, i, salt, 0x51ed270bu)).xy));
        result.x += drawn.weight / float(WEIGHTS);
        result.y = drawn.weight < result.y ? drawn.weight : result.y;
        result.z = drawn.weight > result.z ? drawn.weight : result.z;
        result.w += drawn.weight >= 0.0 && drawn.weight <= 1.00001 ? 0.0 : 1.0;
    }
    return result;
}

// What the same point on the light is worth, found by BSDF sampling.
float bsdf_light_sample(Interaction it, Light light, vec3 d) {
    precise float distance2 = d.x * d.x + d.y * d.y + d.z * d.z;
    precise vec3 wi = d * inversesqrt(distance2);
    float cos_light = -dot(wi, light.ng);
    float cos_surface = dot(wi, it.ns);
    if (!(cos_light > 0.0) || !(cos_surface > 0.0)) {
        return 0.0;
    }
    float weight = power_heuristic(lambert_pdf(cos_surface), light_pdf(light.pdf_area, distance2, cos_light));
    return it.material.reflectance.r * light.emission.r * weight;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.samples) {
        return;
    }
    uvec4 words = probe_input[3u * index];
    uvec4 second = probe_input[3u * index + 1u];
    uvec4 third = probe_input[3u * index + 2u];
    vec4 a = uintBitsToFloat(words);
    vec4 b = uintBitsToFloat(second);
    vec4 c = uintBitsToFloat(third);
    vec4 result = vec4(0.0);
    vec4 more = vec4(0.0);
    if (push.flags == 0u) {
        result.x = ggx_distribution(a.xyz, a.w);
    } else if (push.flags == 1u) {
        MicrofacetSample drawn = sample_ggx(a.xyz, a.w, b.xy);
        result = vec4(drawn.wi, drawn.weight);
        more = vec4(drawn.pdf, ggx_value_cosine(a.xyz, drawn.wi, a.w), ggx_pdf(a.xyz, drawn.wi, a.w), 0.0);
    } else if (push.flags == 2u) {
        result = ggx_weights(a.xyz, a.w, index, second.x);
    } else if (push.flags == 3u) {
        result.x = solid_angle(vec3(a.w, b.w, c.w), a.xyz, b.xyz, c.xyz);
    } else if (push.flags == 4u) {
        result.x = arc_tangent(a.x, a.y);
    } else if (push.flags == 5u) {
        float cos_t;
        result.w = fresnel_dielectric(a.z, a.w, cos_t);
        result.xyz = refract_through(a.xyz, vec3(0.0, 0.0, 1.0), a.w, a.z, cos_t);
        more.x = cos_t;
    } else if (push.flags == 6u) {
        Material glass = Material(vec3(1.0), MATERIAL_GLASS, vec3(0.0), a.w);
        BsdfSample drawn = sample_glass(flat_interaction(vec3(0.0), vec3(0.0, 0.0, 1.0), b.y > 0.0, glass), a.xyz, b.x);
        result = vec4(drawn.wi, drawn.weight.r);
        more = vec4(drawn.eta_scale, drawn.transmitted ? 1.0 : 0.0, 0.0, 0.0);
    } else if (push.flags == 7u) {
        Material grey = Material(vec3(b.z), MATERIAL_LAMBERT, vec3(0.0), 1.0);
        Interaction it = flat_interaction(a.xyz, c.xyz, true, grey);
        Light light = fetch_light(words.w);
        LightSample arriving = sample_light(it, a.xyz, light, b.xy);
        result = vec4(arriving.radiance.r, bsdf_light_sample(it, light, arriving.d), dot(arriving.d, arriving.d), 0.0);
    } else if (push.flags == 8u) {
        result.xy = disc_point(a.x, a.yz);
    } else if (push.flags == 9u) {
        // Over the cosines: the value alone is what reciprocity speaks of.
        result = vec4(ggx_value_cosine(a.xyz, b.xyz, a.w) / b.z, ggx_value_cosine(b.xyz, a.xyz, a.w) / a.z,
                      ggx_pdf(a.xyz, b.xyz, a.w), 0.0);
    } else if (push.flags == 10u) {
        vec3 w = a.xyz;
        for (uint i = 0u; i < uint(b.x); i++) {
            w = reflect_about(w, uniform_hemisphere(unit_float2(pcg4d(uvec4(index, i, 76u, 0u)).xy)));
        }
        precise float length2 = w.x * w.x + w.y * w.y + w.z * w.z;
        result = vec4(w, length2);
    }
    if (push.flags == 11u) {
        uint steps = 0u;
        LitPoint lit = LitPoint(a.xyz, encode_octahedral(b.xyz));
        LightChoice choice = ask_light_tree(LightQuestion(false, 0u, lit, true, words.w, lit), steps).choice;
        probe_output[2u * index] = uvec4(choice.light, choice.place, choice.words, steps);
        return;
    } else if (push.flags == 12u) {
        uint steps = 0u;
        LitPoint from = LitPoint(a.xyz, encode_octahedral(b.xyz));
        LightAnswer answer = ask_light_tree(LightQuestion(true, words.w, from, false, 0u, from), steps);
        probe_output[2u * index] = uvec4(answer.met_words, steps, 0u, 0u);
        return;
    } else if (push.flags == 13u) {
        uint steps = 0u;
        LitPoint from = LitPoint(a.xyz, encode_octahedral(b.xyz));
        LitPoint lit = LitPoint(c.xyz, encode_octahedral(b.xyz));
        LightAnswer answer = ask_light_tree(LightQuestion(true, second.w, from, true, words.w, lit), steps);
        probe_output[2u * index] = uvec4(answer.choice.light, answer.choice.place, answer.choice.words, answer.met_words);
        return;
    } else if (push.flags == 14u) {
        result.x = place_in_words(LightChoice(0u, words.y, words.z), a.x);
    }
    probe_output[2u * index] = floatBitsToUint(result);
    probe_output[2u * index + 1u] = floatBitsToUint(more);
}
