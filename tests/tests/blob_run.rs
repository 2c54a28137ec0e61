//! The blob method through `mollis-core`: against the reference implementation, order of RK4, refusals, stops, watch on the energy.

use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::diagnostics::{self, Moments};
use mollis_core::exec::Run;
use mollis_core::field::{Interaction, Options};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::{Error, Real};
use mollis_reference::blob::{self as twin, Points};

/// A workspace of exactly `bytes` with arbitrary contents, between canaries that are checked when it is dropped.
struct Workspace {
    memory: Vec<u8>,
    start: usize,
    bytes: usize,
}

const CANARY: u8 = 0xC5;

impl Workspace {
    fn new(bytes: usize) -> Self {
        let mut memory = vec![CANARY; bytes + 3 * ALIGN];
        let start = ALIGN + memory[ALIGN..].as_ptr().align_offset(ALIGN);
        memory[start..start + bytes].fill(0xFF);
        Self { memory, start, bytes }
    }
    fn get(&mut self) -> &mut [u8] {
        &mut self.memory[self.start..self.start + self.bytes]
    }
}

impl Drop for Workspace {
    fn drop(&mut self) {
        let (before, after) = (&self.memory[..self.start], &self.memory[self.start + self.bytes..]);
        assert!(before.iter().chain(after).all(|&b| b == CANARY), "a write outside the workspace");
    }
}

/// Deterministic numbers in [0, 1): the upper bits of a linear congruential generator (Knuth's MMIX).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// All data that a run reads and writes, in scalar T.
#[derive(Clone, Debug, PartialEq)]
struct Case<T, const D: usize> {
    masses: Vec<T>,
    x: Vec<[T; D]>,
    rho: Vec<T>,
    velocity: Vec<[T; D]>,
    divergence: Vec<T>,
    tracer_x: Vec<[T; D]>,
    tracer_rho: Vec<T>,
    tracer_velocity: Vec<[T; D]>,
}

const ALL: Wanted = Wanted { density: true, velocity: true, divergence: true, energy: true };

impl<T: Real, const D: usize> Case<T, D> {
    fn random(n: usize, tracers: usize) -> Self {
        let mut next = random(n as u64 + 17);
        let mut points = |n: usize| -> Vec<[T; D]> {
            (0..n).map(|_| std::array::from_fn(|_| T::from_f64(2.0 * next() - 1.0))).collect()
        };
        let (x, tracer_x) = (points(n), points(tracers));
        let mut scalars = |n: usize| -> Vec<T> { (0..n).map(|_| T::from_f64(0.5 + next())).collect() };
        let masses = scalars(n).iter().map(|&m| m / T::from_usize(n.max(1))).collect();
        Self {
            masses,
            x,
            rho: scalars(n),
            velocity: vec![[T::NAN; D]; n],
            divergence: vec![T::NAN; n],
            tracer_x,
            tracer_rho: scalars(tracers),
            tracer_velocity: vec![[T::NAN; D]; tracers],
        }
    }

