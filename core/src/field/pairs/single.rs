//! One target and one source at a time: the direct sum for machines with little flash memory (feature `small`).
//!
//! The same operations in the same order as the engine's at level portable, so the same bits (test `bits_are_those_of_the_lanes`), in a fraction of
//! the code: outputs are selected at run time, not by compiled variants.
//! There is no executor, as the C functions refuse it, and there is no scaled path: a coordinate or mass below 2^-100 (f64: 2^-900) of the largest counts as zero, pairs without a
//! mollifier closer than 2^-28 (2^-60) of the largest coordinate count as coincident, and a delta below that is refused.

use super::newtonian::inside::{descending, descending_potential};
use super::newtonian::{Newtonian, outside_potential};
use super::packed::{Packed, Units, class_width, least_square_exponent, power_of_two};
use super::{BLOCK, Call, PairKernel, SHORT_BLOCK};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::Accumulation;
use crate::memory::Carve;
use crate::mollifier::{MAX_COEFFICIENTS, Mollifier, Polynomial};
use crate::real::Real;
use crate::simd::{Isa, Job, portable};

/// Targets between two calls of `should_stop`.
const TASK: usize = 128;

/// Overwrites the outputs.
///
/// Not `FULL`: no potential is wanted, the options are the defaults. What the others need is then not linked.
pub(super) fn sums<T: Real, const D: usize, const FULL: bool>(
    kernel: &Newtonian<'_, T, D, false, false>,
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let Call { options, sources, targets, mut outputs, .. } = call;
    let [coordinate, mass] = sources.largest(1);
    let units = Units::of([coordinate.max(kernel.length()), mass], targets);
    let mut packed = Packed::<T, D>::layout(&mut Carve::reopen(workspace)?, sources.positions.len(), [false; 2])?;
    let (positions, masses) = packed.fill_in_range(units, sources.positions, sources.masses);
    let (blob, wanted) = (kernel.blob, outputs.wanted());
    let mollified = blob.mollifier() != Mollifier::None;
    let least = power_of_two::<T>(-least_square_exponent::<T>());
    let delta = blob.delta() * power_of_two(units.position);
    let square = delta * delta;
    if mollified && (square < least || blob.terms(Polynomial::Gradient).is_none()) {
        return Err(Error::Unsupported);
    }
    let scales = kernel.scales(units, 0);
    let (a, b) = options.combination;
    let combine = FULL && (a, b) != (1.0, 0.0);
    let compensated = FULL && options.accumulation == Accumulation::Compensated;
    let (potential, gradient) = (FULL && wanted.potential, wanted.gradient);
    // What is not wanted takes no stack where that is known when this is compiled (which it is not of parts of a tuple).
    let mut of_gradient = [T::ZERO; MAX_COEFFICIENTS];
    let mut of_potential = [T::ZERO; MAX_COEFFICIENTS];
    let mut of_density = [T::ZERO; MAX_COEFFICIENTS];
    let mut pair = Pair {
        edge: if mollified { square } else { least },
        per_square: T::ZERO,
        offset: T::ZERO,
        log_exponent: T::from_i32(units.position.saturating_mul(-2)),
        potential: potential.then_some(&[]),
        gradient: gradient.then_some(&[]),
        laplacian: wanted.laplacian.then_some(&[]),
        mollified,
    };
    if mollified {
        let per = T::ONE / delta;
        let scale = per.powi(D as u32);
        pair.per_square = per * per;
        if gradient {
            let terms = descending(&mut of_gradient, blob, Polynomial::Gradient, scale);
            pair.gradient = of_gradient.get(..terms);
        }
        if potential {
            let (terms, offset) = descending_potential(&mut of_potential, blob, delta);
            (pair.potential, pair.offset) = (of_potential.get(..terms), offset);
        }
        if wanted.laplacian {
            let terms = descending(&mut of_density, blob, Polynomial::Density, scale);
            pair.laplacian = of_density.get(..terms);
        }
    }
    let each = if compensated { SHORT_BLOCK } else { BLOCK };
    for (i, target) in targets.iter().enumerate() {
        if i % TASK == 0 && run.should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let x = units.point_in_range(target);
        let (mut total, mut sums, mut low) = (Totals::ZERO, Totals::ZERO, Totals::ZERO);
        for (k, (source, &mass)) in positions.iter().zip(masses).enumerate() {
            if k % each == 0 {
                total.join::<FULL>(&sums, &mut low, compensated);
                sums = Totals::ZERO;
            }
            pair.add::<D, FULL>(&x, source, mass, &mut sums);
        }
        total.join::<FULL>(&sums, &mut low, compensated);
        if FULL && let Some(to) = outputs.potential.as_mut().and_then(|p| p.get_mut(i)) {
            *to = value(total.potential, scales.potential);
        }
        if let Some(to) = outputs.gradient.as_mut().and_then(|g| g.get_mut(i)) {
            for (to, &sum) in to.iter_mut().zip(&total.gradient) {
                *to = value(sum, scales.gradient);
            }
            if let (true, [x, y, ..]) = (combine, to.as_mut_slice()) {
                let (a, b) = (T::from_f64(a), T::from_f64(b));
                (*x, *y) = (a * *x - b * *y, a * *y + b * *x);
            }
        }
        if let Some(to) = outputs.laplacian.as_mut().and_then(|l| l.get_mut(i)) {
            *to = value(total.laplacian, scales.laplacian);
        }
    }
    // Solvers count nothing.
    if FULL && let Some(counters) = run.counters.as_deref_mut() {
        let pairs = (masses.len() as u64).saturating_mul(targets.len() as u64);
        let massless = sources.masses.len().saturating_sub(masses.len()) as u64;
        counters.pairs = counters.pairs.saturating_add(pairs);
        counters.massless_sources = counters.massless_sources.saturating_add(massless);
    }
    Ok(())
}

