//! A kernel at many distances side by side, for sums: the operations of [`Kernel::pair`] in the same order, so the same bits (test
//! `bits_are_those_of_one_pair_at_a_time`), a series for all lanes at once and only where it is wanted.
//!
//! Lanes lie in different panels of a fit. Each panel that some lane needs is evaluated for all of them, and lanes take what is theirs: most
//! pairs of a sum are outside the mollifier, where one series serves all.

use super::law::Law;
use super::part::{Outer, Panel, Part};
use super::{Kernel, Others};
use crate::isa::{Level, Plain, widest};
use crate::real::Real;

/// Distances side by side: enough recurrences at once to hide what each waits for.
pub const LANES: usize = 16;

/// A number for each lane.
type Lanes<T> = [T; LANES];

impl<T: Real, const D: usize> Kernel<'_, T, D> {
    /// Value, gradient factor and Laplacian at each distance, where `wanted` says so (else zero). At distance zero without a mollifier
    /// they may be anything.
    pub(crate) fn pairs(&self, r: &Lanes<T>, wanted: [bool; 3]) -> [Lanes<T>; 3] {
        widest(Level::best(), Pairs { kernel: self, r, wanted })
    }
}

struct Pairs<'a, 'k, T: Real, const D: usize> {
    kernel: &'a Kernel<'k, T, D>,
    r: &'a Lanes<T>,
    wanted: [bool; 3],
}

impl<T: Real, const D: usize> Plain for Pairs<'_, '_, T, D> {
    type Out = [Lanes<T>; 3];

    #[inline(always)]
    fn run(self) -> [Lanes<T>; 3] {
        let Self { kernel, r, wanted } = self;
        let mut sums = [[T::ZERO; LANES]; 3];
        if let Some(Others { tables, .. }) = kernel.others.first() {
            for part in kernel.parts() {
                add_part::<T, D>(&part.narrow(), tables, r, wanted, &mut sums);
            }
        }
        if kernel.newtonian != T::ZERO {
            add_newtonian(kernel, r, wanted, &mut sums);
        }
        sums
    }
}

/// Adds the values of the chosen lanes.
#[inline(always)]
pub(crate) fn add<T: Real>(sums: &mut Lanes<T>, values: &Lanes<T>, chosen: &Lanes<bool>) {
    for ((sum, &value), &chosen) in sums.iter_mut().zip(values).zip(chosen) {
        *sum += if chosen { value } else { T::ZERO };
    }
}

/// A function of two numbers in every lane.
#[inline(always)]
fn both<T: Real>(a: &Lanes<T>, b: &Lanes<T>, function: impl Fn(T, T) -> T) -> Lanes<T> {
    let mut values = *a;
    values.iter_mut().zip(b).for_each(|(a, &b)| *a = function(*a, b));
    values
}

/// A function that is not worth lanes, of those that are chosen; zero elsewhere.
#[inline(always)]
fn each<T: Real>(r: &Lanes<T>, chosen: &Lanes<bool>, function: impl Fn(T) -> T) -> Lanes<T> {
    let mut values = [T::ZERO; LANES];
    for ((value, &r), &chosen) in values.iter_mut().zip(r).zip(chosen) {
        if chosen {
            *value = function(r);
        }
    }
    values
}

/// A polynomial in every lane, lowest power first, by Horner's rule.
#[inline(always)]
pub(crate) fn horner<T: Real, const N: usize>(coefficients: impl DoubleEndedIterator<Item = T>, x: &[T; N]) -> [T; N] {
    coefficients.rev().fold([T::ZERO; N], |mut sum, c| {
        sum.iter_mut().zip(x).for_each(|(sum, &x)| *sum = *sum * x + c);
        sum
    })
}

/// Clenshaw's recurrence.
#[inline(always)]
fn clenshaw<T: Real>(mut coefficients: impl DoubleEndedIterator<Item = T>, x: &Lanes<T>) -> Lanes<T> {
    let (mut b1, mut b2) = ([T::ZERO; LANES], [T::ZERO; LANES]);
    let Some(first) = coefficients.next() else { return b1 };
    let twice = x.map(|x| x + x);
    for c in coefficients.rev() {
        for ((b1, b2), &twice) in b1.iter_mut().zip(&mut b2).zip(&twice) {
            let next = twice * *b1 - *b2 + c;
            *b2 = *b1;
            *b1 = next;
        }
    }
    for ((b1, &b2), &x) in b1.iter_mut().zip(&b2).zip(x) {
        *b1 = x * *b1 - b2 + first;
    }
    b1
}

