//! Kernel sums through the C ABI: values, a kernel of the host, and invalid kernels, each refused with its own code.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_tests::Aligned;
use mollis_tests::positional::*;

const OK: i32 = 0;
const NONE: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_NONE, order: 0, exponent: 0 };
const COMPACT: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 4, exponent: 4 };

fn term(kind: i32, coefficient: f64, parameter: f64) -> mollis_kernel_term {
    mollis_kernel_term { kind, reserved: 0, coefficient, parameter: [parameter, f64::NAN] }
}

/// The codes of the size query and of preparing, in each dimension and scalar. A refused call writes nothing.
fn codes(
    terms: &[mollis_kernel_term],
    own: *const mollis_radial_kernel,
    mollifier: mollis_mollifier,
    delta: f64,
) -> [[i32; 2]; 6] {
    let (mut block, mut bytes) = (Aligned::new(1 << 20), 77_usize);
    let (p, n, b, size) = (terms.as_ptr(), terms.len(), block.pointer(), 1 << 20);
    let bp = &raw mut bytes;
    // SAFETY: live arrays of the stated lengths.
    let got = unsafe {
        [
            [
                mollis_kernel1_bytes(p, n, own, mollifier, bp),
                mollis_kernel1_prepare(b, size, p, n, own, mollifier, delta),
            ],
            [
                mollis_kernel2_bytes(p, n, own, mollifier, bp),
                mollis_kernel2_prepare(b, size, p, n, own, mollifier, delta),
            ],
            [
                mollis_kernel3_bytes(p, n, own, mollifier, bp),
                mollis_kernel3_prepare(b, size, p, n, own, mollifier, delta),
            ],
            [
                mollis_kernel1_bytes_f32(p, n, own, mollifier, bp),
                mollis_kernel1_prepare_f32(b, size, p, n, own, mollifier, delta as f32),
            ],
            [
                mollis_kernel2_bytes_f32(p, n, own, mollifier, bp),
                mollis_kernel2_prepare_f32(b, size, p, n, own, mollifier, delta as f32),
            ],
            [
                mollis_kernel3_bytes_f32(p, n, own, mollifier, bp),
                mollis_kernel3_prepare_f32(b, size, p, n, own, mollifier, delta as f32),
            ],
        ]
    };
    if got.iter().flatten().all(|&code| code != OK) {
        assert!(bytes == 77 && block.is_untouched());
    }
    got
}

#[test]
fn bad_terms_are_refused() {
    let refused = |terms: &[mollis_kernel_term], error: Error| {
        let got = codes(terms, null(), COMPACT, 0.1);
        assert_eq!(got, [[error as i32; 2]; 6], "{terms:?}");
    };
    let good = term(MOLLIS_KERNEL_POWER, 1.0, 3.0);
    for k in [0.0, -1.0] {
        refused(&[good, term(MOLLIS_KERNEL_SCREENED, 1.0, k)], Error::KernelParameter);
        refused(&[good, term(MOLLIS_KERNEL_EXPONENTIAL, 1.0, k)], Error::KernelParameter);
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&[term(MOLLIS_KERNEL_SCREENED, 1.0, value)], Error::NotFinite);
        refused(&[term(MOLLIS_KERNEL_EXPONENTIAL, 1.0, value)], Error::NotFinite);
        refused(&[term(MOLLIS_KERNEL_POWER, 1.0, value)], Error::NotFinite);
        refused(&[term(MOLLIS_KERNEL_NEWTONIAN, value, 0.0), good], Error::NotFinite);
    }
    refused(&[good, term(4, 1.0, 1.0)], Error::UnknownValue);
    refused(&[term(-1, 1.0, 1.0)], Error::UnknownValue);
    refused(&[], Error::KernelTerms);
    refused(&[good; 9], Error::KernelTerms);
    // p > 1 - d is required. The limit is refused, except log|x| in 1D; a value a little above is accepted
    for p in [-0.5, -2.0, -1.0, 0.0] {
        let got = codes(&[term(MOLLIS_KERNEL_POWER, 1.0, p)], null(), COMPACT, 0.1);
        for (k, pair) in got.into_iter().enumerate() {
            let dimension = k % 3 + 1;
            let good = p > 1.0 - dimension as f64 || (dimension == 1 && p == 0.0);
            assert_eq!(pair, [if good { OK } else { Error::KernelParameter as i32 }; 2], "{dimension} {p}");
        }
    }
}

