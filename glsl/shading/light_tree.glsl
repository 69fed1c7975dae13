// Many lights: one is chosen by what it may contribute to the point that is lit (Conty Estevez and Kulla, "Importance Sampling
// of Many Lights with Adaptive Tree Splitting", 2018; Pharr, Jakob and Humphreys, PBRT 4th ed., 12.6.3).
//
// A node shares its words out among its clusters by their importance; a light's probability is the number of words that reach
// it, over all. Words are whole numbers, and each light below a node keeps at least one: what is drawn and what is divided by
// cannot differ, and no light is without a chance, whatever the estimate of its importance says.
#ifndef SHADING_LIGHT_TREE_GLSL
#define SHADING_LIGHT_TREE_GLSL

#include "guards.glsl"
#include "records/light_node.glsl"
#include "trace/ray.glsl"

// Share of a node's words that goes by how many lights a cluster has: a bright cluster that cannot be seen from the point shall
// not take everything.
const float EVEN_SHARE = 0.00390625;

// cos(max(a - b, 0)) and sin(max(a - b, 0)), of sines and cosines of the angles a and b in [0, pi].
vec2 angle_less(vec2 a, vec2 b) {
    precise float cosine = a.x * b.x + a.y * b.y;
    precise float sine = a.y * b.x - a.x * b.y;
    return a.x > b.x ? vec2(1.0, 0.0) : vec2(cosine, sine);
}

// The sine of a cosine, as a pair of both.
vec2 with_sine(float cosine) {
    precise float sine2 = (1.0 - cosine) * (1.0 + cosine);
    return vec2(cosine, sqrt(sine2 > 0.0 ? sine2 : 0.0));
}

// Bound on what the cluster's lights give the point p of a surface with the normal n, up to a constant: power over squared
// distance, times the largest cosines at light and surface that any of its lights may have. 0 where all of them show p their
// backs, or are behind the surface.
float cluster_importance(LightCluster cluster, vec3 p, vec3 n) {
    precise vec3 d = p - cluster.centre;
    precise float distance2 = d.x * d.x + d.y * d.y + d.z * d.z;
    precise float radius2 = cluster.radius * cluster.radius;
    float clamped2 = guarded(GUARD_CLUSTER_DISTANCE) ? greater(distance2, radius2) : distance2;
    float divisor = greater(clamped2, 1.0e-24);
    precise float strength = cluster.power / divisor;
    if (distance2 <= radius2) {
        return strength;
    }
    precise vec3 w = d * inversesqrt(divisor);
    precise float spread2 = radius2 / divisor;
    vec2 spread = vec2(sqrt(1.0 - spread2), sqrt(spread2)); // half the angle that the ball subtends
    if (!guarded(GUARD_CLUSTER_SPREAD)) {
        spread = vec2(1.0, 0.0);
    }
    precise float cos_w = w.x * cluster.axis.x + w.y * cluster.axis.y + w.z * cluster.axis.z;
    precise float cos_i = -(w.x * n.x + w.y * n.y + w.z * n.z);
    vec2 emitted = angle_less(angle_less(with_sine(cos_w), with_sine(cluster.cos_o)), spread);
    vec2 received = angle_less(with_sine(cos_i), spread);
    precise float importance = strength * emitted.x * received.x;
    return emitted.x > 0.0 && received.x > 0.0 ? importance : 0.0;
}

// A node's clusters as the choice among them needs them.
struct LightBranches {
    uvec4 words;    // How many words each gets.
    uvec4 children; // Light or node below.
    uvec4 counts;   // Lights.
};

// Shares `words` out among the clusters of a node by importance; each of their lights keeps one. words >= the sum of counts.
uvec4 share_words(vec4 importance, uvec4 counts, uint words) {
    uint lights = counts.x + counts.y + counts.z + counts.w;
    precise float total = importance.x + importance.y + importance.z + importance.w;
    // Nothing that matters (or a NaN): by numbers alone. The bound keeps quotients clear of denormals.
    bool matters = total > 1.0e-30;
    vec4 numbers = vec4(counts);
    float even = matters && guarded(GUARD_CLUSTER_SHARE) ? EVEN_SHARE : 0.0;
    precise vec4 mixed = importance / (matters ? total : 1.0) + even * (numbers / float(lights));
    // What is behind the surface needs no such share.
    vec4 weights = matters ? mix(mixed, vec4(0.0), equal(importance, vec4(0.0))) : numbers;
    precise vec3 ends = vec3(weights.x, weights.x + weights.y, weights.x + weights.y + weights.z);
    precise float whole = ends.z + weights.w;
    uvec4 least = guarded(GUARD_LIGHT_FLOOR) ? counts : uvec4(0u);
    uint spare = guarded(GUARD_LIGHT_FLOOR) ? words - lights : words;
    precise vec3 places = ends * (float(spare) / whole);
    // Floats may round above the last word: held as integers. The last cluster's end is exact.
    uvec3 cuts = min(uvec3(places), uvec3(spare));
    cuts = mix(cuts, uvec3(spare), equal(counts.yzw, uvec3(0u)));
    return uvec4(cuts.x, cuts.y - cuts.x, cuts.z - cuts.y, spare - cuts.z) + least;
}

