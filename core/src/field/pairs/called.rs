//! A kernel that is known by its functions alone: they are called for every pair.

use super::exact::product;
use super::lanes::{Group, Noted, Want, distances};
use super::output::{Contribution, Scales};
use super::packed::{Units, least_square_exponent, power_of_two};
use super::{Block, PairKernel};
use crate::exec::Statistics;
use crate::field::Wanted;
use crate::real::{Real, Scalar, length};
use crate::simd::{Isa, MAX_LANES};

/// A kernel as a function of the distance alone, in double precision: a value beyond single precision, times a small mass, may be within.
pub(in crate::field) trait Radial: Sync {
    /// [`crate::field::Interaction::pair_wide`].
    fn pair(&self, r: f64, wanted: Wanted) -> [f64; 3];
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

impl<'a, T: Real, const D: usize> PairKernel<T, D> for Called<'a> {
    type Prepared = Prepared<'a, T>;
    type Lanes<V: Copy> = V;

    const TOGETHER: bool = true;
    const SCALAR: bool = true;

    fn length(&self) -> T {
        T::ZERO
    }

    fn prepare(&self, units: Units<T>) -> Self::Prepared {
        let least = power_of_two(-least_square_exponent::<T>());
        Prepared { kernel: self.0, exponent: -units.position, sizes: self.sizes(-units.position), least }
    }

    fn scales(&self, units: Units<T>, class: usize) -> Scales<T> {
        // The kernel answers in true units; masses and the d of a gradient are in units, and d is source minus target.
        let mass = -units.class(class);
        let [value, factor, laplacian] = self.sizes(-units.position);
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
    fn add_block<I: Isa<T>, const NB: usize, const P: bool>(
        isa: I,
        (prepared, &least): (&Self::Prepared, &I::V),
        block: &Block<'_, T, D>,
        groups: &mut [Group<I::V, D>; NB],
        [noted, _]: &mut [Noted; 2],
        _counts: &mut Statistics,
    ) {
        let wanted = Wanted { potential: P, gradient: true, laplacian: block.laplacian };
        for (at, (x, &m)) in block.sources.0.iter().zip(block.sources.1).enumerate() {
            let (d, r2) = distances(isa, x, groups);
            let mass = isa.splat(m);
            if isa.any_below(&r2, least) {
                noted.push(at);
            }
            for (v, ((group, d), &r2)) in groups.iter_mut().zip(&d).zip(&r2).enumerate() {
                let near = isa.bits(isa.lt(r2, least));
                let valid = block.valid.get(v).copied().unwrap_or(0) & !near;
                let (mut values, mut factors, mut laplacians) =
                    ([T::ZERO; MAX_LANES], [T::ZERO; MAX_LANES], [T::ZERO; MAX_LANES]);
                let slots = values.iter_mut().zip(&mut factors).zip(&mut laplacians);
                for (lane, (r2, ((value, factor), laplacian))) in isa.store(r2).into_iter().zip(slots).enumerate() {
                    if valid >> lane & 1 == 1 {
                        let r = r2.to_f64().sqrt().ldexp(prepared.exponent);
                        let numbers = prepared.kernel.pair(r, wanted);
                        for (to, (number, size)) in
                            [value, factor, laplacian].into_iter().zip(numbers.into_iter().zip(prepared.sizes))
                        {
                            *to = T::from_f64(number.ldexp(-size));
                        }
                    }
                }
                if P {
                    group.add_potential(isa, mass, isa.load(&values));
                }
                group.add_gradient(isa, isa.mul(mass, isa.load(&factors)), d);
                if block.laplacian {
                    group.add_laplacian(isa, mass, isa.load(&laplacians));
                }
            }
        }
    }

    #[inline(always)]
    fn left_out<I: Isa<T>, const NB: usize>(
        isa: I,
        (_, &least): (&Self::Prepared, &I::V),
        source: &[T; D],
        groups: &[Group<I::V, D>; NB],
        _laplacian: bool,
    ) -> [u32; NB] {
        distances(isa, source, groups).1.map(|r2| isa.bits(isa.lt(r2, least)))
    }

    fn exact(&self, x: &[T; D], mass: T, want: Want) -> Contribution<T, D> {
        pair(self.0, x, mass, want)
    }
}

impl Called<'_> {
    /// The exponents of value, gradient factor and Laplacian at the largest distance.
    fn sizes(&self, exponent: i32) -> [i32; 3] {
        let all = Wanted { potential: true, gradient: true, laplacian: true };
        let numbers = self.0.pair(1.0_f64.ldexp(exponent), all);
        numbers.map(|number| if number.is_finite() { number.frexp().1 } else { 0 })
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
    let wanted = Wanted { potential: want.potential, gradient: want.gradient, laplacian: want.laplacian };
    let [value, factor, laplacian] = kernel.pair(r, wanted);
    let mass = mass.to_f64();
    if want.potential {
        sums.potential = T::from_f64(mass * value);
    }
    if want.gradient {
        sums.gradient.iter_mut().zip(x).for_each(|(sum, x)| *sum = T::from_f64(product([mass, factor, x])));
    }
    if want.laplacian {
        sums.laplacian = T::from_f64(mass * laplacian);
    }
    sums
}
