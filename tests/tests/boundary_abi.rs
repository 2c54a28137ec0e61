//! Rules for every function of the C interface: sizes of options, statuses of the host's functions, sizes checked before data, the first bad
//! element. Also the limits of a mesh that the header states.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it, or what the library must notice before it uses it"
)]

use std::ffi::{CStr, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_tests::positional::*;
use mollis_tests::sums::Sum;
use mollis_tests::{Aligned, Split};

const OK: i32 = 0;
const COMPACT: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 4, exponent: 4 };
const NONE: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_NONE, order: 0, exponent: 0 };

/// A structure as its `_init` function leaves it.
pub(crate) fn filled<X>(init: unsafe extern "C" fn(*mut X, usize) -> i32) -> X {
    let mut value = MaybeUninit::<X>::uninit();
    unsafe {
        assert_eq!(init(value.as_mut_ptr(), size_of::<X>()), OK);
        value.assume_init()
    }
}

/// A prepared kernel of one term.
fn kernel(kind: i32, coefficient: f64, parameter: f64, mollifier: mollis_mollifier, delta: f64) -> Aligned {
    let term = mollis_kernel_term { kind, reserved: 0, coefficient, parameter: [parameter, 0.0] };
    let mut bytes = 0;
    unsafe {
        assert_eq!(mollis_kernel2_bytes(&raw const term, 1, null(), mollifier, &raw mut bytes), OK);
        let mut block = Aligned::new(bytes);
        let made = mollis_kernel2_prepare(block.pointer(), bytes, &raw const term, 1, null(), mollifier, delta);
        assert_eq!(made, OK);
        block
    }
}

fn newtonian() -> Aligned {
    kernel(MOLLIS_KERNEL_NEWTONIAN, 1.0, 0.0, COMPACT, 0.3)
}

/// For every size from 0 to beyond the structure: `_init` and the function that reads it accept only sizes at which a member ends.
fn takes_ends_of_members<X: Copy>(
    ends: &[usize],
    init: unsafe extern "C" fn(*mut X, usize) -> i32,
    read: impl Fn(*const X) -> i32,
) {
    assert_eq!(ends.last(), Some(&size_of::<X>()));
    let good = filled(init);
    for size in 0..size_of::<X>() + 70 {
        let is_end = ends.contains(&size);
        let mut block = Aligned::new(size_of::<X>() + 128);
        let code = unsafe { init(block.pointer().cast(), size) };
        assert_eq!(code, if is_end { OK } else { Error::OptionsSize as i32 }, "_init of {size}");
        if is_end {
            assert!(block.bytes()[size..].iter().all(|&byte| byte == 0xA5), "_init of {size} wrote beyond");
            // Bytes beyond the size of an older header are not read.
            assert_eq!(read(block.pointer().cast()), OK, "{size}");
        } else {
            assert!(block.is_untouched());
        }
        let mut value = good;
        // The size is the first member of each structure.
        unsafe { (&raw mut value).cast::<u32>().write(size as u32) };
        let want = match size {
            0 => Error::NotInitialised as i32,
            _ if is_end => OK,
            _ => Error::OptionsSize as i32,
        };
        assert_eq!(read(&raw const value), want, "{size}");
    }
}

/// The tables are those of the C structures on a 64-bit machine.
#[test]
#[cfg(target_pointer_width = "64")]
fn options_end_where_a_member_ends() {
    let mut block = newtonian();
    let (kernel, length) = (block.pointer().cast_const(), block.bytes().len());
    let (x, m, mut gradient) = ([[0.0; 2]; 3], [1.0; 3], [[0.0; 2]; 3]);
    let to = (null_mut(), gradient.as_mut_ptr(), null_mut());
    let sum = Sum::<f64, 2>::new((3, x.as_ptr(), m.as_ptr()), (3, x.as_ptr()), to);
    takes_ends_of_members(&[4, 8, 16, 24, 32, 40, 48, 56], mollis_run_init, |run| unsafe {
        mollis_field2_workspace_bytes(kernel, length, sum.sources(), null(), sum.outputs(), null(), run, &mut 0)
    });
    takes_ends_of_members(&[4, 8, 12, 16, 32, 40], mollis_field_options_init, |options| unsafe {
        mollis_field2_workspace_bytes(kernel, length, sum.sources(), null(), sum.outputs(), options, null(), &mut 0)
    });
    takes_ends_of_members(&[4, 8, 16, 24, 32, 48, 56, 64, 80, 88], mollis_blob_options_init, |options| unsafe {
        blob2_workspace_bytes(kernel, length, 3, 0, 0, options, null(), &mut 0)
    });
    let mesh = mollis_mesh2 { lower: [0.0; 2], upper: [1.0; 2], cells: [8, 8] };
    takes_ends_of_members(&[4, 8, 16, 20, 24, 32, 40], mollis_grid2_options_init, |options| unsafe {
        grid2_workspace_bytes(&raw const mesh, options, null(), &mut 0)
    });
    let ends = [4, 8, 12, 16, 24, 32, 40, 48, 56, 64, 68, 72, 80, 112, 116, 120, 128];
    takes_ends_of_members(&ends, mollis_pks_options_init, |options| unsafe {
        pks_workspace_bytes(3, options, &NOTHING, null(), &mut 0)
    });
    let text = unsafe { CStr::from_ptr(mollis_status_text(Error::NotInitialised as i32)) };
    assert_eq!(text, c"the options structure was not filled by its _init function");
}

