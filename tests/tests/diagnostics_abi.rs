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
     $size:ident() $dual:ident() $norm:ident() $sobolev:ident()) => {
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
                assert_eq!(($step(kp, bytes, n, xp, mp, a), Ok(out[0])), (OK, want.0));
                assert_eq!(($anywhere(kp, bytes, 2.0, 3.0, a), Ok(out[0])), (OK, want.1));
                out = untouched;
                let mut bad = x.clone();
                bad[3][0] = <$t>::NAN;
                assert_eq!($step(kp, bytes, n, bad.as_ptr(), mp, a), Error::NotFinite as i32);
                assert_eq!($step(kp, bytes, n, xp, mp, null_mut()), Error::NullPointer as i32);
                assert_eq!($step(kp, bytes - 1, n, xp, mp, a), Error::WorkspaceTooSmall as i32);
                assert_eq!($step(kp, 0, n, xp, mp, a), Error::NotPrepared as i32);
                assert_eq!($anywhere(kp, bytes, -2.0, 3.0, a), Error::OutOfDomain as i32);
                assert_eq!($anywhere(kp, bytes, 2.0, <$t>::INFINITY, a), Error::NotFinite as i32);
                assert_eq!(out, untouched);
                // without a mollifier |x|^1.5 has no bounded Hessian, so coincident particles have no stable step
                let mut singular = kernel_block::<$t, $d>(Mollifier::None);
                let (sp, bytes) = (singular.bytes().as_ptr().cast(), singular.bytes().len());
                assert_eq!($step(sp, bytes, n, xp, mp, a), OK);

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
                assert_eq!(Ok(bytes), lattice.workspace_bytes().map(|own| own + mollis_core::memory::ALIGN - 1));
                let values: Vec<$t> = (0..3_usize.pow($d)).map(|k| 0.2 * k as $t - 0.7).collect();
                let mut memory = Aligned::new(bytes);
                let want = lattice.dual_norm(&values, memory.bytes());
                let (vp, wp) = (values.as_ptr(), memory.bytes().as_mut_ptr().cast());
                let pp = &raw const points;
                assert_eq!(($dual(pp, 0.5, 4, vp, a, wp, bytes), Ok(out[0])), (OK, want));
                out = untouched;
                for p in [1.0, 2.0, <$t>::INFINITY] {
                    let want = diagnostics::sobolev(&points, &values, 0.5, p);
                    assert_eq!(($sobolev(pp, 0.5, p, vp, a), Ok(out[0])), (OK, want));
                }
                out = untouched;
                assert_eq!($sobolev(pp, 0.0, 2.0, vp, a), Error::OutOfDomain as i32);
                assert_eq!($sobolev(pp, 0.5, 0.5, vp, a), Error::OutOfDomain as i32);
                assert_eq!($sobolev(pp, 0.5, 2.0, null(), a), Error::NullPointer as i32);
                assert_eq!($sobolev(pp, 0.5, 2.0, vp, vp.cast_mut()), Error::Overlap as i32);
                let most = [usize::MAX; $d];
                assert_eq!($sobolev(&raw const most, 0.5, 2.0, vp, a), Error::TooLarge as i32);
                assert_eq!($dual(pp, 0.0, 4, vp, a, wp, bytes), Error::OutOfDomain as i32);
                assert_eq!($dual(pp, 0.5, 4, vp, a, wp, bytes - 1), Error::WorkspaceTooSmall as i32);
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

check!(line_f64, f64, 1; mollis_moments1() mollis_stable_step1() mollis_stable_step1_anywhere()
    mollis_overlap1() mollis_distance_norm1() mollis_dual_norm1_workspace_bytes() mollis_dual_norm1() mollis_norm() mollis_sobolev_norm1());
check!(plane_f64, f64, 2; mollis_moments2() mollis_stable_step2() mollis_stable_step2_anywhere()
    mollis_overlap2() mollis_distance_norm2() mollis_dual_norm2_workspace_bytes() mollis_dual_norm2() mollis_norm() mollis_sobolev_norm2());
check!(space_f64, f64, 3; mollis_moments3() mollis_stable_step3() mollis_stable_step3_anywhere()
    mollis_overlap3() mollis_distance_norm3() mollis_dual_norm3_workspace_bytes() mollis_dual_norm3() mollis_norm() mollis_sobolev_norm3());
check!(line_f32, f32, 1; mollis_moments1_f32() mollis_stable_step1_f32() mollis_stable_step1_anywhere_f32()
    mollis_overlap1_f32() mollis_distance_norm1_f32() mollis_dual_norm1_workspace_bytes_f32()
    mollis_dual_norm1_f32() mollis_norm_f32() mollis_sobolev_norm1_f32());
check!(plane_f32, f32, 2; mollis_moments2_f32() mollis_stable_step2_f32() mollis_stable_step2_anywhere_f32()
    mollis_overlap2_f32() mollis_distance_norm2_f32() mollis_dual_norm2_workspace_bytes_f32()
    mollis_dual_norm2_f32() mollis_norm_f32() mollis_sobolev_norm2_f32());
check!(space_f32, f32, 3; mollis_moments3_f32() mollis_stable_step3_f32() mollis_stable_step3_anywhere_f32()
    mollis_overlap3_f32() mollis_distance_norm3_f32() mollis_dual_norm3_workspace_bytes_f32()
    mollis_dual_norm3_f32() mollis_norm_f32() mollis_sobolev_norm3_f32());
