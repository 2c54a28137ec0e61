//! `mollis run` and `mollis plan`: from a scene file to data, pictures and checked numbers.
//!
//! [`simulation`] is the loop that every model runs in; [`blob`], [`pks`], [`cluster`] and [`profile`] are the models;
//! [`history`] is what a run keeps; [`store`] the bytes of a checkpoint; [`measure`] the numbers a scene expects.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mollis_host::pool::Pool;
use mollis_host::{complain, console, say};

use crate::initial::{self, Particles};
use crate::scene::{self, Model, Sampling, Scene, SceneFile};
use crate::{output, plot};

mod blob;
mod cluster;
pub mod history;
mod host;
mod kernel;
pub mod measure;
pub mod pks;
mod plan;
mod profile;
mod simulation;
mod store;

pub use kernel::density as blob_density;
pub use plan::{Args as PlanArgs, main as plan_main};

use history::History;
use simulation::{Ending, Simulation, Watch, drive};
use store::{Reader, Writer};

/// Arguments of `mollis run`.
#[derive(clap::Args)]
pub struct Args {
    /// The scene.
    scene: PathBuf,
    /// Where data and pictures go; otherwise `out/NAME`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Threads, at most 256; 0 takes as many as the machine has. Results don't depend on it.
    #[arg(long, default_value_t = 0, value_parser = |text: &str| mollis_host::command::threads(text, 0))]
    threads: usize,
    /// In place of the scene's own seed.
    #[arg(long)]
    seed: Option<u64>,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
    /// Run the scene's quick size.
    #[arg(long)]
    quick: bool,
    /// Go on from the checkpoint in the output folder; start anew if there is none.
    #[arg(long)]
    resume: bool,
    /// Seconds between checkpoints; `inf` for none but the one that Ctrl-C leaves.
    #[arg(long, default_value = "30", value_parser = interval)]
    checkpoint_every: Duration,
}

/// Reads `--checkpoint-every`. What a `Duration` can't hold is as good as infinite.
fn interval(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 => Ok(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)),
        _ => Err("must be a number of seconds above 0".to_owned()),
    }
}

/// One case of a scene after its run.
pub struct CaseResult<'a> {
    /// The case.
    pub scene: &'a Scene,
    /// Its run; with a study the one on the finest grid.
    pub main: History,
    /// The study, coarse to fine.
    pub study: Vec<StudyPoint>,
}

/// One run of a study.
#[derive(Clone, Debug)]
pub struct StudyPoint {
    /// Spacing.
    pub h: f64,
    /// Particles.
    pub particles: usize,
    /// L1 errors of positions and densities at the end; NaN where there is none.
    pub errors: [f64; 2],
}

/// What a run of a case is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    Whole,
    Study(f64),
    Reference(f64),
}

struct Job<'a> {
    scene: &'a Scene,
    role: Role,
}

impl Job<'_> {
    /// The spacing of its grid.
    fn h(&self) -> Option<f64> {
        match (self.role, self.scene.sampling) {
            (Role::Study(h) | Role::Reference(h), _) | (Role::Whole, Some(Sampling::Grid { h })) => Some(h),
            _ => None,
        }
    }

    fn label(&self) -> String {
        let h = match self.role {
            Role::Whole => String::new(),
            Role::Study(h) => format!("h = {h:.4}"),
            Role::Reference(h) => format!("reference, h = {h:.4}"),
        };
        [self.scene.name.as_str(), &h].iter().filter(|text| !text.is_empty()).copied().collect::<Vec<_>>().join(", ")
    }
}

fn jobs(file: &SceneFile) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for scene in &file.cases {
        match &scene.study {
            None => jobs.push(Job { scene, role: Role::Whole }),
            Some(study) => {
                jobs.extend(study.reference.map(|h| Job { scene, role: Role::Reference(h) }));
                jobs.extend(study.h.iter().map(|&h| Job { scene, role: Role::Study(h) }));
            }
        }
    }
    jobs
}

