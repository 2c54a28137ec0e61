//! Compact polynomial mollifiers inside their support, with t in two words.

use super::Quantity;
use super::distance::{Distance, sphere};
use super::scaled::Scaled;
use super::series::{Exact, Polynomial};
use crate::real::{DoubleWord, Real};

/// The shape of a compact mollifier: its coefficients, without a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compact<T, const D: usize> {
    pub series: Exact<T, D>,
}

/// A point inside the support.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inside<'a, T, const D: usize> {
    shape: &'a Compact<T, D>,
    delta: Distance<T>,
    r: Distance<T>,
    /// (delta^2 - r^2)/delta^2. Both squares are exact, so its relative error is O(u^2) up to the edge.
    t: DoubleWord<T>,
}

impl<T: Real, const D: usize> Compact<T, D> {
    pub fn new(order: u32, exponent: u32) -> Self {
        Self { series: Exact::new(order, exponent) }
    }

    /// The point at distance `r` <= `delta`.
    pub fn inside(&self, delta: Distance<T>, r: Distance<T>) -> Inside<'_, T, D> {
        let t = (delta.square - r.square_in(delta.exponent)) / delta.square;
        Inside { shape: self, delta, r, t }
    }
}

impl<T: Real, const D: usize> Inside<'_, T, D> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        let (n, m) = (D as u32, self.shape.series.exponent());
        let (of, low, power) = match quantity {
            Quantity::Density => (Polynomial::Density, m, n),
            Quantity::DensitySlope => (Polynomial::DensitySlope, m - 1, n + 2),
            Quantity::Potential if D < 3 => return self.potential(),
            Quantity::Potential => (Polynomial::Potential, 0, 1),
            Quantity::GradientFactor => (Polynomial::Gradient, 0, n),
            Quantity::HessianFactor => (Polynomial::Hessian, 0, n + 2),
            Quantity::EnclosedMass => (Polynomial::Gradient, 0, 0),
        };
        let value = self.polynomial(of, low);
        if power == 0 {
            // (r/delta)^N G(t)
            return value.times(self.r.power(n)).over(self.delta.power(n));
        }
        // polynomial / (S_N delta^power)
        value.over(sphere(D).times(self.delta.power(power)))
    }

    /// A polynomial whose coefficients below `low` are zero, as t^low times the rest, because t^9 may underflow where the density does not.
    fn polynomial(&self, of: Polynomial, low: u32) -> Scaled<T> {
        let rest = self.shape.series.above_low(of, low as usize, self.t);
        Scaled::new(self.t, 0).powi(low).times(Scaled::new(rest, 0))
    }

    fn potential(&self) -> Scaled<T> {
        if D == 1 {
            // (delta/2) (c + (s/2) R(t)). In powers of t alone the terms would cancel.
            let s = self.r.square_in(self.delta.exponent) / self.delta.square;
            let start = (DoubleWord::ZERO, DoubleWord::ZERO);
            let (rise, lowest) = self.shape.series.rise().fold(start, |(sum, _), c| (sum * self.t + c, c));
            let centre = DoubleWord::ONE - lowest * T::HALF;
            return self.delta.length().scale((centre + s * rise * T::HALF) * T::HALF);
        }
        let p = self.shape.series.above_low(Polynomial::Potential, 0, self.t);
        Scaled::new(p + self.delta.log(), 0).over(sphere(2))
    }
}
