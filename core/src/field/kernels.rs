//! Sums of kernels as the field sums see them.

use super::Interaction;
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
    fn is_singular(&self) -> bool {
        Kernel::is_singular(self)
    }
}
