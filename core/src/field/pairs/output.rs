//! From sums in units to results.

use super::lanes::{Sums, Total, WIDE};
use crate::checked::Present;
use crate::field::Outputs;
use crate::real::{DoubleWord, Real};
use crate::simd::{Isa, MAX_LANES};

/// The way from sums in units to true ones: factors, and the powers of two that follow them.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Scales<T> {
    pub potential: (T, i32),
    pub gradient: (T, i32),
    pub laplacian: (T, i32),
}

/// The contribution of one pair, or of all pairs of a target, in the caller's units.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Contribution<T, const D: usize> {
    pub potential: T,
    pub gradient: [T; D],
    pub laplacian: T,
}

impl<T: Real, const D: usize> Contribution<T, D> {
    pub const ZERO: Self = Self { potential: T::ZERO, gradient: [T::ZERO; D], laplacian: T::ZERO };

    /// Adds another one; returns the errors of the additions.
    fn add(&mut self, other: &Self) -> Self {
        let mut error = Self::ZERO;
        let add = |sum: &mut T, term: T| {
            let DoubleWord { hi, lo } = DoubleWord::sum(*sum, term);
            *sum = hi;
            // The error of an infinite sum would be NaN.
            if hi.is_finite() { lo } else { T::ZERO }
        };
        error.potential = add(&mut self.potential, other.potential);
        error.laplacian = add(&mut self.laplacian, other.laplacian);
        for ((error, sum), &term) in error.gradient.iter_mut().zip(&mut self.gradient).zip(&other.gradient) {
            *error = add(sum, term);
        }
        error
    }
}

/// The results of a register block's targets, with what their sums of single pairs lack.
pub(super) struct Results<T, const D: usize> {
    values: [Contribution<T, D>; WIDE * MAX_LANES],
    /// None without single pairs.
    low: Option<[Contribution<T, D>; WIDE * MAX_LANES]>,
}

impl<T: Real, const D: usize> Results<T, D> {
    pub const ZERO: Self = Self { values: [Contribution::ZERO; WIDE * MAX_LANES], low: None };

    /// Starts the first `n` targets again.
    #[inline(always)]
    pub fn clear(&mut self, n: usize) {
        self.values.iter_mut().take(n).for_each(|value| *value = Contribution::ZERO);
        self.low = None;
    }

    /// Adds a pair to a target in double words.
    pub fn add(&mut self, target: usize, pair: &Contribution<T, D>) {
        if self.low.is_none() {
            self.low = Some([Contribution::ZERO; WIDE * MAX_LANES]);
        }
        let low = self.low.as_mut().and_then(|low| low.get_mut(target));
        if let (Some(value), Some(low)) = (self.values.get_mut(target), low) {
            let error = value.add(pair);
            low.add(&error);
            *low = value.add(&low.clone());
        }
    }

    /// The results of the first `n` targets, by vectors of so many.
    #[inline(always)]
    fn vectors(&mut self, n: usize, lanes: usize) -> impl Iterator<Item = &mut [Contribution<T, D>]> {
        self.values.get_mut(..n).unwrap_or_default().chunks_mut(lanes)
    }

    /// The results of the first `n` targets, rounded.
    #[inline(always)]
    pub fn finish(&mut self, n: usize) -> &[Contribution<T, D>] {
        if let Some(low) = &self.low {
            for (value, low) in self.values.iter_mut().zip(low) {
                value.add(low);
            }
        }
        self.values.get(..n).present_or(&[])
    }
}

/// Adds the sums of vectors of targets to their results.
#[inline(always)]
pub(super) fn add<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    (results, n): (&mut Results<T, D>, usize),
    totals: &[Total<I::V, D>; NB],
    scales: &Scales<T>,
) {
    for (results, Total { sums, .. }) in results.vectors(n, I::LANES).zip(totals) {
        let mut lanes = Sums::splat([T::ZERO; MAX_LANES]);
        lanes.potential = isa.store(sums.potential);
        lanes.laplacian = isa.store(sums.laplacian);
        for (lanes, &sum) in lanes.gradient.iter_mut().zip(&sums.gradient) {
            *lanes = isa.store(sum);
        }
        add_lanes(results, &lanes, scales);
    }
}

/// Adds the sums of each lane to the results. Not in line: it is compiled once for all instruction sets.
#[inline(never)]
fn add_lanes<T: Real, const D: usize>(
    results: &mut [Contribution<T, D>],
    sums: &Sums<[T; MAX_LANES], D>,
    scales: &Scales<T>,
) {
    scaled(&sums.potential, scales.potential, |k, p| {
        results.get_mut(k).into_iter().for_each(|result| result.potential += p);
    });
    scaled(&sums.laplacian, scales.laplacian, |k, l| {
        results.get_mut(k).into_iter().for_each(|result| result.laplacian += l);
    });
    for (d, sum) in sums.gradient.iter().enumerate() {
        scaled(sum, scales.gradient, |k, g| {
            let to = results.get_mut(k).and_then(|result| result.gradient.get_mut(d));
            to.into_iter().for_each(|to| *to += g);
        });
    }
}

