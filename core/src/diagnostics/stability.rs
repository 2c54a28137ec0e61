//! Bounds of the time step of RK4, from a bound of the Jacobian of the velocity.

use crate::error::{Error, Result};
use crate::field::Interaction;
use crate::kernel::Law;
use crate::real::{Real, length};
use crate::rk4::REAL_STABILITY;

/// A time step for which RK4 is stable at this state: `2.785 / L`, where L bounds the spectral radius of the Jacobian of
/// the right-hand side of Definition 2.2. Infinite if nothing moves.
///
/// The Jacobian's blocks are `J_ij = m_j H_ij` for j != i and `J_ii = -sum_(j != i) m_j H_ij`, with `H_ij` the Hessian of
/// K_delta at `x_i - x_j`, whose norm is the larger of `|g|` and `|Laplacian - (d - 1) g|` (g the gradient factor). So the
/// row sums of norms, and the spectral radius, are at most `2 max_i sum_(j != i) |m_j| |H_ij|`. Densities add the
/// eigenvalues `sum_j m_j Laplacian(K_delta)(x_i - x_j)`. The system is a gradient flow whose Jacobian has real eigenvalues, so
/// the real interval of stability applies. The bound takes the absolute value of every contribution.
/// Only this slack covers changes of the state, so the step must be recomputed when particles have moved by a considerable
/// part of delta. [`stable_step_anywhere`] needs no recomputation.
///
/// With [`Options::combination`](crate::field::Options::combination) (a, b) divide the step by `1.07 sqrt(a^2 + b^2)`. The Jacobian is then multiplied by a + b J, whose
/// norm is `sqrt(a^2 + b^2)`, and its eigenvalues may be complex. All z with `|z| <= 2.615` and a real part of at most 0 belong to RK4's region of stability
/// (test `half_disc`), so no mode grows that does not grow in the exact solution. Modes with a positive real part, which vortices have where they strain each other, grow
/// for any step.
///
/// | argument    | shape    | unit   |
/// |-------------|----------|--------|
/// | `positions` | `[n][D]` | length |
/// | `masses`    | `[n]`    | mass, any sign |
///
/// Without a mollifier a kernel has a bounded Hessian only if each of its terms is a power with p >= 2. For other kernels no such step exists
/// if two particles coincide. Nor does it for a pair whose distance, or the Hessian at it, is out of the scalar's range, however small the masses.
///
/// Cost: `n (n - 1)` evaluations of two scalar functions of the kernel. Intended for use once in many steps.
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
    let origin = Hessian::at_origin(kernel);
    let at = |r: T| if r == T::ZERO { origin } else { Some(Hessian::at(kernel, r)) };
    let own_growth = origin.filter(|_| !kernel.is_singular()).map_or(0.0, |own| own.trace);
    let mut bound = 0.0_f64;
    for (i, (x, own)) in positions.iter().zip(masses).enumerate() {
        let (mut hessian, mut growth) = (0.0, own.to_f64().abs() * own_growth);
        for (j, (y, m)) in positions.iter().zip(masses).enumerate() {
            if i == j || *m == T::ZERO {
                continue;
            }
            let mut apart = *x;
            apart.iter_mut().zip(y).for_each(|(a, &b)| *a -= b);
            let found = at(length(&apart)).ok_or(Error::NotFinite)?;
            hessian += m.to_f64().abs() * found.norm;
            growth += m.to_f64().abs() * found.trace;
        }
        let larger = if 2.0 * hessian > growth { 2.0 * hessian } else { growth };
        // NaN compares as not larger, so finiteness is tested separately.
        if !(larger.is_finite() && (hessian + growth).is_finite() && x.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite);
        }
        bound = if larger > bound { larger } else { bound };
    }
    step_of(bound)
}

