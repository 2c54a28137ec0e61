//! The interaction: kernels K and their mollified forms K_delta = K * psi_delta.
//!
//! A sum of up to [`MAX_TERMS`] laws ([`Law`]) is prepared once, with a mollifier and its length, in the caller's buffer.
//! The result ([`Kernel`]) gives value, gradient factor and Laplacian at any distance. Source: K. Craig, A. L. Bertozzi, "A
//! blob method for the aggregation equation", (1.2) and Section 2; each file cites the formulas it uses.
//!
//! | kernel | inside the mollifier | outside |
//! |---|---|---|
//! | Newtonian | [`Blob`] | exactly Newtonian |
//! | even powers; odd powers in 1D and 3D (compact) | polynomial in s or t | finite Laurent sum |
//! | other powers, log | Chebyshev fits in powers of t | r^p times fits in (delta/r)^2 |
//! | screened, 1D exponential | series from the edge (k delta <= 3) or fits in t | a constant times itself, exactly |
//! | 3D exponential | fits in t | two terms, exactly |
//! | 2D exponential | fits in powers of t | e^{-r/l} times fits in delta/r |
//! | a user's [`RadialKernel`] | fit | fits on octaves up to its reach, and between its knots |
//!
//! with s = (r/delta)^2 and t = 1 - s. Under a Gaussian mollifier "inside" is a few octaves of fits. Fits sample the convolution
//! integrals directly. Under a Richardson combination ([`Mollifier::Richardson`]) a kernel is the sum of the weights times that of each radius.
//!
//! # Accuracy
//! [`Kernel::at`] and its parts evaluate in double precision for both scalars and round once. For one term of coefficient c let S be c times
//! the larger of two magnitudes. The first is that of the bare kernel at delta (the logarithm's at least 1; the Laplacian's at least the
//! gradient factor's). The second, where delta is more than 5 lengths l or 1/k, is the convolution of magnitudes, |K| * |psi_delta| for the
//! value (of K' two dimensions up for the gradient factor): there the mollifier may be far larger than the kernel and cancel. Then
//!
//! * fits are within 1e-13 of the larger of |value| and S, for delta up to about 100 lengths and, under Gaussian mollifiers, powers up to 12;
//!   the largest error found at random parameters is 2.7e-14 (test `kernel_random`);
//! * closed forms and Newtonian kernels are within 8 ulp of |value|;
//! * single precision adds 1/2 ulp of |value| for the rounding, 1 ulp if a Newtonian term is added to others.
//!
//! The error of a sum is at most the sum of the errors of its terms, and under a combination of those of its radii, times their weights (4/3 and 1/3, ...). Results overflow and underflow where the true ones do. The error of a
//! user's kernel is [`Kernel::fit_errors`]. [`Kernel::pair`] evaluates the same series in the arithmetic of the scalar.
//!
//! Sums over particles do not search for panels. A kernel with non-Newtonian terms, or a Newtonian one under a Gaussian mollifier or a combination, also has a
//! table in r^2 (`table`; 256 KiB in f64, 128 KiB in f32), from which sums read at any distance in the same few operations for any terms.

mod block;
mod chebyshev;
mod convolution;
mod edge_series;
mod far;
mod fit;
mod fitted_term;
mod law;
mod profile;
mod quadrature;
mod sizes;
mod table;

pub(crate) use far::{Far, Near, POWERS, Scaled};
pub use law::{Law, MAX_KNOTS, MAX_TERMS, RadialKernel, Supplied, Term};
pub(crate) use profile::sphere;
pub(crate) use table::{Head as TableHead, Table, mark as table_mark, terms as table_terms};

use crate::checked::Present;
use crate::error::Result;
use crate::mollifier::{Blob, Mollifier, Polynomials, Series};
use crate::real::{Extended, Real, Scalar};
use fitted_term::{FittedTerm, Outer};

