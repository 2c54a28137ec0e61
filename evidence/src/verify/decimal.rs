//! Reference values of 25 digits, and the distance of a result from one in units in the last place.

use anyhow::{Context, Result};
use mollis_core::Scalar as _;
use mollis_core::real::DoubleWord;

/// The scalar that results were computed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Scalar {
    /// 53 digits.
    F64,
    /// 24 digits.
    F32,
}

impl Scalar {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }

    /// The exponent of one unit in the last place of numbers in [2^(e-1), 2^e).
    fn ulp_exponent(self, e: i32) -> i32 {
        match self {
            Self::F64 => e.max(-1021) - 53,
            Self::F32 => e.max(-125) - 24,
        }
    }

    /// No finite number is 2^this or larger.
    fn overflow_exponent(self) -> i32 {
        match self {
            Self::F64 => 1024,
            Self::F32 => 128,
        }
    }

    /// Whether the scalar holds `x` exactly.
    pub fn holds(self, x: f64) -> bool {
        self == Self::F64 || f64::from(x as f32) == x
    }
}

/// `value * 2^exponent` with 1/2 <= |value| < 1, or zero, good to 30 digits: a comparison with a rounded 25-digit reference
/// in f64 needs 19. (A reference read as an f64 would itself be wrong by half a unit.)
#[derive(Clone, Copy, Debug)]
pub struct Decimal {
    value: DoubleWord<f64>,
    exponent: i32,
}

impl Decimal {
    pub fn parse(text: &str) -> Result<Self> {
        let (number, power) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let (negative, number) = match number.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, number),
        };
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        let digits = format!("{whole}{fraction}").parse::<u128>().with_context(|| format!("not a number: {text}"))?;
        let power: i64 = power.parse().with_context(|| format!("not a number: {text}"))?;
        Ok(Self::from_digits(digits, power - fraction.len() as i64, negative))
    }

    /// `digits * 10^power`.
    fn from_digits(digits: u128, power: i64, negative: bool) -> Self {
        // No scalar holds anything beyond 10^400 or below 10^-500.
        if digits == 0 || power < -500 {
            return Self { value: DoubleWord::ZERO, exponent: 0 };
        }
        let power = power.min(500) as i32;
        let high = (digits >> 64) as f64;
        let middle = (digits as u64 >> 32) as f64;
        let low = f64::from(digits as u32);
        let mut value =
            DoubleWord::from(high * 2_f64.powi(64)) + DoubleWord::from(middle * 2_f64.powi(32)) + low.into();
        let mut exponent = 0;
        for _ in 0..power.abs() {
            value = if power > 0 { value * 10.0 } else { value / 10.0 };
            let (_, shift) = value.hi.frexp();
            value = value.ldexp(-shift);
            exponent += shift;
        }
        let (_, shift) = value.hi.frexp();
        value = value.ldexp(-shift);
        Self { value: if negative { -value } else { value }, exponent: exponent + shift }
    }

    pub fn to_f64(self) -> f64 {
        self.value.hi.ldexp(self.exponent)
    }

    /// Rounded to the scalar it would overflow.
    pub fn overflows(self, scalar: Scalar) -> bool {
        self.exponent > scalar.overflow_exponent()
    }

    /// |got - self| in units in the last place of `scalar` at the magnitude of the larger of `self` and `scale`.
    ///
    /// Infinite where `got` is not a number, and unless both overflow alike.
    pub fn ulps(self, got: f64, scale: f64, scalar: Scalar) -> f64 {
        if self.overflows(scalar) {
            return if got == f64::INFINITY.copysign(self.value.hi) { 0.0 } else { f64::INFINITY };
        }
        if !got.is_finite() {
            return f64::INFINITY;
        }
        let (_, scale_exponent) = scale.frexp();
        let own_exponent = if self.value.hi == 0.0 { i32::MIN / 2 } else { self.exponent };
        let wanted = own_exponent.max(if scale == 0.0 { i32::MIN / 2 } else { scale_exponent });
        let ulp = scalar.ulp_exponent(wanted);
        let difference = DoubleWord::from(got.ldexp(-ulp)) - self.value.ldexp(self.exponent.saturating_sub(ulp));
        difference.hi.abs()
    }

    /// |got - self|.
    pub fn error(self, got: f64) -> f64 {
        // Scaled, so that differences of tiny numbers are not lost.
        let difference = DoubleWord::from(got.ldexp(-self.exponent)) - self.value;
        difference.hi.abs().ldexp(self.exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_keep_their_digits() {
        let third = Decimal::parse("3.333333333333333333333333e-1").unwrap();
        assert_eq!(third.to_f64(), 1.0 / 3.0);
        // 1/3 - fl(1/3) = 2^-54 / 3 = a sixth of a unit in the last place (2^-54)
        let ulps = third.ulps(1.0 / 3.0, 0.0, Scalar::F64);
        assert!((ulps - 1.0 / 3.0).abs() < 1e-7, "{ulps}");
        assert_eq!(Decimal::parse("0").unwrap().ulps(0.0, 0.0, Scalar::F64), 0.0);
        assert_eq!(Decimal::parse("-1.0").unwrap().ulps(-1.0 - f64::EPSILON, 0.0, Scalar::F64), 1.0);
        assert_eq!(Decimal::parse("1e400").unwrap().ulps(f64::INFINITY, 0.0, Scalar::F64), 0.0);
        assert_eq!(Decimal::parse("1e39").unwrap().ulps(f64::INFINITY, 0.0, Scalar::F32), 0.0);
        assert_eq!(Decimal::parse("1e30").unwrap().ulps(f64::NAN, 0.0, Scalar::F32), f64::INFINITY);
        assert_eq!(Decimal::parse("-3.7e-217147240941").unwrap().ulps(-0.0, 0.0, Scalar::F64), 0.0);
        // Subnormal numbers are multiples of 2^-1074.
        let tiny = Decimal::parse("5e-324").unwrap().ulps(0.0, 0.0, Scalar::F64);
        assert!((tiny - 1.012).abs() < 1e-3, "{tiny}");
        assert!(Decimal::parse("one").is_err());
    }
}
