//! The blob method through the C ABI: every refusal has its own code and leaves every buffer unchanged, byte for byte.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;
use mollis_reference::diffusion as twin;
use mollis_tests::positional::*;

/// Bytes aligned to 64 between canaries. Every check compares the canaries too.
#[derive(Clone)]
struct Block {
    memory: Vec<u8>,
    start: usize,
}

impl Block {
    fn new(bytes: usize) -> Self {
        let mut memory = vec![0xC5; bytes + 3 * ALIGN];
        let start = ALIGN + memory[ALIGN..].as_ptr().align_offset(ALIGN);
        memory[start..start + bytes].fill(0xFF);
        Self { memory, start }
    }

    fn of<T: Copy>(values: &[T]) -> Self {
        let mut block = Self::new(size_of_val(values));
        // SAFETY: the block is as large as the values and aligned for them.
        unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), block.pointer(), values.len()) };
        block
    }

    fn pointer<T>(&mut self) -> *mut T {
        self.memory[self.start..].as_mut_ptr().cast()
    }

    fn read<T: Copy>(&self, n: usize) -> Vec<T> {
        // SAFETY: only called with the type and the length with which the block was made.
        unsafe { std::slice::from_raw_parts(self.memory[self.start..].as_ptr().cast::<T>(), n) }.to_vec()
    }
}

const N: usize = 9;
const TRACERS: usize = 4;

/// All arguments of a step in the plane. Each array has a block of its own.
struct Call {
    kernel: Block,
    kernel_bytes: usize,
    n: usize,
    masses: Block,
    positions: Block,
    density: Block,
    velocity: Block,
    divergence: Block,
    tracers: usize,
    tracer_positions: Block,
    tracer_density: Block,
    tracer_velocity: Block,
    dt: f64,
    options: mollis_blob_options,
    run: mollis_run,
    report: Block,
    workspace: Block,
    workspace_bytes: usize,
}

/// The pointers of a call. A test makes one at a time invalid.
struct Pointers {
    kernel: *const c_void,
    masses: *const f64,
    positions: *mut [f64; 2],
    density: *mut f64,
    velocity: *mut [f64; 2],
    divergence: *mut f64,
    tracer_positions: *mut [f64; 2],
    tracer_density: *mut f64,
    tracer_velocity: *mut [f64; 2],
    options: *const mollis_blob_options,
    run: *const mollis_run,
    report: *mut mollis_blob_report,
    workspace: *mut c_void,
}

fn kernel_block() -> Block {
    let (terms, mollifier) =
        ([Term { law: Law::Newtonian, coefficient: 1.0 }], Mollifier::Compact { order: 2, exponent: 4 });
    let bytes = Kernel::<f64, 2>::workspace_bytes(&terms, mollifier).unwrap();
    let mut block = Block::new(bytes);
    let start = block.start;
    Kernel::<f64, 2>::prepare(&mut block.memory[start..start + bytes], &terms, mollifier, 0.3).unwrap();
    block
}

fn bytes_of(block: &Block) -> usize {
    block.memory.len() - 3 * ALIGN
}

