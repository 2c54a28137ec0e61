//! Which method runs, why, what it skips and what it needs.

use super::expansions::Expansions;
use super::options::{Method, Options, PairRadius, Reason};
use super::problem::{Interaction, Wanted};
use super::{pairs, skips};
use crate::build;
use crate::error::{Error, Result};
use crate::exec::MAX_WORKERS;
use crate::mollifier::{Blob, Mollifier};
use crate::real::{Real, Scalar};

/// What will run. A small value, made from sizes alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    n_sources: usize,
    n_targets: usize,
    wanted: Wanted,
    options: Options,
    method: Method,
    reason: Reason,
    bytes: usize,
    bytes_per_worker: usize,
    /// Terms, points of a leaf, and the numbers of sources and targets from which a method of expansions is faster.
    expansions: Option<[usize; 3]>,
}

/// Whether sums of the kernel take core radii, those of a pair, and vector strengths, if these are asked for.
pub(super) fn serves<T: Real, const D: usize>(kernel: &dyn Interaction<T, D>, options: &Options) -> bool {
    if (!options.radii || options.strengths) && options.pair_radius != PairRadius::Source {
        return false;
    }
    if !options.radii && !options.strengths {
        return true;
    }
    let mollified = |(_, blob): (T, &Blob<T, D>)| blob.mollifier() != Mollifier::None;
    build::METHODS
        && (!options.radii || kernel.newtonian().is_some_and(mollified))
        && (!options.strengths || (D == 3 && kernel.newtonian().is_some()))
}

/// Chooses the method for sums of `kernel` over `n_sources` at `n_targets`.
///
/// # Errors
/// [`crate::Error::Unsupported`]: the forced method cannot do this, or core radii with a kernel that is not Newtonian or has no mollifier, or a pair's
/// radius without radii or with vector strengths, or
/// vector strengths but for the gradient of a Newtonian kernel in space. [`crate::Error::OutOfDomain`]: a negative tolerance. [`crate::Error::TooLarge`]: the workspace's size overflows.
pub fn plan<T: Real, const D: usize>(
    kernel: &dyn Interaction<T, D>,
    n_sources: usize,
    n_targets: usize,
    wanted: Wanted,
    options: &Options,
) -> Result<Plan> {
    let reason = if options.method.is_some() { Reason::Forced } else { Reason::NothingFaster };
    let (a, b) = options.combination;
    if !(Scalar::is_finite(a) && Scalar::is_finite(b) && Scalar::is_finite(options.tolerance)) {
        return Err(Error::NotFinite);
    }
    if options.tolerance < 0.0 {
        return Err(Error::OutOfDomain);
    }
    if D != 2 && (a, b) != (1.0, 0.0) {
        return Err(Error::Unsupported);
    }
    if !serves(kernel, options) {
        return Err(Error::Unsupported);
    }
    if (options.strengths && (wanted.potential || wanted.laplacian || wanted.hessian))
        || (wanted.hessian && !build::METHODS)
    {
        return Err(Error::Unsupported);
    }
    let sizes = (n_sources, n_targets);
    let needed = wanted.in_dimension(D);
    if let Some((method, reason)) = skips::choose(kernel, sizes, needed, options)? {
        let one = skips::workspace_bytes(kernel, method, (sizes, needed), options, 1)?;
        let bytes_per_worker = skips::workspace_bytes(kernel, method, (sizes, needed), options, 2)?.saturating_sub(one);
        let bytes = one.saturating_sub(bytes_per_worker);
        let expansions = Expansions::of(kernel, wanted, options)
            .filter(|expansions| expansions.method() == method)
            .map(Expansions::numbers);
        let options = *options;
        return Ok(Plan { n_sources, n_targets, wanted, options, method, reason, bytes, bytes_per_worker, expansions });
    }
    let bytes = pairs::workspace_bytes::<T, D>(n_sources, [options.radii, options.strengths])?;
    Ok(Plan {
        n_sources,
        n_targets,
        wanted,
        options: *options,
        method: Method::Direct,
        reason,
        bytes,
        bytes_per_worker: 0,
        expansions: None,
    })
}

impl Plan {
    /// The number of sources it is for.
    #[must_use]
    pub fn n_sources(&self) -> usize {
        self.n_sources
    }

    /// The number of targets it is for.
    #[must_use]
    pub fn n_targets(&self) -> usize {
        self.n_targets
    }

    /// What was asked for beyond the outputs.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The method that will run.
    #[must_use]
    pub fn method(&self) -> Method {
        self.method
    }

    /// Why.
    #[must_use]
    pub fn reason(&self) -> Reason {
        self.reason
    }

