//! Mesh sums through the C ABI.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::exec::Resources;
use mollis_core::grid::{Coefficients, Limits, Mesh, Variable, Walls};
use mollis_tests::Aligned;
use mollis_tests::positional::*;

use crate::border::grid_options;

#[test]
fn the_call_does_what_core_does_and_refuses_without_writing() {
    let mesh = mollis_mesh2 { lower: [-1.0, -1.0], upper: [1.0, 1.0], cells: [12, 10] };
    let (x, m) = ([[0.1, 0.2], [-0.3, 0.4], [2.0, 0.0]], [1.0, 2.0, 0.5]);
    let mut memory = Aligned::new(1 << 16);
    let memory: *mut c_void = memory.pointer();
    let nodes = 13 * 11;
    let (mut gradient, mut total, mut outside) = ([[7.0; 2]; 3], [7.0; 3], 7_u64);
    let (mut mass, mut u, mut du) = (vec![7.0; nodes], vec![7.0; nodes], vec![[7.0; 2]; nodes]);
    let mut bytes = 0;
    // SAFETY: live arrays of these lengths.
    unsafe {
        assert_eq!(grid2_workspace_bytes(&raw const mesh, null(), null(), &raw mut bytes), 0);
        assert!(bytes <= 1 << 16);
        let mut call =
            |mesh: *const mollis_mesh2, options: *const mollis_grid2_options, x: *const [f64; 2], bytes: usize| {
                grid2_eval(
                    mesh,
                    options,
                    3,
                    x,
                    m.as_ptr(),
                    3,
                    x,
                    gradient.as_mut_ptr(),
                    mass.as_mut_ptr(),
                    u.as_mut_ptr(),
                    du.as_mut_ptr(),
                    &raw mut total,
                    &raw mut outside,
                    memory,
                    bytes,
                    null(),
                )
            };
        let bad = [[0.1, f64::NAN], [0.0; 2], [0.0; 2]];
        let thin = mollis_mesh2 { cells: [1, 10], ..mesh };
        let unknown = mollis_grid2_options { walls: 9, ..grid_options(MOLLIS_WALLS_FREE) };
        let negative = mollis_grid2_options { screening: -1.0, ..grid_options(MOLLIS_WALLS_FREE) };
        let screened = mollis_grid2_options {
            walls: MOLLIS_WALLS_FREE_QUADRUPOLE,
            screening: 1.0,
            ..grid_options(MOLLIS_WALLS_FREE)
        };
        let third = mollis_grid2_options { order: 3, ..grid_options(MOLLIS_WALLS_FREE) };
        let long = mollis_mesh2 { cells: [12, 5], ..mesh };
        let fourth = mollis_grid2_options { order: 4, ..grid_options(MOLLIS_WALLS_FREE) };
        for (status, error) in [
            (call(&raw const mesh, &raw const third, x.as_ptr(), bytes), Error::UnknownValue),
            (call(&raw const long, &raw const fourth, x.as_ptr(), bytes), Error::Unsupported),
            (call(null(), null(), x.as_ptr(), bytes), Error::NullPointer),
            (call(&raw const thin, null(), x.as_ptr(), bytes), Error::OutOfDomain),
            (call(&raw const mesh, &raw const unknown, x.as_ptr(), bytes), Error::UnknownValue),
            (call(&raw const mesh, &raw const negative, x.as_ptr(), bytes), Error::KernelParameter),
            (call(&raw const mesh, &raw const screened, x.as_ptr(), bytes), Error::Unsupported),
            (call(&raw const mesh, null(), x.as_ptr(), bytes - 1), Error::WorkspaceTooSmall),
            (call(&raw const mesh, null(), bad.as_ptr(), bytes), Error::NotFinite),
            (call(&raw const mesh, null(), memory.cast::<[f64; 2]>(), bytes), Error::Overlap),
        ] {
            assert_eq!(status, error as i32);
        }
        assert!(call(&raw const mesh, null(), x.as_ptr(), bytes) == 0);
    }
    assert_eq!((outside, total[0]), (1, 3.5));
    assert!((mass.iter().sum::<f64>() - 3.0).abs() < 1e-13);
    let exact = [(0.1 - 0.6 + 1.0) / 3.5, (0.2 + 0.8) / 3.5];
    assert!((total[1] - exact[0]).abs() < 1e-12 && (total[2] - exact[1]).abs() < 1e-12);
    assert!(gradient.iter().chain(&du).flatten().chain(&u).all(|v| v.is_finite() && *v != 7.0));

    // Only what is wanted, by single precision: the total alone needs no field.
    let (x32, m32) = (x.map(|x| x.map(|v| v as f32)), m.map(|m| m as f32));
    let (mut total32, mut bytes32) = ([0.0_f32; 3], 0);
    // SAFETY: live arrays of these lengths.
    let status = unsafe {
        assert_eq!(grid2_workspace_bytes_f32(&raw const mesh, null(), null(), &raw mut bytes32), 0);
        assert!(bytes32 > 0 && bytes32 < bytes);
        grid2_eval_f32(
            &raw const mesh,
            null(),
            3,
            x32.as_ptr(),
            m32.as_ptr(),
            0,
            null(),
            null_mut(),
            null_mut(),
            null_mut(),
            null_mut(),
            &raw mut total32,
            null_mut(),
            memory,
            bytes32,
            null(),
        )
    };
    assert_eq!((status, total32[0]), (0, 3.5));
}

