//! Coalescing particles that follow an attractant with a memory: the delay, the elliptic limit, checkpoints, failed steps, the C interface.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use std::f64::consts::TAU;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::exec::Run;
use mollis_core::grid::{Equation, Grid, Mesh, Parabolic, Walls};
use mollis_core::pks::{Attraction, Merging, Options, Scheme, workspace_bytes};
use mollis_tests::positional::*;
use mollis_tests::{Aligned, Cloud, Split};

use crate::border::grid_options;
use crate::boundary_abi::{NOTHING, filled};

/// A disc of radius 1 with mass 1.
fn disc(n: usize) -> Cloud {
    let mut numbers = Split(11);
    let positions = (0..n).map(|_| {
        let (r, angle) = (numbers.uniform().sqrt(), TAU * numbers.uniform());
        [r * angle.cos(), r * angle.sin()]
    });
    Cloud::new(positions.collect(), vec![1.0 / n as f64; n])
}

/// sum m |x|^2.
fn moment(cloud: &Cloud) -> f64 {
    cloud.positions.iter().zip(&cloud.masses).map(|(x, m)| m * (x[0] * x[0] + x[1] * x[1])).sum()
}

fn with_field<R>(
    mesh: Mesh<f64>,
    equation: Equation<f64>,
    time_scale: f64,
    body: impl FnOnce(&mut Parabolic<'_, f64>) -> R,
) -> R {
    let mut memory = Aligned::new(Parabolic::workspace_bytes(&mesh, &equation, 1).unwrap());
    body(&mut Parabolic::prepare(memory.bytes(), mesh, equation, time_scale, 1).unwrap())
}

fn attractant(field: &Parabolic<'_, f64>) -> Vec<f64> {
    let mut c = vec![f64::NAN; field.grid().mesh().nodes()];
    field.attractant(&mut c).unwrap();
    c
}

fn boxed() -> (Mesh<f64>, Equation<f64>) {
    (Mesh::new([-2.0; 2], [2.0; 2], [32, 30]).unwrap(), Equation { walls: Walls::NoFlux, ..Equation::POISSON })
}

#[test]
fn attraction_sets_in_with_the_delay() {
    // Particles that all but rest: the force between two at distance r is that of the logarithm times e^(-epsilon r^2 / 4 t), so the second moment M falls at the rate
    // -(chi / 2 pi) sum_(i != j) m_i m_j e^(-epsilon r_ij^2 / 4 t), which is flat at first and tends to the elliptic -chi (M^2 - sum m_i^2) / 2 pi.
    let (chi, time_scale, dt) = (1e-3, 1.0, 0.02);
    let mesh = Mesh::new([-5.0; 2], [5.0; 2], [128, 128]).unwrap();
    let options = Options { merging: Merging::Never, ..Options::new(chi, 0.0) };
    with_field(mesh, Equation::POISSON, time_scale, |field| {
        let mut cloud = disc(400);
        let (start, pairs) = (cloud.positions.clone(), 1.0 / (400.0 * 400.0));
        let elliptic = chi / TAU * (1.0 - 1.0 / 400.0);
        let mut ratios = Vec::new();
        for n in 1..=100 {
            let before = moment(&cloud);
            cloud.step(&options, Attraction::Parabolic(field), dt).unwrap();
            if ![1, 2, 5, 10, 25, 50, 100].contains(&n) {
                continue;
            }
            let (got, t) = ((before - moment(&cloud)) / dt / elliptic, f64::from(n) * dt);
            let mut sum = 0.0;
            for (i, a) in start.iter().enumerate() {
                for b in &start[..i] {
                    let r2 = (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
                    sum += 2.0 * pairs * (-time_scale * r2 / (4.0 * t)).exp();
                }
            }
            let want = chi / TAU * sum / elliptic;
            // The mesh, of width 0.08, loses 0.4 (h / 0.7)^2 = 0.5% of the whole attraction, more of a young field's, whose width is sqrt(4 t).
            let bound = 0.01 + 0.3 * mesh.spacing()[0].powi(2) / t * want;
            assert!((got - want).abs() < bound, "step {n}: {got} {want}");
            ratios.push((t, got, want));
        }
        println!("time, rate of the second moment over the elliptic one, expected: {ratios:.3?}");
        assert!(ratios[0].1 < 0.1 && ratios[6].1 > 0.8);
    });
}

/// When half of the mass is in one particle, twice the critical mass of the elliptic model being in a disc of radius 1; None: the elliptic model.
fn collapse(time_scale: Option<f64>) -> f64 {
    let mesh = Mesh::new([-4.0; 2], [4.0; 2], [48, 48]).unwrap();
    let (n, dt) = (400, 0.05);
    // chi M = 16 pi noise / m.
    let options = Options::new(1.0, 1.0 / (8.0 * TAU) / n as f64);
    let mut cloud = disc(n);
    let mut memory = Aligned::new(Grid::workspace_bytes(&mesh, &Equation::POISSON, 1).unwrap());
    let mut grid = Grid::prepare(memory.bytes(), mesh, Equation::POISSON, 1).unwrap();
    with_field(mesh, Equation::POISSON, time_scale.unwrap_or(1.0), |field| {
        for _ in 0..600 {
            match time_scale {
                Some(_) => cloud.step(&options, Attraction::Parabolic(field), dt).unwrap(),
                None => cloud.step(&options, Attraction::Mesh(&mut grid, None), dt).unwrap(),
            }
            if cloud.alive().1.iter().any(|&m| m > 0.5) {
                break;
            }
        }
        cloud.counters.time
    })
}

#[test]
fn the_collapse_is_delayed() {
    let times = [None, Some(0.5), Some(2.0), Some(8.0)].map(collapse);
    println!("half of the mass is one particle at times {times:.2?} for epsilon = 0, 0.5, 2, 8");
    assert!(times.windows(2).all(|pair| pair[1] > pair[0]) && times[0] < 7.0, "{times:?}");
}

#[test]
fn without_a_time_scale_it_is_the_plain_mesh() {
    let (mesh, equation) = boxed();
    let equation = Equation { screening: 1.0, ..equation };
    let options = Options::new(20.0, 0.01);
    let mut delayed = disc(300);
    let mut plain = delayed.clone();
    with_field(mesh, equation, 1e-12, |field| {
        (0..6).for_each(|_| delayed.step(&options, Attraction::Parabolic(field), 1e-3).unwrap());
    });
    let mut memory = Aligned::new(Grid::workspace_bytes(&mesh, &equation, 1).unwrap());
    let mut grid = Grid::prepare(memory.bytes(), mesh, equation, 1).unwrap();
    (0..6).for_each(|_| plain.step(&options, Attraction::Mesh(&mut grid, None), 1e-3).unwrap());
    assert_eq!((delayed.counters, delayed.events.len()), (plain.counters, plain.events.len()));
    assert!(!plain.events.is_empty());
    for (a, b) in delayed.positions.iter().zip(&plain.positions) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn a_checkpoint_goes_on_bit_for_bit_and_a_failed_step_leaves_the_attractant() {
    let (mesh, equation) = boxed();
    let options = Options::new(20.0, 0.01);
    let dt = 2e-3;
    let (mut cloud, saved) = with_field(mesh, equation, 0.1, |field| {
        let mut cloud = disc(200);
        (0..4).for_each(|_| cloud.step(&options, Attraction::Parabolic(field), dt).unwrap());
        let (c, before) = (attractant(field), cloud.positions.clone());
        let mut few = options;
        (few.control.at_least, few.control.at_most, few.control.width) = (1, 1, 1e-6);
        assert_eq!(cloud.step(&few, Attraction::Parabolic(field), dt), Err(Error::TooManySubsteps));
        let strang = Options { scheme: Scheme::StrangRk4, ..options };
        assert_eq!(cloud.step(&strang, Attraction::Parabolic(field), dt), Err(Error::Unsupported));
        assert!(attractant(field) == c && cloud.positions == before);
        let saved = (cloud.clone(), c);
        (0..4).for_each(|_| cloud.step(&options, Attraction::Parabolic(field), dt).unwrap());
        (cloud, (saved, attractant(field)))
    });
    let ((mut again, c), want) = saved;
    with_field(mesh, equation, 0.1, |field| {
        field.set_attractant(&c, Run::default().resources()).unwrap();
        (0..4).for_each(|_| again.step(&options, Attraction::Parabolic(field), dt).unwrap());
        assert!(
            attractant(field) == want && again.alive() == cloud.alive() && again.events.len() == cloud.events.len()
        );
        // A step that waits for room for its events has advanced c, once.
        let n = cloud.positions.len();
        let mut memory = Aligned::new(workspace_bytes(n, None, &options, 1).unwrap());
        let (mut waits, mut steps) = (0, 0);
        while steps < 8 {
            match cloud.step_with_room(&options, Attraction::Parabolic(field), dt, (&mut memory, 1)) {
                Ok(()) => steps += 1,
                Err(Error::EventsFull) => waits += 1,
                Err(error) => panic!("{error:?}"),
            }
        }
        let in_parts = attractant(field);
        field.set_attractant(&want, Run::default().resources()).unwrap();
        (0..8).for_each(|_| again.step(&options, Attraction::Parabolic(field), dt).unwrap());
        assert!(attractant(field) == in_parts && again.alive() == cloud.alive() && waits > 0, "{waits}");
    });
}

/// The options of a field with a memory.
fn remembering(past: &mollis_parabolic2) -> mollis_grid2_options {
    mollis_grid2_options { parabolic: past, ..grid_options(MOLLIS_WALLS_NO_FLUX) }
}

#[test]
fn a_step_in_c_is_that_of_core() {
    let (mesh, equation) = boxed();
    let rectangle = mollis_mesh2 { lower: mesh.lower(), upper: mesh.upper(), cells: mesh.cells() };
    let mut c = vec![0.0; mesh.nodes()];
    let past = mollis_parabolic2 { time_scale: 0.1, time: 0.0, attractant: c.as_mut_ptr() };
    let grid = remembering(&past);
    let attraction = mollis_pks_attraction {
        kind: MOLLIS_PKS_ATTRACTION_MESH,
        mesh: &raw const rectangle,
        grid: &raw const grid,
        ..NOTHING
    };
    let options = mollis_pks_options { chi: 20.0, noise: 0.01, seed: 3, ..filled(mollis_pks_options_init) };
    let mut cloud = disc(100);
    let mut want = cloud.clone();
    let n = cloud.positions.len();
    let mut progress = mollis_pks_progress { time: 0.0, step: 7, count: n as u64, pending: 0 };
    let none = mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 };
    let (mut log, mut absorbed) = (vec![none; n], vec![0; n]);
    let mut events = mollis_pks_events {
        events: log.as_mut_ptr(),
        room: n,
        written: 0,
        labels: absorbed.as_mut_ptr(),
        labels_room: n,
        labels_written: 0,
    };
    let mut bytes = 0;
    // SAFETY: live arrays of these lengths.
    assert_eq!(unsafe { pks_workspace_bytes(n, &raw const options, &raw const attraction, null(), &raw mut bytes) }, 0);
    let strang = mollis_pks_options { scheme: MOLLIS_PKS_SCHEME_STRANG_RK4, ..options };
    let mut more = 0;
    // SAFETY: as above.
    assert_eq!(unsafe { pks_workspace_bytes(n, &raw const strang, &raw const attraction, null(), &raw mut more) }, 0);
    let mut memory = Aligned::new(bytes.max(more));
    let mut call = |options: &mollis_pks_options, attraction: &mollis_pks_attraction, bytes: usize, steps: usize| {
        // SAFETY: live arrays of these lengths.
        unsafe {
            pks_step(
                options,
                attraction,
                n,
                cloud.positions.as_mut_ptr(),
                cloud.masses.as_mut_ptr(),
                cloud.labels.as_mut_ptr(),
                null_mut(),
                &raw mut progress,
                null(),
                0,
                2e-3,
                steps,
                &raw mut events,
                null_mut(),
                memory.pointer(),
                bytes,
                null(),
            )
        }
    };
    let mut bad = c.clone();
    bad[40] = f64::NAN;
    let (no_flux, quadrupole) = (MOLLIS_WALLS_NO_FLUX, MOLLIS_WALLS_FREE_QUADRUPOLE);
    let scale = |time_scale: f64| mollis_parabolic2 { time_scale, ..past };
    let with = |attractant: *mut f64| mollis_parabolic2 { attractant, ..past };
    for (past, walls, order, heavy, error) in [
        (past, no_flux, 2, 1.0, Error::Unsupported),
        (past, quadrupole, 2, 0.0, Error::Unsupported),
        (past, no_flux, 4, 0.0, Error::Unsupported),
        (scale(0.0), no_flux, 2, 0.0, Error::OutOfDomain),
        (scale(f64::NAN), no_flux, 2, 0.0, Error::NotFinite),
        (with(null_mut()), no_flux, 2, 0.0, Error::NullPointer),
        (with(bad.as_mut_ptr()), no_flux, 2, 0.0, Error::NotFinite),
    ] {
        let grid = mollis_grid2_options { walls, order, ..remembering(&past) };
        let attraction = mollis_pks_attraction { grid: &raw const grid, heavy, ..attraction };
        assert_eq!(call(&options, &attraction, bytes, 1), error as i32, "{walls} {order} {heavy} {}", past.time_scale);
    }
    assert_eq!(call(&options, &attraction, bytes - 1, 1), Error::WorkspaceTooSmall as i32);
    assert_eq!(call(&strang, &attraction, more, 1), Error::Unsupported as i32);
    // SAFETY: c lives.
    assert!((0..mesh.nodes()).all(|k| unsafe { *past.attractant.add(k) } == 0.0));
    // In two calls, between which the workspace is anyone's.
    assert_eq!((call(&options, &attraction, bytes, 2), call(&options, &attraction, bytes, 1)), (0, 0));

    with_field(mesh, equation, 0.1, |field| {
        let core = Options {
            search: mollis_core::pks::search::Search {
                domain: Some([mesh.lower(), mesh.upper()]),
                ..Options::new(20.0, 0.01).search
            },
            ..Options::new(20.0, 0.01)
        };
        (0..3).for_each(|_| want.step(&core, Attraction::Parabolic(field), 2e-3).unwrap());
        assert!(c == attractant(field) && c.iter().all(|&c| c > 0.0));
    });
    assert!(cloud.positions == want.positions && cloud.masses == want.masses && cloud.labels == want.labels);
    assert_eq!((progress.count, progress.step), (want.counters.count, want.counters.step));
}

#[test]
fn a_field_in_c_is_that_of_core() {
    let (mesh, equation) = boxed();
    let rectangle = mollis_mesh2 { lower: mesh.lower(), upper: mesh.upper(), cells: mesh.cells() };
    let cloud = disc(50);
    let mut c = vec![0.0; mesh.nodes()];
    let past = mollis_parabolic2 { time_scale: 0.3, time: 0.05, attractant: c.as_mut_ptr() };
    let mut bytes = 0;
    let options = remembering(&past);
    // SAFETY: live arrays of these lengths.
    assert_eq!(unsafe { grid2_workspace_bytes(&raw const rectangle, &raw const options, null(), &raw mut bytes) }, 0);
    let mut memory = Aligned::new(bytes);
    let (mut gradient, mut u) = (vec![[7.0; 2]; 50], vec![7.0; mesh.nodes()]);
    let mut call = |options: &mollis_grid2_options| {
        // SAFETY: live arrays of these lengths.
        unsafe {
            grid2_eval(
                &raw const rectangle,
                options,
                50,
                cloud.positions.as_ptr(),
                cloud.masses.as_ptr(),
                50,
                cloud.positions.as_ptr(),
                gradient.as_mut_ptr(),
                null_mut(),
                u.as_mut_ptr(),
                null_mut(),
                null_mut(),
                null_mut(),
                memory.pointer(),
                bytes,
                null(),
            )
        }
    };
    for time in [0.0, -1.0, f64::NAN] {
        assert_eq!(call(&remembering(&mollis_parabolic2 { time, ..past })), Error::TimeStep as i32);
    }
    let overlapping = mollis_parabolic2 { attractant: cloud.positions.as_ptr().cast_mut().cast(), ..past };
    assert_eq!(call(&remembering(&overlapping)), Error::Overlap as i32);
    // SAFETY: c lives.
    assert!((0..mesh.nodes()).all(|k| unsafe { *past.attractant.add(k) } == 0.0));
    assert_eq!((call(&options), call(&options)), (0, 0));
    with_field(mesh, equation, 0.3, |field| {
        let run = Run::default();
        (0..2).for_each(|_| field.advance(&cloud.positions, &cloud.masses, 0.05, run.resources()).unwrap());
        let mut want = vec![[7.0; 2]; 50];
        field.grid().interpolate(&cloud.positions, &mut want, run.resources()).unwrap();
        assert!(c == attractant(field) && gradient == want && u.iter().zip(&c).all(|(u, c)| *u == -*c));
    });
}