    #[allow(clippy::manual_clamp, reason = "where it is not inlined, clamp's check of its bounds is a way to panic")]
    /// Bytes that [`super::evaluate`] needs for an executor of so many workers.
    ///
    /// # Errors
    /// [`crate::Error::TooLarge`].
    pub fn workspace_bytes(&self, workers: usize) -> Result<usize> {
        if !build::WORKERS {
            return Ok(self.bytes);
        }
        let workers = self.bytes_per_worker.checked_mul(workers.max(1).min(MAX_WORKERS)).ok_or(Error::TooLarge)?;
        self.bytes.checked_add(workers).ok_or(Error::TooLarge)
    }

    /// The outputs it is for.
    pub(super) fn wanted(&self) -> Wanted {
        self.wanted
    }

    /// Whether the plan is for these outputs.
    pub(super) fn covers(&self, outputs: Wanted) -> bool {
        (self.wanted.potential || !outputs.potential)
            && (self.wanted.gradient || !outputs.gradient)
            && (self.wanted.laplacian || !outputs.laplacian)
            && (self.wanted.hessian || !outputs.hessian)
    }
}

impl Plan {
    /// What will run, why, and what is skipped, in a sentence, piece by piece to `take`. (core's formatting can panic, which
    /// a library without a panic handler of its own must not carry.)
    pub fn describe(&self, mut take: impl FnMut(&str)) {
        let mut decimal = [0_u8; 20];
        take(match self.method {
            Method::Direct => "direct (all pairs)",
            Method::Moments => "moments (no pair)",
            Method::Sorted => "sorted (one sort, running moments)",
            Method::Neighbours => "neighbours (pairs closer than delta)",
            Method::Split => "split (even powers from moments, the other terms over all pairs)",
            Method::Fmm => "fast multipole method (expansions of distant sources, near pairs exactly)",
            Method::Tree => "tree (the kernel interpolated between distant cells, near pairs exactly)",
        });
        take(": ");
        take(match self.reason {
            Reason::Forced => "as the caller asked",
            Reason::EvenPowers => "every term is an even power",
            Reason::OneDimension => "one dimension, and polynomials of the distance",
            Reason::CompactLaplacian => "only the Laplacian is wanted, which has compact support",
            Reason::ShortRange => "the kernel is below rounding beyond some lengths",
            Reason::SomeEvenPowers => "some terms are even powers",
            Reason::Tolerance => "the tolerance and the number of particles allow it",
            Reason::NothingFaster => "no faster method serves this kernel, mollifier, dimension, tolerance and size",
        });
        let mut count = |number: usize, what: &str| {
            take("; ");
            take(digits(number, &mut decimal));
            take(what);
        };
        count(self.n_sources, " sources");
        count(self.n_targets, " targets");
        count(self.bytes, " workspace bytes, without copies of arrays with gaps");
        if let Some([terms, leaf, least]) = self.expansions {
            count(terms, " terms an expansion");
            count(leaf, " points in a leaf at most");
            count(least, " sources and targets or more make it faster than all pairs");
        }
        let outputs = [
            (self.wanted.potential, "; potential computed", "; potential skipped"),
            (self.wanted.gradient, "; gradient computed", "; gradient skipped"),
            (self.wanted.laplacian, "; Laplacian computed", "; Laplacian skipped"),
            (self.wanted.hessian, "; second derivatives computed", "; second derivatives skipped"),
        ];
        for (wanted, computed, skipped) in outputs {
            take(if wanted { computed } else { skipped });
        }
        take("; massless sources skipped");
        if matches!(self.method, Method::Direct | Method::Fmm | Method::Tree) {
            take("; a mollifier of compact support evaluated only where a block of targets has a near pair");
        }
    }
}

/// A number's decimal digits.
fn digits(mut number: usize, room: &mut [u8; 20]) -> &str {
    let mut start = room.len();
    for (at, digit) in room.iter_mut().enumerate().rev() {
        *digit = b'0' + (number % 10) as u8;
        number /= 10;
        start = at;
        if number == 0 {
            break;
        }
    }
    room.get(start..).and_then(|digits| core::str::from_utf8(digits).ok()).unwrap_or("")
}

impl core::fmt::Display for Plan {
    /// [`Plan::describe`].
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let mut result = Ok(());
        self.describe(|text| result = result.and_then(|()| f.write_str(text)));
        result
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn digits_are_decimal() {
        for n in [0, 7, 10, 1_234_567_890, usize::MAX] {
            assert_eq!(super::digits(n, &mut [0; 20]), std::format!("{n}"));
        }
    }
}
