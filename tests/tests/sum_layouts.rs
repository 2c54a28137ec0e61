//! Sums of the C ABI over arrays of any layout: structures, columns, arrays of their own; results added and multiplied; core radii.

#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![expect(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_tests::Aligned;
use mollis_tests::sums::Sum;

const N: usize = 37;
const CANARY: f64 = 1234.5;

/// A particle of a host's: members in an order and of sizes of its own.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
struct Particle<T> {
    name: u64,
    x: [T; 3],
    potential: T,
    mass: T,
    acceleration: [T; 3],
    tide: [T; 9],
    radius: T,
    density: T,
    flags: [u32; 4],
}

macro_rules! layouts {
    ($name:ident, $t:ty, $d:literal, $sources:ident, $targets:ident, $outputs:ident; $bytes:ident $prepare:ident $size:ident $eval:ident) => {
        mod $name {
            use super::*;

            type Out = (Vec<$t>, Vec<[$t; $d]>, Vec<$t>, Vec<[[$t; $d]; $d]>);

            fn block(mollifier: mollis_mollifier) -> Aligned {
                let term = mollis_kernel_term {
                    kind: MOLLIS_KERNEL_NEWTONIAN,
                    reserved: 0,
                    coefficient: -1.0,
                    parameter: [0.0; 2],
                };
                let mut bytes = 0;
                unsafe {
                    assert_eq!($bytes(&raw const term, 1, null(), mollifier, &raw mut bytes), 0);
                    let mut block = Aligned::new(bytes);
                    assert_eq!($prepare(block.pointer(), bytes, &raw const term, 1, null(), mollifier, 0.25), 0);
                    block
                }
            }

            /// The status. The workspace is of the stated size and begins at an odd address, between canaries.
            fn call(block: &mut Aligned, sources: &$sources, targets: *const $targets, outputs: &$outputs) -> i32 {
                let (kernel, length) = (block.pointer().cast_const(), block.bytes().len());
                let mut bytes = 0;
                unsafe {
                    let sized = $size(kernel, length, sources, targets, outputs, null(), null(), &raw mut bytes);
                    if sized != 0 {
                        return sized;
                    }
                    let mut memory = vec![0xC5_u8; bytes + 256];
                    let start = memory.as_ptr().align_offset(64) + 65;
                    let space = memory[start..].as_mut_ptr().cast::<c_void>();
                    let code =
                        $eval(kernel, length, sources, targets, outputs, null(), null(), space, bytes, null_mut());
                    if code == 0 {
                        let short = bytes - 1;
                        let code =
                            $eval(kernel, length, sources, targets, outputs, null(), null(), space, short, null_mut());
                        assert_eq!(code, Error::WorkspaceTooSmall as i32);
                    }
                    assert!(memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xC5), "canaries");
                    code
                }
            }

            fn scene() -> Vec<Particle<$t>> {
                let number = |k: usize| (k as f64 * 1.37).sin() as $t;
                let particle = |k: usize| Particle {
                    name: k as u64,
                    x: std::array::from_fn(|d| number(3 * k + d)),
                    potential: 0.5,
                    mass: 0.3 + number(7 * k),
                    acceleration: [0.25, 0.5, 0.75],
                    tide: [0.125; 9],
                    radius: 0.2 + 0.1 * number(5 * k),
                    density: -1.0,
                    flags: [k as u32; 4],
                };
                (0..N).map(particle).collect()
            }

            fn dense_sources(x: &[[$t; $d]], m: &[$t], radii: Option<&[$t]>) -> $sources {
                let mut positions = [null(); $d];
                positions[0] = x.as_ptr().cast();
                let radii = radii.map_or(null(), |r| r.as_ptr());
                $sources {
                    n: x.len(),
                    positions,
                    stride: 0,
                    masses: m.as_ptr(),
                    mass_stride: 0,
                    radii,
                    radius_stride: 0,
                    strengths: [null(); $d],
                    strength_stride: 0,
                }
            }

            fn dense_outputs(out: &mut Out) -> $outputs {
                let mut gradient = [null_mut(); $d];
                gradient[0] = out.1.as_mut_ptr().cast();
                $outputs {
                    potential: out.0.as_mut_ptr(),
                    potential_stride: 0,
                    gradient,
                    gradient_stride: 0,
                    laplacian: out.2.as_mut_ptr(),
                    laplacian_stride: 0,
                    hessian: out.3.as_mut_ptr().cast(),
                    hessian_stride: 0,
                    factor: 0.0,
                    add: 0,
                    reserved: 0,
                }
            }

            fn empty() -> Out {
                let canary = CANARY as $t;
                (vec![canary; N], vec![[canary; $d]; N], vec![canary; N], vec![[[canary; $d]; $d]; N])
            }

            #[test]
            fn every_layout_gives_the_same_bits() {
                for mollifier in [
                    mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 2, exponent: 3 },
                    mollis_mollifier { kind: MOLLIS_MOLLIFIER_PLUMMER, order: 0, exponent: 0 },
                ] {
                    let block = &mut block(mollifier);
                    for with_radii in [false, true] {
                        let particles = scene();
                        let x: Vec<[$t; $d]> = particles.iter().map(|p| std::array::from_fn(|d| p.x[d])).collect();
                        let m: Vec<$t> = particles.iter().map(|p| p.mass).collect();
                        let r: Vec<$t> = particles.iter().map(|p| p.radius).collect();
                        let mut want = empty();
                        let sources = dense_sources(&x, &m, with_radii.then_some(&r));
                        assert_eq!(call(block, &sources, null(), &dense_outputs(&mut want)), 0);
                        assert!(
                            want.3
                                .as_flattened()
                                .as_flattened()
                                .iter()
                                .chain(&want.0)
                                .all(|v| v.is_finite() && *v != CANARY as $t)
                        );

                        // Columns [d][n], and arrays of their own.
                        let columns: [Vec<$t>; $d] = std::array::from_fn(|d| x.iter().map(|x| x[d]).collect());
                        let mut out = empty();
                        let mut slopes: [Vec<$t>; $d] = std::array::from_fn(|_| vec![CANARY as $t; N]);
                        let by_columns = $sources { positions: columns.each_ref().map(|c| c.as_ptr()), ..sources };
                        let to =
                            $outputs { gradient: slopes.each_mut().map(|c| c.as_mut_ptr()), ..dense_outputs(&mut out) };
                        assert_eq!(call(block, &by_columns, null(), &to), 0);
                        // In one dimension a column is an array of points.
                        let slopes: Vec<[$t; $d]> = (0..N).map(|i| std::array::from_fn(|d| slopes[d][i])).collect();
                        assert_eq!((&out.0, &slopes, &out.2, &out.3), (&want.0, &want.1, &want.2, &want.3));

                        // Structures, results among their members; targets are the sources by their own structure.
                        let mut structures = particles.clone();
                        let p = structures.as_mut_ptr();
                        let stride = size_of::<Particle<$t>>() / size_of::<$t>();
                        unsafe {
                            let mut positions = [null(); $d];
                            positions[0] = (&raw const (*p).x).cast::<$t>();
                            let radii = if with_radii { (&raw const (*p).radius).cast::<$t>() } else { null() };
                            let sources = $sources {
                                n: N,
                                positions,
                                stride,
                                masses: &raw const (*p).mass,
                                mass_stride: stride,
                                radii,
                                radius_stride: stride,
                                strengths: [null(); $d],
                                strength_stride: 0,
                            };
                            let targets = $targets { n: N, positions, stride, radii, radius_stride: stride };
                            let mut gradient = [null_mut(); $d];
                            gradient[0] = (&raw mut (*p).acceleration).cast::<$t>();
                            let outputs = $outputs {
                                potential: &raw mut (*p).potential,
                                potential_stride: stride,
                                gradient,
                                gradient_stride: stride,
                                laplacian: &raw mut (*p).density,
                                laplacian_stride: stride,
                                hessian: (&raw mut (*p).tide).cast::<$t>(),
                                hessian_stride: stride,
                                factor: 0.0,
                                add: 0,
                                reserved: 0,
                            };
                            assert_eq!(call(block, &sources, &raw const targets, &outputs), 0);
                            // Added twice more with a factor.
                            let more = $outputs { factor: -0.5, add: 1, ..outputs };
                            let before = structures.clone();
                            assert_eq!(call(block, &sources, null(), &more), 0);
                            for ((after, before), original) in structures.iter().zip(&before).zip(&particles) {
                                let i = original.name as usize;
                                let half = |x: $t| x + -0.5 * x;
                                let mut wanted = *original;
                                (wanted.potential, wanted.density) = (want.0[i], want.2[i]);
                                wanted.acceleration[..$d].copy_from_slice(&want.1[i]);
                                wanted.tide[..$d * $d].copy_from_slice(want.3[i].as_flattened());
                                assert_eq!(*before, wanted, "{mollifier:?}");
                                (wanted.potential, wanted.density) = (half(want.0[i]), half(want.2[i]));
                                wanted.acceleration.iter_mut().take($d).for_each(|a| *a = half(*a));
                                wanted.tide.iter_mut().take($d * $d).for_each(|a| *a = half(*a));
                                assert_eq!(*after, wanted, "{mollifier:?}");
                            }
                        }
                    }
                }
            }

            #[test]
            fn refusals() {
                let block = &mut block(mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 2, exponent: 3 });
                let particles = scene();
                let x: Vec<[$t; $d]> = particles.iter().map(|p| std::array::from_fn(|d| p.x[d])).collect();
                let m: Vec<$t> = particles.iter().map(|p| p.mass).collect();
                let mut out = empty();
                let (good, to) = (dense_sources(&x, &m, None), dense_outputs(&mut out));
                let one = [1.0 as $t; N];
                let with = |at: usize, value: f64| {
                    let mut radii = one;
                    radii[at] = value as $t;
                    radii
                };
                let (zero, negative, nan) = (with(3, 0.0), with(N - 1, -1.0), with(5, f64::NAN));
                let radii = |r: &[$t; N]| $sources { radii: r.as_ptr(), ..good };
                let cases: &[(&str, $sources, $outputs, Error)] = &[
                    ("radius 0", radii(&zero), to, Error::Delta),
                    ("radius below 0", radii(&negative), to, Error::Delta),
                    ("radius NaN", radii(&nan), to, Error::NotFinite),
                    ("add 2", good, $outputs { add: 2, ..to }, Error::UnknownValue),
                    ("factor NaN", good, $outputs { factor: f64::NAN, ..to }, Error::NotFinite),
                    // The coordinates of one point would be those of the next. (On the line there is one.)
                    (
                        "points within each other",
                        $sources { stride: if $d > 1 { 1 } else { usize::MAX / 16 }, ..good },
                        to,
                        if $d > 1 { Error::OutOfDomain } else { Error::TooLarge },
                    ),
                    ("stride beyond memory", $sources { stride: usize::MAX / 16, ..good }, to, Error::TooLarge),
                    ("masses beyond memory", $sources { mass_stride: usize::MAX / 32, ..good }, to, Error::TooLarge),
                    ("outputs overlap", good, $outputs { laplacian: to.potential, ..to }, Error::Overlap),
                    ("an output with itself", good, $outputs { gradient: [to.potential; $d], ..to }, Error::Overlap),
                    ("matrices on values", good, $outputs { hessian: to.laplacian, ..to }, Error::Overlap),
                    (
                        "matrices beyond memory",
                        good,
                        $outputs { hessian_stride: usize::MAX / 32, ..to },
                        Error::TooLarge,
                    ),
                    ("output in input", good, $outputs { potential: good.masses.cast_mut(), ..to }, Error::Overlap),
                    ("no positions", $sources { positions: [null(); $d], ..good }, to, Error::NullPointer),
                ];
                for (what, sources, outputs, error) in cases {
                    assert_eq!(call(block, sources, null(), outputs), *error as i32, "{what}");
                    assert_eq!(out, empty(), "{what} wrote");
                }
                unsafe {
                    let (kernel, length, mut bytes) = (block.pointer().cast_const(), block.bytes().len(), 77);
                    for (sources, outputs) in [(null(), &raw const to), (&raw const good, null())] {
                        let sized = $size(kernel, length, sources, null(), outputs, null(), null(), &raw mut bytes);
                        assert_eq!((sized, bytes), (Error::NullPointer as i32, 77));
                    }
                }
                // The index of a radius that is not finite.
                let mut run = std::mem::MaybeUninit::<mollis_run>::uninit();
                let mut first = 0;
                unsafe {
                    assert_eq!(mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()), 0);
                    let run = mollis_run { first_bad: &raw mut first, ..run.assume_init() };
                    let (kernel, length, mut bytes) = (block.pointer().cast_const(), block.bytes().len(), 0);
                    let (sources, none) = (radii(&nan), null_mut());
                    let sized = $size(
                        kernel,
                        length,
                        &raw const sources,
                        null(),
                        &raw const to,
                        null(),
                        &raw const run,
                        &raw mut bytes,
                    );
                    assert_eq!(sized, 0);
                    let mut space = Aligned::new(bytes);
                    let code = $eval(
                        kernel,
                        length,
                        &raw const sources,
                        null(),
                        &raw const to,
                        null(),
                        &raw const run,
                        space.pointer(),
                        bytes,
                        none,
                    );
                    assert_eq!((code, first), (Error::NotFinite as i32, 5));
                }
            }
        }
    };
}

