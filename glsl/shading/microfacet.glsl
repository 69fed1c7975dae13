// Trowbridge and Reitz's microfacets (GGX) with Smith's masking: distribution, reflection, densities and samples of a lobe
// that absorbs nothing.
//
// Directions are unit vectors in the frame of the shading normal, z along it, and point away from the surface; `alpha` > 0
// is the roughness of Walter et al. (2007). A conductor is this lobe times its Fresnel reflectance at dot(wo, h).
// Everything is divided by its cosines on paper, so that nothing is 0 / 0 at grazing angles.
#ifndef SHADING_MICROFACET_GLSL
#define SHADING_MICROFACET_GLSL

#include "guards.glsl"
#include "sampling/warp.glsl"

struct MicrofacetSample {
    vec3 wi;      // Unit direction; it may lie below the surface, where the weight is 0.
    float weight; // Value times cosine over density, within [0, 1].
    float pdf;    // Density per solid angle.
};

// Density of microfacet normals `h` per solid angle and projected area. A sum of squares: cos^2 (alpha^2 - 1) + 1 would be
// a difference of nearly equal numbers wherever alpha is small.
float ggx_distribution(vec3 h, float alpha) {
    precise vec2 slope = h.xy / alpha;
    precise float sum = slope.x * slope.x + slope.y * slope.y + h.z * h.z;
    if (!guarded(GUARD_GGX_VECTOR_FORM)) {
        precise float difference = h.z * h.z * (alpha * alpha - 1.0) + 1.0;
        sum = difference / (alpha * alpha);
    }
    precise float density = INV_PI / (alpha * sum * (alpha * sum));
    return density;
}

// Length of `w` with its tangential part scaled by alpha: Smith's G1(w) is 2 w.z / (w.z + this).
float ggx_stretched(vec3 w, float alpha) {
    precise vec2 tangential = w.xy * alpha;
    precise float stretched = sqrt(tangential.x * tangential.x + tangential.y * tangential.y + w.z * w.z);
    return stretched;
}

// Height-correlated masking of both directions over 4 wo.z wi.z (Heitz 2014).
float ggx_visibility(vec3 wo, vec3 wi, float alpha) {
    precise float sum = wo.z * ggx_stretched(wi, alpha) + wi.z * ggx_stretched(wo, alpha);
    precise float visibility = 0.5 / sum;
    return visibility;
}

// Value of the lobe times the cosine of wi.
float ggx_value_cosine(vec3 wo, vec3 wi, float alpha) {
    if (!(wo.z > 0.0) || !(wi.z > 0.0)) {
        return 0.0;
    }
    precise vec3 h = wo + wi;
    precise float value = ggx_distribution(normalize(h), alpha) * ggx_visibility(wo, wi, alpha) * wi.z;
    return value;
}

// Density per solid angle with which `sample_ggx` draws the reflection of wo about `h`: G1(wo) D(h) / (4 wo.z).
float ggx_pdf_of_normal(vec3 wo, vec3 h, float alpha) {
    precise float pdf = 0.5 * ggx_distribution(h, alpha) / (wo.z + ggx_stretched(wo, alpha));
    return pdf;
}

// The same for the direction wi.
float ggx_pdf(vec3 wo, vec3 wi, float alpha) {
    precise vec3 h = wo + wi;
    return ggx_pdf_of_normal(wo, normalize(h), alpha);
}

// Masking of both directions over that of wo alone: the weight of a sample.
float ggx_weight(vec3 wo, vec3 wi, float alpha) {
    float so = ggx_stretched(wo, alpha);
    float si = ggx_stretched(wi, alpha);
    precise float weight = wi.z * (wo.z + so) / (wo.z * si + wi.z * so);
    if (!guarded(GUARD_GGX_CANCELLED_COSINES)) {
        precise float both = 2.0 * wo.z * wi.z / (wo.z * si + wi.z * so);
        precise float one = 2.0 * wo.z / (wo.z + so);
        precise float value = both / (4.0 * wo.z * wi.z);
        weight = value * wi.z / (one / (4.0 * wo.z));
    }
    return weight;
}

// A microfacet normal that wo sees, at the place `u` of the unit square: density G1(wo) D(h) dot(wo, h) / wo.z. Heitz,
// "Sampling the GGX Distribution of Visible Normals" (JCGT 2018).
vec3 sample_ggx_normal(vec3 wo, float alpha, vec2 u) {
    precise vec3 stretched = vec3(wo.xy * alpha, wo.z);
    vec3 v = normalize(stretched);
    precise float sine2 = v.x * v.x + v.y * v.y;
    vec3 t1 = sine2 > 0.0 ? vec3(-v.y, v.x, 0.0) * inversesqrt(sine2) : vec3(1.0, 0.0, 0.0);
    vec3 t2 = cross(v, t1);
    vec2 disc = square_to_disc(u);
    precise float chord = sqrt(max((1.0 - disc.x) * (1.0 + disc.x), 0.0));
    precise float s = 0.5 * (1.0 + v.z);
    precise float y = (1.0 - s) * chord + s * disc.y;
    precise float z = sqrt(max(1.0 - disc.x * disc.x - y * y, 0.0));
    precise vec3 n = disc.x * t1 + y * t2 + z * v;
    return normalize(vec3(alpha * n.xy, max(n.z, 0.0)));
}

// A direction that wo (wo.z > 0) is reflected to.
MicrofacetSample sample_ggx(vec3 wo, float alpha, vec2 u) {
    vec3 h = sample_ggx_normal(wo, alpha, u);
    precise float cosine = wo.x * h.x + wo.y * h.y + wo.z * h.z;
    precise vec3 reflected = h * (2.0 * cosine) - wo;
    vec3 wi = normalize(reflected);
    // Asked this way round, a NaN is no direction.
    float weight = wi.z > 0.0 ? ggx_weight(wo, wi, alpha) : 0.0;
    return MicrofacetSample(wi, weight, ggx_pdf_of_normal(wo, h, alpha));
}

#endif
