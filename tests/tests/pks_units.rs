//! A step does not depend on the units of length, mass and time.

use mollis_core::exec::{Run, Serial};
use mollis_core::field;
use mollis_core::grid::{Equation, Grid, Mesh};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::pks::{
    Attraction, CollisionLaw, Counters, Event, Events, Heavy, Merging, Options, Report, Scheme, Setting, State, Summed,
    step, workspace_bytes,
};
use mollis_core::random::Philox;
use mollis_core::{Error, Real, Result, Scalar};
use mollis_tests::Aligned;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Force {
    Sum,
    Mesh,
    Heavy,
}

#[derive(Clone, Copy, Debug)]
struct Case {
    force: Force,
    law: CollisionLaw,
    merging: Merging,
    noise: f64,
    scheme: Scheme,
    n: usize,
}

/// What a run ends with, in the units of the run without any.
#[derive(Debug, PartialEq)]
struct End<T> {
    positions: Vec<[T; 2]>,
    masses: Vec<T>,
    labels: Vec<u64>,
    counters: Counters,
    events: Vec<Event>,
    report: Report,
}

/// Uniform numbers in [0, 1): Knuth's MMIX congruence.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 3_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Some steps in units of length, mass and time that are these powers of two, even ones for mass and time, as their square roots are taken.
fn run<T: Real>(case: Case, [length, mass, time]: [i32; 3]) -> Result<End<T>> {
    let c = T::from_f64;
    let Case { force, law, merging, noise, scheme, n } = case;
    let mut number = numbers();
    let mut positions: Vec<[T; 2]> = (0..n).map(|_| [0, 1].map(|_| c(1.8 * number() - 0.9).ldexp(length))).collect();
    let mut masses: Vec<T> = (0..n).map(|_| c(0.2 + number()).ldexp(mass)).collect();
    if force == Force::Heavy {
        masses.iter_mut().take(3).for_each(|m| *m = c(12.0).ldexp(mass));
    }
    let mut labels: Vec<u64> = (0..n as u64).collect();
    let chi = if merging == Merging::All { 1.0 } else { 6.0 };
    let mut options = Options::new(c(chi).ldexp(2 * length - mass - time), c(noise).ldexp(mass + 2 * length - time));
    (options.law, options.merging, options.scheme) = (law, merging, scheme);
    options.control.width = c(0.5).ldexp(length);
    options.search.domain = (force != Force::Sum).then(|| [c(-1.0), c(1.0)].map(|x| [x.ldexp(length); 2]));
    let blob = Blob::<T, 2>::new(Mollifier::Compact { order: 2, exponent: 4 }, c(0.125).ldexp(length)).unwrap();
    let exactly = field::Options::default();
    let mesh = Mesh::new([c(-1.0).ldexp(length); 2], [T::ONE.ldexp(length); 2], [16; 2]).unwrap();
    let summed: Summed<'_, T> = if force == Force::Sum { Some((&blob, &exactly)) } else { None };
    let mut memory = Aligned::new(workspace_bytes(n, summed, &options, 1).unwrap());
    let mut space = Aligned::new(Grid::workspace_bytes(&mesh, &Equation::POISSON, 1).unwrap());
    let mut grid = Grid::prepare(space.bytes(), mesh, Equation::POISSON, 1).unwrap();
    let softened = Heavy::softening(&mesh).unwrap();
    let heavy = Heavy { kernel: &softened, mass: c(10.0).ldexp(mass), core: softened.delta() };
    let mut counters = Counters { count: n as u64, ..Counters::default() };
    let (mut log, mut absorbed) = (vec![Event::default(); n], vec![0; n]);
    let (mut written, mut labels_written, mut report) = (0, 0, Report::default());
    for _ in 0..4 {
        let attraction = match force {
            Force::Sum => Attraction::Sum(&blob, &exactly),
            Force::Mesh => Attraction::Mesh(&mut grid, None),
            Force::Heavy => Attraction::Mesh(&mut grid, Some(&heavy)),
        };
        let state =
            State { positions: &mut positions, masses: &mut masses, labels: &mut labels, species: None, weights: None };
        let events = Events {
            events: &mut log,
            labels: &mut absorbed,
            written: &mut written,
            labels_written: &mut labels_written,
        };
        let run = &mut Run { executor: &Serial, ..Run::default() };
        let setting = Setting { options: &options, attraction, run, report: Some(&mut report) };
        let dt = c(0.002).ldexp(time);
        step(state, &mut counters, &mut Philox::new(7), dt, events, memory.bytes(), setting)?;
    }
    let left = counters.count as usize;
    counters.time = counters.time.ldexp(-time);
    log.truncate(written);
    for event in &mut log {
        (event.time, event.mass) = (event.time.ldexp(-time), event.mass.ldexp(-mass));
    }
    Ok(End {
        positions: positions[..left].iter().map(|x| x.map(|x| x.ldexp(-length))).collect(),
        masses: masses[..left].iter().map(|m| m.ldexp(-mass)).collect(),
        labels: labels[..left].to_vec(),
        counters,
        events: log,
        report,
    })
}

