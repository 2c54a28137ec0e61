//! Discrete norms of grid functions and of differences of trajectories (Craig & Bertozzi, section 3).

use super::compensated::Sum;
use crate::error::{Error, Result};
use crate::real::{Extended, Real, Scalar, length};

/// `(sum_i |u_i|^p cell)^(1/p)`, the L^p_h norm with `cell` = h^d; the largest `|u_i|` for infinite `p`.
///
/// Values are scaled by the largest one, so that no power overflows, and summed in double precision with compensation. The result has a few
/// roundings for any n, in single precision two. No values give 0; NaN gives NaN.
///
/// # Errors
/// [`Error::OutOfDomain`]: `p` is below 1 or NaN, or `cell` is not positive and finite.
pub fn norm<T: Real>(values: &[T], cell: T, p: T) -> Result<T> {
    check(cell, p)?;
    let mean = power_mean(|unit| values.iter().map(move |v| v.abs().to_f64() * unit), cell.to_f64(), p.to_f64());
    Ok(T::from_f64(mean.get()))
}

/// The L^p_h norm of `|a_i - b_i|` (Euclidean), for the error of trajectories.
///
/// # Errors
/// [`Error::LengthMismatch`]; those of [`norm`].
pub fn distance<T: Real, const D: usize>(a: &[[T; D]], b: &[[T; D]], cell: T, p: T) -> Result<T> {
    if a.len() != b.len() {
        return Err(Error::LengthMismatch);
    }
    let part = |x: &[T; D], k: usize| x.get(k).map_or(0.0, |c| c.to_f64());
    let apart = |unit: f64| {
        a.iter()
            .zip(b)
            .map(move |(a, b)| length::<f64, D>(&core::array::from_fn(|k| part(a, k) * unit - part(b, k) * unit)))
    };
    check(cell, p)?;
    Ok(T::from_f64(power_mean(apart, cell.to_f64(), p.to_f64()).get()))
}

/// The W^{1,p}_h norm of a function on a box of the lattice h Z^D, `(|u|^p + sum_j |D_j u|^p)^(1/p)` in L^p_h with the forward differences `D_j u = (u_(i + e_j) - u_i) / h`; for
/// infinite `p` the largest of all. Outside the box the function is zero, so the differences at its border count.
///
/// `values`: one for each point of the box, the first axis fastest. W^{-1,p}_h, its dual, is there for p = 2 ([`super::Lattice::dual_norm`]), where the supremum is the solution of a linear
/// system; for other p it would be that of a nonlinear one, and is not offered.
///
/// # Errors
/// [`Error::LengthMismatch`]; [`Error::OutOfDomain`]: `p` is below 1 or NaN, or h or h^D is not positive and finite. NaN gives NaN.
pub fn sobolev<T: Real, const D: usize>(points: &[usize; D], values: &[T], spacing: T, p: T) -> Result<T> {
    let count = points.iter().try_fold(1_usize, |product, &n| product.checked_mul(n)).ok_or(Error::TooLarge)?;
    if values.len() != count {
        return Err(Error::LengthMismatch);
    }
    let h = spacing.to_f64();
    let cell = Scalar::powi(h, D as u32);
    check(spacing, p)?;
    check(cell, p.to_f64())?;
    // Of h u and differences, or of u and differences over h: neither is beyond the range where the norm is not.
    let (of_values, of_differences) = if h < 1.0 { (h, 1.0) } else { (1.0, 1.0 / h) };
    let at = |k: usize| values.get(k).map_or(0.0, |v| v.to_f64());
    let all = |unit: f64| {
        let differences = (0..D).flat_map(move |axis| {
            let pitch = points.iter().take(axis).product::<usize>();
            let n = points.get(axis).copied().unwrap_or(0);
            (0..count).flat_map(move |k| {
                let place = k / pitch.max(1) % n.max(1);
                let next = if place + 1 < n { at(k + pitch) } else { 0.0 };
                // The first point of a line has one before it.
                let before = (place == 0).then(|| at(k) * unit);
                core::iter::once(next * unit - at(k) * unit).chain(before)
            })
        });
        let differences = differences.map(move |d| d.abs() * of_differences);
        values.iter().map(move |v| v.abs().to_f64() * unit * of_values).chain(differences)
    };
    let norm = power_mean(all, cell, p.to_f64());
    Ok(T::from_f64(if h < 1.0 { norm.times(Extended::new(1.0 / h, 0)).get() } else { norm.get() }))
}

/// Refuses what is no volume of a cell, or no exponent.
fn check<T: Real>(cell: T, p: T) -> Result<()> {
    if p.is_nan() || p < T::ONE || !(cell > T::ZERO && cell.is_finite()) { Err(Error::OutOfDomain) } else { Ok(()) }
}

