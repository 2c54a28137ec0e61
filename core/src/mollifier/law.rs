//! The coefficients of compact polynomial mollifiers as exact rationals, by integer arithmetic. Tests compare those that
//! [`super::series`] prepares with them.
//!
//! With t = 1 - (r/delta)^2, dimension N, exponent M and order 2K the gradient factor inside the support is
//! `G(t) = sum of g_k t^k, k = 0..M+K-1`, and all other polynomials follow from it:
//!
//! * `g_k = a_k = (N/2)_k / k!` for k <= M: the truncated Taylor series of the exterior field (1-t)^(-N/2);
//! * `g_(M+i) = W_(M+i) a_(M+i)` for i = 1..K-1, with `W_(M+i)` the sum over j = i..K-1 of
//!   `(-1)^(K-1+j) C(K-1,j) (N/2)_(M+K) (N/2+M+K)_j / ((K-1)! (N/2)_(M+j+1))`;
//! * density `b_k = (N + 2k) g_k - 2 (k+1) g_(k+1)`, which vanishes below k = M;
//! * Hessian factor `H = -2 G'`, potential `P' = -G/2`.
//!
//! Derived from Anderson (3), (12) as t^M times a Jacobi polynomial. The paper's Tables 1 to 8 contain four misprints and are
//! not used. A test compares each coefficient for every N, M and order with independently computed rationals.

/// The largest exponent M.
pub const MAX_EXPONENT: u32 = 9;
/// The largest order.
pub const MAX_ORDER: u32 = 8;
/// Coefficients of the longest series, the potential's: degree M + K = 13.
pub const MAX_COEFFICIENTS: usize = 14;

/// An exact rational number in lowest terms, with a positive denominator.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rational {
    pub numerator: i128,
    pub denominator: i128,
}

#[cfg(test)]
impl Rational {
    pub const ZERO: Self = Self::new(0, 1);
    pub const ONE: Self = Self::new(1, 1);

    pub const fn new(numerator: i128, denominator: i128) -> Self {
        let (mut a, mut b) = (numerator.abs(), denominator.abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = if denominator < 0 { -a } else { a };
        Self { numerator: numerator / divisor, denominator: denominator / divisor }
    }

    pub const fn times(self, numerator: i128, denominator: i128) -> Self {
        // Cancelling common factors first keeps the products small.
        let left = Self::new(self.numerator, denominator);
        let right = Self::new(numerator, self.denominator);
        Self::new(left.numerator * right.numerator, left.denominator * right.denominator)
    }

    pub const fn plus(self, other: Self) -> Self {
        Self::new(
            self.numerator * other.denominator + other.numerator * self.denominator,
            self.denominator * other.denominator,
        )
    }
}

/// `a_k = (N/2)_k / k!`.
#[cfg(test)]
pub(super) const fn taylor(dimension: u32, k: u32) -> Rational {
    let mut a = Rational::ONE;
    let mut i = 0;
    while i < k {
        a = a.times((dimension + 2 * i) as i128, 2 * (i + 1) as i128);
        i += 1;
    }
    a
}

/// `W_(M+i)`, for i = 1..K-1 and order 2K:
/// the sum over j = i..K-1 of (-1)^(K-1+j) C(K-1,j) (N/2)_(M+K) (N/2+M+K)_j / ((K-1)! (N/2)_(M+j+1)).
#[cfg(test)]
pub(super) const fn weight(dimension: u32, exponent: u32, half_order: u32, i: u32) -> Rational {
    let (n, m, k) = (dimension, exponent, half_order);
    let mut sum = Rational::ZERO;
    let mut j = i;
    while j < k {
        let mut term = Rational::new(if (k - 1 + j).is_multiple_of(2) { 1 } else { -1 }, 1);
        // C(K-1, j) / (K-1)! = 1 / (j! (K-1-j)!)
        let mut f = 2;
        while f <= j {
            term = term.times(1, f as i128);
            f += 1;
        }
        let mut f = 2;
        while f <= k - 1 - j {
            term = term.times(1, f as i128);
            f += 1;
        }
        // (N/2)_(M+K) / (N/2)_(M+j+1)
        let mut f = m + j + 1;
        while f < m + k {
            term = term.times((n + 2 * f) as i128, 2);
            f += 1;
        }
        // (N/2+M+K)_j
        let mut f = m + k;
        while f < m + k + j {
            term = term.times((n + 2 * f) as i128, 2);
            f += 1;
        }
        sum = sum.plus(term);
        j += 1;
    }
    sum
}

/// `g_k`.
#[cfg(test)]
pub(super) const fn gradient(dimension: u32, exponent: u32, half_order: u32, k: u32) -> Rational {
    let a = taylor(dimension, k);
    if k <= exponent {
        a
    } else if k < exponent + half_order {
        let w = weight(dimension, exponent, half_order, k - exponent);
        a.times(w.numerator, w.denominator)
    } else {
        Rational::ZERO
    }
}