impl Call {
    fn new() -> Self {
        let point = |k: usize| [(k as f64 * 1.3).sin(), (k as f64 * 2.1).cos()];
        let points = |n: usize, from: usize| -> Vec<[f64; 2]> { (from..from + n).map(point).collect() };
        let mut kernel = kernel_block();
        let kernel_bytes = bytes_of(&kernel);
        let (mut options, mut run, mut workspace_bytes) =
            (std::mem::MaybeUninit::<mollis_blob_options>::uninit(), std::mem::MaybeUninit::<mollis_run>::uninit(), 0);
        // SAFETY: pointers to live locals of the stated sizes; `_init` fills the structures.
        let (options, run) = unsafe {
            assert_eq!(mollis_blob_options_init(options.as_mut_ptr(), size_of::<mollis_blob_options>()), 0);
            assert_eq!(mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()), 0);
            (options.assume_init(), run.assume_init())
        };
        let wanted = DENSITY | VELOCITY | DIVERGENCE;
        let block = kernel.pointer::<c_void>();
        // SAFETY: as above.
        let code = unsafe {
            let bytes = &raw mut workspace_bytes;
            blob2_workspace_bytes(block, kernel_bytes, N, TRACERS, wanted, &raw const options, null(), bytes)
        };
        assert_eq!(code, 0);
        Self {
            kernel,
            kernel_bytes,
            n: N,
            masses: Block::of(&[0.1_f64; N]),
            positions: Block::of(&points(N, 0)),
            density: Block::of(&[1.0_f64; N]),
            velocity: Block::new(16 * N),
            divergence: Block::new(8 * N),
            tracers: TRACERS,
            tracer_positions: Block::of(&points(TRACERS, N)),
            tracer_density: Block::of(&[0.5_f64; TRACERS]),
            tracer_velocity: Block::new(16 * TRACERS),
            dt: 0.05,
            options,
            run,
            report: Block::new(size_of::<mollis_blob_report>()),
            workspace: Block::new(workspace_bytes),
            workspace_bytes,
        }
    }

    /// Runs two steps with pointers that `spoil` may change.
    fn step(&mut self, spoil: impl FnOnce(&mut Pointers)) -> i32 {
        let mut p = Pointers {
            kernel: self.kernel.pointer(),
            masses: self.masses.pointer(),
            positions: self.positions.pointer(),
            density: self.density.pointer(),
            velocity: self.velocity.pointer(),
            divergence: self.divergence.pointer(),
            tracer_positions: self.tracer_positions.pointer(),
            tracer_density: self.tracer_density.pointer(),
            tracer_velocity: self.tracer_velocity.pointer(),
            options: &raw const self.options,
            run: &raw const self.run,
            report: self.report.pointer(),
            workspace: self.workspace.pointer(),
        };
        spoil(&mut p);
        // SAFETY: live blocks of the stated sizes, or invalid arguments that the library must detect before it uses them.
        unsafe {
            blob2_step(
                p.kernel,
                self.kernel_bytes,
                self.n,
                p.masses,
                p.positions,
                p.density,
                p.velocity,
                p.divergence,
                self.tracers,
                p.tracer_positions,
                p.tracer_density,
                p.tracer_velocity,
                self.dt,
                2,
                p.options,
                p.run,
                p.report,
                p.workspace,
                self.workspace_bytes,
            )
        }
    }

    /// The contents and canaries of all buffers except report and scratch, and the canaries of the scratch.
    fn snapshot(&self) -> Vec<Vec<u8>> {
        let scratch = &self.workspace;
        let (before, after) = (&scratch.memory[..scratch.start], &scratch.memory[scratch.start + bytes_of(scratch)..]);
        [
            &self.kernel,
            &self.masses,
            &self.positions,
            &self.density,
            &self.velocity,
            &self.divergence,
            &self.tracer_positions,
            &self.tracer_density,
            &self.tracer_velocity,
        ]
        .iter()
        .map(|block| block.memory.clone())
        .chain([before.to_vec(), after.to_vec()])
        .collect()
    }

    fn report(&self) -> mollis_blob_report {
        self.report.read(1)[0]
    }
}

/// A changed call with invalid pointers returns `want` and writes nothing.
fn refused(want: Error, change: impl FnOnce(&mut Call), spoil: impl FnOnce(&mut Pointers)) -> Call {
    let mut call = Call::new();
    change(&mut call);
    let before = call.snapshot();
    let code = call.step(spoil);
    assert_eq!(Error::from_code(code), Some(want), "code {code}");
    assert!(call.snapshot() == before, "{want:?}: a buffer was written");
    call
}

#[test]
fn a_good_call_steps() {
    let mut call = Call::new();
    let before = call.snapshot();
    assert_eq!(call.step(|_| {}), 0);
    let after = call.snapshot();
    // Kernel and masses are only read. All other buffers are written, and no canary is.
    let same: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a == b).collect();
    assert_eq!(same, [true, true, false, false, false, false, false, false, false, true, true]);
    let report = call.report();
    assert_eq!((report.steps, report.first_bad), (2, MOLLIS_NONE_BAD));
    assert!(report.energy_first.is_nan() && report.energy_last.is_nan());
    assert!(call.velocity.read::<f64>(2 * N).iter().all(|v| v.is_finite()));
    // Options, run and report may be null.
    let mut again = Call::new();
    let nulls = |p: &mut Pointers| (p.options, p.run, p.report) = (null(), null(), null_mut());
    assert_eq!(again.step(nulls), 0);
    assert_eq!(again.positions.read::<f64>(2 * N), call.positions.read::<f64>(2 * N));
    assert_eq!(again.tracer_velocity.read::<f64>(2 * TRACERS), call.tracer_velocity.read::<f64>(2 * TRACERS));
    assert!(again.report.read::<u8>(size_of::<mollis_blob_report>()).iter().all(|&b| b == 0xFF));
}

