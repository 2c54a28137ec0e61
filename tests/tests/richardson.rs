//! Richardson combinations as the mollifiers of kernels (Anderson (8) to (10)): against their definition, kernels and sums against those of the parts, refusals, and what
//! they cost. Sums of Newtonian kernels with core radii, second derivatives and the fast multipole method have them in the lists of `softenings`, `hessians` and `fmm`;
//! observed orders of the blob method are those of the scene `richardson-orders`.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::ptr::null;

use mollis_abi::*;
use mollis_core::exec::{Run, Statistics};
use mollis_core::field::{self, Accumulation, Interaction, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, MAX_TERMS, RadialKernel, Supplied, Term};
use mollis_core::mollifier::{Blob, Mollifier, Quantity, Richardson};
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_reference::mollifier::Combination;
use mollis_tests::{Aligned, Split};

const FIELD: Wanted = Wanted { potential: true, gradient: true, laplacian: false, hessian: false };
const ALL: Wanted = Wanted { laplacian: true, ..FIELD };

fn combined(order: u32, exponent: u32) -> Mollifier {
    Mollifier::Richardson { order, exponent }
}

/// The radii j / K.
fn radii(order: u32) -> Vec<f64> {
    let count = order / 2;
    (1..=count).map(|j| f64::from(j) / f64::from(count)).collect()
}

fn term(law: Law, coefficient: f64) -> Term {
    Term { law, coefficient }
}

