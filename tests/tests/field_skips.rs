//! Moments, sorted sums and neighbour sums against all pairs, by values and by statistics.

use mollis_core::Error;
use mollis_core::exec::{Executor, Run, Serial, Statistics};
use mollis_core::field::{Method, Options, Outputs, Reason, Sources, Wanted, evaluate, plan};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;

const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
const COMPACT: Mollifier = Mollifier::Compact { order: 4, exponent: 4 };

/// Numbers in [0, 1), the same sequence every time (splitmix).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn cloud<const D: usize>(n: usize, seed: u64, at: f64, signed: bool) -> (Vec<[f64; D]>, Vec<f64>) {
    let mut numbers = Numbers(seed);
    let positions = (0..n).map(|_| [(); D].map(|()| at + 2.0 * numbers.next() - 1.0)).collect();
    let masses = (0..n).map(|_| numbers.next() - if signed { 0.5 } else { 0.0 }).collect();
    (positions, masses)
}

fn power(p: f64, coefficient: f64) -> Term {
    Term { law: Law::Power { exponent: p }, coefficient }
}

const NEWTONIAN: Term = Term { law: Law::Newtonian, coefficient: -1.0 };

struct Threads;

impl Executor for Threads {
    fn workers(&self) -> usize {
        3
    }
    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> mollis_core::Result<()> {
        std::thread::scope(|scope| {
            for worker in 0..3 {
                scope.spawn(move || (worker..tasks).step_by(3).for_each(|_| task(worker)));
            }
        });
        Ok(())
    }
}

#[derive(Debug, PartialEq)]
struct Sums<const D: usize> {
    potential: Vec<f64>,
    gradient: Vec<[f64; D]>,
    laplacian: Vec<f64>,
}

struct Case<'a, const D: usize> {
    terms: &'a [Term],
    mollifier: Mollifier,
    delta: f64,
    sources: (&'a [[f64; D]], &'a [f64]),
    targets: &'a [[f64; D]],
}

