//! The C ABI's steps and mesh fields with their arguments one by one, from arrays without gaps, so that a test can spoil one at a time.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::too_many_arguments,
    clippy::missing_safety_doc,
    missing_docs,
    reason = "the arguments of the C functions"
)]

use std::ffi::c_void;
use std::ptr::{NonNull, null, null_mut};

use mollis_abi::{
    GridOutputsOf, ParticlesOf, PksParticlesOf, mollis_blob_options, mollis_blob_report, mollis_generator,
    mollis_grid2_options, mollis_mesh2, mollis_pks_attraction, mollis_pks_events, mollis_pks_options,
    mollis_pks_progress, mollis_pks_report, mollis_run,
};

use crate::sums::{Sum, together};

/// Densities are advanced.
pub const DENSITY: u32 = 1;
/// Velocities are wanted.
pub const VELOCITY: u32 = 2;
/// Divergences are wanted.
pub const DIVERGENCE: u32 = 4;

fn particles<T, const D: usize>(
    n: usize,
    masses: *const T,
    positions: *mut [T; D],
    density: *mut T,
    velocity: *mut [T; D],
    divergence: *mut T,
) -> ParticlesOf<T, D> {
    ParticlesOf {
        n,
        positions: together(positions).map(<*const T>::cast_mut),
        stride: 0,
        masses,
        mass_stride: 0,
        density,
        density_stride: 0,
        velocity: together(velocity).map(<*const T>::cast_mut),
        velocity_stride: 0,
        divergence,
        divergence_stride: 0,
    }
}

/// Particles of which a size query sees what is wanted.
fn asked<T, const D: usize>(n: usize, wanted: u32, massless: bool) -> ParticlesOf<T, D> {
    let some = NonNull::<T>::dangling().as_ptr();
    let if_wanted = |flag: u32| if wanted & flag == 0 { null_mut() } else { some };
    let divergence = if massless { null_mut() } else { if_wanted(DIVERGENCE) };
    particles(n, some, some.cast(), if_wanted(DENSITY), if_wanted(VELOCITY).cast(), divergence)
}

macro_rules! blob {
    ($($t:ty, $d:literal: $abi_size:ident $size:ident $abi_step:ident $step:ident;)*) => { $(
        /// # Safety
        /// That of the C function.
        pub unsafe fn $size(
            kernel: *const c_void,
            kernel_bytes: usize,
            n: usize,
            tracers: usize,
            wanted: u32,
            options: *const mollis_blob_options,
            run: *const mollis_run,
            bytes: *mut usize,
        ) -> i32 {
            let (particles, massless) = (asked::<$t, $d>(n, wanted, false), asked::<$t, $d>(tracers, wanted, true));
            let massless = if tracers == 0 { null() } else { (&raw const massless).cast() };
            // SAFETY: passed on.
            unsafe {
                mollis_abi::$abi_size(kernel, kernel_bytes, (&raw const particles).cast(), massless, options, run, bytes)
            }
        }

        /// # Safety
        /// That of the C function.
        pub unsafe fn $step(
            kernel: *const c_void,
            kernel_bytes: usize,
            n: usize,
            masses: *const $t,
            positions: *mut [$t; $d],
            density: *mut $t,
            velocity: *mut [$t; $d],
            divergence: *mut $t,
            tracers: usize,
            tracer_positions: *mut [$t; $d],
            tracer_density: *mut $t,
            tracer_velocity: *mut [$t; $d],
            dt: f64,
            steps: usize,
            options: *const mollis_blob_options,
            run: *const mollis_run,
            report: *mut mollis_blob_report,
            workspace: *mut c_void,
            workspace_bytes: usize,
        ) -> i32 {
            let particles = particles(n, masses, positions, density, velocity, divergence);
            let massless = self::particles(tracers, null(), tracer_positions, tracer_density, tracer_velocity, null_mut());
            let massless = if tracers == 0 { null() } else { (&raw const massless).cast() };
            let particles = (&raw const particles).cast();
            // SAFETY: passed on.
            unsafe {
                mollis_abi::$abi_step(
                    kernel, kernel_bytes, particles, massless, dt, steps, options, run, workspace, workspace_bytes, report,
                )
            }
        }
    )* };
}
blob! {
    f64, 1: mollis_blob1_workspace_bytes blob1_workspace_bytes mollis_blob1_step blob1_step;
    f64, 2: mollis_blob2_workspace_bytes blob2_workspace_bytes mollis_blob2_step blob2_step;
    f64, 3: mollis_blob3_workspace_bytes blob3_workspace_bytes mollis_blob3_step blob3_step;
    f32, 1: mollis_blob1_workspace_bytes_f32 blob1_workspace_bytes_f32 mollis_blob1_step_f32 blob1_step_f32;
    f32, 2: mollis_blob2_workspace_bytes_f32 blob2_workspace_bytes_f32 mollis_blob2_step_f32 blob2_step_f32;
    f32, 3: mollis_blob3_workspace_bytes_f32 blob3_workspace_bytes_f32 mollis_blob3_step_f32 blob3_step_f32;
}

