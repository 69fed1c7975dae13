//! Means over the 5 x 5 pixels around each pixel, fewer at the border.

use rayon::prelude::*;

/// Pixels to each side that take part: 5 x 5 in all.
const NEIGHBOURS: usize = 2;

/// Mean of `value` over the neighbourhood of each pixel of a picture `width` pixels wide, in rows from the top. Sums are made
/// along rows first, then along columns, so they do not depend on threads.
pub fn means(width: usize, height: usize, value: impl Fn(usize) -> [f64; 3] + Sync) -> Vec<[f64; 3]> {
    let window = |at: usize, end: usize| at.saturating_sub(NEIGHBOURS)..(at + NEIGHBOURS + 1).min(end);
    let mut across = vec![[0.0; 3]; width * height];
    across.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, sum) in row.iter_mut().enumerate() {
            *sum = window(x, width).fold([0.0; 3], |sum, x| add(sum, value(y * width + x)));
        }
    });
    let mut means = vec![[0.0; 3]; width * height];
    means.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, mean) in row.iter_mut().enumerate() {
            let rows = window(y, height);
            let pixels = (rows.len() * window(x, width).len()) as f64;
            let sum = rows.fold([0.0; 3], |sum, row| add(sum, across[row * width + x]));
            *mean = sum.map(|sum| sum / pixels);
        }
    });
    means
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_end_at_the_border() {
        let means = means(7, 6, |i| [1.0, (i % 7) as f64, (i / 7) as f64]);
        assert_eq!(means[0], [1.0, 1.0, 1.0]);
        assert_eq!(means[3 * 7 + 3], [1.0, 3.0, 3.0]);
        assert_eq!(means[5 * 7 + 6], [1.0, 5.0, 4.0]);
        assert_eq!(super::means(1, 1, |_| [3.0; 3]), [[3.0; 3]]);
    }
}