/// A time step for which RK4 is stable at every state of this total absolute mass (`sum |m_j|`) in which no two
/// particles are farther apart than `diameter`: as [`stable_step`], with `L = 2 sum |m_j| max_r |H(r)|`.
///
/// It is shorter than most states need, by about the number of particles within delta, but holds along a whole run. With it the
/// energy (2.4) never rises beyond rounding (test `energy_falls_below_the_step_estimate`; not claimed for a combination with b != 0). The maximum is taken over about 3000 distances up to
/// `diameter`: evenly spaced, geometrically down to a millionth of it or to delta, and evenly up to twice delta.
///
/// A kernel without a mollifier is refused unless each term is a power with p >= 2. Other terms, including a user's own kernel, are assumed to
/// have an unbounded Hessian at r = 0.
///
/// # Errors
/// [`Error::NotFinite`]: an argument or the bound is not finite, no bound exists, or the Hessian leaves the scalar's range within `diameter`;
/// [`Error::OutOfDomain`]: a negative argument.
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
    let origin = Hessian::at_origin(kernel).ok_or(Error::NotFinite)?;
    const EACH: usize = 1024;
    // Down to distances at which the mollified kernel is as at the origin.
    let delta = length_of(kernel).min(diameter);
    let share = if delta > T::ZERO && diameter > T::ZERO { delta / diameter } else { T::ONE };
    let ratio = share.min(T::from_f64(1e-6)).max(T::MIN_POSITIVE).pow(T::ONE / T::from_usize(EACH));
    let (mut geometric, mut largest) = (diameter, origin.larger());
    for k in 1..=EACH {
        let evenly = T::from_usize(k) / T::from_usize(EACH);
        for r in [diameter * evenly, geometric, (T::TWO * delta).min(diameter) * evenly] {
            if r > T::ZERO {
                let here = Hessian::at(kernel, r).larger();
                // NaN is kept.
                largest = if here > largest || here.is_nan() { here } else { largest };
            }
        }
        geometric *= ratio;
    }
    step_of(2.0 * absolute_mass.to_f64() * largest)
}

/// delta if the kernel provides it, else 0.
fn length_of<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>) -> T {
    kernel
        .sum()
        .map_or_else(|| kernel.newtonian().map_or(T::ZERO, |(_, blob)| blob.delta()), crate::kernel::Kernel::delta)
}

/// The numbers used in the bounds, for K_delta at one distance.
#[derive(Clone, Copy)]
struct Hessian {
    /// The norm of the Hessian.
    norm: f64,
    /// The absolute value of its trace.
    trace: f64,
}

impl Hessian {
    /// At a positive distance, or at any distance for a mollified kernel.
    fn at<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>, r: T) -> Self {
        let laplacian = kernel.laplacian(r).to_f64();
        // In one dimension there is only the radial direction.
        let g = if D == 1 { laplacian } else { kernel.gradient_factor(r).to_f64() };
        let along = (laplacian - (D - 1) as f64 * g).abs();
        // NaN is kept.
        Self { norm: if g.abs() > along { g.abs() } else { along }, trace: laplacian.abs() }
    }

    /// At zero distance, if bounded. Without a mollifier it is the limit: the sum of the coefficients of the terms with p = 2, times the identity.
    fn at_origin<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>) -> Option<Self> {
        if !kernel.is_singular() {
            return Some(Self::at(kernel, T::ZERO));
        }
        let sum = kernel.sum().filter(|sum| sum.is_known())?;
        let mut factor = 0.0;
        for term in sum.terms().iter().filter(|term| term.coefficient != 0.0) {
            match term.law {
                Law::Power { exponent } if exponent >= 2.0 => {
                    factor += if exponent == 2.0 { term.coefficient } else { 0.0 };
                }
                _ => return None,
            }
        }
        Some(Self { norm: factor.abs(), trace: (D as f64 * factor).abs() })
    }

    /// Twice this value bounds the contribution of a unit of mass to velocities and densities.
    fn larger(self) -> f64 {
        let half = 0.5 * self.trace;
        if half > self.norm { half } else { self.norm }
    }
}

fn step_of<T: Real>(bound: f64) -> Result<T> {
    if !T::from_f64(bound).is_finite() {
        return Err(Error::NotFinite);
    }
    Ok(if bound > 0.0 { T::from_f64(REAL_STABILITY / bound) } else { T::INFINITY })
}
