//! What holds for sums of any particles, of any kernel, without another program to compare with: random particles, shrunk to the least ones that fail.
//!
//! The particles of a run are always the same; `MOLLIS_CASES=20000 cargo test --release -p mollis-tests properties::` takes as many others.

use mollis_core::aggregation::{self, Advance, Report, State, Trajectories};
use mollis_core::exec::{Executor, Run, Serial};
use mollis_core::field::{Method, Options, Sources};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;
use mollis_tests::{Aligned, Threads};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use crate::field_bounds::{COMPACT, power, term, with_kernel};
use crate::hessians::{ALL, Sums, run};

/// Cases of a property.
const CASES: u32 = 24;

/// Calls the property with random values: the same in each run, or as many others as the environment asks for.
fn check<S: Strategy>(strategy: &S, property: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let asked = std::env::var("MOLLIS_CASES").ok().and_then(|cases| cases.parse().ok());
    let config = Config { cases: asked.unwrap_or(CASES), failure_persistence: None, ..Config::default() };
    let mut runner = match asked {
        Some(_) => TestRunner::new(config),
        None => TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha)),
    };
    runner.run(strategy, property).unwrap_or_else(|failure| panic!("{failure}"));
}

/// Positions and masses. Coordinates are multiples of 2^-20, so that differences and sums of a few of them are exact.
#[derive(Clone, Debug, PartialEq)]
struct Cloud<const D: usize> {
    x: Vec<[f64; D]>,
    m: Vec<f64>,
}

const UNIT: f64 = 1.0 / (1 << 20) as f64;

fn cloud<const D: usize>(least: usize, most: usize) -> impl Strategy<Value = Cloud<D>> {
    let coordinates: [_; D] = std::array::from_fn(|_| -(1_i32 << 20)..1 << 20);
    proptest::collection::vec((coordinates, -1000_i32..1000), least..most).prop_map(|particles| Cloud {
        x: particles.iter().map(|(x, _)| x.map(|x| f64::from(x) * UNIT)).collect(),
        m: particles.iter().map(|&(_, m)| f64::from(m) / 1000.0).collect(),
    })
}

/// A kernel of each kind, and a mollifier's length.
#[derive(Clone, Debug)]
struct Shape {
    terms: Vec<Term>,
    mollifier: Mollifier,
    delta: f64,
}

impl Shape {
    fn newtonian(mollifier: Mollifier, delta: f64) -> Self {
        Self { terms: vec![term(Law::Newtonian, 1.0)], mollifier, delta }
    }

    fn with<const D: usize, R>(&self, then: impl FnOnce(&Kernel<'_, f64, D>) -> R) -> R {
        with_kernel(&self.terms, (self.mollifier, self.delta), then)
    }
}

fn shape() -> impl Strategy<Value = Shape> {
    (0..7_usize, 3..12_i32).prop_map(|(kind, exponent)| {
        let delta = 0.5_f64.powi(exponent);
        let newtonian = |mollifier| Shape::newtonian(mollifier, delta);
        match kind {
            0 => Shape::newtonian(Mollifier::None, 0.0),
            1 => newtonian(COMPACT),
            2 => newtonian(Mollifier::Compact { order: 4, exponent: 6 }),
            3 => newtonian(Mollifier::Gaussian { order: 2 }),
            4 => newtonian(Mollifier::Plummer),
            5 => Shape { terms: vec![term(power(1.5), 0.75)], mollifier: COMPACT, delta },
            _ => Shape {
                terms: vec![term(Law::Exponential { length: 0.5 }, 1.0), term(Law::Exponential { length: 0.25 }, -2.0)],
                mollifier: Mollifier::None,
                delta: 0.0,
            },
        }
    })
}

fn sums_with<const D: usize>(
    kernel: &Kernel<'_, f64, D>,
    (cloud, targets): (&Cloud<D>, &[[f64; D]]),
    options: &Options,
    executor: &dyn Executor,
) -> Sums<f64, D> {
    run(kernel, (Sources::new(&cloud.x, &cloud.m), targets), ALL, options, (Level::best(), executor))
}

fn sums<const D: usize>(shape: &Shape, cloud: &Cloud<D>, targets: &[[f64; D]]) -> Sums<f64, D> {
    let direct = Options { method: Some(Method::Direct), ..Options::default() };
    shape.with(|kernel| sums_with(kernel, (cloud, targets), &direct, &Serial))
}

/// What the errors of potential, gradient and second derivatives at each target are measured by: the sum over sources of |m| and the largest values of the kernel near the distance.
fn scales<const D: usize>(shape: &Shape, cloud: &Cloud<D>, targets: &[[f64; D]]) -> Vec<[f64; 3]> {
    let at = |kernel: &Kernel<'_, f64, D>, target: &[f64; D]| {
        let mut scales = [f64::MIN_POSITIVE; 3];
        for (x, m) in cloud.x.iter().zip(&cloud.m) {
            let r = x.iter().zip(target).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            if r == 0.0 && kernel.is_singular() {
                continue;
            }
            let near = if r < shape.delta { shape.delta } else { r };
            let mut largest = [0.0_f64; 3];
            for r in [r, near, 0.75 * near, 0.5 * near] {
                let [k, g, l] = kernel.at(r).map(f64::abs);
                let sizes = [k + g * r * r, g * r, l + D as f64 * g];
                largest.iter_mut().zip(sizes).for_each(|(largest, size)| *largest = largest.max(size));
            }
            scales.iter_mut().zip(largest).for_each(|(scale, largest)| *scale += m.abs() * largest);
        }
        scales
    };
    shape.with(|kernel| targets.iter().map(|target| at(kernel, target)).collect())
}

