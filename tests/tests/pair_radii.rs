//! Core radii of pairs, made of the source's and the target's: against sums of single pairs, between particles, and by the fast multipole method.

use mollis_abi::*;
use mollis_core::exec::{Run, Serial};
use mollis_core::field::{self, Accumulation, Interaction, Method, Options, Outputs, PairRadius, Sources, Wanted};
use mollis_core::kernel::{Law, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::simd::Level;
use mollis_core::{Error, Real, Result};
use mollis_tests::Aligned;
use mollis_tests::sums::Sum;

use crate::field_bounds::{COMPACT, with_kernel};
use crate::softenings::{mollifiers, random, twin};

const RULES: [PairRadius; 3] = [PairRadius::Maximum, PairRadius::Mean, PairRadius::RootMeanSquare];
const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };

fn of(rule: PairRadius, a: f64, b: f64) -> f64 {
    match rule {
        PairRadius::Source => a,
        PairRadius::Maximum => a.max(b),
        PairRadius::Mean => 0.5 * (a + b),
        PairRadius::RootMeanSquare => (0.5 * (a * a + b * b)).sqrt(),
    }
}

/// One call's results.
struct Sums<T, const D: usize> {
    potential: Vec<T>,
    gradient: Vec<[T; D]>,
    laplacian: Vec<T>,
}

fn run<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    (sources, targets): (Sources<'_, T, D>, &[[T; D]]),
    options: &Options,
    level: Level,
) -> Result<Sums<T, D>> {
    let n = targets.len();
    let plan = field::plan(kernel, sources.positions.len(), n, ALL, options)?;
    let mut memory = Aligned::new(plan.workspace_bytes(1)?);
    let mut sums = Sums { potential: vec![T::NAN; n], gradient: vec![[T::NAN; D]; n], laplacian: vec![T::NAN; n] };
    let outputs = Outputs {
        potential: Some(&mut sums.potential),
        gradient: Some(&mut sums.gradient),
        laplacian: Some(&mut sums.laplacian),
        hessian: None,
    };
    let mut run = Run { level, executor: &Serial, ..Run::default() };
    field::evaluate(&plan, kernel, sources, targets, outputs, memory.bytes(), &mut run)?;
    Ok(sums)
}

/// Radii that are alike, or from far below to far above the spacing, some beyond the range of lanes.
fn radius<T: Real>(wild: bool, number: f64) -> T {
    T::from_f64(if wild { 10.0_f64.powf(14.0 * number - 12.0) } else { 0.1 + 0.2 * number })
}

fn against_pairs<T: Real, const D: usize>() {
    let u = 0.5 * T::EPSILON.to_f64();
    for mollifier in mollifiers(D) {
        for (seed, n) in [1, 9, 140].into_iter().enumerate() {
            for wild in [false, true] {
                let mut next = random(77 + seed as u64);
                let x: Vec<[T; D]> = (0..n).map(|_| std::array::from_fn(|_| T::from_f64(2.0 * next() - 1.0))).collect();
                let masses: Vec<T> = (0..n).map(|_| T::from_f64(next() - 0.3)).collect();
                let radii: Vec<T> = (0..n).map(|_| radius(wild, next())).collect();
                let mut targets: Vec<[T; D]> = x.iter().take(12).copied().collect();
                targets.extend(x.iter().take(5).map(|x| x.map(|c| c + T::from_f64(1e-9) * c)));
                let of_targets: Vec<T> = targets.iter().map(|_| radius(wild, next())).collect();
                let sources = Sources::new(&x, &masses).with_radii(&radii).with_target_radii(&of_targets);
                let table = matches!(mollifier, Mollifier::Gaussian { .. } | Mollifier::Richardson { .. });
                let c = if table && u < 1e-10 { 1000.0 } else { 96.0 };
                with_kernel::<T, D, _>(
                    &[Term { law: Law::Newtonian, coefficient: -1.5 }],
                    (mollifier, 0.25),
                    |kernel| {
                        for rule in RULES {
                            let wants: Vec<_> = targets
                                .iter()
                                .zip(&of_targets)
                                .map(|(target, b)| {
                                    let pairs: Vec<_> = (0..n)
                                        .map(|j| {
                                            let radius = of(rule, radii[j].to_f64(), b.to_f64());
                                            (x[j].map(T::to_f64), -1.5 * masses[j].to_f64(), radius)
                                        })
                                        .collect();
                                    twin(mollifier, &target.map(T::to_f64), &pairs)
                                })
                                .collect();
                            let accumulation = Accumulation::Compensated;
                            let options =
                                Options { radii: true, pair_radius: rule, accumulation, ..Options::default() };
                            for level in Level::available() {
                                let got = run(kernel, (sources, &targets), &options, level).unwrap();
                                for (i, want) in wants.iter().enumerate() {
                                    let what = format!("{mollifier:?} {D}D n {n} {wild} {rule:?} {level:?} target {i}");
                                    let check = |got: T, [want, scale]: [f64; 2], which: &str| {
                                        let (error, scale) = ((got.to_f64() - want).abs(), u * scale);
                                        let bound = c * scale + T::MIN_POSITIVE.to_f64();
                                        assert!(
                                            error <= bound,
                                            "{what}: {which} {got:?} {want:e}, {} u S",
                                            error / scale
                                        );
                                    };
                                    check(got.potential[i], want.potential, "potential");
                                    let size = want.gradient[1].iter().sum();
                                    for (&got, &want) in got.gradient[i].iter().zip(&want.gradient[0]) {
                                        check(got, [want, size], "gradient");
                                    }
                                    if !table {
                                        check(got.laplacian[i], want.laplacian, "laplacian");
                                    }
                                }
                            }
                        }
                    },
                );
            }
        }
    }
}

