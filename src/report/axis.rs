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

/// Larger values count as infinite, so that an axis that spans them is finite.
const LARGEST: f64 = f64::MAX / 16.0;

impl Scale {
    /// Whether a value has a place.
    pub fn shows(self, value: f64) -> bool {
        value.abs() <= LARGEST && (self == Scale::Linear || value > 0.0)
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
    /// How it is written; empty where a tick between others has no room for it.
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
    /// Distance of ticks at multiples of it; `None` for ticks at powers of ten and between.
    step: Option<f64>,
}

/// Share of the axis left free at either end where it cannot end at round values.
const MARGIN: f64 = 0.04;
/// Ticks that an axis has about.
const TICKS: f64 = 5.0;
/// A logarithmic axis of fewer decades has ticks as a linear one has.
const FEW_DECADES: f64 = 0.5;
/// One of up to so many decades names 1, 2 and 5 times powers of ten; of more, the powers alone.
const SOME_DECADES: f64 = 2.4;
/// One of more than so many decades names some of the powers.
const MANY_DECADES: f64 = 6.0;

impl Ruler {
    /// Spans `values` and ends at round ones, so that ticks cover all of it; `None` where the scale shows none of them.
    /// A linear one begins at 0 where the smallest value is less than two fifths of the largest.
    pub fn of(scale: Scale, values: impl Iterator<Item = f64>, start: f64, end: f64) -> Option<Ruler> {
        let shown: Vec<f64> = values.filter(|&value| scale.shows(value)).map(|value| scale.length(value)).collect();
        let low = shown.iter().copied().reduce(f64::min)?;
        let high = shown.iter().copied().reduce(f64::max)?;
        // One value alone stands in the middle. The halves keep the span finite.
        let span = (high / 2.0 - low / 2.0) * 2.0;
        let from_zero = scale == Scale::Linear && low >= 0.0 && low < 0.4 * high;
        let least = if scale == Scale::Log { 0.3 } else { (low.abs() * 0.1).max(1e-300) };
        let pad = if span > 0.0 { 0.0 } else { least };
        let (near, far) = (if from_zero { 0.0 } else { low - pad }, high + pad);
        if let Some((low, high, step)) = rounded(scale, near, far) {
            return Some(Ruler { scale, low, high, start, end, step });
        }
        let pad = if span > 0.0 { span.min(f64::MAX / 4.0) * MARGIN } else { least };
        let low = if from_zero { 0.0 } else { (low - pad).max(-f64::MAX / 4.0) };
        Some(Ruler { scale, low, high: (high + pad).min(f64::MAX / 4.0), start, end, step: None })
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

    /// Round values along the whole axis, in rising order. The first and the last are its ends, but for values that no
    /// number of steps reaches.
    pub fn ticks(&self) -> Vec<Tick> {
        match (self.scale, self.step) {
            (Scale::Linear, None) => self.linear_ticks(self.low, self.high, step(self.low, self.high)),
            (Scale::Linear, Some(step)) => self.linear_ticks(self.low, self.high, step),
            (Scale::Log, Some(step)) => self.linear_ticks(10f64.powf(self.low), 10f64.powf(self.high), step),
            (Scale::Log, None) => self.log_ticks(),
        }
    }

    fn linear_ticks(&self, low: f64, high: f64, step: f64) -> Vec<Tick> {
        // A multiple of the step may be a rounding error outside of the ends that were made of it.
        let slack = step * 1e-6;
        let first = ((low - slack) / step).ceil();
        let values = (0..9).map(|i| (first + f64::from(i)) * step).take_while(|value| *value <= high + slack);
        let shown = values.filter(|value| self.scale.shows(*value));
        shown.map(|value| Tick { value: value.clamp(low, high), label: number::tick(value, step) }).collect()
    }

    /// Powers of ten, every so many named, and ticks between them.
    fn log_ticks(&self) -> Vec<Tick> {
        let decades = self.high - self.low;
        let factors: &[f64] = if decades <= MANY_DECADES { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = (decades / MANY_DECADES).ceil().max(1.0) as i32;
        let is_named =
            |exponent: i32, factor: f64| exponent.rem_euclid(every) == 0 && (factor == 1.0 || decades <= SOME_DECADES);
        let exponents = (self.low.floor() as i32)..=(self.high.ceil() as i32);
        let values = exponents.flat_map(|exponent| factors.iter().map(move |&factor| (exponent, factor)));
        let inside =
            |value: f64| self.scale.shows(value) && (self.low - 1e-9..=self.high + 1e-9).contains(&value.log10());
        let tick = |(exponent, factor): (i32, f64)| {
            let value = factor * 10f64.powi(exponent);
            let label = if is_named(exponent, factor) { number::log_tick(value) } else { String::new() };
            inside(value).then_some(Tick { value, label })
        };
        values.filter_map(tick).collect()
    }
}

/// A round distance of about [`TICKS`] ticks.
fn step(low: f64, high: f64) -> f64 {
    let raw = (high - low) / TICKS;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= raw);
    step.unwrap_or(10.0 * power)
}

/// Round ends around `low` and `high`, lengths of the scale, with the distance of ticks where that is even; `None`
/// where numbers are too large, too small or too near to each other for that.
fn rounded(scale: Scale, low: f64, high: f64) -> Option<(f64, f64, Option<f64>)> {
    let even = |low: f64, high: f64| {
        let step = step(low, high);
        let usable = step.is_normal() && step > 1e-9 * low.abs().max(high.abs());
        let (first, last) = ((low / step).floor() * step, (high / step).ceil() * step);
        (usable && first.is_finite() && last.is_finite()).then(|| (first.min(low), last.max(high), step))
    };
    if scale == Scale::Linear {
        return even(low, high).map(|(low, high, step)| (low, high, Some(step)));
    }
    if high - low < FEW_DECADES
        && let Some((first, last, step)) = even(10f64.powf(low), 10f64.powf(high))
        && first > 0.0
    {
        return Some((first.log10().min(low), last.log10().max(high), Some(step)));
    }
    let factors: &[f64] = if high - low <= MANY_DECADES - 0.8 { &[1.0, 2.0, 5.0, 10.0] } else { &[1.0, 10.0] };
    let ends = |length: f64| factors.iter().map(move |factor| length.floor() + factor.log10());
    let below = ends(low).filter(|end| *end <= low + 1e-9).fold(low.floor(), f64::max);
    let above = ends(high).filter(|end| *end >= high - 1e-9).fold(high.floor() + 1.0, f64::min);
    Some((below.min(low), above.max(high), None))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ruler(scale: Scale, values: &[f64]) -> Option<Ruler> {
        Ruler::of(scale, values.iter().copied(), 0.0, 100.0)
    }

    fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
        ruler(scale, values)
            .unwrap()
            .ticks()
            .into_iter()
            .map(|tick| tick.label)
            .filter(|label| !label.is_empty())
            .collect()
    }

