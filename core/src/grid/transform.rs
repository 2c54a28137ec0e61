//! Sine and cosine transforms of mesh rows, two rows per complex sequence.
//!
//! With x_0 .. x_n the nodes of a row, the transforms are
//!
//! * sine: X_k = sum_(0<j<n) x_j sin(pi j k / n), 0 < k < n,
//! * cosine: X_k = (x_0 + (-1)^k x_n) / 2 + sum_(0<j<n) x_j cos(pi j k / n), 0 <= k <= n,
//!
//! each its own inverse up to the factor 2 / n. x and its reflection are combined into a real sequence of length n. One half of its
//! Fourier transform holds the even X_k, the other the differences X_(2k+1) - X_(2k-1) (Cooley, Lewis & Welch 1970;
//! Dollimore 1973). That is half the length of the odd or even extension. The running sum adds rounding errors of about
//! sqrt(n) u, far below the error that the solve allows.

use super::fft::{Element, Fft, LANES, add, half_root, scale, sub, times_i};
use crate::checked::Present;
use crate::error::Result;
use crate::memory::Space;
use crate::real::Real;

/// Real rows transformed together: one in the real part and one in the imaginary part of each lane.
pub(super) const ROWS: usize = 2 * LANES;

/// Sine (Dirichlet) or cosine (no flux).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Sine,
    Cosine,
}

/// The transform along one axis of n cells.
#[derive(Debug)]
pub(super) struct Transform<'w, T> {
    kind: Kind,
    n: usize,
    /// (sin, cos)(pi j / n), 0 <= j <= n / 2.
    half_roots: &'w mut [[T; 2]],
    fft: Fft<'w, T>,
}

impl<'w, T: Real> Transform<'w, T> {
    pub(super) fn layout(space: &mut impl Space<'w>, kind: Kind, n: usize) -> Result<Self> {
        Ok(Self { kind, n, half_roots: space.try_array(n / 2 + 1)?, fft: Fft::layout(space, n)? })
    }

    pub(super) fn prepare(&mut self) {
        for (j, slot) in self.half_roots.iter_mut().enumerate() {
            *slot = half_root(j, self.n);
        }
        self.fft.prepare();
    }

    /// Elements of each of the two buffers.
    pub(super) fn buffer(n: usize) -> usize {
        Fft::<T>::buffer(n).max(n.saturating_add(2))
    }

    /// Transforms elements 0 to n of `a`. The real part of a lane is one row, its imaginary part another. Returns the buffer with
    /// the result. The sine transform ignores elements 0 and n and leaves them undefined in the result.
    #[inline(always)]
    pub(super) fn run<'b>(&self, a: &'b mut [Element<T>], b: &'b mut [Element<T>]) -> &'b mut [Element<T>] {
        let first = self.fold(a);
        let (z, out) = self.fft.run(a, b);
        self.unfold(first, z, out);
        out
    }

    /// Combines x into the sequence y whose Fourier transform holds X. Returns X_1 for the cosine transform.
    #[inline(always)]
    fn fold(&self, a: &mut [Element<T>]) -> Element<T> {
        let n = self.n;
        let zero = [[T::ZERO; LANES]; 2];
        let mut first = zero;
        let (mut x_0, x_n) = (a.first().copied().unwrap_or(zero), a.get(n).copied().unwrap_or(zero));
        if self.kind == Kind::Cosine {
            first = scale(sub(x_0, x_n), T::HALF);
            x_0 = scale(add(x_0, x_n), T::HALF);
        } else {
            x_0 = zero;
        }
        let pairs = n.saturating_sub(1) / 2;
        let roots = self.half_roots.get(1..).present_or_default();
        let (low, high) = a.get_mut(1..n).and_then(|a| a.split_at_mut_checked(pairs)).unwrap_or((&mut [], &mut []));
        for ((low, high), &[sin, cos]) in low.iter_mut().zip(high.iter_mut().rev()).zip(roots) {
            let (sum, difference) = (add(*low, *high), sub(*low, *high));
            let (even, odd) = match self.kind {
                Kind::Sine => (scale(sum, sin), scale(difference, T::HALF)),
                Kind::Cosine => {
                    first = add(first, scale(difference, cos));
                    (scale(sum, T::HALF), scale(difference, -sin))
                }
            };
            *low = add(even, odd);
            *high = sub(even, odd);
        }
        // For even n the middle node is its own mirror image.
        if n.is_multiple_of(2)
            && self.kind == Kind::Sine
            && let Some(middle) = high.first_mut()
        {
            *middle = add(*middle, *middle);
        }
        if let Some(slot) = a.first_mut() {
            *slot = x_0;
        }
        first
    }

