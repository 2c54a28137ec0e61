//! Field sums and their applications (steps of the blob method, coalescing particles with summed attraction) raise none of invalid, divide-by-zero
//! and overflow on ordinary input. One row for each function of the header and kind of input.

use std::ptr::{null, null_mut};

use mollis_core::simd::Level;
use mollis_tests::Aligned;
use mollis_tests::exceptions::Rows;
use mollis_tests::positional::*;
use mollis_tests::sums::Sum;

use super::*;

fn mollifiers_in(dimension: usize) -> Vec<mollis_mollifier> {
    let mut all = vec![NONE, compact(2, 4), compact(4, 4)];
    all.extend([gaussian(4)].into_iter().filter(|_| dimension < 3));
    all
}

fn term(kind: i32, coefficient: f64, parameter: f64) -> mollis_kernel_term {
    mollis_kernel_term { kind, reserved: 0, coefficient, parameter: [parameter, 0.0] }
}

/// Newtonian, closed forms, fits, sums of them.
fn sums() -> Vec<Vec<mollis_kernel_term>> {
    let newtonian = term(MOLLIS_KERNEL_NEWTONIAN, -1.0, 0.0);
    let power = |p: f64| term(MOLLIS_KERNEL_POWER, 1.0, p);
    vec![
        vec![newtonian],
        vec![power(0.0)],
        vec![power(1.0)],
        vec![power(1.5)],
        vec![power(2.0)],
        vec![power(3.0)],
        vec![power(4.0)],
        vec![power(4.0), newtonian],
        vec![power(3.0), newtonian],
        vec![term(MOLLIS_KERNEL_EXPONENTIAL, 1.0, 0.7), term(MOLLIS_KERNEL_EXPONENTIAL, -2.0, 0.4)],
        vec![term(MOLLIS_KERNEL_SCREENED, 1.0, 2.0)],
    ]
}

/// Points on a skew lattice, with the origin and two equal points among them.
macro_rules! points {
    ($n:expr, $t:ty, $d:literal) => {{
        let at = |k: usize, d: usize| ((k * 7 + d * 3) as f64 * 0.31 % 1.7 - 0.85) as $t;
        let mut points: Vec<[$t; $d]> = (0..$n).map(|k| std::array::from_fn(|d| at(k, d))).collect();
        points[0] = [0.0; $d];
        points[3] = points[2];
        points
    }};
}

