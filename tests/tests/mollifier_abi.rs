//! Mollifiers through the C ABI: values, each refusal, and untouched outputs.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ptr::{null, null_mut};

use mollis_core::Error;
use mollis_core::mollifier::{Blob, Mollifier, Quantity};

use mollis_abi::*;

const N: usize = 5;
const RADII: [f64; N] = [0.0, 0.25, 0.5, 1.0, 3.0];
const GOOD: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 4, exponent: 3 };

const CORE: Mollifier = Mollifier::Compact { order: 4, exponent: 3 };

fn with(kind: i32, order: i32, exponent: i32) -> mollis_mollifier {
    mollis_mollifier { kind, order, exponent }
}

#[test]
fn values_are_those_of_core_and_null_outputs_are_skipped() {
    let blob = Blob::<f64, 2>::new(CORE, 0.7).unwrap();
    let mut out = [[7.0; N]; 6];
    let [b, q, p, g, h, m] = &mut out;
    let status = unsafe {
        mollis_mollifier2_eval(
            GOOD,
            0.7,
            N,
            RADII.as_ptr(),
            b.as_mut_ptr(),
            q.as_mut_ptr(),
            p.as_mut_ptr(),
            g.as_mut_ptr(),
            h.as_mut_ptr(),
            m.as_mut_ptr(),
        )
    };
    assert_eq!(status, 0);
    for (quantity, values) in Quantity::ALL.into_iter().zip(out) {
        assert_eq!(values, RADII.map(|r| blob.evaluate(quantity, r)), "{quantity:?}");
    }
    let mut only = [7.0; N];
    let none = null_mut();
    let status = unsafe {
        mollis_mollifier2_eval(GOOD, 0.7, N, RADII.as_ptr(), none, none, only.as_mut_ptr(), none, none, none)
    };
    assert_eq!((status, only), (0, out[2]));
    let status = unsafe {
        mollis_mollifier3_eval_f32(
            GOOD,
            0.7,
            0,
            null(),
            null_mut(),
            null_mut(),
            null_mut(),
            null_mut(),
            null_mut(),
            null_mut(),
        )
    };
    assert_eq!(status, 0, "no radii, no pointers");
}

