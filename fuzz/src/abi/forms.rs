//! The functions of the C interface by scalar and dimension.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![expect(clippy::too_many_arguments, reason = "the arguments of the C functions")]

use std::ffi::{c_char, c_void};

use mollis_abi::*;

/// A scalar, with what exists for each.
pub trait Scalar: Copy + PartialOrd + Into<f64> + 'static {
    fn of(value: f64) -> Self;
    unsafe fn heaviside(mollifier: mollis_mollifier, delta: Self, n: usize, x: *const Self, values: *mut Self) -> i32;
    unsafe fn norm(n: usize, values: *const Self, cell: Self, p: Self, norm: *mut Self) -> i32;
    unsafe fn first_bad(n: usize, each: usize, values: *const Self, first: *mut u64) -> i32;
    unsafe fn philox_normals(
        seed: u64,
        n: usize,
        labels: *const u64,
        step: u32,
        substep: u32,
        normals: *mut [Self; 2],
    ) -> i32;
    unsafe fn normals(n: usize, words: *const u64, out: *mut Self) -> i32;
    unsafe fn grid_bytes(
        mesh: *const mollis_mesh2,
        sources: *const SourcesOf<Self, 2>,
        targets: *const TargetsOf<Self, 2>,
        outputs: *const GridOutputsOf<Self>,
        options: *const mollis_grid2_options,
        run: *const mollis_run,
        needed: *mut usize,
    ) -> i32;
    unsafe fn grid_eval(
        mesh: *const mollis_mesh2,
        sources: *const SourcesOf<Self, 2>,
        targets: *const TargetsOf<Self, 2>,
        outputs: *const GridOutputsOf<Self>,
        options: *const mollis_grid2_options,
        run: *const mollis_run,
        workspace: *mut c_void,
        room: usize,
    ) -> i32;
    unsafe fn pks_bytes(
        room: usize,
        attraction: *const mollis_pks_attraction,
        options: *const mollis_pks_options,
        run: *const mollis_run,
        needed: *mut usize,
    ) -> i32;
    unsafe fn pks_step(
        particles: *const PksParticlesOf<Self>,
        progress: *mut mollis_pks_progress,
        attraction: *const mollis_pks_attraction,
        generator: *const mollis_generator,
        dt: f64,
        steps: usize,
        events: *mut mollis_pks_events,
        options: *const mollis_pks_options,
        run: *const mollis_run,
        workspace: *mut c_void,
        workspace_bytes: usize,
        report: *mut mollis_pks_report,
    ) -> i32;
}

