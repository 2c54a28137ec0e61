//! The blob method with turned gradients: what vortices keep, exact motions, and how fast errors fall.

use std::f64::consts::{PI, TAU};

use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::exact::vortex::{self, Flow};
use mollis_core::exec::Run;
use mollis_core::field::Options;
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_core::{Error, Real, Result};
use mollis_tests::Aligned;

const VORTICES: (f64, f64) = (0.0, -1.0);
const COMPACT: Mollifier = Mollifier::Compact { order: 4, exponent: 4 };

fn newtonian<const D: usize>(mollifier: Mollifier, delta: f64) -> Kernel<'static, f64, D> {
    Kernel::newtonian(1.0, mollifier, delta).unwrap()
}

/// Vortices in the plane, with everything that a run can tell.
#[derive(Clone, Debug, PartialEq)]
struct Vortices {
    x: Vec<[f64; 2]>,
    m: Vec<f64>,
    rho: Vec<f64>,
    velocity: Vec<[f64; 2]>,
}

impl Vortices {
    fn new(x: Vec<[f64; 2]>, m: Vec<f64>) -> Self {
        let rho = (0..m.len()).map(|k| 1.0 + k as f64).collect();
        Self { velocity: vec![[0.0; 2]; x.len()], x, m, rho }
    }

    /// Runs to `time`, and returns the first and the last energy. Without a step there are velocities only.
    fn run(
        &mut self,
        kernel: &Kernel<'_, f64, 2>,
        combination: (f64, f64),
        time: f64,
        steps: usize,
    ) -> Result<(f64, f64)> {
        let options = Options { combination, ..Options::default() };
        let wanted = Wanted { density: true, velocity: true, divergence: false, energy: steps > 0 };
        let plan = aggregation::plan(kernel, self.x.len(), 0, wanted, &options)?;
        let mut memory = Aligned::new(plan.workspace_bytes::<f64, 2>(1)?);
        let state = State {
            masses: &self.m,
            particles: Trajectories {
                positions: &mut self.x,
                density: Some(&mut self.rho),
                velocity: Some(&mut self.velocity),
                divergence: None,
            },
            tracers: Trajectories::none(),
        };
        let advance = Advance { dt: time / steps.max(1) as f64, steps, after_step: None };
        let mut report = Report::default();
        aggregation::step(&plan, kernel, state, advance, memory.bytes(), &mut Run::default(), &mut report)?;
        Ok(report.energy.unwrap_or_default())
    }

    /// sum m x, sum m |x|^2.
    fn moments(&self) -> ([f64; 2], f64) {
        let along = |k: usize| self.x.iter().zip(&self.m).map(|(x, m)| m * x[k]).sum();
        let second = self.x.iter().zip(&self.m).map(|(x, m)| m * (x[0] * x[0] + x[1] * x[1])).sum();
        ([along(0), along(1)], second)
    }
}

/// Errors that are divided by at least this much when the step is halved are of fourth order: 16, less a few per cent.
const FOURTH: f64 = 15.0;

/// What vortices keep: the centre to rounding, their densities bit for bit; angular impulse and energy to the error of RK4, whose fourth order is seen in two halvings.
fn keeps_invariants(start: &Vortices, kernel: &Kernel<'_, f64, 2>, time: f64, steps: [usize; 3]) {
    let (first, second) = start.moments();
    let errors = steps.map(|steps| {
        let mut moved = start.clone();
        let (before, after) = moved.run(kernel, VORTICES, time, steps).unwrap();
        let (now, turned) = moved.moments();
        for k in 0..2 {
            assert!((now[k] - first[k]).abs() <= 1e-13, "{now:?} {first:?}");
        }
        assert_eq!((&moved.m, &moved.rho), (&start.m, &start.rho));
        assert!(moved.x.iter().zip(&start.x).any(|(x, y)| (x[0] - y[0]).hypot(x[1] - y[1]) > 0.3), "it moves");
        [(turned - second).abs(), (after - before).abs()]
    });
    for k in 0..2 {
        for pair in errors.windows(2) {
            assert!(pair[1][k] > 1e-13 && pair[0][k] / pair[1][k] >= FOURTH, "{errors:?}");
        }
        assert!(errors[2][k] <= 1e-6, "{errors:?}");
    }
}