    #[test]
    fn round_ticks() {
        assert_eq!(labels(Scale::Linear, &[1.0, 9.7]), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(Scale::Linear, &[0.0, 1.0]), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Scale::Linear, &[76.7, 100.0]), ["75", "80", "85", "90", "95", "100"]);
        assert_eq!(labels(Scale::Log, &[1.0, 1500.0]), ["1", "10", "100", "1000"]);
        assert_eq!(labels(Scale::Log, &[1e-9, 1e3]), ["10⁻⁸", "10⁻⁶", "10⁻⁴", "0.01", "1", "100"]);
        assert_eq!(labels(Scale::Log, &[3.0, 40.0]), ["2", "5", "10", "20", "50"]);
        assert_eq!(labels(Scale::Log, &[3.1, 4.9]), ["3.0", "3.5", "4.0", "4.5", "5.0"]);
        assert_eq!(labels(Scale::Log, &[0.06, 7.0]), ["0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10"]);
    }

    #[test]
    fn nothing_to_show_is_no_ruler() {
        assert_eq!(ruler(Scale::Linear, &[]), None);
        assert_eq!(ruler(Scale::Linear, &[f64::NAN, f64::INFINITY]), None);
        assert_eq!(ruler(Scale::Log, &[0.0, -1.0]), None);
    }

    /// Of figures as studies have them, ticks reach from one end of the axis to the other, with names not far apart.
    #[test]
    fn ticks_cover_the_whole_axis() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        for i in 0..4000 {
            let scale = if i % 2 == 0 { Scale::Log } else { Scale::Linear };
            let values: Vec<f64> = (0..3).map(|_| 10f64.powf(12.0 * random() - 6.0)).collect();
            let ruler = ruler(scale, &values).unwrap();
            let ticks = ruler.ticks();
            let at = |tick: &Tick| ruler.at(tick.value).unwrap();
            let [first, last] = [&ticks[0], &ticks[ticks.len() - 1]].map(at);
            assert!(first.abs() < 1e-3 && (last - 100.0).abs() < 1e-3, "{values:?}: {ticks:?}");
            let named: Vec<f64> = ticks.iter().filter(|tick| !tick.label.is_empty()).map(at).collect();
            let gap = [0.0].iter().chain(&named).zip(named.iter().chain(&[100.0])).map(|(a, b)| b - a);
            assert!(named.len() >= 2 && gap.fold(0.0, f64::max) <= 52.0, "{values:?}: {ticks:?}");
        }
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
            prop_assert!(ticks.iter().filter(|tick| !tick.label.is_empty()).count() <= 9, "{ticks:?}");
            for tick in &ticks {
                prop_assert!((-1e-6..=100.000_001).contains(&ruler.at(tick.value).unwrap()), "{tick:?}");
            }
            prop_assert!(!ticks.is_empty());
            prop_assert!(ticks.windows(2).all(|pair| pair[0].value < pair[1].value), "{ticks:?}");
        }
    }
}
