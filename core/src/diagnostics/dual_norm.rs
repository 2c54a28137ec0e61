//! The W^{-1,2}_h norm of a grid function (Craig & Bertozzi, section 3), in which the density converges.

use super::sums::dot;
use crate::error::{Error, Result};
use crate::memory::{Carve, Measure, Space};
use crate::real::{Extended, Real};

/// A box of the lattice `h Z^D`, with a margin of zeros that represents the rest of the lattice.
///
/// Arrays over the box are ordered with the first axis fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice<T, const D: usize> {
    /// Points along each axis.
    pub points: [usize; D],
    /// h.
    pub spacing: T,
    /// Points of zeros added on every side. The limit is the infinite lattice. The truncation changes the norm by
    /// about `e^(-2 margin h)`, relatively.
    pub margin: usize,
}

impl<T: Real, const D: usize> Lattice<T, D> {
    /// Points along each axis, including the margin and one more layer for the zero boundary values.
    fn extended(&self) -> Result<[usize; D]> {
        let both = self.margin.checked_add(1).and_then(|m| m.checked_mul(2)).ok_or(Error::TooLarge)?;
        let mut extended = self.points;
        for n in &mut extended {
            *n = n.checked_add(both).ok_or(Error::TooLarge)?;
        }
        Ok(extended)
    }

    fn count(axes: &[usize; D]) -> Result<usize> {
        axes.iter().try_fold(1_usize, |product, &n| product.checked_mul(n)).ok_or(Error::TooLarge)
    }

    /// Bytes of workspace that [`Lattice::dual_norm`] needs.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub fn workspace_bytes(&self) -> Result<usize> {
        Measure::of(|space| Arrays::<T>::layout(space, Self::count(&self.extended()?)?).map(|_| ()))
    }

    /// The norm of `values` in W^{-1,2}_h: the maximum of `(u, g)_h` over grid functions g with
    /// `|g|^2 + sum_k |D_k^+ g|^2 <= 1` in L^2_h.
    ///
    /// The maximum is `sqrt((u, A^{-1} u)_h)` with `A = 1 - Laplacian_h`, the (2 D + 1)-point lattice Laplacian. The
    /// system is solved by conjugate gradients, whose steps sum to `(u, A^{-1} u)` from below (Hestenes, Stiefel 1952, theorem 6:1).
    /// Since A >= 1, the remainder is at most the squared residual, which is reduced below 1e3 u of the sum. Cost: about
    /// `10 sqrt(1 + 4 D / h^2)` sweeps over box and margin.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`]: `values` does not have one value per point; [`Error::NotFinite`]: a value;
    /// [`Error::OutOfDomain`]: the spacing; [`Error::TooLarge`]; [`Error::WorkspaceTooSmall`], [`Error::Misaligned`].
    pub fn dual_norm(&self, values: &[T], workspace: &mut [u8]) -> Result<T> {
        let extended = self.extended()?;
        let n = Self::count(&extended)?;
        if values.len() != Self::count(&self.points)? {
            return Err(Error::LengthMismatch);
        }
        if !(self.spacing > T::ZERO && self.spacing.is_finite()) {
            return Err(Error::OutOfDomain);
        }
        let Arrays { residual, direction, image } = Arrays::layout(&mut Carve::new(workspace)?, n)?;
        if !values.iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        self.place(values, &extended, residual);

        let largest = values.iter().fold(T::ZERO, |m, v| m.max(v.abs()));
        if largest == T::ZERO {
            return Ok(T::ZERO);
        }
        residual.iter_mut().for_each(|v| *v /= largest);
        direction.iter_mut().zip(residual.iter()).for_each(|(d, &r)| *d = r);

        // The square of the spacing may overflow.
        let per_square = (T::ONE / self.spacing) * (T::ONE / self.spacing);
        let condition = T::ONE + T::from_usize(4 * D) * per_square;
        if !condition.is_finite() {
            return Err(Error::OutOfDomain);
        }
        let sweeps = T::from_i32(40) * condition.sqrt() + T::from_i32(100);
        let enough = 1000.0 * T::EPSILON.to_f64();
        let (mut square, mut sum, mut sweep) = (dot(residual, residual), 0.0, T::ZERO);
        while square > enough * sum && sweep < sweeps {
            apply(direction, image, &extended, per_square);
            let along = square / dot(direction, image);
            sum += along * square;
            let along = T::from_f64(along);
            for (r, &a) in residual.iter_mut().zip(image.iter()) {
                *r -= along * a;
            }
            let next = dot(residual, residual);
            let keep = T::from_f64(next / square);
            for (d, &r) in direction.iter_mut().zip(residual.iter()) {
                *d = r + keep * *d;
            }
            square = next;
            sweep += T::ONE;
        }
        let wide = |x: T| Extended::new(x.to_f64(), 0);
        let volume = (0..D).fold(Extended::new(sum, 0), |product, _| product.times(wide(self.spacing)));
        Ok(T::from_f64(wide(largest).times(volume.root(2)).get()))
    }

    /// Copies the box to the middle of the zeroed extended box.
    fn place(&self, values: &[T], extended: &[usize; D], into: &mut [T]) {
        let from = self.margin.saturating_add(1);
        let inside = |mut index: usize| {
            for (&n, &all) in self.points.iter().zip(extended) {
                let k = index.checked_rem(all).unwrap_or(0);
                index = index.checked_div(all).unwrap_or(0);
                if k < from || k - from >= n {
                    return false;
                }
            }
            true
        };
        let targets = into.iter_mut().enumerate().filter(|(index, _)| inside(*index));
        for ((_, to), &value) in targets.zip(values) {
            *to = value;
        }
    }
}

