//! `mollis plan`: what would run and what it would cost, without running it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result};
use mollis_core::exec::Executor;
use mollis_host::pool::Pool;
use mollis_host::say;

use super::job::{build, jobs};
use crate::initial;
use crate::particles::Particles;
use crate::scene::{self, Model, Sampling};

/// More particles than this are not sampled for a plan.
const SAMPLED: f64 = 1e6;

/// Particles of the steps that the cost is estimated from.
const FEW: usize = 2000;
/// See [`FEW`].
const MORE: usize = 50_000;

/// Arguments of `mollis plan`.
#[derive(clap::Args)]
pub struct Args {
    /// The scene.
    scene: PathBuf,
    /// Threads that the run would have, at most 256; 0 takes as many as the machine has.
    #[arg(long, default_value_t = 0, value_parser = |text: &str| mollis_host::command::threads(text, 0))]
    threads: usize,
    /// The scene's quick size.
    #[arg(long)]
    quick: bool,
}

/// Runs `mollis plan`.
pub fn main(args: Args) -> Result<ExitCode> {
    let file = scene::load(&args.scene, args.quick)?;
    let pool = Pool::new(args.threads).context("--threads")?;
    say!("{}", file.title)?;
    let mut whole = 0.0;
    for job in jobs(&file) {
        let scene = job.scene;
        let label = if job.label().is_empty() { "run".to_owned() } else { job.label() };
        if scene.model == Model::Profile {
            say!("{label}: curves of a mollifier; nothing moves")?;
            continue;
        }
        let folder = args.scene.parent().unwrap_or(Path::new(""));
        // So many are not sampled to be counted: a few of them stand for all.
        let about = initial::about(scene, job.h());
        let sampled = about <= SAMPLED;
        let share = if sampled { 1.0 } else { MORE as f64 / about };
        let initial::Start { particles: start, notes } = initial::sparse(scene, job.h(), folder, share)?;
        let is_given = |part: &&u8| !scene.initial[**part as usize].shape.is_sampled();
        let n = if sampled { start.len() } else { about as usize + start.parts.iter().filter(is_given).count() };
        let exact = sampled || matches!(scene.sampling, Some(Sampling::Random { .. }));
        let count = if exact { n.to_string() } else { format!("about {:.2e}", n as f64) };
        say!(
            "{label}: {:?}, {count} particles in {}D, {} steps of {}",
            scene.model,
            scene.dimension,
            scene.steps,
            scene.dt
        )?;
        for note in notes.iter().filter(|_| sampled) {
            say!("  {note}")?;
        }
        let direct = build(&job, start.clone(), &pool, |simulation| {
            let lines = simulation.plan(n)?;
            for line in &lines {
                say!("  {line}")?;
            }
            Ok(lines.iter().any(|line| line.starts_with("velocity: Direct")))
        })?;
        // The cost is estimated from steps of a few particles of the same data, which are not kept.
        let measured = |wanted: usize| -> Result<(f64, f64)> {
            let few = thinned(&start, wanted);
            let m = few.len() as f64;
            let seconds = build(&job, few, &pool, |simulation| {
                let clock = Instant::now();
                simulation.step()?;
                Ok(clock.elapsed().as_secs_f64())
            })?;
            Ok((m, seconds))
        };
        let estimate = || -> Result<f64> {
            let (m, seconds) = measured(FEW)?;
            if direct {
                return Ok(seconds * (n as f64 / m).powi(2));
            }
            // What a step costs whatever the number of particles, such as a mesh, and what each particle adds.
            let (more, longer) = measured(MORE)?;
            let slope = if more > m { (longer - seconds).max(0.0) / (more - m) } else { seconds / m };
            Ok(seconds + slope * (n as f64 - m))
        };
        let each = match estimate() {
            Ok(each) => each,
            // Fewer particles are heavier ones: their step may be refused where that of all is not.
            Err(error) => {
                say!("  cost: not estimated: with fewer particles, {error:#}")?;
                continue;
            }
        };
        say!(
            "  cost: about {each:.1e} s a step (from steps of fewer particles), {:.1} s in all",
            each * scene.steps as f64
        )?;
        whole += each * scene.steps as f64;
    }
    say!("about {whole:.1} s on {} thread(s), pictures and tables not counted", pool.workers())?;
    for picture in &file.pictures {
        say!("picture {}: {}", picture.name, picture.kind)?;
    }
    say!("{} expectation(s) would be checked", file.expectations.len())?;
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