layouts!(line, f64, 1, mollis_sources1, mollis_targets1, mollis_outputs1;
    mollis_kernel1_bytes mollis_kernel1_prepare mollis_field1_workspace_bytes mollis_field1_eval);
layouts!(plane, f64, 2, mollis_sources2, mollis_targets2, mollis_outputs2;
    mollis_kernel2_bytes mollis_kernel2_prepare mollis_field2_workspace_bytes mollis_field2_eval);
layouts!(space, f64, 3, mollis_sources3, mollis_targets3, mollis_outputs3;
    mollis_kernel3_bytes mollis_kernel3_prepare mollis_field3_workspace_bytes mollis_field3_eval);
layouts!(line_f32, f32, 1, mollis_sources1_f32, mollis_targets1_f32, mollis_outputs1_f32;
    mollis_kernel1_bytes_f32 mollis_kernel1_prepare_f32 mollis_field1_workspace_bytes_f32 mollis_field1_eval_f32);
layouts!(plane_f32, f32, 2, mollis_sources2_f32, mollis_targets2_f32, mollis_outputs2_f32;
    mollis_kernel2_bytes_f32 mollis_kernel2_prepare_f32 mollis_field2_workspace_bytes_f32 mollis_field2_eval_f32);
layouts!(space_f32, f32, 3, mollis_sources3_f32, mollis_targets3_f32, mollis_outputs3_f32;
    mollis_kernel3_bytes_f32 mollis_kernel3_prepare_f32 mollis_field3_workspace_bytes_f32 mollis_field3_eval_f32);

