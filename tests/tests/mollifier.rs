//! Mollifiers against their definition, properties that need no reference, and the limits of the number range.

use mollis_core::Real;
use mollis_core::Scalar;
use mollis_core::mollifier::{Blob, Mollifier, Quantity, Richardson};
use mollis_reference::mollifier::Compact;

fn compact(order: u32, exponent: u32) -> Mollifier {
    Mollifier::Compact { order, exponent }
}

/// All mollifiers that exist in dimension D.
fn all<const D: usize>() -> Vec<Mollifier> {
    let mut list = vec![Mollifier::None];
    for order in [2, 4, 6, 8] {
        list.extend((1..=9).map(|exponent| compact(order, exponent)));
        list.extend([1, 4, 9].map(|exponent| Mollifier::Richardson { order, exponent }));
        list.push(Mollifier::Gaussian { order });
    }
    list.retain(|m| m.check(D).is_ok());
    list
}

#[test]
fn compact_mollifiers_are_what_the_definition_says() {
    fn check<const D: usize>() {
        for order in [2, 4, 6, 8] {
            for exponent in [1, 2, 4, 9] {
                let slow = Compact::new(D as u32, order, exponent);
                let blob = Blob::<f64, D>::new(compact(order, exponent), 1.0).unwrap();
                let largest = slow.density(0.0).abs();
                for i in 1..=8 {
                    let r = f64::from(i) / 8.0;
                    // Quadrature of degree 9 on 64 pieces is exact up to rounding. The condition number of the moment system reaches 1e5.
                    let close = |a: f64, b: f64, size: f64| {
                        assert!((a - b).abs() <= 1e-10 * size, "{D} {order} {exponent} {r}: {a} {b}")
                    };
                    close(blob.density(r), slow.density(r), largest);
                    close(blob.gradient_factor(r), slow.gradient_factor(r), largest);
                    close(blob.enclosed_mass(r), slow.mass(r), largest);
                    close(blob.potential(r), slow.potential(r), largest);
                }
            }
        }
    }
    check::<1>();
    check::<2>();
    check::<3>();
}

