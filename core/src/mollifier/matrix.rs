//! Hessians as matrices of nalgebra, for programs that go on with linear algebra: principal axes, determinants, Newton steps.

use nalgebra::{SMatrix, SVector};

use super::Blob;
use crate::real::Real;

impl<T: Real, const D: usize> Blob<T, D> {
    /// [`Blob::hessian_at`] as a matrix.
    ///
    /// ```
    /// use mollis_core::mollifier::{Blob, Mollifier};
    /// let blob = Blob::<f64, 3>::new(Mollifier::Compact { order: 2, exponent: 4 }, 0.5)?;
    /// let x = nalgebra::Vector3::new(0.1, 0.2, -0.1);
    /// let hessian = blob.hessian_matrix(&x);
    /// assert!((hessian.trace() - blob.density_at(&x.into())).abs() < 1e-15);
    /// # Ok::<(), mollis_core::Error>(())
    /// ```
    #[must_use]
    pub fn hessian_matrix(&self, x: &SVector<T, D>) -> SMatrix<T, D, D> {
        // Symmetric, so rows may serve as columns.
        SMatrix::from_data(nalgebra::ArrayStorage(self.hessian_at(&x.data.0[0])))
    }
}
