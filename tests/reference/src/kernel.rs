//! K * psi_delta from its definition, by quadrature in polar coordinates about the target. Slow; accurate to about 1e-9.
//!
//! `u(r) = int K(|y|) psi(x - y) dy` with |x| = r. About the target the singularity of the kernel is at the lower end of the
//! integral over s = |y|. The substitution s = b q^4 removes it.

use crate::mollifier::Compact;

/// Pieces of each integral, each with Gauss-Legendre's rule of 3 points.
const PIECES: usize = 200;

fn integral(a: f64, b: f64, pieces: usize, f: impl Fn(f64) -> f64) -> f64 {
    let half = (b - a) / (2.0 * pieces as f64);
    let node = 0.6_f64.sqrt() * half;
    let piece = |k: usize| {
        let middle = a + half * (2 * k + 1) as f64;
        half * (5.0 * f(middle - node) + 8.0 * f(middle) + 5.0 * f(middle + node)) / 9.0
    };
    (0..pieces).map(piece).sum()
}

/// Value and derivative in r of `K * psi_delta` at distance r > 0, from K and K', in 1, 2 or 3 dimensions.
pub fn mollified(dimension: u32, psi: &Compact, delta: f64, kernel: impl Fn(f64) -> [f64; 2], r: f64) -> [f64; 2] {
    let density = |distance: f64| psi.density(distance / delta) / delta.powi(dimension as i32);
    // |x - y|, and the part of y along x over |y|, at angle cosine c
    let apart = |s: f64, c: f64| (r * r + s * s - 2.0 * r * s * c).max(0.0).sqrt();
    // int over the sphere of psi, and of psi times c
    let sphere = |s: f64| -> [f64; 2] {
        if dimension == 1 {
            let (near, far) = (density(apart(s, 1.0)), density(apart(s, -1.0)));
            return [near + far, near - far];
        }
        // only angles with |x - y| < delta contribute
        let least = (r * r + s * s - delta * delta) / (2.0 * r * s);
        let widest = least.clamp(-1.0, 1.0).acos();
        let term = |angle: f64, power: i32| {
            let measure = if dimension == 2 { 2.0 } else { 2.0 * std::f64::consts::PI * angle.sin() };
            measure * density(apart(s, angle.cos())) * angle.cos().powi(power)
        };
        [0, 1].map(|power| integral(0.0, widest, 40, |angle| term(angle, power)))
    };
    // the integrand has a kink at s = delta - r, where the far side leaves the support
    let (from, to) = ((r - delta).abs(), r + delta);
    // s = from + (to - from) q^4
    let radial = |which: usize| {
        let between = |from: f64, to: f64| {
            integral(0.0, 1.0, PIECES, |q| {
                let s = from + (to - from) * q.powi(4);
                let weight = 4.0 * (to - from) * q.powi(3) * s.powi(dimension as i32 - 1);
                weight * kernel(s)[which] * sphere(s)[which]
            })
        };
        between(from, to) + if r < delta { between(0.0, from) } else { 0.0 }
    };
    // the gradient: int K'(|y|) (y/|y|) psi(x - y) dy, along x
    [radial(0), radial(1)]
}
