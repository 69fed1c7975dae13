//! A chart: series of points in a plane, with whiskers, fitted power laws and the interval of their slopes.
//!
//! Comes in: a [`Chart`]. Goes out: a figure of title, legend, drawing, what could not be drawn and why, and the
//! numbers as a table. A series differs from the others by colour and by the shape of its marks.

use maud::{Markup, html};

use super::axis::Ruler;
use super::chart_marks::{self, Frame};
use super::number::significant;
use super::table::{Table, numbers};
use super::{Axis, Fit};

/// Points in a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What is shown.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Series, in the order of the legend.
    pub series: Vec<Series>,
}

/// Points that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What they are of.
    pub name: String,
    /// The points; in the drawing they are joined in the order of x, unless a fit is given.
    pub points: Vec<Point>,
    /// The power law to draw through them ([`Fit::of`]).
    pub fit: Option<Fit>,
    /// Whether they are of the choice that the program makes by default: drawn above the others and named as such.
    pub is_default: bool,
}

/// A point, in the units of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Horizontal.
    pub x: f64,
    /// Vertical.
    pub y: f64,
    /// Lower end of y's interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl Point {
    /// A point without an interval.
    pub fn new(x: f64, y: f64) -> Point {
        Point { x, y, low: None, high: None }
    }

    /// Whether the ends of its interval are so far apart that the point says little.
    pub fn is_doubtful(&self) -> bool {
        is_doubtful(self.low, self.high)
    }
}

impl Series {
    /// A series without a fit.
    pub fn new(name: &str, points: Vec<Point>) -> Series {
        Series { name: name.into(), points, fit: None, is_default: false }
    }

    /// The same with the power law of its points, where there is one.
    pub fn fitted(mut self) -> Series {
        self.fit = Fit::of(&self.points);
        self
    }

    /// The same as the default choice, if `is_default`.
    pub fn default_if(mut self, is_default: bool) -> Series {
        self.is_default = is_default;
        self
    }
}

/// Repeats whose largest is this many times their smallest do not agree.
const DOUBTFUL: f64 = 10.0;

/// Whether the ends of an interval of positive figures differ by [`DOUBTFUL`] times or more.
pub(super) fn is_doubtful(low: Option<f64>, high: Option<f64>) -> bool {
    matches!((low, high), (Some(low), Some(high)) if low > 0.0 && high >= DOUBTFUL * low)
}

/// Digits of the numbers in tables and tips.
pub(super) const DIGITS: usize = 4;

/// What lines and bands of fits mean.
const FIT_NOTE: &str = "Lines: power laws by least squares. Shaded: laws through the points' centre whose slope is in \
                        its 95 % interval.";

impl Chart {
    /// The figure; `id` is unique on the page.
    pub(super) fn markup(&self, id: &str) -> Markup {
        let frame = self.frame();
        html! {
            figure.chart id=(id) {
                figcaption { (self.title) }
                @if !self.series.is_empty() { (self.legend()) }
                @match frame {
                    Some(frame) => (chart_marks::svg(self, &frame, id)),
                    None => p.gap { "No figures to draw." },
                }
                @for gap in self.gaps().into_iter().chain(self.doubtful()) { p.gap { (gap) } }
                @if self.series.iter().any(|series| !series.points.is_empty()) { (self.numbers()) }
            }
        }
    }

    /// Whether a point can be drawn.
    pub(super) fn shows(&self, point: &Point) -> bool {
        self.x.scale.shows(point.x) && self.y.scale.shows(point.y)
    }

    fn frame(&self) -> Option<Frame> {
        let shown = || self.series.iter().flat_map(|series| &series.points).filter(|point| self.shows(point));
        let heights = shown().flat_map(|point| [Some(point.y), point.low, point.high]).flatten();
        Some(Frame {
            x: Ruler::of(self.x.scale, shown().map(|point| point.x), chart_marks::LEFT, chart_marks::RIGHT)?,
            y: Ruler::of(self.y.scale, heights, chart_marks::BOTTOM, chart_marks::TOP)?,
        })
    }

    fn legend(&self) -> Markup {
        html! {
            ul.legend {
                @for (i, series) in self.series.iter().enumerate() {
                    li .default[series.is_default] {
                        (chart_marks::key(i)) (series.name)
                        @if series.is_default && !series.name.contains("default") { " (the default)" }
                        @if let Some(fit) = &series.fit {
                            span.fit { ": slope " (significant(fit.slope, 3)) " (95 %: " (significant(fit.slope_low, 3))
                                " to " (significant(fit.slope_high, 3)) ")" }
                        }
                    }
                }
            }
            @if self.series.iter().any(|series| series.fit.is_some()) {
                p.note { (FIT_NOTE) }
            }
        }
    }

    /// What the drawing lacks, a sentence each.
    fn gaps(&self) -> Vec<String> {
        let of_series = |series: &Series| {
            let missing: Vec<String> = series.points.iter().filter(|point| !self.shows(point)).map(describe).collect();
            match (series.points.len(), missing.len()) {
                (0, _) => Some(format!("{}: no figures.", series.name)),
                (_, 0) => None,
                (all, count) => Some(format!(
                    "{}: {count} of {all} points cannot be drawn, as they are not finite{}: {}{}.",
                    series.name,
                    if self.y.scale == super::Scale::Log || self.x.scale == super::Scale::Log {
                        " or not above 0"
                    } else {
                        ""
                    },
                    missing[..count.min(5)].join(", "),
                    if count > 5 { ", …" } else { "" }
                )),
            }
        };
        self.series.iter().filter_map(of_series).collect()
    }

    /// Points that repeats disagree on, a sentence a series.
    fn doubtful(&self) -> Vec<String> {
        let of_series = |series: &Series| {
            let points = series.points.iter().filter(|point| self.shows(point));
            let found: Vec<String> = points.filter(|point| point.is_doubtful()).map(describe_range).collect();
            let count = found.len();
            let at = if count == 1 { "a ringed point".to_owned() } else { format!("{count} ringed points") };
            (count > 0).then(|| {
                format!(
                    "{}: the repeats of {at} differ by {DOUBTFUL} times or more: {}{}.",
                    series.name,
                    found[..count.min(3)].join(", "),
                    if count > 3 { ", …" } else { "" }
                )
            })
        };
        self.series.iter().filter_map(of_series).collect()
    }

    fn numbers(&self) -> Markup {
        let rows = self.series.iter().flat_map(|series| {
            series.points.iter().map(move |point| {
                let end = |end: Option<f64>| end.map_or_else(String::new, |value| significant(value, DIGITS));
                let [x, y] = [point.x, point.y].map(|value| significant(value, DIGITS));
                vec![series.name.clone(), x, y, end(point.low), end(point.high)]
            })
        });
        let columns = ["series".into(), self.x.title(), self.y.title(), "low".into(), "high".into()];
        numbers(&self.title, &Table { columns: columns.into(), rows: rows.collect() })
    }
}

fn describe_range(point: &Point) -> String {
    let [low, high] = [point.low, point.high].map(|end| significant(end.unwrap_or(point.y), 3));
    format!("{low} to {high} at {}", significant(point.x, 3))
}

fn describe(point: &Point) -> String {
    format!("({}, {})", significant(point.x, 3), significant(point.y, 3))
}
