//! Tail probabilities of the distributions that tests and error bounds are judged by, in f64.
//!
//! Comes in: a statistic and its degrees of freedom. Goes out: the probability of one at least as extreme; NaN where it is not
//! defined, or where a series has not settled after 100,000 terms: neither passes a comparison with a limit. Relative error
//! below 1e-9 down to 1e-12 (`tests/statistics.rs` holds them against printed tables). Series and continued fractions are those
//! of Abramowitz and Stegun, chapters 6 and 26, evaluated by Lentz's method.

/// Terms after which a series that has not settled is given up: far above the need of any test here.
const TERMS: u32 = 100_000;

/// ln Γ(x) for x > 0 (Lanczos, g = 7, 9 terms: relative error about 1e-15).
pub fn ln_gamma(x: f64) -> f64 {
    const COEFFICIENTS: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        return (std::f64::consts::PI / (std::f64::consts::PI * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let sum = COEFFICIENTS[0] + (1..9).map(|i| COEFFICIENTS[i] / (x + i as f64)).sum::<f64>();
    let base = x + 7.5;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * base.ln() - base + sum.ln()
}

/// Upper regularised incomplete gamma function Q(a, x) = Γ(a, x) / Γ(a), for a > 0 and x >= 0.
pub fn gamma_upper(a: f64, x: f64) -> f64 {
    // Written so that a NaN is refused too.
    if !(a > 0.0 && x >= 0.0) {
        return f64::NAN;
    }
    if x == 0.0 {
        return 1.0;
    }
    let factor = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..TERMS {
            term *= x / (a + f64::from(n));
            sum += term;
            if term < sum * 1e-17 {
                return 1.0 - sum * factor;
            }
        }
        return f64::NAN;
    }
    // 1 / (x + 1 - a - 1(1 - a) / (x + 3 - a - 2(2 - a) / (x + 5 - a - …)))
    factor / continued_fraction(x + 1.0 - a, |n| (-n * (n - a), x + 2.0 * n + 1.0 - a))
}

/// Regularised incomplete beta function I_x(a, b), for positive a and b and x in [0, 1].
pub fn beta_lower(a: f64, b: f64, x: f64) -> f64 {
    if !(a > 0.0 && b > 0.0 && (0.0..=1.0).contains(&x)) {
        return f64::NAN;
    }
    if x == 0.0 || x == 1.0 {
        return x;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_lower(b, a, 1.0 - x);
    }
    let factor = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln()).exp() / a;
    // 1 + d1 / (1 + d2 / (1 + …)): odd terms d(2m+1), even terms d(2m).
    let term = |n: f64| {
        let m = (n / 2.0).floor();
        let numerator = if n % 2.0 == 0.0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (numerator, 1.0)
    };
    factor / continued_fraction(1.0, term)
}

/// first + n1 / (d1 + n2 / (d2 + …)) with (n_k, d_k) = `term(k)`, by Lentz's method.
fn continued_fraction(first: f64, term: impl Fn(f64) -> (f64, f64)) -> f64 {
    let guard = |value: f64| if value.abs() < 1e-300 { 1e-300 } else { value };
    let (mut value, mut c, mut d) = (guard(first), guard(first), 0.0);
    for n in 1..TERMS {
        let (numerator, denominator) = term(f64::from(n));
        d = 1.0 / guard(denominator + numerator * d);
        c = guard(denominator + numerator / c);
        value *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            return value;
        }
    }
    f64::NAN
}

/// Probability that a standard normal number lies at least `z` from 0, on either side.
pub fn normal_two_sided(z: f64) -> f64 {
    gamma_upper(0.5, z * z / 2.0)
}

/// Probability that Student's t of `dof` degrees of freedom lies at least `t` from 0, on either side.
pub fn student_two_sided(t: f64, dof: f64) -> f64 {
    beta_lower(dof / 2.0, 0.5, dof / (dof + t * t))
}

/// Probability that chi-square of `dof` degrees of freedom is at least `statistic`.
pub fn chi_square_upper(statistic: f64, dof: f64) -> f64 {
    gamma_upper(dof / 2.0, statistic / 2.0)
}

/// Probability that Kolmogorov's limit distribution is at least `x` (an alternating series; below 0.3 it is 1 to
/// within 1e-5).
pub fn kolmogorov_upper(x: f64) -> f64 {
    if x < 0.3 {
        return 1.0;
    }
    let term = |k: i32| (if k % 2 == 1 { 2.0 } else { -2.0 }) * (-2.0 * f64::from(k * k) * x * x).exp();
    (1..=20).map(term).sum::<f64>().clamp(0.0, 1.0)
}

/// The z that a standard normal number exceeds, on either side, with probability `alpha`.
pub fn normal_critical(alpha: f64) -> f64 {
    critical(alpha, normal_two_sided)
}

/// The t that Student's distribution of `dof` degrees of freedom, at least 1, exceeds, on either side, with probability
/// `alpha`.
pub fn student_critical(alpha: f64, dof: f64) -> f64 {
    critical(alpha, |t| student_two_sided(t, dof))
}

/// Where a falling tail probability is `alpha`, in (0, 1), by bisection to the last bits.
fn critical(alpha: f64, tail: impl Fn(f64) -> f64) -> f64 {
    if !(alpha > 0.0 && alpha < 1.0) {
        return f64::NAN;
    }
    let (mut low, mut high) = (0.0, 1.0);
    // Student's tail of one degree of freedom falls as 1 / t: doubling ends for any alpha that f64 holds.
    while tail(high) > alpha {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if tail(middle) > alpha {
            low = middle;
        } else {
            high = middle;
        }
    }
    // A tail that is not a number compares as one that has fallen, so `high` is where it would show.
    if tail(high).is_nan() { f64::NAN } else { (low + high) / 2.0 }
}
