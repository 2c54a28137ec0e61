//! Numbers that are not finite: refused with everything as it was, wherever they stand. Numbers that become so: an infinite result where the true one is out of range, or a run that stops at its last completed step.

use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::exec::{Run, Serial};
use mollis_core::field::{self, Method, Options, Outputs, Sources};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;
use mollis_core::{Error, Real};
use mollis_tests::Aligned;

use super::{cloud, kernel, narrow, size};
use crate::field_bounds::{self, COMPACT, LAPLACIAN, power, term, with_kernel};
use crate::hessians;

/// What is put in the place of a number.
fn bad<T: Real>() -> [T; 3] {
    [T::NAN, T::INFINITY, -T::INFINITY]
}

/// Each index in turn, or some of them.
fn places(n: usize) -> impl Iterator<Item = usize> {
    (0..n).step_by(size(1 + n / 12, 1)).chain([n - 1])
}

/// Every place of sources and targets, for one kernel and method.
fn refused_sums_of<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>, method: Method, wanted: field::Wanted) {
    const N: usize = 300;
    let options = Options { method: Some(method), tolerance: 1e-6, ..Options::default() };
    let (x, y): (Vec<[T; D]>, Vec<[T; D]>) = (narrow(&cloud(N, 1)), narrow(&cloud(N + 5, 2)));
    let m = vec![T::from_f64(0.1); N];
    let plan = field::plan(kernel, N, N + 5, wanted, &options).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
    let mut call = |x: &[[T; D]], m: &[T], y: &[[T; D]]| {
        let (mut u, mut g, mut l) = (vec![T::ONE; N + 5], vec![[T::ONE; D]; N + 5], vec![T::ONE; N + 5]);
        let outputs = Outputs {
            potential: wanted.potential.then_some(&mut u[..]),
            gradient: wanted.gradient.then_some(&mut g[..]),
            laplacian: wanted.laplacian.then_some(&mut l[..]),
            hessian: None,
        };
        let (sources, memory) = (Sources::new(x, m), memory.bytes());
        let result = field::evaluate(&plan, kernel, sources, y, outputs, memory, &mut Run::default());
        (result, u.iter().chain(g.as_flattened()).chain(&l).all(|&v| v == T::ONE))
    };
    assert_eq!(call(&x, &m, &y), (Ok(()), false), "{D}D {method:?}");
    let refused = (Err(Error::NotFinite), true);
    for value in bad::<T>() {
        for at in places(N) {
            let (mut x, mut m) = (x.clone(), m.clone());
            m[at] = value;
            assert_eq!(call(&x, &m, &y), refused, "{D}D {method:?}, mass {at}: {value:?}");
            m[at] = T::ONE;
            for k in 0..D {
                let before = x[at][k];
                x[at][k] = value;
                assert_eq!(call(&x, &m, &y), refused, "{D}D {method:?}, source {at} {k}: {value:?}");
                // Also where its mass is zero.
                m[at] = T::ZERO;
                assert_eq!(call(&x, &m, &y), refused, "{D}D {method:?}, massless source {at} {k}: {value:?}");
                (x[at][k], m[at]) = (before, T::ONE);
            }
        }
        for at in places(N + 5) {
            let mut y = y.clone();
            y[at][D - 1] = value;
            assert_eq!(call(&x, &m, &y), refused, "{D}D {method:?}, target {at}: {value:?}");
        }
    }
}

fn refused_sums<T: Real, const D: usize>() {
    let all = field_bounds::ALL;
    let newtonian = [term(Law::Newtonian, 1.0)];
    for shape in [(Mollifier::None, 0.0), (COMPACT, 0.25), (Mollifier::Plummer, 0.25)] {
        with_kernel::<T, D, _>(&newtonian, shape, |kernel| refused_sums_of(kernel, Method::Direct, all));
    }
    with_kernel::<T, D, _>(&newtonian, (COMPACT, 0.25), |kernel| {
        refused_sums_of(kernel, Method::Neighbours, LAPLACIAN)
    });
    let split = [term(power(2.0), 1.0), term(Law::Newtonian, 1.0)];
    with_kernel::<T, D, _>(&split, (COMPACT, 0.25), |kernel| refused_sums_of(kernel, Method::Direct, all));
    with_kernel::<T, D, _>(&[term(power(4.0), 1.0)], (Mollifier::None, 0.0), |kernel| {
        refused_sums_of(kernel, Method::Moments, all);
    });
    with_kernel::<T, D, _>(&[term(power(1.5), 1.0)], (COMPACT, 0.25), |kernel| {
        refused_sums_of(kernel, Method::Direct, all);
    });
}

