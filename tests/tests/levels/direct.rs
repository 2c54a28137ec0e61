//! The direct sum against its twin in double-double arithmetic, at every level this machine has; and what it promises about
//! bits, counts, refusals and extreme distances.

use mollis_core::exec::{Executor, Run, Serial, Statistics};
use mollis_core::field::{self, Accumulation, Options, Outputs, Plan, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_reference::field::{Soft, newtonian};
use mollis_tests::Threads;

use super::{Random, cases, levels};

const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };

struct Case<const D: usize> {
    positions: Vec<[f64; D]>,
    masses: Vec<f64>,
    targets: Vec<[f64; D]>,
    soft: Option<Soft>,
}

struct Result3<T, const D: usize> {
    potential: Vec<T>,
    gradient: Vec<[T; D]>,
    laplacian: Vec<T>,
    counters: Statistics,
}

fn kernel<T: Real, const D: usize>(soft: Option<Soft>) -> Kernel<'static, T, D> {
    let (mollifier, delta) = match soft {
        Some(s) => (Mollifier::Compact { order: s.order, exponent: s.exponent }, s.delta),
        None => (Mollifier::None, 0.0),
    };
    Kernel::newtonian(T::ONE, mollifier, T::from_f64(delta)).unwrap()
}

/// A dirty workspace of exactly the plan's size, ringed by canaries.
fn in_workspace<R>(plan: &Plan, workers: usize, body: impl FnOnce(&mut [u8]) -> R) -> R {
    let bytes = plan.workspace_bytes(workers).unwrap();
    let mut memory = vec![0xA5_u8; bytes + 256];
    let start = memory.as_ptr().align_offset(64) + 64;
    let result = body(&mut memory[start..start + bytes]);
    assert!(memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xA5), "wrote outside the workspace");
    result
}

fn sum<T: Real, const D: usize>(
    case: &Case<D>,
    wanted: Wanted,
    options: &Options,
    level: Level,
    executor: &dyn Executor,
) -> Result3<T, D> {
    let kernel = kernel::<T, D>(case.soft);
    let convert = |points: &[[f64; D]]| points.iter().map(|x| x.map(T::from_f64)).collect::<Vec<_>>();
    let (positions, targets) = (convert(&case.positions), convert(&case.targets));
    let masses: Vec<T> = case.masses.iter().map(|&m| T::from_f64(m)).collect();
    let n = targets.len();
    let mut out = Result3 {
        potential: vec![T::NAN; n],
        gradient: vec![[T::NAN; D]; n],
        laplacian: vec![T::NAN; n],
        counters: Statistics::default(),
    };
    let plan = field::plan(&kernel, positions.len(), n, wanted, options).unwrap();
    in_workspace(&plan, executor.workers(), |workspace| {
        let outputs = Outputs {
            potential: wanted.potential.then_some(&mut out.potential[..]),
            gradient: wanted.gradient.then_some(&mut out.gradient[..]),
            laplacian: wanted.laplacian.then_some(&mut out.laplacian[..]),
            hessian: None,
        };
        let sources = Sources::new(&positions, &masses);
        let mut run = Run { level, executor, counters: Some(&mut out.counters), ..Run::default() };
        field::evaluate(&plan, &kernel, sources, &targets, outputs, workspace, &mut run).unwrap();
    });
    out
}