pub(crate) const NOTHING: mollis_pks_attraction = mollis_pks_attraction {
    kind: MOLLIS_PKS_ATTRACTION_NONE,
    reserved: 0,
    mesh: null(),
    grid: null(),
    kernel: null(),
    kernel_bytes: 0,
    tolerance: 0.0,
    heavy: 0.0,
};

static MESH: mollis_mesh2 = mollis_mesh2 { lower: [-2.0; 2], upper: [2.0; 2], cells: [8, 8] };
/// Number of particles, of sources, and of targets.
const N: usize = 12;

/// The four functions that take a run, each with its own arrays, which a test may change.
struct Calls {
    x: Vec<[f64; 2]>,
    m: Vec<f64>,
    targets: Vec<[f64; 2]>,
    pks: mollis_pks_options,
    field: mollis_field_options,
    generator: *const mollis_generator,
    /// Number of bytes by which the workspaces are too short.
    short: usize,
    steps: usize,
}

/// Names of these functions.
const FUNCTIONS: [&str; 4] = ["field", "grid", "blob", "pks"];

impl Calls {
    fn new() -> Self {
        let point = |k: usize| [(k as f64 * 1.3).sin(), (k as f64 * 2.1).cos()];
        let mut pks = filled(mollis_pks_options_init);
        (pks.chi, pks.noise) = (0.5, 0.01);
        Self {
            x: (0..N).map(point).collect(),
            m: (0..N).map(|k| 0.1 + 0.01 * k as f64).collect(),
            targets: (N..2 * N).map(point).collect(),
            pks,
            field: filled(mollis_field_options_init),
            generator: null(),
            short: 0,
            steps: 3,
        }
    }

    /// The status, and the state afterwards: steps, positions.
    fn call(&self, function: &str, run: &mollis_run) -> (i32, u64, Vec<[f64; 2]>) {
        let mut kernel = newtonian();
        let (block, length) = (kernel.pointer().cast_const(), kernel.bytes().len());
        let (mut x, mut m) = (self.x.clone(), self.m.clone());
        let (sources, targets) = (x.as_mut_ptr(), self.targets.as_ptr());
        let (mut gradient, mut bytes) = (vec![[7.0; 2]; N], 0);
        let to = gradient.as_mut_ptr();
        let none = null_mut::<f64>();
        let (mut space, size);
        let space_of = |bytes: usize| (Aligned::new(bytes), bytes - self.short);
        unsafe {
            match function {
                "field" => {
                    let options = &raw const self.field;
                    let sum = Sum::new((N, sources.cast_const(), m.as_ptr()), (N, targets), (none, to, none));
                    let (sources, at, to) = (sum.sources(), sum.targets(), sum.outputs());
                    let sized =
                        mollis_field2_workspace_bytes(block, length, sources, at, to, null(), run, &raw mut bytes);
                    assert_eq!(sized, OK);
                    (space, size) = space_of(bytes);
                    let (pointer, none) = (space.pointer(), null_mut());
                    (mollis_field2_eval(block, length, sources, at, to, options, run, pointer, size, none), 0, x)
                }
                "grid" => {
                    assert_eq!(grid2_workspace_bytes(&raw const MESH, null(), run, &raw mut bytes), OK);
                    (space, size) = space_of(bytes);
                    #[rustfmt::skip]
                    let code = grid2_eval(&raw const MESH, null(), N, sources, m.as_ptr(), N, targets, to, none, none,
                        null_mut(), null_mut(), null_mut(), space.pointer(), size, run);
                    (code, 0, x)
                }
                "blob" => {
                    let sized = blob2_workspace_bytes(block, length, N, N, 0, null(), run, &raw mut bytes);
                    assert_eq!(sized, OK);
                    (space, size) = space_of(bytes);
                    let mut report = mollis_blob_report { steps: 0, first_bad: 0, energy_first: 0.0, energy_last: 0.0 };
                    let mut tracers = self.targets.clone();
                    #[rustfmt::skip]
                    let code = blob2_step(block, length, N, m.as_ptr(), sources, none, null_mut(), none, N,
                        tracers.as_mut_ptr(), none, null_mut(), 0.01, self.steps, null(), run, &raw mut report,
                        space.pointer(), size);
                    (code, report.steps, x)
                }
                "pks" => {
                    let attraction =
                        mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_MESH, mesh: &raw const MESH, ..NOTHING };
                    let good = mollis_pks_options { chi: 0.5, ..self.pks };
                    let sized = pks_workspace_bytes(N, &raw const good, &raw const attraction, run, &raw mut bytes);
                    assert_eq!(sized, OK);
                    (space, size) = space_of(bytes);
                    let mut labels: Vec<u64> = (0..N as u64).collect();
                    // The last particle is not alive.
                    let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: N as u64 - 1, pending: 0 };
                    let mut events = mollis_pks_events {
                        events: null_mut(),
                        room: 0,
                        written: 0,
                        labels: null_mut(),
                        labels_room: 0,
                        labels_written: 0,
                    };
                    #[rustfmt::skip]
                    let code = pks_step(&raw const self.pks, &raw const attraction, N, sources, m.as_mut_ptr(),
                        labels.as_mut_ptr(), null_mut(), &raw mut counters, self.generator, 7, 1e-4, self.steps,
                        &raw mut events, null_mut(), space.pointer(), size, run);
                    (code, counters.step, x)
                }
                _ => unreachable!(),
            }
        }
    }
}

