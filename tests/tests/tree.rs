//! Fast sums of smooth kernels by the tree against sums over all pairs, on a sample of the targets.
//!
//! Errors are in the l2 norm over the sample, relative to that of sum_j |m_j| |K_j|, for potentials and gradients.

use mollis_core::exec::{Executor, Run, Serial, Statistics};
use mollis_core::field::{
    self, Accumulation, Interaction, Method, Options, Outputs, PairRadius, Reason, Sources, Wanted,
};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::{Aligned, Split, Threads};

const FIELD: Wanted = Wanted { potential: true, gradient: true, laplacian: false, hessian: false };
const COMPACT: Mollifier = Mollifier::Compact { order: 4, exponent: 4 };

/// Points of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Points {
    Uniform,
    Normal,
    Sphere,
    Line,
    /// Half of them in a cube of side 1e-6.
    TwoScales,
    /// Each point is the middle of the last one and of a corner.
    Fractal,
}

pub(crate) const POINTS: [Points; 6] =
    [Points::Uniform, Points::Normal, Points::Sphere, Points::Line, Points::TwoScales, Points::Fractal];

pub(crate) fn points<T: Real, const D: usize>(kind: Points, n: usize, seed: u64) -> Vec<[T; D]> {
    let mut numbers = Split(seed);
    let mut last = [0.2; D];
    let point = |k: usize| {
        let mut uniform = || numbers.uniform();
        let cube: [f64; D] = std::array::from_fn(|_| uniform());
        let normal: [f64; D] =
            std::array::from_fn(|_| (-2.0 * (1.0 - uniform()).ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos());
        match kind {
            Points::Uniform => cube,
            Points::Normal => normal,
            Points::Sphere => {
                let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
                normal.map(|x| x / length)
            }
            Points::Line => std::array::from_fn(|axis| 0.3 + (1.0 - 0.4 * axis as f64) * cube[0]),
            Points::TwoScales if k.is_multiple_of(2) => cube.map(|x| 0.3 + 1e-6 * x),
            Points::TwoScales => cube,
            Points::Fractal => {
                let corner = (cube[0] * (D + 1) as f64) as usize;
                last = std::array::from_fn(|axis| 0.5 * (last[axis] + if axis + 1 == corner { 1.0 } else { 0.0 }));
                last
            }
        }
    };
    (0..n).map(point).map(|x| x.map(T::from_f64)).collect()
}

pub(crate) fn masses<T: Real>(n: usize, signed: bool) -> Vec<T> {
    let mut numbers = Split(5);
    (0..n).map(|_| T::from_f64(numbers.uniform() - if signed { 0.5 } else { 0.0 })).collect()
}

pub(crate) fn with_kernel<T: Real, const D: usize, R>(
    terms: &[Term],
    (mollifier, delta): (Mollifier, f64),
    run: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> R {
    let mut memory = Aligned::new(Kernel::<T, D>::workspace_bytes(terms, mollifier).unwrap());
    run(&Kernel::prepare(memory.bytes(), terms, mollifier, T::from_f64(delta)).unwrap())
}

pub(crate) fn term(law: Law, coefficient: f64) -> Term {
    Term { law, coefficient }
}

/// Kernels that other methods don't serve, with a length of the order of the points'.
pub(crate) fn kernels() -> [Vec<Term>; 5] {
    let power = |exponent: f64| Law::Power { exponent };
    [
        vec![term(Law::Newtonian, 1.0)],
        vec![term(power(1.5), 1.0)],
        vec![term(power(4.0), 1.0), term(Law::Newtonian, -1.0)],
        vec![term(Law::Exponential { length: 0.1 }, 1.5), term(Law::Exponential { length: 0.3 }, -1.0)],
        vec![term(Law::Screened { k: 5.0 }, 1.0)],
    ]
}

#[derive(Clone, Debug, PartialEq)]
struct Sums<T, const D: usize> {
    potential: Vec<T>,
    gradient: Vec<[T; D]>,
    laplacian: Vec<T>,
}

/// The methods of Newtonian kernels in space.
const SPACE: [Method; 2] = [Method::Tree, Method::Fmm];

/// A sum, by a fast method.
struct Case<'a, T: Real, const D: usize> {
    method: Method,
    kernel: &'a dyn Interaction<T, D>,
    positions: &'a [[T; D]],
    masses: &'a [T],
}

const CANARY: u8 = 0xA5;

impl<T: Real, const D: usize> Case<'_, T, D> {
    /// In a workspace of just the bytes that the plan asks for, of arbitrary content, between canaries.
    fn run(
        &self,
        targets: &[[T; D]],
        wanted: Wanted,
        options: &Options,
        executor: &dyn Executor,
        level: Level,
    ) -> (Sums<T, D>, Statistics) {
        let n = targets.len();
        let plan = field::plan(self.kernel, self.positions.len(), n, wanted, options).unwrap();
        let bytes = plan.workspace_bytes(executor.workers()).unwrap();
        let mut memory = Aligned::new(bytes + 64);
        memory.bytes().fill(CANARY);
        let mut sums = Sums { potential: vec![T::NAN; n], gradient: vec![[T::NAN; D]; n], laplacian: vec![T::NAN; n] };
        let mut counters = Statistics::default();
        let outputs = Outputs {
            potential: wanted.potential.then_some(&mut sums.potential[..]),
            gradient: wanted.gradient.then_some(&mut sums.gradient[..]),
            laplacian: wanted.laplacian.then_some(&mut sums.laplacian[..]),
            hessian: None,
        };
        let sources = Sources::new(self.positions, self.masses);
        let mut run = Run { executor, level, counters: Some(&mut counters), ..Run::default() };
        field::evaluate(&plan, self.kernel, sources, targets, outputs, &mut memory.bytes()[..bytes], &mut run).unwrap();
        assert!(memory.bytes()[bytes..].iter().all(|&byte| byte == CANARY));
        (sums, counters)
    }

    fn fast(&self, targets: &[[T; D]], tolerance: f64) -> (Sums<T, D>, Statistics) {
        let options = Options { tolerance, method: Some(self.method), ..Options::default() };
        self.run(targets, FIELD, &options, &Serial, Level::best())
    }

    fn direct(&self, targets: &[[T; D]], wanted: Wanted) -> Sums<T, D> {
        let accumulation = Accumulation::Compensated;
        let options = Options { method: Some(Method::Direct), accumulation, ..Options::default() };
        self.run(targets, wanted, &options, &Serial, Level::best()).0
    }

    /// Errors of potential and gradient on a sample of the targets, relative to sum_j |m_j| |K_j|.
    fn errors(&self, targets: &[[T; D]], got: &Sums<T, D>, n: usize) -> [f64; 2] {
        let each = (targets.len() / n).max(1);
        let sample: Vec<[T; D]> = targets.iter().step_by(each).copied().collect();
        let want = self.direct(&sample, FIELD);
        let mut squares = [[0.0_f64; 2]; 2];
        for (k, x) in sample.iter().enumerate() {
            let mut sizes = [0.0_f64; 2];
            for (y, m) in self.positions.iter().zip(self.masses) {
                let r = x.iter().zip(y).map(|(&x, &y)| (x - y).to_f64().powi(2)).sum::<f64>().sqrt();
                if r > 0.0 || !self.kernel.is_singular() {
                    let [value, factor, _] = self.kernel.pair(T::from_f64(r), FIELD);
                    sizes[0] += (*m * value).abs().to_f64();
                    sizes[1] += (*m * factor).abs().to_f64() * r;
                }
            }
            squares[0][0] += (got.potential[k * each] - want.potential[k]).to_f64().powi(2);
            for (got, want) in got.gradient[k * each].iter().zip(&want.gradient[k]) {
                squares[1][0] += (*got - *want).to_f64().powi(2);
            }
            squares.iter_mut().zip(sizes).for_each(|(squares, size)| squares[1] += size * size);
        }
        squares.map(|[error, size]| if error == 0.0 { 0.0 } else { (error / size).sqrt() })
    }
}

