//! The film: exact under any order and split, variance 0 for constants, unbiased error, open blocks, refusals.

use proptest::prelude::*;
use texray::Error;
use texray::film::{Film, PixelSum, block_in_replicate, replicate_of_block};

const BLOCK: u32 = 16;

/// A deterministic stream of 64-bit numbers (SplitMix64, Steele et al. 2014): independent of the film's own code.
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Uniform in [0, 1), 24 bits.
    fn uniform(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u32 << 24) as f32
    }
}

fn pixel(value: f32, count: u32) -> PixelSum {
    let bits = value.to_bits();
    [bits, bits, bits, count]
}

/// Sum of `count` samples as the shader makes it: f32, one after the other.
fn sum_of(count: u32, mut sample: impl FnMut() -> f32) -> PixelSum {
    pixel((0..count).fold(0.0f32, |sum, _| sum + sample()), count)
}

/// `blocks` random blocks for `pixels` pixels, magnitudes spread over 60 powers of two.
fn random_blocks(seed: u64, blocks: u32, pixels: usize) -> Vec<Vec<PixelSum>> {
    let mut stream = Stream(seed);
    let mut value = || stream.uniform() * 2f32.powi((stream.next() % 60) as i32 - 30);
    (0..blocks)
        .map(|_| (0..pixels).map(|_| [value().to_bits(), value().to_bits(), value().to_bits(), BLOCK]).collect())
        .collect()
}

fn part(block: &[PixelSum], width: u32, [x, y, w, h]: [u32; 4]) -> Vec<PixelSum> {
    let at = |row: u32| (row * width + x) as usize;
    (y..y + h).flat_map(|row| block[at(row)..at(row) + w as usize].to_vec()).collect()
}