/// [`power`](super::law::power) in lanes.
#[inline(always)]
fn powers<T: Real>(r: &Lanes<T>, p: f64, chosen: &Lanes<bool>) -> Lanes<T> {
    let doubled = 2.0 * p;
    if doubled.abs() > 32.0 || doubled != (doubled as i32) as f64 {
        return each(r, chosen, |r| r.pow(T::from_f64(p)));
    }
    let n = (doubled as i32).unsigned_abs();
    let (mut base, mut left, mut result) = (*r, n / 2, [T::ONE; LANES]);
    while left > 0 {
        if left & 1 == 1 {
            result.iter_mut().zip(&base).for_each(|(result, &base)| *result *= base);
        }
        base.iter_mut().for_each(|base| *base *= *base);
        left >>= 1;
    }
    if n % 2 == 1 {
        result.iter_mut().zip(r).for_each(|(result, &r)| *result *= r.sqrt());
    }
    if p < 0.0 { result.map(|v| T::ONE / v) } else { result }
}

#[inline(always)]
fn add_newtonian<T: Real, const D: usize>(
    kernel: &Kernel<'_, T, D>,
    r: &Lanes<T>,
    wanted: [bool; 3],
    sums: &mut [Lanes<T>; 3],
) {
    let c = kernel.newtonian;
    #[cfg(feature = "kernels")]
    let polynomials = &kernel.polynomials;
    #[cfg(not(feature = "kernels"))]
    let polynomials = &kernel.blob.polynomials();
    if polynomials.is_none() && !kernel.is_singular() {
        // Gaussians.
        for (k, &r) in r.iter().enumerate() {
            let values = kernel.newtonian_pair(r, wanted);
            for ((sums, value), _) in sums.iter_mut().zip(values).zip(wanted).filter(|(_, wanted)| *wanted) {
                sums.get_mut(k).into_iter().for_each(|sum| *sum += value);
            }
        }
        return;
    }
    let [value, gradient, laplacian] = sums;
    let mut outside = [true; LANES];
    if let Some(p) = polynomials {
        let inside = r.map(|r| r < p.delta);
        outside = inside.map(|inside| !inside);
        let t = r.map(|r| (p.delta - r) / p.delta * (T::ONE + r / p.delta));
        if wanted[0] {
            let values = horner(p.potential.coefficients().iter().copied(), &t)
                .map(|v| c * (p.potential_scale * v + p.potential_offset));
            add(value, &values, &inside);
        }
        if wanted[1] {
            let values = horner(p.gradient.coefficients().iter().copied(), &t).map(|v| c * (p.scale * v));
            add(gradient, &values, &inside);
        }
        if wanted[2] {
            let values = horner(p.density.coefficients().iter().copied(), &t).map(|v| c * (p.scale * v));
            add(laplacian, &values, &inside);
        }
    }
    // Outside: the bare law, whose Laplacian is zero.
    if wanted[0] {
        let values = match D {
            2 => each(r, &outside, |r| c * Law::Newtonian.bare::<T, D>(r)[0]),
            _ => r.map(|r| c * Law::Newtonian.bare::<T, D>(r)[0]),
        };
        add(value, &values, &outside);
    }
    if wanted[1] {
        let values = r.map(|r| {
            let per_r = T::ONE / r;
            c * match D {
                1 => T::HALF * per_r,
                2 => T::HALF / T::PI * per_r * per_r,
                _ => T::from_f64(0.25) / T::PI * per_r * per_r * per_r,
            }
        });
        add(gradient, &values, &outside);
    }
}

#[inline(always)]
fn add_part<T: Real, const D: usize>(
    part: &Part<T>,
    tables: &[f64],
    r: &Lanes<T>,
    wanted: [bool; 3],
    sums: &mut [Lanes<T>; 3],
) {
    let mut from = *r;
    if let Outer::Clamped { least } = part.outer {
        from = r.map(|r| r.max(least));
    }
    // Which panel each lane is in; beyond the last it is outside.
    let mut numbers = [0_usize; LANES];
    for index in 0..part.panels {
        let end = part.panel(tables, index).map_or(T::NAN, |panel| panel.end);
        numbers.iter_mut().zip(&from).for_each(|(number, &r)| *number += usize::from(r > end));
    }
    let mut left = [true; LANES];
    while let Some(&number) = numbers.iter().zip(&left).find(|(_, left)| **left).map(|(number, _)| number) {
        let chosen = numbers.map(|n| n == number);
        left.iter_mut().zip(&chosen).for_each(|(left, &chosen)| *left &= !chosen);
        let panel = part.panel(tables, number);
        let inside = number < part.plain;
        let series = |k: usize| match &panel {
            Some(panel) => panel.lanes(tables, part.radius, if inside { &from } else { r }, k),
            None => [T::NAN; LANES],
        };
        let outside = if inside { None } else { Some(Outside::new::<D>(part, r, &chosen, wanted)) };
        for (k, sums) in sums.iter_mut().enumerate().filter(|(k, _)| wanted.get(*k) == Some(&true)) {
            let values = match &outside {
                None => series(k),
                Some(outside) => outside.quantity(r, k, &series),
            };
            add(sums, &values, &chosen);
        }
    }
}

