//! A kernel given only by its functions, which are called for every pair.
//!
//! Values carry a separate binary exponent ([`Extended`]). Lanes take them divided by powers of two, those of the largest distance; where one of a
//! pair's three numbers is far from 1 even so, the pair is left out and summed in true units.

use super::lanes::{Deferred, Group, HESSIANS, POTENTIALS, Want, distances};
use super::output::{Contribution, Scales};
use super::packed::{Units, least_square_exponent, power_of_two};
use super::{Block, PairKernel, Passes};
use crate::checked::Present;
use crate::exec::Statistics;
use crate::field::{PairRadius, Wanted};
use crate::real::{Extended, Real, Scalar, length};
use crate::simd::{Isa, MAX_LANES};

/// A kernel as a function of the distance alone, in double precision: a value beyond single precision, times a small mass, may be within.
pub(in crate::field) trait Radial: Sync {
    /// [`crate::field::Interaction::pair_wide`], which may leave the range of double precision where the kernel's laws are known.
    fn pair(&self, r: f64, wanted: Wanted) -> [Extended; 3];
    /// [`crate::field::Interaction::is_singular`].
    fn is_singular(&self) -> bool;
}

/// A kernel that is called. c is that of its own functions plus 8: 3 for r, 5 for products and sums.
pub(in crate::field) struct Called<'a>(pub &'a dyn Radial);

/// The kernel in units.
pub(in crate::field) struct Prepared<'a, T> {
    kernel: &'a dyn Radial,
    /// A true length is one in units times 2^this.
    exponent: i32,
    /// Value, gradient factor and Laplacian are divided by 2^this, so that they are in range.
    sizes: [i32; 3],
    /// Pairs with r^2 below this, in units, are left out.
    least: T,
}

/// Pairs are left out where an exponent, less its size, is not between these: products with masses in units then stay in range, and normal but for
/// masses below 2^-36 of the largest at f32's lower limit.
const fn limits<T: Real>() -> (i32, i32) {
    if T::DIGITS > 24 { (-120, 900) } else { (-90, 90) }
}

impl<T: Real> Prepared<'_, T> {
    /// The numbers of a pair at this r^2 in units, in the lanes' units; None where it is left out. It does not depend on what is wanted.
    #[inline]
    fn numbers(&self, r2: T) -> Option<[T; 3]> {
        if r2 < self.least {
            return None;
        }
        let (least, most) = limits::<T>();
        let mut numbers = [T::ZERO; 3];
        let all = self.kernel.pair(r2.to_f64().sqrt().ldexp(self.exponent), ALL);
        for ((to, number), size) in numbers.iter_mut().zip(all).zip(self.sizes) {
            if number.exponent().is_some_and(|exponent| !(least..=most).contains(&exponent.saturating_sub(size))) {
                return None;
            }
            *to = T::from_f64(number.in_units(size));
        }
        Some(numbers)
    }
}

const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };

impl<'a, T: Real, const D: usize> PairKernel<T, D> for Called<'a> {
    type Prepared = Prepared<'a, T>;
    type Lanes<V: Copy> = V;

    const PASSES: Passes = Passes::One;
    const SCALAR: bool = true;

    fn length(&self) -> T {
        T::ZERO
    }

    fn prepare(&self, units: Units<T>, _rule: PairRadius, _potentials: bool) -> Self::Prepared {
        let least = power_of_two(-least_square_exponent::<T>());
        Prepared { kernel: self.0, exponent: -units.position, sizes: self.sizes::<T>(-units.position), least }
    }

    fn scales(&self, units: Units<T>, class: usize) -> Scales<T> {
        // The kernel answers in true units; masses and the d of a gradient are in units, and d is source minus target.
        let mass = -units.class(class);
        let [value, factor, laplacian] = self.sizes::<T>(-units.position);
        Scales {
            potential: (T::ONE, mass + value),
            gradient: (-T::ONE, mass + factor - units.position),
            laplacian: (T::ONE, mass + laplacian),
        }
    }

    fn lanes<I: Isa<T>>(prepared: &Self::Prepared, isa: I) -> I::V {
        isa.splat(prepared.least)
    }

