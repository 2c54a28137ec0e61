//! Masses in 64-bit fixed point. The sums do not depend on the order of the particles, the threads or the ranks.
//!
//! A mass m is stored as the integer nearest to m / unit with unit = 2^`exponent`, and integers are added. For a scale of
//! total mass M >= sum |m| the unit is between 2^-50 M and 2^-49 M. One particle's share has at most 50 bits, so it is rounded
//! by one floating-point addition. The total of a node is at most 2^50 plus half a unit for each of n shares, so no sum
//! overflows 2^63 before n reaches 2^63.

use crate::error::{Error, Result};
use crate::real::{Real, Scalar};

/// Bits of the total mass, in units.
pub(super) const BITS: i32 = 50;
/// The exponent of the smallest unit, which is the smallest positive f64. It represents every mass exactly.
const LEAST: i32 = -1074;
/// 1.5 * 2^52. Adding it to |x| <= 2^51 rounds x to an integer and leaves that integer in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// The unit of fixed-point masses, a power of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MassScale {
    exponent: i32,
}

impl MassScale {
    /// The scale for masses whose absolute values add up to at most `total`.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Mass`]: `total` is negative.
    pub fn for_total<T: Real>(total: T) -> Result<Self> {
        if !total.is_finite() {
            return Err(Error::NotFinite);
        }
        if total < T::ZERO {
            return Err(Error::Mass);
        }
        let (_, e) = total.to_f64().frexp();
        Ok(Self::from_bound(e))
    }

    /// The scale of these masses, of any sign. It does not depend on their order.
    ///
    /// Cost: two passes over the masses. Recompute it only when masses change.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn of<T: Real>(masses: &[T]) -> Result<Self> {
        let mut largest = T::ZERO;
        let mut bad = false;
        for m in masses {
            bad |= !m.is_finite();
            largest = largest.max(m.abs());
        }
        if bad {
            return Err(Error::NotFinite);
        }
        if largest == T::ZERO {
            return Ok(Self::from_bound(0));
        }
        // The first scale is from n max |m|, which does not depend on the order but may be far above the sum. The sum in that scale
        // gives the second scale. Truncation loses less than one unit each, so `n` units are added for an upper bound.
        let n = masses.len() as u64;
        let e = largest.to_f64().frexp().1 + (64 - n.leading_zeros()) as i32;
        let [first, second] = halves::<f64>(61 - e);
        let units = |m: &T| (m.abs().to_f64() * first * second) as u64;
        let sum = masses.iter().fold(n, |sum, m| sum.saturating_add(units(m)));
        Ok(Self::from_bound((64 - sum.leading_zeros()) as i32 - (61 - e)))
    }

    /// The scale for sum |m| <= 2^e.
    fn from_bound(e: i32) -> Self {
        Self { exponent: (e - BITS).max(LEAST) }
    }

    /// The exponent of the unit, a power of two.
    #[must_use]
    pub fn exponent(self) -> i32 {
        self.exponent
    }

    /// One mass unit.
    #[must_use]
    pub fn unit(self) -> f64 {
        1.0_f64.ldexp(self.exponent)
    }

    /// Units in a mass of 1, as two factors.
    pub(super) fn per_mass(self) -> [f64; 2] {
        halves(-self.exponent)
    }
}

/// 2^`exponent` as two factors. Each is in the range if the power is. Multiplying a number by one after the other rounds
/// only where the result is below the normal range.
pub(super) fn halves<T: Real>(exponent: i32) -> [T; 2] {
    let half = exponent / 2;
    [half, exponent - half].map(|e| T::ONE.ldexp(e.min(T::MAX_EXPONENT)))
}

/// The integer nearest to `x`, for |x| <= 2^51; halves round to even.
#[inline(always)]
pub(super) fn nearest(x: f64) -> i64 {
    (x + ROUND).to_bits().wrapping_sub(ROUND.to_bits()) as i64
}

/// `units` as a number, for |units| < 2^51. The inverse of [`nearest`]; it vectorises as well.
#[inline(always)]
pub(super) fn exact(units: i64) -> f64 {
    f64::from_bits((units as u64).wrapping_add(ROUND.to_bits())) - ROUND
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_bounds_the_sum_and_ignores_the_order() {
        let mut masses = std::vec![1e-8_f64; 1001];
        masses[500] = 3.0;
        let scale = MassScale::of(&masses).unwrap();
        let total = masses.iter().sum::<f64>();
        let units = |m: f64, scale: MassScale| scale.per_mass().into_iter().fold(m, |m, factor| m * factor);
        let bits = units(total, scale).log2();
        assert!((48.0..=50.0).contains(&bits), "{bits}");
        masses.reverse();
        assert_eq!(MassScale::of(&masses), Ok(scale));
        masses.rotate_left(77);
        assert_eq!(MassScale::of(&masses), Ok(scale));
        for m in [5e-324, f64::MIN_POSITIVE, 1e-300, 1e-30, 1.0, 1e300] {
            for n in [1, 2, 3, 1000] {
                let scale = MassScale::of(&std::vec![-m; n]).unwrap();
                let one = units(m, scale);
                // The smallest masses are multiples of the smallest unit. Others keep 50 bits less those of n.
                assert!(one * n as f64 <= 2.0_f64.powi(50) && scale.unit() > 0.0);
                assert!(one * n as f64 >= 2.0_f64.powi(47) || scale.exponent() == LEAST && nearest(one) as f64 == one);
                assert!((nearest(one) as f64 * scale.unit() / m - 1.0).abs() <= n as f64 * 2.0_f64.powi(-47));
            }
        }
        assert_eq!(MassScale::of(&[0.0_f64; 4]), MassScale::of::<f64>(&[]));
        assert_eq!(MassScale::of(&[1.0, f64::NAN]), Err(Error::NotFinite));
        assert_eq!(MassScale::of(&[1.0_f32, f32::INFINITY]), Err(Error::NotFinite));
        assert_eq!(MassScale::for_total(-1.0), Err(Error::Mass));
        assert!(MassScale::for_total(3.0_f64).unwrap().exponent() == scale_exponent(3.0));
    }

    fn scale_exponent(total: f64) -> i32 {
        total.log2().floor() as i32 + 1 - BITS
    }

    #[test]
    fn nearest_rounds_halves_to_even() {
        for (x, want) in [(0.5, 0), (1.5, 2), (-0.5, 0), (-1.5, -2), (2.4, 2), (-2.6, -3), (0.0, 0)] {
            assert_eq!(nearest(x), want);
            assert_eq!(exact(want), want as f64);
        }
        let big = 2.0_f64.powi(51);
        assert_eq!((nearest(big), nearest(-big)), (1 << 51, -(1 << 51)));
    }
}
