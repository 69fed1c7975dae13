//! A picture of linear radiance, and where it lies in the whole image.
//!
//! Comes in: pixels from a film. Goes out: the same, with the window they belong to. May be assumed: as many pixels as
//! the window has, and a window inside the whole image ([`Picture::new`] checks both).

use super::Layer;
use crate::{Error, Result};

/// Linear Rec. 709 radiance of a window of an image, in rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Column of the whole image where the window begins.
    pub x: u32,
    /// Row of the whole image where the window begins.
    pub y: u32,
    /// Width of the window in pixels.
    pub width: u32,
    /// Height of the window in pixels.
    pub height: u32,
    /// Width of the whole image in pixels.
    pub full_width: u32,
    /// Height of the whole image in pixels.
    pub full_height: u32,
    /// Radiance of each pixel, W/(sr·m²).
    pub rgb: Vec<[f32; 3]>,
    /// Further figures of each pixel, for formats that hold them.
    pub layers: Vec<Layer>,
}

impl Picture {
    /// The picture of a window `crop` (`[x, y, width, height]`; `None`: all of it) of an image of `full_width` x
    /// `full_height` pixels.
    pub fn new(full_width: u32, full_height: u32, crop: Option<[u32; 4]>, rgb: Vec<[f32; 3]>) -> Result<Picture> {
        let [x, y, width, height] = crop.unwrap_or([0, 0, full_width, full_height]);
        let fits =
            |first: u32, count: u32, all: u32| count > 0 && first.checked_add(count).is_some_and(|end| end <= all);
        let pixels = u64::from(width) * u64::from(height);
        if !fits(x, width, full_width) || !fits(y, height, full_height) || rgb.len() as u64 != pixels {
            return Err(Error::Internal(format!(
                "{} pixels for the window {width}x{height} at ({x}, {y}) of a picture of {full_width}x{full_height}",
                rgb.len()
            )));
        }
        Ok(Picture { x, y, width, height, full_width, full_height, rgb, layers: Vec::new() })
    }

    /// The picture with these layers; each channel has a value of each pixel.
    pub fn with_layers(mut self, layers: Vec<Layer>) -> Result<Picture> {
        let fits = |layer: &Layer| layer.channels.iter().all(|(_, values)| values.len() == self.rgb.len());
        if let Some(layer) = layers.iter().find(|layer| !fits(layer)) {
            return Err(Error::Internal(format!("the layer {} is not of {} pixels", layer.name, self.rgb.len())));
        }
        self.layers = layers;
        Ok(self)
    }

    /// Whether the window is less than the whole image.
    pub fn is_crop(&self) -> bool {
        (self.width, self.height) != (self.full_width, self.full_height)
    }
}
