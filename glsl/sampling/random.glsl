// Random numbers: a pure function of (seed, pixel, replicate, sample, dimension).
//
// Dimensions come in sets of four: set 0 is the camera's, bounce b (from 0) has the sets 1 + 2 b and 2 + 2 b. A set is a
// fixed function of bounce and purpose, so an effect that is off changes no other number. Values are whole 32-bit words;
// `unit_float` makes them floats in [0, 1).
#ifndef SAMPLING_RANDOM_GLSL
#define SAMPLING_RANDOM_GLSL

#include "bindings.glsl"
#include "effects.glsl"

const uint SET_CAMERA = 0u;      // x, y: pixel filter; z, w: lens
const uint SET_DIRECTIONS = 1u;  // + 2 bounce; x, y: BSDF direction; z, w: point on the light
const uint SET_CHOICES = 2u;     // + 2 bounce; x: lobe; y: light; z: roulette; w: free

// Which sequence a path draws from, and where it stands in it.
struct RandomState {
    uint pixel;     // x | y << 16, in pixels of the whole picture.
    uint replicate;
    uint index;     // Index of the sample in its replicate.
    uint sample_index; // Index of the sample in the pixel.
};

// A float in [0, 1): 24 bits, so that the largest is 1 - 2^-24 (32 bits would round up to 1).
float unit_float(uint word) {
    return float(word >> 8) * 5.9604644775390625e-8;
}

vec2 unit_float2(uvec2 words) {
    return vec2(words >> 8) * 5.9604644775390625e-8;
}

// Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 2020), pcg4d.
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// A nested uniform (Owen) scramble of a bit-reversed word: every bit is flipped by a hash of the bits below it, which are
// the more significant ones of the number. Laine and Karras (EGSR 2011), with Vegdahl's constants (Burley, "Practical
// Hash-based Owen Scrambling", JCGT 2020, describes the use).
uvec4 scramble_reversed(uvec4 v, uvec4 seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

// Four dimensions of the `index`-th point of Sobol's sequence, shuffled and scrambled by `seeds`. The table holds, for
// each byte of the bit-reversed index, the exclusive or of its direction numbers, bit-reversed.
uvec4 sobol_set(uint index, uvec4 seeds, uint shuffle_seed) {
    uint shuffled = scramble_reversed(uvec4(bitfieldReverse(index)), uvec4(shuffle_seed)).x;
    uvec4 point = random_texel(shuffled & 255u) ^ random_texel(256u + ((shuffled >> 8) & 255u)) ^
                  random_texel(512u + ((shuffled >> 16) & 255u)) ^ random_texel(768u + (shuffled >> 24));
    return bitfieldReverse(scramble_reversed(point, seeds));
}

// The four numbers of a set.
uvec4 random_set(RandomState state, uint set) {
    if (SAMPLER == SAMPLER_SOBOL) {
        uvec4 seeds = pcg4d(uvec4(state.pixel + push.seed_low, set, state.replicate + push.seed_high, 0x9e3779b9u));
        return sobol_set(state.index, seeds, pcg4d(seeds).x);
    }
    if (SAMPLER == SAMPLER_INDEPENDENT) {
        return pcg4d(uvec4(state.pixel + push.seed_low, set, state.replicate + push.seed_high, state.index));
    }
    // The thesis's way: a table made by the host, read from a place of the pixel's own and around again at its end.
    uint start = pcg4d(uvec4(state.pixel + push.seed_low, push.seed_high, 0x85ebca6bu, 0xc2b2ae35u)).x;
    uint sets = 1u + 2u * push.max_bounces;
    return random_texel((start + state.sample_index * sets + set) % RANDOM_TABLE_TEXELS);
}

#endif
