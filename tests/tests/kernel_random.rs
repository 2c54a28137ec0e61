//! Mollified kernels at random parameters against their definition, integrated with 60 digits by `data/kernels_random.py`. Also kernels at
//! single distances at the limits of the number range.

#![allow(clippy::excessive_precision, reason = "reference values keep the digits that they were computed with")]

use mollis_core::Error;
use mollis_core::Real;
use mollis_core::Scalar;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_tests::Aligned;

const TABLE: &str = include_str!("../data/kernels_random.csv");

struct Row {
    dimension: usize,
    law: Law,
    mollifier: Mollifier,
    delta: f64,
    r: f64,
    want: [f64; 3],
    /// The convolutions of the magnitudes.
    size: [f64; 3],
}

fn rows() -> Vec<Row> {
    let row = |line: &str| {
        let f: Vec<&str> = line.split(',').collect();
        let number = |k: usize| f[k].parse::<f64>().unwrap();
        let law = match f[1] {
            "power" => Law::Power { exponent: number(2) },
            "exponential" => Law::Exponential { length: number(2) },
            _ => Law::Screened { k: number(2) },
        };
        let order = f[4].parse().unwrap();
        let mollifier = match f[3] {
            "compact" => Mollifier::Compact { order, exponent: f[5].parse().unwrap() },
            _ => Mollifier::Gaussian { order },
        };
        let (want, size) = ([8, 9, 10].map(number), [11, 12, 13].map(number));
        Row { dimension: f[0].parse().unwrap(), law, mollifier, delta: number(6), r: number(7), want, size }
    };
    TABLE.lines().skip(1).map(row).collect()
}

