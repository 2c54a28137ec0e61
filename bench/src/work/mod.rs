//! `mollis-bench work`: run time against error, as pictures, numbers and a page that says what to use for how many digits (`cargo xtask bench`).
//!
//! Each module is a study: a question, and curves of settings with the time that each takes and the error that it has. All times are CPU times of one thread; peers are
//! measured in the same run.

mod blob;
mod mollifiers;
mod page;
mod particles;
mod sums;

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;

use crate::field::cpu_time;

/// Run time against error.
#[derive(Clone, Debug, Args)]
pub struct Work {
    /// Where the page, its pictures and its numbers go.
    #[arg(long, default_value = "bench/results")]
    out: PathBuf,
    /// What `bench/peers/numpy_blob.py` printed; without it the blob method has no peer.
    #[arg(long)]
    numpy: Vec<PathBuf>,
    /// libfmm2d.so, built for one thread; without it sums have no peer but the loop in C.
    #[arg(long)]
    fmm2d: Option<PathBuf>,
    /// Small sizes: whether it works, not what it measures.
    #[arg(long)]
    quick: bool,
    /// Studies to run, by name; all if none is named.
    studies: Vec<String>,
}

/// A setting, the time that it takes and the error that it has.
#[derive(Clone, Debug, Serialize)]
struct Row {
    setting: String,
    /// In the study's unit.
    time: f64,
    error: f64,
    /// One standard deviation of the error over runs with other random numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    spread: Option<f64>,
}

/// Settings of one kind.
#[derive(Clone, Debug, Serialize)]
struct Curve {
    name: String,
    rows: Vec<Row>,
}

/// A question with its measurements.
#[derive(Clone, Debug, Serialize)]
struct Study {
    /// Of its files.
    name: &'static str,
    question: &'static str,
    /// What was computed, in sentences.
    about: String,
    /// Of the times.
    unit: &'static str,
    /// What the error is.
    error: &'static str,
    /// Digits for which the page says what is fastest.
    digits: &'static [i32],
    curves: Vec<Curve>,
    /// More that the page says, a sentence each.
    notes: Vec<String>,
}

/// The fastest setting with at most this error, and the name of its curve.
fn fastest(curves: &[Curve], error: f64) -> Option<(&str, &Row)> {
    let all = curves.iter().flat_map(|curve| curve.rows.iter().map(|row| (curve.name.as_str(), row)));
    all.filter(|(_, row)| row.error <= error).min_by(|(_, a), (_, b)| a.time.total_cmp(&b.time))
}

/// A study's function.
type Measure = fn(&Work) -> Result<Study>;

const STUDIES: &[(&str, Measure)] = &[
    ("mollifiers", mollifiers::study),
    ("sums", sums::study),
    ("blob", blob::paper),
    ("orders", blob::orders),
    ("steps", blob::steps),
    ("particles", particles::study),
];

impl Work {
    /// Measures and writes.
    pub fn run(&self) -> Result<()> {
        std::fs::create_dir_all(&self.out).with_context(|| format!("cannot make {}", self.out.display()))?;
        for (name, study) in STUDIES {
            if self.studies.is_empty() || self.studies.iter().any(|wanted| wanted == name) {
                println!("{name}");
                page::write(&self.out, &study(self)?)?;
            }
        }
        let names: Vec<&str> = STUDIES.iter().map(|(name, _)| *name).collect();
        page::join(&self.out, &names)
    }
}

/// The least CPU time of a call, in seconds, over as many calls as fit into a tenth of a second, and three at least.
fn least_time(mut call: impl FnMut() -> Result<()>) -> Result<f64> {
    let (begin, mut least, mut calls) = (cpu_time(), f64::INFINITY, 0);
    while calls < 3 || (cpu_time() - begin).as_secs_f64() < 0.1 {
        let before = cpu_time();
        call()?;
        least = least.min((cpu_time() - before).as_secs_f64());
        calls += 1;
    }
    Ok(least)
}
