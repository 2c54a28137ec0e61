//! In place of `meshes`, in a build without them: the choice is refused, and there is nothing to choose about a sum.

use core::convert::Infallible;
use core::marker::PhantomData;

use mollis_core::exec::Resources;
use mollis_core::field;
use mollis_core::pks::Heavy;
use mollis_core::{Error, Real, Result};

use super::mollis_pks_attraction;
use crate::buffers::Range;
use crate::grid::medium::Field;

/// Never there.
pub(super) struct MeshChoice<'k, T: Real>(Infallible, PhantomData<(&'k (), T)>);

impl<T: Real> MeshChoice<'_, T> {
    /// # Safety
    /// None is needed.
    pub unsafe fn read(_given: &mollis_pks_attraction) -> Result<Self> {
        Err(Error::Unsupported)
    }

    pub fn bytes(&self, _workers: usize) -> Result<usize> {
        match self.0 {}
    }

    pub fn domain(&self) -> [[T; 2]; 2] {
        match self.0 {}
    }

    pub fn output(&self) -> Option<Range> {
        match self.0 {}
    }

    /// # Safety
    /// None is needed.
    pub unsafe fn field<'w>(&self, _memory: &'w mut [u8], _resources: Resources<'_>) -> Result<Field<'w, T>> {
        match self.0 {}
    }

    pub fn heavy(&self) -> Option<Heavy<'_, T>> {
        match self.0 {}
    }
}

/// Not held.
pub(super) type SumOptions = &'static field::Options;

pub(super) fn sum_options(tolerance: f64) -> Result<SumOptions> {
    if mollis_core::Scalar::is_finite(tolerance) { Ok(&field::Options::DEFAULT) } else { Err(Error::NotFinite) }
}

/// Not asked, as a comparison of doubles takes flash.
pub(super) fn has_heavy(_attraction: &mollis_pks_attraction) -> bool {
    false
}
