//! Mollification: compact polynomial, Gaussian and algebraic mollifiers psi with their Newtonian fields.
//!
//! Sources: C. R. Anderson, "Compact Polynomial Mollifiers For Poisson's Equation", UCLA CAM 14-43 (2015), and the Gaussians of
//! K. Craig, A. L. Bertozzi, "A blob method for the aggregation equation", (3.1), (4.1), (4.2).
//!
//! A [`Mollifier`] is the choice of psi. A [`Blob`] is a mollifier prepared with its length delta, in a scalar type and a dimension.
//! For psi_delta(x) = delta^-N psi(x/delta), the Newtonian K (Laplacian K = +Dirac: |x|/2, log|x|/(2 pi), -1/(4 pi |x|)) and
//! phi = K * psi_delta it gives
//!
//! | function | value | unit |
//! |---|---|---|
//! | [`Blob::density`] | B = psi_delta(r) | length^-N |
//! | [`Blob::density_slope`] | B'(r)/r | length^-(N+2) |
//! | [`Blob::potential`] | phi(r), Laplacian phi = B | length^(2-N) |
//! | [`Blob::gradient_factor`] | g = phi'(r)/r, grad phi = g x | length^-N |
//! | [`Blob::hessian_factor`] | h = g'(r)/r, Hess phi = g I + h x x^T | length^-(N+2) |
//! | [`Blob::enclosed_mass`] | the integral of psi_delta over a ball of radius r | 1 |
//!
//! and the fields at points, [moments](Blob::moment) and the smooth [Heaviside](Blob::heaviside) function. Outside the support of a compact mollifier, or a
//! combination of such, the field is exactly Newtonian. [`Mollifier::Richardson`] is the combination of compact mollifiers for kernels and sums, [`Richardson`] that of any radii.
//!
//! These functions favour accuracy. They represent all numbers as sums of two ([`DoubleWord`](crate::real::DoubleWord))
//! with a separate exponent, use +, -, *, / and sqrt alone (and one libm logarithm for the potential in 2D), and
//! round once at the end. They overflow or underflow only where the true value does and give no NaN for finite
//! arguments. Their errors are listed in `docs/accuracy.md`. Sums over many particles use [`Polynomials`].

mod algebraic;
mod blob;
#[cfg_attr(not(feature = "kernels"), path = "no_combined.rs")]
mod combined;
mod compact;
mod distance;
mod gaussian;
mod law;
#[cfg(feature = "nalgebra")]
mod matrix;
mod moments;
mod newtonian;
mod points;
mod richardson;
mod scaled;
mod series;
mod single_word;

#[cfg(test)]
mod tests;

pub use blob::Blob;
pub use law::{MAX_COEFFICIENTS, MAX_EXPONENT, MAX_ORDER};
pub use richardson::Richardson;
pub(crate) use series::Polynomial;
pub use series::{Polynomials, Series};

use crate::error::{Error, Result};

/// The largest order of a moment.
pub const MAX_MOMENT: u32 = 64;
/// The most radii of a [`Richardson`] combination.
pub const MAX_COMBINED: usize = 4;

/// The choice of mollifier, without its length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mollifier {
    /// No mollifier: the singular kernel of the particle method. Its value at zero distance is taken as zero.
    None,
    /// The compact polynomial of Anderson (3), (12): support radius delta, M - 1 times continuously differentiable.
    Compact {
        /// 2, 4, 6 or 8: moments 1 to order - 1 vanish.
        order: u32,
        /// M = 1..9.
        exponent: u32,
    },
    /// Sums of Gaussians of widths that are multiples of delta: `e^(-r^2 / delta^2)` alone for order 2 (Lamb and Oseen's vortex in 2D), those of
    /// Craig & Bertozzi for orders 4 and 6 in 1D (4.1) and 4 in 2D (4.2), and alike in 3D and for order 6 in 2D.
    Gaussian {
        /// 2, 4 or 6.
        order: u32,
    },
    /// Plummer's softening of gravity: K at the distance `(r^2 + delta^2)^(1/2)`. Rosenhead and Moore's of vortices.
    Plummer,
    /// The high-order algebraic kernel of vortex methods (Winckelmans & Leonard): g ~ `(r^2 + (1 + N/2) delta^2) / (r^2 + delta^2)^(N/2 + 1)`.
    Algebraic,
    /// Vatistas' vortex, n = 2, in 2D: g ~ `1 / (r^4 + delta^4)^(1/2)`.
    Vatistas,
    /// The Richardson combination of K = order / 2 compact mollifiers of order 2 with the radii delta j / K (Anderson (8)): support radius delta, M - 1 times
    /// continuously differentiable. (9) is order 4, -1/3 and 4/3 times the radii delta and delta / 2; (10) is order 6, 1/10, -3/5 and 3/2 times delta, 2 delta / 3 and
    /// delta / 3. [`Richardson`] has other radii, for functions of the distance.
    Richardson {
        /// 4, 6 or 8: moments 1 to order - 1 vanish.
        order: u32,
        /// M = 1..9, of each part.
        exponent: u32,
    },
}