/// Every function over radii, one wrong thing at a time, from one good case: its code, and outputs as they were.
#[test]
fn refusals_leave_outputs_as_they_were() {
    type Case = (&'static str, mollis_mollifier, f64, usize, *const f64, Error);
    let not_finite = [0.0, f64::NAN, 1.0, 1.0, 1.0];
    let infinite = [0.0, 1.0, 1.0, 1.0, f64::NEG_INFINITY];
    let good = RADII.as_ptr();
    let misaligned = good.cast::<u8>().wrapping_add(1).cast::<f64>();
    let compact = |order, exponent| with(MOLLIS_MOLLIFIER_COMPACT, order, exponent);
    let richardson = |order, exponent| with(MOLLIS_MOLLIFIER_RICHARDSON, order, exponent);
    let cases: [Case; 23] = [
        ("null r", GOOD, 1.0, N, null(), Error::NullPointer),
        ("misaligned r", GOOD, 1.0, N, misaligned, Error::Misaligned),
        ("n overflows", GOOD, 1.0, usize::MAX / 2, good, Error::TooLarge),
        ("n overflows by one", GOOD, 1.0, usize::MAX / 8 + 1, good, Error::TooLarge),
        ("NaN r", GOOD, 1.0, N, not_finite.as_ptr(), Error::NotFinite),
        ("infinite r", GOOD, 1.0, N, infinite.as_ptr(), Error::NotFinite),
        ("zero delta", GOOD, 0.0, N, good, Error::Delta),
        ("negative delta", GOOD, -1.0, N, good, Error::Delta),
        ("NaN delta", GOOD, f64::NAN, N, good, Error::Delta),
        ("infinite delta", GOOD, f64::INFINITY, N, good, Error::Delta),
        ("kind", with(7, 4, 3), 1.0, N, good, Error::UnknownValue),
        ("negative kind", with(-1, 4, 3), 1.0, N, good, Error::UnknownValue),
        ("odd order", compact(3, 3), 1.0, N, good, Error::Order),
        ("negative order", compact(-2, 3), 1.0, N, good, Error::Order),
        ("order 10", compact(10, 3), 1.0, N, good, Error::Order),
        ("exponent 0", compact(2, 0), 1.0, N, good, Error::Exponent),
        ("exponent 10", compact(2, 10), 1.0, N, good, Error::Exponent),
        ("negative exponent", compact(2, -3), 1.0, N, good, Error::Exponent),
        ("Gaussian of order 8", with(MOLLIS_MOLLIFIER_GAUSSIAN, 8, 0), 1.0, N, good, Error::Order),
        ("combination of order 2", richardson(2, 4), 1.0, N, good, Error::Order),
        ("combination of order 10", richardson(10, 4), 1.0, N, good, Error::Order),
        ("combination of exponent 0", richardson(4, 0), 1.0, N, good, Error::Exponent),
        ("combination of exponent 10", richardson(4, 10), 1.0, N, good, Error::Exponent),
    ];
    for (what, mollifier, delta, n, r, error) in cases {
        let mut out = [[7.5_f64; N]; 6];
        let mut weights = [7.5_f64; 2];
        let p = out.each_mut().map(|o| o.as_mut_ptr());
        let w = weights.as_mut_ptr();
        let radii = [1.0, 0.5];
        let codes = unsafe {
            [
                mollis_mollifier1_eval(mollifier, delta, n, r, p[0], p[1], p[2], p[3], p[4], p[5]),
                mollis_mollifier2_eval(mollifier, delta, n, r, p[0], p[1], p[2], p[3], p[4], p[5]),
                mollis_mollifier3_eval(mollifier, delta, n, r, p[0], p[1], p[2], p[3], p[4], p[5]),
                mollis_mollifier1_heaviside(mollifier, delta, n, r, p[0]),
                mollis_mollifier1_field(mollifier, delta, n, r.cast(), p[0], p[1], p[2].cast(), p[3].cast()),
                mollis_mollifier2_richardson(
                    mollifier,
                    delta,
                    2,
                    radii.as_ptr(),
                    w,
                    n,
                    r,
                    p[0],
                    p[1],
                    p[2],
                    p[3],
                    p[4],
                    p[5],
                ),
            ]
        };
        assert_eq!(codes, [error as i32; 6], "{what}");
        assert_eq!((out, weights), ([[7.5; N]; 6], [7.5; 2]), "{what}");
    }
}

#[test]
fn overlaps_are_refused() {
    let mut values = [0.5_f64; 2 * N];
    let before = values;
    let start = values.as_mut_ptr();
    let none = null_mut();
    // An output over the radii, two outputs over each other by one element, the same output twice.
    let codes = unsafe {
        [
            mollis_mollifier2_eval(GOOD, 1.0, N, start, start, none, none, none, none, none),
            mollis_mollifier2_eval(GOOD, 1.0, N, RADII.as_ptr(), start, start.add(N - 1), none, none, none, none),
            mollis_mollifier2_eval(GOOD, 1.0, N, RADII.as_ptr(), none, none, start, none, none, start),
            mollis_mollifier1_heaviside(GOOD, 1.0, N, start, start.add(N - 1)),
            mollis_mollifier2_field(GOOD, 1.0, 2, start.cast(), start.add(3), none, null_mut(), null_mut()),
            mollis_mollifier2_richardson(
                GOOD,
                1.0,
                2,
                RADII[2..].as_ptr(),
                start,
                N,
                RADII.as_ptr(),
                none,
                none,
                start,
                none,
                none,
                none,
            ),
            mollis_mollifier2_richardson(
                GOOD,
                1.0,
                2,
                start,
                none,
                N,
                RADII.as_ptr(),
                none,
                none,
                start.add(1),
                none,
                none,
                none,
            ),
        ]
    };
    assert_eq!(codes, [Error::Overlap as i32; 7]);
    assert_eq!(values, before);
    // Neighbours do not overlap.
    let code = unsafe { mollis_mollifier1_heaviside(GOOD, 1.0, N, start, start.add(N)) };
    assert_eq!(code, 0);
}

#[test]
fn points_are_checked_and_evaluated() {
    let x = [[0.1_f32, -0.2, 0.05], [0.0, 0.0, 0.0], [1.0, 2.0, 3.0]];
    let blob = Blob::<f32, 3>::new(CORE, 0.5).unwrap();
    let (mut density, mut potential) = ([0.0; 3], [0.0; 3]);
    let (mut gradient, mut hessian) = ([[0.0; 3]; 3], [[[0.0; 3]; 3]; 3]);
    let mut eval = |x: &[[f32; 3]; 3]| unsafe {
        mollis_mollifier3_field_f32(
            GOOD,
            0.5,
            3,
            x.as_ptr(),
            density.as_mut_ptr(),
            potential.as_mut_ptr(),
            gradient.as_mut_ptr(),
            hessian.as_mut_ptr(),
        )
    };
    let mut bad = x;
    bad[1][2] = f32::INFINITY;
    assert_eq!(eval(&bad), Error::NotFinite as i32);
    assert_eq!(eval(&x), 0);
    for (i, x) in x.iter().enumerate() {
        assert_eq!(density[i], blob.density_at(x));
        assert_eq!(potential[i], blob.potential_at(x));
        assert_eq!(gradient[i], blob.gradient_at(x));
        assert_eq!(hessian[i], blob.hessian_at(x));
    }
}

#[test]
fn moments_and_combinations() {
    let mut value = 7.0;
    assert_eq!(unsafe { mollis_mollifier2_moment(with(MOLLIS_MOLLIFIER_COMPACT, 2, 4), 0.5, 2, &mut value) }, 0);
    assert!((value - 0.25 / 6.0).abs() < 1e-17);
    value = 7.0;
    assert_eq!(unsafe { mollis_mollifier2_moment(GOOD, 0.5, 65, &mut value) }, Error::OutOfDomain as i32);
    assert_eq!(unsafe { mollis_mollifier2_moment(GOOD, -0.5, 2, &mut value) }, Error::Delta as i32);
    assert_eq!(unsafe { mollis_mollifier2_moment(GOOD, 0.5, 2, null_mut()) }, Error::NullPointer as i32);
    assert_eq!(value, 7.0);

    // Anderson (9) and (10).
    let mut weights = [0.0; 4];
    let none = null_mut();
    let order_2 = with(MOLLIS_MOLLIFIER_COMPACT, 2, 4);
    let mut combine = |mollifier, radii: &[f64], n: usize| unsafe {
        let w = weights.as_mut_ptr();
        let code = mollis_mollifier3_richardson(
            mollifier,
            1.0,
            n,
            radii.as_ptr(),
            w,
            0,
            null(),
            none,
            none,
            none,
            none,
            none,
            none,
        );
        (code, weights)
    };
    let (code, w) = combine(order_2, &[1.0, 0.5], 2);
    assert_eq!((code, w[0], w[1], w[2]), (0, -1.0 / 3.0, 4.0 / 3.0, 0.0));
    let (code, w) = combine(order_2, &[1.0, 2.0 / 3.0, 1.0 / 3.0], 3);
    assert_eq!(code, 0);
    for (w, exact) in w.iter().zip([0.1, -0.6, 1.5]) {
        assert!((w - exact).abs() < 1e-14, "{w} {exact}");
    }
    let refused = |(code, _): (i32, [f64; 4])| Error::from_code(code);
    assert_eq!(refused(combine(order_2, &[1.0], 0)), Some(Error::LengthMismatch));
    assert_eq!(refused(combine(order_2, &[1.0, 0.9, 0.8, 0.7, 0.6], 5)), Some(Error::LengthMismatch));
    assert_eq!(refused(combine(order_2, &[1.0, 1.5], 2)), Some(Error::OutOfDomain));
    assert_eq!(refused(combine(order_2, &[1.0, 0.0], 2)), Some(Error::OutOfDomain));
    assert_eq!(refused(combine(order_2, &[0.5, 0.5], 2)), Some(Error::OutOfDomain));
    assert_eq!(refused(combine(order_2, &[0.5, f64::NAN], 2)), Some(Error::OutOfDomain));
    assert_eq!(refused(combine(with(MOLLIS_MOLLIFIER_NONE, 0, 0), &[1.0], 1)), Some(Error::Unsupported));
}
