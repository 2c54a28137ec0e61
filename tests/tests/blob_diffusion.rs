//! Diffusion by blobs through `mollis-core`: against the reference implementation, exact solutions with observed orders, steady states, what is conserved, skipped and refused.

use mollis_core::aggregation::{self, Advance, Diffusion, Plan, Report, State, Trajectories, Wanted};
use mollis_core::diagnostics;
use mollis_core::exact::diffusion::{Profile, Spreading, steady};
use mollis_core::exec::{Run, Statistics};
use mollis_core::field::{self, Density, Interaction, Method, Options, Outputs, Reason, Sources};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;
use mollis_core::{Error, Real};
use mollis_reference::diffusion as twin;

const COMPACT: Mollifier = Mollifier::Compact { order: 2, exponent: 4 };
const GAUSSIAN: Mollifier = Mollifier::Gaussian { order: 2 };

fn diffusion(exponent: f64, mollifier: Mollifier, length: f64) -> Diffusion {
    Diffusion { exponent, coefficient: 1.0, mollifier, length }
}

/// A workspace of exactly `bytes` with arbitrary contents, between canaries.
fn in_workspace<R>(bytes: usize, body: impl FnOnce(&mut [u8]) -> R) -> R {
    let mut memory = vec![0xC5; bytes + 3 * ALIGN];
    let start = ALIGN + memory[ALIGN..].as_ptr().align_offset(ALIGN);
    memory[start..start + bytes].fill(0xFF);
    let result = body(&mut memory[start..start + bytes]);
    assert!(
        memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xC5),
        "a write outside the workspace"
    );
    result
}

/// Deterministic numbers in [0, 1).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn no_force<T: Real, const D: usize>() -> Kernel<'static, T, D> {
    Kernel::newtonian(T::ZERO, Mollifier::None, T::ZERO).unwrap()
}

/// Particles, tracers and what a run says of them.
#[derive(Clone, Debug)]
struct Case<T, const D: usize> {
    masses: Vec<T>,
    x: Vec<[T; D]>,
    tracers: Vec<[T; D]>,
    velocity: Vec<[T; D]>,
    tracer_velocity: Vec<[T; D]>,
    counters: Statistics,
    report: Report,
}

impl<T: Real, const D: usize> Case<T, D> {
    fn new(x: Vec<[T; D]>, masses: Vec<T>, tracers: Vec<[T; D]>) -> Self {
        let (velocity, tracer_velocity) = (vec![[T::NAN; D]; x.len()], vec![[T::NAN; D]; tracers.len()]);
        let (counters, report) = (Statistics::default(), Report::default());
        Self { masses, x, tracers, velocity, tracer_velocity, counters, report }
    }

    /// In the unit cube.
    fn random(n: usize, tracers: usize) -> Self {
        let mut next = random(n as u64 + 3);
        let mut points =
            |n: usize| -> Vec<[T; D]> { (0..n).map(|_| std::array::from_fn(|_| T::from_f64(next()))).collect() };
        let (x, tracers) = (points(n), points(tracers));
        let masses = (0..n).map(|_| T::from_f64((0.5 + next()) / n as f64)).collect();
        Self::new(x, masses, tracers)
    }

    fn plan(&self, kernel: &dyn Interaction<T, D>, wanted: Wanted, options: &Options, by: &Diffusion) -> Plan {
        let plan = aggregation::plan(kernel, self.x.len(), self.tracers.len(), wanted, options).unwrap();
        plan.with_diffusion::<T, D>(by, options).unwrap()
    }

    fn step(&mut self, kernel: &dyn Interaction<T, D>, plan: &Plan, dt: f64, steps: usize) -> Result<(), Error> {
        let bytes = plan.workspace_bytes::<T, D>(1).unwrap();
        in_workspace(bytes, |workspace| self.step_in(kernel, plan, dt, steps, workspace))
    }