fn with<T: Real, const D: usize, R>(
    terms: &[Term],
    mollifier: Mollifier,
    delta: T,
    f: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> Result<R, Error> {
    let bytes = Kernel::<T, D>::workspace_bytes(terms, mollifier)?;
    let mut memory = Aligned::new(bytes);
    let kernel = Kernel::<T, D>::prepare(memory.bytes(), terms, mollifier, delta)?;
    Ok(f(&kernel))
}

fn one(law: Law) -> [Term; 1] {
    [Term { law, coefficient: 1.0 }]
}

/// Even powers, and odd ones in 1D and 3D under compact mollifiers, are polynomials and finite sums.
fn is_closed(row: &Row) -> bool {
    let Law::Power { exponent: p } = row.law else { return false };
    let compact = matches!(row.mollifier, Mollifier::Compact { .. });
    p > 0.0 && (p % 2.0 == 0.0 || p % 1.0 == 0.0 && row.dimension != 2 && compact)
}

/// S of the module `kernel`: the magnitudes of the bare kernel at delta, and for delta above 5 lengths those of the convolution.
fn scale(row: &Row, bare: [f64; 3]) -> [f64; 3] {
    let [value, gradient, laplacian] = bare.map(f64::abs);
    let value = if row.law == (Law::Power { exponent: 0.0 }) { value.max(1.0) } else { value };
    let lengths = match row.law {
        Law::Exponential { length } => row.delta / length,
        Law::Screened { k } => row.delta * k,
        _ => 0.0,
    };
    let mut scale = [value, gradient, laplacian.max(gradient)];
    if lengths > 5.0 {
        scale.iter_mut().zip(row.size).for_each(|(scale, size)| *scale = scale.max(size));
    }
    scale
}

/// The largest errors of a row over their bounds, in double and in single precision (none if single precision refuses the kernel).
///
/// Double: 1e-13 of the larger of |value| and the scale, as `Kernel::at` states. The losses are some 300 positive terms of an integral,
/// each with a few roundings, and Clenshaw's recurrence of 30 steps, both relative to the largest size on a panel, which is at most 64
/// times that at r: 64 * 1e-15 and a margin. Closed forms: 8 ulp of |value|. They round a double-word series once, a power of r and one of
/// delta (an ulp each) and three products. Where the series itself is zero, some 100 u^2 of its terms remain.
///
/// Single: the same, and one rounding to nearest, u of |value|. Results below the normal range have the spacing there.
fn check<const D: usize>(row: &Row) -> (f64, Option<f64>) {
    let terms = one(row.law);
    let scale = scale(row, with::<f64, D, _>(&terms, Mollifier::None, row.delta, |k| k.at(row.delta)).unwrap());
    let bounds: Vec<f64> = (0..3)
        .map(|n| {
            let size = row.want[n].abs();
            if is_closed(row) { 8.0 * f64::EPSILON * size + 1e-30 * row.size[n] } else { 1e-13 * size.max(scale[n]) }
        })
        .collect();
    let worst = |got: [f64; 3], more: &dyn Fn(f64) -> f64| {
        (0..3).fold(0.0_f64, |worst, n| {
            let (error, bound) = ((got[n] - row.want[n]).abs(), bounds[n] + more(row.want[n].abs()));
            // the error of equal zeros is zero, that of a NaN infinite
            let ratio = if error == 0.0 { 0.0 } else { error / bound };
            worst.max(if ratio.is_nan() { f64::INFINITY } else { ratio })
        })
    };
    let double = with::<f64, D, _>(&terms, row.mollifier, row.delta, |k| k.at(row.r)).unwrap();
    let (delta, r) = (row.delta as f32, row.r as f32);
    assert!(
        f64::from(delta) == row.delta && f64::from(r) == row.r,
        "the table's lengths are numbers of either precision"
    );
    let u = f64::from(f32::EPSILON) / 2.0;
    let single = match with::<f32, D, _>(&terms, row.mollifier, delta, |k| k.at(r)) {
        Ok(got) => Some(worst(got.map(f64::from), &|size| u * size + u * f64::from(f32::MIN_POSITIVE))),
        // the exterior factor, or a coefficient, exceeds its range
        Err(error) => {
            assert_eq!(error, Error::OutOfDomain);
            None
        }
    };
    (worst(double, &|_| 0.0), single)
}

#[test]
fn every_row_in_both_precisions() {
    let (mut failed, mut refused) = (0, 0);
    let rows = rows();
    for row in &rows {
        let (double, single) = match row.dimension {
            1 => check::<1>(row),
            2 => check::<2>(row),
            _ => check::<3>(row),
        };
        refused += usize::from(single.is_none());
        if double > 1.0 || single.is_some_and(|single| single > 1.0) {
            let Row { dimension, law, mollifier, delta, r, .. } = row;
            println!("FAILED {dimension} {law:?} {mollifier:?} {delta} {r}: {double} {single:?}");
            failed += 1;
        }
    }
    assert_eq!((rows.len(), failed), (774, 0));
    // Gaussian mollifiers of more than 4.7 (1D, order 6), 9.4 and 13 (2D) lengths: three kernels
    assert_eq!(refused, 9);
}

/// Two values for which a report gave the correct results.
#[test]
fn exponentials_of_short_length() {
    let compact = Mollifier::Compact { order: 8, exponent: 9 };
    let exponential = |length| one(Law::Exponential { length });
    let value = with::<f64, 1, _>(&exponential(0.1), compact, 1.0, |k| k.value(0.99)).unwrap();
    let want = -4.009_931_503_578_882_922_3e-7;
    // 1e-13 of K at delta, e^-10, whose |K| * |psi| is 5.93e-4 there
    assert!((value - want).abs() < 1e-13 * 4.54e-5, "{value:e}");
    // r = 0.0325 delta in single precision, and the Laplacian at that number's value
    let laplacian = with::<f32, 1, _>(&exponential(0.5), compact, 0.4, |k| k.laplacian(0.0128)).unwrap();
    let double =
        with::<f64, 1, _>(&exponential(0.5), compact, f64::from(0.4_f32), |k| k.laplacian(f64::from(0.0128_f32)));
    assert_eq!(laplacian, double.unwrap() as f32);
    let laplacian = with::<f64, 1, _>(&exponential(0.5), compact, 0.4, |k| k.laplacian(0.0128)).unwrap();
    assert!((laplacian + 38.635_873_283_316_286_492).abs() < 1e-13 * 51.7, "{laplacian}");
}

/// Kernels that cannot be computed to this accuracy are refused.
#[test]
fn what_the_fits_cannot_hold_is_refused() {
    let compact = |exponent| Mollifier::Compact { order: 4, exponent };
    let value = |terms: &[Term], mollifier| with::<f64, 2, _>(terms, mollifier, 1.0, |k| k.value(0.5));
    let power = |exponent| one(Law::Power { exponent });
    let screened = |k| one(Law::Screened { k });
    for (refused, mollifier) in [
        (power(-0.95), compact(1)),
        (screened(800.0), compact(4)),
        (one(Law::Exponential { length: 1.0 / 40.0 }), Mollifier::Gaussian { order: 4 }),
        (screened(40.0), Mollifier::Gaussian { order: 4 }),
    ] {
        assert_eq!(value(&refused, mollifier).err(), Some(Error::Unsupported), "{refused:?} {mollifier:?}");
    }
    for (taken, mollifier) in [
        (power(-0.95), compact(2)),
        (power(-0.9), compact(1)),
        (screened(500.0), compact(4)),
        (one(Law::Exponential { length: 1.0 / 500.0 }), compact(1)),
        (screened(25.0), Mollifier::Gaussian { order: 4 }),
    ] {
        assert!(value(&taken, mollifier).unwrap().is_finite(), "{taken:?} {mollifier:?}");
    }
}

/// Near the centre the terms of a Morse potential cancel to a twentieth in the Laplacian. The error of the sum is that of its terms.
#[test]
fn a_morse_potential_near_the_centre() {
    let terms = [
        Term { law: Law::Exponential { length: 1.0 }, coefficient: 1.0 },
        Term { law: Law::Exponential { length: 2.0 }, coefficient: -2.0 },
    ];
    let compact = Mollifier::Compact { order: 4, exponent: 4 };
    for (dimension, r, want) in MORSE {
        let delta = 0.1;
        let (got, bare) = match dimension {
            1 => (
                with::<f64, 1, _>(&terms, compact, delta, |k| k.at(r)),
                with::<f64, 1, _>(&terms, Mollifier::None, delta, |k| k.at(delta)),
            ),
            2 => (
                with::<f64, 2, _>(&terms, compact, delta, |k| k.at(r)),
                with::<f64, 2, _>(&terms, Mollifier::None, delta, |k| k.at(delta)),
            ),
            _ => (
                with::<f64, 3, _>(&terms, compact, delta, |k| k.at(r)),
                with::<f64, 3, _>(&terms, Mollifier::None, delta, |k| k.at(delta)),
            ),
        };
        let (got, bare) = (got.unwrap(), bare.unwrap());
        for n in 0..3 {
            // relative to the scale of the sum, which is smaller than that of its terms
            let scale = want[n].abs().max(bare[n].abs()).max(if n == 2 { bare[1].abs() } else { 0.0 });
            let error = (got[n] - want[n]).abs() / scale;
            assert!(error < 1e-13, "{dimension} {r} {n}: {} {} {error:e}", got[n], want[n]);
        }
    }
}

/// Dimension, r, and value, gradient factor, Laplacian at delta = 0.1, integrated in the same way as the rows of the table.
const MORSE: [(usize, f64, [f64; 3]); 6] = [
    (1, 0.0, [-0.99999804099749620, 0.49154298392359131, 0.49154298392359131]),
    (1, 0.0048828125, [-0.99999218204837739, 0.49142564492481704, 0.49119144561087575]),
    (2, 0.0, [-0.99999586548515837, 0.49041283533857605, 0.98082567067715210]),
    (2, 0.0048828125, [-0.99999001995173030, 0.49030500166585670, 0.98039474015275387]),
    (3, 0.0, [-0.99999366440665688, 0.48953034952952128, 1.46859104858856384]),
    (3, 0.0048828125, [-0.99998782935411048, 0.48942907920984946, 1.46808505255718378]),
];

/// Powers without a mollifier: r^p/p, r^(p-2), (p + d - 2) r^(p-2) where these are in range, otherwise infinite or zero.
#[test]
fn powers_keep_their_range() {
    fn at<T: Real>(p: f64, r: f64) -> [f64; 3] {
        let terms = one(Law::Power { exponent: p });
        with::<T, 2, _>(&terms, Mollifier::None, T::ONE, |k| k.at(T::from_f64(r))).unwrap().map(Scalar::to_f64)
    }
    let inf = f64::INFINITY;
    for (p, r, want) in [
        (8.0, 1e5, [inf, 1e30, 8e30]),
        (8.0, 1e-6, [0.0, 1e-36, 8e-36]),
        (3.0, 1e15, [inf, 1e15, 3e15]),
        (-0.5, 1e-30, [-2e15, inf, -inf]),
        (0.0, 1e-15, [1e-15_f64.ln(), 1e30, 0.0]),
        (0.0, 1e30, [1e30_f64.ln(), 0.0, 0.0]),
    ] {
        let r = f64::from(r as f32);
        // rounding r to single precision changes r^p by p u
        for (got, want) in at::<f32>(p, r).into_iter().zip(want) {
            let close = got == want || (got - want).abs() <= 16.0 * f64::from(f32::EPSILON) * want.abs();
            assert!(close, "f32 {p} {r}: {got:e} {want:e}");
        }
    }
    for (p, r, want) in [
        (2.0, 1e-200, [0.0, 1.0, 2.0]),
        (2.0, 1e200, [inf, 1.0, 2.0]),
        (3.0, 1e200, [inf, 1e200, 3e200]),
        (4.0, 1e-150, [0.0, 1e-300, 4e-300]),
        (1.5, 1e-200, [1e-300 / 1.5, 1e100, 1.5e100]),
        (-0.5, 1e-200, [-2e100, inf, -inf]),
        (-0.5, 1e100, [-2e-50, 1e-250, -5e-251]),
        (0.25, 1e250, [4e62 * 10.0_f64.sqrt(), 0.0, 0.0]),
    ] {
        for (got, want) in at::<f64>(p, r).into_iter().zip(want) {
            let close = got == want || (got - want).abs() <= 1e-13 * want.abs();
            assert!(close, "f64 {p} {r}: {got:e} {want:e}");
        }
    }
}

/// Mollified kernels far outside and far inside the support, and gradients at points whose |x|^2 or K'/r is out of range.
#[test]
fn mollified_powers_and_gradients_at_points_keep_their_range() {
    let compact = Mollifier::Compact { order: 4, exponent: 4 };
    // far outside the mollifier has no effect
    for (p, delta, r) in [(2.0, 1e-250, 1e-200), (3.0, 1e-3, 1e150), (1.5, 1.0, 1e180), (8.0, 1e-45, 1e-40)] {
        let gradient = with::<f64, 2, _>(&one(Law::Power { exponent: p }), compact, delta, |k| k.gradient_factor(r));
        let want = r.powf(p - 2.0);
        assert!((gradient.unwrap() - want).abs() <= 1e-13 * want, "{p} {delta} {r}");
    }
    for mollifier in [Mollifier::None, compact] {
        let power = |p: f64, x: [f64; 2]| {
            let terms = one(Law::Power { exponent: p });
            with::<f64, 2, _>(&terms, mollifier, 1e-30, |k| k.gradient_at(&x)).unwrap()
        };
        // r^(p-1) x/|x| with |x| = 5e200, 5e-20
        for (p, x, size) in [(1.5, [3e200, -4e200], 5e200_f64.sqrt()), (0.5, [3e-20, -4e-20], 5e-20_f64.powf(-0.5))] {
            let [a, b] = power(p, x);
            assert!((a - 0.6 * size).abs() <= 1e-13 * size && (b + 0.8 * size).abs() <= 1e-13 * size, "{p} {a} {b}");
        }
    }
    // without a mollifier at any distance: K'/r = 1e450, K' = 1e150
    let terms = one(Law::Power { exponent: 0.5 });
    let at = |x: [f64; 2]| with::<f64, 2, _>(&terms, Mollifier::None, 1.0, |k| k.gradient_at(&x)).unwrap();
    let [a, b] = at([0.0, -1e-300]);
    assert!(a == 0.0 && (b + 1e150).abs() < 1e-13 * 1e150);
    assert_eq!(at([0.0, 0.0]), [0.0, 0.0]);
    assert!(at([f64::NAN, 0.0])[0].is_nan());
    let single = with::<f32, 3, _>(&terms, Mollifier::None, 1.0, |k| k.gradient_at(&[0.0, 3e-30, 4e-30])).unwrap();
    let size = 5e-30_f64.powf(-0.5);
    assert!((f64::from(single[1]) / (0.6 * size) - 1.0).abs() < 1e-6 && single[0] == 0.0);
    // a Newtonian term beside a power
    let sum =
        [Term { law: Law::Newtonian, coefficient: 2.0 }, Term { law: Law::Power { exponent: 2.0 }, coefficient: 3.0 }];
    let [x, y, z] = with::<f64, 3, _>(&sum, compact, 0.5, |k| k.gradient_at(&[3.0, 0.0, 4.0])).unwrap();
    let factor = 3.0 + 2.0 / (4.0 * std::f64::consts::PI * 125.0);
    assert!((x - 3.0 * factor).abs() < 1e-14 && y == 0.0 && (z - 4.0 * factor).abs() < 1e-14 * 13.0);
}

/// Laws whose lengths are at the limits of the number range.
#[test]
fn exponentials_keep_their_range() {
    let at = |law, r| with::<f64, 3, _>(&one(law), Mollifier::None, 1.0, |k| k.at(r)).unwrap();
    let close = |got: [f64; 3], want: [f64; 3]| {
        for (got, want) in got.into_iter().zip(want) {
            assert!(got == want || (got - want).abs() <= 1e-13 * want.abs(), "{got:e} {want:e}");
        }
    };
    let e = (-1.0_f64).exp();
    // K = e^(-r/l): K'/r = -K/(l r), the Laplacian K/l (1/l - 2/r)
    close(at(Law::Exponential { length: 1e-120 }, 1e-120), [e, -e * 1e240, -e * 1e240]);
    close(at(Law::Exponential { length: 1e120 }, 1e120), [e, -e * 1e-240, -e * 1e-240]);
    close(at(Law::Exponential { length: 1e-3 }, 1e10), [0.0; 3].map(|v: f64| -v.abs()));
    let c = 0.25 / std::f64::consts::PI;
    // -e^(-kr) c/r, (1 + kr) e^(-kr) c/r^3, k^2 K
    close(at(Law::Screened { k: 1e-90 }, 1e90), [-e * c * 1e-90, 2.0 * e * c * 1e-270, -e * c * 1e-270]);
    close(at(Law::Screened { k: 1e90 }, 1e-90), [-e * c * 1e90, 2.0 * e * c * 1e270, -e * c * 1e270]);
}