/// Two overlapping vortices, of one sign and of both, and three.
#[test]
fn mollified_pairs_keep_their_invariants() {
    let kernel = newtonian(COMPACT, 1.0);
    for (x, m) in [
        (vec![[0.3, 0.1], [-0.2, -0.15]], vec![1.0, 0.5]),
        (vec![[0.3, 0.1], [-0.2, -0.15], [0.1, -0.3]], vec![2.0, -1.0, 1.5]),
    ] {
        keeps_invariants(&Vortices::new(x, m), &kernel, 2.0, [16, 32, 64]);
    }
}

/// Points of a lattice of this spacing with the masses of a vortex of Lamb and Oseen, exp(-r^2) / pi, where that is above 1e-14.
fn lamb_oseen(h: f64) -> Vortices {
    let side = (5.7 / h) as i32;
    let lattice = (-side..=side).flat_map(|i| (-side..=side).map(move |j| [f64::from(i) * h, f64::from(j) * h]));
    let mass = |[x, y]: [f64; 2]| h * h * (-x * x - y * y).exp() / PI;
    let (x, m) = lattice.map(|x| (x, mass(x))).filter(|(_, m)| *m > 1e-14 * h * h).unzip();
    Vortices::new(x, m)
}

/// A patch with a Gaussian vorticity and a weak one beside it, so that the flow is not circular.
#[test]
fn a_patch_of_lamb_and_oseen_keeps_its_invariants() {
    let mut patch = lamb_oseen(0.5);
    let strong: Vec<_> = patch.x.iter().zip(&patch.m).filter(|(_, m)| **m > 1e-5).map(|(x, m)| (*x, 8.0 * m)).collect();
    let beside = strong.iter().map(|([x, y], m)| ([x + 1.75, y - 0.75], -0.25 * m));
    (patch.x, patch.m) = strong.iter().copied().chain(beside).unzip();
    patch = Vortices::new(patch.x, patch.m);
    keeps_invariants(&patch, &newtonian(COMPACT, 1.5), 2.0, [4, 8, 16]);
}

/// Under a Gaussian mollifier of order 2 the vortex exp(-r^2) / pi is the one that diffusion has widened to 1 + delta^2: v = (1 - exp(-r^2 / (1 + delta^2))) / (2 pi r),
/// counter-clockwise. The sums' terms are products with a squared width of delta^2 / (1 + delta^2) = 0.69,
/// which a lattice of spacing h adds up to exp(-0.69 (pi / h)^2) = 2e-15. What is left are roundings and the masses left out.
#[test]
fn the_velocity_of_lamb_and_oseen() {
    let delta = 1.5;
    let mut patch = lamb_oseen(0.45);
    patch.run(&newtonian(Mollifier::Gaussian { order: 2 }, delta), VORTICES, 0.0, 0).unwrap();
    for ([x, y], [u, v]) in patch.x.iter().zip(&patch.velocity) {
        let square = x * x + y * y;
        let rate = if square == 0.0 { 0.0 } else { -(-square / (1.0 + delta * delta)).exp_m1() / (TAU * square) };
        assert!((u + rate * y).abs() <= 1e-12 && (v - rate * x).abs() <= 1e-12, "{x} {y}: {u} {v}");
    }
}

