//! Coalescing particles: collisions from any distance and mass ratio, noise of any size, refusals, and what runs conserve.

use std::f64::consts::PI;

use mollis_core::exec::Run;
use mollis_core::field;
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::pks::{Attraction, Counters, Event, Events, Merging, Options, Setting, State, step, workspace_bytes};
use mollis_core::random::Philox;
use mollis_core::{Error, Real, Result};
use mollis_reference::random;
use mollis_tests::{Aligned, Split};

use super::{cloud, narrow, size};

const SEED: u64 = 17;

/// Particles under the sum of the Newtonian kernel or, without one, under noise alone.
#[derive(Clone, Debug)]
pub(super) struct System<T: Real> {
    kernel: Option<Blob<T, 2>>,
    options: Options<T>,
    pub(super) x: Vec<[T; 2]>,
    pub(super) m: Vec<T>,
    labels: Vec<u64>,
    counters: Counters,
    log: Vec<Event>,
    absorbed: Vec<u64>,
}

impl<T: Real> System<T> {
    pub(super) fn new(delta: Option<f64>, options: Options<T>, x: Vec<[T; 2]>, m: Vec<T>) -> Self {
        let kernel = delta.map(|delta| {
            let mollifier = if delta > 0.0 { Mollifier::Compact { order: 2, exponent: 4 } } else { Mollifier::None };
            Blob::new(mollifier, T::from_f64(delta)).unwrap()
        });
        let n = m.len();
        let counters = Counters { count: n as u64, ..Counters::default() };
        let (labels, log, absorbed) = ((10..10 + n as u64).collect(), Vec::new(), Vec::new());
        Self { kernel, options, x, m, labels, counters, log, absorbed }
    }

    pub(super) fn step(&mut self, dt: T) -> Result<()> {
        const EXACTLY: field::Options = field::Options::DEFAULT;
        let n = self.m.len();
        let kernel = self.kernel;
        let summed = kernel.as_ref().map(|kernel| (kernel as _, &EXACTLY));
        let mut memory = Aligned::new(workspace_bytes(n, summed, &self.options, 1).unwrap());
        let (mut log, mut labels, mut written, mut labels_written) = (vec![Event::default(); n], vec![0; n], 0, 0);
        let result = step(
            State {
                positions: &mut self.x,
                masses: &mut self.m,
                labels: &mut self.labels,
                species: None,
                weights: None,
            },
            &mut self.counters,
            &mut Philox::new(SEED),
            dt,
            Events {
                events: &mut log,
                labels: &mut labels,
                written: &mut written,
                labels_written: &mut labels_written,
            },
            memory.bytes(),
            Setting {
                options: &self.options,
                attraction: kernel.as_ref().map_or(Attraction::None, |kernel| Attraction::Sum(kernel, &EXACTLY)),
                run: &mut Run::default(),
                report: None,
            },
        );
        self.log.extend(&log[..written]);
        self.absorbed.extend(&labels[..labels_written]);
        result
    }

    /// Particles alive.
    pub(super) fn count(&self) -> usize {
        self.counters.count as usize
    }

    pub(super) fn mass(&self) -> f64 {
        self.m[..self.count()].iter().map(|m| m.to_f64()).sum()
    }
}

/// The normals of a particle's first sub-step.
fn normals(label: u64, step: u32) -> [f64; 2] {
    let words = random::words(SEED, label, step, 0, 2);
    random::normals([words[0], words[1]]).0
}

/// Particles in one place merge at once: into the lowest label, with the rounded sum of the masses, where they are.
fn one_place_of<T: Real>() {
    let place = [T::from_f64(0.3), T::from_f64(-0.7)];
    for (noise, n) in [0.0, 1e-3].into_iter().flat_map(|noise| [2, 3, 40].map(|n| (noise, n))) {
        // Indices far below -1.
        let options = Options::new(T::from_f64(1e6), T::from_f64(noise));
        let m: Vec<T> = (0..n).map(|k| T::from_f64(1.0 + k as f64)).collect();
        let mut system = System::new(Some(0.0), options, vec![place; n], m);
        let (dt, whole) = (1e-3, (n * (n + 1) / 2) as f64);
        assert_eq!(system.step(T::from_f64(dt)), Ok(()));
        assert_eq!((system.count(), system.labels[0], system.m[0].to_f64()), (1, 10, whole), "{noise} {n}");
        let event = system.log[0];
        assert_eq!((event.time, event.label, event.mass), (0.0, 10, whole));
        assert_eq!(system.absorbed, (11..10 + n as u64).collect::<Vec<_>>());
        // The centre of mass is displaced by the noise of all.
        for (c, start) in place.into_iter().enumerate() {
            let weighted = |k: usize| (2.0 * noise * dt * (1.0 + k as f64)).sqrt() * normals(10 + k as u64, 0)[c];
            let moved = (0..n).map(weighted).sum::<f64>() / whole;
            let error = system.x[0][c].to_f64() - (start.to_f64() + moved);
            assert!(error.abs() <= 64.0 * T::EPSILON.to_f64(), "{noise} {n}: {:?} {moved}", system.x[0]);
            assert!(noise > 0.0 || system.x[0][c] == start);
        }
    }
    // Under repulsion, or where nothing merges, they are left where they are.
    for (chi, merging) in [(-1e6, Merging::All), (1e6, Merging::Never)] {
        let options = Options { merging, ..Options::new(T::from_f64(chi), T::ZERO) };
        let mut system = System::new(Some(0.0), options, vec![place; 5], vec![T::ONE; 5]);
        assert_eq!(system.step(T::from_f64(1e-3)), Ok(()));
        assert_eq!((system.count(), &system.x), (5, &vec![place; 5]));
    }
}

