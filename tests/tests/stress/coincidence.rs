//! Coincident particles stay together, as they feel the same field.

use mollis_core::Real;
use mollis_core::aggregation::Wanted;
use mollis_core::diagnostics::stable_step_anywhere;
use mollis_core::field::{Method, Options};
use mollis_core::kernel::Kernel;
use mollis_core::rk4::REAL_STABILITY;
use mollis_core::simd::Level;
use mollis_reference::field::Soft;
use mollis_tests::Split;

use super::{Stepper, cloud, kernel, narrow, size};

/// A bound of the rate of change of the velocity in the square.
fn largest_rate<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>, m: &[T]) -> f64 {
    let mass = m.iter().fold(T::ZERO, |sum, &m| sum + m);
    REAL_STABILITY / stable_step_anywhere(kernel, mass, T::from_i32(8)).unwrap().to_f64()
}

/// Seven particles in each place, in any order. At level portable a result does not depend on the other targets, so they stay together bit for bit, and singular kernels never see them apart.
/// At other levels the last bits may differ: a mollified field, of which the rate of change is bounded, keeps them as close as that.
fn stay_of<T: Real, const D: usize>() {
    const EACH: usize = 7;
    let (dt, steps) = (1e-3, size(10, 200));
    for n in [14_usize, 126, 299] {
        let (places, mut numbers) = (cloud::<D>(n.div_ceil(EACH), 11), Split(12));
        let mut order: Vec<usize> = (0..n).collect();
        (1..n).rev().for_each(|k| order.swap(k, (numbers.next() % (k as u64 + 1)) as usize));
        let start: Vec<[T; D]> = narrow(&order.iter().map(|k| places[k / EACH]).collect::<Vec<_>>());
        let m: Vec<T> = (0..n).map(|_| T::from_f64((numbers.uniform() + 0.1) / n as f64)).collect();
        let soft = Some(Soft { order: 2, exponent: 4, delta: 1.0 });
        for (coefficient, soft) in [(1.0, soft), (-1.0, soft), (1.0, None), (-1.0, None)] {
            let kernel = kernel::<T, D>(coefficient, soft);
            for level in Level::available().filter(|&level| soft.is_some() || level == Level::Portable) {
                for method in [Some(Method::Direct), None] {
                    let options = Options { method, ..Options::default() };
                    let mut stepper = Stepper { level, ..Stepper::new(&kernel, n, Wanted::default(), &options) };
                    let mut x = start.clone();
                    assert_eq!(stepper.step(&mut x, &m, T::from_f64(dt), steps).0, Ok(()));
                    // A rounding in each step, which grows like the exponential of the largest rate of change.
                    let growth = || (dt * steps as f64 * largest_rate(&kernel, &m)).exp();
                    let bound = if level == Level::Portable { 0.0 } else { 4.0 * steps as f64 * growth() };
                    for k in 0..n {
                        let first = (0..n).find(|&j| order[j] / EACH == order[k] / EACH).unwrap();
                        let apart = x[k].iter().zip(&x[first]).map(|(a, b)| (a.to_f64() - b.to_f64()).abs());
                        let apart = apart.fold(0.0, f64::max);
                        let what = format!("{D}D {n} {coefficient} {soft:?} {} {method:?}", level.name());
                        assert!(apart <= bound * T::EPSILON.to_f64(), "{what} {k}: {apart:e}");
                    }
                    assert!(x.iter().zip(&start).any(|(x, y)| x != y));
                }
            }
        }
    }
}

#[test]
fn coincident_particles_stay_together() {
    stay_of::<f64, 1>();
    stay_of::<f64, 2>();
    stay_of::<f64, 3>();
    stay_of::<f32, 1>();
    stay_of::<f32, 2>();
    stay_of::<f32, 3>();
}