/// What three quantities outside all panels have in common: the expensive functions, once for all of them.
enum Outside<T> {
    /// The quantities themselves, without a series.
    Whole([Lanes<T>; 3]),
    /// r^p, which multiplies the first series, over r^2 the others.
    Power(Lanes<T>),
    /// Added to the first series; the others are divided by r^2.
    Logarithm(Lanes<T>),
    /// Multiplies every series, over r the second.
    Factor(Lanes<T>),
}

impl<T: Real> Outside<T> {
    #[inline(always)]
    fn new<const D: usize>(part: &Part<T>, r: &Lanes<T>, chosen: &Lanes<bool>, wanted: [bool; 3]) -> Self {
        match part.outer {
            Outer::Power { exponent } => Self::Power(powers(r, exponent, chosen)),
            Outer::Log { coefficient } if wanted[0] => Self::Logarithm(each(r, chosen, |r| coefficient * r.log())),
            Outer::Log { .. } => Self::Logarithm([T::ZERO; LANES]),
            Outer::Exponential { k } => Self::Factor(each(r, chosen, |r| (-(k * r)).exp())),
            Outer::Bare { factor } => match part.law {
                Law::Power { exponent } if exponent != 0.0 => {
                    let p = T::from_f64(exponent);
                    let power = powers(r, exponent, chosen);
                    let mut all = [power.map(|v| factor * (v / p)), power, power];
                    let [_, gradient, laplacian] = &mut all;
                    for ((gradient, laplacian), &r) in gradient.iter_mut().zip(laplacian).zip(r) {
                        let per_r = T::ONE / r;
                        let slope = *gradient * per_r * per_r;
                        *gradient = factor * slope;
                        *laplacian = factor * ((p + T::from_usize(D) - T::TWO) * slope);
                    }
                    Self::Whole(all)
                }
                law => Self::one_by_one(r, chosen, |r| law.bare::<T, D>(r).map(|v| factor * v)),
            },
            Outer::Yukawa { .. } | Outer::Zero | Outer::Clamped { .. } => {
                Self::one_by_one(r, chosen, |r| part.without_series(r))
            }
        }
    }

    #[inline(always)]
    fn one_by_one(r: &Lanes<T>, chosen: &Lanes<bool>, function: impl Fn(T) -> [T; 3]) -> Self {
        let mut all = [[T::ZERO; LANES]; 3];
        for (lane, (&r, _)) in r.iter().zip(chosen).enumerate().filter(|(_, (_, chosen))| **chosen) {
            for (values, value) in all.iter_mut().zip(function(r)) {
                values.get_mut(lane).into_iter().for_each(|slot| *slot = value);
            }
        }
        Self::Whole(all)
    }

    /// The k-th quantity.
    #[inline(always)]
    fn quantity(&self, r: &Lanes<T>, k: usize, series: &impl Fn(usize) -> Lanes<T>) -> Lanes<T> {
        let (times, over_square) = (|a: T, b: T| a * b, |v: T, r: T| v / r / r);
        match self {
            Self::Whole(all) => all.get(k).copied().unwrap_or([T::NAN; LANES]),
            Self::Factor(factor) if k == 1 => both(&both(factor, r, |e, r| e / r), &series(k), times),
            Self::Factor(factor) => both(factor, &series(k), times),
            Self::Power(power) if k == 0 => both(power, &series(k), times),
            Self::Power(power) => both(&both(power, r, over_square), &series(k), times),
            Self::Logarithm(logarithm) if k == 0 => both(logarithm, &series(k), |a, b| a + b),
            Self::Logarithm(_) => both(&series(k), r, over_square),
        }
    }
}

