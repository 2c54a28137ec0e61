//! Second derivatives of sums: against matrices that are added up pair by pair, against differences of the gradient, and what they have to do with the other outputs.

use mollis_core::exec::{Executor, Run, Serial, Statistics};
use mollis_core::field::{self, Accumulation, Interaction, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Law, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::{Aligned, Split, Threads};

use crate::field_bounds::{COMPACT, power, term, with_kernel};

const HESSIAN: Wanted = Wanted { potential: false, gradient: false, laplacian: false, hessian: true };
pub(crate) const ALL: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: true };

/// One call's results.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sums<T, const D: usize> {
    pub(crate) potential: Vec<T>,
    pub(crate) gradient: Vec<[T; D]>,
    pub(crate) laplacian: Vec<T>,
    pub(crate) hessian: Vec<[[T; D]; D]>,
    pub(crate) counters: Statistics,
}

pub(crate) fn run<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    (sources, targets): (Sources<'_, T, D>, &[[T; D]]),
    wanted: Wanted,
    options: &Options,
    (level, executor): (Level, &dyn Executor),
) -> Sums<T, D> {
    let n = targets.len();
    let options = Options { radii: sources.radii.is_some(), ..*options };
    let plan = field::plan(kernel, sources.positions.len(), n, wanted, &options).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(executor.workers()).unwrap());
    let mut sums = Sums {
        potential: vec![T::NAN; n],
        gradient: vec![[T::NAN; D]; n],
        laplacian: vec![T::NAN; n],
        hessian: vec![[[T::NAN; D]; D]; n],
        counters: Statistics::default(),
    };
    let outputs = Outputs {
        potential: wanted.potential.then_some(&mut sums.potential[..]),
        gradient: wanted.gradient.then_some(&mut sums.gradient[..]),
        laplacian: wanted.laplacian.then_some(&mut sums.laplacian[..]),
        hessian: wanted.hessian.then_some(&mut sums.hessian[..]),
    };
    let mut run = Run { level, executor, counters: Some(&mut sums.counters), ..Run::default() };
    field::evaluate(&plan, kernel, sources, targets, outputs, memory.bytes(), &mut run).unwrap();
    sums
}

/// Points of a cloud, of which some are close together, and masses of both signs.
fn cloud<T: Real, const D: usize>(n: usize) -> (Vec<[T; D]>, Vec<T>) {
    let mut numbers = Split(n as u64 + 7);
    let mut x: Vec<[f64; D]> = (0..n).map(|_| std::array::from_fn(|_| 2.0 * numbers.uniform() - 1.0)).collect();
    for k in (4..n).step_by(5) {
        let near = x[k - 1].map(|c| c + 1e-3 * numbers.uniform());
        x[k] = near;
    }
    let masses = (0..n).map(|_| T::from_f64(numbers.uniform() - 0.3)).collect();
    (x.into_iter().map(|x| x.map(T::from_f64)).collect(), masses)
}

/// A matrix of each pair, and what errors are measured by.
type Pair<'a, const D: usize> = dyn Fn(&[f64; D], usize) -> ([[f64; D]; D], f64) + 'a;

/// The sums of pairs at each target, and what their errors are measured by.
fn sums<T: Real, const D: usize>(
    (targets, positions, masses): (&[[T; D]], &[[T; D]], &[T]),
    pair: &Pair<'_, D>,
) -> Vec<([[f64; D]; D], f64)> {
    let of = |x: &[T; D]| {
        let (mut want, mut scale) = ([[0.0; D]; D], 0.0);
        for (j, (y, m)) in positions.iter().zip(masses).enumerate() {
            let d = std::array::from_fn(|k| x[k].to_f64() - y[k].to_f64());
            let (matrix, size) = pair(&d, j);
            for (to, of) in want.as_flattened_mut().iter_mut().zip(matrix.as_flattened()) {
                *to += m.to_f64() * of;
            }
            scale += m.to_f64().abs() * size;
        }
        (want, scale)
    };
    targets.iter().map(of).collect()
}

/// Whether matrices are within (c + 256) u S of these sums, and symmetric.
fn compare<T: Real, const D: usize>(got: &[[[T; D]; D]], wants: &[([[f64; D]; D], f64)], c: f64, what: &str) {
    let u = 0.5 * T::EPSILON.to_f64();
    for (i, (got, (want, scale))) in got.iter().zip(wants).enumerate() {
        for k in 0..D {
            for l in 0..D {
                let (error, bound) = ((got[k][l].to_f64() - want[k][l]).abs(), (c + 256.0) * u * scale);
                assert!(
                    error <= bound + T::MIN_POSITIVE.to_f64(),
                    "{what} target {i} [{k}][{l}]: {:?} {:e}, {} u S",
                    got[k][l],
                    want[k][l],
                    error / (u * scale)
                );
                assert_eq!(got[k][l].bits(), got[l][k].bits(), "{what} target {i}");
            }
        }
    }
}