#[test]
fn against_single_pairs() {
    against_pairs::<f64, 1>();
    against_pairs::<f64, 2>();
    against_pairs::<f64, 3>();
    against_pairs::<f32, 2>();
    against_pairs::<f32, 3>();
}

/// Forces between particles are equal and opposite, which they are not where the source's radius counts; targets that are the sources have the sources' radii.
#[test]
fn forces_add_up_to_zero() {
    fn check<const D: usize>(mollifier: Mollifier) {
        let mut next = random(5);
        let n = 300;
        let x: Vec<[f64; D]> = (0..n).map(|_| std::array::from_fn(|_| next())).collect();
        let masses: Vec<f64> = (0..n).map(|_| next()).collect();
        let radii: Vec<f64> = (0..n).map(|_| 0.05 + 0.5 * next()).collect();
        let sources = Sources::new(&x, &masses).with_radii(&radii);
        with_kernel::<f64, D, _>(&[Term { law: Law::Newtonian, coefficient: 1.0 }], (mollifier, 0.25), |kernel| {
            let force = |pair_radius| {
                let options = Options { radii: true, pair_radius, ..Options::default() };
                let sums = run(kernel, (sources, &x), &options, Level::best()).unwrap();
                let total = |k: usize| -> f64 { sums.gradient.iter().zip(&masses).map(|(g, m)| g[k] * m).sum() };
                (0..D).map(|k| total(k).abs()).fold(0.0, f64::max)
            };
            for rule in RULES {
                assert!(force(rule) < 1e-9, "{D}D {mollifier:?} {rule:?}: {}", force(rule));
            }
            assert!(D == 1 || force(PairRadius::Source) > 1e-3, "{D}D {mollifier:?}: {}", force(PairRadius::Source));
        });
    }
    for mollifier in [COMPACT, Mollifier::Plummer, Mollifier::Gaussian { order: 2 }] {
        check::<1>(mollifier);
        check::<2>(mollifier);
        check::<3>(mollifier);
    }
}

/// The support of a pair may be that of the target: with targets that are the sources, that are others, and that are the sources with other radii.
#[test]
fn by_the_fast_multipole_method() {
    let n = 4000;
    let mut next = random(11);
    let x: Vec<[f64; 2]> = (0..n).map(|_| [next(), next()]).collect();
    let masses: Vec<f64> = (0..n).map(|_| next() - 0.4).collect();
    let mut radii = |large: usize| -> Vec<f64> {
        (0..n).map(|k| if k % 500 == large { 0.3 } else { 1e-3 * (1.0 + next()) }).collect()
    };
    let (small, other) = (radii(7), radii(3));
    let others: Vec<[f64; 2]> = x.iter().map(|x| [x[1], x[0]]).collect();
    let blob = Blob::<f64, 2>::new(COMPACT, 1.0).unwrap();
    for rule in RULES {
        for (targets, of_targets) in [(&x, &small), (&x, &other), (&others, &other)] {
            let sources = Sources::new(&x, &masses).with_radii(&small).with_target_radii(of_targets);
            let sum = |method| {
                let tolerance = 1e-9;
                let options =
                    Options { method: Some(method), tolerance, radii: true, pair_radius: rule, ..Options::default() };
                run(&blob, (sources, targets), &options, Level::best()).unwrap()
            };
            let (fast, direct) = (sum(Method::Fmm), sum(Method::Direct));
            let difference = |a: &[f64], b: &[f64]| {
                let square = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>();
                (square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut b.iter().copied())).sqrt()
            };
            let errors = [
                difference(&fast.potential, &direct.potential),
                difference(fast.gradient.as_flattened(), direct.gradient.as_flattened()),
                difference(&fast.laplacian, &direct.laplacian),
            ];
            assert!(errors.iter().all(|&error| error < 4e-9), "{rule:?} {errors:?}");
        }
    }
}

