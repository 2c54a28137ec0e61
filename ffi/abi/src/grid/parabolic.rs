//! An attractant with a memory: the caller's array of its values.

use mollis_core::exec::Resources;
use mollis_core::grid::Parabolic;
use mollis_core::memory::{Measure, Plain, Space};
use mollis_core::{Real, Result};

use crate::arrays::{Extent, fetch, of_structure};
use crate::buffers::Output;

/// An attractant with a memory: c of epsilon c_t = Laplacian(c) - k^2 c + density, k being the options' screening; u = -c. Its time scale epsilon and its values, in double precision for both
/// scalars. The values are the state: a checkpoint saves them, and a run that is given them again goes on bit for bit.
///
/// A step in time is exact while the particles rest, and stable for every length. As epsilon goes to 0 it gives the field without a memory. With MOLLIS_WALLS_FREE c is 0 on the mesh's border
/// and outside, which is free space until a time of epsilon R^2 / 4 and some for a border at distance R from the masses. With MOLLIS_WALLS_NO_FLUX and k = 0 the mean of c grows for ever.
///
/// mollis_pks_step advances c with the particles where they are, then moves them in the field of the new c (first order in dt; not MOLLIS_PKS_SCHEME_STRANG_RK4, no heavy particles, one
/// rank). Collisions are decided by the law of the model without a memory, which is right to leading order in epsilon noise / m. mollis_grid2_eval advances c by `time`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_parabolic2 {
    /// epsilon > 0, a time over the square of a length.
    pub time_scale: f64,
    /// mollis_grid2_eval: how long the density acts before the field is taken, positive. mollis_pks_step takes its own dt.
    pub time: f64,
    /// c at the nodes, node (i, j) at j (cells[0] + 1) + i: before the call and, if it succeeds, after it. 0 on the border with MOLLIS_WALLS_FREE, else MOLLIS_ERR_OUT_OF_DOMAIN.
    /// A call of several steps that fails leaves it as it is after the last step that moved the particles, also if that ended with MOLLIS_ERR_EVENTS_FULL.
    pub attractant: *mut f64,
}

/// The caller's, checked as far as sizes and addresses go.
#[derive(Clone, Copy)]
pub(crate) struct Memory {
    pub time_scale: f64,
    pub time: f64,
    attractant: Output<f64>,
    own: Extent,
}

impl Memory {
    /// # Safety
    /// The crate's contract for what `given` points to.
    pub unsafe fn read(given: *const mollis_parabolic2, nodes: usize) -> Result<Option<Self>> {
        if given.is_null() {
            return Ok(None);
        }
        // SAFETY: passed on.
        let mollis_parabolic2 { time_scale, time, attractant } = unsafe { fetch(given)? };
        Ok(Some(Self { time_scale, time, attractant: Output::new(attractant, nodes)?, own: of_structure(given)? }))
    }

    /// The structure.
    pub fn input(&self) -> Extent {
        self.own
    }

    /// The values.
    pub fn output(&self) -> Output<f64> {
        self.attractant
    }

    /// The only statement of the layout: the values in the scalar of the call.
    pub fn layout<'w, T: Plain>(space: &mut impl Space<'w>, nodes: usize) -> Result<&'w mut [T]> {
        space.try_array(nodes)
    }

    pub fn bytes<T: Plain>(nodes: usize) -> Result<usize> {
        Measure::of(|space| Self::layout::<T>(space, nodes).map(|_| ()))
    }

    /// Gives the caller's values to the field, through `copy`.
    ///
    /// # Safety
    /// The crate's contract for the values.
    pub unsafe fn give<T: Real>(
        &self,
        copy: &mut [T],
        field: &mut Parabolic<'_, T>,
        resources: Resources<'_>,
    ) -> Result<()> {
        // SAFETY: passed on.
        let values = unsafe { self.attractant.slice() };
        copy.iter_mut().zip(values).for_each(|(copy, &mut c)| *copy = T::from_f64(c));
        field.set_attractant(copy, resources)
    }

    /// Writes the field's values to the caller's.
    ///
    /// # Safety
    /// The crate's contract for the values.
    pub unsafe fn take<T: Real>(&self, copy: &mut [T], field: &Parabolic<'_, T>) -> Result<()> {
        field.attractant(copy)?;
        // SAFETY: passed on.
        let values = unsafe { self.attractant.slice() };
        values.iter_mut().zip(copy).for_each(|(c, copy)| *c = copy.to_f64());
        Ok(())
    }
}
