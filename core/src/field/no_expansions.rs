//! Firmware has no methods of expansions: this file stands for each of them.

use super::options::{Method, Options};
use super::problem::{Essential, Interaction, Outputs, Sources, Wanted};
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::real::Real;

/// What a plan would say of the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::field) struct Settings {
    pub terms: usize,
    pub leaf: usize,
}

/// None: the method serves no sum.
pub(super) fn settings<T: Real, const D: usize>(_: &dyn Interaction<T, D>, _: Wanted, _: &Options) -> Option<Settings> {
    None
}

/// What a plan would call it.
#[allow(dead_code, reason = "one of the two methods has it")]
pub(super) fn method(_: Settings) -> Method {
    Method::Tree
}

/// No.
pub(super) fn pays(_: Settings, _: (usize, usize)) -> bool {
    false
}

/// None is enough.
pub(super) fn least_size(_: Settings) -> usize {
    usize::MAX
}

/// [`Error::Unsupported`].
pub(super) fn workspace_bytes<T: Real>(
    _: Settings,
    _: (usize, usize),
    _: Wanted,
    _: &Options,
    _: usize,
) -> Result<usize> {
    Err(Error::Unsupported)
}

/// [`Error::Unsupported`].
pub(super) fn evaluate<T: Real, const D: usize>(
    _: (&dyn Interaction<T, D>, Wanted),
    _: &Options,
    _: (Sources<'_, T, D>, &[[T; D]]),
    _: Outputs<'_, T, D>,
    _: &mut [u8],
    _: &mut Run<'_>,
) -> Result<()> {
    Err(Error::Unsupported)
}

/// [`Error::Unsupported`].
///
/// # Errors
/// That one.
#[allow(dead_code, reason = "one of the two methods has it")]
pub fn essential_bytes<T: Real, const D: usize>(_: &dyn Interaction<T, D>, _: usize, _: f64) -> Result<usize> {
    Err(Error::Unsupported)
}

/// [`Error::Unsupported`].
///
/// # Errors
/// That one.
#[allow(dead_code, reason = "one of the two methods has it")]
pub fn essential<T: Real, const D: usize>(
    _: &dyn Interaction<T, D>,
    _: Sources<'_, T, D>,
    _: f64,
    _: &[[[T; D]; 2]],
    _: (&mut [u64], Option<Essential<'_, T, D>>),
    _: &mut [u8],
    _: &mut Run<'_>,
) -> Result<()> {
    Err(Error::Unsupported)
}