#[test]
fn a_medium_does_what_core_does_and_refuses_without_writing() {
    let mesh = mollis_mesh2 { lower: [-1.0, -1.0], upper: [1.0, 1.0], cells: [24, 20] };
    let (x, m) = ([[0.1, 0.2], [-0.3, 0.4], [2.0, 0.0]], [1.0, 2.0, 0.5]);
    let nodes = 25 * 21;
    let inside = |k: usize| (8..15).contains(&(k % 25)) && (6..12).contains(&(k / 25));
    let g: Vec<f64> = (0..nodes).map(|k| if inside(k) { 8.0 } else { 0.5 }).collect();
    let decay: Vec<f64> = (0..nodes).map(|k| if inside(k) { 3.0 } else { 1.0 }).collect();
    let (mut report, mut medium_report) = ([7.0; 2], [7.0; 2]);
    let medium = mollis_medium2 {
        diffusivity: g.as_ptr(),
        decay: decay.as_ptr(),
        tolerance: 1e-11,
        iterations: 80,
        report: &raw mut report,
    };
    let with = |medium: &mollis_medium2| mollis_grid2_options { medium, ..grid_options(MOLLIS_WALLS_FREE) };
    let options = with(&medium);
    let mut bytes = 0;
    // SAFETY: live arrays of these lengths.
    assert_eq!(unsafe { grid2_workspace_bytes(&raw const mesh, &raw const options, null(), &raw mut bytes) }, 0);
    let mut memory = Aligned::new(bytes);
    let mut gradient = [[7.0; 2]; 3];
    let mut u = vec![7.0; nodes];
    let u_at = u.as_mut_ptr();
    let mut call = |options: &mollis_grid2_options, bytes: usize| {
        // SAFETY: live arrays of these lengths.
        unsafe {
            grid2_eval(
                &raw const mesh,
                options,
                3,
                x.as_ptr(),
                m.as_ptr(),
                3,
                x.as_ptr(),
                gradient.as_mut_ptr(),
                null_mut(),
                u_at,
                null_mut(),
                null_mut(),
                null_mut(),
                memory.pointer(),
                bytes,
                null(),
            )
        }
    };
    let other = |at: usize, value: f64| {
        let mut values = g.clone();
        values[at] = value;
        values
    };
    let (flat, uneven, hole) = (other(40, 0.0), other(3, 0.6), other(40, f64::NAN));
    let of = |diffusivity: *const f64| mollis_medium2 { diffusivity, ..medium };
    let mut sink = [7.0; 2];
    let short = mollis_medium2 { iterations: 2, report: &raw mut sink, ..medium };
    let overlapping = mollis_medium2 { report: u_at.cast(), ..medium };
    for (options, bytes, error) in [
        (with(&of(null())), bytes, Error::NullPointer),
        (with(&of(flat.as_ptr())), bytes, Error::OutOfDomain),
        (with(&of(hole.as_ptr())), bytes, Error::NotFinite),
        (with(&of(uneven.as_ptr())), bytes, Error::Unsupported),
        (with(&of(u_at)), bytes, Error::Overlap),
        (with(&mollis_medium2 { tolerance: 0.0, ..medium }), bytes, Error::OutOfDomain),
        (with(&mollis_medium2 { tolerance: f64::NAN, ..medium }), bytes, Error::NotFinite),
        (with(&overlapping), bytes, Error::Overlap),
        (mollis_grid2_options { screening: 1.0, ..options }, bytes, Error::Unsupported),
        (mollis_grid2_options { order: 4, ..options }, bytes, Error::Unsupported),
        (mollis_grid2_options { walls: MOLLIS_WALLS_FREE_QUADRUPOLE, ..options }, bytes, Error::Unsupported),
        (options, bytes - 1, Error::WorkspaceTooSmall),
    ] {
        assert_eq!(call(&options, bytes), error as i32, "{error:?}");
    }
    // SAFETY: the array lives.
    assert!(unsafe { std::slice::from_raw_parts(u_at, nodes) }.iter().all(|&v| v == 7.0));
    assert_eq!(call(&with(&short), bytes), Error::NotConverged as i32);
    assert!(sink[0] == 2.0 && sink[1] > 1e-6);
    // SAFETY: the array lives.
    assert!(unsafe { std::slice::from_raw_parts(u_at, nodes) }.iter().all(|&v| v != 7.0));
    assert_eq!(call(&options, bytes), 0);
    // No arrays of decay: another field.
    let plain = mollis_medium2 { decay: null(), report: &raw mut medium_report, ..medium };
    let before = gradient;
    let mut call_again = |options: &mollis_grid2_options| {
        // SAFETY: live arrays of these lengths.
        unsafe {
            grid2_eval(
                &raw const mesh,
                options,
                3,
                x.as_ptr(),
                m.as_ptr(),
                3,
                x.as_ptr(),
                gradient.as_mut_ptr(),
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
                memory.pointer(),
                bytes,
                null(),
            )
        }
    };
    assert_eq!(call_again(&with(&plain)), 0);
    assert!(gradient != before && medium_report[0] > 5.0 && medium_report[1] <= 1e-11);

    let rectangle = Mesh::new(mesh.lower, mesh.upper, mesh.cells).unwrap();
    let coefficients = Coefficients { diffusivity: &g, decay: Some(&decay) };
    let mut memory = Aligned::new(Variable::workspace_bytes(&rectangle, Walls::Free, 1).unwrap());
    let mut field = Variable::prepare(memory.bytes(), rectangle, Walls::Free, &coefficients, 1).unwrap();
    field.deposit(&x, &m, Resources::default()).unwrap();
    let done = field.solve(&Limits { tolerance: 1e-11, iterations: 80 }, Resources::default()).unwrap();
    assert_eq!(report, [f64::from(done.iterations), done.residual]);
    let (mut want, mut want_u) = ([[0.0; 2]; 3], vec![0.0; nodes]);
    field.grid().interpolate(&x, &mut want, Resources::default()).unwrap();
    field.grid().potential(&mut want_u).unwrap();
    assert!(want == before && want_u == u);

    // In single precision the coefficients are doubles as well.
    let single = mollis_medium2 { tolerance: 1e-5, ..medium };
    let (x32, m32) = (x.map(|x| x.map(|v| v as f32)), m.map(|m| m as f32));
    let (mut gradient32, mut bytes32) = ([[7.0_f32; 2]; 3], 0);
    // SAFETY: live arrays of these lengths.
    let status = unsafe {
        let options = with(&single);
        assert_eq!(grid2_workspace_bytes_f32(&raw const mesh, &raw const options, null(), &raw mut bytes32), 0);
        assert!(bytes32 < bytes);
        let mut memory = Aligned::new(bytes32);
        grid2_eval_f32(
            &raw const mesh,
            &raw const options,
            3,
            x32.as_ptr(),
            m32.as_ptr(),
            3,
            x32.as_ptr(),
            gradient32.as_mut_ptr(),
            null_mut(),
            null_mut(),
            null_mut(),
            null_mut(),
            null_mut(),
            memory.pointer(),
            bytes32,
            null(),
        )
    };
    assert_eq!(status, 0);
    for (single, double) in gradient32.iter().flatten().zip(before.iter().flatten()) {
        // The tolerance over a mesh width of 1/12.
        assert!((f64::from(*single) - double).abs() < 5e-4, "{single} {double}");
    }
}
