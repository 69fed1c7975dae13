//! `texray compare A.exr B.exr`: how far picture A is from the reference B.
//!
//! Comes in: two OpenEXR files of any renderer, limits. Goes out: figures as text or JSON on stdout, a difference
//! image, and whether the limits hold.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use texray::compare::difference::{Difference, LEGEND};
use texray::compare::read::{ExrPicture, read};
use texray::compare::{Comparison, Figures};
use texray::output::{Format, check_writable, write_whole};
use texray::{Error, Result, quote};

use super::save::same;
use super::{Outcome, parse, streams};

/// Hold a picture against a reference: relMSE, RMSE, PSNR, HDR-FLIP, a test of tiles, a difference image
///
/// The exit code is 1 where a limit given by --max-relmse, --max-rmse, --min-psnr, --max-flip or --max-failed-tests is
/// not kept. A pixel that is not finite in either picture is left out of the figures and counted; where it is finite in
/// the other, no limit is kept. A test of tiles, of 16x16 pixels and a channel, is done where a file has the layer
/// `variance` (render with --aov variance): it tells whether the difference is more than noise.
#[derive(Args)]
pub struct CompareArgs {
    /// The picture, OpenEXR of any renderer
    #[arg(value_name = "A.exr")]
    picture: PathBuf,
    /// The reference, with the same data window
    #[arg(value_name = "B.exr")]
    reference: PathBuf,
    /// Layer of A, where it has several pictures
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Layer of B, where it has several pictures
    #[arg(long, value_name = "NAME")]
    reference_layer: Option<String>,
    /// Peak of the PSNR [default: the reference's largest value]
    #[arg(long, value_name = "P", value_parser = parse::positive)]
    peak: Option<f64>,
    /// Write a difference image: blue where A is darker, orange where it is brighter
    #[arg(long, value_name = "FILE.png")]
    difference: Option<PathBuf>,
    /// Do not overwrite an existing file
    #[arg(long)]
    no_clobber: bool,
    /// Largest relative mean squared error
    #[arg(long, value_name = "X", value_parser = parse::not_negative)]
    max_relmse: Option<f64>,
    /// Largest root mean squared error
    #[arg(long, value_name = "X", value_parser = parse::not_negative)]
    max_rmse: Option<f64>,
    /// Smallest PSNR in dB
    #[arg(long, value_name = "DB", value_parser = parse::finite, allow_hyphen_values = true)]
    min_psnr: Option<f64>,
    /// Largest mean of HDR-FLIP, 0 to 1
    #[arg(long, value_name = "X", value_parser = parse::not_negative)]
    max_flip: Option<f64>,
    /// Most tests of tiles that may fail; needs a variance layer in one of the files
    #[arg(long, value_name = "N")]
    max_failed_tests: Option<usize>,
    /// Print one JSON document on stdout instead of text
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    picture: String,
    layer: &'a str,
    reference: String,
    reference_layer: &'a str,
    #[serde(flatten)]
    comparison: &'a Comparison,
    difference: Option<String>,
    exceeded: &'a [String],
}

impl CompareArgs {
    /// Reads, compares, writes, prints.
    pub fn run(&self) -> Result<Outcome> {
        if let Some(path) = &self.difference {
            self.check(path)?;
        }
        let picture = read(&self.picture, self.layer.as_deref())?;
        let reference = read(&self.reference, self.reference_layer.as_deref())?;
        let comparison = Comparison::of(&picture, &reference, self.peak)?;
        if self.max_failed_tests.is_some() && comparison.tiles.is_none() {
            return Err(Error::Usage("--max-failed-tests: neither file has a variance layer".into()));
        }
        if let Some(path) = &self.difference {
            self.write(path, &picture, &reference)?;
        }
        let exceeded = self.exceeded(&comparison);
        if self.json {
            streams::answer_json(&Document {
                schema: 1,
                picture: self.picture.display().to_string(),
                layer: &picture.layer,
                reference: self.reference.display().to_string(),
                reference_layer: &reference.layer,
                comparison: &comparison,
                difference: self.difference.as_ref().map(|path| path.display().to_string()),
                exceeded: &exceeded,
            })?;
        } else {
            streams::answer(&self.lines(&comparison).join("\n"))?;
        }
        Ok(if exceeded.is_empty() { Outcome::Done } else { Outcome::LimitsExceeded(exceeded) })
    }

    fn check(&self, path: &Path) -> Result<()> {
        if Format::of(path)? != Format::Png {
            return Err(Error::Usage(format!("{}: a difference image is a .png", quote::path(path))));
        }
        if [&self.picture, &self.reference].into_iter().any(|input| same(path, input)) {
            return Err(Error::Usage(format!("{}: the output is one of the pictures compared", quote::path(path))));
        }
        check_writable(path, self.no_clobber)
    }

    fn write(&self, path: &Path, picture: &ExrPicture, reference: &ExrPicture) -> Result<()> {
        let difference = Difference::of(&picture.rgb, &reference.rgb)
            .ok_or_else(|| Error::Internal("pictures of one window differ in size".into()))?;
        let side = |pixels: usize| u32::try_from(pixels).map_err(|error| Error::output(path, error.to_string()));
        let bytes = difference.png(side(picture.window.width)?, side(picture.window.height)?);
        write_whole(path, self.no_clobber, &bytes.map_err(|message| Error::output(path, message))?)
    }

