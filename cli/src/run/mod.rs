//! `mollis run` and `mollis plan`: from a scene file to data, pictures and checked numbers.
//!
//! [`job`] lists the runs that a scene asks for, [`runner`] runs them, [`summary`] and [`mod@report`] tell of them, in a file and
//! on standard output; [`plan`] only estimates.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use mollis_host::pool::Pool;
use mollis_host::{complain, console};

mod job;
mod plan;
mod report;
mod runner;
mod summary;

pub use plan::{Args as PlanArgs, main as plan_main};

use crate::measure;
use crate::model::stop;
use crate::results::{CaseResult, STUDY_COLUMNS, study_rows};
use crate::scene::{self, Model, Scene, SceneFile};
use crate::{checkpoint, files, output, plot};
use job::jobs;
use report::{described, report};
use runner::{Runner, bar, gather};

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
    stop::listen()?;

    let jobs = jobs(&file);
    let runner = Runner {
        folder: args.scene.parent().unwrap_or(Path::new("")),
        checkpoint: out.join(scene::CHECKPOINT),
        key: checkpoint::checksum(format!("{} {} {:?}", file.text, args.quick, args.seed).as_bytes()),
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
    let tell = |pictures: &[Option<String>], picture_seconds: f64| {
        let whole = wall.elapsed().as_secs_f64();
        let seconds = [("data", data_seconds), ("pictures", picture_seconds), ("whole", whole)];
        summary::write(&out, &args, &file, &results, &checks, pictures, &seconds)
    };
    // Before the pictures too: whatever becomes of them, the numbers are kept.
    let early = tell(&[], 0.0);
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
    let late = early.and_then(|()| tell(&pictures, clock.elapsed().as_secs_f64()));
    failed.extend(late.err().map(|error| format!("{error:#}")));
    // Data that could not be written can be after `--resume`.
    if failed.is_empty() && runner.checkpoint.exists() {
        std::fs::remove_file(&runner.checkpoint).with_context(|| format!("{}", runner.checkpoint.display()))?;
    }
    // All files are written; a closed output pipe does not change the exit status.
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
        files::prepare(&folder)?;
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
