//! A pair that merges, calls that are refused, the theory.

use super::*;
use crate::boundary_abi::NOTHING;
use mollis_tests::positional::*;

#[test]
fn a_pair_on_a_mesh_merges_and_bad_calls_write_nothing() {
    let mesh = mollis_mesh2 { lower: [-1.0; 2], upper: [1.0; 2], cells: [8, 8] };
    let attraction = mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_MESH, mesh: &raw const mesh, ..NOTHING };
    let options = mollis_pks_options { chi: 1e3, noise: 1.0, ..options() };
    let mut memory = Aligned::new(1 << 16);
    let memory: *mut c_void = memory.pointer();
    let (mut x, mut m) = ([[0.1, 0.1], [0.1, 0.100_001], [-0.9, 0.3]], [1.0, 3.0, 0.5]);
    let (mut labels, mut species) = ([9_u64, 4, 6], [1_u32, 2, 3]);
    let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: 3, pending: 0 };
    let mut log = [mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 }; 2];
    let mut absorbed = [0_u64; 2];
    let mut events = mollis_pks_events {
        events: log.as_mut_ptr(),
        room: 2,
        written: 0,
        labels: absorbed.as_mut_ptr(),
        labels_room: 2,
        labels_written: 0,
    };
    let mut report =
        mollis_pks_report { substeps: 0, normals: 0, fields: 0, searches: 0, clusters: 0, merges: 0, absorbed: 0 };
    let mut bytes = 0;
    // SAFETY: live arrays of these lengths.
    unsafe {
        assert_eq!(pks_workspace_bytes(3, &raw const options, &raw const attraction, null(), &raw mut bytes), 0);
        assert!(bytes <= 1 << 16);
        let mut call = |options: *const mollis_pks_options, attraction, species: *mut u32, bytes, dt| {
            pks_step(
                options,
                attraction,
                3,
                x.as_mut_ptr(),
                m.as_mut_ptr(),
                labels.as_mut_ptr(),
                species,
                &raw mut counters,
                null(),
                7,
                dt,
                1,
                &raw mut events,
                &raw mut report,
                memory,
                bytes,
                null(),
            )
        };
        let unknown = mollis_pks_options { law: 5, ..options };
        let negative = mollis_pks_options { noise: -1.0, ..options };
        let kind = mollis_pks_attraction { kind: 9, ..NOTHING };
        let good = (&raw const options, &raw const attraction, species.as_mut_ptr());
        for (status, error) in [
            (call(&raw const unknown, good.1, good.2, bytes, 1e-4), Error::UnknownValue),
            (call(&raw const negative, good.1, good.2, bytes, 1e-4), Error::OutOfDomain),
            (call(good.0, &raw const kind, good.2, bytes, 1e-4), Error::UnknownValue),
            (call(good.0, null(), good.2, bytes, 1e-4), Error::NullPointer),
            (call(good.0, good.1, memory.cast(), bytes, 1e-4), Error::Overlap),
            (call(good.0, good.1, good.2, bytes - 1, 1e-4), Error::WorkspaceTooSmall),
            (call(good.0, good.1, good.2, bytes, -1.0), Error::TimeStep),
        ] {
            assert_eq!(status, error as i32);
        }
        assert_eq!(call(good.0, good.1, good.2, bytes, 1e-4), 0);
    }
    assert_eq!((counters.count, counters.step, counters.time, counters.pending), (2, 1, 1e-4, 0));
    assert_eq!((labels[0], labels[1], m[0], m[1], species[0], species[1]), (4, 6, 4.0, 0.5, 2, 3));
    assert_eq!((events.written, events.labels_written, absorbed[0]), (1, 1, 9));
    assert_eq!((log[0].label, log[0].mass, log[0].absorbed), (4, 4.0, 1));
    assert!(log[0].index < -1.0 && report.merges == 1 && report.normals == 3 && report.fields == 1);
}

#[test]
fn single_precision_without_attraction_diffuses() {
    let options = mollis_pks_options { noise: 1.0, ..options() };
    let mut memory = Aligned::new(1 << 16);
    let (mut x, mut m, mut labels) = ([[0.0_f32; 2]; 5], [1.0_f32; 5], [0_u64, 1, 2, 3, 4]);
    let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: 5, pending: 0 };
    let mut events = mollis_pks_events {
        events: null_mut(),
        room: 0,
        written: 0,
        labels: null_mut(),
        labels_room: 0,
        labels_written: 0,
    };
    let mut bytes = 0;
    // SAFETY: live arrays of these lengths.
    unsafe {
        let sized = pks_workspace_bytes_f32(5, &raw const options, &NOTHING, null(), &raw mut bytes);
        assert!(sized == 0 && bytes <= 1 << 16);
        let done = pks_step_f32(
            &raw const options,
            &NOTHING,
            5,
            x.as_mut_ptr(),
            m.as_mut_ptr(),
            labels.as_mut_ptr(),
            null_mut(),
            &raw mut counters,
            null(),
            7,
            0.5,
            3,
            &raw mut events,
            null_mut(),
            memory.pointer(),
            bytes,
            null(),
        );
        assert_eq!(done, 0);
    }
    assert_eq!((counters.count, counters.step, counters.time), (5, 3, 1.5));
    assert!(x.iter().flatten().all(|v| *v != 0.0 && v.abs() < 10.0));
}

#[test]
fn the_theory_in_c() {
    let mut index = [0.0; 3];
    let masses = [1.0, 1.0];
    let species = [
        mollis_pks_species { mass: 4.0, mu: 17.5, sensitivity: 0.0 },
        mollis_pks_species { mass: 24.0, mu: 35.0 / 12.0, sensitivity: 0.0 },
    ];
    let (mut share, mut noise, mut rate) = ([0.0; 2], 0.0, 0.0);
    let mut prediction = mollis_pks_prediction { critical_mass: 0.0, blow_up_bound: 0.0, second_moment_rate: 0.0 };
    // SAFETY: live arrays of these lengths.
    unsafe {
        assert_eq!(mollis_pks_index(2, masses.as_ptr(), 3.0, 1.0, 1.0, index.as_mut_ptr()), 0);
        let done = mollis_pks_represent_species(
            2,
            species.as_ptr(),
            4.0,
            100,
            share.as_mut_ptr(),
            &raw mut noise,
            &raw mut rate,
        );
        assert_eq!(done, 0);
        assert_eq!(mollis_pks_predict(2.0, 1.0, 1.0, 1.0, 0, null(), &raw mut prediction), 0);
        let none = mollis_pks_represent_species(0, null(), 4.0, 100, null_mut(), &raw mut noise, null_mut());
        assert_eq!(none, Error::OutOfDomain as i32);
    }
    // (2.7) with gamma 1: 0 - 3 * 2 / 4; (2.4): (4 - 3 * 2) / 2 and 2 / 2.
    assert_eq!(index, [-1.5, -1.0, 1.0]);
    assert!(share.iter().all(|s| (s - 0.5).abs() < 1e-15) && (noise - 1.4).abs() < 1e-14 && rate.is_finite());
    assert_eq!(prediction.blow_up_bound, f64::INFINITY);
    assert!((prediction.critical_mass - 8.0 * std::f64::consts::PI).abs() < 1e-14);
}
