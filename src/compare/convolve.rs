//! Separable convolution of a plane of numbers; beyond the edges, the edge goes on.

use rayon::prelude::*;

/// A plane of numbers in rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// A number a place.
    pub values: Vec<f64>,
}

impl Plane {
    /// The plane convolved with `along_x`(x) · `along_y`(y), kernels of odd length centred on the place. The sum runs
    /// in the order of the image, as in a correlation: the first weight meets the left or upper neighbours.
    pub fn convolved(&self, along_x: &[f64], along_y: &[f64]) -> Plane {
        let (width, height) = (self.width, self.height);
        let (rx, ry) = ((along_x.len() / 2) as isize, (along_y.len() / 2) as isize);
        let held = |i: isize, count: usize| i.clamp(0, count as isize - 1) as usize;
        let mut rows = vec![0.0; self.values.len()];
        rows.par_chunks_mut(width).zip(self.values.par_chunks(width)).for_each(|(out, row)| {
            for (x, value) in out.iter_mut().enumerate() {
                let weighted = |(k, weight): (usize, &f64)| weight * row[held(x as isize + k as isize - rx, width)];
                *value = along_x.iter().enumerate().map(weighted).sum();
            }
        });
        let mut values = vec![0.0; self.values.len()];
        values.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            for (k, weight) in along_y.iter().enumerate() {
                let from = held(y as isize + k as isize - ry, height) * width;
                for (value, row) in out.iter_mut().zip(&rows[from..from + width]) {
                    *value += weight * row;
                }
            }
        });
        Plane { width, height, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_go_on_and_weights_keep_their_order() {
        let plane = Plane { width: 3, height: 2, values: vec![1.0, 2.0, 4.0, 10.0, 20.0, 40.0] };
        let left = plane.convolved(&[1.0, 0.0, 0.0], &[1.0]);
        assert_eq!(left.values, [1.0, 1.0, 2.0, 10.0, 10.0, 20.0]);
        let lower = plane.convolved(&[1.0], &[0.0, 0.0, 1.0]);
        assert_eq!(lower.values, [10.0, 20.0, 40.0, 10.0, 20.0, 40.0]);
        let mean = plane.convolved(&[0.25, 0.5, 0.25], &[1.0]);
        assert_eq!(mean.values[..3], [1.25, 2.25, 3.5]);
    }
}