#[test]
fn fields_at_points_are_those_of_the_distance() {
    fn check<T: Real, const D: usize>(points: &[[f64; D]]) {
        let u = T::EPSILON.to_f64();
        for mollifier in all::<D>() {
            let delta = T::from_f64(0.75);
            let blob = Blob::<T, D>::new(mollifier, delta).unwrap();
            for x in points {
                let x = x.map(T::from_f64);
                // The distance of a point on an axis is exact.
                let r = x.iter().fold(T::ZERO, |sum, c| sum + c.abs());
                let (g, h) = (blob.gradient_factor(r), blob.hessian_factor(r));
                // Gaussians at points use plain arithmetic, with bounds of their own. With other mollifiers the results at a point
                // and at its distance are equal.
                let plain = matches!(mollifier, Mollifier::Gaussian { .. });
                let close = |got: T, want: T, size: f64| {
                    let allowed = if plain { size * u } else { 0.0 };
                    assert!((got.to_f64() - want.to_f64()).abs() <= allowed, "{mollifier:?} {x:?}: {got} {want}");
                };
                let phi = blob.potential(r);
                let logarithms = if D == 2 { 1.0 + delta.to_f64().ln().abs() } else { 0.0 };
                close(blob.potential_at(&x), phi, 4.0 * (phi.to_f64().abs() + logarithms));
                close(blob.density_at(&x), blob.density(r), 4.0 * blob.density(T::ZERO).to_f64());
                let normal = |value: T| value.is_finite() && value.abs() >= T::MIN_POSITIVE;
                let gradient = blob.gradient_at(&x);
                assert!(gradient.iter().all(|c| !c.is_nan()));
                for (got, c) in gradient.into_iter().zip(x).filter(|_| normal(g)) {
                    let want = g.to_f64() * c.to_f64();
                    let allowed = if plain { 5.0 } else { 2.0 } * u * want.abs();
                    assert!((got.to_f64() - want).abs() <= allowed, "{mollifier:?} {x:?}");
                }
                let hessian = blob.hessian_at(&x);
                if g != T::ZERO && !(normal(g) && normal(h)) {
                    // A factor may be out of range where the Hessian is not: there is no value to compare with.
                    assert!(hessian.iter().flatten().all(|c| !c.is_nan()));
                    continue;
                }
                let mut trace = 0.0;
                for i in 0..D {
                    trace += hessian[i][i].to_f64();
                    for j in 0..D {
                        assert_eq!(hessian[i][j], hessian[j][i]);
                        let outer = h.to_f64() * x[i].to_f64() * x[j].to_f64();
                        let want = outer + if i == j { g.to_f64() } else { 0.0 };
                        let allowed = 4.0 * u * (outer.abs() + g.to_f64().abs());
                        let got = hessian[i][j].to_f64();
                        assert!((got - want).abs() <= allowed, "D{D} {mollifier:?} {x:?} {i}{j}: {got} {want} {g} {h}");
                    }
                }
                let size = D as f64 * (g.to_f64().abs() + h.to_f64().abs() * r.to_f64() * r.to_f64());
                assert!((trace - blob.density(r).to_f64()).abs() <= 4.0 * u * size, "{mollifier:?} {x:?}");
            }
        }
    }
    fn axes<const D: usize>() -> Vec<[f64; D]> {
        let mut points = vec![[0.0; D]];
        for r in [0.125, -0.5, 0.74, 0.75, -0.751, 3.0, 1e-20, 1e15] {
            for axis in 0..D {
                let mut x = [0.0; D];
                x[axis] = r;
                points.push(x);
            }
        }
        points
    }
    check::<f64, 1>(&axes());
    check::<f64, 2>(&axes());
    check::<f64, 3>(&axes());
    check::<f32, 1>(&axes());
    check::<f32, 2>(&axes());
    check::<f32, 3>(&axes());
}

#[test]
fn points_off_the_axes_agree_with_their_rotation() {
    // (3, 4)/8 and (0.625, 0): the same distance exactly.
    for mollifier in all::<2>() {
        let blob = Blob::<f64, 2>::new(mollifier, 0.7).unwrap();
        let (a, b) = ([0.375, 0.5], [0.625, 0.0]);
        // The squared distance, 25/64, is exact in both cases.
        assert_eq!(blob.potential_at(&a), blob.potential_at(&b));
        assert_eq!(blob.density_at(&a), blob.density_at(&b));
        let (ga, gb) = (blob.gradient_at(&a), blob.gradient_at(&b));
        assert!(
            (ga[0] - 0.6 * gb[0]).abs() <= 5e-16 * gb[0].abs() && (ga[1] - 0.8 * gb[0]).abs() <= 4e-16 * gb[0].abs()
        );
    }
}

