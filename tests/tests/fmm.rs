//! The fast multipole method in the plane against the sum over all pairs, on a sample of the targets.
//!
//! Errors are in the l2 norm over the sample, relative to that of sum_j |m_j| |K_j| (the promise), and to the sum's own (what users see).

use mollis_core::exec::{Executor, Run, Serial, Statistics};
use mollis_core::field::{self, Accumulation, Interaction, Method, Options, Outputs, Reason, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_reference::field::{Soft, newtonian};
use mollis_tests::{Aligned, Split, Threads};

const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
const FIELD: Wanted = Wanted { potential: true, gradient: true, laplacian: false, hessian: false };
const HESSIANS: Wanted = Wanted { hessian: true, ..FIELD };
const COMPACT: Mollifier = Mollifier::Compact { order: 4, exponent: 4 };

/// Points of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Points {
    Uniform,
    Normal,
    Ring,
    Line,
    /// Half of them in a square of side 1e-6.
    TwoScales,
    Lattice,
    /// Each point is the middle of the last one and of a corner of a triangle: a set of dimension log 3 / log 2.
    Fractal,
}

const POINTS: [Points; 7] =
    [Points::Uniform, Points::Normal, Points::Ring, Points::Line, Points::TwoScales, Points::Lattice, Points::Fractal];

fn points(kind: Points, n: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut numbers = Split(seed);
    let side = (n as f64).sqrt().ceil() as usize;
    let mut last = [0.2, 0.1];
    (0..n)
        .map(|k| {
            let (a, b) = (numbers.uniform(), numbers.uniform());
            let turn = std::f64::consts::TAU * b;
            match kind {
                Points::Uniform => [a, b],
                Points::Normal => [turn.cos(), turn.sin()].map(|x| x * (-2.0 * (1.0 - a).ln()).sqrt()),
                Points::Ring => [turn.cos(), turn.sin()],
                Points::Line => [a, 0.3 + 0.4 * a],
                Points::TwoScales if k % 2 == 0 => [0.3 + 1e-6 * a, 0.6 + 1e-6 * b],
                Points::TwoScales => [a, b],
                Points::Lattice => [(k % side) as f64 / side as f64, (k / side) as f64 / side as f64],
                Points::Fractal => {
                    let corner = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]][(3.0 * a) as usize];
                    last = [0.5 * (last[0] + corner[0]), 0.5 * (last[1] + corner[1])];
                    last
                }
            }
        })
        .collect()
}

fn masses(n: usize, signed: bool) -> Vec<f64> {
    let mut numbers = Split(5);
    (0..n).map(|_| numbers.uniform() - if signed { 0.5 } else { 0.0 }).collect()
}

fn of<T: Real, const D: usize>(x: &[[f64; D]]) -> Vec<[T; D]> {
    x.iter().map(|x| x.map(T::from_f64)).collect()
}

#[derive(Clone, Debug, PartialEq)]
struct Sums<T> {
    potential: Vec<T>,
    gradient: Vec<[T; 2]>,
    laplacian: Vec<T>,
    hessian: Vec<[[T; 2]; 2]>,
}

/// A sum.
struct Case<'a, T: Real> {
    kernel: &'a dyn Interaction<T, 2>,
    positions: &'a [[T; 2]],
    masses: &'a [T],
    radii: Option<&'a [T]>,
}

impl<'a, T: Real> Case<'a, T> {
    fn new(kernel: &'a dyn Interaction<T, 2>, positions: &'a [[T; 2]], masses: &'a [T]) -> Self {
        Self { kernel, positions, masses, radii: None }
    }