fn with_kernel<T: Real, const D: usize, R>(
    terms: &[Term],
    (mollifier, delta): (Mollifier, f64),
    f: impl FnOnce(&Kernel<'_, T, D>) -> R,
) -> R {
    let mut memory = Aligned::new(Kernel::<T, D>::workspace_bytes(terms, mollifier).unwrap());
    f(&Kernel::prepare(memory.bytes(), terms, mollifier, T::from_f64(delta)).unwrap())
}

#[test]
fn functions_are_those_of_the_definition() {
    fn check<T: Real, const D: usize>() {
        for (order, exponent) in [4, 6, 8].into_iter().flat_map(|order| [1, 2, 4, 9].map(|m| (order, m))) {
            let slow = Combination::new(D as u32, exponent, &radii(order));
            let blob = Blob::<T, D>::new(combined(order, exponent), T::ONE).unwrap();
            let largest = slow.parts.iter().map(|(w, r)| w.abs() / r.powi(D as i32)).sum::<f64>() * 20.0;
            for k in 1..=18 {
                let r = f64::from(k) / 16.0;
                // The quadrature is within 1e-10 (test `mollifier::compact_mollifiers_are_what_the_definition_says`).
                let close = |quantity, want: f64| {
                    let got = blob.evaluate(quantity, T::from_f64(r)).to_f64();
                    let bound = 1e-10 * largest + 0.5 * T::EPSILON.to_f64() * want.abs();
                    assert!((got - want).abs() <= bound, "{D}D {order} {exponent} {r} {quantity:?}: {got} {want}");
                };
                close(Quantity::Density, slow.density(r));
                close(Quantity::GradientFactor, slow.gradient_factor(r));
                close(Quantity::EnclosedMass, slow.mass(r));
                close(Quantity::Potential, slow.potential(r));
            }
        }
    }
    check::<f64, 1>();
    check::<f64, 2>();
    check::<f64, 3>();
    check::<f32, 1>();
    check::<f32, 2>();
    check::<f32, 3>();
}

/// (9) and (10) in each quantity, and the same radii through the combinations of any radii, which round gamma delta: some u of the parts.
#[test]
fn weights_are_those_of_the_paper() {
    fn check<const D: usize>() {
        let (base, delta) = (Mollifier::Compact { order: 2, exponent: 4 }, 0.75);
        let nine = [(4.0 / 3.0, 0.5), (-1.0 / 3.0, 1.0)];
        let ten = [(1.5, 1.0 / 3.0), (-0.6, 2.0 / 3.0), (0.1, 1.0)];
        for (order, parts) in [(4, &nine[..]), (6, &ten)] {
            let blob = Blob::<f64, D>::new(combined(order, 4), delta).unwrap();
            let general = Richardson::<f64, D>::new(base, delta, &radii(order)).unwrap();
            for (quantity, r) in
                Quantity::ALL.into_iter().flat_map(|q| [0.0, 0.2, 0.26, 0.6, 0.75, 2.0].map(|r| (q, r)))
            {
                let each = parts.iter().map(|&(weight, radius)| {
                    weight * Blob::<f64, D>::new(base, delta * radius).unwrap().evaluate(quantity, r)
                });
                let (want, size) = each.fold((0.0, 0.0), |(sum, size), value| (sum + value, size + value.abs()));
                let got = blob.evaluate(quantity, r);
                assert!(
                    (got - want).abs() <= 16.0 * f64::EPSILON * size,
                    "{D}D {order} {quantity:?} {r}: {got} {want}"
                );
                let other = general.evaluate(quantity, r);
                assert!(
                    (got - other).abs() <= 16.0 * f64::EPSILON * size,
                    "{D}D {order} {quantity:?} {r}: {got} {other}"
                );
            }
        }
    }
    check::<1>();
    check::<2>();
    check::<3>();
}

const LAWS: [Law; 9] = [
    Law::Newtonian,
    Law::Power { exponent: 0.0 },
    Law::Power { exponent: 0.5 },
    Law::Power { exponent: 1.5 },
    Law::Power { exponent: 3.0 },
    Law::Power { exponent: 4.0 },
    Law::Exponential { length: 0.7 },
    Law::Screened { k: 1.3 },
    Law::Screened { k: 12.0 },
];

const DISTANCES: [f64; 8] = [0.0, 0.05, 0.11, 0.16, 0.24, 0.29, 0.31, 2.0];

/// Value, gradient factor and Laplacian at each distance from kernels under the parts, and the sums of their magnitudes.
fn of_parts<const D: usize>(terms: &[Term], order: u32, delta: f64) -> [[[f64; 3]; 2]; DISTANCES.len()] {
    let part = Mollifier::Compact { order: 2, exponent: 4 };
    let mut sums = [[[0.0; 3]; 2]; DISTANCES.len()];
    for (weight, radius) in Combination::new(D as u32, 4, &radii(order)).parts {
        with_kernel::<f64, D, _>(terms, (part, radius * delta), |kernel| {
            for ([sum, size], r) in sums.iter_mut().zip(DISTANCES) {
                for (k, value) in kernel.at(r).into_iter().enumerate() {
                    sum[k] += weight * value;
                    size[k] += (weight * value).abs();
                }
            }
        });
    }
    sums
}

/// Terms alone and together: of two screened ones the series of each radius are added up.
#[test]
fn kernels_are_sums_over_the_radii() {
    fn check<T: Real, const D: usize>() {
        let mut all: Vec<(Vec<Term>, u32)> = LAWS
            .into_iter()
            .zip([4, 6, 8].into_iter().cycle())
            .map(|(law, order)| (vec![term(law, 1.0)], order))
            .collect();
        let screened = |k, coefficient| term(Law::Screened { k }, coefficient);
        let power = term(Law::Power { exponent: 1.5 }, 0.25);
        all.push((vec![term(Law::Newtonian, -0.5), screened(1.3, 1.0), power, screened(2.0, 0.5)], 4));
        all.push((vec![screened(1.3, 1.0), screened(2.0, -0.5), term(Law::Newtonian, 2.0)], 6));
        all.retain(|(terms, _)| D > 1 || terms[0].law != Law::Power { exponent: 0.0 });
        for (terms, order) in all {
            let wants = of_parts::<D>(&terms, order, 0.3);
            with_kernel::<T, D, _>(&terms, (combined(order, 4), 0.3), |kernel| {
                for ([want, size], r) in wants.into_iter().zip(DISTANCES) {
                    for (k, got) in kernel.at(T::from_f64(r)).into_iter().enumerate() {
                        let error = (got.to_f64() - want[k]).abs();
                        // Fits are within 1e-13 of a scale at delta; that of the Laplacian is the gradient factor's at least. Delta and r are rounded to the scalar.
                        let relative = 2e-13 + 4.0 * T::EPSILON.to_f64();
                        let bound = relative * (size[k] + if k == 2 { size[1] } else { 0.0 } + f64::EPSILON);
                        assert!(
                            error <= bound,
                            "{D}D {terms:?} {order} {r} [{k}]: {got} {} {error:e} {bound:e}",
                            want[k]
                        );
                    }
                }
            });
        }
    }
    check::<f64, 1>();
    check::<f64, 2>();
    check::<f64, 3>();
    check::<f32, 2>();
}

struct Sums<T, const D: usize> {
    potential: Vec<T>,
    gradient: Vec<[T; D]>,
    laplacian: Vec<T>,
    counts: Statistics,
}

fn run<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    (x, m): (&[[T; D]], &[T]),
    wanted: Wanted,
    options: &Options,
    level: Level,
) -> (Method, Sums<T, D>) {
    let n = x.len();
    let plan = field::plan(kernel, n, n, wanted, options).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
    let mut sums = Sums {
        potential: vec![T::ZERO; n],
        gradient: vec![[T::ZERO; D]; n],
        laplacian: vec![T::ZERO; n],
        counts: Statistics::default(),
    };
    let outputs = Outputs {
        potential: wanted.potential.then_some(&mut sums.potential[..]),
        gradient: wanted.gradient.then_some(&mut sums.gradient[..]),
        laplacian: wanted.laplacian.then_some(&mut sums.laplacian[..]),
        hessian: None,
    };
    let mut run = Run { level, counters: Some(&mut sums.counts), ..Run::default() };
    field::evaluate(&plan, kernel, Sources::new(x, m), x, outputs, memory.bytes(), &mut run).unwrap();
    (plan.method(), sums)
}