#[test]
fn nothing_is_fine() {
    let mut call = Call::new();
    (call.n, call.tracers) = (0, 0);
    let nulls = |p: &mut Pointers| {
        (p.masses, p.positions, p.density, p.velocity) = (null(), null_mut(), null_mut(), null_mut());
        (p.divergence, p.tracer_positions, p.tracer_density) = (null_mut(), null_mut(), null_mut());
        p.tracer_velocity = null_mut();
    };
    assert_eq!(call.step(nulls), 0);
    assert_eq!(call.report().steps, 2);
}

#[test]
fn null_pointers() {
    let none = |_: &mut Call| {};
    refused(Error::NullPointer, none, |p| p.kernel = null());
    refused(Error::NullPointer, none, |p| p.masses = null());
    refused(Error::NullPointer, none, |p| p.positions = null_mut());
    refused(Error::NullPointer, none, |p| p.tracer_positions = null_mut());
    refused(Error::NullPointer, none, |p| p.workspace = null_mut());
}

#[test]
fn sizes_that_overflow() {
    for n in [usize::MAX, usize::MAX / 8, isize::MAX as usize / 8 + 1] {
        refused(Error::TooLarge, |c| c.n = n, |_| {});
        refused(Error::TooLarge, |c| c.tracers = n, |_| {});
    }
    let mut bytes = 77_usize;
    let mut kernel = kernel_block();
    for n in [usize::MAX, usize::MAX / 16] {
        let length = bytes_of(&kernel);
        // SAFETY: pointers to live locals.
        let code = unsafe {
            let block = kernel.pointer::<c_void>();
            blob2_workspace_bytes(block, length, n, n, 0, null(), null(), &raw mut bytes)
        };
        assert_eq!((code, bytes), (Error::TooLarge as i32, 77));
    }
}

#[test]
fn workspaces() {
    let none = |_: &mut Pointers| {};
    refused(Error::WorkspaceTooSmall, |c| c.workspace_bytes -= 1, none);
    refused(Error::WorkspaceTooSmall, |c| c.workspace_bytes = 0, none);
    // It may begin anywhere, and the bytes that are needed are told.
    let mut needed = 0;
    let change = |c: &mut Call| {
        (c.workspace_bytes, c.run.bytes_needed) = (c.workspace_bytes - 1, &raw mut needed);
    };
    let call = refused(Error::WorkspaceTooSmall, change, none);
    assert_eq!(needed, call.workspace_bytes + 1);
    for by in [1, 8, 32] {
        let mut call = Call::new();
        call.workspace = Block::new(needed + by);
        let before = call.snapshot();
        assert_eq!(call.step(move |p| p.workspace = p.workspace.wrapping_byte_add(by)), 0);
        assert_eq!(before[9..], call.snapshot()[9..], "a canary of the workspace");
    }
}

#[test]
fn misaligned_arrays() {
    let none = |_: &mut Call| {};
    refused(Error::Misaligned, none, |p| p.positions = p.positions.wrapping_byte_add(4));
    refused(Error::Misaligned, none, |p| p.masses = p.masses.wrapping_byte_add(1));
    refused(Error::Misaligned, none, |p| p.divergence = p.divergence.wrapping_byte_add(4));
    refused(Error::Misaligned, none, |p| p.report = p.report.wrapping_byte_add(4));
    refused(Error::Misaligned, none, |p| p.kernel = p.kernel.wrapping_byte_add(4));
}

#[test]
fn overlaps() {
    let none = |_: &mut Call| {};
    refused(Error::Overlap, none, |p| p.velocity = p.positions);
    refused(Error::Overlap, none, |p| p.velocity = p.positions.wrapping_add(N - 1));
    refused(Error::Overlap, none, |p| p.divergence = p.density);
    refused(Error::Overlap, none, |p| p.density = p.masses.cast_mut());
    refused(Error::Overlap, none, |p| p.tracer_positions = p.positions.wrapping_add(2));
    refused(Error::Overlap, none, |p| p.tracer_velocity = p.velocity);
    refused(Error::Overlap, none, |p| p.positions = p.workspace.cast());
    refused(Error::Overlap, none, |p| p.report = p.density.cast());
    refused(Error::Overlap, none, |p| p.divergence = p.kernel.cast_mut().cast());
}