/// Farther apart than delta the mollifier is not felt. Pairs turn about their centre, spiral or move side by side at the known speed; the error is of fourth order.
#[test]
fn pairs_move_as_point_vortices() {
    let kernel = newtonian(COMPACT, 0.4);
    let points = [[0.5, 0.0], [-0.5, 0.25]];
    for (masses, combination, time) in [
        ([1.0, 1.0], VORTICES, 6.0),
        ([2.0, -0.5], VORTICES, 6.0),
        ([1.0, -1.0], VORTICES, 6.0),
        ([1.0, 0.5], (0.5, 1.0), 1.5),
        ([1.0, 0.5], (-1.0, -0.25), 1.5),
    ] {
        let flow = Flow { coefficient: 1.0, a: combination.0, b: combination.1 };
        let exact = flow.pair(points, masses, time);
        let errors = [16, 32, 64].map(|steps| {
            let mut pair = Vortices::new(points.to_vec(), masses.to_vec());
            pair.run(&kernel, combination, time, steps).unwrap();
            pair.x.iter().zip(exact).map(|(x, y)| (x[0] - y[0]).hypot(x[1] - y[1])).fold(0.0, f64::max)
        });
        // A pair that moves straight on has no error of the method.
        let straight = masses[0] + masses[1] == 0.0;
        let fourth = errors.windows(2).all(|pair| (14.0..=33.0).contains(&(pair[0] / pair[1])));
        assert!(if straight { errors[0] <= 1e-13 } else { fourth }, "{masses:?} {combination:?} {errors:?}");
    }
    // A pair of equal and opposite circulations moves at m / (2 pi r), across the line between them: upwards if the positive one is on the left.
    let mut pair = Vortices::new(vec![[0.5, 0.0], [-0.5, 0.0]], vec![-1.0, 1.0]);
    pair.run(&kernel, VORTICES, 0.0, 0).unwrap();
    for velocity in &pair.velocity {
        assert!(velocity[0].abs() <= 1e-16 && (velocity[1] - 1.0 / TAU).abs() <= 1e-15, "{velocity:?}");
    }
}

/// Nodes and weights of Gauss's rule on [0, 1].
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let legendre = |z: f64| {
        let (mut before, mut now) = (1.0, z);
        for k in 2..=n {
            let k = k as f64;
            (before, now) = (now, ((2.0 * k - 1.0) * z * now - (k - 1.0) * before) / k);
        }
        (now, n as f64 * (z * now - before) / (z * z - 1.0))
    };
    let node = |i: usize| {
        let mut z = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..8 {
            let (value, slope) = legendre(z);
            z -= value / slope;
        }
        (0.5 * (1.0 + z), 1.0 / ((1.0 - z * z) * legendre(z).1.powi(2)))
    };
    (0..n).map(node).collect()
}

const AXES: [f64; 2] = [1.0, 0.5];

/// An ellipse of vorticity 1: rings by Gauss's rule in the square of the radius, so that the edge costs no accuracy, and equal angles on each.
fn ellipse(rings: usize, angles: usize) -> Vortices {
    let ring = |(k, (square, weight)): (usize, (f64, f64))| {
        (0..angles).map(move |j| {
            let (sine, cosine) = (TAU * (j as f64 + 0.5 * (k % 2) as f64) / angles as f64).sin_cos();
            let r = square.sqrt();
            ([AXES[0] * r * cosine, AXES[1] * r * sine], PI * AXES[0] * AXES[1] * weight / angles as f64)
        })
    };
    let (x, m) = gauss(rings).into_iter().enumerate().flat_map(ring).unzip();
    Vortices::new(x, m)
}

/// Kirchhoff's ellipse turns at the rate p q / (p + q)^2. How errors fall with delta:
///
/// * Velocities are exact farther than delta from the edge, and wrong by order delta within: in L1 of order 2, for any order of the mollifier.
/// * The rate is that of the second moments. The velocity's error of order delta^2 is J grad f(vorticity), which moves no vorticity. So the rate is of order 3.
#[test]
fn kirchhoffs_ellipse_turns_at_the_known_rate() {
    let rate = vortex::ellipse_rate(1.0, AXES);
    let measure = |order: u32, delta: f64, patch: &mut Vortices| {
        patch.run(&newtonian(Mollifier::Compact { order, exponent: 4 }, delta), VORTICES, 0.0, 0).unwrap();
        let (mut mixed, mut difference, mut wrong) = (0.0, 0.0, 0.0);
        for (([x, y], [u, v]), m) in patch.x.iter().zip(&patch.velocity).zip(&patch.m) {
            mixed += m * (x * v + y * u);
            difference += m * (x * x - y * y);
            let exact = [-AXES[0] * y / (AXES[0] + AXES[1]), AXES[1] * x / (AXES[0] + AXES[1])];
            wrong += m * (u - exact[0]).hypot(v - exact[1]);
        }
        [(mixed / difference / rate - 1.0).abs(), wrong]
    };
    let mut patch = ellipse(24, 96);
    for order in [2, 4] {
        let [coarse, fine] = [0.4, 0.2].map(|delta| measure(order, delta, &mut patch));
        let orders = [0, 1].map(|k| f64::log2(coarse[k] / fine[k]));
        assert!(orders[0] >= 2.8 && orders[1] >= 1.8, "{orders:?}");
        assert!(fine[0] <= 5e-4, "{fine:?}");
    }
}