/// That the sum keeps its tolerances; the pairs of a target.
fn check<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    (kind, n): (Points, usize),
    tolerances: &[f64],
    what: &str,
) {
    let x = points::<T, D>(kind, n, 1);
    let fmm = Options { method: Some(Method::Fmm), ..Options::default() };
    let has_fmm = D == 3 && field::plan(kernel, n, n, FIELD, &fmm).is_ok();
    let methods = if has_fmm { &SPACE[..] } else { &[Method::Tree] };
    for (signed, &method) in [false, true].into_iter().flat_map(|signed| methods.iter().map(move |of| (signed, of))) {
        let m = masses::<T>(n, signed);
        let case = Case { method, kernel, positions: &x, masses: &m };
        for &tolerance in tolerances {
            let (got, counts) = case.fast(&x, tolerance);
            let errors = case.errors(&x, &got, 20);
            let pairs = counts.pairs as f64 / n as f64;
            println!("{D}D {method:?} {what} {kind:?} {signed} {tolerance:e}: {errors:?}, {pairs} pairs");
            assert!(
                errors.iter().all(|&e| e <= tolerance),
                "{D}D {method:?} {what} {kind:?} {signed} {tolerance:e}: {errors:?}"
            );
        }
    }
}

#[test]
fn every_kernel_in_every_dimension() {
    for (number, terms) in kernels().iter().enumerate() {
        let what = number.to_string();
        with_kernel::<f64, 1, _>(terms, (COMPACT, 0.02), |k| check(k, (Points::Uniform, 600), &[1e-3, 1e-12], &what));
        with_kernel::<f64, 2, _>(terms, (COMPACT, 0.02), |k| check(k, (Points::Uniform, 1200), &[1e-3, 1e-8], &what));
        with_kernel::<f64, 3, _>(terms, (COMPACT, 0.1), |k| check(k, (Points::Uniform, 800), &[1e-2], &what));
    }
    // A support as large as everything; and without a mollifier, where each pair of a power is a function call.
    let newtonian = &kernels()[0];
    with_kernel::<f64, 3, _>(newtonian, (COMPACT, 2.0), |k| check(k, (Points::Uniform, 500), &[1e-3], "all near"));
    with_kernel::<f64, 3, _>(newtonian, (Mollifier::None, 0.0), |k| check(k, (Points::Uniform, 1200), &[1e-4], "bare"));
    let power = &kernels()[1];
    with_kernel::<f64, 1, _>(power, (Mollifier::None, 0.0), |k| check(k, (Points::Uniform, 600), &[1e-6], "bare"));
}

