//! Pictures held against each other: how far one is from a reference, as numbers and as a picture.
//!
//! Comes in: OpenEXR files of any renderer. Goes out: a [`Comparison`] of picture A with the reference B, and a
//! difference image. Pixels that are not finite in either picture are counted and told; figures are of the others.
//!
//! ```text
//! header           what a file claims, before anything of that size is allocated
//! read             a file's layers → a picture, with its variance where the file has it
//! relative_error   relative mean squared error, mean squared error, mean
//! flip             FLIP: what an eye that flips between the two would see
//! tiles            are the differences more than noise?
//! difference       an image of them
//! ```

mod colour;
mod convolve;
pub mod difference;
pub mod flip;
mod header;
pub mod read;
pub mod relative_error;
pub mod tiles;

use std::borrow::Cow;

use serde::Serialize;

use crate::{Error, Result, memory, quote};
use flip::HdrFlip;
use read::ExrPicture;
use relative_error::{mean, mean_squared, relative_mse};
use tiles::TileTest;

/// How far a picture is from a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Pixels of the picture with a channel that is not finite.
    pub not_finite: usize,
    /// The same of the reference.
    pub not_finite_reference: usize,
    /// Pixels that are finite in one of the two alone: 0 where the same pixels are not finite in both.
    pub not_finite_in_one: usize,
    /// Figures over the pixels that are finite in both; `None` where there is no such pixel.
    pub figures: Option<Figures>,
    /// FLIP over the pixels that are finite in both.
    pub hdr_flip: Option<HdrFlip>,
    /// Why there is no FLIP, where there is none.
    pub hdr_flip_missing: Option<String>,
    /// Test of tiles; `None` without a variance layer.
    pub tiles: Option<TileTest>,
}

/// Figures over pixels and channels alike, in the pictures' own units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Mean of (a - b)² / (b² + 0.01).
    pub relative_mse: f64,
    /// Square root of the mean of (a - b)².
    pub rmse: f64,
    /// Peak of the PSNR.
    pub peak: f64,
    /// 20 log10(peak / RMSE) in dB; `None` where the pictures are equal or the peak is 0.
    pub psnr_db: Option<f64>,
    /// Mean of the picture over that of the reference; `None` where the latter is 0.
    pub mean_ratio: Option<f64>,
    /// Largest |a - b|.
    pub largest: f64,
}

impl Comparison {
    /// Compares `picture` with `reference`, pixel by pixel. `peak` of the PSNR: the reference's largest value where not
    /// given.
    ///
    /// Fails with [`Error::Usage`] where their data windows differ.
    pub fn of(picture: &ExrPicture, reference: &ExrPicture, peak: Option<f64>) -> Result<Comparison> {
        if picture.window != reference.window {
            return Err(Error::Usage(format!(
                "{}: its data window is {}, that of {} is {}; pictures are compared pixel by pixel, and the \
                 windows must be the same",
                quote::path(&picture.path),
                picture.window,
                quote::path(&reference.path),
                reference.window
            )));
        }
        let not_finite = |picture: &ExrPicture| picture.rgb.iter().filter(|rgb| !finite(rgb)).count();
        let [in_picture, in_reference] = [not_finite(picture), not_finite(reference)];
        let both = picture.rgb.iter().zip(&reference.rgb);
        let in_one = both.filter(|(a, b)| finite(a) != finite(b)).count();
        let (a, b) = match in_picture + in_reference {
            0 => (Cow::Borrowed(&picture.rgb), Cow::Borrowed(&reference.rgb)),
            _ => finite_in_both(picture, reference)?,
        };
        let size = [picture.window.width, picture.window.height];
        let hdr_flip = flip::hdr(&picture.rgb, &reference.rgb, size);
        Ok(Comparison {
            size,
            not_finite: in_picture,
            not_finite_reference: in_reference,
            not_finite_in_one: in_one,
            figures: figures(&a, &b, peak),
            hdr_flip_missing: hdr_flip.as_ref().err().cloned(),
            hdr_flip: hdr_flip.ok(),
            tiles: tiles::test(picture, reference),
        })
    }
}

/// Colours of the pixels that are finite in both pictures.
type Finite<'a> = Cow<'a, Vec<[f32; 3]>>;

fn finite_in_both<'a>(picture: &'a ExrPicture, reference: &'a ExrPicture) -> Result<(Finite<'a>, Finite<'a>)> {
    let pixels = picture.rgb.len();
    memory::check("the pixels that are finite", 2 * size_of::<[f32; 3]>() as u64 * pixels as u64)?;
    let (mut a, mut b) = (Vec::with_capacity(pixels), Vec::with_capacity(pixels));
    for (of_a, of_b) in picture.rgb.iter().zip(&reference.rgb).filter(|(a, b)| finite(a) && finite(b)) {
        a.push(*of_a);
        b.push(*of_b);
    }
    Ok((Cow::Owned(a), Cow::Owned(b)))
}

/// Whether all channels are numbers.
pub fn finite(rgb: &[f32; 3]) -> bool {
    rgb.iter().all(|channel| channel.is_finite())
}

fn figures(a: &[[f32; 3]], b: &[[f32; 3]], peak: Option<f64>) -> Option<Figures> {
    let relative_mse = relative_mse(a, b)?;
    let rmse = mean_squared(a, b)?.sqrt();
    let largest_of = |values: &[[f32; 3]]| values.iter().flatten().fold(0.0, |most, &x| f64::from(x).max(most));
    let peak = peak.unwrap_or_else(|| largest_of(b));
    let distances = a.iter().flatten().zip(b.iter().flatten()).map(|(&a, &b)| (f64::from(a) - f64::from(b)).abs());
    Some(Figures {
        relative_mse,
        rmse,
        peak,
        psnr_db: Some(20.0 * (peak / rmse).log10()).filter(|psnr| psnr.is_finite()),
        mean_ratio: Some(mean(a) / mean(b)).filter(|ratio| ratio.is_finite()),
        largest: distances.fold(0.0, f64::max),
    })
}
