//! A caller's choice of a field on a mesh.

use mollis_core::exec::Resources;
use mollis_core::field;
use mollis_core::kernel::Kernel;
use mollis_core::pks::Heavy;
use mollis_core::{Error, Real, Result};

use super::mollis_pks_attraction;
use crate::buffers::Range;
use crate::grid::medium::{Field, Problem};
use crate::grid::mollis_mesh2;
use crate::kernel;
use crate::options as structures;

/// The mesh, its equation, and the kernel and least mass of heavy particles.
pub(super) struct MeshChoice<'k, T: Real> {
    problem: Problem<T>,
    heavy: Option<(Kernel<'k, T, 2>, T)>,
}

impl<T: Real> MeshChoice<'_, T> {
    /// # Safety
    /// The crate's contract for what `given` points to.
    pub unsafe fn read(given: &mollis_pks_attraction) -> Result<Self> {
        // SAFETY: passed on.
        unsafe {
            let problem = Problem::read(mollis_mesh2::read(given.mesh)?, &structures::read(given.grid)?)?;
            let heavy = if given.heavy == 0.0 {
                None
            } else if problem.medium.is_some() || problem.memory.is_some() {
                return Err(Error::Unsupported);
            } else {
                let kernel: Kernel<'_, T, 2> = kernel::open(given.kernel, given.kernel_bytes)?;
                let mass = T::from_wide(given.heavy);
                Heavy { kernel: &kernel, mass, core: kernel.delta() }.check(&problem.equation)?;
                Some((kernel, mass))
            };
            Ok(Self { problem, heavy })
        }
    }

    /// Bytes of the field.
    pub fn bytes(&self, workers: usize) -> Result<usize> {
        self.problem.bytes(workers)
    }

    /// Where a medium's report goes, or the attractant.
    pub fn output(&self) -> Option<Range> {
        self.problem.output()
    }

    /// The box that the mesh covers.
    pub fn domain(&self) -> [[T; 2]; 2] {
        [self.problem.mesh.lower(), self.problem.mesh.upper()]
    }

    /// # Safety
    /// The crate's contract for a medium's arrays and the attractant.
    pub unsafe fn field<'w>(&self, memory: &'w mut [u8], resources: Resources<'_>) -> Result<Field<'w, T>> {
        // SAFETY: passed on.
        unsafe { self.problem.field(memory, resources) }
    }

    pub fn heavy(&self) -> Option<Heavy<'_, T>> {
        let (kernel, mass) = self.heavy.as_ref()?;
        Some(Heavy { kernel, mass: *mass, core: kernel.delta() })
    }
}

/// The options of a sum.
pub(super) type SumOptions = field::Options;

pub(super) fn sum_options(tolerance: f64) -> Result<SumOptions> {
    Ok(field::Options { tolerance, ..field::Options::default() })
}

/// Whether the attraction has heavy particles beside a mesh.
pub(super) fn has_heavy(attraction: &mollis_pks_attraction) -> bool {
    attraction.kind == super::MOLLIS_PKS_ATTRACTION_MESH && attraction.heavy != 0.0
}
