//! Uniform and normal numbers from random bits, with operations that give the same bits on every machine.
//!
//! The normals are those of Box & Muller (*A note on the generation of random normal deviates*, 1958), exact in distribution. There is no
//! rejection, so word i of the input always belongs to number i of the output, and no branch, so
//! the compiler can vectorise. Logarithm, sine and cosine are FreeBSD msun's polynomials (Sun Microsystems,
//! 1993) of the reduced argument, which is taken directly from the bits.

use crate::build;
use crate::real::Real;
use crate::real::single::{logarithm, series};
use crate::simd::{Level, Loops, with_simd};

/// The bits of 1.0. Or-ed with 52 bits b they give 1 + b 2^-52.
const ONE: u64 = 0x3FF0_0000_0000_0000;
/// The bits of sqrt(1/2), rounded down.
const SQRT_HALF: u64 = 0x3FE6_A09E_667F_3BCC;
const FRACTION: u64 = 0x000F_FFFF_FFFF_FFFF;

/// A uniform number in the open interval (0, 1): an odd multiple of 2^-53 (f64) or 2^-24 (f32), from the high bits of the word.
#[inline(always)]
#[must_use]
pub fn uniform<T: Real>(word: u64) -> T {
    // 52 or 23 bits and a half: exact in T, so the result is neither 0 nor 1.
    let kept = word >> (65 - T::DIGITS);
    T::from_f64(f64::from_bits(ONE | kept << (53 - T::DIGITS)) - 1.0) + T::EPSILON * T::HALF
}

/// (2 k + 1) 2^-53 with k the high 52 bits of the word. The subtraction is exact.
#[inline(always)]
fn open(word: u64) -> f64 {
    f64::from_bits(ONE | word >> 12) - (1.0 - f64::EPSILON / 2.0)
}

/// The number of words that [`normals`] needs for `n` numbers: `n` rounded up to even.
#[must_use]
pub const fn words(n: usize) -> usize {
    n.saturating_add(n % 2)
}

/// Overwrites `out` with independent standard normals from uniform bits. Words 2 i and 2 i + 1 give numbers 2 i and 2 i + 1.
///
/// `bits` holds [`words`]`(out.len())` words; numbers without words are not changed. The distribution is normal up to the granularity of
/// the uniform numbers, 2^-53 in the probability of the radius: |z| <= 8.58, and the distribution function has an error of at most 2^-52.
/// Each number is within 4 units in the last place of the pair's radius of the exact value for the same bits
/// (test `against_the_formula`).
///
/// Cost: about 3 ns a number.
///
/// # Source
/// Box & Muller 1958.
pub fn normals<T: Real>(bits: &[u64], out: &mut [T]) {
    with_simd(Level::best(), Normals { bits, out });
}

struct Normals<'a, T> {
    bits: &'a [u64],
    out: &'a mut [T],
}

impl<T: Real> Loops for Normals<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let (pairs, last) = self.out.as_chunks_mut::<2>();
        let (words, _) = self.bits.as_chunks::<2>();
        for (out, &two) in pairs.iter_mut().zip(words) {
            *out = pair(two);
        }
        if let (Some(last), Some(&two)) = (last.first_mut(), words.get(pairs.len())) {
            let [z, _] = pair(two);
            *last = z;
        }
    }
}

/// Two normals from two words: the radius sqrt(-2 log u) from the first, the direction 2 pi v from the second.
#[inline(always)]
pub(super) fn pair<T: Real>([first, second]: [u64; 2]) -> [T; 2] {
    let radius = (T::from_f64(-2.0) * log(first)).sqrt();
    let [cos, sin] = direction(second);
    [radius * cos, radius * sin]
}

/// As [`pair`] for several pairs, with the same bits. The loops are short, so a processor overlaps several of their iterations. In one long
/// loop the operations would form a chain of dependences.
#[inline(always)]
pub(super) fn pairs<T: Real, const L: usize>([first, second]: [&[u64; L]; 2], out: &mut [[T; 2]; L]) {
    let (mut radius, mut along) = ([T::ZERO; L], [[T::ZERO; L]; 2]);
    for (radius, &word) in radius.iter_mut().zip(first) {
        *radius = T::from_f64(-2.0) * log(word);
    }
    let [cos, sin] = &mut along;
    for ((cos, sin), &word) in cos.iter_mut().zip(sin).zip(second) {
        [*cos, *sin] = direction(word);
    }
    for radius in &mut radius {
        *radius = radius.sqrt();
    }
    let [cos, sin] = &along;
    for (((out, &radius), &cos), &sin) in out.iter_mut().zip(&radius).zip(cos).zip(sin) {
        *out = [radius * cos, radius * sin];
    }
}

