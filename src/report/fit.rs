//! A power law through points: a straight line by least squares in a log-log plane.

use super::Point;
use crate::statistics::distributions::student_critical;
use crate::statistics::fit_line;

/// Chance that the slope's interval misses the true slope, where the points scatter normally about the law.
const ALPHA: f64 = 0.05;

/// y = 10^intercept · x^slope, with the 95 % interval of the slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Exponent of x.
    pub slope: f64,
    /// log10 of y at x = 1.
    pub intercept: f64,
    /// Lower end of the 95 % interval of the slope.
    pub slope_low: f64,
    /// Upper end.
    pub slope_high: f64,
}

impl Fit {
    /// Through the points whose x and y are finite and above 0, each of the same weight; the interval is that of
    /// Student's t with two degrees of freedom fewer than points. `None` where fewer than three such points, or all at
    /// one x, leave nothing to tell scatter from slope.
    pub fn of(points: &[Point]) -> Option<Fit> {
        let logs = logarithms(points);
        let (first, _) = *logs.first()?;
        if logs.len() < 3 || logs.iter().all(|(x, _)| *x == first) {
            return None;
        }
        let line = fit_line(&logs);
        let half = student_critical(ALPHA, (logs.len() - 2) as f64) * line.slope_error;
        let fit = Fit {
            slope: line.slope,
            intercept: line.intercept,
            slope_low: line.slope - half,
            slope_high: line.slope + half,
        };
        [fit.slope, fit.intercept, half].iter().all(|value| value.is_finite()).then_some(fit)
    }

    /// y at `x` above 0.
    pub fn at(&self, x: f64) -> f64 {
        10f64.powf(self.intercept + self.slope * x.log10())
    }
}

/// log10 of x and y of the points that have both.
pub(super) fn logarithms(points: &[Point]) -> Vec<(f64, f64)> {
    let logs = points.iter().map(|point| (point.x.log10(), point.y.log10()));
    logs.filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(pairs: &[(f64, f64)]) -> Vec<Point> {
        pairs.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    /// Printed tables of Student's t, two-sided 5 %.
    #[test]
    fn critical_t() {
        for (dof, t) in [(1.0, 12.706), (2.0, 4.303), (5.0, 2.571), (30.0, 2.042)] {
            assert!((student_critical(0.05, dof) - t).abs() < 1e-3, "{dof}");
        }
    }

    #[test]
    fn a_power_law_is_found_exactly() {
        let law = |x: f64| 3.0 * x.powf(-0.5);
        let exact: Vec<Point> = [1.0, 4.0, 16.0, 256.0].map(|x| Point::new(x, law(x))).into();
        let fit = Fit::of(&exact).unwrap();
        assert!((fit.slope + 0.5).abs() < 1e-12 && (fit.intercept - 3f64.log10()).abs() < 1e-12);
        assert!((fit.at(64.0) - law(64.0)).abs() < 1e-12);
        assert!(fit.slope_high - fit.slope_low < 1e-10);
    }

    /// log10 points (0, 0), (1, 1.1), (2, 1.9): slope 0.95, residuals ∓0.05, 0.1: s² = 0.015, se = √(0.015 / 2), t =
    /// 12.706.
    #[test]
    fn the_interval_is_students() {
        let fit = Fit::of(&points(&[(1.0, 1.0), (10.0, 10f64.powf(1.1)), (100.0, 10f64.powf(1.9))])).unwrap();
        assert!((fit.slope - 0.95).abs() < 1e-12);
        let half = 12.706_204_7 * (0.015f64 / 2.0).sqrt();
        assert!((fit.slope_high - 0.95 - half).abs() < 1e-6, "{fit:?}");
        assert!((fit.slope_low - 0.95 + half).abs() < 1e-6, "{fit:?}");
    }

    #[test]
    fn what_cannot_be_fitted_is_not() {
        assert_eq!(Fit::of(&[]), None);
        assert_eq!(Fit::of(&points(&[(1.0, 1.0), (2.0, 2.0)])), None);
        assert_eq!(Fit::of(&points(&[(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)])), None);
        assert_eq!(Fit::of(&points(&[(1.0, 1.0), (2.0, 0.0), (3.0, f64::NAN), (-1.0, 1.0), (4.0, 2.0)])), None);
    }
}
