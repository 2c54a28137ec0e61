//! The `mollis` command: a user of `mollis-core` like any other.
//!
//! Every subcommand is a module with `Args` (what clap parses) and `main(Args) -> anyhow::Result<ExitCode>`; this file only
//! dispatches. An error is printed to standard error and ends with status 1; what clap refuses ends with status 2.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod converge;
mod initial;
mod memory;
mod output;
mod pks_check;
mod plot;
mod run;
mod scene;
mod verify;

/// Particles with softened potentials: run a scene, see it move, check it against an oracle.
#[derive(Parser)]
#[command(name = "mollis", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run an experiment on coalescing particles and compare it with the theory.
    PksCheck(pks_check::Args),
    /// Run a scene: data, pictures and checked numbers.
    Run(run::Args),
    /// Print what a scene would run and what it would cost, without running it.
    Plan(run::PlanArgs),
    /// Measure the blob method's convergence and compare it with known numbers.
    Converge(converge::Args),
    /// Run the blob method to known steady states and compare.
    Steady(converge::Args),
    /// Measure what the blob method keeps over 1e5 steps: centre of mass, decay of the energy.
    Conserve(converge::Args),
    /// Print the schema of scene files, or check scene files without running them.
    Scene(scene::Args),
    /// Compare results with reference values of 25 digits; status 1 above a tolerance.
    Verify(verify::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::PksCheck(args) => pks_check::main(args),
        Command::Run(args) => run::main(args),
        Command::Plan(args) => run::plan_main(args),
        Command::Converge(args) => converge::main(args),
        Command::Steady(args) => converge::steady(args),
        Command::Conserve(args) => converge::conserve(args),
        Command::Scene(args) => scene::main(args),
        Command::Verify(args) => verify::main(args),
    };
    result.unwrap_or_else(|error| {
        eprintln!("mollis: {error:#}");
        ExitCode::FAILURE
    })
}
