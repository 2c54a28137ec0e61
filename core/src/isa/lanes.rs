//! What every machine can do: about twenty operations on lanes.

use crate::real::Real;

/// The most lanes of any machine: sixteen f32 in 512 bits.
pub const MAX_LANES: usize =
    if cfg!(all(feature = "small", not(any(target_arch = "x86_64", target_arch = "aarch64")))) { 1 } else { 16 };

/// A machine that works on [`Isa::LANES`] numbers at a time. A value of the type proves that the processor has it.
#[expect(missing_docs, reason = "the arithmetic operations are named after what they do, lane by lane")]
pub trait Isa<T: Real>: Copy + Send + Sync {
    /// A vector of numbers.
    type V: Copy;
    /// A vector of truth values.
    type M: Copy;
    /// Numbers in a vector.
    const LANES: usize;
    /// Vectors that the machine holds at a time: how many targets a loop keeps.
    const REGISTERS: usize;
    /// Terms of the series that turns [`Isa::root_seed`] into 1/sqrt; 0 where the seed is already that.
    const ROOT_TERMS: usize;

    /// `a` in every lane.
    fn splat(self, a: T) -> Self::V;
    /// The first [`Isa::LANES`] numbers.
    fn load(self, from: &[T; MAX_LANES]) -> Self::V;
    /// The numbers, then zeros.
    fn store(self, a: Self::V) -> [T; MAX_LANES];
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    /// |a|.
    fn abs(self, a: Self::V) -> Self::V;
    /// a b + c, fused where the machine can.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c - a b, fused where the machine can.
    fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// a < b.
    fn lt(self, a: Self::V, b: Self::V) -> Self::M;
    /// `yes` where `m`, else `no`.
    fn select(self, m: Self::M, yes: Self::V, no: Self::V) -> Self::V;
    /// One bit a lane, lane 0 lowest.
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

    /// Approximately 1/sqrt(a), for a in 2^-120..2^120 (f32: 2^-100..2^100): `1 - a seed^2` is so small that the series
    /// of [`Isa::ROOT_TERMS`] terms in it reaches full precision.
    fn root_seed(self, a: Self::V) -> Self::V;

    /// m / a for each a, to two or three ulp: with fewer divisions than vectors where that is faster. Products of four
    /// of the a, and m over them, must stay in the normal range.
    fn quotients<const N: usize>(self, m: Self::V, a: [Self::V; N]) -> [Self::V; N];

    /// (f, e) with a = f 2^e, sqrt(1/2) <= f < sqrt(2) to rounding, e a whole number; a is positive and normal.
    fn split(self, a: Self::V) -> (Self::V, Self::V);
}

/// An algorithm over lanes, to be run on a machine that is chosen at run time.
pub trait Job<T: Real> {
    /// What it returns.
    type Out;
    /// The algorithm; `#[inline(always)]` in every implementation.
    fn run<I: Isa<T>>(self, isa: I) -> Self::Out;
}

/// m / a with one division for each two vectors: m / (a b) times b, and times a.
///
/// Errors: the product, the quotient and the last product round once each, so 3 u instead of 1 u.
#[inline(always)]
pub(super) fn paired_quotients<T: Real, I: Isa<T>, const N: usize>(isa: I, m: I::V, a: [I::V; N]) -> [I::V; N] {
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