impl<T: Real> Panel<T> {
    /// The k-th series of this panel.
    #[inline(always)]
    fn lanes(&self, tables: &[f64], radius: T, r: &Lanes<T>, k: usize) -> Lanes<T> {
        let all = self.coefficients(tables).iter();
        let coefficients = all.map(|c| T::from_f64(c.get(k).copied().unwrap_or(0.0)));
        let variable = r.map(|r| self.variable.at(radius, r, self.root));
        if self.variable.is_power() {
            return horner(coefficients, &variable);
        }
        let x = variable.map(|v| (self.scale * v + self.shift).min(T::ONE).max(-T::ONE));
        clenshaw(coefficients, &x)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RadialKernel, Supplied, Term};
    use super::*;
    use crate::mollifier::Mollifier;
    use std::{vec, vec::Vec};

    /// e^{-r^2}, whose Laplacian depends on the dimension: it need not be right here.
    struct Host;

    impl RadialKernel for Host {
        fn at(&self, r: f64) -> [f64; 3] {
            let e = (-r * r).exp();
            [e, -2.0 * e, (4.0 * r * r - 4.0) * e]
        }
    }

    /// Every law under every kind of mollifier, at distances in all panels, on their ends and at zero, in mixed lanes.
    fn compare<T: Real, const D: usize>() {
        let power = |exponent| Law::Power { exponent };
        let sums: Vec<Vec<Law>> = vec![
            vec![Law::Newtonian],
            vec![power(4.0), power(1.5)],
            vec![power(2.7), Law::Newtonian],
            vec![power(-0.25)],
            vec![power(0.0), power(3.0), Law::Exponential { length: 0.7 }],
            vec![Law::Screened { k: 2.5 }, Law::Exponential { length: 2.0 }, Law::Newtonian],
        ];
        for mollifier in [
            Mollifier::None,
            Mollifier::Compact { order: 2, exponent: 3 },
            Mollifier::Compact { order: 4, exponent: 5 },
            Mollifier::Gaussian { order: 4 },
        ] {
            // There are no Gaussians in three dimensions.
            if mollifier.check(D).is_err() {
                continue;
            }
            for laws in &sums {
                let terms: Vec<Term> =
                    laws.iter().zip([-0.7, 1.3, 0.4]).map(|(&law, coefficient)| Term { law, coefficient }).collect();
                if laws.iter().any(|law| law.check(D).is_err()) {
                    continue;
                }
                // A host's kernel beside the last of them.
                let host = (laws.len() == 1).then_some(Supplied { kernel: &Host, coefficient: 0.9, reach: 2.0 });
                let bytes = Kernel::<T, D>::workspace_bytes_with(&terms, host.is_some(), mollifier).unwrap();
                let mut memory = vec![0_u8; bytes + 64];
                let start = memory.as_ptr().align_offset(64);
                let delta = T::from_f64(0.3);
                let block = &mut memory[start..start + bytes];
                let kernel = Kernel::<T, D>::prepare_with(block, &terms, host, mollifier, delta).unwrap();
                let mut seed = 5_u64;
                let mut distances: Vec<T> = (0..40 * LANES)
                    .map(|_| {
                        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                        let unit = (seed >> 11) as f64 / (1_u64 << 53) as f64;
                        T::from_f64(0.3 * 200.0_f64.powf(unit) / 30.0)
                    })
                    .collect();
                let ends = kernel.parts().iter().flat_map(|part| {
                    let tables = kernel.others.first().map_or(&[][..], |others| others.tables);
                    (0..part.panels).filter_map(move |k| part.panel(tables, k)).map(|panel| T::from_f64(panel.end))
                });
                let zero = if kernel.is_singular() { delta } else { T::ZERO };
                for (k, end) in ends.chain([delta, zero, delta * T::from_f64(1e-3)]).enumerate() {
                    distances[(7 * k) % (40 * LANES)] = end;
                }
                for lanes in distances.as_chunks::<LANES>().0 {
                    for wanted in 1..8 {
                        let wanted = [wanted & 1 != 0, wanted & 2 != 0, wanted & 4 != 0];
                        let got = kernel.pairs(lanes, wanted);
                        for (i, &r) in lanes.iter().enumerate() {
                            let want = kernel.pair(r, wanted);
                            for k in (0..3).filter(|&k| wanted[k]) {
                                assert_eq!(got[k][i].bits(), want[k].bits(), "{D} {laws:?} {mollifier:?} {r} {k}");
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn bits_are_those_of_one_pair_at_a_time() {
        compare::<f64, 1>();
        compare::<f64, 2>();
        compare::<f64, 3>();
        compare::<f32, 2>();
    }
}