    fn state(&mut self, wanted: Wanted) -> State<'_, T, D> {
        State {
            masses: &self.masses,
            particles: Trajectories {
                positions: &mut self.x,
                density: wanted.density.then_some(&mut self.rho),
                velocity: wanted.velocity.then_some(&mut self.velocity),
                divergence: wanted.divergence.then_some(&mut self.divergence),
            },
            tracers: Trajectories {
                positions: &mut self.tracer_x,
                density: wanted.density.then_some(&mut self.tracer_rho),
                velocity: wanted.velocity.then_some(&mut self.tracer_velocity),
                divergence: None,
            },
        }
    }

    fn run(
        &mut self,
        kernel: &dyn Interaction<T, D>,
        wanted: Wanted,
        dt: f64,
        steps: usize,
    ) -> (Result<(), Error>, Report) {
        self.run_with(kernel, wanted, &Options::default(), dt, steps)
    }

    fn run_with(
        &mut self,
        kernel: &dyn Interaction<T, D>,
        wanted: Wanted,
        options: &Options,
        dt: f64,
        steps: usize,
    ) -> (Result<(), Error>, Report) {
        let plan = aggregation::plan(kernel, self.x.len(), self.tracer_x.len(), wanted, options).unwrap();
        let mut workspace = Workspace::new(plan.workspace_bytes::<T, D>(1).unwrap());
        let mut report = Report::default();
        let advance = Advance { dt: T::from_f64(dt), steps, after_step: None };
        let state = self.state(wanted);
        let result =
            aggregation::step(&plan, kernel, state, advance, workspace.get(), &mut Run::default(), &mut report);
        (result, report)
    }

    fn points(&self) -> [Points; 2] {
        let wide = |x: &[[T; D]]| x.iter().map(|x| x.iter().map(|c| c.to_f64()).collect()).collect();
        let scalars = |v: &[T]| v.iter().map(|c| c.to_f64()).collect();
        [
            Points { positions: wide(&self.x), densities: scalars(&self.rho) },
            Points { positions: wide(&self.tracer_x), densities: scalars(&self.tracer_rho) },
        ]
    }
}

/// The mollified Newtonian kernel, by its scalar functions.
struct Newtonian<T: Real, const D: usize> {
    coefficient: T,
    blob: Blob<T, D>,
}

impl<T: Real, const D: usize> Newtonian<T, D> {
    fn new(coefficient: f64, delta: f64) -> Self {
        let mollifier = Mollifier::Compact { order: 2, exponent: if D == 2 { 4 } else { 1 } };
        Self { coefficient: T::from_f64(coefficient), blob: Blob::new(mollifier, T::from_f64(delta)).unwrap() }
    }
}

impl<T: Real, const D: usize> Interaction<T, D> for Newtonian<T, D> {
    fn value(&self, r: T) -> T {
        self.coefficient * self.blob.potential(r)
    }
    fn gradient_factor(&self, r: T) -> T {
        self.coefficient * self.blob.gradient_factor(r)
    }
    fn laplacian(&self, r: T) -> T {
        self.coefficient * self.blob.density(r)
    }
    fn is_singular(&self) -> bool {
        false
    }
}

/// Sizes 0, 1 and around the widths of lanes and tiles; with and without tracers; masses of both signs.
///
/// Tolerance: n roundings of a sum whose terms are at most sum |m_j| |grad K| <= 1.5 / (2 delta) in size, a few steps of length
/// 1/40, and an amplification e^(L t) below 10: 1e3 u. The error of the reference implementation is 1e-13: its closed forms lose u / s
/// at r = delta sqrt s, and no pair is closer than s = 1e-3.
fn agrees_with_the_twin<T: Real, const D: usize>() {
    let delta = 0.35;
    let tolerance = 1e3 * T::EPSILON.to_f64() + 1e-12;
    for n in [0, 1, 2, 7, 8, 9, 33, 65] {
        for (tracers, coefficient) in [(0, 1.0), (5, -1.0)] {
            let kernel = Newtonian::<T, D>::new(coefficient, delta);
            let reference = twin::newtonian(D, coefficient, f64::from_bits(T::from_f64(delta).to_f64().to_bits()));
            let mut case = Case::<T, D>::random(n, tracers);
            let [particles, passive] = case.points();
            let masses: Vec<f64> = case.masses.iter().map(|m| m.to_f64()).collect();
            let before = twin::energy(&reference, &particles.positions, &masses);
            let want = twin::run(&reference, &masses, &particles, &passive, 0.025, 3);
            let (result, report) = case.run(&kernel, ALL, 0.025, 3);
            assert_eq!((result, report.steps, report.first_bad), (Ok(()), 3, None));
            let close = |got: f64, want: f64, what: &str| {
                assert!((got - want).abs() <= tolerance * want.abs().max(4.0), "{D}D n = {n} {what}: {got} {want}");
            };
            for (got, want) in case.points().iter().zip(&want) {
                for (got, want) in got.positions.iter().flatten().zip(want.positions.iter().flatten()) {
                    close(*got, *want, "position");
                }
                for (got, want) in got.densities.iter().zip(&want.densities) {
                    close(*got, *want, "density");
                }
            }
            let sources = &want[0].positions;
            for i in 0..n {
                let (_, gradient, laplacian) = twin::fields(&reference, sources, &masses, &sources[i]);
                for (got, want) in case.velocity[i].iter().zip(gradient) {
                    close(got.to_f64(), -want, "velocity");
                }
                close(case.divergence[i].to_f64(), -laplacian, "divergence");
            }
            for i in 0..tracers {
                let (_, gradient, _) = twin::fields(&reference, sources, &masses, &want[1].positions[i]);
                for (got, want) in case.tracer_velocity[i].iter().zip(gradient) {
                    close(got.to_f64(), -want, "tracer velocity");
                }
            }
            let (first, last) = report.energy.unwrap();
            close(first, before, "energy");
            close(last, twin::energy(&reference, sources, &masses), "energy after");
        }
    }
}