    fn step_in(
        &mut self,
        kernel: &dyn Interaction<T, D>,
        plan: &Plan,
        dt: f64,
        steps: usize,
        workspace: &mut [u8],
    ) -> Result<(), Error> {
        let velocities = plan.wanted().velocity;
        let state = State {
            masses: &self.masses,
            particles: Trajectories {
                positions: &mut self.x,
                velocity: velocities.then_some(&mut self.velocity),
                ..Trajectories::none()
            },
            tracers: Trajectories {
                positions: &mut self.tracers,
                velocity: velocities.then_some(&mut self.tracer_velocity),
                ..Trajectories::none()
            },
        };
        self.counters = Statistics::default();
        let mut run = Run { counters: Some(&mut self.counters), ..Run::default() };
        let advance = Advance { dt: T::from_f64(dt), steps, after_step: None };
        aggregation::step(plan, kernel, state, advance, workspace, &mut run, &mut self.report)
    }
}

fn wide<T: Real, const D: usize>(x: &[[T; D]]) -> Vec<Vec<f64>> {
    x.iter().map(|x| x.iter().map(|c| c.to_f64()).collect()).collect()
}

const VELOCITY_AND_ENERGY: Wanted = Wanted { density: false, velocity: true, divergence: false, energy: true };

/// Velocities at particles and tracers, and the entropy. A velocity is a sum of n terms, each wrong by some tens of roundings (the polynomials' coefficients, f' of a density of
/// positive terms): 100 u n of the largest, which is below n times the largest velocity / 5 for these points.
fn agrees_with_the_twin<T: Real, const D: usize>() {
    let tolerance = 400.0 * T::EPSILON.to_f64() + 1e-13;
    let length = 0.5;
    for n in [0, 1, 2, 9, 50] {
        for (mollifier, phi) in [
            (COMPACT, twin::compact(D, 4, length)),
            (Mollifier::Compact { order: 2, exponent: 2 }, twin::compact(D, 2, length)),
            (GAUSSIAN, twin::gaussian(D, length)),
        ] {
            for m in [1.0, 1.5, 2.0, 3.0, 2.5] {
                let by = Diffusion { exponent: m, coefficient: 0.7, mollifier, length };
                let kernel = no_force::<T, D>();
                let mut case = Case::<T, D>::random(n, 5);
                let plan = case.plan(&kernel, VELOCITY_AND_ENERGY, &Options::default(), &by);
                case.step(&kernel, &plan, 1.0, 0).unwrap();
                let (x, masses) = (wide(&case.x), case.masses.iter().map(|m| m.to_f64()).collect::<Vec<_>>());
                let all = x.iter().chain(&wide(&case.tracers)).cloned().collect::<Vec<_>>();
                let want: Vec<_> = all.iter().map(|at| twin::velocity(&phi, (m, 0.7), &x, &masses, at)).collect();
                let got = [wide(&case.velocity), wide(&case.tracer_velocity)].concat();
                let largest = want.iter().flatten().fold(1.0, |most: f64, v| most.max(v.abs()));
                for (got, want) in got.iter().flatten().zip(want.iter().flatten()) {
                    assert!((got - want).abs() <= tolerance * largest, "{D}D {n} {m} {mollifier:?}: {got} {want}");
                }
                let entropy = twin::entropy(&phi, (m, 0.7), &x, &masses);
                let (first, last) = case.report.energy.unwrap();
                assert!(
                    first == last && (first - entropy).abs() <= tolerance * (1.0 + entropy.abs()),
                    "{first} {entropy}"
                );
            }
        }
    }
}

#[test]
fn velocities_and_entropies_are_those_of_the_reference() {
    agrees_with_the_twin::<f64, 1>();
    agrees_with_the_twin::<f64, 2>();
    agrees_with_the_twin::<f64, 3>();
    agrees_with_the_twin::<f32, 1>();
    agrees_with_the_twin::<f32, 2>();
    agrees_with_the_twin::<f32, 3>();
}

