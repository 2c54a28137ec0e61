//! The natural logarithm over lanes, to full precision. The caller performs its division.
//!
//! With x = f 2^e, sqrt(1/2) <= f < sqrt(2), z = f - 1 (exact) and s = z / (2 + z):
//! log x = e log 2 + log(1+s) - log(1-s) = e log 2 + s (2 + s^2 R(s^2)). R is the minimax polynomial of FreeBSD's `e_log.c`
//! (K. C. Ng, 1993; error below 2^-58.45 on |s| < 0.1716), in f32 of `e_logf.c` (below 2^-34.24).

use super::lanes::Isa;
use crate::scalar::Scalar;

// The bits of 0.666..., 0.399..., ...; lowest power first.
const SERIES_F64: [u64; 7] = [
    0x3FE5_5555_5555_5593,
    0x3FD9_9999_9997_FA04,
    0x3FD2_4924_9422_9359,
    0x3FCC_71C5_1D8E_78AF,
    0x3FC7_4664_96CB_03DE,
    0x3FC3_9A09_D078_C69F,
    0x3FC2_F112_DF3E_5244,
];
const SERIES_F32: [f64; 4] = [0.66666662693, 0.40000972152, 0.28498786688, 0.24279078841];

/// (z, e) with x = (1 + z) 2^e: the part of the logarithm before its division.
#[inline(always)]
pub(crate) fn log_numerator<T: Scalar, I: Isa<T>>(isa: I, x: I::V) -> (I::V, I::V) {
    let (f, e) = isa.split(x);
    (isa.sub(f, isa.splat(T::ONE)), e)
}

/// log((1 + z) 2^e), given s = z / (2 + z) with an error of k u. The error is (k + 3) u, relative even near x = 1,
/// where e = 0.
#[inline(always)]
pub(crate) fn log<T: Scalar, I: Isa<T>, const N: usize>(isa: I, e: [I::V; N], s: [I::V; N]) -> [I::V; N] {
    let w = product(isa, &s, &s);
    // Estrin's scheme, because the time of a sum of logarithms is bound by the chain of dependent operations, not by their number.
    let square = product(isa, &w, &w);
    let r = if T::DIGITS > 24 {
        let [a, b, c, d, e, f, g] = SERIES_F64;
        let number = |bits| [isa.splat(T::from_f64(f64::from_bits(bits))); N];
        let first = join(isa, &number(b), &w, &number(a));
        let second = join(isa, &number(d), &w, &number(c));
        let third = join(isa, &number(f), &w, &number(e));
        let third = join(isa, &number(g), &square, &third);
        let first = join(isa, &second, &square, &first);
        join(isa, &third, &product(isa, &square, &square), &first)
    } else {
        let [a, b, c, d] = SERIES_F32;
        let number = |c| [isa.splat(T::from_f64(c)); N];
        let first = join(isa, &number(b), &w, &number(a));
        let second = join(isa, &number(d), &w, &number(c));
        join(isa, &second, &square, &first)
    };
    let part = product(isa, &s, &join(isa, &r, &w, &[isa.splat(T::TWO); N]));
    join(isa, &e, &[isa.splat(T::from_f64(core::f64::consts::LN_2)); N], &part)
}

/// log x, of which something is added to the binary exponent.
#[inline(always)]
pub(crate) fn log_of<T: Scalar, I: Isa<T>>(isa: I, x: I::V, exponent: I::V) -> I::V {
    let (z, e) = log_numerator(isa, x);
    let [log] = log(isa, [isa.add(e, exponent)], [isa.div(z, isa.add(isa.splat(T::TWO), z))]);
    log
}

/// a b + c.
#[inline(always)]
fn join<T: Scalar, I: Isa<T>, const N: usize>(isa: I, a: &[I::V; N], b: &[I::V; N], c: &[I::V; N]) -> [I::V; N] {
    let mut sums = *c;
    for ((sum, &a), &b) in sums.iter_mut().zip(a).zip(b) {
        *sum = isa.mul_add(a, b, *sum);
    }
    sums
}

#[inline(always)]
fn product<T: Scalar, I: Isa<T>, const N: usize>(isa: I, a: &[I::V; N], b: &[I::V; N]) -> [I::V; N] {
    let mut products = *a;
    for (product, &b) in products.iter_mut().zip(b) {
        *product = isa.mul(*product, b);
    }
    products
}