/// Random and adversarial: particles on each other, on the edge of the support, on a line through the target, far and near,
/// masses that cancel.
fn case<const D: usize>(rng: &mut Random, small: f64, large: f64) -> Case<D> {
    let n = rng.below(40);
    let kind = rng.below(8);
    let soft = (rng.below(4) > 0).then(|| Soft {
        order: 2 + 2 * rng.below(2) as u32,
        exponent: 1 + rng.below(9) as u32,
        delta: f64::from([0.05_f32, 0.5, 4.0, 1e-3][rng.below(4)]),
    });
    let mut positions: Vec<[f64; D]> = Vec::new();
    for i in 0..n {
        let mut x: [f64; D] = std::array::from_fn(|_| rng.number());
        match (kind, i % 3) {
            (1, 1) => x = positions[rng.below(i)],
            (2, _) => x = x.map(|c| c * small),
            (3, 0) => x = x.map(|c| c * large),
            (4, 0) => x = x.map(|c| c * small),
            (4, 1) => x = x.map(|c| c * large),
            (5, _) => {
                // At the edge, one ulp of f32 to either side.
                let nudge = 1.0 + f64::from(f32::EPSILON) * (rng.below(5) as f64 - 2.0);
                x = [0.0; D];
                x[0] = f64::from((soft.map_or(1.0, |s| s.delta) * nudge) as f32);
            }
            (6, _) => x = std::array::from_fn(|c| if c == 0 { x[0] } else { 0.0 }),
            _ => {}
        }
        // What both scalars hold exactly, unless f32 is not asked for.
        positions.push(if small < 1e-40 { x } else { x.map(|c| f64::from(c as f32)) });
    }
    let masses = (0..n).map(|i| {
        if kind == 7 {
            [1.0, -1.0][i % 2]
        } else if i % 7 == 6 {
            0.0
        } else {
            rng.number()
        }
    });
    let masses = masses.collect();
    let mut targets: Vec<[f64; D]> = positions.iter().copied().step_by(2).collect();
    targets.push([0.0; D]);
    targets.push(std::array::from_fn(|_| rng.number()));
    Case { positions, masses, targets, soft }
}

/// |error| <= (c + n) u sum |m K|, the documented bound for n < 256 with c = 16; for the 2D potential with |K| + 1/(2 pi), for
/// the Laplacian with max psi in place of |K|. Returns the largest error over bound.
fn check<T: Real, const D: usize>(case: &Case<D>, got: &Result3<T, D>, what: &str) -> f64 {
    let u = T::EPSILON.to_f64() / 2.0;
    let bound = (16.0 + case.positions.len() as f64) * u;
    let (largest, least) = (T::MAX.to_f64(), T::MIN_POSITIVE.to_f64());
    let mut worst: f64 = 0.0;
    for (i, target) in case.targets.iter().enumerate() {
        let want = newtonian(case.soft, &case.positions, &case.masses, target);
        let mut one = |name: &str, got: T, want: f64, size: f64| {
            if size.is_nan() || size > largest / 16.0 {
                return;
            }
            let error = (got.to_f64() - want).abs();
            let allowed = bound * size + 64.0 * least;
            assert!(
                error <= allowed,
                "{what} {D}D {name} target {i}: {got} for {want}, error/allowed {}, {:?}",
                error / allowed,
                case.soft
            );
            worst = worst.max(error / allowed);
        };
        let flat = if D == 2 { want.mass / (2.0 * std::f64::consts::PI) } else { 0.0 };
        one("potential", got.potential[i], want.potential.value(), want.potential_size + flat);
        for k in 0..D {
            one("gradient", got.gradient[i][k], want.gradient[k].value(), want.gradient_size[k]);
        }
        one("laplacian", got.laplacian[i], want.laplacian.value(), want.laplacian_size);
    }
    worst
}

fn bound_holds<T: Real, const D: usize>(cases: usize, small: f64, large: f64) {
    let mut rng = Random::new(D as u64);
    let levels = levels();
    let mut worst: f64 = 0.0;
    for i in 0..cases {
        let case = case::<D>(&mut rng, small, large);
        let level = levels[i % levels.len()];
        let got = sum::<T, D>(&case, ALL, &Options::default(), level, &Serial);
        worst = worst.max(check(&case, &got, &format!("case {i} {}", level.name())));
    }
    assert!(worst > 0.0, "nothing was compared");
}

#[test]
fn the_error_bound_holds_in_f64() {
    bound_holds::<f64, 1>(cases(2000), 1e-300, 1e150);
    bound_holds::<f64, 2>(cases(2000), 1e-300, 1e150);
    bound_holds::<f64, 3>(cases(2000), 1e-300, 1e150);
}

