//! What the headers of an OpenEXR file ask for, before anything of that size is allocated.
//!
//! Comes in: an open file. Goes out: nothing where its pixels can be in the file and fit in memory, else the refusal. A
//! header of a few bytes may claim any size, and the reader allocates what it says; so the attributes are walked first,
//! whose sizes must lie within the file, and then the claimed chunks and pixels are held against the file's size:
//! compression of every kind has a largest ratio.

use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use exr::compression::Compression;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData, mip_map_levels, rip_map_levels};

use crate::input_file::Input;
use crate::quote::{self, cut};
use crate::{Error, Result, memory};

/// Most parts of a file; programs write one a layer.
const MOST_PARTS: usize = 4096;
/// Longest name of an attribute, its zero included.
const LONGEST_NAME: u64 = 256;
/// Bytes of memory for a byte of the headers: names and values are kept several times, each with room to spare.
const HEADER_BYTES: u64 = 192;
/// Bytes of memory for a chunk: its place in the file, twice, and in the picture.
const CHUNK_BYTES: u64 = 160;
/// Bytes of memory for a pixel of the picture and of its variance, as they are handed on.
const PIXEL_BYTES: u64 = 24;
/// Bytes of memory for a byte of a block while it is decompressed.
const BLOCK_BYTES: u64 = 8;
/// Bytes of memory that decompressing takes whatever the size, as for tables of codes.
const FIXED_BYTES: u64 = 32 << 20;
/// Longest message of the reader that is passed on, in characters.
const MESSAGE: usize = 120;

/// The refusal of a file that cannot be read.
pub(super) fn unreadable(path: &Path, reason: &str) -> Error {
    Error::scene(path, 0, format!("not a readable OpenEXR file: {}", cut(reason, MESSAGE)))
}

/// Refuses `path` where its headers ask for more than the file or memory can hold. Leaves the file at its start.
pub(super) fn check(path: &Path, input: &mut Input) -> Result<()> {
    let refused = |reason: String| unreadable(path, &reason);
    let what = |what: &str| format!("{}: its {what}", quote::path(path));
    if let Some(message) = other_format(input) {
        return Err(Error::scene(path, 0, message));
    }
    rewind(path, input)?;
    let bytes = input.bytes;
    let length = walk(BufReader::new(&mut *input), bytes).map_err(refused)?;
    let of_headers = length.saturating_mul(HEADER_BYTES);
    memory::check(&what("headers"), of_headers)?;
    rewind(path, input)?;
    let headers = MetaData::read_from_buffered(BufReader::new(&mut *input), false)
        .map_err(|error| unreadable(path, &error.to_string()))?
        .headers;
    rewind(path, input)?;
    if headers.iter().any(|header| header.deep) {
        return Err(refused("deep data; allowed are flat pictures".into()));
    }
    let least = headers.iter().map(least_bytes).fold(u128::from(length), u128::saturating_add);
    if least > u128::from(input.bytes) {
        let text = "the pixels of its header take at least";
        return Err(refused(format!("{text} {least} bytes of file, and it has {}", input.bytes)));
    }
    // The reader keeps two blocks more than it has threads.
    let threads = memory::threads() as u64 + 2;
    let need = headers.iter().map(|header| memory_bytes(header, threads)).fold(of_headers, u64::saturating_add);
    memory::check(&what("pixels by its header"), need.saturating_add(FIXED_BYTES))
}

fn rewind(path: &Path, input: &mut Input) -> Result<()> {
    input.seek(SeekFrom::Start(0)).map(|_| ()).map_err(|error| unreadable(path, &error.to_string()))
}

/// First bytes of other pictures, their names, and why they do not hold what is compared.
const OTHER_FORMATS: [(&[u8], &str, &str); 8] = [
    (b"\x89PNG", "a PNG", "is tone-mapped and rounded"),
    (b"\xff\xd8\xff", "a JPEG", "is tone-mapped, rounded and compressed with losses"),
    (b"#?RADIANCE", "a Radiance HDR", "keeps 8 bits of a channel"),
    (b"#?RGBE", "a Radiance HDR", "keeps 8 bits of a channel"),
    (b"II*\0", "a TIFF", "may hold anything"),
    (b"MM\0*", "a TIFF", "may hold anything"),
    (b"RIFF", "a WebP", "is tone-mapped and rounded"),
    (b"PF\n", "a PFM", "has no layers"),
];

