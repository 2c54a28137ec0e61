//! Every dimension and scalar of the C ABI gives the same bits as the Rust functions. Each C function is written separately, so each
//! is called here. The last tests cover what a field sum refuses; a refused call writes nothing.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![expect(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ffi::{CStr, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::aggregation;
use mollis_core::exec::Run;
use mollis_core::field::{self, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::{Blob, Mollifier, Quantity, Richardson};
use mollis_core::real::Real;
use mollis_tests::Aligned;
use mollis_tests::positional::*;
use mollis_tests::sums::Sum;

fn number(k: usize) -> f64 {
    (k as f64 * 1.37).sin()
}

fn points<T: Real, const D: usize>(n: usize, from: usize) -> Vec<[T; D]> {
    (0..n).map(|i| std::array::from_fn(|k| T::from_f64(number(D * (i + from) + k)))).collect()
}

fn masses<T: Real>(n: usize) -> Vec<T> {
    (0..n).map(|i| T::from_f64(0.3 + number(7 * i))).collect()
}

const MOLLIFIER: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 4, exponent: 3 };
const CORE_MOLLIFIER: Mollifier = Mollifier::Compact { order: 4, exponent: 3 };
const DELTA: f64 = 0.4;

/// Newtonian repulsion and a cubic attraction, one of which has a fit.
fn c_terms() -> [mollis_kernel_term; 2] {
    let term = |kind, coefficient, parameter| mollis_kernel_term {
        kind,
        reserved: 0,
        coefficient,
        parameter: [parameter, 0.0],
    };
    [term(MOLLIS_KERNEL_NEWTONIAN, -1.0, 0.0), term(MOLLIS_KERNEL_POWER, 0.7, 3.0)]
}

fn terms() -> [Term; 2] {
    [Term { law: Law::Newtonian, coefficient: -1.0 }, Term { law: Law::Power { exponent: 3.0 }, coefficient: 0.7 }]
}

fn run_options() -> mollis_run {
    let mut run = MaybeUninit::<mollis_run>::uninit();
    // SAFETY: the call fills a structure of the stated size.
    unsafe {
        assert_eq!(mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()), 0);
        run.assume_init()
    }
}

fn field_options() -> mollis_field_options {
    let mut options = MaybeUninit::<mollis_field_options>::uninit();
    // SAFETY: the call fills a structure of the stated size.
    unsafe {
        assert_eq!(mollis_field_options_init(options.as_mut_ptr(), size_of::<mollis_field_options>()), 0);
        options.assume_init()
    }
}

