//! Long sums: compensated or plain on the device, and what of a picture's sums is exact.
//!
//! Comes in: a bench of the self-test. Goes out: how far a sum of a million numbers is off, and what adding a block to the film takes.

use std::hint::black_box;
use std::time::Instant;

use crate::Result;
use crate::film::{Film, PixelSum, replicate_of_block};
use crate::gpu::shaders;
use crate::interface::BLOCK_SAMPLES;
use crate::render::Guard;
use crate::selftest::TestBench;
use crate::selftest::kit::streams;
use crate::study::engine::spread::digits;
use crate::study::engine::summary::{Summary, Table};
use crate::study::engine::{Rows, Values};

/// Dispatches of a device's sum: a million numbers.
const DISPATCHES: u32 = 16;
/// Blocks of as many numbers.
const BLOCKS: u32 = DISPATCHES * streams::STEPS / BLOCK_SAMPLES;
/// Pixels of the film whose additions are timed, width and height.
const TIMED: [u32; 2] = [320, 240];
/// Times that each is added.
const TIMES: u32 = 16;

/// A way to sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sum {
    /// In f32 on the device, what rounding takes carried along.
    Compensated,
    /// In f32 on the device.
    Plain,
    /// As a render does: blocks of 16 in f32 on the device, exact on the host.
    Film,
    /// Blocks in f32 on the device, their sums in f64 on the host.
    HostF64,
    /// All of it in f32, blocks included: what a picture accumulated on the device is.
    DeviceF32,
}

impl Sum {
    /// All of them.
    pub const ALL: [Sum; 5] = [Sum::Compensated, Sum::Plain, Sum::Film, Sum::HostF64, Sum::DeviceF32];

    /// Its name in rows.
    pub fn name(self) -> &'static str {
        match self {
            Sum::Compensated => "compensated f32",
            Sum::Plain => "plain f32",
            Sum::Film => "blocks f32, film exact",
            Sum::HostF64 => "blocks f32, host f64",
            Sum::DeviceF32 => "blocks f32, sums f32",
        }
    }

    /// Sums a million numbers uniform in [0, 1).
    pub fn measure(self, bench: &TestBench) -> Result<Values> {
        const UNIFORM: usize = 1;
        let count = DISPATCHES * streams::STEPS;
        let exact = streams::sum(UNIFORM as u32, count);
        let device = |bench: &TestBench| streams::compensated(bench, shaders::PROBE_SUMS, DISPATCHES);
        let blocks = || streams::blocks(bench, BLOCKS);
        let f64_of = |block: &PixelSum| f64::from(f32::from_bits(block[UNIFORM]));
        let sum = match self {
            Sum::Compensated => f64::from(device(bench)?[UNIFORM]),
            Sum::Plain => f64::from(device(&bench.without(Guard::CompensatedSum))?[UNIFORM]),
            Sum::Film => f64::from(film(&blocks()?)?[UNIFORM]) * f64::from(count),
            Sum::HostF64 => blocks()?.iter().map(f64_of).sum(),
            Sum::DeviceF32 => f64::from(blocks()?.iter().map(|block| f32::from_bits(block[UNIFORM])).sum::<f32>()),
        };
        let mut values = vec![("numbers", f64::from(count)), ("relative_error", (sum / exact - 1.0).abs())];
        values.extend(self.time()?.map(|seconds| ("ns_per_pixel_and_block", 1e9 * seconds)));
        Ok(values)
    }

    /// Seconds to add a block to a pixel on the host, for the ways that do so.
    fn time(self) -> Result<Option<f64>> {
        let [width, height] = TIMED;
        let pixels = (width * height) as usize;
        let block: Vec<PixelSum> = vec![[1.5f32.to_bits(), 0.25f32.to_bits(), 3.0f32.to_bits(), BLOCK_SAMPLES]; pixels];
        let additions = pixels as f64 * f64::from(TIMES);
        match self {
            Sum::Film => {
                let mut film = Film::new(width, height, 2, 0)?;
                // The first touches the memory.
                film.add_block(0, [0, 0, width, height], &block)?;
                film.add_block(1, [0, 0, width, height], &block)?;
                let start = Instant::now();
                for time in 0..TIMES {
                    film.add_block(time % 2, [0, 0, width, height], &block)?;
                }
                let elapsed = start.elapsed().as_secs_f64();
                black_box(&film);
                Ok(Some(elapsed / additions))
            }
            Sum::HostF64 => {
                let mut sums = vec![[0f64; 3]; pixels];
                let start = Instant::now();
                for _ in 0..TIMES {
                    for (sum, &[r, g, b, _]) in sums.iter_mut().zip(&block) {
                        [r, g, b].iter().zip(sum).for_each(|(&bits, sum)| *sum += f64::from(f32::from_bits(bits)));
                    }
                    black_box(&mut sums);
                }
                Ok(Some(start.elapsed().as_secs_f64() / additions))
            }
            Sum::Compensated | Sum::Plain | Sum::DeviceF32 => Ok(None),
        }
    }
}

/// Mean of a pixel whose blocks go to a film.
fn film(blocks: &[PixelSum]) -> Result<[f32; 3]> {
    let mut film = Film::new(1, 1, 4, 0)?;
    for (block, sum) in (0..).zip(blocks) {
        film.add_block(replicate_of_block(block, 4), [0, 0, 1, 1], &[*sum])?;
    }
    Ok(film.mean()[0])
}

/// How far each is off, and what it takes.
pub fn summary(rows: &Rows, scene: &str) -> Summary {
    let title =
        "A sum of a million numbers in [0, 1): relative error; nanoseconds on the host to add a block to a pixel";
    let mut table = Table::new(title, &["sums", "error", "ns a block"]);
    let figure = |sum: Sum, value: &str| rows.median(scene, sum.name(), value);
    for sum in Sum::ALL {
        let Some(error) = figure(sum, "relative_error") else { continue };
        let time = figure(sum, "ns_per_pixel_and_block").map_or("-".into(), digits);
        table.rows.push(vec![sum.name().into(), format!("{error:.1e}"), time]);
    }
    let mut summary = Summary::default();
    if table.rows.is_empty() {
        return summary;
    }
    let error = |sum| figure(sum, "relative_error").map_or("?".into(), |error| format!("{error:.1e}"));
    summary.findings.push(format!(
        "A million numbers summed in f32 are off by {} plain and by {} compensated; by blocks of 16 and f32 sums of those by {}, with \
         the film's exact sums by {} (in an f32 mean), which takes {} ns a block and pixel on the host, f64 {} ns.",
        error(Sum::Plain),
        error(Sum::Compensated),
        error(Sum::DeviceF32),
        error(Sum::Film),
        figure(Sum::Film, "ns_per_pixel_and_block").map_or("?".into(), digits),
        figure(Sum::HostF64, "ns_per_pixel_and_block").map_or("?".into(), digits),
    ));
    summary.table(table);
    summary
}
