//! The error bound of sums for every kernel and method, the range of their arguments, and the independence of outputs.

use mollis_core::Real;
use mollis_core::exec::{Run, Statistics};
use mollis_core::field::{self, Accumulation, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;
use mollis_tests::{Aligned, Split};

use crate::field_ranges::row;

pub(crate) const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
pub(crate) const COMPACT: Mollifier = Mollifier::Compact { order: 2, exponent: 4 };

/// One call's results.
pub(crate) struct Sums<T, const D: usize> {
    pub(crate) potential: Vec<T>,
    pub(crate) gradient: Vec<[T; D]>,
    pub(crate) laplacian: Vec<T>,
    pub(crate) counters: Statistics,
}

pub(crate) fn term(law: Law, coefficient: f64) -> Term {
    Term { law, coefficient }
}

pub(crate) fn power(exponent: f64) -> Law {
    Law::Power { exponent }
}

/// One output alone, or two.
pub(crate) const POTENTIAL: Wanted = Wanted { potential: true, gradient: false, laplacian: false, hessian: false };
pub(crate) const LAPLACIAN: Wanted = Wanted { potential: false, gradient: false, laplacian: true, hessian: false };

/// Prepares the kernel and calls the function with it.
pub(crate) fn with_kernel<T: Real, const D: usize, R>(
    terms: &[Term],
    shape: (Mollifier, f64),
    then: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> R {
    with_kernel_if_any(terms, shape, then).unwrap_or_else(|| panic!("{D}D {terms:?} {shape:?}"))
}

/// The same; None where the numbers of the prepared kernel leave the range.
fn with_kernel_if_any<T: Real, const D: usize, R>(
    terms: &[Term],
    (mollifier, delta): (Mollifier, f64),
    then: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> Option<R> {
    let mut block = Aligned::new(Kernel::<T, D>::workspace_bytes(terms, mollifier).unwrap());
    match Kernel::<T, D>::prepare(block.bytes(), terms, mollifier, T::from_f64(delta)) {
        Ok(kernel) => Some(then(&kernel)),
        Err(error) => {
            assert_eq!(error, mollis_core::Error::OutOfDomain);
            None
        }
    }
}

pub(crate) fn sums_of<T: Real, const D: usize>(
    kernel: &Kernel<'_, T, D>,
    (positions, masses, targets): (&[[T; D]], &[T], &[[T; D]]),
    wanted: Wanted,
    options: &Options,
    level: Level,
) -> Sums<T, D> {
    let n = targets.len();
    let plan = field::plan(kernel, positions.len(), n, wanted, options).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
    let mut sums = Sums {
        potential: vec![T::NAN; n],
        gradient: vec![[T::NAN; D]; n],
        laplacian: vec![T::NAN; n],
        counters: Statistics::default(),
    };
    let outputs = Outputs {
        potential: wanted.potential.then_some(&mut sums.potential[..]),
        gradient: wanted.gradient.then_some(&mut sums.gradient[..]),
        laplacian: wanted.laplacian.then_some(&mut sums.laplacian[..]),
        hessian: None,
    };
    let mut run = Run { level, counters: Some(&mut sums.counters), ..Run::default() };
    let sources = Sources::new(positions, masses);
    field::evaluate(&plan, kernel, sources, targets, outputs, memory.bytes(), &mut run).unwrap();
    sums
}

fn cloud<T: Real, const D: usize>(n: usize, seed: u64) -> (Vec<[T; D]>, Vec<T>) {
    let mut split = Split(seed);
    let mut number = || T::from_f64(f64::from((2.0 * split.uniform() - 1.0) as f32));
    let positions = (0..n).map(|_| std::array::from_fn(|_| number())).collect();
    (positions, (0..n).map(|_| number()).collect())
}

/// The bound (c + 256 + n / 256) u S for equal sources in one place. Their sum rounds the same way every time: plain addition loses n u / 2.
#[test]
fn a_million_equal_sources_stay_within_the_bound() {
    fn check<T: Real, const D: usize>(
        terms: &[Term],
        shape: (Mollifier, f64),
        c: f64,
        options: &Options,
        wanted: Wanted,
    ) {
        let n = 1_000_000;
        let mass = T::from_f64(0.1);
        let (positions, masses) = (vec![[T::ZERO; D]; n], vec![mass; n]);
        let targets = [[T::from_f64(0.0625); D]];
        with_kernel::<T, D, _>(terms, shape, |kernel| {
            let got = sums_of(kernel, (&positions, &masses, &targets), wanted, options, Level::best());
            let r = (D as f64).sqrt() * 0.0625;
            let [value, factor, laplacian] =
                with_kernel::<f64, D, _>(terms, (shape.0, T::from_f64(shape.1).to_f64()), |kernel| kernel.at(r));
            let total = n as f64 * mass.to_f64();
            let u = T::EPSILON.to_f64() / 2.0;
            let blocked = options.accumulation == Accumulation::Blocked;
            let bound = if blocked { c + 256.0 + n as f64 / 256.0 } else { c + 12.0 + n as f64 / 4.0 * u } * u;
            let check = |name: &str, got: T, want: f64, scale: f64| {
                let error = (got.to_f64() - total * want).abs() / (total * scale.abs().max(want.abs()));
                assert!(error <= bound, "{D}D {terms:?} {shape:?} {name}: {} of the bound", error / bound);
            };
            if wanted.potential {
                check("potential", got.potential[0], value, value);
            }
            if wanted.gradient {
                check("gradient", got.gradient[0][0], factor * 0.0625, factor * 0.0625);
            }
            if wanted.laplacian {
                let centre = with_kernel::<f64, D, _>(terms, shape, |kernel| kernel.laplacian(0.0));
                // A table's Laplacian has an error of 1e-13 in f64, 1000 u.
                check(
                    "laplacian",
                    got.laplacian[0],
                    laplacian,
                    centre * if D == 2 && T::DIGITS > 24 { 16.0 } else { 1.0 },
                );
            }
        });
    }
    let plain = Options::default();
    let direct = Options { method: Some(Method::Direct), ..plain };
    let compensated = Options { accumulation: Accumulation::Compensated, ..direct };
    let laplacian = LAPLACIAN;
    let newtonian = [term(Law::Newtonian, 1.0)];
    // A sum over neighbours; then tables of Gaussian mollifiers and powers, whose c is 64.
    check::<f32, 2>(&newtonian, (COMPACT, 0.5), 16.0, &plain, laplacian);
    check::<f32, 1>(&newtonian, (COMPACT, 0.5), 16.0, &plain, ALL);
    check::<f32, 2>(&newtonian, (Mollifier::Gaussian { order: 4 }, 0.25), 64.0, &plain, ALL);
    check::<f32, 2>(&[term(power(1.5), 1.0)], (COMPACT, 0.05), 64.0, &plain, ALL);
    check::<f32, 2>(&[term(power(-0.5), 1.0)], (Mollifier::None, 0.0), 64.0, &plain, ALL);
    check::<f32, 3>(&[term(Law::Exponential { length: 0.5 }, 1.0)], (COMPACT, 0.05), 64.0, &plain, ALL);
    for terms in [&newtonian[..], &[term(power(1.5), 1.0)], &[term(Law::Screened { k: 2.0 }, 1.0)]] {
        check::<f32, 2>(terms, (COMPACT, 0.05), 64.0, &compensated, ALL);
        check::<f64, 2>(terms, (COMPACT, 0.05), 64.0, &compensated, ALL);
    }
    // Methods that the plan chooses: neighbours, sorted (by polynomials and one by one), moments.
    let chosen = Options { accumulation: Accumulation::Compensated, ..plain };
    check::<f32, 2>(&newtonian, (COMPACT, 1.0), 16.0, &chosen, laplacian);
    check::<f32, 1>(&newtonian, (COMPACT, 1.0), 16.0, &chosen, ALL);
    check::<f32, 1>(&newtonian, (Mollifier::Gaussian { order: 4 }, 1.0), 64.0, &chosen, ALL);
    check::<f32, 1>(&newtonian, (Mollifier::None, 0.0), 16.0, &chosen, Wanted { laplacian: false, ..ALL });
    check::<f32, 2>(&[term(power(2.0), 1.0)], (COMPACT, 1.0), 64.0, &chosen, ALL);
}

/// Single pairs of every law at random distances: the error is at most c u of the kernel's scale. The scale of a sum of terms is the sum of theirs.
#[test]
fn single_pairs_are_within_c_u_of_the_scale() {
    fn check<T: Real, const D: usize>() {
        let laws = [
            vec![term(Law::Exponential { length: 0.3 }, 1.0), term(Law::Exponential { length: 0.4 }, -1.0)],
            vec![term(power(0.0), 1.0)],
            vec![term(power(1.5), -0.7)],
            vec![term(Law::Screened { k: 3.0 }, 1.0)],
            vec![term(Law::Newtonian, 1.0), term(power(3.0), 0.5)],
        ];
        let shapes = [(Mollifier::None, 0.0), (COMPACT, 0.25), (Mollifier::Compact { order: 4, exponent: 6 }, 0.25)];
        let mut split = Split(D as u64);
        for terms in &laws {
            for shape in shapes {
                let distances: Vec<T> = (0..40).map(|_| T::from_f64(2.0 * split.uniform())).collect();
                let (mut all_scales, mut wants) = (vec![[0.0; 3]; 40], vec![[0.0; 3]; 40]);
                for &one in terms {
                    with_kernel::<f64, D, _>(&[one], shape, |kernel| {
                        let soft = shape.1 > 0.0;
                        // Beyond its own length an exponential is small. The error of its table is relative to the values within that length.
                        let own = match one.law {
                            Law::Exponential { length } => length,
                            Law::Screened { k } => 1.0 / k,
                            _ => 0.0,
                        };
                        let there =
                            if soft || own > 0.0 { kernel.at(if soft { shape.1 } else { own }) } else { [0.0; 3] };
                        let centre = if soft { kernel.at(0.0) } else { [0.0; 3] };
                        for ((sum, want), r) in all_scales.iter_mut().zip(&mut wants).zip(&distances) {
                            let here = kernel.at(r.to_f64());
                            for k in 0..3 {
                                want[k] += here[k];
                                sum[k] += here[k].abs().max(there[k].abs()).max(centre[k].abs());
                            }
                            // The argument of a logarithm is rounded. A Laplacian is the sum of two terms that cancel.
                            sum[0] += if one.law == power(0.0) || one.law == Law::Newtonian { 1.0 } else { 0.0 };
                            sum[2] += 2.0 * D as f64 * here[1].abs();
                        }
                    });
                }
                with_kernel::<T, D, _>(terms, shape, |kernel| {
                    for ((&r, &scales), &want) in distances.iter().zip(&all_scales).zip(&wants) {
                        let mut x = [T::ZERO; D];
                        x[0] = r;
                        let wanted = Options { method: Some(Method::Direct), ..Options::default() };
                        for level in Level::available() {
                            let got = sums_of(kernel, (&[[T::ZERO; D]], &[T::ONE], &[x]), ALL, &wanted, level);
                            let r = r.to_f64();
                            let u = T::EPSILON.to_f64() / 2.0;
                            let got = [got.potential[0], got.gradient[0][0], got.laplacian[0]].map(T::to_f64);
                            let want = [want[0], want[1] * r, want[2]];
                            for (k, scale) in [scales[0], scales[1] * r, scales[2]].into_iter().enumerate() {
                                // A table's Laplacian has an error of 1e-13 in f64.
                                let bound = if k == 2 { (128.0 * u).max(1.2e-13) } else { 128.0 * u };
                                let error = (got[k] - want[k]).abs() / scale;
                                assert!(
                                    error <= bound,
                                    "{D}D {terms:?} {shape:?} r {r} {k} {}: {} of the bound",
                                    level.name(),
                                    error / bound
                                );
                            }
                        }
                    }
                });
            }
        }
    }
    check::<f64, 1>();
    check::<f64, 2>();
    check::<f64, 3>();
    check::<f32, 2>();
}

/// Random scenes of f32 in random units, every method of sums that need no table, against double precision.
#[test]
fn random_scenes_in_random_units() {
    fn check<const D: usize>(seed: u64) {
        let mut split = Split(3 * seed + D as u64);
        let mut random = || split.uniform();
        let powers = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 2.5, 0.5, 5.0];
        let mut law = |newtonian: bool| {
            let p = powers[(9.0 * random()) as usize];
            if newtonian { Law::Newtonian } else { power(p) }
        };
        let newtonian = seed.is_multiple_of(2);
        let mut terms = vec![term(law(newtonian), 1.0)];
        if seed.is_multiple_of(3) {
            terms.push(term(law(false), if seed.is_multiple_of(5) { -1.0 } else { 1.0 }));
        }
        let tens = |x: f64, range: f64| 10.0_f64.powf((x - 0.5) * range);
        let length = tens(random(), 72.0);
        let delta = f64::from((length * tens(random(), 8.0)) as f32);
        if delta == 0.0 || !delta.is_finite() {
            return;
        }
        let soft = seed % 7 < 4;
        let shape = if soft { (COMPACT, delta) } else { (Mollifier::None, 0.0) };
        let (spread, size) = ((3.0 * random()) as u32, tens(random(), 70.0));
        let mut point = || {
            std::array::from_fn::<f32, D, _>(|_| {
                let near = if spread == 2 { 10.0_f64.powf(-12.0 * random()) } else { 1.0 };
                (length * (random() - 0.5) * near) as f32
            })
        };
        let positions: Vec<[f32; D]> = (0..6).map(|_| point()).collect();
        let targets = [positions[0], point(), point()];
        let masses: Vec<f32> = (0..6)
            .map(|_| (size * (0.5 + random()) * if spread > 0 { tens(random(), 20.0) } else { 1.0 }) as f32)
            .collect();
        let finite = |x: &f32| x.is_finite();
        if !(masses.iter().all(finite) && positions.as_flattened().iter().chain(targets.as_flattened()).all(finite)) {
            return;
        }
        let pairs = |x: &[f32; D]| {
            let offsets =
                positions.iter().map(|y| std::array::from_fn::<f64, D, _>(|d| f64::from(x[d]) - f64::from(y[d])));
            offsets.zip(masses.iter().map(|&m| f64::from(m))).collect::<Vec<_>>()
        };
        let (mut wants, mut scales) = ([[0.0; 5]; 3], [[0.0; 5]; 3]);
        let reference = with_kernel_if_any::<f64, D, _>(&terms, shape, |kernel| {
            for ((x, want), scale) in targets.iter().zip(&mut wants).zip(&mut scales) {
                for (d, m) in pairs(x) {
                    let r = d.iter().fold(0.0_f64, |r, x| r.hypot(*x));
                    if r == 0.0 && !soft {
                        continue;
                    }
                    let [u, g, l] = kernel.at(r);
                    let all = [m * u, m * l].into_iter().chain(d.iter().map(|d| m * g * d));
                    all.enumerate().for_each(|(k, v)| {
                        want[k] += v;
                        scale[k] += v.abs();
                    });
                    scale[0] += if D == 2 { m.abs() } else { 0.0 };
                    scale[1] += (m * D as f64 * g).abs();
                }
            }
        });
        if reference.is_none() {
            return;
        }
        let _ = with_kernel_if_any::<f32, D, _>(&terms, shape, |kernel| {
            let mut methods = vec![Method::Moments, Method::Sorted, Method::Neighbours, Method::Split];
            // Over pairs: what has no table and is not the Newtonian kernel alone.
            if !soft && terms.iter().any(|term| term.law != Law::Newtonian) {
                methods.push(Method::Direct);
            }
            for method in methods {
                let wanted = if method == Method::Neighbours { LAPLACIAN } else { ALL };
                let options = Options { method: Some(method), ..Options::default() };
                if field::plan(kernel, 6, 3, wanted, &options).is_err() {
                    continue;
                }
                let got = sums_of(kernel, (&positions, &masses, &targets), wanted, &options, Level::best());
                for (i, (want, scale)) in wants.iter().zip(&scales).enumerate() {
                    let got = [got.potential[i], got.laplacian[i]].into_iter().chain(got.gradient[i]);
                    for (k, got) in got.enumerate().filter(|(k, _)| *k == 1 || method != Method::Neighbours) {
                        if scale[k].is_nan() || scale[k] >= 3e38 || !want[k].is_finite() {
                            continue;
                        }
                        let bound = 3e-5 * scale[k] + 1e-42;
                        assert!(
                            (f64::from(got) - want[k]).abs() <= bound,
                            "{D}D seed {seed} {terms:?} {shape:?} {method:?} target {i} output {k}: {got:e} {:e} {:e} {positions:?} {masses:?} {targets:?}",
                            want[k],
                            scale[k]
                        );
                    }
                }
            }
        });
    }
    for seed in 0..150 {
        check::<1>(seed);
        check::<2>(seed);
        check::<3>(seed);
    }
}

/// Sorted sums are added up from either side, so that heavy sources elsewhere take no digits from them.
#[test]
fn light_sources_beside_heavy_ones_in_sorted_sums() {
    let newtonian = [term(Law::Newtonian, 1.0)];
    let none = (Mollifier::None, 0.0);
    let scene: (&[(f64, f64)], f64) = (&[(0.0, 2e30), (0.0, 1e20), (1.0, 1.0)], 0.0);
    assert_eq!(row::<f32, 1>(&newtonian, none, scene, (ALL, Method::Sorted)), [0.5, -0.5, 0.0]);
    let scene: (&[(f64, f64)], f64) = (&[(0.0, 1e60), (0.0, 1e30), (1.0, 1.0), (-1.0, 3.0)], 0.0);
    assert_eq!(row::<f64, 1>(&newtonian, none, scene, (ALL, Method::Sorted)), [2.0, 1.0, 0.0]);
    // More sources than are kept together, on either side of the heavy one.
    let mut sources: Vec<(f64, f64)> = (0..333).map(|k| (f64::from(k) - 100.0, 1.0)).collect();
    sources[100].1 = 1e30;
    for method in [Method::Sorted, Method::Direct] {
        let [u, g, _] = row::<f32, 1>(&newtonian, none, (&sources, 0.0), (ALL, method));
        assert_eq!(([u, g], method), ([0.5 * (5050.0 + 232.0 * 233.0 / 2.0), 0.5 * (100.0 - 232.0)], method));
    }
}

/// Stars of 2e30 kg beside bodies of 1 kg, in f32. Each class of masses is summed in its own units, and no pair takes the slow path. The
/// contribution of the light bodies to the star is not lost.
#[test]
fn masses_of_any_ratio_take_the_fast_path() {
    let (positions, _) = cloud::<f32, 2>(600, 3);
    let masses: Vec<f32> = (0..600).map(|k| if k % 3 == 0 { 2e30 } else { 1.0 + k as f32 }).collect();
    for level in Level::available() {
        let kernel = Kernel::<f32, 2>::newtonian(1.0, Mollifier::None, 0.0).unwrap();
        let got = sums_of(&kernel, (&positions, &masses, &positions), ALL, &Options::default(), level);
        assert_eq!(got.counters.scaled_pairs, 600, "{}: a target on its source alone", level.name());
        for (x, g) in positions.iter().zip(&got.gradient) {
            let (mut want, mut scale) = ([0.0; 2], 0.0);
            for (y, &m) in positions.iter().zip(&masses).filter(|(y, _)| *y != x) {
                let d = [f64::from(x[0]) - f64::from(y[0]), f64::from(x[1]) - f64::from(y[1])];
                let factor = f64::from(m) / (2.0 * std::f64::consts::PI * (d[0] * d[0] + d[1] * d[1]));
                want = [want[0] + factor * d[0], want[1] + factor * d[1]];
                scale += (factor * d[0]).abs().max((factor * d[1]).abs());
            }
            for k in 0..2 {
                assert!((f64::from(g[k]) - want[k]).abs() <= 300.0 * f64::from(f32::EPSILON) * scale);
            }
        }
    }
    // One star and light bodies: the gradient at the star comes from the light bodies alone.
    let masses: Vec<f32> = (0..600).map(|k| if k == 0 { 2e38 } else { 1e-3 }).collect();
    let kernel = Kernel::<f32, 2>::newtonian(1.0, Mollifier::None, 0.0).unwrap();
    let got = sums_of(&kernel, (&positions, &masses, &positions[..1]), ALL, &Options::default(), Level::best());
    let alone =
        sums_of(&kernel, (&positions[1..], &masses[1..], &positions[..1]), ALL, &Options::default(), Level::best());
    for k in 0..2 {
        let (got, want) = (got.gradient[0][k], alone.gradient[0][k]);
        assert!(want != 0.0 && (got - want).abs() <= 1e-4 * want.abs(), "{got} {want}");
    }
}

/// The largest |K|, |K'/r| and Laplacian (or D |K'/r|) at distances of a range.
fn sizes<const D: usize>(kernel: &Kernel<'_, f64, D>, from: f64, to: f64) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for k in 0..=24 {
        let [value, factor, laplacian] = kernel.at(from + (to - from) * f64::from(k) / 24.0).map(f64::abs);
        most = [most[0].max(value), most[1].max(factor), most[2].max(laplacian).max(D as f64 * factor)];
    }
    most
}

/// The bound that the header states for kernels in tables, at random parameters, on every level.
#[test]
fn single_pairs_of_random_kernels_are_within_the_bound() {
    fn check<T: Real, const D: usize>(split: &mut Split, law: Law, (mollifier, delta): (Mollifier, f64)) {
        let delta = T::from_f64(delta).to_f64();
        let terms = [term(law, 1.0)];
        let decays = matches!(law, Law::Exponential { .. } | Law::Screened { .. });
        let singular = mollifier == Mollifier::None;
        let distances: Vec<T> = (0..120)
            .map(|k| match k % 4 {
                0 => 0.05 * split.uniform(),
                1 => 2.0_f64.powf(12.0 * split.uniform() - 6.0),
                _ => split.uniform(),
            })
            .map(|ratio| T::from_f64(ratio * if singular { 1.0 } else { delta }))
            .collect();
        let (mut wants, mut scales) = (Vec::new(), Vec::new());
        with_kernel::<f64, D, _>(&terms, (mollifier, delta), |kernel| {
            for r in distances.iter().map(|r| r.to_f64()) {
                let [value, factor, laplacian] = kernel.at(r);
                wants.push([value, factor * r, laplacian]);
                let mut most = sizes(kernel, 0.5 * r, r);
                if !singular && (r < delta || decays && matches!(mollifier, Mollifier::Gaussian { .. })) {
                    most.iter_mut().zip(sizes(kernel, 0.0, delta)).for_each(|(most, s)| *most = most.max(s));
                }
                scales.push([most[0].max(r * r * most[1]), most[1] * r, most[2]]);
            }
        });
        let c = match (T::DIGITS > 24, decays && delta > 5.0) {
            (false, _) => [32.0; 3],
            (true, false) => [128.0, 128.0, 1000.0],
            (true, true) => [400.0, 400.0, 3000.0],
        };
        let options = Options { method: Some(Method::Direct), ..Options::default() };
        let targets: Vec<[T; D]> =
            distances.iter().map(|&r| std::array::from_fn(|k| if k == 0 { r } else { T::ZERO })).collect();
        with_kernel::<T, D, _>(&terms, (mollifier, delta), |kernel| {
            for level in Level::available() {
                let got = sums_of(kernel, (&[[T::ZERO; D]], &[T::ONE], &targets), ALL, &options, level);
                for (i, (want, scale)) in wants.iter().zip(&scales).enumerate() {
                    let got = [got.potential[i], got.gradient[i][0], got.laplacian[i]].map(T::to_f64);
                    for k in 0..3 {
                        let error = (got[k] - want[k]).abs() / (0.5 * T::EPSILON.to_f64());
                        let what =
                            format!("{D}D {law:?} {mollifier:?} {delta} r {:?} {k} {}", distances[i], level.name());
                        assert!(error <= c[k] * scale[k], "{what}: {} u s", error / scale[k]);
                    }
                }
            }
        });
    }
    fn random<T: Real, const D: usize>(count: usize) {
        let mut split = Split(D as u64 + u64::from(T::DIGITS));
        for _ in 0..count {
            let law = match (3.0 * split.uniform()) as u32 {
                0 => power(8.0 * split.uniform() + 1.05),
                1 => Law::Exponential { length: 1.0 },
                _ => Law::Screened { k: 1.0 },
            };
            let order = 2 * (1 + (4.0 * split.uniform()) as u32);
            let mollifier = match (6.0 * split.uniform()) as u32 {
                0 => Mollifier::Gaussian { order: order.min(6) },
                1 if !matches!(law, Law::Power { .. }) => Mollifier::None,
                _ => Mollifier::Compact { order, exponent: 2 + (8.0 * split.uniform()) as u32 },
            };
            let delta = 2.0_f64.powf(8.0 * split.uniform() - 4.0);
            // Not every order is there in every dimension, nor every exterior factor in the scalar's range.
            let Ok(bytes) = Kernel::<T, D>::workspace_bytes(&[term(law, 1.0)], mollifier) else { continue };
            let mut block = Aligned::new(bytes);
            if Kernel::<T, D>::prepare(block.bytes(), &[term(law, 1.0)], mollifier, T::from_f64(delta)).is_err() {
                continue;
            }
            check::<T, D>(&mut split, law, (mollifier, delta));
        }
    }
    let mut split = Split(9);
    let steepest = Mollifier::Compact { order: 8, exponent: 9 };
    check::<f64, 1>(&mut split, Law::Exponential { length: 4.382_391_825_094_345 }, (steepest, 3.516_648_530_960_083));
    check::<f64, 1>(&mut split, power(5.643_698_267_871_514), (steepest, 49.000_156_402_587_89));
    random::<f64, 1>(60);
    random::<f64, 2>(16);
    random::<f64, 3>(60);
    random::<f32, 1>(60);
    random::<f32, 2>(16);
    random::<f32, 3>(60);
}

/// A cluster that is tiny beside the coordinates of one particle: its pairs are too close for the first units, and are summed in lanes in closer ones.
#[test]
fn close_pairs_are_within_the_bound() {
    fn check<T: Real, const D: usize>(width: f64, mollifier: Mollifier, delta: f64) {
        let terms = [term(Law::Newtonian, 1.0)];
        let n = 150;
        let (mut positions, masses) = cloud::<T, D>(n, 11);
        positions.as_flattened_mut().iter_mut().for_each(|x| *x = T::from_f64(x.to_f64() * width));
        positions[7] = [T::ONE; D];
        // A coincident pair.
        positions[9] = positions[20];
        let delta = T::from_f64(delta * width).to_f64();
        let singular = mollifier == Mollifier::None;
        let least = 2.0_f64.powi(if T::DIGITS > 24 { -120 } else { -56 });
        let wide = positions.iter().map(|x| x.map(T::to_f64)).collect::<Vec<_>>();
        let c = if matches!(mollifier, Mollifier::Gaussian { .. }) { [128.0, 128.0, 1000.0] } else { [32.0; 3] };
        // r, K, g, Laplacian of each pair of a target.
        let (mut wants, mut scales, mut close) = (vec![[0.0; 5]; n], vec![[0.0; 5]; n], 0);
        with_kernel::<f64, D, _>(&terms, (mollifier, delta), |kernel| {
            let most = if singular { [0.0; 3] } else { kernel.at(0.0).map(f64::abs) };
            for ((want, scale), x) in wants.iter_mut().zip(&mut scales).zip(&wide) {
                for (y, m) in wide.iter().zip(&masses).filter(|(y, _)| !singular || *y != x) {
                    let d: [f64; D] = std::array::from_fn(|k| x[k] - y[k]);
                    let r2 = d.iter().map(|d| d * d).sum::<f64>();
                    close += u64::from(r2 < least);
                    let (m, [value, factor, laplacian]) = (m.to_f64(), kernel.at(r2.sqrt()));
                    want[3] += m * value;
                    scale[3] += m.abs() * (value.abs() + 1.0).max(most[0]);
                    want[4] += m * laplacian;
                    scale[4] += m.abs() * most[2].max(laplacian.abs());
                    for k in 0..D {
                        want[k] += m * factor * d[k];
                        scale[k] +=
                            m.abs() * factor.abs().max(if r2.sqrt() < delta { most[1] } else { 0.0 }) * d[k].abs();
                    }
                }
            }
        });
        with_kernel::<T, D, _>(&terms, (mollifier, delta), |kernel| {
            let options = Options { method: Some(Method::Direct), ..Options::default() };
            for level in Level::available() {
                let got = sums_of(kernel, (&positions, &masses, &positions), ALL, &options, level);
                let what = format!("{D}D {width} {mollifier:?} {delta} {} {}", level.name(), T::DIGITS);
                if least.sqrt() > 10.0 * width {
                    assert!(got.counters.scaled_pairs >= close && close > 20_000, "{what} {:?} {close}", got.counters);
                }
                for i in 0..n {
                    let mut all = [got.potential[i].to_f64(); 5];
                    all[4] = got.laplacian[i].to_f64();
                    all.iter_mut().zip(got.gradient[i]).for_each(|(to, g)| *to = g.to_f64());
                    for k in (0..D).chain(3..5) {
                        let bound = (c[match k {
                            3 => 0,
                            4 => 2,
                            _ => 1,
                        }] + 256.0)
                            * 0.5
                            * T::EPSILON.to_f64();
                        let error = (all[k] - wants[i][k]).abs();
                        assert!(
                            error <= bound * scales[i][k],
                            "{what} {i} {k}: {} {} {}",
                            all[k],
                            wants[i][k],
                            scales[i][k]
                        );
                    }
                }
            }
        });
    }
    fn shapes<T: Real, const D: usize>(widths: &[f64]) {
        for &width in widths {
            check::<T, D>(width, Mollifier::None, 0.0);
            check::<T, D>(width, COMPACT, 0.1);
            check::<T, D>(width, COMPACT, 1e-3);
            if D < 3 {
                check::<T, D>(width, Mollifier::Gaussian { order: 4 }, 0.1);
            }
        }
    }
    // Some pairs too close; all; some too close even in closer units.
    shapes::<f32, 1>(&[1e-8, 1e-10, 1e-17, 1e-26]);
    shapes::<f32, 2>(&[1e-8, 1e-10, 1e-15]);
    shapes::<f32, 3>(&[1e-8, 4e-9]);
    shapes::<f64, 1>(&[1e-18, 1e-25, 1e-36, 1e-55]);
    shapes::<f64, 2>(&[1e-18, 1e-25, 1e-36]);
    shapes::<f64, 3>(&[1e-18, 1e-25, 1e-36]);
}

#[test]
fn outputs_do_not_change_each_others_bits() {
    fn check<T: Real, const D: usize>(terms: &[Term], shape: (Mollifier, f64)) {
        let (positions, masses) = cloud::<T, D>(300, 7);
        let options = Options { method: Some(Method::Direct), ..Options::default() };
        with_kernel::<T, D, _>(terms, shape, |kernel| {
            for level in Level::available() {
                let run = |wanted| sums_of(kernel, (&positions, &masses, &positions[..70]), wanted, &options, level);
                let all = run(ALL);
                for which in 1..7 {
                    let wanted = Wanted {
                        potential: which & 1 > 0,
                        gradient: which & 2 > 0,
                        laplacian: which & 4 > 0,
                        hessian: false,
                    };
                    let some = run(wanted);
                    let what = format!("{D}D {terms:?} {shape:?} {} {wanted:?}", level.name());
                    assert!(!wanted.potential || bits(&some.potential) == bits(&all.potential), "{what}");
                    assert!(!wanted.laplacian || bits(&some.laplacian) == bits(&all.laplacian), "{what}");
                    let (some, all) = (some.gradient.as_flattened(), all.gradient.as_flattened());
                    assert!(!wanted.gradient || bits(some) == bits(all), "{what}");
                }
            }
        });
    }
    fn bits<T: Real>(numbers: &[T]) -> Vec<u64> {
        numbers.iter().map(|x| x.bits()).collect()
    }
    let newtonian = [term(Law::Newtonian, -1.0)];
    for shape in
        [(Mollifier::None, 0.0), (COMPACT, 0.3), (COMPACT, 4.0), (Mollifier::Compact { order: 4, exponent: 3 }, 1.0)]
    {
        check::<f64, 1>(&newtonian, shape);
        check::<f64, 2>(&newtonian, shape);
        check::<f64, 3>(&newtonian, shape);
        check::<f32, 2>(&newtonian, shape);
        check::<f32, 3>(&newtonian, shape);
        check::<f64, 2>(&[term(power(-0.5), 1.0), term(Law::Screened { k: 2.0 }, -1.0)], shape);
        check::<f32, 3>(&[term(Law::Exponential { length: 0.7 }, 1.0)], shape);
    }
    check::<f64, 2>(&newtonian, (Mollifier::Gaussian { order: 4 }, 0.1));
    check::<f32, 1>(&newtonian, (Mollifier::Gaussian { order: 6 }, 0.1));
}

/// The bound of blocked and of compensated sums where no pair is in a table's range or in that of the lanes: many pairs that are computed one by one
/// are summed as well as others.
#[test]
fn pairs_one_by_one_are_summed_as_well() {
    fn check<T: Real, const D: usize>(law: Law, shape: (Mollifier, f64), r: f64, c: f64) {
        let (r, delta, mass) = (T::from_f64(r), T::from_f64(shape.1), T::from_f64(0.1));
        let n = 200_000;
        let (positions, masses) = (vec![[T::ZERO; D]; n], vec![mass; n]);
        let mut target = [T::ZERO; D];
        target[0] = r;
        let terms = [term(law, 1.0)];
        let [value, factor, _] =
            with_kernel::<f64, D, _>(&terms, (shape.0, delta.to_f64()), |kernel| kernel.at(r.to_f64()));
        let u = T::EPSILON.to_f64() / 2.0;
        with_kernel::<T, D, _>(&terms, shape, |kernel| {
            for accumulation in [Accumulation::Blocked, Accumulation::Compensated] {
                let options = Options { method: Some(Method::Direct), accumulation, ..Options::default() };
                let wanted = Wanted { laplacian: false, ..ALL };
                let got = sums_of(kernel, (&positions, &masses, &[target]), wanted, &options, Level::best());
                let bound = match accumulation {
                    Accumulation::Blocked => c + 256.0 + n as f64 / 256.0,
                    _ => c + 12.0 + n as f64 / 4.0 * u,
                };
                let total = n as f64 * mass.to_f64();
                for (got, want) in [(got.potential[0], value), (got.gradient[0][0], factor * r.to_f64())] {
                    let error = (got.to_f64() / (total * want) - 1.0).abs() / u;
                    assert!(error <= bound, "{D}D {law:?} {shape:?} {accumulation:?}: {error} u, {bound} are stated");
                }
            }
        });
    }
    let none = (Mollifier::None, 0.0);
    let rough = Mollifier::Compact { order: 2, exponent: 1 };
    check::<f32, 1>(Law::Exponential { length: 1.0 }, none, 0.01, 32.0);
    check::<f32, 2>(Law::Screened { k: 1.0 }, none, 1e-5, 32.0);
    check::<f64, 1>(Law::Exponential { length: 1.0 }, none, 1e-7, 128.0);
    check::<f64, 3>(Law::Screened { k: 1.0 }, none, 1e-7, 128.0);
    check::<f32, 1>(power(7.0), none, 1e-3, 32.0);
    // Beyond the table's end, and in the gap at a rough edge.
    check::<f32, 2>(power(1.5), (COMPACT, 1e-6), 0.3, 32.0);
    check::<f32, 2>(power(0.5), (rough, 1.0), 0.999, 32.0);
    check::<f32, 2>(power(-0.5), (rough, 1.0), 1.002, 32.0);
}

/// The bound of Laplacians of Newtonian kernels, relative to the mollifier's largest value, for every compact mollifier.
#[test]
fn laplacians_of_every_mollifier() {
    fn check<const D: usize>() {
        let mut split = Split(D as u64 + 20);
        for order in [2, 4, 6, 8] {
            let c = [16.0, 112.0, 250.0, 2000.0][order as usize / 2 - 1];
            for exponent in 1..=9 {
                let mollifier = Mollifier::Compact { order, exponent };
                let profile = mollis_reference::mollifier::Compact::new(D as u32, order, exponent);
                for _ in 0..40 {
                    let delta = 2.0_f32.powf(2.0 * split.uniform() as f32 - 1.0);
                    let Ok(kernel) = Kernel::<f32, D>::newtonian(1.0, mollifier, delta) else { return };
                    let targets: Vec<[f32; D]> = (0..64)
                        .map(|_| {
                            let mut x = [0.0; D];
                            x[0] = delta * split.uniform() as f32 * if split.uniform() < 0.5 { 0.1 } else { 1.0 };
                            x
                        })
                        .collect();
                    let options = Options { method: Some(Method::Direct), ..Options::default() };
                    let scene = (&[[0.0; D]][..], &[1.0_f32][..], &targets[..]);
                    let got = sums_of(&kernel, scene, LAPLACIAN, &options, Level::best());
                    let per = f64::from(delta).powi(-(D as i32));
                    for (x, got) in targets.iter().zip(&got.laplacian) {
                        let want = per * profile.density(f64::from(x[0]) / f64::from(delta));
                        let error = (f64::from(*got) - want).abs() / (per * profile.density(0.0)) * 2.0_f64.powi(24);
                        assert!(error <= c, "{D}D order {order} M {exponent} delta {delta} {x:?}: {error} u");
                    }
                }
            }
        }
    }
    check::<1>();
    check::<2>();
    check::<3>();
}

/// Compensated sums by sorting, with every mollifier: potentials and gradients within 1.5 c + 12, with the header's c.
#[test]
fn sorted_sums_of_every_mollifier() {
    let (x, m) = cloud::<f32, 1>(60, 11);
    let wide: (Vec<_>, Vec<_>) =
        (x.iter().map(|x| x.map(f64::from)).collect(), m.iter().map(|&m| f64::from(m)).collect());
    let newtonian = [term(Law::Newtonian, 1.0)];
    let wanted = Wanted { laplacian: false, ..ALL };
    let compensated =
        Options { accumulation: Accumulation::Compensated, method: Some(Method::Sorted), ..Options::default() };
    let u = 0.5 * f64::from(f32::EPSILON);
    for order in [2, 4, 6, 8] {
        for exponent in 1..=9 {
            let shape = (Mollifier::Compact { order, exponent }, 0.5);
            let got = with_kernel::<f32, 1, _>(&newtonian, shape, |kernel| {
                sums_of(kernel, (&x, &m, &x), wanted, &compensated, Level::best())
            });
            with_kernel::<f64, 1, _>(&newtonian, shape, |kernel| {
                let c = if order > 4 { 112.0 } else { 16.0 };
                for (i, at) in wide.0.iter().enumerate() {
                    let (mut sums, mut sizes) = ([0.0; 2], [0.0; 2]);
                    for (y, m) in wide.0.iter().zip(&wide.1) {
                        let d = at[0] - y[0];
                        for (k, value) in
                            [kernel.value(d.abs()), kernel.gradient_factor(d.abs()) * d].into_iter().enumerate()
                        {
                            sums[k] += m * value;
                            sizes[k] += (m * value).abs();
                        }
                    }
                    for (k, got) in [got.potential[i], got.gradient[i][0]].into_iter().enumerate() {
                        let error = (f64::from(got) - sums[k]).abs() / (u * sizes[k]);
                        assert!(error <= 1.5 * c + 12.0, "order {order} M {exponent}, output {k}: {error}");
                    }
                }
            });
        }
    }
}
