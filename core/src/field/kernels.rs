//! Sums of kernels as the field sums see them.

use super::problem::{Interaction, Wanted};
use crate::build;
use crate::kernel::Kernel;
use crate::mollifier::Blob;
use crate::real::Real;

/// Without [`build::KERNELS`] every sum is Newtonian and asks for [`Interaction::newtonian`] alone: the
/// questions about a distance answer NaN then. [`Kernel`]'s own functions are there in every build.
impl<T: Real, const D: usize> Interaction<T, D> for Kernel<'_, T, D> {
    fn value(&self, r: T) -> T {
        if build::KERNELS { Kernel::value(self, r) } else { T::NAN }
    }
    fn gradient_factor(&self, r: T) -> T {
        if build::KERNELS { Kernel::gradient_factor(self, r) } else { T::NAN }
    }
    fn laplacian(&self, r: T) -> T {
        if build::KERNELS { Kernel::laplacian(self, r) } else { T::NAN }
    }
    fn newtonian(&self) -> Option<(T, &Blob<T, D>)> {
        self.is_newtonian().then(|| (self.newtonian_coefficient(), self.blob()))
    }
    fn sum(&self) -> Option<&Kernel<'_, T, D>> {
        Some(self)
    }
    fn pair(&self, r: T, wanted: Wanted) -> [T; 3] {
        if build::KERNELS { Kernel::pair(self, r, wanted.into()) } else { [T::NAN; 3] }
    }
    fn pair_wide(&self, r: f64, wanted: Wanted) -> [f64; 3] {
        if build::KERNELS { Kernel::pair_wide(self, r, wanted.into()) } else { [f64::NAN; 3] }
    }
    fn is_singular(&self) -> bool {
        Kernel::is_singular(self)
    }
}
