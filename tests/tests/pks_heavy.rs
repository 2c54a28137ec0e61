//! Heavy particles beside a mesh: their pairs are exact and conserve momentum, and they are chosen by mass. Without heavy particles results
//! do not change.

use mollis_core::exec::{Executor, Run, Serial};
use mollis_core::field::Interaction;
use mollis_core::grid::{Equation, Grid, Mesh, Order, Walls};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::pks::{
    Attraction, Counters, Events, Heavy, MAX_HEAVY, Merging, Options, Scheme, Setting, State, step, workspace_bytes,
};
use mollis_core::random::Philox;
use mollis_core::{Error, Real, Result, Scalar};
use mollis_tests::{Aligned, Threads};

const CELLS: usize = 32;
/// The mesh width.
const H: f64 = 2.0 / CELLS as f64;
const CORE: f64 = H / 4.0;

/// Evenly spread numbers in 0..1: multiples of the golden ratio and of the square root of two.
fn spread(k: usize) -> [f64; 2] {
    [0.618_033_988_749_894_9, 0.414_213_562_373_095_05].map(|step| (k as f64 * step).fract())
}

fn blob<T: Real>() -> Blob<T, 2> {
    Blob::new(Mollifier::Compact { order: 2, exponent: 4 }, T::from_f64(CORE)).unwrap()
}

fn equation<T: Real>() -> Equation<T> {
    Equation { screening: T::ZERO, walls: Walls::Free, order: Order::Second }
}

#[derive(Clone, PartialEq)]
struct Particles<T> {
    positions: Vec<[T; 2]>,
    masses: Vec<T>,
}

/// Makes this many steps on [-1, 1]^2.
fn steps<T: Real>(
    particles: &mut Particles<T>,
    options: &Options<T>,
    equation: Equation<T>,
    heavy: Option<&Heavy<'_, T>>,
    dt: f64,
    steps: usize,
    executor: &dyn Executor,
) -> Result<()> {
    let n = particles.positions.len();
    let mesh = Mesh::new([-T::ONE; 2], [T::ONE; 2], [CELLS; 2]).unwrap();
    let workers = executor.workers();
    let mut memory = Aligned::new(Grid::workspace_bytes(&mesh, &equation, workers).unwrap());
    let mut grid = Grid::prepare(memory.bytes(), mesh, equation, workers).unwrap();
    let mut workspace = Aligned::new(workspace_bytes(n, None, options, workers).unwrap());
    let mut labels: Vec<u64> = (0..n as u64).collect();
    let mut counters = Counters { count: n as u64, ..Counters::default() };
    for _ in 0..steps {
        step(
            State {
                positions: &mut particles.positions,
                masses: &mut particles.masses,
                labels: &mut labels,
                species: None,
                weights: None,
            },
            &mut counters,
            &mut Philox::new(3),
            T::from_f64(dt),
            Events { events: &mut [], labels: &mut [], written: &mut 0, labels_written: &mut 0 },
            workspace.bytes(),
            Setting {
                options,
                attraction: Attraction::Mesh(&mut grid, heavy),
                run: &mut Run { executor, ..Run::default() },
                report: None,
            },
        )?;
    }
    Ok(())
}

/// Attraction alone: no noise, no merging.
fn quiet<T: Real>(chi: f64) -> Options<T> {
    Options { merging: Merging::Never, ..Options::new(T::from_f64(chi), T::ZERO) }
}