/// An executor whose call number `refuse_at` fails, before or after it has run the tasks.
struct Refusing {
    calls: usize,
    refuse_at: usize,
    after_the_tasks: bool,
    status: i32,
}

unsafe extern "C" fn refusing(context: *mut c_void, tasks: usize, task: mollis_task, data: *mut c_void) -> i32 {
    let own = unsafe { &mut *context.cast::<Refusing>() };
    own.calls += 1;
    let refused = own.calls == own.refuse_at;
    if !refused || own.after_the_tasks {
        for index in 0..tasks {
            assert_eq!(unsafe { task.unwrap()(data, index, 0) }, OK);
        }
    }
    if refused { own.status } else { OK }
}

/// Statuses that the library uses itself, others, and the extremes.
const STATUSES: [i32; 12] = [77, 3, 1, 20, 40, 41, 42, 45, 46, 1000, i32::MAX, i32::MIN];

/// The status of an executor is returned unchanged, whichever of its calls fails. The state is that of the last completed step.
#[test]
fn an_executors_status_comes_back_unchanged() {
    let calls = Calls::new();
    for function in FUNCTIONS {
        let run_with = |refuse_at: usize, after_the_tasks: bool, status: i32| {
            let mut own = Refusing { calls: 0, refuse_at, after_the_tasks, status };
            let executor = mollis_executor { context: (&raw mut own).cast(), workers: 2, parallel_for: Some(refusing) };
            let run = mollis_run { executor: &raw const executor, ..filled(mollis_run_init) };
            let outcome = calls.call(function, &run);
            (outcome, own.calls)
        };
        let (whole, times) = run_with(0, false, 0);
        assert_eq!(whole.0, OK, "{function}");
        assert!(times > 0, "{function} does not use the executor");
        // The states after 0, 1, ... steps.
        let states: Vec<_> = (0..=calls.steps)
            .map(|steps| Calls { steps, ..Calls::new() }.call(function, &filled(mollis_run_init)).2)
            .collect();
        for refuse_at in 1..=times {
            for after_the_tasks in [false, true] {
                // All statuses at the first call, one at each of the others, because these are many.
                let some = if refuse_at == 1 { &STATUSES[..] } else { &STATUSES[refuse_at % 12..][..1] };
                for &status in some {
                    let ((code, steps, state), _) = run_with(refuse_at, after_the_tasks, status);
                    assert_eq!(code, status, "{function}, call {refuse_at} of {times}");
                    assert_eq!(state, states[steps as usize], "{function}, call {refuse_at} of {times}: {steps} steps");
                }
            }
        }
    }
}

unsafe extern "C" fn unreduced(context: *mut c_void, _: i32, _: *mut u64, _: usize) -> i32 {
    unsafe { *context.cast::<i32>() }
}

unsafe extern "C" fn unsent(context: *mut c_void, _: *const u64, _: *const usize, _: *mut u64, _: *const usize) -> i32 {
    unsafe { *context.cast::<i32>() }
}

/// A communicator whose functions return this status.
fn communicator(status: &mut i32, rank: usize, ranks: usize) -> mollis_communicator {
    let context = (&raw mut *status).cast();
    mollis_communicator { context, rank, ranks, reduce: Some(unreduced), exchange: Some(unsent) }
}

/// Steps of coalescing particles ask for it if there is more than one rank, and return its status unchanged; nothing else asks.
#[test]
fn a_communicators_status_comes_back_unchanged() {
    let calls = Calls::new();
    for function in FUNCTIONS {
        let alone = calls.call(function, &filled(mollis_run_init));
        for mut status in STATUSES {
            for (ranks, asked) in [(1, false), (2, function == "pks")] {
                let given = communicator(&mut status, 0, ranks);
                let outcome =
                    calls.call(function, &mollis_run { communicator: &raw const given, ..filled(mollis_run_init) });
                if asked {
                    assert_eq!(outcome, (status, 0, calls.x.clone()), "{function}");
                } else {
                    assert_eq!(outcome, alone, "{function}");
                }
            }
        }
    }
}

