//! The `mollis` command: a user of `mollis-core` like any other.
//!
//! Every subcommand is a module with `Args` (what clap parses) and `main(Args) -> anyhow::Result<ExitCode>`; this file only
//! dispatches. (A library, and a program of one line: it is then compiled while `mollis-core` still is.) `mollis_host::command` says what status a command ends with.
//!
//! `scene` reads a scene, `initial` makes its `particles` (or `points` reads them), `model` moves them and fills a
//! `history`, `measure`, `plot` and `output` turn the `results` into numbers, pictures and tables, `checkpoint`
//! holds what a stopped run needs; `files` writes. `run` puts these together. `inputs` reads scenes and points for checks.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod checkpoint;
mod files;
mod history;
mod initial;
pub mod inputs;
mod measure;
mod model;
mod output;
mod particles;
pub mod plot;
mod points;
mod results;
mod run;
mod scene;

/// Particles with softened potentials: check, run and plot scenes.
#[derive(Parser)]
#[command(name = "mollis", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene: data, pictures and checked numbers.
    Run(run::Args),
    /// Print what a scene would run and what it would cost, without running it.
    Plan(run::PlanArgs),
    /// Print the schema of scene files, or check scene files without running them.
    Scene(scene::Args),
}

/// What the program does.
#[must_use]
pub fn main() -> ExitCode {
    mollis_host::command::main("mollis", |arguments: Arguments| match arguments.command {
        Command::Run(args) => run::main(args),
        Command::Plan(args) => run::plan_main(args),
        Command::Scene(args) => scene::main(args),
    })
}