/// A sum in units, as the way to results takes it.
fn value<T: Real>(sum: T, (factor, exponent): (T, i32)) -> T {
    // As the engine adds it to a result that begins with zero.
    T::ZERO + (sum * factor).ldexp(exponent)
}

/// The potential of a pair outside the support.
struct Far<T, const D: usize> {
    exponent: T,
    d: [T; D],
    square: T,
}

impl<T: Real, const D: usize> Job<T> for Far<T, D> {
    type Out = T;

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) -> T {
        let (exponent, r2) = (isa.splat(self.exponent), [isa.splat(self.square)]);
        let [value] = outside_potential::<T, I, D, 1>(isa, exponent, &[self.d.map(|d| isa.splat(d))], &r2);
        isa.store(value).first().copied().unwrap_or(T::NAN)
    }
}

/// m S_D g of the bare kernel, rounded as the engine rounds it at level portable.
#[inline(always)]
fn far_gradient<T: Real, const D: usize>(mass: T, r2: T) -> T {
    match D {
        1 => mass / r2.sqrt(),
        2 => mass / r2,
        _ => mass / (r2 * r2.sqrt()),
    }
}

/// Sums for one target, as [`super::lanes::Sums`] are for many.
#[derive(Clone, Copy)]
struct Totals<T, const D: usize> {
    gradient: [T; D],
    laplacian: T,
    potential: T,
}

impl<T: Real, const D: usize> Totals<T, D> {
    const ZERO: Self = Self { gradient: [T::ZERO; D], laplacian: T::ZERO, potential: T::ZERO };

    /// Adds a block's sums, compensated as the engine does it.
    #[inline(always)]
    fn join<const FULL: bool>(&mut self, block: &Self, low: &mut Self, compensated: bool) {
        let add = |sum: &mut T, term: T, low: &mut T| {
            if !(FULL && compensated) {
                *sum += term;
                return;
            }
            let total = *sum + term;
            let back = total - *sum;
            *low += (*sum - (total - back)) + (term - back);
            *sum = total + *low;
            *low -= *sum - total;
        };
        for ((sum, &term), low) in self.gradient.iter_mut().zip(&block.gradient).zip(&mut low.gradient) {
            add(sum, term, low);
        }
        add(&mut self.laplacian, block.laplacian, &mut low.laplacian);
        add(&mut self.potential, block.potential, &mut low.potential);
    }
}

