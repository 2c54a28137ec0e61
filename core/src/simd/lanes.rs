//! The operations that every instruction set provides: about twenty, on lanes.

use super::rows::{ROW, Rows};
use crate::scalar::Scalar;

/// The largest number of lanes of any instruction set.
pub use super::vectors::MAX_LANES;

/// A part of an algorithm, for [`Isa::apart`].
pub trait Part<T: Scalar, I: Isa<T>> {
    /// What it returns.
    type Out;

    /// The part. To be `#[inline(always)]`.
    fn run(self, isa: I) -> Self::Out;
}

/// Some numbers that stand together in memory: those of a vector.
pub trait Row<T>: Copy {
    /// Numbers as rows, without those that fill none.
    fn of(numbers: &[T]) -> &[Self];
    /// The same.
    fn of_mut(numbers: &mut [T]) -> &mut [Self];
    /// The numbers of rows.
    fn numbers(rows: &[Self]) -> &[T];
}

impl<T: Copy, const N: usize> Row<T> for [T; N] {
    #[inline(always)]
    fn of(numbers: &[T]) -> &[Self] {
        numbers.as_chunks().0
    }

    #[inline(always)]
    fn of_mut(numbers: &mut [T]) -> &mut [Self] {
        numbers.as_chunks_mut().0
    }

    #[inline(always)]
    fn numbers(rows: &[Self]) -> &[T] {
        rows.as_flattened()
    }
}

/// An instruction set that works on [`Isa::LANES`] numbers at a time. A value of the type proves that the processor has it.
#[expect(missing_docs, reason = "the arithmetic operations are named after what they do, lane by lane")]
pub trait Isa<T: Scalar>: Copy + Send + Sync {
    /// A vector of numbers.
    type V: Copy;
    /// A vector of truth values.
    type M: Copy;
    /// Row numbers, one per lane.
    type R: Copy;
    /// The numbers of a vector in memory.
    type Row: Row<T>;
    /// Numbers in a vector.
    const LANES: usize;
    /// Whether a lane's sum must not depend on other lanes, including the order of the additions. The bits then do not
    /// depend on the number of lanes.
    const IN_ORDER: bool = false;

    /// Runs the algorithm on as many vectors of targets at a time as the registers can hold: two with 16 registers, four with 32; one
    /// in portable code.
    fn in_blocks<J: BlockJob<T>>(self, job: J) -> J::Out;

    /// Runs a part of an algorithm as a function of its own with these instructions, so that a loop that needs all registers has them.
    #[inline(never)]
    fn apart<P: Part<T, Self>>(self, part: P) -> P::Out {
        part.run(self)
    }

    /// `a` in every lane.
    fn splat(self, a: T) -> Self::V;
    /// The first [`Isa::LANES`] numbers.
    fn load(self, from: &[T; MAX_LANES]) -> Self::V;
    /// The numbers, padded with zeros.
    fn store(self, a: Self::V) -> [T; MAX_LANES];
    /// All numbers of a row.
    fn load_row(self, from: &Self::Row) -> Self::V;
    /// The numbers as a row.
    fn store_row(self, a: Self::V) -> Self::Row;
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    /// |a|.
    fn abs(self, a: Self::V) -> Self::V;
    /// a b + c, fused if the instruction set can.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c - a b, fused if the instruction set can.
    fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// a < b.
    fn lt(self, a: Self::V, b: Self::V) -> Self::M;
    /// `yes` where `m`, else `no`.
    fn select(self, m: Self::M, yes: Self::V, no: Self::V) -> Self::V;
    /// One bit per lane; lane 0 is the lowest.
    fn bits(self, m: Self::M) -> u32;

    /// Whether any lane is true.
    #[inline(always)]
    fn any(self, m: Self::M) -> bool {
        self.bits(m) != 0
    }

    /// Whether any lane of any of the vectors is below the bound. Neither may be NaN.
    fn any_below<const N: usize>(self, a: &[Self::V; N], bound: Self::V) -> bool;

    /// Whether every lane of every vector is below the bound. Neither may be NaN.
    fn all_below<const N: usize>(self, a: &[Self::V; N], bound: Self::V) -> bool;

    /// 1 / sqrt(a) for each a, to four ulp, for a in 2^-120..2^120 (f32: 2^-56..2^56).
    #[inline(always)]
    fn inverse_roots<const N: usize>(self, a: [Self::V; N]) -> [Self::V; N] {
        let mut roots = a;
        roots.iter_mut().for_each(|a| *a = self.sqrt(*a));
        self.quotients(self.splat(T::ONE), roots)
    }

    /// m / a^(3/2) for each a, to six ulp, in the same range.
    #[inline(always)]
    fn over_cubed_roots<const N: usize>(self, m: Self::V, a: [Self::V; N]) -> [Self::V; N] {
        let mut cubes = a;
        cubes.iter_mut().for_each(|a| *a = self.mul(*a, self.sqrt(*a)));
        if T::DIGITS > 24 {
            return self.quotients(m, cubes);
        }
        // In f32 the product of two cubes would leave the range, so each has its own division.
        cubes.iter_mut().for_each(|a| *a = self.div(m, *a));
        cubes
    }

    /// m / a for each a, to two or three ulp, with fewer divisions than vectors where that is faster. Products of four
    /// of the a, and m divided by them, must be in the normal range.
    fn quotients<const N: usize>(self, m: Self::V, a: [Self::V; N]) -> [Self::V; N];