/// Runs `mollis run`.
pub fn main(args: Args) -> Result<ExitCode> {
    let wall = Instant::now();
    let mut file = scene::load(&args.scene, args.quick)?;
    if let Some(seed) = args.seed {
        file.cases.iter_mut().for_each(|case| case.seed = seed);
    }
    let stem = args.scene.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let out = args.out.clone().unwrap_or_else(|| Path::new("out").join(&stem));
    let folder = |scene: &Scene| if file.cases.len() == 1 { out.clone() } else { out.join(&scene.folder) };
    prepare(&out, &file, &folder)?;
    let pool = Pool::new(args.threads).context("--threads")?;
    host::listen()?;

    let jobs = jobs(&file);
    let runner = Runner {
        folder: args.scene.parent().unwrap_or(Path::new("")),
        checkpoint: out.join(scene::CHECKPOINT),
        key: store::checksum(format!("{} {} {:?}", file.text, args.quick, args.seed).as_bytes()),
        pool: &pool,
        interval: args.checkpoint_every,
    };
    runner.check(&jobs)?;
    let bar = bar(&jobs, args.quiet);
    let Some(histories) = runner.all(&jobs, args.resume, &bar)? else {
        bar.abandon();
        complain!("mollis: stopped; go on with: mollis run {} --out {} --resume", args.scene.display(), out.display());
        return Ok(ExitCode::from(130));
    };
    bar.finish_and_clear();

    let results = gather(&file, &jobs, histories)?;
    let clock = Instant::now();
    let mut failed: Vec<String> = results
        .iter()
        .filter_map(|result| data(result, &folder(result.scene)).err().map(|error| format!("{error:#}")))
        .collect();
    let data_seconds = clock.elapsed().as_secs_f64();
    let checks: Vec<measure::Check> =
        file.expectations.iter().map(|expectation| measure::check(expectation, &results)).collect();
    let write_summary = |pictures: &[Option<String>], picture_seconds: f64| {
        let whole = wall.elapsed().as_secs_f64();
        let seconds = [("data", data_seconds), ("pictures", picture_seconds), ("whole", whole)];
        summary(&out, &args, &file, &results, &checks, pictures, &seconds)
    };
    // Before the pictures too: whatever becomes of them, the numbers are kept.
    let early = write_summary(&[], 0.0);
    let clock = Instant::now();
    let pictures: Vec<Option<String>> = file
        .pictures
        .iter()
        .map(|picture| {
            let drawn =
                plot::picture(picture, &results, &pool).and_then(|canvas| canvas.write(&out.join(&picture.name)));
            drawn.err().map(|error| format!("{error:#}"))
        })
        .collect();
    let late = early.and_then(|()| write_summary(&pictures, clock.elapsed().as_secs_f64()));
    failed.extend(late.err().map(|error| format!("{error:#}")));
    // Data that could not be written can be after `--resume`.
    if failed.is_empty() && runner.checkpoint.exists() {
        std::fs::remove_file(&runner.checkpoint).with_context(|| format!("{}", runner.checkpoint.display()))?;
    }
    // Everything is written by now: a reader that has gone changes nothing about how the run ended.
    let told = if args.quiet { Ok(()) } else { report(&out, &file, &results, &checks) };
    failed.extend(told.err().filter(|error| !console::is_closed(error)).map(|error| format!("{error:#}")));
    let missed: Vec<String> = checks.iter().filter(|check| !check.passed).map(described).collect();
    if !missed.is_empty() {
        failed.push(format!("{} of {} expectations not met:\n{}", missed.len(), checks.len(), missed.join("\n")));
    }
    for (picture, error) in file.pictures.iter().zip(&pictures) {
        failed.extend(error.as_ref().map(|error| format!("picture {:?}: {error}", picture.name)));
    }
    ensure!(failed.is_empty(), "{}", failed.join("\n"));
    Ok(ExitCode::SUCCESS)
}

/// Writes what one case leaves.
fn data(result: &CaseResult<'_>, folder: &Path) -> Result<()> {
    let with_events = result.scene.model == Model::Pks && result.scene.output.events;
    output::history(folder, &result.main, &result.scene.output.particles, with_events)?;
    if !result.study.is_empty() {
        let path = folder.join("convergence.csv");
        output::table(&path, &STUDY_COLUMNS.map(str::to_owned), &study_rows(&result.study))?;
    }
    Ok(())
}

/// Makes the folders that a run writes to and sees that it can: what would fail at the end fails now.
fn prepare(out: &Path, file: &SceneFile, folder: &dyn Fn(&Scene) -> PathBuf) -> Result<()> {
    let mut paths = vec![out.join(scene::SUMMARY), out.join(scene::CHECKPOINT)];
    for picture in &file.pictures {
        paths.extend(["png", "svg"].map(|ending| out.join(&picture.name).with_extension(ending)));
    }
    let mut folders = vec![out.to_owned()];
    for scene in &file.cases {
        let folder = folder(scene);
        paths.extend(output::FILES.map(|name| folder.join(name)));
        folders.push(folder);
    }
    for folder in folders {
        std::fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
        let trial = folder.join("trial");
        output::write(&trial, |_| Ok(()))?;
        std::fs::remove_file(&trial).with_context(|| format!("{}", trial.display()))?;
    }
    for path in &paths {
        ensure!(!path.is_dir(), "{}: is a folder, where a file is to be written", path.display());
    }
    // What an earlier run left must not be taken for this one's.
    let summary = out.join(scene::SUMMARY);
    if summary.exists() {
        std::fs::remove_file(&summary).with_context(|| format!("{}", summary.display()))?;
    }
    Ok(())
}

