//! A line through points.
//!
//! Comes in: points. Goes out: the line of least squares with the error of its slope.

/// A straight line through points, by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Rise of y a unit of x.
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// Standard error of the slope from the points' scatter about the line (0 of two points).
    pub slope_error: f64,
}

/// Fits a line; log-log points of error against samples have slope -1 (variance) or -1/2 (standard error).
pub fn fit_line(points: &[(f64, f64)]) -> Line {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / n, y + point.1 / n));
    let spread: f64 = points.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    let slope = points.iter().map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / spread;
    let intercept = my - slope * mx;
    let rest: f64 = points.iter().map(|(x, y)| (y - intercept - slope * x).powi(2)).sum();
    let slope_error = if points.len() > 2 { (rest / (n - 2.0) / spread).sqrt() } else { 0.0 };
    Line { slope, intercept, slope_error }
}
