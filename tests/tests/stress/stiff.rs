//! Steps below, at and beyond the estimates of the stable step.

use mollis_core::aggregation::Wanted;
use mollis_core::diagnostics::{stable_step, stable_step_anywhere};
use mollis_core::field::Options;
use mollis_core::kernel::Law;
use mollis_core::mollifier::Mollifier;
use mollis_core::rk4::REAL_STABILITY;
use mollis_core::{Error, Real};
use mollis_reference::field::Soft;

use super::{Scene, Stepper, cloud, first_moment, kernel, size, wide};
use crate::field_bounds::{power, term, with_kernel};

/// The factor of a step of RK4 for y' = lambda y, z = lambda dt.
fn amplification(z: f64) -> f64 {
    1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))
}

/// |x|^2 / 2: about the centre of mass, x' = -M x. So a step multiplies distances by a polynomial, which is at most 1 up to the end of the stability interval, and beyond it makes them grow until
/// they leave the range.
fn linear_of<T: Real, const D: usize>() {
    let eps = T::EPSILON.to_f64();
    let x: Vec<[T; D]> = super::narrow(&cloud::<D>(30, 4));
    let m: Vec<T> = (0..30).map(|k| T::from_f64(0.125 * f64::from(1 + k % 3))).collect();
    let mass: f64 = m.iter().map(|m| m.to_f64()).sum();
    let centre = first_moment(&x, &m).0.map(|c| c / mass);
    let run = |kernel: &mollis_core::kernel::Kernel<'_, T, D>| {
        // 2 (M - the least mass) for velocities, d (M - the least mass) for densities.
        let estimate = stable_step(kernel, &x, &m).unwrap().to_f64();
        let rate = f64::max(2.0, D as f64) * (mass - 0.125);
        assert!((estimate * rate / REAL_STABILITY - 1.0).abs() < 1e-5, "{estimate}");
        let limit = REAL_STABILITY / mass;
        for factor in [1e-12, 0.1, 0.5, 0.9, 0.999, 1.001, 1.5, 4.0, 40.0, 1e4] {
            let dt = T::from_f64(factor * limit);
            let (z, mut y, mut stepper) = (-mass * dt.to_f64(), x.clone(), Stepper::plain(kernel, 30));
            let r = amplification(z);
            assert_eq!(r.abs() < 1.0, factor < 1.0);
            // A step rounds numbers as large as its stages.
            let stage = (1.0 + z.abs()).powi(4);
            let (mut size_of, mut steps) = (1.0_f64, 0);
            let most = size(40, 4000);
            let stopped = loop {
                let before = y.clone();
                let (result, report) = stepper.step(&mut y, &m, dt, 1);
                if result.is_err() {
                    assert_eq!((result, report.steps, &y), (Err(Error::BecameNotFinite), 0, &before));
                    break true;
                }
                (steps, size_of) = (steps + 1, f64::max(1.0, size_of * r.abs()));
                // The errors of all steps grow by the same factor.
                let bound = 64.0 * eps * stage * size_of * f64::from(steps);
                for (x, y) in wide(&x).iter().zip(wide(&y)) {
                    for k in 0..D {
                        let want = centre[k] + r.powi(steps) * (x[k] - centre[k]);
                        let error = (y[k] - want).abs();
                        assert!(error <= bound, "{D}D {factor} {steps}: {} {want}, {}", y[k], error / bound);
                    }
                }
                if steps == most {
                    break false;
                }
            };
            // It stops only where the next step may have numbers out of range. A state never holds one.
            let next = 100.0 * mass * size_of * stage;
            assert!(if stopped { next > T::MAX.to_f64() } else { size_of <= T::MAX.to_f64() }, "{factor} {next:e}");
        }
    };
    with_kernel::<T, D, _>(&[term(power(2.0), 1.0)], (Mollifier::None, 0.0), run);
}

#[test]
fn linear_fields_follow_the_stability_polynomial() {
    linear_of::<f64, 1>();
    linear_of::<f64, 2>();
    linear_of::<f64, 3>();
    linear_of::<f32, 1>();
    linear_of::<f32, 2>();
    linear_of::<f32, 3>();
}

