//! Sources that are essential for boxes of targets, against all sources: sums over all pairs at targets in the box. Also through the C ABI.
//!
//! Errors are in the l2 norm over the targets of a box, relative to that of sum_j |m_j| |K_j|, for potentials and gradients.

#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![expect(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::exec::{Run, Serial};
use mollis_core::field::{Essential, Interaction, PROXY, Sources, essential, essential_bytes};
use mollis_core::kernel::{Kernel, Law};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::simd::Level;
use mollis_core::{Error, Real, Result};
use mollis_tests::{Aligned, Split};

use crate::tree::{POINTS, Points, kernels, masses, points, term, with_kernel};

const COMPACT: Mollifier = Mollifier::Compact { order: 4, exponent: 4 };

type Box<T, const D: usize> = [[T; D]; 2];

/// What comes out for some boxes.
#[derive(Clone, Debug, PartialEq)]
struct Found<T, const D: usize> {
    starts: Vec<u64>,
    positions: Vec<[T; D]>,
    masses: Vec<T>,
    origins: Vec<u64>,
}

/// Calls in a workspace of the stated size, between canaries, with so much room.
fn find<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    sources: Sources<'_, T, D>,
    tolerance: f64,
    boxes: &[Box<T, D>],
    room: usize,
) -> Result<Found<T, D>> {
    let n = sources.positions.len();
    let bytes = essential_bytes(kernel, n, tolerance)?;
    let mut memory = Aligned::new(bytes + 64);
    let mut found = Found {
        starts: vec![7; boxes.len() + 1],
        positions: vec![[T::from_f64(7.0); D]; room],
        masses: vec![T::from_f64(7.0); room],
        origins: vec![7; room],
    };

    let mut call = |bytes: usize, found: &mut Found<T, D>| {
        let mut run = Run { level: Level::best(), executor: &Serial, ..Run::default() };
        let to =
            Essential { positions: &mut found.positions, masses: &mut found.masses, origins: Some(&mut found.origins) };
        let workspace = &mut memory.bytes()[..bytes];
        essential(kernel, sources, tolerance, boxes, (&mut found.starts, Some(to)), workspace, &mut run)
    };
    let before = found.clone();
    assert_eq!(call(bytes - 1, &mut found), Err(Error::WorkspaceTooSmall));
    assert_eq!(found, before);
    let result = call(bytes, &mut found);
    assert!(memory.bytes()[bytes..].iter().all(|&byte| byte == 0xA5), "written beyond the workspace");
    if result == Err(Error::NoRoom) {
        let whole = found.starts[boxes.len()] as usize;
        assert!(whole > room);
        return result.map(|()| found);
    }
    result?;
    found.positions.truncate(found.starts[boxes.len()] as usize);
    found.masses.truncate(found.positions.len());
    found.origins.truncate(found.positions.len());
    Ok(found)
}

/// Potential and gradient of sources at a target, in double precision, and sums of absolute values.
fn sums<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    (positions, masses): (&[[T; D]], &[T]),
    x: [T; D],
) -> ([f64; 4], [f64; 2]) {
    let (mut sums, mut sizes) = ([0.0; 4], [0.0; 2]);
    for (y, m) in positions.iter().zip(masses) {
        let step: [f64; D] = std::array::from_fn(|k| x[k].to_f64() - y[k].to_f64());
        let r = step.iter().map(|s| s * s).sum::<f64>().sqrt();
        let (value, factor) = (kernel.value(T::from_f64(r)).to_f64(), kernel.gradient_factor(T::from_f64(r)).to_f64());
        sums[0] += m.to_f64() * value;
        step.iter().zip(&mut sums[1..]).for_each(|(s, to)| *to += m.to_f64() * factor * s);
        sizes[0] += (m.to_f64() * value).abs();
        sizes[1] += (m.to_f64() * factor * r).abs();
    }
    (sums, sizes)
}

/// The errors of potential and gradient of found sources at targets in a box.
fn errors<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    all: (&[[T; D]], &[T]),
    some: (&[[T; D]], &[T]),
    corners: Box<T, D>,
) -> [f64; 2] {
    let mut numbers = Split(11);
    let (mut errors, mut sizes) = ([0.0; 2], [0.0; 2]);
    for k in 0..12 {
        // The corners, the faces, and points inside.
        let x: [T; D] = std::array::from_fn(|axis| {
            let [lower, upper] = [corners[0][axis].to_f64(), corners[1][axis].to_f64()];
            let part = if k < 8 { f64::from(k >> axis & 1) } else { numbers.uniform() };
            T::from_f64(lower + part * (upper - lower))
        });
        let (want, size) = sums(kernel, all, x);
        let (got, _) = sums(kernel, some, x);
        errors[0] += (want[0] - got[0]).powi(2);
        errors[1] += want[1..].iter().zip(&got[1..]).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        sizes.iter_mut().zip(size).for_each(|(to, size)| *to += size * size);
    }
    // Where nothing is felt, nothing may come.
    [0, 1].map(|k| if sizes[k] > 0.0 { (errors[k] / sizes[k]).sqrt() } else { errors[k].sqrt() })
}

