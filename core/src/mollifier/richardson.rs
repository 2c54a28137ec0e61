//! Combinations of one mollifier at several lengths, of higher order (Anderson (8) to (10)).

use super::blob::Blob;
use super::distance::Distance;
use super::scaled::Scaled;
use super::{MAX_COMBINED, Mollifier, Quantity};
use crate::error::{Error, Result};
use crate::real::{DoubleWord, Real};

/// The sum over j of alpha_j B_(gamma_j)(r), with B_gamma(r) = gamma^-N B(r/gamma) as in Anderson (4), of order p + 2 (K-1)
/// for K radii and a mollifier of order p. A plain value, prepared with its length.
///
/// (9) is the radii 1, 1/2: weights -1/3, 4/3. (10) is 1, 2/3, 1/3: 1/10, -3/5, 3/2. (As printed, with B(r/2) in place of
/// B_(1/2)(r), neither has unit mass.) The weights solve the moment system
/// `sum alpha_j = 1, sum alpha_j gamma_j^(p + 2i) = 0 for i = 0..K-2`, which has the closed solution
/// `alpha_j = c gamma_j^-p / product over i != j of (gamma_j^2 - gamma_i^2)`. Radii that are close together have
/// large weights and therefore large cancellation.
///
/// The functions are those of [`Blob`], at K times the cost, for lengths gamma_j delta rounded to `T`. For these lengths the error before
/// the last rounding is of the order of u^2 times the sum of |alpha_j| times the parts. The result is accurate to 1 ulp unless the parts
/// cancel to less than u times that sum. Relative to the exact gamma_j delta, the rounding of the product adds an error of up to u/2 times
/// |alpha_j gamma_j delta dB/d(gamma_j delta)|, some ulp of the larger parts. It is zero for radii with exact products (powers of two).
#[derive(Clone, Copy, Debug)]
pub struct Richardson<T: Real, const D: usize> {
    blobs: [Option<Blob<T, D>>; MAX_COMBINED],
    weights: [DoubleWord<T>; MAX_COMBINED],
}

impl<T: Real, const D: usize> Richardson<T, D> {
    /// Combines `mollifier` at lengths `radii[j] * delta`. The radii (gamma) are 1 to [`MAX_COMBINED`] different numbers in (0, 1].
    ///
    /// # Errors
    /// Those of [`Blob::new`]; [`Error::LengthMismatch`]: no radius or too many; [`Error::OutOfDomain`]: a radius
    /// outside (0, 1], or two that are equal; [`Error::Unsupported`]: [`Mollifier::None`], and algebraic mollifiers, whose errors are no
    /// series in powers of delta.
    pub fn new(mollifier: Mollifier, delta: T, radii: &[T]) -> Result<Self> {
        if mollifier == Mollifier::None || mollifier.is_algebraic() {
            return Err(Error::Unsupported);
        }
        Blob::<T, D>::new(mollifier, delta)?;
        if !(1..=MAX_COMBINED).contains(&radii.len()) {
            return Err(Error::LengthMismatch);
        }
        let mut this = Self { blobs: [None; MAX_COMBINED], weights: [DoubleWord::ZERO; MAX_COMBINED] };
        // Weights relative to the first, then divided by their sum.
        let mut sum = DoubleWord::ZERO;
        for (j, ((&radius, blob), weight)) in radii.iter().zip(&mut this.blobs).zip(&mut this.weights).enumerate() {
            if !(radius > T::ZERO && radius <= T::ONE) {
                return Err(Error::OutOfDomain);
            }
            *blob = Some(Blob::new(mollifier, delta * radius)?);
            let power = DoubleWord::from(radius).powi(mollifier.order());
            let mut product = DoubleWord::ONE / power;
            for (_, &other) in radii.iter().enumerate().filter(|&(i, _)| i != j) {
                if other == radius {
                    return Err(Error::OutOfDomain);
                }
                product = product / (DoubleWord::product(radius, radius) - DoubleWord::product(other, other));
            }
            *weight = product;
            sum = sum + product;
        }
        for weight in &mut this.weights {
            *weight = *weight / sum;
        }
        if this.weights.iter().any(|w| !w.hi.is_finite()) {
            return Err(Error::OutOfDomain);
        }
        Ok(this)
    }

    /// The weights alpha_j, one per radius.
    pub fn weights(&self) -> impl Iterator<Item = T> {
        self.terms().map(|(_, w)| w.hi)
    }

    /// One of the functions of the distance that [`Blob`] has.
    #[must_use]
    pub fn evaluate(&self, quantity: Quantity, r: T) -> T {
        if !r.is_finite() {
            return T::NAN;
        }
        let r = Distance::new(r);
        let term = |(blob, weight): (&Blob<T, D>, _)| blob.place(r).value(quantity).scale(weight);
        self.terms().map(term).fold(Scaled::ZERO, Scaled::plus).round()
    }

    /// The integral of |x|^k times the combination.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`]: k too large, as [`Blob::moment`].
    pub fn moment(&self, k: u32) -> Result<T> {
        let mut sum = Scaled::ZERO;
        for (blob, weight) in self.terms() {
            sum = sum.plus(Scaled::from(blob.moment(k)?).scale(weight));
        }
        Ok(sum.round())
    }

    fn terms(&self) -> impl Iterator<Item = (&Blob<T, D>, DoubleWord<T>)> {
        self.blobs.iter().flatten().zip(self.weights)
    }
}