/// Every result is that of the other, to the errors that the documentation states for both.
fn agree<const D: usize>(a: &Sums<f64, D>, b: &Sums<f64, D>, scales: &[[f64; 3]]) -> Result<(), TestCaseError> {
    for (i, &[value, slope, curve]) in scales.iter().enumerate() {
        let near = |a: f64, b: f64, scale: f64, c: f64| (a - b).abs() <= c * f64::EPSILON * scale;
        prop_assert!(near(a.potential[i], b.potential[i], value, 400.0), "potential {i}: {a:?} {b:?}");
        for (x, y) in a.gradient[i].iter().zip(&b.gradient[i]) {
            prop_assert!(near(*x, *y, slope, 400.0), "gradient {i}: {a:?} {b:?}");
        }
        prop_assert!(near(a.laplacian[i], b.laplacian[i], curve, 4000.0), "Laplacian {i}: {a:?} {b:?}");
        for (x, y) in a.hessian[i].as_flattened().iter().zip(b.hessian[i].as_flattened()) {
            prop_assert!(near(*x, *y, curve, 4000.0), "second derivatives {i}: {a:?} {b:?}");
        }
    }
    Ok(())
}

/// The same property in one, two and three dimensions.
macro_rules! in_each_dimension {
    ($property:ident) => {
        $property::<1>();
        $property::<2>();
        $property::<3>();
    };
}

fn of_two_clouds<const D: usize>() {
    check(&(shape(), cloud::<D>(1, 40), cloud::<D>(1, 40)), |(shape, a, b)| {
        let both = Cloud { x: [&a.x[..], &b.x].concat(), m: [&a.m[..], &b.m].concat() };
        let (of_a, of_b) = (sums(&shape, &a, &a.x), sums(&shape, &b, &a.x));
        let plus = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x + y).collect::<Vec<f64>>();
        let pairs = |x: &[[f64; D]], y: &[[f64; D]]| plus(x.as_flattened(), y.as_flattened()).as_chunks().0.to_vec();
        let hessians = |x: &[[[f64; D]; D]], y: &[[[f64; D]; D]]| pairs(x.as_flattened(), y.as_flattened());
        let sum = Sums {
            potential: plus(&of_a.potential, &of_b.potential),
            gradient: pairs(&of_a.gradient, &of_b.gradient),
            laplacian: plus(&of_a.laplacian, &of_b.laplacian),
            hessian: hessians(&of_a.hessian, &of_b.hessian).as_chunks().0.to_vec(),
            counters: of_a.counters,
        };
        let scales = scales(&shape, &both, &a.x);
        agree(&sums(&shape, &both, &a.x), &sum, &scales)
    });
}

#[test]
fn the_sum_over_two_clouds_is_the_sum_of_the_sums() {
    in_each_dimension!(of_two_clouds);
}