#[test]
fn agrees_with_the_twin_1d() {
    agrees_with_the_twin::<f64, 1>();
    agrees_with_the_twin::<f32, 1>();
}

#[test]
fn agrees_with_the_twin_2d() {
    agrees_with_the_twin::<f64, 2>();
    agrees_with_the_twin::<f32, 2>();
}

#[test]
fn agrees_with_the_twin_3d() {
    agrees_with_the_twin::<f64, 3>();
    agrees_with_the_twin::<f32, 3>();
}

/// The velocity -(a + b J) grad u has the divergence -a Laplacian(u), J being the turn by a right angle: vortices (a = 0) keep their densities,
/// which otherwise grow at a times the rate.
#[test]
fn turned_gradients_have_no_divergence() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.6);
    let wanted = Wanted { energy: false, ..ALL };
    let start = Case::<f64, 2>::random(30, 4);
    let mut plain = start.clone();
    plain.run(&kernel, wanted, 1.0, 0).0.unwrap();
    for (a, b) in [(0.0, -1.0), (0.5, 0.3), (-1.0, 2.0)] {
        let options = Options { combination: (a, b), ..Options::default() };
        let mut case = start.clone();
        case.run_with(&kernel, wanted, &options, 1.0, 0).0.unwrap();
        for (&got, &full) in case.divergence.iter().zip(&plain.divergence) {
            assert_eq!(got, a * full);
        }
        for (got, &[x, y]) in case.velocity.iter().zip(&plain.velocity) {
            assert!((got[0] - (a * x - b * y)).abs() <= 1e-14 && (got[1] - (a * y + b * x)).abs() <= 1e-14);
        }
        let dt = 1e-6;
        case.run_with(&kernel, wanted, &options, dt, 1).0.unwrap();
        for ((&after, &before), &full) in case.rho.iter().zip(&start.rho).zip(&plain.divergence) {
            let rate = (after - before) / dt;
            assert!((rate + a * full * before).abs() <= 1e-4 && (a != 0.0 || after == before), "{rate} {full}");
        }
    }
}

