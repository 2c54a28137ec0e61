//! Steps of the blob method and fields on meshes from arrays with gaps and from columns of their own: the same bits as from arrays without, and nothing written between.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_tests::positional::{grid2_eval, grid2_workspace_bytes};
use mollis_tests::{Aligned, Split};

const CANARY: f64 = 12345.5;

/// What a run of some layout left: positions, densities, velocities, divergences of particles; positions, densities, velocities of tracers.
type Outcome<T> = (Vec<T>, Vec<T>, Vec<T>, Vec<T>, Vec<T>, Vec<T>, Vec<T>);

/// Numbers at these places of a caller's memory: `n` of them, `stride` apart.
fn put<T: Copy>(memory: &mut [T], start: usize, stride: usize, values: &[T]) {
    values.iter().enumerate().for_each(|(k, &value)| memory[start + k * stride] = value);
}

fn get<T: Copy>(memory: &[T], start: usize, stride: usize, n: usize) -> Vec<T> {
    (0..n).map(|k| memory[start + k * stride]).collect()
}

macro_rules! layouts {
    ($name:ident, $t:ty, $d:literal, $size:ident $step:ident) => {
        #[test]
        fn $name() {
            const N: usize = 37;
            const TRACERS: usize = 5;
            let mut random = Split(5);
            let mut numbers = |n: usize| -> Vec<$t> { (0..n).map(|_| random.uniform() as $t).collect() };
            let (x, masses, rho) = (numbers(N * $d), numbers(N), numbers(N));
            let (y, rho_y) = (numbers(TRACERS * $d), numbers(TRACERS));
            let terms = [Term { law: Law::Newtonian, coefficient: 1.0 }];
            let mollifier = Mollifier::Compact { order: 2, exponent: 4 };
            let kernel_bytes = Kernel::<$t, $d>::workspace_bytes(&terms, mollifier).unwrap();
            let mut kernel = Aligned::new(kernel_bytes);
            Kernel::<$t, $d>::prepare(kernel.bytes(), &terms, mollifier, 0.4).unwrap();
            // Of each layout: where coordinate k, mass, density, velocity k and divergence begin, and strides of points and of numbers.
            let run = |layout: &str| -> Outcome<$t> {
                let (place, stride, each): (fn(usize, usize) -> usize, usize, usize) = match layout {
                    "dense" => (|what, n| [0, $d * n, ($d + 1) * n, ($d + 2) * n, (2 * $d + 2) * n][what], $d, 1),
                    // x x m . rho v v div . .
                    "structures" => (|what, _| [0, $d, $d + 2, $d + 3, 2 * $d + 3][what], 2 * $d + 6, 2 * $d + 6),
                    "columns" => (|what, n| [0, $d * n, ($d + 1) * n, ($d + 2) * n, (2 * $d + 2) * n][what], 1, 1),
                    _ => unreachable!(),
                };
                let own = |n: usize, coordinate: usize| if layout == "columns" { coordinate * n } else { coordinate };
                let length = |n: usize| if layout == "structures" { n * stride } else { (2 * $d + 3) * n };
                let canary = CANARY as $t;
                let fill = |n: usize, points: &[$t], masses: &[$t], rho: &[$t]| {
                    let mut memory = vec![canary; length(n)];
                    for k in 0..$d {
                        let column: Vec<$t> = points.iter().skip(k).step_by($d).copied().collect();
                        put(&mut memory, place(0, n) + own(n, k), stride, &column);
                    }
                    put(&mut memory, place(1, n), each, masses);
                    put(&mut memory, place(2, n), each, rho);
                    memory
                };
                let (mut here, mut there) = (fill(N, &x, &masses, &rho), fill(TRACERS, &y, &[], &rho_y));
                let describe = |memory: &mut Vec<$t>, n: usize, massless: bool| {
                    let start = memory.as_mut_ptr();
                    let at = |what: usize| start.wrapping_add(place(what, n));
                    let points = |what: usize| {
                        let mut pointers = [null_mut(); $d];
                        for k in 0..if layout == "columns" { $d } else { 1 } {
                            pointers[k] = at(what).wrapping_add(own(n, k));
                        }
                        pointers
                    };
                    ParticlesOf::<$t, $d> {
                        n,
                        positions: points(0),
                        stride,
                        masses: if massless { null() } else { at(1) },
                        mass_stride: each,
                        density: at(2),
                        density_stride: each,
                        velocity: points(3),
                        velocity_stride: stride,
                        divergence: if massless { null_mut() } else { at(4) },
                        divergence_stride: each,
                    }
                };
                let (particles, tracers) = (describe(&mut here, N, false), describe(&mut there, TRACERS, true));
                let (particles, tracers) = ((&raw const particles).cast(), (&raw const tracers).cast());
                let (block, mut bytes, mut needed) = (kernel.start(), 0, 0);
                unsafe {
                    let mut run = std::mem::MaybeUninit::<mollis_run>::uninit();
                    assert_eq!(mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()), 0);
                    let mut run = run.assume_init();
                    run.bytes_needed = &raw mut needed;
                    let run = &raw const run;
                    assert_eq!($size(block, kernel_bytes, particles, tracers, null(), run, &raw mut bytes), 0);
                    let mut memory = vec![0x5A_u8; bytes + 2];
                    let mut step = |bytes: usize| {
                        let workspace = memory.as_mut_ptr().wrapping_add(1).cast();
                        $step(
                            block,
                            kernel_bytes,
                            particles,
                            tracers,
                            0.01,
                            3,
                            null(),
                            run,
                            workspace,
                            bytes,
                            null_mut(),
                        )
                    };
                    assert_eq!((step(bytes - 1), needed), (Error::WorkspaceTooSmall as i32, bytes));
                    assert_eq!(step(bytes), 0);
                    assert_eq!((memory[0], memory[bytes + 1]), (0x5A, 0x5A));
                }
                if layout == "structures" {
                    let gaps = [$d + 1, 2 * $d + 4, 2 * $d + 5];
                    assert!((0..N).all(|i| gaps.iter().all(|gap| here[i * stride + gap] == canary)));
                }
                let points = |memory: &[$t], what: usize, n: usize| -> Vec<$t> {
                    let mut points = vec![0.0; n * $d];
                    for k in 0..$d {
                        put(&mut points, k, $d, &get(memory, place(what, n) + own(n, k), stride, n));
                    }
                    points
                };
                let column = |memory: &[$t], what: usize, n: usize| get(memory, place(what, n), each, n);
                assert_eq!(column(&here, 1, N), masses);
                (
                    points(&here, 0, N),
                    column(&here, 2, N),
                    points(&here, 3, N),
                    column(&here, 4, N),
                    points(&there, 0, TRACERS),
                    column(&there, 2, TRACERS),
                    points(&there, 3, TRACERS),
                )
            };
            let dense = run("dense");
            assert!(dense.0 != x && dense.4 != y && dense.2.iter().all(|v| v.is_finite() && *v != CANARY as $t));
            for layout in ["structures", "columns"] {
                assert_eq!(run(layout), dense, "{layout}");
            }
        }
    };
}