#[test]
fn a_heavy_particle_attracts_exactly_at_every_distance() {
    /// The largest relative error of the speeds of light particles at 0.01 to 12 mesh widths from one of mass 1.
    fn error<T: Real>(kernel: &dyn Interaction<T, 2>, equation: Equation<T>, scheme: Scheme, with: bool) -> f64 {
        let heavy = Heavy { kernel, mass: T::HALF, core: T::from_f64(CORE) };
        let at = [0.123, -0.077].map(T::from_f64);
        let mut start = Particles { positions: vec![at], masses: vec![T::ONE] };
        for k in 0..200 {
            let r = H * 0.01 * 1200_f64.powf(k as f64 / 199.0);
            let (sin, cos) = (2.0 * std::f64::consts::PI * spread(k)[0]).sin_cos();
            start.positions.push([at[0] + T::from_f64(r * cos), at[1] + T::from_f64(r * sin)]);
            start.masses.push(T::from_f64(1e-12));
        }
        // The step is so short that the field is that of the start, and long enough to keep the move above the rounding of positions.
        let (chi, dt) = (1.0, if T::EPSILON > T::from_f64(1e-10) { 2e-5 } else { 1e-8 });
        let mut end = start.clone();
        let options = Options { scheme, ..quiet(chi) };
        steps(&mut end, &options, equation, with.then_some(&heavy), dt, 1, &Serial).unwrap();
        let mut worst = 0.0_f64;
        for (x, y) in start.positions.iter().zip(&end.positions).skip(1) {
            let d = [x[0] - at[0], x[1] - at[1]].map(Scalar::to_f64);
            let r = d[0].hypot(d[1]);
            let factor = kernel.gradient_factor(T::from_f64(r)).to_f64();
            let miss = [0, 1].map(|k| (y[k] - x[k]).to_f64() + chi * dt * factor * d[k]);
            worst = worst.max(miss[0].hypot(miss[1]) / (chi * dt * factor * r));
        }
        worst
    }
    for order in [Order::Second, Order::Fourth] {
        for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
            let equation = Equation { order, ..equation() };
            let (with, without) = [true, false].map(|with| error::<f64>(&blob(), equation, scheme, with)).into();
            // In this time both schemes move by up to 3e-5 of the distance.
            assert!(with < 1e-4 && without > 0.5, "{order:?} {scheme:?}: {with:e}, on the mesh {without:e}");
        }
    }
    let single = error::<f32>(&blob(), equation(), Scheme::EulerMaruyama, true);
    assert!(single < 5e-2, "{single:e}");
    let screened = Equation { screening: 3.0, ..equation() };
    let terms = [Term { law: Law::Screened { k: 3.0 }, coefficient: 1.0 }];
    let mollifier = Mollifier::Compact { order: 2, exponent: 4 };
    let mut memory = Aligned::new(Kernel::<f64, 2>::workspace_bytes(&terms, mollifier).unwrap());
    let kernel = Kernel::prepare(memory.bytes(), &terms, mollifier, CORE).unwrap();
    let found = error::<f64>(&kernel, screened, Scheme::EulerMaruyama, true);
    assert!(found < 1e-4, "{found:e}");
}

#[test]
fn pairs_of_heavy_and_light_conserve_momentum() {
    for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
        let mut start = Particles { positions: Vec::new(), masses: Vec::new() };
        for k in 0..600 {
            let [a, b] = spread(k);
            start.positions.push([0.8 * a - 0.4, 0.8 * b - 0.3]);
            start.masses.push(if k % 150 == 7 { 3.0 } else { 1e-2 });
        }
        let kernel = blob();
        let heavy = Heavy { kernel: &kernel, mass: 1.0, core: CORE };
        let options = Options { scheme, ..quiet(1.0) };
        let drift = |heavy: Option<&Heavy<'_, f64>>| {
            let mut end = start.clone();
            steps(&mut end, &options, equation(), heavy, 1e-9, 1, &Serial).unwrap();
            let (mut sum, mut size) = ([0.0_f64; 2], 0.0_f64);
            for ((x, y), m) in start.positions.iter().zip(&end.positions).zip(&start.masses) {
                let way = [y[0] - x[0], y[1] - x[1]];
                sum = [sum[0] + m * way[0], sum[1] + m * way[1]];
                size += m * way[0].hypot(way[1]);
            }
            sum[0].hypot(sum[1]) / size
        };
        // The remaining momentum comes from the border, whose field is prescribed, for the mass of the light particles.
        let (with, without) = (drift(Some(&heavy)), drift(None));
        assert!(with < 3e-5 && with < 0.02 * without, "{scheme:?}: {with:e}, on the mesh {without:e}");
    }
}