/// What to say of a picture of another format.
fn other_format(input: &mut Input) -> Option<String> {
    let mut start = Vec::new();
    input.by_ref().take(12).read_to_end(&mut start).ok()?;
    let (_, name, why) = OTHER_FORMATS.iter().find(|(magic, ..)| start.starts_with(magic))?;
    let kind = name.strip_prefix("a ").unwrap_or(name);
    Some(format!(
        "this is {name}, and compare takes OpenEXR: a {kind} {why}; render to a name that ends in .exr, or convert the \
         picture of linear radiance"
    ))
}

/// Walks over the attributes of all headers. Goes out: the bytes up to their end, or why they are none.
fn walk(mut reader: impl BufRead + Seek, bytes: u64) -> std::result::Result<u64, String> {
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(|_| "it ends before its header".to_owned())?;
    if start[..4] != exr::meta::magic_number::BYTES {
        return Err("it does not begin as one".into());
    }
    // Of the second word, the bits above the version's byte: several parts.
    let several = start[5] & 0x10 != 0;
    let mut place = 8;
    for _ in 0..MOST_PARTS {
        let mut attributes = 0;
        while let Some(length) = attribute(&mut reader)? {
            place += length;
            attributes += 1;
            if place > bytes {
                return Err("an attribute of its header reaches beyond its end".into());
            }
        }
        place += 1;
        if attributes == 0 || !several {
            return Ok(place);
        }
    }
    Err(format!("more than {MOST_PARTS} parts; allowed are as many"))
}

/// Bytes of the next attribute, over which the reader is moved; `None` behind the last one of a header.
fn attribute(reader: &mut (impl BufRead + Seek)) -> std::result::Result<Option<u64>, String> {
    let mut word = |least: u64| {
        let mut bytes = Vec::new();
        let read = reader.by_ref().take(LONGEST_NAME).read_until(0, &mut bytes);
        match read {
            Ok(_) if bytes.last() == Some(&0) && bytes.len() as u64 > least => Ok(bytes.len() as u64),
            _ => Err("its header has no end".to_owned()),
        }
    };
    let name = word(0)?;
    if name == 1 {
        return Ok(None);
    }
    let kind = word(1)?;
    let mut size = [0; 4];
    reader.read_exact(&mut size).map_err(|_| "its header has no end".to_owned())?;
    let Ok(size) = u32::try_from(i32::from_le_bytes(size)) else {
        return Err("an attribute of its header has less than no bytes".into());
    };
    reader.seek_relative(i64::from(size)).map_err(|error| error.to_string())?;
    Ok(Some(name + kind + 4 + u64::from(size)))
}

/// Bytes that all channels of a pixel have in the file, were every one there for every pixel.
fn sample_bytes(header: &Header) -> u64 {
    header.channels.list.iter().map(|channel| if channel.sample_type == SampleType::F16 { 2 } else { 4 }).sum()
}

/// Chunks that the header claims, of all levels.
fn chunks(header: &Header) -> u128 {
    let size = header.layer_size;
    let BlockDescription::Tiles(tiles) = header.blocks else {
        return size.height().div_ceil(header.compression.scan_lines_per_block().max(1)) as u128;
    };
    let of_level = |width: usize, height: usize| {
        let columns = width.div_ceil(tiles.tile_size.width().max(1)) as u128;
        columns * height.div_ceil(tiles.tile_size.height().max(1)) as u128
    };
    match tiles.level_mode {
        LevelMode::Singular => of_level(size.width(), size.height()),
        LevelMode::MipMap => mip_map_levels(tiles.rounding_mode, size)
            .map(|(_, level)| of_level(level.width(), level.height()))
            .fold(0, u128::saturating_add),
        LevelMode::RipMap => rip_map_levels(tiles.rounding_mode, size)
            .map(|(_, level)| of_level(level.width(), level.height()))
            .fold(0, u128::saturating_add),
    }
}