macro_rules! check {
    ($name:ident, $t:ty, $d:literal; $bytes:ident() $prepare:ident(); $size:ident() $text:ident() $field:ident();
     $blob_size:ident() $blob:ident(); $essential_size:ident() $essential:ident()) => {
        #[test]
        fn $name() {
            // More than a block of lanes, and a remainder.
            const N: usize = 41;
            let mut rows = Rows::default();
            let mut run = std::mem::MaybeUninit::<mollis_run>::uninit();
            let run = unsafe {
                assert_eq!(mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()), 0);
                run.assume_init()
            };
            let (x, targets) = (points!(N, $t, $d), points!(N + 5, $t, $d));
            let all: Vec<$t> = (0..N).map(|k| if k % 2 == 0 { 0.25 } else { -0.2 }).collect();
            let some: Vec<$t> = all.iter().enumerate().map(|(k, &m)| if k % 5 == 0 { 0.0 } else { m }).collect();
            let mut options = std::mem::MaybeUninit::<mollis_field_options>::uninit();
            let options = unsafe {
                assert_eq!(mollis_field_options_init(options.as_mut_ptr(), size_of::<mollis_field_options>()), 0);
                options.assume_init()
            };
            for mollifier in mollifiers_in($d) {
                for terms in sums() {
                    let (terms, count) = (&terms, terms.len());
                    let what = |f: &str, kind: &str| format!("{f}, {kind}, {mollifier:?}, {terms:?}");
                    let (mut bytes, mut needed) = (0, 0);
                    assert_eq!(unsafe { $bytes(terms.as_ptr(), count, null(), mollifier, &raw mut bytes) }, 0);
                    let mut block = Aligned::new(bytes);
                    let kernel = block.pointer();
                    assert_eq!(unsafe { $prepare(kernel, bytes, terms.as_ptr(), count, null(), mollifier, 0.3) }, 0);
                    let accumulations = [MOLLIS_ACCUMULATION_BLOCKED, MOLLIS_ACCUMULATION_COMPENSATED];
                    let methods = [MOLLIS_METHOD_AUTO, MOLLIS_METHOD_SORTED];
                    let ways = methods.iter().flat_map(|m| accumulations.iter().map(move |a| (*m, *a)));
                    for ((method, accumulation), level) in
                        ways.flat_map(|way| Level::available().map(move |level| (way, level)))
                    {
                        let options = mollis_field_options { method, accumulation, ..options };
                        let options = &raw const options;
                        let run = mollis_run { level: level as i32, ..run };
                        let run = &raw const run;
                        for wanted in 1..8 {
                            for (kind, targets, masses) in [
                                ("targets are the sources", &x[..], &all),
                                ("massless ones", &x[..], &some),
                                ("other targets", &targets[..], &all),
                            ] {
                                let m = targets.len();
                                let kind = format!(
                                    "{kind}, method {method}, wanted {wanted}, accumulation {accumulation}, {}",
                                    level.name()
                                );
                                let (mut u, mut g, mut l) =
                                    (vec![0.0 as $t; m], vec![[0.0 as $t; $d]; m], vec![0.0 as $t; m]);
                                let u = if wanted & 1 == 0 { null_mut() } else { u.as_mut_ptr() };
                                let g = if wanted & 2 == 0 { null_mut() } else { g.as_mut_ptr() };
                                let l = if wanted & 4 == 0 { null_mut() } else { l.as_mut_ptr() };
                                let sum = Sum::new((N, x.as_ptr(), masses.as_ptr()), (m, targets.as_ptr()), (u, g, l));
                                let (sources, at, to) = (sum.sources(), sum.targets(), sum.outputs());
                                if method != MOLLIS_METHOD_AUTO
                                    && unsafe { $size(kernel, bytes, sources, at, to, options, run, &raw mut needed) }
                                        != 0
                                {
                                    // It serves other sums.
                                    continue;
                                }
                                rows.row(what(stringify!($size), &kind), || unsafe {
                                    $size(kernel, bytes, sources, at, to, options, run, &raw mut needed)
                                });
                                rows.row(what(stringify!($text), &kind), || unsafe {
                                    let mut length = 0;
                                    let (text, length) = (null_mut(), &raw mut length);
                                    $text(kernel, bytes, sources, at, to, options, text, 0, length)
                                });
                                let mut memory = Aligned::new(needed);
                                let workspace = memory.pointer();
                                rows.row(what(stringify!($field), &kind), || unsafe {
                                    $field(kernel, bytes, sources, at, to, options, run, workspace, needed, null_mut())
                                });
                            }
                        }
                    }
                    // Boxes beside the points, far away, around them, and without targets.
                    let ends = [[1.0, 2.0], [40.0, 41.0], [-1.0, 1.0], [1.0, -1.0]];
                    let boxes = ends.map(|ends| ends.map(|x| [x as $t; $d]));
                    let none = null_mut();
                    let sum = Sum::new((N, x.as_ptr(), some.as_ptr()), (N, x.as_ptr()), (none, null_mut(), none));
                    rows.row(what(stringify!($essential_size), ""), || unsafe {
                        $essential_size(kernel, bytes, sum.sources(), 1e-3, &raw mut needed)
                    });
                    let mut memory = Aligned::new(needed);
                    let workspace = memory.pointer();
                    let (mut starts, mut found, mut mass) = ([0; 5], [[0.0 as $t; $d]; 4 * N], [0.0 as $t; 4 * N]);
                    rows.row(what(stringify!($essential), ""), || unsafe {
                        $essential(
                            kernel,
                            bytes,
                            sum.sources(),
                            1e-3,
                            4,
                            boxes.as_ptr(),
                            starts.as_mut_ptr(),
                            4 * N,
                            found.as_mut_ptr(),
                            mass.as_mut_ptr(),
                            null_mut(),
                            null(),
                            workspace,
                            needed,
                        )
                    });
                    // Steps with all optional outputs.
                    let wanted = DENSITY | VELOCITY | DIVERGENCE;
                    for (kind, tracers) in [("particles", 0), ("tracers", 5)] {
                        rows.row(what(stringify!($blob_size), kind), || unsafe {
                            $blob_size(kernel, bytes, N, tracers, wanted, null(), null(), &raw mut needed)
                        });
                        let mut memory = Aligned::new(needed);
                        let workspace = memory.pointer();
                        let (mut x, mut rho, mut v, mut div) =
                            (x.clone(), vec![1.0 as $t; N], vec![[0.0 as $t; $d]; N], vec![0.0 as $t; N]);
                        let (mut y, mut rho_y, mut v_y) = (points!(5, $t, $d), [1.0 as $t; 5], [[0.0 as $t; $d]; 5]);
                        let (y, rho_y, v_y) = if tracers == 0 {
                            (null_mut(), null_mut(), null_mut())
                        } else {
                            (y.as_mut_ptr(), rho_y.as_mut_ptr(), v_y.as_mut_ptr())
                        };
                        rows.row(what(stringify!($blob), kind), || unsafe {
                            $blob(
                                kernel,
                                bytes,
                                N,
                                all.as_ptr(),
                                x.as_mut_ptr(),
                                rho.as_mut_ptr(),
                                v.as_mut_ptr(),
                                div.as_mut_ptr(),
                                tracers,
                                y,
                                rho_y,
                                v_y,
                                1e-3,
                                3,
                                null(),
                                null(),
                                null_mut(),
                                workspace,
                                needed,
                            )
                        });
                    }
                }
            }
            rows.finish();
        }
    };
}

