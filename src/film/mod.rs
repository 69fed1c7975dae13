//! Stage 6: the film: exact sums of every replicate, and from them mean, error and invalid samples.
//!
//! Comes in: for each block of 16 samples and each pixel, what the GPU summed in f32 in sample order, as four words
//! `[sum.r, sum.g, sum.b, count]` (f32 bits three times, then the number of valid samples). Goes out: the mean picture
//! in the file's radiance units, the variance of that mean, and the error of the whole picture. May be assumed: sums
//! are in the scene's scaled radiance, not larger than [`fixed::MAX_SUM`] (the shader leaves larger samples out).
//!
//! Closed blocks are added in fixed point, which is exact, so no order of blocks, tiling, length of runs or split into
//! shares can change a bit of the result. Blocks go round robin to replicates that are scrambled independently; the
//! spread of the replicate means is what the error is estimated from.

mod error;
pub mod error_map;
mod estimate;
pub mod fixed;
mod held;
mod neighbourhood;

use rayon::prelude::*;

use crate::interface::BLOCK_SAMPLES;
use crate::{Error, Result, memory};

pub use error::PictureError;
pub use estimate::{DENOMINATOR_FLOOR, Estimate};

pub use crate::settings::MAX_REPLICATES;

/// Pixels of a picture up to which it has four replicates; larger ones have two: their many pixels make up for the few
/// replicates in the error of the picture, and each replicate's samples are spread more evenly the more there are of them.
pub const FOUR_REPLICATES_PIXELS: u64 = 1 << 14;

/// What comes back of one pixel: `[sum.r, sum.g, sum.b]` as f32 bits, then the number of valid samples.
pub type PixelSum = [u32; 4];

/// Replicate that owns block `block` of every pixel: round robin, by the index alone.
pub fn replicate_of_block(block: u32, replicates: u32) -> u32 {
    block % replicates.max(1)
}

/// Position of block `block` in the sample sequence of the replicate that owns it.
pub fn block_in_replicate(block: u32, replicates: u32) -> u32 {
    block / replicates.max(1)
}

/// Exact sums of the rendered region: the whole picture or its crop.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    replicates: u32,
    radiance_exponent: i32,
    /// Fixed-point sums of closed blocks, replicate after replicate, each in rows from the top.
    sums: Vec<[i128; 3]>,
    /// Valid samples in `sums`, in the same order.
    counts: Vec<u32>,
    /// The open block of each pixel; empty while no block is open.
    open: Vec<Open>,
    /// Blocks closed, summed over pixels.
    closed_blocks: u64,
    /// What reading out takes.
    held: held::Held,
}

/// The open block of a pixel: fewer than 16 samples have been taken of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Open {
    sum: [f32; 3],
    count: u32,
    replicate: u32,
}

impl Film {
    /// Replicates of a picture of `pixels` pixels. Give the whole picture's size where only a crop of it is rendered:
    /// the rule must not depend on the crop, or a crop would not equal that part of the whole picture.
    pub fn replicates(pixels: u64) -> u32 {
        if pixels <= FOUR_REPLICATES_PIXELS { 4 } else { 2 }
    }

    /// An empty film of `width` x `height` pixels, 1 to [`MAX_REPLICATES`] replicates, for radiance that was scaled by
    /// `2^radiance_exponent`. Refused where it needs more memory than the system has available.
    pub fn new(width: u32, height: u32, replicates: u32, radiance_exponent: i32) -> Result<Film> {
        if width == 0 || height == 0 || !(1..=MAX_REPLICATES).contains(&replicates) {
            return Err(Error::Internal(format!("a film of {width}x{height} pixels and {replicates} replicates")));
        }
        let pixels = u64::from(width) * u64::from(height);
        let what = format!("memory for the film of {width}x{height} pixels and {replicates} replicates");
        memory::check(&what, Film::bytes(pixels, replicates))?;
        let entries = usize::try_from(pixels.saturating_mul(u64::from(replicates))).unwrap_or(usize::MAX);
        memory::probe::<[i128; 3]>(&what, entries)?;
        let sums = vec![[0; 3]; entries];
        let counts = vec![0; entries];
        let held = held::Held::new(&what, Film::read_out_bytes(pixels))?;
        Ok(Film {
            width,
            height,
            replicates,
            radiance_exponent,
            sums,
            counts,
            open: Vec::new(),
            closed_blocks: 0,
            held,
        })
    }

    /// Bytes that a film of `pixels` pixels and `replicates` replicates needs: sums and counts, the open block, and
    /// what reading it out takes.
    pub fn bytes(pixels: u64, replicates: u32) -> u64 {
        let sums = (size_of::<[i128; 3]>() + size_of::<u32>()) as u64;
        let open = size_of::<Open>() as u64;
        pixels.saturating_mul(sums * u64::from(replicates) + open).saturating_add(Film::read_out_bytes(pixels))
    }

    /// Bytes of that which reading out takes. A film holds them until [`Film::let_go`].
    pub fn read_out_bytes(pixels: u64) -> u64 {
        pixels.saturating_mul(estimate::READ_OUT_BYTES as u64)
    }

    /// Lets go of the memory that is held for reading out: for what is done with the film next, which is its last.
    pub fn let_go(&self) {
        self.held.take();
    }

