//! The methods that expand the fields of distant sources: which of them serves a sum.

use super::options::{Method, Options};
use super::problem::{Interaction, Outputs, Sources, Wanted};
use super::{fmm, tree};
use crate::error::Result;
use crate::exec::Run;
use crate::real::Real;

/// The method, with its settings.
#[derive(Clone, Copy, Debug)]
pub(super) enum Expansions {
    /// The fast multipole method in the plane.
    Plane(fmm::Settings),
    /// Cells: in space the fast multipole method of a Newtonian kernel, else a series for any smooth kernel.
    Cells(tree::Settings),
}

impl Expansions {
    /// That for a sum, if one serves it: to the tolerance, or, where the method is forced, to its least one.
    pub fn of<T: Real, const D: usize>(
        kernel: &dyn Interaction<T, D>,
        wanted: Wanted,
        options: &Options,
    ) -> Option<Self> {
        let plane = fmm::settings(kernel, wanted, options).filter(|_| options.method != Some(Method::Tree));
        plane.map(Self::Plane).or_else(|| tree::settings(kernel, wanted, options).map(Self::Cells))
    }

    /// What it is called.
    pub fn method(self) -> Method {
        match self {
            Self::Plane(_) => Method::Fmm,
            Self::Cells(settings) => tree::method(settings),
        }
    }

    /// Whether so many sources and targets take less time than the sum over all pairs.
    pub fn pays(self, sizes: (usize, usize)) -> bool {
        match self {
            Self::Plane(settings) => fmm::pays(settings, sizes),
            Self::Cells(settings) => tree::pays(settings, sizes),
        }
    }

    /// For a plan's text: terms, points of a leaf, and the numbers of sources and targets from which it is faster than all pairs.
    pub fn numbers(self) -> [usize; 3] {
        match self {
            Self::Plane(settings) => [settings.terms, settings.leaf, fmm::least_size(settings)],
            Self::Cells(settings) => [settings.terms, settings.leaf, tree::least_size(settings)],
        }
    }

    /// Bytes of workspace.
    ///
    /// # Errors
    /// [`crate::Error::TooLarge`].
    pub fn workspace_bytes<T: Real>(
        self,
        sizes: (usize, usize),
        wanted: Wanted,
        options: &Options,
        workers: usize,
    ) -> Result<usize> {
        match self {
            Self::Plane(settings) => fmm::workspace_bytes::<T>(settings, sizes, wanted, options, workers),
            Self::Cells(settings) => tree::workspace_bytes::<T>(settings, sizes, wanted, options, workers),
        }
    }

    /// Overwrites the outputs, which are among those wanted of the plan. The caller has checked lengths, values and the workspace's size.
    pub fn evaluate<T: Real, const D: usize>(
        self,
        of: (&dyn Interaction<T, D>, Wanted),
        options: &Options,
        points: (Sources<'_, T, D>, &[[T; D]]),
        outputs: Outputs<'_, T, D>,
        workspace: &mut [u8],
        run: &mut Run<'_>,
    ) -> Result<()> {
        match self {
            Self::Plane(_) => fmm::evaluate(of, options, points, outputs, workspace, run),
            Self::Cells(_) => tree::evaluate(of, options, points, outputs, workspace, run),
        }
    }
}
