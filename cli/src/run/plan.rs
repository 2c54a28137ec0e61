//! `mollis plan`: what would run and what it would cost, without running it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use std::time::Instant;

use anyhow::Result;
use mollis_core::parallel::Executor;

use super::host::Pool;
use super::{build, jobs};
use crate::initial::{self, Particles};
use crate::scene::{self, Model};

/// Arguments of `mollis plan`.
#[derive(clap::Args)]
pub struct Args {
    /// The scene.
    scene: PathBuf,
    /// Threads that the run would have; 0 takes as many as the machine has.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// The scene's quick size.
    #[arg(long)]
    quick: bool,
}

/// Runs `mollis plan`.
pub fn main(args: Args) -> Result<ExitCode> {
    let file = scene::load(&args.scene, args.quick)?;
    let pool = Pool::new(args.threads)?;
    println!("{}", file.title);
    let mut whole = 0.0;
    for job in jobs(&file) {
        let scene = job.scene;
        let label = if job.label().is_empty() { "run".to_owned() } else { job.label() };
        if scene.model == Model::Profile {
            println!("{label}: curves of a mollifier; nothing moves");
            continue;
        }
        let start = initial::particles(scene, job.h(), args.scene.parent().unwrap_or(Path::new("")))?;
        println!(
            "{label}: {:?}, {} particles in {}D, {} steps of {}",
            scene.model,
            start.len(),
            scene.dimension,
            scene.steps,
            scene.dt
        );
        let n = start.len();
        let direct = build(&job, start.clone(), &pool, |simulation| {
            let lines = simulation.plan();
            lines.iter().for_each(|line| println!("  {line}"));
            Ok(lines.iter().any(|line| line.starts_with("velocity: Direct")))
        })?;
        // The cost of a step is estimated from one of a few particles of the same data, which nothing keeps.
        let few = thinned(&start, 2000);
        let m = few.len();
        let clock = build(&job, few, &pool, |simulation| {
            let clock = Instant::now();
            simulation.step()?;
            Ok(clock.elapsed().as_secs_f64())
        })?;
        let ratio = n as f64 / m as f64;
        let each = clock * if direct { ratio * ratio } else { ratio };
        println!(
            "  cost: about {each:.1e} s a step (from one of {m} particles), {:.1} s in all",
            each * scene.steps as f64
        );
        whole += each * scene.steps as f64;
    }
    println!("about {whole:.1} s on {} thread(s), pictures and tables not counted", pool.workers());
    for picture in &file.pictures {
        println!("picture {}: {}", picture.name, picture.kind);
    }
    println!("{} expectation(s) would be checked", file.expectations.len());
    Ok(ExitCode::SUCCESS)
}

/// At most `wanted` of the particles, evenly spaced, with all of the mass.
fn thinned(all: &Particles, wanted: usize) -> Particles {
    let d = all.dimension;
    let stride = all.len().div_ceil(wanted).max(1);
    let mut few = Particles { dimension: d, ..Particles::default() };
    for index in (0..all.len()).step_by(stride) {
        few.positions.extend_from_slice(&all.positions[index * d..(index + 1) * d]);
        few.masses.push(all.masses[index] * stride as f64);
        few.densities.push(all.densities[index]);
        few.parts.push(all.parts[index]);
    }
    few
}