/// What every pair has in common: `Softened` for one number at a time.
struct Pair<'a, T> {
    /// Pairs with r2 below this are inside the support, or coincident.
    edge: T,
    /// 1 / delta^2.
    per_square: T,
    /// Added to the potential's polynomial.
    offset: T,
    /// Added to the exponent of r2, so that its logarithm is that of true units.
    log_exponent: T,
    /// Polynomials in t, highest power first, of what is wanted.
    potential: Option<&'a [T]>,
    gradient: Option<&'a [T]>,
    laplacian: Option<&'a [T]>,
    mollified: bool,
}

/// Horner's rule, rounded as at level portable.
fn horner<T: Real>(coefficients: &[T], t: T) -> T {
    let Some((&first, rest)) = coefficients.split_first() else { return T::ZERO };
    rest.iter().fold(first, |sum, &c| sum * t + c)
}

impl<T: Real> Pair<'_, T> {
    #[inline(always)]
    fn add<const D: usize, const FULL: bool>(&self, x: &[T; D], source: &[T; D], mass: T, sums: &mut Totals<T, D>) {
        let mut d = *source;
        let mut square = T::ZERO;
        for (k, (d, &x)) in d.iter_mut().zip(x).enumerate() {
            *d -= x;
            square = if k == 0 { *d * *d } else { *d * *d + square };
        }
        let (mut k, mut g, mut b) = (T::ZERO, T::ZERO, T::ZERO);
        let has_potential = FULL && self.potential.is_some();
        if square < self.edge {
            if !self.mollified {
                return;
            }
            let t = T::ONE - square * self.per_square;
            if let Some(coefficients) = self.gradient {
                g = mass * horner(coefficients, t);
            }
            if let (Some(coefficients), true) = (self.potential, FULL) {
                let polynomial = horner(coefficients, t);
                k = if D == 1 { polynomial * square + self.offset } else { polynomial + self.offset };
            }
            if let Some(coefficients) = self.laplacian {
                b = horner(coefficients, t);
            }
        } else {
            if has_potential {
                k = portable(Far { exponent: self.log_exponent, d, square });
            }
            if self.gradient.is_some() {
                g = far_gradient::<T, D>(mass, square);
            }
        }
        let add = |sum: &mut T, x: T, y: T| *sum = x * y + *sum;
        // What is not wanted adds zeros, which costs less flash than asking.
        if FULL {
            add(&mut sums.potential, mass, k);
        }
        add(&mut sums.laplacian, mass, b);
        for (sum, d) in sums.gradient.iter_mut().zip(d) {
            add(sum, g, d);
        }
    }
}

impl<T: Real> Units<T> {
    /// A point in these units; coordinates so small beside the largest that their squares leave the range are zero.
    #[inline(always)]
    pub fn point_in_range<const D: usize>(&self, x: &[T; D]) -> [T; D] {
        let least = power_of_two(-class_width::<T>());
        let mut point = *x;
        for x in &mut point {
            let scaled = *x * self.position_factor;
            *x = if scaled.abs() < least { T::ZERO } else { scaled };
        }
        point
    }
}

