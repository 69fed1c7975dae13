//! Radiance HDR: the picture with a shared exponent, 8 bits a channel.
//!
//! Comes in: a picture and its metadata. Goes out: the bytes of a file. The format holds no negative, infinite or
//! invalid values; they are brought into its range. Facts stand in the header as `texray:KEY=VALUE`, a line each.

use image::Rgb;
use image::codecs::hdr::HdrEncoder;

use super::{Metadata, Picture};

/// Largest value written: the format's exponent ends below 2^127.
const LARGEST: f32 = 1e38;
/// Smallest value written other than 0: the format's exponent begins at 2^-127.
const SMALLEST: f32 = 1e-37;

/// The line that a file begins with.
const MAGIC: &[u8] = b"#?RADIANCE\n";
/// Prefix of texray's own lines of the header.
const PREFIX: &str = "texray:";

/// The file's bytes, or why they cannot be made.
pub fn encode(picture: &Picture, metadata: &Metadata) -> Result<Vec<u8>, String> {
    let pixels: Vec<_> = picture.rgb.iter().map(|&rgb| Rgb(rgb.map(in_range))).collect();
    let mut bytes = Vec::new();
    let encoded = HdrEncoder::new(&mut bytes).encode(&pixels, picture.width as usize, picture.height as usize);
    encoded.map_err(|error| error.to_string())?;
    let rest = bytes.strip_prefix(MAGIC).ok_or("the header is not as expected")?;
    // A line ends where its value would: what stands after it would be no line of ours.
    let line = |(key, value): (&str, &str)| format!("{PREFIX}{key}={}\n", value.replace(['\n', '\r'], " "));
    let lines: String = metadata.fixed_entries().map(line).collect();
    Ok([MAGIC, lines.as_bytes(), rest].concat())
}

/// What a file that begins with `bytes` says of itself: texray's own lines. Nothing where it is no HDR file.
pub fn facts(bytes: &[u8]) -> Vec<(String, String)> {
    let Some(header) = bytes.strip_prefix(MAGIC) else { return Vec::new() };
    let lines = header.split(|&byte| byte == b'\n').take_while(|line| !line.is_empty());
    let own = |line: &[u8]| {
        let (key, value) = std::str::from_utf8(line).ok()?.strip_prefix(PREFIX)?.split_once('=')?;
        Some((key.to_owned(), value.to_owned()))
    };
    lines.filter_map(own).collect()
}

fn in_range(value: f32) -> f32 {
    if value >= SMALLEST { value.min(LARGEST) } else { 0.0 }
}