    /// In a workspace of just the bytes that the plan asks for, of arbitrary content.
    fn run(
        &self,
        targets: &[[T; 2]],
        wanted: Wanted,
        options: &Options,
        executor: &dyn Executor,
        level: Level,
    ) -> (Sums<T>, Statistics) {
        let options = Options { radii: self.radii.is_some(), ..*options };
        let n = targets.len();
        let plan = field::plan(self.kernel, self.positions.len(), n, wanted, &options).unwrap();
        let mut memory = Aligned::new(plan.workspace_bytes(executor.workers()).unwrap());
        let mut sums = Sums {
            potential: vec![T::NAN; n],
            gradient: vec![[T::NAN; 2]; n],
            laplacian: vec![T::NAN; n],
            hessian: vec![[[if wanted.hessian { T::NAN } else { T::ZERO }; 2]; 2]; n],
        };
        let mut counters = Statistics::default();
        let outputs = Outputs {
            potential: wanted.potential.then_some(&mut sums.potential[..]),
            gradient: wanted.gradient.then_some(&mut sums.gradient[..]),
            laplacian: wanted.laplacian.then_some(&mut sums.laplacian[..]),
            hessian: wanted.hessian.then_some(&mut sums.hessian[..]),
        };
        let sources = Sources::new(self.positions, self.masses);
        let sources = self.radii.map_or(sources, |radii| sources.with_radii(radii));
        let mut run = Run { executor, level, counters: Some(&mut counters), ..Run::default() };
        field::evaluate(&plan, self.kernel, sources, targets, outputs, memory.bytes(), &mut run).unwrap();
        (sums, counters)
    }

    fn fmm(&self, targets: &[[T; 2]], wanted: Wanted, tolerance: f64) -> (Sums<T>, Statistics) {
        let options = Options { tolerance, method: Some(Method::Fmm), ..Options::default() };
        self.run(targets, wanted, &options, &Serial, Level::best())
    }

    /// sum_j |m_j| |K_j| for potential, gradient, Laplacian and second derivatives at a target, by the bare kernel at no less than half a mollifier's length; for Laplacians 1 / length^2 within
    /// six lengths.
    fn sizes(&self, x: &[T; 2], delta: f64) -> [f64; 4] {
        let mut sizes = [0.0; 4];
        for (j, (y, m)) in self.positions.iter().zip(self.masses).enumerate() {
            let length = self.radii.map_or(delta, |radii| radii[j].to_f64());
            let r = (x[0] - y[0]).to_f64().hypot((x[1] - y[1]).to_f64());
            if r == 0.0 && length == 0.0 {
                continue;
            }
            let (m, distance) = (m.abs().to_f64(), r.max(0.5 * length));
            sizes[0] += m * distance.ln().abs() / std::f64::consts::TAU;
            sizes[1] += m / (std::f64::consts::TAU * distance);
            sizes[3] += m / (std::f64::consts::TAU * distance * distance);
            sizes[2] += if r < 6.0 * length { m / (length * length) } else { 0.0 };
        }
        sizes
    }

    /// Errors of potential, gradient, Laplacian and second derivatives on a sample of the targets, relative to the sizes and to the sums themselves: of sums over all pairs in the same
    /// precision, in compensated summation.
    fn errors(&self, targets: &[[T; 2]], got: &Sums<T>, wanted: Wanted, delta: f64) -> [[f64; 2]; 4] {
        let sample = sample(targets, 50);
        let accumulation = Accumulation::Compensated;
        let options = Options { method: Some(Method::Direct), accumulation, ..Options::default() };
        let (want, _) = self.run(&sample, wanted, &options, &Serial, Level::best());
        self.errors_from(&want, (&sample, each(targets.len(), 50)), got, wanted, delta)
    }

    /// The same, of sums that are given for a sample of which every `each`-th target is one.
    fn errors_from<U: Real>(
        &self,
        want: &Sums<U>,
        (sample, each): (&[[T; 2]], usize),
        got: &Sums<T>,
        wanted: Wanted,
        delta: f64,
    ) -> [[f64; 2]; 4] {
        let mut squares = [[0.0_f64; 3]; 4];
        for (k, x) in sample.iter().enumerate() {
            let sizes = self.sizes(x, delta);
            let mut add = |which: usize, got: T, want: U| {
                squares[which][0] += (got.to_f64() - want.to_f64()).powi(2);
                squares[which][2] += want.to_f64().powi(2);
            };
            if wanted.potential {
                add(0, got.potential[k * each], want.potential[k]);
            }
            if wanted.gradient {
                add(1, got.gradient[k * each][0], want.gradient[k][0]);
                add(1, got.gradient[k * each][1], want.gradient[k][1]);
            }
            if wanted.laplacian {
                add(2, got.laplacian[k * each], want.laplacian[k]);
            }
            if wanted.hessian {
                let got = got.hessian[k * each].as_flattened();
                got.iter().zip(want.hessian[k].as_flattened()).for_each(|(&got, &want)| add(3, got, want));
            }
            squares.iter_mut().zip(sizes).for_each(|(squares, size)| squares[1] += size.powi(2));
        }
        let ratio = |a: f64, b: f64| if a == 0.0 { 0.0 } else { (a / b).sqrt() };
        squares.map(|[error, size, own]| [ratio(error, size), ratio(error, own)])
    }
}