/// What exists for each dimension of a scalar.
pub trait Form<const D: usize>: Scalar {
    /// 0 to 5.
    const INDEX: usize;
    unsafe fn kernel_bytes(
        terms: *const mollis_kernel_term,
        n: usize,
        own: *const mollis_radial_kernel,
        mollifier: mollis_mollifier,
        bytes: *mut usize,
    ) -> i32;
    unsafe fn kernel_prepare(
        kernel: *mut c_void,
        bytes: usize,
        terms: *const mollis_kernel_term,
        n: usize,
        own: *const mollis_radial_kernel,
        mollifier: mollis_mollifier,
        delta: Self,
    ) -> i32;
    unsafe fn kernel_eval(
        kernel: *const c_void,
        bytes: usize,
        n: usize,
        r: *const Self,
        value: *mut Self,
        factor: *mut Self,
        laplacian: *mut Self,
    ) -> i32;
    unsafe fn mollifier_eval(
        mollifier: mollis_mollifier,
        delta: Self,
        n: usize,
        r: *const Self,
        a: *mut Self,
        b: *mut Self,
        c: *mut Self,
        d: *mut Self,
        e: *mut Self,
        f: *mut Self,
    ) -> i32;
    unsafe fn mollifier_moment(mollifier: mollis_mollifier, delta: Self, k: u32, value: *mut Self) -> i32;
    unsafe fn mollifier_field(
        mollifier: mollis_mollifier,
        delta: Self,
        n: usize,
        x: *const [Self; D],
        density: *mut Self,
        potential: *mut Self,
        gradient: *mut [Self; D],
        hessian: *mut [[Self; D]; D],
    ) -> i32;
    unsafe fn mollifier_richardson(
        mollifier: mollis_mollifier,
        delta: Self,
        k: usize,
        radii: *const Self,
        weights: *mut Self,
        n: usize,
        r: *const Self,
        a: *mut Self,
        b: *mut Self,
        c: *mut Self,
        d: *mut Self,
        e: *mut Self,
        f: *mut Self,
    ) -> i32;
    unsafe fn moments(
        n: usize,
        x: *const [Self; D],
        masses: *const Self,
        mass: *mut Self,
        absolute: *mut Self,
        centre: *mut [Self; D],
        second: *mut Self,
    ) -> i32;
    unsafe fn stable_step(
        kernel: *const c_void,
        bytes: usize,
        n: usize,
        x: *const [Self; D],
        masses: *const Self,
        step: *mut Self,
    ) -> i32;
    unsafe fn stable_step_anywhere(
        kernel: *const c_void,
        bytes: usize,
        mass: Self,
        diameter: Self,
        step: *mut Self,
    ) -> i32;
    unsafe fn overlap(n: usize, delta: Self, masses: *const Self, densities: *const Self, smallest: *mut Self) -> i32;
    unsafe fn distance_norm(
        n: usize,
        a: *const [Self; D],
        b: *const [Self; D],
        cell: Self,
        p: Self,
        norm: *mut Self,
    ) -> i32;
    unsafe fn dual_norm_bytes(points: *const [usize; D], margin: usize, bytes: *mut usize) -> i32;
    unsafe fn dual_norm(
        points: *const [usize; D],
        spacing: Self,
        margin: usize,
        values: *const Self,
        norm: *mut Self,
        workspace: *mut c_void,
        room: usize,
    ) -> i32;
    unsafe fn field_bytes(
        kernel: *const c_void,
        bytes: usize,
        sources: *const SourcesOf<Self, D>,
        targets: *const TargetsOf<Self, D>,
        outputs: *const OutputsOf<Self, D>,
        options: *const mollis_field_options,
        run: *const mollis_run,
        needed: *mut usize,
    ) -> i32;
    unsafe fn field_text(
        kernel: *const c_void,
        bytes: usize,
        sources: *const SourcesOf<Self, D>,
        targets: *const TargetsOf<Self, D>,
        outputs: *const OutputsOf<Self, D>,
        options: *const mollis_field_options,
        text: *mut c_char,
        room: usize,
        length: *mut usize,
    ) -> i32;
    unsafe fn field_eval(
        kernel: *const c_void,
        bytes: usize,
        sources: *const SourcesOf<Self, D>,
        targets: *const TargetsOf<Self, D>,
        outputs: *const OutputsOf<Self, D>,
        options: *const mollis_field_options,
        run: *const mollis_run,
        workspace: *mut c_void,
        room: usize,
        counts: *mut mollis_field_counts,
    ) -> i32;
    unsafe fn blob_bytes(
        kernel: *const c_void,
        bytes: usize,
        particles: *const ParticlesOf<Self, D>,
        tracers: *const ParticlesOf<Self, D>,
        options: *const mollis_blob_options,
        run: *const mollis_run,
        needed: *mut usize,
    ) -> i32;
    unsafe fn blob_step(
        kernel: *const c_void,
        bytes: usize,
        particles: *const ParticlesOf<Self, D>,
        tracers: *const ParticlesOf<Self, D>,
        dt: f64,
        steps: usize,
        options: *const mollis_blob_options,
        run: *const mollis_run,
        workspace: *mut c_void,
        room: usize,
        report: *mut mollis_blob_report,
    ) -> i32;
}