#[test]
fn values() {
    let none = |_: &mut Pointers| {};
    for dt in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        refused(Error::TimeStep, |c| c.dt = dt, none);
    }
    let spoil = |block: &mut Block, index: usize, value: f64| {
        let at = block.start + 8 * index;
        block.memory[at..at + 8].copy_from_slice(&value.to_ne_bytes());
    };
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let first_bad = |call: Call| call.report().first_bad;
        assert_eq!(first_bad(refused(Error::NotFinite, |c| spoil(&mut c.positions, 7, value), none)), 3);
        assert_eq!(first_bad(refused(Error::NotFinite, |c| spoil(&mut c.masses, 8, value), none)), 8);
        assert_eq!(first_bad(refused(Error::NotFinite, |c| spoil(&mut c.density, 0, value), none)), 0);
        assert_eq!(
            first_bad(refused(Error::NotFinite, |c| spoil(&mut c.tracer_positions, 2, value), none)),
            N as u64 + 1
        );
        assert_eq!(
            first_bad(refused(Error::NotFinite, |c| spoil(&mut c.tracer_density, 3, value), none)),
            N as u64 + 3
        );
    }
    refused(Error::LengthMismatch, |_| {}, |p| p.tracer_density = null_mut());
    refused(Error::LengthMismatch, |_| {}, |p| p.density = null_mut());
}

#[test]
fn options_and_run() {
    let none = |_: &mut Pointers| {};
    refused(Error::OptionsSize, |c| c.options.size += 1, none);
    refused(Error::NotInitialised, |c| c.options.size = 0, none);
    refused(Error::NotInitialised, |c| c.run.size = 0, none);
    refused(Error::OptionsSize, |c| c.run.size = 4096, none);
    refused(Error::NotFinite, |c| c.options.tolerance = f64::NAN, none);
    refused(Error::OutOfDomain, |c| c.options.tolerance = -1e-6, none);
    refused(Error::OutOfDomain, |c| c.options.tolerance = -1e-3, none);
    refused(Error::UnknownValue, |c| c.run.level = 77, none);
    refused(Error::NotFinite, |c| c.options.combination[0] = f64::NAN, none);
    refused(Error::NotFinite, |c| c.options.combination[1] = f64::INFINITY, none);
}

/// What `combination` (a, b) makes of the velocity v and the divergence d of (1, 0): a v + b J v and a d, at particles and tracers. Options of an older header have (1, 0).
#[test]
fn combinations() {
    let with = |combination: [f64; 2], size: usize| {
        let mut call = Call::new();
        call.options.combination = combination;
        call.options.size = size as u32;
        // Of no length: two steps of it are outputs of the state as it is, up to rounding.
        call.dt = 1e-300;
        assert_eq!(call.step(|_| {}), 0);
        let velocities = [call.velocity.read::<[f64; 2]>(N), call.tracer_velocity.read(TRACERS)].concat();
        (velocities, call.divergence.read::<f64>(N), call.positions.read::<[f64; 2]>(N))
    };
    let whole = size_of::<mollis_blob_options>();
    let older = std::mem::offset_of!(mollis_blob_options, combination);
    let (plain, divergence, x) = with([1.0, 0.0], whole);
    assert_eq!((plain.clone(), divergence.clone(), x.clone()), with([0.0, -1.0], older));
    for [a, b] in [[0.0, -1.0], [0.5, 2.0]] {
        let (turned, scaled, same) = with([a, b], whole);
        let moved = x.iter().zip(&same).map(|(x, y)| (x[0] - y[0]).hypot(x[1] - y[1])).fold(0.0, f64::max);
        assert!(moved <= 1e-298, "{moved}");
        for ([u, v], [x, y]) in turned.iter().zip(&plain) {
            assert!((u - (a * x - b * y)).abs() <= 1e-15 && (v - (a * y + b * x)).abs() <= 1e-15, "{a} {b}");
        }
        assert!(scaled.iter().zip(&divergence).all(|(got, d)| (got - a * d).abs() <= 1e-15));
    }
}

