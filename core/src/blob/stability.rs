//! How long a step of RK4 may be: from a bound on the Jacobian of the velocity.

use crate::error::{Error, Result};
use crate::field::Interaction;
use crate::real::Real;
use crate::rk4::REAL_STABILITY;

/// A step length that RK4 is stable with at this state: `2.785 / L`, where L bounds the spectral radius of the Jacobian of
/// the right-hand side of Definition 2.2. Infinite where nothing moves.
///
/// The Jacobian's blocks are `J_ij = m_j H_ij` for j != i and `J_ii = -sum_(j != i) m_j H_ij`, with `H_ij` the Hessian of
/// K_delta at `x_i - x_j`, whose norm is the larger of `|g|` and `|Laplacian - (d - 1) g|` (g the gradient factor). So the
/// row sums of norms, hence the spectral radius, are at most `2 max_i sum_(j != i) |m_j| |H_ij|`. Densities add the
/// eigenvalues `sum_j m_j Laplacian(K_delta)(x_i - x_j)`. The system is a gradient flow and its Jacobian has real eigenvalues, so
/// the real interval of stability is the one that counts. The bound counts every contribution with its absolute
/// value; that the state changes is covered by that slack alone, so ask again when particles have moved by a good
/// part of delta. [`stable_step_anywhere`] needs no asking again.
///
/// | argument    | shape    | unit   |
/// |-------------|----------|--------|
/// | `positions` | `[n][D]` | length |
/// | `masses`    | `[n]`    | mass, any sign |
///
/// Cost: `n (n - 1)` evaluations of two of the kernel's scalar functions: meant for once in many steps.
///
/// # Errors
/// [`Error::LengthMismatch`]; [`Error::NotFinite`]: a position, a mass or the bound is not finite.
pub fn stable_step<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    positions: &[[T; D]],
    masses: &[T],
) -> Result<T> {
    if positions.len() != masses.len() {
        return Err(Error::LengthMismatch);
    }
    let (mut bound, mut finite) = (T::ZERO, true);
    for (i, (x, &own)) in positions.iter().zip(masses).enumerate() {
        let (mut hessian, mut growth) = (T::ZERO, own.abs() * kernel.laplacian(T::ZERO).abs());
        for (j, (y, &m)) in positions.iter().zip(masses).enumerate() {
            if i == j {
                continue;
            }
            let r = x.iter().zip(y).fold(T::ZERO, |sum, (&a, &b)| sum + (a - b) * (a - b)).sqrt();
            let (norm, laplacian) = hessian_norm(kernel, r);
            hessian += m.abs() * norm;
            growth += m.abs() * laplacian;
            finite &= norm.is_finite();
        }
        finite &= hessian.is_finite() && own.is_finite();
        bound = bound.max(T::TWO * hessian).max(growth);
    }
    step_of(bound, finite)
}

/// A step length that RK4 is stable with at every state of this total absolute mass (`sum |m_j|`) in which no two
/// particles are farther apart than `diameter`: as [`stable_step`] with `L = 2 sum |m_j| max_r |H(r)|`.
///
/// Shorter than what most states allow, by about the number of particles within delta, but it holds along a whole run: with it the
/// energy (2.4) never rises beyond rounding (test `energy_falls_below_the_step_estimate`). Without a mollifier a singular kernel has no such bound.
/// The maximum is taken over 2048 distances, half of them spaced evenly and half geometrically up to `diameter`.
///
/// # Errors
/// [`Error::NotFinite`]: an argument or the bound is not finite; [`Error::OutOfDomain`]: a negative argument.
pub fn stable_step_anywhere<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    absolute_mass: T,
    diameter: T,
) -> Result<T> {
    if !absolute_mass.is_finite() || !diameter.is_finite() {
        return Err(Error::NotFinite);
    }
    if absolute_mass < T::ZERO || diameter < T::ZERO {
        return Err(Error::OutOfDomain);
    }
    const HALF: usize = 1024;
    // 1024 steps of this ratio span six decades, where the mollified kernel is as at the origin.
    let (mut ratio, each) = (T::ONE, T::from_f64(0.986_6));
    let (mut largest, mut finite) = (T::ZERO, true);
    for k in 0..=HALF {
        let evenly = T::from_usize(k) / T::from_usize(HALF);
        for r in [diameter * evenly, diameter * ratio] {
            let (norm, laplacian) = hessian_norm(kernel, r);
            finite &= norm.is_finite() && laplacian.is_finite();
            largest = largest.max(norm).max(laplacian * T::HALF);
        }
        ratio *= each;
    }
    step_of(T::TWO * absolute_mass * largest, finite)
}

/// The norm of the Hessian at distance r, and the absolute value of its trace.
fn hessian_norm<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>, r: T) -> (T, T) {
    let laplacian = kernel.laplacian(r);
    // In one dimension there is no direction but along.
    if D == 1 {
        return (laplacian.abs(), laplacian.abs());
    }
    let g = kernel.gradient_factor(r);
    ((laplacian - T::from_usize(D - 1) * g).abs().max(g.abs()), laplacian.abs())
}

fn step_of<T: Real>(bound: T, finite: bool) -> Result<T> {
    if !finite || !bound.is_finite() {
        return Err(Error::NotFinite);
    }
    Ok(if bound == T::ZERO { T::INFINITY } else { T::from_f64(REAL_STABILITY) / bound })
}
