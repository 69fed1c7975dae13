//! The drawing of a chart: grid, axes, bands, lines, whiskers, marks.
//!
//! Comes in: a chart and its two rulers. Goes out: one SVG element. Colours are classes (`s0` to `s7`), which page.css
//! gives a value for light and dark; places are in units of the drawing, 1/560 of its width.

use std::fmt::Write;

use maud::{Markup, html};

use super::axis::{Ruler, Tick};
use super::chart::{Chart, DIGITS, Point, Series};
use super::fit::logarithms;
use super::number::significant;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 360.0;
/// Left end of the horizontal axis: letters of narrow screens, which are larger, have room for six digits.
pub(super) const LEFT: f64 = 78.0;
/// Right end, with room for half of its last number.
pub(super) const RIGHT: f64 = 528.0;
/// Lower end of the vertical axis.
pub(super) const BOTTOM: f64 = 304.0;
/// Upper end, below the vertical axis's name.
pub(super) const TOP: f64 = 36.0;
/// Length of a tick without a name.
const MINOR: f64 = 6.0;
/// Half the width of a mark.
const MARK: f64 = 4.5;
/// Half the width of a whisker's ends.
const CAP: f64 = 4.0;
/// Series before colours come again; with the shapes, of which there are seven, 56 series differ.
const COLOURS: usize = 8;
/// Pieces of a fitted line, which is straight in a log-log plane only.
const PIECES: usize = 48;

/// The rulers of a chart.
pub(super) struct Frame {
    /// Along the width.
    pub x: Ruler,
    /// Along the height.
    pub y: Ruler,
}

/// The drawing. `id` names its title.
pub(super) fn svg(chart: &Chart, frame: &Frame, id: &str) -> Markup {
    let label = format!("{id}-label");
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-labelledby=(label) {
            title id=(label) { (chart.title) ": " (chart.y.title()) " against " (chart.x.title()) }
            (axes(chart, frame))
            @for (i, series) in drawn(&chart.series) {
                g.series.(colour(i)).default[series.is_default] {
                    (band(series, frame))
                    (line(chart, series, frame))
                    @for point in series.points.iter().filter(|point| chart.shows(point)) {
                        (whisker(point, frame)) (ring(point, frame)) (mark(chart, series, i, point, frame))
                    }
                }
            }
        }
    }
}

/// The series in the order of drawing: the default last, so that no other hides it.
fn drawn(series: &[Series]) -> Vec<(usize, &Series)> {
    let mut drawn: Vec<_> = series.iter().enumerate().collect();
    drawn.sort_by_key(|(_, series)| series.is_default);
    drawn
}

/// A ring about a point that repeats disagree on.
fn ring(point: &Point, frame: &Frame) -> Markup {
    match (frame.x.at(point.x), frame.y.at(point.y)) {
        (Some(x), Some(y)) if point.is_doubtful() => html! { circle.doubt cx=(unit(x)) cy=(unit(y)) r=(2.0 * MARK) {} },
        _ => Markup::default(),
    }
}

/// A series' mark beside its name.
pub(super) fn key(series: usize) -> Markup {
    html! {
        svg.key.(colour(series)) viewBox="0 0 24 12" aria-hidden="true" {
            line.line x1="0" y1="6" x2="24" y2="6" {}
            path.dot d=(shape(series, 12.0, 6.0)) {}
        }
    }
}

fn colour(series: usize) -> String {
    format!("s{}", series % COLOURS)
}

fn axes(chart: &Chart, frame: &Frame) -> Markup {
    let at = |ruler: &Ruler| -> Vec<(f64, Tick)> {
        ruler.ticks().into_iter().filter_map(|tick| Some((ruler.at(tick.value)?, tick))).collect()
    };
    html! {
        g.axis {
            @for (x, tick) in at(&frame.x) {
                line.grid x1=(unit(x)) y1=(tick_end(&tick, BOTTOM - MINOR, TOP)) x2=(unit(x)) y2=(BOTTOM) {}
                text x=(unit(x)) y=(BOTTOM + 19.0) text-anchor="middle" { (tick.label) }
            }
            @for (y, tick) in at(&frame.y) {
                line.grid x1=(LEFT) y1=(unit(y)) x2=(tick_end(&tick, LEFT + MINOR, RIGHT)) y2=(unit(y)) {}
                text x=(LEFT - 8.0) y=(unit(y + 4.5)) text-anchor="end" { (tick.label) }
            }
            path.frame d=(format!("M{LEFT} {TOP}V{BOTTOM}H{RIGHT}")) {}
            text.name x=(unit((LEFT + RIGHT) / 2.0)) y=(HEIGHT - 10.0) text-anchor="middle" { (chart.x.title()) }
            // Above its axis: beside it, it would stand on the numbers of narrow screens.
            text.name x="4" y=(TOP - 18.0) { (chart.y.title()) }
        }
    }
}

/// Where a tick's line ends: at `minor` without a name, else across the drawing.
fn tick_end(tick: &Tick, minor: f64, across: f64) -> f64 {
    if tick.label.is_empty() { minor } else { across }
}

