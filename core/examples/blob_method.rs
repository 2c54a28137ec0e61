//! The aggregation equation in the plane by the blob method: a disc of uniform density 1/pi under Newtonian attraction shrinks to a point at t = pi.
//!
//!     cargo run --release -p mollis-core --example blob_method
#![allow(clippy::disallowed_methods, reason = "a program with std")]

use mollis_core::Result;
use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::exec::Run;
use mollis_core::field::Options;
use mollis_core::kernel::Kernel;
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;

fn main() -> Result<()> {
    // Particles on the lattice h Z^2 within the unit disc; a mass is the density times h^2.
    let h: f64 = 0.04;
    let density = 1.0 / std::f64::consts::PI;
    let steps = (1.0 / h) as i32;
    let lattice = (-steps..=steps).flat_map(|a| (-steps..=steps).map(move |b| [f64::from(a) * h, f64::from(b) * h]));
    let mut x: Vec<[f64; 2]> = lattice.filter(|x| x[0] * x[0] + x[1] * x[1] < 1.0).collect();
    let mass = vec![density * h * h; x.len()];
    let mut rho = vec![density; x.len()];

    // Craig & Bertozzi: delta = 4 h^0.9 with a mollifier of order 4.
    let kernel = Kernel::<f64, 2>::newtonian(1.0, Mollifier::Compact { order: 4, exponent: 6 }, 4.0 * h.powf(0.9))?;
    let wanted = Wanted { density: true, ..Wanted::default() };
    let plan = aggregation::plan(&kernel, x.len(), 0, wanted, &Options::default())?;
    let bytes = plan.workspace_bytes::<f64, 2>(1)?;
    let mut memory = vec![0; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);

    let (dt, count) = (0.05, 20);
    let state = State {
        masses: &mass,
        particles: Trajectories { positions: &mut x, density: Some(&mut rho), ..Trajectories::none() },
        tracers: Trajectories::none(),
    };
    let advance = Advance { dt, steps: count, after_step: None };
    let workspace = &mut memory[start..start + bytes];
    aggregation::step(&plan, &kernel, state, advance, workspace, &mut Run::default(), &mut Report::default())?;

    // rho' = rho^2 along trajectories.
    let t = dt * count as f64;
    let exact = density / (1.0 - density * t);
    let centre = x.iter().position(|x| x[0].abs() + x[1].abs() < 1e-9).unwrap_or(0);
    println!("{} particles at t = {t}: density at the centre {:.6}, exact {exact:.6}", x.len(), rho[centre]);
    Ok(())
}