/// About so many of the targets.
fn sample<T: Real>(targets: &[[T; 2]], n: usize) -> Vec<[T; 2]> {
    targets.iter().step_by(each(targets.len(), n)).copied().collect()
}

/// How far apart they stand.
fn each(targets: usize, n: usize) -> usize {
    (targets / n).max(1)
}

/// Potentials and gradients of the bare kernel in double-double arithmetic, rounded.
fn exact<T: Real>(case: &Case<'_, T>, sample: &[[T; 2]]) -> Sums<f64> {
    let x: Vec<[f64; 2]> = case.positions.iter().map(|x| x.map(T::to_f64)).collect();
    let m: Vec<f64> = case.masses.iter().map(|m| m.to_f64()).collect();
    let sums: Vec<_> = sample.iter().map(|at| newtonian::<2>(None, &x, &m, &at.map(T::to_f64))).collect();
    Sums {
        potential: sums.iter().map(|sum| sum.potential.value()).collect(),
        gradient: sums.iter().map(|sum| [sum.gradient[0].value(), sum.gradient[1].value()]).collect(),
        laplacian: vec![0.0; sample.len()],
        hessian: vec![],
    }
}

fn blob<T: Real>(mollifier: Mollifier, delta: f64) -> Blob<T, 2> {
    Blob::new(mollifier, T::from_f64(delta)).unwrap()
}

fn tolerances<T: Real>(n: usize, tolerances: &[f64]) {
    let kernel = blob::<T>(Mollifier::None, 0.0);
    for kind in POINTS {
        let x = of::<T, 2>(&points(kind, n, 1));
        for signed in [false, true] {
            let m: Vec<T> = masses(n, signed).into_iter().map(T::from_f64).collect();
            let case = Case::new(&kernel, &x, &m);
            let some = sample(&x, 20);
            let want = exact(&case, &some);
            for &tolerance in tolerances {
                let (got, counts) = case.fmm(&x, FIELD, tolerance);
                let errors = case.errors_from(&want, (&some, each(n, 20)), &got, FIELD, kernel.delta().to_f64());
                let [potential, gradient, ..] = errors;
                println!("{kind:?} {signed} {tolerance:e}: {errors:?}, {} pairs", counts.pairs as f64 / n as f64);
                assert!(
                    potential[0] <= tolerance && gradient[0] <= tolerance,
                    "{kind:?} {signed} {tolerance}: {errors:?}"
                );
                assert!(gradient[1] <= tolerance, "{kind:?} {signed} {tolerance}: {errors:?}");
                assert!(counts.pairs < (n * n / 2) as u64, "{kind:?}: {}", counts.pairs);
                let (got, _) = case.fmm(&x, HESSIANS, tolerance);
                let [.., hessian] = case.errors(&x, &got, HESSIANS, kernel.delta().to_f64());
                println!("    second derivatives {hessian:?}");
                assert!(hessian[0] <= tolerance, "{kind:?} {signed} {tolerance}: {hessian:?}");
                assert!(got.hessian.iter().all(|[[a, b], [c, d]]| b == c && *a == -*d));
            }
        }
    }
}

#[test]
fn every_tolerance_on_every_kind_of_points() {
    tolerances::<f64>(5000, &[1e-3, 1e-6, 1e-9, 1e-12, 1e-13]);
}

