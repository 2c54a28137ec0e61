//! The natural logarithm over lanes, to full precision.
//!
//! With x = f 2^e, sqrt(1/2) <= f < sqrt(2), z = f - 1 (exact) and s = z / (2 + z):
//! log f = log(1+s) - log(1-s) = 2s + s R(s^2), and, since 2s = z - s z and so that the rounding of s matters little,
//! log f = z - (z^2/2 - s (z^2/2 + R)). R is the minimax polynomial of FreeBSD's `e_log.c` (K. C. Ng, 1993; error below
//! 2^-58.45 on |s| < 0.1716) and of `e_logf.c` in f32 (below 2^-34.24).

use super::lanes::Isa;
use crate::real::Real;

const SERIES_F64: [f64; 7] = [
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860511658591e-01,
];
const SERIES_F32: [f64; 4] = [0.66666662693, 0.40000972152, 0.28498786688, 0.24279078841];

/// (z, e) with x = (1 + z) 2^e: the part of the logarithm that comes before its division.
#[inline(always)]
pub(crate) fn log_numerator<T: Real, I: Isa<T>>(isa: I, x: I::V) -> (I::V, I::V) {
    let (f, e) = isa.split(x);
    (isa.sub(f, isa.splat(T::ONE)), e)
}

/// log((1 + z) 2^e), given s = z / (2 + z) to a few ulp. Error: 1 ulp, and 1 ulp more where the two parts cancel; relative
/// even at x = 1, where e = 0.
#[inline(always)]
pub(crate) fn log<T: Real, I: Isa<T>>(isa: I, z: I::V, e: I::V, s: I::V) -> I::V {
    let constant = |x: f64| isa.splat(T::from_f64(x));
    let series: &[f64] = if T::DIGITS > 24 { &SERIES_F64 } else { &SERIES_F32 };
    let w = isa.mul(s, s);
    let mut r = isa.splat(T::ZERO);
    for &c in series.iter().rev() {
        r = isa.mul_add(r, w, constant(c));
    }
    r = isa.mul(r, w);
    let half_square = isa.mul(isa.mul(constant(0.5), z), z);
    // ln 2 = high + low; e times the high part is exact, which has 11 (f32: 9) zero bits at its end.
    let (high, low) = if T::DIGITS > 24 {
        (6.931_471_803_691_238_164_90e-01, 1.908_214_929_270_587_700_02e-10)
    } else {
        (6.931_381_225_6e-01, 9.058_000_614_5e-06)
    };
    let correction = isa.mul_add(s, isa.add(half_square, r), isa.mul(e, constant(low)));
    isa.mul_add(e, constant(high), isa.sub(z, isa.sub(half_square, correction)))
}