/// The velocity of a particle is minus the entropy's gradient over its mass, for mollifiers of both signs too. By central differences of 1e-5: 1e-9 of the third derivatives, some thousands here.
#[test]
fn velocities_are_the_gradient_of_the_entropy() {
    for (m, mollifier) in [
        (1.0, COMPACT),
        (3.0, COMPACT),
        (3.0, Mollifier::Compact { order: 4, exponent: 5 }),
        (2.0, Mollifier::Gaussian { order: 4 }),
    ] {
        let (kernel, by) = (no_force::<f64, 2>(), diffusion(m, mollifier, 0.5));
        let mut case = Case::<f64, 2>::random(20, 0);
        let plan = case.plan(&kernel, VELOCITY_AND_ENERGY, &Options::default(), &by);
        let entropy = |case: &mut Case<f64, 2>| {
            case.step(&kernel, &plan, 1.0, 0).unwrap();
            case.report.energy.unwrap().0
        };
        entropy(&mut case);
        let velocity = case.velocity.clone();
        for i in [0, 7, 19] {
            for (k, &got) in velocity[i].iter().enumerate() {
                let moved = |by: f64| {
                    let mut case = case.clone();
                    case.x[i][k] += by;
                    entropy(&mut case)
                };
                let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                let want = -slope / case.masses[i];
                assert!((got - want).abs() < 1e-5 * (1.0 + want.abs()), "{m} {got} {want}");
            }
        }
    }
}

/// The kernel's functions are the mollifier's accurate ones, and the Laplacian is that of differences.
#[test]
fn the_kernel_is_the_mollifier() {
    fn check<const D: usize>(mollifier: Mollifier) {
        let (kernel, delta) = (Density::<f64, D>::new(mollifier, 0.3).unwrap(), 0.3);
        let blob = kernel.blob();
        let (peak, bend) = (blob.density(0.0), blob.density(0.0) / (delta * delta));
        for k in 1..80 {
            let (r, step) = (0.005 * f64::from(k), 1e-5);
            assert!((kernel.value(r) - blob.density(r)).abs() < 1e-14 * peak.abs());
            assert!((kernel.gradient_factor(r) - blob.density_slope(r)).abs() < 1e-12 * bend);
            let at = |r: f64| blob.density_slope(r) * r;
            let want = (at(r + step) - at(r - step)) / (2.0 * step) + (D as f64 - 1.0) * blob.density_slope(r);
            assert!(
                (kernel.laplacian(r) - want).abs() < 1e-5 * bend,
                "{mollifier:?} {r} {} {want}",
                kernel.laplacian(r)
            );
        }
    }
    for mollifier in [COMPACT, Mollifier::Compact { order: 6, exponent: 5 }, GAUSSIAN, Mollifier::Gaussian { order: 6 }]
    {
        check::<1>(mollifier);
        check::<2>(mollifier);
        check::<3>(mollifier);
    }
}

/// Particles on a lattice of width h within `radius`, with the profile's masses.
fn lattice<const D: usize>(profile: &Profile<f64, D>, h: f64, radius: f64) -> Case<f64, D> {
    let half = (radius / h).ceil() as i32;
    let side = 2 * half as usize;
    let points = (0..side.pow(D as u32)).map(|k| -> [f64; D] {
        std::array::from_fn(|d| ((k / side.pow(d as u32) % side) as f64 - f64::from(half) + 0.5) * h)
    });
    let of = |x: &[f64; D]| profile.density(x.iter().map(|c| c * c).sum::<f64>().sqrt());
    let x: Vec<_> = points.filter(|x| of(x) > 0.0 && x.iter().map(|c| c * c).sum::<f64>() < radius * radius).collect();
    let masses = x.iter().map(|x| of(x) * h.powi(D as i32)).collect();
    Case::new(x, masses, vec![])
}

/// The mean over the mass of the distance to the exact places, relative to that of the places.
fn error<const D: usize>(case: &Case<f64, D>, start: &[[f64; D]], stretch: f64) -> f64 {
    let length = |x: &[f64; D]| x.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (mut wrong, mut whole) = (0.0, 0.0);
    for ((x, start), m) in case.x.iter().zip(start).zip(&case.masses) {
        let want = start.map(|c| stretch * c);
        wrong += m * length(&std::array::from_fn(|d| x[d] - want[d]));
        whole += m * length(&want);
    }
    wrong / whole
}