impl<const D: usize> Case<'_, D> {
    /// Uses a workspace of exactly the stated size with arbitrary contents, between canaries.
    fn run(&self, wanted: Wanted, options: &Options, executor: &dyn Executor) -> (Method, Reason, Sums<D>, Statistics) {
        let bytes = Kernel::<f64, D>::workspace_bytes(self.terms, self.mollifier).unwrap();
        let mut block = vec![0xA5_u8; bytes + 64];
        let at = block.as_ptr().align_offset(64);
        let memory = &mut block[at..at + bytes];
        let kernel = Kernel::<f64, D>::prepare(memory, self.terms, self.mollifier, self.delta).unwrap();
        let (positions, masses) = self.sources;
        let n = self.targets.len();
        let plan = plan(&kernel, positions.len(), n, wanted, options).unwrap();
        let mut sums = Sums { potential: vec![7.0; n], gradient: vec![[7.0; D]; n], laplacian: vec![7.0; n] };
        let bytes = plan.workspace_bytes(executor.workers()).unwrap();
        let mut workspace = vec![0x5A_u8; bytes + 192];
        let start = workspace.as_ptr().align_offset(64) + 64;
        let mut counters = Statistics::default();
        for short in [1, 0] {
            let Some(bytes) = bytes.checked_sub(short) else { continue };
            let mut run = Run { executor, counters: Some(&mut counters), ..Run::default() };
            let outputs = Outputs {
                potential: wanted.potential.then_some(&mut sums.potential[..]),
                gradient: wanted.gradient.then_some(&mut sums.gradient[..]),
                laplacian: wanted.laplacian.then_some(&mut sums.laplacian[..]),
                hessian: None,
            };
            let sources = Sources::new(positions, masses);
            let memory = &mut workspace[start..start + bytes];
            let result = evaluate(&plan, &kernel, sources, self.targets, outputs, memory, &mut run);
            assert_eq!(result, if short == 1 { Err(Error::WorkspaceTooSmall) } else { Ok(()) });
            assert!(short == 0 || sums.potential.iter().all(|&u| u == 7.0));
        }
        assert!(workspace[..start].iter().chain(&workspace[start + bytes..]).all(|&b| b == 0x5A));
        (plan.method(), plan.reason(), sums, counters)
    }

    /// sum |m| |K|, sum |m| |K'|, sum |m| |Laplacian| at each target: errors are measured against these. Under a mollifier the scale of the
    /// kernel, and that of K' / r, is at least that at distance zero and at delta: errors of tables and polynomials are relative to these values.
    fn sizes(&self) -> Vec<[f64; 3]> {
        let bytes = Kernel::<f64, D>::workspace_bytes(self.terms, self.mollifier).unwrap();
        let mut block = vec![0xA5_u8; bytes + 64];
        let at = block.as_ptr().align_offset(64);
        let memory = &mut block[at..at + bytes];
        let kernel = Kernel::<f64, D>::prepare(memory, self.terms, self.mollifier, self.delta).unwrap();
        let mollified = self.mollifier != Mollifier::None;
        let least = |values: [f64; 2]| if mollified { values[0].abs().max(values[1].abs()) } else { 0.0 };
        let least_potential = least([kernel.value(0.0), kernel.value(self.delta)]);
        let least_factor = least([kernel.gradient_factor(0.0), kernel.gradient_factor(self.delta)]);
        let least_laplacian = least([kernel.laplacian(0.0), kernel.laplacian(self.delta)]);
        let size = |x: &[f64; D]| {
            let mut sum = [0.0; 3];
            for (y, m) in self.sources.0.iter().zip(self.sources.1) {
                let r = x.iter().zip(y).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                let [u, g, l] = kernel.pair(r, [true; 3]);
                let (u, g, l) = (u.abs().max(least_potential), g.abs().max(least_factor), l.abs().max(least_laplacian));
                sum = [sum[0] + (m * u).abs(), sum[1] + (m * g * r).abs(), sum[2] + (m * l).abs()];
            }
            sum
        };
        self.targets.iter().map(size).collect()
    }

    /// The largest errors against all pairs, with compensated sums, relative to the sizes.
    fn errors(&self, got: &Sums<D>, wanted: Wanted) -> [f64; 3] {
        let direct = Options { method: Some(Method::Direct), ..Options::default() };
        let (method, _, want, counters) = self.run(wanted, &direct, &Serial);
        let (pairs, n) = (counters.pairs, self.sources.1.iter().filter(|&&m| m != 0.0).count());
        assert_eq!((method, pairs), (Method::Direct, (n * self.targets.len()) as u64));
        let mut worst = [0.0_f64; 3];
        let centre = self.sources.1.iter().map(|m| m.abs()).sum::<f64>() / self.delta;
        for (k, size) in self.sizes().into_iter().enumerate() {
            let before = worst;
            let distance = |a: &[f64; D], b: &[f64; D]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let errors = [
                (got.potential[k] - want.potential[k]).abs(),
                distance(&got.gradient[k], &want.gradient[k]),
                (got.laplacian[k] - want.laplacian[k]).abs(),
            ];
            for ((w, e), s) in worst.iter_mut().zip(errors).zip(size) {
                *w = w.max(if e == 0.0 { 0.0 } else { e / s });
            }
            if let Mollifier::Gaussian { .. } = self.mollifier {
                // beyond its reach a Gaussian is cut off: e^{-6.6^2} = 1.2e-19 of its largest value
                worst[2] = if errors[2] < 2e-19 * centre { before[2] } else { worst[2] };
            }
        }
        worst
    }
}

/// Moments are double-word sums of terms with about 6 roundings. The expansion of degree 4 in two variables has weights up to
/// 4^2 times sum |m| |K| and 15 terms. All pairs (here the reference, plain sums in blocks) lose up to sqrt(n) u: 1e-14
/// is 45 u.
#[test]
fn quartic_moments_are_within_1e_14_of_all_pairs_for_1e4_particles() {
    for (at, signed, mollifier) in [(0.0, false, COMPACT), (1e3, false, Mollifier::None), (0.3, true, COMPACT)] {
        let (positions, masses) = cloud::<2>(10_000, 1, at, signed);
        let targets = &positions[..200];
        let terms = [power(4.0, 1.0)];
        let case = Case { terms: &terms, mollifier, delta: 0.1, sources: (&positions, &masses), targets };
        let (method, reason, sums, counters) = case.run(ALL, &Options::default(), &Serial);
        assert_eq!((method, reason), (Method::Moments, Reason::EvenPowers));
        assert_eq!(counters, Statistics::default());
        let errors = case.errors(&sums, ALL);
        println!("at {at}: {errors:?}");
        assert!(errors.iter().all(|&e| e < 1e-14), "{errors:?}");
        // the same bits on several threads, and on every machine
        let (_, _, again, _) = case.run(ALL, &Options::default(), &Threads);
        assert_eq!(sums, again);
    }
}