/// The norm of values that are not negative; `values` gives them times a power of two, which keeps them in range.
fn power_mean<V: Iterator<Item = f64>>(values: impl Fn(f64) -> V, cell: f64, p: f64) -> Extended {
    let most = |unit: f64| values(unit).fold(0.0_f64, |m, v| if v > m || v.is_nan() { v } else { m });
    // A sixteenth loses nothing that counts beside a value beyond the range.
    let (mut largest, mut unit, mut down) = (most(1.0), 1.0, 0);
    if largest == f64::INFINITY {
        (largest, unit, down) = (most(1.0 / 16.0), 1.0 / 16.0, 4);
    }
    if largest == 0.0 || !largest.is_finite() || p == f64::INFINITY {
        return Extended::new(largest, down);
    }
    let mut sum = Sum::<f64>::default();
    for v in values(unit) {
        let q = v / largest;
        sum.add(if p == 1.0 {
            q
        } else if p == 2.0 {
            q * q
        } else {
            Scalar::pow(q, p)
        });
    }
    // sum cell = mean 2^exponent may be out of range where its root is not, so integer powers of two are kept separately.
    let (sum, of_sum) = sum.value().frexp();
    let (share, of_share) = cell.frexp();
    let (mean, exponent) = (sum * share, of_sum + of_share);
    let whole = (f64::from(exponent) / p).to_i32();
    let rest = f64::from(exponent) - f64::from(whole) * p;
    let root = if p == 1.0 {
        mean
    } else if p == 2.0 {
        mean.ldexp(rest.to_i32()).sqrt()
    } else {
        Scalar::pow(mean, 1.0 / p) * Scalar::pow(2.0_f64, rest / p)
    };
    Extended::new(largest, down).times(Extended::new(root, whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_norms() {
        let values = [3.0, -4.0, 0.0];
        assert_eq!(norm(&values, 0.25, 1.0), Ok(1.75));
        assert_eq!(norm(&values, 0.25, 2.0), Ok(2.5));
        assert_eq!(norm(&values, 0.25, f64::INFINITY), Ok(4.0));
        assert_eq!(norm(&[1e300, 1e300], 0.5, 2.0), Ok(1e300));
        assert_eq!(norm::<f32>(&[], 0.5, 3.0), Ok(0.0));
        assert!(norm(&[1.0, f64::NAN, 2.0], 0.5, 2.0).unwrap().is_nan());
        assert_eq!(distance(&[[3.0, 4.0], [0.0, 1.0]], &[[0.0, 0.0], [0.0, 0.0]], 0.5, 1.0), Ok(3.0));
        // Five roundings.
        let huge: f64 = distance(&[[3.0e200, 4.0e200]], &[[0.0; 2]], 1.0, 1.0).unwrap();
        assert!((huge / 5e200 - 1.0).abs() < 5.0 * f64::EPSILON);
    }

    /// One point: its value, and a difference before and behind it along each axis.
    #[test]
    fn sobolev_norms_of_a_point() {
        for (h, p) in [(0.5_f64, 1.0), (0.5, 2.0), (2.0, 3.0), (1e-3, 1.5), (1e-200, 2.0), (1e90, 2.0)] {
            let want = |d: f64| {
                let (of_value, of_slopes) =
                    (Scalar::pow(h, d / p), Scalar::pow(2.0 * d, 1.0 / p) * Scalar::pow(h, d / p - 1.0));
                let most = of_value.max(of_slopes);
                3.0 * most * Scalar::pow(Scalar::pow(of_value / most, p) + Scalar::pow(of_slopes / most, p), 1.0 / p)
            };
            let near = |got: Result<f64>, want: f64| {
                let got = got.unwrap();
                assert!((got / want - 1.0).abs() < 1e-12, "{h} {p}: {got:e} {want:e}");
            };
            near(sobolev(&[1], &[-3.0], h, p), want(1.0));
            if h > 1e-100 {
                near(sobolev(&[1, 1], &[3.0], h, p), want(2.0));
                near(sobolev(&[3, 1, 2], &[0.0, 0.0, 0.0, 0.0, 3.0, 0.0], h, p), want(3.0));
            }
        }
        assert_eq!(sobolev(&[2, 2], &[1.0, -4.0, 2.0, 0.5], 0.5, f64::INFINITY), Ok(10.0));
        assert_eq!(sobolev::<f64, 2>(&[0, 4], &[], 0.5, 2.0), Ok(0.0));
        assert!(sobolev(&[2], &[f64::NAN, 1.0], 0.5, 2.0).unwrap().is_nan());
        assert_eq!(sobolev(&[2, 2], &[1.0; 3], 0.5, 2.0), Err(Error::LengthMismatch));
        for (h, p) in [(0.0, 2.0), (-1.0, 2.0), (f64::NAN, 2.0), (1e-200, 2.0), (1.0, 0.5), (1.0, f64::NAN)] {
            assert_eq!(sobolev(&[1, 1], &[1.0], h, p), Err(Error::OutOfDomain));
        }
    }

    /// e^(-|x|^2) in the plane: the square of its norm in W^{1,2} is 3 pi / 2. Forward differences are centred between points.
    #[test]
    fn sobolev_norms_converge() {
        let mut last = 0.0;
        for k in [1, 2] {
            let (h, n) = (0.1 / f64::from(k), 100 * k as usize + 1);
            let x = |i: usize| (i as f64 - (n / 2) as f64) * h;
            let values: std::vec::Vec<f64> =
                (0..n * n).map(|i| libm::exp(-x(i % n) * x(i % n) - x(i / n) * x(i / n))).collect();
            let error = sobolev(&[n, n], &values, h, 2.0).unwrap() - Scalar::sqrt(1.5 * core::f64::consts::PI);
            assert!(k == 1 || (last / error - 4.0).abs() < 0.02, "{last:e} {error:e}");
            last = error;
        }
    }

    /// 2^25 ones. Their sum of squares exceeds the integers that single precision can count.
    #[test]
    fn long_norms_in_single_precision() {
        let ones = std::vec![1.0_f32; 1 << 25];
        assert_eq!(norm(&ones, 1.0, 1.0), Ok(33_554_432.0));
        // 2^12.5, rounded once.
        let root = 5_792.618_751_480_198_f64 as f32;
        assert_eq!(norm(&ones, 1.0, 2.0), Ok(root));
        let zeros = std::vec![[0.0_f32]; 1 << 25];
        let (ones, _) = ones.as_chunks::<1>();
        assert_eq!(distance(ones, &zeros, 1.0, 2.0), Ok(root));
        assert_eq!(distance(ones, &zeros, 0.25, 1.0), Ok(8_388_608.0));
    }

    #[test]
    fn norms_at_the_ends_of_the_range() {
        // (3^2 + 4^2)^(1/2) = 5, (27 + 64 + 125)^(1/3) = 6, at scales of values and cell.
        for exponent in [-1070, -1000, -500, 0, 500, 1000, 1020] {
            for cell in [-1074, -900, 0, 900, 1023] {
                for (p, values, want) in
                    [(1.0, [1.0, 1.0, 2.0], 4.0), (2.0, [3.0, 4.0, 0.0], 5.0), (3.0, [3.0, 4.0, 5.0], 6.0)]
                {
                    let values: [f64; 3] = values.map(|v: f64| v.ldexp(exponent));
                    let got: f64 = norm(&values, 1.0_f64.ldexp(cell), p).unwrap();
                    let (whole, rest) = (i32::div_euclid(cell, p as i32), i32::rem_euclid(cell, p as i32));
                    let want = (want * libm::exp2(f64::from(rest) / p)).ldexp(exponent + whole);
                    // About ten roundings; for subnormal results one unit.
                    let close = (got - want).abs() <= 16.0 * f64::EPSILON * want + 5e-324;
                    assert!(close || got == want, "{exponent} {cell} {p}: {got:e} {want:e}");
                }
            }
        }
        assert_eq!(norm(&[1.0, 2.0], 1.0, 1e300), Ok(2.0));
        // Differences beyond the range: 3.4e308 in one dimension, 5 2^1023 in two.
        let far: f64 = distance(&[[1.7e308, 0.0]], &[[-1.7e308, 0.0]], 1e-10, 1.0).unwrap();
        assert!((far / 3.4e298 - 1.0).abs() <= 8.0 * f64::EPSILON, "{far:e}");
        let (half, side) = (1.0_f64.ldexp(1023), 1.5_f64.ldexp(1023));
        for (p, cell, want) in [(1.0, 0.25, 0.625), (2.0, 0.0625, 0.625), (f64::INFINITY, 0.25, f64::INFINITY)] {
            let far: f64 = distance(&[[side, half], [1.0, 1.0]], &[[0.0, -half], [1.0, 1.0]], cell, p).unwrap();
            let want = want * half;
            assert!(far == want || (far / want - 1.0).abs() <= 8.0 * f64::EPSILON, "{p} {far:e}");
        }
        assert_eq!(distance(&[[f64::INFINITY]], &[[0.0]], 1e-300, 2.0), Ok(f64::INFINITY));
        assert!(distance(&[[f64::INFINITY]], &[[f64::INFINITY]], 1.0, 2.0).unwrap().is_nan());
        // Squares of these underflow in single precision.
        let tiny: f32 = distance(&[[3e-30, 0.0]], &[[0.0, 4e-30]], 1.0, 1.0).unwrap();
        assert!((tiny / 5e-30 - 1.0).abs() <= 2.0 * f32::EPSILON);
    }

    #[test]
    fn refusals() {
        for p in [0.5, f64::NAN, -1.0] {
            assert_eq!(norm(&[1.0], 1.0, p), Err(Error::OutOfDomain));
        }
        for cell in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(norm(&[1.0], cell, 1.0), Err(Error::OutOfDomain));
        }
        assert_eq!(distance(&[[1.0]], &[], 1.0, 1.0), Err(Error::LengthMismatch));
    }
}
