//! Fixed-point radiance: sums that do not depend on the order of their terms.
//!
//! Comes in: the f32 sum of a block. Goes out: the same number in units of 2^-80 as an `i128`. A value of 2^-57 or more
//! is exact (an f32 has 24 bits); smaller ones are rounded to the nearest unit, which is 8.3e-25 of the brightest emission's
//! scale, so that light 10^20 times fainter keeps four digits. Sums of blocks stay below 2^47: room for 2^11 - 1 of the
//! largest, 2^36, and for 2^27 blocks whose samples average 2^16 times the brightest emission. More is refused.

/// Bits below the binary point.
pub const FRACTION_BITS: u32 = 80;
/// Largest sum of a block: 16 samples of `interface::MAX_SAMPLE_RADIANCE`, 2^36.
pub const MAX_SUM: f32 = 68_719_476_736.0;

/// Exponent bias of an f32's integer mantissa: the value is `mantissa * 2^(exponent - 150)`.
const MANTISSA_BIAS: i32 = 150;

/// `value` in units of 2^-80, rounded to nearest (halves away from zero); `None` where it is not finite or its
/// magnitude exceeds [`MAX_SUM`].
pub fn from_f32(value: f32) -> Option<i128> {
    if value.is_nan() || value.abs() > MAX_SUM {
        return None;
    }
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32;
    let mantissa = i128::from(bits & 0x7f_ffff | 0x80_0000);
    let shift = exponent - MANTISSA_BIAS + FRACTION_BITS as i32;
    // Zeros and denormals (exponent 0) shift right by 70 and so are 0, whatever their mantissa.
    let magnitude = match shift {
        0.. => mantissa << shift,
        -24..=-1 => (mantissa + (1 << (-shift - 1))) >> -shift,
        _ => 0,
    };
    Some(if value.is_sign_negative() { -magnitude } else { magnitude })
}

/// A sum in units of 2^-80 as an f64: exact where it has at most 53 significant bits, else within an ulp. Its two words
/// are converted apart, which is several times faster than the conversion of an `i128`.
pub fn to_f64(sum: i128) -> f64 {
    const UNIT: f64 = 1.0 / (1u128 << FRACTION_BITS) as f64;
    const UPPER_UNIT: f64 = (1u128 << 64) as f64 * UNIT;
    let magnitude = sum.unsigned_abs();
    let value = (magnitude >> 64) as u64 as f64 * UPPER_UNIT + magnitude as u64 as f64 * UNIT;
    if sum < 0 { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ONE: i128 = 1 << FRACTION_BITS;

    #[test]
    fn known_values() {
        assert_eq!(from_f32(0.0), Some(0));
        assert_eq!(from_f32(-0.0), Some(0));
        assert_eq!(from_f32(1.0), Some(ONE));
        assert_eq!(from_f32(-1.5), Some(-3 * ONE / 2));
        assert_eq!(from_f32(MAX_SUM), Some(ONE << 36));
        assert_eq!(from_f32(MAX_SUM.next_up()), None);
        assert_eq!(from_f32(f32::NAN), None);
        assert_eq!(from_f32(f32::NEG_INFINITY), None);
    }

    #[test]
    fn rounds_to_the_nearest_unit() {
        let unit = f32::from_bits((127 - 80) << 23);
        assert_eq!(from_f32(unit), Some(1));
        assert_eq!(from_f32(unit / 2.0), Some(1));
        assert_eq!(from_f32((unit / 2.0).next_down()), Some(0));
        assert_eq!(from_f32(1.5 * unit), Some(2));
        assert_eq!(from_f32(1.25 * unit), Some(1));
        assert_eq!(from_f32(f32::MIN_POSITIVE), Some(0));
        assert_eq!(from_f32(f32::from_bits(1)), Some(0));
    }

    #[test]
    fn two_to_the_11_largest_sums_but_one_fit() {
        let largest = from_f32(MAX_SUM).unwrap();
        assert!(largest.checked_mul((1 << 11) - 1).is_some());
        assert!(largest.checked_mul(1 << 11).is_none());
    }

    proptest! {
        /// An f64 holds any f32 exactly, and 2^80 times it, so f64 arithmetic is an independent oracle.
        #[test]
        fn agrees_with_f64(bits in 0u32..(163 << 23), negative: bool) {
            let value = f32::from_bits(bits | u32::from(negative) << 31);
            let expected = (f64::from(value) * (1u128 << 80) as f64).round();
            prop_assert_eq!(from_f32(value).unwrap() as f64, expected);
        }

        /// Exact from 2^-57 on: it comes back.
        #[test]
        fn round_trip(bits in (70u32 << 23)..(163 << 23)) {
            let value = f32::from_bits(bits);
            prop_assert_eq!(to_f64(from_f32(value).unwrap()), f64::from(value));
        }
    }
}
