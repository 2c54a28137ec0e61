//! The one table of tolerances.

/// What a unit of error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// A unit in the last place of the reference value.
    Ulp,
    /// A unit in the last place of the function's largest magnitude, its value at r = 0: for functions with zeros.
    UlpOfMax,
    /// A unit in the last place of max(|P|, |log delta|) / (2 pi), the two terms of phi = (P + log delta) / (2 pi).
    UlpOfTerms,
}

/// What a row of a reference file is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Compact,
    Gaussian,
    Kernel,
}

pub struct Tolerance {
    family: Family,
    /// Column names.
    quantities: &'static [&'static str],
    /// None: any.
    dimension: Option<u32>,
    orders: core::ops::RangeInclusive<u32>,
    pub unit: Unit,
    pub limit: f64,
    /// Printed in the documentation.
    pub reason: &'static str,
}

/// Rounding once costs half a unit; a result below the normal range is rounded twice.
const ONCE: f64 = 1.0;

/// Every quantity that a reference file may hold.
pub const TABLE: &[Tolerance] = &[
    Tolerance {
        family: Family::Compact,
        quantities: &["B", "grad_factor", "hess_factor", "Bprime_over_r"],
        dimension: None,
        orders: 2..=2,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "no function has a zero and all terms are positive: u^2 throughout, then one rounding",
    },
    Tolerance {
        family: Family::Compact,
        quantities: &["grad_factor", "hess_factor"],
        dimension: None,
        orders: 4..=8,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "no zeros; conditions up to 1e3 (order 8) of u^2, then one rounding",
    },
    Tolerance {
        family: Family::Compact,
        quantities: &["B", "Bprime_over_r"],
        dimension: None,
        orders: 4..=8,
        unit: Unit::UlpOfMax,
        limit: ONCE,
        reason: "has zeros in the support; beside them u^2 of the maximum, then one rounding",
    },
    Tolerance {
        family: Family::Compact,
        quantities: &["phi"],
        dimension: Some(2),
        orders: 2..=8,
        unit: Unit::UlpOfTerms,
        limit: ONCE,
        reason: "P and log delta cancel where phi changes sign; both carry 100 u^2 or less",
    },
    Tolerance {
        family: Family::Compact,
        quantities: &["phi"],
        dimension: None,
        orders: 2..=8,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "1D by the positive form, 3D without cancellation up to order 4, by 4 at order 6: u^2, then one rounding",
    },
    Tolerance {
        family: Family::Gaussian,
        quantities: &["psi", "psiprime_over_r"],
        dimension: None,
        orders: 4..=6,
        unit: Unit::UlpOfMax,
        limit: ONCE,
        reason: "has zeros; beside them (60 + 2 xi) u^2 of the terms, then one rounding",
    },
    Tolerance {
        family: Family::Gaussian,
        quantities: &["grad_factor", "hess_factor", "mass"],
        dimension: None,
        orders: 4..=6,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "two or three Gaussians cancel by 4 at most, each to u/60 at the switch to its far field: 0.57, one rounding",
    },
    Tolerance {
        family: Family::Gaussian,
        quantities: &["phi"],
        dimension: Some(2),
        orders: 4..=4,
        unit: Unit::UlpOfTerms,
        limit: ONCE,
        reason: "the logarithm cancels where phi changes sign; E1 to u/1000",
    },
    Tolerance {
        family: Family::Gaussian,
        quantities: &["phi"],
        dimension: None,
        orders: 4..=6,
        unit: Unit::Ulp,
        limit: ONCE,
        reason: "as the gradient factor",
    },
];

/// The entry for a quantity; the first that fits.
pub fn tolerance(family: Family, quantity: &str, dimension: u32, order: u32) -> Option<&'static Tolerance> {
    TABLE.iter().find(|t| {
        t.family == family
            && t.quantities.contains(&quantity)
            && t.dimension.is_none_or(|d| d == dimension)
            && t.orders.contains(&order)
    })
}