/// Number of terms that a kernel holds, and whether it may hold non-Newtonian terms.
const KEPT: usize = if cfg!(feature = "kernels") { MAX_TERMS } else { 1 };
const OTHERS: usize = if cfg!(feature = "kernels") { 1 } else { 0 };

/// A prepared sum of kernels K_delta. It borrows its tables. A sum of Newtonian terms has none.
#[derive(Clone, Copy, Debug)]
pub struct Kernel<'k, T: Real, const D: usize> {
    blob: Blob<T, D>,
    /// Inside a compact mollifier, or what a combination combines.
    #[cfg(feature = "kernels")]
    polynomials: Option<Polynomials<T>>,
    newtonian: T,
    terms: [Term; KEPT],
    count: usize,
    others: [Others<'k, T>; OTHERS],
}

/// A polynomial in double precision, by Horner's rule.
fn wide_at<T: Real>(series: &Series<T>, t: f64) -> f64 {
    series.coefficients().iter().rev().fold(0.0, |sum, &c| sum * t + c.to_f64())
}

/// The non-Newtonian terms of a kernel, in double precision.
#[derive(Clone, Copy, Debug)]
struct Others<'k, T> {
    parts: [FittedTerm<f64>; MAX_TERMS],
    used: usize,
    series: &'k [f64],
    table: Option<Table<'k, T>>,
    fit_error: f64,
    fit_errors: [f64; 3],
}

impl<T> Others<'_, T> {
    fn parts(&self) -> &[FittedTerm<f64>] {
        self.parts.get(..self.used).present_or(&[])
    }
}

