//! Sums of near-collisions, coincident particles, lengths and masses of every size: within the stated bound of double-double sums.

use mollis_core::Real;
use mollis_core::exec::Serial;
use mollis_core::field::Method;
use mollis_core::simd::Level;
use mollis_reference::field::Soft;
use mollis_tests::Split;

use super::{Scene, cloud, size};

const SOFT: Soft = Soft { order: 2, exponent: 4, delta: 1.0 };

/// Each check in every dimension and scalar.
macro_rules! everywhere {
    ($check:ident) => {
        $check::<f64, 1>();
        $check::<f64, 2>();
        $check::<f64, 3>();
        $check::<f32, 1>();
        $check::<f32, 2>();
        $check::<f32, 3>();
    };
}

/// A cloud in which the first four particles are `apart` from each other around the origin, and some others are neighbouring numbers.
pub(super) fn close_cloud<T: Real, const D: usize>(apart: f64, seed: u64) -> Vec<[f64; D]> {
    let mut x = cloud::<D>(48, seed);
    x.iter_mut().take(4).for_each(|x| *x = x.map(|c| c * apart));
    for k in (6..48).step_by(6) {
        x[k] = x[k - 1].map(|c| c * (1.0 + T::EPSILON.to_f64()));
    }
    x
}

pub(super) fn signed_masses(n: usize, seed: u64) -> Vec<f64> {
    let mut numbers = Split(seed);
    (0..n).map(|_| numbers.uniform() - 0.3).collect()
}

fn near_collisions_of<T: Real, const D: usize>() {
    let last = if T::DIGITS > 24 { 300 } else { 36 };
    for exponent in (1..=last).step_by(size(last as usize / 6, 1)) {
        let apart = 0.1_f64.powi(exponent);
        let (x, m) = (close_cloud::<T, D>(apart, exponent as u64), signed_masses(48, 7));
        for soft in [None, Some(Soft { delta: 0.25, ..SOFT }), Some(Soft { order: 4, exponent: 3, delta: 2.0 * apart })]
        {
            Scene::<T, D>::new(&x, &m, soft).check_everywhere(&format!("{apart:e} apart"));
        }
    }
}

#[test]
fn near_collisions_keep_the_bound() {
    everywhere!(near_collisions_of);
}

/// From lengths that no two particles share to lengths in which all of them are one.
fn lengths_of<T: Real, const D: usize>() {
    for seed in 0..size(1, 8) {
        for exponent in (-12..=12).step_by(size(3, 1)) {
            let (x, m) = (cloud::<D>(48, seed), signed_masses(48, seed));
            for order in [2, 4] {
                let soft = Soft { order, exponent: 4, delta: 10_f64.powi(exponent) };
                Scene::<T, D>::new(&x, &m, Some(soft)).check_everywhere("lengths");
            }
        }
    }
}

#[test]
fn mollifiers_of_every_length_keep_the_bound() {
    everywhere!(lengths_of);
}

/// Masses of 1e-30 to 1e30, of either sign. Where two particles are alone, the light one's share of the field is felt too.
fn mass_ratios_of<T: Real, const D: usize>() {
    for seed in 0..size(2, 40) {
        let (x, mut numbers) = (cloud::<D>(48, seed), Split(seed));
        let mut mass =
            || (if numbers.uniform() < 0.3 { -1.0 } else { 1.0 }) * 10_f64.powf(60.0 * numbers.uniform() - 30.0);
        let m: Vec<f64> = (0..48).map(|_| mass()).collect();
        for soft in [None, Some(Soft { delta: 0.5, ..SOFT })] {
            Scene::<T, D>::new(&x, &m, soft).check_everywhere("masses");
        }
    }
    for exponent in (0..=30).step_by(size(10, 1)) {
        for (a, b) in [(1.0, 10_f64.powi(exponent)), (10_f64.powi(-exponent), 10_f64.powi(exponent))] {
            for soft in [None, Some(SOFT)] {
                Scene::<T, D>::new(&cloud::<D>(2, 3), &[a, b], soft).check_everywhere("two masses");
                Scene::<T, D>::new(&cloud::<D>(2, 3), &[b, -a], soft).check_everywhere("two masses");
            }
        }
    }
}

#[test]
fn masses_of_every_ratio_keep_the_bound() {
    everywhere!(mass_ratios_of);
}

/// Positions, masses and lengths below the normal range. In the plane a subnormal mass at a subnormal distance has a field of order one.
fn subnormal_numbers_of<T: Real, const D: usize>() {
    let small = 64.0 * T::MIN_POSITIVE.to_f64() * T::EPSILON.to_f64().sqrt();
    let scaled = |x: &[[f64; D]]| x.iter().map(|x| x.map(|c| c * small)).collect::<Vec<_>>();
    let (x, m) = (cloud::<D>(20, 5), signed_masses(20, 5));
    let light: Vec<f64> = m.iter().map(|m| m * small).collect();
    for soft in [None, Some(SOFT), Some(Soft { delta: small, ..SOFT })] {
        Scene::<T, D>::new(&x, &light, soft).check_everywhere("subnormal masses");
        Scene::<T, D>::new(&scaled(&x), &light, soft).check_everywhere("subnormal masses and positions");
        Scene::<T, D>::new(&scaled(&x), &m, soft).check_everywhere("subnormal positions");
    }
    // Beside ordinary ones.
    let both = m.iter().zip(&light).enumerate().map(|(k, (m, light))| if k % 2 == 0 { *m } else { *light });
    let both: Vec<f64> = both.collect();
    for soft in [None, Some(SOFT)] {
        Scene::<T, D>::new(&x, &both, soft).check_everywhere("some subnormal masses");
    }
}

#[test]
fn subnormal_numbers_keep_the_bound() {
    everywhere!(subnormal_numbers_of);
}

/// All particles in one place: without a mollifier nothing acts, and with one no gradient is left. Of clusters each particle feels the others only.
fn one_place_of<T: Real, const D: usize>() {
    for n in [1, 2, 9, 40, 129, 300] {
        let (x, m) = (vec![[0.7; D]; n], signed_masses(n, n as u64));
        for (soft, level) in [None, Some(SOFT)].into_iter().flat_map(|s| Level::available().map(move |l| (s, l))) {
            let scene = Scene::<T, D>::new(&x, &m, soft);
            let got = scene.sums(Some(Method::Direct), (level, &Serial));
            scene.check(&got, 1.0, "one place");
            assert!(got.gradient.iter().flatten().all(|&g| g == T::ZERO), "{D}D {soft:?} {}", level.name());
            assert!(soft.is_some() || got.potential.iter().chain(&got.laplacian).all(|&u| u == T::ZERO));
        }
        // Five places, one of them a zero of either sign.
        let places = cloud::<D>(5, 2);
        let x: Vec<[f64; D]> =
            (0..n).map(|k| if k % 5 == 0 { [if k % 2 == 0 { 0.0 } else { -0.0 }; D] } else { places[k % 5] }).collect();
        for soft in [None, Some(SOFT), Some(Soft { delta: 1e-9, ..SOFT })] {
            Scene::<T, D>::new(&x, &m, soft).check_everywhere("five places");
        }
    }
}

#[test]
fn coincident_particles_do_not_act_on_each_other() {
    everywhere!(one_place_of);
}