check!(line_f64, f64, 1; mollis_kernel1_bytes() mollis_kernel1_prepare();
    mollis_field1_workspace_bytes() mollis_field1_text() mollis_field1_eval(); blob1_workspace_bytes() blob1_step();
    mollis_field1_essential_bytes() mollis_field1_essential());
check!(plane_f64, f64, 2; mollis_kernel2_bytes() mollis_kernel2_prepare();
    mollis_field2_workspace_bytes() mollis_field2_text() mollis_field2_eval(); blob2_workspace_bytes() blob2_step();
    mollis_field2_essential_bytes() mollis_field2_essential());
check!(space_f64, f64, 3; mollis_kernel3_bytes() mollis_kernel3_prepare();
    mollis_field3_workspace_bytes() mollis_field3_text() mollis_field3_eval(); blob3_workspace_bytes() blob3_step();
    mollis_field3_essential_bytes() mollis_field3_essential());
check!(line_f32, f32, 1; mollis_kernel1_bytes_f32() mollis_kernel1_prepare_f32();
    mollis_field1_workspace_bytes_f32() mollis_field1_text_f32() mollis_field1_eval_f32();
    blob1_workspace_bytes_f32() blob1_step_f32();
    mollis_field1_essential_bytes_f32() mollis_field1_essential_f32());
check!(plane_f32, f32, 2; mollis_kernel2_bytes_f32() mollis_kernel2_prepare_f32();
    mollis_field2_workspace_bytes_f32() mollis_field2_text_f32() mollis_field2_eval_f32();
    blob2_workspace_bytes_f32() blob2_step_f32();
    mollis_field2_essential_bytes_f32() mollis_field2_essential_f32());
check!(space_f32, f32, 3; mollis_kernel3_bytes_f32() mollis_kernel3_prepare_f32();
    mollis_field3_workspace_bytes_f32() mollis_field3_text_f32() mollis_field3_eval_f32();
    blob3_workspace_bytes_f32() blob3_step_f32();
    mollis_field3_essential_bytes_f32() mollis_field3_essential_f32());