/// Twice the mean square of a coordinate of a blob: what bounds the step.
fn width<const D: usize>(mollifier: Mollifier, length: f64) -> f64 {
    match mollifier {
        Mollifier::Compact { exponent, .. } => 2.0 * length * length / (2.0 * f64::from(exponent) + D as f64 + 2.0),
        _ => length * length,
    }
}

/// The error after the exact solution has widened by a factor of 1.5, with blobs of length `factor h^q`.
fn spread<const D: usize>(m: f64, mollifier: Mollifier, h: f64, length: f64) -> f64 {
    let exact = Spreading::<f64, D>::new(m, 1.0, 1.0).unwrap();
    // Of a mean square of D / 4 at the start.
    let grows = 2.0 / (D as f64 * (m - 1.0) + 2.0);
    let from = (D as f64 / 4.0 / exact.at(1.0).mean_square()).powf(1.0 / grows);
    let to = from * 1.5_f64.powf(2.0 / grows);
    let start = exact.at(from);
    let mut case = lattice(&start, h, if m == 1.0 { 2.5 } else { 10.0 });
    let before = case.x.clone();
    let kernel = no_force::<f64, D>();
    let plan = case.plan(
        &kernel,
        Wanted { energy: true, ..Wanted::default() },
        &Options::default(),
        &diffusion(m, mollifier, length),
    );
    let limit = 0.5 * width::<D>(mollifier, length) / (m * start.peak.powf(m - 1.0));
    let steps = ((to - from) / limit).ceil();
    assert_eq!(
        case.step(&kernel, &plan, (to - from) / steps, steps as usize),
        Ok(()),
        "{m} {mollifier:?} {h} {length}"
    );
    error(&case, &before, exact.stretch(from, to))
}

/// Errors of three spacings with blobs of length 2 h^0.9, printed, and the orders between them, which lie between `least` and `most`.
fn order<const D: usize>(m: f64, mollifier: Mollifier, spacings: [f64; 3], [least, most]: [f64; 2]) {
    let errors = spacings.map(|h: f64| spread::<D>(m, mollifier, h, 2.0 * h.powf(0.9)));
    for k in 0..2 {
        let order = (errors[k] / errors[k + 1]).ln() / (spacings[k] / spacings[k + 1]).ln();
        println!(
            "{D}D m = {m}, order {}, h = {}: {:.3e}, order {order:.2}",
            mollifier.order(),
            spacings[k + 1],
            errors[k + 1]
        );
        assert!((least..most).contains(&order), "{D}D {m} {mollifier:?}: {errors:?} {order}");
    }
}

/// With blobs of order 2 the velocity is wrong by eps^4 for m = 1, as the two terms' errors of order eps^2 cancel in f = log, and by eps^2 for m > 1; eps = 2 h^0.9. The edge of
/// Barenblatt's profile, like s for m = 2 and like s^(1/2) for m = 3, allows orders of 2 and about 1.7 in the mean, whatever the order of the blobs.
#[test]
fn orders_of_convergence() {
    let line = [0.1, 0.05, 0.025];
    order::<1>(1.0, GAUSSIAN, line, [3.3, 3.7]);
    order::<1>(2.0, GAUSSIAN, line, [1.6, 2.0]);
    order::<1>(2.0, Mollifier::Gaussian { order: 4 }, line, [2.0, 2.4]);
    order::<1>(3.0, GAUSSIAN, line, [1.4, 1.8]);
    let plane = [0.2, 0.14, 0.1];
    order::<2>(1.0, GAUSSIAN, plane, [2.9, 3.5]);
    order::<2>(2.0, GAUSSIAN, plane, [1.5, 2.0]);
    order::<2>(3.0, GAUSSIAN, plane, [1.2, 2.0]);
}