    #[inline(always)]
    fn add_block<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        (prepared, &least): (&Self::Prepared, &I::V),
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        [noted, _]: &mut [Deferred; 2],
        _counts: &mut Statistics,
    ) {
        if P == HESSIANS {
            // Gradient factor and Laplacian have units of their own here, so they meet in [`PairKernel::exact`].
            (0..block.sources.0.len()).for_each(|at| noted.push(at));
            return;
        }
        for (at, (x, &m)) in block.sources.0.iter().zip(block.sources.1).enumerate() {
            let (d, r2) = distances(isa, x, groups);
            let mass = isa.splat(m);
            let mut left_out = isa.any_below(&r2, least);
            for (v, ((group, d), &r2)) in groups.iter_mut().zip(&d).zip(&r2).enumerate() {
                let valid = block.valid.get(v).copied().unwrap_or(0);
                let (mut values, mut factors, mut laplacians) =
                    ([T::ZERO; MAX_LANES], [T::ZERO; MAX_LANES], [T::ZERO; MAX_LANES]);
                let slots = values.iter_mut().zip(&mut factors).zip(&mut laplacians);
                for (lane, (r2, ((value, factor), laplacian))) in isa.store(r2).into_iter().zip(slots).enumerate() {
                    if valid >> lane & 1 == 1 {
                        match prepared.numbers(r2) {
                            Some(numbers) => [*value, *factor, *laplacian] = numbers,
                            None => left_out = true,
                        }
                    }
                }
                if P == POTENTIALS && block.potential {
                    group.add_potential(isa, mass, isa.load(&values));
                }
                group.add_gradient::<_, _, P>(isa, isa.mul(mass, isa.load(&factors)), d);
                if block.laplacian {
                    group.add_laplacian::<_, _, P>(isa, mass, isa.load(&laplacians), d);
                }
            }
            if left_out {
                noted.push(at);
            }
        }
    }

    #[inline(always)]
    fn left_out<I: Isa<T>, const NB: usize, const P: u8>(
        isa: I,
        (prepared, _): (&Self::Prepared, &I::V),
        (source, _): (&[T; D], Option<&T>),
        groups: &[Group<I::V, D>; NB],
        _laplacian: bool,
    ) -> [u32; NB] {
        if P == HESSIANS {
            return [u32::MAX; NB];
        }
        distances(isa, source, groups).1.map(|r2| {
            let lanes = isa.store(r2).into_iter().take(I::LANES).enumerate();
            lanes.fold(0, |bits, (lane, r2)| bits | u32::from(prepared.numbers(r2).is_none()) << lane)
        })
    }

    fn exact(&self, x: &[T; D], mass: T, _radius: Option<T>, want: Want) -> Contribution<T, D> {
        pair(self.0, x, mass, want)
    }
}

impl Called<'_> {
    /// The exponents of value, gradient factor and Laplacian at the largest distance, or more where those at the least one would not fit.
    fn sizes<T: Real>(&self, exponent: i32) -> [i32; 3] {
        let at = |exponent: i32| self.0.pair(1.0_f64.ldexp(exponent), ALL).map(Extended::exponent);
        let least = exponent.saturating_sub(least_square_exponent::<T>() / 2);
        let (_, most) = limits::<T>();
        let mut sizes = [0; 3];
        for (size, (far, near)) in sizes.iter_mut().zip(at(exponent).into_iter().zip(at(least))) {
            let near = near.map(|near| near.saturating_sub(most));
            *size = far.max(near).unwrap_or(0);
        }
        sizes
    }
}

/// One pair, from its distance without overflow or underflow.
pub(super) fn pair<T: Real, const D: usize>(
    kernel: &dyn Radial,
    x: &[T; D],
    mass: T,
    want: Want,
) -> Contribution<T, D> {
    let x = x.map(T::to_f64);
    let r = length(&x);
    let mut sums = Contribution::ZERO;
    if r == 0.0 && kernel.is_singular() {
        return sums;
    }
    let Want { potential, gradient, laplacian, row } = want;
    let wanted = Wanted { potential, gradient, laplacian, hessian: false };
    let mass = Extended::new(mass.to_f64(), 0);
    let [value, factor, of_laplacian] = kernel.pair(r, wanted).map(|number| number.times(mass));
    if potential {
        sums.potential = T::from_f64(value.get());
    }
    if let Some(row) = row.get() {
        // As lanes do: (L - D g) (x x^T / r^2 - I / D), and zero at x = 0. Where the Laplacian alone was left out, g is there already.
        let zero = |wanted: bool, number| if wanted { number } else { Extended::ZERO };
        let c = zero(laplacian, of_laplacian).plus(zero(gradient, factor).scale(-(D as f64)));
        let unit = if r > 0.0 { x.map(|x| x / r) } else { [0.0; D] };
        let along = unit.get(row).copied().present_or(0.0);
        for (k, (sum, &x)) in sums.gradient.iter_mut().zip(&unit).enumerate() {
            let trace = if k == row && r > 0.0 { 1.0 / D as f64 } else { 0.0 };
            *sum = T::from_f64(c.scale(along * x - trace).get());
        }
    } else if gradient {
        sums.gradient.iter_mut().zip(x).for_each(|(sum, x)| *sum = T::from_f64(factor.scale(x).get()));
    }
    if laplacian {
        sums.laplacian = T::from_f64(of_laplacian.get());
    }
    sums
}
