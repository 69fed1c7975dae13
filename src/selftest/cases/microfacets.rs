//! GGX in f64, by other ways than the shader's: integrals over microfacet normals.
//!
//! Comes in: roughness and the angle of wo. Goes out: the distribution, the directional albedo of the lossless lobe, and how
//! many visible normals fall in a cell. Normals are described by (s, t): s = tan²θ / (tan²θ + α²) and t = φ / 2π, in
//! which D(h) cos θ dω is uniform on the unit square.

use std::f64::consts::{PI, TAU};

/// D(h) of any h, in the form that is a sum of squares.
pub fn distribution([x, y, z]: [f64; 3], alpha: f64) -> f64 {
    let sum = (x / alpha).powi(2) + (y / alpha).powi(2) + z * z;
    1.0 / (PI * alpha * alpha * sum * sum)
}

/// The direction of (s, t).
fn normal(s: f64, t: f64, alpha: f64) -> [f64; 3] {
    let tan2 = alpha * alpha * s / (1.0 - s);
    let cosine = 1.0 / (1.0 + tan2).sqrt();
    let (sin, cos) = (TAU * t).sin_cos();
    let sine = (tan2 / (1.0 + tan2)).sqrt();
    [sine * cos, sine * sin, cosine]
}

/// (s, t) of a direction.
pub fn place([x, y, z]: [f64; 3], alpha: f64) -> [f64; 2] {
    let tan2 = (x * x + y * y) / (z * z);
    [tan2 / (tan2 + alpha * alpha), (y.atan2(x) / TAU).rem_euclid(1.0)]
}

/// `w` in the plane y = 0, stretched.
fn stretched(sine: f64, cosine: f64, alpha: f64) -> f64 {
    (alpha * alpha * sine * sine + cosine * cosine).sqrt()
}

/// Directional albedo: ∫ D(h) G2(wo, wi) (wo · h) / cos θo dω, by midpoints of a grid, s = 1 - (1 - v)² so that its end is
/// finely divided.
pub fn albedo(theta: f64, alpha: f64, side: usize) -> f64 {
    let (sine, cosine) = theta.sin_cos();
    let so = stretched(sine, cosine, alpha);
    let mut sum = 0.0;
    for i in 0..side {
        let v = (i as f64 + 0.5) / side as f64;
        let (s, density) = (1.0 - (1.0 - v) * (1.0 - v), 2.0 * (1.0 - v));
        for j in 0..side {
            // By symmetry, half of the circle.
            let [x, y, z] = normal(s, 0.5 * (j as f64 + 0.5) / side as f64, alpha);
            let along = sine * x + cosine * z;
            let wi = [2.0 * along * x - sine, 2.0 * along * y, 2.0 * along * z - cosine];
            if along > 0.0 && wi[2] > 0.0 {
                let si = stretched(wi[0].hypot(wi[1]), wi[2], alpha);
                sum += density * 2.0 * wi[2] / (cosine * si + wi[2] * so) * along / z;
            }
        }
    }
    sum / (side * side) as f64
}

/// Probabilities of visible normals in `rows` x `columns` cells of (s, t), by `fine` x `fine` midpoints a cell; where all of
/// these are hidden but the cell is not, by 16 times as many a side.
pub fn visible_normals(theta: f64, alpha: f64, [rows, columns]: [usize; 2], fine: usize) -> Vec<f64> {
    let (sine, cosine) = theta.sin_cos();
    let masking = 2.0 / (cosine + stretched(sine, cosine, alpha));
    let share = |row: usize, column: usize, fine: usize| {
        let mut sum = 0.0;
        for i in 0..fine {
            // The last row ends where the density is infinite: finely divided there, as in `albedo`.
            let u = (i as f64 + 0.5) / fine as f64;
            let (u, density) = (1.0 - (1.0 - u) * (1.0 - u), 2.0 * (1.0 - u));
            for j in 0..fine {
                let v = (j as f64 + 0.5) / fine as f64;
                let [x, _, z] = normal((row as f64 + u) / rows as f64, (column as f64 + v) / columns as f64, alpha);
                sum += density * (sine * x + cosine * z).max(0.0) / z;
            }
        }
        masking * sum / (fine * fine * rows * columns) as f64
    };
    // Of hidden normals the steepest are hidden most: a cell shows most where it is flattest, at one of its ends in t.
    let shows = |row: usize, column: usize| {
        [column, column + 1].into_iter().any(|end| {
            let [x, _, z] = normal(row as f64 / rows as f64, end as f64 / columns as f64, alpha);
            sine * x + cosine * z > 0.0
        })
    };
    let cell = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        match share(row, column, fine) {
            0.0 if shows(row, column) => share(row, column, 16 * fine),
            share => share,
        }
    };
    (0..rows * columns).map(cell).collect()
}
