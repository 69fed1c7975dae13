//! OpenEXR files of any renderer: layers and channels to a picture of linear radiance.
//!
//! Comes in: a path and, where the file has several pictures, the name of one. Goes out: an [`ExrPicture`]. Layers may
//! be parts of the file (`beauty`) or prefixes of channel names (`ViewLayer.Combined.R`); samples may be half, float or
//! unsigned. Refused by name: subsampled channels, deep data, a file without R, G and B or Y.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use exr::meta::{BlockDescription, MetaData, header::Header};
use exr::prelude::read_all_flat_layers_from_file;

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
    let names = || layers.iter().map(|name| shown(name)).collect::<Vec<_>>().join(", ");
    let chosen = match layer {
        Some(wanted) => layers.iter().find(|name| name.as_str() == wanted).ok_or_else(|| {
            refused(format!("no layer {wanted:?} with channels R, G, B or Y; the file has {}", names()))
        })?,
        None => {
            let plain = layers.iter().find(|name| name.is_empty());
            let others: Vec<&String> = layers.iter().filter(|name| name.as_str() != VARIANCE_LAYER).collect();
            match (plain, others.as_slice()) {
                (Some(plain), _) => plain,
                (None, [only]) => only,
                (None, []) => {
                    let have: Vec<&str> = channels.keys().map(String::as_str).collect();
                    return Err(refused(format!("channels R, G, B or Y needed, {} found", have.join(", "))));
                }
                _ => return Err(refused(format!("several pictures: name one with --layer, of {}", names()))),
            }
        }
    };
    let (window, rgb) = colours(path, &channels, chosen)?;
    let variance_layer = if chosen.is_empty() { VARIANCE_LAYER.into() } else { format!("{chosen}.{VARIANCE_LAYER}") };
    let variance = [variance_layer, VARIANCE_LAYER.into()].into_iter().find(|name| layers.contains(name));
    let variance = variance.map(|name| colours(path, &channels, &name)).transpose()?;
    let variance = variance.filter(|(of, _)| *of == window).map(|(_, variance)| variance);
    Ok(ExrPicture { path: path.into(), layer: chosen.clone(), window, rgb, variance })
}

/// Bytes of memory that a sample takes: as the file has it, and as f32.
const SAMPLE_BYTES: u64 = 8;

/// Refuses a file whose headers, true or not, ask for more memory than there is; the reader allocates what they say.
fn check_memory(path: &Path) -> Result<()> {
    let headers = MetaData::read_from_file(path, false).map_err(|error| unreadable(path, &error))?.headers;
    let samples = |header: &Header| {
        let area = |width: usize, height: usize| (width as u64).saturating_mul(height as u64);
        let block = match header.blocks {
            BlockDescription::Tiles(tiles) => area(tiles.tile_size.width(), tiles.tile_size.height()),
            BlockDescription::ScanLines => 0,
        };
        let pixels = area(header.layer_size.width(), header.layer_size.height()).saturating_add(block);
        pixels.saturating_mul(header.channels.list.len() as u64)
    };
    let all = headers.iter().map(samples).fold(0, u64::saturating_add);
    memory::check(&format!("{}: its pixels by its header", path.display()), all.saturating_mul(SAMPLE_BYTES))
}

fn unreadable(path: &Path, error: &exr::error::Error) -> Error {
    Error::scene(path, 0, format!("not a readable OpenEXR file: {error}"))
}

/// All channels by their full names: part, layers, channel, joined by dots.
fn channels(path: &Path) -> Result<BTreeMap<String, Channel>> {
    check_memory(path)?;
    let image = read_all_flat_layers_from_file(path).map_err(|error| unreadable(path, &error))?;
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
            let values = channel.sample_data.values_as_f32().collect();
            channels.entry(full).or_insert(Channel { window, sampling, values });
        }
    }
    Ok(channels)
}

/// Layers that have R, G and B, or Y.
fn coloured(channels: &BTreeMap<String, Channel>) -> Vec<String> {
    let layer_of = |name: &str| name.rsplit_once('.').map_or(String::new(), |(layer, _)| layer.into());
    let mut layers: Vec<String> = channels.keys().map(|name| layer_of(name)).collect();
    layers.sort();
    layers.dedup();
    let has = |layer: &str, channel: &str| channels.contains_key(&join(layer, channel));
    layers.retain(|layer| ["R", "G", "B"].iter().all(|channel| has(layer, channel)) || has(layer, "Y"));
    layers
}

fn join(layer: &str, channel: &str) -> String {
    if layer.is_empty() { channel.into() } else { format!("{layer}.{channel}") }
}

fn shown(layer: &str) -> String {
    if layer.is_empty() { "R, G, B without a layer".into() } else { format!("{layer:?}") }
}

fn colours(path: &Path, channels: &BTreeMap<String, Channel>, layer: &str) -> Result<(DataWindow, Vec<[f32; 3]>)> {
    let refused = |message: String| Err(Error::scene(path, 0, message));
    let find = |name: &str| channels.get(&join(layer, name));
    let [r, g, b] = match (find("R"), find("G"), find("B"), find("Y")) {
        (Some(r), Some(g), Some(b), _) => [r, g, b],
        (_, _, _, Some(y)) => [y, y, y],
        _ => return refused(format!("layer {} has no channels R, G, B", shown(layer))),
    };
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