/// A stream whose draw number `left` fails.
struct Stream {
    random: Split,
    left: usize,
    status: i32,
}

unsafe extern "C" fn drawn(state: *mut c_void, out: *mut u64, n: usize) -> i32 {
    let own = unsafe { &mut *state.cast::<Stream>() };
    own.left -= 1;
    if own.left == 0 {
        return own.status;
    }
    for k in 0..n {
        unsafe { out.add(k).write(own.random.next()) };
    }
    OK
}

#[test]
fn a_generators_status_comes_back_unchanged() {
    for scheme in [MOLLIS_PKS_SCHEME_EULER_MARUYAMA, MOLLIS_PKS_SCHEME_STRANG_RK4] {
        for (k, status) in STATUSES.into_iter().enumerate() {
            let run_with = |left: usize, steps: usize| {
                let mut stream = Stream { random: Split(3), left, status };
                let generator = mollis_generator { state: (&raw mut stream).cast(), fill: Some(drawn) };
                let mut calls = Calls { generator: &raw const generator, steps, ..Calls::new() };
                calls.pks.scheme = scheme;
                calls.call("pks", &filled(mollis_run_init))
            };
            // A step draws at least eleven times: failures in the first, the second and the third step.
            for left in [1, 2 + k % 10, 14 + k % 10, 23 + k % 10] {
                let (code, steps, state) = run_with(left, 3);
                assert_eq!(code, status);
                let (done, made, want) = run_with(usize::MAX, steps as usize);
                assert_eq!((done, made, want), (OK, steps, state));
            }
        }
    }
}

/// A workspace that is one byte short is refused as such, whatever the arrays contain.
#[test]
fn sizes_are_checked_before_data_are_read() {
    let spoilt = || Calls {
        x: vec![[f64::NAN; 2]; N],
        m: vec![f64::NEG_INFINITY; N],
        targets: vec![[f64::INFINITY; 2]; N],
        ..Calls::new()
    };
    let mut bad = 77;
    let run = mollis_run { first_bad: &raw mut bad, ..filled(mollis_run_init) };
    for function in FUNCTIONS {
        let short = Calls { short: 1, ..spoilt() };
        assert_eq!(short.call(function, &run).0, Error::WorkspaceTooSmall as i32, "{function}");
        assert_eq!(unsafe { run.first_bad.read() }, 77, "{function}");
        assert_eq!(spoilt().call(function, &run).0, Error::NotFinite as i32, "{function}");
        assert_eq!(unsafe { run.first_bad.replace(77) }, 0, "{function}");
    }
    let (points, values, mut norm, mut bytes) = ([3_usize, 2], [f64::NAN; 6], 7.0, 0);
    unsafe {
        assert_eq!(mollis_dual_norm2_workspace_bytes(&raw const points, 4, &raw mut bytes), OK);
        let mut space = Aligned::new(bytes);
        let mut dual = |bytes| {
            let memory = space.pointer();
            mollis_dual_norm2(&raw const points, 0.5, 4, values.as_ptr(), &raw mut norm, memory, bytes)
        };
        assert_eq!(dual(bytes - 1), Error::WorkspaceTooSmall as i32);
        assert_eq!(dual(bytes), Error::NotFinite as i32);
        assert_eq!(norm, 7.0);
        let species = [mollis_pks_species { mass: f64::NAN, mu: f64::NAN, sensitivity: 0.0 }];
        let none = null_mut();
        let eval =
            |n, particles| mollis_pks_represent_species(n, species.as_ptr(), f64::NAN, particles, none, none, none);
        assert_eq!((eval(0, 10), eval(1, 0)), (Error::OutOfDomain as i32, Error::OutOfDomain as i32));
        assert_eq!(eval(1, 10), Error::NotFinite as i32);
    }
}