/// Particles that start too wide and are drawn together by |x|^2 / 2: the mean square at the end relative to that of the steady state, less 1, and blobs' length squared relative to it.
fn settled<const D: usize>(m: f64, h: f64) -> [f64; 2] {
    let steady = steady::<f64, D>(m, 1.0, 1.0).unwrap();
    // 1.3 times as wide.
    let wide = Profile { peak: steady.peak / 1.3_f64.powi(D as i32), square: 1.69 * steady.square, ..steady };
    let mut case = lattice(&wide, h, 4.0 * wide.mean_square().sqrt());
    let mass: f64 = case.masses.iter().sum();
    case.masses.iter_mut().for_each(|m| *m /= mass);
    let terms = [Term { law: Law::Power { exponent: 2.0 }, coefficient: 1.0 }];
    let mut memory = vec![0; Kernel::<f64, D>::workspace_bytes(&terms, Mollifier::None).unwrap() + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);
    let kernel = Kernel::<f64, D>::prepare(&mut memory[start..], &terms, Mollifier::None, 0.0).unwrap();
    let length = 1.5 * h.powf(0.9);
    let wanted = Wanted { energy: true, ..Wanted::default() };
    let plan = case.plan(&kernel, wanted, &Options::default(), &diffusion(m, GAUSSIAN, length));
    let dt = (0.5 * width::<D>(GAUSSIAN, length) / (m * steady.peak.powf(m - 1.0))).min(0.1);
    // Differences decay like e^(-2 t) for m = 1, faster above.
    case.step(&kernel, &plan, dt, (6.0 / dt) as usize).unwrap();
    let (first, last) = case.report.energy.unwrap();
    assert!(last < first, "{first} {last}");
    let moments = diagnostics::moments(&case.x, &case.masses).unwrap();
    let relative = [moments.second / moments.mass - steady.mean_square(), length * length];
    relative.map(|x| x / steady.mean_square())
}

/// For m = 1 the blobs' errors of order eps^2 cancel, as in `orders_of_convergence`; 3.1e-4 and a tenth of it were found. For m > 1 the state is narrower, by less than eps^2.
#[test]
fn attraction_and_diffusion_end_at_the_steady_state() {
    for m in [1.0, 2.0, 3.0] {
        let [coarse, fine] = [0.1, 0.05].map(|h| settled::<1>(m, h));
        println!("1D m = {m}: {:.2e}, {:.2e}", coarse[0], fine[0]);
        assert!(fine[0].abs() < coarse[0].abs() / 2.5, "{m} {coarse:?} {fine:?}");
        assert!(fine[0].abs() < if m == 1.0 { 1e-4 } else { fine[1] }, "{m} {fine:?}");
    }
    let [error, square] = settled::<2>(2.0, 0.28);
    println!("2D m = 2: {error:.2e}");
    assert!(error.abs() < square, "{error} {square}");
}

/// The centre of mass rests to rounding, and the energy falls at every step, which a run checks itself.
#[test]
fn the_centre_rests_and_the_energy_falls() {
    for (m, mollifier, tolerance) in
        [(1.0, COMPACT, 0.0), (2.0, GAUSSIAN, 0.0), (3.0, COMPACT, 0.0), (1.0, GAUSSIAN, 1e-9)]
    {
        let mut case = Case::<f64, 2>::random(200, 0);
        let kernel = Kernel::<f64, 2>::newtonian(1.0, COMPACT, 0.3).unwrap();
        let options = Options { tolerance, ..Options::default() };
        let plan =
            case.plan(&kernel, Wanted { energy: true, ..Wanted::default() }, &options, &diffusion(m, mollifier, 0.3));
        let before = diagnostics::moments(&case.x, &case.masses).unwrap();
        case.step(&kernel, &plan, 0.002, 30).unwrap();
        let after = diagnostics::moments(&case.x, &case.masses).unwrap();
        let (first, last) = case.report.energy.unwrap();
        assert!(last < first - 1e-3, "{first} {last}");
        for k in 0..2 {
            assert!((after.centre[k] - before.centre[k]).abs() < 1e-13 + tolerance, "{m}");
        }
    }
}