macro_rules! same {
    ($name:ident, $t:ty, $d:literal, kernel $kb:ident $kp:ident $ke:ident, field $fb:ident $ft:ident $fe:ident,
     blob $bb:ident $bs:ident, mollifier $m:ident $mf:ident $rich:ident $moment:ident) => {
        #[test]
        fn $name() {
            let good = |status: mollis_status| assert_eq!(status, 0);
            // Kernels: size, preparation, values.
            let c_terms = c_terms();
            let mut bytes = 0;
            // SAFETY: live buffers of the stated sizes, here and in every call below.
            good(unsafe { $kb(c_terms.as_ptr(), 2, null(), MOLLIFIER, &raw mut bytes) });
            assert_eq!(bytes, Kernel::<$t, $d>::workspace_bytes(&terms(), CORE_MOLLIFIER).unwrap());
            let (mut c_block, mut block) = (Aligned::new(bytes), Aligned::new(bytes));
            good(unsafe { $kp(c_block.pointer(), bytes, c_terms.as_ptr(), 2, null(), MOLLIFIER, DELTA as $t) });
            let kernel = Kernel::<$t, $d>::prepare(block.bytes(), &terms(), CORE_MOLLIFIER, DELTA as $t).unwrap();
            let radii: Vec<$t> = (0..40).map(|k| 0.07 * k as $t).collect();
            let mut values = vec![[0.0 as $t; 40]; 3];
            let [u, g, l] = &mut values[..] else { unreachable!() };
            good(unsafe {
                $ke(c_block.pointer(), bytes, 40, radii.as_ptr(), u.as_mut_ptr(), g.as_mut_ptr(), l.as_mut_ptr())
            });
            for (i, &r) in radii.iter().enumerate() {
                assert_eq!([values[0][i], values[1][i], values[2][i]], kernel.at(r), "r = {r}");
            }

            // Fields of the sum, and of the Newtonian kernel alone, which uses another loop.
            for n_terms in [2, 1] {
                let mut bytes = 0;
                good(unsafe { $kb(c_terms.as_ptr(), n_terms, null(), MOLLIFIER, &raw mut bytes) });
                let (mut c_block, mut block) = (Aligned::new(bytes), Aligned::new(bytes));
                good(unsafe {
                    $kp(c_block.pointer(), bytes, c_terms.as_ptr(), n_terms, null(), MOLLIFIER, DELTA as $t)
                });
                let kernel =
                    Kernel::<$t, $d>::prepare(block.bytes(), &terms()[..n_terms], CORE_MOLLIFIER, DELTA as $t).unwrap();
                let (n, m) = (150, 131);
                let (positions, masses, targets) = (points::<$t, $d>(n, 0), masses::<$t>(n), points::<$t, $d>(m, n));
                let (options, run) = (field_options(), run_options());
                let mut needed = 0;
                let outputs = || (vec![0.0 as $t; m], vec![[0.0 as $t; $d]; m], vec![0.0 as $t; m]);
                let (mut c, mut rust) = (outputs(), outputs());
                let to = (c.0.as_mut_ptr(), c.1.as_mut_ptr(), c.2.as_mut_ptr());
                let sum = Sum::new((n, positions.as_ptr(), masses.as_ptr()), (m, targets.as_ptr()), to);
                let (sources, at, to) = (sum.sources(), sum.targets(), sum.outputs());
                good(unsafe {
                    let (options, run) = (&raw const options, &raw const run);
                    $fb(c_block.pointer(), bytes, sources, at, to, options, run, &raw mut needed)
                });
                let wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
                let plan = field::plan(&kernel, n, m, wanted, &Options::default()).unwrap();
                // And what brings the start to the alignment.
                assert_eq!(needed, plan.workspace_bytes(1).unwrap() + ALIGN - 1);
                let (mut text, mut length) = ([0_u8; 600], 0);
                good(unsafe {
                    let (block, into) = (c_block.pointer(), text.as_mut_ptr().cast());
                    $ft(block, bytes, sources, at, to, null(), into, text.len(), &raw mut length)
                });
                let text = CStr::from_bytes_until_nul(&text).unwrap().to_str().unwrap();
                assert_eq!((text, text.len()), (plan.to_string().as_str(), length));
                let mut space = Aligned::new(needed);
                good(unsafe {
                    let (options, run) = (&raw const options, &raw const run);
                    $fe(c_block.pointer(), bytes, sources, at, to, options, run, space.pointer(), needed, null_mut())
                });
                let to = Outputs {
                    potential: Some(&mut rust.0[..]),
                    gradient: Some(&mut rust.1[..]),
                    laplacian: Some(&mut rust.2[..]),
                    hessian: None,
                };
                let sources = Sources::new(&positions, &masses);
                field::evaluate(&plan, &kernel, sources, &targets, to, space.bytes(), &mut Run::default()).unwrap();
                assert_eq!(c, rust);
            }

            // The blob method: two steps with densities, then compared.
            let n = 21;
            let (mut wanted_bytes, mut report) = (0, MaybeUninit::<mollis_blob_report>::zeroed());
            good(unsafe {
                let (block, to) = (c_block.pointer(), &raw mut wanted_bytes);
                $bb(block, bytes, n, 0, DENSITY, null(), null(), to)
            });
            let plan_wanted = aggregation::Wanted { density: true, ..aggregation::Wanted::default() };
            let plan = aggregation::plan(&kernel, n, 0, plan_wanted, &Options::default()).unwrap();
            assert_eq!(wanted_bytes, plan.workspace_bytes::<$t, $d>(1).unwrap() + ALIGN - 1);
            let mass = masses::<$t>(n);
            let (mut c_x, mut c_rho) = (points::<$t, $d>(n, 3), vec![1.0 as $t; n]);
            let (mut x, mut rho) = (c_x.clone(), c_rho.clone());
            let mut space = Aligned::new(wanted_bytes);
            good(unsafe {
                $bs(
                    c_block.pointer(),
                    bytes,
                    n,
                    mass.as_ptr(),
                    c_x.as_mut_ptr(),
                    c_rho.as_mut_ptr(),
                    null_mut(),
                    null_mut(),
                    0,
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    0.01,
                    2,
                    null(),
                    null(),
                    report.as_mut_ptr(),
                    space.pointer(),
                    wanted_bytes,
                )
            });
            let state = aggregation::State {
                masses: &mass,
                particles: aggregation::Trajectories {
                    positions: &mut x,
                    density: Some(&mut rho),
                    velocity: None,
                    divergence: None,
                },
                tracers: aggregation::Trajectories::none(),
            };
            let advance = aggregation::Advance { dt: 0.01 as $t, steps: 2, after_step: None };
            aggregation::step(
                &plan,
                &kernel,
                state,
                advance,
                space.bytes(),
                &mut Run::default(),
                &mut aggregation::Report::default(),
            )
            .unwrap();
            assert_eq!((c_x, c_rho), (x, rho));

            // Mollifiers: radii, points, combinations, moments.
            let blob = Blob::<$t, $d>::new(CORE_MOLLIFIER, DELTA as $t).unwrap();
            let mut six = [[0.0 as $t; 40]; 6];
            let p = six.each_mut().map(|out| out.as_mut_ptr());
            good(unsafe { $m(MOLLIFIER, DELTA as $t, 40, radii.as_ptr(), p[0], p[1], p[2], p[3], p[4], p[5]) });
            for (quantity, got) in Quantity::ALL.into_iter().zip(&six) {
                assert!(got.iter().zip(&radii).all(|(&got, &r)| got == blob.evaluate(quantity, r)), "{quantity:?}");
            }
            let x = points::<$t, $d>(40, 11);
            let mut gradient = [[0.0 as $t; $d]; 40];
            let mut hessian = [[[0.0 as $t; $d]; $d]; 40];
            let mut two = [[0.0 as $t; 40]; 2];
            let p = two.each_mut().map(|out| out.as_mut_ptr());
            good(unsafe {
                let (g, h) = (gradient.as_mut_ptr(), hessian.as_mut_ptr());
                $mf(MOLLIFIER, DELTA as $t, 40, x.as_ptr(), p[0], p[1], g, h)
            });
            for (i, x) in x.iter().enumerate() {
                assert_eq!((two[0][i], two[1][i]), (blob.density_at(x), blob.potential_at(x)));
                assert_eq!((gradient[i], hessian[i]), (blob.gradient_at(x), blob.hessian_at(x)));
            }
            let lengths = [1.0 as $t, 0.5];
            let combination = Richardson::<$t, $d>::new(CORE_MOLLIFIER, DELTA as $t, &lengths).unwrap();
            let (mut weights, p) = ([0.0 as $t; 2], six.each_mut().map(|out| out.as_mut_ptr()));
            good(unsafe {
                let (lengths, weights, r) = (lengths.as_ptr(), weights.as_mut_ptr(), radii.as_ptr());
                $rich(MOLLIFIER, DELTA as $t, 2, lengths, weights, 40, r, p[0], p[1], p[2], p[3], p[4], p[5])
            });
            assert!(weights.into_iter().eq(combination.weights()));
            for (quantity, got) in Quantity::ALL.into_iter().zip(&six) {
                assert!(got.iter().zip(&radii).all(|(&got, &r)| got == combination.evaluate(quantity, r)));
            }
            for k in [0, 2, 4] {
                let mut moment = 0.0 as $t;
                good(unsafe { $moment(MOLLIFIER, DELTA as $t, k, &raw mut moment) });
                assert_eq!(moment, blob.moment(k).unwrap());
            }
        }
    };
}

