//! Mollifiers: functions of the distance, fields at points, combinations, moments.

use std::ptr::null_mut;

use mollis_tests::exceptions::Rows;

use super::*;

/// From the centre to far outside, in units of delta.
const RADII: [f64; 11] = [0.0, 1e-30, 1e-9, 0.1, 0.5, 0.999, 1.0, 1.5, 7.0, 40.0, 1e6];

macro_rules! check {
    ($name:ident, $t:ty, $d:literal; $radii:ident() $points:ident() $richardson:ident() $moment:ident()) => {
        #[test]
        fn $name() {
            let mut rows = Rows::default();
            for mollifier in mollifiers_in($d) {
                for delta in [0.3 as $t, 2.0, 1e-3] {
                    let what = |function: &str| format!("{function}, {}, delta {delta}", name(mollifier));
                    // Without a mollifier the field is out of range so close to zero.
                    let least = if mollifier.kind == MOLLIS_MOLLIFIER_NONE { 1e-3 } else { 0.0 };
                    let r = RADII.map(|r| if r < least { r.min(0.0) as $t } else { r as $t * delta });
                    let n = r.len();
                    let mut out = vec![[0.0 as $t; RADII.len()]; 6];
                    let [a, b, c, d, e, f] = std::array::from_fn(|k| out[k].as_mut_ptr());
                    rows.row(what(stringify!($radii)), || unsafe {
                        $radii(mollifier, delta, n, r.as_ptr(), a, b, c, d, e, f)
                    });
                    let (mut density, mut potential) = (vec![0.0 as $t; n], vec![0.0 as $t; n]);
                    let (mut gradient, mut hessian) = (vec![[0.0 as $t; $d]; n], vec![[[0.0 as $t; $d]; $d]; n]);
                    let x: Vec<[$t; $d]> =
                        r.iter().map(|r| std::array::from_fn(|k| if k == 0 { *r } else { -0.4 * r })).collect();
                    rows.row(what(stringify!($points)), || unsafe {
                        let (u, g, h) = (potential.as_mut_ptr(), gradient.as_mut_ptr(), hessian.as_mut_ptr());
                        $points(mollifier, delta, n, x.as_ptr(), density.as_mut_ptr(), u, g, h)
                    });
                    for k in 0..6 {
                        let mut value = 0.0;
                        rows.row(what(stringify!($moment)), || unsafe { $moment(mollifier, delta, k, &raw mut value) });
                    }
                    if mollifier.kind != MOLLIS_MOLLIFIER_NONE {
                        let radii = [1.0 as $t, 0.5];
                        rows.row(what(stringify!($richardson)), || unsafe {
                            let (radii, r) = (radii.as_ptr(), r.as_ptr());
                            $richardson(mollifier, delta, 2, radii, null_mut(), n, r, a, b, c, d, e, f)
                        });
                    }
                }
            }
            rows.finish();
        }
    };
}

check!(line_f64, f64, 1; mollis_mollifier1_eval() mollis_mollifier1_field() mollis_mollifier1_richardson() mollis_mollifier1_moment());
check!(plane_f64, f64, 2; mollis_mollifier2_eval() mollis_mollifier2_field() mollis_mollifier2_richardson() mollis_mollifier2_moment());
check!(space_f64, f64, 3; mollis_mollifier3_eval() mollis_mollifier3_field() mollis_mollifier3_richardson() mollis_mollifier3_moment());
check!(line_f32, f32, 1; mollis_mollifier1_eval_f32() mollis_mollifier1_field_f32() mollis_mollifier1_richardson_f32()
    mollis_mollifier1_moment_f32());
check!(plane_f32, f32, 2; mollis_mollifier2_eval_f32() mollis_mollifier2_field_f32() mollis_mollifier2_richardson_f32()
    mollis_mollifier2_moment_f32());
check!(space_f32, f32, 3; mollis_mollifier3_eval_f32() mollis_mollifier3_field_f32() mollis_mollifier3_richardson_f32()
    mollis_mollifier3_moment_f32());

#[test]
fn heaviside() {
    let mut rows = Rows::default();
    for mollifier in mollifiers_in(1) {
        let x = [-3.0, -0.3, -0.1, 0.0, 1e-9, 0.2, 0.3, 5.0];
        let (single, mut out, mut narrow) = (x.map(|x| x as f32), [0.0; 8], [0.0; 8]);
        rows.row(format!("mollis_mollifier1_heaviside, {}", name(mollifier)), || unsafe {
            mollis_mollifier1_heaviside(mollifier, 0.3, 8, x.as_ptr(), out.as_mut_ptr())
        });
        rows.row(format!("mollis_mollifier1_heaviside_f32, {}", name(mollifier)), || unsafe {
            mollis_mollifier1_heaviside_f32(mollifier, 0.3, 8, single.as_ptr(), narrow.as_mut_ptr())
        });
    }
    rows.finish();
}