/// A step that is too long for the blobs' fastest mode raises the energy, which a watched run reports.
#[test]
fn steps_too_long_raise_the_energy() {
    let mut case = lattice(&Spreading::<f64, 1>::new(2.0, 1.0, 1.0).unwrap().at(0.1), 0.02, 2.0);
    case.x.iter_mut().enumerate().for_each(|(k, x)| x[0] += 0.002 * (k as f64 * 1.7).sin());
    let kernel = no_force::<f64, 1>();
    let plan = case.plan(
        &kernel,
        Wanted { energy: true, ..Wanted::default() },
        &Options::default(),
        &diffusion(2.0, COMPACT, 0.08),
    );
    assert_eq!(case.step(&kernel, &plan, 0.05, 20), Err(Error::EnergyRose));
    // The bound for m = 2, by the blob function as a kernel.
    let twice: Vec<f64> = case.masses.iter().map(|m| 2.0 * m).collect();
    let blobs = Density::<f64, 1>::new(COMPACT, 0.08).unwrap();
    let step = diagnostics::stable_step(&blobs, &case.x, &twice).unwrap();
    case.step(&kernel, &plan, step, 20).unwrap();
}

/// m = 2 needs one sum and no density; a kernel of coefficient 0 no sum; no diffusion nothing.
#[test]
fn what_is_not_needed_is_skipped() {
    let n = 50_u64;
    let attraction = Kernel::<f64, 2>::newtonian(1.0, COMPACT, 0.3).unwrap();
    let counts = |kernel: &Kernel<'_, f64, 2>, m: f64, coefficient: f64, energy: bool| {
        let mut case = Case::<f64, 2>::random(n as usize, 0);
        let by = Diffusion { coefficient, ..diffusion(m, GAUSSIAN, 0.3) };
        let plan = case.plan(kernel, Wanted { energy, ..Wanted::default() }, &Options::default(), &by);
        let bytes = plan.workspace_bytes::<f64, 2>(1).unwrap();
        case.step(kernel, &plan, 0.01, 1).unwrap();
        (case.counters.pairs, bytes, plan.diffusion_field().is_some())
    };
    let none = no_force();
    let all = n * n;
    assert_eq!(counts(&none, 2.0, 1.0, false).0, 4 * all);
    assert_eq!(counts(&none, 3.0, 1.0, false).0, 8 * all);
    assert_eq!(counts(&attraction, 2.0, 1.0, false).0, 8 * all);
    assert_eq!(counts(&attraction, 1.0, 1.0, false).0, 12 * all);
    // The energy shares the sums of the first stage, and takes one of each kind at the end.
    assert_eq!(counts(&none, 2.0, 1.0, true).0, 5 * all);
    assert_eq!(counts(&attraction, 3.0, 1.0, true).0, 14 * all);
    let plain = aggregation::plan(&attraction, n as usize, 0, Wanted::default(), &Options::default()).unwrap();
    assert_eq!(counts(&attraction, 1.0, 0.0, false), (4 * all, plain.workspace_bytes::<f64, 2>(1).unwrap(), false));
    // And m = 2 takes no memory for densities and weights.
    assert!(counts(&none, 2.0, 1.0, false).1 + 8 * 4 * n as usize <= counts(&none, 3.0, 1.0, false).1);
}

