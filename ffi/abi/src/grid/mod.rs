//! Mesh fields: the mesh, and what is solved on it.

pub(crate) mod call;
pub(crate) mod medium;
mod parabolic;

pub use call::GridOutputsOf;
pub use medium::mollis_medium2;
pub use parabolic::mollis_parabolic2;

use mollis_core::grid::{Equation, Mesh, Order, Walls};
use mollis_core::{Error, Real, Result};

use crate::options;
use crate::status::{mollis_status, status};

/// Free space: the field of all mass at its centre is prescribed on the mesh's border, and acts outside. Closer to the centre than half of
/// the smaller mesh width its potential is that at this distance, and its gradient falls linearly to 0.
pub const MOLLIS_WALLS_FREE: i32 = 0;
/// No flux through the border: particles outside act from, and are driven at, their mirror places.
pub const MOLLIS_WALLS_NO_FLUX: i32 = 1;
/// Free space, with the second moments of the mass in that field as well: for long or divided mass. Without screening only.
/// Closer to the centre than sqrt(2 |Q| / |M|), Q = sum m (x + i y)^2 about it, where this expansion means nothing, their part grows no more.
pub const MOLLIS_WALLS_FREE_QUADRUPOLE: i32 = 2;

/// A rectangle cut into cells[0] by cells[1] equal cells, at least 2 each way. It has (cells[0] + 1) (cells[1] + 1) nodes; arrays over
/// the nodes run along x first.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_mesh2 {
    /// The lower left corner.
    pub lower: [f64; 2],
    /// The upper right corner.
    pub upper: [f64; 2],
    /// Cells along x and y.
    pub cells: [usize; 2],
}

impl mollis_mesh2 {
    /// # Safety
    /// The crate's contract for `mesh`.
    pub(crate) unsafe fn read<T: Real>(mesh: *const Self) -> Result<Mesh<T>> {
        if mesh.is_null() {
            return Err(Error::NullPointer);
        }
        if !mesh.is_aligned() {
            return Err(Error::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises a mesh there.
        let mesh = unsafe { *mesh };
        Mesh::new(mesh.lower.map(T::from_f64), mesh.upper.map(T::from_f64), mesh.cells)
    }
}

/// Which field a grid solves for. Fill it with `mollis_grid2_options_init`; null means the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_grid2_options {
    /// Bytes of this structure, as `mollis_grid2_options_init` sets it.
    pub size: u32,
    /// `MOLLIS_WALLS_*`. Default: free space.
    pub walls: i32,
    /// k >= 0 of Laplacian(u) - k^2 u = density. Default: 0.
    pub screening: f64,
    /// How fast the error of the particles' attraction, summed over many, falls with the mesh width where their density is smooth: 2 (five points; the
    /// default) or 4 (nine points, a density sharpened by what deposit and interpolation smooth it; for cells whose sides are within a factor of
    /// 1.25 and at most 1/k).
    pub order: i32,
    /// Ignored.
    pub reserved: i32,
    /// The medium; null (the default): the same everywhere. With one, screening is 0, the order 2, and the walls are not MOLLIS_WALLS_FREE_QUADRUPOLE, else
    /// MOLLIS_ERR_UNSUPPORTED.
    pub medium: *const mollis_medium2,
    /// An attractant with a memory; null (the default): the field is that of the moment. With one, the order is 2, there is no medium, and the walls are not
    /// MOLLIS_WALLS_FREE_QUADRUPOLE, else MOLLIS_ERR_UNSUPPORTED.
    pub parabolic: *const mollis_parabolic2,
}

options::options!(mollis_grid2_options {
    walls: MOLLIS_WALLS_FREE,
    screening: 0.0,
    order: 2,
    reserved: 0,
    medium: core::ptr::null(),
    parabolic: core::ptr::null()
});

pub(crate) fn equation<T: Real>(options: &mollis_grid2_options) -> Result<Equation<T>> {
    let walls = match options.walls {
        MOLLIS_WALLS_FREE => Walls::Free,
        MOLLIS_WALLS_NO_FLUX => Walls::NoFlux,
        MOLLIS_WALLS_FREE_QUADRUPOLE => Walls::FreeQuadrupole,
        _ => return Err(Error::UnknownValue),
    };
    let order = match options.order {
        2 => Order::Second,
        4 => Order::Fourth,
        _ => return Err(Error::UnknownValue),
    };
    Ok(Equation { screening: T::from_f64(options.screening), walls, order })
}

/// Fills `options` with the defaults. `size` is `sizeof *options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_grid2_options_init(options: *mut mollis_grid2_options, size: usize) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { options::init(options, size) })
}