/// The index of the particle, source or target that is not finite, and failures that no element causes.
#[test]
fn the_first_bad_element_is_told() {
    let mut bad = 77;
    let run = mollis_run { first_bad: &raw mut bad, ..filled(mollis_run_init) };
    let not_finite = Error::NotFinite as i32;
    for function in FUNCTIONS {
        let told = |spoil: &dyn Fn(&mut Calls)| {
            let mut calls = Calls::new();
            spoil(&mut calls);
            let code = calls.call(function, &run).0;
            (code, unsafe { run.first_bad.replace(77) })
        };
        assert_eq!(told(&|_| ()), (OK, 77), "{function}");
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for k in [0, 5, 10] {
                assert_eq!(told(&|c| c.x[k][k % 2] = value), (not_finite, k as u64), "{function}");
                assert_eq!(told(&|c| c.m[k] = value), (not_finite, k as u64), "{function}");
                let targets = told(&|c| c.targets[k][1] = value);
                assert_eq!(
                    targets,
                    if function == "pks" { (OK, 77) } else { (not_finite, (N + k) as u64) },
                    "{function}"
                );
            }
            let many = told(&|c| (c.x[8][0], c.m[3], c.m[9], c.targets[0][0]) = (value, value, value, value));
            assert_eq!(many, (not_finite, 3), "{function}");
        }
        // A null pointer: only the status is returned.
        let mut calls = Calls::new();
        calls.m[1] = f64::NAN;
        assert_eq!(calls.call(function, &filled(mollis_run_init)).0, not_finite, "{function}");
    }
    // A particle that is not alive is not read. Invalid parameters and a sum that overflows are not attributed to an element.
    let mut calls = Calls::new();
    calls.x[N - 1] = [f64::NAN; 2];
    assert_eq!(calls.call("pks", &run).0, OK);
    let told = |spoil: &dyn Fn(&mut Calls), function: &str| {
        let mut calls = Calls::new();
        spoil(&mut calls);
        let code = calls.call(function, &run).0;
        (code, unsafe { run.first_bad.replace(77) })
    };
    let none = (not_finite, MOLLIS_NONE_BAD);
    assert_eq!(told(&|c| c.pks.chi = f64::NAN, "pks"), none);
    assert_eq!(told(&|c| c.m.fill(1e308), "pks"), none);
    assert_eq!(told(&|c| c.field.tolerance = f64::NAN, "field"), none);
    assert_eq!(told(&|c| c.field.method = 99, "field"), (Error::UnknownValue as i32, 77));
}

/// The pointer to the index is checked like that of any other output.
#[test]
fn the_first_bad_element_has_a_place_of_its_own() {
    let mut words = [77_u64; 2];
    let odd = words.as_mut_ptr().wrapping_byte_add(4);
    let run = mollis_run { first_bad: odd, ..filled(mollis_run_init) };
    for function in FUNCTIONS {
        assert_eq!(Calls::new().call_sized(function, &run), Error::Misaligned as i32);
    }
    let mut block = newtonian();
    let (kernel, length) = (block.pointer().cast_const(), block.bytes().len());
    let (mut x, m, mut bytes) = ([[0.0; 2], [1.0, 0.5]], [1.0, 2.0], 0);
    let run = mollis_run { first_bad: x.as_mut_ptr().cast(), ..filled(mollis_run_init) };
    unsafe {
        let (p, none, mut gradient) = (x.as_ptr(), null_mut(), [[0.0; 2]; 2]);
        let sum = Sum::new((2, p, m.as_ptr()), (2, p), (none, gradient.as_mut_ptr(), none));
        let (sources, at, to) = (sum.sources(), sum.targets(), sum.outputs());
        let sized = mollis_field2_workspace_bytes(kernel, length, sources, at, to, null(), null(), &raw mut bytes);
        assert_eq!(sized, OK);
        let mut space = Aligned::new(bytes);
        let (run_at, space) = (&raw const run, space.pointer());
        let code = mollis_field2_eval(kernel, length, sources, at, to, null(), run_at, space, bytes, null_mut());
        assert_eq!(code, Error::Overlap as i32);
        assert_eq!(grid2_workspace_bytes(&raw const MESH, null(), null(), &raw mut bytes), OK);
        let mut space = Aligned::new(bytes);
        #[rustfmt::skip]
        let code = grid2_eval(&raw const MESH, null(), 2, p, m.as_ptr(), 2, p, gradient.as_mut_ptr(), none, none,
            null_mut(), null_mut(), null_mut(), space.pointer(), bytes, &raw const run);
        assert_eq!(code, Error::Overlap as i32);
        assert_eq!(blob2_workspace_bytes(kernel, length, 2, 0, 0, null(), null(), &raw mut bytes), OK);
        let mut space = Aligned::new(bytes);
        #[rustfmt::skip]
        let code = blob2_step(kernel, length, 2, m.as_ptr(), x.as_mut_ptr(), none, null_mut(), none, 0, null_mut(),
            none, null_mut(), 0.1, 1, null(), &raw const run, null_mut(), space.pointer(), bytes);
        assert_eq!(code, Error::Overlap as i32);
        let (options, mut masses, mut labels) = (filled(mollis_pks_options_init), m, [0_u64, 1]);
        let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: 2, pending: 0 };
        let mut events = mollis_pks_events {
            events: null_mut(),
            room: 0,
            written: 0,
            labels: null_mut(),
            labels_room: 0,
            labels_written: 0,
        };
        assert_eq!(pks_workspace_bytes(2, &raw const options, &NOTHING, null(), &raw mut bytes), OK);
        let mut space = Aligned::new(bytes);
        #[rustfmt::skip]
        let code = pks_step(&raw const options, &NOTHING, 2, x.as_mut_ptr(), masses.as_mut_ptr(), labels.as_mut_ptr(),
            null_mut(), &raw mut counters, null(), 7, 0.1, 1, &raw mut events, null_mut(), space.pointer(), bytes,
            &raw const run);
        assert_eq!(code, Error::Overlap as i32);
    }
    assert_eq!(x, [[0.0; 2], [1.0, 0.5]]);
}

