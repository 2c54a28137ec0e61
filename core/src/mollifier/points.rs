//! Fields at points: potential, gradient and Hessian of K * psi_delta at x, for a particle of unit mass at 0.

use super::Quantity;
use super::blob::{Blob, Place, Shape};
use super::distance::Distance;
use super::scaled::Scaled;
use super::single_word::SingleWord;
use crate::checked::Present;
use crate::real::{DoubleWord, Real};

/// Points that are not finite give NaN.
///
/// Gaussian mollifiers in 1D, and of order 4 in 2D, use single-word arithmetic, as in sums over particles, unless a square leaves the normal range. Errors: the density
/// 4 u of its maximum, the gradient 10 u in each component, the potential 8 u (2D: 8 u (1 + |log delta| + |phi|)). Their
/// Hessian and all functions of compact mollifiers are accurate: |x|^2 is computed to a few u^2 and results are rounded once. The
/// bounds are those of the scalar functions at the exact |x|, except that t = 1 - |x|^2/delta^2 has an absolute error of
/// 16 u^2. This affects the density alone, and only within 2^10 u delta of the edge.
impl<T: Real, const D: usize> Blob<T, D> {
    /// psi_delta(x).
    #[must_use]
    pub fn density_at(&self, x: &[T; D]) -> T {
        if let Some(plain) = self.plain(x) {
            return plain.density();
        }
        self.at(x, T::NAN, |_, place| place.value(Quantity::Density).round())
    }

    /// phi(x).
    #[must_use]
    pub fn potential_at(&self, x: &[T; D]) -> T {
        if let Some(plain) = self.plain(x) {
            return plain.potential();
        }
        self.at(x, T::NAN, |_, place| place.value(Quantity::Potential).round())
    }

    /// grad phi(x) = g x: each component to 2 ulp for orders 2 and 4.
    #[must_use]
    pub fn gradient_at(&self, x: &[T; D]) -> [T; D] {
        if let Some(plain) = self.plain(x) {
            let g = plain.gradient_factor();
            return x.map(|c| g * c);
        }
        self.at(x, [T::NAN; D], |_, place| {
            let g = place.value(Quantity::GradientFactor);
            x.map(|c| g.times(Scaled::from(c)).round())
        })
    }

    /// phi, grad phi and psi at x, where `which` requests them, for a particle whose mass is the product of two numbers. A result in range is
    /// computed for factors of any size.
    pub(crate) fn field_of(&self, mass: [T; 2], x: &[T; D], which: [bool; 3]) -> (T, [T; D], T) {
        let [a, b] = mass.map(Scaled::from);
        let strength = a.times(b);
        self.at(x, (T::NAN, [T::NAN; D], T::NAN), |_, place| {
            let value = |wanted: bool, of| if wanted { strength.times(place.value(of)) } else { Scaled::ZERO };
            let [potential, gradient, density] = which;
            let g = value(gradient, Quantity::GradientFactor);
            let mut slope = *x;
            slope.iter_mut().for_each(|c| *c = if gradient { g.times(Scaled::from(*c)).round() } else { T::ZERO });
            (value(potential, Quantity::Potential).round(), slope, value(density, Quantity::Density).round())
        })
    }

    /// Hess phi(x) = g I + h x x^T, a symmetric matrix whose trace is the density. Where the two terms cancel, the error is
    /// u^2 of either term: each entry is accurate to 2 ulp unless it is smaller than |g| by a factor of 1/u.
    #[must_use]
    pub fn hessian_at(&self, x: &[T; D]) -> [[T; D]; D] {
        self.at(x, [[T::NAN; D]; D], |r, place| {
            if D == 1 {
                // g + h x^2 = B, which would cancel in the sum.
                return [[place.value(Quantity::Density).round(); D]; D];
            }
            let (g, h) = (place.value(Quantity::GradientFactor), place.value(Quantity::HessianFactor));
            // x = y 2^exponent with |y_i| < 1
            let y = x.map(|c| c.ldexp(-r.exponent));
            let h = h.shift(r.exponent.saturating_mul(2));
            core::array::from_fn(|i| {
                core::array::from_fn(|j| match (y.get(i), y.get(j)) {
                    (Some(&a), Some(&b)) => {
                        let outer = h.scale(DoubleWord::product(a, b));
                        if i == j { g.plus(outer).round() } else { outer.round() }
                    }
                    _ => T::ZERO,
                })
            })
        })
    }

    /// A row of Hess phi(x) - I psi(x) / D, for a particle whose mass is the product of two numbers; zero at x = 0. A result in range is computed for factors of any size.
    pub(crate) fn row_of(&self, mass: [T; 2], x: &[T; D], row: usize) -> [T; D] {
        let [a, b] = mass.map(Scaled::from);
        self.at(x, [T::NAN; D], |r, place| {
            let h = a.times(b).times(place.value(Quantity::HessianFactor)).shift(r.exponent.saturating_mul(2));
            let y = x.map(|c| c.ldexp(-r.exponent));
            let square = y.iter().fold(DoubleWord::ZERO, |sum, &c| sum + DoubleWord::product(c, c));
            let part = square / DoubleWord::from(T::from_usize(D));
            let along = y.get(row).copied().present_or(T::ZERO);
            let mut to = y;
            for (k, (to, &c)) in to.iter_mut().zip(&y).enumerate() {
                let outer = DoubleWord::product(along, c);
                *to = h.scale(if k == row { outer - part } else { outer }).round();
            }
            to
        })
    }

    /// `[phi, g, psi]` at distance r where `wanted`, in single-word arithmetic. `None` unless the mollifier is Gaussian and all squares are in
    /// the normal range.
    pub(crate) fn gaussian_pair(&self, r: T, wanted: [bool; 3]) -> Option<[T; 3]> {
        let mut x = [T::ZERO; D];
        x.iter_mut().take(1).for_each(|c| *c = r);
        let plain = self.plain(&x)?;
        Some([
            if wanted[0] { plain.potential() } else { T::ZERO },
            if wanted[1] { plain.gradient_factor() } else { T::ZERO },
            if wanted[2] { plain.density() } else { T::ZERO },
        ])
    }

    fn plain(&self, x: &[T; D]) -> Option<SingleWord<T>> {
        match self.shape() {
            Shape::Gaussian(shape) if cfg!(feature = "gaussian") => SingleWord::new(*shape, D, self.delta(), x),
            _ => None,
        }
    }

    fn at<R>(&self, x: &[T; D], not_finite: R, function: impl Fn(&Distance<T>, &Place<'_, T, D>) -> R) -> R {
        if !x.iter().all(|c| c.is_finite()) {
            return not_finite;
        }
        let r = Distance::of_point(x);
        function(&r, &self.place(r))
    }
}
