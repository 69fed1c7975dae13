//! Linear radiance to the 8-bit sRGB of a display: exposure, tone map, transfer curve, quantisation.
//!
//! Comes in: a pixel of any value, not-a-numbers, infinities and negatives included. Goes out: three bytes. All of it is
//! computed in f64 and nowhere else, so that every 8-bit picture of texray looks the same.

use crate::named::named;

/// How a picture is shown; it changes 8-bit files only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Exposure in stops: radiance is multiplied by 2 to this power.
    pub exposure_stops: f64,
    /// What brings radiance above 1 into the range of the display.
    pub tonemap: Tonemap,
}

named! {
    /// What brings radiance into the range [0, 1] of the display; every curve acts on each channel by itself.
    pub enum Tonemap = None {
        /// Clip at 1: below it, colours are exact.
        None = "none",
        /// x / (1 + x) (Reinhard et al. 2002, equation 3): keeps detail in highlights, dims the rest.
        Reinhard = "reinhard",
        /// Filmic curve: Narkowicz's fit (2015) to the ACES reference transform; more contrast.
        Aces = "aces",
    }
}

/// Largest radiance that a curve is asked for, after exposure; all of them have reached 1 in 8 bits long before, and
/// their squares stay finite.
const BRIGHTEST: f64 = 1e30;

impl Display {
    /// The pixel's three bytes.
    pub fn bytes(&self, rgb: [f32; 3]) -> [u8; 3] {
        let gain = self.exposure_stops.exp2();
        rgb.map(|radiance| {
            let exposed = f64::from(radiance) * gain;
            // A not-a-number (invalid radiance, or an infinity times a gain of 0) shows black.
            let exposed = if exposed > 0.0 { exposed.min(BRIGHTEST) } else { 0.0 };
            (srgb_transfer(self.tonemap.curve(exposed)) * 255.0).round() as u8
        })
    }
}

impl Tonemap {
    /// The curve at `x`, 0 to [`BRIGHTEST`]; the result is in [0, 1].
    fn curve(self, x: f64) -> f64 {
        let y = match self {
            Tonemap::None => x,
            Tonemap::Reinhard => x / (1.0 + x),
            Tonemap::Aces => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
        };
        y.clamp(0.0, 1.0)
    }
}

/// The transfer curve of sRGB (IEC 61966-2-1) from linear light, both in [0, 1].
pub fn srgb_transfer(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [Tonemap; 3] = [Tonemap::None, Tonemap::Reinhard, Tonemap::Aces];

    fn byte(tonemap: Tonemap, exposure_stops: f64, value: f32) -> u8 {
        Display { exposure_stops, tonemap }.bytes([value; 3])[0]
    }

    #[test]
    fn extremes_are_black_or_white() {
        for tonemap in ALL {
            for exposure in [0.0, -1.0, 1000.0, -2000.0, 2000.0] {
                for black in [0.0, -0.0, -1e-9, -1e38, f32::NEG_INFINITY, f32::NAN] {
                    assert_eq!(byte(tonemap, exposure, black), 0, "{tonemap:?} {exposure} {black}");
                }
            }
            for white in [1e30, 1e38, f32::MAX, f32::INFINITY] {
                assert_eq!(byte(tonemap, 0.0, white), 255, "{tonemap:?} {white}");
            }
        }
    }

    #[test]
    fn known_values() {
        // sRGB of 18 % grey is 117.6 of 255, of 0.5 is 187.5, of 1 is 255.
        assert_eq!(byte(Tonemap::None, 0.0, 0.18), 118);
        assert_eq!(byte(Tonemap::None, 0.0, 0.5), 188);
        assert_eq!(byte(Tonemap::None, 1.0, 0.5), 255);
        assert_eq!(byte(Tonemap::None, -1.0, 1.0), 188);
        assert_eq!(byte(Tonemap::Reinhard, 0.0, 1.0), 188);
        // 2.54 / 3.16 = 0.8038, in sRGB 231.6 of 255.
        assert_eq!(byte(Tonemap::Aces, 0.0, 1.0), 232);
    }

    proptest! {
        #[test]
        fn rises_with_radiance(a in 0f32..1e4, b in 0f32..1e4, exposure in -10f64..10.0) {
            for tonemap in ALL {
                let (low, high) = (byte(tonemap, exposure, a.min(b)), byte(tonemap, exposure, a.max(b)));
                prop_assert!(low <= high, "{:?}: {} then {}", tonemap, low, high);
            }
        }
    }
}
