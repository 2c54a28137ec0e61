//! A mollifier prepared with its length: scalar functions of the distance, accurate to about one ulp.

use super::algebraic::{Kind, Soft};
use super::combined::{Combined, Parts, RICHARDSON};
use super::compact::{Compact, Inside};
use super::distance::Distance;
use super::gaussian::{Around, Gaussian};
use super::newtonian::Newtonian;
use super::scaled::Scaled;
use super::series::{Polynomial, Polynomials};
use super::{Mollifier, Quantity};
use crate::error::{Error, Result};
use crate::real::Real;

/// A mollifier with its length delta in dimension `D` = 1, 2 or 3. A plain value of at most 300 bytes.
///
/// Functions of r use its magnitude and return NaN where r is not finite. Without a mollifier r = 0 contributes
/// nothing: every function is 0 there.
#[derive(Clone, Copy, Debug)]
pub struct Blob<T: Real, const D: usize> {
    mollifier: Mollifier,
    delta: T,
    length: Distance<T>,
    shape: Shape<T, D>,
}

/// Algebraic mollifiers are left out with kernels other than the Newtonian one.
pub(super) const ALGEBRAIC: bool = cfg!(feature = "kernels");

#[derive(Clone, Copy, Debug)]
pub(super) enum Shape<T, const D: usize> {
    None,
    Compact(Compact<T, D>),
    Gaussian(Gaussian),
    Algebraic(Kind),
    Combined(Combined<T, D>),
}