#[test]
fn every_kind_of_points() {
    for kind in POINTS {
        let newtonian = Blob::<f64, 3>::new(COMPACT, 0.05).unwrap();
        check(&newtonian, (kind, 2000), &[1e-3], "Newtonian");
        let newtonian = Blob::<f32, 3>::new(COMPACT, 0.05).unwrap();
        check(&newtonian, (kind, 1000), &[1e-3], "Newtonian, f32");
        with_kernel::<f64, 2, _>(&kernels()[3], (COMPACT, 0.01), |k| check(k, (kind, 1500), &[1e-4, 1e-9], "Morse"));
    }
}

/// Mollifiers without an end, and Gaussians.
#[test]
fn every_mollifier() {
    let newtonian = &kernels()[0];
    for mollifier in [Mollifier::Plummer, Mollifier::Algebraic, Mollifier::Gaussian { order: 4 }] {
        for delta in [0.05, 2.0] {
            let (shape, what) = ((mollifier, delta), format!("{mollifier:?} {delta}"));
            with_kernel::<f64, 3, _>(newtonian, shape, |k| check(k, (Points::Uniform, 800), &[1e-3], &what));
            with_kernel::<f64, 2, _>(newtonian, shape, |k| check(k, (Points::Normal, 1000), &[1e-7], &what));
        }
    }
}

/// Half of the targets within 1e-7, and half of these in one place; then one mass above all others.
#[test]
fn crowds_of_targets_keep_the_tolerance() {
    for dominates in [false, true] {
        let mut worst = [0.0_f64; 2];
        for seed in 0..3 {
            let mut x = points::<f64, 2>(Points::Uniform, 600, seed);
            for k in (0..600).step_by(4) {
                x[k] = x[k].map(|c| 0.4 + 1e-7 * c);
                x[k + 1] = x[k];
            }
            let mut numbers = Split(seed);
            let mass = |u: f64| if dominates { 10_f64.powf(60.0 * u - 30.0) } else { u };
            let m: Vec<f64> = (0..600).map(|_| mass(numbers.uniform())).collect();
            for terms in [&kernels()[1], &kernels()[3]] {
                with_kernel::<f64, 2, _>(terms, (COMPACT, 0.01), |kernel| {
                    let case = Case { method: Method::Tree, kernel, positions: &x, masses: &m };
                    for tolerance in [1e-3, 1e-6, 1e-10] {
                        let (got, _) = case.fast(&x, tolerance);
                        let errors = case.errors(&x, &got, 600);
                        println!("{seed} {dominates} {tolerance:e}: {:?}", errors.map(|e| e / tolerance));
                        worst.iter_mut().zip(errors).for_each(|(worst, e)| *worst = worst.max(e / tolerance));
                    }
                });
            }
        }
        assert!(worst.iter().all(|&share| share <= 1.0), "{dominates}: {worst:?} times the tolerance");
    }
}