impl Calls {
    /// The status of the size query, for a run that it must refuse too.
    fn call_sized(&self, function: &str, run: &mollis_run) -> i32 {
        let mut kernel = newtonian();
        let (block, length) = (kernel.pointer().cast_const(), kernel.bytes().len());
        let mut bytes = 77;
        let code = unsafe {
            match function {
                "field" => {
                    let (x, mut gradient) = (self.x.as_ptr(), vec![[0.0; 2]; N]);
                    let to = (null_mut(), gradient.as_mut_ptr(), null_mut());
                    let sum = Sum::new((N, x, self.m.as_ptr()), (N, x), to);
                    let (sources, at, to) = (sum.sources(), sum.targets(), sum.outputs());
                    mollis_field2_workspace_bytes(block, length, sources, at, to, null(), run, &raw mut bytes)
                }
                "grid" => grid2_workspace_bytes(&raw const MESH, null(), run, &raw mut bytes),
                "blob" => blob2_workspace_bytes(block, length, N, N, 0, null(), run, &raw mut bytes),
                _ => pks_workspace_bytes(N, &raw const self.pks, &NOTHING, run, &raw mut bytes),
            }
        };
        assert_eq!(bytes, 77);
        code
    }
}

#[test]
fn the_first_bad_element_is_found() {
    let mut first = 77;
    let mut values = [0.0, -1.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, -0.0];
    let at = &raw mut first;
    unsafe {
        assert_eq!((mollis_first_bad(6, 1, values.as_ptr(), at), *at), (OK, MOLLIS_NONE_BAD));
        assert_eq!((mollis_first_bad(0, 3, null(), at), *at), (OK, MOLLIS_NONE_BAD));
        assert_eq!((mollis_first_bad(6, 0, null(), at), *at), (OK, MOLLIS_NONE_BAD));
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            values[3] = value;
            for (n, each, want) in [(6, 1, 3), (3, 2, 1), (2, 3, 1), (1, 6, 0), (3, 1, MOLLIS_NONE_BAD)] {
                assert_eq!((mollis_first_bad(n, each, values.as_ptr(), at), *at), (OK, want));
                let single = values.map(|v| if v == f64::MAX { 0.0 } else { v as f32 });
                assert_eq!((mollis_first_bad_f32(n, each, single.as_ptr(), at), *at), (OK, want));
            }
        }
        *at = 77;
        for (code, error) in [
            (mollis_first_bad(6, 1, null(), at), Error::NullPointer),
            (mollis_first_bad(6, 1, values.as_ptr(), null_mut()), Error::NullPointer),
            (mollis_first_bad(6, 1, values.as_ptr().byte_add(1), at), Error::Misaligned),
            (mollis_first_bad(usize::MAX, 3, values.as_ptr(), at), Error::TooLarge),
            (mollis_first_bad(6, 1, values.as_ptr(), values.as_mut_ptr().cast()), Error::Overlap),
        ] {
            assert_eq!(code, error as i32);
        }
        assert_eq!(*at, 77);
    }
}

/// The size query for particles does not write into the kernel that it reads.
#[test]
fn the_answer_of_a_size_query_overlaps_no_kernel() {
    let options = filled(mollis_pks_options_init);
    let mut block = newtonian();
    let before = block.bytes().to_vec();
    let (kernel, kernel_bytes) = (block.pointer(), block.bytes().len());
    let sum = mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_SUM, kernel, kernel_bytes, ..NOTHING };
    let heavy = mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_MESH, mesh: &raw const MESH, heavy: 1.0, ..sum };
    for attraction in [sum, heavy] {
        for at in [0, 8, kernel_bytes - 8] {
            let bytes = kernel.wrapping_byte_add(at).cast();
            let code = unsafe { pks_workspace_bytes(5, &raw const options, &raw const attraction, null(), bytes) };
            assert_eq!(code, Error::Overlap as i32);
            let (five, run) = (&raw const options, null());
            let code = unsafe { pks_workspace_bytes_f32(5, five, &raw const attraction, run, bytes) };
            assert_eq!(code, Error::Overlap as i32);
        }
        let mut bytes = 0;
        let code = unsafe { pks_workspace_bytes(5, &raw const options, &raw const attraction, null(), &raw mut bytes) };
        assert!(code == OK && bytes > 0);
    }
    assert_eq!(block.bytes(), before);
}