struct Arrays<'w, T> {
    residual: &'w mut [T],
    direction: &'w mut [T],
    image: &'w mut [T],
}

impl<'w, T: Real> Arrays<'w, T> {
    fn layout(space: &mut impl Space<'w>, n: usize) -> Result<Self> {
        Ok(Self { residual: space.try_array(n)?, direction: space.try_array(n)?, image: space.try_array(n)? })
    }
}

/// `to = (1 - Laplacian_h) from` inside the outermost layer, and zero on it. `from` is zero on that layer. It contains the neighbours
/// across the end of a row, so they contribute nothing.
fn apply<T: Real, const D: usize>(from: &[T], to: &mut [T], axes: &[usize; D], per_square: T) {
    let diagonal = T::ONE + T::from_usize(2 * D) * per_square;
    for (to, &v) in to.iter_mut().zip(from) {
        *to = diagonal * v;
    }
    let mut stride = 1_usize;
    for &n in axes {
        for (to, &v) in to.iter_mut().skip(stride).zip(from) {
            *to -= per_square * v;
        }
        for (to, &v) in to.iter_mut().zip(from.iter().skip(stride)) {
            *to -= per_square * v;
        }
        stride = stride.saturating_mul(n);
    }
    let mut stride = 1_usize;
    for &n in axes {
        let block = stride.saturating_mul(n).max(1);
        for row in to.chunks_mut(block) {
            row.iter_mut().take(stride).for_each(|v| *v = T::ZERO);
            row.iter_mut().rev().take(stride).for_each(|v| *v = T::ZERO);
        }
        stride = block;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostics::norm;
    use crate::memory::ALIGN;
    use crate::real::Scalar;
    use std::{vec, vec::Vec};

    fn dual<const D: usize>(lattice: &Lattice<f64, D>, values: &[f64]) -> Result<f64> {
        let mut memory = vec![0xFF_u8; lattice.workspace_bytes()? + ALIGN];
        let start = memory.as_ptr().align_offset(ALIGN);
        let bytes = memory.len() - ALIGN;
        lattice.dual_norm(values, &mut memory[start..start + bytes])
    }

    /// In one dimension the lattice Green's function is geometric: G(n) = q^|n| / (1 + 2 (1 - q) / h^2) with
    /// q = 1 + h^2/2 - h sqrt(1 + h^2/4).
    #[test]
    fn the_line_in_closed_form() {
        for h in [0.5_f64, 0.1] {
            let q = 1.0 + h * h / 2.0 - h * (1.0 + h * h / 4.0).sqrt();
            let at_zero = 1.0 / (1.0 + 2.0 * (1.0 - q) / (h * h));
            for n in [1_usize, 2, 17] {
                let values: Vec<f64> = (0..n).map(|k| (k as f64 * 1.7).cos() + 0.2).collect();
                let green = |i: usize, j: usize| at_zero * q.powi(i.abs_diff(j) as i32);
                let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
                let square: f64 = pairs.map(|(i, j)| values[i] * green(i, j) * values[j]).sum();
                // A margin of 18 length units cuts off e^-36.
                let lattice = Lattice { points: [n], spacing: h, margin: (18.0 / h) as usize };
                let got = dual(&lattice, &values).unwrap();
                let want = (h * square).sqrt();
                assert!((got - want).abs() < 1e-12 * want, "{h} {n} {got} {want}");
            }
        }
    }

    /// A product of sines is an eigenfunction on a box with zero boundary values (margin 0).
    fn eigenfunction<const D: usize>(points: [usize; D], waves: [usize; D]) {
        let h = 0.25;
        let lattice = Lattice { points, spacing: h, margin: 0 };
        let count: usize = points.iter().product();
        let mut eigenvalue = 1.0;
        for (&n, &k) in points.iter().zip(&waves) {
            let angle = f64::PI * k as f64 / (2 * (n + 1)) as f64;
            eigenvalue += (2.0 / h * angle.sin()).powi(2);
        }
        let values: Vec<f64> = (0..count)
            .map(|mut index| {
                let mut product = 1.0;
                for (&n, &k) in points.iter().zip(&waves) {
                    product *= (f64::PI * k as f64 * (index % n + 1) as f64 / (n + 1) as f64).sin();
                    index /= n;
                }
                product
            })
            .collect();
        let want = norm(&values, h.powi(D as i32), 2.0).unwrap() / eigenvalue.sqrt();
        let got = dual(&lattice, &values).unwrap();
        assert!((got - want).abs() < 1e-12 * want, "{points:?} {got} {want}");
    }

    #[test]
    fn boxes_in_every_dimension() {
        eigenfunction([9], [2]);
        eigenfunction([5, 8], [1, 3]);
        eigenfunction([4, 3, 6], [1, 2, 2]);
        eigenfunction([1, 1, 1], [1, 1, 1]);
    }

    /// Proposition 3.1: |u|_{W^-1,2} <= |u|_2 <= (1 + 2 d / h) |u|_{W^-1,2}.
    #[test]
    fn bounded_by_the_discrete_l2_norm_both_ways() {
        let lattice = Lattice { points: [7, 6], spacing: 0.2, margin: 20 };
        for seed in 1..6 {
            let values: Vec<f64> = (0..42).map(|k| ((k * seed) as f64 * 2.3).sin()).collect();
            let (dual, plain) = (dual(&lattice, &values).unwrap(), norm(&values, 0.04, 2.0).unwrap());
            assert!(dual <= plain && plain <= (1.0 + 4.0 / 0.2) * dual, "{dual} {plain}");
        }
    }

    /// In single precision 2^24 + 1 is 2^24. The spacing is so large that the lattice Laplacian is negligible, and the norm is that of L^2_h.
    #[test]
    fn many_small_values_beside_a_large_one() {
        let (n, h) = ((1 << 20) + 1, 2.0_f32.powi(40));
        let lattice = Lattice { points: [n], spacing: h, margin: 0 };
        let mut memory = vec![0xFF_u8; lattice.workspace_bytes().unwrap() + ALIGN];
        let start = memory.as_ptr().align_offset(ALIGN);
        let bytes = memory.len() - ALIGN;
        let mut values = vec![1.0_f32; n];
        values[n / 2] = 4096.0;
        let got = lattice.dual_norm(&values, &mut memory[start..start + bytes]).unwrap();
        // (2^40 (2^24 + 2^20))^(1/2) = 2^30 17^(1/2), up to a relative 2 / h^2 = 2^-79 and one rounding.
        assert_eq!(got, 2.0_f32.powi(30) * 4.123_105_6);
    }

    /// h^D overflows or underflows, its square root does not. Relative to h^2 = 1e400 the Laplacian is negligible.
    #[test]
    fn volumes_beyond_the_range() {
        for h in [1e130_f64, 1e200] {
            let lattice = Lattice { points: [2, 1, 1], spacing: h, margin: 0 };
            let got = dual(&lattice, &[3.0, -4.0]).unwrap();
            assert!((got / (5.0 * h.sqrt().powi(3)) - 1.0).abs() < 16.0 * f64::EPSILON);
        }
    }

    #[test]
    fn refusals() {
        let lattice = Lattice { points: [2, 2], spacing: 0.2, margin: 1 };
        assert_eq!(dual(&lattice, &[0.0; 4]), Ok(0.0));
        assert_eq!(dual(&Lattice { points: [0, 2], ..lattice }, &[]), Ok(0.0));
        assert_eq!(dual(&lattice, &[0.0; 3]), Err(Error::LengthMismatch));
        assert_eq!(dual(&lattice, &[0.0, 1.0, f64::NAN, 0.0]), Err(Error::NotFinite));
        assert_eq!(dual(&Lattice { spacing: 0.0, ..lattice }, &[1.0; 4]), Err(Error::OutOfDomain));
        assert_eq!(dual(&Lattice { margin: usize::MAX, ..lattice }, &[1.0; 4]), Err(Error::TooLarge));
        assert_eq!(lattice.dual_norm(&[1.0; 4], &mut []), Err(Error::WorkspaceTooSmall));
    }
}