    /// The row of each lane in a table ([`Rows`]), and the least argument of that row. The lanes are positive and normal.
    fn rows(self, u: Self::V) -> (Self::R, Self::V);

    /// The numbers of each lane's row: vector n holds number n of every lane's row.
    fn look_up(self, table: &Rows<T>, rows: Self::R) -> [Self::V; ROW];

    /// The columns of some rows, one a lane: vector n holds number n of every lane's row. Rows beyond the last lane are not looked at.
    #[inline(always)]
    fn columns(self, rows: &[&[T; ROW]; MAX_LANES]) -> [Self::V; ROW] {
        let mut columns = [[T::ZERO; MAX_LANES]; ROW];
        for (lane, row) in rows.iter().enumerate().take(Self::LANES) {
            for (column, &number) in columns.iter_mut().zip(*row) {
                column.get_mut(lane).into_iter().for_each(|slot| *slot = number);
            }
        }
        let mut vectors = [self.splat(T::ZERO); ROW];
        for (vector, column) in vectors.iter_mut().zip(&columns) {
            *vector = self.load(column);
        }
        vectors
    }

    /// (f, e) with a = f 2^e, sqrt(1/2) <= f < sqrt(2) to rounding, e an integer. a is positive and normal.
    fn split(self, a: Self::V) -> (Self::V, Self::V);
}

/// An algorithm over lanes, run with an instruction set that is selected at run time.
pub trait Job<T: Scalar> {
    /// The return type.
    type Out;
    /// The algorithm. Must be `#[inline(always)]` in every implementation.
    fn run<I: Isa<T>>(self, isa: I) -> Self::Out;
}

/// An algorithm over blocks of vectors. The instruction set determines the number of vectors.
pub trait BlockJob<T: Scalar> {
    /// The return type.
    type Out;
    /// The algorithm for `N` vectors at a time. Must be `#[inline(always)]` in every implementation.
    fn run<I: Isa<T>, const N: usize>(self, isa: I) -> Self::Out;
}

/// m / a with one division per two vectors: m / (a b) times b, and times a.
///
/// Errors: the product, the quotient and the last product round once each, so 3 u instead of 1 u.
#[inline(always)]
pub(super) fn paired_quotients<T: Scalar, I: Isa<T>, const N: usize>(isa: I, m: I::V, a: [I::V; N]) -> [I::V; N] {
    let mut result = a;
    let (pairs, rest) = result.as_chunks_mut::<2>();
    for [first, second] in pairs {
        let both = isa.div(m, isa.mul(*first, *second));
        (*first, *second) = (isa.mul(both, *second), isa.mul(both, *first));
    }
    for one in rest {
        *one = isa.div(m, *one);
    }
    result
}

/// m / a with one division per four vectors.
///
/// Errors: two products, the quotient and two more products round once each, so 5 u instead of 1 u.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn fourfold_quotients<T: Scalar, I: Isa<T>, const N: usize>(isa: I, m: I::V, a: [I::V; N]) -> [I::V; N] {
    let mut result = a;
    let (fours, _) = result.as_chunks_mut::<4>();
    for [a, b, c, d] in fours {
        let (ab, cd) = (isa.mul(*a, *b), isa.mul(*c, *d));
        let all = isa.div(m, isa.mul(ab, cd));
        let (of_ab, of_cd) = (isa.mul(all, cd), isa.mul(all, ab));
        (*a, *b, *c, *d) = (isa.mul(of_ab, *b), isa.mul(of_ab, *a), isa.mul(of_cd, *d), isa.mul(of_cd, *c));
    }
    result
}

/// (1 - e)^-a, truncated after `TERMS` powers of e. For a seed y of 1/sqrt(x) and e = 1 - x y^2, x^-a = y^(2a) (1 - e)^-a.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn root_series<T: Scalar, I: Isa<T>, const TERMS: usize>(isa: I, e: I::V, a: f64) -> I::V {
    // (a)_k / k!
    let mut coefficients = [1.0_f64; 6];
    let mut last = 1.0;
    for (k, c) in coefficients.iter_mut().enumerate().skip(1) {
        last *= (a + (k as f64 - 1.0)) / k as f64;
        *c = last;
    }
    let mut sum = isa.splat(T::ZERO);
    for (k, &c) in coefficients.iter().enumerate().rev() {
        if k == TERMS {
            sum = isa.splat(T::from_f64(c));
        } else if k < TERMS {
            sum = isa.mul_add(sum, e, isa.splat(T::from_f64(c)));
        }
    }
    sum
}

/// [`Isa::inverse_roots`] from a seed.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn seeded_root<T: Scalar, I: Isa<T>, const TERMS: usize>(isa: I, a: I::V, seed: I::V) -> I::V {
    let e = isa.neg_mul_add(a, isa.mul(seed, seed), isa.splat(T::ONE));
    isa.mul(seed, root_series::<T, I, TERMS>(isa, e, 0.5))
}

/// One quotient of [`Isa::over_cubed_roots`] from a seed.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn seeded_over_cube<T: Scalar, I: Isa<T>, const TERMS: usize>(isa: I, m: I::V, a: I::V, seed: I::V) -> I::V {
    let square = isa.mul(seed, seed);
    let e = isa.neg_mul_add(a, square, isa.splat(T::ONE));
    isa.mul(isa.mul(isa.mul(m, seed), square), root_series::<T, I, TERMS>(isa, e, 1.5))
}