/// Two bodies in the plane farther apart than delta: r^2 = r_0^2 - M t / pi with M the total mass. The error falls by 16 +- 1
/// in each of three halvings. With dt from 1/8 to 1/64 it stays above rounding (1e-6 to 1e-10).
#[test]
fn rk4_halves_by_sixteen_on_two_bodies() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.1);
    let time = 1.0;
    let error = |steps: u32| {
        let mut case = Case::<f64, 2>::random(2, 0);
        case.masses = vec![1.0, 0.5];
        case.x = vec![[0.4, 0.0], [-0.4, 0.1]];
        let square = |x: &[[f64; 2]]| (x[0][0] - x[1][0]).powi(2) + (x[0][1] - x[1][1]).powi(2);
        let exact = (square(&case.x) - 1.5 * time / std::f64::consts::PI).sqrt();
        let wanted = Wanted::default();
        assert_eq!(case.run(&kernel, wanted, time / f64::from(steps), steps as usize).0, Ok(()));
        (square(&case.x).sqrt() - exact).abs()
    };
    let errors: Vec<f64> = [16, 32, 64, 128].map(error).to_vec();
    for pair in errors.windows(2) {
        assert!((15.0..=17.0).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

/// Outputs are optional. Leaving one out does not change the bits of the others.
#[test]
fn what_is_not_wanted_changes_nothing_else() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.3);
    let mut all = Case::<f64, 2>::random(40, 3);
    let start = all.clone();
    all.run(&kernel, ALL, 0.02, 4).0.unwrap();
    for bits in 0..16 {
        let on = |k: u32| bits >> k & 1 == 1;
        let wanted = Wanted { density: on(0), velocity: on(1), divergence: on(2), energy: on(3) };
        let mut case = start.clone();
        let (result, report) = case.run(&kernel, wanted, 0.02, 4);
        assert_eq!((result, report.energy.is_some()), (Ok(()), wanted.energy));
        assert_eq!((&case.x, &case.tracer_x), (&all.x, &all.tracer_x));
        assert_eq!(&case.rho, if wanted.density { &all.rho } else { &start.rho });
        assert_eq!(case.velocity == all.velocity, wanted.velocity);
        assert_eq!(case.divergence == all.divergence, wanted.divergence);
    }
    // One call of four steps equals four calls of one step.
    let mut split = start.clone();
    (0..4).for_each(|_| split.run(&kernel, ALL, 0.02, 1).0.unwrap());
    assert_eq!(split, all);
    // Zero steps: the outputs belong to the given state.
    let mut still = Case { velocity: start.velocity.clone(), divergence: start.divergence.clone(), ..all.clone() };
    still.tracer_velocity.fill([f64::NAN; 2]);
    still.run(&kernel, ALL, f64::NAN, 0).0.unwrap();
    assert_eq!(still, all);
}

/// A refused call writes nothing except its report.
#[test]
fn refusals_write_nothing() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.3);
    let bits = |case: &Case<f64, 2>| format!("{case:?}");
    let refused = |change: &dyn Fn(&mut Case<f64, 2>), dt: f64, want: Error, bad: Option<usize>| {
        let mut case = Case::random(9, 4);
        change(&mut case);
        let before = bits(&case);
        let (result, report) = case.run(&kernel, ALL, dt, 2);
        assert_eq!((result, report.steps, report.first_bad), (Err(want), 0, bad));
        assert_eq!(bits(&case), before);
    };
    for dt in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        refused(&|_| {}, dt, Error::TimeStep, None);
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&|c| c.x[3][1] = value, 0.1, Error::NotFinite, Some(3));
        refused(&|c| (c.masses[7], c.x[8][0]) = (value, value), 0.1, Error::NotFinite, Some(7));
        refused(&|c| c.rho[0] = value, 0.1, Error::NotFinite, Some(0));
        refused(&|c| c.tracer_x[1][0] = value, 0.1, Error::NotFinite, Some(10));
        refused(&|c| c.tracer_rho[2] = value, 0.1, Error::NotFinite, Some(11));
    }
    refused(&|c| c.masses.truncate(8), 0.1, Error::LengthMismatch, None);
    refused(&|c| c.rho.truncate(8), 0.1, Error::LengthMismatch, None);
    refused(&|c| c.velocity.truncate(8), 0.1, Error::LengthMismatch, None);
    refused(&|c| c.divergence.truncate(8), 0.1, Error::LengthMismatch, None);
    refused(&|c| c.tracer_velocity.push([0.0; 2]), 0.1, Error::LengthMismatch, None);

    let mut case = Case::<f64, 2>::random(9, 4);
    let before = bits(&case);
    let plan = aggregation::plan(&kernel, 9, 4, ALL, &Options::default()).unwrap();
    let bytes = plan.workspace_bytes::<f64, 2>(1).unwrap();
    let mut workspace = Workspace::new(bytes);
    for (range, want) in [(0..bytes - 1, Error::WorkspaceTooSmall), (1..bytes, Error::Misaligned)] {
        let advance = Advance { dt: 0.1, steps: 1, after_step: None };
        let memory = &mut workspace.get()[range];
        let result = aggregation::step(
            &plan,
            &kernel,
            case.state(ALL),
            advance,
            memory,
            &mut Run::default(),
            &mut Report::default(),
        );
        assert_eq!((result, bits(&case)), (Err(want), before.clone()));
    }
    assert_eq!(aggregation::plan(&kernel, usize::MAX, 1, ALL, &Options::default()).err(), Some(Error::TooLarge));
}