same! { one_dimension_f64, f64, 1,
kernel mollis_kernel1_bytes mollis_kernel1_prepare mollis_kernel1_eval,
field mollis_field1_workspace_bytes mollis_field1_text mollis_field1_eval,
blob blob1_workspace_bytes blob1_step,
mollifier mollis_mollifier1_eval mollis_mollifier1_field mollis_mollifier1_richardson mollis_mollifier1_moment }
same! { two_dimensions_f64, f64, 2,
kernel mollis_kernel2_bytes mollis_kernel2_prepare mollis_kernel2_eval,
field mollis_field2_workspace_bytes mollis_field2_text mollis_field2_eval,
blob blob2_workspace_bytes blob2_step,
mollifier mollis_mollifier2_eval mollis_mollifier2_field mollis_mollifier2_richardson mollis_mollifier2_moment }
same! { three_dimensions_f64, f64, 3,
kernel mollis_kernel3_bytes mollis_kernel3_prepare mollis_kernel3_eval,
field mollis_field3_workspace_bytes mollis_field3_text mollis_field3_eval,
blob blob3_workspace_bytes blob3_step,
mollifier mollis_mollifier3_eval mollis_mollifier3_field mollis_mollifier3_richardson mollis_mollifier3_moment }
same! { one_dimension_f32, f32, 1,
kernel mollis_kernel1_bytes_f32 mollis_kernel1_prepare_f32 mollis_kernel1_eval_f32,
field mollis_field1_workspace_bytes_f32 mollis_field1_text_f32 mollis_field1_eval_f32,
blob blob1_workspace_bytes_f32 blob1_step_f32,
mollifier mollis_mollifier1_eval_f32 mollis_mollifier1_field_f32 mollis_mollifier1_richardson_f32
mollis_mollifier1_moment_f32 }
same! { two_dimensions_f32, f32, 2,
kernel mollis_kernel2_bytes_f32 mollis_kernel2_prepare_f32 mollis_kernel2_eval_f32,
field mollis_field2_workspace_bytes_f32 mollis_field2_text_f32 mollis_field2_eval_f32,
blob blob2_workspace_bytes_f32 blob2_step_f32,
mollifier mollis_mollifier2_eval_f32 mollis_mollifier2_field_f32 mollis_mollifier2_richardson_f32
mollis_mollifier2_moment_f32 }
same! { three_dimensions_f32, f32, 3,
kernel mollis_kernel3_bytes_f32 mollis_kernel3_prepare_f32 mollis_kernel3_eval_f32,
field mollis_field3_workspace_bytes_f32 mollis_field3_text_f32 mollis_field3_eval_f32,
blob blob3_workspace_bytes_f32 blob3_step_f32,
mollifier mollis_mollifier3_eval_f32 mollis_mollifier3_field_f32 mollis_mollifier3_richardson_f32
mollis_mollifier3_moment_f32 }