fn of_moved_clouds<const D: usize>() {
    let shift: [_; D] = std::array::from_fn(|_| -(1_i32 << 22)..1 << 22);
    check(&(shape(), cloud::<D>(1, 40), shift), |(shape, cloud, shift)| {
        let by = shift.map(|x| f64::from(x) * UNIT);
        let moved = |x: &[f64; D]| std::array::from_fn(|k| x[k] + by[k]);
        let there = Cloud { x: cloud.x.iter().map(moved).collect(), m: cloud.m.clone() };
        agree(&sums(&shape, &there, &there.x), &sums(&shape, &cloud, &cloud.x), &scales(&shape, &cloud, &cloud.x))
    });
}

#[test]
fn moved_particles_have_the_same_sums() {
    in_each_dimension!(of_moved_clouds);
}

fn of_turned_clouds<const D: usize>() {
    // (x, y, ..) to (-y, x, ..)
    let turn = |x: &[f64; D]| {
        let mut turned = *x;
        if D > 1 {
            (turned[0], turned[1]) = (-x[1], x[0]);
        } else {
            turned[0] = -x[0];
        }
        turned
    };
    check(&(shape(), cloud::<D>(1, 40)), |(shape, cloud)| {
        let there = Cloud { x: cloud.x.iter().map(turn).collect(), m: cloud.m.clone() };
        let mut here = sums(&shape, &cloud, &cloud.x);
        for (gradient, hessian) in here.gradient.iter_mut().zip(&mut here.hessian) {
            *gradient = turn(gradient);
            // Rows, then columns.
            let rows = hessian.map(|row| turn(&row));
            let columns: [[f64; D]; D] = std::array::from_fn(|k| turn(&std::array::from_fn(|j| rows[j][k])));
            *hessian = std::array::from_fn(|j| std::array::from_fn(|k| columns[k][j]));
        }
        agree(&sums(&shape, &there, &there.x), &here, &scales(&shape, &cloud, &cloud.x))
    });
}

#[test]
fn turned_particles_have_turned_sums() {
    in_each_dimension!(of_turned_clouds);
}

fn of_shuffled_clouds<const D: usize>() {
    check(&(shape(), cloud::<D>(1, 300), any::<u64>()), |(shape, cloud, seed)| {
        let mut order: Vec<usize> = (0..cloud.x.len()).collect();
        let mut numbers = mollis_tests::Split(seed);
        for k in (1..order.len()).rev() {
            order.swap(k, (numbers.next() % (k as u64 + 1)) as usize);
        }
        let other =
            Cloud { x: order.iter().map(|&k| cloud.x[k]).collect(), m: order.iter().map(|&k| cloud.m[k]).collect() };
        let targets = &cloud.x[..cloud.x.len().min(20)];
        let scales = scales(&shape, &cloud, targets);
        agree(&sums(&shape, &other, targets), &sums(&shape, &cloud, targets), &scales)
    });
}

#[test]
fn the_order_of_the_sources_does_not_matter() {
    in_each_dimension!(of_shuffled_clouds);
}

fn of_reactions<const D: usize>() {
    check(&(shape(), cloud::<D>(1, 40), cloud::<D>(1, 40)), |(shape, a, b)| {
        let (of_a, of_b) = (sums(&shape, &a, &b.x), sums(&shape, &b, &a.x));
        // sum b (K a) = sum a (K b), and the forces are opposite.
        let (mut work, mut back, mut bounds) = (0.0, 0.0, [0.0; 2]);
        let (mut force, mut reaction) = ([0.0; D], [0.0; D]);
        for (i, (m, [value, slope, _])) in b.m.iter().zip(scales(&shape, &a, &b.x)).enumerate() {
            work += m * of_a.potential[i];
            (0..D).for_each(|k| force[k] += m * of_a.gradient[i][k]);
            bounds = [bounds[0] + m.abs() * value, bounds[1] + m.abs() * slope];
        }
        for (i, m) in a.m.iter().enumerate() {
            back += m * of_b.potential[i];
            (0..D).for_each(|k| reaction[k] += m * of_b.gradient[i][k]);
        }
        prop_assert!((work - back).abs() <= 600.0 * f64::EPSILON * bounds[0], "{work} {back}");
        for (f, r) in force.iter().zip(&reaction) {
            prop_assert!((f + r).abs() <= 600.0 * f64::EPSILON * bounds[1], "{force:?} {reaction:?}");
        }
        Ok(())
    });
}