/// Half of the targets within 1e-7, and half of these in one place: their errors do not average. What is near is mollified, so that all of their field comes from afar.
#[test]
fn crowds_of_targets_keep_the_tolerance() {
    let delta = 0.01;
    let soft = Soft { order: 2, exponent: 4, delta };
    let kernel = blob::<f64>(Mollifier::Compact { order: 2, exponent: 4 }, delta);
    let mut worst = [0.0_f64; 2];
    for seed in 0..6 {
        let mut numbers = Split(seed);
        let mut x: Vec<[f64; 2]> = (0..400).map(|_| [0, 1].map(|_| 2.0 * numbers.uniform() - 1.0)).collect();
        for k in (0..400).step_by(4) {
            x[k] = x[k].map(|c| 1e-7 * c);
            x[k + 1] = x[k];
        }
        for one_dominates in [false, true] {
            let mass = |u: f64| if one_dominates { 10_f64.powf(60.0 * u - 30.0) } else { u };
            let m: Vec<f64> = (0..400).map(|_| mass(numbers.uniform())).collect();
            let want: Vec<_> = x.iter().map(|at| newtonian::<2>(Some(soft), &x, &m, at)).collect();
            for tolerance in [1e-3, 1e-6, 1e-9, 1e-12, 1e-13] {
                let (got, _) = Case::new(&kernel, &x, &m).fmm(&x, FIELD, tolerance);
                let mut squares = [[0.0_f64; 2]; 2];
                for ((u, g), want) in got.potential.iter().zip(&got.gradient).zip(&want) {
                    squares[0][0] += (u - want.potential.value()).powi(2);
                    squares[0][1] += want.potential_size.powi(2);
                    for (g, (sum, size)) in g.iter().zip(want.gradient.iter().zip(want.gradient_size)) {
                        squares[1][0] += (g - sum.value()).powi(2);
                        squares[1][1] += size.powi(2);
                    }
                }
                for (worst, [error, size]) in worst.iter_mut().zip(squares) {
                    let share = (error / size).sqrt() / tolerance;
                    println!("{seed} {one_dominates} {tolerance:e}: {share:.3} of the tolerance");
                    *worst = worst.max(share);
                }
            }
        }
    }
    assert!(worst.iter().all(|&share| share <= 1.0), "{worst:?} times the tolerance");
}

#[test]
fn every_tolerance_in_single_precision() {
    tolerances::<f32>(3000, &[1e-3, 1e-5]);
}

/// Near pairs are the engine's: every mollifier, with supports that are smaller and larger than a leaf, and larger than all.
#[test]
fn every_mollifier() {
    let n = 2500;
    let (x, m) = (points(Points::Normal, n, 2), masses(n, true));
    let newtonian = [Term { law: Law::Newtonian, coefficient: -1.5 }];
    for mollifier in [
        COMPACT,
        Mollifier::Compact { order: 2, exponent: 1 },
        Mollifier::Compact { order: 8, exponent: 6 },
        Mollifier::Richardson { order: 6, exponent: 4 },
        Mollifier::Gaussian { order: 2 },
        Mollifier::Gaussian { order: 6 },
    ] {
        for delta in [1e-3, 0.05, 0.6, 20.0] {
            let mut memory = Aligned::new(Kernel::<f64, 2>::workspace_bytes(&newtonian, mollifier).unwrap());
            let kernel = Kernel::<f64, 2>::prepare(memory.bytes(), &newtonian, mollifier, delta).unwrap();
            let case = Case::new(&kernel, &x, &m);
            let (got, _) = case.fmm(&x, ALL, 1e-9);
            let [potential, gradient, laplacian, _] = case.errors(&x, &got, ALL, delta);
            assert!(potential[0] < 1e-9 && gradient[0] < 1e-9, "{mollifier:?} {delta}: {potential:?} {gradient:?}");
            assert!(laplacian[0] < 1e-12, "{mollifier:?} {delta}: {laplacian:?}");
        }
    }
}

/// Radii from 1e-3 to a few as large as everything: correct, and far from quadratic.
#[test]
fn core_radii() {
    let n = 12000;
    let (x, m) = (points(Points::Uniform, n, 3), masses(n, true));
    let kernel = blob(COMPACT, 1.0);
    let mut numbers = Split(9);
    let radii: Vec<f64> = (0..n)
        .map(|k| match k % 4000 {
            17 => 2.0,
            18..28 => 0.05,
            _ => 1e-3 * (1.0 + numbers.uniform()),
        })
        .collect();
    let case = Case { radii: Some(&radii), ..Case::new(&kernel, &x, &m) };
    let (got, counts) = case.fmm(&x, ALL, 1e-6);
    let [potential, gradient, laplacian, _] = case.errors(&x, &got, ALL, kernel.delta());
    assert!(
        potential[0] < 1e-6 && gradient[0] < 1e-6 && laplacian[0] < 1e-12,
        "{potential:?} {gradient:?} {laplacian:?}"
    );
    let pairs = counts.pairs as f64 / n as f64;
    assert!(pairs < 600.0, "{pairs} pairs a target");
}