#[test]
fn sums_refuse_what_is_not_finite() {
    refused_sums::<f64, 1>();
    refused_sums::<f64, 2>();
    refused_sums::<f64, 3>();
    refused_sums::<f32, 2>();
    let newtonian = [term(Law::Newtonian, 1.0)];
    let shape = (Mollifier::None, 0.0);
    with_kernel::<f64, 1, _>(&newtonian, shape, |kernel| refused_sums_of(kernel, Method::Sorted, field_bounds::ALL));
    with_kernel::<f64, 2, _>(&newtonian, shape, |kernel| refused_sums_of(kernel, Method::Fmm, field_bounds::ALL));
}

/// A run with tracers and densities: the first bad point is told, and nothing but the report is written.
#[test]
fn runs_refuse_what_is_not_finite() {
    const N: usize = 20;
    const TRACERS: usize = 7;
    let kernel = kernel::<f64, 2>(1.0, None);
    let wanted = Wanted { density: true, velocity: true, ..Wanted::default() };
    let plan = aggregation::plan(&kernel, N, TRACERS, wanted, &Options::default()).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes::<f64, 2>(1).unwrap());
    // Positions, densities and masses of particles, positions and densities of tracers: one array, in which any number may be bad.
    let numbers: Vec<f64> = cloud::<1>(4 * N + 3 * TRACERS, 3).iter().map(|[x]| x.abs() + 0.1).collect();
    let mut call = |numbers: &[f64], dt: f64, steps: usize| {
        let (x, rest) = numbers.split_at(2 * N);
        let (rho, rest) = rest.split_at(N);
        let (m, rest) = rest.split_at(N);
        let (y, rest) = rest.split_at(2 * TRACERS);
        let mut x = x.as_chunks::<2>().0.to_vec();
        let (mut rho, mut y, mut sigma) = (rho.to_vec(), y.as_chunks::<2>().0.to_vec(), rest.to_vec());
        let (mut v, mut w) = (vec![[7.0; 2]; N], vec![[7.0; 2]; TRACERS]);
        let mut report = Report { steps: 9, first_bad: Some(9), energy: None };
        let particles =
            Trajectories { positions: &mut x, density: Some(&mut rho), velocity: Some(&mut v), divergence: None };
        let tracers =
            Trajectories { positions: &mut y, density: Some(&mut sigma), velocity: Some(&mut w), divergence: None };
        let advance = Advance { dt, steps, after_step: None };
        let state = State { masses: m, particles, tracers };
        let (memory, mut run) = (memory.bytes(), Run::default());
        let result = aggregation::step(&plan, &kernel, state, advance, memory, &mut run, &mut report);
        let now = [x.as_flattened(), &rho, m, y.as_flattened(), &sigma].concat();
        let same = now.iter().zip(numbers).all(|(a, b)| a.to_bits() == b.to_bits());
        (result, report, same && v.iter().chain(&w).flatten().all(|&v| v == 7.0))
    };
    let owner = |at: usize| match at {
        0..40 => at / 2,
        40..60 => at - 40,
        60..80 => at - 60,
        80..94 => N + (at - 80) / 2,
        _ => N + at - 94,
    };
    let refused = |bad| Report { steps: 0, first_bad: bad, energy: None };
    for (at, value) in (0..101).flat_map(|at| bad::<f64>().map(|value| (at, value))) {
        for steps in [0, 3] {
            let mut numbers = numbers.clone();
            numbers[at] = value;
            let want = (Err(Error::NotFinite), refused(Some(owner(at))), true);
            assert_eq!(call(&numbers, 1e-3, steps), want, "{at} {value}");
            // The first of two.
            let last = if at < 80 { 79 } else { 100 };
            numbers[last] = value;
            assert_eq!(call(&numbers, 1e-3, steps).1, refused(Some(owner(at).min(owner(last)))), "{at} {value}");
        }
    }
    for dt in bad::<f64>().into_iter().chain([0.0, -0.0, -1.0]) {
        assert_eq!(call(&numbers, dt, 1), (Err(Error::TimeStep), refused(None), true), "{dt}");
    }
    assert_eq!(call(&numbers, f64::NAN, 0).0, Ok(()));
}