/// Blobs visit near pairs alone.
#[test]
fn fast_sums_of_blobs_are_those_of_all_pairs() {
    fn check<const D: usize>(mollifier: Mollifier, length: f64, method: Method, reason: Reason, tolerance: f64) {
        let n = 2000;
        let case = Case::<f64, D>::random(n, 0);
        let kernel = Density::<f64, D>::new(mollifier, length).unwrap();
        let sums = |options: &Options| {
            let wanted = field::Wanted { potential: true, gradient: true, ..field::Wanted::default() };
            let plan = field::plan(&kernel, n, n, wanted, options).unwrap();
            let (mut density, mut gradient) = (vec![0.0; n], vec![[0.0; D]; n]);
            let outputs =
                Outputs { potential: Some(&mut density), gradient: Some(&mut gradient), ..Outputs::default() };
            let mut counters = Statistics::default();
            let mut run = Run { counters: Some(&mut counters), ..Run::default() };
            let sources = Sources::new(&case.x, &case.masses);
            in_workspace(plan.workspace_bytes(1).unwrap(), |workspace| {
                field::evaluate(&plan, &kernel, sources, &case.x, outputs, workspace, &mut run).unwrap();
            });
            (plan.method(), plan.reason(), density, gradient, counters.pairs)
        };
        let fast = sums(&Options { tolerance, ..Options::default() });
        let all = sums(&Options { method: Some(Method::Direct), ..Options::default() });
        assert_eq!((fast.0, fast.1), (method, reason), "{D}D {mollifier:?}");
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = |a: &[f64], b: &[f64]| norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(b);
        // Gradients cancel: their sum of magnitudes is 50 times the result's here.
        let allowed = tolerance + 1e-13;
        assert!(apart(&fast.2, &all.2) < allowed, "{:e}", apart(&fast.2, &all.2));
        let error = apart(fast.3.as_flattened(), all.3.as_flattened());
        assert!(error < 50.0 * allowed, "{error:e}");
        assert!(fast.4 < all.4 / 2, "{} {}", fast.4, all.4);
    }
    check::<1>(COMPACT, 0.02, Method::Neighbours, Reason::ShortRange, 0.0);
    check::<2>(COMPACT, 0.05, Method::Neighbours, Reason::ShortRange, 0.0);
    check::<3>(Mollifier::Compact { order: 4, exponent: 3 }, 0.1, Method::Neighbours, Reason::ShortRange, 0.0);
    check::<1>(GAUSSIAN, 0.01, Method::Neighbours, Reason::ShortRange, 0.0);
    check::<2>(GAUSSIAN, 0.02, Method::Neighbours, Reason::ShortRange, 0.0);
    check::<3>(Mollifier::Gaussian { order: 6 }, 0.01, Method::Neighbours, Reason::ShortRange, 0.0);
}

/// Particles at one place share their densities and stay together; none and one rest.
#[test]
fn few_and_coincident_particles() {
    for m in [1.0, 1.5, 2.0, 3.0] {
        for mollifier in [COMPACT, GAUSSIAN] {
            let by = diffusion(m, mollifier, 0.5);
            let kernel = no_force::<f64, 2>();
            let run = |x: Vec<[f64; 2]>| {
                let mut case = Case::new(x.clone(), vec![0.5; x.len()], vec![[9.0; 2]]);
                let plan = case.plan(&kernel, VELOCITY_AND_ENERGY, &Options::default(), &by);
                case.step(&kernel, &plan, 0.01, 2).unwrap();
                case
            };
            assert_eq!(run(vec![]).report.energy, Some((0.0, 0.0)));
            let one = run(vec![[0.3, 0.4]]);
            assert_eq!((one.x[0], one.velocity[0]), ([0.3, 0.4], [0.0; 2]));
            let four = run(vec![[0.3, 0.4]; 4]);
            assert_eq!(four.x, [[0.3, 0.4]; 4]);
            // A pair beside a third one, all of which move apart.
            let three = run(vec![[0.0, 0.0], [0.0, 0.0], [0.2, 0.0]]);
            assert!(three.x[0] == three.x[1] && three.x[0][0] < 0.0 && three.x[2][0] > 0.2);
            // A tracer beyond all blobs, and a particle without mass there.
            if mollifier.is_compact() {
                assert_eq!(three.tracers[0], [9.0; 2]);
            }
            let mut massless = Case::new(vec![[0.0, 0.0], [9.0, 0.0]], vec![1.0, 0.0], vec![]);
            let plan = massless.plan(&kernel, VELOCITY_AND_ENERGY, &Options::default(), &by);
            massless.step(&kernel, &plan, 0.01, 2).unwrap();
            assert!(massless.x.as_flattened().iter().all(|c| c.is_finite()));
        }
    }
}