/// A kernel with an edge in the middle of the points: where it cannot be interpolated, pairs are summed one by one.
#[test]
fn an_edge_is_met_pair_by_pair() {
    struct Edge;
    impl Interaction<f64, 2> for Edge {
        fn value(&self, r: f64) -> f64 {
            (0.3 - r).max(0.0)
        }
        fn gradient_factor(&self, r: f64) -> f64 {
            if r < 0.3 && r > 0.0 { -1.0 / r } else { 0.0 }
        }
        fn laplacian(&self, r: f64) -> f64 {
            self.gradient_factor(r)
        }
        fn is_singular(&self) -> bool {
            false
        }
    }
    let n = 1500;
    let (x, m) = (points::<f64, 2>(Points::Uniform, n, 1), masses(n, true));
    let case = Case { method: Method::Tree, kernel: &Edge, positions: &x, masses: &m };
    let (got, counts) = case.fast(&x, 1e-6);
    let errors = case.errors(&x, &got, 50);
    assert!(errors.iter().all(|&e| e <= 1e-6), "{errors:?}");
    // Beyond the edge nothing is summed.
    assert!(counts.pairs < (3 * n * n / 4) as u64, "{}", counts.pairs);
}

#[test]
fn targets_need_not_be_sources() {
    let (n, n_targets) = (1500, 400);
    let (x, m, y) = (points(Points::Sphere, n, 4), masses(n, true), points(Points::Uniform, n_targets, 5));
    let kernel = Blob::<f64, 3>::new(COMPACT, 0.05).unwrap();
    let all = [&y[..], &y[..1], &[[1e3, -1e3, 5.0]], &x[..500]];
    for (method, targets) in SPACE.into_iter().flat_map(|method| all.map(|targets| (method, targets))) {
        let case = Case { method, kernel: &kernel, positions: &x, masses: &m };
        let (got, _) = case.fast(targets, 1e-4);
        let errors = case.errors(targets, &got, 50);
        assert!(errors.iter().all(|&e| e <= 1e-4), "{errors:?}");
    }
    // The Laplacian of a Newtonian kernel comes from near pairs alone.
    for method in SPACE {
        let case = Case { method, kernel: &kernel, positions: &x, masses: &m };
        let options = Options { tolerance: 1e-3, method: Some(method), ..Options::default() };
        let wanted = Wanted { laplacian: true, ..FIELD };
        let (got, _) = case.run(&x[..300], wanted, &options, &Serial, Level::best());
        let want = case.direct(&x[..300], wanted);
        let largest = want.laplacian.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        assert!(got.laplacian.iter().zip(&want.laplacian).all(|(a, b)| (a - b).abs() < 1e-13 * largest));
    }
}

#[test]
fn all_sizes() {
    fn of<const D: usize>(method: Method) {
        let terms = if method == Method::Fmm { &kernels()[0] } else { &kernels()[3] };
        with_kernel::<f64, D, _>(terms, (COMPACT, 0.05), |kernel| {
            for n in [0, 1, 2, 3, 23, 24, 25, 63, 64, 65, 129, 1024, 1025] {
                let (x, m) = (points::<f64, D>(Points::Uniform, n, 6), masses::<f64>(n, true));
                let case = Case { method, kernel, positions: &x, masses: &m };
                let (got, counts) = case.fast(&x, 1e-5);
                let errors = case.errors(&x, &got, 50);
                assert!(errors.iter().all(|&e| e <= 1e-5), "{n}: {errors:?}");
                assert!(counts.pairs <= (n * n) as u64);
                // No source, or none with mass; no target.
                let none = Case { method, kernel, positions: &[], masses: &[] };
                let (got, _) = none.fast(&x, 1e-5);
                assert!(got.gradient.iter().flatten().chain(&got.potential).all(|&u| u == 0.0));
                let zeros = vec![0.0; n];
                let (got, counts) = Case { method, kernel, positions: &x, masses: &zeros }.fast(&x, 1e-5);
                assert!(got.gradient.iter().flatten().all(|&u| u == 0.0) && counts.massless_sources == n as u64);
                assert_eq!(case.fast(&[], 1e-5).0.potential.len(), 0);
            }
        });
    }
    of::<1>(Method::Tree);
    of::<2>(Method::Tree);
    of::<3>(Method::Tree);
    of::<3>(Method::Fmm);
}