/// One source: a result beyond the range is infinite, of the sign of the true one, and the other targets' are not touched.
fn overflows_of<T: Real, const D: usize>() {
    let point = |r: f64| {
        let mut x = [T::ZERO; D];
        x[0] = T::from_f64(r);
        x
    };
    let heavy = T::MAX.to_f64() / 4.0;
    let far = 1e3;
    for sign in [1.0, -1.0] {
        for level in Level::available() {
            let (x, m) = ([point(0.0)], [T::from_f64(sign * heavy)]);
            let targets = [point(far), point(-1e-6), point(1e-6), point(2.0 * far)];
            let kernel = kernel::<T, D>(1.0, None);
            let sources = Sources::new(&x, &m);
            let got = hessians::run(
                &kernel,
                (sources, &targets),
                field_bounds::ALL,
                &Options { method: Some(Method::Direct), ..Options::default() },
                (level, &Serial),
            );
            // Beyond one dimension mass / (S_D r^(D - 1)) overflows at 1e-6.
            if D > 1 {
                let want = T::from_f64(sign) * T::INFINITY;
                assert_eq!((got.gradient[1][0], got.gradient[2][0]), (-want, want), "{D}D {}", level.name());
            }
            let sphere = [2.0, std::f64::consts::TAU, 2.0 * std::f64::consts::TAU][D - 1];
            for (k, r) in [(0, far), (3, 2.0 * far)] {
                let want = m[0].to_f64() / sphere / r.powi(D as i32 - 1);
                let error = got.gradient[k][0].to_f64() / want - 1.0;
                assert!(error.abs() <= 300.0 * T::EPSILON.to_f64(), "{D}D {}: {:?}", level.name(), got.gradient);
            }
        }
    }
}

#[test]
fn results_out_of_range_are_infinite() {
    overflows_of::<f64, 1>();
    overflows_of::<f64, 2>();
    overflows_of::<f64, 3>();
    overflows_of::<f32, 1>();
    overflows_of::<f32, 2>();
    overflows_of::<f32, 3>();
}

/// |x|^4 / 4, far too long a step: each raises the distance to a power, until a number leaves the range. The state is that after the completed steps, bit for bit, and velocities are not
/// written. A state whose velocity alone overflows has no velocity.
fn stops_of<T: Real>() {
    let terms = [Term { law: power(4.0), coefficient: 1.0 }];
    with_kernel::<T, 2, _>(&terms, (Mollifier::None, 0.0), |kernel| {
        let wanted = Wanted { velocity: true, ..Wanted::default() };
        let plan = aggregation::plan(kernel, 3, 0, wanted, &Options::default()).unwrap();
        let mut memory = Aligned::new(plan.workspace_bytes::<T, 2>(1).unwrap());
        let m = [T::ONE; 3];
        let start = [[T::ONE, T::ZERO], [-T::ONE, T::ZERO], [T::ZERO; 2]];
        let mut call = |x: &mut [[T; 2]], steps: usize| {
            let mut v = [[T::from_f64(7.0); 2]; 3];
            let particles = Trajectories { positions: x, velocity: Some(&mut v), ..Trajectories::none() };
            let state = State { masses: &m, particles, tracers: Trajectories::none() };
            let advance = Advance { dt: T::HALF, steps, after_step: None };
            let (mut run, mut report) = (Run::default(), Report::default());
            let result = aggregation::step(&plan, kernel, state, advance, memory.bytes(), &mut run, &mut report);
            (result, report.steps, v.iter().flatten().all(|&v| v.to_f64() == 7.0))
        };
        let mut x = start;
        let (result, steps, unwritten) = call(&mut x, 1000);
        assert_eq!((result, unwritten), (Err(Error::BecameNotFinite), true));
        assert!(steps > 0 && steps < 20 && x.iter().flatten().all(|c| c.is_finite()), "{steps}");
        let mut again = start;
        for done in 0..steps {
            let (result, one, _) = call(&mut again, 1);
            // The last velocities may overflow where the positions do not.
            assert!(result == Ok(()) || done + 1 == steps);
            assert_eq!(one, 1);
        }
        assert_eq!(x, again);
        // It does not recover.
        let (result, none, unwritten) = call(&mut x, 1);
        assert_eq!((result, none, unwritten, x), (Err(Error::BecameNotFinite), 0, true, again));
        // Positions at the end of the range, at rest in one place, are as good as others.
        let mut x = [[T::MAX, -T::MAX]; 3];
        assert_eq!(call(&mut x, 5), (Ok(()), 5, false));
        assert_eq!(x, [[T::MAX, -T::MAX]; 3]);
    });
}

#[test]
fn a_run_stops_at_its_last_finite_state() {
    stops_of::<f64>();
    stops_of::<f32>();
}