/// Weights and squared widths, in units of delta^2, of the Gaussians of a mollifier; unused ones have the weight 0.
pub(crate) fn gaussian_weights(dimension: usize, order: u32) -> [(f64, f64); 3] {
    gaussian::Gaussian::new(dimension, order).weights()
}

impl Mollifier {
    /// Returns an error for a mollifier that does not exist in this dimension.
    ///
    /// # Errors
    /// [`Error::Dimension`], [`Error::Order`], [`Error::Exponent`].
    pub fn check(self, dimension: usize) -> Result<()> {
        if !(1..=3).contains(&dimension) {
            return Err(Error::Dimension);
        }
        match self {
            Self::Richardson { .. } if !combined::RICHARDSON => Err(Error::Unsupported),
            Self::Compact { order: 2 | 4 | 6 | 8, exponent } | Self::Richardson { order: 4 | 6 | 8, exponent } => {
                if (1..=MAX_EXPONENT).contains(&exponent) { Ok(()) } else { Err(Error::Exponent) }
            }
            Self::Gaussian { .. } if !cfg!(feature = "gaussian") => Err(Error::Unsupported),
            Self::Plummer | Self::Algebraic | Self::Vatistas if !blob::ALGEBRAIC => Err(Error::Unsupported),
            Self::Vatistas if dimension != 2 => Err(Error::Dimension),
            Self::None | Self::Gaussian { order: 2 | 4 | 6 } | Self::Plummer | Self::Algebraic | Self::Vatistas => {
                Ok(())
            }
            Self::Compact { .. } | Self::Gaussian { .. } | Self::Richardson { .. } => Err(Error::Order),
        }
    }

    /// The mollifier's order p: mollifying a smooth function changes it by O(delta^p) (Plummer: O(delta^2 log delta), order 1). 0 without a mollifier.
    #[must_use]
    pub fn order(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Compact { order, .. } | Self::Gaussian { order } | Self::Richardson { order, .. } => order,
            Self::Plummer => 1,
            Self::Algebraic | Self::Vatistas => 2,
        }
    }

    /// Whether the field is exactly Newtonian beyond delta: without a mollifier, or of a compact one or a combination of such.
    #[must_use]
    pub fn is_compact(self) -> bool {
        matches!(self, Self::None | Self::Compact { .. } | Self::Richardson { .. })
    }

    /// Whether the field approaches the Newtonian one like a power of the distance.
    #[must_use]
    pub fn is_algebraic(self) -> bool {
        matches!(self, Self::Plummer | Self::Algebraic | Self::Vatistas)
    }
}

/// A function of the distance r; see the table above for values and units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// B = psi_delta.
    Density,
    /// B'/r.
    DensitySlope,
    /// phi.
    Potential,
    /// g = phi'/r.
    GradientFactor,
    /// h = g'/r.
    HessianFactor,
    /// S_N r^N g.
    EnclosedMass,
}

impl Quantity {
    /// All functions.
    pub const ALL: [Self; 6] = [
        Self::Density,
        Self::DensitySlope,
        Self::Potential,
        Self::GradientFactor,
        Self::HessianFactor,
        Self::EnclosedMass,
    ];
}