/// Points in a cube, some of which coincide or nearly so, and masses of either sign.
fn cloud<T: Real, const D: usize>(n: usize) -> (Vec<[T; D]>, Vec<T>) {
    let mut numbers = Split(n as u64);
    let mut x: Vec<[f64; D]> = (0..n).map(|_| std::array::from_fn(|_| numbers.uniform())).collect();
    for k in (1..n).step_by(17) {
        x[k] = x[k - 1].map(|c| c + if k % 2 == 0 { 0.0 } else { 1e-7 });
    }
    let m = (0..n).map(|_| T::from_f64(numbers.uniform() - 0.3)).collect();
    (x.into_iter().map(|x| x.map(T::from_f64)).collect(), m)
}

/// Sums over pairs by the kernel's own functions of the distance, and of what errors are relative to: the magnitudes over the distances from r/2 to r, and to delta from 0
/// where r < delta; twice those, as parts of other radii cancel in them.
fn pairs<T: Real, const D: usize>(
    kernel: &Kernel<'_, f64, D>,
    delta: f64,
    (x, m): (&[[T; D]], &[T]),
    target: &[T; D],
) -> ([f64; 2], [[f64; D]; 2], [f64; 2]) {
    let (mut u, mut g, mut l) = ([0.0; 2], [[0.0; D]; 2], [0.0; 2]);
    for (y, m) in x.iter().zip(m) {
        let m = m.to_f64();
        let d: [f64; D] = std::array::from_fn(|k| target[k].to_f64() - y[k].to_f64());
        let r = d.iter().map(|d| d * d).sum::<f64>().sqrt();
        let [value, factor, laplacian] = kernel.at(r);
        let (from, to) = if r < delta { (0.0, delta) } else { (0.5 * r, r) };
        let sizes = (0..=8).map(|k| kernel.at(from + (to - from) * f64::from(k) / 8.0).map(f64::abs));
        let most = sizes.fold([0.0_f64; 3], |most, size| std::array::from_fn(|k| most[k].max(size[k])));
        u[0] += m * value;
        u[1] += 2.0 * m.abs() * most[0].max(r * r * most[1]);
        for k in 0..D {
            g[0][k] += m * factor * d[k];
            g[1][k] += 2.0 * m.abs() * r * most[1];
        }
        l[0] += m * laplacian;
        l[1] += 2.0 * m.abs() * most[2].max(D as f64 * most[1]);
    }
    (u, g, l)
}