#[test]
fn nothing_is_nan_and_only_the_true_value_overflows() {
    fn check<T: Real, const D: usize>() {
        let (tiny, huge) = (T::MIN_POSITIVE * T::EPSILON, T::MAX);
        let sizes = [tiny, T::MIN_POSITIVE, T::from_f64(1e-30), T::from_f64(0.3), T::ONE, T::from_f64(1e30), huge];
        for mollifier in all::<D>() {
            for delta in sizes {
                let blob = Blob::<T, D>::new(mollifier, delta).unwrap();
                for r in sizes.into_iter().chain([T::ZERO]) {
                    for quantity in Quantity::ALL {
                        let value = blob.evaluate(quantity, r);
                        assert!(!value.is_nan(), "{mollifier:?} {quantity:?} {delta} {r}");
                    }
                    // Only the potential in 3D can overflow; there it is about -1/(4 pi r).
                    let potential = blob.potential(r);
                    let length = if mollifier == Mollifier::None { r } else { delta.max(r) }.to_f64();
                    assert!(
                        potential.is_finite() || (D == 3 && length < 4.0 / huge.to_f64()),
                        "{potential} {delta} {r}"
                    );
                    let mass = blob.enclosed_mass(r).to_f64();
                    assert!((0.0..=2.0).contains(&mass), "{mollifier:?} {delta} {r} {mass}");
                    // A point off the axes: the elements of the Hessian are sums.
                    let x = [r; D];
                    assert!(blob.gradient_at(&x).iter().all(|c| !c.is_nan()));
                    assert!(!blob.potential_at(&x).is_nan());
                    let hessian = blob.hessian_at(&x);
                    assert!(hessian.iter().flatten().all(|c| !c.is_nan()), "{mollifier:?} {delta} {r} {hessian:?}");
                }
                assert!(blob.potential(T::NAN).is_nan() && blob.gradient_at(&[T::INFINITY; D])[0].is_nan());
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

/// Scaling lengths by a power of two scales every result by a power of two, bit for bit, unless it leaves the normal range.
#[test]
fn scaling_is_exact() {
    fn check<const D: usize>() {
        for mollifier in all::<D>() {
            let unit = Blob::<f64, D>::new(mollifier, 0.7).unwrap();
            for shift in [-500, -300, 300] {
                let factor = 2_f64.powi(shift);
                let scaled = Blob::<f64, D>::new(mollifier, 0.7 * factor).unwrap();
                for r in [0.0, 0.1, 0.35, 0.69999, 0.7, 0.9, 7.0] {
                    for (quantity, power) in [
                        (Quantity::Density, -(D as i32)),
                        (Quantity::GradientFactor, -(D as i32)),
                        (Quantity::HessianFactor, -(D as i32) - 2),
                        (Quantity::DensitySlope, -(D as i32) - 2),
                        (Quantity::EnclosedMass, 0),
                        (Quantity::Potential, 2 - D as i32),
                    ] {
                        if D == 2 && quantity == Quantity::Potential {
                            continue;
                        }
                        let want = unit.evaluate(quantity, r).ldexp(power * shift);
                        let got = scaled.evaluate(quantity, r * factor);
                        // Results that are subnormal are rounded twice.
                        let same = got == want || (got.abs() < f64::MIN_POSITIVE && (got - want).abs() <= 5e-324);
                        assert!(same, "{mollifier:?} {quantity:?} {shift} {r}: {got} {want}");
                    }
                }
            }
        }
    }
    check::<1>();
    check::<2>();
    check::<3>();
}

#[test]
fn moments_vanish_below_the_order() {
    fn check<T: Real, const D: usize>() {
        for mollifier in all::<D>().into_iter().skip(1) {
            let blob = Blob::<T, D>::new(mollifier, T::from_f64(0.5)).unwrap();
            assert_eq!(blob.moment(0), Ok(T::ONE), "{mollifier:?}");
            for k in (2..mollifier.order()).step_by(2) {
                assert_eq!(blob.moment(k), Ok(T::ZERO), "{mollifier:?} {k}");
            }
            assert!(blob.moment(mollifier.order()).unwrap() != T::ZERO);
            assert!(blob.moment(65).is_err());
        }
    }
    check::<f64, 1>();
    check::<f64, 2>();
    check::<f64, 3>();
    check::<f32, 2>();
    // Anderson's second moments, and Craig & Bertozzi's: 1D psi4 has fourth moment -3, psi6 sixth moment 120, 2D psi4 -4.
    let moment = |m, k| Blob::<f64, 2>::new(m, 1.0).unwrap().moment(k).unwrap();
    assert_eq!(moment(compact(2, 4), 2), 1.0 / 6.0);
    assert_eq!(moment(Mollifier::Gaussian { order: 4 }, 4), -4.0);
    let moment = |m, k| Blob::<f64, 1>::new(m, 1.0).unwrap().moment(k).unwrap();
    assert_eq!(moment(compact(2, 4), 2), 1.0 / 11.0);
    assert_eq!(moment(Mollifier::Gaussian { order: 4 }, 4), -3.0);
    assert_eq!(moment(Mollifier::Gaussian { order: 6 }, 6), 120.0);
    // Odd moments: of 3/4 (1 - x^2), the first is 3/8; of 2 e^{-r^2} - e^{-r^2/2}/2 over pi, sqrt(pi)/2 (2 - sqrt 2).
    assert_eq!(moment(compact(2, 1), 1), 0.375);
    let first = Blob::<f64, 2>::new(Mollifier::Gaussian { order: 4 }, 1.0).unwrap().moment(1).unwrap();
    assert!((first - std::f64::consts::PI.sqrt() / 2.0 * (2.0 - 2_f64.sqrt())).abs() < 1e-15);
}

#[test]
fn heaviside_rises_from_zero_to_one() {
    for mollifier in all::<1>() {
        let blob = Blob::<f64, 1>::new(mollifier, 0.7).unwrap();
        assert_eq!(blob.heaviside(0.0), 0.5);
        assert_eq!(blob.heaviside(100.0), 1.0);
        assert!(blob.heaviside(-100.0).abs() < if mollifier.order() == 0 { 5e-324 } else { 1e-31 });
        for x in [0.01, 0.1, 0.3, 0.6, 0.69] {
            assert!((blob.heaviside(x) + blob.heaviside(-x) - 1.0).abs() <= 2.3e-16);
            // Its slope is the density: central differences of step 1e-4 have an error of 1e-8 of its third derivative.
            if mollifier != Mollifier::None {
                let slope = (blob.heaviside(x + 1e-4) - blob.heaviside(x - 1e-4)) / 2e-4;
                assert!((slope - blob.density(x)).abs() < 2e-4, "{mollifier:?} {x} {slope}");
            }
        }
    }
    // M = 1: (2 + 3x - x^3)/4. The tail (1+x)^2 (2-x)/4 keeps its relative accuracy.
    let blob = Blob::<f64, 1>::new(compact(2, 1), 1.0).unwrap();
    let e = 2_f64.powi(-10);
    let tail = e * e * (3.0 - e) / 4.0;
    assert!((blob.heaviside(e - 1.0) / tail - 1.0).abs() < 3e-16);
}

#[test]
fn richardson_combinations_raise_the_order() {
    fn check<const D: usize>() {
        for (radii, order) in [(&[1.0, 0.5][..], 4), (&[1.0, 2.0 / 3.0, 1.0 / 3.0], 6)] {
            for base in [compact(2, 3), compact(4, 3)] {
                let order = order + base.order() - 2;
                let combined = Richardson::<f64, D>::new(base, 0.8, radii).unwrap();
                assert!((combined.moment(0).unwrap() - 1.0).abs() < 1e-15);
                for k in (2..order).step_by(2) {
                    // Radii and lengths are rounded. The weights (below 20) amplify this.
                    assert!(combined.moment(k).unwrap().abs() < 20.0 * 8.0 * f64::EPSILON, "{D} {base:?} {k}");
                }
                assert!(combined.moment(order).unwrap().abs() > 1e-6);
                assert!((combined.evaluate(Quantity::EnclosedMass, 0.8) - 1.0).abs() < 1e-15);
                let outside = Blob::<f64, D>::new(Mollifier::None, 1.0).unwrap();
                for quantity in [Quantity::Potential, Quantity::GradientFactor] {
                    let (a, b) = (combined.evaluate(quantity, 1.5), outside.evaluate(quantity, 1.5));
                    assert!((a - b).abs() < 1e-15, "{a} {b}");
                }
            }
        }
    }
    check::<1>();
    check::<2>();
    check::<3>();
}
