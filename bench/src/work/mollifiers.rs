//! Values of a compact mollifier in several arithmetics and forms.

use anyhow::Result;
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::real::Real;
use mollis_reference::field::Dd;

use super::{Curve, Row, Study, Work, least_time};

const DELTA: f64 = 0.7;
/// Radii within delta.
const RADII: usize = 4000;
const EXPONENTS: [u32; 5] = [1, 3, 5, 7, 9];

/// psi of order 4 in the plane times 2 pi delta^2 is -2 (M + 1) (M + 2) t^M + 2 (M + 2) (M + 3) t^(M + 1), t = 1 - (r / delta)^2.
fn coefficients(exponent: u32) -> [f64; 2] {
    let m = f64::from(exponent);
    [-2.0 * (m + 1.0) * (m + 2.0), 2.0 * (m + 2.0) * (m + 3.0)]
}

fn binomial(n: u32, k: u32) -> f64 {
    (0..k).fold(1.0, |c, j| c * f64::from(n - j) / f64::from(j + 1))
}

/// The same polynomial in powers of (r / delta)^2, as papers print it: whole numbers, exact.
fn power_basis(exponent: u32) -> Vec<f64> {
    let [a, b] = coefficients(exponent);
    let of = |k: u32| if k > exponent { 0.0 } else { a * binomial(exponent, k) };
    let sign = |k: u32| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    (0..=exponent + 1).map(|k| sign(k) * (of(k) + b * binomial(exponent + 1, k))).collect()
}

fn in_powers<T: Real>(coefficients: &[T], scale: T, r: T) -> T {
    let s = r / T::from_f64(DELTA) * (r / T::from_f64(DELTA));
    scale * coefficients.iter().rev().fold(T::ZERO, |sum, &c| sum * s + c)
}

fn in_double_double(exponent: u32, r: f64) -> Dd {
    let (r, delta, one) = (Dd(r, 0.0), Dd(DELTA, 0.0), Dd(1.0, 0.0));
    let square = delta * delta;
    let t = one - r * r / square;
    let power = (0..exponent).fold(one, |power, _| power * t);
    let [a, b] = coefficients(exponent);
    let two_pi = Dd(core::f64::consts::TAU, 2.449_293_598_294_706_4e-16);
    power * (Dd(a, 0.0) + Dd(b, 0.0) * t) / (two_pi * square)
}

/// The study.
pub fn study(_: &Work) -> Result<Study> {
    let radii: Vec<f64> = (0..RADII).map(|k| DELTA * (k as f64 + 0.5) / RADII as f64).collect();
    // Exact in single precision, so that all forms are asked for the same number.
    let radii: Vec<f64> = radii.into_iter().map(|r| f64::from(r as f32)).collect();
    let exact = EXPONENTS.map(|m| radii.iter().map(|&r| in_double_double(m, r)).collect::<Vec<Dd>>());
    let curve = |name: &str, row: &dyn Fn(usize) -> Result<Row>| -> Result<Curve> {
        Ok(Curve { name: name.to_owned(), rows: (0..EXPONENTS.len()).map(row).collect::<Result<_>>()? })
    };
    let row = |which: usize, psi: &mut dyn FnMut(f64) -> f64| -> Result<Row> {
        let largest = exact[which].iter().map(|x| x.value().abs()).fold(0.0, f64::max);
        let differences = radii.iter().zip(&exact[which]).map(|(&r, x)| (Dd(psi(r), 0.0) - *x).value().abs());
        let error = differences.fold(0.0, f64::max) / largest;
        let seconds = least_time(|| {
            radii.iter().for_each(|&r| {
                std::hint::black_box(psi(std::hint::black_box(r)));
            });
            Ok(())
        })?;
        Ok(Row {
            setting: format!("M = {}", EXPONENTS[which]),
            time: 1e9 * seconds / RADII as f64,
            error,
            spread: None,
        })
    };
    let mollifier = |which: usize| Mollifier::Compact { order: 4, exponent: EXPONENTS[which] };
    let scale = 1.0 / (core::f64::consts::TAU * DELTA * DELTA);
    let curves = vec![
        curve("mollis, f64: powers of t", &|which| {
            let blob = Blob::<f64, 2>::new(mollifier(which), DELTA)?;
            row(which, &mut |r| blob.density(r))
        })?,
        curve("mollis, f32: powers of t", &|which| {
            let blob = Blob::<f32, 2>::new(mollifier(which), DELTA as f32)?;
            row(which, &mut |r| f64::from(blob.density(r as f32)))
        })?,
        curve("f64: plain powers of t", &|which| {
            row(which, &mut |r| {
                let t = (DELTA - r) * (DELTA + r) / (DELTA * DELTA);
                let [a, b] = coefficients(EXPONENTS[which]);
                scale * (0..EXPONENTS[which]).fold(1.0, |power, _| power * t) * (a + b * t)
            })
        })?,
        curve("f64: powers of r, as printed", &|which| {
            let coefficients = power_basis(EXPONENTS[which]);
            row(which, &mut |r| in_powers(&coefficients, scale, r))
        })?,
        curve("f32: powers of r, as printed", &|which| {
            let coefficients: Vec<f32> = power_basis(EXPONENTS[which]).into_iter().map(|c| c as f32).collect();
            row(which, &mut |r| f64::from(in_powers(&coefficients, scale as f32, r as f32)))
        })?,
        curve("double-double, rounded", &|which| row(which, &mut |r| in_double_double(EXPONENTS[which], r).value()))?,
    ];
    Ok(Study {
        name: "mollifiers",
        question: "What does it cost to evaluate a mollifier, and what is lost in the form that papers print?",
        about: format!(
            "Compact mollifiers of order 4 in the plane, M = 1 to 9, at {RADII} radii within their support, one call a radius. Powers of r lose a factor of more than 2^M, as their terms cancel; \
             powers of t = 1 - (r / delta)^2 do not. mollis' functions of one radius also serve any radius and length in the range of the numbers and round once, and pay for it; its sums over pairs \
             evaluate powers of t in lanes, at less than a nanosecond a pair."
        ),
        unit: "ns a value",
        error: "largest error, relative to the largest value",
        digits: &[],
        curves,
        notes: vec![],
    })
}