    /// The limits that are not kept, a sentence each. What is unknown keeps no limit: figures of pictures one of which
    /// is not finite where the other is, or that have no pixel that is finite in both.
    fn exceeded(&self, comparison: &Comparison) -> Vec<String> {
        let figures = comparison.figures.filter(|_| comparison.not_finite_in_one == 0);
        let equal = figures.is_some_and(|figures| figures.rmse == 0.0);
        let mut exceeded = Vec::new();
        let mut limit = |option: &str, name: &str, limit: Option<f64>, value: Option<f64>, sign: f64| {
            let Some(limit) = limit else { return };
            match value {
                Some(value) if sign * value <= sign * limit => {}
                Some(value) => exceeded.push(format!("{name} {} is not within {option} {limit}", short(value))),
                None => exceeded.push(format!("{name} is unknown, so not within {option} {limit}")),
            }
        };
        limit("--max-relmse", "relMSE", self.max_relmse, figures.map(|figures| figures.relative_mse), 1.0);
        limit("--max-rmse", "RMSE", self.max_rmse, figures.map(|figures| figures.rmse), 1.0);
        let psnr = if equal { Some(f64::INFINITY) } else { figures.and_then(|figures| figures.psnr_db) };
        limit("--min-psnr", "PSNR", self.min_psnr, psnr, -1.0);
        limit(
            "--max-flip",
            "HDR-FLIP",
            self.max_flip,
            comparison.hdr_flip.filter(|_| figures.is_some()).map(|flip| flip.mean),
            1.0,
        );
        if let (Some(most), Some(tiles)) = (self.max_failed_tests, comparison.tiles) {
            let failed = tiles.failed + tiles.left_out;
            if comparison.figures.is_none() {
                exceeded.push(format!("no tile can be tested, so --max-failed-tests {most} is not kept"));
            } else if failed > most {
                exceeded.push(format!("{failed} tests of tiles fail, more than --max-failed-tests {most}"));
            }
        }
        exceeded
    }

    /// The figures, lines of at most 80 columns.
    fn lines(&self, comparison: &Comparison) -> Vec<String> {
        let mut lines = Vec::new();
        let mut line = |name: &str, text: String| lines.push(streams::folded(&format!("{name:<13}{text}"), 13));
        line("picture A", quote::path(&self.picture));
        line("reference B", quote::path(&self.reference));
        line("size", format!("{}x{}", comparison.size[0], comparison.size[1]));
        line(
            "not finite",
            match (comparison.not_finite, comparison.not_finite_reference) {
                (0, 0) => "no pixel".into(),
                (a, b) => format!("{a} pixels of A, {b} of B: left out of what follows"),
            },
        );
        match &comparison.figures {
            Some(figures) => describe(figures, self.peak.is_some(), &mut line),
            None => line("figures", "none, as no pixel is finite in both".into()),
        }
        match &comparison.hdr_flip {
            Some(flip) if flip.exposures == 0 => line("HDR-FLIP", "0: the pictures are equal, and black".into()),
            Some(flip) => line(
                "HDR-FLIP",
                format!(
                    "{} mean, {} largest, over {} exposures from {:.1} to {:.1} stops",
                    short(flip.mean),
                    short(flip.largest),
                    flip.exposures,
                    flip.start_stops,
                    flip.stop_stops
                ),
            ),
            None => {
                let why = comparison.hdr_flip_missing.as_deref().unwrap_or("no reason is known");
                line("HDR-FLIP", format!("unknown: {why}"));
            }
        }
        match &comparison.tiles {
            Some(tiles) => {
                let exact = match (tiles.exact_picture, tiles.exact_reference) {
                    (true, _) => "; A has no variance and counts as exact",
                    (_, true) => "; B has no variance and counts as exact",
                    _ => "",
                };
                let largest = tiles.largest_z.map_or("unknown".into(), |z| format!("{z:.2}"));
                line(
                    "tiles",
                    format!(
                        "{} of {} z tests fail, {} left out; largest |z| {largest}, critical {:.2}{exact}",
                        tiles.failed, tiles.tests, tiles.left_out, tiles.critical_z
                    ),
                );
            }
            None => line("tiles", "not tested: neither file has a variance layer".into()),
        }
        if let Some(path) = &self.difference {
            line("difference", format!("{}: {LEGEND}", quote::path(path)));
        }
        lines
    }
}

fn describe(figures: &Figures, given: bool, line: &mut impl FnMut(&str, String)) {
    let peak = if given { "as given" } else { "B's largest value" };
    line("relMSE", format!("{}, the mean of (A - B)² / (B² + 0.01)", short(figures.relative_mse)));
    line("RMSE", short(figures.rmse));
    line(
        "PSNR",
        match figures.psnr_db {
            Some(psnr) => format!("{psnr:.2} dB at a peak of {}, {peak}", short(figures.peak)),
            None if figures.rmse == 0.0 => "infinite: the pictures are equal".into(),
            None => "unknown: the peak is 0".into(),
        },
    );
    line("mean", figures.mean_ratio.map_or("unknown: B is black".into(), |ratio| format!("A / B = {ratio:.5}")));
    line("largest", format!("|A - B| = {}", short(figures.largest)));
}

/// Three digits, or the exponent where that would be long.
fn short(value: f64) -> String {
    match value {
        0.0 => "0".into(),
        _ if (1e-4..1e6).contains(&value.abs()) => {
            let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.2e}"),
    }
}
