//! The Newtonian kernel under an algebraic mollifier: one formula for every pair, without a branch.
//!
//! With q = r2 + delta^2 and e = delta^2 / q in units, S_D = 2, 2 pi, 4 pi, and B(q) the bare kernel's gradient factor at the distance q^(1/2), that is
//! q^(-D/2) ([`outside_gradient`]):
//!
//! | | Plummer | algebraic | Vatistas, w = r2^2 + delta^4 |
//! |---|---|---|---|
//! | S_D g | B(q) | B(q) (1 + D e / 2) | w^(-1/2) |
//! | S_D K | bare at q | 1D, 3D: bare at q times (1 - e / 2), (1 + e / 2); 2D, twice: log q - e | twice: log((r2 + w^(1/2)) / 2) |
//! | S_D psi | D e B(q) | D (D + 2) e^2 B(q) / 2 | 2 delta^4 / w times w^(-1/2) |
//!
//! Each source has its core radius, or all have the kernel's delta. Where delta is below 2^-60 (single precision 2^-28) of the largest coordinate, q may
//! leave the range: lanes closer than that are left out, and computed one by one.
//!
//! # Rounding
//! With u the unit roundoff: r2 has 5 u, q 6 u; B(q) has at most 1.5 times that and 8 u more, the factors in e at most 8 u, the products by d and m 4 u:
//! c = 32. The scale is that of the bare kernel at the distance q^(1/2) (2D: |K| + 1 / (2 pi)), for the density its own value, as long as delta^4 in units
//! is a normal number (test `softenings`).

use super::lanes::{Deferred, Group, POTENTIALS, Want, arms, cores, distances, margins};
use super::newtonian::{exact_pair, newtonian_scales, outside_gradient, outside_potential, passes, wants_potential};
use super::output::{Contribution, Scales};
use super::packed::{Units, least_square_exponent, power_of_two};
use super::{Block, PairKernel, Passes};
use crate::checked::Present;
use crate::exec::Statistics;
use crate::field::PairRadius;
use crate::mollifier::{Blob, Mollifier};
use crate::real::Real;
use crate::simd::{Isa, Part};

/// An algebraic mollifier. Which one is asked for each source, in a branch that is always the same: a loop for each would take three times as long to compile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::field) enum Form {
    /// [`Mollifier::Plummer`].
    Plummer,
    /// [`Mollifier::Algebraic`].
    Algebraic,
    /// [`Mollifier::Vatistas`], in the plane.
    Vatistas,
}

impl Form {
    /// Of a mollifier, if it is an algebraic one of this dimension.
    pub fn of(mollifier: Mollifier, dimension: usize) -> Option<Self> {
        match mollifier {
            Mollifier::Plummer => Some(Self::Plummer),
            Mollifier::Algebraic => Some(Self::Algebraic),
            Mollifier::Vatistas if dimension == 2 => Some(Self::Vatistas),
            _ => None,
        }
    }

    /// Whether it is [`Form::Vatistas`]; outside the plane it never is, which is known while this is compiled.
    #[inline(always)]
    fn is_vatistas<const D: usize>(self) -> bool {
        D == 2 && self == Self::Vatistas
    }

