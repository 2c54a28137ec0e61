//! What a mesh makes of a heavy particle, and what is left when its pairs are summed beside the mesh.

use std::f64::consts::PI;

use mollis_core::grid::{Equation, Mesh, Order};
use mollis_core::pks::{Merging, Options};
use mollis_core::random::Philox;
use mollis_host::say;

use super::slope;
use super::system::{Bump, Split, System};

/// How the attraction is found.
#[derive(Clone, Copy, Debug)]
enum Way {
    Mesh(Order),
    Pairs,
}

const WAYS: [Way; 3] = [Way::Mesh(Order::Second), Way::Mesh(Order::Fourth), Way::Pairs];

/// Distances in mesh widths.
const DISTANCES: [f64; 9] = [0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0];

/// Both tables; whether the pairs' errors are small everywhere.
pub fn run() -> anyhow::Result<bool> {
    let passed = field()?;
    Ok(meeting()? && passed)
}

fn system(way: Way, mesh: Mesh<f64>, particles: &[([f64; 2], f64)]) -> anyhow::Result<System> {
    let order = if let Way::Mesh(order) = way { order } else { Order::Second };
    // Attraction alone.
    let options = Options { merging: Merging::Never, ..Options::new(1.0, 0.0) };
    let bump = Bump { centre: [0.0; 2], axes: [1.0; 2], mass: 1.0, count: particles.len() };
    let mut system = System::new(&[bump], Some((mesh, Equation { order, ..Equation::POISSON })), options, 1, 1)?;
    (system.positions, system.masses) = particles.iter().copied().unzip();
    if let Way::Pairs = way {
        system.sum_heavy(0.1)?;
    }
    Ok(system)
}

/// The attraction by one particle of mass 1, at 40 places in its cell, of 24 light ones at each distance.
fn field() -> anyhow::Result<bool> {
    let mesh = Mesh::new([-1.0; 2], [1.0; 2], [64; 2])?;
    let [h, _] = mesh.spacing();
    say!("root mean square error of a light particle's speed, relative, over the distance in mesh widths (64 x 64)")?;
    let header: String = DISTANCES.iter().map(|r| format!("{r:9}")).collect();
    say!("{:14}{header}", "")?;
    let mut passed = true;
    for way in WAYS {
        let mut squares = [0.0_f64; DISTANCES.len()];
        let mut random = Split(1);
        for _ in 0..40 {
            let at = [random.uniform(), random.uniform()].map(|v| h * v);
            let mut particles = vec![(at, 1.0)];
            for r in DISTANCES {
                for _ in 0..24 {
                    let (sin, cos) = (2.0 * PI * random.uniform()).sin_cos();
                    particles.push(([at[0] + r * h * cos, at[1] + r * h * sin], 1e-12));
                }
            }
            let mut system = system(way, mesh, &particles)?;
            // So short that it is the field at the start.
            let dt = 1e-9;
            system.step(&mut Philox::new(1), dt)?;
            for (k, (&(x, _), y)) in particles.iter().zip(&system.positions).enumerate().skip(1) {
                let d = [x[0] - at[0], x[1] - at[1]];
                let factor = -dt / (2.0 * PI * (d[0] * d[0] + d[1] * d[1]));
                let miss = (y[0] - x[0] - factor * d[0]).hypot(y[1] - x[1] - factor * d[1]);
                squares[(k - 1) / 24] += (miss / (factor * d[0].hypot(d[1]))).powi(2);
            }
        }
        let errors = squares.map(|sum| (sum / (40.0 * 24.0)).sqrt());
        let row: String = errors.iter().map(|e| format!("{e:9.1e}")).collect();
        say!("{:14}{row}", format!("{way:?}"))?;
        if let Way::Pairs = way {
            passed &= errors.iter().all(|&e| e < 1e-5);
        }
    }
    Ok(passed)
}

/// Two particles with the masses of Section 5.2.2, six apart in four directions, until they are 0.6 apart: the slope of the second moment.
fn meeting() -> anyhow::Result<bool> {
    let mass = 64.0 * PI;
    say!(
        "slope of the second moment of two heavy particles, theory -13.44; 270 x 270 on [-15, 15]^2, four directions"
    )?;
    let mut passed = true;
    for dt in [2e-3, 5e-4] {
        for way in WAYS {
            let mut slopes = Vec::new();
            for direction in 0..4 {
                let (sin, cos) = (0.1 + 0.2 * f64::from(direction)).sin_cos();
                let mesh = Mesh::new([-15.0; 2], [15.0; 2], [270; 2])?;
                let particles = [([4.2 * cos, 4.2 * sin], 0.3 * mass), ([-1.8 * cos, -1.8 * sin], 0.7 * mass)];
                let mut system = system(way, mesh, &particles)?;
                let mut line = Vec::new();
                while system.second_moment() > 0.21 * 0.36 {
                    line.push((system.counters.time, system.second_moment()));
                    system.step(&mut Philox::new(1), dt)?;
                }
                slopes.push(slope(&line));
            }
            let (least, most) =
                slopes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &s| (a.min(s), b.max(s)));
            say!("dt {dt}, {way:?}: {least:.4} to {most:.4}")?;
            if let Way::Pairs = way {
                passed &= (least + 13.44).abs().max((most + 13.44).abs()) < 5e-3;
            }
        }
    }
    Ok(passed)
}
