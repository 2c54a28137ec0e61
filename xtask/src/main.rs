//! The commands for developers: `cargo xtask ...`.
//!
//! `shell` runs programs, `tools` finds or installs them, `text` reads sources. Each other file is one command or one check. `suites` runs
//! all of them and counts.

mod avx512;
mod bench;
mod counts;
mod coverage;
mod evidence;
mod examples;
mod faults;
mod features;
mod figures;
mod firmware;
mod fuzz;
mod header;
mod install;
mod layers;
mod neon;
mod python;
mod sanitize;
mod shell;
mod stress;
mod suites;
mod symbols;
mod templates;
mod text;
mod tools;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Commands for developers of mollis.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs all suites, or those named, and prints a table of minutes and `N passed, N failed`.
    #[command(visible_alias = "ci")]
    Test {
        /// Suites to run; all if none is named.
        suites: Vec<String>,
    },
    /// Builds the library and a program of `examples_c/`, and runs the program.
    Example {
        /// The file name of the program without its extension.
        name: String,
        /// Arguments of the program.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Writes `include/mollis.h` from the source of the C ABI.
    Header {
        /// Writes nothing, and fails if the file is not up to date.
        #[arg(long)]
        check: bool,
    },
    /// Checks that the linked library contains no allocation, panic or output.
    Symbols,
    /// Refuses a `use` in `core` that points to a higher layer or closes a circle, and `unsafe` outside the listed modules.
    Layers,
    /// Builds each combination of Cargo features without std.
    Features,
    /// Refuses a function of the header that is not called by a test or an example.
    Coverage,
    /// Compares what mollis computes with what is known of it: `cargo xtask evidence --help` lists the comparisons.
    #[command(disable_help_flag = true)]
    Evidence {
        /// The comparison's name, and what it takes.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Runs the programs of `tests/firmware/` on bare machines in QEMU and measures their size, stack and instructions.
    Firmware,
    /// Runs the tests of the AVX-512 level on this processor, or in an emulator if it lacks the instructions.
    Avx512 {
        /// Uses the emulator in any case.
        #[arg(long)]
        emulate: bool,
    },
    /// Runs the tests of core and of `tests/` on aarch64, in QEMU.
    Neon {
        /// Arguments of `cargo test`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        filter: Vec<String>,
    },
    /// Measures run time against error and writes `bench/results/README.md` with its pictures.
    Bench(bench::Args),
    /// Counts the instructions of fixed cases by callgrind, and compares them with `bench/counts.txt`.
    Counts {
        /// Records the counts.
        #[arg(long)]
        write: bool,
        /// Cases; all if none is named.
        cases: Vec<String>,
    },
    /// Runs the stability tests in their long sizes: more scales and seeds, and a million steps.
    Stress {
        /// A module or test of `tests/tests/stress/`; all if none is named.
        #[arg(default_value = "")]
        filter: String,
    },
    /// Puts faults into a copy of the sources, one at a time, and runs the tests that have to notice it.
    Faults {
        /// Part of a path: faults of these files; all if none is named.
        #[arg(default_value = "")]
        filter: String,
    },
    /// Runs the checks of `fuzz/` with inputs that libFuzzer finds; `cargo test` replays those that are kept.
    Fuzz {
        /// A check; all if none is named.
        target: Option<String>,
        /// How long each runs.
        #[arg(long, default_value_t = 60)]
        seconds: u32,
        /// Runs this input alone.
        #[arg(long, requires = "target")]
        input: Option<std::path::PathBuf>,
    },
    /// Runs the programs in C and C++ under AddressSanitizer, UndefinedBehaviorSanitizer, ThreadSanitizer and valgrind.
    Sanitize,
    /// Runs all scenes, or those named, and writes a gallery of pictures with the papers' numbers and the measured ones.
    Figures {
        /// Uses the quick sizes of the scenes.
        #[arg(long)]
        quick: bool,
        /// Threads; 0 uses all processors of the machine.
        #[arg(long, default_value_t = 0)]
        threads: usize,
        /// Scenes to run, by file name without extension.
        scenes: Vec<String>,
    },
    /// Builds for release and installs both libraries, shared and static, headers, files for pkg-config and CMake, licences and examples below a prefix.
    ///
    /// The environment variable DESTDIR is put before the prefix where files are written, as packages are made.
    Install {
        /// The prefix; created if missing.
        prefix: std::path::PathBuf,
    },
    /// Removes what `install` wrote below a prefix, and below DESTDIR if it is set.
    Uninstall {
        /// The prefix.
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
        Command::Stress { filter } => stress::run(&filter),
        Command::Faults { filter } => faults::run(&filter),
        Command::Fuzz { target, seconds, input } => fuzz::run(target.as_deref(), seconds, input.as_deref()),
        Command::Sanitize => sanitize::run(),
        Command::Figures { quick, threads, scenes } => figures::run(quick, threads, &scenes),
        Command::Firmware => firmware::run().map(|_| ()),
        Command::Avx512 { emulate } => avx512::run(emulate).map(|_| ()),
        Command::Bench(args) => bench::run(&args),
        Command::Counts { write, cases } => counts::run(write, &cases),
        Command::Neon { filter } => neon::run(&filter),
        Command::Install { prefix } => install::run(&prefix),
        Command::Uninstall { prefix } => install::remove(&prefix),
    }
}
