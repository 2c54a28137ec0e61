//! Coalescing particles of different sensitivities (Zhelezov & Fatkullin, Section 4.5): weights beside the masses.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use std::collections::BTreeMap;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::euler_maruyama::Control;
use mollis_core::exec::Run;
use mollis_core::field::{self, Interaction};
use mollis_core::grid::{Coefficients, Equation, Grid, Limits, Mesh, Variable, Walls};
use mollis_core::pks::theory::{
    Constants, Group, Species, noise, second_moment_rate_of_species, species_mu, species_share,
};
use mollis_core::pks::{
    Attraction, Counters, Event, Events, Heavy, Merging, Options, Report, Scheme, Setting, State, step, workspace_bytes,
};
use mollis_core::random::Philox;
use mollis_core::real::DoubleWord;
use mollis_core::special::incomplete_gamma;
use mollis_core::{Error, Real, Result};
use mollis_tests::{Aligned, Split};

/// V = log r / (2 pi), softened by Plummer's law over this length.
#[derive(Clone, Copy)]
struct Plummer(f64);
impl<T: Real> Interaction<T, 2> for Plummer {
    fn value(&self, r: T) -> T {
        (r * r + T::from_f64(self.0 * self.0)).log() / (T::from_i32(4) * T::PI)
    }
    fn gradient_factor(&self, r: T) -> T {
        T::ONE / (T::TWO * T::PI * (r * r + T::from_f64(self.0 * self.0)))
    }
    fn laplacian(&self, _: T) -> T {
        T::ZERO
    }
    fn is_singular(&self) -> bool {
        self.0 == 0.0
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Force {
    None,
    Sum(f64),
    Mesh,
    Heavy,
    Medium,
}

#[derive(Clone, Debug)]
struct Crowd<T> {
    positions: Vec<[T; 2]>,
    masses: Vec<T>,
    weights: Option<Vec<T>>,
    labels: Vec<u64>,
    counters: Counters,
    report: Report,
    events: Vec<Event>,
    absorbed: Vec<u64>,
}

impl<T: Real> Crowd<T> {
    fn new(positions: Vec<[T; 2]>, masses: Vec<T>, weights: Option<Vec<T>>) -> Self {
        let n = positions.len();
        let labels = (0..n as u64).map(|k| k * 37 % 1009).collect();
        let counters = Counters { count: n as u64, ..Counters::default() };
        let (report, events, absorbed) = (Report::default(), Vec::new(), Vec::new());
        Self { positions, masses, weights, labels, counters, report, events, absorbed }
    }

    fn n(&self) -> usize {
        self.counters.count as usize
    }

    /// One step with room for so many events at a time.
    fn step(&mut self, force: Force, options: &Options<T>, seed: u64, dt: f64, room: usize) -> Result<()> {
        let n = self.positions.len();
        let c = T::from_f64;
        let exactly = field::Options::default();
        let softened = Plummer(if let Force::Sum(length) = force { length } else { 0.01 });
        let summed: Option<(&dyn Interaction<T, 2>, _)> =
            matches!(force, Force::Sum(_)).then_some((&softened, &exactly));
        let mut memory = Aligned::new(workspace_bytes(n, summed, options, 1).unwrap());
        let mesh = Mesh::new([c(-1.0); 2], [T::ONE; 2], [32; 2]).unwrap();
        let mut on_grid = Aligned::new(Grid::workspace_bytes(&mesh, &Equation::POISSON, 1).unwrap());
        let mut grid = matches!(force, Force::Mesh | Force::Heavy)
            .then(|| Grid::prepare(on_grid.bytes(), mesh, Equation::POISSON, 1).unwrap());
        let g: Vec<T> = (0..mesh.nodes()).map(|k| c(1.0 + (k % 33) as f64 / 33.0)).collect();
        let mut in_medium = Aligned::new(Variable::workspace_bytes(&mesh, Walls::NoFlux, 1).unwrap());
        let medium = Coefficients { diffusivity: &g, decay: None };
        let mut field = (force == Force::Medium)
            .then(|| Variable::prepare(in_medium.bytes(), mesh, Walls::NoFlux, &medium, 1).unwrap());
        let heavy = Heavy { kernel: &softened, mass: c(0.5), core: c(0.01) };
        let limits = Limits { tolerance: c(1e-5), iterations: 100 };
        loop {
            let (mut events, mut labels) = (vec![Event::default(); room], vec![0; n]);
            let (mut written, mut labels_written) = (0, 0);
            let attraction = match (force, &mut grid, &mut field) {
                (Force::Sum(_), ..) => Attraction::Sum(&softened, &exactly),
                (Force::Heavy, Some(grid), _) => Attraction::Mesh(grid, Some(&heavy)),
                (_, Some(grid), _) => Attraction::Mesh(grid, None),
                (.., Some(field)) => Attraction::Medium(field, limits),
                _ => Attraction::None,
            };
            let done = step(
                State {
                    positions: &mut self.positions,
                    masses: &mut self.masses,
                    labels: &mut self.labels,
                    species: None,
                    weights: self.weights.as_deref_mut(),
                },
                &mut self.counters,
                &mut Philox::new(seed),
                c(dt),
                Events {
                    events: &mut events,
                    labels: &mut labels,
                    written: &mut written,
                    labels_written: &mut labels_written,
                },
                memory.bytes(),
                Setting { options, attraction, run: &mut Run::default(), report: Some(&mut self.report) },
            );
            for event in &events[..written] {
                self.events.push(Event { first: self.absorbed.len() as u64, ..*event });
                let from = event.first as usize;
                self.absorbed.extend(&labels[from..from + event.absorbed as usize]);
            }
            match done {
                Err(Error::EventsFull) => {}
                done => return done,
            }
        }
    }

    /// Everything that a step leaves, as bits.
    fn bits(&self) -> Vec<[u64; 4]> {
        let weights = self.weights.as_ref().unwrap_or(&self.masses);
        let rows = (0..self.n()).map(|i| {
            let [x, y] = self.positions[i].map(T::to_f64);
            [
                x.to_bits(),
                y.to_bits(),
                self.masses[i].to_f64().to_bits(),
                weights[i].to_f64().to_bits() ^ self.labels[i],
            ]
        });
        rows.collect()
    }

    /// The centre of the weights, and the second moment Y about it.
    fn moment(&self) -> ([f64; 2], f64) {
        let weights = self.weights.as_ref().unwrap_or(&self.masses);
        let of = |f: &dyn Fn([f64; 2]) -> f64| {
            let rows = self.positions.iter().zip(weights).take(self.n());
            rows.map(|(x, w)| w.to_f64() * f(x.map(T::to_f64))).sum::<f64>()
        };
        let whole = of(&|_| 1.0);
        let centre = [of(&|x| x[0]) / whole, of(&|x| x[1]) / whole];
        (centre, of(&|x| (x[0] - centre[0]).powi(2) + (x[1] - centre[1]).powi(2)) / whole)
    }
}

/// A dense clump in a cloud, with sensitivities of one of four values.
fn collapsing<T: Real>(n: usize, seed: u64) -> Crowd<T> {
    let mut random = Split(seed);
    let mut positions = Vec::new();
    for i in 0..n {
        let size = if i % 3 == 0 { 0.7 } else { 0.15 };
        positions.push([0.2, -0.1].map(|c| T::from_f64(c + size * (random.uniform() + random.uniform() - 1.0))));
    }
    let masses: Vec<T> = (0..n).map(|_| T::from_f64(60.0 / n as f64 * (0.5 + random.uniform()))).collect();
    let chi = |k: u64| T::from_f64([0.5, 0.8, 1.0, 1.7][(k % 4) as usize]);
    let weights = masses.iter().map(|&m| m / chi(random.next())).collect();
    Crowd::new(positions, masses, Some(weights))
}

#[test]
fn equal_sensitivities_change_no_bit_and_cost_nothing() {
    fn check<T: Real>(force: Force, scheme: Scheme) {
        let c = T::from_f64;
        let given = collapsing::<T>(600, 3);
        let options = Options { scheme, ..Options::new(c(1.5), c(noise(60.0, 1.0, 600))) };
        let four = c(4.0);
        let fourfold = Options { chi: four * options.chi, noise: four * options.noise, ..options };
        let plain = Crowd { weights: None, ..given.clone() };
        // Sensitivities of 1, and of 4, whose root is exact, too.
        for (sensitivity, as_if) in [(T::ONE, options), (four, fourfold)] {
            let weights: Vec<T> = given.masses.iter().map(|&m| m / sensitivity).collect();
            let mut weighted = Crowd { weights: Some(weights), ..given.clone() };
            let mut plain = plain.clone();
            for _ in 0..8 {
                weighted.step(force, &options, 5, 1e-3, 700).unwrap();
                plain.step(force, &as_if, 5, 1e-3, 700).unwrap();
            }
            assert!(force == Force::None || plain.report.merges > 3, "{force:?} {:?}", plain.report);
            assert_eq!((weighted.report, weighted.counters), (plain.report, plain.counters));
            assert_eq!((&weighted.events, &weighted.absorbed), (&plain.events, &plain.absorbed));
            let weights = weighted.weights.take().unwrap();
            assert_eq!(weighted.bits(), plain.bits());
            assert!(weights.iter().zip(&weighted.masses).take(weighted.n()).all(|(&w, &m)| w == m / sensitivity));
        }
    }
    for force in [Force::None, Force::Sum(0.01), Force::Mesh, Force::Medium] {
        for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
            check::<f64>(force, scheme);
            check::<f32>(force, scheme);
        }
    }
}

/// Without noise the second moment of the weights is a straight line, whatever the sensitivities, and their centre rests; (4.28) as printed, for the moment of the masses, is wrong.
#[test]
fn the_moment_of_the_weights_has_the_rate_of_the_theory() {
    let mut random = Split(8);
    let mut printed = 0.0_f64;
    for _ in 0..20 {
        let n = 3 + random.next() as usize % 5;
        let masses: Vec<f64> = (0..n).map(|_| 0.2 + random.uniform()).collect();
        let weights: Vec<f64> = masses.iter().map(|m| m / 10_f64.powf(2.0 * random.uniform() - 1.0)).collect();
        let place = |i: usize| {
            let (angle, r) = (core::f64::consts::TAU * i as f64 / n as f64, 0.7 + 0.3 * random.uniform());
            [3.0 + r * angle.cos(), r * angle.sin() - 7.0]
        };
        let positions = (0..n).map(place).collect();
        let mut crowd = Crowd::new(positions, masses.clone(), Some(weights.clone()));
        // Repulsion, so that nothing merges; RK4.
        let options = Options { scheme: Scheme::StrangRk4, ..Options::new(-1.0, 0.0) };
        let (start, before) = crowd.moment();
        let by_masses = |crowd: &Crowd<f64>| Crowd { weights: None, ..crowd.clone() }.moment().1;
        let masses_before = by_masses(&crowd);
        for _ in 0..200 {
            crowd.step(Force::Sum(0.0), &options, 1, 1e-4, 1).unwrap();
        }
        let (end, after) = crowd.moment();
        let group = Group::of(&masses);
        let rate = -Constants::new(-1.0, 0.0).gamma * -group.pairs / weights.iter().sum::<f64>();
        // Distances are at least 0.6, and speeds at most 10 * 7 * 1.2 / (2 pi 0.6) = 22, so RK4's error is of order (1e-4 * 22 / 0.6)^4 = 2e-10; that of the difference is 1e-15 * 60 / 0.02 / rate.
        assert!(((after - before) / 0.02 / rate - 1.0).abs() < 1e-6, "{} {rate}", (after - before) / 0.02);
        assert!((start[0] - end[0]).abs() + (start[1] - end[1]).abs() < 1e-12, "{start:?} {end:?}");
        let of_masses = -Constants::new(-1.0, 0.0).gamma * -group.pairs / group.mass;
        printed = printed.max(((by_masses(&crowd) - masses_before) / 0.02 / of_masses - 1.0).abs());
    }
    assert!(printed > 0.2, "{printed}");
}

/// With noise the mean is alpha of the theory.
#[test]
fn the_mean_moment_with_noise_is_that_of_the_theory() {
    let masses = vec![0.4, 1.0, 0.7];
    let weights = vec![0.4 / 0.3, 1.0 / 2.5, 0.7];
    let (chi, mu) = (-6.0, 0.5);
    let law = Constants::new(chi, mu);
    let alpha = law.alpha(&Group::of(&masses)) * masses.iter().sum::<f64>() / weights.iter().sum::<f64>();
    let (runs, steps, dt) = (4000, 25, 4e-3);
    let control = Control { width: f64::INFINITY, at_least: 4, at_most: 1000 };
    let options = Options { control, ..Options::new(chi, mu) };
    let (mut sum, mut squares) = (0.0, 0.0);
    for seed in 0..runs {
        let start = vec![[0.0, 0.0], [0.8, 0.1], [-0.2, 0.9]];
        let mut crowd = Crowd::new(start, masses.clone(), Some(weights.clone()));
        let (_, before) = crowd.moment();
        for _ in 0..steps {
            crowd.step(Force::Sum(0.05), &options, seed, dt, 2).unwrap();
        }
        let rate = (crowd.moment().1 - before) / (f64::from(steps) * dt);
        sum += rate;
        squares += rate * rate;
    }
    let n = runs as f64;
    let (mean, error) = (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt());
    println!("mean {mean} +- {error}, alpha {alpha}");
    // Repelled particles seldom come within the softening length of 0.05, which takes 1% off there; four standard errors.
    assert!((mean - alpha).abs() < 4.0 * error + 0.01 * alpha, "{mean} +- {error}, {alpha}");
    // Had the noise the masses' amplitude, it would be another one.
    assert!(error < 0.02 * alpha);
}

/// Two particles of different sensitivities: the time of their collision follows the law of the index of their masses and of Y and beta of their weights.
#[test]
fn collision_times_follow_the_law() {
    let (masses, weights) = ([1.0, 3.0], [1.0 / 0.4, 3.0 / 1.5]);
    let whole: f64 = weights.iter().sum();
    let moment = weights[0] * weights[1] / whole.powi(2);
    for nu in [-0.6, -1.5] {
        let (n, mu) = (1500, 1.0);
        let chi = -nu * 2.0 * mu / masses[0] / masses[1] * core::f64::consts::TAU;
        let mut options = Options::new(chi, mu);
        options.probability = 1e-12;
        options.control = Control { width: f64::INFINITY, at_least: 64, at_most: 1000 };
        let law = |t: f64| incomplete_gamma::upper(-nu, moment * whole / (4.0 * mu * t));
        let horizon = moment * whole / (4.0 * mu * incomplete_gamma::upper_inverse(-nu, 0.85));
        let mut times = Vec::new();
        for seed in 0..n {
            let mut pair = Crowd::new(vec![[0.0, 0.0], [1.0, 0.0]], masses.to_vec(), Some(weights.to_vec()));
            while pair.n() == 2 && pair.counters.time < horizon {
                let dt = (pair.moment().1 * whole / 40.0).max(0.02);
                pair.step(Force::Sum(0.0), &options, seed, dt, 1).unwrap();
            }
            times.extend(pair.events.iter().map(|event| event.time).filter(|&t| t <= horizon));
            if let [event] = pair.events[..] {
                assert!((event.index - nu).abs() < 1e-12 && pair.weights.unwrap()[0] == whole);
            }
        }
        times.sort_by(f64::total_cmp);
        let n = n as f64;
        let off = |(k, &t): (usize, &f64)| (law(t) - k as f64 / n).abs().max((law(t) - (k as f64 + 1.0) / n).abs());
        let distance = times.iter().enumerate().map(off).fold(0.0, f64::max) * n.sqrt();
        println!("nu {nu}: D sqrt(n) = {distance}");
        // The 99.9% point of Kolmogorov's law.
        assert!(distance < 1.95, "{nu}: {distance}");
    }
}

/// The event log replays masses and weights bitwise; the index is that of the masses, and the place the centre of the weights.
#[test]
fn merging_adds_masses_and_weights() {
    fn check<T: Real>(force: Force, room: usize) -> Vec<[u64; 4]> {
        let start = collapsing::<T>(700, 1);
        let mut crowd = start.clone();
        let options = Options::new(T::ONE, T::from_f64(noise(60.0, 1.0, 700)));
        for _ in 0..15 {
            crowd.step(force, &options, 5, 1e-3, room).unwrap();
        }
        assert!(crowd.n() < 680 && crowd.report.merges > 20, "{force:?} {} {:?}", crowd.n(), crowd.report);
        let column =
            |values: &[T]| start.labels.iter().copied().zip(values.iter().copied()).collect::<BTreeMap<_, _>>();
        let (mut masses, mut weights) = (column(&start.masses), column(start.weights.as_ref().unwrap()));
        let law = Constants { chi: options.chi, noise: options.noise, gamma: options.gamma };
        for event in &crowd.events {
            let from = event.first as usize;
            let absorbed = &crowd.absorbed[from..from + event.absorbed as usize];
            let members: Vec<T> = core::iter::once(&event.label).chain(absorbed).map(|label| masses[label]).collect();
            let index = law.index(&Group::of(&members)).to_f64();
            // Roundings of masses over the largest sensitivity, of two sums over pairs, and of the difference to N - 2.
            let scale = 1.0 + members.len() as f64 + index.abs();
            let bound = 8.0 * members.len() as f64 * T::EPSILON.to_f64() * scale;
            assert!(force == Force::Medium || (event.index - index).abs() <= bound, "{} {index}", event.index);
            for column in [&mut masses, &mut weights] {
                let mut sum = DoubleWord::from(column[&event.label]);
                absorbed.iter().for_each(|label| sum = sum.plus(column.remove(label).unwrap()));
                column.insert(event.label, sum.hi);
            }
            assert_eq!(masses[&event.label].to_f64(), event.mass);
        }
        assert_eq!(masses.len(), crowd.n());
        for i in 0..crowd.n() {
            let label = crowd.labels[i];
            assert!(masses[&label] == crowd.masses[i] && weights[&label] == crowd.weights.as_ref().unwrap()[i]);
        }
        crowd.bits()
    }
    for force in [Force::Sum(0.01), Force::Mesh, Force::Medium] {
        // The room for events changes nothing.
        assert_eq!(check::<f64>(force, 700), check::<f64>(force, 1));
        check::<f32>(force, 700);
    }
    // Two that all but touch merge at the centre of their weights.
    let start = [[0.25, 0.5], [0.2500001, 0.5000001]];
    let mut pair = Crowd::new(start.to_vec(), vec![1.0, 2.0], Some(vec![4.0, 1.0]));
    pair.counters.step = 7;
    let still =
        Options { control: Control { width: f64::INFINITY, at_least: 1, at_most: 1 }, ..Options::new(1.0, 1e-12) };
    pair.step(Force::None, &Options { chi: 0.0, ..still }, 1, 1e-9, 1).unwrap();
    assert_eq!(pair.n(), 2);
    pair.step(Force::Mesh, &Options { chi: 1e-3, ..still }, 1, 1e-9, 1).unwrap();
    assert_eq!(pair.n(), 1);
    for ((merged, first), second) in pair.positions[0].iter().zip(start[0]).zip(start[1]) {
        // The motion in 1e-9 is below 1e-10.
        assert!((merged - (0.8 * first + 0.2 * second)).abs() < 1e-9, "{pair:?}");
    }
}

/// Many particles of species with different diffusivities and sensitivities: the moment has the rate (4.28) of species.
#[test]
fn species_have_the_rate_of_their_sensitivities() {
    let all = [
        Species { mass: 8.0, mu: 2.0, sensitivity: 0.5 },
        Species { mass: 6.0, mu: 1.0, sensitivity: 1.5 },
        Species { mass: 4.0, mu: 0.5, sensitivity: 1.0 },
    ];
    let (chi, whole) = (1.0, 18.0);
    let rate = second_moment_rate_of_species(&all, chi);
    let shares = all.map(|s| species_share(&all, &s));
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    let mut rates = Vec::new();
    for seed in 0..6 {
        let n = 4000.0;
        let mut random = Split(90 + seed);
        let (mut positions, mut masses, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for (k, (species, share)) in all.iter().zip(&shares).enumerate() {
            let count = (share * n).round();
            for _ in 0..count as usize {
                let place = [0.3 * k as f64 - 0.3, 0.1 - 0.1 * k as f64];
                positions.push(place.map(|c| c + 0.4 * (random.uniform() + random.uniform() - 1.0)));
                masses.push(species.mass / count);
                weights.push(species.mass / count / species.sensitivity);
            }
        }
        let particles = masses.len();
        let mut crowd = Crowd::new(positions, masses, Some(weights));
        let mut options = Options::new(chi, noise(whole, species_mu(&all), particles));
        options.merging = Merging::Hard;
        // Diffusivities are the species'.
        let diffusivity = options.noise / crowd.weights.as_ref().unwrap()[0];
        assert!((diffusivity / all[0].mu - 1.0).abs() < 1e-3);
        let inertia: f64 = crowd.weights.as_ref().unwrap().iter().sum();
        let (_, before) = crowd.moment();
        for _ in 0..10 {
            crowd.step(Force::Mesh, &options, seed, 5e-4, 10).unwrap();
        }
        rates.push((crowd.moment().1 - before) / 5e-3 * inertia);
    }
    let mean = rates.iter().sum::<f64>() / 6.0;
    let error = (rates.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 30.0).sqrt();
    println!("rate {mean} +- {error}, (4.28) {rate}");
    // Four standard errors (of six runs), and 1% of the attraction for the mesh.
    let pull = chi * whole * whole / core::f64::consts::TAU;
    assert!((mean - rate).abs() < 4.0 * error + 0.01 * pull, "{mean} +- {error}, {rate}");
    assert!(4.0 * error < 0.25 * rate.abs());
}

#[test]
fn what_knows_masses_alone_is_refused() {
    let start = collapsing::<f64>(20, 1);
    let options = Options::new(1.0, 0.1);
    let refused = |crowd: &Crowd<f64>, force: Force, options: &Options<f64>| {
        let mut crowd = crowd.clone();
        let before = crowd.bits();
        let error = crowd.step(force, options, 1, 1e-4, 30).unwrap_err();
        assert_eq!(crowd.bits(), before);
        error
    };
    assert_eq!(refused(&start, Force::Heavy, &options), Error::Unsupported);
    for merging in [Merging::Hard, Merging::Never] {
        assert_eq!(refused(&start, Force::Sum(0.01), &Options { merging, ..options }), Error::Unsupported);
        start.clone().step(Force::Sum(0.01), &Options { merging, noise: 0.0, ..options }, 1, 1e-4, 30).unwrap();
        start.clone().step(Force::Mesh, &Options { merging, ..options }, 1, 1e-4, 30).unwrap();
    }
    let with = |change: &dyn Fn(&mut Vec<f64>)| {
        let mut crowd = start.clone();
        change(crowd.weights.as_mut().unwrap());
        refused(&crowd, Force::Mesh, &options)
    };
    assert_eq!(with(&|w| w[3] = 0.0), Error::Mass);
    assert_eq!(with(&|w| w[3] = -1.0), Error::Mass);
    assert_eq!(with(&|w| w[3] = f64::NAN), Error::NotFinite);
    assert_eq!(with(&|w| w[3] = 1e-310), Error::OutOfDomain);
    let mut shorter = start.clone();
    shorter.weights.as_mut().unwrap().truncate(19);
    assert_eq!(shorter.step(Force::Mesh, &options, 1, 1e-4, 30), Err(Error::LengthMismatch));
}

/// The C function computes what `step` does, and refuses.
#[test]
fn in_c_as_in_rust() {
    let start = collapsing::<f64>(100, 4);
    let mut options = std::mem::MaybeUninit::<mollis_pks_options>::uninit();
    // SAFETY: a live structure of this size, which the call fills.
    let mut options = unsafe {
        assert_eq!(mollis_pks_options_init(options.as_mut_ptr(), size_of::<mollis_pks_options>()), 0);
        options.assume_init()
    };
    (options.chi, options.noise) = (2.0, 0.3);
    let attraction = mollis_pks_attraction {
        kind: MOLLIS_PKS_ATTRACTION_NONE,
        reserved: 0,
        mesh: null(),
        grid: null(),
        kernel: null(),
        kernel_bytes: 0,
        tolerance: 0.0,
        heavy: 0.0,
    };
    let mut bytes = 0;
    // SAFETY: live structures.
    let asked =
        unsafe { mollis_pks_workspace_bytes(100, &raw const attraction, &raw const options, null(), &raw mut bytes) };
    assert_eq!(asked, 0);
    let mut memory = vec![0_u8; bytes];
    let mut call = |crowd: &mut Crowd<f64>, weights: *mut f64, run: *const mollis_run| {
        let particles = mollis_pks_particles {
            room: 100,
            positions: crowd.positions.as_mut_ptr(),
            masses: crowd.masses.as_mut_ptr(),
            labels: crowd.labels.as_mut_ptr(),
            species: null_mut(),
            weights,
        };
        let mut progress = mollis_pks_progress { time: 0.0, step: 0, count: 100, pending: 0 };
        let (mut log, mut labels) =
            ([mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 }], [0; 100]);
        let mut events = mollis_pks_events {
            events: log.as_mut_ptr(),
            room: 1,
            written: 0,
            labels: labels.as_mut_ptr(),
            labels_room: 100,
            labels_written: 0,
        };
        // SAFETY: live arrays of these lengths.
        unsafe {
            mollis_pks_step(
                &raw const particles,
                &raw mut progress,
                &raw const attraction,
                null(),
                1e-3,
                3,
                &raw mut events,
                &raw const options,
                run,
                memory.as_mut_ptr().cast(),
                bytes,
                null_mut(),
            )
        }
    };
    let mut in_c = start.clone();
    let weights = in_c.weights.as_mut().unwrap().as_mut_ptr();
    assert_eq!(call(&mut in_c, weights, null()), 0);
    let mut in_rust = start.clone();
    for _ in 0..3 {
        in_rust.step(Force::None, &Options::new(2.0, 0.3), options.seed, 1e-3, 10).unwrap();
    }
    assert_eq!(in_c.bits(), in_rust.bits());
    let masses = in_c.masses.as_mut_ptr();
    assert_eq!(call(&mut in_c, masses, null()), Error::Overlap as i32);
    assert_eq!(call(&mut in_c, weights.wrapping_byte_add(1), null()), Error::Misaligned as i32);
    in_c.weights.as_mut().unwrap()[17] = f64::INFINITY;
    let mut first = 0;
    let mut run = std::mem::MaybeUninit::<mollis_run>::uninit();
    // SAFETY: a live structure of this size, which the call fills.
    let mut run = unsafe {
        assert_eq!(mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()), 0);
        run.assume_init()
    };
    run.first_bad = &raw mut first;
    assert_eq!(call(&mut in_c, weights, &raw const run), Error::NotFinite as i32);
    assert_eq!(first, 17);
}
