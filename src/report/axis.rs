//! An axis of a chart: from values to places along a line, with ticks at round values.
//!
//! Comes in: an [`Axis`] and the values to show. Goes out: a [`Ruler`]. Values that the scale cannot show (not finite,
//! or, on a logarithmic one, not above 0) have no place.

use super::number;

/// What an axis says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// How values are laid out.
    pub scale: Scale,
}

/// How values are laid out along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equal lengths.
    Linear,
    /// Equal ratios are equal lengths.
    Log,
}

impl Axis {
    /// An axis of a quantity in a unit.
    pub fn new(label: &str, unit: &str, scale: Scale) -> Axis {
        Axis { label: label.into(), unit: unit.into(), scale }
    }

    /// The quantity with its unit.
    pub fn title(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }
}

impl Scale {
    /// Whether a value has a place.
    pub fn shows(self, value: f64) -> bool {
        value.is_finite() && (self == Scale::Linear || value > 0.0)
    }

    fn length(self, value: f64) -> f64 {
        match self {
            Scale::Linear => value,
            Scale::Log => value.log10(),
        }
    }
}

/// A round value on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The value.
    pub value: f64,
    /// How it is written.
    pub label: String,
}

/// Places along a line of a drawing, from `start` to `end` in its units.
#[derive(Clone, Debug, PartialEq)]
pub struct Ruler {
    scale: Scale,
    low: f64,
    high: f64,
    start: f64,
    end: f64,
}

/// Share of the axis left free at either end.
const MARGIN: f64 = 0.04;
/// Ticks that an axis has about.
const TICKS: f64 = 5.0;

impl Ruler {
    /// Spans `values`; `None` where the scale shows none of them. A linear one begins at 0 where the smallest value is
    /// less than two fifths of the largest.
    pub fn of(scale: Scale, values: impl Iterator<Item = f64>, start: f64, end: f64) -> Option<Ruler> {
        let shown: Vec<f64> = values.filter(|&value| scale.shows(value)).map(|value| scale.length(value)).collect();
        let low = shown.iter().copied().reduce(f64::min)?;
        let high = shown.iter().copied().reduce(f64::max)?;
        if scale == Scale::Linear && low >= 0.0 && low < 0.4 * high {
            return Some(Ruler { scale, low: 0.0, high: high * (1.0 + MARGIN), start, end });
        }
        // One value alone stands in the middle. The halves keep the span finite.
        let span = (high / 2.0 - low / 2.0) * 2.0;
        let least = if scale == Scale::Log { 0.3 } else { (low.abs() * 0.1).max(1e-300) };
        let pad = if span > 0.0 { span.min(f64::MAX / 4.0) * MARGIN } else { least };
        Some(Ruler { scale, low: (low - pad).max(-f64::MAX / 4.0), high: (high + pad).min(f64::MAX / 4.0), start, end })
    }

    /// The place of a value, if it has one.
    pub fn at(&self, value: f64) -> Option<f64> {
        self.scale.shows(value).then(|| self.place(self.scale.length(value)))
    }

    /// The place of a value, or the nearest end of the axis: values below a logarithmic scale are at its lower end.
    pub fn clamped(&self, value: f64) -> f64 {
        let length = if self.scale.shows(value) { self.scale.length(value) } else { self.low };
        self.place(length.clamp(self.low, self.high))
    }

    fn place(&self, length: f64) -> f64 {
        self.start + (self.end - self.start) * ((length - self.low) / (self.high - self.low))
    }

    /// Round values inside the axis, in rising order: at least one, seven at the most.
    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(self.low, self.high),
            Scale::Log => self.log_ticks(),
        }
    }

    fn linear_ticks(&self, low: f64, high: f64) -> Vec<Tick> {
        let raw = (high - low) / TICKS;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= raw);
        let step = step.unwrap_or(10.0 * power);
        let first = (low / step).ceil();
        let values = (0..8).map(|i| (first + f64::from(i)) * step).take_while(|value| *value <= high);
        values.map(|value| Tick { value, label: number::tick(value, step) }).collect()
    }

    /// Powers of ten, every so many; over fewer than two decades also 2 and 5 times them, or round values.
    fn log_ticks(&self) -> Vec<Tick> {
        let factors: &[f64] = if self.high - self.low < 2.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = ((self.high - self.low) / 6.0).ceil().max(1.0) as i32;
        let exponents = (self.low.floor() as i32)..=(self.high.ceil() as i32);
        let kept = exponents.filter(|exponent| exponent.rem_euclid(every) == 0);
        let values = kept.flat_map(|exponent| factors.iter().map(move |factor| factor * 10f64.powi(exponent)));
        let inside = values.filter(|value| (self.low..=self.high).contains(&value.log10()));
        let ticks: Vec<Tick> = inside.map(|value| Tick { value, label: number::log_tick(value) }).collect();
        if ticks.len() < 3 { self.linear_ticks(10f64.powf(self.low), 10f64.powf(self.high)) } else { ticks }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ruler(scale: Scale, values: &[f64]) -> Option<Ruler> {
        Ruler::of(scale, values.iter().copied(), 0.0, 100.0)
    }

    fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
        ruler(scale, values).unwrap().ticks().into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn round_ticks() {
        assert_eq!(labels(Scale::Linear, &[1.0, 9.7]), ["0", "5", "10"]);
        assert_eq!(labels(Scale::Linear, &[0.0, 1.0]), ["0", "0.5", "1.0"]);
        assert_eq!(labels(Scale::Log, &[1.0, 1500.0]), ["1", "10", "100", "1000"]);
        assert_eq!(labels(Scale::Log, &[1e-9, 1e3]), ["10⁻⁹", "10⁻⁶", "0.001", "1", "1000"].map(String::from));
        assert_eq!(labels(Scale::Log, &[3.0, 40.0]), ["5", "10", "20"]);
    }

    #[test]
    fn nothing_to_show_is_no_ruler() {
        assert_eq!(ruler(Scale::Linear, &[]), None);
        assert_eq!(ruler(Scale::Linear, &[f64::NAN, f64::INFINITY]), None);
        assert_eq!(ruler(Scale::Log, &[0.0, -1.0]), None);
    }

    proptest! {
        /// Every value shown lies on the axis, and the ticks do too, rising and few.
        #[test]
        fn values_lie_on_the_axis(values in prop::collection::vec(prop::num::f64::NORMAL, 1..9), log: bool) {
            let scale = if log { Scale::Log } else { Scale::Linear };
            let Some(ruler) = ruler(scale, &values) else { return Ok(()) };
            for value in values {
                if let Some(at) = ruler.at(value) {
                    prop_assert!((-1e-6..=100.000_001).contains(&at), "{value} at {at}");
                }
            }
            let ticks = ruler.ticks();
            prop_assert!(ticks.len() <= 8);
            for tick in &ticks {
                prop_assert!((-1e-6..=100.000_001).contains(&ruler.at(tick.value).unwrap()), "{tick:?}");
            }
            prop_assert!(ticks.windows(2).all(|pair| pair[0].value < pair[1].value), "{ticks:?}");
        }
    }
}
