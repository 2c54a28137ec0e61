//! The host's floating-point control: directed rounding, no subnormal numbers, traps. Rust's own arithmetic is that of the caller, so all of a call is done under that control.
//!
//! A rounding in another direction is at most twice as large, so twice the stated bound holds to first order; four times that is allowed.

use mollis_core::Real;
use mollis_core::exec::Serial;
use mollis_core::field::Method;
use mollis_core::pks::Options;
use mollis_core::simd::Level;
use mollis_reference::field::Soft;
use mollis_tests::control::Control;
use mollis_tests::exceptions::Rows;

use super::coalescing::System;
use super::sums::{close_cloud, signed_masses};
use super::{Scene, Stepper, cloud, kernel, narrow, size};

/// Scenes with near-collisions, long and short mollifiers, and masses of many sizes, without subnormal numbers.
fn scenes<T: Real, const D: usize>(shortest: f64) -> Vec<Scene<T, D>> {
    let soft = |delta| Some(Soft { order: 2, exponent: 4, delta });
    let x = close_cloud::<T, D>(1e-9, 5);
    let wild: Vec<f64> = (0..48).map(|k| 10_f64.powi(15 - k % 30)).collect();
    let mut scenes = Vec::new();
    for delta in [None, soft(shortest), soft(1e-9), soft(0.3), soft(1e12)] {
        scenes.push(Scene::new(&x, &signed_masses(48, 5), delta));
        scenes.push(Scene::new(&cloud(48, 6), &wild, delta));
    }
    scenes
}

fn sums_of<T: Real, const D: usize>() {
    for scene in scenes::<T, D>(1e-12) {
        for (control, level) in Control::ALL.into_iter().flat_map(|c| Level::available().map(move |l| (c, l))) {
            for method in [Some(Method::Direct), None] {
                let got = control.during(|| scene.sums(method, (level, &Serial)));
                scene.check(&got, 4.0, &format!("{}, {} {method:?}", control.name, level.name()));
            }
        }
    }
}

#[test]
fn sums_keep_four_times_their_bound_under_any_rounding() {
    sums_of::<f64, 1>();
    sums_of::<f64, 2>();
    sums_of::<f64, 3>();
    sums_of::<f32, 1>();
    sums_of::<f32, 2>();
    sums_of::<f32, 3>();
}

/// Two particles in the plane: (r^2)' = -(m + m') / pi. Directed roundings do not cancel: 512 steps of one u each in one direction.
#[test]
fn runs_follow_their_closed_form_under_any_rounding() {
    let kernel = kernel::<f64, 2>(1.0, None);
    for control in Control::ALL {
        let (mut x, m) = ([[0.0, 0.0], [0.6, 0.8]], [1.0, 0.25]);
        let dt = std::f64::consts::PI / (1.25 * 1024.0);
        let (result, report) = control.during(|| Stepper::plain(&kernel, 2).step(&mut x, &m, dt, 512));
        assert_eq!((result, report.steps), (Ok(()), 512));
        let r = (x[1][0] - x[0][0]).hypot(x[1][1] - x[0][1]);
        assert!((r - 0.5_f64.sqrt()).abs() <= 1e-10, "{}: {r}", control.name);
        for (k, c) in [0.15, 0.2].into_iter().enumerate() {
            assert!((x[0][k] + 0.25 * x[1][k] - c).abs() <= 4.0 * 512.0 * f64::EPSILON, "{}", control.name);
        }
    }
}

/// Numbers below the normal range are numbers or zero: results are finite, and steps end.
fn subnormal_of<T: Real>() {
    let small = T::MIN_POSITIVE.to_f64() / 8.0;
    let x: Vec<[f64; 2]> = cloud(48, 3).iter().map(|x: &[f64; 2]| x.map(|c| c * small)).collect();
    let m: Vec<f64> = signed_masses(48, 3).iter().map(|m| m * small).collect();
    for soft in [None, Some(Soft { order: 2, exponent: 4, delta: 0.5 })] {
        let scene = Scene::<T, 2>::new(&x, &m, soft);
        for (control, level) in Control::ALL.into_iter().flat_map(|c| Level::available().map(move |l| (c, l))) {
            let got = control.during(|| scene.sums(Some(Method::Direct), (level, &Serial)));
            let finite = got.gradient.as_flattened().iter().chain(&got.potential).chain(&got.laplacian);
            assert!(finite.clone().all(|v| v.is_finite()), "{} {} {soft:?}", control.name, level.name());
        }
    }
}

#[test]
fn subnormal_numbers_give_finite_results_under_any_rounding() {
    subnormal_of::<f64>();
    subnormal_of::<f32>();
}

fn coalescing<T: Real>() -> System<T> {
    let m = (0..40).map(|k| T::from_f64(0.05 * (1.0 + k as f64))).collect();
    System::new(Some(1e-2), Options::new(T::from_f64(4.0), T::from_f64(0.05)), narrow(&cloud(40, 4)), m)
}

fn steps_of<T: Real>() {
    for control in Control::ALL {
        let mut system = coalescing::<T>();
        let (whole, steps) = (system.mass(), size(20, 500));
        control.during(|| {
            for _ in 0..steps {
                assert_eq!(system.step(T::from_f64(1e-2)), Ok(()), "{}", control.name);
            }
        });
        // Each merge rounds once, by at most a unit.
        assert!((system.mass() / whole - 1.0).abs() <= 42.0 * T::EPSILON.to_f64(), "{}", control.name);
        assert!(system.x[..system.count()].iter().flatten().all(|c| c.is_finite()) && system.count() < 40);
    }
}

#[test]
fn coalescing_particles_conserve_mass_under_any_rounding() {
    steps_of::<f64>();
    steps_of::<f32>();
}

/// What raises no exception does not trap. The flags come first, as a failure then has a name.
fn traps_of<T: Real, const D: usize>(rows: &mut Rows, traps: bool) {
    let mut row = |what: String, call: &mut dyn FnMut()| {
        rows.row(what, || {
            if traps {
                Control::TRAPS.during(&mut *call)
            } else {
                call()
            }
            0
        });
    };
    // Masses of 1e15 over the square of a shorter length are out of the range of single precision.
    for (k, scene) in scenes::<T, D>(if T::DIGITS > 24 { 1e-12 } else { 1e-11 }).iter().enumerate() {
        for level in Level::available() {
            for method in [Some(Method::Direct), None] {
                row(format!("{D}D scene {k}, {} {method:?}", level.name()), &mut || {
                    scene.sums(method, (level, &Serial));
                });
            }
        }
        row(format!("{D}D run {k}"), &mut || {
            let kernel = kernel::<T, D>(-1.0, scene.soft);
            let (mut x, dt) = (scene.x.clone(), T::from_f64(1e-20));
            assert_eq!(Stepper::plain(&kernel, x.len()).step(&mut x, &scene.m, dt, 3).0, Ok(()));
        });
    }
}

#[test]
fn no_call_traps() {
    for traps in [false, true] {
        let mut rows = Rows::default();
        traps_of::<f64, 1>(&mut rows, traps);
        traps_of::<f64, 2>(&mut rows, traps);
        traps_of::<f64, 3>(&mut rows, traps);
        traps_of::<f32, 1>(&mut rows, traps);
        traps_of::<f32, 2>(&mut rows, traps);
        let mut system = coalescing::<f64>();
        rows.row("coalescing", || {
            let mut steps = || (0..20).all(|_| system.step(1e-2) == Ok(()));
            i32::from(!if traps { Control::TRAPS.during(steps) } else { steps() })
        });
        rows.finish();
    }
}