fn newtonian<T: Real, const D: usize>() {
    let mut mollifiers = vec![
        Mollifier::None,
        COMPACT,
        Mollifier::Compact { order: 4, exponent: 2 },
        Mollifier::Richardson { order: 4, exponent: 4 },
        Mollifier::Gaussian { order: 2 },
        Mollifier::Gaussian { order: 4 },
        Mollifier::Plummer,
        Mollifier::Algebraic,
    ];
    if D == 2 {
        mollifiers.push(Mollifier::Vatistas);
    }
    for mollifier in mollifiers {
        for n in [0, 1, 9, 130] {
            // One delta; one that is large, and tiny; core radii that are alike, and from far below to far above the spacing.
            for radii in 0..5 {
                let mut numbers = Split(n as u64 + 31 * radii);
                let (x, masses) = cloud::<T, D>(n);
                let delta = [0.25, 5.0, 1e-11, 0.25, 0.25][radii as usize];
                let radius: Vec<T> = (0..n)
                    .map(|_| match radii {
                        3 => T::from_f64(0.1 + 0.1 * numbers.uniform()),
                        4 => T::from_f64(10.0_f64.powf(14.0 * numbers.uniform() - 12.0)),
                        _ => T::from_f64(delta),
                    })
                    .collect();
                if radii > 0 && mollifier == Mollifier::None {
                    continue;
                }
                let mut targets: Vec<[T; D]> = x.iter().take(12).copied().collect();
                targets.extend(x.iter().take(5).map(|x| x.map(|c| c + T::from_f64(1e-9) * c)));
                with_kernel::<T, D, _>(&[term(Law::Newtonian, -1.5)], (mollifier, delta), |kernel| {
                    let sources = Sources::new(&x, &masses);
                    let sources = if radii < 3 { sources } else { sources.with_radii(&radius) };
                    let table = matches!(mollifier, Mollifier::Gaussian { .. } | Mollifier::Richardson { .. })
                        && T::DIGITS > 24;
                    let blobs: Vec<_> =
                        radius.iter().map(|r| Blob::<f64, D>::new(mollifier, r.to_f64()).unwrap()).collect();
                    let pair = |d: &[f64; D], j: usize| {
                        let r = d.iter().map(|d| d * d).sum::<f64>().sqrt();
                        if mollifier == Mollifier::None && r == 0.0 {
                            return ([[0.0; D]; D], 0.0);
                        }
                        let (blob, matrix) = (&blobs[j], blobs[j].hessian_at(d));
                        let most = if mollifier == Mollifier::None { 0.0 } else { blob.density(0.0).abs() };
                        let reach = if mollifier.is_compact() { 1.0 } else { 6.0 };
                        let density = if r < reach * blob.delta() { most } else { 0.0 };
                        let size = D as f64 * blob.gradient_factor(r).abs() + blob.density(r).abs() + density;
                        (matrix.map(|row| row.map(|h| -1.5 * h)), 1.5 * size)
                    };
                    let wants = sums((&targets, &x, &masses), &pair);
                    for level in Level::available() {
                        let got = run(kernel, (sources, &targets), HESSIAN, &Options::default(), (level, &Serial));
                        let what = format!("{mollifier:?} {D}D n {n} radii {radii} {level:?}");
                        let c = if table { 1500.0 } else { 128.0 };
                        compare(&got.hessian, &wants, c, &what);
                    }
                });
            }
        }
    }
}

#[test]
fn newtonian_kernels() {
    newtonian::<f64, 1>();
    newtonian::<f64, 2>();
    newtonian::<f64, 3>();
    newtonian::<f32, 2>();
    newtonian::<f32, 3>();
}

/// K, K'/r and the Laplacian at distances from 0 to r/2 and r: what tables' errors are measured by.
fn size<const D: usize>(kernel: &dyn Interaction<f64, D>, r: f64) -> f64 {
    [1.0, 0.8, 0.65, 0.5].into_iter().fold(0.0, |most: f64, part| {
        let [_, g, l] = kernel.pair(part * r, Wanted { gradient: true, laplacian: true, ..Wanted::default() });
        most.max(2.0 * D as f64 * g.abs() + l.abs())
    })
}

