//! Reference implementation of the blob method: all pairs, closed forms in s, a vector for each array.

use std::f64::consts::PI;

/// Gauss' rule with five points on [-1, 1], exact for polynomials of degree 9, the highest degree of the forces below.
const GAUSS: [(f64, f64); 5] = [
    (0.0, 128.0 / 225.0),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// Value, gradient factor and Laplacian of a radial kernel at a distance.
pub type Radial = dyn Fn(f64) -> [f64; 3];

/// The Newtonian kernel with a compact polynomial mollifier of order 2 and radius `delta`: M = 1 in 1D and 3D, M = 4 in 2D.
///
/// From the enclosed mass m(r): g = m / (S r^d); the value is integrated inwards from the edge.
pub fn newtonian(dimension: usize, coefficient: f64, delta: f64) -> Box<Radial> {
    let mass = move |q: f64| match dimension {
        1 => (3.0 * q - q.powi(3)) / 2.0,
        2 => 1.0 - (1.0 - q * q).powi(5),
        _ => (5.0 * q.powi(3) - 3.0 * q.powi(5)) / 2.0,
    };
    let psi = move |q: f64| match dimension {
        1 => 0.75 * (1.0 - q * q) / delta,
        2 => 5.0 / PI * (1.0 - q * q).powi(4) / delta.powi(2),
        _ => 15.0 / (8.0 * PI) * (1.0 - q * q) / delta.powi(3),
    };
    let sphere = [2.0, 2.0 * PI, 4.0 * PI][dimension - 1];
    let bare = move |r: f64| match dimension {
        1 => r / 2.0,
        2 => r.ln() / (2.0 * PI),
        _ => -1.0 / (4.0 * PI * r),
    };
    // The force m / (S r^(d-1)); zero at the centre.
    let force = move |r: f64| if r == 0.0 { 0.0 } else { mass(r / delta) / (sphere * r.powi(dimension as i32 - 1)) };
    Box::new(move |r| {
        let d = dimension as i32;
        let all = if r >= delta {
            [bare(r), 1.0 / (sphere * r.powi(d)), 0.0]
        } else {
            let (middle, half) = ((delta + r) / 2.0, (delta - r) / 2.0);
            let inward: f64 = half * GAUSS.iter().map(|(x, w)| w * force(middle + half * x)).sum::<f64>();
            // At the centre g is not needed: it multiplies x = 0.
            let factor = if r == 0.0 { 0.0 } else { mass(r / delta) / (sphere * r.powi(d)) };
            [bare(delta) - inward, factor, psi(r / delta)]
        };
        all.map(|v| coefficient * v)
    })
}

/// Points in any dimension, with the quantities that move along.
#[derive(Clone, Debug)]
pub struct Points {
    /// Coordinates, one vector a point.
    pub positions: Vec<Vec<f64>>,
    /// Densities, one a point.
    pub densities: Vec<f64>,
}

/// Potential, gradient and Laplacian at `x`, by summing over all sources.
pub fn fields(kernel: &Radial, sources: &[Vec<f64>], masses: &[f64], x: &[f64]) -> (f64, Vec<f64>, f64) {
    let (mut potential, mut gradient, mut laplacian) = (0.0, vec![0.0; x.len()], 0.0);
    for (y, m) in sources.iter().zip(masses) {
        let offset: Vec<f64> = x.iter().zip(y).map(|(a, b)| a - b).collect();
        let r = offset.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [value, factor, second] = kernel(r);
        potential += m * value;
        laplacian += m * second;
        for (g, c) in gradient.iter_mut().zip(&offset) {
            *g += m * factor * c;
        }
    }
    (potential, gradient, laplacian)
}

/// Definition 2.2 with tracers (2.3): `steps` steps of the classical Runge-Kutta method.
pub fn run(
    kernel: &Radial,
    masses: &[f64],
    particles: &Points,
    tracers: &Points,
    dt: f64,
    steps: usize,
) -> [Points; 2] {
    let mut state = [particles.clone(), tracers.clone()];
    let slope = |state: &[Points; 2]| -> [Points; 2] {
        state.each_ref().map(|points| {
            let at: Vec<_> = points.positions.iter().map(|x| fields(kernel, &state[0].positions, masses, x)).collect();
            Points {
                positions: at.iter().map(|(_, g, _)| g.iter().map(|c| -c).collect()).collect(),
                densities: at.iter().zip(&points.densities).map(|((_, _, l), rho)| l * rho).collect(),
            }
        })
    };
    let along = |from: &[Points; 2], by: &[Points; 2], dt: f64| -> [Points; 2] {
        std::array::from_fn(|k| Points {
            positions: (from[k].positions.iter().zip(&by[k].positions))
                .map(|(x, v)| x.iter().zip(v).map(|(a, b)| a + dt * b).collect())
                .collect(),
            densities: from[k].densities.iter().zip(&by[k].densities).map(|(a, b)| a + dt * b).collect(),
        })
    };
    for _ in 0..steps {
        let k1 = slope(&state);
        let k2 = slope(&along(&state, &k1, dt / 2.0));
        let k3 = slope(&along(&state, &k2, dt / 2.0));
        let k4 = slope(&along(&state, &k3, dt));
        for (k, weight) in [(&k1, 1.0), (&k2, 2.0), (&k3, 2.0), (&k4, 1.0)] {
            state = along(&state, k, weight * dt / 6.0);
        }
    }
    state
}

/// `(1/2) sum_ij m_i m_j K(x_i - x_j)`.
pub fn energy(kernel: &Radial, positions: &[Vec<f64>], masses: &[f64]) -> f64 {
    0.5 * positions.iter().zip(masses).map(|(x, m)| m * fields(kernel, positions, masses, x).0).sum::<f64>()
}
