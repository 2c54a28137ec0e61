//! `mollis-bench codes`: sums as particle codes have them, through the C ABI, beside plain loops in C (`peers/codes.c`).

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use anyhow::{Result, ensure};
use mollis_abi::*;

use crate::field::{cpu_time, minimum};
use crate::scene::Scene;

const N: usize = 4000;
const ROUNDS: usize = 9;

/// A body of a host's, of 128 bytes.
#[repr(C)]
#[derive(Clone, Copy, Default)]
struct Body {
    mass: f64,
    x: [f64; 3],
    v: [f64; 3],
    a: [f64; 3],
    rest: [f64; 6],
}

#[expect(unsafe_code, reason = "C functions")]
unsafe extern "C" {
    fn peer_gravity(n: usize, bodies: *mut Body, softening: f64);
    fn peer_vortices(
        n: usize,
        x: *const f32,
        y: *const f32,
        circulation: *const f32,
        radius: *const f32,
        u: *mut f32,
        v: *mut f32,
    );
    fn peer_elements(
        n: usize,
        x: *const f64,
        y: *const f64,
        z: *const f64,
        a: *const f64,
        b: *const f64,
        c: *const f64,
        radius: *const f64,
        u: *mut f64,
        v: *mut f64,
        w: *mut f64,
    );
}

fn ok(status: mollis_status) {
    assert_eq!(status, 0, "mollis refused");
}

/// Memory at a multiple of 64.
fn aligned(bytes: usize) -> Vec<[u64; 8]> {
    vec![[0; 8]; bytes.div_ceil(64) + 1]
}

fn start(memory: &mut [[u64; 8]]) -> *mut c_void {
    let start = memory.as_mut_ptr().cast::<u8>();
    start.wrapping_add(start.align_offset(64)).cast()
}

const NEWTONIAN: mollis_kernel_term =
    mollis_kernel_term { kind: MOLLIS_KERNEL_NEWTONIAN, reserved: 0, coefficient: 1.0, parameter: [0.0; 2] };

/// Times of both in turns, and prints seconds a pair and the ratio; `other` says what the second is.
fn compare(name: &str, other: &str, mut ours: impl FnMut(), mut theirs: impl FnMut()) {
    let (mut a, mut b) = (Vec::new(), Vec::new());
    ours();
    theirs();
    for _ in 0..ROUNDS {
        let begin = cpu_time();
        ours();
        let middle = cpu_time();
        theirs();
        a.push((middle - begin).as_secs_f64());
        b.push((cpu_time() - middle).as_secs_f64());
    }
    let mut ratios: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a / b).collect();
    ratios.sort_by(f64::total_cmp);
    let pairs = (N * N) as f64;
    println!(
        "{name}: {:.2} ns a pair, {other} {:.2}, ratio of times {:.3} (median of {ROUNDS})",
        1e9 * minimum(&a) / pairs,
        1e9 * minimum(&b) / pairs,
        ratios[ROUNDS / 2]
    );
}

/// No sources but their number.
fn nothing() -> mollis_sources3 {
    mollis_sources3 {
        n: N,
        positions: [null(); 3],
        stride: 0,
        masses: null(),
        mass_stride: 0,
        radii: null(),
        radius_stride: 0,
        strengths: [null(); 3],
        strength_stride: 0,
    }
}

/// The gradient alone, times a factor.
fn gradient_to(gradient: [*mut f64; 3], gradient_stride: usize, factor: f64) -> mollis_outputs3 {
    mollis_outputs3 {
        potential: null_mut(),
        potential_stride: 0,
        gradient,
        gradient_stride,
        laplacian: null_mut(),
        laplacian_stride: 0,
        hessian: std::ptr::null_mut(),
        hessian_stride: 0,
        factor,
        add: 0,
        reserved: 0,
    }
}