/// At the estimate for all states the energy never rises and the centre of mass stays, for mollifiers of 1e-12 to 1e12 of the spacing.
fn energies_of<T: Real, const D: usize>() {
    let eps = T::EPSILON.to_f64();
    for exponent in (-12..=12).step_by(size(4, 1)) {
        for (coefficient, order) in [(1.0, 2), (-1.0, 2), (1.0, 4), (-1.0, 4)] {
            let soft = Some(Soft { order, exponent: 4, delta: 10_f64.powi(exponent) });
            let kernel = kernel::<T, D>(coefficient, soft);
            let m: Vec<f64> = (0..24).map(|k| f64::from(1 + k % 5) / 64.0).collect();
            let mut scene = Scene::<T, D>::new(&cloud::<D>(24, 9), &m, soft);
            let mass: f64 = m.iter().sum();
            // Repulsion spreads the particles, and the largest second derivatives are at the shortest distances.
            let dt = stable_step_anywhere(&kernel, T::from_f64(mass), T::from_f64(16.0)).unwrap();
            let wanted = Wanted { energy: true, ..Wanted::default() };
            let mut stepper = Stepper::new(&kernel, 24, wanted, &Options::default());
            for step in 0..size(8, 60) {
                let ([before, size_of], (moment, length)) = (scene.energy(), first_moment(&scene.x, &scene.m));
                let mut x = scene.x.clone();
                let (result, report) = stepper.step(&mut x, &scene.m, dt, 1);
                assert_eq!((result, report.steps), (Ok(()), 1), "{D}D {soft:?} {coefficient} {step} {report:?}");
                scene = Scene::new(&wide(&x), &m, soft);
                let rose = coefficient * (scene.energy()[0] - before);
                // Positions are rounded: by u of a step's numbers, which changes an energy by its gradient, at most |K| over the mollifier's length or the spacing.
                assert!(rose <= 64.0 * eps * (size_of + mass * mass), "{D}D {soft:?} {coefficient} {step}: {rose:e}");
                let (after, longer) = first_moment(&scene.x, &scene.m);
                for k in 0..D {
                    let drift = (after[k] - moment[k]).abs();
                    assert!(drift <= 16.0 * eps * length.max(longer), "{D}D {soft:?} {step}: {drift:e}");
                }
            }
        }
    }
}

#[test]
fn energies_fall_at_the_estimate() {
    energies_of::<f64, 1>();
    energies_of::<f64, 2>();
    energies_of::<f64, 3>();
    energies_of::<f32, 1>();
    energies_of::<f32, 2>();
    energies_of::<f32, 3>();
}

/// Beyond the estimate a rise is told, and the state is that after the step which raised it. Two particles under |x|^2 / 2: the energy is multiplied by the square of the step's factor.
#[test]
fn a_rising_energy_stops_the_run() {
    with_kernel::<f64, 2, _>(&[term(Law::Power { exponent: 2.0 }, 1.0)], (Mollifier::None, 0.0), |kernel| {
        let m = [1.0, 1.0];
        let wanted = Wanted { energy: true, ..Wanted::default() };
        for (factor, falls) in [(0.5, true), (0.99, true), (1.01, false), (3.0, false), (1e3, false)] {
            let (mut x, dt) = ([[1.0, 0.0], [-1.0, 0.0]], factor * REAL_STABILITY / 2.0);
            let r = amplification(-2.0 * dt);
            let (result, report) = Stepper::new(kernel, 2, wanted, &Options::default()).step(&mut x, &m, dt, 5);
            let (first, last) = report.energy.unwrap();
            // m m' |x - y|^2 / 2 / 2, twice.
            assert!((first - 2.0).abs() < 1e-12, "{first}");
            if falls {
                assert_eq!((result, report.steps), (Ok(()), 5));
                assert!((last / (2.0 * r.powi(10)) - 1.0).abs() < 1e-9, "{factor} {last}");
            } else {
                assert_eq!((result, report.steps), (Err(Error::EnergyRose), 1));
                assert!((last / (2.0 * r * r) - 1.0).abs() < 1e-9, "{factor} {last}");
                assert!((x[0][0] / r - 1.0).abs() < 1e-9 && x[1][0] == -x[0][0], "{factor} {x:?}");
            }
        }
    });
}
