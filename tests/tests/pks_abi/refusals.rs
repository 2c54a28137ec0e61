//! Each argument of a step made invalid in turn.

use super::*;
use mollis_tests::positional::*;

/// Arguments of a step in double precision. Each case makes one invalid.
struct Call {
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    room: usize,
    positions: *mut [f64; 2],
    masses: *mut f64,
    labels: *mut u64,
    species: *mut u32,
    counters: *mut mollis_pks_progress,
    generator: *const mollis_generator,
    dt: f64,
    events: *mut mollis_pks_events,
    report: *mut mollis_pks_report,
    workspace: *mut c_void,
    bytes: usize,
    run: *const mollis_run,
}

/// Moves a pointer by a byte.
fn off<X>(pointer: *mut X) -> *mut X {
    pointer.wrapping_byte_add(1)
}

#[test]
fn refused_calls_have_their_codes_and_write_nothing() {
    let good_options = options();
    let mesh = MESH;
    let attraction = mollis_pks_attraction {
        kind: MOLLIS_PKS_ATTRACTION_MESH,
        reserved: 0,
        mesh: &raw const mesh,
        grid: null(),
        kernel: null(),
        kernel_bytes: 0,
        tolerance: 0.0,
        heavy: 0.0,
    };
    let (positions, masses, labels, species) = start::<f64>();
    let mut bytes = 0;
    // SAFETY: live structures.
    let sized =
        unsafe { pks_workspace_bytes(N, &raw const good_options, &raw const attraction, null(), &raw mut bytes) };
    assert_eq!(sized, 0);
    let changed = |change: &dyn Fn(&mut mollis_pks_options)| {
        let mut options = good_options;
        change(&mut options);
        options
    };
    let bad_options = [
        (changed(&|o| o.size = 3), Error::OptionsSize),
        (changed(&|o| o.law = 2), Error::UnknownValue),
        (changed(&|o| o.merging = -1), Error::UnknownValue),
        (changed(&|o| o.scheme = 2), Error::UnknownValue),
        (changed(&|o| o.chi = f64::NAN), Error::NotFinite),
        (changed(&|o| o.noise = f64::INFINITY), Error::NotFinite),
        (changed(&|o| o.gamma = f64::NAN), Error::NotFinite),
        (changed(&|o| o.noise = -1.0), Error::OutOfDomain),
        (changed(&|o| o.noise = 1e-310), Error::OutOfDomain),
        (changed(&|o| o.chi = -1e-310), Error::OutOfDomain),
        (changed(&|o| o.gamma = 1e-310), Error::OutOfDomain),
        (changed(&|o| o.separation = 1.0), Error::OutOfDomain),
        (changed(&|o| o.probability = 0.0), Error::OutOfDomain),
        (changed(&|o| o.width = -1.0), Error::OutOfDomain),
        (changed(&|o| (o.at_least, o.at_most) = (5, 4)), Error::OutOfDomain),
        (changed(&|o| o.at_most = 0), Error::OutOfDomain),
        (changed(&|o| o.mesh = [0, 1]), Error::OutOfDomain),
        (changed(&|o| o.domain = [1.0, 0.0, 0.0, 1.0]), Error::OutOfDomain),
    ];
    let coarse = mollis_mesh2 { cells: [1, 8], ..MESH };
    let heavy = mollis_pks_attraction { heavy: 1.0, ..attraction };
    let mut block = [0_u8; 4096];
    let at = block.as_ptr().align_offset(ALIGN);
    let terms = [Term { law: Law::Newtonian, coefficient: 1.0 }];
    let softened = Mollifier::Compact { order: 2, exponent: 4 };
    Kernel::<f64, 2>::prepare(&mut block[at..], &terms, softened, DELTA).unwrap();
    let ready = mollis_pks_attraction { kernel: block[at..].as_ptr().cast(), kernel_bytes: 4096 - at, ..heavy };
    let mut walled = std::mem::MaybeUninit::<mollis_grid2_options>::uninit();
    // SAFETY: a live structure of this size, which the call fills.
    let mut walled = unsafe {
        assert_eq!(mollis_grid2_options_init(walled.as_mut_ptr(), size_of::<mollis_grid2_options>()), 0);
        walled.assume_init()
    };
    walled.walls = MOLLIS_WALLS_NO_FLUX;
    let bad_attractions = [
        (heavy, Error::NotPrepared),
        (mollis_pks_attraction { kernel_bytes: 64, ..heavy }, Error::NullPointer),
        (mollis_pks_attraction { heavy: -1.0, ..ready }, Error::OutOfDomain),
        (mollis_pks_attraction { heavy: f64::NAN, ..ready }, Error::NotFinite),
        (mollis_pks_attraction { grid: &raw const walled, ..ready }, Error::Unsupported),
        (mollis_pks_attraction { kind: 3, ..attraction }, Error::UnknownValue),
        (mollis_pks_attraction { mesh: null(), ..attraction }, Error::NullPointer),
        (mollis_pks_attraction { mesh: &raw const coarse, ..attraction }, Error::OutOfDomain),
        (mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_SUM, ..attraction }, Error::NotPrepared),
        (mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_SUM, kernel_bytes: 64, ..attraction }, Error::NullPointer),
    ];
    let no_fill = mollis_generator { state: null_mut(), fill: None };
    let full = |e: &mut mollis_pks_events| e.written = e.room + 1;
    let full_labels = |e: &mut mollis_pks_events| e.labels_written = e.labels_room + 1;
    let null_events = |e: &mut mollis_pks_events| e.events = null_mut();
    type Spoil<'a> = (Box<dyn Fn(&mut Call) + 'a>, Error);
    let mut cases: Vec<Spoil<'_>> = Vec::new();
    for (options, error) in &bad_options {
        cases.push((Box::new(move |c| c.options = options), *error));
    }
    for (attraction, error) in &bad_attractions {
        cases.push((Box::new(move |c| c.attraction = attraction), *error));
    }
    // SAFETY (of the dereferences below): the pointers are those of live arrays.
    let more: Vec<Spoil<'_>> = vec![
        (Box::new(|c| c.attraction = null()), Error::NullPointer),
        (Box::new(|c| c.attraction = off(c.attraction.cast_mut())), Error::Misaligned),
        (Box::new(|c| c.positions = null_mut()), Error::NullPointer),
        (Box::new(|c| c.positions = off(c.positions)), Error::Misaligned),
        (Box::new(|c| c.masses = null_mut()), Error::NullPointer),
        (Box::new(|c| c.labels = null_mut()), Error::NullPointer),
        (Box::new(|c| c.species = off(c.species)), Error::Misaligned),
        (Box::new(|c| c.counters = null_mut()), Error::NullPointer),
        (Box::new(|c| c.events = null_mut()), Error::NullPointer),
        (Box::new(|c| c.report = off(c.report)), Error::Misaligned),
        (Box::new(|c| c.workspace = null_mut()), Error::NullPointer),
        (Box::new(|c| c.bytes -= 1), Error::WorkspaceTooSmall),
        (Box::new(|c| c.generator = &raw const no_fill), Error::NullPointer),
        (Box::new(|c| c.masses = c.positions.cast()), Error::Overlap),
        (Box::new(|c| c.species = c.labels.cast()), Error::Overlap),
        (Box::new(|c| c.counters = c.report.cast()), Error::Overlap),
        (Box::new(|c| c.labels = c.workspace.cast()), Error::Overlap),
        (Box::new(move |c| (c.attraction, c.workspace) = (&raw const ready, ready.kernel.cast_mut())), Error::Overlap),
        (Box::new(|c| c.dt = 0.0), Error::TimeStep),
        (Box::new(|c| c.dt = f64::NAN), Error::TimeStep),
        (Box::new(|c| c.room = N - 1), Error::LengthMismatch),
        (Box::new(move |c| full(unsafe { &mut *c.events })), Error::OutOfDomain),
        (Box::new(move |c| full_labels(unsafe { &mut *c.events })), Error::OutOfDomain),
        (Box::new(move |c| null_events(unsafe { &mut *c.events })), Error::NullPointer),
        (Box::new(|c| unsafe { (*c.positions)[1] = f64::NAN }), Error::NotFinite),
        (Box::new(|c| unsafe { *c.masses = f64::INFINITY }), Error::NotFinite),
        (Box::new(|c| unsafe { *c.masses = -1.0 }), Error::Mass),
        (Box::new(|c| unsafe { (*c.counters).step = 1 << 32 }), Error::TooLarge),
        (Box::new(|c| unsafe { (*c.counters).pending = 1 }), Error::NotPrepared),
    ];
    cases.extend(more);
    for (k, (spoil, error)) in cases.iter().enumerate() {
        let (mut x, mut m, mut names, mut kinds) = (positions.clone(), masses.clone(), labels.clone(), species.clone());
        let mut counters = mollis_pks_progress { time: 0.5, step: 3, count: N as u64, pending: 0 };
        let none = mollis_pks_event { time: 9.0, label: 9, mass: 9.0, index: 9.0, first: 9, absorbed: 9 };
        let (mut log, mut absorbed) = (vec![none; N], vec![8_u64; N]);
        let mut events = mollis_pks_events {
            events: log.as_mut_ptr(),
            room: N,
            written: 0,
            labels: absorbed.as_mut_ptr(),
            labels_room: N,
            labels_written: 0,
        };
        let mut report =
            mollis_pks_report { substeps: 1, normals: 2, fields: 3, searches: 4, clusters: 5, merges: 6, absorbed: 7 };
        let mut workspace = Aligned::new(bytes);
        let mut call = Call {
            options: &raw const good_options,
            attraction: &raw const attraction,
            room: N,
            positions: x.as_mut_ptr(),
            masses: m.as_mut_ptr(),
            labels: names.as_mut_ptr(),
            species: kinds.as_mut_ptr(),
            counters: &raw mut counters,
            generator: null(),
            dt: 1e-3,
            events: &raw mut events,
            report: &raw mut report,
            workspace: workspace.pointer(),
            bytes,
            run: null(),
        };
        spoil(&mut call);
        // The expected contents after a refused call.
        let bits = |x: &[[f64; 2]], m: &[f64]| -> Vec<u64> {
            x.iter().flatten().chain(m).map(|v| v.to_bits()).collect::<Vec<u64>>()
        };
        let before = (bits(&x, &m), names.clone(), kinds.clone(), absorbed.clone());
        let counted = (counters.time, counters.step, counters.count, counters.pending);
        let written = (events.written, events.labels_written);
        // SAFETY: live arrays of these lengths, except the invalid argument, which is refused.
        let status = unsafe {
            pks_step(
                call.options,
                call.attraction,
                call.room,
                call.positions,
                call.masses,
                call.labels,
                call.species,
                call.counters,
                call.generator,
                1,
                call.dt,
                1,
                call.events,
                call.report,
                call.workspace,
                call.bytes,
                call.run,
            )
        };
        assert_eq!(status, *error as i32, "case {k}: {error:?}");
        assert_eq!(before, (bits(&x, &m), names, kinds, absorbed), "case {k}");
        assert_eq!(counted, (counters.time, counters.step, counters.count, counters.pending), "case {k}");
        assert_eq!(written, (events.written, events.labels_written), "case {k}");
        let counts = [report.substeps, report.normals, report.fields, report.searches];
        assert_eq!((counts, report.clusters, report.merges, report.absorbed), ([1, 2, 3, 4], 5, 6, 7), "case {k}");
        assert!(log.iter().all(|e| e.label == 9 && e.absorbed == 9 && e.time == 9.0), "case {k}");
    }
    // The size query refuses the same arguments and leaves its output unchanged.
    for (options, error) in &bad_options {
        let mut bytes = 77;
        // SAFETY: live structures.
        let (double, single) = unsafe {
            (
                pks_workspace_bytes(N, options, &raw const attraction, null(), &raw mut bytes),
                pks_workspace_bytes_f32(N, options, &raw const attraction, null(), &raw mut bytes),
            )
        };
        assert_eq!((double, single, bytes), (*error as i32, *error as i32, 77));
    }
    // SAFETY: a null output is refused.
    let nowhere = unsafe { pks_workspace_bytes(N, &raw const good_options, &raw const attraction, null(), null_mut()) };
    assert_eq!(nowhere, Error::NullPointer as i32);
    let mut options = good_options;
    // SAFETY: a live structure. A size smaller than the first member is refused, and so is null.
    unsafe {
        assert_eq!(mollis_pks_options_init(null_mut(), size_of::<mollis_pks_options>()), Error::NullPointer as i32);
        assert_eq!(mollis_pks_options_init(&raw mut options, 2), Error::OptionsSize as i32);
    }
    assert_eq!(options.chi, good_options.chi);
}
