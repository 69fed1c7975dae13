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

use super::cost::Extent;
use super::{Format, Metadata, Picture};

/// Prefix of the names of texray's own attributes.
const PREFIX: &str = "texray:";
/// Length of magic number and version, which stand before the attributes.
const PREAMBLE_BYTES: usize = 8;
/// The magic number.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

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
    // All of it at once: a buffer that grows takes up to three times as much, and ends the process where there is no
    // more.
    let extent = Extent {
        width: picture.width,
        height: picture.height,
        further_channels: picture.layers.iter().map(|layer| layer.channels.len() as u32).sum(),
    };
    let mut bytes = Vec::new();
    let most = usize::try_from(Format::Exr.file_bytes(extent)).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(most).map_err(|_| format!("no memory for a file of {most} bytes"))?;
    let mut file = Cursor::new(bytes);
    image.write().to_buffered(&mut file).map_err(|error| error.to_string())?;
    let mut bytes = file.into_inner();
    sort_attributes(&mut bytes).ok_or("the header is not as expected")?;
    Ok(bytes)
}

/// EXR text is a run of bytes; UTF-8 is what readers expect.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

/// Sorts the attributes of a header by name. The header keeps its length, so the offsets that follow it stay true.
fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    let mut attributes = attributes(bytes.get(PREAMBLE_BYTES..)?)?;
    attributes.sort_unstable_by_key(|attribute| attribute.bytes);
    let sorted: Vec<u8> = attributes.iter().flat_map(|attribute| attribute.bytes).copied().collect();
    bytes.get_mut(PREAMBLE_BYTES..PREAMBLE_BYTES + sorted.len())?.copy_from_slice(&sorted);
    Some(())
}

/// An attribute of a header: `name\0 type\0 size value`.
struct Attribute<'a> {
    name: &'a [u8],
    value: &'a [u8],
    bytes: &'a [u8],
}

/// The attributes that `header` begins with, which an empty name ends; `None` where it holds something else.
fn attributes(header: &[u8]) -> Option<Vec<Attribute<'_>>> {
    let mut attributes = Vec::new();
    let mut rest = header;
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&byte| byte == 0)? + 1;
        let kind = rest.get(name..)?.iter().position(|&byte| byte == 0)? + 1;
        let size = rest.get(name + kind..)?.first_chunk::<4>()?;
        let before = name + kind + 4;
        let (bytes, after) = rest.split_at_checked(before.checked_add(u32::from_le_bytes(*size) as usize)?)?;
        attributes.push(Attribute { name: &bytes[..name - 1], value: &bytes[before..], bytes });
        rest = after;
    }
    Some(attributes)
}

/// What a file that begins with `bytes` says of itself: texray's own attributes, without their prefix. Nothing where it
/// is no EXR file, or its header is longer.
pub fn facts(bytes: &[u8]) -> Vec<(String, String)> {
    let header = bytes.strip_prefix(&MAGIC).and_then(|rest| rest.get(PREAMBLE_BYTES - MAGIC.len()..));
    let own = |attribute: Attribute<'_>| {
        let key = attribute.name.strip_prefix(PREFIX.as_bytes())?;
        Some((String::from_utf8(key.to_vec()).ok()?, String::from_utf8(attribute.value.to_vec()).ok()?))
    };
    header.and_then(attributes).unwrap_or_default().into_iter().filter_map(own).collect()
}
