//! `cargo xtask evidence converge`, `cargo xtask evidence steady`, `cargo xtask evidence conserve`: the blob method's convergence and long-time studies, as numbers.
//!
//! Each study prints a table and compares it with what is known: exact solutions, rates of the theory, closed forms of steady
//! states. Where an independent implementation's numbers are known, a deviation above 5 per cent makes the command fail.
//! Source of the studies: Craig & Bertozzi, section 4, Figures 1 to 5 and 7.

mod cubic;
mod long;
mod run;
mod tables;

use std::process::ExitCode;

use anyhow::{Result, bail};
use mollis_host::say;

/// Arguments of these commands.
#[derive(clap::Args)]
pub struct Args {
    /// Studies to run; all of them without a name.
    names: Vec<String>,
    /// Names of the studies, with what each shows.
    #[arg(long)]
    list: bool,
}

/// A study: its name, what it shows, and the function that prints it and says whether all was as expected.
type Study = (&'static str, &'static str, fn() -> Result<bool>);

const STUDIES: &[Study] = &[
    ("attractive", "Figure 1: 1D Newtonian, (1 - x^2)^20, both Gaussian mollifiers", tables::attractive),
    ("particle", "Figure 2: the particle method on the same data: rate 2", tables::particle),
    ("discontinuous", "Figure 3: 1D Newtonian, indicator of [-1, 1]", tables::discontinuous),
    ("repulsive", "Figure 4: 1D repulsive Newtonian, (1 - x^2)^10, both Gaussian mollifiers", tables::repulsive),
    ("cubic", "Figure 4: K = |x|^3 / 3, both Gaussian mollifiers and the particle method", tables::cubic),
    ("plane", "Figure 5: 2D Newtonian: blobs, particle method, discontinuous data", tables::plane),
    ("overlap", "why the density's rate flattens under repulsion: delta over the particles' spacing", tables::overlap),
];

const STEADY: &[Study] = &[
    ("contraction", "K = |x|^2 / 2: e^-t about the centre of mass", long::contraction),
    ("ring", "K = |x|^4 / 4 - |x|^1.5 / 1.5: the ring's radius as delta -> 0", long::ring),
    ("clusters", "K = |x|^7 / 7 - |x|^1.5 / 1.5: the ring breaks; large delta: three clusters", long::clusters),
    ("radial", "K = |x|^4 / 4 - log|x| / (2 pi): the radial steady state", long::radial),
];

const CONSERVATION: &[Study] =
    &[("conservation", "1e5 steps: drift of the centre of mass, energy monotone, f32 and f64", long::conservation)];

/// Runs `cargo xtask evidence converge`: convergence against exact solutions.
pub fn main(args: Args) -> Result<ExitCode> {
    run(&args, STUDIES)
}

/// Runs `cargo xtask evidence steady`: steady states.
pub fn steady(args: Args) -> Result<ExitCode> {
    run(&args, STEADY)
}

/// Runs `cargo xtask evidence conserve`: what a long run keeps.
pub fn conserve(args: Args) -> Result<ExitCode> {
    run(&args, CONSERVATION)
}

fn run(args: &Args, studies: &[Study]) -> Result<ExitCode> {
    if args.list {
        for (name, about, _) in studies {
            say!("{name:14} {about}")?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(unknown) = args.names.iter().find(|name| !studies.iter().any(|study| study.0 == name.as_str())) {
        bail!("no study is named {unknown}; --list names them");
    }
    let mut failed = Vec::new();
    for (name, about, study) in studies {
        if args.names.is_empty() || args.names.iter().any(|wanted| wanted == name) {
            say!("# {name}: {about}")?;
            let expected = study()?;
            say!("{}\n", if expected { "as expected" } else { "NOT AS EXPECTED" })?;
            if !expected {
                failed.push(*name);
            }
        }
    }
    if failed.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    say!("not as expected: {}", failed.join(", "))?;
    Ok(ExitCode::FAILURE)
}
