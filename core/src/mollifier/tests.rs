use std::string::{String, ToString};
use std::vec::Vec;

use serde_json::Value;

use super::law::{Rational, gradient, taylor};
use super::series::{Exact, Polynomial};
use super::*;
use crate::real::{DoubleWord, Real};

fn rational(text: &Value) -> Rational {
    let text = text.as_str().unwrap();
    let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
    Rational::new(numerator.parse().unwrap(), denominator.parse().unwrap())
}

fn rationals(list: &Value) -> Vec<Rational> {
    let mut all: Vec<_> = list.as_array().unwrap().iter().map(rational).collect();
    while all.last() == Some(&Rational::ZERO) {
        all.pop();
    }
    all
}

/// (N, order, M, the entry of the reference) of all 3 x 4 x 9 mollifiers.
fn reference() -> Vec<(u32, u32, u32, Value)> {
    let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/coeffs.json"));
    let all: Value = serde_json::from_str(text).unwrap();
    let mut entries = Vec::new();
    for n in 1..=3 {
        for order in [2, 4, 6, 8] {
            for m in 1..=9 {
                let entry = all[["N", &n.to_string(), "_o", &order.to_string(), "_M", &m.to_string()].concat()].clone();
                assert!(entry.is_object());
                entries.push((n, order, m, entry));
            }
        }
    }
    entries
}

/// The polynomials in exact arithmetic: (b, B'/r, G, H, P, R and centre of 1D).
struct Law {
    density: Vec<Rational>,
    density_slope: Vec<Rational>,
    gradient: Vec<Rational>,
    hessian: Vec<Rational>,
    potential: Vec<Rational>,
    rise: Vec<Rational>,
    centre: Rational,
}

fn law(n: u32, order: u32, m: u32) -> Law {
    let degree = m + order / 2 - 1;
    let g = |k| gradient(n, m, order / 2, k);
    let b = |k: u32| g(k).times((n + 2 * k).into(), 1).plus(g(k + 1).times(-2 * i128::from(k + 1), 1));
    assert!((0..m).all(|k| b(k) == Rational::ZERO));
    let mut potential = std::vec![Rational::new(i128::from(2 - n as i32), 1)];
    potential.extend((0..=degree).map(|k| g(k).times(-1, 2 * i128::from(k + 1))));
    let rise: Vec<_> = (0..=degree)
        .map(|j| (j..=degree).map(|k| g(k).times(1, i128::from(k + 1))).fold(Rational::ZERO, Rational::plus))
        .collect();
    Law {
        density: (0..=degree).map(b).collect(),
        density_slope: (1..=degree).map(|k| b(k).times(-2 * i128::from(k), 1)).collect(),
        gradient: (0..=degree).map(g).collect(),
        hessian: (1..=degree).map(|k| g(k).times(-2 * i128::from(k), 1)).collect(),
        potential,
        centre: Rational::ONE.plus(rise[0].times(-1, 2)),
        rise,
    }
}

#[test]
fn the_law_gives_every_reference_coefficient_exactly() {
    for (n, order, m, entry) in reference() {
        let ours = law(n, order, m);
        let name = [n, order, m];
        assert_eq!(ours.density, rationals(&entry["B"]["t"]), "{name:?}");
        assert_eq!(ours.gradient, rationals(&entry["g"]["t"]), "{name:?}");
        assert_eq!(ours.hessian, rationals(&entry["h"]["t"]), "{name:?}");
        assert_eq!(ours.potential, rationals(&entry["phi"]["t"]), "{name:?}");
        assert_eq!(ours.density_slope, rationals(&entry["Bp"]["t"]), "{name:?}");
        // The reference lists the positive form up to order 6. Beyond, it follows from the gradient.
        if n == 1 && order <= 6 {
            assert_eq!(ours.rise, rationals(&entry["phi_pos"]["P"]), "{name:?}");
            assert_eq!(ours.centre, rational(&entry["phi_pos"]["c"]), "{name:?}");
        }
    }
}

#[test]
fn only_the_top_coefficients_leave_the_taylor_series() {
    assert_eq!(taylor(3, 2), Rational::new(15, 8));
    assert_eq!(gradient(2, 4, 2, 5), Rational::new(7, 1));
    assert_eq!(gradient(3, 4, 3, 5), Rational::new(-129_591, 2048));
    assert_eq!(gradient(3, 4, 3, 7), Rational::ZERO);
}

/// Asserts |prepared - exact| <= 2^-digits |exact| in integers, with prepared = a / 2^p.
fn agree<T: Real>(got: &[DoubleWord<T>], want: &[Rational], digits: u32, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (c, exact) in got.iter().zip(want) {
        let fixed = |x: f64| -> i128 {
            // Bits below 2^-98 are cut off. The coefficients are below 2^28.
            let scaled = libm::ldexp(x, 98);
            assert!(scaled.abs() < 1.7e38);
            scaled as i128
        };
        let got = fixed(c.hi.to_f64()) + fixed(c.lo.to_f64());
        // exact * 2^98, bit by bit, so that nothing overflows
        let quotient = exact.numerator / exact.denominator;
        let rest = exact.numerator % exact.denominator;
        let mut want = quotient;
        let mut left = rest;
        for _ in 0..98 {
            left *= 2;
            want = want * 2 + left / exact.denominator;
            left %= exact.denominator;
        }
        let error = (got - want).abs();
        assert!(error <= (want.abs() >> digits) + 2, "{what}: {c:?} against {exact:?}");
    }
}

