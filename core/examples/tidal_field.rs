//! The tidal field in the middle of three softened masses: the principal axes of the Hessian of their potential, by nalgebra.
//!
//!     cargo run --release -p mollis-core --features nalgebra --example tidal_field
#![allow(clippy::disallowed_methods, reason = "a program with std")]

use mollis_core::Result;
use mollis_core::mollifier::{Blob, Mollifier};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

fn main() -> Result<()> {
    let blob = Blob::<f64, 3>::new(Mollifier::Compact { order: 4, exponent: 5 }, 0.25)?;
    let masses =
        [(2.0, Vector3::new(1.0, 0.0, 0.0)), (1.0, Vector3::new(-0.5, 0.8, 0.0)), (0.5, Vector3::new(0.0, 0.1, 0.05))];

    let at = Vector3::new(0.0, 0.0, 0.0);
    let hessian: Matrix3<f64> = masses.iter().map(|(mass, x)| blob.hessian_matrix(&(at - x)) * *mass).sum();

    // The Laplacian of the potential is the density: here that of the third mass, the only one within 0.25.
    let density: f64 = masses.iter().map(|(mass, x)| mass * blob.density_at(&(at - x).into())).sum();
    assert!((hessian.trace() - density).abs() < 1e-12 * density);

    let axes = SymmetricEigen::new(hessian);
    for (value, axis) in axes.eigenvalues.iter().zip(axes.eigenvectors.column_iter()) {
        println!("{value:9.5} along ({:7.4}, {:7.4}, {:7.4})", axis[0], axis[1], axis[2]);
    }
    Ok(())
}
