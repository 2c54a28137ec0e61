//! Mollifiers: scalar functions of r, and fields at points.

pub(crate) mod combinations;
pub(crate) mod points;
pub(crate) mod radii;

use mollis_core::mollifier::Mollifier;
use mollis_core::{Error, Result};

/// No mollifier: the singular kernel of the particle method. Order, exponent and delta are not looked at.
pub const MOLLIS_MOLLIFIER_NONE: i32 = 0;
/// Compact polynomial (Anderson): order 2, 4, 6 or 8, exponent 1 to 9; delta is the radius of the support.
pub const MOLLIS_MOLLIFIER_COMPACT: i32 = 1;
/// Sum of Gaussians: exp(-r^2 / delta^2) alone for order 2 (Lamb and Oseen's vortex in 2D); of order 4 and 6 Craig and Bertozzi's and alike. The exponent is not
/// looked at.
pub const MOLLIS_MOLLIFIER_GAUSSIAN: i32 = 2;
/// Plummer's softening: the Newtonian kernel at the distance (r^2 + delta^2)^(1/2); in vortex methods the low-order algebraic kernel of Rosenhead and Moore. Of
/// Newtonian kernels only, as the next two. Order and exponent are not looked at.
pub const MOLLIS_MOLLIFIER_PLUMMER: i32 = 3;
/// The high-order algebraic kernel of vortex methods (Winckelmans and Leonard): K'/r is (r^2 + (1 + D/2) delta^2) / (S_D (r^2 + delta^2)^(D/2 + 1)) in D dimensions.
pub const MOLLIS_MOLLIFIER_ALGEBRAIC: i32 = 4;
/// Vatistas' vortex with n = 2, in the plane: K'/r is 1 / (2 pi (r^4 + delta^4)^(1/2)).
pub const MOLLIS_MOLLIFIER_VATISTAS: i32 = 5;
/// Richardson combination of order / 2 compact polynomials of order 2 (Anderson (8)): order 4 (9), of the radii delta and delta / 2 with the weights -1/3 and 4/3; order 6
/// (10), of delta, 2/3 delta and delta / 3 with 1/10, -3/5 and 3/2; order 8, of delta times 1, 3/4, 1/2 and 1/4. Exponent 1 to 9; beyond delta the field is exactly Newtonian.
pub const MOLLIS_MOLLIFIER_RICHARDSON: i32 = 6;

/// A mollifier without its length delta. A plain value without invariants: fill it and pass it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct mollis_mollifier {
    /// `MOLLIS_MOLLIFIER_...`.
    pub kind: i32,
    /// The order: moments 1 to order - 1 vanish.
    pub order: i32,
    /// The exponent M: M - 1 continuous derivatives.
    pub exponent: i32,
}

impl mollis_mollifier {
    /// The mollifier, not yet checked against a dimension.
    pub(crate) fn to_core(self) -> Result<Mollifier> {
        let order = u32::try_from(self.order).map_err(|_| Error::Order);
        let exponent = u32::try_from(self.exponent).map_err(|_| Error::Exponent);
        match self.kind {
            MOLLIS_MOLLIFIER_NONE => Ok(Mollifier::None),
            MOLLIS_MOLLIFIER_COMPACT => Ok(Mollifier::Compact { order: order?, exponent: exponent? }),
            MOLLIS_MOLLIFIER_GAUSSIAN => Ok(Mollifier::Gaussian { order: order? }),
            MOLLIS_MOLLIFIER_PLUMMER => Ok(Mollifier::Plummer),
            MOLLIS_MOLLIFIER_ALGEBRAIC => Ok(Mollifier::Algebraic),
            MOLLIS_MOLLIFIER_VATISTAS => Ok(Mollifier::Vatistas),
            MOLLIS_MOLLIFIER_RICHARDSON => Ok(Mollifier::Richardson { order: order?, exponent: exponent? }),
            _ => Err(Error::UnknownValue),
        }
    }
}
