//! Coalescing particles without a sum over pairs: steps without attraction, on meshes, with heavy particles, with and without noise. Also
//! the functions in closed form.

use std::ptr::{null, null_mut};

use mollis_tests::Aligned;
use mollis_tests::exceptions::Rows;
use mollis_tests::positional::*;

use super::*;
use crate::pks_abi::options;

const N: usize = 60;

/// Constants, laws and schemes with different formulas.
fn choices() -> Vec<(&'static str, mollis_pks_options)> {
    let with = |name, change: &dyn Fn(&mut mollis_pks_options)| {
        let mut options = options();
        change(&mut options);
        (name, options)
    };
    vec![
        with("defaults", &|_| ()),
        with("printed law", &|o| o.law = MOLLIS_PKS_LAW_PRINTED),
        with("hard", &|o| (o.chi, o.merging) = (30.0, MOLLIS_PKS_MERGE_HARD)),
        with("never", &|o| o.merging = MOLLIS_PKS_MERGE_NEVER),
        with("Strang", &|o| o.scheme = MOLLIS_PKS_SCHEME_STRANG_RK4),
        with("repulsive", &|o| (o.chi, o.noise) = (-3.0, 0.1)),
        with("chi = 0", &|o| o.chi = 0.0),
        with("no noise", &|o| o.noise = 0.0),
        with("neither", &|o| (o.chi, o.noise) = (0.0, 0.0)),
        with("noisy", &|o| o.noise = 0.5),
        with("width", &|o| (o.width, o.at_least) = (0.01, 3)),
    ]
}

macro_rules! check {
    ($name:ident, $t:ty; $bytes:ident() $step:ident() $kernel_bytes:ident() $prepare:ident()) => {
        #[test]
        fn $name() {
            let mut rows = Rows::default();
            let mesh = mollis_mesh2 { lower: [-2.0; 2], upper: [2.0; 2], cells: [17, 20] };
            let grids = meshes::options();
            let no_flux = grids.iter().find(|g| g.walls == MOLLIS_WALLS_NO_FLUX && g.screening == 0.0).unwrap();
            let term = mollis_kernel_term {
                kind: MOLLIS_KERNEL_NEWTONIAN,
                reserved: 0,
                coefficient: 1.0,
                parameter: [0.0; 2],
            };
            let mut kernel_bytes = 0;
            unsafe { assert_eq!($kernel_bytes(&raw const term, 1, null(), compact(2, 4), &raw mut kernel_bytes), 0) };
            let mut block = Aligned::new(kernel_bytes);
            let kernel = pointer(&mut block);
            unsafe { assert_eq!($prepare(kernel, kernel_bytes, &raw const term, 1, null(), compact(2, 4), 0.05), 0) };
            for (choice, options) in choices() {
                for force in ["none", "free", "no flux", "heavy"] {
                    let what = |function: &str| format!("{function}, {choice}, {force}");
                    let attraction = mollis_pks_attraction {
                        kind: if force == "none" { MOLLIS_PKS_ATTRACTION_NONE } else { MOLLIS_PKS_ATTRACTION_MESH },
                        reserved: 0,
                        mesh: &raw const mesh,
                        grid: if force == "no flux" { no_flux } else { null() },
                        kernel,
                        kernel_bytes,
                        tolerance: 0.0,
                        heavy: if force == "heavy" { 0.11 } else { 0.0 },
                    };
                    let mut positions = points!(N, $t, 2);
                    positions[4] = [2.0, -0.3];
                    let mut masses: Vec<$t> = (0..N).map(|k| 0.02 + 0.1 * (k * 7 % 10) as $t / 10.0).collect();
                    masses[9] = 0.12;
                    let mut labels: Vec<u64> = (0..N as u64).collect();
                    let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: N as u64, pending: 0 };
                    let none = mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 };
                    let (mut log, mut absorbed) = (vec![none; N], vec![0_u64; N]);
                    let mut events = mollis_pks_events {
                        events: log.as_mut_ptr(),
                        room: N,
                        written: 0,
                        labels: absorbed.as_mut_ptr(),
                        labels_room: N,
                        labels_written: 0,
                    };
                    let mut bytes = 0;
                    rows.row(what(stringify!($bytes)), || unsafe {
                        $bytes(N, &raw const options, &raw const attraction, null(), &raw mut bytes)
                    });
                    let mut memory = Aligned::new(bytes);
                    let workspace = pointer(&mut memory);
                    rows.row(what(stringify!($step)), || unsafe {
                        $step(
                            &raw const options,
                            &raw const attraction,
                            N,
                            positions.as_mut_ptr(),
                            masses.as_mut_ptr(),
                            labels.as_mut_ptr(),
                            null_mut(),
                            &raw mut counters,
                            null(),
                            7,
                            2e-3,
                            6,
                            &raw mut events,
                            null_mut(),
                            workspace,
                            bytes,
                            null(),
                        )
                    });
                }
            }
            rows.finish();
        }
    };
}

check!(double, f64; pks_workspace_bytes() pks_step() mollis_kernel2_bytes() mollis_kernel2_prepare());
check!(single, f32; pks_workspace_bytes_f32() pks_step_f32() mollis_kernel2_bytes_f32()
    mollis_kernel2_prepare_f32());

#[test]
fn closed_forms() {
    let mut rows = Rows::default();
    let heavy = [2.0, 3.0];
    for chi in [0.0, 1.0, 10.0, -1.0] {
        for mu in [0.0, 1.0] {
            for n in [0, 2] {
                let mut out = mollis_pks_prediction { critical_mass: 0.0, blow_up_bound: 0.0, second_moment_rate: 0.0 };
                rows.row(format!("mollis_pks_predict, chi {chi}, mu {mu}, {n}"), || unsafe {
                    mollis_pks_predict(20.0, mu, chi, 7.0, n, heavy.as_ptr(), &raw mut out)
                });
                assert!(chi != 0.0 || (out.critical_mass, out.blow_up_bound) == (f64::INFINITY, f64::INFINITY));
            }
            let mut index = [0.0; 3];
            for n in [1, 2] {
                rows.row(format!("mollis_pks_index, chi {chi}, noise {mu}, {n}"), || unsafe {
                    mollis_pks_index(n, heavy.as_ptr(), chi, mu, 0.16, index.as_mut_ptr())
                });
            }
        }
        let species = [
            mollis_pks_species { mass: 4.0, mu: 17.5, sensitivity: 0.0 },
            mollis_pks_species { mass: 24.0, mu: 3.0, sensitivity: 0.0 },
        ];
        let (mut share, mut noise, mut rate) = ([0.0; 2], 0.0, 0.0);
        rows.row(format!("mollis_pks_represent_species, chi {chi}"), || unsafe {
            let share = share.as_mut_ptr();
            mollis_pks_represent_species(2, species.as_ptr(), chi, 100, share, &raw mut noise, &raw mut rate)
        });
    }
    rows.finish();
}