/// Every structure of a dimension and scalar has the layout of the one behind it.
#[test]
fn structures_have_the_layout_of_the_generic_ones() {
    fn same<A, B>() {
        assert_eq!((size_of::<A>(), align_of::<A>()), (size_of::<B>(), align_of::<B>()));
    }
    same::<mollis_sources1, SourcesOf<f64, 1>>();
    same::<mollis_sources3_f32, SourcesOf<f32, 3>>();
    same::<mollis_targets2, TargetsOf<f64, 2>>();
    same::<mollis_outputs3, OutputsOf<f64, 3>>();
    same::<mollis_outputs2_f32, OutputsOf<f32, 2>>();
    assert_eq!(
        std::mem::offset_of!(mollis_sources2, radius_stride),
        std::mem::offset_of!(SourcesOf<f64, 2>, radius_stride)
    );
    assert_eq!(std::mem::offset_of!(mollis_outputs2, factor), std::mem::offset_of!(OutputsOf<f64, 2>, factor));
}

/// Results that are members of one array of structures may not share a number, and need not be apart as blocks.
#[test]
fn members_of_structures_are_apart() {
    let term =
        mollis_kernel_term { kind: MOLLIS_KERNEL_NEWTONIAN, reserved: 0, coefficient: -1.0, parameter: [0.0; 2] };
    let mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 2, exponent: 3 };
    let (mut kernel_bytes, mut bytes) = (0, 0);
    let mut memory = [0.0_f64; 72];
    unsafe {
        assert_eq!(mollis_kernel2_bytes(&raw const term, 1, null(), mollifier, &raw mut kernel_bytes), 0);
        let mut kernel = Aligned::new(kernel_bytes);
        let prepared =
            mollis_kernel2_prepare(kernel.pointer(), kernel_bytes, &raw const term, 1, null(), mollifier, 0.25);
        assert_eq!(prepared, 0);
        // Whether the potential at one place and the Laplacian at another, `(first, stride)`, are accepted for n points.
        let mut accepted = |n: usize, a: (usize, usize), b: (usize, usize)| {
            let x: Vec<[f64; 2]> = (0..n).map(|k| [k as f64, 0.5]).collect();
            let m = vec![1.0; n];
            let p = memory.as_mut_ptr();
            let mut sum = Sum::new((n, x.as_ptr(), m.as_ptr()), (n, x.as_ptr()), (p.add(a.0), null_mut(), p.add(b.0)));
            (sum.outputs.potential_stride, sum.outputs.laplacian_stride) = (a.1, b.1);
            let (sources, outputs) = (sum.sources(), sum.outputs());
            let (at, block) = (kernel.pointer().cast_const(), kernel_bytes);
            let sized =
                mollis_field2_workspace_bytes(at, block, sources, null(), outputs, null(), null(), &raw mut bytes);
            assert_eq!(sized, 0);
            let mut space = Aligned::new(bytes);
            let (space, none) = (space.pointer(), null_mut());
            match mollis_field2_eval(at, block, sources, null(), outputs, null(), null(), space, bytes, none) {
                0 => true,
                code => {
                    assert_eq!(code, Error::Overlap as i32);
                    false
                }
            }
        };
        // Five structures of twelve numbers: members 0, 3, 11.
        let members = [(0, 12), (3, 12), (11, 12)];
        for (i, &a) in members.iter().enumerate() {
            for (j, &b) in members.iter().enumerate() {
                assert_eq!(accepted(5, a, b), i != j, "{a:?} {b:?}");
            }
        }
        // The same member from another structure on, a member of another stride, and a solid array.
        for other in [(12, 12), (3, 3), (8, 1)] {
            assert!(!accepted(5, (0, 12), other) && !accepted(5, other, (0, 12)), "{other:?}");
        }
        // Solid arrays behind the last structure and between two of them.
        assert!(accepted(5, (0, 12), (49, 1)) && accepted(5, (1, 1), (12, 12)));
        // A single member of one structure: a stride means nothing.
        assert!(accepted(1, (0, 12), (12, 1)) && !accepted(1, (24, 7), (24, 1)));
        assert!(accepted(0, (0, 12), (0, 12)));
    }
}