/// Velocities of vortex elements in space with a compact core and a radius each; columns.
#[expect(unsafe_code, reason = "calls C as a host does")]
fn elements() {
    let (scene, other) = (Scene::<3>::uniform(N, None, 1), Scene::<3>::uniform(N, None, 2));
    let column = |scene: &Scene<3>, k: usize| scene.positions.iter().map(|x| x[k]).collect::<Vec<_>>();
    let x: [Vec<f64>; 3] = std::array::from_fn(|k| column(&scene, k));
    let strength: [Vec<f64>; 3] = std::array::from_fn(|k| column(&other, k).iter().map(|s| s - 0.5).collect());
    let radius: Vec<f64> = (0..N).map(|k| 0.04 + 0.01 * (k % 7) as f64).collect();
    let (mut ours_out, mut peer_out) = ([(); 3].map(|()| vec![0.0; N]), [(); 3].map(|()| vec![0.0; N]));
    let compact = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 2, exponent: 2 };
    let (mut kernel_bytes, mut bytes) = (0, 0);
    // SAFETY: every pointer is to a buffer of the stated size that lives through the calls.
    unsafe {
        ok(mollis_kernel3_bytes(&NEWTONIAN, 1, null(), compact, &raw mut kernel_bytes));
        let mut block = aligned(kernel_bytes);
        let kernel = start(&mut block);
        ok(mollis_kernel3_prepare(kernel, kernel_bytes, &NEWTONIAN, 1, null(), compact, 1.0));
        let [positions, strengths] = [&x, &strength].map(|columns| columns.each_ref().map(|column| column.as_ptr()));
        let sources = mollis_sources3 { positions, strengths, radii: radius.as_ptr(), ..nothing() };
        let outputs = gradient_to(ours_out.each_mut().map(|column| column.as_mut_ptr()), 0, 4.0 * std::f64::consts::PI);
        let (sources, outputs) = (&raw const sources, &raw const outputs);
        ok(mollis_field3_workspace_bytes(
            kernel,
            kernel_bytes,
            sources,
            null(),
            outputs,
            null(),
            null(),
            &raw mut bytes,
        ));
        let mut memory = vec![0_u8; bytes];
        let space = memory.as_mut_ptr().cast();
        let ours = || {
            let none = null_mut();
            ok(mollis_field3_eval(kernel, kernel_bytes, sources, null(), outputs, null(), null(), space, bytes, none));
        };
        let ([px, py, pz], [a, b, c], r) = (positions, strengths, radius.as_ptr());
        let [u, v, w] = peer_out.each_mut().map(|column| column.as_mut_ptr());
        let theirs = || peer_elements(N, px, py, pz, a, b, c, r, u, v, w);
        compare("vortex elements, compact core, 3D, radius each", "plain loop", ours, theirs);
    }
    let (mut error, mut size) = (0.0, 0.0);
    for (a, b) in ours_out.iter().zip(&peer_out) {
        error += a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        size += b.iter().map(|b| b.powi(2)).sum::<f64>();
    }
    println!("  relative difference of the velocities {:.1e}", (error / size).sqrt());
}

/// Gravity with Plummer's softening over an array of structures.
#[expect(unsafe_code, reason = "calls C as a host does")]
fn gravity() {
    let scene = Scene::<3>::uniform(N, None, 1);
    let body = |(x, m): (&[f64; 3], &f64)| Body { mass: m.abs(), x: *x, ..Body::default() };
    let mut bodies: Vec<Body> = scene.positions.iter().zip(&scene.masses).map(body).collect();
    let mut peers = bodies.clone();
    let compact_masses: Vec<f64> = bodies.iter().map(|body| body.mass).collect();
    let mut accelerations = vec![[0.0_f64; 3]; N];
    let softening = 0.02;
    let plummer = mollis_mollifier { kind: MOLLIS_MOLLIFIER_PLUMMER, order: 0, exponent: 0 };
    let (mut kernel_bytes, mut bytes) = (0, 0);
    // SAFETY: every pointer is to a buffer of the stated size that lives through the calls.
    unsafe {
        ok(mollis_kernel3_bytes(&NEWTONIAN, 1, null(), plummer, &raw mut kernel_bytes));
        let mut block = aligned(kernel_bytes);
        let kernel = start(&mut block);
        ok(mollis_kernel3_prepare(kernel, kernel_bytes, &NEWTONIAN, 1, null(), plummer, softening));
        let (p, stride) = (bodies.as_mut_ptr(), size_of::<Body>() / size_of::<f64>());
        let positions = [(&raw const (*p).x).cast(), null(), null()];
        let masses = &raw const (*p).mass;
        let sources = mollis_sources3 { positions, stride, masses, mass_stride: stride, ..nothing() };
        // a = -4 pi grad u with u = -m / (4 pi (r^2 + e^2)^(1/2)).
        let factor = -4.0 * std::f64::consts::PI;
        let outputs = gradient_to([(&raw mut (*p).a).cast(), null_mut(), null_mut()], stride, factor);
        let (sources, outputs) = (&raw const sources, &raw const outputs);
        ok(mollis_field3_workspace_bytes(
            kernel,
            kernel_bytes,
            sources,
            null(),
            outputs,
            null(),
            null(),
            &raw mut bytes,
        ));
        let mut memory = vec![0_u8; bytes];
        let space = memory.as_mut_ptr().cast();
        let ours = || {
            let none = null_mut();
            ok(mollis_field3_eval(kernel, kernel_bytes, sources, null(), outputs, null(), null(), space, bytes, none));
        };
        let theirs = || peer_gravity(N, peers.as_mut_ptr(), softening);
        compare("gravity, Plummer, 3D, structures of 128 bytes", "plain loop", ours, theirs);
        // The same numbers in arrays without gaps.
        let (x, m) = (scene.positions.as_ptr().cast(), compact_masses.as_ptr());
        let compact = mollis_sources3 { positions: [x, null(), null()], masses: m, ..nothing() };
        let to = gradient_to([accelerations.as_mut_ptr().cast(), null_mut(), null_mut()], 0, factor);
        let (compact, to) = (&raw const compact, &raw const to);
        let without_gaps = || {
            let none = null_mut();
            ok(mollis_field3_eval(kernel, kernel_bytes, compact, null(), to, null(), null(), space, bytes, none));
        };
        compare("  with a stride of 128 bytes", "arrays without gaps", ours, without_gaps);
    }
    let (mut error, mut size) = (0.0, 0.0);
    for (a, b) in bodies.iter().zip(&peers) {
        error += (0..3).map(|k| (a.a[k] - b.a[k]).powi(2)).sum::<f64>();
        size += (0..3).map(|k| b.a[k].powi(2)).sum::<f64>();
    }
    println!("  relative difference of the accelerations {:.1e}", (error / size).sqrt());
}

