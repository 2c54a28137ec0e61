//! The one table of tolerances.

use super::reference::{Family, Row};

/// What a unit of error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A unit in the last place of the reference value.
    Ulp,
    /// A unit in the last place of the function's largest magnitude, its value at r = 0: for functions with zeros.
    UlpOfMax,
    /// A unit in the last place of max(|P|, |log delta|) / (2 pi), the two terms of phi = (P + log delta) / (2 pi).
    UlpOfTerms,
    /// A unit in the last place of the bare kernel's magnitude at r = delta (of its Laplacian: or of its gradient factor, where
    /// that is larger).
    UlpOfKernel,
}

impl Unit {
    /// As reports name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ulp => "ulp",
            Self::UlpOfMax => "ulp_of_max",
            Self::UlpOfTerms => "ulp_of_terms",
            Self::UlpOfKernel => "ulp_of_kernel",
        }
    }
}

pub struct Tolerance {
    family: Family,
    /// Names of kernels; empty: any.
    kernels: &'static [&'static str],
    /// Column names.
    quantities: &'static [&'static str],
    /// None: any.
    dimension: Option<u32>,
    orders: core::ops::RangeInclusive<u32>,
    pub unit: Unit,
    pub limit: f64,
    pub reason: &'static str,
}

/// Rounding once costs half a unit; a result below the normal range is rounded twice.
const ONCE: f64 = 1.0;

/// Every quantity that a reference file may hold.
pub const TABLE: &[Tolerance] = &[
    Tolerance {
        family: Family::Compact,
        kernels: &[],
        quantities: &["B", "grad_factor", "hess_factor", "Bprime_over_r"],
        dimension: None,
        orders: 2..=2,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "no function has a zero and all terms are positive: u^2 throughout, then one rounding",
    },
    Tolerance {
        family: Family::Compact,
        kernels: &[],
        quantities: &["grad_factor", "hess_factor"],
        dimension: None,
        orders: 4..=8,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "no zeros; conditions up to 1e3 (order 8) of u^2, then one rounding",
    },
    Tolerance {
        family: Family::Compact,
        kernels: &[],
        quantities: &["B", "Bprime_over_r"],
        dimension: None,
        orders: 4..=8,
        unit: Unit::UlpOfMax,
        limit: ONCE,
        reason: "has zeros in the support; beside them u^2 of the maximum, then one rounding",
    },
    Tolerance {
        family: Family::Compact,
        kernels: &[],
        quantities: &["phi"],
        dimension: Some(2),
        orders: 2..=8,
        unit: Unit::UlpOfTerms,
        limit: ONCE,
        reason: "P and log delta cancel where phi changes sign; both carry 100 u^2 or less",
    },
    Tolerance {
        family: Family::Compact,
        kernels: &[],
        quantities: &["phi"],
        dimension: None,
        orders: 2..=8,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "1D by the positive form, 3D without cancellation up to order 4, by 4 at order 6: u^2, then one rounding",
    },
    Tolerance {
        family: Family::Gaussian,
        kernels: &[],
        quantities: &["psi", "psiprime_over_r"],
        dimension: None,
        orders: 4..=6,
        unit: Unit::UlpOfMax,
        limit: ONCE,
        reason: "has zeros; beside them (60 + 2 xi) u^2 of the terms, then one rounding",
    },
    Tolerance {
        family: Family::Gaussian,
        kernels: &[],
        quantities: &["grad_factor", "hess_factor", "mass"],
        dimension: None,
        orders: 4..=6,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "two or three Gaussians cancel by 4 at most, each to u/60 at the switch to its far field: 0.57, one rounding",
    },
    Tolerance {
        family: Family::Gaussian,
        kernels: &[],
        quantities: &["phi"],
        dimension: Some(2),
        orders: 4..=4,
        unit: Unit::UlpOfTerms,
        limit: ONCE,
        reason: "the logarithm cancels where phi changes sign; E1 to u/1000",
    },
    Tolerance {
        family: Family::Gaussian,
        kernels: &[],
        quantities: &["phi"],
        dimension: None,
        orders: 4..=6,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "as the gradient factor",
    },
    Tolerance {
        family: Family::Kernel,
        kernels: &["p4"],
        quantities: &["value", "grad_factor", "laplacian"],
        dimension: None,
        orders: 2..=8,
        unit: Unit::UlpOfKernel,
        limit: 16.0,
        reason: "|x|^4/4 is a polynomial of three positive terms (order 2): 8 roundings, each up to 2 ulp of the result",
    },
    Tolerance {
        family: Family::Kernel,
        kernels: &[],
        quantities: &["value", "grad_factor", "laplacian"],
        dimension: None,
        orders: 2..=8,
        unit: Unit::UlpOfKernel,
        limit: 900.0,
        reason: "1e-13: fits by quadrature of 2000 terms, evaluated by 30 steps of Clenshaw; Morse cancels by up to 20 more",
    },
];

/// The entry for a quantity of a row; the first that fits.
pub fn tolerance(row: &Row, quantity: &str) -> Option<&'static Tolerance> {
    TABLE.iter().find(|t| {
        t.family == row.family
            && (t.kernels.is_empty() || row.kernel.as_deref().is_some_and(|name| t.kernels.contains(&name)))
            && t.quantities.contains(&quantity)
            && t.dimension.is_none_or(|d| d == row.dimension)
            && t.orders.contains(&row.order())
    })
}