#[test]
fn heaviside_and_version() {
    let blob = Blob::<f64, 1>::new(CORE_MOLLIFIER, DELTA).unwrap();
    let single = Blob::<f32, 1>::new(CORE_MOLLIFIER, DELTA as f32).unwrap();
    let x = [-1.0, -0.1, 0.0, 0.2, 0.7];
    let (mut values, mut values32) = ([0.0; 5], [0.0_f32; 5]);
    let x32 = x.map(|x| x as f32);
    // SAFETY: live arrays of the stated lengths.
    unsafe {
        assert_eq!(mollis_mollifier1_heaviside(MOLLIFIER, DELTA, 5, x.as_ptr(), values.as_mut_ptr()), 0);
        let (from, to) = (x32.as_ptr(), values32.as_mut_ptr());
        assert_eq!(mollis_mollifier1_heaviside_f32(MOLLIFIER, DELTA as f32, 5, from, to), 0);
    }
    assert_eq!(values, x.map(|x| blob.heaviside(x)));
    assert_eq!(values32, x32.map(|x| single.heaviside(x)));
    assert_eq!(mollis_abi_version(), 1);
    let header = include_str!("../../include/mollis.h");
    assert!(header.contains("#define MOLLIS_ABI_VERSION 1\n"));
}

/// Arguments of `mollis_field2_eval`. Each case makes one of them invalid.
#[derive(Clone, Copy)]
struct Call {
    kernel: *const c_void,
    kernel_bytes: usize,
    n_sources: usize,
    positions: *const [f64; 2],
    masses: *const f64,
    n_targets: usize,
    targets: *const [f64; 2],
    potential: *mut f64,
    gradient: *mut [f64; 2],
    options: *const mollis_field_options,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
}