#[test]
fn moments_of_every_even_power_dimension_and_mollifier() {
    fn check<const D: usize>(mollifiers: &[Mollifier]) {
        for &mollifier in mollifiers {
            for n in [0, 1, 15, 16, 17, 1025] {
                let (positions, mut masses) = cloud::<D>(n, 3, 5.0, n % 2 == 0);
                if n > 5 {
                    masses[3] = 0.0;
                }
                let (targets, _) = cloud::<D>(33, 4, 5.2, false);
                for terms in [vec![power(2.0, -1.0)], vec![power(8.0, 0.3), power(4.0, 1.0)], vec![power(6.0, 2.0)]] {
                    let case = Case {
                        terms: &terms,
                        mollifier,
                        delta: 0.4,
                        sources: (&positions, &masses),
                        targets: &targets,
                    };
                    let singular = mollifier == Mollifier::None && terms[0].law == Law::Power { exponent: 2.0 };
                    let wanted = Wanted { laplacian: !singular, ..ALL };
                    let (method, _, sums, counters) = case.run(wanted, &Options::default(), &Serial);
                    assert_eq!(method, Method::Moments);
                    assert_eq!((counters.pairs, counters.massless_sources), (0, u64::from(n > 5)));
                    // the weights of the expansion are at most 4^p/2 for degree p = 8: 256 roundings of sum |m| |K|; the
                    // sixth- and eighth-power kernels of high-order mollifiers have sizes that cancel among themselves
                    let errors = case.errors(&sums, wanted);
                    assert!(
                        errors.iter().all(|&e| e < 1024.0 * f64::EPSILON),
                        "{D} {mollifier:?} {n} {terms:?} {errors:?}"
                    );
                }
            }
        }
    }
    check::<1>(&[Mollifier::None, COMPACT, Mollifier::Gaussian { order: 6 }]);
    check::<2>(&[Mollifier::None, COMPACT, Mollifier::Gaussian { order: 4 }]);
    check::<3>(&[Mollifier::None, Mollifier::Compact { order: 2, exponent: 9 }]);
}

/// Sorted sums: each moment is a double-word sum. The expansion of degree 3 loses at most 4^3 u against sum |m| |K|, the near pairs
/// and the reference sqrt(n) u. 1e4 particles: 100 + 64 roundings.
#[test]
fn sorted_sums_equal_all_pairs() {
    let sums: [&[Term]; 4] =
        [&[NEWTONIAN], &[power(3.0, 1.0)], &[power(1.0, 2.0), power(2.0, -0.5)], &[power(5.0, 1.0), NEWTONIAN]];
    let gaussian = Mollifier::Gaussian { order: 4 };
    for (terms, mollifier) in sums.iter().flat_map(|&t| [Mollifier::None, COMPACT, gaussian].map(|m| (t, m))) {
        for n in [0, 1, 2, 63, 64, 65, 250] {
            let (mut positions, mut masses) = cloud::<1>(n, 5, 3.0, n % 2 == 1);
            if n > 60 {
                // some particles coincide, and one has no mass
                positions[7] = positions[9];
                positions[8] = positions[9];
                masses[11] = 0.0;
            }
            let (other, _) = cloud::<1>(65, 6, 3.0, false);
            for targets in [&positions[..], &other[..]] {
                let case = Case { terms, mollifier, delta: 0.003, sources: (&positions, &masses), targets };
                let (method, reason, sums, counters) = case.run(ALL, &Options::default(), &Serial);
                if n * targets.len() < 2048 {
                    assert_eq!(method, Method::Direct);
                    continue;
                }
                assert_eq!((method, reason), (Method::Sorted, Reason::OneDimension));
                let near = if mollifier == Mollifier::None { 0 } else { counters.near_pairs };
                assert_eq!((counters.pairs, counters.massless_sources), (near, 1));
                assert!(counters.pairs < (n * targets.len()) as u64 / 10);
                let errors = case.errors(&sums, ALL);
                assert!(errors.iter().all(|&e| e < 200.0 * f64::EPSILON), "{mollifier:?} {n} {terms:?} {errors:?}");
            }
        }
    }
    // ten thousand particles
    let (positions, masses) = cloud::<1>(10_000, 8, 0.0, false);
    let case = Case {
        terms: &[NEWTONIAN],
        mollifier: COMPACT,
        delta: 5e-4,
        sources: (&positions, &masses),
        targets: &positions,
    };
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    let (method, _, sums, _) = case.run(wanted, &Options::default(), &Serial);
    let few = Case { targets: &positions[..300], ..case };
    let some = Sums { potential: vec![7.0; 300], gradient: sums.gradient[..300].to_vec(), laplacian: vec![7.0; 300] };
    assert_eq!(method, Method::Sorted);
    let errors = few.errors(&some, wanted);
    assert!(errors[1] < 100.0 * f64::EPSILON, "{errors:?}");
}