/// Least bytes of a file that holds what the header claims: a place and a head of each chunk, and the pixels compressed
/// as well as can be, a byte of each chunk at least.
fn least_bytes(header: &Header) -> u128 {
    let head = if header.blocks == BlockDescription::ScanLines { 8 } else { 20 };
    let area = |sampling: exr::math::Vec2<usize>| {
        let size = header.layer_size;
        (size.width() / sampling.width().max(1)) as u128 * (size.height() / sampling.height().max(1)) as u128
    };
    let of_channels = header.channels.list.iter().map(|channel| {
        let sample = if channel.sample_type == SampleType::F16 { 2 } else { 4 };
        area(channel.sampling).saturating_mul(sample)
    });
    let pixels = of_channels.fold(0, u128::saturating_add);
    let chunks = chunks(header);
    chunks.saturating_mul(8 + head).saturating_add(chunks.max(pixels / largest_ratio(header.compression)))
}

/// How many bytes one byte of a chunk can become at the most.
fn largest_ratio(compression: Compression) -> u128 {
    match compression {
        Compression::Uncompressed => 1,
        // Two bytes stand for a run of 128.
        Compression::RLE => 64,
        // A length code of one bit and a distance of one bit stand for 258 bytes.
        Compression::ZIP1 | Compression::ZIP16 => 1032,
        // Of the four bytes of a float, three are deflated.
        Compression::PXR24 => 1376,
        // A code of one bit and a count of eight stand for 255 samples of two bytes.
        Compression::PIZ => 454,
        // Three bytes stand for 16 samples of two bytes.
        Compression::B44 | Compression::B44A => 11,
        // Four deflated bytes stand for 64 samples of up to four bytes.
        Compression::DWAA(_) | Compression::DWAB(_) => 1032 * 64,
        // Not read by the reader.
        _ => u128::MAX,
    }
}

/// Bytes of memory that reading the header's part takes.
fn memory_bytes(header: &Header, threads: u64) -> u64 {
    let area = |width: usize, height: usize| (width as u64).saturating_mul(height as u64);
    let size = header.layer_size;
    let pixels = area(size.width(), size.height());
    let block = match header.blocks {
        BlockDescription::Tiles(tiles) => area(tiles.tile_size.width(), tiles.tile_size.height()),
        BlockDescription::ScanLines => area(size.width(), header.compression.scan_lines_per_block()),
    };
    // Samples as the file has them, and as f32 where they are not.
    let of_sample = |kind: SampleType| match kind {
        SampleType::F16 => 6,
        SampleType::F32 => 4,
        SampleType::U32 => 8,
    };
    let of_pixel = header.channels.list.iter().map(|channel| of_sample(channel.sample_type)).sum::<u64>() + PIXEL_BYTES;
    let chunks = u64::try_from(chunks(header)).unwrap_or(u64::MAX);
    let blocks = block.saturating_mul(sample_bytes(header)).saturating_mul(BLOCK_BYTES * threads.min(chunks));
    pixels.saturating_mul(of_pixel).saturating_add(chunks.saturating_mul(CHUNK_BYTES)).saturating_add(blocks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn file(several: bool, attributes: &[(&str, i32, usize)]) -> Vec<u8> {
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, if several { 0x10 } else { 0 }, 0, 0];
        for (name, size, there) in attributes {
            bytes.extend(name.as_bytes());
            bytes.extend(b"\0int\0");
            bytes.extend(size.to_le_bytes());
            bytes.extend(vec![1; *there]);
        }
        bytes.push(0);
        bytes
    }

    fn walked(bytes: &[u8]) -> std::result::Result<u64, String> {
        walk(Cursor::new(bytes), bytes.len() as u64)
    }

    #[test]
    fn attributes_lie_within_the_file() {
        assert_eq!(walked(&file(false, &[])), Ok(9));
        let whole = file(false, &[("a", 4, 4), ("b", 0, 0)]);
        assert_eq!(walked(&whole), Ok(whole.len() as u64));
        let mut parts = file(true, &[("a", 4, 4)]);
        assert!(walked(&parts).is_err(), "the empty header at the end is missing");
        parts.push(0);
        assert_eq!(walked(&parts), Ok(parts.len() as u64));
        for (size, there) in [(i32::MAX, 4), (5, 4), (-1, 4), (i32::MIN, 0)] {
            assert!(walked(&file(false, &[("a", size, there)])).is_err(), "{size}");
        }
        let long = "x".repeat(300);
        assert!(walked(&file(false, &[(&long, 4, 4)])).is_err());
        assert!(walked(b"v/1\x01\x02\0\0").is_err() && walked(b"PNG").is_err() && walked(b"").is_err());
    }
}
