//! The singular Newtonian field, which is the field of every mollifier outside its support.

use super::Quantity;
use super::distance::{Distance, sphere};
use super::scaled::Scaled;
use crate::real::{DoubleWord, Real};

/// The field of a unit particle at distance r > 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Newtonian<T, const D: usize> {
    pub r: Distance<T>,
}

impl<T: Real, const D: usize> Newtonian<T, D> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        match quantity {
            Quantity::Density | Quantity::DensitySlope => Scaled::ZERO,
            Quantity::Potential => self.potential(),
            Quantity::GradientFactor => self.gradient(),
            Quantity::HessianFactor => self.hessian(),
            Quantity::EnclosedMass => Scaled::from(T::ONE),
        }
    }

    /// |x|/2, log|x|/(2 pi), -1/(4 pi |x|).
    pub fn potential(&self) -> Scaled<T> {
        match D {
            1 => self.r.length().shift(-1),
            2 => Scaled::new(self.r.log(), 0).over(sphere(2)),
            _ => Scaled::from(-T::ONE).over(sphere::<T>(3).times(self.r.length())),
        }
    }

    /// 1 / (S_N r^N).
    pub fn gradient(&self) -> Scaled<T> {
        Scaled::from(T::ONE).over(sphere::<T>(D).times(self.r.power(D as u32)))
    }

    /// -N / (S_N r^(N+2)).
    pub fn hessian(&self) -> Scaled<T> {
        self.gradient().over(self.r.squared()).scale(DoubleWord::from(-T::from_usize(D)))
    }
}