/// In a field that grows like r^3 the motion overflows in the second step. The state before it is kept, and the error does not blame the input.
#[test]
fn what_overflows_in_a_step_was_given_finite() {
    let mut block = kernel(MOLLIS_KERNEL_POWER, 1.0, 4.0, NONE, 1.0);
    let attraction = mollis_pks_attraction {
        kind: MOLLIS_PKS_ATTRACTION_SUM,
        kernel: block.pointer(),
        kernel_bytes: block.bytes().len(),
        ..NOTHING
    };
    let start = [[10.0, 0.0], [-10.0, 1.0], [0.0, 12.0]];
    for scheme in [MOLLIS_PKS_SCHEME_EULER_MARUYAMA, MOLLIS_PKS_SCHEME_STRANG_RK4] {
        let mut options = filled(mollis_pks_options_init);
        (options.chi, options.merging, options.scheme) = (1.0, MOLLIS_PKS_MERGE_NEVER, scheme);
        options.at_least = 3;
        let run_of = |steps: usize, dt: f64| {
            let (mut x, mut m, mut labels) = (start, [1.0; 3], [0_u64, 1, 2]);
            let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: 3, pending: 0 };
            let mut events = mollis_pks_events {
                events: null_mut(),
                room: 0,
                written: 0,
                labels: null_mut(),
                labels_room: 0,
                labels_written: 0,
            };
            let (mut bytes, mut bad) = (0, 77);
            let run = mollis_run { first_bad: &raw mut bad, ..filled(mollis_run_init) };
            let code = unsafe {
                let options = &raw const options;
                assert_eq!(pks_workspace_bytes(3, options, &raw const attraction, null(), &raw mut bytes), OK);
                let mut space = Aligned::new(bytes);
                #[rustfmt::skip]
                let code = pks_step(options, &raw const attraction, 3, x.as_mut_ptr(), m.as_mut_ptr(),
                    labels.as_mut_ptr(), null_mut(), &raw mut counters, null(), 7, dt, steps, &raw mut events, null_mut(),
                    space.pointer(), bytes, &raw const run);
                code
            };
            assert_eq!(bad, 77);
            (code, counters.step, x)
        };
        let (code, steps, x) = run_of(100, 0.2);
        assert_eq!(code, Error::BecameNotFinite as i32, "{scheme}");
        assert!(steps > 0, "{scheme}");
        assert_eq!(run_of(steps as usize, 0.2), (OK, steps, x), "{scheme}");
        // The same for an overflow in the first step.
        assert_eq!(run_of(1, 1e100), (Error::BecameNotFinite as i32, 0, start), "{scheme}");
    }
}

/// Predictions from heavy masses that are not finite are refused.
#[test]
fn predictions_refuse_heavy_masses_that_are_not_finite() {
    let mut out = mollis_pks_prediction { critical_mass: 7.0, blow_up_bound: 7.0, second_moment_rate: 7.0 };
    for value in [f64::NAN, f64::INFINITY] {
        let heavy = [1.0, value];
        let code = unsafe { mollis_pks_predict(60.0, 1.0, 1.0, 1.0, 2, heavy.as_ptr(), &raw mut out) };
        assert_eq!(code, Error::NotFinite as i32);
    }
    assert_eq!((out.critical_mass, out.blow_up_bound, out.second_moment_rate), (7.0, 7.0, 7.0));
}

/// A unit square of 8 x 8 cells.
static UNIT: mollis_mesh2 = mollis_mesh2 { lower: [0.0; 2], upper: [1.0; 2], cells: [8, 8] };
const NODES: usize = 9 * 9;

/// Masses and potential at the nodes, gradient at the targets, and total mass.
fn on_the_mesh(
    walls: i32,
    x: &[[f64; 2]],
    m: &[f64],
    targets: &[[f64; 2]],
) -> ([f64; NODES], [f64; NODES], Vec<[f64; 2]>, f64) {
    let options = mollis_grid2_options { walls, ..filled(mollis_grid2_options_init) };
    let (mut mass, mut u, mut gradient, mut total) =
        ([0.0; NODES], [0.0; NODES], vec![[0.0; 2]; targets.len()], [0.0; 3]);
    let mut bytes = 0;
    unsafe {
        assert_eq!(grid2_workspace_bytes(&raw const UNIT, &raw const options, null(), &raw mut bytes), OK);
        let mut space = Aligned::new(bytes);
        #[rustfmt::skip]
        let code = grid2_eval(&raw const UNIT, &raw const options, x.len(), x.as_ptr(), m.as_ptr(), targets.len(),
            targets.as_ptr(), gradient.as_mut_ptr(), mass.as_mut_ptr(), u.as_mut_ptr(), null_mut(), &raw mut total,
            null_mut(), space.pointer(), bytes, null());
        assert_eq!(code, OK);
    }
    (mass, u, gradient, total[0])
}

