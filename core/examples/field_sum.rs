//! The potential and its gradient of 1000 masses in the plane, softened over 0.05, at the masses themselves.
//!
//!     cargo run --release -p mollis-core --example field_sum
#![allow(clippy::disallowed_methods, reason = "a program with std")]

use mollis_core::Result;
use mollis_core::exec::Run;
use mollis_core::field::{self, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;

fn main() -> Result<()> {
    // Points of a low-discrepancy sequence in the unit square, of total mass 1.
    let n = 1000;
    let x: Vec<[f64; 2]> =
        (1..=n).map(|k| [0.754_877_666, 0.569_840_291].map(|a| (a * f64::from(k)).fract())).collect();
    let mass = vec![1.0 / f64::from(n); x.len()];

    // K = log|x| / (2 pi), of which the mollifier makes a smooth function within 0.05; v = -grad u attracts.
    let kernel = Kernel::<f64, 2>::newtonian(1.0, Mollifier::Compact { order: 2, exponent: 4 }, 0.05)?;

    // The plan says how much memory the sum needs; the memory is ours.
    let wanted = Wanted { potential: true, gradient: true, ..Wanted::default() };
    let plan = field::plan(&kernel, x.len(), x.len(), wanted, &Options::default())?;
    println!("{plan}");
    let bytes = plan.workspace_bytes(1)?;
    let mut memory = vec![0; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);
    let workspace = &mut memory[start..start + bytes];

    let (mut u, mut gradient) = (vec![0.0; x.len()], vec![[0.0; 2]; x.len()]);
    let outputs = Outputs { potential: Some(&mut u), gradient: Some(&mut gradient), ..Outputs::default() };
    let sources = Sources::new(&x, &mass);
    field::evaluate(&plan, &kernel, sources, &x, outputs, workspace, &mut Run::default())?;

    let energy: f64 = mass.iter().zip(&u).map(|(m, u)| 0.5 * m * u).sum();
    let force: [f64; 2] = [0, 1].map(|k| mass.iter().zip(&gradient).map(|(m, g)| m * g[k]).sum());
    println!("energy {energy:.12}, sum of forces {:.1e} {:.1e} (zero but for rounding)", force[0], force[1]);
    Ok(())
}