/// A callback receives each state and may stop the run. `should_stop` may stop it within a step.
#[test]
fn stops_keep_the_last_completed_step() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.3);
    let start = Case::<f64, 2>::random(20, 2);
    let mut want = start.clone();
    want.run(&kernel, Wanted { density: true, ..Wanted::default() }, 0.02, 3).0.unwrap();

    let mut case = start.clone();
    let plan = aggregation::plan(&kernel, 20, 2, ALL, &Options::default()).unwrap();
    let mut workspace = Workspace::new(plan.workspace_bytes::<f64, 2>(1).unwrap());
    let mut seen = Vec::new();
    let mut report = Report::default();
    let mut after_step = |p: aggregation::Progress<'_, f64, 2>| {
        seen.push((p.steps, p.positions.to_vec(), p.density.unwrap().to_vec()));
        p.steps < 3
    };
    let advance = Advance { dt: 0.02, steps: 10, after_step: Some(&mut after_step) };
    let result =
        aggregation::step(&plan, &kernel, case.state(ALL), advance, workspace.get(), &mut Run::default(), &mut report);
    assert_eq!((result, report.steps, seen.len()), (Err(Error::Stopped), 3, 3));
    assert_eq!((&case.x, &case.rho, &case.tracer_x), (&want.x, &want.rho, &want.tracer_x));
    assert_eq!(seen[2], (3, want.x.clone(), want.rho.clone()));
    assert!(case.velocity.iter().flatten().all(|v| v.is_nan()), "no output is written by a run that stops");

    let asked = std::sync::atomic::AtomicUsize::new(0);
    let should_stop = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= 6;
    let mut run = Run { should_stop: Some(&should_stop), ..Run::default() };
    let mut case = start.clone();
    let advance = Advance { dt: 0.02, steps: 10, after_step: None };
    let result = aggregation::step(&plan, &kernel, case.state(ALL), advance, workspace.get(), &mut run, &mut report);
    assert_eq!(result, Err(Error::Stopped));
    assert!(report.steps < 3, "{report:?}");
    let mut again = start.clone();
    again.run(&kernel, Wanted { density: true, ..Wanted::default() }, 0.02, report.steps).0.unwrap();
    assert_eq!((&case.x, &case.rho), (&again.x, &again.rho));
}

/// Steps far beyond the limit of stability make the state overflow. The run stops and keeps the last finite state.
#[test]
fn a_value_that_becomes_non_finite_stops_the_run() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.3);
    let mut case = Case::<f64, 2>::random(12, 0);
    case.masses.fill(1e200);
    let start = case.clone();
    let (result, report) = case.run(&kernel, Wanted { density: true, ..Wanted::default() }, 1e100, 8);
    assert_eq!(result, Err(Error::BecameNotFinite));
    assert!(case.x.iter().flatten().chain(&case.rho).all(|v| v.is_finite()));
    let mut again = start.clone();
    again.run(&kernel, Wanted { density: true, ..Wanted::default() }, 1e100, report.steps).0.unwrap();
    assert_eq!((&case.x, &case.rho), (&again.x, &again.rho));
}

/// An interaction whose potential and Laplacian do not depend on the distance, without a field: positions do not change.
struct Constant<T> {
    value: T,
    laplacian: T,
}