/// Coincident sources are one source with their mass; clusters are resolved at any scale.
#[test]
fn equal_points_and_tiny_clusters() {
    let n = 5000;
    let m = masses::<f64>(n, false);
    let total: f64 = m.iter().sum();
    let equal = vec![[0.25, -3.0, 1.0]; n];
    let kernel = Blob::<f64, 3>::new(COMPACT, 0.5).unwrap();
    let bare = Blob::<f64, 3>::new(Mollifier::None, 0.0).unwrap();
    for method in SPACE {
        let (got, counts) = Case { method, kernel: &kernel, positions: &equal, masses: &m }.fast(&equal, 1e-6);
        assert!(counts.pairs <= n as u64 && got.gradient.iter().flatten().all(|&g| g == 0.0));
        let want = total * kernel.potential(0.0);
        assert!(got.potential.iter().all(|&u| (u / want - 1.0).abs() < 1e-12), "{} {want}", got.potential[0]);
        let (got, _) = Case { method, kernel: &bare, positions: &equal, masses: &m }.fast(&equal, 1e-6);
        assert!(got.gradient.iter().flatten().chain(&got.potential).all(|&g| g == 0.0));
    }
    // Clusters within clusters, about a point that no cell has in its centre, and about the origin.
    for centre in [0.0, 0.31] {
        let mut x = points::<f64, 2>(Points::Uniform, 3000, 8);
        for (k, x) in x.iter_mut().enumerate() {
            let scale = [1.0, 1e-3, 1e-7][k % 3];
            *x = x.map(|x| centre + x * scale);
        }
        with_kernel::<f64, 2, _>(&kernels()[4], (COMPACT, 1e-9), |kernel| {
            let case = Case { method: Method::Tree, kernel, positions: &x, masses: &m[..3000] };
            let (got, counts) = case.fast(&x, 1e-6);
            let errors = case.errors(&x, &got, 30);
            assert!(errors.iter().all(|&e| e <= 1e-6), "{errors:?}");
            assert!(counts.pairs < 3000 * 1500, "{}", counts.pairs);
        });
    }
}

/// The same in space, and where half of the points are in the corner of cells of all sizes, or crowded with a mass above all others.
#[test]
fn clusters_in_space() {
    let (n, mut worst) = (3000, 0.0_f64);
    let kernel = Blob::<f64, 3>::new(COMPACT, 1e-9).unwrap();
    for centre in [0.0, 0.31, 0.5, 0.25] {
        for levels in [[1.0, 1e-3, 1e-7], [1.0, 1e-4, 1e-4]] {
            let mut x = points::<f64, 3>(Points::Uniform, n, 8);
            let mut m = masses::<f64>(n, false);
            for (k, x) in x.iter_mut().enumerate() {
                *x = x.map(|x| centre + x * levels[k % 3]);
            }
            m[1] *= 1e6;
            let cases = SPACE.into_iter().flat_map(|method| [1e-3, 1e-6].map(|tolerance| (method, tolerance)));
            for (method, tolerance) in cases.chain([(Method::Fmm, 1e-10)]) {
                let case = Case { method, kernel: &kernel, positions: &x, masses: &m };
                let (got, counts) = case.fast(&x, tolerance);
                // Of each kind.
                let errors = case.errors(&x, &got, 93).map(|e| e / tolerance);
                println!("{method:?} {centre} {levels:?} {tolerance:e}: {errors:?} times, {} pairs", counts.pairs);
                worst = errors.iter().fold(worst, |worst, &e| worst.max(e));
            }
        }
    }
    assert!(worst <= 1.0, "{worst} times the tolerance");
}

#[test]
fn the_same_bits_for_any_executor() {
    let n = 1500;
    let (x, m) = (points(Points::Normal, n, 10), masses(n, true));
    let kernel = Blob::<f64, 3>::new(COMPACT, 0.1).unwrap();
    for (method, level) in SPACE.into_iter().flat_map(|of| [Level::best(), Level::Portable].map(|level| (of, level))) {
        let case = Case { method, kernel: &kernel, positions: &x, masses: &m };
        let options = Options { tolerance: 1e-3, method: Some(method), ..Options::default() };
        let (one, counts) = case.run(&x, FIELD, &options, &Serial, level);
        for workers in [2, 3] {
            let (got, others) = case.run(&x, FIELD, &options, &Threads(workers), level);
            assert!(got.potential == one.potential && got.gradient == one.gradient, "{level:?} {workers}");
            assert_eq!(others, counts);
        }
        // What else is wanted changes no bit.
        let (alone, _) = case.run(&x, Wanted { gradient: true, ..Wanted::default() }, &options, &Serial, level);
        assert!(alone.gradient == one.gradient);
    }
}