#[test]
fn targets_need_not_be_sources() {
    let (n, n_targets) = (6000, 1500);
    let (x, m, y) = (points(Points::Ring, n, 4), masses(n, true), points(Points::Uniform, n_targets, 5));
    let kernel = blob(COMPACT, 0.01);
    let case = Case::new(&kernel, &x, &m);
    for targets in [&y[..], &y[..1], &[[1e3, -1e3]], &x[..500]] {
        let (got, _) = case.fmm(targets, ALL, 1e-8);
        let errors = case.errors(targets, &got, ALL, kernel.delta());
        assert!(errors[0][0] < 1e-8 && errors[1][0] < 1e-8 && errors[2][0] < 1e-12, "{errors:?}");
    }
}

#[test]
fn all_sizes() {
    let kernel = blob(COMPACT, 0.05);
    for n in [0, 1, 2, 3, 15, 16, 17, 31, 32, 33, 63, 64, 65, 129, 1024, 1025, 2100] {
        let (x, m) = (points(Points::Uniform, n, 6), masses(n, true));
        let case = Case::new(&kernel, &x, &m);
        let (got, counts) = case.fmm(&x, ALL, 1e-10);
        let errors = case.errors(&x, &got, ALL, kernel.delta());
        assert!(errors[0][0] < 1e-10 && errors[1][0] < 1e-10 && errors[2][0] < 1e-12, "{n}: {errors:?}");
        assert!(counts.pairs <= (n * n) as u64);
        // No source, or none with mass; no target.
        let none = Case::new(&kernel, &[], &[]);
        let (got, _) = none.fmm(&x, ALL, 1e-6);
        assert!(got.gradient.iter().flatten().chain(&got.potential).chain(&got.laplacian).all(|&u| u == 0.0));
        let zeros = vec![0.0; n];
        let (got, counts) = Case::new(&kernel, &x, &zeros).fmm(&x, ALL, 1e-6);
        assert!(got.gradient.iter().flatten().all(|&u| u == 0.0) && counts.massless_sources == n as u64);
        assert_eq!(case.fmm(&[], ALL, 1e-6).0.potential.len(), 0);
    }
}

/// Coincident sources are one source with their mass; points that nearly coincide are told apart at any scale.
#[test]
fn equal_points_and_tiny_clusters() {
    let n = 20000;
    let m = masses(n, false);
    let total: f64 = m.iter().sum();
    let equal = vec![[0.25, -3.0]; n];
    let kernel = blob(COMPACT, 0.5);
    let case = Case::new(&kernel, &equal, &m);
    let (got, counts) = case.fmm(&equal, ALL, 1e-9);
    assert!(counts.pairs <= n as u64 && got.gradient.iter().flatten().all(|&g| g == 0.0));
    for (got, want) in [(&got.potential, kernel.potential(0.0)), (&got.laplacian, kernel.density(0.0))] {
        assert!(got.iter().all(|&u| (u / (total * want) - 1.0).abs() < 1e-12), "{} {}", got[0], total * want);
    }
    let bare = blob(Mollifier::None, 0.0);
    let (got, _) = Case::new(&bare, &equal, &m).fmm(&equal, FIELD, 1e-9);
    assert!(got.gradient.iter().flatten().chain(&got.potential).all(|&g| g == 0.0));
    // A tiny delta, so that pairs are summed in closer units, and one by one.
    for delta in [1e-40, 1e-70] {
        let tiny = blob(COMPACT, delta);
        let (got, _) = Case::new(&tiny, &equal[..2000], &m[..2000]).fmm(&equal[..20], ALL, 1e-9);
        let want = tiny.density(0.0) * m[..2000].iter().sum::<f64>();
        assert!(got.laplacian.iter().all(|&u| (u / want - 1.0).abs() < 1e-12), "{delta}: {} {want}", got.laplacian[0]);
    }
    // Clusters within clusters.
    let mut x = points(Points::Uniform, 4000, 8);
    for (k, x) in x.iter_mut().enumerate() {
        let scale = [1.0, 1e-5, 1e-10, 1e-14][k % 4];
        *x = [x[0] * scale, x[1] * scale];
    }
    let case = Case::new(&bare, &x, &m[..4000]);
    let (got, counts) = case.fmm(&x, FIELD, 1e-6);
    let errors = case.errors(&x, &got, FIELD, 0.0);
    assert!(errors[0][0] < 1e-6 && errors[1][0] < 1e-6, "{errors:?}");
    assert!(counts.pairs < 4000 * 1200, "{}", counts.pairs);
}

