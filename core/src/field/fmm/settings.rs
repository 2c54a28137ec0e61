//! The order of the expansions and the size of the leaves, from the tolerance.
//!
//! Two boxes of radii a >= b about centres at a distance d are *well separated* if a + [`OPENING`] b < [`OPENING`] d: every source is then closer to its centre than
//! `OPENING` times the distance from there to any target, and every target likewise. With p terms either series is cut with an error of at most
//! `OPENING^p / (1 - OPENING)` times sum |m| over the least distance (Greengard & Rokhlin 1987, Lemma 2.1 and Theorem 2.4, without the powers that the distance to
//! the box adds). Few pairs of boxes are as close as that, and errors of different pairs have different phases: the measured error of all targets in the l2 norm is far
//! below the bound. [`terms`] is fitted to what is left where they do not average: targets in one place, and a mass that is larger than all others together. There errors are
//! up to 0.5 of the tolerance, relative to the norm of sum |m| |K| (test `fmm::crowds_of_targets_keep_the_tolerance`); nearly all mass in one place and nearly all targets in another, 0.9
//! (found by `cargo xtask fuzz`, `fuzz/corpus/fmm/two-clusters`). For other points they are below a hundredth of it; relative to
//! the sum itself, with masses of random sign, below a tenth (test `fmm::every_tolerance_on_every_kind_of_points`).

use crate::field::Wanted;
use crate::real::Real;
use crate::simd::MAX_LANES;

/// The opening of well separated boxes.
pub(super) const OPENING: f64 = 0.55;
/// Its logarithm.
pub(super) const OPENING_LOG: f64 = -0.597_837_000_755_620_4;

/// The most terms of an expansion.
pub(super) const MAX_TERMS: usize = 48;

/// Of these numbers: (2 p - 2)! must be one.
const fn most_terms<T: Real>() -> usize {
    if T::DIGITS > 24 { MAX_TERMS } else { 18 }
}

/// The least tolerance: below it sums go direct. Rounding in the expansions is some units in the last place of sum |m| |K|; so is that of a direct sum.
pub(super) const fn floor<T: Real>() -> f64 {
    if T::DIGITS > 24 { 1e-13 } else { 1e-5 }
}

/// The tolerance for the expansions of gradients: the caller's, or the floor where that is larger. Second derivatives of a series that is cut after p terms have p times the error.
pub(super) fn effective<T: Real>(tolerance: f64, wanted: Wanted) -> f64 {
    let tolerance = if tolerance > floor::<T>() { tolerance } else { floor::<T>() };
    if wanted.hessian { tolerance / 16.0 } else { tolerance }
}

/// What the tolerance decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::field) struct Settings {
    /// Terms of an expansion.
    pub terms: usize,
    /// The most points of a leaf; twice as many where its cell is a square.
    pub leaf: usize,
}

impl Settings {
    /// For a tolerance as [`effective`] gives it.
    pub fn new<T: Real>(tolerance: f64, wanted: Wanted) -> Self {
        let terms = terms::<T>(tolerance);
        Self { terms, leaf: leaf(terms, wanted) }
    }

    /// [`Settings::terms`], rounded up to the longest vectors.
    pub fn stride<T: Real>(&self) -> usize {
        self.terms.next_multiple_of(if T::DIGITS > 24 { MAX_LANES / 2 } else { MAX_LANES })
    }
}

/// Terms for a tolerance.
fn terms<T: Real>(tolerance: f64) -> usize {
    // Tolerances as powers of ten, without a logarithm.
    let (mut digits, mut left) = (0.0, tolerance);
    while left < 0.999 && digits < 20.0 {
        left *= 1.778_279_410_038_922_8;
        digits += 0.25;
    }
    let terms = (3.6 * digits) as usize + 1;
    if terms < 4 { 4 } else { terms.min(most_terms::<T>()) }
}

/// The size of leaves: the cost of translations grows with the number of terms and shrinks with larger leaves, whose near pairs cost the more with their logarithms.
fn leaf(terms: usize, wanted: Wanted) -> usize {
    match terms {
        _ if wanted.potential => 24,
        0..=22 => 32,
        _ => 48,
    }
}

/// From this many sources and targets on (their harmonic mean) the method is faster than the sum over all pairs.
pub(super) fn crossover(terms: usize) -> usize {
    400 + 12 * terms
}
