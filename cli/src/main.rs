//! The `mollis` command: a user of `mollis-core` like any other.
//!
//! Every subcommand is a module with `Args` (what clap parses) and `main(Args) -> anyhow::Result<ExitCode>`; this file only
//! dispatches. An error is printed to standard error and ends with status 1; what clap refuses ends with status 2. Where the
//! reader of standard output has gone, the command ends quietly with status 141, as a program ends that SIGPIPE stops.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod console;
mod converge;
mod initial;
mod memory;
mod output;
mod pks_check;
mod plot;
mod run;
mod scene;
mod verify;

/// Status of a command whose standard output was closed: 128 and the number of SIGPIPE.
const CLOSED: u8 = 141;

/// The largest number of threads that can be asked for: as many as the library uses.
const THREADS: u64 = mollis_core::exec::MAX_WORKERS as u64;

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

/// Reads `--threads`, from `least` on.
fn threads(text: &str, least: u64) -> Result<usize, String> {
    match text.parse::<u64>() {
        Ok(threads) if (least..=THREADS).contains(&threads) => Ok(threads as usize),
        _ => Err(format!("must be a whole number from {least} to {THREADS}")),
    }
}

fn dispatch() -> anyhow::Result<ExitCode> {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            // In colours where the terminal has them; where printing fails there is no place left to say so.
            let _ = error.print();
            return Ok(ExitCode::from(2));
        }
        // The text that `--help` and `--version` ask for.
        Err(text) => {
            console::checked(text.print())?;
            return Ok(ExitCode::SUCCESS);
        }
    };
    match cli.command {
        Command::PksCheck(args) => pks_check::main(args),
        Command::Run(args) => run::main(args),
        Command::Plan(args) => run::plan_main(args),
        Command::Converge(args) => converge::main(args),
        Command::Steady(args) => converge::steady(args),
        Command::Conserve(args) => converge::conserve(args),
        Command::Scene(args) => scene::main(args),
        Command::Verify(args) => verify::main(args),
    }
}

fn main() -> ExitCode {
    dispatch().unwrap_or_else(|error| {
        if console::is_closed(&error) {
            return ExitCode::from(CLOSED);
        }
        console::complain!("mollis: {error:#}");
        ExitCode::FAILURE
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_few() {
        assert_eq!((threads("0", 0), threads("256", 0)), (Ok(0), Ok(256)));
        for (text, least) in [("257", 0), ("100000", 0), ("0", 1), ("-1", 0), ("two", 0), ("18446744073709551616", 0)] {
            assert!(threads(text, least).unwrap_err().contains("from"), "{text}");
        }
    }
}
