//! PNG: the picture as 8-bit sRGB, marked as such, with all its facts as text.
//!
//! Comes in: a picture, how to show it, and its metadata. Goes out: the bytes of a file. A crop is as large as its
//! window; where it lies in the image is among the facts.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Encoder, EncodingError, Filter, SrgbRenderingIntent};
use rayon::prelude::*;

use super::{Display, Metadata, Picture};

/// The file's bytes, or why they cannot be made.
pub fn encode(picture: &Picture, display: &Display, metadata: &Metadata) -> Result<Vec<u8>, String> {
    let pixels: Vec<[u8; 3]> = picture.rgb.par_iter().map(|&rgb| display.bytes(rgb)).collect();
    write(picture, pixels.as_flattened(), metadata).map_err(|error| error.to_string())
}

/// A picture of colours from a palette (sRGB) that mean what `legend` says, an index per pixel, in rows from the top:
/// the file's bytes, or why they cannot be made. At most 256 colours.
pub fn encode_indexed(
    width: u32,
    height: u32,
    palette: &[[u8; 3]],
    legend: &str,
    indices: &[u8],
    metadata: &Metadata,
) -> Result<Vec<u8>, String> {
    let write = || -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_palette(palette.as_flattened());
        // Filters predict a value from its neighbours'; an index is a name.
        encoder.set_filter(Filter::NoFilter);
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        encoder.add_text_chunk("Software".into(), "texray".into())?;
        encoder.add_text_chunk("Description".into(), legend.into())?;
        add_text(&mut encoder, metadata)?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(indices)?;
        writer.finish()?;
        Ok(bytes)
    };
    write().map_err(|error| error.to_string())
}

fn write(picture: &Picture, samples: &[u8], metadata: &Metadata) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    encoder.add_text_chunk("Software".into(), "texray".into())?;
    add_text(&mut encoder, metadata)?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()?;
    Ok(bytes)
}

fn add_text(encoder: &mut Encoder<'_, &mut Vec<u8>>, metadata: &Metadata) -> Result<(), EncodingError> {
    for (key, value) in metadata.entries() {
        // tEXt holds Latin-1 only; iTXt holds anything.
        if value.chars().all(|character| u32::from(character) < 256) {
            encoder.add_text_chunk(key.into(), value.into())?;
        } else {
            encoder.add_itxt_chunk(key.into(), value.into())?;
        }
    }
    Ok(())
}

/// What a file that begins with `bytes` says of itself: the text before its pixels. Nothing where it is no PNG file.
pub fn facts(bytes: &[u8]) -> Vec<(String, String)> {
    let Ok(reader) = Decoder::new(Cursor::new(bytes)).read_info() else { return Vec::new() };
    let info = reader.info();
    let latin1 = info.uncompressed_latin1_text.iter().map(|text| (text.keyword.clone(), text.text.clone()));
    let utf8 = info.utf8_text.iter().filter_map(|text| Some((text.keyword.clone(), text.get_text().ok()?)));
    latin1.chain(utf8).collect()
}
