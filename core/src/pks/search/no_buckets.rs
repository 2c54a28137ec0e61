//! In place of `buckets`, where all particles are few.

use super::Particles;
use super::bound::Bound;
use super::mesh::Mesh;
use super::shared::{Part, Shared};
use crate::error::Result;
use crate::exec::{Ranks, Resources};
use crate::memory::Space;
use crate::pks::collision::Criterion;
use crate::real::Real;

/// None.
pub const LOADS: usize = 0;
/// None.
pub const ROW: usize = 0;

/// No memory.
#[derive(Debug)]
pub struct Buckets<'w>(core::marker::PhantomData<&'w ()>);

/// There is none.
pub struct Bucket<'a> {
    pub first: usize,
    pub count: usize,
    pub mass: f64,
    pub pairs: Option<&'a [u64]>,
}

impl<'w> Buckets<'w> {
    pub fn layout(_space: &mut impl Space<'w>, _n: usize) -> Self {
        Self(core::marker::PhantomData)
    }

    /// Never called.
    pub fn sort<T: Real>(
        &mut self,
        _mesh: &Mesh<T>,
        _criterion: &Criterion<T>,
        _particles: Particles<'_, T>,
        _resources: Resources<'_>,
        _to: (&mut [u64], &mut [u8]),
    ) -> Result<()> {
        Err(crate::error::Error::Unsupported)
    }

    /// Never called.
    pub fn sort_on_ranks<T: Real>(
        &mut self,
        _on: (&Ranks<'_>, Part),
        _known: &mut Shared<'_, T>,
        _by: (&Mesh<T>, &Criterion<T>),
        _particles: (Particles<'_, T>, T),
        _resources: Resources<'_>,
        _to: (&mut [u64], &mut [u8]),
    ) -> Result<()> {
        Err(crate::error::Error::Unsupported)
    }

    /// Never called.
    pub fn complete_on_ranks<T: Real>(
        &mut self,
        _on: (&Ranks<'_>, Part),
        _known: &mut Shared<'_, T>,
        _by: (&Mesh<T>, &Criterion<T>),
        _particles: Particles<'_, T>,
        _resources: Resources<'_>,
        _to: (&mut [u64], &mut [u8]),
    ) -> Result<bool> {
        Err(crate::error::Error::Unsupported)
    }

    pub fn bound<T: Real>(&self, _mesh: &Mesh<T>, smallest: T) -> Bound<'_, T> {
        Bound { starts: &[], sums: &[], width: 0.0, smallest }
    }

    pub fn iter(&self) -> impl Iterator<Item = Bucket<'_>> {
        core::iter::empty()
    }
}