#[test]
fn a_field_sum_refuses_with_its_own_code_and_writes_nothing() {
    const N: usize = 9;
    let terms = c_terms();
    let mut bytes = 0;
    // SAFETY: live buffers of the stated sizes, here and below.
    unsafe {
        assert_eq!(mollis_kernel2_bytes(terms.as_ptr(), 1, null(), MOLLIFIER, &raw mut bytes), 0);
    }
    let mut block = Aligned::new(bytes);
    let prepared =
        unsafe { mollis_kernel2_prepare(block.pointer(), bytes, terms.as_ptr(), 1, null(), MOLLIFIER, DELTA) };
    assert_eq!(prepared, 0);
    let mut spoilt = Aligned::new(bytes);
    spoilt.bytes().copy_from_slice(block.bytes());
    spoilt.bytes()[0] ^= 0xFF;
    let (positions, masses) = (points::<f64, 2>(N, 0), masses::<f64>(N));
    let with = |at: usize, value: f64| {
        let mut positions = positions.clone();
        positions[at / 2][at % 2] = value;
        positions
    };
    let (nan, infinite) = (with(17, f64::NAN), with(4, f64::INFINITY));
    let mut bad_masses = masses.clone();
    bad_masses[3] = f64::NEG_INFINITY;
    let (good_options, good_run) = (field_options(), run_options());
    let mut needed = 0;
    let (mut potential, mut gradient) = (vec![7.5; N], vec![[7.5; 2]; N]);
    let code = unsafe {
        let sum = Sum::new(
            (N, positions.as_ptr(), masses.as_ptr()),
            (N, positions.as_ptr()),
            (potential.as_mut_ptr(), gradient.as_mut_ptr(), null_mut()),
        );
        let (options, run, to) = (&raw const good_options, &raw const good_run, &raw mut needed);
        let (kernel, sources, targets) = (block.pointer(), sum.sources(), sum.targets());
        mollis_field2_workspace_bytes(kernel, bytes, sources, targets, sum.outputs(), options, run, to)
    };
    assert_eq!(code, 0);
    let option = |change: fn(&mut mollis_field_options)| {
        let mut options = good_options;
        change(&mut options);
        options
    };
    let no_method = option(|o| o.method = 99);
    let no_accumulation = option(|o| o.accumulation = -1);
    let no_number = option(|o| o.combination[1] = f64::NAN);
    let no_size = option(|o| o.size = 3);
    let mut no_level = good_run;
    no_level.level = 99;
    let mut other_level = good_run;
    other_level.level = if cfg!(target_arch = "x86_64") { MOLLIS_LEVEL_NEON } else { MOLLIS_LEVEL_AVX2 };
    let mut space = Aligned::new(needed + ALIGN);
    let good = Call {
        kernel: block.pointer(),
        kernel_bytes: bytes,
        n_sources: N,
        positions: positions.as_ptr(),
        masses: masses.as_ptr(),
        n_targets: N,
        targets: positions.as_ptr(),
        potential: potential.as_mut_ptr(),
        gradient: gradient.as_mut_ptr(),
        options: &raw const good_options,
        workspace: space.pointer(),
        workspace_bytes: needed,
        run: &raw const good_run,
    };
    let evaluate = |call: Call| unsafe {
        let Call { kernel, kernel_bytes, n_sources, positions, masses, n_targets, targets, .. } = call;
        let Call { potential, gradient, options, workspace, workspace_bytes, run, .. } = call;
        let sum = Sum::new((n_sources, positions, masses), (n_targets, targets), (potential, gradient, null_mut()));
        let (sources, targets, outputs) = (sum.sources(), sum.targets(), sum.outputs());
        let space = (workspace, workspace_bytes);
        mollis_field2_eval(kernel, kernel_bytes, sources, targets, outputs, options, run, space.0, space.1, null_mut())
    };
    let byte = |pointer: *const c_void, by: isize| pointer.cast::<u8>().wrapping_offset(by).cast::<c_void>();
    type Case<'a> = (&'a str, Error, &'a dyn Fn(&mut Call));
    let spoilt = spoilt.pointer();
    let cases: &[Case<'_>] = &[
        ("no kernel", Error::NullPointer, &|c| c.kernel = null()),
        ("kernel misaligned", Error::Misaligned, &|c| c.kernel = byte(c.kernel, 4)),
        ("kernel spoilt", Error::NotPrepared, &|c| c.kernel = spoilt),
        ("kernel cut", Error::NotPrepared, &|c| c.kernel_bytes = 8),
        ("no positions", Error::NullPointer, &|c| c.positions = null()),
        ("no masses", Error::NullPointer, &|c| c.masses = null()),
        ("no targets", Error::NullPointer, &|c| c.targets = null()),
        ("positions misaligned", Error::Misaligned, &|c| c.positions = byte(c.positions.cast(), 1).cast()),
        ("gradient misaligned", Error::Misaligned, &|c| c.gradient = byte(c.gradient.cast(), 3).cast_mut().cast()),
        ("too many sources", Error::TooLarge, &|c| c.n_sources = usize::MAX / 16 + 1),
        ("too many targets", Error::TooLarge, &|c| c.n_targets = usize::MAX / 8),
        ("NaN", Error::NotFinite, &|c| c.positions = nan.as_ptr()),
        ("infinite target", Error::NotFinite, &|c| c.targets = infinite.as_ptr()),
        ("infinite mass", Error::NotFinite, &|c| c.masses = bad_masses.as_ptr()),
        ("one byte short", Error::WorkspaceTooSmall, &|c| c.workspace_bytes -= 1),
        ("no workspace", Error::NullPointer, &|c| c.workspace = null_mut()),
        ("outputs overlap", Error::Overlap, &|c| c.gradient = c.potential.cast()),
        ("output in input", Error::Overlap, &|c| c.gradient = c.targets.cast_mut()),
        ("workspace in output", Error::Overlap, &|c| c.potential = c.workspace.cast()),
        ("unknown method", Error::UnknownValue, &|c| c.options = &raw const no_method),
        ("unknown accumulation", Error::UnknownValue, &|c| c.options = &raw const no_accumulation),
        ("combination", Error::NotFinite, &|c| c.options = &raw const no_number),
        ("size of options", Error::OptionsSize, &|c| c.options = &raw const no_size),
        ("unknown level", Error::UnknownValue, &|c| c.run = &raw const no_level),
        ("another machine's level", Error::Unsupported, &|c| c.run = &raw const other_level),
    ];
    for (what, error, spoil) in cases {
        let mut call = good;
        spoil(&mut call);
        assert_eq!(evaluate(call), *error as i32, "{what}");
        assert!(potential.iter().chain(gradient.as_flattened()).all(|&x| x == 7.5), "{what} wrote");
        assert_eq!(positions, points::<f64, 2>(N, 0), "{what} wrote into an input");
    }
    // Zero points are valid, with null for every array. The valid call succeeds.
    let nothing = Call { n_sources: 0, n_targets: 0, ..good };
    let (positions, masses, targets, potential, gradient) = (null(), null(), null(), null_mut(), null_mut());
    assert_eq!(evaluate(Call { positions, masses, targets, potential, gradient, ..nothing }), 0);
    assert_eq!(evaluate(good), 0);
    // A workspace may begin anywhere.
    for by in [1, 8, 63] {
        assert_eq!(evaluate(Call { workspace: byte(good.workspace, by).cast_mut(), ..good }), 0);
    }
}

