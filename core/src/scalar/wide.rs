//! Double-precision addition and conversion by integer operations, in a third of the flash of the compiler's functions.

use crate::build::{self, shared};

/// `x` as f64.
#[inline(always)]
pub(super) fn same(x: f64) -> f64 {
    x
}

shared! {
    /// The nearest f32.
    pub(super) fn narrow(x: f64) -> f32 {
        if build::DOUBLE { x as f32 } else { rounded(x) }
    }
}

shared! {
    /// `x + y`.
    pub(super) fn sum(x: f64, y: f64) -> f64 {
        if build::DOUBLE { x + y } else { added(x, y) }
    }
}

const FRACTION: u64 = (1 << 52) - 1;

/// Rounds `scaled`, in units of 2^-3 of the last place with a sticky lowest bit, to an integer; halves to even.
fn round(scaled: u64) -> u64 {
    (scaled + 3 + (scaled >> 3 & 1)) >> 3
}

/// `value` shifted right. The lost bits are or-ed into one sticky bit.
fn shift(value: u64, by: u32) -> u64 {
    if by > 62 {
        return u64::from(value != 0);
    }
    let kept = value >> by;
    if kept << by == value { kept } else { kept | 1 }
}

/// The nearest f32, computed from the bits.
fn rounded(x: f64) -> f32 {
    let (bits, sign) = (x.to_bits() & !(1 << 63), (x.to_bits() >> 32) as u32 & 1 << 31);
    let exponent = (bits >> 52) as u32;
    // In the normal range an ulp of f32 is 2^29 ulp of f64. Three bits are kept for rounding.
    let scaled = if exponent > 896 {
        // NaN, and numbers that are too large and become infinite.
        if exponent > 1150 {
            let nan = u32::from(bits > 0x7FF << 52) << 22;
            return f32::from_bits(sign | 0x7F80_0000 | nan);
        }
        shift(bits - (896 << 52), 26)
    } else {
        shift(bits & FRACTION | 1 << 52, 26 + 897 - exponent)
    };
    f32::from_bits(sign | round(scaled) as u32)
}

/// `a + b`, computed from the bits, in the normal range. Subnormal numbers count as zero. Operands that are not finite are returned.
fn added(a: f64, b: f64) -> f64 {
    let magnitude = |x: f64| x.to_bits() & !(1 << 63);
    let (a, b) = if magnitude(a) < magnitude(b) { (b, a) } else { (a, b) };
    let (large, small) = (magnitude(a), magnitude(b));
    let apart = (large >> 52).wrapping_sub(small >> 52) as u32;
    if large >> 52 == 0x7FF || small >> 52 == 0 {
        return a;
    }
    // Significands with three bits for rounding, the lowest sticky. The larger operand counts as positive.
    let significand = |bits: u64| (bits & FRACTION | 1 << 52) << 3;
    let right = shift(significand(small), apart);
    let same = (a.to_bits() ^ b.to_bits()) >> 63 == 0;
    let sum = significand(large).wrapping_add(if same { right } else { right.wrapping_neg() });
    // Shifts the leading digit to bit 55.
    let zeros = sum.leading_zeros();
    let scaled = if zeros < 8 { shift(sum, 1) } else { sum << (zeros & 63) >> 8 };
    let exponent = (large >> 52).wrapping_add(8).wrapping_sub(u64::from(zeros));
    if zeros == 64 || exponent as i64 <= 0 {
        return 0.0;
    }
    let bits = (exponent << 52) + round(scaled) - (1 << 52);
    f64::from_bits(bits | a.to_bits() & 1 << 63)
}

#[cfg(test)]
mod tests {
    use super::{added, rounded};
    use std::vec::Vec;

    /// Numbers of all sizes, and boundary cases.
    fn numbers() -> Vec<f64> {
        let mut seed = 9_u64;
        let mut all: Vec<f64> = (0..3000)
            .map(|i: u32| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let fraction = match i % 4 {
                    0 => seed >> 12,
                    1 => seed >> 12 & !((1 << 29) - 1) | 1 << 28,
                    2 => (seed >> 12 & !((1 << 29) - 1) | 1 << 28) + (seed >> 60) - 8,
                    _ => seed >> 12 & !((1 << 27) - 1),
                };
                let exponent = 1023 - 180 + u64::from(i) % 330;
                f64::from_bits((seed & 1) << 63 | exponent << 52 | fraction & super::FRACTION)
            })
            .collect();
        all.extend([
            0.0,
            -0.0,
            1.0,
            -1.0,
            f64::INFINITY,
            f64::MAX,
            f64::from(f32::MAX),
            f64::MIN_POSITIVE,
            3.4e38,
            3.5e38,
        ]);
        all.extend([f64::from(f32::MIN_POSITIVE), 1e-45, 7e-46, 1e-50, 2.0_f64.powi(-150), 2.0_f64.powi(-126)]);
        all
    }

    #[test]
    fn conversions_round_as_the_machine_does() {
        for x in numbers() {
            assert_eq!(rounded(x).to_bits(), (x as f32).to_bits(), "{x:e}");
        }
        assert!(rounded(f64::NAN).is_nan());
    }

    #[test]
    fn sums_round_as_the_machine_does() {
        let numbers = numbers();
        for (i, &a) in numbers.iter().enumerate() {
            let near = [a * (1.0 + 1e-16), -a * (1.0 - 1e-15), -a, a * 0.75, -a * 0.5, a * 1e-16, -a * 1.7e-16];
            for b in near.into_iter().chain(numbers.iter().skip(i % 7).step_by(41).copied()) {
                let want = a + b;
                let whole = |x: f64| x == 0.0 || x.is_normal();
                if !(whole(a) && whole(b) && whole(want)) {
                    continue;
                }
                // The sign of a zero is not preserved.
                let same = added(a, b).to_bits() == want.to_bits() || want == 0.0 && added(a, b) == 0.0;
                assert!(same, "{a:e} {b:e} {:e} {want:e}", added(a, b));
            }
        }
        assert!(added(f64::NAN, 1.0).is_nan() && added(1.0, f64::NAN).is_nan());
        assert_eq!((added(1.0, f64::INFINITY), added(-1.0, 1.0)), (f64::INFINITY, 0.0));
    }
}
