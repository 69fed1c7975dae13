//! OpenEXR files of any renderer: layers and channels to a picture of linear radiance.
//!
//! Comes in: a path and, where the file has several pictures, the name of one. Goes out: an [`ExrPicture`]. Layers may
//! be parts of the file (`beauty`) or prefixes of channel names (`ViewLayer.Combined.R`, `Ci.r`), also empty ones
//! (`.R`); channels are R, G, B in either case; samples may be half, float or unsigned. Refused by name: subsampled
//! channels, deep data, a file without R, G and B or Y.

use std::collections::BTreeMap;
use std::fmt;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read as read_layers};

use super::header::{check, unreadable};
use crate::input_file::Input;
use crate::quote::{self, quoted};
use crate::{Error, Result, memory};

/// Layer of the per-pixel variance of the mean, a channel each, beside the picture's own.
pub const VARIANCE_LAYER: &str = "variance";

/// A picture from a file, linear radiance in the file's units.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPicture {
    /// The file.
    pub path: PathBuf,
    /// The layer taken; empty for the channels without a layer.
    pub layer: String,
    /// Where the pixels lie in the image.
    pub window: DataWindow,
    /// A pixel each, in rows from the top.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of each pixel's mean, where the file has it.
    pub variance: Option<Vec<[f32; 3]>>,
}

/// The data window of a layer: its upper left pixel and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataWindow {
    /// Left column, counted from the display window's.
    pub x: i32,
    /// Top row, counted from the display window's.
    pub y: i32,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
}

impl fmt::Display for DataWindow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{} at ({}, {})", self.width, self.height, self.x, self.y)
    }
}

/// One channel's samples.
struct Channel {
    window: DataWindow,
    sampling: (usize, usize),
    values: Vec<f32>,
}

/// Reads a picture: of `layer`, or of the file's unnamed channels, or of its only layer that has colours.
///
/// Fails with [`Error::Scene`], as for any input, where the file cannot be read or has no such picture, and with
/// [`Error::Limit`] where its pixels would not fit in memory.
pub fn read(path: &Path, layer: Option<&str>) -> Result<ExrPicture> {
    let channels = channels(path)?;
    let layers = coloured(&channels);
    let refused = |message: String| Error::scene(path, 0, message);
    let names = || listed(layers.keys().map(|name| shown(name)));
    let chosen = match layer {
        Some(wanted) => named(&layers, wanted).ok_or_else(|| {
            refused(format!("no layer {} with channels R, G, B or Y; the file has {}", quoted(wanted), names()))
        })?,
        None => {
            let plain = layers.keys().find(|name| name.is_empty());
            let others: Vec<&String> = layers.keys().filter(|name| name.as_str() != VARIANCE_LAYER).collect();
            match (plain, others.as_slice()) {
                (Some(plain), _) => plain,
                (None, [only]) => only,
                (None, []) => {
                    let have = listed(channels.keys().map(|name| quote::shown(name)));
                    return Err(refused(format!("channels R, G, B or Y needed, {have} found")));
                }
                _ => return Err(refused(format!("several pictures: name one with --layer, of {}", names()))),
            }
        }
    };
    let (window, rgb) = colours(path, &channels, chosen, &layers[chosen])?;
    let variance_layer = if chosen.is_empty() { VARIANCE_LAYER.into() } else { format!("{chosen}.{VARIANCE_LAYER}") };
    let variance = [variance_layer, VARIANCE_LAYER.into()].into_iter().find_map(|name| layers.get_key_value(&name));
    let variance = variance.map(|(name, names)| colours(path, &channels, name, names)).transpose()?;
    let variance = variance.filter(|(of, _)| *of == window).map(|(_, variance)| variance);
    Ok(ExrPicture { path: path.into(), layer: chosen.clone(), window, rgb, variance })
}

