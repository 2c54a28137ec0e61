//! Stable steps of singular kernels through the C ABI: they behave as documented.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::f64::consts::PI;
use std::ffi::c_void;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_tests::Aligned;

const NONE: mollis_mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_NONE, order: 0, exponent: 0 };
const REFUSED: i32 = Error::NotFinite as i32;
/// The end of the stability interval.
const END: f64 = 2.785_293_563;

fn term(kind: i32, coefficient: f64, parameter: f64) -> mollis_kernel_term {
    mollis_kernel_term { kind, reserved: 0, coefficient, parameter: [parameter, 0.0] }
}

/// A smooth kernel of the host. The library cannot know that it is smooth.
unsafe extern "C" fn smooth(dimension: *mut c_void, r: f64, out: *mut f64) -> mollis_status {
    unsafe { out.cast::<[f64; 3]>().write([0.5 * r * r, 1.0, dimension.addr() as f64]) };
    0
}

macro_rules! check {
    ($name:ident, $t:ty, $d:literal, $close:expr; $bytes:ident() $prepare:ident() $step:ident() $anywhere:ident()) => {
        #[test]
        fn $name() {
            let host = mollis_radial_kernel {
                context: std::ptr::without_provenance_mut($d),
                evaluate: Some(smooth),
                coefficient: 1.0,
                reach: 100.0,
                tolerance: 0.0,
                least: 0.0,
                n_knots: 0,
                knots: null(),
                errors: null_mut(),
            };
            let prepared = |terms: &[mollis_kernel_term], host: *const mollis_radial_kernel| unsafe {
                let mut bytes = 0;
                assert_eq!($bytes(terms.as_ptr(), terms.len(), host, NONE, &raw mut bytes), 0);
                let mut block = Aligned::new(bytes);
                assert_eq!($prepare(block.pointer(), bytes, terms.as_ptr(), terms.len(), host, NONE, 1.0), 0);
                (block, bytes)
            };
            let point = |x: f64| -> [$t; $d] { std::array::from_fn(|k| if k == 0 { x as $t } else { 0.0 }) };
            let (far, same) = ([point(0.0), point(2.0)], [point(1.0), point(1.0)]);
            // Three particles, so that the refused pair is one among others.
            let close = [point(5.0), point(0.0), point($close)];
            let step = |(block, bytes): &mut (Aligned, usize), x: &[[$t; $d]]| {
                let (m, mut step) = ([0.5 as $t; 3], -7.0 as $t);
                let status = unsafe { $step(block.pointer(), *bytes, x.len(), x.as_ptr(), m.as_ptr(), &raw mut step) };
                assert_eq!(status == 0, step != -7.0, "written if and only if it succeeds");
                (status, step)
            };
            let anywhere = |(block, bytes): &mut (Aligned, usize)| {
                let mut step = -7.0 as $t;
                let status = unsafe { $anywhere(block.pointer(), *bytes, 1.0, 3.0, &raw mut step) };
                assert_eq!(status == 0, step != -7.0, "written if and only if it succeeds");
                (status, step)
            };
            let newtonian = term(MOLLIS_KERNEL_NEWTONIAN, 1.0, 0.0);
            let power = |p: f64| term(MOLLIS_KERNEL_POWER, 1.0, p);
            let singular = [
                newtonian,
                power(0.5),
                power(1.5),
                power(1.99),
                term(MOLLIS_KERNEL_EXPONENTIAL, 1.0, 1.0),
                term(MOLLIS_KERNEL_SCREENED, 1.0, 1.0),
            ];
            for other in singular {
                for terms in [vec![other], vec![power(4.0), other]] {
                    let mut kernel = prepared(&terms, null());
                    assert_eq!(anywhere(&mut kernel).0, REFUSED, "{terms:?}");
                    assert_eq!(step(&mut kernel, &same).0, REFUSED, "{terms:?}");
                    assert_eq!(step(&mut kernel, &far).0, 0, "{terms:?}");
                }
            }
            // Second derivatives at the close pair are out of range. In one dimension those of |x| vanish away from 0.
            if $d > 1 {
                assert_eq!(step(&mut prepared(&[newtonian], null()), &close).0, REFUSED);
            }
            assert_eq!(step(&mut prepared(&[power(0.5)], null()), &close).0, REFUSED);
            assert_eq!(anywhere(&mut prepared(&[], &raw const host)).0, REFUSED);
            // Powers with p >= 2 have a stable step: the Hessian of |x|^2/2 is the identity, also at 0. The bound is 2 |m| for
            // velocities and d (|m| + |m|) for densities.
            let mut kernel = prepared(&[power(2.0)], null());
            let per_density = |mass: f64| END / (mass * f64::max(2.0, $d as f64));
            for x in [&far, &same] {
                let (status, got) = step(&mut kernel, x);
                assert!(status == 0 && (f64::from(got) / per_density(0.5) - 1.0).abs() < 1e-6, "{got}");
            }
            let (status, got) = anywhere(&mut kernel);
            assert!(status == 0 && (f64::from(got) / per_density(1.0) - 1.0).abs() < 1e-6, "{got}");
            // |x|^4/4: the Hessian is 3 r^2 along and r^2 across. At the diameter 3 its norm is 27; the trace (d + 2) 9 is at most twice that.
            let (status, got) = anywhere(&mut prepared(&[power(4.0)], null()));
            assert!(status == 0 && (f64::from(got) / (END / 54.0) - 1.0).abs() < 1e-6, "{got}");
        }
    };
}