/// Coordinates in any unit: by a power of two the results change by powers of two alone.
#[test]
fn any_unit() {
    let n = 1500;
    let (x, m) = (points::<f64, 3>(Points::Uniform, n, 11), masses::<f64>(n, true));
    let sums = |method: Method, exponent: i32| {
        let scale = 2.0_f64.powi(exponent);
        let x: Vec<[f64; 3]> = x.iter().map(|x| x.map(|x| x * scale)).collect();
        let m: Vec<f64> = m.iter().map(|m| m * scale * scale).collect();
        let kernel = Blob::<f64, 3>::new(COMPACT, 0.05 * scale).unwrap();
        Case { method, kernel: &kernel, positions: &x, masses: &m }.fast(&x, 1e-4).0
    };
    for (method, exponent) in SPACE.into_iter().flat_map(|method| [-400, 400].map(|exponent| (method, exponent))) {
        let (want, got) = (sums(method, 0), sums(method, exponent));
        assert!(got.gradient == want.gradient, "{exponent}");
        assert!(got.potential.iter().all(|u| u.is_finite()));
    }
}

#[test]
fn turned_gradients() {
    let n = 1000;
    let (x, m) = (points(Points::Uniform, n, 12), masses(n, true));
    with_kernel::<f64, 2, _>(&kernels()[3], (COMPACT, 0.02), |kernel| {
        let case = Case { method: Method::Tree, kernel, positions: &x, masses: &m };
        let options = Options { tolerance: 1e-6, method: Some(Method::Tree), ..Options::default() };
        let (plain, _) = case.run(&x, FIELD, &options, &Serial, Level::best());
        let (turned, _) = case.run(&x, FIELD, &Options { combination: (0.0, 1.0), ..options }, &Serial, Level::best());
        assert!(plain.gradient.iter().zip(&turned.gradient).all(|(g, t)| *t == [-g[1], g[0]]));
    });
}

/// Across the faces of cells the gradient's error jumps by no more than the tolerance allows.
#[test]
fn smooth_across_cells() {
    let n = 2500;
    let (x, m) = (points::<f64, 2>(Points::Uniform, n, 13), masses::<f64>(n, false));
    with_kernel::<f64, 2, _>(&kernels()[3], (COMPACT, 0.1), |kernel| {
        let case = Case { method: Method::Tree, kernel, positions: &x, masses: &m };
        let line: Vec<[f64; 2]> = (0..4000).map(|k| [0.1 + 2e-4 * f64::from(k), 0.413]).collect();
        let size: f64 = line[..100]
            .iter()
            .flat_map(|at| x.iter().zip(&m).map(move |(y, m)| (at, y, m)))
            .map(|(at, y, m)| {
                let r = (at[0] - y[0]).hypot(at[1] - y[1]);
                m * kernel.pair(r, [false, true, false])[1].abs() * r
            })
            .sum::<f64>()
            / 100.0;
        let want = case.direct(&line, FIELD);
        for tolerance in [1e-3, 1e-7] {
            let (got, _) = case.fast(&line, tolerance);
            let error = |k: usize, d: usize| got.gradient[k][d] - want.gradient[k][d];
            let jump =
                (1..line.len()).flat_map(|k| [0, 1].map(|d| (error(k, d) - error(k - 1, d)).abs())).fold(0.0, f64::max);
            println!("{tolerance:e}: jump {:.1e}", jump / size);
            assert!(jump < 4.0 * tolerance * size, "{jump} {size}");
        }
    });
}