impl<T: Real, const D: usize> Kernel<'_, T, D> {
    /// The Newtonian kernel times `coefficient` (+1 attracts, -1 repels). Needs no memory.
    ///
    /// Under a Gaussian mollifier or a combination near pairs are then evaluated one by one, a thousand times as slowly as others: for sums take [`Kernel::prepare`], which tabulates its field.
    ///
    /// # Errors
    /// Those of [`Blob::new`]; [`crate::Error::NotFinite`]: the coefficient.
    pub fn newtonian(coefficient: T, mollifier: Mollifier, delta: T) -> Result<Kernel<'static, T, D>> {
        if !coefficient.is_finite() {
            return Err(crate::Error::NotFinite);
        }
        let blob = Blob::new(mollifier, delta)?;
        let term = Term { law: Law::Newtonian, coefficient: coefficient.to_f64() };
        let mut kernel = Kernel::empty(blob);
        kernel.newtonian = coefficient;
        if let Some(slot) = kernel.terms.first_mut() {
            *slot = term;
        }
        kernel.count = 1;
        Ok(kernel)
    }

    /// The mollifier.
    #[must_use]
    pub fn mollifier(&self) -> Mollifier {
        self.blob.mollifier()
    }

    /// delta; 0 without a mollifier.
    #[must_use]
    pub fn delta(&self) -> T {
        self.blob.delta()
    }

    /// Whether there is no mollifier, so that coincident pairs contribute nothing.
    #[must_use]
    pub fn is_singular(&self) -> bool {
        self.blob.mollifier() == Mollifier::None
    }

    /// The mollifier prepared with its length, with its Newtonian field.
    #[must_use]
    pub fn blob(&self) -> &Blob<T, D> {
        &self.blob
    }

    /// The sum of the coefficients of the Newtonian terms (including powers with p = 2 - d).
    #[must_use]
    pub fn newtonian_coefficient(&self) -> T {
        self.newtonian
    }

    /// Whether every term is Newtonian, so that `newtonian_coefficient` and `blob` determine the kernel.
    #[must_use]
    pub fn is_newtonian(&self) -> bool {
        self.parts().is_empty()
    }

    /// The terms as given, without a user's own kernel.
    #[must_use]
    pub fn terms(&self) -> &[Term] {
        self.terms.get(..self.count).present_or(&[])
    }

    /// Whether the terms determine the kernel; false if it includes a user's kernel.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.parts().iter().all(|part| part.law != Law::Newtonian)
    }

    /// The largest error of a fit, relative to the size of the function on the fit's interval; 0 for closed forms. It exceeds 1e-14
    /// only for users' kernels that are rough after mollification (by themselves, or with M = 1).
    #[must_use]
    pub fn fit_error(&self) -> f64 {
        self.others.first().map_or(0.0, |others| others.fit_error)
    }

    /// By how much sums and single distances may miss a user's kernel in value, gradient factor and Laplacian; 0 without one. Twice the largest errors that were found between
    /// the nodes of its fits and in the panels of the table, in units of the scalar's sums: relative to the largest |K| (or r^2 |K'/r|), |K'/r|, and |Laplacian| or
    /// D |K'/r|, over all distances from r/2 to r, to delta from 0 where r < delta, to `Supplied::least` where r is less; of all terms. Values below 2^-64 of the largest in
    /// single precision (2^-960 in double) count as that. Within some roundings of a knot either side's value may be returned.
    #[must_use]
    pub fn fit_errors(&self) -> [f64; 3] {
        self.others.first().map_or([0.0; 3], |others| others.fit_errors)
    }

    /// The table for sums: of all terms, or with coefficient 1 if all are Newtonian.
    pub(crate) fn table(&self) -> Option<Table<'_, T>> {
        self.others.first().and_then(|others| others.table)
    }

    /// The non-Newtonian terms, prepared.
    fn parts(&self) -> &[FittedTerm<f64>] {
        self.others.first().map_or(&[], Others::parts)
    }

    /// K_delta(r), r >= 0; 0 at r = 0 without a mollifier.
    #[must_use]
    pub fn value(&self, r: T) -> T {
        self.with_newtonian(self.alone(r)[0], || self.blob.potential(r))
    }

    /// K_delta'(r)/r: the gradient is this times x. 0 at r = 0 without a mollifier.
    #[must_use]
    pub fn gradient_factor(&self, r: T) -> T {
        self.with_newtonian(self.alone(r)[1], || self.blob.gradient_factor(r))
    }

    /// The Laplacian of K_delta at r. 0 at r = 0 without a mollifier.
    #[must_use]
    pub fn laplacian(&self, r: T) -> T {
        self.with_newtonian(self.alone(r)[2], || self.blob.density(r))
    }

    /// Value, gradient factor and Laplacian.
    #[must_use]
    pub fn at(&self, r: T) -> [T; 3] {
        let [u, g, l] = self.alone(r);
        [
            self.with_newtonian(u, || self.blob.potential(r)),
            self.with_newtonian(g, || self.blob.gradient_factor(r)),
            self.with_newtonian(l, || self.blob.density(r)),
        ]
    }

    /// The gradient of K_delta at x: K_delta'(|x|) x/|x|. It is finite wherever its value is, even if |x|^2 or the gradient factor overflows.
    /// 0 at x = 0; NaN where x is not finite.
    #[must_use]
    pub fn gradient_at(&self, x: &[T; D]) -> [T; D] {
        if !x.iter().all(|c| c.is_finite()) {
            return [T::NAN; D];
        }
        let wide = x.map(Scalar::to_f64);
        let (_, exponent) = Scalar::frexp(wide.iter().fold(0.0, |most: f64, c| most.max(c.abs())));
        let scaled = wide.map(|c| Scalar::ldexp(c, -exponent));
        let length = scaled.iter().fold(0.0, |sum, c| sum + c * c).sqrt();
        let r = Scalar::ldexp(length, exponent);
        let Some(others) = self.others.first().filter(|others| others.used > 0 && r > 0.0) else {
            return self.blob.gradient_at(x).map(|c| self.newtonian * c);
        };
        let slope: f64 = others.parts().iter().map(|part| part.slope::<D>(others.series, r)).sum();
        let mut gradient = scaled.map(|c| slope * (c / length));
        if self.newtonian != T::ZERO {
            for (sum, c) in gradient.iter_mut().zip(self.blob.gradient_at(x)) {
                *sum += self.newtonian.to_f64() * c.to_f64();
            }
        }
        gradient.map(T::from_f64)
    }

    /// The sum of the non-Newtonian terms and the Newtonian one, rounded once.
    fn with_newtonian(&self, others: f64, newtonian: impl Fn() -> T) -> T {
        if self.newtonian == T::ZERO {
            T::from_f64(others)
        } else if self.parts().is_empty() {
            self.newtonian * newtonian()
        } else {
            T::from_f64(self.newtonian.to_f64() * newtonian().to_f64() + others)
        }
    }

    /// Value, gradient factor and Laplacian of all non-Newtonian terms, in double precision for both scalars.
    fn alone(&self, r: T) -> [f64; 3] {
        let r = r.to_f64();
        let mut sum = [0.0; 3];
        let Some(others) = self.others.first().filter(|others| others.used > 0) else { return sum };
        if r == 0.0 && self.is_singular() {
            return sum;
        }
        for part in others.parts() {
            let [u, g, l] = part.alone::<D>(others.series, r);
            sum = [sum[0] + u, sum[1] + g, sum[2] + l];
        }
        sum
    }

    /// Value, gradient factor and Laplacian of all non-Newtonian terms, in one pass over the tables. For sums,
    /// which take the Newtonian part from [`Blob::polynomials`].
    #[must_use]
    #[inline]
    pub fn others(&self, r: T) -> [T; 3] {
        let mut sum = [T::ZERO; 3];
        let Some(others) = self.others.first().filter(|others| others.used > 0) else { return sum };
        if r == T::ZERO && self.is_singular() {
            return sum;
        }
        for part in others.parts() {
            let [u, g, l] = match part.outer {
                // Coefficients of a host's kernel may be beyond single precision.
                Outer::Continued { .. } => part.alone::<D>(others.series, r.to_f64()).map(T::from_f64),
                _ => part.narrow::<T>().at::<D>(others.series, r),
            };
            sum = [sum[0] + u, sum[1] + g, sum[2] + l];
        }
        sum
    }

    /// [`Kernel::pair`] in double precision.
    pub(crate) fn pair_wide(&self, r: f64, wanted: [bool; 3]) -> [f64; 3] {
        self.pair_scaled(r, wanted).map(Extended::get)
    }

    /// The same with exponents, so that what bare powers and Newtonian terms give need not be in range.
    pub(crate) fn pair_scaled(&self, r: f64, wanted: [bool; 3]) -> [Extended; 3] {
        let mut sum = [Extended::ZERO; 3];
        if r == 0.0 && self.is_singular() {
            return sum;
        }
        let mut add = |more: [Extended; 3]| sum.iter_mut().zip(more).for_each(|(sum, more)| *sum = sum.plus(more));
        if let Some(others) = self.others.first().filter(|others| others.used > 0) {
            others.parts().iter().for_each(|part| add(part.scaled::<D>(others.series, r)));
        }
        if self.newtonian != T::ZERO {
            let coefficient = Extended::new(self.newtonian.to_f64(), 0);
            add(self.newtonian_scaled(r, wanted).map(|v| v.times(coefficient)));
        }
        sum
    }

    /// The magnitudes of all terms, added up.
    fn sizes_scaled(&self, r: f64) -> [Extended; 3] {
        let mut sum = [Extended::ZERO; 3];
        if r == 0.0 && self.is_singular() {
            return sum;
        }
        let mut add =
            |more: [Extended; 3]| sum.iter_mut().zip(more).for_each(|(sum, more)| *sum = sum.plus(more.abs()));
        if let Some(others) = self.others.first().filter(|others| others.used > 0) {
            others.parts().iter().for_each(|part| add(part.scaled::<D>(others.series, r)));
        }
        if self.newtonian != T::ZERO {
            let coefficient = Extended::new(self.newtonian.to_f64(), 0);
            add(self.newtonian_scaled(r, [true; 3]).map(|v| v.times(coefficient)));
        }
        sum
    }

    /// The Newtonian part of [`Kernel::pair_scaled`], of coefficient 1.
    fn newtonian_scaled(&self, r: f64, wanted: [bool; 3]) -> [Extended; 3] {
        // In units of a power of two near delta, in which nothing leaves the range.
        let (delta, exponent) = Scalar::frexp(self.delta().to_f64());
        let near = Scalar::ldexp(r, exponent.saturating_neg());
        let unit = |n: i32| n.saturating_mul(exponent);
        let d = D as i32;
        let shift =
            if D == 2 { f64::from(exponent) * core::f64::consts::LN_2 * (0.5 / core::f64::consts::PI) } else { 0.0 };
        let true_units = |[u, g, l]: [f64; 3]| {
            [
                Extended::new(u, unit(2 - d)).plus(Extended::new(shift, 0)),
                Extended::new(g, unit(-d)),
                Extended::new(l, unit(-d)),
            ]
        };
        #[cfg(feature = "kernels")]
        let polynomials = &self.polynomials;
        #[cfg(not(feature = "kernels"))]
        let polynomials = &self.blob.polynomials();
        match polynomials {
            Some(p) if near < delta => {
                let [value, factor, density] = if self.is_combination() {
                    self.combination(p, near / delta)
                } else {
                    let t = (delta - near) / delta * (1.0 + near / delta);
                    let at = |wanted: bool, series: &Series<T>| if wanted { wide_at(series, t) } else { 0.0 };
                    [at(wanted[0], &p.potential), at(wanted[1], &p.gradient), at(wanted[2], &p.density)]
                };
                let square = delta * delta;
                let per = 1.0 / (sphere(D) * if D == 1 { delta } else { square * if D == 2 { 1.0 } else { delta } });
                let offset = if D == 2 { Scalar::log(delta) / sphere(2) } else { 0.0 };
                true_units([
                    if wanted[0] { per * square * value + offset } else { 0.0 },
                    if wanted[1] { per * factor } else { 0.0 },
                    if wanted[2] { per * density } else { 0.0 },
                ])
            }
            None if !self.is_singular() => {
                let Ok(blob) = Blob::<f64, D>::new(self.mollifier(), delta) else {
                    return [Extended::new(f64::NAN, 0); 3];
                };
                true_units(blob.gaussian_pair(near, wanted).unwrap_or_else(|| {
                    [
                        if wanted[0] { blob.potential(near) } else { 0.0 },
                        if wanted[1] { blob.gradient_factor(near) } else { 0.0 },
                        if wanted[2] { blob.density(near) } else { 0.0 },
                    ]
                }))
            }
            _ => Law::Newtonian.scaled::<D>(r),
        }
    }

    /// Value, gradient factor and Laplacian for sums; entries not `wanted` are unspecified. The Newtonian part uses single-word polynomials
    /// inside a compact mollifier and the bare law outside.
    #[must_use]
    #[inline]
    pub fn pair(&self, r: T, wanted: [bool; 3]) -> [T; 3] {
        let [u, g, l] = self.others(r);
        if self.newtonian == T::ZERO || (r == T::ZERO && self.is_singular()) {
            return [u, g, l];
        }
        let [more_u, more_g, more_l] = self.newtonian_pair(r, wanted);
        [u + more_u, g + more_g, l + more_l]
    }

    /// The Newtonian part of [`Kernel::pair`].
    fn newtonian_pair(&self, r: T, wanted: [bool; 3]) -> [T; 3] {
        let c = self.newtonian;
        let (mut u, mut g, mut l) = (T::ZERO, T::ZERO, T::ZERO);
        #[cfg(feature = "kernels")]
        let polynomials = &self.polynomials;
        #[cfg(not(feature = "kernels"))]
        let polynomials = &self.blob.polynomials();
        match polynomials {
            Some(p) if r < p.delta && self.is_combination() => {
                let [value, factor, density] = self.combination(p, (r / p.delta).to_f64()).map(T::from_f64);
                u = c * (p.potential_scale * value + p.potential_offset);
                g = c * (p.scale * factor);
                l = c * (p.scale * density);
            }
            Some(p) if r < p.delta => {
                let t = (p.delta - r) / p.delta * (T::ONE + r / p.delta);
                if wanted[0] {
                    u = c * (p.potential_scale * p.potential.at(t) + p.potential_offset);
                }
                if wanted[1] {
                    g = c * (p.scale * p.gradient.at(t));
                }
                if wanted[2] {
                    l = c * (p.scale * p.density.at(t));
                }
            }
            None if !self.is_singular() => {
                let blob = &self.blob;
                if let Some(plain) = blob.gaussian_pair(r, wanted) {
                    return plain.map(|v| c * v);
                }
                if wanted[0] {
                    u = c * blob.potential(r);
                }
                if wanted[1] {
                    g = c * blob.gradient_factor(r);
                }
                if wanted[2] {
                    l = c * blob.density(r);
                }
            }
            _ => {
                // Not zero here, but the compiler may divide before it knows.
                let [v, f, _] = Law::Newtonian.bare::<T, D>(if r > T::ZERO { r } else { T::ONE });
                u = c * v;
                g = c * f;
            }
        }
        [u, g, l]
    }

    /// Whether the mollifier is a Richardson combination.
    fn is_combination(&self) -> bool {
        cfg!(feature = "kernels") && self.blob.mollifier().radii() > 1
    }

    /// P, G and b of a combination at r = q delta, q < 1, from those of what it combines: with x = q / gamma those of t = 1 - x^2 where x < 1, and else of the bare kernel,
    /// times powers of the radius gamma.
    fn combination(&self, p: &Polynomials<T>, q: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (weight, radius) in self.blob.mollifier().parts() {
            let x = q / radius;
            let [value, factor, density] = if x < 1.0 {
                let t = (1.0 - x) * (1.0 + x);
                [wide_at(&p.potential, t), wide_at(&p.gradient, t), wide_at(&p.density, t)]
            } else {
                let value = match D {
                    1 => x,
                    2 => Scalar::log(x),
                    _ => -1.0 / x,
                };
                [value, 1.0 / Scalar::powi(x, D as u32), 0.0]
            };
            let per = 1.0 / Scalar::powi(radius, D as u32);
            let value = if D == 2 { value + Scalar::log(radius) } else { per * radius * radius * value };
            let values = [value, per * factor, per * density];
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }

    /// Splits off the even powers, whose sums need no pairs. `None` unless both parts are nonempty.
    pub(crate) fn without_even_powers(&self) -> Option<(Self, Self)> {
        let is_even = |law: Law| matches!(law, Law::Power { exponent: p } if p > 0.0 && law::is_multiple(p, 2.0));
        let (mut even, mut rest) = (*self, *self);
        even.newtonian = T::ZERO;
        for (kernel, wanted) in [(&mut even, true), (&mut rest, false)] {
            kernel.count = 0;
            for &term in self.terms().iter().filter(|term| is_even(term.law) == wanted) {
                if let Some(slot) = kernel.terms.get_mut(kernel.count) {
                    *slot = term;
                    kernel.count += 1;
                }
            }
            for others in &mut kernel.others {
                // The table is valid only for the whole sum.
                others.table = None;
                others.used = 0;
                for &part in self.parts().iter().filter(|part| is_even(part.law) == wanted) {
                    if let Some(slot) = others.parts.get_mut(others.used) {
                        *slot = part;
                        others.used += 1;
                    }
                }
            }
        }
        let some_left = !rest.parts().is_empty() || rest.newtonian != T::ZERO;
        (!even.parts().is_empty() && some_left).then_some((even, rest))
    }
}