check!(line_f64, f64, 1, 1e-250; mollis_kernel1_bytes() mollis_kernel1_prepare() mollis_stable_step1()
    mollis_stable_step1_anywhere());
check!(plane_f64, f64, 2, 1e-250; mollis_kernel2_bytes() mollis_kernel2_prepare() mollis_stable_step2()
    mollis_stable_step2_anywhere());
check!(space_f64, f64, 3, 1e-250; mollis_kernel3_bytes() mollis_kernel3_prepare() mollis_stable_step3()
    mollis_stable_step3_anywhere());
check!(line_f32, f32, 1, 1e-40; mollis_kernel1_bytes_f32() mollis_kernel1_prepare_f32()
    mollis_stable_step1_f32() mollis_stable_step1_anywhere_f32());
check!(plane_f32, f32, 2, 1e-40; mollis_kernel2_bytes_f32() mollis_kernel2_prepare_f32()
    mollis_stable_step2_f32() mollis_stable_step2_anywhere_f32());
check!(space_f32, f32, 3, 1e-40; mollis_kernel3_bytes_f32() mollis_kernel3_prepare_f32()
    mollis_stable_step3_f32() mollis_stable_step3_anywhere_f32());

/// A pair at distance 1e-180 under the logarithm in the plane: 1 / (2 pi r^2) is out of range, 1 / r is not.
#[test]
fn a_pair_so_close_that_its_square_is_zero() {
    let mut bytes = 0;
    let newtonian = term(MOLLIS_KERNEL_NEWTONIAN, 1.0, 0.0);
    for (r, refused) in [(1e-180, true), (1e-150, false)] {
        let (x, m, mut step) = ([[0.0, 0.0], [0.6 * r, 0.8 * r]], [1.0, 1.0], -7.0);
        unsafe {
            assert_eq!(mollis_kernel2_bytes(&raw const newtonian, 1, null(), NONE, &raw mut bytes), 0);
            let mut block = Aligned::new(bytes);
            assert_eq!(mollis_kernel2_prepare(block.pointer(), bytes, &raw const newtonian, 1, null(), NONE, 1.0), 0);
            let status = mollis_stable_step2(block.pointer(), bytes, 2, x.as_ptr(), m.as_ptr(), &raw mut step);
            assert_eq!(status, if refused { REFUSED } else { 0 });
        }
        // 2 |m| / (2 pi r^2).
        assert!(refused || (step / (END * PI * r * r) - 1.0).abs() < 1e-14);
    }
}