#[test]
fn coincident_particles_merge_at_once_or_stay() {
    one_place_of::<f64>();
    one_place_of::<f32>();
}

/// Two particles without noise: the square of their distance falls by chi (m + m') / pi in a unit of time. A step that holds the collision merges them then, in the centre of mass.
fn collisions_of<T: Real>() {
    let eps = T::EPSILON.to_f64();
    let (widest, step) = if T::DIGITS > 24 { (100, size(25, 2)) } else { (10, size(5, 1)) };
    for (exponent, ratio) in (-widest..=widest).step_by(step).flat_map(|e| [0, 3, 12, 30].map(|r| (e, r))) {
        let m = vec![T::ONE, T::from_f64(0.1_f64.powi(ratio))];
        let x = vec![[T::ZERO, T::ZERO], [T::ZERO, T::from_f64(10_f64.powi(exponent))]];
        let (r, chi) = (x[1][1].to_f64(), 3.0);
        let mass = m[0].to_f64() + m[1].to_f64();
        let collision = r * r * PI / (chi * mass);
        let options = Options::new(T::from_f64(chi), T::ZERO);
        let mut system = System::new(Some(0.0), options, x.clone(), m.clone());
        assert_eq!(system.step(T::from_f64(2.0 * collision)), Ok(()), "1e{exponent} 1e-{ratio}");
        assert_eq!((system.count(), system.labels[0], system.log.len()), (1, 10, 1), "1e{exponent} 1e-{ratio}");
        assert_eq!(system.m[0], m[0] + m[1]);
        let [event] = system.log[..] else { unreachable!() };
        assert!((event.time / collision - 1.0).abs() <= 100.0 * eps, "1e{exponent}: {} {collision}", event.time);
        let centre = r * m[1].to_f64() / mass;
        // A centre or a gradient below the normal range is rounded to the spacing there.
        let lost = T::MIN_POSITIVE.to_f64() * eps * (1.0 + chi * 2.0 * collision);
        let error = (system.x[0][1].to_f64() - centre).abs();
        assert!(error <= 8.0 * eps * centre + lost && system.x[0][0] == T::ZERO, "{:?}", system.x[0]);
        // Half of the way: Euler's step.
        let mut system = System::new(Some(0.0), options, x, m);
        let dt = T::from_f64(0.5 * collision);
        assert_eq!(system.step(dt), Ok(()));
        let apart = system.x[1][1].to_f64() - system.x[0][1].to_f64();
        let want = r - chi * mass / (2.0 * PI * r) * dt.to_f64();
        assert_eq!((system.count(), system.log.len()), (2, 0));
        assert!((apart - want).abs() <= 64.0 * eps * r, "1e{exponent} 1e-{ratio}: {apart} {want}");
    }
}

#[test]
fn two_particles_collide_when_their_closed_form_says() {
    collisions_of::<f64>();
    collisions_of::<f32>();
}

/// Without attraction a step displaces a particle by (2 noise dt / m)^(1/2) times its normals, whatever the masses.
fn jumps_of<T: Real>() {
    const N: usize = 61;
    let m: Vec<T> = (0..N).map(|k| T::from_f64(10_f64.powi(k as i32 - 30))).collect();
    let options = Options::new(T::ZERO, T::from_f64(0.7));
    let mut system = System::new(None, options, vec![[T::ZERO; 2]; N], m);
    let dt = T::from_f64(1e-3);
    for number in 0..size(2, 100_u32) {
        let before = system.x.clone();
        assert_eq!(system.step(dt), Ok(()));
        assert_eq!(system.count(), N);
        for (k, (x, y)) in system.x.iter().zip(&before).enumerate() {
            let spread = (2.0 * options.noise.to_f64() * dt.to_f64() / system.m[k].to_f64()).sqrt();
            for (c, z) in normals(10 + k as u64, number).iter().enumerate() {
                let (moved, want) = (x[c].to_f64() - y[c].to_f64(), spread * z);
                // Normals, the spread, and the addition to the position.
                let bound = T::EPSILON.to_f64() * (16.0 * spread + x[c].to_f64().abs() + y[c].to_f64().abs());
                assert!((moved - want).abs() <= bound, "{number} {k}: {moved:e} {want:e}");
            }
        }
    }
}