/// log u for u = (2 k + 1) 2^-53, k the high 52 bits of the word.
#[inline(always)]
fn log<T: Real>(word: u64) -> T {
    // u = 2^e (1 + f) with sqrt(1/2) <= 1 + f < sqrt(2).
    let (f, e) = if !build::DOUBLE && T::DIGITS <= 24 { split_whole(word) } else { split(word) };
    logarithm(f, e)
}

/// The numbers (f, e) of [`log`].
#[inline(always)]
fn split<T: Real>(word: u64) -> (T, T) {
    let shifted = open(word).to_bits().wrapping_add(ONE - SQRT_HALF);
    // The biased exponent as a number, by or-ing it into the low bits of 2^52.
    let e = f64::from_bits(0x4330_0000_0000_0000 | shifted >> 52) - (4_503_599_627_370_496.0 + 1023.0);
    let f = f64::from_bits((shifted & FRACTION).wrapping_add(SQRT_HALF)) - 1.0;
    (T::from_f64(f), T::from_f64(e))
}

/// As [`split`], without double precision.
#[inline(always)]
fn split_whole<T: Real>(word: u64) -> (T, T) {
    let whole = word >> 12 << 1 | 1;
    let zeros = whole.leading_zeros();
    // 1 + f or 2 (1 + f), in units of 2^-63.
    let scaled = whole << zeros;
    let exponent = T::from_i32(10 - zeros as i32);
    if scaled >> 11 & FRACTION < SQRT_HALF & FRACTION {
        (T::from_i64((scaled ^ 1 << 63) as i64) * T::from_f32(power(-63)), exponent)
    } else {
        // Subtracts 2^64 by reading the word as a signed number.
        (T::from_i64(scaled as i64) * T::from_f32(power(-64)), exponent + T::ONE)
    }
}

/// 2^n, n > -127.
const fn power(n: i32) -> f32 {
    f32::from_bits(((127 + n) as u32) << 23)
}

/// (cos, sin) of 2 pi v, v uniform: two bits select the quadrant, 52 bits the angle from its middle.
#[inline(always)]
fn direction<T: Real>(word: u64) -> [T; 2] {
    let c = T::from_f64;
    // (2 k + 1) 2^-53 - 1/2 of a quarter turn, with one rounding; |x| < pi/4.
    let turn = if !build::DOUBLE && T::DIGITS <= 24 {
        T::from_i64(((word << 2) >> 12 << 1 | 1) as i64 - (1 << 52)) * T::from_f32(power(-53))
    } else {
        c((f64::from_bits(ONE | (word << 2) >> 12) - 1.5) + f64::EPSILON / 2.0)
    };
    let x = turn * (T::PI * T::HALF);
    let z = x * x;
    // msun k_sin.c, k_cos.c; k_sinf.c, k_cosf.c.
    let (sin, cos) = if T::DIGITS > 24 {
        (
            c(-1.666_666_666_666_663_2e-1)
                + z * (c(8.333_333_333_322_49e-3)
                    + z * (c(-1.984_126_982_985_795e-4)
                        + z * (c(2.755_731_370_707_006_8e-6)
                            + z * (c(-2.505_076_025_340_686_3e-8) + z * c(1.589_690_995_211_55e-10))))),
            c(4.166_666_666_666_66e-2)
                + z * (c(-1.388_888_888_887_411e-3)
                    + z * (c(2.480_158_728_947_673e-5)
                        + z * (c(-2.755_731_435_139_066_3e-7)
                            + z * (c(2.087_572_321_298_175e-9) + z * c(-1.135_964_755_778_819_5e-11))))),
        )
    } else {
        (
            series(&[2.718_311_5e-6, -1.983_933_5e-4, 8.333_329e-3, -1.666_666_6e-1], z),
            series(&[2.439_044_9e-5, -1.388_676_4e-3, 4.166_662_3e-2], z),
        )
    };
    let (sin, cos) = (x + x * z * sin, T::ONE - T::HALF * z + z * z * cos);
    // Rotated by the quadrant: (c, s), (-s, c), (-c, -s), (s, -c).
    let (odd, back) = (word >> 62 & 1 == 1, word >> 63 == 1);
    let (a, b) = if odd { (-sin, cos) } else { (cos, sin) };
    if back { [-a, -b] } else { [a, b] }
}

#[cfg(test)]
mod tests {
    #[test]
    fn whole_numbers_split_as_double_precision_does() {
        let mut word = 7_u64;
        for i in 0..100_000 {
            word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            for word in [word, word >> (i % 64), !(word >> (i % 64)), super::SQRT_HALF << 11, super::SQRT_HALF << 12] {
                assert_eq!(super::split_whole::<f32>(word), super::split::<f32>(word), "{word:x}");
            }
        }
    }
}