layouts!(line, f64, 1, mollis_blob1_workspace_bytes mollis_blob1_step);
layouts!(plane, f64, 2, mollis_blob2_workspace_bytes mollis_blob2_step);
layouts!(space, f64, 3, mollis_blob3_workspace_bytes mollis_blob3_step);
layouts!(line_f32, f32, 1, mollis_blob1_workspace_bytes_f32 mollis_blob1_step_f32);
layouts!(plane_f32, f32, 2, mollis_blob2_workspace_bytes_f32 mollis_blob2_step_f32);
layouts!(space_f32, f32, 3, mollis_blob3_workspace_bytes_f32 mollis_blob3_step_f32);

/// A mesh field of structures x y m . g g: the same gradients as from arrays without gaps.
#[test]
fn fields_on_a_mesh() {
    const N: usize = 50;
    const S: usize = 6;
    let mesh = mollis_mesh2 { lower: [0.0, 0.0], upper: [1.0, 1.0], cells: [8, 12] };
    let mut random = Split(9);
    let mut all = vec![CANARY; S * N];
    let x: Vec<[f64; 2]> = (0..N).map(|_| [random.uniform(), random.uniform()]).collect();
    let m: Vec<f64> = (0..N).map(|_| random.uniform() - 0.5).collect();
    for (k, (x, &m)) in x.iter().zip(&m).enumerate() {
        all[S * k..S * k + 3].copy_from_slice(&[x[0], x[1], m]);
    }
    let (mut bytes, mut want) = (0, vec![[0.0; 2]; N]);
    let none = null_mut();
    unsafe {
        assert_eq!(grid2_workspace_bytes(&raw const mesh, null(), null(), &raw mut bytes), 0);
        let mut memory = Aligned::new(bytes);
        let (points, to) = (x.as_ptr(), want.as_mut_ptr());
        #[rustfmt::skip]
        let code = grid2_eval(&raw const mesh, null(), N, points, m.as_ptr(), N, points, to, none, none, null_mut(), null_mut(),
            null_mut(), memory.pointer(), bytes, null());
        assert_eq!(code, 0);
        let start = all.as_mut_ptr();
        let mut sources = mollis_sources2 {
            n: N,
            positions: [start, null_mut()].map(|p: *mut f64| p.cast_const()),
            stride: S,
            masses: start.wrapping_add(2),
            mass_stride: S,
            radii: null(),
            radius_stride: 0,
            strengths: [null(); 2],
            strength_stride: 0,
        };
        let outputs = mollis_grid2_outputs {
            gradient: [start.wrapping_add(4), null_mut()],
            gradient_stride: S,
            node_mass: none,
            node_potential: none,
            node_gradient: null_mut(),
            total: null_mut(),
            outside: null_mut(),
        };
        let (mesh, outputs) = (&raw const mesh, &raw const outputs);
        assert_eq!(
            mollis_grid2_workspace_bytes(mesh, &raw const sources, null(), outputs, null(), null(), &raw mut bytes),
            0
        );
        let mut memory = vec![0_u8; bytes];
        let space = memory.as_mut_ptr().cast();
        assert_eq!(mollis_grid2_eval(mesh, &raw const sources, null(), outputs, null(), null(), space, bytes), 0);
        sources.radii = m.as_ptr();
        let code = mollis_grid2_eval(mesh, &raw const sources, null(), outputs, null(), null(), space, bytes);
        assert_eq!(code, Error::Unsupported as i32);
    }
    for (k, want) in want.iter().enumerate() {
        assert_eq!(all[S * k..S * k + S], [x[k][0], x[k][1], m[k], CANARY, want[0], want[1]]);
    }
}