    /// Extracts X from Z = FFT(y), y = y_1 + i y_2 of two real rows. With R and I the cosine and sine sums of y, R_k = (Z_k + Z_(n-k)) / 2
    /// and I_k = i (Z_k - Z_(n-k)) / 2; the rows stay packed.
    #[inline(always)]
    fn unfold(&self, first: Element<T>, z: &[Element<T>], out: &mut [Element<T>]) {
        let zero = [[T::ZERO; LANES]; 2];
        let n = self.n;
        let z_0 = z.first().copied().unwrap_or(zero);
        let mut odd = match self.kind {
            Kind::Sine => scale(z_0, T::HALF),
            Kind::Cosine => first,
        };
        let (out, _) = out.as_chunks_mut::<2>();
        let Some((start, out)) = out.split_first_mut() else { return };
        *start = [z_0, odd];
        let z = z.get(1..n).present_or_default();
        for (([even_out, odd_out], &a), &b) in out.iter_mut().zip(z.iter().take(n / 2)).zip(z.iter().rev()) {
            let cosine = scale(add(a, b), T::HALF);
            let sine = times_i(scale(sub(a, b), T::HALF));
            let (even, step) = match self.kind {
                Kind::Sine => (sine, cosine),
                Kind::Cosine => (cosine, sine),
            };
            odd = add(odd, step);
            *even_out = even;
            *odd_out = odd;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::tests::{aligned, unit};
    use crate::memory::{Carve, Measure};
    use std::vec;

    #[test]
    fn any_length_against_the_sums() {
        for n in (2..=40).chain([64, 97, 100, 127, 128, 255, 257, 320]) {
            for kind in [Kind::Sine, Kind::Cosine] {
                let bytes = Measure::of(|space| Transform::<f64>::layout(space, kind, n).map(|_| ())).unwrap();
                let mut memory = vec![0xA5_u8; bytes + 64];
                let mut carve = Carve::new(aligned(&mut memory, bytes)).unwrap();
                let mut transform = Transform::<f64>::layout(&mut carve, kind, n).unwrap();
                transform.prepare();
                let size = Transform::<f64>::buffer(n);
                let mut seed = n as u64;
                let (mut a, mut b) = (vec![[[f64::NAN; LANES]; 2]; size], vec![[[f64::NAN; LANES]; 2]; size]);
                a[..=n].fill_with(|| [0, 1].map(|_| [0; LANES].map(|_| unit(&mut seed) - 0.5)));
                let x = a.clone();
                let result = transform.run(&mut a, &mut b);
                let range = if kind == Kind::Sine { 1..n } else { 0..n + 1 };
                for k in range.clone() {
                    for (part, l) in [(0, 0), (1, 0), (0, LANES - 1), (1, LANES - 1)] {
                        let want: f64 = range
                            .clone()
                            .map(|j| {
                                let angle = core::f64::consts::PI * (j * k % (2 * n)) as f64 / n as f64;
                                let weight = if kind == Kind::Cosine && (j == 0 || j == n) { 0.5 } else { 1.0 };
                                weight * x[j][part][l] * if kind == Kind::Sine { angle.sin() } else { angle.cos() }
                            })
                            .sum();
                        // Each step of the running sum has an error of about u |x|, |x| about sqrt(n / 12). sqrt(n / 2) steps add up to about
                        // u n / 5, and the direct sum has as much. The bound is ten times that.
                        let bound = 2.0 * (n as f64 + 10.0) * f64::EPSILON;
                        let error = (result[k][part][l] - want).abs();
                        assert!(error < bound, "{kind:?} n {n} k {k}: {error:e}");
                    }
                }
            }
        }
    }
}