macro_rules! scalars {
    ($($t:ty: $heaviside:ident $norm:ident $first_bad:ident $philox_normals:ident $normals:ident $grid_bytes:ident $grid_eval:ident $pks_bytes:ident $pks_step:ident;)*) => { $(
        // SAFETY of each function: that of the C function.
        impl Scalar for $t {
            fn of(value: f64) -> Self {
                value as Self
            }
            unsafe fn heaviside(mollifier: mollis_mollifier, delta: Self, n: usize, x: *const Self, values: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$heaviside(mollifier, delta, n, x, values) }
            }
            unsafe fn norm(n: usize, values: *const Self, cell: Self, p: Self, norm: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$norm(n, values, cell, p, norm) }
            }
            unsafe fn first_bad(n: usize, each: usize, values: *const Self, first: *mut u64) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$first_bad(n, each, values, first) }
            }
            unsafe fn philox_normals(seed: u64, n: usize, labels: *const u64, step: u32, substep: u32, normals: *mut [Self; 2]) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$philox_normals(seed, n, labels, step, substep, normals) }
            }
            unsafe fn normals(n: usize, words: *const u64, out: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$normals(n, words, out) }
            }
            unsafe fn grid_bytes(mesh: *const mollis_mesh2, sources: *const SourcesOf<Self, 2>, targets: *const TargetsOf<Self, 2>, outputs: *const GridOutputsOf<Self>, options: *const mollis_grid2_options, run: *const mollis_run, needed: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$grid_bytes(mesh, sources.cast(), targets.cast(), outputs.cast(), options, run, needed) }
            }
            unsafe fn grid_eval(mesh: *const mollis_mesh2, sources: *const SourcesOf<Self, 2>, targets: *const TargetsOf<Self, 2>, outputs: *const GridOutputsOf<Self>, options: *const mollis_grid2_options, run: *const mollis_run, workspace: *mut c_void, room: usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$grid_eval(mesh, sources.cast(), targets.cast(), outputs.cast(), options, run, workspace, room) }
            }
            unsafe fn pks_bytes(room: usize, attraction: *const mollis_pks_attraction, options: *const mollis_pks_options, run: *const mollis_run, needed: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$pks_bytes(room, attraction, options, run, needed) }
            }
            unsafe fn pks_step(particles: *const PksParticlesOf<Self>, progress: *mut mollis_pks_progress, attraction: *const mollis_pks_attraction, generator: *const mollis_generator, dt: f64, steps: usize, events: *mut mollis_pks_events, options: *const mollis_pks_options, run: *const mollis_run, workspace: *mut c_void, workspace_bytes: usize, report: *mut mollis_pks_report) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$pks_step(particles.cast(), progress, attraction, generator, dt, steps, events, options, run, workspace, workspace_bytes, report) }
            }
        }
    )* };
}
scalars! {
    f64: mollis_mollifier1_heaviside mollis_norm mollis_first_bad mollis_philox_normals mollis_normals mollis_grid2_workspace_bytes mollis_grid2_eval mollis_pks_workspace_bytes mollis_pks_step;
    f32: mollis_mollifier1_heaviside_f32 mollis_norm_f32 mollis_first_bad_f32 mollis_philox_normals_f32 mollis_normals_f32 mollis_grid2_workspace_bytes_f32 mollis_grid2_eval_f32 mollis_pks_workspace_bytes_f32 mollis_pks_step_f32;
}

