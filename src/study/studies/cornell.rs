//! The Cornell box beside what is published of it: a section of the report.
//!
//! Comes in: our picture of the box by the published camera. Goes out: the picture beside Mitsuba 3's of the same data,
//! how far apart they are, and in words what is compared and what is not. The photograph and the spectra that Cornell
//! measured are not in any package registry, so no figure here is against a measurement of light.

use crate::compare::read::{DataWindow, ExrPicture};
use crate::compare::{Comparison, difference::luminance};
use crate::report::{Block, NamedPicture, Pictures, Section, Table};
use crate::scene::{Filter, Scene};
use crate::{Error, Result};

/// Width and height of the reference in pixels.
pub const SIDE: u32 = 64;
/// Vertical field of view in degrees of the published camera: 2 atan(0.0125 / 0.035), a film of 25 mm behind a focal
/// length of 35 mm.
pub const VFOV: f64 = 39.307_7;
/// Surface scatterings of a path in the reference.
pub const MAX_BOUNCES: u32 = 8;
/// Samples a pixel of the reference, over its 16 seeds.
const REFERENCE_SPP: u32 = 16 * 512;
/// Mean, then variance of the mean, of each pixel and channel, f32 little-endian; made by
/// `tests/golden/mitsuba_golden.py`.
const REFERENCE: &[u8] = include_bytes!("../../../tests/golden/cornell-box.bin");

/// A render of the box as the reference was rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxRender {
    /// Radiance, [`SIDE`]² pixels in rows from the top, in the file's units.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of each pixel's mean, where it is known.
    pub variance: Option<Vec<[f32; 3]>>,
    /// Samples a pixel.
    pub spp: u32,
    /// Wall time of rendering in seconds.
    pub seconds: f64,
}

/// Gives `scenes/cornell-box.toml` the reference's film: square, by a box filter, the field of view the published one.
/// Position and direction of its camera are the published ones already. To be rendered with [`MAX_BOUNCES`].
pub fn prepare(scene: &mut Scene) {
    (scene.film.width, scene.film.height, scene.film.filter) = (SIDE, SIDE, Filter::Box);
    scene.camera.vfov = VFOV;
}

/// The section. `command` remakes it.
///
/// Fails with [`Error::Usage`] where the picture is not of [`SIDE`]² pixels.
pub fn section(ours: &BoxRender, command: &str) -> Result<Section> {
    let [mean, variance] = reference()?;
    let ours_name = format!("texray, {} spp", ours.spp);
    let theirs_name = format!("Mitsuba 3.9.1, {REFERENCE_SPP} spp");
    let a = as_picture(&ours_name, ours.rgb.clone(), ours.variance.clone());
    let b = as_picture(&theirs_name, mean, Some(variance));
    if a.rgb.len() != b.rgb.len() {
        return Err(Error::Usage(format!("a picture of {} pixels, {SIDE}x{SIDE} needed", a.rgb.len())));
    }
    let comparison = Comparison::of(&a, &b, None)?;
    let named = |picture: &ExrPicture, name: &str| NamedPicture {
        name: name.into(),
        width: SIDE,
        height: SIDE,
        rgb: picture.rgb.clone(),
    };
    let pictures = Pictures {
        title: "The Cornell box by the published camera".into(),
        pictures: vec![named(&a, &ours_name), named(&b, &theirs_name)],
        reference: Some(1),
    };
    let blocks = vec![
        Block::Pictures(pictures),
        Block::Table(figures(&comparison, &a, &b)),
        Block::Text("What is compared, and what cannot be:".into()),
        Block::Table(compared()),
        Block::Text(
            "No registry of packages (crates.io, PyPI, npm, Debian) has Cornell's photograph, its calibrated camera \
             data or its measured spectra. Agreement with another renderer of the same numbers shows that both solve \
             the same equation; it does not show how near either is to the box in Cornell's laboratory."
                .into(),
        ),
    ];
    let finding = finding(&comparison, ours);
    Ok(Section { id: "cornell".into(), title: "The Cornell box".into(), finding, command: command.into(), blocks })
}

fn finding(comparison: &Comparison, ours: &BoxRender) -> Vec<String> {
    let mut finding = Vec::new();
    match &comparison.figures {
        Some(figures) => finding.push(format!(
            "With {} samples a pixel ({:.1} s) our picture of the published data is {:.2} % from Mitsuba's (relative \
             RMSE over pixels and channels){}.",
            ours.spp,
            ours.seconds,
            100.0 * figures.relative_mse.sqrt(),
            figures.mean_ratio.map_or(String::new(), |ratio| format!(", its mean {ratio:.4} of Mitsuba's"))
        )),
        None => finding.push("No pixel of the picture is finite: there is nothing to compare.".into()),
    }
    if let Some(tiles) = comparison.tiles {
        let largest = tiles.largest_z.map_or("unknown".into(), |z| format!("{z:.1}"));
        finding.push(format!(
            "{} of {} tests of tiles (16x16 pixels, a channel) find more than noise; the largest |z| is {largest}, \
             of so many tests {:.1} is the limit.",
            tiles.failed, tiles.tests, tiles.critical_z
        ));
    }
    finding
}