fn prepared_series_hold_both_words<T: Real, const D: usize>(digits: u32) {
    for (n, order, m, _) in reference().into_iter().filter(|&(n, ..)| n as usize == D) {
        let law = law(n, order, m);
        let exact = Exact::<T, D>::new(order, m);
        let what: String = std::format!("N{n} order {order} M{m} {}", core::any::type_name::<T>());
        let series = |of| (0..exact.terms(of)).map(|k| exact.coefficient(of, k)).collect::<Vec<_>>();
        agree(&series(Polynomial::Density), &law.density, digits, &what);
        agree(&series(Polynomial::DensitySlope), &law.density_slope, digits, &what);
        agree(&series(Polynomial::Gradient), &law.gradient, digits, &what);
        agree(&series(Polynomial::Hessian), &law.hessian, digits, &what);
        agree(&series(Polynomial::Potential), &law.potential, digits, &what);
        if n == 1 {
            let mut rise: Vec<_> = exact.rise().collect();
            rise.reverse();
            agree(&rise, &law.rise, digits, &what);
        }
    }
}

#[test]
fn prepared_coefficients_are_the_exact_ones_to_twice_the_digits() {
    // One rounding of a stored word pair is 2^-106 (2^-48). The recurrence of the density cancels up to 2^10.
    prepared_series_hold_both_words::<f64, 1>(94);
    prepared_series_hold_both_words::<f64, 2>(94);
    prepared_series_hold_both_words::<f64, 3>(94);
    prepared_series_hold_both_words::<f32, 1>(36);
    prepared_series_hold_both_words::<f32, 2>(36);
    prepared_series_hold_both_words::<f32, 3>(36);
}

#[test]
fn mollifiers_that_do_not_exist_are_refused() {
    let compact = |order, exponent| Mollifier::Compact { order, exponent };
    assert_eq!(compact(4, 9).check(3), Ok(()));
    for (mollifier, dimension, error) in [
        (Mollifier::None, 0, Error::Dimension),
        (compact(2, 1), 4, Error::Dimension),
        (compact(3, 1), 2, Error::Order),
        (compact(0, 1), 2, Error::Order),
        (compact(10, 1), 2, Error::Order),
        (compact(2, 0), 2, Error::Exponent),
        (compact(2, 10), 2, Error::Exponent),
        (Mollifier::Gaussian { order: 8 }, 2, Error::Order),
        (Mollifier::Gaussian { order: 3 }, 1, Error::Order),
        (Mollifier::Vatistas, 1, Error::Dimension),
        (Mollifier::Vatistas, 3, Error::Dimension),
    ] {
        assert_eq!(mollifier.check(dimension), Err(error), "{mollifier:?} {dimension}");
    }
    for delta in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Blob::<f64, 2>::new(compact(2, 1), delta).err(), Some(Error::Delta));
        assert!(Blob::<f64, 2>::new(Mollifier::None, delta).is_ok());
    }
}

/// Horner's rule of degree n has 2n + 1 roundings. t = (delta^2 - r^2)/delta^2 has four, amplified n times. The scale factor
/// and the product have three. The sum is (6n + 4) u of the sum of |c_k|, which is the condition of the series times its maximum.
#[test]
fn plain_polynomials_meet_their_bound() {
    fn check<T: Real, const D: usize>() {
        for (_, order, exponent, _) in reference().into_iter().filter(|e| e.0 == D as u32) {
            let delta = T::from_f64(0.37);
            let blob = Blob::<T, D>::new(Mollifier::Compact { order, exponent }, delta).unwrap();
            let p = blob.polynomials().unwrap();
            let square = delta * delta;
            let compare = |series: &Series<T>, scale: T, accurate: &dyn Fn(T) -> T| {
                let size: f64 = series.coefficients().iter().map(|c| (*c * scale).abs().to_f64()).sum();
                let bound = (6 * series.degree() + 4) as f64 * T::EPSILON.to_f64() / 2.0 * size;
                for i in 0..=64 {
                    let r = delta * T::from_i32(i) / T::from_i32(64);
                    let plain = scale * series.at((square - r * r) / square);
                    let error = (plain - accurate(r)).abs().to_f64();
                    assert!(error <= bound, "D{D} order {order} M{exponent} r = {r}: {error} {bound}");
                }
            };
            compare(&p.density, p.scale, &|r| blob.density(r));
            compare(&p.gradient, p.scale, &|r| blob.gradient_factor(r));
            compare(&p.hessian, p.hessian_scale, &|r| blob.hessian_factor(r));
            compare(&p.density_slope, p.hessian_scale, &|r| blob.density_slope(r));
            if D != 2 {
                compare(&p.potential, p.potential_scale, &|r| blob.potential(r));
            }
        }
    }
    check::<f64, 1>();
    check::<f64, 2>();
    check::<f64, 3>();
    check::<f32, 1>();
    check::<f32, 2>();
    check::<f32, 3>();
}