#[test]
fn the_same_bits_for_any_executor() {
    let n = 9000;
    let (x, m) = (points(Points::Normal, n, 10), masses(n, true));
    let kernel = blob(COMPACT, 0.02);
    let case = Case::new(&kernel, &x, &m);
    let options = Options { tolerance: 1e-6, method: Some(Method::Fmm), ..Options::default() };
    for level in [Level::best(), Level::Portable] {
        let (one, counts) = case.run(&x, ALL, &options, &Serial, level);
        for workers in [2, 3] {
            let (got, others) = case.run(&x, ALL, &options, &Threads(workers), level);
            assert!(got == one && others == counts, "{level:?} {workers}");
        }
        // What else is wanted changes no bit.
        let (alone, _) = case.run(&x, Wanted { gradient: true, ..Wanted::default() }, &options, &Serial, level);
        assert!(alone.gradient == one.gradient);
    }
}

/// Coordinates in any unit: by a power of two the results change by powers of two alone.
#[test]
fn any_unit() {
    let n = 3000;
    let (x, m) = (points(Points::Uniform, n, 11), masses(n, true));
    let sums = |exponent: i32| {
        let scale = 2.0_f64.powi(exponent);
        let x: Vec<[f64; 2]> = x.iter().map(|x| x.map(|x| x * scale)).collect();
        let m: Vec<f64> = m.iter().map(|m| m * scale).collect();
        let kernel = blob(COMPACT, 0.01 * scale);
        Case::new(&kernel, &x, &m).fmm(&x, FIELD, 1e-9).0
    };
    let want = sums(0);
    for exponent in [-990, 480] {
        let got = sums(exponent);
        assert!(got.gradient == want.gradient, "{exponent}");
        assert!(got.potential.iter().all(|u| u.is_finite()));
    }
}

#[test]
fn turned_gradients() {
    let n = 2000;
    let (x, m) = (points(Points::Uniform, n, 12), masses(n, true));
    let kernel = blob(COMPACT, 0.01);
    let case = Case::new(&kernel, &x, &m);
    let options = Options { tolerance: 1e-6, method: Some(Method::Fmm), ..Options::default() };
    let (plain, _) = case.run(&x, ALL, &options, &Serial, Level::best());
    let (turned, _) = case.run(&x, ALL, &Options { combination: (0.0, 1.0), ..options }, &Serial, Level::best());
    assert!(plain.gradient.iter().zip(&turned.gradient).all(|(g, t)| *t == [-g[1], g[0]]));
}

/// Across the faces of boxes, the gradient's error jumps by no more than the tolerance allows; nor does it depart from the difference quotient of the potential.
#[test]
fn smooth_across_boxes() {
    let n = 4000;
    let (x, m) = (points(Points::Uniform, n, 13), masses(n, false));
    // The mollifier keeps the field itself smooth on the scale of the steps.
    let kernel = blob(COMPACT, 0.1);
    let case = Case::new(&kernel, &x, &m);
    let step = 1e-4;
    let line: Vec<[f64; 2]> = (0..8000).map(|k| [0.1 + step * k as f64, 0.413]).collect();
    for tolerance in [1e-4, 1e-8] {
        let (got, _) = case.fmm(&line, FIELD, tolerance);
        let direct = Options { method: Some(Method::Direct), ..Options::default() };
        let (want, _) = case.run(&line, FIELD, &direct, &Serial, Level::best());
        let size = case.sizes(&line[4000], kernel.delta());
        let error = |k: usize, d: usize| got.gradient[k][d] - want.gradient[k][d];
        let jump =
            (1..line.len()).flat_map(|k| [0, 1].map(|d| (error(k, d) - error(k - 1, d)).abs())).fold(0.0, f64::max);
        let quotient = |k: usize| (got.potential[k + 1] - got.potential[k - 1]) / (2.0 * step) - got.gradient[k][0];
        let plain = |k: usize| (want.potential[k + 1] - want.potential[k - 1]) / (2.0 * step) - want.gradient[k][0];
        let mut apart: Vec<f64> = (1..line.len() - 1).map(|k| (quotient(k) - plain(k)).abs()).collect();
        apart.sort_by(f64::total_cmp);
        println!(
            "{tolerance:e}: jump {:.1e}, quotient {:.1e} (median)",
            jump / size[1],
            apart[apart.len() / 2] / size[1]
        );
        assert!(jump < 4.0 * tolerance * size[1], "{jump} {}", size[1]);
        assert!(apart[apart.len() / 2] < 4.0 * tolerance * size[1]);
    }
}