#[test]
fn action_is_reaction() {
    in_each_dimension!(of_reactions);
}

fn of_scaled_clouds<const D: usize>() {
    check(&(0..3_usize, cloud::<D>(1, 60), -150..150_i32, -150..150_i32), |(kind, cloud, length, mass)| {
        let mollifier = [Mollifier::None, COMPACT, Mollifier::Plummer][kind];
        let delta = if mollifier == Mollifier::None { 0.0 } else { 0.125 };
        let power = |n: i32| 2.0_f64.powi(n);
        let there = Cloud {
            x: cloud.x.iter().map(|x| x.map(|x| x * power(length))).collect(),
            m: cloud.m.iter().map(|m| m * power(mass)).collect(),
        };
        let here = sums(&Shape::newtonian(mollifier, delta), &cloud, &cloud.x);
        let sums = sums(&Shape::newtonian(mollifier, delta * power(length)), &there, &there.x);
        let d = D as i32;
        for (i, gradient) in here.gradient.iter().enumerate() {
            prop_assert_eq!(sums.gradient[i], gradient.map(|g| g * power(mass - (d - 1) * length)));
            prop_assert_eq!(sums.laplacian[i], here.laplacian[i] * power(mass - d * length));
        }
        Ok(())
    });
}

#[test]
fn powers_of_two_as_units_change_no_bit_of_newtonian_sums() {
    in_each_dimension!(of_scaled_clouds);
}

fn of_massless_sources<const D: usize>() {
    check(&(shape(), cloud::<D>(1, 60), cloud::<D>(1, 20), any::<u64>()), |(shape, cloud, massless, seed)| {
        let (mut more, mut numbers) = (cloud.clone(), mollis_tests::Split(seed));
        for x in &massless.x {
            // Within the coordinates of the others, which the units depend on.
            let [x, at] = [x.map(|x| x * 0.5f64.powi(20)), [(numbers.next() % (more.x.len() as u64 + 1)) as f64; D]];
            more.x.insert(at[0] as usize, x);
            more.m.insert(at[0] as usize, 0.0);
        }
        let (a, b) = (sums(&shape, &cloud, &cloud.x), sums(&shape, &more, &cloud.x));
        let zeros = cloud.m.iter().filter(|m| **m == 0.0).count() as u64;
        prop_assert_eq!(a.counters.massless_sources, zeros);
        prop_assert_eq!(b.counters.massless_sources, zeros + massless.x.len() as u64);
        prop_assert_eq!(a.counters.pairs, b.counters.pairs);
        prop_assert_eq!((a.potential, a.gradient, a.laplacian), (b.potential, b.gradient, b.laplacian));
        Ok(())
    });
}

#[test]
fn massless_sources_are_skipped() {
    in_each_dimension!(of_massless_sources);
}

fn of_threads<const D: usize>() {
    check(&(shape(), cloud::<D>(1, 500), 2..5_usize), |(shape, cloud, workers)| {
        shape.with(|kernel| {
            let one = sums_with(kernel, (&cloud, &cloud.x), &Options::default(), &Serial);
            let more = sums_with(kernel, (&cloud, &cloud.x), &Options::default(), &Threads(workers));
            prop_assert_eq!(one, more);
            Ok(())
        })
    });
}

#[test]
fn the_number_of_threads_changes_nothing() {
    in_each_dimension!(of_threads);
}

fn of_second_derivatives<const D: usize>() {
    check(&(shape(), cloud::<D>(1, 60)), |(shape, cloud)| {
        let sums = sums(&shape, &cloud, &cloud.x);
        let scales = scales(&shape, &cloud, &cloud.x);
        for (i, (hessian, [.., scale])) in sums.hessian.iter().zip(scales).enumerate() {
            let trace: f64 = (0..D).map(|k| hessian[k][k]).sum();
            prop_assert!((trace - sums.laplacian[i]).abs() <= 4000.0 * f64::EPSILON * scale, "{trace} {i}");
            for (j, row) in hessian.iter().enumerate() {
                (0..D).try_for_each(|k| {
                    prop_assert_eq!(row[k], hessian[k][j]);
                    Ok(())
                })?;
            }
        }
        Ok(())
    });
}

#[test]
fn second_derivatives_are_symmetric_and_their_trace_is_the_laplacian() {
    in_each_dimension!(of_second_derivatives);
}

