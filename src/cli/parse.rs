//! Values of options that clap has no parser for.
//!
//! Comes in: the text of one value. Goes out: a checked value, or what is allowed.

use std::path::PathBuf;
use std::time::Duration;

use texray::interface::MAX_SIDE;
use texray::render::Roulette;

/// Largest exposure in stops, either way.
const LARGEST_EXPOSURE: f64 = 100.0;

/// `WxH` in pixels.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| format!("use WIDTHxHEIGHT in pixels, each 1 to {MAX_SIDE}"))
}

/// `x,y,w,h` in pixels, not empty; whether it lies in the picture is known later.
pub fn crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Vec<u32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match <[u32; 4]>::try_from(numbers) {
        Ok(crop) if crop[2] > 0 && crop[3] > 0 && text.split(',').count() == 4 => Ok(crop),
        _ => Err("use x,y,w,h in pixels: the window's upper left corner, then its width and height, at least 1".into()),
    }
}

/// Least probability of survival: the shader compares 24-bit numbers, so a smaller one would be off by more than 6e-5.
const LEAST_SURVIVAL: f32 = 0.001;

/// `throughput`, `off` or a probability.
pub fn roulette(text: &str) -> Result<Roulette, String> {
    match (text, text.parse::<f32>()) {
        ("throughput", _) => Ok(Roulette::Throughput),
        ("off", _) => Ok(Roulette::Off),
        (_, Ok(survival)) if (LEAST_SURVIVAL..=1.0).contains(&survival) => Ok(Roulette::Fixed(survival)),
        _ => Err("use throughput, off, or a probability of survival from 0.001 to 1".into()),
    }
}

/// Name of a PNG file.
pub fn png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    is_png.then_some(path).ok_or_else(|| "use a name that ends in .png".into())
}

/// Longest time that can be given: a century.
const LONGEST_HOURS: f64 = 876_600.0;

/// A time: seconds, or numbers each with its unit, as in `1h30m`.
pub fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || "use a time above 0 such as 90, 10s, 5m or 1h30m".to_string();
    let mut rest = text.trim();
    let mut seconds = 0.0;
    let mut last_unit = f64::INFINITY;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let (number, after) = rest.split_at(digits);
        let (unit, after) = match after.chars().next() {
            Some('h') => (3600.0, &after[1..]),
            Some('m') => (60.0, &after[1..]),
            Some('s') => (1.0, &after[1..]),
            None if last_unit.is_infinite() => (1.0, after),
            _ => return Err(wrong()),
        };
        if unit >= last_unit {
            return Err(wrong());
        }
        seconds += number.parse::<f64>().map_err(|_| wrong())? * unit;
        (rest, last_unit) = (after, unit);
    }
    match seconds > 0.0 && seconds <= LONGEST_HOURS * 3600.0 {
        true => Ok(Duration::from_secs_f64(seconds)),
        false => Err(wrong()),
    }
}

/// A percentage with its sign, or a ratio.
fn share(text: &str) -> Option<f64> {
    let share = match text.strip_suffix('%') {
        Some(percent) => percent.trim_end().parse::<f64>().ok()? / 100.0,
        None => text.parse().ok()?,
    };
    share.is_finite().then_some(share)
}

/// A number of 1 or more without a sign of per cent: whoever types it means per cent, which it would not be.
fn bare_percentage(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 1.0)
}

/// A relative error, or a share of the light.
pub fn ratio(text: &str) -> Result<f64, String> {
    if let Some(number) = bare_percentage(text).filter(|number| *number <= 1000.0) {
        let (percent, ratio) = (number * 100.0, number / 100.0);
        return Err(format!("without a % sign that is {percent} %; use {number}% or {ratio} for {number} per cent"));
    }
    let allowed = "use a ratio above 0, at most 1000 %, such as 1% or 0.01";
    share(text).filter(|share| *share > 0.0 && *share <= 10.0).ok_or_else(|| allowed.into())
}

/// A confidence.
pub fn confidence(text: &str) -> Result<f64, String> {
    let fits = |share: &f64| (0.5..=0.999_999).contains(share);
    if let Some(number) = bare_percentage(text).filter(|number| fits(&(number / 100.0))) {
        return Err(format!("without a % sign that is {} %; use {number}%", number * 100.0));
    }
    let allowed = "use a probability from 50 % to 99.9999 %, such as 95% or 0.95";
    share(text).filter(fits).ok_or_else(|| allowed.into())
}