#[test]
fn plans() {
    let kernel = blob::<f64>(COMPACT, 0.01);
    let plan =
        |kernel: &dyn Interaction<f64, 2>, n: usize, options: &Options| field::plan(kernel, n, n, FIELD, options);
    let auto = Options { tolerance: 1e-6, ..Options::default() };
    let forced = Options { method: Some(Method::Fmm), ..Options::default() };
    let negative = Options { tolerance: -1e-6, ..auto };
    assert_eq!(plan(&kernel, 100, &negative).unwrap_err(), mollis_core::Error::OutOfDomain);
    let large = plan(&kernel, 100_000, &auto).unwrap();
    assert_eq!((large.method(), large.reason()), (Method::Fmm, Reason::Tolerance));
    let text = large.to_string();
    assert!(text.contains("fast multipole") && text.contains("terms") && text.contains("leaf"), "{text}");
    assert_eq!(plan(&kernel, 200, &auto).unwrap().method(), Method::Direct);
    assert_eq!(plan(&kernel, 200, &forced).unwrap().method(), Method::Fmm);
    for tolerance in [0.0, 1e-16] {
        let options = Options { tolerance, ..auto };
        assert_eq!(plan(&kernel, 100_000, &options).unwrap().method(), Method::Direct);
    }
    for mollifier in [Mollifier::Plummer, Mollifier::Algebraic, Mollifier::Vatistas] {
        let kernel = blob::<f64>(mollifier, 0.01);
        assert_eq!(plan(&kernel, 100_000, &auto).unwrap().method(), Method::Tree);
        assert_eq!(plan(&kernel, 100_000, &forced).err(), Some(Error::Unsupported));
    }
    let line = Blob::<f64, 1>::new(COMPACT, 0.1).unwrap();
    assert_eq!(field::plan(&line, 9, 9, FIELD, &forced).err(), Some(Error::Unsupported));
    // Few targets are served directly.
    assert_eq!(field::plan(&kernel, 100_000, 10, FIELD, &auto).unwrap().method(), Method::Direct);
    let bytes = |options: &Options| plan(&kernel, 100_000, options).unwrap().workspace_bytes(1).unwrap();
    let most = |tolerance: f64| bytes(&Options { tolerance, ..auto }) / 100_000;
    assert!(most(1e-6) <= 200 && most(1e-12) <= 260, "{} {}", most(1e-6), most(1e-12));
}

#[test]
fn refusals() {
    let kernel = blob::<f64>(COMPACT, 0.01);
    let n = 500;
    let (mut x, m) = (points(Points::Uniform, n, 14), masses(n, true));
    let options = Options { tolerance: 1e-6, method: Some(Method::Fmm), ..Options::default() };
    let plan = field::plan(&kernel, n, n, FIELD, &options).unwrap();
    let bytes = plan.workspace_bytes(1).unwrap();
    let mut memory = Aligned::new(bytes);
    let mut run = |x: &[[f64; 2]], m: &[f64], bytes: usize| {
        let (mut potential, mut gradient) = (vec![7.0; n], vec![[7.0; 2]; n]);
        let outputs =
            Outputs { potential: Some(&mut potential), gradient: Some(&mut gradient), laplacian: None, hessian: None };
        let sources = Sources::new(x, m);
        let result =
            field::evaluate(&plan, &kernel, sources, x, outputs, &mut memory.bytes()[..bytes], &mut Run::default());
        assert!(result.is_ok() || potential.iter().chain(gradient.as_flattened()).all(|&u| u == 7.0));
        result
    };
    assert_eq!(run(&x, &m, bytes), Ok(()));
    assert_eq!(run(&x, &m, bytes - 1), Err(Error::WorkspaceTooSmall));
    let mut bad = m.clone();
    bad[77] = f64::INFINITY;
    assert_eq!(run(&x, &bad, bytes), Err(Error::NotFinite));
    x[30][1] = f64::NAN;
    assert_eq!(run(&x, &m, bytes), Err(Error::NotFinite));
}
