//! The exact coefficients of compact polynomial mollifiers, by integer arithmetic when the library is compiled.
//!
//! With t = 1 - (r/delta)^2, dimension N, exponent M and order 2K the gradient factor inside the support is
//! `G(t) = sum of g_k t^k, k = 0..M+K-1`, and everything else follows from it:
//!
//! * `g_k = a_k = (N/2)_k / k!` for k <= M: the Taylor series of the exterior field (1-t)^(-N/2), cut off;
//! * `g_(M+i) = W_(M+i) a_(M+i)` for i = 1..K-1, with [`weight`];
//! * density `b_k = (N + 2k) g_k - 2 (k+1) g_(k+1)`, which vanishes below k = M;
//! * Hessian factor `H = -2 G'`, potential `P' = -G/2`.
//!
//! Derived from Anderson (3), (12) by t^M times a Jacobi polynomial; the paper's Tables 1 to 8 hold four misprints and are
//! not used. A test compares each coefficient of every N, M and order with independently computed rationals.

/// The largest exponent M.
pub const MAX_EXPONENT: u32 = 9;
/// The largest order.
pub const MAX_ORDER: u32 = 8;
/// Coefficients of the longest series, the potential's: degree M + K = 13.
pub const MAX_TERMS: usize = 14;

/// An exact rational number in lowest terms, with a positive denominator.
///
/// An overflow of its 128 bits would not compile, as it occurs in constants alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rational {
    pub numerator: i128,
    pub denominator: i128,
}

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
        // Cross-cancelling first keeps the products small.
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

    /// The value, which must be a multiple of a power of 1/2 with at most 53 digits.
    const fn exact_f64(self) -> f64 {
        let value = self.numerator as f64 / self.denominator as f64;
        assert!(self.denominator & (self.denominator - 1) == 0, "not a binary fraction");
        let odd = if self.numerator == 0 { 0 } else { self.numerator >> self.numerator.trailing_zeros() };
        assert!(odd.abs() < 1 << 53, "more than 53 digits");
        value
    }
}

/// `a_k = (N/2)_k / k!`.
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

/// `g_(M+1)` to `g_(M+K-1)` of every mollifier of order 2K > 2 in one dimension: each the exact sum of three f32, at
/// [`top`]. A dimension takes 648 bytes, all that is stored of its coefficients, and is linked only where it is used.
///
/// The third parts stand apart: single precision, which holds sums of two, doesn't need them.
struct Tops {
    pairs: [[f32; 2]; 54],
    thirds: [f32; 54],
}

const TOPS: [Tops; 3] = [tops(1), tops(2), tops(3)];
static PAIRS_1: [[f32; 2]; 54] = TOPS[0].pairs;
static PAIRS_2: [[f32; 2]; 54] = TOPS[1].pairs;
static PAIRS_3: [[f32; 2]; 54] = TOPS[2].pairs;
static THIRDS_1: [f32; 54] = TOPS[0].thirds;
static THIRDS_2: [f32; 54] = TOPS[1].thirds;
static THIRDS_3: [f32; 54] = TOPS[2].thirds;

/// Where a mollifier's first entry stands: behind those of lower orders and exponents.
const fn top(exponent: usize, half_order: usize) -> usize {
    9 * ((half_order - 1) * (half_order - 2) / 2) + (exponent - 1) * (half_order - 1)
}

/// The entries of one mollifier: the two higher parts of each; none for order 2.
#[inline(always)]
pub(super) fn gradient_tops<const D: usize>(exponent: usize, half_order: usize) -> &'static [[f32; 2]] {
    let pairs = match D {
        1 => &PAIRS_1,
        2 => &PAIRS_2,
        _ => &PAIRS_3,
    };
    entries(pairs, exponent, half_order)
}

/// The lowest parts of the same entries.
#[inline(always)]
pub(super) fn gradient_thirds<const D: usize>(exponent: usize, half_order: usize) -> &'static [f32] {
    let thirds = match D {
        1 => &THIRDS_1,
        2 => &THIRDS_2,
        _ => &THIRDS_3,
    };
    entries(thirds, exponent, half_order)
}

#[inline(always)]
fn entries<C>(all: &[C], exponent: usize, half_order: usize) -> &[C] {
    if !(2..=4).contains(&half_order) || !(1..=9).contains(&exponent) {
        return &[];
    }
    let start = top(exponent, half_order);
    all.get(start..start + half_order - 1).unwrap_or(&[])
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler, where an index out of range is an error")]
const fn tops(dimension: u32) -> Tops {
    let mut tops = Tops { pairs: [[0.0; 2]; 54], thirds: [0.0; 54] };
    let mut half_order = 2;
    while half_order <= 4 {
        let mut exponent = 1;
        while exponent <= 9 {
            let mut i = 1;
            while i < half_order {
                let value = gradient(dimension, exponent, half_order, exponent + i).exact_f64();
                let at = top(exponent as usize, half_order as usize) + i as usize - 1;
                let [first, second, third] = three_parts(value);
                tops.pairs[at] = [first, second];
                tops.thirds[at] = third;
                i += 1;
            }
            exponent += 1;
        }
        half_order += 1;
    }
    tops
}

/// 53 digits as three times 24.
const fn three_parts(value: f64) -> [f32; 3] {
    let first = value as f32;
    let second = (value - first as f64) as f32;
    let third = (value - first as f64 - second as f64) as f32;
    assert!(first as f64 + second as f64 + third as f64 == value, "more than three parts");
    assert!(second + third == second, "the third part matters in single precision");
    [first, second, third]
}
