//! The error of a picture against a reference.

/// Keeps dark pixels from deciding the whole: the denominator is (reference² + this). The peers' scripts use the same.
pub const DENOMINATOR_FLOOR: f64 = 0.01;

/// Relative mean squared error: mean over pixels and channels of (x - r)² / (r² + 0.01), nothing clipped. Both pictures
/// in the scene's own units. `None` where their sizes differ or there is no pixel.
pub fn relative_mse(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> Option<f64> {
    if picture.len() != reference.len() || picture.is_empty() {
        return None;
    }
    let pairs = picture.iter().flatten().zip(reference.iter().flatten());
    let sum: f64 = pairs
        .map(|(&x, &r)| {
            let (x, r) = (f64::from(x), f64::from(r));
            (x - r).powi(2) / (r * r + DENOMINATOR_FLOOR)
        })
        .sum();
    Some(sum / (3 * picture.len()) as f64)
}

/// Mean squared error: mean over pixels and channels of (x - r)². `None` where their sizes differ or there is no pixel.
pub fn mean_squared(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> Option<f64> {
    if picture.len() != reference.len() || picture.is_empty() {
        return None;
    }
    let pairs = picture.iter().flatten().zip(reference.iter().flatten());
    let sum: f64 = pairs.map(|(&x, &r)| (f64::from(x) - f64::from(r)).powi(2)).sum();
    Some(sum / (3 * picture.len()) as f64)
}

/// Mean over pixels and channels.
pub fn mean(picture: &[[f32; 3]]) -> f64 {
    picture.iter().flatten().map(|&x| f64::from(x)).sum::<f64>() / (3 * picture.len()).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_known_pictures() {
        let reference = [[1.0, 0.0, 2.0]];
        assert_eq!(relative_mse(&reference, &reference), Some(0.0));
        let error = relative_mse(&[[1.1, 0.1, 2.0]], &reference).unwrap();
        assert!((error - (0.01 / 1.01 + 0.01 / 0.01) / 3.0).abs() < 1e-6, "{error}");
        assert_eq!(relative_mse(&[], &[]), None);
        assert_eq!(relative_mse(&reference, &[]), None);
        assert_eq!(mean(&reference), 1.0);
        let squared = mean_squared(&[[1.5, 0.0, 1.0]], &reference).unwrap();
        assert_eq!(squared, (0.25 + 1.0) / 3.0);
        assert_eq!(mean_squared(&[], &[]), None);
    }
}