/// All channels by their full names: part, layers, channel, joined by dots.
fn channels(path: &Path) -> Result<BTreeMap<String, Channel>> {
    let mut input = Input::open(path).map_err(|reason| unreadable(path, &reason))?;
    check(path, &mut input)?;
    let reader = read_layers().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    // Under a limit of the address space the heaps of its threads would take what the pixels need.
    let reader = if memory::threads() == cores() { reader } else { reader.non_parallel() };
    let image = reader.from_buffered(BufReader::new(input));
    let image = image.map_err(|error| unreadable(path, &error.to_string()))?;
    let mut channels = BTreeMap::new();
    for part in image.layer_data {
        let position = part.attributes.layer_position;
        let window =
            DataWindow { x: position.x(), y: position.y(), width: part.size.width(), height: part.size.height() };
        let part_name = part.attributes.layer_name.map(|name| name.to_string()).unwrap_or_default();
        for channel in part.channel_data.list {
            let name = channel.name.to_string();
            // Some writers name the part and repeat that name in its channels.
            let full = match part_name.is_empty() || name.starts_with(&format!("{part_name}.")) {
                true => name,
                false => format!("{part_name}.{name}"),
            };
            let sampling = (channel.sampling.x(), channel.sampling.y());
            let values = match channel.sample_data {
                FlatSamples::F32(values) => values,
                FlatSamples::F16(values) => values.into_iter().map(|value| value.to_f32()).collect(),
                FlatSamples::U32(values) => values.into_iter().map(|value| value as f32).collect(),
            };
            channels.entry(full).or_insert(Channel { window, sampling, values });
        }
    }
    Ok(channels)
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Layers that have R, G and B, or Y, with the full names of these channels.
fn coloured(channels: &BTreeMap<String, Channel>) -> BTreeMap<String, [&str; 3]> {
    let mut layers: BTreeMap<String, BTreeMap<&str, &str>> = BTreeMap::new();
    for full in channels.keys() {
        // V-Ray writes an empty layer: `.R`.
        let (layer, channel) = full.rsplit_once('.').unwrap_or(("", full));
        layers.entry(layer.into()).or_default().entry(channel).or_insert(full);
    }
    layers.into_iter().filter_map(|(layer, channels)| Some((layer, colour_names(&channels)?))).collect()
}

/// Of a layer's channels by their own names, the full names of R, G and B, or of Y thrice.
fn colour_names<'a>(channels: &BTreeMap<&str, &'a str>) -> Option<[&'a str; 3]> {
    let find = |names: [&str; 2]| names.iter().find_map(|name| channels.get(name).copied());
    if let (Some(r), Some(g), Some(b)) = (find(["R", "r"]), find(["G", "g"]), find(["B", "b"])) {
        return Some([r, g, b]);
    }
    // The Y of X, Y, Z is a coordinate.
    let is_coordinate = ["X", "Z"].iter().any(|name| channels.contains_key(name));
    channels.get("Y").filter(|_| !is_coordinate).map(|grey| [*grey; 3])
}

/// The layer of this name, or else the one whose name differs by letter case alone.
fn named<'a>(layers: &'a BTreeMap<String, [&str; 3]>, wanted: &str) -> Option<&'a String> {
    let alike = |name: &&String| name.to_lowercase() == wanted.to_lowercase();
    layers.get_key_value(wanted).map(|(name, _)| name).or_else(|| {
        let mut found = layers.keys().filter(alike);
        let first = found.next()?;
        found.next().is_none().then_some(first)
    })
}

/// Names that a message lists.
const LISTED: usize = 16;

/// The first names, and that there are others.
fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let more = names.len().saturating_sub(LISTED);
    let first = names.take(LISTED).collect::<Vec<_>>().join(", ");
    if more == 0 { first } else { format!("{first} and {more} more") }
}

fn shown(layer: &str) -> String {
    if layer.is_empty() { "R, G, B without a layer".into() } else { quoted(layer) }
}

fn colours(
    path: &Path,
    channels: &BTreeMap<String, Channel>,
    layer: &str,
    names: &[&str; 3],
) -> Result<(DataWindow, Vec<[f32; 3]>)> {
    let refused = |message: String| Err(Error::scene(path, 0, message));
    let [r, g, b] = names.map(|name| &channels[name]);
    if [r, g, b].iter().any(|channel| channel.sampling != (1, 1)) {
        return refused(format!("layer {} has subsampled channels; every pixel must have its own", shown(layer)));
    }
    let window = r.window;
    let pixels = window.width * window.height;
    if [r, g, b].iter().any(|channel| channel.window != window || channel.values.len() != pixels) {
        return refused(format!("the channels of layer {} have different data windows", shown(layer)));
    }
    Ok((window, (0..pixels).map(|i| [r.values[i], g.values[i], b.values[i]]).collect()))
}
