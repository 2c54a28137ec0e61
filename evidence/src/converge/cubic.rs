//! The solution for K = |x|^3 / 3 in one dimension to rounding, for data that are a polynomial on [-1, 1].
//!
//! Particles keep their order, so with cumulative moments `m_k(a) = int_(-1)^a X(b)^k rho_0(b) db` (left) and the rest (right)
//!
//! `dX/dt = -(X^2 d_0 - 2 X d_1 + d_2)`, `d log rho / dt = 2 (X d_0 - d_1)`, `d_k = left - right`:
//!
//! no kernel is evaluated across its kink. X is smooth in a, so Chebyshev points and integration of the interpolating
//! polynomial give it to rounding.

/// Number of panels of the Chebyshev points: 65 points.
const N: usize = 64;

/// Positions and densities at time `time` of the particles that start at `at`, for the density `rho_0` on [-1, 1].
pub fn solution(rho_0: impl Fn(f64) -> f64, at: &[f64], time: f64) -> (Vec<f64>, Vec<f64>) {
    let nodes: Vec<f64> = (0..=N).map(|j| -(std::f64::consts::PI * j as f64 / N as f64).cos()).collect();
    let integral = integration(&nodes);
    let weights: Vec<f64> = nodes.iter().map(|&a| rho_0(a)).collect();
    let slope = |state: &[f64]| -> Vec<f64> {
        let (x, _) = state.split_at(N + 1);
        let difference = |k: i32| -> Vec<f64> {
            let values: Vec<f64> = x.iter().zip(&weights).map(|(x, w)| x.powi(k) * w).collect();
            let left: Vec<f64> = integral.iter().map(|row| row.iter().zip(&values).map(|(s, v)| s * v).sum()).collect();
            left.iter().map(|l| 2.0 * l - left[N]).collect()
        };
        let (d0, d1, d2) = (difference(0), difference(1), difference(2));
        let velocity = (0..=N).map(|i| -(x[i] * x[i] * d0[i] - 2.0 * x[i] * d1[i] + d2[i]));
        let growth = (0..=N).map(|i| 2.0 * (x[i] * d0[i] - d1[i]));
        velocity.chain(growth).collect()
    };
    let mut state: Vec<f64> = nodes.iter().copied().chain(vec![0.0; N + 1]).collect();
    let steps = 400;
    let dt = time / f64::from(steps);
    for _ in 0..steps {
        let along = |k: &[f64], dt: f64| -> Vec<f64> { state.iter().zip(k).map(|(y, k)| y + dt * k).collect() };
        let k1 = slope(&state);
        let k2 = slope(&along(&k1, dt / 2.0));
        let k3 = slope(&along(&k2, dt / 2.0));
        let k4 = slope(&along(&k3, dt));
        for i in 0..state.len() {
            state[i] += dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    let (x, growth) = state.split_at(N + 1);
    let positions = at.iter().map(|&a| interpolate(&nodes, x, a)).collect();
    let densities = at.iter().map(|&a| rho_0(a) * interpolate(&nodes, growth, a).exp()).collect();
    (positions, densities)
}

/// Row i holds the integrals from -1 to node i of the Lagrange polynomials, by way of Chebyshev coefficients:
/// int T_k = T_(k+1) / (2 (k+1)) - T_(k-1) / (2 (k-1)).
fn integration(nodes: &[f64]) -> Vec<Vec<f64>> {
    let chebyshev = |k: usize, x: f64| (k as f64 * x.clamp(-1.0, 1.0).acos()).cos();
    let primitive = |k: usize, x: f64| match k {
        0 => x,
        1 => x * x / 2.0,
        _ => chebyshev(k + 1, x) / (2 * (k + 1)) as f64 - chebyshev(k - 1, x) / (2 * (k - 1)) as f64,
    };
    let half = |j: usize| if j == 0 || j == N { 0.5 } else { 1.0 };
    let entry = |i: usize, j: usize| -> f64 {
        let term = |k: usize| half(k) * chebyshev(k, nodes[j]) * (primitive(k, nodes[i]) - primitive(k, -1.0));
        (0..=N).map(term).sum::<f64>() * 2.0 / N as f64 * half(j)
    };
    (0..=N).map(|i| (0..=N).map(|j| entry(i, j)).collect()).collect()
}

/// Barycentric interpolation (Berrut, Trefethen 2004, (5.4)).
fn interpolate(nodes: &[f64], values: &[f64], x: f64) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for (j, (&node, &value)) in nodes.iter().zip(values).enumerate() {
        if x == node {
            return value;
        }
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        let weight = sign * if j == 0 || j == N { 0.5 } else { 1.0 } / (x - node);
        above += weight * value;
        below += weight;
    }
    above / below
}