fn figures(comparison: &Comparison, ours: &ExrPicture, theirs: &ExrPicture) -> Table {
    // Where the light, both walls, both boxes and the floor are seen, in pixels of the reference.
    const PLACES: [(&str, [usize; 4]); 5] = [
        ("left wall (red)", [2, 24, 6, 16]),
        ("right wall (green)", [56, 24, 6, 16]),
        ("back wall, middle", [26, 16, 12, 6]),
        ("floor, front", [24, 57, 16, 5]),
        ("whole picture", [0, 0, SIDE as usize, SIDE as usize]),
    ];
    let mut rows: Vec<Vec<String>> = PLACES
        .iter()
        .map(|(name, place)| {
            let (a, b) = (mean_luminance(&ours.rgb, *place), mean_luminance(&theirs.rgb, *place));
            vec![(*name).into(), format!("{a:.4}"), format!("{b:.4}"), format!("{:+.2} %", 100.0 * (a / b - 1.0))]
        })
        .collect();
    if let Some(flip) = comparison.hdr_flip {
        rows.push(vec!["HDR-FLIP, mean".into(), format!("{:.4}", flip.mean)]);
    }
    let columns = ["mean luminance of", "texray", "Mitsuba", "difference"].map(String::from);
    Table { columns: columns.into(), rows }
}

fn mean_luminance(rgb: &[[f32; 3]], [x, y, width, height]: [usize; 4]) -> f64 {
    let rows = rgb.chunks(SIDE as usize).skip(y).take(height);
    let pixels = rows.flat_map(|row| row.iter().skip(x).take(width));
    pixels.map(|&pixel| luminance(pixel)).sum::<f64>() / (width * height) as f64
}

fn compared() -> Table {
    let row = |cells: [&str; 4]| cells.map(String::from).to_vec();
    Table {
        columns: ["quantity", "published by Cornell", "here", "compared"].map(String::from).into(),
        rows: vec![
            row(["camera", "at (278, 273, -800) mm, along +z, focal length 35 mm, film 25x25 mm", "the same", "yes"]),
            row(["walls and boxes", "corners in mm, measured", "the same, in units of 100 mm", "yes"]),
            row([
                "light",
                "a hole of 130x105 mm in the ceiling",
                "the same; the light fills the hole",
                "yes, with Mitsuba",
            ]),
            row([
                "reflectances",
                "spectra, 400 to 700 nm in steps of 4 nm",
                "linear RGB as Mitsuba 3's cornell_box() lists them",
                "in RGB, with Mitsuba; not as spectra",
            ]),
            row([
                "light's spectrum",
                "four values, 400 to 700 nm",
                "linear RGB (18.4, 14.0, 6.75)",
                "in RGB, with Mitsuba",
            ]),
            row(["photograph", "CCD behind seven narrow filters", "", "no: it cannot be had here"]),
            row(["bounces", "all there are", "8, in both renderers", "yes; what lies beyond is in neither"]),
        ],
    }
}

fn as_picture(name: &str, rgb: Vec<[f32; 3]>, variance: Option<Vec<[f32; 3]>>) -> ExrPicture {
    let window = DataWindow { x: 0, y: 0, width: SIDE as usize, height: SIDE as usize };
    ExrPicture { path: name.into(), layer: String::new(), window, rgb, variance }
}

/// Mean and variance of the mean.
fn reference() -> Result<[Vec<[f32; 3]>; 2]> {
    let numbers: Vec<f32> = REFERENCE.as_chunks::<4>().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
    let mut mean = numbers.as_chunks::<3>().0.to_vec();
    let pixels = (SIDE * SIDE) as usize;
    if mean.len() != 2 * pixels {
        return Err(Error::Internal(format!("the stored reference has {} pixels", mean.len())));
    }
    let variance = mean.split_off(pixels);
    Ok([mean, variance])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendered(factor: f32) -> BoxRender {
        let [mean, variance] = reference().unwrap();
        let rgb = mean.iter().map(|rgb| rgb.map(|channel| channel * factor)).collect();
        BoxRender { rgb, variance: Some(variance), spp: 1024, seconds: 2.0 }
    }

    #[test]
    fn the_field_of_view_is_the_published_one() {
        assert!((VFOV - 2.0 * (0.0125f64 / 0.035).atan().to_degrees()).abs() < 1e-4);
    }

    #[test]
    fn the_section_tells_how_far_apart_they_are() {
        let same = section(&rendered(1.0), "texray study thesis").unwrap();
        assert!(same.finding[0].contains("0.00 % from Mitsuba's") && same.finding[0].contains("1.0000"), "{same:?}");
        assert!(same.finding[1].starts_with("0 of 48 tests"), "{:?}", same.finding);
        let brighter = section(&rendered(1.05), "").unwrap();
        assert!(brighter.finding[0].contains("mean 1.0500 of"), "{:?}", brighter.finding);
        assert!(!brighter.finding[1].starts_with("0 of"), "{:?}", brighter.finding);
        let Block::Table(table) = &brighter.blocks[1] else { panic!("a table") };
        assert!(table.rows[..5].iter().all(|row| row[3] == "+5.00 %"), "{table:?}");
        let small = BoxRender { rgb: vec![[0.0; 3]; 4], ..rendered(1.0) };
        assert!(section(&small, "").is_err());
    }
}
