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
