//! Kernels: preparing them, and their values at distances including r = 0.

use std::ptr::null;

use mollis_tests::Aligned;
use mollis_tests::exceptions::Rows;

use super::*;

/// |x|^1.5 / 1.5 in the dimension that the context is as a number, up to 2 where it goes on with the same value and slope.
unsafe extern "C" fn own(dimension: *mut c_void, r: f64, out: *mut f64) -> mollis_status {
    let (d, root) = (dimension.addr() as f64, r.sqrt());
    let spline = |x: f64| [x * x / 2.0, x, 1.0];
    let mut values = [r * root / 1.5, 1.0 / root, (d - 0.5) / root];
    if r > 2.0 {
        let [k, slope, curvature] = spline(r - 2.0);
        let more = slope / r;
        values = [values[0] + k, values[1] + more, values[2] + curvature + (d - 1.0) * more];
    }
    unsafe { out.cast::<[f64; 3]>().write(values) };
    0
}

static KNOT: f64 = 2.0;

fn term(kind: i32, coefficient: f64, parameter: f64) -> mollis_kernel_term {
    mollis_kernel_term { kind, reserved: 0, coefficient, parameter: [parameter, 0.0] }
}

/// Sums of terms that exist in this dimension. Fewer in single precision, because preparing uses double precision in any case.
fn sums(dimension: usize, few: bool) -> Vec<Vec<mollis_kernel_term>> {
    let newtonian = term(MOLLIS_KERNEL_NEWTONIAN, -1.0, 0.0);
    let power = |p: f64| term(MOLLIS_KERNEL_POWER, 1.0, p);
    let exponential = |c: f64, l: f64| term(MOLLIS_KERNEL_EXPONENTIAL, c, l);
    let mut all = vec![
        vec![newtonian],
        vec![power(0.0)],
        vec![power(1.5)],
        vec![power(2.0)],
        vec![exponential(1.0, 0.7)],
        vec![term(MOLLIS_KERNEL_SCREENED, 1.0, 2.0)],
    ];
    if !few {
        all.extend([
            vec![power(1.0)],
            vec![power(2.5)],
            vec![power(3.0)],
            vec![power(4.0), newtonian],
            vec![power(8.0)],
            vec![exponential(1.0, 1.0), exponential(-2.0, 0.4)],
            vec![term(MOLLIS_KERNEL_SCREENED, 1.0, 20.0)],
        ]);
        all.extend([-0.5, -1.5].iter().filter(|&&p| p > 1.0 - dimension as f64).map(|&p| vec![power(p)]));
    }
    all
}

macro_rules! check {
    ($name:ident, $t:ty, $d:literal, $few:literal; $bytes:ident() $prepare:ident() $eval:ident()) => {
        #[test]
        fn $name() {
            let mut rows = Rows::default();
            let r = [0.0 as $t, 1e-12, 1e-3, 0.1, 0.29, 0.3, 0.31, 0.6, 2.0, 13.0, 100.0];
            let host = mollis_radial_kernel {
                context: std::ptr::without_provenance_mut($d),
                evaluate: Some(own),
                coefficient: 1.0,
                reach: 5.0,
                tolerance: f64::INFINITY,
                least: 0.0,
                n_knots: 1,
                knots: &raw const KNOT,
                errors: std::ptr::null_mut(),
            };
            let mut kernels: Vec<_> = sums($d, $few).into_iter().map(|terms| (terms, None)).collect();
            kernels.push((vec![], Some(host)));
            for mollifier in mollifiers_in($d).into_iter().filter(|m| m.order != 6 && m.order != 8) {
                // A combination takes no kernel of a host's own.
                let taken = |host: &Option<_>| host.is_none() || mollifier.kind != MOLLIS_MOLLIFIER_RICHARDSON;
                for (terms, host) in kernels.iter().filter(|(_, host)| taken(host)) {
                    let own: *const mollis_radial_kernel = host.as_ref().map_or(null(), |host| host);
                    let what =
                        |function: &str| format!("{function}, {}, {terms:?} {}", name(mollifier), host.is_some());
                    let mut bytes = 0;
                    rows.row(what(stringify!($bytes)), || unsafe {
                        $bytes(terms.as_ptr(), terms.len(), own, mollifier, &raw mut bytes)
                    });
                    let mut block = Aligned::new(bytes);
                    let kernel = pointer(&mut block);
                    rows.row(what(stringify!($prepare)), || unsafe {
                        $prepare(kernel, bytes, terms.as_ptr(), terms.len(), own, mollifier, 0.3)
                    });
                    let mut out = [[0.0 as $t; 11]; 3];
                    let [u, g, l] = out.each_mut().map(|out| out.as_mut_ptr());
                    for (k, r) in r.iter().enumerate() {
                        rows.row(format!("{}, r = {r}", what(stringify!($eval))), || unsafe {
                            $eval(kernel, bytes, 1, r, u.add(k), g.add(k), l.add(k))
                        });
                    }
                }
            }
            rows.finish();
        }
    };
}

check!(line_f64, f64, 1, false; mollis_kernel1_bytes() mollis_kernel1_prepare() mollis_kernel1_eval());
check!(plane_f64, f64, 2, false; mollis_kernel2_bytes() mollis_kernel2_prepare() mollis_kernel2_eval());
check!(space_f64, f64, 3, false; mollis_kernel3_bytes() mollis_kernel3_prepare() mollis_kernel3_eval());
check!(line_f32, f32, 1, true; mollis_kernel1_bytes_f32() mollis_kernel1_prepare_f32() mollis_kernel1_eval_f32());
check!(plane_f32, f32, 2, true; mollis_kernel2_bytes_f32() mollis_kernel2_prepare_f32() mollis_kernel2_eval_f32());
check!(space_f32, f32, 3, true; mollis_kernel3_bytes_f32() mollis_kernel3_prepare_f32() mollis_kernel3_eval_f32());
