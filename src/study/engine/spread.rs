//! Median and range of repeats.

use std::fmt;

use crate::report::{Bar, Point};

/// What repeats of one measurement gave.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Spread {
    /// The middle value, or the mean of the two in the middle.
    pub median: f64,
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// How many.
    pub count: usize,
}

impl Spread {
    /// Of these values; `None` where there is none, or one that is not a number.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Spread> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let (least, most) = (*values.first()?, *values.last()?);
        let median = (values[(count - 1) / 2] + values[count / 2]) / 2.0;
        median.is_finite().then_some(Spread { median, least, most, count })
    }
}

impl Spread {
    /// The middle at `x` of a chart, the range around it.
    pub fn point(self, x: f64) -> Point {
        Point { x, y: self.median, low: Some(self.least), high: Some(self.most) }
    }

    /// The middle as a bar, the range as its whisker.
    pub fn bar(self, name: &str) -> Bar {
        Bar { name: name.into(), value: self.median, low: Some(self.least), high: Some(self.most), is_default: false }
    }
}

impl fmt::Display for Spread {
    /// `median (least to most)`, three digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} to {})", digits(self.median), digits(self.least), digits(self.most))
    }
}

/// A positive number in three significant digits or, from 100 on, without a fraction.
pub fn digits(value: f64) -> String {
    let decimals = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 9.0) as usize } else { 0 };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(Spread::of([]), None);
        assert_eq!(Spread::of([3.0]).unwrap().median, 3.0);
        let spread = Spread::of([4.0, 1.0, 2.0, 9.0]).unwrap();
        assert_eq!((spread.median, spread.least, spread.most, spread.count), (3.0, 1.0, 9.0, 4));
        assert_eq!(Spread::of([1.0, f64::NAN, f64::NAN]), None);
    }

    #[test]
    fn three_digits() {
        assert_eq!(Spread::of([1.234]).unwrap().to_string(), "1.23 (1.23 to 1.23)");
        assert_eq!(digits(0.001234), "0.00123");
        assert_eq!(digits(123.4), "123");
        assert_eq!(digits(0.0), "0");
    }
}
