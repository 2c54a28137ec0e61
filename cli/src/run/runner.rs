//! Runs the jobs of a scene one after another, from a checkpoint on where there is one.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mollis_host::pool::Pool;

use super::job::{Job, Role, build};
use crate::checkpoint::{Reader, Writer};
use crate::history::History;
use crate::initial;
use crate::measure;
use crate::model::{Ending, Simulation, Watch, drive, profile};
use crate::particles::Particles;
use crate::results::{CaseResult, StudyPoint};
use crate::scene::{Model, SceneFile};

/// A progress bar over the steps of all runs; hidden unless standard error is a terminal.
pub fn bar(jobs: &[Job<'_>], quiet: bool) -> ProgressBar {
    let steps: u64 = jobs.iter().filter(|job| job.scene.model != Model::Profile).map(|job| job.scene.steps).sum();
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(5) };
    let bar = ProgressBar::with_draw_target(Some(steps), target);
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent}%  {per_sec} (steps), {eta} left");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Runs jobs, and writes and reads their checkpoint.
pub struct Runner<'a> {
    /// Where the scene is.
    pub folder: &'a Path,
    /// The checkpoint's file.
    pub checkpoint: PathBuf,
    /// Of the scene's text, its size and the seed: a checkpoint belongs to one scene.
    pub key: u64,
    /// Threads.
    pub pool: &'a Pool,
    /// Between checkpoints.
    pub interval: Duration,
}

impl Runner<'_> {
    /// Makes every job's particles and simulation once, where there are several: none is refused after another has run. A
    /// single job needs no such check, as it does the same before its first step.
    pub fn check(&self, jobs: &[Job<'_>]) -> Result<()> {
        let moving: Vec<&Job<'_>> = jobs.iter().filter(|job| job.scene.model != Model::Profile).collect();
        let mut reference = None;
        for job in moving.iter().filter(|_| moving.len() > 1) {
            let attempt = || -> Result<Particles> {
                let start = initial::particles(job.scene, job.h(), self.folder)?.particles;
                build(job, start.clone(), self.pool, |_| Ok(()))?;
                Ok(start)
            };
            let start = attempt().with_context(|| job.label())?;
            match job.role {
                Role::Reference(h) => reference = Some((start, h)),
                Role::Study(h) => {
                    // The reference of this study comes before its first run.
                    if let (Some((finer, finest)), true) =
                        (&reference, job.scene.study.as_ref().is_some_and(|study| study.reference.is_some()))
                    {
                        measure::matches(&start, finer, *finest).with_context(|| format!("h = {h}"))?;
                    }
                }
                Role::Whole => {}
            }
        }
        Ok(())
    }

    /// Runs all jobs; `None` if the host stopped them.
    pub fn all(&self, jobs: &[Job<'_>], resume: bool, bar: &ProgressBar) -> Result<Option<Vec<History>>> {
        let mut finished = Vec::new();
        let mut current = None;
        if resume && self.checkpoint.exists() {
            let mut reader = Reader::open(&self.checkpoint)?;
            ensure!(
                reader.count()? == self.key,
                "{}: is of another scene, size or seed; remove it or run without --resume",
                self.checkpoint.display()
            );
            for _ in 0..reader.count()? {
                finished.push(History::restore(&mut reader)?);
            }
            let step = reader.count()?;
            current = Some((step, History::restore(&mut reader)?, reader));
            bar.inc(jobs.iter().take(finished.len()).map(|job| job.scene.steps).sum::<u64>() + step);
            bar.reset_eta();
        }
        let mut last = Instant::now();
        for job in jobs.iter().skip(finished.len()) {
            bar.set_message(job.label());
            let mut watch = Watch { bar, interval: self.interval, last };
            let (history, ending) = self.one(job, current.take(), &finished, &mut watch)?;
            last = watch.last;
            if ending == Ending::Stopped {
                return Ok(None);
            }
            finished.push(history);
        }
        Ok(Some(finished))
    }

    fn one(
        &self,
        job: &Job<'_>,
        current: Option<(u64, History, Reader)>,
        finished: &[History],
        watch: &mut Watch<'_>,
    ) -> Result<(History, Ending)> {
        let scene = job.scene;
        if scene.model == Model::Profile {
            return Ok((profile::curves(scene)?, Ending::Done));
        }
        let clock = Instant::now();
        let initial::Start { particles: start, notes } = initial::particles(scene, job.h(), self.folder)?;
        let (from, mut history, reader) = match current {
            Some((step, history, reader)) => (step, history, Some(reader)),
            None => {
                let h = job.h().unwrap_or(0.0);
                (0, History { h, start: start.clone(), plan: notes, ..History::default() }, None)
            }
        };
        history.spent("initial data", clock.elapsed().as_secs_f64());
        let mut save = |step: u64, simulation: &dyn Simulation, history: &History| {
            let mut writer = Writer::default();
            writer.count(self.key);
            writer.count(finished.len() as u64);
            finished.iter().for_each(|history| history.save(&mut writer));
            writer.count(step);
            history.save(&mut writer);
            simulation.save(&mut writer);
            writer.write(&self.checkpoint)
        };
        let ending = build(job, start, self.pool, |simulation| {
            if let Some(mut reader) = reader {
                simulation.restore(&mut reader)?;
            }
            drive(simulation, scene, &mut history, from, watch, &mut save)
        })?;
        Ok((history, ending))
    }
}

/// Histories by case, with the errors of studies.
pub fn gather<'a>(file: &'a SceneFile, jobs: &[Job<'_>], histories: Vec<History>) -> Result<Vec<CaseResult<'a>>> {
    let mut all = jobs.iter().zip(histories).peekable();
    let mut results = Vec::new();
    for scene in &file.cases {
        let mut reference = None;
        let mut study = Vec::new();
        let mut main = None;
        while let Some((job, history)) = all.next_if(|(job, _)| std::ptr::eq(job.scene, scene)) {
            if let Role::Reference(_) = job.role {
                reference = Some(history);
                continue;
            }
            if let Role::Study(h) = job.role {
                let errors = match &reference {
                    Some(reference) => measure::errors_against(&history, reference, h.powi(scene.dimension as i32))?,
                    None => ["error_positions", "error_density"].map(|name| {
                        history.column(name).and_then(|column| column.last().map(|point| point[1])).unwrap_or(f64::NAN)
                    }),
                };
                study.push(StudyPoint { h, particles: history.start.len(), errors });
            }
            main = Some(history);
        }
        results.push(CaseResult { scene, main: main.context("a case without a run")?, study });
    }
    Ok(results)
}