    /// Empties the film: another picture of the same size begins.
    pub fn clear(&mut self) {
        self.sums.fill([0; 3]);
        self.counts.fill(0);
        self.open.clear();
        self.closed_blocks = 0;
    }

    /// Width in pixels of the rendered region.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels of the rendered region.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Pixels of the rendered region.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Replicates of this film.
    pub fn replicate_count(&self) -> u32 {
        self.replicates
    }

    /// Whether every pixel has at least `blocks` closed blocks, counting those that a tile may be ahead by as if they
    /// were spread evenly: exact at every run boundary.
    pub fn has_blocks(&self, blocks: u64) -> bool {
        self.closed_blocks >= blocks.saturating_mul(self.pixels() as u64)
    }

    /// Adds a closed block of `replicate` for the pixels of `rect` (`[x, y, width, height]` inside the region, rows
    /// from the top). The open block of these pixels, which is the one that closes, is dropped.
    ///
    /// An error is a bug of the caller or the shader; the film is then unspecified.
    pub fn add_block(&mut self, replicate: u32, rect: [u32; 4], block: &[PixelSum]) -> Result<()> {
        self.check(replicate, rect, block)?;
        let ([x, y, width, height], row) = (rect.map(|value| value as usize), self.width as usize);
        let plane = replicate as usize * self.pixels();
        let rows = plane + y * row..plane + (y + height) * row;
        let sums = self.sums[rows.clone()].par_chunks_mut(row);
        let counts = self.counts[rows].par_chunks_mut(row);
        sums.zip(counts).zip(block.par_chunks(width)).try_for_each(|((sums, counts), block)| {
            let (sums, counts) = (&mut sums[x..x + width], &mut counts[x..x + width]);
            let added = sums
                .iter_mut()
                .zip(counts)
                .zip(block)
                .all(|((sum, count), pixel)| add_pixel(sum, count, pixel).is_some());
            if added { Ok(()) } else { Err(Error::Internal("a block's sum is out of the film's range".into())) }
        })?;
        if !self.open.is_empty() {
            for open in self.open[y * row..(y + height) * row].chunks_mut(row) {
                open[x..x + width].fill(Open::default());
            }
        }
        self.closed_blocks += (width * height) as u64;
        Ok(())
    }

    /// Replaces the open block of the pixels of `rect` by these sums of fewer than 16 samples of `replicate`. It counts
    /// on read-out only.
    pub fn set_open(&mut self, replicate: u32, rect: [u32; 4], block: &[PixelSum]) -> Result<()> {
        self.check(replicate, rect, block)?;
        if self.open.is_empty() {
            self.open = memory::filled("memory for the open block of a film", Open::default(), self.pixels())?;
        }
        let ([x, y, width, height], row) = (rect.map(|value| value as usize), self.width as usize);
        let rows = self.open[y * row..(y + height) * row].par_chunks_mut(row);
        rows.zip(block.par_chunks(width)).try_for_each(|(open, block)| {
            for (open, &[r, g, b, count]) in open[x..x + width].iter_mut().zip(block) {
                let sum = [r, g, b].map(f32::from_bits);
                if count > BLOCK_SAMPLES || sum.iter().any(|&value| fixed::from_f32(value).is_none()) {
                    return Err(Error::Internal("an open block's sum is out of the film's range".into()));
                }
                *open = Open { sum, count, replicate };
            }
            Ok(())
        })
    }

    /// Valid samples of each pixel, the open block's included.
    pub fn sample_counts(&self) -> Vec<u64> {
        (0..self.pixels()).into_par_iter().map(|pixel| self.samples_of(pixel)).collect()
    }

    /// Pixels without a single valid sample; they read 0.
    pub fn empty_pixels(&self) -> usize {
        (0..self.pixels()).into_par_iter().filter(|&pixel| self.samples_of(pixel) == 0).count()
    }

    fn samples_of(&self, pixel: usize) -> u64 {
        let closed = self.counts[pixel..].iter().step_by(self.pixels()).map(|&count| u64::from(count));
        closed.sum::<u64>() + self.open.get(pixel).map_or(0, |open| u64::from(open.count))
    }

    fn check(&self, replicate: u32, [x, y, width, height]: [u32; 4], block: &[PixelSum]) -> Result<()> {
        let fits =
            |first: u32, count: u32, all: u32| count > 0 && first.checked_add(count).is_some_and(|end| end <= all);
        let pixels = u64::from(width) * u64::from(height);
        let inside = fits(x, width, self.width) && fits(y, height, self.height);
        if inside && replicate < self.replicates && block.len() as u64 == pixels {
            return Ok(());
        }
        Err(Error::Internal(format!(
            "{} pixels of replicate {replicate} for {width}x{height} at ({x}, {y}) in a film of {}x{} and {} replicates",
            block.len(),
            self.width,
            self.height,
            self.replicates
        )))
    }
}

/// Adds what came back of a pixel; `None` where a number is out of range.
fn add_pixel(sum: &mut [i128; 3], count: &mut u32, &[r, g, b, samples]: &PixelSum) -> Option<()> {
    if samples > BLOCK_SAMPLES {
        return None;
    }
    for (sum, bits) in sum.iter_mut().zip([r, g, b]) {
        *sum = sum.checked_add(fixed::from_f32(f32::from_bits(bits))?)?;
    }
    *count = count.checked_add(samples)?;
    Some(())
}
