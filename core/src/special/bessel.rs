//! Modified Bessel functions of orders 0 and 1, scaled so that they do not overflow.
//!
//! K: for x < 1 the power series with its logarithm, which does not cancel there; for larger x the trapezoidal rule for
//! e^x K_n(x) = int_0^inf e^{-2x sinh^2(t/2)} cosh(nt) dt. Its terms are all positive, and it converges
//! exponentially because the integrand is entire (Trefethen and Weideman, SIAM Review 56, 2014). I: the power series, all
//! terms positive, then Hankel's asymptotic series (DLMF 10.40.1). Relative error of each: a few roundings (test below).

use crate::real::Real;

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// e^x K0(x) for x > 0.
pub fn k0_scaled<T: Real>(x: T) -> T {
    k_scaled(x, 0)
}

/// e^x K1(x) for x > 0.
pub fn k1_scaled<T: Real>(x: T) -> T {
    k_scaled(x, 1)
}

fn k_scaled<T: Real>(x: T, order: u32) -> T {
    if x < T::ONE { k_series(x, order) * x.exp() } else { k_integral(x, order) }
}

/// DLMF 10.31.1 and 10.31.2.
fn k_series<T: Real>(x: T, order: u32) -> T {
    let quarter = T::from_f64(0.25) * x * x;
    let log = (T::HALF * x).log() + T::from_f64(EULER);
    // sum_k (x^2/4)^k / (k! (k+n)!), plain and weighted by the harmonic numbers
    let (mut term, mut k, mut harmonic) = (T::ONE, 0_i32, T::ZERO);
    let (mut plain, mut weighted) = (T::ZERO, T::ZERO);
    while term > T::EPSILON * T::from_f64(0.01) * plain || k == 0 {
        let next = T::from_i32(k + 1);
        plain += term;
        weighted += term * if order == 0 { harmonic } else { T::TWO * harmonic + T::ONE / next };
        harmonic += T::ONE / next;
        term *= quarter / (next * (next + if order == 0 { T::ZERO } else { T::ONE }));
        k += 1;
    }
    if order == 0 {
        weighted - log * plain
    } else {
        // psi(k+1) + psi(k+2) = 2 H_k + 1/(k+1) - 2 gamma
        T::ONE / x + T::HALF * x * (log * plain - T::HALF * weighted)
    }
}

fn k_integral<T: Real>(x: T, order: u32) -> T {
    // A step h has the error e^{-2 pi a / h + x (1 - cos a)} for any a > 0. a = pi/2 for x = 1 and a ~ 2 pi/(x h) for large
    // x give the exponents -pi^2/h and -2 pi^2/(x h^2). Both are below -40 with these steps.
    let h = T::from_f64(0.22).min(T::from_f64(0.66) / x.sqrt());
    let (mut sum, mut k) = (T::HALF, 1_i32);
    loop {
        let t = T::from_i32(k) * h;
        let half = T::HALF * t;
        let e = half.exp();
        let sinh = if half < T::from_f64(0.3) { sinh_small(half) } else { T::HALF * (e - T::ONE / e) };
        let square = sinh * sinh;
        let mut term = (-(T::TWO * x * square)).exp();
        if order == 1 {
            term *= T::ONE + T::TWO * square;
        }
        sum += term;
        if term < T::EPSILON * T::from_f64(0.02) || k > 400 {
            return h * sum;
        }
        k += 1;
    }
}

/// sinh x for |x| < 0.3, to rounding.
fn sinh_small<T: Real>(x: T) -> T {
    let s = x * x;
    let mut sum = T::ZERO;
    for k in (1..=6_i32).rev() {
        sum = (T::ONE + sum) * s / T::from_i32(2 * k * (2 * k + 1));
    }
    x + x * sum
}

/// e^{-x} I0(x) for x >= 0.
pub fn i0_scaled<T: Real>(x: T) -> T {
    i_scaled(x, 0)
}

/// e^{-x} I1(x) / x for x >= 0; 1/2 at 0.
pub fn i1_scaled_over_x<T: Real>(x: T) -> T {
    i_scaled(x, 1)
}