/// Boxes beside, away from, diagonal to and around data in about the unit cube; without targets; a point.
fn boxes<T: Real, const D: usize>() -> Vec<Box<T, D>> {
    let cube = |lower: [f64; 2], upper: [f64; 2]| {
        let corner = |x: [f64; 2]| std::array::from_fn(|axis| T::from_f64(x[usize::from(axis > 0)]));
        [corner(lower), corner(upper)]
    };
    vec![
        cube([1.0, 0.0], [1.5, 1.0]),
        cube([-0.3, -0.4], [0.25, 1.1]),
        cube([7.0, -3.0], [9.0, 2.0]),
        cube([1.0, 1.0], [1.5, 1.5]),
        cube([-1.0, -1.0], [3.0, 3.0]),
        cube([1.0, 0.0], [0.5, 1.0]),
        cube([400.0, 0.3], [400.0, 0.3]),
    ]
}

fn holds<T: Real, const D: usize>(tolerances: &[f64], n: usize) -> f64 {
    let (boxes, mut worst) = (boxes::<T, D>(), 0.0_f64);
    for (number, terms) in kernels().into_iter().enumerate() {
        for (mollifier, delta) in [(COMPACT, 0.05), (Mollifier::Plummer, 0.02), (Mollifier::None, 1.0)] {
            if mollifier == Mollifier::Plummer && terms.len() + usize::from(terms[0].law != Law::Newtonian) > 1 {
                continue;
            }
            with_kernel::<T, D, _>(&terms, (mollifier, delta), |kernel| {
                // Each kind of points under some kernels, each kernel with three kinds.
                for kind in POINTS.into_iter().skip(number % 2).step_by(2) {
                    let (x, m) = (points::<T, D>(kind, n, 3), masses::<T>(n, kind == Points::Normal));
                    for &tolerance in tolerances {
                        let found = find(kernel, Sources::new(&x, &m), tolerance, &boxes, 7 * n).unwrap();
                        for (k, &corners) in boxes.iter().enumerate() {
                            let part = found.starts[k] as usize..found.starts[k + 1] as usize;
                            assert!(part.len() <= n);
                            for i in part.clone().filter(|&i| found.origins[i] != PROXY) {
                                let origin = found.origins[i] as usize;
                                assert_eq!((found.positions[i], found.masses[i]), (x[origin], m[origin]));
                            }
                            if corners[0][0] > corners[1][0] {
                                assert_eq!(part.len(), 0, "a box without targets");
                                continue;
                            }
                            let some = (&found.positions[part.clone()], &found.masses[part.clone()]);
                            let got = errors(kernel, (&x, &m), some, corners);
                            let floor = if T::DIGITS > 24 { 1e-14 } else { 1e-6 };
                            for error in got {
                                assert!(
                                    error <= tolerance + floor,
                                    "{terms:?} {mollifier:?} {kind:?} box {k} {tolerance:e}: {got:?} with {}",
                                    part.len()
                                );
                                worst = worst.max((error - floor) / tolerance);
                            }
                        }
                    }
                }
            });
        }
    }
    worst
}

#[test]
fn essential_sources_act_as_all_do() {
    println!("line {:.3}", holds::<f64, 1>(&[1e-3, 1e-12], 300));
    println!("plane {:.3}", holds::<f64, 2>(&[1e-5, 1e-12], 300));
    println!("space {:.3}", holds::<f64, 3>(&[1e-3, 1e-6], 300));
    println!("single {:.3} {:.3}", holds::<f32, 2>(&[1e-3, 1e-5], 300), holds::<f32, 3>(&[1e-3], 300));
}

