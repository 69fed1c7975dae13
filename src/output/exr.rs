//! OpenEXR: the picture and its layers as 32-bit floats, its window as the data window, its facts as attributes.
//!
//! Comes in: a picture and its metadata. Goes out: the bytes of a file. They are a function of what comes in: lines are
//! in rising order, and the attributes are sorted by name, since the `exr` crate keeps them in a hash map of
//! random order.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image, IntegerBounds, Layer,
    LayerAttributes, LineOrder, SmallVec, Text, Vec2, WritableImage,
};

use super::{Metadata, Picture};

/// Prefix of the names of texray's own attributes.
const PREFIX: &str = "texray:";
/// Length of magic number and version, which stand before the attributes.
const PREAMBLE_BYTES: usize = 8;

/// The file's bytes, or why they cannot be made.
pub fn encode(picture: &Picture, metadata: &Metadata) -> Result<Vec<u8>, String> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let colour = |c: usize| FlatSamples::F32(picture.rgb.iter().map(|rgb| rgb[c]).collect());
    let mut channels: SmallVec<_> = (0..3).map(|c| AnyChannel::new(["R", "G", "B"][c], colour(c))).collect();
    for layer in &picture.layers {
        let named = |(name, values): &(&str, Vec<f32>)| {
            AnyChannel::new(text(&format!("{}.{name}", layer.name)), FlatSamples::F32(values.clone()))
        };
        channels.extend(layer.channels.iter().map(named));
    }
    let channels = AnyChannels::sort(channels);
    let mut attributes = LayerAttributes {
        // The picture's place in the whole image; at most 16384, so it fits.
        layer_position: Vec2(picture.x as i32, picture.y as i32),
        software_name: Some(text("texray")),
        ..LayerAttributes::default()
    };
    for (key, value) in metadata.fixed_entries() {
        attributes.other.insert(text(&format!("{PREFIX}{key}")), AttributeValue::Text(text(value)));
    }
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let mut image = Image::from_layer(Layer::new((width, height), attributes, encoding, channels));
    image.attributes.display_window =
        IntegerBounds::from_dimensions((picture.full_width as usize, picture.full_height as usize));
    let mut file = Cursor::new(Vec::new());
    image.write().to_buffered(&mut file).map_err(|error| error.to_string())?;
    let mut bytes = file.into_inner();
    sort_attributes(&mut bytes).ok_or("the header is not as expected")?;
    Ok(bytes)
}

/// EXR text is a run of bytes; UTF-8 is what readers expect.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

/// Sorts the attributes of a header (`name\0 type\0 size value`, ended by an empty name) by name. The header keeps its
/// length, so the offsets that follow it stay true.
fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    let header = bytes.get(PREAMBLE_BYTES..)?;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut rest = header;
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&byte| byte == 0)? + 1;
        let kind = rest.get(name..)?.iter().position(|&byte| byte == 0)? + 1;
        let size = rest.get(name + kind..)?.first_chunk::<4>()?;
        let (attribute, tail) = rest.split_at_checked(name + kind + 4 + u32::from_le_bytes(*size) as usize)?;
        attributes.push(attribute);
        rest = tail;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    bytes.get_mut(PREAMBLE_BYTES..PREAMBLE_BYTES + sorted.len())?.copy_from_slice(&sorted);
    Some(())
}
