//! One target and one source at a time: the direct sum for machines whose flash is dear (feature `small`).
//!
//! The same operations in the same order as [`super::direct`] at level portable, so the same bits (test
//! `bits_are_those_of_the_lanes`), in a fraction of the code: what is wanted is asked in the loop, not compiled in variants.
//! There is no executor, as the C functions refuse it, and there is no scaled path: a coordinate or mass below 2^-100 (f64: 2^-900) of the largest counts as zero, pairs without a
//! mollifier closer than 2^-28 (2^-60) of the largest coordinate count as coincident, and a delta below that is refused.

use super::direct::{Call, Scales};
use super::newtonian::{BLOCK, descending, descending_potential, far_gradient, outside};
use super::packed::{Packed, least_square_exponent, power_of_two};
use super::{Accumulation, Options, Run};
use crate::error::{Error, Result};
use crate::isa::{Isa, Job, Level};
use crate::mollifier::{MAX_TERMS, Mollifier, Polynomial};
use crate::real::Real;
use crate::space::Carve;

/// Targets between two questions whether to stop.
const TASK: usize = 128;

/// Overwrites the outputs.
///
/// Not `FULL`: no potential is wanted, the options are the defaults. What the others need is then not linked.
pub(super) fn sums<T: Real, const D: usize, const FULL: bool>(
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let units = call.units();
    let Call { kernel, options, sources, targets, mut outputs } = call;
    let mut packed = Packed::<T, D>::lay(&mut Carve::reopen(workspace)?, sources.positions.len())?;
    packed.fill_tame(units, sources.positions, sources.masses);
    let (blob, wanted) = (kernel.blob, outputs.wanted());
    let mollified = blob.mollifier() != Mollifier::None;
    let least = power_of_two::<T>(-least_square_exponent::<T>());
    let delta = blob.delta() * power_of_two(units.position);
    let square = delta * delta;
    if mollified && (square < least || blob.terms(Polynomial::Gradient).is_none()) {
        return Err(Error::Unsupported);
    }
    let scales = Scales::new::<D>(kernel.coefficient, units, if FULL { options } else { &Options::DEFAULT });
    let compensated = FULL && options.accumulation == Accumulation::Compensated;
    // Compensated sums always carry both, whatever is wanted: the gradient's division is then the logarithm's.
    let (potential, gradient) = (FULL && wanted.potential || compensated, wanted.gradient || compensated);
    // What is not wanted takes no stack where that is known when this is compiled (which it is not of parts of a tuple).
    let mut of_gradient = [T::ZERO; MAX_TERMS];
    let mut of_potential = [T::ZERO; MAX_TERMS];
    let mut of_density = [T::ZERO; MAX_TERMS];
    let mut pair = Pair {
        edge: if mollified { square } else { least },
        per_square: T::ZERO,
        offset: T::ZERO,
        log_exponent: T::from_i32(units.position.saturating_mul(-2)),
        potential: potential.then_some(&[]),
        gradient: gradient.then_some(&[]),
        laplacian: wanted.laplacian.then_some(&[]),
        mollified,
        compensated,
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
    let (positions, masses) = packed.tame();
    for (i, target) in targets.iter().enumerate() {
        if i % TASK == 0 && run.should_stop.is_some_and(|stop| stop()) {
            return Err(Error::Stopped);
        }
        let x = units.tame_point(target);
        let (mut total, mut sums, mut lost) = (Totals::ZERO, Totals::ZERO, Totals::ZERO);
        for (k, (source, &mass)) in positions.iter().zip(masses).enumerate() {
            // A compensated sum has nothing to gain from blocks.
            if k % BLOCK == 0 && !compensated {
                total.add(&sums);
                sums = Totals::ZERO;
            }
            pair.add::<D, FULL>(&x, source, mass, &mut sums, &mut lost);
        }
        total.add(&sums);
        if FULL {
            total.add(&lost);
            if let Some(to) = outputs.potential.as_mut().and_then(|p| p.get_mut(i)) {
                *to = scales.value(total.potential, scales.potential);
            }
        }
        if let Some(to) = outputs.gradient.as_mut().and_then(|g| g.get_mut(i)) {
            for (to, &sum) in to.iter_mut().zip(&total.gradient) {
                *to = scales.value(sum, scales.gradient);
            }
            if FULL {
                scales.combine(to);
            }
        }
        if let Some(to) = outputs.laplacian.as_mut().and_then(|l| l.get_mut(i)) {
            *to = scales.value(total.laplacian, scales.laplacian);
        }
    }
    // Solvers count nothing.
    if FULL && let Some(counters) = run.counters.as_deref_mut() {
        let pairs = (packed.len() as u64).saturating_mul(targets.len() as u64);
        let massless = sources.masses.len().saturating_sub(packed.len()) as u64;
        counters.pairs = counters.pairs.saturating_add(pairs);
        counters.massless_sources = counters.massless_sources.saturating_add(massless);
    }
    Ok(())
}

/// A pair outside the support whose potential is wanted too.
struct Far<T, const D: usize> {
    exponent: T,
    mass: T,
    d: [T; D],
    square: T,
    gradient: bool,
}

impl<T: Real, const D: usize> Job<T> for Far<T, D> {
    type Out = (T, T);

    #[inline(always)]
    fn run<I: Isa<T>>(self, isa: I) -> (T, T) {
        let lane = |vector: I::V| isa.store(vector).first().copied().unwrap_or(T::ZERO);
        let (e, mass) = (isa.splat(self.exponent), isa.splat(self.mass));
        let (d, r2) = ([self.d.map(|d| isa.splat(d))], [isa.splat(self.square)]);
        let [(value, factor)] = if self.gradient {
            outside::<T, I, D, 1, true, true>(isa, e, mass, &d, &r2)
        } else {
            outside::<T, I, D, 1, true, false>(isa, e, mass, &d, &r2)
        };
        (lane(value), lane(factor))
    }
}

/// Sums for one target, as [`super::newtonian::Sums`] are for many.
#[derive(Clone, Copy)]
struct Totals<T, const D: usize> {
    gradient: [T; D],
    laplacian: T,
    potential: T,
}

impl<T: Real, const D: usize> Totals<T, D> {
    const ZERO: Self = Self { gradient: [T::ZERO; D], laplacian: T::ZERO, potential: T::ZERO };

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(sum, &other)| *sum += other);
        self.laplacian += other.laplacian;
        self.potential += other.potential;
    }
}