/// Diffusion adds the velocities of the reference implementation to those of the kernel, at particles and tracers. Options of an older header have none.
#[test]
fn diffusions() {
    let with = |exponent: f64, size: usize| {
        let mut call = Call::new();
        call.options.diffusion = 0.5;
        call.options.diffusion_exponent = exponent;
        call.options.diffusion_length = 0.7;
        call.options.size = size as u32;
        call.dt = 1e-300;
        (call.workspace, call.workspace_bytes) = (Block::new(1 << 16), 1 << 16);
        let without = |p: &mut Pointers| {
            (p.density, p.divergence, p.tracer_density) = (null_mut(), null_mut(), null_mut());
        };
        assert_eq!(call.step(without), 0);
        let points = [call.positions.read::<[f64; 2]>(N), call.tracer_positions.read(TRACERS)].concat();
        (points, [call.velocity.read::<[f64; 2]>(N), call.tracer_velocity.read(TRACERS)].concat())
    };
    let older = std::mem::offset_of!(mollis_blob_options, diffusion);
    let (points, plain) = with(1.0, older);
    let points: Vec<Vec<f64>> = points.iter().map(|x| x.to_vec()).collect();
    let phi = twin::gaussian(2, 0.7);
    for m in [1.0, 2.0, 3.0] {
        let (_, velocities) = with(m, size_of::<mollis_blob_options>());
        for ((x, v), u) in points.iter().zip(velocities).zip(&plain) {
            let want = twin::velocity(&phi, (m, 0.5), &points[..N], &[0.1; N], x);
            assert!((v[0] - u[0] - want[0]).abs() < 1e-12 && (v[1] - u[1] - want[1]).abs() < 1e-12, "{m} {want:?}");
        }
    }
}

#[test]
fn diffusions_that_mean_nothing() {
    let none = |_: &mut Pointers| {};
    let refuse = |error: Error, spoil: fn(&mut mollis_blob_options)| {
        let ask = |call: &mut Call| {
            (call.options.diffusion, call.options.diffusion_length) = (1.0, 0.3);
            spoil(&mut call.options);
        };
        refused(error, ask, none);
    };
    refuse(Error::SignChange, |o| o.diffusion_mollifier.order = 4);
    refuse(Error::UnknownValue, |o| o.diffusion_mollifier.kind = 99);
    refuse(Error::Delta, |o| o.diffusion_length = 0.0);
    refuse(Error::OutOfDomain, |o| o.diffusion = -1.0);
    refuse(Error::OutOfDomain, |o| o.diffusion_exponent = 0.5);
    refuse(Error::NotFinite, |o| o.diffusion = f64::NAN);
    // Densities and divergences, which this call asks for.
    refuse(Error::Unsupported, |_| {});
}

/// On the line and in space there is no turned gradient.
#[test]
fn combinations_are_of_the_plane() {
    let mut call = Call::new();
    call.options.combination = [0.0, -1.0];
    let (options, mut bytes) = (&raw const call.options, 77_usize);
    macro_rules! refuses {
        ($t:ty, $d:literal, $size:ident) => {
            let terms = [Term { law: Law::Newtonian, coefficient: 1.0 }];
            let length = Kernel::<$t, $d>::workspace_bytes(&terms, Mollifier::None).unwrap();
            let mut kernel = Block::new(length);
            let start = kernel.start;
            Kernel::<$t, $d>::prepare(&mut kernel.memory[start..start + length], &terms, Mollifier::None, 1.0).unwrap();
            // SAFETY: pointers to live locals.
            let code = unsafe { $size(kernel.pointer(), length, N, 0, 0, options, null(), &raw mut bytes) };
            assert_eq!((Error::from_code(code), bytes), (Some(Error::Unsupported), 77));
        };
    }
    refuses!(f64, 1, blob1_workspace_bytes);
    refuses!(f64, 3, blob3_workspace_bytes);
    refuses!(f32, 1, blob1_workspace_bytes_f32);
    refuses!(f32, 3, blob3_workspace_bytes_f32);
}