#[test]
fn what_falls_in_within_a_step_takes_the_heavy_one_along_by_its_own_mass() {
    // Light particles on one side fall in during the first part of the step. With the force of the start the heavy one would move too far.
    for (radius, dt) in [(0.5 * H, 1e-4), (0.5 * H, 1e-3), (2.0 * H, 1e-3), (2.0 * H, 4e-3)] {
        let mut start = Particles { positions: vec![[0.01, 0.02]], masses: vec![10.0] };
        for k in 0..1000 {
            let [a, b] = spread(k);
            let (sin, cos) = (std::f64::consts::PI * (a - 0.5)).sin_cos();
            let r = radius * b.sqrt();
            start.positions.push([0.01 + r * cos, 0.02 + r * sin]);
            start.masses.push(1e-3);
        }
        let kernel = blob();
        let heavy = Heavy { kernel: &kernel, mass: 1.0, core: CORE };
        let mut end = start.clone();
        steps(&mut end, &quiet(1.0), equation(), Some(&heavy), dt, 1, &Serial).unwrap();
        let way = |k: usize| [0, 1].map(|c| start.masses[k] * (end.positions[k][c] - start.positions[k][c]));
        let light = (1..1001).map(way).fold([0.0; 2], |sum, w| [sum[0] + w[0], sum[1] + w[1]]);
        let own = way(0);
        let off = (own[0] + light[0]).hypot(own[1] + light[1]) / light[0].hypot(light[1]);
        // The error is largest where the fall just ends at the edge of the softening.
        assert!(off < if dt == 1e-4 { 0.12 } else { 0.05 }, "{radius} {dt}: {off}, {own:?}, {light:?}");
    }
}

#[test]
fn two_heavy_particles_meet_at_the_rate_of_the_theory() {
    // d |x|^2 / dt = -chi M / pi for the vector x between two particles.
    let rate = |heavy: Option<&Heavy<'_, f64>>| {
        let mut pair = Particles { positions: vec![[-0.21, -0.1], [0.33, 0.17]], masses: vec![3.0, 7.0] };
        let square = |p: &Particles<f64>| {
            let [a, b] = [p.positions[0], p.positions[1]];
            (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
        };
        let before = square(&pair);
        // The squared distance falls to 1%: from three mesh widths to a third of one.
        let time = 0.99 * before * std::f64::consts::PI / 10.0;
        steps(&mut pair, &quiet(1.0), equation(), heavy, time / 100.0, 100, &Serial).unwrap();
        (before - square(&pair)) / time * std::f64::consts::PI / 10.0
    };
    let kernel = blob();
    let with = rate(Some(&Heavy { kernel: &kernel, mass: 1.0, core: CORE }));
    let without = rate(None);
    assert!(
        (with - 1.0).abs() < 1e-3 && (without - 1.0).abs() > 4.0 * (with - 1.0).abs(),
        "{with}, on the mesh {without}"
    );
}

#[test]
fn the_heaviest_are_taken_and_none_where_there_is_none() {
    // Ten more than the maximum. The first ten are the lightest.
    let mut start = Particles { positions: Vec::new(), masses: Vec::new() };
    let n = MAX_HEAVY + 10;
    for k in 0..n {
        start.positions.push([k % 9, k / 9].map(|i| 0.19 * i as f64 - 0.77));
        start.masses.push(if k < 10 { 1.0 } else { 1.5 + 1e-3 * k as f64 });
    }
    // One light particle beside each, much closer than a mesh width.
    for k in 0..n {
        let [x, y] = start.positions[k];
        start.positions.push([x + 0.3 * CORE, y]);
        start.masses.push(1e-12);
    }
    let kernel = blob();
    let heavy = Heavy { kernel: &kernel, mass: 1.0, core: CORE };
    let (mut with, mut without, dt) = (start.clone(), start.clone(), 1e-9);
    steps(&mut with, &quiet(1.0), equation(), Some(&heavy), dt, 1, &Serial).unwrap();
    steps(&mut without, &quiet(1.0), equation(), None, dt, 1, &Serial).unwrap();
    let towards = |p: &Particles<f64>, k: usize| (start.positions[n + k][0] - p.positions[n + k][0]) / dt;
    for k in 0..n {
        let own = start.masses[k] * kernel.gradient_factor(0.3 * CORE) * 0.3 * CORE;
        // The effect of the others is nearly the same by pairs and on the mesh, and on the mesh that of the adjacent one is small.
        let more = towards(&with, k) - towards(&without, k);
        assert!(if k < 10 { more.abs() < 0.1 * own } else { more > 0.7 * own }, "{k}: {more} of {own}");
    }
    let none = Heavy { mass: 100.0, ..heavy };
    let mut nobody = start.clone();
    steps(&mut nobody, &quiet(1.0), equation(), Some(&none), dt, 1, &Serial).unwrap();
    assert!(nobody == without);
}