/// What every pair has in common: [`super::newtonian::Softened`] for one number at a time.
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
    compensated: bool,
}

/// Horner's rule, rounded as at level portable.
#[cfg_attr(feature = "small", inline(never))]
fn horner<T: Real>(coefficients: &[T], t: T) -> T {
    let Some((&first, rest)) = coefficients.split_first() else { return T::ZERO };
    rest.iter().fold(first, |sum, &c| sum * t + c)
}

impl<T: Real> Pair<'_, T> {
    #[inline(always)]
    fn add<const D: usize, const FULL: bool>(
        &self,
        x: &[T; D],
        source: &[T; D],
        mass: T,
        sums: &mut Totals<T, D>,
        lost: &mut Totals<T, D>,
    ) {
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
        } else if has_potential {
            let (exponent, gradient) = (self.log_exponent, self.gradient.is_some());
            (k, g) = Level::Portable.run(Far { exponent, mass, d, square, gradient });
        } else if self.gradient.is_some() {
            g = far_gradient::<T, D>(mass, square);
        } else {
            return;
        }
        let add = |sum: &mut T, lost: &mut T, x: T, y: T| {
            let term = x * y;
            if FULL && self.compensated {
                // The addition's error (Knuth's two-sum).
                let total = *sum + term;
                let back = total - *sum;
                *lost += (*sum - (total - back)) + (term - back);
                *sum = total;
            } else {
                *sum = term + *sum;
            }
        };
        // What is not wanted adds zeros, which costs less flash than asking.
        if FULL {
            add(&mut sums.potential, &mut lost.potential, mass, k);
        }
        add(&mut sums.laplacian, &mut lost.laplacian, mass, b);
        for ((sum, lost), d) in sums.gradient.iter_mut().zip(&mut lost.gradient).zip(d) {
            add(sum, lost, g, d);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Outputs, Sources, direct, direct::Newtonian};
    use super::*;
    use crate::mollifier::Blob;
    use crate::parallel::Serial;
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
        };
        let kernel = Newtonian { blob, coefficient: -T::from_f64(1.7) };
        let call = Call { kernel, options, sources: Sources { positions: points, masses }, targets: points, outputs };
        let bytes = direct::workspace_bytes::<T, D>(n).unwrap();
        let mut memory = vec![0xA5_u8; bytes + 64];
        let start = memory.as_ptr().align_offset(64);
        let workspace = &mut memory[start..start + bytes];
        let mut run = Run { level: Level::Portable, executor: &Serial, should_stop: None, counters: None };
        let plain = !which[0] && *options == Options::default();
        let sum = match (single, plain) {
            (false, _) => direct::evaluate,
            (true, false) => sums::<T, D, true>,
            (true, true) => sums::<T, D, false>,
        };
        sum(call, workspace, &mut run).unwrap();
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
