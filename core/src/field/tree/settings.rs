//! The order of the basis and the size of the leaves, from the tolerance.

use super::chebyshev::{MAX_ORDER, basis, most_shells};
use super::harmonics;
use crate::error::{Error, Result};
use crate::field::{Method, Options};
use crate::real::Real;

/// The least tolerance: below it sums go direct.
pub(super) const fn floor<T: Real>() -> f64 {
    if T::DIGITS > 24 { 1e-12 } else { 1e-5 }
}

/// The caller's tolerance, or the floor where that is larger.
pub(super) fn effective<T: Real>(tolerance: f64) -> f64 {
    if tolerance > floor::<T>() { tolerance } else { floor::<T>() }
}

/// What the tolerance decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::field) struct Settings {
    pub dimension: usize,
    /// Whether the kernel is Newtonian, with a mollifier or without.
    pub newtonian: bool,
    /// Whether the series are those of spherical harmonics.
    pub harmonics: bool,
    /// p of the series.
    pub order: usize,
    /// Terms of the series.
    pub terms: usize,
    /// Nodes along an axis at which the kernel is interpolated.
    pub nodes: usize,
    /// The most points of a leaf, and how many are best if points are uniform (0: any).
    pub leaf: usize,
    pub mean: usize,
    /// Pairs of cells with so many pairs of points, or fewer, are summed pair by pair.
    pub few: usize,
}

impl Settings {
    /// For a tolerance as [`effective`] gives it, and a kernel that is Newtonian or not, and if so, beyond its mollifier's support as without one or not.
    pub fn of(options: &Options, dimension: usize, newtonian: Option<bool>) -> Self {
        if dimension == 3 && newtonian == Some(true) && options.method != Some(Method::Tree) {
            Self::harmonics(options.tolerance)
        } else {
            Self::polynomials(options.tolerance, dimension, newtonian.is_some())
        }
    }

    /// For spherical harmonics.
    fn harmonics(tolerance: f64) -> Self {
        let order = harmonics::order(digits(tolerance));
        let few = order * order;
        let mean = harmonics::points_of_leaf(order);
        let leaf = mean + mean / 2 + 16;
        Self { dimension: 3, newtonian: true, harmonics: true, order, terms: order * order, nodes: 0, leaf, mean, few }
    }

    /// For polynomials.
    pub fn polynomials(tolerance: f64, dimension: usize, newtonian: bool) -> Self {
        let order = ((4.0 * digits(tolerance)) as usize / 3 + 2).max(3);
        let order = if order > MAX_ORDER { MAX_ORDER } else { order };
        let terms = basis::count(dimension, order);
        // The cost of a translation, in pairs of points; and the size from which the parts of a leaf cost less than itself: with 3^d near cells and 6^d - 3^d translations a cell,
        // its square is 2, 12 and 56 times that on the line, in the plane and in space.
        let few = terms * terms / 120;
        let leaf = match dimension {
            1 => 24,
            2 => (terms / 3).max(24),
            _ => (2 * terms / 3).max(64),
        };
        // In space few levels fit a number of points.
        let mean = if dimension > 2 { 2 * leaf / 3 } else { 0 };
        Self { dimension, newtonian, harmonics: false, order, terms, nodes: most_shells(order) + 2, leaf, mean, few }
    }
}

impl Settings {
    /// Room for the cells of so many points, sources or targets: what uniform ones need, and more.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub fn cells(&self, points: usize) -> Result<usize> {
        // Where the width follows the points, leaves are as full as they should be.
        let some = if self.mean > 0 { 4 } else { 6 };
        let leaves = points.checked_mul(some).and_then(|points| points.checked_div(self.leaf));
        leaves.and_then(|leaves| leaves.checked_add(512)).ok_or(Error::TooLarge)
    }
}

/// A tolerance's digits, in quarters, without a logarithm.
fn digits(tolerance: f64) -> f64 {
    let (mut digits, mut left) = (0.0, tolerance);
    while left < 0.999 && digits < 20.0 {
        left *= 1.778_279_410_038_922_8;
        digits += 0.25;
    }
    digits
}

/// From this many sources and targets on (their harmonic mean) the method is faster than the sum over all pairs; a pair of a Newtonian kernel takes less than half the time of others.
pub(super) fn crossover(settings: Settings) -> usize {
    let terms = settings.terms;
    if settings.harmonics {
        return 1000 + 150 * settings.order;
    }
    let others = match settings.dimension {
        1 => 300 + 10 * terms,
        2 => 500 + 11 * terms,
        _ => 900 + 26 * terms,
    };
    if settings.newtonian { others * 9 / 4 } else { others }
}