macro_rules! pks {
    ($($t:ty: $abi_size:ident $size:ident $abi_step:ident $step:ident;)*) => { $(
        /// # Safety
        /// That of the C function.
        pub unsafe fn $size(
            room: usize,
            options: *const mollis_pks_options,
            attraction: *const mollis_pks_attraction,
            run: *const mollis_run,
            bytes: *mut usize,
        ) -> i32 {
            // SAFETY: passed on.
            unsafe { mollis_abi::$abi_size(room, attraction, options, run, bytes) }
        }

        /// A seed that is not 0 replaces that of the options, which are then whole.
        ///
        /// # Safety
        /// That of the C function.
        pub unsafe fn $step(
            options: *const mollis_pks_options,
            attraction: *const mollis_pks_attraction,
            room: usize,
            positions: *mut [$t; 2],
            masses: *mut $t,
            labels: *mut u64,
            species: *mut u32,
            progress: *mut mollis_pks_progress,
            generator: *const mollis_generator,
            seed: u64,
            dt: $t,
            steps: usize,
            events: *mut mollis_pks_events,
            report: *mut mollis_pks_report,
            workspace: *mut c_void,
            workspace_bytes: usize,
            run: *const mollis_run,
        ) -> i32 {
            let particles = PksParticlesOf { room, positions, masses, labels, species, weights: core::ptr::null_mut() };
            let (particles, dt) = ((&raw const particles).cast(), f64::from(dt));
            let mut seeded = std::mem::MaybeUninit::<mollis_pks_options>::uninit();
            // SAFETY: passed on.
            unsafe {
                let mut given = options;
                if seed != 0 {
                    given = seeded.write(mollis_pks_options { seed, ..*options });
                }
                mollis_abi::$abi_step(
                    particles, progress, attraction, generator, dt, steps, events, given, run, workspace, workspace_bytes, report,
                )
            }
        }
    )* };
}
pks! {
    f64: mollis_pks_workspace_bytes pks_workspace_bytes mollis_pks_step pks_step;
    f32: mollis_pks_workspace_bytes_f32 pks_workspace_bytes_f32 mollis_pks_step_f32 pks_step_f32;
}

macro_rules! grid {
    ($($t:ty: $abi_size:ident $size:ident $abi_eval:ident $eval:ident;)*) => { $(
        /// # Safety
        /// That of the C function.
        pub unsafe fn $size(
            mesh: *const mollis_mesh2,
            options: *const mollis_grid2_options,
            run: *const mollis_run,
            bytes: *mut usize,
        ) -> i32 {
            let sum = Sum::<$t, 2>::new((0, null(), null()), (0, null()), (null_mut(), null_mut(), null_mut()));
            let outputs = GridOutputsOf::<$t> {
                gradient: [null_mut(); 2],
                gradient_stride: 0,
                node_mass: null_mut(),
                node_potential: null_mut(),
                node_gradient: null_mut(),
                total: null_mut(),
                outside: null_mut(),
            };
            let outputs = (&raw const outputs).cast();
            // SAFETY: passed on.
            unsafe { mollis_abi::$abi_size(mesh, sum.sources(), sum.targets(), outputs, options, run, bytes) }
        }

        /// # Safety
        /// That of the C function.
        pub unsafe fn $eval(
            mesh: *const mollis_mesh2,
            options: *const mollis_grid2_options,
            n_sources: usize,
            sources: *const [$t; 2],
            masses: *const $t,
            n_targets: usize,
            targets: *const [$t; 2],
            gradient: *mut [$t; 2],
            node_mass: *mut $t,
            node_potential: *mut $t,
            node_gradient: *mut [$t; 2],
            total: *mut [$t; 3],
            outside: *mut u64,
            workspace: *mut c_void,
            workspace_bytes: usize,
            run: *const mollis_run,
        ) -> i32 {
            let nothing = (null_mut(), null_mut(), null_mut());
            let sum = Sum::new((n_sources, sources, masses), (n_targets, targets), nothing);
            let gradient = together(gradient).map(<*const $t>::cast_mut);
            let outputs =
                GridOutputsOf { gradient, gradient_stride: 0, node_mass, node_potential, node_gradient, total, outside };
            let outputs = (&raw const outputs).cast();
            // SAFETY: passed on.
            unsafe {
                mollis_abi::$abi_eval(
                    mesh, sum.sources(), sum.targets(), outputs, options, run, workspace, workspace_bytes,
                )
            }
        }
    )* };
}
grid! {
    f64: mollis_grid2_workspace_bytes grid2_workspace_bytes mollis_grid2_eval grid2_eval;
    f32: mollis_grid2_workspace_bytes_f32 grid2_workspace_bytes_f32 mollis_grid2_eval_f32 grid2_eval_f32;
}