/// Away from the sources their number does not matter; beside them what matters are those near the border.
#[test]
fn few_are_essential() {
    let blob = Blob::<f64, 2>::new(COMPACT, 1e-3).unwrap();
    let mut last = [0; 2];
    for (k, n) in [4_000, 16_000, 64_000].into_iter().enumerate() {
        let (x, m) = (points::<f64, 2>(Points::Uniform, n, 3), masses::<f64>(n, false));
        let there = [[[3.0, 0.0], [4.0, 1.0]], [[1.0, 0.0], [2.0, 1.0]]];
        let found = find(&blob, Sources::new(&x, &m), 1e-6, &there, 2 * n).unwrap();
        let counts = [found.starts[1] as usize, (found.starts[2] - found.starts[1]) as usize];
        assert!(counts[0] <= 200, "{n}: {counts:?}");
        assert!(counts[1] < n / 2, "{n}: {counts:?}");
        // Twice as many along the border, not four times.
        assert!(k == 0 || counts[1] < 3 * last[1], "{n}: {counts:?} {last:?}");
        last = counts;
    }
}

#[test]
fn room_and_massless_sources_change_nothing() {
    let n = 3_000;
    let (x, m) = (points::<f64, 2>(Points::Normal, n, 9), masses::<f64>(n, true));
    let blob = Blob::<f64, 2>::new(COMPACT, 0.01).unwrap();
    let boxes = boxes::<f64, 2>();
    let whole = find(&blob, Sources::new(&x, &m), 1e-5, &boxes, 7 * n).unwrap();
    let count = whole.positions.len();
    assert_eq!(find(&blob, Sources::new(&x, &m), 1e-5, &boxes, count).unwrap(), whole);
    assert_eq!(find(&blob, Sources::new(&x, &m), 1e-5, &boxes, count - 1).err(), Some(Error::NoRoom));
    // Only numbers are asked for.
    let mut starts = vec![7; boxes.len() + 1];
    let mut memory = Aligned::new(essential_bytes(&blob, n, 1e-5).unwrap());
    let mut run = Run { level: Level::Portable, executor: &Serial, ..Run::default() };
    let sources = Sources::new(&x, &m);
    essential(&blob, sources, 1e-5, &boxes, (&mut starts, None), memory.bytes(), &mut run).unwrap();
    assert_eq!(starts, whole.starts);
    // Sources without mass are left out, wherever they are.
    let (mut more_x, mut more_m) = (vec![[1e9, 0.0]], vec![0.0]);
    more_x.extend(&x);
    more_m.extend(&m);
    let other = find(&blob, Sources::new(&more_x, &more_m), 1e-5, &boxes, 7 * n).unwrap();
    let kept = |found: &Found<f64, 2>| found.origins.iter().filter(|&&o| o != PROXY).count();
    assert!(kept(&other) <= n * boxes.len() && !other.origins.contains(&0));
    // None at all.
    let none = find(&blob, Sources::new(&[], &[]), 1e-5, &boxes, 0).unwrap();
    assert_eq!(none.starts, vec![0; boxes.len() + 1]);
    // All in one place.
    let (same, one) = (vec![[0.25, 0.5]; 500], vec![1.0; 500]);
    let found = find(&blob, Sources::new(&same, &one), 1e-5, &boxes, 4_000).unwrap();
    let total: f64 = found.masses[..found.starts[1] as usize].iter().sum();
    assert!((total - 500.0).abs() < 1e-9);
}

/// Sources whose cores reach the box are kept; lengths of any size.
#[test]
fn cores_and_units() {
    let n = 2_000;
    let (x, m) = (points::<f64, 2>(Points::Uniform, n, 4), masses::<f64>(n, false));
    let blob = Blob::<f64, 2>::new(COMPACT, 1e-3).unwrap();
    let corners = [[[1.5, 0.0], [2.0, 1.0]]];
    let mut radii = vec![1e-3; n];
    let few = find(&blob, Sources::new(&x, &m).with_radii(&radii), 1e-6, &corners, n).unwrap();
    radii[17] = 3.0;
    let all = find(&blob, Sources::new(&x, &m).with_radii(&radii), 1e-6, &corners, n).unwrap();
    assert!(few.positions.len() < n / 2);
    assert!(all.positions.len() == n && !all.origins.contains(&PROXY));
    for exponent in [-900, -300, 300, 900] {
        let unit = 2_f64.powi(exponent);
        let scaled: Vec<_> = x.iter().map(|x| x.map(|x| x * unit)).collect();
        let corners = corners.map(|c| c.map(|c| c.map(|x| x * unit)));
        let blob = Blob::<f64, 2>::new(COMPACT, 1e-3 * unit).unwrap();
        let found = find(&blob, Sources::new(&scaled, &m), 1e-6, &corners, n).unwrap();
        let back: Vec<_> = found.positions.iter().map(|x| x.map(|x| x / unit)).collect();
        let same = (&found.masses, &found.starts, &back) == (&few.masses, &few.starts, &few.positions);
        assert!(same, "2^{exponent}: {:?} {:?}", found.starts, few.starts);
    }
}

