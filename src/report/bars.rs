//! Values by name, as bars from zero with whiskers.
//!
//! Comes in: [`Bars`]. Goes out: a figure of title, drawing, gaps in words, and the numbers as a table. A name stands
//! above its bar, so that long ones fit on narrow screens.

use maud::{Markup, html};

use super::axis::{Ruler, Scale};
use super::chart::{DIGITS, is_doubtful};
use super::chart_marks::unit;
use super::number::significant;
use super::table::{Table, numbers};

/// Values by name, of one quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bars {
    /// What is shown.
    pub title: String,
    /// Unit of the values; empty for none.
    pub unit: String,
    /// From the top.
    pub bars: Vec<Bar>,
}

/// A value with its interval.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bar {
    /// What it is of.
    pub name: String,
    /// The value; not a number where it is not known.
    pub value: f64,
    /// Lower end of its interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// Whether it is of the choice that the program makes by default, and named as such.
    pub is_default: bool,
}

impl Bar {
    /// The same as the default choice, if `is_default`.
    pub fn default_if(mut self, is_default: bool) -> Bar {
        self.is_default = is_default;
        self
    }

    /// The name, with what is particular about it.
    fn full_name(&self) -> String {
        if self.is_default { format!("{} (the default)", self.name) } else { self.name.clone() }
    }
}

const WIDTH: f64 = 560.0;
/// Height of a bar's row: the name, then the bar.
const ROW: f64 = 48.0;
const BAR: f64 = 16.0;
/// Room right of the longest bar for its value.
const RIGHT: f64 = 440.0;
/// Room left of the axis for half of its first number.
const LEFT: f64 = 22.0;
const CAP: f64 = 4.0;
/// Height of the axis below the bars, with its numbers.
const AXIS: f64 = 34.0;
/// Characters of a name that fit above a bar, in the larger letters of a narrow screen; the tip and the table have all.
const LONGEST_NAME: usize = 54;

impl Bars {
    /// The figure; `id` is unique on the page.
    pub(super) fn markup(&self, id: &str) -> Markup {
        let values = || self.bars.iter().flat_map(|bar| [Some(bar.value), bar.low, bar.high]).flatten();
        let ruler = Ruler::of(Scale::Linear, values().chain([0.0]), LEFT, RIGHT);
        let label = format!("{id}-label");
        html! {
            figure.bars id=(id) {
                figcaption { (self.title) @if !self.unit.is_empty() { span.unit { " (" (self.unit) ")" } } }
                @match ruler.filter(|_| self.bars.iter().any(|bar| bar.value.is_finite())) {
                    Some(ruler) => {
                        svg viewBox=(format!("0 0 {WIDTH} {}", ROW * self.bars.len() as f64 + AXIS)) role="img"
                            aria-labelledby=(label) {
                            title id=(label) { (self.title) }
                            (axis(&ruler, ROW * self.bars.len() as f64))
                            @for (i, bar) in self.bars.iter().enumerate() {
                                (row(bar, &self.unit, ROW * i as f64, &ruler))
                            }
                        }
                    },
                    None => p.gap { "No figures to draw." },
                }
                @for bar in self.bars.iter().filter(|bar| is_doubtful(bar.low, bar.high)) {
                    p.gap { (doubt(bar)) }
                }
                @if !self.bars.is_empty() { (self.numbers()) }
            }
        }
    }

    fn numbers(&self) -> Markup {
        let end = |end: Option<f64>| end.map_or_else(String::new, |value| significant(value, DIGITS));
        let row = |bar: &Bar| vec![bar.full_name(), significant(bar.value, DIGITS), end(bar.low), end(bar.high)];
        let value = if self.unit.is_empty() { "value".into() } else { self.unit.clone() };
        let columns = vec!["name".into(), value, "low".into(), "high".into()];
        numbers(&self.title, &Table { columns, rows: self.bars.iter().map(row).collect() })
    }
}

/// Ticks over the whole length, from the first bar to the numbers below the last.
fn axis(ruler: &Ruler, bottom: f64) -> Markup {
    let ticks = ruler.ticks().into_iter().filter_map(|tick| Some((ruler.at(tick.value)?, tick.label)));
    html! {
        g.axis {
            @for (x, label) in ticks {
                line.grid x1=(unit(x)) y1="20" x2=(unit(x)) y2=(bottom + 4.0) {}
                text x=(unit(x)) y=(bottom + 22.0) text-anchor="middle" { (label) }
            }
            path.frame d=(format!("M{LEFT} {0}H{RIGHT}", bottom + 4.0)) {}
        }
    }
}

fn doubt(bar: &Bar) -> String {
    let [low, high] = [bar.low, bar.high].map(|end| significant(end.unwrap_or(bar.value), 3));
    format!("{}: its repeats differ by 10 times or more: {low} to {high}.", bar.name)
}

fn row(bar: &Bar, unit_name: &str, top: f64, ruler: &Ruler) -> Markup {
    let name_at = top + 16.0;
    let bar_at = top + 23.0;
    let middle = bar_at + BAR / 2.0;
    let Some(end) = ruler.at(bar.value) else {
        return html! {
            text.name x="2" y=(name_at) { (cut(&bar.full_name())) }
            text.gap x=(LEFT) y=(middle + 5.0) { (significant(bar.value, DIGITS)) ": no bar" }
        };
    };
    let zero = ruler.clamped(0.0);
    let ends = [bar.low, bar.high].map(|end| end.filter(|end| !end.is_nan()));
    let [low, high] = ends.map(|end| ruler.clamped(end.unwrap_or(bar.value)));
    let text_at = end.max(low).max(high).max(zero) + 8.0;
    let mut tip = format!("{}: {} {unit_name}", bar.name, significant(bar.value, DIGITS));
    if let [Some(low), Some(high)] = ends {
        tip += &format!("\n{} to {}", significant(low, DIGITS), significant(high, DIGITS));
    }
    let whisker = format!(
        "M{low} {middle}H{high}M{low} {0}V{1}M{high} {0}V{1}",
        middle - CAP,
        middle + CAP,
        low = unit(low),
        high = unit(high)
    );
    html! {
        text.name x="2" y=(name_at) { (cut(&bar.full_name())) }
        line.zero x1=(unit(zero)) y1=(bar_at - 3.0) x2=(unit(zero)) y2=(bar_at + BAR + 3.0) {}
        rect.mark.s0.default[bar.is_default] x=(unit(end.min(zero))) y=(bar_at)
            width=(unit((end - zero).abs().max(1.0))) height=(BAR) {
            title { (tip.trim_end()) }
        }
        @if ends.iter().any(Option::is_some) { path.whisker d=(whisker) {} }
        text x=(unit(text_at)) y=(middle + 5.0) { (significant(bar.value, 3)) }
    }
}

/// A name that fits.
fn cut(name: &str) -> String {
    if name.chars().count() <= LONGEST_NAME {
        return name.into();
    }
    let kept: String = name.chars().take(LONGEST_NAME - 1).collect();
    format!("{}…", kept.trim_end())
}
