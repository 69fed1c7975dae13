//! Further layers of an EXR file: figures of each pixel beside its colour.

use crate::film::{Estimate, Film};
use crate::named::named;

named! {
    /// A layer that can be asked for.
    pub enum Aov {
        /// Estimated variance of each pixel's mean, `variance.R`, `.G`, `.B`; not a number before two blocks of 16
        /// samples
        Variance = "variance",
        /// Valid samples of each pixel, `samples.Y`
        Samples = "samples",
    }
}

impl Aov {
    /// Channels of the layer.
    pub fn channels(self) -> u32 {
        match self {
            Aov::Variance => 3,
            Aov::Samples => 1,
        }
    }
}

/// A layer: its channels' names after the layer's own, and a value of each pixel in each, in rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name of the layer.
    pub name: &'static str,
    /// Channels.
    pub channels: Vec<(&'static str, Vec<f32>)>,
}

impl Layer {
    /// The layer of a film whose estimate is `estimate`.
    pub fn of(aov: Aov, film: &Film, estimate: &Estimate) -> Layer {
        match aov {
            Aov::Variance => {
                let channel = |c: usize| estimate.variance.iter().map(|variance| variance[c] as f32).collect();
                Layer { name: "variance", channels: vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))] }
            }
            // Exact up to 2^24 samples; rounded above.
            Aov::Samples => {
                let samples = film.sample_counts().into_iter().map(|count| count as f32).collect();
                Layer { name: "samples", channels: vec![("Y", samples)] }
            }
        }
    }
}