impl<T: Real, const D: usize> Packed<'_, T, D> {
    /// Takes in the sources of class 0 alone, coordinates by [`Units::point_in_range`]; no bounds are made.
    pub fn fill_in_range(&mut self, units: Units<T>, positions: &[[T; D]], masses: &[T]) -> (&[[T; D]], &[T]) {
        let (least, factor) = (power_of_two::<T>(-class_width::<T>()), power_of_two::<T>(units.mass));
        let mut slots = self.positions.iter_mut().zip(self.masses.iter_mut());
        let mut count = 0;
        for (x, &m) in positions.iter().zip(masses) {
            let mass = m * factor;
            if mass.abs() < least {
                continue;
            }
            if let Some((to_x, to_m)) = slots.next() {
                (*to_x, *to_m) = (units.point_in_range(x), mass);
                count += 1;
            }
        }
        (self.positions.get(..count).present_or(&[]), self.masses.get(..count).present_or(&[]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::{Run, Serial};
    use crate::field::{Options, Outputs, Sources};
    use crate::mollifier::Blob;
    use crate::simd::Level;
    use std::{vec, vec::Vec};

    /// All outputs of one sum, as bits.
    fn bits<T: Real, const D: usize>(
        blob: &Blob<T, D>,
        points: &[[T; D]],
        masses: &[T],
        which: [bool; 3],
        options: &Options,
        single: bool,
    ) -> Vec<u64> {
        let n = points.len();
        let (mut u, mut g, mut l) = (vec![T::NAN; n], vec![[T::NAN; D]; n], vec![T::NAN; n]);
        let outputs = Outputs {
            potential: which[0].then_some(&mut *u),
            gradient: which[1].then_some(&mut *g),
            laplacian: which[2].then_some(&mut *l),
            hessian: None,
        };
        let kernel = Newtonian { blob, coefficient: -T::from_f64(1.7), largest: blob.delta(), table: None };
        let call = Call { options, sources: Sources::new(points, masses), targets: points, outputs, near: None };
        let bytes = super::super::workspace_bytes::<T, D>(n, [false; 2]).unwrap();
        let mut memory = vec![0xA5_u8; bytes + 64];
        let start = memory.as_ptr().align_offset(64);
        let workspace = &mut memory[start..start + bytes];
        let mut run =
            Run { level: Level::Portable, executor: &Serial, should_stop: None, counters: None, communicator: None };
        if single {
            sums::<T, D, true>(&kernel, call, workspace, &mut run).unwrap();
        } else {
            super::super::sums(true, &kernel, call, workspace, &mut run).unwrap();
        }
        u.iter().chain(g.as_flattened()).chain(&l).map(|v| v.bits()).collect()
    }

    fn compare<T: Real, const D: usize>() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            T::from_f64((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        let compact = |order, exponent, delta| Blob::new(Mollifier::Compact { order, exponent }, T::from_f64(delta));
        let blobs = [
            Blob::new(Mollifier::None, T::ZERO),
            compact(2, 4, 0.2),
            compact(4, 5, 0.7),
            compact(6, 1, 30.0),
            compact(2, 1, 1e-3),
        ];
        for n in [0, 1, 7, 9, 64, 257, 530] {
            let mut points: Vec<[T; D]> = (0..n).map(|_| core::array::from_fn(|_| random())).collect();
            let masses: Vec<T> = (0..n).map(|i| if i % 5 == 3 { T::ZERO } else { random() }).collect();
            if n > 8 {
                // A coincident pair, and a point with zeros.
                points[4] = points[2];
                points[7] = [T::ZERO; D];
            }
            for blob in &blobs {
                let blob = blob.as_ref().unwrap();
                for which in 1..8 {
                    let which = [which & 1 != 0, which & 2 != 0, which & 4 != 0];
                    for accumulation in [Accumulation::Blocked, Accumulation::Compensated] {
                        let combination = if D == 2 && which[2] { (0.3, -1.1) } else { (1.0, 0.0) };
                        let options = Options { accumulation, combination, ..Options::default() };
                        let [a, b] = [false, true].map(|one| bits(blob, &points, &masses, which, &options, one));
                        assert!(a == b, "D = {D}, n = {n}, {:?}, {which:?}, {accumulation:?}", blob.mollifier());
                    }
                }
            }
        }
    }

    #[test]
    fn bits_are_those_of_the_lanes() {
        compare::<f32, 1>();
        compare::<f32, 2>();
        compare::<f32, 3>();
        compare::<f64, 2>();
    }
}
