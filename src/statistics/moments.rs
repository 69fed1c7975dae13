//! What numbers that come one by one amount to: mean and variance, or the largest error.
//!
//! Comes in: numbers. Goes out: their [`Moments`] or the [`Worst`] of them, in f64.

/// Count, mean and sum of squared deviations, updated number by number (Welford) or merged (Chan).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Numbers seen.
    pub count: f64,
    /// Their mean.
    pub mean: f64,
    squares: f64,
}

impl Moments {
    /// Moments of a set of numbers.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Moments {
        let mut moments = Moments::default();
        values.into_iter().for_each(|value| moments.add(value));
        moments
    }

    /// Adds one number.
    pub fn add(&mut self, value: f64) {
        self.count += 1.0;
        let change = value - self.mean;
        self.mean += change / self.count;
        self.squares += change * (value - self.mean);
    }

    /// Unbiased variance of the numbers.
    pub fn variance(&self) -> f64 {
        self.squares / (self.count - 1.0)
    }

    /// Estimated variance of the mean.
    pub fn variance_of_mean(&self) -> f64 {
        self.variance() / self.count
    }
}

/// The largest of many errors; a NaN among them is larger than any.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst(pub f64);

impl Worst {
    /// Takes one error into account.
    pub fn add(&mut self, error: f64) {
        self.0 = if error.is_nan() { f64::INFINITY } else { self.0.max(error) };
    }
}