/// Vortices in the plane with Vatistas' core and a radius each, in single precision.
#[expect(unsafe_code, reason = "calls C as a host does")]
fn vortices() {
    let scene = Scene::<2>::uniform(N, None, 1);
    let column = |k: usize| scene.positions.iter().map(|x| x[k] as f32).collect::<Vec<_>>();
    let (x, y) = (column(0), column(1));
    let circulation: Vec<f32> = scene.masses.iter().map(|&m| m as f32).collect();
    let radius: Vec<f32> = (0..N).map(|k| 0.01 + 0.01 * (k % 7) as f32).collect();
    let [mut u, mut v, mut peer_u, mut peer_v] = [(); 4].map(|()| vec![0.0_f32; N]);
    let vatistas = mollis_mollifier { kind: MOLLIS_MOLLIFIER_VATISTAS, order: 0, exponent: 0 };
    let (mut kernel_bytes, mut bytes) = (0, 0);
    // SAFETY: as above.
    unsafe {
        ok(mollis_kernel2_bytes_f32(&NEWTONIAN, 1, null(), vatistas, &raw mut kernel_bytes));
        let mut block = aligned(kernel_bytes);
        let kernel = start(&mut block);
        ok(mollis_kernel2_prepare_f32(kernel, kernel_bytes, &NEWTONIAN, 1, null(), vatistas, 1.0));
        let sources = mollis_sources2_f32 {
            n: N,
            positions: [x.as_ptr(), y.as_ptr()],
            stride: 0,
            masses: circulation.as_ptr(),
            mass_stride: 0,
            radii: radius.as_ptr(),
            radius_stride: 0,
            strengths: [null(); 2],
            strength_stride: 0,
        };
        let outputs = mollis_outputs2_f32 {
            potential: null_mut(),
            potential_stride: 0,
            gradient: [u.as_mut_ptr(), v.as_mut_ptr()],
            gradient_stride: 0,
            laplacian: null_mut(),
            laplacian_stride: 0,
            hessian: std::ptr::null_mut(),
            hessian_stride: 0,
            factor: std::f64::consts::TAU,
            add: 0,
            reserved: 0,
        };
        let mut options = std::mem::MaybeUninit::<mollis_field_options>::uninit();
        ok(mollis_field_options_init(options.as_mut_ptr(), size_of::<mollis_field_options>()));
        let options = mollis_field_options { combination: [0.0, 1.0], ..options.assume_init() };
        let (sources, outputs, options) = (&raw const sources, &raw const outputs, &raw const options);
        let sized = &raw mut bytes;
        ok(mollis_field2_workspace_bytes_f32(kernel, kernel_bytes, sources, null(), outputs, options, null(), sized));
        let mut memory = vec![0_u8; bytes];
        let space = memory.as_mut_ptr().cast();
        let ours = || {
            let none = null_mut();
            ok(mollis_field2_eval_f32(
                kernel,
                kernel_bytes,
                sources,
                null(),
                outputs,
                options,
                null(),
                space,
                bytes,
                none,
            ));
        };
        let (x, y, m, r) = (x.as_ptr(), y.as_ptr(), circulation.as_ptr(), radius.as_ptr());
        let (to_u, to_v) = (peer_u.as_mut_ptr(), peer_v.as_mut_ptr());
        let theirs = || peer_vortices(N, x, y, m, r, to_u, to_v);
        compare("vortices, Vatistas, 2D, radius each, f32", "plain loop", ours, theirs);
    }
    let sum = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
    let zero = vec![0.0; N];
    let (error, size) = (sum(&u, &peer_u) + sum(&v, &peer_v), sum(&peer_u, &zero) + sum(&peer_v, &zero));
    println!("  relative difference of the velocities {:.1e}", (error / size).sqrt());
}

/// Measures and prints all three.
pub fn run() -> Result<()> {
    ensure!(size_of::<Body>() == 128, "a body has 128 bytes");
    elements();
    gravity();
    vortices();
    Ok(())
}
