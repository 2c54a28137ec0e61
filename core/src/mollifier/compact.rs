//! Compact polynomial mollifiers inside their support, with t carried as a sum of two numbers.

use super::Quantity;
use super::distance::{Distance, sphere};
use super::scaled::Scaled;
use super::series::{Exact, Polynomial};
use crate::real::{DoubleWord, Real};

/// A compact mollifier's shape: its coefficients, without a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compact<T> {
    exponent: u32,
    pub series: Exact<T>,
}

/// A place inside the support.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inside<'a, T> {
    shape: &'a Compact<T>,
    dimension: usize,
    delta: Distance<T>,
    r: Distance<T>,
    /// (delta^2 - r^2)/delta^2, whose relative error stays O(u^2) up to the edge, as both squares are exact.
    t: DoubleWord<T>,
}

impl<T: Real> Compact<T> {
    pub fn new<const D: usize>(order: u32, exponent: u32) -> Self {
        Self { exponent, series: Exact::new::<D>(order, exponent) }
    }

    /// The place at distance `r` <= `delta`.
    pub fn inside(&self, dimension: usize, delta: Distance<T>, r: Distance<T>) -> Inside<'_, T> {
        let t = (delta.square - r.square_in(delta.exponent)) / delta.square;
        Inside { shape: self, dimension, delta, r, t }
    }
}

impl<T: Real> Inside<'_, T> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        match quantity {
            Quantity::Density => self.density(),
            Quantity::DensitySlope => self.density_slope(),
            Quantity::Potential => self.potential(),
            Quantity::GradientFactor => self.gradient(),
            Quantity::HessianFactor => self.hessian(),
            Quantity::EnclosedMass => self.enclosed_mass(),
        }
    }

    /// `polynomial / (S_N delta^power)`.
    fn over_power(&self, value: Scaled<T>, power: u32) -> Scaled<T> {
        value.over(sphere(self.dimension).times(self.delta.power(power)))
    }

    fn polynomial(&self, of: Polynomial) -> Scaled<T> {
        Scaled::new(self.shape.series.above_low(of, 0, self.t), 0)
    }

    /// t^low times a polynomial whose coefficients below `low` are zero: t^9 may underflow where the density does not.
    fn high_polynomial(&self, of: Polynomial, low: u32) -> Scaled<T> {
        let rest = self.shape.series.above_low(of, low as usize, self.t);
        Scaled::new(self.t, 0).powi(low).times(Scaled::new(rest, 0))
    }

    fn density(&self) -> Scaled<T> {
        let b = self.high_polynomial(Polynomial::Density, self.shape.exponent);
        self.over_power(b, self.dimension as u32)
    }

    fn density_slope(&self) -> Scaled<T> {
        let q = self.high_polynomial(Polynomial::DensitySlope, self.shape.exponent - 1);
        self.over_power(q, self.dimension as u32 + 2)
    }

    fn gradient(&self) -> Scaled<T> {
        self.over_power(self.polynomial(Polynomial::Gradient), self.dimension as u32)
    }

    fn hessian(&self) -> Scaled<T> {
        self.over_power(self.polynomial(Polynomial::Hessian), self.dimension as u32 + 2)
    }

    fn potential(&self) -> Scaled<T> {
        match self.dimension {
            1 => {
                // (delta/2) (c + (s/2) R(t)): in powers of t alone the terms cancel.
                let s = self.r.square_in(self.delta.exponent) / self.delta.square;
                let start = (DoubleWord::ZERO, DoubleWord::ZERO);
                let (rise, lowest) = self.shape.series.rise().fold(start, |(sum, _), c| (sum * self.t + c, c));
                let centre = DoubleWord::ONE - lowest * T::HALF;
                self.delta.length().scale((centre + s * rise * T::HALF) * T::HALF)
            }
            2 => {
                let p = self.shape.series.above_low(Polynomial::Potential, 0, self.t);
                Scaled::new(p + self.delta.log(), 0).over(sphere(2))
            }
            _ => self.over_power(self.polynomial(Polynomial::Potential), 1),
        }
    }

    /// (r/delta)^N G(t).
    fn enclosed_mass(&self) -> Scaled<T> {
        let n = self.dimension as u32;
        self.polynomial(Polynomial::Gradient).times(self.r.power(n)).over(self.delta.power(n))
    }
}
