//! The arrays of particles or of tracers: checked, and copied where they have gaps.

use mollis_core::aggregation::{Trajectories, Wanted};
use mollis_core::memory::{Plain, Space};
use mollis_core::{Error, Real, Result};

use super::particles::ParticlesOf;
use crate::arrays::{Column, Extents, Points, Way, apart, fetch, gathered_column};
use crate::buffers::Range;

/// The arrays of particles or of tracers, checked.
pub(super) struct Arrays<T, const D: usize> {
    pub n: usize,
    positions: Points<T, D>,
    /// None of tracers.
    masses: Option<Column<T>>,
    density: Option<Column<T>>,
    velocity: Option<Points<T, D>>,
    divergence: Option<Column<T>>,
}

/// Arrays of the workspace in place of a caller's that have gaps.
pub(super) struct Copies<'w, T, const D: usize> {
    positions: &'w mut [[T; D]],
    masses: &'w mut [T],
    density: &'w mut [T],
    velocity: &'w mut [[T; D]],
    divergence: &'w mut [T],
}

impl<T: Real, const D: usize> Arrays<T, D>
where
    [T; D]: Plain,
{
    /// # Safety
    /// The crate's contract for the structure.
    pub unsafe fn read(given: *const ParticlesOf<T, D>, massless: bool) -> Result<Self> {
        // SAFETY: passed on.
        let given = unsafe { fetch(given)? };
        let n = given.n;
        if massless && !given.divergence.is_null() {
            return Err(Error::Unsupported);
        }
        Ok(Self {
            n,
            positions: Points::new(given.positions, given.stride, n)?,
            masses: if massless { None } else { Some(Column::new(given.masses.cast_mut(), given.mass_stride, n)?) },
            density: Column::optional(given.density, given.density_stride, n)?,
            velocity: Points::optional(given.velocity, given.velocity_stride, n)?,
            divergence: Column::optional(given.divergence, given.divergence_stride, n)?,
        })
    }

    /// What there are arrays for.
    pub fn wanted(&self) -> Wanted {
        Wanted {
            density: self.density.is_some(),
            velocity: self.velocity.is_some(),
            divergence: self.divergence.is_some(),
            ..Wanted::default()
        }
    }

    /// Refuses arrays of particles and tracers that overlap each other, another output or an input.
    pub fn check(particles: &Self, tracers: Option<&Self>, others: &[Option<Range>], given: &[Range]) -> Result<()> {
        let (mut outputs, mut inputs) = (Extents::new(), Extents::new());
        particles.extents(&mut outputs, &mut inputs);
        tracers.into_iter().for_each(|tracers| tracers.extents(&mut outputs, &mut inputs));
        outputs.add(others.iter().flatten().map(|&range| range.into()));
        inputs.add(given.iter().map(|&range| range.into()));
        apart(outputs.as_slice(), inputs.as_slice())
    }

    fn extents(&self, outputs: &mut Extents, inputs: &mut Extents) {
        outputs.add(self.positions.extents()).add(self.density.map(|c| c.extent()));
        outputs.add(self.velocity.iter().flat_map(Points::extents)).add(self.divergence.map(|c| c.extent()));
        inputs.add(self.masses.map(|c| c.extent()));
    }

    pub fn layout<'w>(&self, space: &mut impl Space<'w>) -> Result<Copies<'w, T, D>> {
        let column = |column: &Option<Column<T>>| column.as_ref().map_or(0, Column::copied);
        Ok(Copies {
            positions: space.try_array(self.positions.copied())?,
            masses: space.try_array(column(&self.masses))?,
            density: space.try_array(column(&self.density))?,
            velocity: space.try_array(self.velocity.as_ref().map_or(0, Points::copied))?,
            divergence: space.try_array(column(&self.divergence))?,
        })
    }

    /// The masses, and what is advanced or wanted: the caller's arrays, or copies of them.
    ///
    /// # Safety
    /// The crate's contract for the arrays, which overlap nothing.
    pub unsafe fn state<'a>(&self, copies: &'a mut Copies<'_, T, D>) -> (&'a [T], Trajectories<'a, T, D>) {
        // SAFETY: passed on.
        unsafe {
            if !self.positions.is_dense() {
                self.positions.gather(copies.positions);
            }
            if let Some(density) = self.density.filter(|density| !density.is_dense()) {
                density.gather(copies.density);
            }
            let column =
                |column: Column<T>, copy: &'a mut [T]| if column.is_dense() { column.array_mut() } else { copy };
            let points = |points: Points<T, D>, copy: &'a mut [[T; D]]| {
                if points.is_dense() { points.array_mut() } else { copy }
            };
            let masses = self.masses.map_or(&[][..], |masses| gathered_column(masses, copies.masses));
            let trajectories = Trajectories {
                positions: points(self.positions, copies.positions),
                density: self.density.map(|density| column(density, copies.density)),
                velocity: self.velocity.map(|velocity| points(velocity, copies.velocity)),
                divergence: self.divergence.map(|divergence| column(divergence, copies.divergence)),
            };
            (masses, trajectories)
        }
    }

    /// Brings copies back to the caller; velocities and divergences only if `finished`.
    ///
    /// # Safety
    /// As [`Arrays::state`], whose results are no longer used.
    pub unsafe fn scatter(&self, copies: &Copies<'_, T, D>, finished: bool) {
        let columns = [(self.density, &*copies.density), (self.divergence.filter(|_| finished), &*copies.divergence)];
        let points =
            [(Some(self.positions), &*copies.positions), (self.velocity.filter(|_| finished), &*copies.velocity)];
        // SAFETY: passed on.
        unsafe {
            for (column, copy) in columns {
                if let Some(column) = column.filter(|column| !column.is_dense()) {
                    column.scatter(copy.iter().copied(), Way::PLAIN);
                }
            }
            for (points, copy) in points {
                if let Some(points) = points.filter(|points| !points.is_dense()) {
                    points.scatter(copy, Way::PLAIN);
                }
            }
        }
    }
}