/// A progress bar over the steps of all runs; hidden unless standard error is a terminal.
fn bar(jobs: &[Job<'_>], quiet: bool) -> ProgressBar {
    let steps: u64 = jobs.iter().filter(|job| job.scene.model != Model::Profile).map(|job| job.scene.steps).sum();
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(5) };
    let bar = ProgressBar::with_draw_target(Some(steps), target);
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent}%  {per_sec} (steps), {eta} left");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

struct Runner<'a> {
    folder: &'a Path,
    checkpoint: PathBuf,
    /// Of the scene's text, its size and the seed: a checkpoint belongs to one scene.
    key: u64,
    pool: &'a Pool,
    interval: Duration,
}

impl Runner<'_> {
    /// Makes every job's particles and simulation once, where there are several: none is refused after another has run. A
    /// single job needs no such check, as it does the same before its first step.
    fn check(&self, jobs: &[Job<'_>]) -> Result<()> {
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
    fn all(&self, jobs: &[Job<'_>], resume: bool, bar: &ProgressBar) -> Result<Option<Vec<History>>> {
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

/// Makes a job's simulation and passes it on.
fn build<R>(
    job: &Job<'_>,
    start: Particles,
    pool: &Pool,
    then: impl FnOnce(&mut dyn Simulation) -> Result<R>,
) -> Result<R> {
    match (job.scene.model, job.scene.dimension) {
        (Model::Blob | Model::Particle, 1) => flow::<1, R>(job, start, pool, then),
        (Model::Blob | Model::Particle, 2) => flow::<2, R>(job, start, pool, then),
        (Model::Blob | Model::Particle, _) => flow::<3, R>(job, start, pool, then),
        (Model::Pks, _) => then(&mut pks::Coalescing::new(job.scene, start, pool)?),
        (Model::Cluster, _) => then(&mut cluster::Cluster::new(job.scene, &start)?),
        (Model::Profile, _) => bail!("a profile has nothing that moves"),
    }
}

fn flow<const D: usize, R>(
    job: &Job<'_>,
    start: Particles,
    pool: &Pool,
    then: impl FnOnce(&mut dyn Simulation) -> Result<R>,
) -> Result<R> {
    kernel::with::<D, R>(job.scene, job.h(), |kernel| {
        then(&mut blob::Flow::<D>::new(job.scene, start, job.h(), kernel, pool)?)
    })
}

/// Histories by case, with the errors of studies.
fn gather<'a>(file: &'a SceneFile, jobs: &[Job<'_>], histories: Vec<History>) -> Result<Vec<CaseResult<'a>>> {
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

const STUDY_COLUMNS: [&str; 6] =
    ["h", "particles", "error_positions", "rate_positions", "error_density", "rate_density"];

fn study_rows(study: &[StudyPoint]) -> Vec<Vec<f64>> {
    let rate = |i: usize, which: usize| match i.checked_sub(1).and_then(|i| study.get(i)) {
        Some(coarse) => (coarse.errors[which] / study[i].errors[which]).ln() / (coarse.h / study[i].h).ln(),
        None => f64::NAN,
    };
    let row = |(i, point): (usize, &StudyPoint)| {
        vec![point.h, point.particles as f64, point.errors[0], rate(i, 0), point.errors[1], rate(i, 1)]
    };
    study.iter().enumerate().map(row).collect()
}

/// A number as short as it is readable.
fn short(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-2 { format!("{value:.4e}") } else { format!("{value:.5}") }
}

fn described(check: &measure::Check) -> String {
    let expectation = &check.expectation;
    let case = expectation.case.as_ref().map_or(String::new(), |case| format!(" [{case}]"));
    let place = match (expectation.at, expectation.from, expectation.to) {
        (Some(at), _, _) => format!(" at {at}"),
        (None, None, None) => String::new(),
        (None, from, to) => {
            format!(" from {} to {}", from.unwrap_or(0.0), to.map_or("the end".to_owned(), |to| to.to_string()))
        }
    };
    let bounds = match (expectation.least.is_finite(), expectation.most.is_finite()) {
        (true, true) => format!("{} to {}", short(expectation.least), short(expectation.most)),
        (true, false) => format!("at least {}", short(expectation.least)),
        _ => format!("at most {}", short(expectation.most)),
    };
    let verdict = if check.passed { "met" } else { "NOT MET" };
    let value = check.error.clone().unwrap_or_else(|| short(check.value));
    format!("  {}{case}{place}: {value} (expected {bounds}): {verdict}", expectation.quantity)
}

fn report(out: &Path, file: &SceneFile, results: &[CaseResult<'_>], checks: &[measure::Check]) -> Result<()> {
    say!("{}", file.title)?;
    for result in results {
        let name = if result.scene.name.is_empty() { String::new() } else { format!("{}: ", result.scene.name) };
        let steps = result.main.seconds.iter().find(|(phase, _)| phase == "steps").map_or(0.0, |(_, seconds)| *seconds);
        say!("  {name}{} particles, {} steps in {steps:.2} s", result.main.start.len(), result.scene.steps)?;
        for line in &result.main.plan {
            say!("    {line}")?;
        }
        for (row, point) in study_rows(&result.study).iter().zip(&result.study) {
            say!(
                "    h = {:<8.5} {:>7} particles  positions {:.3e} (rate {:.2})  density {:.3e} (rate {:.2})",
                point.h,
                point.particles,
                row[2],
                row[3],
                row[4],
                row[5]
            )?;
        }
    }
    for check in checks {
        say!("{}", described(check))?;
    }
    say!("  written to {}", out.display())
}

fn summary(
    out: &Path,
    args: &Args,
    file: &SceneFile,
    results: &[CaseResult<'_>],
    checks: &[measure::Check],
    pictures: &[Option<String>],
    seconds: &[(&str, f64)],
) -> Result<()> {
    use serde_json::{Map, Value, json};
    // JSON knows no infinity and no NaN: they become null.
    let number = |value: f64| serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number);
    let phases = |list: &[(String, f64)]| -> Map<String, Value> {
        list.iter().map(|(phase, seconds)| (phase.clone(), number(*seconds))).collect()
    };
    let cases: Vec<Value> = results
        .iter()
        .map(|result| {
            let last = result.main.rows.last().map_or(&[][..], Vec::as_slice);
            let diagnostics: Map<String, Value> =
                result.main.columns.iter().zip(last).map(|(name, value)| (name.clone(), number(*value))).collect();
            let study: Vec<Map<String, Value>> = study_rows(&result.study)
                .iter()
                .map(|row| {
                    STUDY_COLUMNS.iter().zip(row).map(|(name, value)| ((*name).to_owned(), number(*value))).collect()
                })
                .collect();
            let (skipped, plan): (Vec<&String>, Vec<&String>) =
                result.main.plan.iter().partition(|line| line.starts_with("skipped: "));
            let h = (result.main.h > 0.0).then_some(result.main.h);
            json!({
                "name": result.scene.name,
                "folder": if results.len() == 1 { "." } else { result.scene.folder.as_str() },
                "model": format!("{:?}", result.scene.model).to_lowercase(),
                "dimension": result.scene.dimension,
                "seed": result.scene.seed,
                "h": h,
                "delta": result.scene.mollifier.map(|softening| number(softening.delta(h))),
                "dt": result.scene.dt,
                "steps": result.scene.steps,
                "particles_at_start": result.main.start.len(),
                "particles_at_end": result.main.end.len(),
                "coalescences": result.main.events.len(),
                "diagnostics_at_end": diagnostics,
                "study": study,
                "plan": plan,
                "skipped": skipped.iter().map(|line| line.trim_start_matches("skipped: ")).collect::<Vec<_>>(),
                "seconds": phases(&result.main.seconds),
            })
        })
        .collect();
    let expectations: Vec<Value> = checks
        .iter()
        .map(|check| {
            let expectation = &check.expectation;
            json!({
                "quantity": expectation.quantity,
                "case": expectation.case,
                "at": expectation.at,
                "from": expectation.from,
                "to": expectation.to,
                "part": expectation.part,
                "expected": expectation.value,
                "least": number(expectation.least),
                "most": number(expectation.most),
                "paper": expectation.paper,
                "reason": expectation.reason,
                "value": number(check.value),
                "error": check.error,
                "passed": check.passed,
            })
        })
        .collect();
    let drawn: Vec<Value> = file
        .pictures
        .iter()
        .zip(pictures)
        .map(|(picture, error)| json!({"name": picture.name, "title": picture.title, "error": error}))
        .collect();
    let whole: Map<String, Value> =
        seconds.iter().map(|(phase, seconds)| ((*phase).to_owned(), number(*seconds))).collect();
    let summary = json!({
        "title": file.title,
        "source": file.source,
        "note": file.note,
        "scene": args.scene.display().to_string(),
        "quick": args.quick,
        "version": env!("CARGO_PKG_VERSION"),
        "level": format!("{:?}", mollis_core::simd::Level::best()),
        "threads": args.threads,
        "cases": cases,
        "expectations": expectations,
        "pictures": drawn,
        "seconds": whole,
    });
    output::write(&out.join(scene::SUMMARY), |file| Ok(serde_json::to_writer_pretty(file, &summary)?))
}
