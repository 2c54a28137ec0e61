//! `cargo xtask evidence pks-check NAME`: the numerical experiments of Zhelezov & Fatkullin, Section 5, and the laws behind them, with numbers
//! to compare. Exit status 1 if a number misses.

mod experiments;
mod heavy;
mod hitting;
mod soft;
mod system;

use std::process::ExitCode;

use clap::{Args as Arguments, ValueEnum};
use mollis_core::grid::{Equation, Order, Walls};
use mollis_core::pks::theory;
use mollis_host::say;

/// Which experiment.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    /// Collision times of two particles against the exact law; the printed test beside it.
    Hitting,
    /// Section 5.2.1: slopes of the second moment before and after a collapse.
    Transfer,
    /// Section 5.2.2: two collapsed bumps.
    Singularities,
    /// Section 5.3: two species, one expands, one contracts.
    Species,
    /// A subcritical mass spreads and forms no heavy particle.
    Subcritical,
    /// Ten thousand steps past blow-up, chi up to 1e6, dt from 1e-8 to 1.
    Stress,
    /// Time of a step.
    Speed,
    /// The mesh's field round a heavy particle, and two heavy ones that meet, with and without their pairs summed beside the mesh.
    Heavy,
    /// Five particles whose pairs collide and do not merge: the time at which all five do, against the exact law.
    Soft,
}

/// Arguments of `cargo xtask evidence pks-check`.
#[derive(Arguments, Clone, Debug)]
pub struct Args {
    /// The experiment.
    name: Name,
    /// Seeds (runs); the experiment's own number if 0.
    #[arg(long, default_value_t = 0)]
    seeds: u64,
    /// The first seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Particles (for `hitting`: pairs, for `soft`: paths); the experiment's own number if 0.
    #[arg(long, default_value_t = 0)]
    particles: usize,
    /// Threads, at most 256.
    #[arg(long, default_value_t = 1, value_parser = |text: &str| mollis_host::command::threads(text, 1))]
    threads: usize,
    /// Decide collisions by the printed increment test.
    #[arg(long)]
    printed: bool,
    /// Merge only what must collide (nu <= -1).
    #[arg(long)]
    hard: bool,
    /// `hitting`: the shortest step, in units of Y_0 / beta^2 times 4; the experiment's own if 0. The printed law is then left out.
    #[arg(long, default_value_t = 0.0)]
    shortest: f64,
    /// `species`: the border's field is that of all mass at its centre (the paper's), without second moments.
    #[arg(long)]
    monopole: bool,
    /// The mesh's scheme is of fourth order, not the paper's of second.
    #[arg(long)]
    fourth: bool,
    /// `transfer`, `singularities`, `stress`: particles of at least this mass act pair by pair, not through the mesh; in units of 8 pi mu / chi.
    #[arg(long)]
    heavy: Option<f64>,
    /// `species`: steps; the experiment's own number if 0.
    #[arg(long, default_value_t = 0)]
    steps: u32,
    /// `singularities`, `soft`: the step; the experiment's own if 0.
    #[arg(long, default_value_t = 0.0)]
    dt: f64,
    /// Decimals of progress while it runs.
    #[arg(long)]
    verbose: bool,
}

/// Runs the experiment.
pub fn main(args: Args) -> anyhow::Result<ExitCode> {
    let passed = match args.name {
        Name::Hitting => hitting::run(&args)?,
        Name::Transfer => experiments::transfer(&args)?,
        Name::Singularities => experiments::singularities(&args)?,
        Name::Species => experiments::species(&args)?,
        Name::Subcritical => experiments::subcritical(&args)?,
        Name::Stress => experiments::stress(&args)?,
        Name::Speed => experiments::speed(&args)?,
        Name::Heavy => heavy::run()?,
        Name::Soft => soft::run(&args)?,
    };
    say!("{}", if passed { "PASS" } else { "FAIL" })?;
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Args {
    /// The mesh's field within these walls.
    fn equation(&self, walls: Walls) -> Equation<f64> {
        let order = if self.fourth { Order::Fourth } else { Order::Second };
        Equation { walls, order, ..Equation::POISSON }
    }

    /// The option's particles act pair by pair.
    fn sum_heavy(&self, system: &mut system::System) -> anyhow::Result<()> {
        if let Some(mass) = self.heavy {
            system.sum_heavy(mass * theory::critical_mass(1.0, system.options.chi))?;
        }
        Ok(())
    }

    fn walls(&self) -> Walls {
        if self.monopole { Walls::Free } else { Walls::FreeQuadrupole }
    }

    fn seeds(&self, default: u64) -> std::ops::Range<u64> {
        let n = if self.seeds == 0 { default } else { self.seeds };
        self.first..self.first.saturating_add(n)
    }

    fn particles(&self, default: usize) -> usize {
        if self.particles == 0 { default } else { self.particles }
    }
}

/// Mean, and half the width of the 95% confidence interval (Student).
fn interval(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0);
    // 97.5% points of Student's law for 1, 2, ... degrees of freedom.
    const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    let t = STUDENT.get(values.len().saturating_sub(2)).copied().unwrap_or(1.96);
    (mean, if values.len() < 2 { f64::NAN } else { t * (variance / n).sqrt() })
}

/// The slope of the least-squares line through (t, y).
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (t, y) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + p.0 / n, b + p.1 / n));
    let (top, bottom) =
        points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p.0 - t) * (p.1 - y), b + (p.0 - t) * (p.0 - t)));
    top / bottom
}