/// g I + (L - D g) x x^T / r^2, from the kernel's own functions.
fn matrix<const D: usize>(kernel: &dyn Interaction<f64, D>, d: &[f64; D]) -> ([[f64; D]; D], f64) {
    let r = d.iter().map(|d| d * d).sum::<f64>().sqrt();
    if r == 0.0 && kernel.is_singular() {
        return ([[0.0; D]; D], 0.0);
    }
    let [_, g, l] = kernel.pair(r, Wanted { gradient: true, laplacian: true, ..Wanted::default() });
    let (isotropic, along) = if r > 0.0 { (g, l - D as f64 * g) } else { (l / D as f64, 0.0) };
    let unit = d.map(|d| if r > 0.0 { d / r } else { 0.0 });
    let at = |k: usize, j: usize| if k == j { isotropic } else { 0.0 } + along * unit[k] * unit[j];
    (
        std::array::from_fn(|k| std::array::from_fn(|j| at(k, j))),
        size(kernel, r) + size(kernel, 0.1 * r).min(size(kernel, r)),
    )
}

/// A kernel of the host's without a table: its functions are called for each pair.
struct Host;

impl<T: Real, const D: usize> Interaction<T, D> for Host {
    fn value(&self, r: T) -> T {
        T::from_f64(r.to_f64().powi(3).exp_m1())
    }
    fn gradient_factor(&self, r: T) -> T {
        let r = r.to_f64();
        T::from_f64(3.0 * r * r.powi(3).exp())
    }
    fn laplacian(&self, r: T) -> T {
        let r = r.to_f64();
        T::from_f64(((D as f64 - 1.0) * 3.0 * r + 6.0 * r + 9.0 * r.powi(4)) * r.powi(3).exp())
    }
    fn is_singular(&self) -> bool {
        false
    }
}

fn others<T: Real, const D: usize>() {
    let exponential = Law::Exponential { length: 0.7 };
    let kernels: [&[Term]; 6] = [
        &[term(power(1.5), 2.0)],
        &[term(power(4.0), 1.0), term(Law::Newtonian, -2.0)],
        &[term(power(0.0), 1.0)],
        &[term(exponential, 1.0)],
        &[term(Law::Screened { k: 2.0 }, 1.0)],
        &[term(Law::Newtonian, 1.0), term(exponential, -2.0)],
    ];
    for n in [0, 1, 9, 70] {
        let (x, masses) = cloud::<T, D>(n);
        let (sources, targets) = (Sources::new(&x, &masses), &x[..n.min(12)]);
        for terms in kernels {
            for (mollifier, delta) in [(Mollifier::None, 0.0), (COMPACT, 0.4), (Mollifier::Gaussian { order: 2 }, 0.2)]
            {
                if D == 1 && terms.iter().any(|term| term.law == power(0.0)) {
                    continue;
                }
                with_kernel::<T, D, _>(terms, (mollifier, delta), |kernel| {
                    with_kernel::<f64, D, _>(terms, (mollifier, T::from_f64(delta).to_f64()), |exact| {
                        let options = Options { accumulation: Accumulation::Compensated, ..Options::default() };
                        let wants = sums((targets, &x, &masses), &|d, _| matrix(exact, d));
                        for level in Level::available() {
                            let got = run(kernel, (sources, targets), HESSIAN, &options, (level, &Serial));
                            let what = format!("{terms:?} {mollifier:?} {D}D n {n} {level:?}");
                            let c = if T::DIGITS > 24 { 1200.0 } else { 64.0 };
                            compare(&got.hessian, &wants, c, &what);
                        }
                    });
                });
            }
        }
        let got = run::<T, D>(&Host, (sources, targets), HESSIAN, &Options::default(), (Level::best(), &Serial));
        compare(&got.hessian, &sums((targets, &x, &masses), &|d, _| matrix(&Host, d)), 64.0, "host");
    }
}

#[test]
fn other_kernels() {
    others::<f64, 1>();
    others::<f64, 2>();
    others::<f64, 3>();
    others::<f32, 2>();
    others::<f32, 3>();
}