#[test]
fn the_fast_multipole_method_is_within_its_tolerance_of_all_pairs() {
    let clouds = (cloud::<2>(1, 300), 3..13_i32, 0..2_i32, 0..4_usize);
    check(&clouds, |(cloud, digits, squeeze, kind)| {
        let tolerance = 0.1_f64.powi(digits);
        let shape = match kind {
            0 => Shape::newtonian(Mollifier::None, 0.0),
            1 => Shape::newtonian(COMPACT, 0.01),
            2 => Shape::newtonian(COMPACT, 0.5),
            _ => Shape::newtonian(Mollifier::Gaussian { order: 2 }, 0.01),
        };
        // Half of them a thousandth of the size.
        let mut cloud = cloud;
        if squeeze == 1 {
            cloud.x.iter_mut().step_by(2).for_each(|x| *x = x.map(|x| x * 1e-3));
        }
        let fmm = Options { method: Some(Method::Fmm), tolerance, ..Options::default() };
        let fast = shape.with(|kernel| sums_with(kernel, (&cloud, &cloud.x), &fmm, &Serial));
        let all = sums(&shape, &cloud, &cloud.x);
        let (mut differences, mut sizes) = ([0.0; 3], [0.0; 3]);
        for (i, scales) in scales(&shape, &cloud, &cloud.x).into_iter().enumerate() {
            let gradient = fast.gradient[i].iter().zip(&all.gradient[i]).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            let hessian = fast.hessian[i].as_flattened().iter().zip(all.hessian[i].as_flattened());
            let hessian = hessian.map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            let potential = (fast.potential[i] - all.potential[i]).powi(2);
            for (k, difference) in [potential, gradient, hessian].into_iter().enumerate() {
                differences[k] += difference;
                sizes[k] += scales[k] * scales[k];
            }
        }
        for (difference, size) in differences.iter().zip(&sizes) {
            let error = (difference / size).sqrt();
            prop_assert!(error <= tolerance.max(1e-13), "{error} {tolerance} {kind} {squeeze}");
        }
        Ok(())
    });
}

#[test]
fn attraction_keeps_the_centre_of_mass_and_lowers_the_energy() {
    let energy = |cloud: &Cloud<2>, shape: &Shape| {
        let sums = sums(shape, cloud, &cloud.x);
        cloud.m.iter().zip(&sums.potential).map(|(m, u)| 0.5 * m * u).sum::<f64>()
    };
    check(&(cloud::<2>(2, 40), 1..4_usize, 2..5_i32), |(cloud, steps, exponent)| {
        let shape = Shape::newtonian(COMPACT, 0.5_f64.powi(exponent));
        let mut cloud = Cloud { m: cloud.m.iter().map(|m| (m.abs() + 0.01) / 40.0).collect(), x: cloud.x };
        let centre = |cloud: &Cloud<2>| {
            let mut sum = [0.0; 2];
            cloud.x.iter().zip(&cloud.m).for_each(|(x, m)| (0..2).for_each(|k| sum[k] += m * x[k]));
            sum
        };
        let (before, first) = (energy(&cloud, &shape), centre(&cloud));
        let mut x = cloud.x.clone();
        shape.with(|kernel: &Kernel<'_, f64, 2>| {
            let plan =
                aggregation::plan(kernel, x.len(), 0, aggregation::Wanted::default(), &Options::default()).unwrap();
            let mut memory = Aligned::new(plan.workspace_bytes::<f64, 2>(1).unwrap());
            let state = State {
                masses: &cloud.m,
                particles: Trajectories { positions: &mut x, ..Trajectories::none() },
                tracers: Trajectories::none(),
            };
            // Far below the stable step: 2 / (largest density) is above 0.01.
            let advance = Advance { dt: 1e-3, steps, after_step: None };
            let (mut run, mut report) = (Run::default(), Report::default());
            aggregation::step(&plan, kernel, state, advance, memory.bytes(), &mut run, &mut report).unwrap();
        });
        cloud.x = x;
        let (after, last) = (energy(&cloud, &shape), centre(&cloud));
        prop_assert!(after <= before + 1e-13 * before.abs().max(1.0), "{before} {after}");
        for (a, b) in first.iter().zip(&last) {
            prop_assert!((a - b).abs() <= 1e-13, "{first:?} {last:?}");
        }
        Ok(())
    });
}
