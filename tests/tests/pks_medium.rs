//! Coalescing particles in a medium: the index (4.30) has the gamma of the place, the field is the medium's.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::grid::{Coefficients, Equation, Grid, Limits, Mesh, Variable, Walls};
use mollis_core::pks::theory::{Constants, GAMMA, Group};
use mollis_core::pks::{Attraction, Options, Scheme};
use mollis_tests::positional::*;
use mollis_tests::{Aligned, Cloud, Split};

use crate::border::grid_options;
use crate::boundary_abi::{NOTHING, filled};

const LIMITS: Limits<f64> = Limits { tolerance: 1e-10, iterations: 100 };

fn with_medium<R>(mesh: Mesh<f64>, walls: Walls, g: &[f64], body: impl FnOnce(&mut Variable<'_, f64>) -> R) -> R {
    let medium = Coefficients { diffusivity: g, decay: None };
    let mut memory = Aligned::new(Variable::workspace_bytes(&mesh, walls, 1).unwrap());
    body(&mut Variable::prepare(memory.bytes(), mesh, walls, &medium, 1).unwrap())
}

/// Pairs far from each other, of masses 1 and 2 that all but touch.
fn pairs(places: &[[f64; 2]]) -> Cloud {
    let positions = places.iter().flat_map(|&[x, y]| [[x, y], [x + 1e-9, y]]).collect();
    Cloud::new(positions, places.iter().flat_map(|_| [1.0, 2.0]).collect())
}

#[test]
fn the_index_has_the_gamma_of_the_place() {
    let mesh = Mesh::new([-1.0; 2], [1.0; 2], [40, 40]).unwrap();
    // G rises along x from 1 to 5.
    let rising = |x: f64| 3.0 + 2.0 * x;
    let g: Vec<f64> = (0..mesh.nodes()).map(|k| rising(mesh.node((k % 41) as isize, 0)[0])).collect();
    let noise = 0.001;
    let options = Options::new(1.0, noise);
    let places = [[-0.81, 0.3], [-0.2, -0.6], [0.37, 0.7], [0.93, -0.2]];
    with_medium(mesh, Walls::NoFlux, &g, |field| {
        let mut cloud = pairs(&places);
        cloud.step(&options, Attraction::Medium(field, LIMITS), 1e-5).unwrap();
        assert_eq!((cloud.events.len(), cloud.counters.count), (4, 4));
        for event in &cloud.events {
            let x = places[event.label as usize / 2][0];
            let law = Constants { chi: 1.0, noise, gamma: GAMMA / rising(x) };
            let want = law.index(&Group::of(&[1.0, 2.0]));
            // The place is the centre of mass, 1e-9 from x.
            assert!((event.index / want - 1.0).abs() < 1e-8, "{x}: {} {want}", event.index);
        }
    });
}

#[test]
fn pairs_merge_where_gamma_is_large_enough() {
    // Hard collisions alone: nu <= -1, that is G at most gamma chi 4 / (4 mu~). With mu~ = gamma / 4 it is G <= 4.
    let mesh = Mesh::new([-1.0; 2], [1.0; 2], [40, 40]).unwrap();
    let g: Vec<f64> = (0..mesh.nodes()).map(|k| 3.0 + 2.0 * mesh.node((k % 41) as isize, 0)[0]).collect();
    let mut options = Options::new(1.0, GAMMA / 4.0);
    options.merging = mollis_core::pks::Merging::Hard;
    with_medium(mesh, Walls::NoFlux, &g, |field| {
        let places = [[-0.9, 0.3], [0.2, -0.6], [0.45, 0.7], [0.55, -0.2], [0.9, 0.6]];
        let mut cloud = pairs(&places);
        cloud.step(&options, Attraction::Medium(field, LIMITS), 1e-5).unwrap();
        let mut merged: Vec<u64> = cloud.events.iter().map(|event| event.label / 2).collect();
        merged.sort_unstable();
        // Without a medium of G = 1 all of them would.
        assert_eq!(merged, [0, 1, 2]);
    });
}

#[test]
fn an_even_medium_is_the_plain_mesh() {
    for walls in [Walls::Free, Walls::NoFlux] {
        for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
            let mesh = Mesh::new([-2.0; 2], [2.0; 2], [48, 45]).unwrap();
            let mut numbers = Split(9);
            let positions: Vec<_> = (0..300).map(|_| [0, 1].map(|_| 1.5 * (numbers.uniform() - 0.5))).collect();
            let masses = vec![0.1; 300];
            // In a medium of G = 4, with chi four times as large.
            let even = vec![4.0; mesh.nodes()];
            let options = |chi: f64| Options { scheme, ..Options::new(chi, 0.01) };
            let mut in_medium = Cloud::new(positions.clone(), masses.clone());
            with_medium(mesh, walls, &even, |field| {
                for _ in 0..5 {
                    in_medium.step(&options(4.0), Attraction::Medium(field, LIMITS), 1e-3).unwrap();
                }
            });
            let mut plain = Cloud::new(positions, masses);
            let equation = Equation { walls, ..Equation::POISSON };
            let mut memory = Aligned::new(Grid::workspace_bytes(&mesh, &equation, 1).unwrap());
            let mut grid = Grid::prepare(memory.bytes(), mesh, equation, 1).unwrap();
            for _ in 0..5 {
                plain.step(&options(1.0), Attraction::Mesh(&mut grid, None), 1e-3).unwrap();
            }
            assert_eq!(in_medium.counters, plain.counters);
            assert!(plain.counters.count < 300 && in_medium.events.len() == plain.events.len());
            for (a, b) in in_medium.positions.iter().zip(&plain.positions) {
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-8, "{walls:?} {scheme:?}: {a:?} {b:?}");
            }
            for (a, b) in in_medium.events.iter().zip(&plain.events) {
                assert!((a.index / b.index - 1.0).abs() < 1e-12 && a.label == b.label);
            }
        }
    }
}

