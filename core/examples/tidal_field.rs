//! The tidal field in the middle of three softened masses: the principal axes of the Hessian of their potential, by nalgebra.
//!
//!     cargo run --release -p mollis-core --features nalgebra --example tidal_field
#![allow(clippy::disallowed_methods, reason = "a program with std")]

use mollis_core::Result;
use mollis_core::exec::Run;
use mollis_core::field::{self, Options, Outputs, Sources, Wanted};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::{Blob, Mollifier};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

fn main() -> Result<()> {
    let blob = Blob::<f64, 3>::new(Mollifier::Compact { order: 4, exponent: 5 }, 0.25)?;
    let masses = [2.0, 1.0, 0.5];
    let positions = [[1.0, 0.0, 0.0], [-0.5, 0.8, 0.0], [0.0, 0.1, 0.05]];
    let at = [[0.0; 3]];

    let wanted = Wanted { laplacian: true, hessian: true, ..Wanted::default() };
    let plan = field::plan(&blob, masses.len(), at.len(), wanted, &Options::default())?;
    let (mut density, mut hessian) = ([0.0], [[[0.0; 3]; 3]]);
    let bytes = plan.workspace_bytes(1)?;
    let mut memory = vec![0; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);
    let workspace = &mut memory[start..start + bytes];
    let outputs = Outputs { laplacian: Some(&mut density), hessian: Some(&mut hessian), ..Outputs::default() };
    let sources = Sources::new(&positions, &masses);
    field::evaluate(&plan, &blob, sources, &at, outputs, workspace, &mut Run::default())?;

    // The sum of the matrices of single masses; the trace is the density, here that of the third mass, the only one within 0.25.
    let single = |(mass, x): (&f64, &[f64; 3])| blob.hessian_matrix(&-Vector3::from(*x)) * *mass;
    let twin: Matrix3<f64> = masses.iter().zip(&positions).map(single).sum();
    let matrix = Matrix3::from(hessian[0]);
    assert!((matrix - twin).norm() < 1e-14 * twin.norm());
    assert!((matrix.trace() - density[0]).abs() < 1e-12 * density[0]);

    let axes = SymmetricEigen::new(matrix);
    for (value, axis) in axes.eigenvalues.iter().zip(axes.eigenvectors.column_iter()) {
        println!("{value:9.5} along ({:7.4}, {:7.4}, {:7.4})", axis[0], axis[1], axis[2]);
    }
    Ok(())
}
