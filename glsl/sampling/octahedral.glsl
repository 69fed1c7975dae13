// Unit vectors in one word: Meyer et al., "On Floating-Point Normal Vectors" (EGSR 2010), 16 bits a coordinate.
#ifndef SAMPLING_OCTAHEDRAL_GLSL
#define SAMPLING_OCTAHEDRAL_GLSL

// 1 where `x` is not negative, else -1: unlike sign(), never 0.
vec2 sides(vec2 x) {
    return vec2(x.x < 0.0 ? -1.0 : 1.0, x.y < 0.0 ? -1.0 : 1.0);
}

// The unit vector of a word, within 1e-4 of the one that was encoded. Equal words give equal bits.
vec3 decode_octahedral(uint word) {
    precise vec2 e = vec2(float(word & 0xffffu), float(word >> 16)) * 3.0518043793392844e-5 - 1.0;
    precise float z = 1.0 - abs(e.x) - abs(e.y);
    float fold = z < 0.0 ? -z : 0.0;
    precise vec2 folded = e - sides(e) * fold;
    precise float length2 = folded.x * folded.x + folded.y * folded.y + z * z;
    precise vec3 v = vec3(folded, z) * inversesqrt(length2);
    return v;
}

// The word of a unit vector.
uint encode_octahedral(vec3 v) {
    precise float scale = 1.0 / (abs(v.x) + abs(v.y) + abs(v.z));
    precise vec2 p = v.xy * scale;
    precise vec2 folded = (1.0 - abs(p.yx)) * sides(p);
    vec2 e = v.z < 0.0 ? folded : p;
    // Not below 0 and no NaN; what rounds above 65535 is held as an integer.
    vec2 steps = (e + 1.0) * 32767.5 + 0.5;
    uvec2 words = min(uvec2(steps.x > 0.0 ? steps.x : 0.0, steps.y > 0.0 ? steps.y : 0.0), uvec2(65535u));
    return words.x | (words.y << 16);
}

#endif