#[test]
fn a_solve_that_does_not_converge_changes_nothing() {
    let mesh = Mesh::new([-1.0; 2], [1.0; 2], [20, 20]).unwrap();
    let g: Vec<f64> = (0..mesh.nodes()).map(|k| if k % 21 < 8 { 1.0 } else { 10.0 }).collect();
    with_medium(mesh, Walls::NoFlux, &g, |field| {
        let mut cloud = pairs(&[[0.1, 0.2], [-0.5, 0.3]]);
        let before = (cloud.positions.clone(), cloud.masses.clone());
        let few = Limits { iterations: 2, ..LIMITS };
        let options = Options::new(1.0, 0.01);
        assert_eq!(cloud.step(&options, Attraction::Medium(field, few), 1e-3), Err(Error::NotConverged));
        assert_eq!((cloud.positions.clone(), cloud.masses.clone(), cloud.counters.step), (before.0, before.1, 7));
        assert_eq!(field.report().iterations, 2);
        cloud.step(&options, Attraction::Medium(field, LIMITS), 1e-3).unwrap();
    });
}

#[test]
fn a_step_in_c_is_that_of_core() {
    let rectangle = mollis_mesh2 { lower: [-1.0; 2], upper: [1.0; 2], cells: [20, 24] };
    let mesh = Mesh::new(rectangle.lower, rectangle.upper, rectangle.cells).unwrap();
    let g: Vec<f64> = (0..mesh.nodes()).map(|k| if k % 21 < 8 { 2.0 } else { 7.0 }).collect();
    let places = [[0.13, 0.24], [-0.57, 0.31], [0.71, -0.47]];
    let mut report = [7.0; 2];
    let medium = mollis_medium2 {
        diffusivity: g.as_ptr(),
        decay: null(),
        tolerance: LIMITS.tolerance,
        iterations: u64::from(LIMITS.iterations),
        report: &raw mut report,
    };
    let grid = mollis_grid2_options { medium: &raw const medium, ..grid_options(MOLLIS_WALLS_NO_FLUX) };
    let attraction = mollis_pks_attraction {
        kind: MOLLIS_PKS_ATTRACTION_MESH,
        mesh: &raw const rectangle,
        grid: &raw const grid,
        ..NOTHING
    };
    let options = mollis_pks_options { chi: 1.0, noise: 0.01, seed: 3, ..filled(mollis_pks_options_init) };
    let mut cloud = pairs(&places);
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
    let mut memory = Aligned::new(bytes);
    let mut call = |attraction: &mollis_pks_attraction, bytes: usize| {
        // SAFETY: live arrays of these lengths.
        unsafe {
            pks_step(
                &raw const options,
                attraction,
                n,
                cloud.positions.as_mut_ptr(),
                cloud.masses.as_mut_ptr(),
                cloud.labels.as_mut_ptr(),
                null_mut(),
                &raw mut progress,
                null(),
                0,
                1e-4,
                2,
                &raw mut events,
                null_mut(),
                memory.pointer(),
                bytes,
                null(),
            )
        }
    };
    let heavy = mollis_pks_attraction { heavy: 1.0, ..attraction };
    assert_eq!(call(&heavy, bytes), Error::Unsupported as i32);
    assert_eq!(call(&attraction, bytes - 1), Error::WorkspaceTooSmall as i32);
    let short = mollis_medium2 { iterations: 2, ..medium };
    let few = mollis_grid2_options { medium: &raw const short, ..grid };
    let few = mollis_pks_attraction { grid: &raw const few, ..attraction };
    assert_eq!(call(&few, bytes), Error::NotConverged as i32);
    // SAFETY: the medium's report lives.
    assert_eq!(unsafe { (*medium.report)[0] }, 2.0);
    assert_eq!(call(&attraction, bytes), 0);

    let mut want = pairs(&places);
    with_medium(mesh, Walls::NoFlux, &g, |field| {
        let core = Options {
            search: mollis_core::pks::search::Search {
                domain: Some([mesh.lower(), mesh.upper()]),
                ..Options::new(1.0, 0.01).search
            },
            ..Options::new(1.0, 0.01)
        };
        for _ in 0..2 {
            want.step(&core, Attraction::Medium(field, LIMITS), 1e-4).unwrap();
        }
        let last = field.report();
        assert_eq!(report, [f64::from(last.iterations), last.residual]);
    });
    assert!(cloud.positions == want.positions && cloud.masses == want.masses && cloud.labels == want.labels);
    assert_eq!((progress.count, progress.step), (want.counters.count, want.counters.step));
    assert!(events.written == want.events.len() && events.written > 0);
    for (a, b) in log.iter().zip(&want.events) {
        assert_eq!((a.index, a.label, a.time), (b.index, b.label, b.time));
    }
}
