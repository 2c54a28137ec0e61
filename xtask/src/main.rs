//! What a developer types: `cargo xtask ...`.
//!
//! `shell` runs programs, `tools` finds or installs them, `text` reads sources; each other file is one command or one
//! check, and `suites` runs them all and counts.

mod coverage;
mod evidence;
mod examples;
mod features;
mod figures;
mod firmware;
mod header;
mod install;
mod layers;
mod neon;
mod shell;
mod suites;
mod symbols;
mod text;
mod tools;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// What a developer of mollis types.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs every suite (or those named), prints a table of minutes and `N passed, N failed`.
    #[command(visible_alias = "ci")]
    Test {
        /// Suites to run; all without a name.
        suites: Vec<String>,
    },
    /// Builds the library and a program of `examples_c/`, and runs it.
    Example {
        /// The file's name without its ending.
        name: String,
        /// Handed to the program.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Writes `include/mollis.h` from the C ABI's source.
    Header {
        /// Writes nothing; fails if the file differs from what would be written.
        #[arg(long)]
        check: bool,
    },
    /// Proves on the linked library that it allocates, panics and prints nothing.
    Symbols,
    /// Refuses uses that point up between the layers of `core`, circles of modules, and `unsafe` outside the modules for it.
    Layers,
    /// Builds each combination of Cargo features without std.
    Features,
    /// Refuses a function of the header that no test or example calls.
    Coverage,
    /// Compares what mollis computes with what is known of it: `cargo xtask evidence --help` lists the comparisons.
    #[command(disable_help_flag = true)]
    Evidence {
        /// The comparison's name, and what it takes.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Runs the programs of `tests/firmware/` on bare machines in QEMU and measures them.
    Firmware,
    /// Runs the tests of core and of `tests/` on aarch64, in QEMU.
    Neon {
        /// Handed to `cargo test`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        filter: Vec<String>,
    },
    /// Runs every scene (or those named) and writes a gallery of pictures beside the papers' numbers and ours.
    Figures {
        /// The scenes' quick sizes.
        #[arg(long)]
        quick: bool,
        /// Threads; 0 takes as many as the machine has.
        #[arg(long, default_value_t = 0)]
        threads: usize,
        /// Scenes to run, by file name without ending.
        scenes: Vec<String>,
    },
    /// Builds for release and copies both libraries, shared and static, headers and pkg-config files below a prefix.
    Install {
        /// Where to; made if missing.
        prefix: std::path::PathBuf,
    },
}

fn main() -> ExitCode {
    match run(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Result<()> {
    match command {
        Command::Test { suites } => suites::run(&suites),
        Command::Example { name, arguments } => examples::run(&name, &arguments),
        Command::Header { check } => header::run(check),
        Command::Symbols => symbols::run(),
        Command::Layers => layers::run(),
        Command::Features => features::run(),
        Command::Coverage => coverage::run(),
        Command::Evidence { arguments } => evidence::run(&arguments),
        Command::Figures { quick, threads, scenes } => figures::run(quick, threads, &scenes),
        Command::Firmware => firmware::run().map(|_| ()),
        Command::Neon { filter } => neon::run(&filter),
        Command::Install { prefix } => install::run(&prefix),
    }
}