#[test]
fn the_error_bound_holds_in_f32() {
    bound_holds::<f32, 1>(cases(1400), 1e-30, 1e15);
    bound_holds::<f32, 2>(cases(1400), 1e-30, 1e15);
    bound_holds::<f32, 3>(cases(1400), 1e-12, 1e12);
}

/// Around every lane, register block, task and source block.
fn around() -> Vec<usize> {
    let widths = [2, 4, 8, 16, 32, 64, 128, 256];
    let mut sizes: Vec<usize> = widths.iter().flat_map(|&w| [w - 1, w, w + 1]).chain([0, 1, 300]).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

fn grid_case<const D: usize>(n: usize, k: usize, soft: Option<Soft>) -> Case<D> {
    let mut rng = Random::new(n as u64 * 1000 + k as u64);
    let positions: Vec<[f64; D]> = (0..n).map(|_| std::array::from_fn(|_| rng.number())).collect();
    let targets = (0..k).map(|i| positions.get(i).copied().unwrap_or([0.25; D])).collect();
    Case { masses: (0..n).map(|_| rng.number()).collect(), positions, targets, soft }
}

#[test]
fn sizes_around_every_width() {
    let soft = Some(Soft { order: 2, exponent: 4, delta: 0.25 });
    for level in levels() {
        for k in around() {
            let case = grid_case::<2>(9, k, soft);
            check(&case, &sum::<f64, 2>(&case, ALL, &Options::default(), level, &Serial), "targets");
        }
        for n in around() {
            let case = grid_case::<3>(n, 3, soft);
            check(&case, &sum::<f64, 3>(&case, ALL, &Options::default(), level, &Serial), "sources");
            let case = grid_case::<2>(n, 3, None);
            check(&case, &sum::<f32, 2>(&case, ALL, &Options::default(), level, &Serial), "sources");
        }
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads_at_every_level() {
    let case = grid_case::<2>(700, 700, Some(Soft { order: 4, exponent: 3, delta: 0.1 }));
    for level in levels() {
        let one = sum::<f64, 2>(&case, ALL, &Options::default(), level, &Serial);
        for threads in [1, 2, 3, 7] {
            let many = sum::<f64, 2>(&case, ALL, &Options::default(), level, &Threads(threads));
            let bits = |r: &Result3<f64, 2>| {
                let flat = r.gradient.iter().flatten().chain(&r.potential).chain(&r.laplacian);
                flat.map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            assert_eq!(bits(&one), bits(&many), "{} {threads}", level.name());
            assert_eq!(one.counters, many.counters);
        }
    }
}

/// Outputs do not change what others get beyond the bound, and what is not wanted is not written.
#[test]
fn any_subset_of_outputs() {
    let case = grid_case::<2>(100, 33, Some(Soft { order: 2, exponent: 4, delta: 0.2 }));
    for level in levels() {
        let all = sum::<f64, 2>(&case, ALL, &Options::default(), level, &Serial);
        for bits in 0..8 {
            let wanted =
                Wanted { potential: bits & 1 > 0, gradient: bits & 2 > 0, laplacian: bits & 4 > 0, hessian: false };
            let some = sum::<f64, 2>(&case, wanted, &Options::default(), level, &Serial);
            let whole = Result3 {
                potential: if wanted.potential { some.potential.clone() } else { all.potential.clone() },
                gradient: if wanted.gradient { some.gradient.clone() } else { all.gradient.clone() },
                laplacian: if wanted.laplacian { some.laplacian.clone() } else { all.laplacian.clone() },
                counters: some.counters,
            };
            check(&case, &whole, "subset");
            assert!(wanted.potential || some.potential.iter().all(|x| x.is_nan()));
            assert!(wanted.gradient || some.gradient.iter().flatten().all(|x| x.is_nan()));
            assert!(wanted.laplacian || some.laplacian.iter().all(|x| x.is_nan()));
        }
    }
}

/// A zero or a huge distance in one lane leaves the other lanes' bits as they are.
#[test]
fn lanes_do_not_touch_each_other() {
    for level in levels() {
        let mut case = grid_case::<3>(20, 64, None);
        case.targets = (0..64).map(|i| [0.3 + 0.01 * f64::from(i), 0.2, -0.1]).collect();
        // What enters the units stays: the largest coordinate is a source's.
        case.positions[0] = [1e150, 0.0, 0.0];
        let before = sum::<f64, 3>(&case, ALL, &Options::default(), level, &Serial);
        for lane in 0..64 {
            for strange in [case.positions[3], [1e-300, 0.0, 0.0], [9e149, 1.0, 0.0]] {
                let mut changed = case_copy(&case);
                changed.targets[lane] = strange;
                let after = sum::<f64, 3>(&changed, ALL, &Options::default(), level, &Serial);
                check_one(&changed, &after, lane);
                for i in (0..64).filter(|&i| i != lane) {
                    let close = |a: f64, b: f64| (a - b).abs() <= 1e-14 * a.abs().max(b.abs());
                    assert!(after.gradient[i][0].is_finite() && close(before.potential[i], after.potential[i]));
                }
            }
        }
    }

    fn case_copy<const D: usize>(case: &Case<D>) -> Case<D> {
        Case {
            positions: case.positions.clone(),
            masses: case.masses.clone(),
            targets: case.targets.clone(),
            soft: case.soft,
        }
    }
    fn check_one(case: &Case<3>, got: &Result3<f64, 3>, lane: usize) {
        let one = Case { targets: vec![case.targets[lane]], ..case_copy(case) };
        let got = Result3 {
            potential: vec![got.potential[lane]],
            gradient: vec![got.gradient[lane]],
            laplacian: vec![got.laplacian[lane]],
            counters: got.counters,
        };
        check(&one, &got, "strange lane");
    }
}

#[test]
fn skipped_work_is_counted() {
    let soft = |delta| Some(Soft { order: 2, exponent: 4, delta });
    for level in levels() {
        let run = |case: &Case<2>| sum::<f64, 2>(case, ALL, &Options::default(), level, &Serial).counters;
        // Targets far from all sources: no polynomial. Every seventh source has no mass.
        let mut case = grid_case::<2>(70, 40, soft(0.1));
        case.masses.iter_mut().step_by(7).for_each(|m| *m = 0.0);
        case.targets.iter_mut().for_each(|x| x[0] += 5.0);
        let want = Statistics { pairs: 60 * 40, massless_sources: 10, ..Statistics::default() };
        assert_eq!(run(&case), want);
        // Everything inside: every block, none mixed.
        let mut case = grid_case::<2>(70, 40, soft(8.0));
        let counts = run(&case);
        assert_eq!((counts.near_pairs, counts.pairs), (70 * 40, 70 * 40));
        assert_eq!(counts.polynomial_blocks, counts.all_near_blocks);
        assert_eq!(counts.scaled_pairs, 0);
        // Pairs counted one by one.
        case.soft = soft(0.5);
        let near = case.targets.iter().flat_map(|t| case.positions.iter().map(move |x| (t, x)));
        let near = near.filter(|(t, x)| (t[0] - x[0]).powi(2) + (t[1] - x[1]).powi(2) < 0.25).count();
        assert_eq!(run(&case).near_pairs, near as u64);
    }
}

#[test]
fn compensated_sums_do_not_grow_with_n() {
    let n = 20_000;
    let mut case = grid_case::<2>(n, 3, Some(Soft { order: 2, exponent: 4, delta: 0.1 }));
    case.masses.iter_mut().for_each(|m| *m = m.abs());
    let options = Options { accumulation: Accumulation::Compensated, ..Options::default() };
    for level in levels() {
        let got = sum::<f32, 2>(&case, ALL, &options, level, &Serial);
        // c, the additions within a block of 8, four for the double words; n u^2 / 4 is nothing here.
        let bound = (16.0 + 8.0 + 4.0) * f64::from(f32::EPSILON) / 2.0;
        // f32 delta and masses are not the twin's.
        let soft = Some(Soft { delta: f64::from(0.1_f32), order: 2, exponent: 4 });
        for (i, target) in case.targets.iter().enumerate() {
            let want = newtonian(soft, &case.positions, &case.masses, target);
            let error = (f64::from(got.potential[i]) - want.potential.value()).abs();
            assert!(error <= bound * (want.potential_size + want.mass / 6.0), "{}", level.name());
            for k in 0..2 {
                let error = (f64::from(got.gradient[i][k]) - want.gradient[k].value()).abs();
                assert!(error <= bound * want.gradient_size[k], "{}", level.name());
            }
        }
    }
}

#[test]
fn rotated_and_combined_gradients() {
    let case = grid_case::<2>(30, 30, Some(Soft { order: 2, exponent: 4, delta: 0.3 }));
    let run = |combination| {
        let options = Options { combination, ..Options::default() };
        sum::<f64, 2>(&case, ALL, &options, Level::best(), &Serial).gradient
    };
    let (plain, rotated, mixed) = (run((1.0, 0.0)), run((0.0, 1.0)), run((0.5, -2.0)));
    for ((p, r), m) in plain.iter().zip(&rotated).zip(&mixed) {
        assert_eq!(*r, [-p[1], p[0]]);
        assert_eq!(*m, [0.5 * p[0] + 2.0 * p[1], 0.5 * p[1] - 2.0 * p[0]]);
    }
}

#[test]
fn refused_calls_leave_outputs_alone() {
    let kernel = Kernel::<f64, 2>::newtonian(1.0, Mollifier::None, 0.0).unwrap();
    let options = Options::default();
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    let plan = field::plan(&kernel, 2, 2, wanted, &options).unwrap();
    let good = [[0.0, 0.0], [1.0, 0.0]];
    let attempt =
        |positions: &[[f64; 2]], masses: &[f64], targets: &[[f64; 2]], potential: bool, short: usize, level| {
            let (mut u, mut g) = ([7.0; 2], [[7.0; 2]; 2]);
            let error = in_workspace(&plan, 1, |workspace| {
                let bytes = workspace.len() - short;
                let outputs = Outputs {
                    potential: potential.then_some(&mut u[..]),
                    gradient: Some(&mut g),
                    laplacian: None,
                    hessian: None,
                };
                let mut run = Run { level, ..Run::default() };
                let sources = Sources::new(positions, masses);
                field::evaluate(&plan, &kernel, sources, targets, outputs, &mut workspace[..bytes], &mut run)
                    .unwrap_err()
            });
            assert!(u == [7.0; 2] && g == [[7.0; 2]; 2], "{error}");
            error
        };
    let best = Level::best();
    assert_eq!(attempt(&good[..1], &[1.0; 2], &good, false, 0, best), Error::LengthMismatch);
    assert_eq!(attempt(&good, &[1.0; 3], &good, false, 0, best), Error::LengthMismatch);
    assert_eq!(attempt(&good, &[1.0; 2], &good[..1], false, 0, best), Error::LengthMismatch);
    assert_eq!(attempt(&good, &[1.0, f64::NAN], &good, false, 0, best), Error::NotFinite);
    assert_eq!(attempt(&[[0.0, f64::INFINITY]; 2], &[1.0; 2], &good, false, 0, best), Error::NotFinite);
    assert_eq!(attempt(&good, &[1.0; 2], &good, true, 0, best), Error::Unsupported);
    assert_eq!(attempt(&good, &[1.0; 2], &good, false, 1, best), Error::WorkspaceTooSmall);
    for level in Level::ALL.into_iter().filter(|l| !l.is_available()) {
        assert_eq!(attempt(&good, &[1.0; 2], &good, false, 0, level), Error::Unsupported);
    }
    let three = Kernel::<f64, 3>::newtonian(1.0, Mollifier::None, 0.0).unwrap();
    let rotated = Options { combination: (0.0, 1.0), ..options };
    assert_eq!(field::plan(&three, 1, 1, wanted, &rotated).err(), Some(Error::Unsupported));
    assert_eq!(field::plan(&kernel, usize::MAX / 8, 1, wanted, &options).err(), Some(Error::TooLarge));
}