#[test]
fn refusals() {
    let (x, masses, radii) = ([[0.0, 0.0], [1.0, 0.5]], [1.0, 2.0], [0.5, 0.25]);
    let targets = [[0.5, 0.5]];
    let blob = Blob::<f64, 2>::new(COMPACT, 1.0).unwrap();
    let rule = Options { radii: true, pair_radius: PairRadius::Mean, ..Options::default() };
    let sources = Sources::new(&x, &masses).with_radii(&radii);
    let result = |sources, targets: &[[f64; 2]], options| run(&blob, (sources, targets), options, Level::best()).err();
    assert_eq!(result(sources, &targets, &rule), Some(Error::LengthMismatch));
    assert_eq!(result(sources.with_target_radii(&radii), &targets, &rule), Some(Error::LengthMismatch));
    assert_eq!(result(sources.with_target_radii(&[0.0]), &targets, &rule), Some(Error::Delta));
    assert_eq!(result(sources.with_target_radii(&[f64::NAN]), &targets, &rule), Some(Error::NotFinite));
    assert_eq!(result(sources.with_target_radii(&[0.5]), &targets, &rule), None);
    assert_eq!(result(sources, &x, &rule), None);
    // Without a rule the targets' radii are not looked at.
    let plain = Options { radii: true, ..Options::default() };
    assert_eq!(result(sources.with_target_radii(&[-1.0]), &targets, &plain), None);
    let none = Options { radii: false, ..rule };
    assert_eq!(result(Sources::new(&x, &masses), &x, &none), Some(Error::Unsupported));
}

/// The options and structures of the C ABI, with radii among other members.
#[test]
#[expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#[expect(clippy::undocumented_unsafe_blocks, reason = "each call passes buffers of the stated sizes")]
fn in_c() {
    use std::ptr::{null, null_mut};
    let (x, masses, radii) = ([[0.0, 0.0], [1.0, 0.5], [0.2, 0.1]], [1.0, 2.0, -0.5], [0.5, 0.25, 0.4]);
    let targets = [[0.3, 0.2], [0.9, 0.6]];
    let of_targets = [0.1, -7.0, 0.6, -7.0];
    let term = mollis_kernel_term { kind: MOLLIS_KERNEL_NEWTONIAN, reserved: 0, coefficient: 1.0, parameter: [0.0; 2] };
    let mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_COMPACT, order: 2, exponent: 4 };
    let mut bytes = 0;
    unsafe {
        assert_eq!(mollis_kernel2_bytes(&raw const term, 1, null(), mollifier, &raw mut bytes), 0);
        let mut block = Aligned::new(bytes);
        assert_eq!(mollis_kernel2_prepare(block.pointer(), bytes, &raw const term, 1, null(), mollifier, 1.0), 0);
        let mut gradient = [[0.0; 2]; 3];
        let mut sum = |rule: i32, at_sources: bool, with_radii: bool| {
            let (n, places) = if at_sources { (3, x.as_ptr()) } else { (2, targets.as_ptr()) };
            let out = (null_mut(), gradient.as_mut_ptr(), null_mut());
            let mut sum = Sum::new((3, x.as_ptr(), masses.as_ptr()), (n, places), out);
            sum.sources.radii = radii.as_ptr();
            if with_radii {
                (sum.targets.radii, sum.targets.radius_stride) = (of_targets.as_ptr(), 2);
            }
            let to = if at_sources { null() } else { sum.targets() };
            let mut options = std::mem::MaybeUninit::<mollis_field_options>::uninit();
            assert_eq!(mollis_field_options_init(options.as_mut_ptr(), size_of::<mollis_field_options>()), 0);
            let options = mollis_field_options { pair_radius: rule, ..options.assume_init() };
            let (kernel, options) = (block.pointer().cast_const(), &raw const options);
            let mut needed = 0;
            let (sources, outputs) = (sum.sources(), sum.outputs());
            let sized =
                mollis_field2_workspace_bytes(kernel, bytes, sources, to, outputs, options, null(), &raw mut needed);
            if sized != 0 {
                return Err(sized);
            }
            let mut space = Aligned::new(needed);
            let code = mollis_field2_eval(
                kernel,
                bytes,
                sources,
                to,
                outputs,
                options,
                null(),
                space.pointer(),
                needed,
                null_mut(),
            );
            if code == 0 { Ok(gradient) } else { Err(code) }
        };
        for (number, rule) in [PairRadius::Source, RULES[0], RULES[1], RULES[2]].into_iter().enumerate() {
            let blob = Blob::<f64, 2>::new(COMPACT, 1.0).unwrap();
            let options = Options { radii: true, pair_radius: rule, ..Options::default() };
            let sources = Sources::new(&x, &masses).with_radii(&radii);
            let own = run(&blob, (sources, &x), &options, Level::best()).unwrap();
            assert_eq!(sum(number as i32, true, false), Ok([own.gradient[0], own.gradient[1], own.gradient[2]]));
            let others =
                run(&blob, (sources.with_target_radii(&[0.1, 0.6]), &targets), &options, Level::best()).unwrap();
            assert_eq!(sum(number as i32, false, true).unwrap()[..2], others.gradient[..]);
        }
        assert_eq!(sum(4, true, false), Err(Error::UnknownValue as i32));
        assert_eq!(sum(1, false, false), Err(Error::LengthMismatch as i32));
    }
}
