//! Two particles, and rings of them, whose distances have closed forms; what lies beyond a collision.
//!
//! Under c times the Newtonian kernel the distance of two particles of masses m and m' has `(r^D)' = -c D (m + m') / S_D`, S_D = 2, 2 pi, 4 pi. The radius R of a regular polygon of N particles
//! in the plane has `(R^2)' = -c (N - 1) m / (2 pi)`, as the others attract a corner like half of their mass in the centre.

use std::f64::consts::{PI, TAU};

use mollis_core::exec::Serial;
use mollis_core::field::{Options, Sources};
use mollis_core::kernel::Kernel;
use mollis_core::simd::Level;
use mollis_core::{Error, Real};

use super::{Stepper, first_moment, kernel, size};
use crate::field_bounds::ALL;
use crate::hessians;

const SPHERE: [f64; 4] = [0.0, 2.0, 2.0 * PI, 4.0 * PI];

/// Half of the way to a collision, or as long apart from each other, in 512 steps.
fn pairs_of<T: Real, const D: usize>() {
    const STEPS: usize = 512;
    let (d, eps) = (D as f64, T::EPSILON.to_f64());
    for coefficient in [1.0, -1.0] {
        let kernel = kernel::<T, D>(coefficient, None);
        for exponent in (0..=30).step_by(size(6, 1)) {
            for (r, swapped) in [1e-6, 1.0, 1e6].into_iter().flat_map(|r| [(r, false), (r, true)]) {
                let mut m = [T::ONE, T::from_f64(0.1_f64.powi(exponent))];
                // The heavy particle in the origin, where small displacements of it are not rounded away.
                let mut x = [[T::ZERO; D], [T::ZERO; D]];
                x[1][D - 1] = T::from_f64(r);
                if swapped {
                    (x, m) = ([x[1], x[0]], [m[1], m[0]]);
                }
                let (light, heavy) = (usize::from(!swapped), usize::from(swapped));
                let (before, r) = (first_moment(&x, &m).0, x[light][D - 1].to_f64());
                let rate = d * (m[0].to_f64() + m[1].to_f64()) / SPHERE[D];
                let dt = T::from_f64(r.powi(D as i32) / (2.0 * rate * STEPS as f64));
                let (result, _) = Stepper::plain(&kernel, 2).step(&mut x, &m, dt, STEPS);
                assert_eq!(result, Ok(()));
                let share = rate * dt.to_f64() * STEPS as f64 / r.powi(D as i32);
                let want = r * (1.0 - coefficient * share).powf(1.0 / d);
                let got = x[light][D - 1].to_f64() - x[heavy][D - 1].to_f64();
                // Fourth order: (1 / 1024)^4, with a factor below 100 up to here; and the roundings of the steps, which grow by no more than a factor of 2.
                let bound = 1e-10 + 4.0 * STEPS as f64 * eps;
                assert!((got / want - 1.0).abs() <= bound, "{D}D {exponent} {r} {swapped}: {got:e} {want:e}");
                // The heavy one has moved by as much as its share of the mass.
                let after = first_moment(&x, &m).0;
                let scale = m[light].to_f64() * r.max(want);
                // A velocity below the normal range is rounded to the spacing there.
                let lost = m[heavy].to_f64() * T::MIN_POSITIVE.to_f64() * dt.to_f64() * STEPS as f64;
                for (a, b) in before.iter().zip(&after) {
                    assert!(
                        (a - b).abs() <= 4.0 * STEPS as f64 * eps * scale + lost,
                        "{D}D {exponent} {r}: {a:e} {b:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn two_particles_of_any_masses_follow_their_closed_form() {
    pairs_of::<f64, 1>();
    pairs_of::<f64, 2>();
    pairs_of::<f64, 3>();
    pairs_of::<f32, 1>();
    pairs_of::<f32, 2>();
    pairs_of::<f32, 3>();
}

/// Rings that repel themselves from a radius of 1e-6 to one of 1e6, by steps in proportion to the square of the radius. Up to five corners the shape is stable.
fn blow_outs_of<T: Real>() {
    let kernel = kernel::<T, 2>(-1.0, None);
    for corners in 2..=5 {
        for mass in [1e-6, 1.0, 1e6] {
            let m = vec![T::from_f64(mass); corners];
            let corner = |k: usize| {
                let (y, x) = (TAU * k as f64 / corners as f64).sin_cos();
                [x, y].map(|c| T::from_f64(1e-6 * c))
            };
            let mut x: Vec<[T; 2]> = (0..corners).map(corner).collect();
            let rate = (corners - 1) as f64 * m[0].to_f64() / TAU;
            let (mut square, mut stepper) = (1e-12, Stepper::plain(&kernel, corners));
            while square < 1e12 {
                let dt = T::from_f64(0.02 * square / rate);
                assert_eq!(stepper.step(&mut x, &m, dt, 1).0, Ok(()));
                square += rate * dt.to_f64();
            }
            // An error decreases as the square of the radius grows, so that 50 steps count: 0.02^5 each, and roundings.
            let bound = 50.0 * (0.02_f64.powi(5) + 4.0 * T::EPSILON.to_f64());
            for x in &x {
                let radius = x[0].to_f64().hypot(x[1].to_f64());
                assert!(
                    (radius / square.sqrt() - 1.0).abs() <= bound,
                    "{corners} {mass}: {radius:e} {:e}",
                    square.sqrt()
                );
            }
            // Displacements of 1e6, of which each rounding is u.
            let (moment, size) = first_moment(&x, &m);
            assert!(moment.iter().all(|c| c.abs() <= bound * size), "{corners} {mass}: {moment:?}");
        }
    }
}

#[test]
fn repelling_rings_grow_by_twelve_orders_of_magnitude() {
    blow_outs_of::<f64>();
    blow_outs_of::<f32>();
}

/// The forces on the particles cancel, up to the errors that the sums' bound allows.
fn opposite<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>, x: &[[T; D]], m: &[T]) {
    let call = (Sources::new(x, m), x);
    let got = hessians::run(kernel, call, ALL, &Options::default(), (Level::best(), &Serial));
    let mut force = [0.0; D];
    for (g, m) in got.gradient.iter().zip(m) {
        force.iter_mut().zip(g).for_each(|(f, g)| *f += m.to_f64() * g.to_f64());
    }
    let mut scale = m.len() as f64 * T::MIN_POSITIVE.to_f64();
    for (i, y) in x.iter().enumerate() {
        for (j, z) in x.iter().enumerate() {
            let r = y.iter().zip(z).map(|(a, b)| (a.to_f64() - b.to_f64()).powi(2)).sum::<f64>().sqrt();
            if r > 0.0 {
                scale += m[i].to_f64() * m[j].to_f64() * r.powi(1 - D as i32) / SPHERE[D];
            }
        }
    }
    let fine = |f: &f64| f.abs() <= 300.0 * T::EPSILON.to_f64() * scale;
    assert!(scale > T::MAX.to_f64() / 16.0 || force.iter().all(fine), "{x:?} {m:?}: {force:?} {scale:e}");
}

/// Steps beyond a collision of singular particles: an explicit step moves them past each other, by any distance. Forces are opposite all the same, numbers are finite, and a step that fails
/// leaves the state.
fn collisions_of<T: Real, const D: usize>() {
    let mut failed = 0;
    for coefficient in [1.0, -1.0] {
        let kernel = kernel::<T, D>(coefficient, None);
        for exponent in (-30..=30).step_by(size(5, 1)) {
            let dt = T::from_f64(10_f64.powi(exponent));
            for (ratio, apart) in [(1.0, 1e-3), (1e-3, 1.0), (1e-12, 1e-12)] {
                let m = [T::ONE, T::from_f64(ratio), T::from_f64(0.5)];
                let mut x = [[T::ZERO; D]; 3];
                (x[1][0], x[2][0]) = (T::from_f64(apart), T::from_f64(-0.7));
                let mut stepper = Stepper::plain(&kernel, 3);
                for _ in 0..size(20, 200) {
                    let before = x;
                    let (result, report) = stepper.step(&mut x, &m, dt, 1);
                    if result.is_err() {
                        assert_eq!((result, report.steps, x), (Err(Error::BecameNotFinite), 0, before));
                        failed += 1;
                        break;
                    }
                    assert!(x.iter().flatten().all(|c| c.is_finite()));
                }
                opposite(&kernel, &x, &m);
            }
        }
    }
    // 1e30 times 1 / (4 pi 1e-24).
    assert!(failed > 0 || D < 3 || T::DIGITS > 24);
}

#[test]
fn steps_beyond_a_collision_stay_finite_or_stop() {
    collisions_of::<f64, 1>();
    collisions_of::<f64, 2>();
    collisions_of::<f64, 3>();
    collisions_of::<f32, 1>();
    collisions_of::<f32, 2>();
    collisions_of::<f32, 3>();
}
