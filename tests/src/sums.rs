//! The arguments of the C ABI's sums, from arrays without gaps.

use std::ptr::null;

use mollis_abi::{OutputsOf, SourcesOf, TargetsOf};

/// Sources, targets and outputs of a sum. The structures of each dimension and scalar have the same layout.
#[derive(Clone, Copy, Debug)]
pub struct Sum<T, const D: usize> {
    /// The sources.
    pub sources: SourcesOf<T, D>,
    /// The targets.
    pub targets: TargetsOf<T, D>,
    /// The outputs.
    pub outputs: OutputsOf<T, D>,
}

/// The first pointer, and nulls: the coordinates of a point follow one another.
pub(crate) fn together<T, const D: usize>(points: *const [T; D]) -> [*const T; D] {
    let mut pointers = [null(); D];
    pointers[0] = points.cast();
    pointers
}

impl<T, const D: usize> Sum<T, D> {
    /// Of so many sources and targets.
    #[must_use]
    pub fn new(
        (n, positions, masses): (usize, *const [T; D], *const T),
        (m, targets): (usize, *const [T; D]),
        (potential, gradient, laplacian): (*mut T, *mut [T; D], *mut T),
    ) -> Self {
        Self {
            sources: SourcesOf {
                n,
                positions: together(positions),
                stride: 0,
                masses,
                mass_stride: 0,
                radii: null(),
                radius_stride: 0,
                strengths: [null(); D],
                strength_stride: 0,
            },
            targets: TargetsOf { n: m, positions: together(targets), stride: 0, radii: null(), radius_stride: 0 },
            outputs: OutputsOf {
                potential,
                potential_stride: 0,
                gradient: together(gradient.cast_const()).map(<*const T>::cast_mut),
                gradient_stride: 0,
                laplacian,
                laplacian_stride: 0,
                hessian: null::<T>().cast_mut(),
                hessian_stride: 0,
                factor: 0.0,
                add: 0,
                reserved: 0,
            },
        }
    }

    /// The sources as the structure of their dimension and scalar.
    #[must_use]
    pub fn sources<X>(&self) -> *const X {
        (&raw const self.sources).cast()
    }

    /// The targets.
    #[must_use]
    pub fn targets<X>(&self) -> *const X {
        (&raw const self.targets).cast()
    }

    /// The outputs.
    #[must_use]
    pub fn outputs<X>(&self) -> *const X {
        (&raw const self.outputs).cast()
    }
}
