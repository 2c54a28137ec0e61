//! Diagnostics through the C ABI: the same numbers as in Rust. Refused calls write nothing.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::diagnostics::{self, Lattice};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::{Error, Real};
use mollis_tests::Aligned;

const OK: i32 = 0;
const COMPACT: Mollifier = Mollifier::Compact { order: 4, exponent: 4 };

fn kernel_block<T: Real, const D: usize>(mollifier: Mollifier) -> Aligned {
    let terms = [Term { law: Law::Power { exponent: 1.5 }, coefficient: -1.0 }];
    let mut block = Aligned::new(Kernel::<T, D>::workspace_bytes(&terms, mollifier).unwrap());
    Kernel::<T, D>::prepare(block.bytes(), &terms, mollifier, T::from_f64(0.3)).unwrap();
    block
}

macro_rules! check {
    ($name:ident, $t:ty, $d:literal; $moments:ident() $step:ident() $anywhere:ident() $overlap:ident() $distance:ident()
     $size:ident() $dual:ident() $norm:ident()) => {
        #[test]
        fn $name() {
            type P = [$t; $d];
            let point = |k: usize| -> P { std::array::from_fn(|d| (k * 7 + d * 3) as $t * 0.31 % 1.7 - 0.5) };
            let (x, y): (Vec<P>, Vec<P>) = (0..5).map(|k| (point(k), point(k + 9))).unzip();
            let (m, rho): (Vec<$t>, Vec<$t>) = (0..5).map(|k| (0.1 + k as $t, 2.0 - 0.3 * k as $t)).unzip();
            let (n, mut out, mut centre) = (5, [-7.0 as $t; 3], [-7.0; $d]);
            let untouched = [-7.0 as $t; 3];
            let [a, b, c] = out.each_mut().map(|v| v as *mut $t);

            // SAFETY: pointers to live arrays of the stated lengths, or null where null must be refused.
            unsafe {
                let (xp, yp, mp, rp) = (x.as_ptr(), y.as_ptr(), m.as_ptr(), rho.as_ptr());
                assert_eq!($moments(n, xp, mp, a, b, &raw mut centre, c), OK);
                let want = diagnostics::moments(&x, &m).unwrap();
                assert_eq!((out, centre), ([want.mass, want.absolute_mass, want.second], want.centre));
                assert_eq!($moments(n, xp, mp, null_mut(), null_mut(), null_mut(), null_mut()), OK);
                out = untouched;
                assert_eq!($moments(n, null(), mp, a, b, null_mut(), c), Error::NullPointer as i32);
                assert_eq!($moments(n, xp, mp, a, a, null_mut(), c), Error::Overlap as i32);
                assert_eq!($moments(n, xp, mp, a.byte_add(1), b, null_mut(), c), Error::Misaligned as i32);
                assert_eq!(out, untouched);
                assert_eq!($moments(0, null(), null(), a, b, &raw mut centre, c), OK);
                assert_eq!((out, centre), ([0.0; 3], [0.0; $d]));

                let mut block = kernel_block::<$t, $d>(COMPACT);
                let bytes = block.bytes().len();
                let kernel = Kernel::<$t, $d>::open(block.bytes()).unwrap();
                let want =
                    (diagnostics::stable_step(&kernel, &x, &m), diagnostics::stable_step_anywhere(&kernel, 2.0, 3.0));
                let kp = block.bytes().as_ptr().cast();
                assert_eq!(($step(kp, bytes, n, mp, xp, a), Ok(out[0])), (OK, want.0));
                assert_eq!(($anywhere(kp, bytes, 2.0, 3.0, a), Ok(out[0])), (OK, want.1));
                out = untouched;
                let mut bad = x.clone();
                bad[3][0] = <$t>::NAN;
                assert_eq!($step(kp, bytes, n, mp, bad.as_ptr(), a), Error::NotFinite as i32);
                assert_eq!($step(kp, bytes, n, mp, xp, null_mut()), Error::NullPointer as i32);
                assert_eq!($step(kp, bytes - 1, n, mp, xp, a), Error::WorkspaceTooSmall as i32);
                assert_eq!($step(kp, 0, n, mp, xp, a), Error::NotPrepared as i32);
                assert_eq!($anywhere(kp, bytes, -2.0, 3.0, a), Error::OutOfDomain as i32);
                assert_eq!($anywhere(kp, bytes, 2.0, <$t>::INFINITY, a), Error::NotFinite as i32);
                assert_eq!(out, untouched);
                // without a mollifier |x|^1.5 has no bounded Hessian, so coincident particles have no stable step
                let mut singular = kernel_block::<$t, $d>(Mollifier::None);
                let (sp, bytes) = (singular.bytes().as_ptr().cast(), singular.bytes().len());
                assert_eq!($step(sp, bytes, n, mp, xp, a), OK);

                assert_eq!($overlap(n, 0.4, mp, rp, a), OK);
                assert_eq!(Some(out[0]), diagnostics::smallest_overlap::<$t, $d>(0.4, &m, &rho).unwrap());
                assert_eq!(($overlap(0, 0.4, mp, rp, a), out[0].is_nan()), (OK, true));
                out = untouched;
                assert_eq!($overlap(n, 0.0, mp, rp, a), Error::Delta as i32);
                assert_eq!($overlap(n, 0.4, mp, null(), a), Error::NullPointer as i32);
                assert_eq!(out, untouched);

                for p in [1.0, 2.0, <$t>::INFINITY] {
                    assert_eq!(
                        ($distance(n, xp, yp, 0.01, p, a), Ok(out[0])),
                        (OK, diagnostics::distance(&x, &y, 0.01, p))
                    );
                    assert_eq!(($norm(n, rp, 0.01, p, a), Ok(out[0])), (OK, diagnostics::norm(&rho, 0.01, p)));
                }
                out = untouched;
                assert_eq!($distance(n, xp, yp, 0.01, 0.5, a), Error::OutOfDomain as i32);
                assert_eq!($norm(n, rp, 0.0, 1.0, a), Error::OutOfDomain as i32);
                assert_eq!($norm(n, rp, 1.0, 1.0, rp.cast_mut()), Error::Overlap as i32);
                assert_eq!(out, untouched);

                let (points, mut bytes) = ([3_usize; $d], 0_usize);
                let lattice = Lattice { points, spacing: 0.5 as $t, margin: 4 };
                assert_eq!($size(&raw const points, 4, &raw mut bytes), OK);
                assert_eq!(Ok(bytes), lattice.workspace_bytes());
                let values: Vec<$t> = (0..3_usize.pow($d)).map(|k| 0.2 * k as $t - 0.7).collect();
                let mut memory = Aligned::new(bytes);
                let want = lattice.dual_norm(&values, memory.bytes());
                let (vp, wp) = (values.as_ptr(), memory.bytes().as_mut_ptr().cast());
                let pp = &raw const points;
                assert_eq!(($dual(pp, 0.5, 4, vp, a, wp, bytes), Ok(out[0])), (OK, want));
                out = untouched;
                assert_eq!($dual(pp, 0.0, 4, vp, a, wp, bytes), Error::OutOfDomain as i32);
                assert_eq!($dual(pp, 0.5, 4, vp, a, wp, bytes - 64), Error::WorkspaceTooSmall as i32);
                assert_eq!($dual(pp, 0.5, usize::MAX, vp, a, wp, bytes), Error::TooLarge as i32);
                let huge = [usize::MAX; $d];
                assert_eq!($dual(&raw const huge, 0.5, 4, vp, a, wp, bytes), Error::TooLarge as i32);
                assert_eq!($size(null(), 4, &raw mut bytes), Error::NullPointer as i32);
                assert_eq!($size(&raw const huge, 4, &raw mut bytes), Error::TooLarge as i32);
                assert_eq!((out, bytes), (untouched, memory.bytes().len()));
            }
        }
    };
}