/// The same terms in another order: at most sqrt(n) u of sum |m| |psi|, and 16 u for t from a rounded square.
#[test]
fn neighbour_sums_equal_all_pairs_and_look_at_near_pairs_only() {
    fn check<const D: usize>(n: usize, delta: f64, at: f64) {
        let (mut positions, mut masses) = cloud::<D>(n, 9, at, true);
        if n > 20 {
            positions[4] = positions[5];
            masses[6] = 0.0;
            // particles far away: the extent of the grid must not increase the cost
            positions[7] = [at + 1e4; D];
        }
        let (mut targets, _) = cloud::<D>(129, 10, at, false);
        targets[0] = [at - 1e9; D];
        targets[1] = [at + 1e4 + 0.5 * delta / D as f64; D];
        targets[2] = if n > 5 { positions[5] } else { targets[2] };
        let wanted = Wanted { laplacian: true, ..Wanted::default() };
        let case =
            Case { terms: &[NEWTONIAN], mollifier: COMPACT, delta, sources: (&positions, &masses), targets: &targets };
        let (method, reason, sums, counters) = case.run(wanted, &Options::default(), &Serial);
        assert_eq!((method, reason), (Method::Neighbours, Reason::CompactLaplacian));
        let near = targets.iter().flat_map(|x| positions.iter().zip(&masses).map(move |(y, m)| (x, y, m)));
        let near = near.filter(|(x, y, m)| {
            **m != 0.0 && x.iter().zip(*y).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() < delta * delta
        });
        assert_eq!(counters.near_pairs, near.count() as u64);
        if n > 1000 && delta < 0.2 {
            assert!(counters.pairs < (n * 129) as u64 / 20, "{counters:?}");
        }
        let errors = case.errors(&sums, wanted);
        assert!(errors[2] < 100.0 * f64::EPSILON, "{D} {n} {errors:?}");
        assert_eq!(sums, case.run(wanted, &Options::default(), &Threads).2);
    }
    for n in [0, 1, 2, 100, 3000] {
        check::<1>(n, 0.01, -2.0);
        check::<2>(n, 0.1, 30.0);
        check::<2>(n, 5.0, 30.0);
        check::<3>(n, 0.1, 0.0);
    }
}