#[test]
fn sums_are_those_of_single_pairs() {
    fn check<T: Real, const D: usize>() {
        let u = 0.5 * T::EPSILON.to_f64();
        // Of tables, and of a few hundred roundings of the sum.
        let c = if T::DIGITS > 24 { [128.0, 128.0, 1000.0] } else { [32.0; 3] }.map(|c| c + 64.0);
        let options = Options { accumulation: Accumulation::Compensated, ..Options::default() };
        for (law, (order, exponent)) in LAWS.into_iter().zip([(4, 4), (6, 2), (8, 4)].into_iter().cycle()) {
            if D == 1 && matches!(law, Law::Power { exponent: 0.0 }) {
                continue;
            }
            let shape = (combined(order, exponent), 0.25);
            let (x, m) = cloud::<T, D>(60);
            with_kernel::<f64, D, _>(&[term(law, -1.5)], shape, |exact| {
                let wants: Vec<_> = x.iter().map(|target| pairs(exact, 0.25, (&x, &m), target)).collect();
                with_kernel::<T, D, _>(&[term(law, -1.5)], shape, |kernel| {
                    for level in Level::available() {
                        let (_, got) = run(kernel, (&x, &m), ALL, &options, level);
                        for (i, (potential, gradient, laplacian)) in wants.iter().enumerate() {
                            let within = |got: T, [want, size]: [f64; 2], c: f64| {
                                let error = (got.to_f64() - want).abs() / (u * size);
                                assert!(
                                    error <= c,
                                    "{D}D {law:?} {order} {level:?} target {i}: {got} {want}, {error} u S"
                                );
                            };
                            within(got.potential[i], *potential, c[0]);
                            for ((&got, want), size) in got.gradient[i].iter().zip(gradient[0]).zip(gradient[1]) {
                                within(got, [want, size], c[1]);
                            }
                            within(got.laplacian[i], *laplacian, c[2]);
                        }
                    }
                });
            });
        }
    }
    check::<f64, 1>();
    check::<f64, 2>();
    check::<f64, 3>();
    check::<f32, 1>();
    check::<f32, 2>();
    check::<f32, 3>();
}

/// Sorted sums, moments, neighbours and the fast methods against all pairs.
#[test]
fn methods_agree() {
    fn check<const D: usize>(terms: &[Term], wanted: Wanted, options: &Options, method: Method, bound: f64) {
        let (x, m) = cloud::<f64, D>(3000);
        with_kernel::<f64, D, _>(terms, (combined(6, 4), 0.1), |kernel| {
            let direct = Options { method: Some(Method::Direct), ..Options::default() };
            let (_, want) = run(kernel, (&x, &m), wanted, &direct, Level::best());
            let (chosen, got) = run(kernel, (&x, &m), wanted, options, Level::best());
            assert_eq!(chosen, method, "{D}D {terms:?}");
            let error = |got: &[f64], want: &[f64]| {
                let most = want.iter().fold(f64::MIN_POSITIVE, |most, w| most.max(w.abs()));
                let error = got.iter().zip(want).fold(0.0_f64, |worst, (g, w)| worst.max((g - w).abs())) / most;
                assert!(error < bound, "{D}D {terms:?} {method:?}: {error:e}");
            };
            error(&got.potential, &want.potential);
            error(got.gradient.as_flattened(), want.gradient.as_flattened());
            error(&got.laplacian, &want.laplacian);
        });
    }
    let newtonian = [term(Law::Newtonian, 1.0)];
    let power = |exponent| term(Law::Power { exponent }, -0.5);
    let exact = Options::default();
    check::<1>(&newtonian, ALL, &exact, Method::Sorted, 1e-12);
    check::<1>(&[newtonian[0], power(3.0)], ALL, &exact, Method::Sorted, 1e-12);
    check::<2>(&[power(2.0), power(4.0)], ALL, &exact, Method::Moments, 1e-12);
    let density = Wanted { laplacian: true, ..Wanted::default() };
    check::<1>(&newtonian, density, &exact, Method::Neighbours, 1e-12);
    check::<2>(&newtonian, density, &exact, Method::Neighbours, 1e-12);
    check::<3>(&newtonian, density, &exact, Method::Neighbours, 1e-12);
    let fast = Options { tolerance: 1e-9, ..Options::default() };
    check::<2>(&newtonian, ALL, &Options { method: Some(Method::Fmm), ..fast }, Method::Fmm, 1e-8);
    check::<3>(&newtonian, ALL, &Options { method: Some(Method::Fmm), ..fast }, Method::Fmm, 1e-8);
    let screened = [term(Law::Screened { k: 2.0 }, 1.0)];
    check::<2>(&screened, FIELD, &Options { method: Some(Method::Tree), ..fast }, Method::Tree, 1e-8);
}

/// One pass over the pairs, whatever the number of radii; and a compact mollifier has no table.
#[test]
fn pairs_are_visited_once() {
    let newtonian = [term(Law::Newtonian, 1.0)];
    let (x, m) = cloud::<f64, 2>(200);
    let count = |mollifier| {
        with_kernel::<f64, 2, _>(&newtonian, (mollifier, 0.1), |kernel| {
            run(kernel, (&x, &m), FIELD, &Options::default(), Level::best()).1.counts.pairs
        })
    };
    let one = count(Mollifier::Compact { order: 2, exponent: 4 });
    assert_eq!([4, 6, 8].map(|order| count(combined(order, 4))), [one; 3]);
    let bytes = |mollifier| Kernel::<f64, 2>::workspace_bytes(&newtonian, mollifier).unwrap();
    assert_eq!(bytes(Mollifier::Compact { order: 2, exponent: 4 }), bytes(Mollifier::None));
    assert_eq!(bytes(combined(4, 4)), bytes(Mollifier::Gaussian { order: 4 }));
}

