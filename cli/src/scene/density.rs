//! The shapes of the papers' initial densities, with their integrals.

use std::f64::consts::PI;

use mollis_core::exact::radial::Bump;

use super::types::{Part, Shape};

/// The area of the star: int_0^(2 pi) r(theta)^2 / 2 with r = (sin^2 + 1/2)/4; means of sin^2 and sin^4 are 1/2 and 3/8.
const STAR: f64 = PI * (3.0 / 8.0 + 1.0 / 2.0 + 1.0 / 4.0) / 16.0;

/// A part's density as a function.
#[derive(Clone, Debug)]
pub struct Density {
    shape: Shape,
    axes: Vec<f64>,
    center: Vec<f64>,
    factor: f64,
    integral: f64,
}

impl Density {
    /// The density of a part in `dimension` dimensions. Not for points and files.
    pub fn new(part: &Part, dimension: usize) -> Self {
        let volume: f64 = part.axes.iter().product();
        let unit = match &part.shape {
            Shape::Polynomial(k) => polynomial(*k, dimension) * volume,
            Shape::Flat => polynomial(0, dimension) * volume,
            Shape::Bump => bump(dimension) * volume,
            Shape::Star => STAR,
            Shape::Points(..) | Shape::File(..) => 0.0,
        };
        let factor = part.mass.map_or(part.height, |mass| mass / unit);
        Self {
            shape: part.shape.clone(),
            axes: part.axes.clone(),
            center: part.center.clone(),
            factor,
            integral: unit * factor,
        }
    }

    /// The whole mass.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// The volume of the support.
    pub fn support(&self) -> f64 {
        match self.shape {
            Shape::Star => STAR * self.axes.iter().product::<f64>(),
            _ => polynomial(0, self.axes.len()) * self.axes.iter().product::<f64>(),
        }
    }

    /// The density at a point; `None` outside the (closed) support.
    pub fn at(&self, point: &[f64]) -> Option<f64> {
        let away = |(x, (c, a)): (&f64, (&f64, &f64))| (x - c) / a;
        let scaled: Vec<f64> = point.iter().zip(self.center.iter().zip(&self.axes)).map(away).collect();
        let s: f64 = scaled.iter().map(|x| x * x).sum();
        if let (Shape::Star, [x, y]) = (&self.shape, scaled.as_slice()) {
            // sin^2(5 theta / 2) = (1 - cos 5 theta) / 2: Craig & Bertozzi (4.6).
            let edge = ((1.0 - (5.0 * y.atan2(*x)).cos()) / 2.0 + 0.5) / 4.0;
            return (s.sqrt() < edge).then_some(self.factor);
        }
        // A grid point k h on the edge counts as inside whichever way k h was rounded.
        if s > 1.0 + 1e-12 {
            return None;
        }
        let edge = (1.0 - s).max(0.0);
        Some(
            self.factor
                * match self.shape {
                    Shape::Polynomial(k) => edge.powi(k as i32),
                    Shape::Bump if edge > 0.0 => (-1.0 / edge).exp(),
                    Shape::Bump => 0.0,
                    _ => 1.0,
                },
        )
    }

    /// The smallest box around the support: centre and half widths.
    pub fn bounds(&self) -> (&[f64], Vec<f64>) {
        let reach = if self.shape == Shape::Star { 3.0 / 8.0 } else { 1.0 };
        (&self.center, self.axes.iter().map(|a| a * reach).collect())
    }

    /// The largest value.
    pub fn maximum(&self) -> f64 {
        self.factor * if self.shape == Shape::Bump { (-1.0_f64).exp() } else { 1.0 }
    }
}

/// The integral of (1 - |x|^2)^k over the unit ball.
fn polynomial(k: u32, dimension: usize) -> f64 {
    let Ok(bump) = Bump::new(1.0, 1.0, k) else { return f64::NAN };
    match dimension {
        1 => bump.enclosed_mass::<1>(1.0),
        2 => bump.enclosed_mass::<2>(1.0),
        _ => bump.enclosed_mass::<3>(1.0),
    }
}

/// The integral of e^(1/(|x|^2 - 1)) over the unit ball. All derivatives vanish at r = 1 and the odd ones at 0 (after the
/// even continuation), so the trapezoidal rule converges faster than any power: 400 panels are exact to rounding.
fn bump(dimension: usize) -> f64 {
    let n = 400;
    let sphere = [2.0, 2.0 * PI, 4.0 * PI][dimension - 1];
    let value = |r: f64| if r < 1.0 { (1.0 / (r * r - 1.0)).exp() } else { 0.0 };
    // In the plane the integrand r e^.. is odd, so it's integrated in s = r^2, where it is smooth up to an end point
    // at 0; Simpson's rule is then good to n^-4.
    if dimension == 2 {
        let n = 20_000;
        let f = |i: i32| {
            value((f64::from(i) / f64::from(n)).sqrt())
                * if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) }
        };
        return PI * (0..=n).map(f).sum::<f64>() / (3.0 * f64::from(n));
    }
    let f = |i: i32| {
        let r = f64::from(i) / f64::from(n);
        value(r) * r.powi(dimension as i32 - 1) * if i == 0 { 0.5 } else { 1.0 }
    };
    sphere * (0..=n).map(f).sum::<f64>() / f64::from(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(shape: Shape, axes: &[f64], mass: Option<f64>) -> Part {
        Part {
            shape,
            axes: axes.to_vec(),
            center: vec![0.25; axes.len()],
            height: 1.5,
            mass,
            share: None,
            diffusivity: None,
            sensitivity: None,
        }
    }

    /// The sum over a fine grid; midpoints see an edge only to first order, so discontinuous shapes get 1%.
    #[test]
    fn integrals_are_those_of_the_densities() {
        let cases = [
            (part(Shape::Polynomial(2), &[1.0, 1.0], None), 1e-4),
            (part(Shape::Polynomial(3), &[0.5, 2.0], Some(7.0)), 1e-4),
            (part(Shape::Bump, &[1.0, 7.0], None), 1e-6),
            (part(Shape::Bump, &[0.5], Some(2.0)), 1e-6),
            (part(Shape::Flat, &[1.0, 0.3], None), 1e-2),
            (part(Shape::Star, &[1.0, 1.0], None), 1e-2),
        ];
        for (part, tolerance) in cases {
            let density = Density::new(&part, part.axes.len());
            let (center, half) = density.bounds();
            let n = 400;
            let at =
                |i: i32, axis: usize| center[axis] + half[axis] * ((f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0);
            let cell: f64 = half.iter().map(|a| 2.0 * a / f64::from(n)).product();
            let sum: f64 = if half.len() == 1 {
                (0..n).filter_map(|i| density.at(&[at(i, 0)])).sum()
            } else {
                (0..n * n).filter_map(|i| density.at(&[at(i % n, 0), at(i / n, 1)])).sum()
            };
            let integral = density.integral();
            assert!((sum * cell / integral - 1.0).abs() < tolerance, "{part:?} {} {integral}", sum * cell);
            if let Some(mass) = part.mass {
                assert!((integral / mass - 1.0).abs() < 1e-14);
            }
        }
        // int_0^1 e^(-1/u) du = 1/e - E1(1).
        assert!((bump(1) - 0.443_993_816_168_079_4).abs() < 1e-14, "{}", bump(1));
        assert!((bump(2) - PI * 0.148_495_506_775_922_05).abs() < 1e-12, "{}", bump(2));
    }
}
