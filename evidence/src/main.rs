//! Evidence for developers, `cargo xtask evidence NAME`: what the library returns, against what is known.
//!
//! [`verify`] compares single results with reference values, [`converge`] the blob method with exact solutions, rates and
//! steady states, [`pks_check`] coalescing particles with the laws and experiments of their papers. Status 1 where a number
//! misses.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod converge;
mod pks_check;
mod verify;

/// Compares what mollis computes with what is known of it.
#[derive(Parser)]
#[command(name = "evidence", bin_name = "cargo xtask evidence", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compare results with reference values of 25 digits; status 1 above a tolerance.
    Verify(verify::Args),
    /// Measure the blob method's convergence and compare it with known numbers.
    Converge(converge::Args),
    /// Run the blob method to known steady states and compare.
    Steady(converge::Args),
    /// Measure what the blob method keeps over 1e5 steps: centre of mass, decay of the energy.
    Conserve(converge::Args),
    /// Run an experiment on coalescing particles and compare it with the theory.
    PksCheck(pks_check::Args),
}

fn main() -> ExitCode {
    mollis_host::command::main("evidence", |arguments: Arguments| match arguments.command {
        Command::Verify(args) => verify::main(args),
        Command::Converge(args) => converge::main(args),
        Command::Steady(args) => converge::steady(args),
        Command::Conserve(args) => converge::conserve(args),
        Command::PksCheck(args) => pks_check::main(args),
    })
}