struct Rough;

impl Interaction<f64, 2> for Rough {
    fn value(&self, _: f64) -> f64 {
        0.0
    }
    fn gradient_factor(&self, _: f64) -> f64 {
        0.0
    }
    fn laplacian(&self, _: f64) -> f64 {
        0.0
    }
    fn is_singular(&self) -> bool {
        false
    }
}

#[test]
fn refusals_write_nothing() {
    let (x, m) = (vec![[0.0, 0.0], [1.0, 0.5]], vec![1.0, 2.0]);
    let blob = Blob::<f64, 2>::new(COMPACT, 0.1).unwrap();
    let plummer = Blob::<f64, 2>::new(Mollifier::Plummer, 0.1).unwrap();
    let corners = [[[4.0, 0.0], [5.0, 1.0]]];
    let (bad_x, bad_m, bad_corners) = ([[f64::NAN, 0.0]; 2], [1.0, f64::INFINITY], [[[f64::NAN, 0.0], [1.0; 2]]]);
    let good = Sources::new(&x, &m);
    let one = |kernel: &dyn Interaction<f64, 2>, sources, tolerance, corners: &[Box<f64, 2>]| {
        let mut starts = vec![7; corners.len() + 1];
        let mut memory = Aligned::new(1 << 20);
        let mut run = Run { level: Level::best(), executor: &Serial, ..Run::default() };
        let result = essential(kernel, sources, tolerance, corners, (&mut starts, None), memory.bytes(), &mut run);
        assert!(result.is_ok() || starts.iter().all(|&s| s == 7));
        result
    };
    assert_eq!(one(&blob, good, 1e-6, &corners), Ok(()));
    assert_eq!(one(&blob, good, 1e-6, &[]), Ok(()));
    for (tolerance, error) in [
        (0.0, Error::OutOfDomain),
        (-1.0, Error::OutOfDomain),
        (1e-13, Error::OutOfDomain),
        (f64::NAN, Error::NotFinite),
    ] {
        assert_eq!(one(&blob, good, tolerance, &corners), Err(error));
        assert_eq!(essential_bytes(&blob, 2, tolerance), Err(error));
    }
    assert_eq!(one(&Rough, good, 1e-6, &corners), Err(Error::Unsupported));
    assert_eq!(one(&blob, Sources::new(&bad_x, &m), 1e-6, &corners), Err(Error::NotFinite));
    assert_eq!(one(&blob, Sources::new(&x, &bad_m), 1e-6, &corners), Err(Error::NotFinite));
    assert_eq!(one(&blob, good, 1e-6, &bad_corners), Err(Error::NotFinite));
    assert_eq!(one(&blob, Sources::new(&x, &m[..1]), 1e-6, &corners), Err(Error::LengthMismatch));
    assert_eq!(one(&blob, good.with_radii(&[1.0, -1.0]), 1e-6, &corners), Err(Error::Delta));
    assert_eq!(one(&blob, good.with_radii(&[1.0, f64::NAN]), 1e-6, &corners), Err(Error::NotFinite));
    assert_eq!(one(&plummer, good.with_radii(&[1.0, 1.0]), 1e-6, &corners), Err(Error::Unsupported));
    with_kernel::<f64, 2, _>(&[term(Law::Power { exponent: 1.5 }, 1.0)], (COMPACT, 0.1), |kernel| {
        assert_eq!(one(kernel, good, 1e-6, &corners), Ok(()));
        assert_eq!(one(kernel, good.with_radii(&[1.0, 1.0]), 1e-6, &corners), Err(Error::Unsupported));
    });
    assert_eq!(one(&blob, Sources { strengths: Some(&x), ..good }, 1e-6, &corners), Err(Error::Unsupported));
}

/// A particle of a host's.
#[repr(C)]
#[derive(Clone, Copy)]
struct Particle {
    name: u64,
    x: [f64; 2],
    mass: f64,
}

