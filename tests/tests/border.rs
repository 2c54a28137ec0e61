//! The border of a mesh through the C ABI: particles on it are inside, for any rounding of the quotient by the mesh width.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_tests::Aligned;
use mollis_tests::positional::*;

const WALLS: [i32; 3] = [MOLLIS_WALLS_FREE, MOLLIS_WALLS_NO_FLUX, MOLLIS_WALLS_FREE_QUADRUPOLE];

/// The default options with these walls.
pub(crate) fn grid_options(walls: i32) -> mollis_grid2_options {
    let mut options = std::mem::MaybeUninit::<mollis_grid2_options>::uninit();
    unsafe {
        assert_eq!(mollis_grid2_options_init(options.as_mut_ptr(), size_of::<mollis_grid2_options>()), 0);
        mollis_grid2_options { walls, ..options.assume_init() }
    }
}

/// Meshes for which (upper - x) / width is rounded above the number of cells, or could be.
const MESHES: [(mollis_mesh2, [f64; 2]); 2] = [
    (mollis_mesh2 { lower: [-15.0; 2], upper: [15.0; 2], cells: [250, 250] }, [15.0, 3.75]),
    (mollis_mesh2 { lower: [0.0; 2], upper: [0.3; 2], cells: [100, 100] }, [0.3, 0.1]),
];

macro_rules! field {
    ($name:ident, $t:ty; $bytes:ident() $eval:ident()) => {
        #[test]
        fn $name() {
            for (mesh, x) in MESHES {
                let x = [x.map(|x| x as $t)];
                for walls in WALLS {
                    let options = grid_options(walls);
                    let (mut gradient, mut total, mut outside) = ([[7.0 as $t; 2]], [7.0 as $t; 3], 7);
                    let nodes = (mesh.cells[0] + 1) * (mesh.cells[1] + 1);
                    let mut masses = vec![7.0 as $t; nodes];
                    let mut bytes = 0;
                    unsafe {
                        assert_eq!($bytes(&raw const mesh, &raw const options, null(), &raw mut bytes), 0);
                        let mut memory = Aligned::new(bytes);
                        let status = $eval(
                            &raw const mesh,
                            &raw const options,
                            1,
                            x.as_ptr(),
                            [1.0].as_ptr(),
                            1,
                            x.as_ptr(),
                            gradient.as_mut_ptr(),
                            masses.as_mut_ptr(),
                            null_mut(),
                            null_mut(),
                            &raw mut total,
                            &raw mut outside,
                            memory.pointer(),
                            bytes,
                            null(),
                        );
                        assert_eq!(status, 0);
                    }
                    assert_eq!((outside, total[0]), (0, 1.0), "{walls} {x:?}");
                    assert!(gradient[0].iter().all(|g| g.is_finite()), "{walls} {x:?} {gradient:?}");
                    // Four shares that are a power of two each: their sum is exact.
                    assert_eq!(masses.iter().sum::<$t>(), 1.0, "{walls} {x:?}");
                }
            }
        }
    };
}

field!(fields_in_double_precision, f64; grid2_workspace_bytes() grid2_eval());
field!(fields_in_single_precision, f32; grid2_workspace_bytes_f32() grid2_eval_f32());

macro_rules! steps {
    ($name:ident, $t:ty; $bytes:ident() $step:ident() $kernel_bytes:ident() $prepare:ident()) => {
        #[test]
        fn $name() {
            let mut options = std::mem::MaybeUninit::<mollis_pks_options>::uninit();
            let mut options = unsafe {
                assert_eq!(mollis_pks_options_init(options.as_mut_ptr(), size_of::<mollis_pks_options>()), 0);
                options.assume_init()
            };
            (options.chi, options.noise) = (1.0, 1e-4);
            for (mesh, x) in MESHES {
                let width = (mesh.upper[0] - mesh.lower[0]) / mesh.cells[0] as f64;
                let term = mollis_kernel_term {
                    kind: MOLLIS_KERNEL_NEWTONIAN,
                    reserved: 0,
                    coefficient: 1.0,
                    parameter: [0.0; 2],
                };
                let compact = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 2, exponent: 4 };
                let mut kernel_bytes = 0;
                unsafe { assert_eq!($kernel_bytes(&raw const term, 1, null(), compact, &raw mut kernel_bytes), 0) };
                let mut block = Aligned::new(kernel_bytes);
                unsafe {
                    let delta = (0.25 * width) as $t;
                    assert_eq!($prepare(block.pointer(), kernel_bytes, &raw const term, 1, null(), compact, delta), 0);
                }
                for (walls, heavy) in [(WALLS[0], 0.0), (WALLS[1], 0.0), (WALLS[2], 0.0), (WALLS[0], 0.5)] {
                    let grid = grid_options(walls);
                    let attraction = mollis_pks_attraction {
                        kind: MOLLIS_PKS_ATTRACTION_MESH,
                        reserved: 0,
                        mesh: &raw const mesh,
                        grid: &raw const grid,
                        kernel: block.pointer(),
                        kernel_bytes,
                        tolerance: 0.0,
                        heavy,
                    };
                    // A heavy particle on the border, light ones inside.
                    let inside =
                        |share: f64| [0, 1].map(|k| (mesh.lower[k] + share * (mesh.upper[k] - mesh.lower[k])) as $t);
                    let mut positions = [x.map(|x| x as $t), inside(0.3), inside(0.7)];
                    let mut masses = [1.0 as $t, 0.1, 0.1];
                    let mut labels = [1_u64, 2, 3];
                    let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: 3, pending: 0 };
                    let mut events = mollis_pks_events {
                        events: null_mut(),
                        room: 0,
                        written: 0,
                        labels: null_mut(),
                        labels_room: 0,
                        labels_written: 0,
                    };
                    let mut bytes = 0;
                    let status = unsafe {
                        assert_eq!($bytes(3, &raw const options, &raw const attraction, null(), &raw mut bytes), 0);
                        let mut memory = Aligned::new(bytes);
                        $step(
                            &raw const options,
                            &raw const attraction,
                            3,
                            positions.as_mut_ptr(),
                            masses.as_mut_ptr(),
                            labels.as_mut_ptr(),
                            null_mut(),
                            &raw mut counters,
                            null(),
                            1,
                            (1e-3 * width * width) as $t,
                            5,
                            &raw mut events,
                            null_mut(),
                            memory.pointer(),
                            bytes,
                            null(),
                        )
                    };
                    assert_eq!((status, counters.step), (0, 5), "{walls} {heavy} {x:?}");
                    assert!(positions.as_flattened().iter().all(|x| x.is_finite()));
                }
            }
        }
    };
}

steps!(steps_in_double_precision, f64; pks_workspace_bytes() pks_step() mollis_kernel2_bytes()
    mollis_kernel2_prepare());
steps!(steps_in_single_precision, f32; pks_workspace_bytes_f32() pks_step_f32()
    mollis_kernel2_bytes_f32() mollis_kernel2_prepare_f32());