    /// The distances' squares that the other functions take, q or w.
    #[inline(always)]
    fn sums<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
        self,
        isa: I,
        r2: &[I::V; NB],
        squares: &[I::V; NB],
    ) -> [I::V; NB] {
        let mut sums = *r2;
        for (sum, &square) in sums.iter_mut().zip(squares) {
            *sum = if self.is_vatistas::<D>() {
                isa.mul_add(*sum, *sum, isa.mul(square, square))
            } else {
                isa.add(*sum, square)
            };
        }
        sums
    }

    /// m S_D g.
    #[inline(always)]
    fn gradient<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
        self,
        isa: I,
        mass: I::V,
        squares: &[I::V; NB],
        sums: &[I::V; NB],
    ) -> [I::V; NB] {
        if self.is_vatistas::<D>() {
            let mut values = isa.inverse_roots(*sums);
            values.iter_mut().for_each(|value| *value = isa.mul(mass, *value));
            return values;
        }
        let mut values = outside_gradient::<T, I, D, NB>(isa, mass, sums);
        if self == Self::Algebraic {
            let shares = isa.quotients(isa.splat(T::from_usize(D) * T::HALF), *sums);
            for ((value, &share), &square) in values.iter_mut().zip(&shares).zip(squares) {
                *value = isa.mul_add(*value, isa.mul(square, share), *value);
            }
        }
        values
    }

    /// S_D K, twice that in 2D.
    #[inline(always)]
    fn potential<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
        self,
        isa: I,
        log_exponent: I::V,
        squares: &[I::V; NB],
        r2: &[I::V; NB],
        sums: &[I::V; NB],
    ) -> [I::V; NB] {
        let mut values = *sums;
        if D == 1 {
            values.iter_mut().for_each(|root| *root = isa.sqrt(*root));
        } else {
            if self.is_vatistas::<D>() {
                let half = isa.splat(T::HALF);
                for (value, &r2) in values.iter_mut().zip(r2) {
                    *value = isa.mul(half, isa.add(r2, isa.sqrt(*value)));
                }
            }
            values = outside_potential::<T, I, D, NB>(isa, log_exponent, &[[isa.splat(T::ZERO); D]; NB], &values);
        }
        if self == Self::Algebraic {
            for ((value, &q), &square) in values.iter_mut().zip(sums).zip(squares) {
                let share = isa.div(square, q);
                let half = isa.mul(share, isa.splat(T::HALF));
                *value = match D {
                    1 => isa.neg_mul_add(*value, half, *value),
                    2 => isa.sub(*value, share),
                    _ => isa.mul_add(*value, half, *value),
                };
            }
        }
        values
    }

    /// m S_D psi.
    #[inline(always)]
    fn density<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
        self,
        isa: I,
        mass: I::V,
        squares: &[I::V; NB],
        sums: &[I::V; NB],
    ) -> [I::V; NB] {
        if self.is_vatistas::<D>() {
            let mut values = isa.inverse_roots(*sums);
            for ((value, &w), &square) in values.iter_mut().zip(sums).zip(squares) {
                let twice = isa.mul(isa.splat(T::TWO), isa.mul(square, square));
                *value = isa.mul(isa.mul(mass, *value), isa.div(twice, w));
            }
            return values;
        }
        let mut values = outside_gradient::<T, I, D, NB>(isa, mass, sums);
        // D e or D (D + 2) e^2 / 2, as a sum with a zero in it.
        let (once, twice) = match self {
            Self::Algebraic => (T::ZERO, T::from_usize(D * (D + 2)) * T::HALF),
            _ => (T::from_usize(D), T::ZERO),
        };
        let (once, twice) = (isa.splat(once), isa.splat(twice));
        for ((value, &q), &square) in values.iter_mut().zip(sums).zip(squares) {
            let share = isa.div(square, q);
            *value = isa.mul(*value, isa.mul_add(twice, isa.mul(share, share), isa.mul(once, share)));
        }
        values
    }
}

/// A Newtonian kernel under an algebraic mollifier.
pub(in crate::field) struct Smooth<'a, T: Real, const D: usize, const VECTOR: bool> {
    pub blob: &'a Blob<T, D>,
    pub coefficient: T,
    /// The largest core radius: delta, if it is the only one.
    pub largest: T,
    /// Whether each source has its own.
    pub each: bool,
    pub form: Form,
}

/// The kernel in units.
#[derive(Clone, Copy)]
pub(in crate::field) struct Prepared<T> {
    form: Form,
    /// delta^2; not used where every source has its own.
    square: T,
    log_exponent: T,
    /// How sources' core radii become those of pairs.
    rule: PairRadius,
}

/// The least r^2, in units, of lanes under a tiny delta.
fn least<T: Real>() -> T {
    power_of_two(-least_square_exponent::<T>())
}

impl<T: Real, const D: usize, const VECTOR: bool> PairKernel<T, D> for Smooth<'_, T, D, VECTOR> {
    type Prepared = Prepared<T>;
    type Lanes<V: Copy> = [V; 2];

    const PASSES: Passes = passes(D, VECTOR);
    const RADII: bool = !VECTOR;

    fn length(&self) -> T {
        self.largest
    }

    fn prepare(&self, units: Units<T>, rule: PairRadius, _potentials: bool) -> Prepared<T> {
        let square = |delta: T| {
            let delta = delta.ldexp(units.position);
            delta * delta
        };
        let own = if self.each { T::ONE } else { square(self.blob.delta()) };
        let log_exponent = T::from_i32(units.position.saturating_mul(-2));
        Prepared { form: self.form, square: own, log_exponent, rule }
    }

    fn scales(&self, units: Units<T>, class: usize) -> Scales<T> {
        newtonian_scales::<T, D>(self.coefficient, units, class)
    }

    #[inline(always)]
    fn lanes<I: Isa<T>>(prepared: &Prepared<T>, isa: I) -> [I::V; 2] {
        [isa.splat(prepared.square), isa.splat(prepared.log_exponent)]
    }

    #[inline(always)]
    fn add_block<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        (prepared, &[square, log_exponent]): (&Prepared<T>, &[I::V; 2]),
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        [noted, _]: &mut [Deferred; 2],
        _counts: &mut Statistics,
    ) {
        let (form, rule) = (prepared.form, prepared.rule);
        let limit = isa.splat(limit(prepared.square));
        isa.apart(Pairs::<_, _, D, NB, P, VECTOR> { form, rule, square, limit, log_exponent, block, noted, groups });
    }

    #[inline(always)]
    fn left_out<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        (prepared, _): (&Prepared<T>, &[I::V; 2]),
        (source, core): (&[T; D], Option<&T>),
        groups: &[Group<I::V, D>; NB],
        _laplacian: bool,
    ) -> [u32; NB] {
        // Those of a whole source, as the loop has no registers to spare for the choice of lanes.
        let (_, r2) = distances(isa, source, groups);
        let (square, rule) = (core.copied().unwrap_or(prepared.square), prepared.rule);
        let limits = limits(isa, &cores(isa, rule, square, groups));
        if isa.any_below(&margins(isa, &r2, &limits), isa.splat(T::ZERO)) { [u32::MAX; NB] } else { [0; NB] }
    }

    fn exact(&self, x: &[T; D], mass: T, radius: Option<T>, want: Want) -> Contribution<T, D> {
        let blob = radius.map_or(*self.blob, |radius| self.blob.with_delta(radius));
        exact_pair(&blob, [mass, self.coefficient], x, want)
    }
}