/// Central differences of the gradient; the trace is the Laplacian.
#[test]
fn differences_of_the_gradient() {
    fn check<const D: usize>() {
        let (x, masses) = cloud::<f64, D>(60);
        for (mollifier, delta) in [(COMPACT, 0.5), (Mollifier::Plummer, 0.3)] {
            with_kernel::<f64, D, _>(&[term(Law::Newtonian, 1.0)], (mollifier, delta), |kernel| {
                let sources = Sources::new(&x, &masses);
                let plain = |targets: &[[f64; D]]| {
                    run(kernel, (sources, targets), ALL, &Options::default(), (Level::best(), &Serial))
                };
                let (got, h) = (plain(&x), 1e-5);
                for k in 0..D {
                    let moved = |by: f64| -> Vec<[f64; D]> {
                        x.iter().map(|x| std::array::from_fn(|j| x[j] + if j == k { by } else { 0.0 })).collect()
                    };
                    let (after, before) = (plain(&moved(h)), plain(&moved(-h)));
                    for (i, hessian) in got.hessian.iter().enumerate() {
                        let slopes = after.gradient[i].iter().zip(&before.gradient[i]).zip(&hessian[k]);
                        for ((after, before), want) in slopes {
                            let quotient = (after - before) / (2.0 * h);
                            assert!((quotient - want).abs() < 1e-7, "{D}D {mollifier:?} {quotient} {want}");
                        }
                    }
                }
                for (hessian, laplacian) in got.hessian.iter().zip(&got.laplacian) {
                    let trace: f64 = (0..D).map(|k| hessian[k][k]).sum();
                    assert!((trace - laplacian).abs() < 1e-12, "{trace} {laplacian}");
                }
            });
        }
    }
    check::<1>();
    check::<2>();
    check::<3>();
}

/// Bits of an output do not depend on the others that are wanted, nor on threads; pairs are counted once.
#[test]
fn beside_other_outputs_and_on_threads() {
    fn check<T: Real, const D: usize>(mollifier: Mollifier) {
        let (x, masses) = cloud::<T, D>(700);
        with_kernel::<T, D, _>(&[term(Law::Newtonian, 1.0)], (mollifier, 0.3), |kernel| {
            let of = |wanted: Wanted, executor: &dyn Executor| {
                let options = Options { method: Some(Method::Direct), ..Options::default() };
                run(kernel, (Sources::new(&x, &masses), &x), wanted, &options, (Level::best(), executor))
            };
            let all = of(ALL, &Serial);
            assert_eq!(all, of(ALL, &Threads(3)));
            let (alone, without) = (of(HESSIAN, &Serial), of(Wanted { hessian: false, ..ALL }, &Serial));
            assert_eq!(all.hessian, alone.hessian);
            assert_eq!(
                (&all.potential, &all.gradient, &all.laplacian),
                (&without.potential, &without.gradient, &without.laplacian)
            );
            if D > 1 {
                assert_eq!(alone.counters.pairs, 700 * 700);
                assert_eq!(all.counters, without.counters);
                assert_eq!(alone.counters.near_pairs, without.counters.near_pairs);
            } else {
                assert_eq!(alone.hessian.as_flattened().as_flattened(), all.laplacian);
            }
        });
    }
    for mollifier in [COMPACT, Mollifier::Gaussian { order: 4 }, Mollifier::Algebraic] {
        check::<f64, 1>(mollifier);
        check::<f64, 2>(mollifier);
        check::<f64, 3>(mollifier);
        check::<f32, 2>(mollifier);
    }
}

/// A sum of even powers, or of the Laplacian alone, has faster methods, which do not know second derivatives.
#[test]
fn methods() {
    let plan = |terms: &[Term], wanted, method| {
        with_kernel::<f64, 2, _>(terms, (COMPACT, 0.3), |kernel| {
            field::plan(kernel, 9, 9, wanted, &Options { method, ..Options::default() }).map(|plan| plan.method())
        })
    };
    let even = [term(power(2.0), 1.0)];
    assert_eq!(plan(&even, ALL, None), Ok(Method::Direct));
    assert_eq!(plan(&even, Wanted { hessian: false, ..ALL }, None), Ok(Method::Moments));
    assert_eq!(plan(&even, ALL, Some(Method::Moments)), Err(Error::Unsupported));
    let newtonian = [term(Law::Newtonian, 1.0)];
    let laplacian = Wanted { laplacian: true, ..Wanted::default() };
    assert_eq!(plan(&newtonian, laplacian, None), Ok(Method::Neighbours));
    assert_eq!(plan(&newtonian, Wanted { hessian: true, ..laplacian }, None), Ok(Method::Direct));
    with_kernel::<f64, 1, _>(&newtonian, (COMPACT, 0.3), |kernel| {
        let plan = field::plan(kernel, 9, 9, HESSIAN, &Options::default()).unwrap();
        assert_eq!(plan.method(), Method::Neighbours);
        assert!(plan.to_string().contains("second derivatives computed"), "{plan}");
    });
    with_kernel::<f64, 3, _>(&newtonian, (COMPACT, 0.3), |kernel| {
        let options = Options { strengths: true, ..Options::default() };
        assert_eq!(field::plan(kernel, 9, 9, HESSIAN, &options).err(), Some(Error::Unsupported));
    });
}
