// Scattering: the direction a path takes next, and what it is worth.
//
// Lobes: Lambert (two-sided), perfect mirror, smooth glass. wo and wi point away from the surface. Directions wi that the
// shading normal allows but that lie behind the geometry carry nothing for Lambert; mirror and glass take the geometric
// normal instead, so that they lose no energy.
#ifndef SHADING_BSDF_GLSL
#define SHADING_BSDF_GLSL

#include "effects.glsl"
#include "guards.glsl"
#include "sampling/random.glsl"
#include "sampling/warp.glsl"
#include "shading/fresnel.glsl"
#include "shading/interaction.glsl"

struct BsdfSample {
    vec3 wi;          // Unit direction.
    vec3 weight;      // Value times cosine over density.
    float pdf;        // Density per solid angle; 0 for a mirror or glass direction, which has none.
    float eta_scale;  // What the radiance scaling by refraction amounts to, inverted: for the roulette.
    bool transmitted; // Whether wi is on the other side than wo.
};

const BsdfSample NO_BSDF_SAMPLE = BsdfSample(vec3(0.0), vec3(0.0), 0.0, 1.0, false);

// Density per solid angle with which `sample_lambert` draws a direction of this cosine to the shading normal.
float lambert_pdf(float cosine) {
    return HEMISPHERE == HEMISPHERE_COSINE ? cosine * INV_PI : 0.5 * INV_PI;
}

// Whether `wi` leaves on the side that the geometry hides, whatever the shading normal says. Asked this way round, a NaN goes on
// to where it is counted.
bool behind_geometry(Interaction it, vec3 wi) {
    return guarded(GUARD_GEOMETRIC_SIDE) && dot(wi, it.ng) <= 0.0;
}

BsdfSample sample_lambert(Interaction it, vec2 u) {
    vec3 s, t;
    make_basis(it.ns, s, t);
    vec3 local = HEMISPHERE == HEMISPHERE_COSINE ? cosine_hemisphere(u) : uniform_hemisphere(u);
    precise vec3 world = s * local.x + t * local.y + it.ns * local.z;
    vec3 wi = normalize(world);
    if (local.z <= 0.0 || behind_geometry(it, wi)) {
        return NO_BSDF_SAMPLE;
    }
    // Cosine: albedo / pi * cos / (cos / pi). Uniform: albedo / pi * cos * 2 pi.
    precise float factor = HEMISPHERE == HEMISPHERE_COSINE ? 1.0 : 2.0 * local.z;
    return BsdfSample(wi, it.material.reflectance * factor, lambert_pdf(local.z), 1.0, false);
}

BsdfSample sample_mirror(Interaction it, vec3 wo) {
    vec3 wi = reflect_about(wo, it.ns);
    if (!(dot(wi, it.ng) > 0.0)) {
        wi = reflect_about(wo, it.ng);
    }
    return BsdfSample(wi, it.material.reflectance, 0.0, 1.0, false);
}

BsdfSample reflected_by_glass(Interaction it, vec3 n, vec3 wo) {
    vec3 wi = reflect_about(wo, n);
    if (!(dot(wi, it.ng) > 0.0)) {
        wi = reflect_about(wo, it.ng);
    }
    return BsdfSample(wi, vec3(1.0), 0.0, 1.0, false);
}

// Smooth glass: reflects with the probability of its reflectance, else refracts. Radiance is compressed by refraction
// into a denser medium: L / n^2 is what stays constant along a ray. A refraction about the shading normal that does not
// cross the surface is made about the geometric normal instead, or becomes a reflection where that reflects totally.
BsdfSample sample_glass(Interaction it, vec3 wo, float u) {
    float eta = it.front ? it.material.ior : 1.0 / it.material.ior;
    precise float cosine = min(wo.x * it.ns.x + wo.y * it.ns.y + wo.z * it.ns.z, 1.0);
    float cos_t;
    float reflectance = fresnel_dielectric(cosine, eta, cos_t);
    if (u < reflectance) {
        return reflected_by_glass(it, it.ns, wo);
    }
    vec3 wi = refract_through(wo, it.ns, eta, cosine, cos_t);
    if (!(dot(wi, it.ng) < 0.0)) {
        precise float geometric = min(wo.x * it.ng.x + wo.y * it.ng.y + wo.z * it.ng.z, 1.0);
        if (fresnel_dielectric(geometric, eta, cos_t) >= 1.0) {
            return reflected_by_glass(it, it.ng, wo);
        }
        wi = refract_through(wo, it.ng, eta, geometric, cos_t);
    }
    precise float scale = guarded(GUARD_RADIANCE_SCALE) ? 1.0 / (eta * eta) : 1.0;
    return BsdfSample(wi, vec3(scale), 0.0, eta * eta, true);
}

// The next direction. `direction` and `lobe` are random words of the bounce.
BsdfSample sample_bsdf(Interaction it, vec3 wo, uvec2 direction, uint lobe) {
    if (HAS_MIRROR != 0u && it.material.kind == MATERIAL_MIRROR) {
        return sample_mirror(it, wo);
    }
    if (HAS_GLASS != 0u && it.material.kind == MATERIAL_GLASS) {
        return sample_glass(it, wo, unit_float(lobe));
    }
    return sample_lambert(it, unit_float2(direction));
}

#endif
