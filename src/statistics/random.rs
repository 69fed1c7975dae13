//! The self-test's own random numbers: nothing of the renderer's samplers is used to judge it.
//!
//! Comes in: a seed and the number of a stream. Goes out: independent numbers.

use glam::Vec3;

/// xoshiro256++ (Blackman and Vigna 2019), its state filled by SplitMix64 from seed and stream.
pub struct Random([u64; 4]);

impl Random {
    /// The numbers of one stream of a seed.
    pub fn new(seed: u64, stream: u64) -> Random {
        let mut state = seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ stream.wrapping_mul(0xd134_2543_de82_ef95);
        Random(std::array::from_fn(|_| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            mixed ^ (mixed >> 31)
        }))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.0;
        let result = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let shifted = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= shifted;
        s[3] = s[3].rotate_left(45);
        result
    }

    /// A number uniform in [0, 1), with 53 bits.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number uniform in [0, 1), with 24 bits.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// A whole number below `bound`, which is not 0.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.bits() % bound as u64) as usize
    }

    /// A point uniform in [-1, 1)^3.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// A direction uniform over the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.next() - 1.0, std::f64::consts::TAU * self.next());
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new((radius * phi.cos()) as f32, (radius * phi.sin()) as f32, z as f32)
    }
}
