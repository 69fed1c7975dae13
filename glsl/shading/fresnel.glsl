// Fresnel reflectance and refraction of a smooth dielectric.
#ifndef SHADING_FRESNEL_GLSL
#define SHADING_FRESNEL_GLSL

#include "guards.glsl"

// Unpolarised reflectance at the cosine `cos_i` > 0 of incidence; `eta` is the index of the far side over the near side's.
// `cos_t` is the cosine of refraction, 0 at total internal reflection, where the reflectance is exactly 1. The product
// (1 - c)(1 + c) keeps the digits that 1 - c^2 loses near the critical angle. (Pharr, Jakob, Humphreys, PBR 4, 9.3.5.)
float fresnel_dielectric(float cos_i, float eta, out float cos_t) {
    precise float sin2_i = guarded(GUARD_FRESNEL_PRODUCT) ? (1.0 - cos_i) * (1.0 + cos_i) : 1.0 - cos_i * cos_i;
    precise float sin2_t = sin2_i / (eta * eta);
    cos_t = 0.0;
    if (guarded(GUARD_TOTAL_REFLECTION) && sin2_t >= 1.0) {
        return 1.0;
    }
    precise float refracted = sqrt(1.0 - sin2_t);
    precise float parallel = (eta * cos_i - refracted) / (eta * cos_i + refracted);
    precise float perpendicular = (cos_i - eta * refracted) / (cos_i + eta * refracted);
    precise float reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular);
    cos_t = refracted;
    return reflectance;
}

// Mirror direction of `wo` about `n`.
vec3 reflect_about(vec3 wo, vec3 n) {
    precise float cosine = wo.x * n.x + wo.y * n.y + wo.z * n.z;
    precise vec3 wi = n * (2.0 * cosine) - wo;
    return normalize(wi);
}

// Refraction of `wo` through the interface with normal `n` on its side; cosines from `fresnel_dielectric`.
vec3 refract_through(vec3 wo, vec3 n, float eta, float cos_i, float cos_t) {
    precise vec3 wi = n * (cos_i / eta - cos_t) - wo / eta;
    return normalize(wi);
}

#endif
