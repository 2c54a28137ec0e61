//! Sums of kernels as the field sums see them.

use super::{Interaction, Wanted};
use crate::kernel::Kernel;
use crate::mollifier::Blob;
use crate::real::Real;

impl<T: Real, const D: usize> Interaction<T, D> for Kernel<'_, T, D> {
    fn value(&self, r: T) -> T {
        Kernel::value(self, r)
    }
    fn gradient_factor(&self, r: T) -> T {
        Kernel::gradient_factor(self, r)
    }
    fn laplacian(&self, r: T) -> T {
        Kernel::laplacian(self, r)
    }
    fn newtonian(&self) -> Option<(T, &Blob<T, D>)> {
        self.is_newtonian().then(|| (self.newtonian_coefficient(), self.blob()))
    }
    fn sum(&self) -> Option<&Kernel<'_, T, D>> {
        Some(self)
    }
    fn pair(&self, r: T, wanted: Wanted) -> [T; 3] {
        Kernel::pair(self, r, wanted.into())
    }
    fn is_singular(&self) -> bool {
        Kernel::is_singular(self)
    }
}
