//! The sampler's numbers: the Sobol' table, or the thesis's table of random numbers.

use super::Texel;
use crate::interface::{RANDOM_TABLE_TEXELS, SOBOL_TEXELS};

/// Direction numbers of the first four dimensions of Sobol's sequence: primitive polynomials and initial numbers of Joe and
/// Kuo, "Constructing Sobol sequences with better two-dimensional projections" (2008), new-joe-kuo-6.
/// Each row: degree s, coefficients a, initial numbers m; the first dimension is van der Corput's and has none.
const JOE_KUO: [(u32, u32, &[u32]); 3] = [(1, 0, &[1]), (2, 1, &[1, 3]), (3, 1, &[1, 3, 1])];

/// Direction numbers of four dimensions: `numbers[bit][dimension]`, the most significant digit in the highest bit.
fn direction_numbers() -> [[u32; 4]; 32] {
    let mut numbers = [[0; 4]; 32];
    for (bit, row) in numbers.iter_mut().enumerate() {
        row[0] = 1 << (31 - bit);
    }
    for (dimension, &(degree, coefficients, initial)) in JOE_KUO.iter().enumerate() {
        let s = degree as usize;
        let mut v = [0u32; 32];
        for bit in 0..32 {
            v[bit] = if bit < s {
                initial[bit] << (31 - bit)
            } else {
                let mut value = v[bit - s] ^ (v[bit - s] >> s);
                for k in 1..s {
                    if (coefficients >> (s - 1 - k)) & 1 == 1 {
                        value ^= v[bit - k];
                    }
                }
                value
            };
        }
        for (row, value) in numbers.iter_mut().zip(v) {
            row[dimension + 1] = value;
        }
    }
    numbers
}

/// The table that `sobol_set` in `glsl/sampling/random.glsl` reads: texel `256 t + b` is the exclusive or, bit-reversed, of
/// the direction numbers that byte `t` of the bit-reversed index selects with the value `b`.
pub fn sobol_texels() -> Vec<Texel> {
    let numbers = direction_numbers();
    (0..SOBOL_TEXELS)
        .map(|texel| {
            let (table, byte) = (texel / 256, texel % 256);
            let mut value = [0u32; 4];
            for bit in (0..8).filter(|bit| (byte >> bit) & 1 == 1) {
                // Bit `8 table + bit` of the reversed index is digit 31 minus that of the index.
                let digit = 31 - (8 * table + bit);
                for (lane, number) in value.iter_mut().zip(numbers[digit as usize]) {
                    *lane ^= number.reverse_bits();
                }
            }
            value
        })
        .collect()
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn point(texels: &[Texel], index: u32) -> [f64; 4] {
        let reversed = index.reverse_bits();
        let mut value = [0u32; 4];
        for table in 0..4 {
            let texel = texels[(256 * table + ((reversed >> (8 * table)) & 255)) as usize];
            for (lane, bits) in value.iter_mut().zip(texel) {
                *lane ^= bits;
            }
        }
        value.map(|lane| f64::from(lane.reverse_bits()) / 4_294_967_296.0)
    }

    #[test]
    fn the_first_points_are_sobols() {
        let texels = sobol_texels();
        assert_eq!(point(&texels, 0), [0.0; 4]);
        assert_eq!(point(&texels, 1), [0.5; 4]);
        assert_eq!(point(&texels, 2), [0.25, 0.75, 0.75, 0.75]);
        assert_eq!(point(&texels, 3), [0.75, 0.25, 0.25, 0.25]);
    }

    #[test]
    fn every_dimension_and_the_first_pair_are_nets() {
        let texels = sobol_texels();
        let points: Vec<_> = (0..256).map(|i| point(&texels, i)).collect();
        for dimension in 0..4 {
            let mut seen = [false; 256];
            points.iter().for_each(|p| seen[(p[dimension] * 256.0) as usize] = true);
            assert!(seen.iter().all(|&hit| hit), "dimension {dimension} is not stratified");
        }
        for (columns, rows) in [(256, 1), (64, 4), (16, 16), (4, 64), (1, 256)] {
            let mut seen = vec![false; 256];
            for p in &points {
                seen[(p[0] * f64::from(columns)) as usize * rows + (p[1] * rows as f64) as usize] = true;
            }
            assert!(seen.iter().all(|&hit| hit), "not a (0, 8, 2) net at {columns} x {rows}");
        }
    }
}