fn i_scaled<T: Real>(x: T, order: u32) -> T {
    let n = T::from_usize(order as usize);
    if x < T::from_f64(36.0) {
        let quarter = T::from_f64(0.25) * x * x;
        let (mut term, mut sum, mut k) = (if order == 0 { T::ONE } else { T::HALF }, T::ZERO, T::ZERO);
        while term > T::EPSILON * T::from_f64(0.01) * sum {
            sum += term;
            k += T::ONE;
            term *= quarter / (k * (k + n));
        }
        return sum * (-x).exp();
    }
    // DLMF 10.40.1: a_k(n) = prod ((2n)^2 - (2j-1)^2) / (k! 8^k), alternating
    let four = T::from_f64(4.0) * n * n;
    let (mut term, mut sum) = (T::ONE, T::ONE);
    for k in 1..=24_i32 {
        let odd = T::from_i32(2 * k - 1);
        term *= (odd * odd - four) / (T::from_i32(8 * k) * x);
        sum += term;
        if term.abs() < T::EPSILON * T::from_f64(0.1) {
            break;
        }
    }
    let scale = (T::TWO * T::PI * x).sqrt();
    if order == 0 { sum / scale } else { sum / (scale * x) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x, e^x K0, e^x K1, e^-x I0, e^-x I1 / x to 18 digits (mpmath, 30 digits).
    #[expect(clippy::excessive_precision, clippy::inconsistent_digit_grouping, reason = "as tabulated")]
    const TABLE: &[(f64, [f64; 4])] = &[
        (
            1.0e-8,
            [18.536_612_444_976_901_9, 100_000_000.999_999_908, 0.999_999_990_000_000_075, 0.499_999_995_000_000_031],
        ),
        (
            0.001,
            [7.030_716_002_378_251_5, 1000.996_734_559_068_43, 0.999_000_749_583_515_559, 0.499_500_312_354_221_337],
        ),
        (0.1, [2.682_326_102_262_894_34, 10.890_182_683_049_696, 0.907_100_925_782_301_092, 0.452_984_468_088_093_248]),
        (
            0.5,
            [1.524_109_385_773_909_53, 2.731_009_708_211_785_71, 0.645_035_270_449_150_068, 0.312_841_606_369_743_394],
        ),
        (
            0.99,
            [1.149_412_870_341_531_29, 1.647_705_555_252_131_45, 0.468_353_565_495_116_574, 0.209_498_472_684_772_505],
        ),
        (
            1.0,
            [1.144_463_079_806_895_01, 1.636_153_486_263_258_25, 0.465_759_607_593_640_437, 0.207_910_415_349_708_449],
        ),
        (
            1.01,
            [1.139_578_570_488_989_47, 1.624_814_222_117_598_39, 0.463_196_429_113_319_207, 0.206_338_970_947_132_178],
        ),
        (
            2.0,
            [0.841_568_215_070_771_418, 1.033_476_847_068_688_57, 0.308_508_322_553_671_04, 0.107_634_644_624_468_83],
        ),
        (
            3.7,
            [
                0.632_218_059_198_740_673,
                0.713_006_501_049_576_123,
                0.216_049_441_672_973_721,
                0.049_685_907_574_961_141_1,
            ],
        ),
        (
            8.0,
            [
                0.436_623_018_601_586_113,
                0.463_149_092_870_496_106,
                0.143_431_781_856_850_311,
                0.016_767_811_661_587_272_3,
            ],
        ),
        (
            20.0,
            [
                0.278_544_876_657_182_224,
                0.285_425_496_940_726_445,
                0.089_780_311_884_826_021_6,
                0.004_375_311_109_164_433_27,
            ],
        ),
        (
            100.0,
            [
                0.125_175_621_659_126_579,
                0.125_799_950_479_578_529,
                0.039_944_379_299_096_682_6,
                0.000_397_441_530_251_302_527,
            ],
        ),
        (
            1000.0,
            [
                0.039_628_321_600_754_217_1,
                0.039_648_130_812_960_210_5,
                0.012_617_240_455_891_256_6,
                0.000_012_610_930_256_928_629_5,
            ],
        ),
    ];

    /// Sums of positive terms, each accurate to about 2u, and one exponential of an argument below 40: under 8 roundings. For
    /// x near 1 the series of K subtracts a logarithm of relative weight 6: 12 roundings.
    #[test]
    fn within_a_few_roundings_of_the_table() {
        let mut worst = 0.0_f64;
        for &(x, [k0, k1, i0, i1]) in TABLE {
            let pairs = [(k0_scaled(x), k0), (k1_scaled(x), k1), (i0_scaled(x), i0), (i1_scaled_over_x(x), i1)];
            for (n, (got, want)) in pairs.into_iter().enumerate() {
                let error = ((got - want) / want).abs() / f64::EPSILON;
                worst = worst.max(error);
                assert!(error < 6.0, "function {n} at {x}: {got} {want}: {error} eps");
                let single =
                    [k0_scaled(x as f32), k1_scaled(x as f32), i0_scaled(x as f32), i1_scaled_over_x(x as f32)];
                assert!(((f64::from(single[n]) - want) / want).abs() < 1e-6 * (1.0 + x / 10.0));
            }
        }
        std::println!("worst {worst}");
    }
}