/// Exposure in stops.
pub fn exposure(text: &str) -> Result<f64, String> {
    let stops = text.parse().ok().filter(|stops: &f64| stops.abs() <= LARGEST_EXPOSURE);
    stops.ok_or_else(|| format!("use stops from -{LARGEST_EXPOSURE} to {LARGEST_EXPOSURE}"))
}

/// A number.
pub fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "use a number".into())
}

/// A number of 0 or more.
pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|value| *value >= 0.0).ok_or_else(|| "use a number of 0 or more".into())
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "use a number above 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("800x600"), Ok([800, 600]));
        assert_eq!(size("16384x1"), Ok([16384, 1]));
        for bad in ["", "800", "0x600", "800x0", "16385x1", "-1x2", "800x600x2", "4294967296x1", "axb", "800 x600"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn durations() {
        for (text, seconds) in [
            ("10s", 10.0),
            ("90", 90.0),
            ("0.5", 0.5),
            ("5m", 300.0),
            ("1h30m", 5400.0),
            ("1h2s", 3602.0),
            ("1.5h", 5400.0),
        ] {
            assert_eq!(duration(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for bad in
            ["", "0", "0s", "-1", "s", "5x", "1m1h", "1s1s", "1h30", "1e3", "nan", "inf", "5 m", "99999999h", "1..2s"]
        {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn shares() {
        assert_eq!((ratio("1%"), ratio("0.01"), ratio("2.5 %")), (Ok(0.01), Ok(0.01), Ok(0.025)));
        assert_eq!((confidence("95%"), confidence("0.5")), (Ok(0.95), Ok(0.5)));
        for bad in ["", "0", "0%", "-1%", "%", "1001%", "nan", "inf", "1%%"] {
            assert!(ratio(bad).is_err(), "{bad}");
        }
        for bad in ["", "1", "100%", "49%", "95"] {
            assert!(confidence(bad).is_err(), "{bad}");
        }
        // A bare number of 1 or more is taken for a slip, and the percentage that is meant is named.
        for (bare, meant) in [("1", "use 1% or 0.01"), ("2.5", "use 2.5% or 0.025"), ("1e1", "use 10% or 0.1")] {
            assert!(ratio(bare).is_err_and(|message| message.contains(meant)), "{bare}");
        }
        assert_eq!((ratio("0.99"), ratio("150%")), (Ok(0.99), Ok(1.5)));
        assert!(confidence("95").is_err_and(|message| message.contains("use 95%")));
        assert!(confidence("1").is_err_and(|message| message.contains("from 50 %")));
        assert!(ratio("1001").is_err_and(|message| message.contains("at most 1000 %")));
    }

    #[test]
    fn crops() {
        assert_eq!(crop("1,2,3,4"), Ok([1, 2, 3, 4]));
        for bad in
            ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "1,2,3,0", "1,2,3,x", "-1,2,3,4", "1,2,3,4,", "1,2,3,99999999999"]
        {
            assert!(crop(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn roulettes() {
        assert_eq!(roulette("off"), Ok(Roulette::Off));
        assert_eq!(roulette("throughput"), Ok(Roulette::Throughput));
        assert_eq!(roulette("1"), Ok(Roulette::Fixed(1.0)));
        for bad in ["0", "0.0009", "-0.5", "1.01", "nan", "inf", "on", ""] {
            assert!(roulette(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn limits() {
        assert_eq!((finite("-1e3"), not_negative("0"), positive("0.5")), (Ok(-1000.0), Ok(0.0), Ok(0.5)));
        for bad in ["", "x", "nan", "inf", "1,5"] {
            assert!(finite(bad).is_err() && not_negative(bad).is_err() && positive(bad).is_err(), "{bad}");
        }
        assert!(not_negative("-1").is_err() && positive("0").is_err() && positive("-1").is_err());
    }

    #[test]
    fn exposures() {
        assert_eq!(exposure("-1.5"), Ok(-1.5));
        for bad in ["nan", "inf", "101", "", "1EV"] {
            assert!(exposure(bad).is_err(), "{bad}");
        }
    }
}