#[test]
fn kernels_of_another_kind() {
    let none = |_: &mut Pointers| {};
    refused(Error::WorkspaceTooSmall, |c| c.kernel_bytes -= 1, none);
    refused(Error::NotPrepared, |c| c.kernel_bytes = 0, none);
    refused(Error::NotPrepared, |c| c.kernel = Block::new(c.kernel_bytes), none);
    let mut call = Call::new();
    let before = call.snapshot();
    let mut code = 0;
    call.n = 0;
    call.tracers = 0;
    let length = call.kernel_bytes;
    let mut step = |three: bool| {
        let block = call.kernel.pointer::<c_void>();
        let scratch = call.workspace.pointer::<c_void>();
        // SAFETY: without particles there are no arrays.
        unsafe {
            code = if three {
                blob3_step(
                    block,
                    length,
                    0,
                    null(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    0,
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    0.1,
                    1,
                    null(),
                    null(),
                    null_mut(),
                    scratch,
                    call.workspace_bytes,
                )
            } else {
                blob2_step_f32(
                    block,
                    length,
                    0,
                    null(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    0,
                    null_mut(),
                    null_mut(),
                    null_mut(),
                    0.1,
                    1,
                    null(),
                    null(),
                    null_mut(),
                    scratch,
                    call.workspace_bytes,
                )
            };
        }
        code
    };
    assert_eq!(step(true), Error::NotPrepared as i32);
    assert_eq!(step(false), Error::WrongScalar as i32);
    assert!(call.snapshot() == before);
}

/// The callback receives the arrays of the call after each step, and stops the run.
#[test]
fn the_callback_sees_each_step_and_stops() {
    unsafe extern "C" fn after(context: *mut c_void, steps: usize, x: *const c_void, rho: *const c_void) -> i32 {
        // SAFETY: the context is the test's list; x and rho are the arrays of the call.
        let (seen, x, rho) =
            unsafe { (&mut *context.cast::<Vec<(usize, f64, f64)>>(), *x.cast::<f64>(), *rho.cast::<f64>()) };
        seen.push((steps, x, rho));
        i32::from(steps == 1)
    }
    let mut seen: Vec<(usize, f64, f64)> = Vec::new();
    let mut call = Call::new();
    call.options.after_step = Some(after);
    call.options.context = (&raw mut seen).cast();
    assert_eq!(call.step(|_| {}), Error::Stopped as i32);
    assert_eq!((call.report().steps, seen.len()), (1, 1));
    assert_eq!((seen[0].1, seen[0].2), (call.positions.read::<f64>(1)[0], call.density.read::<f64>(1)[0]));
    // A stopped run writes no output.
    assert!(call.velocity.read::<u8>(16 * N).iter().all(|&b| b == 0xFF));
}

/// The energy of masses of both signs, or all negative, may rise along a correct run. Watching it is refused.
#[test]
fn a_watched_energy_has_no_negative_mass() {
    let spoil = |masses: &mut Block, index: usize, value: f64| {
        let at = masses.start + 8 * index;
        masses.memory[at..at + 8].copy_from_slice(&value.to_ne_bytes());
    };
    let watched = |call: &mut Call| {
        call.options.watch_energy = 1;
        let mut bytes = 0_usize;
        let (block, options) = (call.kernel.pointer::<c_void>(), &raw const call.options);
        // SAFETY: pointers to live locals.
        let code =
            unsafe { blob2_workspace_bytes(block, call.kernel_bytes, N, TRACERS, 7, options, null(), &raw mut bytes) };
        assert_eq!(code, 0);
        (call.workspace, call.workspace_bytes) = (Block::new(bytes), bytes);
    };
    for index in [0, N - 1] {
        let change = |c: &mut Call| {
            watched(c);
            spoil(&mut c.masses, index, -0.1);
        };
        let call = refused(Error::Mass, change, |_| {});
        assert_eq!((call.report().steps, call.report().first_bad), (0, MOLLIS_NONE_BAD));
        // The energy of vortices need not fall: it is reported for masses of either sign.
        let mut call = Call::new();
        change(&mut call);
        call.options.combination = [0.0, -1.0];
        assert_eq!(call.step(|_| {}), 0);
        let (first, last) = (call.report().energy_first, call.report().energy_last);
        assert!((last / first - 1.0).abs() <= 1e-3, "{first} {last}");
        // Without the watch negative masses are valid. With it a mass of 0 is valid.
        let mut call = Call::new();
        spoil(&mut call.masses, index, -0.1);
        assert_eq!(call.step(|_| {}), 0);
        let mut call = Call::new();
        watched(&mut call);
        spoil(&mut call.masses, index, 0.0);
        assert_eq!(call.step(|_| {}), 0);
    }
}

/// The watch reports the energy in every dimension and scalar.
#[test]
fn the_energy_is_reported() {
    let mut call = Call::new();
    call.options.watch_energy = 1;
    let mut bytes = 0_usize;
    let length = call.kernel_bytes;
    // SAFETY: pointers to live locals.
    let code = unsafe {
        let block = call.kernel.pointer::<c_void>();
        let options = &raw const call.options;
        blob2_workspace_bytes(block, length, N, TRACERS, 7, options, null(), &raw mut bytes)
    };
    assert_eq!(code, 0);
    call.workspace = Block::new(bytes);
    call.workspace_bytes = bytes;
    assert_eq!(call.step(|_| {}), 0);
    let report = call.report();
    assert!(report.energy_last < report.energy_first, "{} {}", report.energy_last, report.energy_first);
}