#[test]
fn plans() {
    let auto = Options { tolerance: 1e-6, ..Options::default() };
    let forced = Options { method: Some(Method::Tree), ..Options::default() };
    fn plan<T: Real, const D: usize>(
        kernel: &dyn Interaction<T, D>,
        n: usize,
        wanted: Wanted,
        options: &Options,
    ) -> Result<field::Plan, Error> {
        field::plan(kernel, n, n, wanted, options)
    }
    let space = Blob::<f64, 3>::new(COMPACT, 0.01).unwrap();
    let large = plan(&space, 200_000, FIELD, &auto).unwrap();
    assert_eq!((large.method(), large.reason()), (Method::Fmm, Reason::Tolerance));
    let text = large.to_string();
    assert!(text.contains("multipole") && text.contains("terms") && text.contains("leaf"), "{text}");
    assert_eq!(plan(&space, 500, FIELD, &auto).unwrap().method(), Method::Direct);
    assert_eq!(plan(&space, 500, FIELD, &forced).unwrap().method(), Method::Tree);
    for tolerance in [0.0, 1e-16] {
        let options = Options { tolerance, ..auto };
        assert_eq!(plan(&space, 200_000, FIELD, &options).unwrap().method(), Method::Direct);
    }
    // Newtonian kernels have a faster method, but for algebraic mollifiers.
    let plane = Blob::<f64, 2>::new(COMPACT, 0.01).unwrap();
    assert_eq!(plan(&plane, 100_000, FIELD, &auto).unwrap().method(), Method::Fmm);
    let plummer = Blob::<f64, 2>::new(Mollifier::Plummer, 0.01).unwrap();
    assert_eq!(plan(&plummer, 100_000, FIELD, &auto).unwrap().method(), Method::Tree);
    // Second derivatives, and Laplacians but for those that are zero afar.
    let hessian = Wanted { hessian: true, ..FIELD };
    let laplacian = Wanted { laplacian: true, ..FIELD };
    assert_eq!(plan(&space, 200_000, hessian, &forced).err(), Some(Error::Unsupported));
    assert_eq!(plan(&space, 200_000, laplacian, &forced).unwrap().method(), Method::Tree);
    assert_eq!(plan(&plummer, 100_000, laplacian, &auto).unwrap().method(), Method::Direct);
    with_kernel::<f64, 2, _>(&kernels()[3], (COMPACT, 0.02), |kernel| {
        assert_eq!(plan(kernel, 100_000, FIELD, &auto).unwrap().method(), Method::Tree);
        assert_eq!(plan(kernel, 100_000, laplacian, &auto).unwrap().method(), Method::Direct);
        let bytes = plan(kernel, 100_000, FIELD, &auto).unwrap().workspace_bytes(1).unwrap() / 100_000;
        assert!(bytes <= 480, "{bytes}");
    });
    // Core radii where cores end, of sources alone; vector strengths.
    let radii = Options { radii: true, ..forced };
    assert_eq!(plan(&space, 500, FIELD, &radii).unwrap().method(), Method::Tree);
    assert_eq!(plan(&plummer, 500, FIELD, &radii).err(), Some(Error::Unsupported));
    let pairs = Options { pair_radius: PairRadius::Maximum, ..radii };
    assert_eq!(plan(&space, 500, FIELD, &pairs).err(), Some(Error::Unsupported));
    let velocity = Wanted { potential: false, ..FIELD };
    let vortices = Options { strengths: true, radii: true, ..auto };
    assert_eq!(plan(&space, 200_000, velocity, &vortices).unwrap().method(), Method::Fmm);
    assert_eq!(plan(&space, 500, velocity, &vortices).unwrap().method(), Method::Direct);
}

/// Sums over sources with core radii, vector strengths or both, on a sample of the sources: the error of the gradient relative to sum_j |s_j| |grad K_j|.
fn error_of_vortices<T: Real>(
    kernel: &Blob<T, 3>,
    (kind, n): (Points, usize),
    (vectors, with_radii): (bool, bool),
    (method, tolerance): (Method, f64),
    workers: usize,
) -> f64 {
    let x = points::<T, 3>(kind, n, 21);
    let flat = masses::<T>(3 * n, true);
    let strengths: Vec<[T; 3]> = flat.as_chunks().0.to_vec();
    let radii: Vec<T> = (0..n).map(|k| T::from_f64(0.01 + 0.02 * (k as f64 * 0.7).sin().abs())).collect();
    let sources = if vectors { Sources::vortices(&x, &strengths) } else { Sources::new(&x, &flat[..n]) };
    let sources = if with_radii { sources.with_radii(&radii) } else { sources };
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    let sum = |targets: &[[T; 3]], method: Method| {
        let of_sources = Options { radii: with_radii, strengths: vectors, ..Options::default() };
        let options = Options { tolerance, method: Some(method), ..of_sources };
        let plan = field::plan(kernel, n, targets.len(), wanted, &options).unwrap();
        let bytes = plan.workspace_bytes(workers).unwrap();
        let mut memory = Aligned::new(bytes + 64);
        let mut gradient = vec![[T::NAN; 3]; targets.len()];
        let outputs = Outputs { gradient: Some(&mut gradient), ..Outputs::default() };
        let mut run = Run { executor: &Threads(workers), level: Level::best(), ..Run::default() };
        field::evaluate(&plan, kernel, sources, targets, outputs, &mut memory.bytes()[..bytes], &mut run).unwrap();
        assert!(memory.bytes()[bytes..].iter().all(|&byte| byte == CANARY));
        gradient
    };
    let got = sum(&x, method);
    let sample: Vec<usize> = (0..n).step_by(n.div_ceil(20)).collect();
    let want = sum(&sample.iter().map(|&k| x[k]).collect::<Vec<_>>(), Method::Direct);
    let (mut error, mut size) = (0.0, 0.0);
    for (&k, want) in sample.iter().zip(&want) {
        error += got[k].iter().zip(want).map(|(&a, &b)| (a - b).to_f64().powi(2)).sum::<f64>();
        let mut all = 0.0;
        for (j, y) in x.iter().enumerate() {
            let r = x[k].iter().zip(y).map(|(&a, &b)| (a - b).to_f64().powi(2)).sum::<f64>().sqrt();
            let own = if vectors { strengths[j].map(|s| s.to_f64()).to_vec() } else { vec![flat[j].to_f64()] };
            let strength = own.iter().map(|s| s * s).sum::<f64>().sqrt();
            all += strength * kernel.gradient_factor(T::from_f64(r)).to_f64().abs() * r;
        }
        size += all * all;
    }
    (error / size).sqrt()
}