/// Of equal masses the first are taken. The others act through the mesh.
#[test]
fn of_equal_masses_the_first_are_taken() {
    let n = MAX_HEAVY + 6;
    let mut start = Particles { positions: Vec::new(), masses: vec![1.0; n] };
    start.positions = (0..n).map(|k| [k % 9, k / 9].map(|i| 0.19 * i as f64 - 0.77)).collect();
    for k in 0..n {
        let [x, y] = start.positions[k];
        start.positions.push([x + 0.3 * CORE, y]);
        start.masses.push(1e-12);
    }
    let kernel = blob();
    let heavy = Heavy { kernel: &kernel, mass: 1.0, core: CORE };
    let dt = 1e-9;
    let own = kernel.gradient_factor(0.3 * CORE) * 0.3 * CORE;
    // The speed of the light particle beside each: by pairs, and by the mesh, on which the effect of the adjacent one is small.
    let taken = |start: &Particles<f64>| -> Vec<bool> {
        let speeds = |heavy| {
            let mut moved = start.clone();
            steps(&mut moved, &quiet(1.0), equation(), heavy, dt, 1, &Serial).unwrap();
            (n..2 * n).map(|k| (start.positions[k][0] - moved.positions[k][0]) / dt).collect::<Vec<_>>()
        };
        let (with, without) = (speeds(Some(&heavy)), speeds(None));
        with.iter().zip(without).map(|(with, without)| with - without > 0.5 * own).collect()
    };
    let first: Vec<bool> = (0..n).map(|k| k < MAX_HEAVY).collect();
    assert_eq!(taken(&start), first);
    // A heavier particle at the end replaces the last of those taken.
    start.masses[n - 1] = 1.5;
    let with_last: Vec<bool> = (0..n).map(|k| k < MAX_HEAVY - 1 || k == n - 1).collect();
    assert_eq!(taken(&start), with_last);
}

#[test]
fn threads_do_not_change_the_bits() {
    let mut start = Particles { positions: Vec::new(), masses: Vec::new() };
    for k in 0..20_000 {
        let [a, b] = spread(k);
        start.positions.push([1.8 * a - 0.9, 1.8 * b - 0.9]);
        start.masses.push(if k % 4000 == 999 { 8.0 } else { 1e-3 });
    }
    let kernel = blob();
    let heavy = Heavy { kernel: &kernel, mass: 1.0, core: CORE };
    for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
        let options = Options { noise: 1e-3, scheme, ..quiet(1.0) };
        let run = |workers| {
            let mut p = start.clone();
            steps(&mut p, &options, equation(), Some(&heavy), 1e-4, 3, &Threads(workers)).unwrap();
            p.positions.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>()
        };
        let one = run(1);
        assert!(one == run(2) && one == run(5));
    }
}

#[test]
fn impossible_choices_are_refused() {
    let start = Particles { positions: vec![[0.1, 0.2], [0.3, -0.1]], masses: vec![1.0, 2.0] };
    let kernel = blob();
    let good = Heavy { kernel: &kernel, mass: 1.0, core: CORE };
    let bare = Blob::new(Mollifier::None, 1.0).unwrap();
    let walls = Equation { walls: Walls::NoFlux, ..equation() };
    for (heavy, equation, want) in [
        (Heavy { mass: 0.0, ..good }, equation(), Error::OutOfDomain),
        (Heavy { mass: -1.0, ..good }, equation(), Error::OutOfDomain),
        (Heavy { mass: f64::NAN, ..good }, equation(), Error::NotFinite),
        (Heavy { core: 0.0, ..good }, equation(), Error::OutOfDomain),
        (Heavy { kernel: &bare, ..good }, equation(), Error::Unsupported),
        (Heavy { core: f64::INFINITY, ..good }, equation(), Error::NotFinite),
        (good, walls, Error::Unsupported),
    ] {
        let mut p = start.clone();
        assert_eq!(steps(&mut p, &quiet(1.0), equation, Some(&heavy), 1e-3, 1, &Serial), Err(want));
        assert!(p == start);
    }
}
