//! The loop that every model runs in: steps, records, checkpoints, and stopping.

use std::time::{Duration, Instant};

use anyhow::Result;
use indicatif::ProgressBar;

use super::stop;
use crate::checkpoint::{Reader, Writer};
use crate::history::{Event, History, Snapshot};
use crate::particles::Particles;
use crate::scene::Scene;

/// A model that advances in time.
pub trait Simulation {
    /// The names of what [`Simulation::row`] returns.
    fn columns(&self) -> Vec<String>;

    /// One step. Stopped by the host, the state is that of the last completed step.
    fn step(&mut self) -> Result<()>;

    /// Diagnostics of the state; the first is the time.
    fn row(&mut self) -> Result<Vec<f64>>;

    /// The particles.
    fn particles(&self) -> Particles;

    /// Where the followed particles are.
    fn followed(&self) -> Vec<f64>;

    /// The coalescences since the last call.
    fn events(&mut self) -> Vec<Event> {
        Vec::new()
    }

    /// What runs with so many particles, why, and what is skipped; a line each.
    fn plan(&self, particles: usize) -> Result<Vec<String>>;

    /// What a user should know after the run; a line each.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// The state into a checkpoint.
    fn save(&self, writer: &mut Writer);

    /// The state from a checkpoint.
    fn restore(&mut self, reader: &mut Reader) -> Result<()>;
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// At its end.
    Done,
    /// On request; a checkpoint was written.
    Stopped,
}

/// When checkpoints are due, and the bar.
pub struct Watch<'a> {
    /// Drawn on a terminal only.
    pub bar: &'a ProgressBar,
    /// Between checkpoints.
    pub interval: Duration,
    /// When the last was written.
    pub last: Instant,
}

/// Runs from step `from` to the scene's end. `save` writes a checkpoint of the whole scene run, given this run's part.
pub fn drive(
    simulation: &mut dyn Simulation,
    scene: &Scene,
    history: &mut History,
    from: u64,
    watch: &mut Watch<'_>,
    save: &mut dyn FnMut(u64, &dyn Simulation, &History) -> Result<()>,
) -> Result<Ending> {
    if from == 0 && history.rows.is_empty() {
        history.columns = simulation.columns();
        history.plan.extend(simulation.plan(history.start.len())?);
        history.followed = simulation.followed();
        record(simulation, scene, history, 0)?;
    }
    let mut step = from;
    while step < scene.steps {
        if stop::stopped() {
            save(step, simulation, history)?;
            return Ok(Ending::Stopped);
        }
        let clock = Instant::now();
        match simulation.step() {
            Ok(()) => {}
            Err(error) if stop::stopped() && stopped_by_host(&error) => continue,
            Err(error) => return Err(error.context(format!("at time {}", step as f64 * scene.dt))),
        }
        history.spent("steps", clock.elapsed().as_secs_f64());
        step += 1;
        record(simulation, scene, history, step)?;
        watch.bar.inc(1);
        if watch.last.elapsed() >= watch.interval {
            let clock = Instant::now();
            save(step, simulation, history)?;
            watch.last = Instant::now();
            history.spent("checkpoints", clock.elapsed().as_secs_f64());
        }
    }
    history.end = simulation.particles();
    history.plan.extend(simulation.notes());
    // Within a step events come cluster by cluster.
    history.events.sort_by(|a, b| a.time.total_cmp(&b.time));
    history.done = true;
    Ok(Ending::Done)
}

fn stopped_by_host(error: &anyhow::Error) -> bool {
    error.downcast_ref::<mollis_core::Error>() == Some(&mollis_core::Error::Stopped)
}

/// What is due at this step.
fn record(simulation: &mut dyn Simulation, scene: &Scene, history: &mut History, step: u64) -> Result<()> {
    let clock = Instant::now();
    history.events.extend(simulation.events());
    if step.is_multiple_of(scene.output.every) || step == scene.steps {
        let row = simulation.row()?;
        if scene.output.trajectories > 0 {
            history.paths.push((row[0], simulation.followed()));
        }
        history.rows.push(row);
    }
    if scene.output.snapshots.contains(&step) {
        history.snapshots.push(Snapshot { time: step as f64 * scene.dt, particles: simulation.particles() });
    }
    history.spent("diagnostics", clock.elapsed().as_secs_f64());
    Ok(())
}

/// Which of `n` particles are followed: `wanted` of them, evenly spaced.
pub fn choose(n: usize, wanted: usize) -> Vec<usize> {
    let wanted = wanted.min(n);
    match wanted {
        0 => Vec::new(),
        1 => vec![n / 2],
        _ => (0..wanted).map(|i| i * (n - 1) / (wanted - 1)).collect(),
    }
}