/// The laws through the points' centre with the ends of the slope's interval.
fn band(series: &Series, frame: &Frame) -> Markup {
    let Some(fit) = series.fit else { return Markup::default() };
    let logs = logarithms(&series.points);
    if logs.is_empty() {
        return Markup::default();
    }
    let centre = logs.iter().map(|(x, _)| x / logs.len() as f64).sum::<f64>();
    let height = fit.intercept + fit.slope * centre;
    let edge = |slope: f64| move |x: f64| 10f64.powf(height + slope * (x.log10() - centre));
    let mut outline = curve(frame, &logs, edge(fit.slope_high));
    let mut back = curve(frame, &logs, edge(fit.slope_low));
    back.reverse();
    outline.append(&mut back);
    html! { path.band d=(format!("{}Z", path(&outline))) {} }
}

/// The fitted law, or the points joined in the order of x.
fn line(chart: &Chart, series: &Series, frame: &Frame) -> Markup {
    let places = match series.fit {
        Some(fit) => curve(frame, &logarithms(&series.points), |x| fit.at(x)),
        None => {
            let mut points: Vec<&Point> = series.points.iter().filter(|point| chart.shows(point)).collect();
            points.sort_by(|a, b| a.x.total_cmp(&b.x));
            points.into_iter().filter_map(|point| Some((frame.x.at(point.x)?, frame.y.at(point.y)?))).collect()
        }
    };
    html! { @if places.len() > 1 { path.line d=(path(&places)) {} } }
}

/// Places of y = `law`(x) over the extent of the points, held to the frame.
fn curve(frame: &Frame, logs: &[(f64, f64)], law: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let low = logs.iter().map(|(x, _)| *x).fold(f64::INFINITY, f64::min);
    let high = logs.iter().map(|(x, _)| *x).fold(f64::NEG_INFINITY, f64::max);
    let at = |i: usize| 10f64.powf(low + (high - low) * i as f64 / PIECES as f64);
    (0..=PIECES).map(at).map(|x| (frame.x.clamped(x), frame.y.clamped(law(x)))).collect()
}

fn whisker(point: &Point, frame: &Frame) -> Markup {
    let ends = [point.low, point.high].map(|end| end.filter(|end| !end.is_nan()));
    let (Some(x), true) = (frame.x.at(point.x), ends.iter().any(Option::is_some)) else { return Markup::default() };
    let [low, high] = ends.map(|end| frame.y.clamped(end.unwrap_or(point.y)));
    let d = format!(
        "M{0} {low}V{high}M{1} {low}H{2}M{1} {high}H{2}",
        unit(x),
        unit(x - CAP),
        unit(x + CAP),
        low = unit(low),
        high = unit(high)
    );
    html! { path.whisker d=(d) {} }
}

fn mark(chart: &Chart, series: &Series, index: usize, point: &Point, frame: &Frame) -> Markup {
    let (Some(x), Some(y)) = (frame.x.at(point.x), frame.y.at(point.y)) else { return Markup::default() };
    let mut tip = format!("{}\n", series.name);
    let _ = write!(
        tip,
        "{}: {}\n{}: {}",
        chart.x.title(),
        significant(point.x, DIGITS),
        chart.y.title(),
        significant(point.y, DIGITS)
    );
    if let (Some(low), Some(high)) = (point.low, point.high) {
        let _ = write!(tip, " ({} to {})", significant(low, DIGITS), significant(high, DIGITS));
    }
    html! { path.dot.mark d=(shape(index, x, y)) { title { (tip) } } }
}

/// The outline of a mark at a place: disc, square, triangle up, diamond, triangle down, cross, star of two squares.
fn shape(series: usize, x: f64, y: f64) -> String {
    let r = MARK;
    let corners: &[(f64, f64)] = match series % 7 {
        0 => {
            let (x, y) = (unit(x - r), unit(y));
            return format!("M{x} {y}a{r} {r} 0 1 0 {0} 0a{r} {r} 0 1 0 -{0} 0Z", 2.0 * r);
        }
        1 => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
        2 => &[(0.0, -1.25), (1.15, 0.8), (-1.15, 0.8)],
        3 => &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
        4 => &[(0.0, 1.25), (1.15, -0.8), (-1.15, -0.8)],
        5 => &[
            (-0.4, -1.2),
            (0.4, -1.2),
            (0.4, -0.4),
            (1.2, -0.4),
            (1.2, 0.4),
            (0.4, 0.4),
            (0.4, 1.2),
            (-0.4, 1.2),
            (-0.4, 0.4),
            (-1.2, 0.4),
            (-1.2, -0.4),
            (-0.4, -0.4),
        ],
        _ => &[
            (0.0, -1.4),
            (0.45, -0.45),
            (1.4, 0.0),
            (0.45, 0.45),
            (0.0, 1.4),
            (-0.45, 0.45),
            (-1.4, 0.0),
            (-0.45, -0.45),
        ],
    };
    let places: Vec<(f64, f64)> = corners.iter().map(|(dx, dy)| (x + dx * r, y + dy * r)).collect();
    format!("{}Z", path(&places))
}

fn path(places: &[(f64, f64)]) -> String {
    let mut d = String::new();
    for (i, (x, y)) in places.iter().enumerate() {
        let _ = write!(d, "{}{} {}", if i == 0 { 'M' } else { 'L' }, unit(*x), unit(*y));
    }
    d
}

/// A place in hundredths of a unit, without trailing zeros.
pub(super) fn unit(place: f64) -> f64 {
    (place * 100.0).round() / 100.0
}
