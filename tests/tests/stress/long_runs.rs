//! A million steps, and single against double precision.

use std::f64::consts::TAU;

use mollis_core::Real;
use mollis_core::aggregation::Wanted;
use mollis_core::field::Options;
use mollis_core::mollifier::Mollifier;
use mollis_reference::field::Soft;

use super::{Stepper, cloud, first_moment, kernel, narrow, size, wide};
use crate::field_bounds::{power, term, with_kernel};

/// Two vortices turn about their centre at the rate (m + m') / (2 pi r^2), clockwise, for ever.
fn vortices_of<T: Real>() {
    let (eps, steps) = (T::EPSILON.to_f64(), size(2000, 1_000_000));
    let options = Options { combination: (0.0, 1.0), ..Options::default() };
    for (other, soft) in [(1.0, None), (1e-6, None), (0.5, Some(Soft { order: 2, exponent: 4, delta: 0.5 }))] {
        // Beyond its length a compact mollifier is not felt.
        let kernel = kernel::<T, 2>(1.0, soft);
        let (mut x, m) = ([[T::ONE, T::ZERO], [T::ZERO, T::ZERO]], [T::ONE, T::from_f64(other)]);
        let rate = (1.0 + m[1].to_f64()) / TAU;
        let dt = T::from_f64(0.01 / rate);
        let angle = rate * dt.to_f64();
        let (before, length) = first_moment(&x, &m);
        let (result, report) = Stepper::new(&kernel, 2, Wanted::default(), &options).step(&mut x, &m, dt, steps);
        assert_eq!((result, report.steps), (Ok(()), steps));
        let [dx, dy] = [0, 1].map(|k| x[0][k].to_f64() - x[1][k].to_f64());
        // Fourth order: angle^5 a step. Roundings in all directions add up as a random walk.
        let (n, walk) = (steps as f64, eps * (steps as f64).sqrt());
        let bound = n * angle.powi(5) + 16.0 * walk;
        assert!((dx.hypot(dy) - 1.0).abs() <= bound, "{other} {}: {bound:e}", dx.hypot(dy));
        let after = first_moment(&x, &m).0;
        assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() <= 4.0 * walk * length), "{before:?} {after:?}");
        // In single precision the rate follows the rounded distance.
        if T::DIGITS > 24 {
            let turned = (dy.atan2(dx) + n * angle) / TAU;
            let left = TAU * (turned - turned.round());
            assert!(left.abs() <= 2.0 * bound + 1e-9, "{other}: {left:e} {bound:e}");
        }
    }
}

#[test]
fn vortices_turn_for_ever() {
    vortices_of::<f64>();
    vortices_of::<f32>();
}

/// Particles that settle under |x|^4 / 4 - |x|^1.5 / 1.5: the energy never rises beyond rounding, the centre of mass stays, and the radius is bounded.
fn settling_of<T: Real>() {
    let (eps, steps) = (T::EPSILON.to_f64(), size(2000, 1_000_000));
    with_kernel::<T, 2, _>(&[term(power(4.0), 1.0), term(power(1.5), -1.0)], (Mollifier::None, 0.0), |kernel| {
        let (mut x, m) = (narrow::<T, 2>(&cloud(9, 21)), [T::from_f64(1.0 / 8.0); 9]);
        let before = first_moment(&x, &m).0;
        let wanted = Wanted { energy: true, ..Wanted::default() };
        let mut stepper = Stepper::new(kernel, 9, wanted, &Options::default());
        let (result, report) = stepper.step(&mut x, &m, T::from_f64(0.01), steps);
        assert_eq!((result, report.steps), (Ok(()), steps));
        let (first, last) = report.energy.unwrap();
        assert!(last < first, "{first} {last}");
        let after = first_moment(&x, &m).0;
        // Roundings of positions of order one, as a random walk.
        let bound = 4.0 * eps * (steps as f64).sqrt();
        assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() <= bound), "{before:?} {after:?} {bound:e}");
        // At a distance of 2 a particle's attraction, r^3, exceeds the repulsion, r^0.5, and all of them were closer than 2.9.
        assert!(wide(&x).iter().flatten().all(|c| c.abs() < 3.0));
    });
}

#[test]
fn settled_particles_stay() {
    settling_of::<f64>();
    settling_of::<f32>();
}

/// Under |x|^4 / 4 + |x|^2 / 2, which is convex, two solutions approach each other in the norm (sum m |x|^2)^(1/2), so roundings of single precision are not amplified: at most their sum is seen.
fn precisions_of<const D: usize>() {
    let steps = size(200, 20_000);
    let terms = [term(power(4.0), 1.0), term(power(2.0), 1.0)];
    for seed in 0..size(3, 10) {
        let single = narrow::<f32, D>(&cloud(50, seed));
        let double = wide(&single);
        let dt = 1.0 / 128.0;
        let run_of = |single: &mut Vec<[f32; D]>, double: &mut Vec<[f64; D]>| {
            with_kernel::<f32, D, _>(&terms, (Mollifier::None, 0.0), |kernel| {
                assert_eq!(Stepper::plain(kernel, 50).step(single, &[1.0 / 64.0; 50], dt as f32, steps).0, Ok(()));
            });
            with_kernel::<f64, D, _>(&terms, (Mollifier::None, 0.0), |kernel| {
                assert_eq!(Stepper::plain(kernel, 50).step(double, &[1.0 / 64.0; 50], dt, steps).0, Ok(()));
            });
        };
        let (mut x, mut y) = (single.clone(), double.clone());
        run_of(&mut x, &mut y);
        let square: f64 = wide(&x).as_flattened().iter().zip(y.as_flattened()).map(|(x, y)| (x - y).powi(2)).sum();
        // A step rounds a position of at most sqrt(D), and a field whose magnitudes add up to r^3 + r, r <= 2 sqrt(D), with 2 (c + 256) u, c = 32, while particles are apart: the time
        // constant of the attraction is 64 / 50.
        let u = 0.5 * f64::from(f32::EPSILON);
        let r = 2.0 * (D as f64).sqrt();
        let bound = (steps as f64 * r * u + 1.28 * 2.0 * 288.0 * u * (r.powi(3) + r)) * 50_f64.sqrt();
        assert!(square.sqrt() <= bound, "{D}D {seed}: {:e} {bound:e}", square.sqrt());
    }
}

#[test]
fn single_precision_follows_double_precision() {
    precisions_of::<1>();
    precisions_of::<2>();
    precisions_of::<3>();
}
