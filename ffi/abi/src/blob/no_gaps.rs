//! In place of `arrays`, in a build for firmware: arrays without gaps, no tracers, nothing beside positions and densities.

use mollis_core::aggregation::{Trajectories, Wanted};
use mollis_core::memory::{Plain, Space};
use mollis_core::{Error, Real, Result};

use super::particles::ParticlesOf;
use crate::arrays::fetch;
use crate::buffers::{Input, Output, Range, disjoint};

pub(super) struct Arrays<T, const D: usize> {
    pub n: usize,
    positions: Output<[T; D]>,
    masses: Input<T>,
    density: Option<Output<T>>,
}

/// None are made.
pub(super) struct Copies;

impl<T: Real, const D: usize> Arrays<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract for the structure.
    pub unsafe fn read(given: *const ParticlesOf<T, D>, massless: bool) -> Result<Self> {
        // SAFETY: passed on.
        let given = unsafe { fetch(given)? };
        let (n, [first, others @ ..]) = (given.n, given.positions.as_slice()) else { return Err(Error::Dimension) };
        let beside = others.iter().chain(&given.velocity).chain([&given.divergence]).any(|pointer| !pointer.is_null());
        let gaps = given.stride > 0 && given.stride != D || given.mass_stride > 1 || given.density_stride > 1;
        if massless || beside || gaps {
            return Err(Error::Unsupported);
        }
        Ok(Self {
            n,
            positions: Output::new(first.cast(), n)?,
            masses: Input::new(given.masses, n)?,
            density: Output::optional(given.density, n)?,
        })
    }

    pub fn wanted(&self) -> Wanted {
        Wanted { density: self.density.is_some(), ..Wanted::default() }
    }

    pub fn check(particles: &Self, _tracers: Option<&Self>, others: &[Option<Range>], given: &[Range]) -> Result<()> {
        let &[workspace, report, bad, needed] = others else { return Err(Error::Internal) };
        let &[kernel, structure, _] = given else { return Err(Error::Internal) };
        let density = particles.density.map(Output::range);
        disjoint(
            &[Some(particles.positions.range()), density, workspace, report, bad, needed],
            &[particles.masses.range(), kernel, structure],
        )
    }

    pub fn layout<'w>(&self, _space: &mut impl Space<'w>) -> Result<Copies> {
        Ok(Copies)
    }

    /// # Safety
    /// The crate's contract for the arrays, which overlap nothing.
    pub unsafe fn state<'a>(&self, _copies: &'a mut Copies) -> (&'a [T], Trajectories<'a, T, D>) {
        // SAFETY: passed on.
        unsafe {
            let density = self.density.map(|density| density.slice());
            let positions = self.positions.slice();
            (self.masses.slice(), Trajectories { positions, density, velocity: None, divergence: None })
        }
    }

    /// # Safety
    /// None is needed.
    pub unsafe fn scatter(&self, _copies: &Copies, _finished: bool) {}
}