macro_rules! forms {
    ($($t:ty, $d:literal, $index:literal: $kernel_bytes:ident $kernel_prepare:ident $kernel_eval:ident $mollifier_eval:ident $mollifier_moment:ident $mollifier_field:ident $mollifier_richardson:ident $moments:ident $stable_step:ident $stable_step_anywhere:ident $overlap:ident $distance_norm:ident $dual_norm_bytes:ident $dual_norm:ident $field_bytes:ident $field_text:ident $field_eval:ident $blob_bytes:ident $blob_step:ident;)*) => { $(
        impl Form<$d> for $t {
            const INDEX: usize = $index;
            unsafe fn kernel_bytes(terms: *const mollis_kernel_term, n: usize, own: *const mollis_radial_kernel, mollifier: mollis_mollifier, bytes: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$kernel_bytes(terms, n, own, mollifier, bytes) }
            }
            unsafe fn kernel_prepare(kernel: *mut c_void, bytes: usize, terms: *const mollis_kernel_term, n: usize, own: *const mollis_radial_kernel, mollifier: mollis_mollifier, delta: Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$kernel_prepare(kernel, bytes, terms, n, own, mollifier, delta) }
            }
            unsafe fn kernel_eval(kernel: *const c_void, bytes: usize, n: usize, r: *const Self, value: *mut Self, factor: *mut Self, laplacian: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$kernel_eval(kernel, bytes, n, r, value, factor, laplacian) }
            }
            unsafe fn mollifier_eval(mollifier: mollis_mollifier, delta: Self, n: usize, r: *const Self, a: *mut Self, b: *mut Self, c: *mut Self, d: *mut Self, e: *mut Self, f: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$mollifier_eval(mollifier, delta, n, r, a, b, c, d, e, f) }
            }
            unsafe fn mollifier_moment(mollifier: mollis_mollifier, delta: Self, k: u32, value: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$mollifier_moment(mollifier, delta, k, value) }
            }
            unsafe fn mollifier_field(mollifier: mollis_mollifier, delta: Self, n: usize, x: *const [Self; $d], density: *mut Self, potential: *mut Self, gradient: *mut [Self; $d], hessian: *mut [[Self; $d]; $d]) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$mollifier_field(mollifier, delta, n, x, density, potential, gradient, hessian) }
            }
            unsafe fn mollifier_richardson(mollifier: mollis_mollifier, delta: Self, k: usize, radii: *const Self, weights: *mut Self, n: usize, r: *const Self, a: *mut Self, b: *mut Self, c: *mut Self, d: *mut Self, e: *mut Self, f: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$mollifier_richardson(mollifier, delta, k, radii, weights, n, r, a, b, c, d, e, f) }
            }
            unsafe fn moments(n: usize, x: *const [Self; $d], masses: *const Self, mass: *mut Self, absolute: *mut Self, centre: *mut [Self; $d], second: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$moments(n, x, masses, mass, absolute, centre, second) }
            }
            unsafe fn stable_step(kernel: *const c_void, bytes: usize, n: usize, x: *const [Self; $d], masses: *const Self, step: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$stable_step(kernel, bytes, n, x, masses, step) }
            }
            unsafe fn stable_step_anywhere(kernel: *const c_void, bytes: usize, mass: Self, diameter: Self, step: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$stable_step_anywhere(kernel, bytes, mass, diameter, step) }
            }
            unsafe fn overlap(n: usize, delta: Self, masses: *const Self, densities: *const Self, smallest: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$overlap(n, delta, masses, densities, smallest) }
            }
            unsafe fn distance_norm(n: usize, a: *const [Self; $d], b: *const [Self; $d], cell: Self, p: Self, norm: *mut Self) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$distance_norm(n, a, b, cell, p, norm) }
            }
            unsafe fn dual_norm_bytes(points: *const [usize; $d], margin: usize, bytes: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$dual_norm_bytes(points, margin, bytes) }
            }
            unsafe fn dual_norm(points: *const [usize; $d], spacing: Self, margin: usize, values: *const Self, norm: *mut Self, workspace: *mut c_void, room: usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$dual_norm(points, spacing, margin, values, norm, workspace, room) }
            }
            unsafe fn field_bytes(kernel: *const c_void, bytes: usize, sources: *const SourcesOf<Self, $d>, targets: *const TargetsOf<Self, $d>, outputs: *const OutputsOf<Self, $d>, options: *const mollis_field_options, run: *const mollis_run, needed: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$field_bytes(kernel, bytes, sources.cast(), targets.cast(), outputs.cast(), options, run, needed) }
            }
            unsafe fn field_text(kernel: *const c_void, bytes: usize, sources: *const SourcesOf<Self, $d>, targets: *const TargetsOf<Self, $d>, outputs: *const OutputsOf<Self, $d>, options: *const mollis_field_options, text: *mut c_char, room: usize, length: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$field_text(kernel, bytes, sources.cast(), targets.cast(), outputs.cast(), options, text, room, length) }
            }
            unsafe fn field_eval(kernel: *const c_void, bytes: usize, sources: *const SourcesOf<Self, $d>, targets: *const TargetsOf<Self, $d>, outputs: *const OutputsOf<Self, $d>, options: *const mollis_field_options, run: *const mollis_run, workspace: *mut c_void, room: usize, counts: *mut mollis_field_counts) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$field_eval(kernel, bytes, sources.cast(), targets.cast(), outputs.cast(), options, run, workspace, room, counts) }
            }
            unsafe fn blob_bytes(kernel: *const c_void, bytes: usize, particles: *const ParticlesOf<Self, $d>, tracers: *const ParticlesOf<Self, $d>, options: *const mollis_blob_options, run: *const mollis_run, needed: *mut usize) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$blob_bytes(kernel, bytes, particles.cast(), tracers.cast(), options, run, needed) }
            }
            unsafe fn blob_step(kernel: *const c_void, bytes: usize, particles: *const ParticlesOf<Self, $d>, tracers: *const ParticlesOf<Self, $d>, dt: f64, steps: usize, options: *const mollis_blob_options, run: *const mollis_run, workspace: *mut c_void, room: usize, report: *mut mollis_blob_report) -> i32 {
                // SAFETY: passed on.
                unsafe { mollis_abi::$blob_step(kernel, bytes, particles.cast(), tracers.cast(), dt, steps, options, run, workspace, room, report) }
            }
        }
    )* };
}
forms! {
    f64, 1, 0: mollis_kernel1_bytes mollis_kernel1_prepare mollis_kernel1_eval mollis_mollifier1_eval mollis_mollifier1_moment mollis_mollifier1_field mollis_mollifier1_richardson mollis_moments1 mollis_stable_step1 mollis_stable_step1_anywhere mollis_overlap1 mollis_distance_norm1 mollis_dual_norm1_workspace_bytes mollis_dual_norm1 mollis_field1_workspace_bytes mollis_field1_text mollis_field1_eval mollis_blob1_workspace_bytes mollis_blob1_step;
    f64, 2, 1: mollis_kernel2_bytes mollis_kernel2_prepare mollis_kernel2_eval mollis_mollifier2_eval mollis_mollifier2_moment mollis_mollifier2_field mollis_mollifier2_richardson mollis_moments2 mollis_stable_step2 mollis_stable_step2_anywhere mollis_overlap2 mollis_distance_norm2 mollis_dual_norm2_workspace_bytes mollis_dual_norm2 mollis_field2_workspace_bytes mollis_field2_text mollis_field2_eval mollis_blob2_workspace_bytes mollis_blob2_step;
    f64, 3, 2: mollis_kernel3_bytes mollis_kernel3_prepare mollis_kernel3_eval mollis_mollifier3_eval mollis_mollifier3_moment mollis_mollifier3_field mollis_mollifier3_richardson mollis_moments3 mollis_stable_step3 mollis_stable_step3_anywhere mollis_overlap3 mollis_distance_norm3 mollis_dual_norm3_workspace_bytes mollis_dual_norm3 mollis_field3_workspace_bytes mollis_field3_text mollis_field3_eval mollis_blob3_workspace_bytes mollis_blob3_step;
    f32, 1, 3: mollis_kernel1_bytes_f32 mollis_kernel1_prepare_f32 mollis_kernel1_eval_f32 mollis_mollifier1_eval_f32 mollis_mollifier1_moment_f32 mollis_mollifier1_field_f32 mollis_mollifier1_richardson_f32 mollis_moments1_f32 mollis_stable_step1_f32 mollis_stable_step1_anywhere_f32 mollis_overlap1_f32 mollis_distance_norm1_f32 mollis_dual_norm1_workspace_bytes_f32 mollis_dual_norm1_f32 mollis_field1_workspace_bytes_f32 mollis_field1_text_f32 mollis_field1_eval_f32 mollis_blob1_workspace_bytes_f32 mollis_blob1_step_f32;
    f32, 2, 4: mollis_kernel2_bytes_f32 mollis_kernel2_prepare_f32 mollis_kernel2_eval_f32 mollis_mollifier2_eval_f32 mollis_mollifier2_moment_f32 mollis_mollifier2_field_f32 mollis_mollifier2_richardson_f32 mollis_moments2_f32 mollis_stable_step2_f32 mollis_stable_step2_anywhere_f32 mollis_overlap2_f32 mollis_distance_norm2_f32 mollis_dual_norm2_workspace_bytes_f32 mollis_dual_norm2_f32 mollis_field2_workspace_bytes_f32 mollis_field2_text_f32 mollis_field2_eval_f32 mollis_blob2_workspace_bytes_f32 mollis_blob2_step_f32;
    f32, 3, 5: mollis_kernel3_bytes_f32 mollis_kernel3_prepare_f32 mollis_kernel3_eval_f32 mollis_mollifier3_eval_f32 mollis_mollifier3_moment_f32 mollis_mollifier3_field_f32 mollis_mollifier3_richardson_f32 mollis_moments3_f32 mollis_stable_step3_f32 mollis_stable_step3_anywhere_f32 mollis_overlap3_f32 mollis_distance_norm3_f32 mollis_dual_norm3_workspace_bytes_f32 mollis_dual_norm3_f32 mollis_field3_workspace_bytes_f32 mollis_field3_text_f32 mollis_field3_eval_f32 mollis_blob3_workspace_bytes_f32 mollis_blob3_step_f32;
}