/// The same through the C ABI, from an array of structures.
#[test]
fn through_the_c_interface() {
    let n = 1_500;
    let (x, m) = (points::<f64, 2>(Points::Normal, n, 3), masses::<f64>(n, true));
    let terms = [term(Law::Exponential { length: 0.3 }, 1.0)];
    let c_term =
        mollis_kernel_term { kind: MOLLIS_KERNEL_EXPONENTIAL, reserved: 0, coefficient: 1.0, parameter: [0.3, 0.0] };
    let mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 4, exponent: 4 };
    let boxes = boxes::<f64, 2>();
    let want = with_kernel::<f64, 2, _>(&terms, (COMPACT, 0.05), |kernel: &Kernel<'_, f64, 2>| {
        find(kernel, Sources::new(&x, &m), 1e-6, &boxes, 7 * n).unwrap()
    });
    let particles: Vec<_> = (0..n).map(|k| Particle { name: k as u64, x: x[k], mass: m[k] }).collect();
    let (mut kernel_bytes, mut bytes) = (0, 0);
    unsafe {
        assert_eq!(mollis_kernel2_bytes(&raw const c_term, 1, null(), mollifier, &raw mut kernel_bytes), 0);
        let mut kernel = Aligned::new(kernel_bytes);
        let block = kernel.pointer();
        assert_eq!(mollis_kernel2_prepare(block, kernel_bytes, &raw const c_term, 1, null(), mollifier, 0.05), 0);
        let block = block.cast_const();
        let first = &particles[0];
        let stride = size_of::<Particle>() / size_of::<f64>();
        let mut sources: mollis_sources2 = std::mem::zeroed();
        sources.n = n;
        sources.positions[0] = first.x.as_ptr();
        sources.stride = stride;
        sources.masses = &raw const first.mass;
        sources.mass_stride = stride;
        let asked = mollis_field2_essential_bytes(block, kernel_bytes, &raw const sources, 1e-6, &raw mut bytes);
        assert_eq!(asked, 0);
        let mut space = Aligned::new(bytes);
        let mut starts = vec![7_u64; boxes.len() + 1];
        let mut to = (vec![[7.0; 2]; 7 * n], vec![7.0; 7 * n], vec![7_u64; 7 * n]);
        let corners = boxes.as_ptr();
        let mut call = |n_boxes: usize, tolerance: f64, room: usize, bytes: usize, starts: *mut u64| {
            mollis_field2_essential(
                block,
                kernel_bytes,
                &raw const sources,
                tolerance,
                n_boxes,
                corners,
                starts,
                room,
                to.0.as_mut_ptr(),
                to.1.as_mut_ptr(),
                to.2.as_mut_ptr(),
                null(),
                space.pointer(),
                bytes,
            )
        };
        let all = boxes.len();
        let at = starts.as_mut_ptr();
        assert_eq!(call(all, 1e-6, 7 * n, bytes - 1, at), Error::WorkspaceTooSmall as i32);
        assert_eq!(call(all, 1e-6, 7 * n, bytes, null_mut()), Error::NullPointer as i32);
        assert_eq!(call(all, 1e-6, 7 * n, bytes, at.byte_add(4)), Error::Misaligned as i32);
        assert_eq!(call(all, 0.0, 7 * n, bytes, at), Error::OutOfDomain as i32);
        assert_eq!(starts, vec![7; all + 1]);
        assert_eq!(call(all, 1e-6, 10, bytes, starts.as_mut_ptr()), Error::NoRoom as i32);
        assert_eq!(starts, want.starts);
        assert_eq!(call(all, 1e-6, 7 * n, bytes, starts.as_mut_ptr()), 0);
        let count = starts[all] as usize;
        assert_eq!(starts, want.starts);
        assert_eq!((&to.0[..count], &to.1[..count], &to.2[..count]), (&*want.positions, &*want.masses, &*want.origins));
        assert!(to.2[count..].iter().all(|&o| o == 7));
        // Only numbers are asked for.
        starts.fill(7);
        let none = null_mut();
        #[rustfmt::skip]
        let code = mollis_field2_essential(block, kernel_bytes, &raw const sources, 1e-6, all, corners, starts.as_mut_ptr(), 0,
            null_mut(), none, null_mut(), null(), space.pointer(), bytes);
        assert_eq!((code, &starts), (0, &want.starts));
        // The same array as input and output.
        #[rustfmt::skip]
        let code = mollis_field2_essential(block, kernel_bytes, &raw const sources, 1e-6, 1, corners, starts.as_mut_ptr(), 1,
            x.as_ptr().cast_mut(), starts.as_mut_ptr().cast(), null_mut(), null(), space.pointer(), bytes);
        assert_eq!(code, Error::Overlap as i32);
    }
    assert_eq!(particles[n - 1].name, n as u64 - 1);
}
