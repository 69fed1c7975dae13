//! Radiance HDR: the picture with a shared exponent, 8 bits a channel.
//!
//! Comes in: a picture. Goes out: the bytes of a file. The format holds no negative, infinite or invalid values; they
//! are brought into its range.

use image::Rgb;
use image::codecs::hdr::HdrEncoder;

use super::Picture;

/// Largest value written: the format's exponent ends below 2^127.
const LARGEST: f32 = 1e38;
/// Smallest value written other than 0: the format's exponent begins at 2^-127.
const SMALLEST: f32 = 1e-37;

/// The file's bytes, or why they cannot be made.
pub fn encode(picture: &Picture) -> Result<Vec<u8>, String> {
    let pixels: Vec<_> = picture.rgb.iter().map(|&rgb| Rgb(rgb.map(in_range))).collect();
    let mut bytes = Vec::new();
    let encoded = HdrEncoder::new(&mut bytes).encode(&pixels, picture.width as usize, picture.height as usize);
    encoded.map_err(|error| error.to_string())?;
    Ok(bytes)
}

fn in_range(value: f32) -> f32 {
    if value >= SMALLEST { value.min(LARGEST) } else { 0.0 }
}
