//! What writing a picture takes, known before there is one: bytes on the disk and bytes of memory.
//!
//! Comes in: a format, a size and a number of layers. Goes out: upper bounds. No compression is counted on: noise does
//! not compress.

use std::collections::BTreeMap;
use std::path::Path;

use super::Format;
use super::place::Place;
use super::temporary::folder_of;
use crate::memory::mebibytes;
use crate::{Error, Result};

/// Bytes of a file beside its pixels: the header with its facts, tables of lines.
const HEADER_BYTES: u64 = 1 << 16;
/// Lines of a block of an EXR file, which are compressed together.
const EXR_LINES: u64 = 16;
/// Bytes that a worker of the compressor takes beside its lines: tables, and what it touches of its stack.
const WORKER_BYTES: u64 = 1 << 20;

/// Size of a picture to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Channels beside red, green and blue, for formats that hold them.
    pub further_channels: u32,
}

impl Extent {
    fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    fn channels(self) -> u64 {
        3 + u64::from(self.further_channels)
    }

    /// Bytes of memory that the picture itself takes: its pixels, variances on the way to layers, and the layers.
    pub fn picture_bytes(self) -> u64 {
        let variances = if self.further_channels > 0 { 24 } else { 0 };
        self.pixels() * (12 + variances + 4 * u64::from(self.further_channels))
    }
}

impl Format {
    /// Bytes that the file has at most.
    pub fn file_bytes(self, extent: Extent) -> u64 {
        let (pixels, lines) = (extent.pixels(), u64::from(extent.height));
        HEADER_BYTES
            + match self {
                // A block that does not get smaller is stored as it is; each has an offset and a small header.
                Format::Exr => 4 * extent.channels() * pixels + 32 * lines,
                // A byte per line names its filter; what does not get smaller grows by less than a thousandth.
                Format::Png => 3 * pixels + lines + pixels / 64,
                // A run length per 128 bytes, and 4 bytes per line.
                Format::Hdr => 4 * pixels + pixels / 16 + 8 * lines,
            }
    }

    /// Bytes of memory that encoding takes at most beside the picture, the file's own bytes included.
    pub fn encoding_bytes(self, extent: Extent) -> u64 {
        let (pixels, file) = (extent.pixels(), self.file_bytes(extent));
        match self {
            // A copy of each channel, and blocks on their way through the compressor: two per worker, in several forms.
            Format::Exr => {
                let workers = std::thread::available_parallelism().map_or(1, usize::from) as u64;
                let busy = (workers + 2).min(u64::from(extent.height).div_ceil(EXR_LINES));
                let block = 4 * extent.channels() * u64::from(extent.width) * EXR_LINES;
                file + 4 * extent.channels() * pixels + busy * (WORKER_BYTES + 6 * block)
            }
            // Pixels of three bytes, filtered, compressed into a growing buffer (which is copied when it grows), and
            // the file.
            Format::Png => 6 * file,
            // Pixels of three floats, and the same.
            Format::Hdr => 12 * pixels + 4 * file,
        }
    }
}

/// Refuses files, each a path and its bytes at most, for which their disks have no room, as far as the system says how
/// much they have. Old files of these names are not counted as room: they stay until the new ones are complete. A
/// device or a pipe needs none.
pub fn check_room<'a>(files: impl IntoIterator<Item = (&'a Path, u64)>) -> Result<()> {
    // What was promised to the files before, by disk.
    let mut promised: BTreeMap<u64, u64> = BTreeMap::new();
    for (path, bytes) in files {
        let Ok(place) = Place::of(path) else { continue };
        let Some((disk, room)) = room(folder_of(place.target())).filter(|_| place.is_file()) else { continue };
        let before = promised.entry(disk).or_default();
        let left = room.saturating_sub(*before);
        if bytes > left {
            let (need, have) = (mebibytes(bytes), mebibytes(left));
            return Err(Error::output(path, format!("the disk has no room: {need} needed at most, {have} available")));
        }
        *before += bytes;
    }
    Ok(())
}

/// The disk that a folder is on, and the bytes that it has for this user.
#[cfg(unix)]
fn room(folder: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    let disk = folder.metadata().ok()?.dev();
    let all = rustix::fs::statvfs(folder).ok()?;
    // A file system without a size of its own says 0.
    (all.f_blocks > 0).then_some((disk, all.f_bavail.saturating_mul(all.f_frsize)))
}

#[cfg(not(unix))]
fn room(_: &Path) -> Option<(u64, u64)> {
    None
}

#[cfg(test)]
mod tests {
    use super::super::{Display, Layer, Metadata, Picture, exr, hdr, png};
    use super::*;

    /// Noise, which no format makes smaller: bits without pattern, in the range of floats.
    fn noise(count: usize) -> impl Iterator<Item = f32> {
        let mut state = 1u64;
        (0..count).map(move |_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            f32::from_bits((state >> 35) as u32 & 0x3fff_ffff)
        })
    }

    #[test]
    fn files_of_noise_are_within_their_bounds() {
        for [width, height] in [[1, 1], [1, 5000], [5000, 1], [317, 201]] {
            let pixels = (width * height) as usize;
            let mut values = noise(3 * pixels);
            let rgb = (0..pixels).map(|_| [0; 3].map(|_| values.next().unwrap())).collect();
            let layer = Layer { name: "samples", channels: vec![("Y", noise(pixels).collect())] };
            let picture = Picture::new(width, height, None, rgb).unwrap().with_layers(vec![layer]).unwrap();
            let extent = Extent { width, height, further_channels: 1 };
            for (format, bytes) in [
                (Format::Exr, exr::encode(&picture, &Metadata::new()).unwrap()),
                (Format::Png, png::encode(&picture, &Display::default(), &Metadata::new()).unwrap()),
                (Format::Hdr, hdr::encode(&picture, &Metadata::new()).unwrap()),
            ] {
                let most = format.file_bytes(extent);
                assert!(bytes.len() as u64 <= most, "{format:?} of {width}x{height}: {} of {most}", bytes.len());
            }
        }
    }

    #[test]
    fn what_no_disk_has_room_for_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        let Some((_, room)) = room(folder.path()) else { return };
        check_room([(a.as_path(), 1), (b.as_path(), 1)]).unwrap();
        let error = check_room([(a.as_path(), room / 4 * 3), (b.as_path(), room / 4 * 3)]).unwrap_err();
        assert!(error.exit_code() == 5 && error.to_string().contains("b.exr: the disk has no room"), "{error}");
    }
}
