//! Samples that are left out: what they were, and which stage made them so.
//!
//! Goes out: numbers and names of kinds and causes. A counter each (`COUNTER_INVALID`), kinds first.

numbered! { INVALID_KIND_NUMBERS, INVALID_KIND_NAMES, INVALID_KINDS;
    INVALID_NAN = 0, "nan": "Kind of invalid sample: its radiance is not a number.";
    INVALID_INFINITE = 1, "infinite": "Kind of invalid sample: infinite, or too large for the film's fixed-point sums.";
    INVALID_NEGATIVE = 2, "negative": "Kind of invalid sample: negative.";
}

numbered! { CAUSE_NUMBERS, CAUSE_NAMES, CAUSES;
    CAUSE_SUM = 0, "sum": "Cause of an invalid sample: no stage alone, its terms were valid and their sum is not.";
    CAUSE_CAMERA = 1, "camera": "Cause: the camera's ray.";
    CAUSE_EMISSION = 2, "emission": "Cause: emission that a ray met, or its weight.";
    CAUSE_SKY = 3, "sky": "Cause: the sky.";
    CAUSE_LIGHT = 4, "light": "Cause: a light sample.";
    CAUSE_LAMBERT = 5, "lambert": "Cause: a direction that the Lambert lobe sampled, or its weight.";
    CAUSE_MIRROR = 6, "mirror": "Cause: a direction of a mirror, or its weight.";
    CAUSE_GLASS = 7, "glass": "Cause: a direction of glass, or its weight.";
}