/// Through a radian of its turn, with the points where Kirchhoff's solution has them up to a layer of width delta at the edge.
#[test]
fn kirchhoffs_ellipse_in_motion() {
    let delta = 0.3;
    let start = ellipse(12, 48);
    let mut patch = start.clone();
    let time = 1.0 / vortex::ellipse_rate(1.0, AXES);
    let kernel = newtonian(Mollifier::Compact { order: 2, exponent: 4 }, delta);
    let (before, after) = patch.run(&kernel, VORTICES, time, 20).unwrap();
    assert!((after / before - 1.0).abs() <= 1e-6, "{before} {after}");
    let (first, last) = (start.moments(), patch.moments());
    assert!((last.1 / first.1 - 1.0).abs() <= 1e-6, "{first:?} {last:?}");
    let (mut mixed, mut difference) = (0.0, 0.0);
    for ([x, y], m) in patch.x.iter().zip(&patch.m) {
        mixed += m * 2.0 * x * y;
        difference += m * (x * x - y * y);
    }
    let angle = 0.5 * f64::atan2(mixed, difference);
    assert!((angle - 1.0).abs() <= 5e-3, "{angle}");
    for (x, from) in patch.x.iter().zip(&start.x) {
        let want = vortex::ellipse(1.0, AXES, *from, time);
        let inside = (from[0] / AXES[0]).hypot(from[1] / AXES[1]) < 0.35;
        assert!(!inside || (x[0] - want[0]).hypot(x[1] - want[1]) <= 5e-3, "{from:?} {x:?} {want:?}");
    }
}

/// The energy falls for a > 0 whatever b is, and is only reported for a <= 0.
#[test]
fn the_energy_falls_where_a_is_positive() {
    let kernel = newtonian(COMPACT, 0.5);
    let start = Vortices::new(vec![[0.3, 0.1], [-0.2, -0.15], [0.1, -0.4]], vec![1.0, 0.5, 0.7]);
    let run = |combination, m: [f64; 3]| {
        let mut case = start.clone();
        case.m = m.to_vec();
        case.run(&kernel, combination, 0.1, 10)
    };
    let masses = [1.0, 0.5, 0.7];
    for combination in [(1.0, 0.0), (1.0, -3.0), (0.25, 2.0)] {
        let (before, after) = run(combination, masses).unwrap();
        assert!(after < before);
        assert_eq!(run(combination, [1.0, -0.5, 0.7]), Err(Error::Mass));
    }
    let (before, after) = run((-1.0, 0.5), masses).unwrap();
    assert!(after > before);
    let (before, after) = run((0.0, 2.0), [1.0, -0.5, 0.7]).unwrap();
    assert!((after - before).abs() <= 1e-7 * before.abs());
}

fn refused<T: Real, const D: usize>(mollifier: Mollifier) {
    let kernel = Kernel::<T, D>::newtonian(T::ONE, mollifier, T::HALF).unwrap();
    let plan = |combination| {
        let options = Options { combination, ..Options::default() };
        aggregation::plan(&kernel, 3, 0, Wanted::default(), &options).map(|_| ())
    };
    let turned = if D == 2 { Ok(()) } else { Err(Error::Unsupported) };
    assert_eq!((plan((1.0, 0.0)), plan(VORTICES), plan((2.0, 0.0))), (Ok(()), turned, turned));
    assert_eq!((plan((f64::NAN, 0.0)), plan((1.0, f64::INFINITY))), (Err(Error::NotFinite), Err(Error::NotFinite)));
}

#[test]
fn only_the_plane_turns() {
    refused::<f64, 1>(COMPACT);
    refused::<f64, 2>(COMPACT);
    refused::<f64, 3>(COMPACT);
    refused::<f32, 1>(COMPACT);
    refused::<f32, 2>(COMPACT);
    refused::<f32, 3>(COMPACT);
}