/// Even powers from moments, and Newtonian terms over all pairs. (Other kernels have a table that includes the even powers.) Each part has an
/// error of about 4^2 sqrt(n) u of its own sum |m| |K|: the weights of the expansion for degree 4, and plain sums. The sizes of the parts add up
/// to less than 8 times the sum's here.
#[test]
fn mixed_sums_take_their_even_powers_from_moments() {
    fn check<const D: usize>(terms: &[Term], mollifier: Mollifier, wanted: Wanted) {
        for n in [0, 1, 16, 150] {
            let (mut positions, mut masses) = cloud::<D>(n, 12, 2.0, n % 2 == 0);
            if n > 20 {
                positions[7] = positions[9];
                masses[11] = 0.0;
            }
            let (other, _) = cloud::<D>(130, 13, 2.1, false);
            for targets in [&positions[..], &other[..]] {
                let case = Case { terms, mollifier, delta: 0.3, sources: (&positions, &masses), targets };
                let (method, reason, sums, counters) = case.run(wanted, &Options::default(), &Serial);
                let massless = u64::from(n > 20);
                let pairs = (n as u64 - massless) * targets.len() as u64;
                assert_eq!((counters.pairs, counters.massless_sources), (pairs, massless), "{terms:?}");
                let even = |law| matches!(law, Law::Power { exponent } if exponent % 2.0 == 0.0);
                let only_newtonian = terms.iter().all(|term| *term == NEWTONIAN || even(term.law));
                let splits = only_newtonian && !matches!(mollifier, Mollifier::Gaussian { .. });
                if n * targets.len() < 2048 || !splits {
                    assert_eq!(method, Method::Direct);
                    continue;
                }
                assert_eq!((method, reason), (Method::Split, Reason::SomeEvenPowers));
                let errors = case.errors(&sums, wanted);
                assert!(
                    errors.iter().all(|&e| e < 8.0 * 16.0 * 13.0 * f64::EPSILON),
                    "{mollifier:?} {terms:?} {errors:?}"
                );
                assert_eq!(sums, case.run(wanted, &Options::default(), &Threads).2);
            }
        }
    }
    let screened = Term { law: Law::Screened { k: 2.0 }, coefficient: 1.0 };
    for mollifier in [Mollifier::None, COMPACT, Mollifier::Gaussian { order: 4 }] {
        check::<2>(&[power(4.0, 1.0), NEWTONIAN], mollifier, ALL);
        check::<2>(&[power(1.5, -1.0), power(4.0, 1.0)], mollifier, ALL);
        check::<1>(&[screened, power(2.0, 1.0)], mollifier, Wanted { laplacian: false, ..ALL });
    }
    check::<3>(&[NEWTONIAN, power(2.0, 1.0), power(3.0, 0.5)], COMPACT, ALL);
    // without a mollifier coincident pairs do not contribute to the constant Laplacian of |x|^2: all pairs
    let (positions, masses) = cloud::<2>(60, 14, 0.0, false);
    let terms = [power(2.0, 1.0), NEWTONIAN];
    let sources = (&positions[..], &masses[..]);
    let case = Case { terms: &terms, mollifier: Mollifier::None, delta: 0.1, sources, targets: &positions };
    assert_eq!(case.run(ALL, &Options::default(), &Serial).0, Method::Direct);
    let forced = Options { method: Some(Method::Split), ..Options::default() };
    let wanted = Wanted { laplacian: false, ..ALL };
    assert_eq!(case.run(wanted, &forced, &Serial).1, Reason::Forced);
}

#[test]
fn forced_methods_that_cannot_serve_are_refused_and_users_choices_kept() {
    let kernel = Kernel::<f64, 2>::newtonian(1.0, COMPACT, 0.1).unwrap();
    for method in [Method::Moments, Method::Sorted, Method::Neighbours, Method::Split] {
        let options = Options { method: Some(method), ..Options::default() };
        assert_eq!(plan(&kernel, 10, 10, ALL, &options).err(), Some(Error::Unsupported));
    }
    let wanted = Wanted { laplacian: true, ..Wanted::default() };
    let options = Options { method: Some(Method::Neighbours), ..Options::default() };
    assert_eq!(plan(&kernel, 10, 10, wanted, &options).unwrap().reason(), Reason::Forced);
    // a plan for one kernel is refused with another
    let plan = plan(&kernel, 0, 0, wanted, &Options::default()).unwrap();
    let other = Kernel::<f64, 2>::newtonian(1.0, Mollifier::Gaussian { order: 4 }, 0.1).unwrap();
    let none = Sources::new(&[], &[]);
    assert_eq!(
        evaluate(&plan, &other, none, &[], Outputs::default(), &mut [], &mut Run::default()),
        Err(Error::Unsupported)
    );
    assert!(Level::Portable.is_available());
}

#[test]
fn the_rotated_gradient_of_moments() {
    let (positions, masses) = cloud::<2>(50, 11, 0.0, true);
    let terms = [power(4.0, 1.0)];
    let case =
        Case { terms: &terms, mollifier: COMPACT, delta: 0.1, sources: (&positions, &masses), targets: &positions };
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    let (_, _, plain, _) = case.run(wanted, &Options::default(), &Serial);
    let turned = Options { combination: (0.5, 2.0), ..Options::default() };
    let (method, _, got, _) = case.run(wanted, &turned, &Serial);
    assert_eq!(method, Method::Moments);
    for ([x, y], [gx, gy]) in got.gradient.into_iter().zip(plain.gradient) {
        let size = gx.abs() + gy.abs();
        // 32 roundings: both evaluate polynomials of ten terms
        assert!((x - (0.5 * gx - 2.0 * gy)).abs() < 64.0 * f64::EPSILON * (1.0 + size));
        assert!((y - (0.5 * gy + 2.0 * gx)).abs() < 64.0 * f64::EPSILON * (1.0 + size));
    }
}