#[test]
fn vector_strengths_and_core_radii() {
    let compact = Blob::<f64, 3>::new(COMPACT, 0.02).unwrap();
    let gaussian = Blob::<f64, 3>::new(Mollifier::Gaussian { order: 2 }, 0.01).unwrap();
    let plummer = Blob::<f64, 3>::new(Mollifier::Plummer, 0.02).unwrap();
    for kind in [Points::Uniform, Points::Sphere, Points::TwoScales] {
        for tolerance in [1e-3, 1e-6] {
            for (vectors, radii) in [(true, false), (true, true), (false, true)] {
                for method in SPACE {
                    let how = (method, tolerance);
                    let error = error_of_vortices(&compact, (kind, 1200), (vectors, radii), how, 1);
                    assert!(error <= tolerance, "{method:?} {kind:?} {vectors} {radii} {tolerance:e}: {error:e}");
                }
            }
        }
    }
    let (tree, fmm) = (Method::Tree, Method::Fmm);
    for (kernel, radii, method) in
        [(&gaussian, true, tree), (&gaussian, true, fmm), (&gaussian, false, fmm), (&plummer, false, tree)]
    {
        let error = error_of_vortices(kernel, (Points::Normal, 1000), (true, radii), (method, 1e-4), 3);
        assert!(error <= 1e-4, "{kernel:?} {radii}: {error:e}");
    }
    let single = Blob::<f32, 3>::new(COMPACT, 0.02).unwrap();
    let error = error_of_vortices(&single, (Points::Uniform, 1000), (true, true), (Method::Fmm, 1e-3), 1);
    assert!(error <= 1e-3, "{error:e}");
}

/// Sources in one place are added up, component by component, unless they have core radii of their own.
#[test]
fn coincident_vortices() {
    let kernel = Blob::<f64, 3>::new(COMPACT, 0.02).unwrap();
    let n = 600;
    let (x, s) = (vec![[0.3, 0.4, 0.5]; n], vec![[0.5, -0.25, 1.0]; n]);
    let radii = vec![0.01; n];
    let targets = [[1.0, 2.0, 0.0], [0.31, 0.4, 0.5], [0.3, 0.4, 0.5]];
    let sum = |with_radii: bool, method: Method| {
        let sources = Sources::vortices(&x, &s);
        let sources = if with_radii { sources.with_radii(&radii) } else { sources };
        let of_sources = Options { radii: with_radii, strengths: true, ..Options::default() };
        let options = Options { tolerance: 1e-9, method: Some(method), ..of_sources };
        let wanted = Wanted { gradient: true, ..Wanted::default() };
        let plan = field::plan(&kernel, n, 3, wanted, &options).unwrap();
        let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
        let mut gradient = [[f64::NAN; 3]; 3];
        let outputs = Outputs { gradient: Some(&mut gradient), ..Outputs::default() };
        field::evaluate(&plan, &kernel, sources, &targets, outputs, memory.bytes(), &mut Run::default()).unwrap();
        gradient
    };
    for with_radii in [false, true] {
        let want = sum(with_radii, Method::Direct);
        let fast = SPACE.map(|method| sum(with_radii, method));
        for (got, want) in fast.iter().flat_map(|got| got.as_flattened().iter().zip(want.as_flattened())) {
            assert!((got - want).abs() <= 1e-8 * want.abs().max(1.0), "{with_radii}: {got} {want}");
        }
    }
}

#[test]
fn refusals() {
    let kernel = Blob::<f64, 3>::new(COMPACT, 0.05).unwrap();
    let n = 500;
    let (mut x, m) = (points::<f64, 3>(Points::Uniform, n, 14), masses::<f64>(n, true));
    let options = Options { tolerance: 1e-3, method: Some(Method::Tree), ..Options::default() };
    let plan = field::plan(&kernel, n, n, FIELD, &options).unwrap();
    let bytes = plan.workspace_bytes(1).unwrap();
    let mut memory = Aligned::new(bytes);
    let mut run = |x: &[[f64; 3]], m: &[f64], bytes: usize| {
        let (mut potential, mut gradient) = (vec![7.0; n], vec![[7.0; 3]; n]);
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
