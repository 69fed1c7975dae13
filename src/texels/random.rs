//! The table of random numbers of the `table` sampler, the thesis's way.

use super::Texel;
use crate::interface::RANDOM_TABLE_TEXELS;

/// The table of random numbers that the host makes for the `table` sampler: splitmix64 (Steele, Lea, Flood 2014) from `seed`.
pub fn random_table_texels(seed: u64) -> Vec<Texel> {
    let mut state = seed;
    let mut pair = || {
        let word = splitmix64(&mut state);
        [word as u32, (word >> 32) as u32]
    };
    (0..RANDOM_TABLE_TEXELS)
        .map(|_| {
            let ([x, y], [z, w]) = (pair(), pair());
            [x, y, z, w]
        })
        .collect()
}

/// Next number of splitmix64.
pub fn splitmix64(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