/// Within half a mesh width, 1/16, of the centre of mass the prescribed field is that at this distance. The part of the second moments
/// does not grow below the distance sqrt(2 |Q| / |M|).
///
/// Tolerance: a logarithm, a division and sums of exactly known terms of size 1 have some roundings, 1e-14.
#[test]
fn the_border_sees_no_closer_than_half_a_width() {
    let turn = 2.0 * std::f64::consts::PI;
    let close = |got: f64, want: f64| assert!((got - want).abs() < 1e-14, "{got} {want}");
    // All mass at a node of the left border. The targets are beside it, outside.
    let targets = [[-0.01, 0.5], [-0.5, 0.5]];
    let (_, u, gradient, _) = on_the_mesh(MOLLIS_WALLS_FREE, &[[0.0, 0.5]], &[3.0], &targets);
    close(u[4 * 9], 3.0 * (1.0_f64 / 16.0).ln() / turn);
    close(u[5 * 9], 3.0 * (1.0_f64 / 8.0).ln() / turn);
    close(u[3 * 9], 3.0 * (1.0_f64 / 8.0).ln() / turn);
    close(gradient[0][0], 3.0 * -0.01 * 256.0 / turn);
    close(gradient[1][0], 3.0 / -0.5 / turn);
    // Two masses at -i/4, i/4 from their centre: Q = -1/8, |M| = 2, and the part does not grow below sqrt(1/8).
    let (_, u, ..) = on_the_mesh(MOLLIS_WALLS_FREE_QUADRUPOLE, &[[0.0, 0.25], [0.0, 0.75]], &[1.0, 1.0], &[]);
    // -Re(Q / z^2) / 2 with z = i r is Q / (2 r^2) = -1 / (16 r^2). Below that distance 1/r^4 is held at 64: -4 r^2.
    close(u[5 * 9], (2.0 * (1.0_f64 / 8.0).ln() - 4.0 / 64.0) / turn);
    close(u[6 * 9], (2.0 * (1.0_f64 / 4.0).ln() - 4.0 / 16.0) / turn);
    close(u[7 * 9], (2.0 * (3.0_f64 / 8.0).ln() - 64.0 / 9.0 / 16.0) / turn);
}

/// Masses are rounded to a unit of at most 2^-49 of the total. Below 2^-51 they become zero; at 1e-12 three digits remain.
#[test]
fn light_masses_beside_heavy_ones_are_rounded() {
    let at = [[0.5, 0.5], [0.25, 0.25]];
    for heavy in [1.0, 1e18, 0.3, 1e-100] {
        for (light, error) in [(1e-18, 0.0), (4.4e-16, 0.0), (1e-12, 1e-3), (1e-6, 1e-9)] {
            let (mass, _, _, total) = on_the_mesh(MOLLIS_WALLS_FREE, &at, &[heavy, heavy * light], &[]);
            let (got, want) = (mass[2 * 9 + 2], heavy * light);
            if error == 0.0 {
                assert_eq!(got, 0.0, "{heavy} {light}");
                // The error is half a unit.
                assert!((total / heavy - 1.0).abs() <= 2.0_f64.powi(-50), "{heavy} {light}");
            } else {
                assert!((got / want - 1.0).abs() < error, "{heavy} {light}: {got}");
            }
        }
    }
}

/// Numbers of a run and of an executor that mean nothing, and places where no structure can be.
#[test]
fn runs_that_mean_nothing_are_refused() {
    let calls = Calls::new();
    let good: mollis_run = filled(mollis_run_init);
    let mut own = Refusing { calls: 0, refuse_at: 0, after_the_tasks: false, status: OK };
    let fine = mollis_executor { context: (&raw mut own).cast(), workers: 2, parallel_for: Some(refusing) };
    for function in FUNCTIONS {
        for level in [-2, 4, i32::MAX] {
            let refused = calls.call_sized(function, &mollis_run { level, ..good });
            assert_eq!(refused, Error::UnknownValue as i32, "{function}, level {level}");
        }
        for (executor, error) in [
            (mollis_executor { workers: 0, ..fine }, Error::OutOfDomain),
            (mollis_executor { workers: mollis_core::exec::MAX_WORKERS + 1, ..fine }, Error::OutOfDomain),
            (mollis_executor { parallel_for: None, ..fine }, Error::NullPointer),
        ] {
            let refused = calls.call_sized(function, &mollis_run { executor: &raw const executor, ..good });
            assert_eq!(refused, error as i32, "{function}");
        }
    }
    let mut status = OK;
    let fine = communicator(&mut status, 1, 2);
    for function in FUNCTIONS {
        for (communicator, error) in [
            (mollis_communicator { rank: 2, ..fine }, Error::OutOfDomain),
            (mollis_communicator { rank: 0, ranks: 0, ..fine }, Error::OutOfDomain),
            (mollis_communicator { reduce: None, ..fine }, Error::NullPointer),
            (mollis_communicator { exchange: None, ..fine }, Error::NullPointer),
        ] {
            let refused = calls.call_sized(function, &mollis_run { communicator: &raw const communicator, ..good });
            assert_eq!(refused, error as i32, "{function}");
        }
        let odd = (&raw const fine).wrapping_byte_add(1);
        let refused = calls.call_sized(function, &mollis_run { communicator: odd, ..good });
        assert_eq!(refused, Error::Misaligned as i32, "{function}");
    }
    let mut words = [0_u64; 16];
    let at = words.as_mut_ptr().cast::<mollis_run>();
    unsafe {
        assert_eq!(mollis_run_init(null_mut(), size_of::<mollis_run>()), Error::NullPointer as i32);
        assert_eq!(mollis_run_init(at.byte_add(4), size_of::<mollis_run>()), Error::Misaligned as i32);
    }
    assert_eq!(words, [0; 16]);
}