/// The same merges, and most places the same to roundings, which grow where many fall together.
fn near<T: Real>(a: &End<T>, b: &End<T>) -> bool {
    let kept = |end: &End<T>| end.events.iter().map(|e| (e.label, e.absorbed)).collect::<Vec<_>>();
    let places = |end: &End<T>| end.positions.clone().into_flattened();
    let close = |&(a, b): &(T, T)| (a - b).abs().to_f64() < 1e5 * T::EPSILON.to_f64();
    let (all, same) = (2 * a.labels.len(), places(a).into_iter().zip(places(b)).filter(close).count());
    kept(a) == kept(b) && all - same <= all / 4
}

fn same_in_all<T: Real>(units: &[[i32; 3]]) {
    let (mut merges, mut runs) = (0, 0);
    for force in [Force::Sum, Force::Mesh, Force::Heavy] {
        for law in [CollisionLaw::Exact, CollisionLaw::Printed] {
            for merging in [Merging::All, Merging::Hard, Merging::Never] {
                for (noise, scheme, n) in [
                    (1.0, Scheme::EulerMaruyama, 200),
                    (0.1, Scheme::StrangRk4, 40),
                    (0.0, Scheme::StrangRk4, 40),
                    (3.0, Scheme::EulerMaruyama, 520),
                ] {
                    let case = Case { force, law, merging, noise, scheme, n };
                    let want = run::<T>(case, [0; 3]).unwrap();
                    merges += want.events.len();
                    for &unit in units {
                        let got = run::<T>(case, unit).unwrap();
                        assert_eq!(
                            (got.counters.count, got.report.merges),
                            (want.counters.count, want.report.merges),
                            "{case:?} {unit:?}"
                        );
                        // The mesh's field in free space holds the logarithm of a length, whose digits depend on the unit.
                        let exact = force == Force::Sum || unit[0] == 0;
                        assert!(
                            if exact { got == want } else { merging == Merging::Never || near(&got, &want) },
                            "{case:?} {unit:?}"
                        );
                        runs += 1;
                    }
                }
            }
        }
    }
    assert!(merges > 200 && runs > 100, "{merges} {runs}");
}

#[test]
fn the_units_do_not_matter() {
    same_in_all::<f32>(&[[20, 80, 0], [-40, -30, 0], [20, -80, -4], [0, 60, 30]]);
    same_in_all::<f64>(&[[200, 520, 0], [-300, -300, 0], [0, -700, 90]]);
}

/// One step of these particles without attraction, or of two of them under the logarithm.
fn plain<T: Real>(positions: &mut [[T; 2]], masses: &mut [T], options: &Options<T>, dt: T) -> Result<Counters> {
    let n = positions.len();
    let mut labels: Vec<u64> = (0..n as u64).collect();
    let blob = Blob::<T, 2>::new(Mollifier::None, T::ZERO).unwrap();
    let exactly = field::Options::default();
    let attraction = || if n > 1 { Attraction::Sum(&blob, &exactly) } else { Attraction::None };
    let mut memory = Aligned::new(workspace_bytes(n, attraction().summed(), options, 1).unwrap());
    let mut counters = Counters { count: n as u64, ..Counters::default() };
    let (mut log, mut absorbed, mut written, mut labels_written) = ([Event::default()], [0], 0, 0);
    let state = State { positions, masses, labels: &mut labels, species: None, weights: None };
    let events =
        Events { events: &mut log, labels: &mut absorbed, written: &mut written, labels_written: &mut labels_written };
    let run = &mut Run { executor: &Serial, ..Run::default() };
    let setting = Setting { options, attraction: attraction(), run, report: None };
    step(state, &mut counters, &mut Philox::new(1), dt, events, memory.bytes(), setting)?;
    Ok(counters)
}

#[test]
fn a_jump_in_range_is_made_though_noise_times_time_is_not() {
    let jump = |noise: f32, mass: f32, dt: f32| {
        let mut positions = [[0.0_f32; 2]];
        plain(&mut positions, &mut [mass], &Options::new(0.0, noise), dt).unwrap();
        positions[0]
    };
    let [x, y] = jump(1.0, 2.0, 1.0);
    let power = |n: i32| Scalar::ldexp(1.0_f32, n);
    for (a, b, c) in
        [(93, 89, 40), (-93, -89, -40), (126, 40, 126), (-120, -20, -120), (100, -26, -120), (-4, 126, 120)]
    {
        let unit = power((a + c - b) / 2);
        assert_eq!((a + c - b) % 2, 0);
        assert_eq!(jump(power(a), 2.0 * power(b), power(c)), [x * unit, y * unit], "{a} {b} {c}");
    }
}

#[test]
fn indices_beyond_the_range_are_refused() {
    let merged = |noise: f32| {
        let (mut positions, mut masses) = ([[0.0_f32, 0.0], [1e9, 0.0]], [1e30_f32; 2]);
        plain(&mut positions, &mut masses, &Options::new(1e-11, noise), 1.0)
            // Before they merge they move by 1.6e9, whose last bit is 128.
            .map(|counters| (counters.count, (positions[0][0] - 5e8).abs() <= 256.0, masses[0]))
    };
    // The index is -8e47 / noise.
    assert_eq!(merged(0.0), Ok((1, true, 2e30)));
    assert_eq!(merged(1e15), Ok((1, true, 2e30)));
    assert_eq!(merged(1.0), Err(Error::OutOfDomain));
}