/// The region of a distance, which determines the formula.
pub(super) enum Place<'a, T, const D: usize> {
    /// At zero distance from an unmollified particle.
    Coincident,
    /// Where the field is exactly Newtonian.
    Outside(Newtonian<T, D>),
    Compact(Inside<'a, T, D>),
    Gaussian(Around<T, D>),
    Algebraic(Soft<T, D>),
    Combined(Parts<'a, T, D>),
}

impl<T: Real, const D: usize> Blob<T, D> {
    /// Checks the arguments of [`Blob::new`] and returns the length it will have.
    ///
    /// # Errors
    /// As [`Blob::new`].
    pub fn check(mollifier: Mollifier, delta: T) -> Result<T> {
        mollifier.check(D)?;
        match mollifier {
            Mollifier::None => Ok(T::ZERO),
            _ if delta > T::ZERO && delta.is_finite() => Ok(delta),
            _ => Err(Error::Delta),
        }
    }

    /// Prepares a mollifier. `delta` is ignored for [`Mollifier::None`].
    ///
    /// # Errors
    /// [`Error::Delta`]: not positive and finite; and those of [`Mollifier::check`].
    pub fn new(mollifier: Mollifier, delta: T) -> Result<Self> {
        let delta = Self::check(mollifier, delta)?;
        let shape = match mollifier {
            Mollifier::None => Shape::None,
            Mollifier::Compact { order, exponent } => Shape::Compact(Compact::new(order, exponent)),
            Mollifier::Gaussian { order } => Shape::Gaussian(Gaussian::new(D, order)),
            Mollifier::Plummer => Shape::Algebraic(Kind::Plummer),
            Mollifier::Algebraic => Shape::Algebraic(Kind::Algebraic),
            Mollifier::Vatistas => Shape::Algebraic(Kind::Vatistas),
            Mollifier::Richardson { .. } => Shape::Combined(Combined::of(mollifier).ok_or(Error::Unsupported)?),
        };
        Ok(Self { mollifier, delta, length: Distance::new(delta), shape })
    }

    /// The same mollifier over another length, which is positive and finite.
    pub(crate) fn with_delta(self, delta: T) -> Self {
        Self { delta, length: Distance::new(delta), ..self }
    }

    /// The mollifier.
    #[must_use]
    pub fn mollifier(&self) -> Mollifier {
        self.mollifier
    }

    /// delta; 0 without a mollifier.
    #[must_use]
    pub fn delta(&self) -> T {
        self.delta
    }

    /// The coefficients for sums over many particles; `None` unless the mollifier is compact.
    #[must_use]
    pub fn polynomials(&self) -> Option<Polynomials<T>> {
        match &self.shape {
            Shape::Compact(shape) => Some(Polynomials::new(&shape.series, self.delta)),
            _ => None,
        }
    }

    /// Those of what a combination combines, of the radius delta; else its own.
    pub(crate) fn polynomials_of_part(&self) -> Option<Polynomials<T>> {
        match &self.shape {
            Shape::Combined(shape) if RICHARDSON => Some(Polynomials::new(shape.series(), self.delta)),
            _ => self.polynomials(),
        }
    }

    /// The number of coefficients of a polynomial in t; `None` unless the mollifier is compact.
    pub(crate) fn terms(&self, of: Polynomial) -> Option<usize> {
        match &self.shape {
            Shape::Compact(shape) => Some(shape.series.terms(of)),
            _ => None,
        }
    }

    /// One of these coefficients, rounded.
    pub(crate) fn coefficient(&self, of: Polynomial, k: usize) -> T {
        match &self.shape {
            Shape::Compact(shape) => shape.series.coefficient(of, k).hi,
            _ => T::ZERO,
        }
    }

    /// B(r) = psi_delta(r), the mollifier itself.
    #[must_use]
    pub fn density(&self, r: T) -> T {
        self.evaluate(Quantity::Density, r)
    }

    /// B'(r)/r. At the edge of a compact mollifier with M = 1, where B' jumps, the value inside.
    #[must_use]
    pub fn density_slope(&self, r: T) -> T {
        self.evaluate(Quantity::DensitySlope, r)
    }

    /// phi(r) = (K * psi_delta)(r) for the Newtonian K.
    #[must_use]
    pub fn potential(&self, r: T) -> T {
        self.evaluate(Quantity::Potential, r)
    }

    /// g(r) = phi'(r)/r.
    #[must_use]
    pub fn gradient_factor(&self, r: T) -> T {
        self.evaluate(Quantity::GradientFactor, r)
    }

    /// h(r) = g'(r)/r.
    #[must_use]
    pub fn hessian_factor(&self, r: T) -> T {
        self.evaluate(Quantity::HessianFactor, r)
    }

    /// The integral of psi_delta over the ball of radius |r| about 0: S_N r^N g(r). For orders above 2 it exceeds 1 in places.
    #[must_use]
    pub fn enclosed_mass(&self, r: T) -> T {
        self.evaluate(Quantity::EnclosedMass, r)
    }

    /// Any of the functions of the distance.
    #[must_use]
    pub fn evaluate(&self, quantity: Quantity, r: T) -> T {
        if r.is_finite() { self.place(Distance::new(r)).value(quantity).round() } else { T::NAN }
    }

    pub(super) fn shape(&self) -> &Shape<T, D> {
        &self.shape
    }

    pub(super) fn length(&self) -> &Distance<T> {
        &self.length
    }

    pub(super) fn place(&self, r: Distance<T>) -> Place<'_, T, D> {
        match &self.shape {
            Shape::None if r.is_zero() => Place::Coincident,
            Shape::Gaussian(shape) if cfg!(feature = "gaussian") => Place::Gaussian(shape.place(self.length, r)),
            Shape::Algebraic(shape) if ALGEBRAIC => Place::Algebraic(shape.place(self.length, r)),
            Shape::Compact(shape) if !r.exceeds(&self.length) => Place::Compact(shape.inside(self.length, r)),
            Shape::Combined(shape) if RICHARDSON && !r.exceeds(&self.length) => {
                Place::Combined(shape.inside(self.length, r))
            }
            _ => Place::Outside(Newtonian { r }),
        }
    }
}

impl<T: Real, const D: usize> Place<'_, T, D> {
    pub fn value(&self, quantity: Quantity) -> Scaled<T> {
        match self {
            Self::Outside(newtonian) => newtonian.value(quantity),
            Self::Compact(inside) => inside.value(quantity),
            Self::Gaussian(around) if cfg!(feature = "gaussian") => around.value(quantity),
            Self::Algebraic(soft) if ALGEBRAIC => soft.value(quantity),
            Self::Combined(parts) if RICHARDSON => parts.value(quantity),
            Self::Coincident | Self::Gaussian(_) | Self::Algebraic(_) | Self::Combined(_) => Scaled::ZERO,
        }
    }
}
