//! Moments, stable steps, overlaps and norms, also without particles, with total mass 0, and of zeros.

use std::ptr::null;

use mollis_tests::Aligned;
use mollis_tests::exceptions::Rows;

use super::*;

macro_rules! check {
    ($name:ident, $t:ty, $d:literal; $moments:ident() $step:ident() $anywhere:ident() $overlap:ident() $distance:ident()
     $size:ident() $dual:ident() $norm:ident() $sobolev:ident(); $bytes:ident() $prepare:ident()) => {
        #[test]
        fn $name() {
            const N: usize = 24;
            let mut rows = Rows::default();
            let positions = points!(N, $t, $d);
            let others = points!(N + 5, $t, $d);
            let same: Vec<$t> = vec![0.25; N];
            let opposite: Vec<$t> = (0..N).map(|k| if k % 2 == 0 { 0.25 } else { -0.25 }).collect();
            let some: Vec<$t> = (0..N).map(|k| if k % 3 == 0 { 0.0 } else { 0.25 }).collect();
            let (x, y) = (positions.as_ptr(), others[5..].as_ptr());
            let mut out = [0.0 as $t; 3];
            let [a, b, c] = out.each_mut().map(|out| out as *mut $t);
            for (kind, masses) in [("all", &same), ("total 0", &opposite), ("with zeros", &some)] {
                let m = masses.as_ptr();
                for n in [0, 1, N] {
                    let mut centre = [0.0 as $t; $d];
                    rows.row(format!("{}, {kind} {n}", stringify!($moments)), || unsafe {
                        $moments(n, x, m, a, b, &raw mut centre, c)
                    });
                    for densities in [&same, &some] {
                        rows.row(format!("{}, {kind} {n}", stringify!($overlap)), || unsafe {
                            $overlap(n, 0.4, m, densities.as_ptr(), a)
                        });
                    }
                    for p in [1.0, 2.0, 3.0, <$t>::INFINITY] {
                        rows.row(format!("{}, {kind} {n} {p}", stringify!($norm)), || unsafe {
                            $norm(n, m, 0.1, p, a)
                        });
                        rows.row(format!("{}, {n} {p}", stringify!($distance)), || unsafe {
                            $distance(n, x, y, 0.1, p, a)
                        });
                    }
                    for mollifier in mollifiers_in($d).into_iter().filter(|m| m.order != 6 && m.order != 8) {
                        let terms = [
                            mollis_kernel_term {
                                kind: MOLLIS_KERNEL_NEWTONIAN,
                                reserved: 0,
                                coefficient: 1.0,
                                parameter: [0.0; 2],
                            },
                            mollis_kernel_term {
                                kind: MOLLIS_KERNEL_POWER,
                                reserved: 0,
                                coefficient: 1.0,
                                parameter: [2.0, 0.0],
                            },
                        ];
                        // Without a mollifier only powers have a stable step for all states and for coincident particles.
                        let terms = if mollifier.kind == MOLLIS_MOLLIFIER_NONE { &terms[1..] } else { &terms[..] };
                        let mut bytes = 0;
                        unsafe {
                            let count = terms.len();
                            assert_eq!($bytes(terms.as_ptr(), count, null(), mollifier, &raw mut bytes), 0);
                            let mut block = Aligned::new(bytes);
                            let kernel = pointer(&mut block);
                            assert_eq!($prepare(kernel, bytes, terms.as_ptr(), count, null(), mollifier, 0.3), 0);
                            let what = |f: &str| format!("{f}, {kind} {n}, {}", name(mollifier));
                            rows.row(what(stringify!($step)), || $step(kernel, bytes, n, x, m, a));
                            rows.row(what(stringify!($anywhere)), || $anywhere(kernel, bytes, n as $t, 3.0, a));
                        }
                    }
                }
            }
            let (points, mut bytes) = ([3_usize; $d], 0);
            rows.row(stringify!($size), || unsafe { $size(&raw const points, 4, &raw mut bytes) });
            let mut memory = Aligned::new(bytes);
            let workspace = pointer(&mut memory);
            let values: Vec<$t> = (0..27).map(|k| 0.2 * k as $t - 0.7).collect();
            let zeros = vec![0.0 as $t; 27];
            for (kind, values) in [("values", &values), ("zeros", &zeros)] {
                rows.row(format!("{}, {kind}", stringify!($dual)), || unsafe {
                    $dual(&raw const points, 0.5, 4, values.as_ptr(), a, workspace, bytes)
                });
                for p in [1.0, 2.0, 3.0, <$t>::INFINITY] {
                    rows.row(format!("{}, {kind} {p}", stringify!($sobolev)), || unsafe {
                        $sobolev(&raw const points, 0.5, p, values.as_ptr(), a)
                    });
                }
            }
            rows.finish();
        }
    };
}

check!(line_f64, f64, 1; mollis_moments1() mollis_stable_step1() mollis_stable_step1_anywhere()
    mollis_overlap1() mollis_distance_norm1() mollis_dual_norm1_workspace_bytes() mollis_dual_norm1() mollis_norm() mollis_sobolev_norm1();
    mollis_kernel1_bytes() mollis_kernel1_prepare());
check!(plane_f64, f64, 2; mollis_moments2() mollis_stable_step2() mollis_stable_step2_anywhere()
    mollis_overlap2() mollis_distance_norm2() mollis_dual_norm2_workspace_bytes() mollis_dual_norm2() mollis_norm() mollis_sobolev_norm2();
    mollis_kernel2_bytes() mollis_kernel2_prepare());
check!(space_f64, f64, 3; mollis_moments3() mollis_stable_step3() mollis_stable_step3_anywhere()
    mollis_overlap3() mollis_distance_norm3() mollis_dual_norm3_workspace_bytes() mollis_dual_norm3() mollis_norm() mollis_sobolev_norm3();
    mollis_kernel3_bytes() mollis_kernel3_prepare());
check!(line_f32, f32, 1; mollis_moments1_f32() mollis_stable_step1_f32() mollis_stable_step1_anywhere_f32()
    mollis_overlap1_f32() mollis_distance_norm1_f32() mollis_dual_norm1_workspace_bytes_f32()
    mollis_dual_norm1_f32() mollis_norm_f32() mollis_sobolev_norm1_f32(); mollis_kernel1_bytes_f32() mollis_kernel1_prepare_f32());
check!(plane_f32, f32, 2; mollis_moments2_f32() mollis_stable_step2_f32() mollis_stable_step2_anywhere_f32()
    mollis_overlap2_f32() mollis_distance_norm2_f32() mollis_dual_norm2_workspace_bytes_f32()
    mollis_dual_norm2_f32() mollis_norm_f32() mollis_sobolev_norm2_f32(); mollis_kernel2_bytes_f32() mollis_kernel2_prepare_f32());
check!(space_f32, f32, 3; mollis_moments3_f32() mollis_stable_step3_f32() mollis_stable_step3_anywhere_f32()
    mollis_overlap3_f32() mollis_distance_norm3_f32() mollis_dual_norm3_workspace_bytes_f32()
    mollis_dual_norm3_f32() mollis_norm_f32() mollis_sobolev_norm3_f32(); mollis_kernel3_bytes_f32() mollis_kernel3_prepare_f32());