#[test]
fn refusals() {
    let blob = |mollifier, delta| Blob::<f64, 2>::new(mollifier, delta).err();
    for order in [0, 2, 3, 5, 10] {
        assert_eq!(blob(combined(order, 4), 1.0), Some(Error::Order), "{order}");
    }
    assert_eq!([0, 10].map(|exponent| blob(combined(4, exponent), 1.0)), [Some(Error::Exponent); 2]);
    assert_eq!([0.0, f64::NAN].map(|delta| blob(combined(4, 4), delta)), [Some(Error::Delta); 2]);
    // A term that is not Newtonian counts for each radius.
    let bytes = |terms: &[Term], order| Kernel::<f64, 2>::workspace_bytes(terms, combined(order, 4));
    let powers = [term(Law::Power { exponent: 1.5 }, 1.0); MAX_TERMS];
    for (order, most) in [(4, 4), (6, 2), (8, 2)] {
        assert!(bytes(&powers[..most], order).is_ok());
        assert_eq!(bytes(&powers[..=most], order), Err(Error::KernelTerms));
    }
    assert!(bytes(&[term(Law::Newtonian, 1.0); MAX_TERMS], 8).is_ok());
    struct Own;
    impl RadialKernel for Own {
        fn at(&self, r: f64) -> [f64; 3] {
            [0.5 * r * r, 1.0, 2.0]
        }
    }
    assert_eq!(Kernel::<f64, 2>::workspace_bytes_with(&[], true, combined(4, 4)), Err(Error::Unsupported));
    let mut memory = Aligned::new(1 << 20);
    let made = Kernel::<f64, 2>::write(memory.bytes(), &[], Some(Supplied::new(&Own, 1.0, 5.0)), combined(4, 4), 0.1);
    assert_eq!(made, Err(Error::Unsupported));
    assert_eq!(field::Density::<f64, 2>::new(combined(4, 4), 0.1).err(), Some(Error::Unsupported));
}

/// A block that C prepares is one that Rust opens, with the same mollifier and the same values.
#[test]
fn the_c_functions_give_the_same() {
    let mollifier = mollis_mollifier { kind: MOLLIS_MOLLIFIER_RICHARDSON, order: 6, exponent: 4 };
    let terms = [0, 1].map(|kind| mollis_kernel_term { kind, reserved: 0, coefficient: 2.0, parameter: [1.5, 0.0] });
    let core = [term(Law::Newtonian, 2.0), term(Law::Power { exponent: 1.5 }, 2.0)];
    let (r, mut bytes) = ([0.0, 0.04, 0.09, 0.11, 0.2, 3.0], 0);
    let mut out = [[0.0; 6]; 3];
    let [u, g, l] = &mut out;
    unsafe {
        assert_eq!(mollis_kernel2_bytes(terms.as_ptr(), 2, null(), mollifier, &raw mut bytes), 0);
        let mut block = Aligned::new(bytes);
        assert_eq!(mollis_kernel2_prepare(block.pointer(), bytes, terms.as_ptr(), 2, null(), mollifier, 0.2), 0);
        let (u, g, l) = (u.as_mut_ptr(), g.as_mut_ptr(), l.as_mut_ptr());
        assert_eq!(mollis_kernel2_eval(block.start(), bytes, 6, r.as_ptr(), u, g, l), 0);
        let opened = Kernel::<f64, 2>::open(block.bytes()).unwrap();
        assert_eq!((opened.mollifier(), opened.delta()), (combined(6, 4), 0.2));
        let wrong = mollis_mollifier { order: 2, ..mollifier };
        assert_eq!(
            mollis_kernel2_bytes(terms.as_ptr(), 2, null(), wrong, &raw mut bytes),
            Error::Order as mollis_status
        );
    }
    with_kernel::<f64, 2, _>(&core, (combined(6, 4), 0.2), |kernel| {
        for (k, r) in r.into_iter().enumerate() {
            assert_eq!(kernel.at(r), out.each_ref().map(|values| values[k]));
        }
    });
}
