//! A mollifier prepared with its length: scalar functions of the distance, to nearly the last bit.

use super::Mollifier;
use super::compact::{Compact, Inside};
use super::distance::{Distance, sphere};
use super::scaled::Scaled;
use super::series::Polynomials;
use crate::error::{Error, Result};
use crate::real::{DoubleWord, Real};

/// A mollifier with its length delta in dimension `D` = 1, 2 or 3: a plain value, of 2 KiB at most.
///
/// Functions of r take its magnitude; where r is not finite they return NaN. Without a mollifier r = 0 counts as "no
/// contribution": every function is 0 there.
#[derive(Clone, Copy, Debug)]
pub struct Blob<T: Real, const D: usize> {
    mollifier: Mollifier,
    delta: T,
    length: Distance<T>,
    shape: Shape<T>,
}

#[derive(Clone, Copy, Debug)]
enum Shape<T> {
    None,
    Compact(Compact<T>),
}

/// Where a distance lies, and so which formula holds.
pub(super) enum Place<'a, T> {
    /// At zero distance from an unmollified particle.
    Coincident,
    /// Where the field is exactly Newtonian.
    Outside(Distance<T>),
    Compact(Inside<'a, T>),
}

impl<T: Real, const D: usize> Blob<T, D> {
    /// Prepares a mollifier. `delta` is not looked at for [`Mollifier::None`].
    ///
    /// # Errors
    /// [`Error::Delta`]: not positive and finite; and those of [`Mollifier::check`].
    pub fn new(mollifier: Mollifier, delta: T) -> Result<Self> {
        mollifier.check(D)?;
        let (delta, shape) = match mollifier {
            Mollifier::None => (T::ZERO, Shape::None),
            _ if !(delta > T::ZERO && delta.is_finite()) => return Err(Error::Delta),
            Mollifier::Compact { order, exponent } => (delta, Shape::Compact(Compact::new(D, order, exponent))),
            Mollifier::Gaussian { .. } => return Err(Error::Unsupported),
        };
        Ok(Self { mollifier, delta, length: Distance::new(delta), shape })
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

    /// The coefficients for sums over many particles; none but for compact mollifiers.
    #[must_use]
    pub fn polynomials(&self) -> Option<Polynomials<T>> {
        match &self.shape {
            Shape::Compact(shape) => Some(Polynomials::new(D, &shape.series, self.delta)),
            Shape::None => None,
        }
    }

    /// B(r) = psi_delta(r), the mollifier itself.
    #[must_use]
    pub fn density(&self, r: T) -> T {
        self.finish(r, Self::density_at_place)
    }

    /// B'(r)/r; at the edge of a compact mollifier with M = 1, where B' jumps, the value inside.
    #[must_use]
    pub fn density_slope(&self, r: T) -> T {
        self.finish(r, |place| match place {
            Place::Compact(inside) => inside.density_slope(),
            Place::Outside(_) | Place::Coincident => Scaled::ZERO,
        })
    }

    /// phi(r) = (K * psi_delta)(r) for the Newtonian K.
    #[must_use]
    pub fn potential(&self, r: T) -> T {
        self.finish(r, Self::potential_at_place)
    }

    /// g(r) = phi'(r)/r.
    #[must_use]
    pub fn gradient_factor(&self, r: T) -> T {
        self.finish(r, Self::gradient_at_place)
    }

    /// h(r) = g'(r)/r.
    #[must_use]
    pub fn hessian_factor(&self, r: T) -> T {
        self.finish(r, Self::hessian_at_place)
    }

    /// The integral of psi_delta over the ball of radius |r| about 0: S_N r^N g(r). Above 1 in places for orders above 2.
    #[must_use]
    pub fn enclosed_mass(&self, r: T) -> T {
        self.finish(r, |place| match place {
            Place::Coincident => Scaled::ZERO,
            Place::Outside(_) => Scaled::from(T::ONE),
            Place::Compact(inside) => inside.enclosed_mass(),
        })
    }

    fn finish(&self, r: T, function: impl Fn(&Place<'_, T>) -> Scaled<T>) -> T {
        if !r.is_finite() {
            return T::NAN;
        }
        function(&self.place(Distance::new(r))).round()
    }

    pub(super) fn place(&self, r: Distance<T>) -> Place<'_, T> {
        match &self.shape {
            Shape::None if r.is_zero() => Place::Coincident,
            Shape::None => Place::Outside(r),
            Shape::Compact(_) if r.exceeds(&self.length) => Place::Outside(r),
            Shape::Compact(shape) => Place::Compact(shape.inside(D, self.length, r)),
        }
    }

    pub(super) fn density_at_place(place: &Place<'_, T>) -> Scaled<T> {
        match place {
            Place::Compact(inside) => inside.density(),
            Place::Outside(_) | Place::Coincident => Scaled::ZERO,
        }
    }

    pub(super) fn potential_at_place(place: &Place<'_, T>) -> Scaled<T> {
        match place {
            Place::Coincident => Scaled::ZERO,
            Place::Outside(r) => newtonian_potential::<T, D>(r),
            Place::Compact(inside) => inside.potential(),
        }
    }

    pub(super) fn gradient_at_place(place: &Place<'_, T>) -> Scaled<T> {
        match place {
            Place::Coincident => Scaled::ZERO,
            Place::Outside(r) => newtonian_gradient::<T, D>(r),
            Place::Compact(inside) => inside.gradient(),
        }
    }

    pub(super) fn hessian_at_place(place: &Place<'_, T>) -> Scaled<T> {
        match place {
            Place::Coincident => Scaled::ZERO,
            // -N / (S_N r^(N+2))
            Place::Outside(r) => {
                newtonian_gradient::<T, D>(r).over(r.squared()).scale(DoubleWord::from(-T::from_usize(D)))
            }
            Place::Compact(inside) => inside.hessian(),
        }
    }
}

/// K(r) for r > 0.
fn newtonian_potential<T: Real, const D: usize>(r: &Distance<T>) -> Scaled<T> {
    match D {
        1 => r.length().shift(-1),
        2 => Scaled::new(r.log(), 0).over(sphere(2)),
        _ => Scaled::from(-T::ONE).over(sphere::<T>(3).times(r.length())),
    }
}

/// K'(r)/r = 1 / (S_N r^N) for r > 0.
fn newtonian_gradient<T: Real, const D: usize>(r: &Distance<T>) -> Scaled<T> {
    Scaled::from(T::ONE).over(sphere::<T>(D).times(r.power(D as u32)))
}