#[test]
fn refusals() {
    let kernel = Kernel::<f64, 2>::newtonian(1.0, COMPACT, 0.3).unwrap();
    let with = |by: Diffusion, wanted: Wanted| {
        let plan = aggregation::plan(&kernel, 3, 0, wanted, &Options::default()).unwrap();
        plan.with_diffusion::<f64, 2>(&by, &Options::default()).map(|_| ())
    };
    let good = diffusion(1.0, COMPACT, 0.5);
    let refused = |error: Error, by: Diffusion| assert_eq!(with(by, Wanted::default()), Err(error), "{by:?}");
    assert_eq!(with(good, Wanted::default()), Ok(()));
    for wrong in [f64::NAN, f64::INFINITY] {
        refused(Error::NotFinite, Diffusion { exponent: wrong, ..good });
        refused(Error::NotFinite, Diffusion { coefficient: wrong, ..good });
        refused(Error::Delta, Diffusion { length: wrong, ..good });
    }
    refused(Error::OutOfDomain, Diffusion { exponent: 0.99, ..good });
    refused(Error::OutOfDomain, Diffusion { coefficient: -1.0, ..good });
    refused(Error::Delta, Diffusion { length: 0.0, ..good });
    refused(Error::Delta, Diffusion { length: 1e-100, ..good });
    refused(Error::Unsupported, Diffusion { mollifier: Mollifier::None, ..good });
    refused(Error::Unsupported, Diffusion { mollifier: Mollifier::Plummer, ..good });
    refused(Error::Exponent, Diffusion { mollifier: Mollifier::Compact { order: 2, exponent: 1 }, ..good });
    for mollifier in [Mollifier::Compact { order: 4, exponent: 4 }, Mollifier::Gaussian { order: 6 }] {
        for exponent in [1.0, 1.5, 2.5, 65.0] {
            refused(Error::SignChange, Diffusion { mollifier, exponent, ..good });
        }
        assert_eq!(with(Diffusion { mollifier, exponent: 3.0, ..good }, Wanted::default()), Ok(()));
    }
    for wanted in [Wanted { density: true, ..Wanted::default() }, Wanted { divergence: true, ..Wanted::default() }] {
        assert_eq!(with(good, wanted), Err(Error::Unsupported));
        assert_eq!(with(Diffusion { coefficient: 0.0, ..good }, wanted), Ok(()));
    }
    // A run: masses, positions, memory. Nothing is moved.
    let good = Case::<f64, 2>::random(20, 3);
    let by = diffusion(1.0, COMPACT, 0.5);
    let plan = good.plan(&kernel, VELOCITY_AND_ENERGY, &Options::default(), &by);
    let bytes = plan.workspace_bytes::<f64, 2>(1).unwrap();
    let fails = |error: Error, bytes: usize, spoil: &dyn Fn(&mut Case<f64, 2>)| {
        let mut case = good.clone();
        spoil(&mut case);
        let before = format!("{:?}", (&case.x, &case.tracers, &case.velocity));
        assert_eq!(in_workspace(bytes, |memory| case.step_in(&kernel, &plan, 0.01, 1, memory)), Err(error));
        assert_eq!(before, format!("{:?}", (&case.x, &case.tracers, &case.velocity)));
    };
    fails(Error::Mass, bytes, &|case| case.masses[3] = -1.0);
    fails(Error::NotFinite, bytes, &|case| case.masses[3] = f64::NAN);
    fails(Error::NotFinite, bytes, &|case| case.x[3][1] = f64::NAN);
    fails(Error::NotFinite, bytes, &|case| case.tracers[2][1] = f64::INFINITY);
    fails(Error::WorkspaceTooSmall, bytes - 1, &|_| {});
    // A mass whose density is out of range.
    fails(Error::BecameNotFinite, bytes, &|case| case.masses.fill(1e308));
}