/// Lanes of a source with this delta^2 are left out below this.
#[inline(always)]
fn limit<T: Real>(square: T) -> T {
    if square < least() { least() } else { T::ZERO }
}

/// The same of each lane.
#[inline(always)]
fn limits<T: Real, I: Isa<T>, const NB: usize>(isa: I, squares: &[I::V; NB]) -> [I::V; NB] {
    let (mut limits, least, zero) = (*squares, isa.splat(least::<T>()), isa.splat(T::ZERO));
    for limit in &mut limits {
        *limit = isa.select(isa.lt(*limit, least), least, zero);
    }
    limits
}

/// What a block of sources gives to a register block of targets, with potentials if the pass sums them; a function of its own.
struct Pairs<'a, T, V, const D: usize, const NB: usize, const P: u8, const VECTOR: bool> {
    form: Form,
    rule: PairRadius,
    square: V,
    /// [`limit`] of the square.
    limit: V,
    log_exponent: V,
    block: &'a Block<'a, T, D>,
    noted: &'a mut Deferred,
    groups: &'a mut [Group<V, D>; NB],
}

impl<T: Real, I: Isa<T>, const D: usize, const NB: usize, const P: u8, const VECTOR: bool> Part<T, I>
    for Pairs<'_, T, I::V, D, NB, P, VECTOR>
{
    type Out = ();

    #[inline(always)]
    fn run(self, isa: I) {
        let Self { form, rule, square, limit: of_all, log_exponent, block, noted, groups, .. } = self;
        let Block { sources: (positions, masses), cores: of_sources, laplacian, .. } = *block;
        let one = isa.splat(T::ONE);
        let each = !of_sources.is_empty();
        let potential = wants_potential::<D, P>(block.potential);
        let (mut of_sources, mut strengths) = (of_sources.iter(), block.strengths.iter());
        let mut local = *groups;
        for (at, (x, &m)) in positions.iter().zip(masses).enumerate() {
            let (mut d, r2) = distances(isa, x, &local);
            let core = if each { of_sources.next().copied().present_or(T::ZERO) } else { T::ZERO };
            let (mut squares, mut bound) = ([square; NB], of_all);
            if each {
                (squares, bound) = ([isa.splat(core); NB], isa.splat(limit(core)));
            }
            let mut margins = r2;
            if NB == 1 && each {
                squares = cores(isa, rule, core, &local);
                margins = self::margins(isa, &r2, &limits(isa, &squares));
                bound = isa.splat(T::ZERO);
            }
            let mass = isa.splat(m);
            let strength = if VECTOR { strengths.next().copied().present_or([T::ZERO; D]) } else { [T::ZERO; D] };
            if isa.any_below(&margins, bound) {
                noted.push(at);
                continue;
            }
            let sums = form.sums::<T, I, D, NB>(isa, &r2, &squares);
            if potential {
                let values = form.potential::<T, I, D, NB>(isa, log_exponent, &squares, &r2, &sums);
                local.iter_mut().zip(values).for_each(|(group, k)| group.add_potential(isa, mass, k));
            }
            if P != POTENTIALS || D != 2 {
                let factors = form.gradient::<T, I, D, NB>(isa, mass, &squares, &sums);
                if VECTOR {
                    d = arms::<T, I, D, NB, true>(isa, &d, &strength);
                }
                for ((group, d), g) in local.iter_mut().zip(&d).zip(factors) {
                    group.add_gradient::<_, _, P>(isa, g, d);
                }
                if laplacian {
                    let values = form.density::<T, I, D, NB>(isa, mass, &squares, &sums);
                    for ((group, b), d) in local.iter_mut().zip(values).zip(&d) {
                        group.add_laplacian::<_, _, P>(isa, one, b, d);
                    }
                }
            }
        }
        *groups = local;
    }
}