#[test]
fn blocks_go_round_robin() {
    let owners: Vec<_> = (0..9).map(|block| (replicate_of_block(block, 4), block_in_replicate(block, 4))).collect();
    assert_eq!(owners, [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (3, 1), (0, 2)]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any order of blocks and any cut into tiles gives the same film, bit for bit.
    #[test]
    fn exact_under_any_order_and_split(seed: u64, width in 1u32..14, height in 1u32..9, blocks in 2u32..9) {
        let data = random_blocks(seed, blocks, (width * height) as usize);
        let mut whole = Film::new(width, height, 4, 0).unwrap();
        for (block, sums) in data.iter().enumerate() {
            whole.add_block(replicate_of_block(block as u32, 4), [0, 0, width, height], sums).unwrap();
        }
        let mut parts: Vec<(u32, [u32; 4])> = Vec::new();
        let mut stream = Stream(seed ^ 1);
        for block in 0..blocks {
            let x = stream.next() as u32 % width;
            let y = stream.next() as u32 % height;
            let cuts = [[0, 0, x, y], [x, 0, width - x, y], [0, y, x, height - y], [x, y, width - x, height - y]];
            parts.extend(cuts.iter().filter(|rect| rect[2] > 0 && rect[3] > 0).map(|&rect| (block, rect)));
        }
        for i in (1..parts.len()).rev() {
            parts.swap(i, stream.next() as usize % (i + 1));
        }
        let mut pieces = Film::new(width, height, 4, 0).unwrap();
        for (block, rect) in parts {
            let sums = part(&data[block as usize], width, rect);
            pieces.add_block(replicate_of_block(block, 4), rect, &sums).unwrap();
        }
        prop_assert_eq!(whole.estimate(), pieces.estimate());
        prop_assert_eq!(whole.relative_rmse().unwrap().to_bits(), pieces.relative_rmse().unwrap().to_bits());
    }

    /// Whole blocks of one constant have variance exactly 0, whatever f32 rounding did to the sum of a block.
    #[test]
    fn constant_has_no_variance(value in 0f32..1e6, blocks in 2u32..40) {
        let mut film = Film::new(3, 2, 4, 0).unwrap();
        let block = vec![sum_of(BLOCK, || value); 6];
        for index in 0..blocks {
            film.add_block(replicate_of_block(index, 4), [0, 0, 3, 2], &block).unwrap();
        }
        let estimate = film.estimate();
        prop_assert!(estimate.variance.iter().flatten().all(|&variance| variance == 0.0));
        prop_assert_eq!(film.relative_rmse(), Some(0.0));
        // A block's sum in f32 is within 15 roundings of 2^-24 of 16 times the value.
        for mean in estimate.mean.iter().flatten() {
            prop_assert!((mean - value).abs() <= value * 16.0 / 2f32.powi(24), "{mean} for {value}");
        }
    }
}

/// The variance of the mean is unbiased, open block and unequal counts included. Samples are uniform on [0, 1), so the
/// mean of N has the variance 1 / 12 N. The pooled estimate of P pixels has a relative standard error below
/// sqrt(2 / ((K - 1) P)) (a chi-square's, uniform samples being lighter-tailed): |z| < 5 fails by chance in 1 of
/// 1.7 million runs of a correct film.
#[test]
fn variance_is_unbiased() {
    let (width, height) = (96, 64);
    let pixels = width * height;
    for (blocks, open) in [(4, 0), (6, 0), (7, 5), (2, 9)] {
        let mut film = Film::new(width, height, 4, 0).unwrap();
        let mut stream = Stream(u64::from(blocks));
        let mut sums = |count| -> Vec<_> { (0..pixels).map(|_| sum_of(count, || stream.uniform())).collect() };
        for block in 0..blocks {
            film.add_block(replicate_of_block(block, 4), [0, 0, width, height], &sums(BLOCK)).unwrap();
        }
        if open > 0 {
            film.set_open(replicate_of_block(blocks, 4), [0, 0, width, height], &sums(open)).unwrap();
        }
        let estimate = film.estimate();
        let samples = f64::from(blocks * BLOCK + open);
        let expected = 1.0 / (12.0 * samples);
        let mean: f64 = estimate.variance.iter().map(|v| v[0]).sum::<f64>() / f64::from(pixels);
        let used = f64::from((blocks + u32::from(open > 0)).min(4));
        let z = (mean / expected - 1.0) / (2.0 / ((used - 1.0) * f64::from(pixels))).sqrt();
        assert!(z.abs() < 5.0, "{blocks} blocks and {open} samples: z = {z:.2}, {mean:e} for {expected:e}");
        let average = estimate.mean.iter().map(|m| f64::from(m[0])).sum::<f64>() / f64::from(pixels);
        let z = (average - 0.5) / (expected / f64::from(pixels)).sqrt();
        assert!(z.abs() < 5.0, "mean {average}: z = {z:.2}");
        // Denominator: the 5 x 5 mean is within a few percent of 0.5.
        let relative = film.relative_rmse().unwrap();
        let wanted = (expected / 0.26).sqrt();
        assert!((relative / wanted - 1.0).abs() < 0.05, "{relative} for {wanted}");
        assert!((estimate.rmse().unwrap() / expected.sqrt() - 1.0).abs() < 0.05);
    }
}

/// Case 58: 10^7 samples of 0.1 and 10^7 of a rare bright path keep their mean to 1e-6; a naive f32 sum is 9 % off.
#[test]
fn long_sums_do_not_drift() {
    let mut film = Film::new(2, 1, 4, 0).unwrap();
    let (mut stream, mut exact) = (Stream(7), 0.0f64);
    let blocks = 10_000_000 / BLOCK;
    for block in 0..blocks {
        let rare = sum_of(BLOCK, || if stream.next() % 10_000 == 0 { 1e4 } else { 0.0 });
        exact += f64::from(f32::from_bits(rare[0]));
        film.add_block(replicate_of_block(block, 4), [0, 0, 2, 1], &[sum_of(BLOCK, || 0.1), rare]).unwrap();
    }
    let mean = film.mean();
    let exact = exact / f64::from(blocks * BLOCK);
    assert!((f64::from(mean[0][0]) / f64::from(0.1f32) - 1.0).abs() < 1e-6, "{}", mean[0][0]);
    assert!((f64::from(mean[1][0]) / exact - 1.0).abs() < 1e-6, "{} for {exact}", mean[1][0]);
}

#[test]
fn open_block_counts_on_read_out_only() {
    let mut film = Film::new(2, 1, 2, 0).unwrap();
    film.set_open(0, [0, 0, 2, 1], &[pixel(3.0, 4), pixel(8.0, 8)]).unwrap();
    assert_eq!(film.mean(), [[0.75; 3], [1.0; 3]]);
    film.set_open(0, [1, 0, 1, 1], &[pixel(6.0, 12)]).unwrap();
    assert_eq!(film.mean(), [[0.75; 3], [0.5; 3]]);
    film.add_block(0, [0, 0, 1, 1], &[pixel(32.0, 16)]).unwrap();
    assert_eq!(film.mean(), [[2.0; 3], [0.5; 3]]);
    assert_eq!(film.sample_counts(), [16, 12]);
    assert_eq!(film.relative_rmse(), None);
}

#[test]
fn error_needs_two_blocks() {
    let mut film = Film::new(1, 1, 4, 0).unwrap();
    assert_eq!(film.relative_rmse(), None);
    film.add_block(0, [0, 0, 1, 1], &[pixel(16.0, 16)]).unwrap();
    film.set_open(1, [0, 0, 1, 1], &[pixel(1.0, 15)]).unwrap();
    assert_eq!(film.relative_rmse(), None);
    film.add_block(1, [0, 0, 1, 1], &[pixel(16.0, 16)]).unwrap();
    assert_eq!(film.relative_rmse(), Some(0.0));
}

#[test]
fn invalid_samples_lower_the_count() {
    let mut film = Film::new(2, 1, 2, 0).unwrap();
    film.add_block(0, [0, 0, 2, 1], &[pixel(15.0, 15), pixel(0.0, 0)]).unwrap();
    film.add_block(1, [0, 0, 2, 1], &[pixel(16.0, 16), pixel(0.0, 0)]).unwrap();
    assert_eq!(film.mean(), [[1.0; 3], [0.0; 3]]);
    assert_eq!(film.empty_pixels(), 1);
    assert_eq!(film.sample_counts(), [31, 0]);
    assert_eq!(film.relative_rmse(), Some(0.0));
}

#[test]
fn radiance_scaling_is_undone() {
    for exponent in [0, 5, -5, 100, -100] {
        let mut film = Film::new(1, 1, 2, exponent).unwrap();
        film.add_block(0, [0, 0, 1, 1], &[pixel(16.0, 16)]).unwrap();
        film.add_block(1, [0, 0, 1, 1], &[pixel(32.0, 16)]).unwrap();
        let estimate = film.estimate();
        let scale = 2f64.powi(-exponent);
        assert_eq!(f64::from(estimate.mean[0][0]), f64::from((1.5 * scale) as f32));
        assert_eq!(estimate.variance[0][0], 0.25 * scale * scale);
    }
}

#[test]
fn refuses_what_does_not_fit() {
    let mut film = Film::new(4, 3, 2, 0).unwrap();
    let block = [pixel(1.0, 16); 12];
    for (replicate, rect, sums) in [
        (2, [0, 0, 4, 3], &block[..]),
        (0, [1, 0, 4, 3], &block[..]),
        (0, [0, 0, 4, 3], &block[..11]),
        (0, [0, 0, 0, 3], &block[..0]),
        (0, [u32::MAX, 0, 2, 1], &block[..2]),
    ] {
        assert!(matches!(film.add_block(replicate, rect, sums), Err(Error::Internal(_))), "{rect:?}");
        assert!(matches!(film.set_open(replicate, rect, sums), Err(Error::Internal(_))), "{rect:?}");
    }
    for bad in [pixel(f32::NAN, 16), pixel(f32::INFINITY, 16), pixel(1e11, 16), pixel(1.0, 17)] {
        assert!(film.add_block(0, [0, 0, 1, 1], &[bad]).is_err());
        assert!(film.set_open(0, [0, 0, 1, 1], &[bad]).is_err());
    }
    assert!(matches!(Film::new(0, 3, 2, 0), Err(Error::Internal(_))));
    assert!(matches!(Film::new(1, 3, 0, 0), Err(Error::Internal(_))));
}

#[test]
fn refuses_more_memory_than_there_is() {
    assert_eq!(Film::bytes(1, 4) - Film::bytes(1, 3), 52);
    let error = Film::new(u32::MAX, u32::MAX, 4, 0).unwrap_err();
    assert!(matches!(&error, Error::Limit { need, have, .. } if !need.is_empty() && !have.is_empty()), "{error}");
}
