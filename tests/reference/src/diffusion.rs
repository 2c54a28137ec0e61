//! Reference implementation of diffusion by blobs: all pairs, closed forms of the blob functions, a vector for each array.

use std::f64::consts::PI;

/// A blob function: phi and phi' at a distance.
pub type BlobFunction = dyn Fn(f64) -> [f64; 2];

/// `c (1 - (r / length)^2)^exponent` of integral 1.
pub fn compact(dimension: usize, exponent: i32, length: f64) -> Box<BlobFunction> {
    // The integral of (1 - |y|^2)^M over the unit ball: 2^(M+1) M! / (1 3 5 ...), pi / (M + 1), and by one step more in space.
    let line: f64 = 2.0 * (1..=exponent).map(|k| f64::from(2 * k) / f64::from(2 * k + 1)).product::<f64>();
    let ball = match dimension {
        1 => line,
        2 => PI / f64::from(exponent + 1),
        _ => 2.0 * PI * line / f64::from(2 * exponent + 3),
    };
    let peak = 1.0 / (ball * length.powi(dimension as i32));
    Box::new(move |r| {
        let q = r / length;
        if q >= 1.0 {
            return [0.0; 2];
        }
        let base = 1.0 - q * q;
        [peak * base.powi(exponent), -peak * f64::from(exponent) * base.powi(exponent - 1) * 2.0 * q / length]
    })
}

/// `c e^(-(r / length)^2)` of integral 1.
pub fn gaussian(dimension: usize, length: f64) -> Box<BlobFunction> {
    let peak = (PI.sqrt() * length).powi(-(dimension as i32));
    Box::new(move |r| {
        let value = peak * (-(r / length).powi(2)).exp();
        [value, -2.0 * r / length.powi(2) * value]
    })
}

fn apart(x: &[f64], y: &[f64]) -> (f64, Vec<f64>) {
    let offset: Vec<f64> = x.iter().zip(y).map(|(a, b)| a - b).collect();
    (offset.iter().map(|c| c * c).sum::<f64>().sqrt(), offset)
}

/// `sum_j m_j phi(x - x_j)`.
pub fn density(phi: &BlobFunction, particles: &[Vec<f64>], masses: &[f64], x: &[f64]) -> f64 {
    particles.iter().zip(masses).map(|(y, m)| m * phi(apart(x, y).0)[0]).sum()
}

/// f'(s): 1/s, or s^(m-2).
fn slope(m: f64, s: f64) -> f64 {
    if s == 0.0 && m < 2.0 { 0.0 } else { s.powf(m - 2.0) }
}

/// `-nu sum_j m_j (f'(rho_j) + f'(rho(x))) grad phi(x - x_j)`.
pub fn velocity(
    phi: &BlobFunction,
    (m, nu): (f64, f64),
    particles: &[Vec<f64>],
    masses: &[f64],
    x: &[f64],
) -> Vec<f64> {
    let here = slope(m, density(phi, particles, masses, x));
    let mut velocity = vec![0.0; x.len()];
    for (y, mass) in particles.iter().zip(masses) {
        let (r, offset) = apart(x, y);
        if r == 0.0 || *mass == 0.0 {
            continue;
        }
        let there = slope(m, density(phi, particles, masses, y));
        for (v, c) in velocity.iter_mut().zip(&offset) {
            *v -= nu * mass * (here + there) * phi(r)[1] * c / r;
        }
    }
    velocity
}

/// `nu sum_i m_i f(rho_i)`, f(s) = log s or s^(m-1) / (m-1).
pub fn entropy(phi: &BlobFunction, (m, nu): (f64, f64), particles: &[Vec<f64>], masses: &[f64]) -> f64 {
    let f = |s: f64| if m == 1.0 { s.ln() } else { s.powf(m - 1.0) / (m - 1.0) };
    let term = |(x, mass): (&Vec<f64>, &f64)| mass * f(density(phi, particles, masses, x));
    nu * particles.iter().zip(masses).map(term).sum::<f64>()
}
