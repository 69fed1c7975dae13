//! The largest of many errors.
//!
//! Comes in: errors, one by one. Goes out: the largest, infinite where one of them was not a number.

/// The largest of many errors; a NaN among them is larger than any.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst(pub f64);

impl Worst {
    /// Takes one error into account.
    pub fn add(&mut self, error: f64) {
        self.0 = if error.is_nan() { f64::INFINITY } else { self.0.max(error) };
    }
}