impl<T: Real> Interaction<T, 2> for Constant<T> {
    fn value(&self, _: T) -> T {
        self.value
    }
    fn gradient_factor(&self, _: T) -> T {
        T::ZERO
    }
    fn laplacian(&self, _: T) -> T {
        self.laplacian
    }
    fn is_singular(&self) -> bool {
        false
    }
}

/// Rates and energies overflow while positions do not. No output is written, and the state is that of the last completed step.
fn rates_that_overflow_are_no_results<T: Real>(far: f64) {
    let only = Wanted::default();
    let velocity = Wanted { velocity: true, ..only };
    // |x|^4 / 4: the field is cubic, and far^3 exceeds the range of the scalar. A particle is far away, then a tracer.
    let terms = [Term { law: Law::Power { exponent: 4.0 }, coefficient: 1.0 }];
    let mut memory = Workspace::new(Kernel::<T, 2>::workspace_bytes(&terms, Mollifier::None).unwrap());
    let quartic = Kernel::<T, 2>::prepare(memory.get(), &terms, Mollifier::None, T::ONE).unwrap();
    for tracer in [false, true] {
        let mut case = Case::<T, 2>::random(3, 2);
        let point = if tracer { &mut case.tracer_x[0] } else { &mut case.x[1] };
        point[0] = T::from_f64(far);
        let before = format!("{case:?}");
        let (result, report) = case.run(&quartic, velocity, 0.0, 0);
        assert_eq!((result, report.steps), (Err(Error::BecameNotFinite), 0));
        assert_eq!(format!("{case:?}"), before);
    }
    // Two steps are completed. The divergence is computed only then: sum m Laplacian overflows, with masses of 2.
    let constant = Constant { value: T::ZERO, laplacian: T::MAX };
    let mut case = Case::<T, 2>::random(3, 2);
    case.masses.fill(T::TWO);
    let before = format!("{case:?}");
    let (result, report) = case.run(&constant, Wanted { divergence: true, velocity: true, ..only }, 0.1, 2);
    assert_eq!((result, report.steps), (Err(Error::BecameNotFinite), 2));
    assert_eq!(format!("{case:?}"), before);
    assert_eq!(case.run(&constant, velocity, 0.1, 2).0, Ok(()));
    // The energy overflows before the first step, and with zero steps.
    let constant = Constant { value: T::MAX, laplacian: T::ZERO };
    for steps in [0, 2] {
        let (result, report) = case.run(&constant, Wanted { energy: true, ..only }, 0.1, steps);
        assert_eq!((result, report.steps), (Err(Error::BecameNotFinite), 0));
    }
}

#[test]
fn rates_that_overflow_are_no_results_in_either_precision() {
    rates_that_overflow_are_no_results::<f64>(1e110);
    rates_that_overflow_are_no_results::<f32>(1e14);
}

/// The energy of negative masses may rise along a correct run. Watching it is refused.
#[test]
fn a_watched_energy_has_no_negative_mass() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.3);
    let watched = Wanted { energy: true, ..Wanted::default() };
    let mut case = Case::<f64, 2>::random(9, 2);
    case.masses[8] = -1e-300;
    let before = format!("{case:?}");
    let (result, report) = case.run(&kernel, watched, 0.01, 2);
    assert_eq!((result, report), (Err(Error::Mass), Report::default()));
    assert_eq!(format!("{case:?}"), before);
    case.masses[8] = -0.0;
    assert_eq!(case.run(&kernel, watched, 0.01, 2).0, Ok(()));
}