#[test]
fn noise_displaces_particles_of_any_mass() {
    jumps_of::<f64>();
    jumps_of::<f32>();
}

/// Heavy and light particles above the critical mass, step by step: mass is conserved to the rounding of merges, labels are those of particles that were there, in order, and no number leaves the
/// range.
fn runs_of<T: Real>() {
    const N: usize = 64;
    for seed in 0..size(2, 10) {
        let mut numbers = Split(seed);
        let m: Vec<T> = (0..N).map(|_| T::from_f64(10_f64.powf(-6.0 * numbers.uniform()))).collect();
        for (merging, delta) in
            [(Merging::All, 0.0), (Merging::All, 1e-3), (Merging::Hard, 1e-3), (Merging::Never, 1e-3)]
        {
            // chi M^2 / (8 pi) is far above mu~ N / M.
            let options = Options { merging, ..Options::new(T::from_f64(20.0), T::from_f64(1e-2)) };
            let mut system = System::new(Some(delta), options, narrow(&cloud(N, seed)), m.clone());
            let whole = system.mass();
            for _ in 0..size(60, 5000) {
                let (before, merges) = (system.count(), system.log.len());
                assert_eq!(system.step(T::from_f64(1e-3)), Ok(()), "{merging:?} {delta}");
                let gone: u64 = system.log[merges..].iter().map(|event| event.absorbed).sum();
                assert_eq!(system.count() as u64, before as u64 - gone);
                assert!(system.x[..system.count()].iter().flatten().all(|c| c.is_finite()));
                assert!(system.labels[..system.count()].is_sorted_by(|a, b| a < b));
                let bound = (system.log.len() + 2) as f64 * T::EPSILON.to_f64() * whole;
                assert!((system.mass() - whole).abs() <= bound, "{} {whole}", system.mass());
            }
            assert_eq!(system.count() + system.absorbed.len(), N);
            let mut labels = [&system.labels[..system.count()], &system.absorbed].concat();
            labels.sort_unstable();
            assert_eq!(labels, (10..10 + N as u64).collect::<Vec<_>>());
            assert!(merging != Merging::Never || system.log.is_empty());
            // Without noise the second moment would be gone at 2 pi Y / (chi M), about 0.03, Y being about 2/3.
            assert!(merging != Merging::All || !system.log.is_empty());
        }
    }
}

#[test]
fn runs_conserve_mass_and_labels() {
    runs_of::<f64>();
    runs_of::<f32>();
}

/// What is not finite, and what becomes so: a status, and every particle as it was.
fn refusals_of<T: Real>() {
    const N: usize = 12;
    let options = Options::new(T::ONE, T::from_f64(0.1));
    let fresh = || System::new(Some(0.0), options, narrow(&cloud(N, 1)), vec![T::ONE; N]);
    let refused = |system: &System<T>, dt: T, want: Error, what: &str| {
        let mut after = system.clone();
        assert_eq!(after.step(dt), Err(want), "{what}");
        let bits = |s: &System<T>| s.x.as_flattened().iter().chain(&s.m).map(|v| v.bits()).collect::<Vec<_>>();
        assert_eq!((bits(&after), &after.labels, after.counters), (bits(system), &system.labels, system.counters));
        assert!(after.log.is_empty() && after.absorbed.is_empty(), "{what}");
    };
    let dt = T::from_f64(1e-3);
    for value in [T::NAN, T::INFINITY, -T::INFINITY] {
        for k in 0..N {
            let mut system = fresh();
            system.x[k][k % 2] = value;
            refused(&system, dt, Error::NotFinite, "position");
            let mut system = fresh();
            system.m[k] = value;
            refused(&system, dt, Error::NotFinite, "mass");
        }
        refused(&fresh(), value, Error::TimeStep, "step");
        let spoilt = [
            Options { chi: value, ..options },
            Options { noise: value, ..options },
            Options { gamma: value, ..options },
        ];
        for spoilt in spoilt {
            assert_eq!(workspace_bytes(N, None, &spoilt, 1), Err(Error::NotFinite));
        }
    }
    for value in [T::ZERO, -T::ZERO, -T::ONE] {
        let mut system = fresh();
        system.m[N - 1] = value;
        refused(&system, dt, Error::Mass, "mass");
        refused(&fresh(), value, Error::TimeStep, "step");
    }
    // A sum of masses out of range.
    let mut system = fresh();
    system.m.fill(T::MAX / T::TWO);
    refused(&system, dt, Error::NotFinite, "masses");
    // chi dt / (2 pi r) out of range, in particles that do not merge.
    let mut system = fresh();
    system.options = Options { merging: Merging::Never, ..Options::new(T::from_f64(1e30), T::ZERO) };
    system.x[1] = system.x[0].map(|c| c * (T::ONE + T::EPSILON));
    refused(&system, T::MAX / T::TWO, Error::BecameNotFinite, "an attraction out of range");
}

#[test]
fn steps_refuse_what_is_not_finite() {
    refusals_of::<f64>();
    refusals_of::<f32>();
}