#[test]
fn bad_lengths_and_mollifiers_are_refused() {
    let good = [term(MOLLIS_KERNEL_POWER, 1.0, 3.0)];
    for (delta, error) in [(0.0, Error::Delta), (-1.0, Error::Delta), (f64::NAN, Error::Delta)] {
        for [size, prepare] in codes(&good, null(), COMPACT, delta) {
            assert_eq!((size, prepare), (OK, error as i32));
        }
    }
    let odd = mollis_mollifier { order: 3, ..COMPACT };
    assert_eq!(codes(&good, null(), odd, 0.1), [[Error::Order as i32; 2]; 6]);
    let exponent = mollis_mollifier { exponent: 10, ..COMPACT };
    assert_eq!(codes(&good, null(), exponent, 0.1), [[Error::Exponent as i32; 2]; 6]);
}

/// The behaviour of the callback.
struct Own {
    calls: usize,
    spoil: Option<(usize, f64)>,
    refuse_at: usize,
}

/// |x|^1.5/1.5 in two dimensions.
unsafe extern "C" fn own(context: *mut c_void, r: f64, out: *mut f64) -> mollis_status {
    // SAFETY: the tests pass an `Own`, and the library passes room for three numbers.
    unsafe {
        let own = &mut *context.cast::<Own>();
        own.calls += 1;
        assert!(r > 0.0 && r.is_finite());
        if own.calls == own.refuse_at {
            return 4242;
        }
        let root = r.sqrt();
        let values = [r * root / 1.5, 1.0 / root, 1.5 / root];
        for (k, value) in values.into_iter().enumerate() {
            *out.add(k) = value;
        }
        if let Some((k, value)) = own.spoil.filter(|_| own.calls == 40) {
            *out.add(k) = value;
        }
    }
    OK
}

