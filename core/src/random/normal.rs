//! Uniform and normal numbers from random bits, in operations that give the same bits on every machine.
//!
//! The normals are Box & Muller's (*A note on the generation of random normal deviates*, 1958): exact in law, without
//! rejection, so word i of the input belongs to number i of the output whatever the values are, and without a branch, so
//! the compiler runs several at a time. Logarithm, sine and cosine are FreeBSD msun's polynomials (Sun Microsystems,
//! 1993) on the reduced argument, which here comes straight from the bits.

use crate::isa::{Level, Plain, widest};
use crate::real::Real;

/// The bits of 1.0; or-ed with 52 bits b they make 1 + b 2^-52.
const ONE: u64 = 0x3FF0_0000_0000_0000;
/// The bits of sqrt(1/2), rounded down.
const SQRT_HALF: u64 = 0x3FE6_A09E_667F_3BCC;
const FRACTION: u64 = 0x000F_FFFF_FFFF_FFFF;

/// A uniform number in the open interval (0, 1): an odd multiple of 2^-53 (f64) or 2^-24 (f32), from the word's high bits.
#[inline(always)]
pub fn uniform<T: Real>(word: u64) -> T {
    // 52 or 23 bits and a half: exact in T, so it reaches neither 0 nor 1.
    let kept = word >> (65 - T::DIGITS);
    T::from_f64(f64::from_bits(ONE | kept << (53 - T::DIGITS)) - 1.0) + T::EPSILON * T::HALF
}

/// (2 k + 1) 2^-53 with k the word's high 52 bits. The subtraction is exact.
#[inline(always)]
fn open(word: u64) -> f64 {
    f64::from_bits(ONE | word >> 12) - (1.0 - f64::EPSILON / 2.0)
}

/// How many words [`normals`] takes for `n` numbers: `n`, rounded up to even.
#[must_use]
pub const fn words(n: usize) -> usize {
    n.saturating_add(n % 2)
}

/// Overwrites `out` with independent standard normals from uniform bits; words 2 i and 2 i + 1 make numbers 2 i and 2 i + 1.
///
/// `bits` holds [`words`]`(out.len())` words (numbers without words are left). The law is a normal's up to the granularity of
/// the uniform, 2^-53 in the radius' probability: |z| <= 8.58, and the distribution function is off by at most 2^-52. Each
/// number is within 4 units in the last place of the pair's radius of what exact arithmetic makes of the same bits
/// (test `against_the_formula`).
///
/// Cost: about 3 ns a number.
///
/// # Source
/// Box & Muller 1958.
pub fn normals<T: Real>(bits: &[u64], out: &mut [T]) {
    widest(Level::best(), Normals { bits, out });
}

struct Normals<'a, T> {
    bits: &'a [u64],
    out: &'a mut [T],
}

impl<T: Real> Plain for Normals<'_, T> {
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
    let radius = (T::from_f64(-2.0) * log(open(first))).sqrt();
    let [cos, sin] = direction(second);
    [radius * cos, radius * sin]
}

/// log u for a normal u in (0, 1).
#[inline(always)]
fn log<T: Real>(u: f64) -> T {
    let c = T::from_f64;
    // u = 2^e m with sqrt(1/2) <= m < sqrt(2).
    let shifted = u.to_bits().wrapping_add(ONE - SQRT_HALF);
    // The biased exponent as a number: it is or-ed into the low bits of 2^52.
    let e = c(f64::from_bits(0x4330_0000_0000_0000 | shifted >> 52) - (4_503_599_627_370_496.0 + 1023.0));
    let f = c(f64::from_bits((shifted & FRACTION).wrapping_add(SQRT_HALF)) - 1.0);
    // log(1 + f) = f - f^2/2 + s (f^2/2 + R(s^2)), s = f / (2 + f); msun e_log.c.
    let s = f / (T::TWO + f);
    let (z, half) = (s * s, T::HALF * f * f);
    let w = z * z;
    let even =
        w * (c(3.999_999_999_940_942e-1) + w * (c(2.222_219_843_214_978_4e-1) + w * c(1.531_383_769_920_937_3e-1)));
    let odd = z
        * (c(6.666_666_666_666_735e-1)
            + w * (c(2.857_142_874_366_239e-1)
                + w * (c(1.818_357_216_161_805e-1) + w * c(1.479_819_860_511_658_6e-1))));
    let (high, low) = (c(6.931_471_803_691_238e-1), c(1.908_214_929_270_587_7e-10));
    e * high - ((half - (s * (half + (even + odd)) + e * low)) - f)
}

/// (cos, sin) of 2 pi v, v uniform: two bits choose the quadrant, 52 the angle in it from its middle.
#[inline(always)]
fn direction<T: Real>(word: u64) -> [T; 2] {
    let c = T::from_f64;
    // (2 k + 1) 2^-53 - 1/2 of a quarter turn, exact; |x| < pi/4.
    let x = c((f64::from_bits(ONE | (word << 2) >> 12) - 1.5) + f64::EPSILON / 2.0) * (T::PI * T::HALF);
    let z = x * x;
    // msun k_sin.c, k_cos.c.
    let sin = x + x
        * z
        * (c(-1.666_666_666_666_663_2e-1)
            + z * (c(8.333_333_333_322_49e-3)
                + z * (c(-1.984_126_982_985_795e-4)
                    + z * (c(2.755_731_370_707_006_8e-6)
                        + z * (c(-2.505_076_025_340_686_3e-8) + z * c(1.589_690_995_211_55e-10))))));
    let cos = T::ONE - T::HALF * z
        + z * z
            * (c(4.166_666_666_666_66e-2)
                + z * (c(-1.388_888_888_887_411e-3)
                    + z * (c(2.480_158_728_947_673e-5)
                        + z * (c(-2.755_731_435_139_066_3e-7)
                            + z * (c(2.087_572_321_298_175e-9) + z * c(-1.135_964_755_778_819_5e-11))))));
    // Turned by the quadrant: (c, s), (-s, c), (-c, -s), (s, -c).
    let (odd, back) = (word >> 62 & 1 == 1, word >> 63 == 1);
    let (a, b) = if odd { (-sin, cos) } else { (cos, sin) };
    if back { [-a, -b] } else { [a, b] }
}