check!(line_f64, f64, 1; mollis_moments1_eval() mollis_stable_step1_eval() mollis_stable_step_anywhere1_eval()
    mollis_overlap1_eval() mollis_distance1_eval() mollis_dual_norm1_workspace_bytes() mollis_dual_norm1_eval() mollis_norm_eval());
check!(plane_f64, f64, 2; mollis_moments2_eval() mollis_stable_step2_eval() mollis_stable_step_anywhere2_eval()
    mollis_overlap2_eval() mollis_distance2_eval() mollis_dual_norm2_workspace_bytes() mollis_dual_norm2_eval() mollis_norm_eval());
check!(space_f64, f64, 3; mollis_moments3_eval() mollis_stable_step3_eval() mollis_stable_step_anywhere3_eval()
    mollis_overlap3_eval() mollis_distance3_eval() mollis_dual_norm3_workspace_bytes() mollis_dual_norm3_eval() mollis_norm_eval());
check!(line_f32, f32, 1; mollis_moments1_eval_f32() mollis_stable_step1_eval_f32() mollis_stable_step_anywhere1_eval_f32()
    mollis_overlap1_eval_f32() mollis_distance1_eval_f32() mollis_dual_norm1_workspace_bytes_f32()
    mollis_dual_norm1_eval_f32() mollis_norm_eval_f32());
check!(plane_f32, f32, 2; mollis_moments2_eval_f32() mollis_stable_step2_eval_f32() mollis_stable_step_anywhere2_eval_f32()
    mollis_overlap2_eval_f32() mollis_distance2_eval_f32() mollis_dual_norm2_workspace_bytes_f32()
    mollis_dual_norm2_eval_f32() mollis_norm_eval_f32());
check!(space_f32, f32, 3; mollis_moments3_eval_f32() mollis_stable_step3_eval_f32() mollis_stable_step_anywhere3_eval_f32()
    mollis_overlap3_eval_f32() mollis_distance3_eval_f32() mollis_dual_norm3_workspace_bytes_f32()
    mollis_dual_norm3_eval_f32() mollis_norm_eval_f32());
