//! A compensated sum.

use crate::real::Real;

/// A sum with compensation for its rounding errors: Neumaier's variant of Kahan's summation.
///
/// The result is within 2 u |sum| + (n u)^2 sum |x_j|, to leading order, of the exact sum of the terms as given (Ogita,
/// Rump, Oishi, *Accurate sum and dot product*, 2005, the bound of their Sum2).
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum<T> {
    high: T,
    low: T,
}

impl<T: Real> Sum<T> {
    /// Adds one term.
    #[inline]
    pub fn add(&mut self, term: T) {
        let total = self.high + term;
        self.low += if self.high.abs() >= term.abs() { (self.high - total) + term } else { (term - total) + self.high };
        self.high = total;
    }

    /// The sum so far.
    #[inline]
    #[must_use]
    pub fn value(&self) -> T {
        self.high + self.low
    }
}