static MANY: [f64; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

fn radial(context: &mut Own) -> mollis_radial_kernel {
    mollis_radial_kernel {
        context: (&raw mut *context).cast(),
        evaluate: Some(own),
        coefficient: 1.0,
        reach: 4.0,
        tolerance: 0.0,
        least: 0.0,
        n_knots: 0,
        knots: null(),
        errors: null_mut(),
    }
}

#[test]
fn a_bad_kernel_of_the_host_is_refused() {
    for mollifier in [NONE, COMPACT] {
        for spoil in (0..3).flat_map(|k| [f64::NAN, f64::INFINITY].map(|v| (k, v))) {
            let mut context = Own { calls: 0, spoil: Some(spoil), refuse_at: 0 };
            let kernel = radial(&mut context);
            let (mut block, mut bytes) = (Aligned::new(1 << 20), 0);
            // SAFETY: live locals.
            unsafe {
                assert_eq!(mollis_kernel2_bytes(null(), 0, &raw const kernel, mollifier, &raw mut bytes), OK);
                let code = mollis_kernel2_prepare(block.pointer(), bytes, null(), 0, &raw const kernel, mollifier, 0.1);
                assert_eq!(code, Error::NotFinite as i32, "{spoil:?}");
                // the block is not a valid kernel afterwards
                let (r, mut value) = (1.0, 7.0);
                let code = mollis_kernel2_eval(
                    block.pointer(),
                    bytes,
                    1,
                    &raw const r,
                    &raw mut value,
                    null_mut(),
                    null_mut(),
                );
                assert_eq!((code, value), (Error::NotPrepared as i32, 7.0));
            }
        }
        // the status of the callback is returned, and the callback is not called again
        let mut context = Own { calls: 0, spoil: None, refuse_at: 25 };
        let kernel = radial(&mut context);
        let mut block = Aligned::new(1 << 20);
        // SAFETY: live locals.
        let code =
            unsafe { mollis_kernel2_prepare(block.pointer(), 1 << 20, null(), 0, &raw const kernel, mollifier, 0.1) };
        assert_eq!((code, context.calls), (4242, 25));
    }
    let mut context = Own { calls: 0, spoil: None, refuse_at: 0 };
    let good = radial(&mut context);
    let eight = [term(MOLLIS_KERNEL_POWER, 1.0, 3.0); 8];
    assert_eq!(codes(&eight, &raw const good, COMPACT, 0.1), [[Error::KernelTerms as i32; 2]; 6]);
    let mut block = Aligned::new(1 << 20);
    for (kernel, error) in [
        (mollis_radial_kernel { evaluate: None, ..good }, Error::NullPointer),
        (mollis_radial_kernel { coefficient: f64::NAN, ..good }, Error::NotFinite),
        (mollis_radial_kernel { reach: 0.0, ..good }, Error::KernelReach),
        (mollis_radial_kernel { reach: f64::INFINITY, ..good }, Error::KernelReach),
        (mollis_radial_kernel { least: 1e-16, ..good }, Error::OutOfDomain),
        (mollis_radial_kernel { tolerance: -1.0, ..good }, Error::OutOfDomain),
        (mollis_radial_kernel { tolerance: f64::NAN, ..good }, Error::NotFinite),
        (mollis_radial_kernel { n_knots: 1, ..good }, Error::NullPointer),
        (mollis_radial_kernel { n_knots: 2, knots: [1.0, 1.0].as_ptr(), ..good }, Error::KernelKnots),
        (mollis_radial_kernel { n_knots: 1, knots: [4.0].as_ptr(), ..good }, Error::KernelKnots),
        (mollis_radial_kernel { n_knots: 1, knots: [f64::NAN].as_ptr(), ..good }, Error::NotFinite),
        (mollis_radial_kernel { n_knots: 9, knots: MANY.as_ptr(), ..good }, Error::KernelKnots),
        (mollis_radial_kernel { reach: f64::NAN, ..good }, Error::NotFinite),
    ] {
        // SAFETY: live locals.
        let code =
            unsafe { mollis_kernel2_prepare(block.pointer(), 1 << 20, null(), 0, &raw const kernel, COMPACT, 0.1) };
        assert_eq!(code, error as i32);
    }
}

/// The fit of a host's kernel agrees with the library's |x|^1.5/1.5, with another term in the same sum: within 1e-12 of the scale at
/// delta, ten times the bound of known kernels, because errors of the fits on octaves add up.
#[test]
fn a_host_kernel_equals_the_known_one() {
    let delta = 0.2;
    let known_terms =
        [Term { law: Law::Power { exponent: 1.5 }, coefficient: 1.0 }, Term { law: Law::Newtonian, coefficient: -0.5 }];
    for (given, mollifier) in [(NONE, Mollifier::None), (COMPACT, Mollifier::Compact { order: 4, exponent: 4 })] {
        let mut memory = Aligned::new(Kernel::<f64, 2>::workspace_bytes(&known_terms, mollifier).unwrap());
        let known = Kernel::<f64, 2>::prepare(memory.bytes(), &known_terms, mollifier, delta).unwrap();
        let mut context = Own { calls: 0, spoil: None, refuse_at: 0 };
        let kernel = radial(&mut context);
        let terms = [term(MOLLIS_KERNEL_NEWTONIAN, -0.5, 0.0)];
        let (mut block, mut bytes) = (Aligned::new(1 << 20), 0);
        let r: Vec<f64> = (1..=300).map(|k| 0.0123 * f64::from(k)).collect();
        let mut got = [vec![0.0; 300], vec![0.0; 300], vec![0.0; 300]];
        let [u, g, l] = got.each_mut().map(|v| v.as_mut_ptr());
        // SAFETY: live arrays of the stated lengths.
        unsafe {
            assert_eq!(mollis_kernel2_bytes(terms.as_ptr(), 1, &raw const kernel, given, &raw mut bytes), OK);
            let code =
                mollis_kernel2_prepare(block.pointer(), bytes, terms.as_ptr(), 1, &raw const kernel, given, delta);
            assert_eq!(code, OK);
            assert_eq!(mollis_kernel2_eval(block.pointer(), bytes, 300, r.as_ptr(), u, g, l), OK);
        }
        let scale = known.at(delta).map(f64::abs);
        for (k, &r) in r.iter().enumerate().filter(|(_, r)| **r < 3.5) {
            for (n, (want, scale)) in known.at(r).into_iter().zip(scale).enumerate() {
                let error = (got[n][k] - want).abs() / want.abs().max(scale);
                assert!(error < 1e-12, "{mollifier:?} {n} r = {r}: {} {want} {error:e}", got[n][k]);
            }
        }
    }
}

/// A value that becomes infinite stops a run. The state is that of the last completed step, equal to a run of just those steps.
/// Returns the status and the number of completed steps.
macro_rules! blow_up {
    ($t:ty; $size:ident $prepare:ident $scratch:ident $step:ident) => {{
        let terms = [term(MOLLIS_KERNEL_POWER, 1.0, 6.0)];
        let start: Vec<[$t; 2]> = (0..6_u8).map(|k| [<$t>::from(k), <$t>::from(k * k % 5)]).collect();
        let masses = [1.0 as $t; 6];
        let run = |steps: usize| {
            let mut x = start.clone();
            let mut report = mollis_blob_report { steps: 0, first_bad: 0, energy_first: 0.0, energy_last: 0.0 };
            let (mut block, mut bytes) = (Aligned::new(1 << 20), 0);
            let (mut memory, mut memory_bytes) = (Aligned::new(1 << 20), 0);
            let (kernel, none) = (block.pointer(), null_mut::<$t>());
            // SAFETY: live arrays of the stated lengths.
            let code = unsafe {
                assert_eq!($size(terms.as_ptr(), 1, null(), COMPACT, &raw mut bytes), OK);
                assert_eq!($prepare(kernel, bytes, terms.as_ptr(), 1, null(), COMPACT, 0.5), OK);
                assert_eq!($scratch(kernel, bytes, 6, 0, 0, null(), null(), &raw mut memory_bytes), OK);
                let (m, x, points) = (masses.as_ptr(), x.as_mut_ptr(), null_mut());
                let (space, report) = (memory.pointer(), &raw mut report);
                #[rustfmt::skip]
                let code = $step(kernel, bytes, 6, m, x, none, null_mut(), none, 0, points, none, null_mut(), 0.5, steps,
                    null(), null(), report, space, memory_bytes);
                code
            };
            assert!(x.iter().flatten().all(|c| c.is_finite()));
            (code, report.steps, x)
        };
        let (code, steps, state) = run(50);
        assert_eq!(run(steps as usize), (OK, steps, state));
        (code, steps)
    }};
}

#[test]
fn a_run_that_blows_up_keeps_its_last_good_state() {
    let double = blow_up!(f64; mollis_kernel2_bytes mollis_kernel2_prepare blob2_workspace_bytes
        blob2_step);
    let single = blow_up!(f32; mollis_kernel2_bytes_f32 mollis_kernel2_prepare_f32
        blob2_workspace_bytes_f32 blob2_step_f32);
    for (code, steps) in [double, single] {
        assert_eq!(code, Error::BecameNotFinite as i32);
        assert!(steps < 50);
    }
}

/// The field factor of a homogeneous disc of radius 0.25, or of one with a wrong Laplacian if there is a context.
unsafe extern "C" fn disc(wrong: *mut c_void, r: f64, out: *mut f64) -> mollis_status {
    let values = if r < 0.25 { [8.0 * r * r - 0.5, 16.0, 32.0] } else { [(4.0 * r).ln(), 1.0 / (r * r), 0.0] };
    // SAFETY: the library passes room for three numbers.
    unsafe {
        for (k, value) in values.into_iter().enumerate() {
            *out.add(k) = value;
        }
        if !wrong.is_null() {
            *out.add(2) += 1.0;
        }
    }
    OK
}

#[test]
fn a_hosts_knots_errors_and_pairs_beyond_its_reach() {
    let knots = [0.25];
    let mut errors = [7.0; 3];
    let good = mollis_radial_kernel {
        evaluate: Some(disc),
        reach: 1.9,
        n_knots: 1,
        knots: knots.as_ptr(),
        errors: errors.as_mut_ptr(),
        ..radial(&mut Own { calls: 0, spoil: None, refuse_at: 0 })
    };
    let good = mollis_radial_kernel { context: null_mut(), ..good };
    let mut block = Aligned::new(1 << 20);
    let mut bytes = 0;
    // SAFETY: live locals.
    let code = unsafe { mollis_kernel2_bytes(null(), 0, &raw const good, NONE, &raw mut bytes) };
    assert_eq!(code, OK);
    let mut prepare = |own: mollis_radial_kernel| {
        // SAFETY: live locals.
        unsafe { mollis_kernel2_prepare(block.pointer(), bytes, null(), 0, &raw const own, NONE, 0.0) }
    };
    // No knot; functions that do not belong together. Both say what was reached.
    assert_eq!(prepare(mollis_radial_kernel { n_knots: 0, knots: null(), ..good }), Error::KernelFit as i32);
    assert!(errors[1] > 1e-6 && errors[2] > 0.1, "{errors:?}");
    errors = [7.0; 3];
    let wrong = core::ptr::without_provenance_mut(1);
    assert_eq!(prepare(mollis_radial_kernel { context: wrong, ..good }), Error::KernelFit as i32);
    assert!(errors[2] > 0.01, "{errors:?}");
    // Another refusal leaves them as they were.
    errors = [7.0; 3];
    assert_eq!(prepare(mollis_radial_kernel { reach: -1.0, ..good }), Error::KernelReach as i32);
    assert_eq!(errors, [7.0; 3]);
    let overlapping = mollis_radial_kernel { errors: knots.as_ptr().cast_mut(), ..good };
    assert_eq!(prepare(overlapping), Error::Overlap as i32);
    assert_eq!(prepare(good), OK);
    assert!(errors.iter().all(|&e| e < 1e-12), "{errors:?}");
    // Sources at 0.1, 1 and 3 of the target, and one without mass: one pair beyond the reach.
    let (sources, masses, target) =
        ([[0.1, 0.0], [0.0, 1.0], [3.0, 0.0], [9.0, 0.0]], [1.0, 2.0, 4.0, 0.0], [[0.0; 2]]);
    let mut potential = [0.0];
    let mut counters = mollis_field_counts::default();
    let outputs = (potential.as_mut_ptr(), null_mut(), null_mut());
    let sum = mollis_tests::sums::Sum::new((4, sources.as_ptr(), masses.as_ptr()), (1, target.as_ptr()), outputs);
    let (of, at, to) = (sum.sources(), sum.targets(), sum.outputs());
    let mut space = Aligned::new(1 << 16);
    let kernel = block.pointer();
    // SAFETY: live locals of the stated lengths.
    let code = unsafe {
        mollis_field2_eval(kernel, bytes, of, at, to, null(), null(), space.pointer(), 1 << 16, &raw mut counters)
    };
    assert_eq!(code, OK);
    assert_eq!((counters.pairs, counters.beyond_reach), (3, 1));
    let want = 0.08 - 0.5 + 2.0 * 4.0_f64.ln();
    assert!((potential[0] - want).abs() < 1e-14 * 3.0, "{} {want}", potential[0]);
}

/// A prepared kernel may be moved, and a block that is spoilt is refused for what is wrong with it.
#[test]
#[expect(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]
fn a_sum_prepares_moves_and_evaluates_as_in_core() {
    const SUM: [mollis_kernel_term; 2] = [
        mollis_kernel_term { kind: MOLLIS_KERNEL_POWER, reserved: 0, coefficient: 1.0, parameter: [4.0, 0.0] },
        mollis_kernel_term { kind: MOLLIS_KERNEL_POWER, reserved: 0, coefficient: -1.0, parameter: [1.5, 0.0] },
    ];
    #[repr(align(64))]
    struct Memory([u8; 1 << 19]);

    let mut memory = Box::new(Memory([0xA5; 1 << 19]));
    let mut bytes = 0;
    assert_eq!(unsafe { mollis_kernel2_bytes(SUM.as_ptr(), SUM.len(), null(), COMPACT, &raw mut bytes) }, OK);
    let prepare = |memory: &mut Memory, bytes| unsafe {
        let kernel = memory.0.as_mut_ptr().cast();
        mollis_kernel2_prepare(kernel, bytes, SUM.as_ptr(), 2, null(), COMPACT, 0.3)
    };
    assert_eq!(prepare(&mut memory, bytes - 1), Error::WorkspaceTooSmall as i32);
    assert_eq!(prepare(&mut memory, bytes), 0);
    assert!(memory.0[bytes..].iter().all(|&b| b == 0xA5), "written beyond the block");
    // Elsewhere.
    let mut moved = Box::new(Memory([0; 1 << 19]));
    moved.0[..bytes].copy_from_slice(&memory.0[..bytes]);
    let r = [0.0, 0.1, 0.3, 2.0];
    let (mut u, mut g) = ([7.0; 4], [7.0; 4]);
    let eval = |memory: &Memory, bytes, r: *const f64, u: *mut f64, g: *mut f64| unsafe {
        mollis_kernel2_eval(memory.0.as_ptr().cast(), bytes, 4, r, u, g, null_mut())
    };
    assert_eq!(eval(&moved, bytes, r.as_ptr(), u.as_mut_ptr(), g.as_mut_ptr()), 0);
    let core = Kernel::<f64, 2>::open(&memory.0[..bytes]).unwrap();
    for (k, &r) in r.iter().enumerate() {
        assert_eq!([u[k], g[k]], [core.value(r), core.gradient_factor(r)]);
    }
    // Every refusal leaves the outputs alone.
    let before = (u, g);
    let bad = [0.0, f64::NAN, 0.3, 2.0];
    let up = u.as_mut_ptr();
    let refusals = [
        (eval(&moved, bytes, bad.as_ptr(), up, null_mut()), Error::NotFinite),
        (eval(&moved, bytes, null(), up, null_mut()), Error::NullPointer),
        (eval(&moved, bytes - 1, r.as_ptr(), up, null_mut()), Error::WorkspaceTooSmall),
        (eval(&moved, 8, r.as_ptr(), up, null_mut()), Error::NotPrepared),
        (eval(&moved, bytes, r.as_ptr(), up, up), Error::Overlap),
    ];
    for (status, error) in refusals {
        assert_eq!(status, error as i32);
    }
    let single = unsafe {
        mollis_kernel2_eval_f32(moved.0.as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut())
    };
    assert_eq!(single, Error::WrongScalar as i32);
    let other =
        unsafe { mollis_kernel3_eval(moved.0.as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut()) };
    assert_eq!(other, Error::NotPrepared as i32);
    let askew = unsafe {
        mollis_kernel2_eval(moved.0[4..].as_ptr().cast(), bytes, 0, null(), null_mut(), null_mut(), null_mut())
    };
    assert_eq!(askew, Error::Misaligned as i32);
    moved.0[8] ^= 2;
    assert_eq!(eval(&moved, bytes, r.as_ptr(), up, null_mut()), Error::WrongVersion as i32);
    moved.0[..8].reverse();
    assert_eq!(eval(&moved, bytes, r.as_ptr(), up, null_mut()), Error::WrongByteOrder as i32);
    moved.0[..64].fill(0);
    assert_eq!(eval(&moved, bytes, r.as_ptr(), up, null_mut()), Error::NotPrepared as i32);
    assert_eq!((u, g), before);
}