// The clusters of `node` as the point p of a surface with the normal n sees them, `words` being shared out.
LightBranches light_branches(uint node, uint words, vec3 p, vec3 n) {
    LightCluster a = fetch_light_cluster(node, 0u);
    LightCluster b = fetch_light_cluster(node, 1u);
    LightCluster c = fetch_light_cluster(node, 2u);
    LightCluster d = fetch_light_cluster(node, 3u);
    vec4 importance = vec4(cluster_importance(a, p, n), cluster_importance(b, p, n), cluster_importance(c, p, n),
                           cluster_importance(d, p, n));
    uvec4 counts = uvec4(a.count, b.count, c.count, d.count);
    return LightBranches(share_words(importance, counts, words), uvec4(a.child, b.child, c.child, d.child), counts);
}

// A component by number; an array with a variable index runs lane by lane on lavapipe.
uint component(uvec4 v, uint slot) {
    uvec2 low = (slot & 1u) != 0u ? v.yw : v.xz;
    return (slot & 2u) != 0u ? low.y : low.x;
}

struct LightChoice {
    uint light; // Index of its record.
    uint place; // Where in the light's words the drawn one stands,
    uint words; // and how many it has.
};

// A point that is lit, as the tree sees it: where rays leave it, and its normal as a word (octahedral), so that whoever asks for
// the same point again asks with the same bits.
struct LitPoint {
    vec3 p;
    uint normal;
};

// What is asked of the tree at a hit.
struct LightQuestion {
    bool met;       // A light has been met by a ray from `from`, and its probability is wanted:
    uint trail;     // its way from the root, two bits a level, the root's lowest.
    LitPoint from;
    bool picks;     // A light is to be chosen for `lit`,
    uint word;      // by this number.
    LitPoint lit;
};

struct LightAnswer {
    uint met_words;     // How many words choose the light that was met.
    LightChoice choice; // The chosen light.
};

// Descends the tree, first for the light that was met, then for the one to be chosen: in one loop, as what stands twice costs
// twice. Counts levels in `steps`: 2 LIGHT_TREE_LEVELS at most.
LightAnswer ask_light_tree(LightQuestion question, inout uint steps) {
    LightAnswer answer = LightAnswer(0u, LightChoice(0u, question.word >> 1, LIGHT_TREE_WORDS));
    uint trail = question.trail;
    bool met = question.met;
    bool searching = met || question.picks;
    LightChoice at = answer.choice;
    while (searching) {
        vec3 p = met ? question.from.p : question.lit.p;
        vec3 n = decode_octahedral(met ? question.from.normal : question.lit.normal);
        LightBranches branches = light_branches(at.light, at.words, p, n);
        uvec3 cuts = uvec3(branches.words.x, branches.words.x + branches.words.y,
                           branches.words.x + branches.words.y + branches.words.z);
        uint drawn = (at.place >= cuts.x ? 1u : 0u) + (at.place >= cuts.y ? 1u : 0u) + (at.place >= cuts.z ? 1u : 0u);
        uint slot = met ? trail & 3u : drawn;
        trail >>= 2;
        at.place -= met ? 0u : component(uvec4(0u, cuts), slot);
        at.words = component(branches.words, slot);
        at.light = component(branches.children, slot);
        if (component(branches.counts, slot) <= 1u) {
            // A light: the answer to one question, and perhaps the start of the other.
            answer.met_words = met ? at.words : answer.met_words;
            searching = met && question.picks;
            met = false;
            if (searching) {
                at = answer.choice;
            } else {
                answer.choice = at;
            }
        }
        steps++;
    }
    return answer;
}

// The probability of a light that has `words` words.
float light_tree_probability(uint words) {
    return float(words) * 4.656612873077392578125e-10;
}

// Where in a light's share the draw stands, in [0, 1): its place among whole words, and digits below them from a number of its
// own, as a share may have few words.
float place_in_words(LightChoice choice, float digits) {
    precise float place = (float(choice.place) + digits) / float(choice.words);
    return guarded(GUARD_UNIT_FLOAT) ? lesser(place, 0.999999940395355) : place;
}

#endif