/// Passes each sum to `take` in true units, rounded as `ldexp` rounds: where the power of two is a normal number, its product is rounded once too.
#[inline(always)]
fn scaled<T: Real>(sums: &[T; MAX_LANES], (factor, exponent): (T, i32), mut take: impl FnMut(usize, T)) {
    if exponent.saturating_abs() < T::MAX_EXPONENT {
        let power = T::ONE.ldexp(exponent);
        sums.iter().enumerate().for_each(|(k, &sum)| take(k, sum * factor * power));
    } else {
        sums.iter().enumerate().for_each(|(k, &sum)| take(k, (sum * factor).ldexp(exponent)));
    }
}

/// Where the results of a task's targets go, one block after the other.
pub(super) struct Writer<'a, T, const D: usize> {
    potential: Option<core::slice::IterMut<'a, T>>,
    gradient: Option<core::slice::IterMut<'a, [T; D]>>,
    laplacian: Option<core::slice::IterMut<'a, T>>,
    hessian: Option<core::slice::IterMut<'a, [[T; D]; D]>>,
    /// Which row of the second derivatives.
    row: usize,
    combination: Option<(T, T)>,
    /// Whether the results are added to what is there.
    added: bool,
}

impl<'a, T: Real, const D: usize> Writer<'a, T, D> {
    pub fn new(outputs: Outputs<'a, T, D>, (a, b): (f64, f64), row: usize, added: bool) -> Self {
        Self {
            added,
            potential: outputs.potential.map(|p| p.iter_mut()),
            gradient: outputs.gradient.map(|g| g.iter_mut()),
            laplacian: outputs.laplacian.map(|l| l.iter_mut()),
            hessian: outputs.hessian.map(|h| h.iter_mut()),
            row,
            combination: ((a, b) != (1.0, 0.0)).then(|| (T::from_f64(a), T::from_f64(b))),
        }
    }

    /// Writes the next results. (An iterator in front of a zip would lose an element where the other one ends.)
    pub fn write(&mut self, results: &[Contribution<T, D>]) {
        let added = self.added;
        if let Some(to) = &mut self.potential {
            results
                .iter()
                .zip(to)
                .for_each(|(result, to)| *to = if added { *to + result.potential } else { result.potential });
        }
        if let Some(to) = &mut self.laplacian {
            results
                .iter()
                .zip(to)
                .for_each(|(result, to)| *to = if added { *to + result.laplacian } else { result.laplacian });
        }
        if let Some(to) = &mut self.hessian {
            results.iter().zip(to).for_each(|(result, to)| add_row(to, self.row, result, added));
        }
        if let Some(to) = &mut self.gradient {
            for (result, to) in results.iter().zip(to) {
                if added {
                    to.iter_mut().zip(&result.gradient).for_each(|(to, &g)| *to += g);
                    continue;
                }
                *to = result.gradient;
                if let (Some((a, b)), [x, y, ..]) = (self.combination, to.as_mut_slice()) {
                    // A factor of zero takes nothing from a component that has overflowed.
                    let times = |factor: T, x: T| if factor == T::ZERO { T::ZERO } else { factor * x };
                    (*x, *y) = (times(a, *x) - times(b, *y), times(a, *y) + times(b, *x));
                }
            }
        }
    }
}

/// Adds a row of second derivatives to a matrix, and what it says of the others: it is symmetric, and its trace is the Laplacian. The rows come in their order, but for the last;
/// `added`: to what is there, else the first one overwrites.
fn add_row<T: Real, const D: usize>(to: &mut [[T; D]; D], row: usize, result: &Contribution<T, D>, added: bool) {
    let share = result.laplacian / T::from_usize(D);
    let mut put = |i: usize, j: usize, x: T, first: bool| {
        if let Some(to) = to.get_mut(i).and_then(|to| to.get_mut(j)) {
            *to = if added || !first { *to + x } else { x };
        }
    };
    for (j, &x) in result.gradient.iter().enumerate().skip(row) {
        if j == row {
            put(row, row, x + share, true);
            // The part without trace has its negative at the end of the diagonal.
            put(D - 1, D - 1, if row == 0 { share - x } else { T::ZERO - x }, row == 0);
        } else {
            put(row, j, x, true);
            put(j, row, x, true);
        }
    }
}