/// |x|^3 / 3 has the second derivatives r and 2 r: with light particles the bound is finite where these are.
#[test]
fn distances_and_derivatives_beyond_the_range_are_refused() {
    let cubic = term(MOLLIS_KERNEL_POWER, 1.0, 3.0);
    let mut bytes = 0;
    unsafe {
        assert_eq!(mollis_kernel2_bytes(&raw const cubic, 1, null(), NONE, &raw mut bytes), 0);
        let mut block = Aligned::new(bytes);
        assert_eq!(mollis_kernel2_prepare(block.pointer(), bytes, &raw const cubic, 1, null(), NONE, 1.0), 0);
        for (x, m, refused) in [(1e307, 1e-300, false), (1e308, 1e-300, true)] {
            let (x, m, mut step) = ([[-x, 0.0], [x, 0.0]], [m, m], -7.0);
            let status = mollis_stable_step2(block.pointer(), bytes, 2, x.as_ptr(), m.as_ptr(), &raw mut step);
            assert_eq!((status, step == -7.0), (if refused { REFUSED } else { 0 }, refused));
        }
        assert_eq!(mollis_kernel2_bytes_f32(&raw const cubic, 1, null(), NONE, &raw mut bytes), 0);
        let mut block = Aligned::new(bytes);
        assert_eq!(mollis_kernel2_prepare_f32(block.pointer(), bytes, &raw const cubic, 1, null(), NONE, 1.0), 0);
        for (diameter, refused) in [(1e38, false), (3e38, true)] {
            let mut step = -7.0;
            let status = mollis_stable_step2_anywhere_f32(block.pointer(), bytes, 1e-38, diameter, &raw mut step);
            assert_eq!((status, step == -7.0), (if refused { REFUSED } else { 0 }, refused));
        }
    }
}

/// A mollifier much shorter than the diameter: the bound is the maximum over all distances, here sampled finely.
#[test]
fn the_maximum_is_found_inside_a_short_mollifier() {
    let newtonian = term(MOLLIS_KERNEL_NEWTONIAN, 1.0, 0.0);
    for order in [2, 4, 6, 8] {
        let compact = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order, exponent: 3 };
        for delta in [1e-9, 1e-4, 1.0] {
            let (mut bytes, mut step) = (0, -7.0);
            const N: usize = 20_000;
            let r: Vec<f64> = (0..N).map(|k| delta * 1.5 * k as f64 / N as f64).collect();
            let (mut g, mut l) = (vec![0.0; N], vec![0.0; N]);
            unsafe {
                assert_eq!(mollis_kernel3_bytes(&raw const newtonian, 1, null(), compact, &raw mut bytes), 0);
                let mut block = Aligned::new(bytes);
                let kernel = block.pointer();
                assert_eq!(mollis_kernel3_prepare(kernel, bytes, &raw const newtonian, 1, null(), compact, delta), 0);
                assert_eq!(mollis_stable_step3_anywhere(kernel, bytes, 1.0, 2.0, &raw mut step), 0);
                let (g, l) = (g.as_mut_ptr(), l.as_mut_ptr());
                assert_eq!(mollis_kernel3_eval(kernel, bytes, N, r.as_ptr(), null_mut(), g, l), 0);
            }
            let largest = g.iter().zip(&l).fold(0.0, |most, (g, l): (&f64, &f64)| {
                f64::max(most, f64::max((l - 2.0 * g).abs().max(g.abs()), 0.5 * l.abs()))
            });
            // Between samples a 500th of delta apart a maximum is higher by about (pi order / 1000)^2.
            assert!((step * 2.0 * largest / END - 1.0).abs() < 1e-3, "{order} {delta}: {step} {largest}");
        }
    }
}
