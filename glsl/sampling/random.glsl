// Random numbers: a pure function of (seed, pixel, replicate, sample, dimension).
//
// Dimensions come in pairs, PAIRS_PER_BOUNCE of them for the camera and for each bounce. A pair is a fixed function of
// bounce and purpose, so an effect that is off changes no other number. Values are whole 32-bit words; `unit_float` makes
// them floats in [0, 1).
#ifndef SAMPLING_RANDOM_GLSL
#define SAMPLING_RANDOM_GLSL

#include "bindings.glsl"
#include "effects.glsl"
#include "run.glsl"

const uint PAIR_FILM = 0u;       // camera: place in the pixel
const uint PAIR_LENS = 1u;       // camera: place on the lens
const uint PAIR_DIRECTION = 0u;  // bounce: BSDF direction
const uint PAIR_LIGHT_POINT = 1u; // bounce: which light, and the point on it
const uint PAIR_CHOICES = 2u;    // bounce: which lobe; roulette
const uint PAIR_LIGHT_DIGITS = 3u; // bounce: with a light tree, the last digits of the point's first coordinate

// Number of a pair of the camera (`stage` 0) or of bounce `stage` - 1.
uint pair_number(uint stage, uint purpose) {
    uint own = guarded(GUARD_BOUNCE_DIMENSIONS) ? stage : min(stage, 1u);
    return own * PAIRS_PER_BOUNCE + purpose;
}

// A float in [0, 1): 24 bits, so that the largest is 1 - 2^-24 (32 bits would round up to 1).
float unit_float(uint word) {
    return guarded(GUARD_UNIT_FLOAT) ? float(word >> 8) * 5.9604644775390625e-8 : float(word) * 2.3283064365386963e-10;
}

vec2 unit_float2(uvec2 words) {
    return vec2(unit_float(words.x), unit_float(words.y));
}

// Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 2020), pcg4d, and one shift more.
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
    // The low bits of each lane depend on few input bits, the high ones on all; a scramble's seed is read from the low ones.
    return guarded(GUARD_HASH_SHIFT) ? v ^ (v >> 16) : v;
}

// A nested uniform (Owen) scramble of a bit-reversed word: every bit is flipped by a hash of the bits below it, which are
// the more significant ones of the number. Laine and Karras (EGSR 2011), with Vegdahl's constants (Burley, "Practical
// Hash-based Owen Scrambling", JCGT 2020, describes the use).
uint scramble_reversed(uint v, uint seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

// The second dimension of Sobol's sequence, bit-reversed. Its k-th direction number, reversed, is row k of Pascal's
// triangle modulo 2, and C(k, j) is odd where the bits of j are among those of k (Lucas): bit j of the result is the
// exclusive or of all index bits whose number contains j, which five butterfly steps add up.
uint sobol_second_reversed(uint index) {
    index ^= (index >> 16) & 0x0000ffffu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 1) & 0x55555555u;
    return index;
}

// The `index`-th point of the first two dimensions of Sobol's sequence, shuffled and scrambled by `seeds`. The first
// dimension is the bit-reversed index, so its reversal is the index itself.
uvec2 sobol_pair(uint index, uvec4 seeds) {
    uint shuffled = bitfieldReverse(scramble_reversed(bitfieldReverse(index), seeds.x));
    return bitfieldReverse(uvec2(scramble_reversed(shuffled, seeds.y),
                                 scramble_reversed(sobol_second_reversed(shuffled), seeds.z)));
}

// What makes a pixel's random numbers in a run its own.
struct Stream {
    uint pixel;       // The pixel, seeded.
    uint replicate;   // The replicate, seeded.
    uint first_index; // Index of the run's first sample in the replicate.
};

// The stream of `pixel`: x | y << 16, in pixels of the whole picture. To be made once, as `run` is.
Stream make_stream(uint pixel) {
    return Stream(pixel + constants.seed_low, push.replicate + constants.seed_high, push.first_index);
}

// The numbers of pair `pair` of sample `sample_number` of the run.
uvec2 random_pair(Stream stream, uint sample_number, uint pair) {
    uint index = stream.first_index + sample_number;
    if (SAMPLER == SAMPLER_SOBOL) {
        // The constant keeps these seeds apart from the numbers of the independent sampler.
        return sobol_pair(index, pcg4d(uvec4(stream.pixel, pair, stream.replicate, 0x9e3779b9u)));
    }
    if (SAMPLER == SAMPLER_INDEPENDENT) {
        return pcg4d(uvec4(stream.pixel, pair, stream.replicate, index)).xy;
    }
    // The thesis's way: a table made by the host, read from a place of the pixel's own and around again at its end.
    uint start = pcg4d(uvec4(stream.pixel, constants.seed_high, 0x85ebca6bu, 0xc2b2ae35u)).x;
    // Odd, so that the samples of a pixel go through the whole table before any comes again.
    uint pairs = (PAIRS_PER_BOUNCE * (1u + constants.max_bounces)) | 1u;
    return random_texel((start + (push.first_sample + sample_number) * pairs + pair) & (RANDOM_TABLE_TEXELS - 1u)).xy;
}

#endif