#[test]
fn a_kernel_refuses_with_its_own_code_and_leaves_the_buffer() {
    let good = c_terms();
    let mut bytes = 0;
    // SAFETY: live buffers of the stated sizes, here and below.
    unsafe { assert_eq!(mollis_kernel2_bytes(good.as_ptr(), 2, null(), MOLLIFIER, &raw mut bytes), 0) };
    let compact = |order, exponent| mollis_mollifier { order, exponent, ..MOLLIFIER };
    let with = |kind, parameter| {
        let mut terms = good;
        terms[1] = mollis_kernel_term { kind, parameter: [parameter, 0.0], ..terms[1] };
        terms
    };
    let many = [good[0]; MOLLIS_KERNEL_MAX_TERMS + 1];
    let mut unbounded = good;
    unbounded[0].coefficient = f64::NAN;
    type Case<'a> = (&'a str, Error, &'a [mollis_kernel_term], mollis_mollifier, f64);
    let cases: &[Case<'_>] = &[
        ("delta 0", Error::Delta, &good, MOLLIFIER, 0.0),
        ("delta negative", Error::Delta, &good, MOLLIFIER, -1.0),
        ("delta NaN", Error::Delta, &good, MOLLIFIER, f64::NAN),
        ("delta infinite", Error::Delta, &good, MOLLIFIER, f64::INFINITY),
        ("order 3", Error::Order, &good, compact(3, 4), 0.5),
        ("order 10", Error::Order, &good, compact(10, 4), 0.5),
        ("exponent 0", Error::Exponent, &good, compact(2, 0), 0.5),
        ("exponent 10", Error::Exponent, &good, compact(2, 10), 0.5),
        ("mollifier unknown", Error::UnknownValue, &good, mollis_mollifier { kind: 7, ..MOLLIFIER }, 0.5),
        ("kernel unknown", Error::UnknownValue, &with(9, 1.0), MOLLIFIER, 0.5),
        ("power 1 - d", Error::KernelParameter, &with(MOLLIS_KERNEL_POWER, -1.0), MOLLIFIER, 0.5),
        ("power NaN", Error::NotFinite, &with(MOLLIS_KERNEL_POWER, f64::NAN), MOLLIFIER, 0.5),
        ("screening 0", Error::KernelParameter, &with(MOLLIS_KERNEL_SCREENED, 0.0), MOLLIFIER, 0.5),
        ("length negative", Error::KernelParameter, &with(MOLLIS_KERNEL_EXPONENTIAL, -2.0), MOLLIFIER, 0.5),
        ("no term", Error::KernelTerms, &[], MOLLIFIER, 0.5),
        ("too many terms", Error::KernelTerms, &many, MOLLIFIER, 0.5),
        ("coefficient NaN", Error::NotFinite, &unbounded, MOLLIFIER, 0.5),
    ];
    let mut block = Aligned::new(bytes + 8);
    for &(what, error, terms, mollifier, delta) in cases {
        let to = block.pointer();
        let code = unsafe { mollis_kernel2_prepare(to, bytes, terms.as_ptr(), terms.len(), null(), mollifier, delta) };
        assert_eq!(code, error as i32, "{what}");
        assert!(block.is_untouched(), "{what} wrote");
    }
    let start = block.pointer();
    let misaligned = start.cast::<u8>().wrapping_add(4).cast::<c_void>();
    for (what, error, to, bytes) in [
        ("one byte short", Error::WorkspaceTooSmall, start, bytes - 1),
        ("misaligned", Error::Misaligned, misaligned, bytes),
        ("null", Error::NullPointer, null_mut(), bytes),
    ] {
        let code = unsafe { mollis_kernel2_prepare(to, bytes, good.as_ptr(), 2, null(), MOLLIFIER, 0.5) };
        assert_eq!(code, error as i32, "{what}");
        assert!(block.is_untouched(), "{what} wrote");
    }
}
