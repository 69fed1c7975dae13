//! How a number is written in charts and tables: few digits, no locale.

/// `value` in `digits` significant digits; from 10^6 on and below 10^-4 as a power of ten.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return if value.is_nan() { "not a number".into() } else { "infinite".into() };
    }
    if value == 0.0 {
        return "0".into();
    }
    // The exponent after rounding: 9.996 in three digits is 10.0.
    let scientific = format!("{:.*e}", digits.saturating_sub(1), value);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
        return signed(&format!("{value:.decimals$}"));
    }
    signed(&format!("{mantissa}·10{}", superscript(exponent)))
}

/// A tick's label: all the digits that a multiple of `step` needs.
pub fn tick(value: f64, step: f64) -> String {
    if value.abs() < step / 1e6 {
        return "0".into();
    }
    if value.abs() >= 1e6 || step < 1e-5 {
        let digits = (value.abs().log10().floor() - step.log10().floor()).clamp(0.0, 8.0) as usize + 1;
        return power(value).unwrap_or_else(|| significant(value, digits));
    }
    let decimals = (-(step * 1.000_001).log10().floor()).clamp(0.0, 9.0) as usize;
    signed(&format!("{value:.decimals$}"))
}

/// A tick of a logarithmic axis: plain from 0.001 to 100,000, else as a power of ten.
pub fn log_tick(value: f64) -> String {
    let exponent = value.log10().floor();
    if (-3.0..=5.0).contains(&exponent) {
        return tick(value, 10f64.powf(exponent));
    }
    power(value).unwrap_or_else(|| significant(value, 1))
}

/// 10^n where `value` is that.
fn power(value: f64) -> Option<String> {
    let exponent = value.log10().round();
    ((value.log10() - exponent).abs() < 1e-9).then(|| format!("10{}", superscript(exponent as i32)))
}

/// A true minus sign.
fn signed(text: &str) -> String {
    text.replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁰',
    };
    exponent.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        for (value, text) in [
            (0.0, "0"),
            (1.234_56, "1.23"),
            (9.996, "10.0"),
            (-0.05, "−0.0500"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.23·10⁶"),
            (1.5e-5, "1.50·10⁻⁵"),
            (f64::NAN, "not a number"),
            (f64::INFINITY, "infinite"),
        ] {
            assert_eq!(significant(value, 3), text);
        }
    }

    #[test]
    fn ticks() {
        assert_eq!([0.0, 0.2, -0.4].map(|value| tick(value, 0.2)), ["0", "0.2", "−0.4"]);
        assert_eq!([50.0, 100.0].map(|value| tick(value, 50.0)), ["50", "100"]);
        assert_eq!(tick(0.25, 0.05), "0.25");
        assert_eq!(tick(2_500_000.0, 500_000.0), "2.5·10⁶");
        assert_eq!([0.001, 0.5, 20.0, 100_000.0].map(log_tick), ["0.001", "0.5", "20", "100000"]);
        assert_eq!([1e-4, 1e6, 2e-7].map(log_tick), ["10⁻⁴", "10⁶", "2·10⁻⁷"]);
    }
}
