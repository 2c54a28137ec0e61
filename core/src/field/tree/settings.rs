//! The order of the basis and the size of the leaves, from the tolerance.

use super::basis::{self, MAX_ORDER};
use super::operators::most_shells;
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
    /// p of the basis.
    pub order: usize,
    /// Polynomials of the basis.
    pub terms: usize,
    /// Nodes along an axis at which the kernel is interpolated.
    pub nodes: usize,
    /// The most points of a leaf.
    pub leaf: usize,
    /// Pairs of cells with so many pairs of points, or fewer, are summed pair by pair.
    pub few: usize,
}

impl Settings {
    /// For a tolerance as [`effective`] gives it.
    pub fn new(tolerance: f64, dimension: usize, newtonian: bool) -> Self {
        // Tolerances as powers of ten, without a logarithm.
        let (mut digits, mut left) = (0.0, tolerance);
        while left < 0.999 && digits < 20.0 {
            left *= 1.778_279_410_038_922_8;
            digits += 0.25;
        }
        let order = ((4.0 * digits) as usize / 3 + 2).max(3);
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
        Self { dimension, newtonian, order, terms, nodes: most_shells(order) + 2, leaf, few }
    }
}

/// From this many sources and targets on (their harmonic mean) the method is faster than the sum over all pairs; a pair of a Newtonian kernel takes less than half the time of others.
pub(super) fn crossover(settings: Settings) -> usize {
    let terms = settings.terms;
    let others = match settings.dimension {
        1 => 300 + 10 * terms,
        2 => 500 + 11 * terms,
        _ => 900 + 26 * terms,
    };
    if settings.newtonian { others * 9 / 4 } else { others }
}