/// With the step estimate that holds anywhere the energy falls along runs of either sign, through collapse to a cluster. A step that is far
/// too long is detected.
#[test]
fn energy_falls_below_the_step_estimate() {
    let watched = Wanted { energy: true, ..Wanted::default() };
    for coefficient in [1.0, -1.0] {
        let kernel = Newtonian::<f64, 2>::new(coefficient, 0.3);
        let mut case = Case::<f64, 2>::random(30, 0);
        let mass = diagnostics::moments(&case.x, &case.masses).unwrap().absolute_mass;
        let dt = diagnostics::stable_step_anywhere(&kernel, mass, 10.0).unwrap();
        let mut last_energy = f64::INFINITY;
        for _ in 0..40 {
            // The estimate for all states is at most the estimate for each state.
            assert!(diagnostics::stable_step(&kernel, &case.x, &case.masses).unwrap() >= dt);
            let (result, report) = case.run(&kernel, watched, dt, 5);
            let (first, last) = report.energy.unwrap();
            // The run itself compares up to rounding. Between runs the same energy is computed twice.
            assert!(result == Ok(()) && first <= last_energy, "{coefficient} {dt} {report:?}");
            assert!(last <= first + 1e-14, "{coefficient} {dt} {report:?}");
            last_energy = last;
        }
        // Fifty times the estimate: the attraction overshoots.
        let (result, report) = Case::<f64, 2>::random(30, 0).run(&kernel, watched, 50.0 * dt, 50);
        if coefficient > 0.0 {
            assert_eq!(result, Err(Error::EnergyRose), "{report:?}");
            assert!(report.steps < 50);
        }
    }
}

#[test]
fn step_estimates_refuse_and_know_rest() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 0.3);
    assert_eq!(diagnostics::stable_step(&kernel, &[], &[]), Ok(f64::INFINITY));
    assert_eq!(diagnostics::stable_step(&kernel, &[[0.0; 2], [1.0; 2]], &[0.0, 0.0]), Ok(f64::INFINITY));
    assert_eq!(diagnostics::stable_step(&kernel, &[[0.0; 2]], &[]), Err(Error::LengthMismatch));
    assert_eq!(diagnostics::stable_step(&kernel, &[[0.0; 2], [f64::NAN; 2]], &[1.0, 1.0]), Err(Error::NotFinite));
    assert_eq!(diagnostics::stable_step(&kernel, &[[0.0; 2]], &[f64::INFINITY]), Err(Error::NotFinite));
    assert_eq!(diagnostics::stable_step_anywhere(&kernel, -1.0, 1.0), Err(Error::OutOfDomain));
    assert_eq!(diagnostics::stable_step_anywhere(&kernel, 1.0, f64::NAN), Err(Error::NotFinite));
    // M = 4, order 2 in the plane: |H| is largest at the centre, 5 / (2 pi delta^2).
    let want = 2.785_293_563 / (2.0 * 5.0 / (2.0 * std::f64::consts::PI * 0.09));
    assert!((diagnostics::stable_step_anywhere(&kernel, 1.0, 4.0).unwrap() / want - 1.0).abs() < 1e-12);
}

/// The centre of mass is constant. Until a pair is within delta the second moment follows its own law: in the plane
/// d/dt sum m |x|^2 = -(1/2 pi) sum_(i != j) m_i m_j.
#[test]
fn conserved_and_dissipated() {
    let kernel = Newtonian::<f64, 2>::new(1.0, 1e-3);
    let mut case = Case::<f64, 2>::random(6, 0);
    let moments = |case: &Case<f64, 2>| -> Moments<f64, 2> { diagnostics::moments(&case.x, &case.masses).unwrap() };
    let before = moments(&case);
    case.run(&kernel, Wanted::default(), 1e-3, 50).0.unwrap();
    let after = moments(&case);
    assert_eq!(before.mass, after.mass);
    for (a, b) in before.centre.iter().zip(after.centre) {
        // 200 evaluations, each with a few roundings of increments of 1e-3.
        assert!((a - b).abs() < 1e-15, "{a} {b}");
    }
    let squares: f64 = case.masses.iter().map(|m| m * m).sum();
    let rate = -(before.mass.powi(2) - squares) / (2.0 * std::f64::consts::PI);
    // RK4's truncation at dt = 1e-3, with pairs no closer than 0.1: below 1e-10.
    assert!((after.second - before.second - 0.05 * rate).abs() < 1e-10, "{} {}", after.second - before.second, rate);
}
