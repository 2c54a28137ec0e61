//! Runs the checks of `fuzz/` with inputs that libFuzzer finds. Needs a nightly compiler, cargo-fuzz and g++.
//!
//! New inputs are kept in `target/xtask/fuzz/corpus/`, and those that fail a check in `target/xtask/fuzz/failures/`.

use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};

use crate::{shell, tools};

/// The checks, each with a folder of further inputs.
const TARGETS: [(&str, Option<&str>); 5] =
    [("abi", None), ("scene", Some("scenes")), ("points", None), ("fmm", None), ("search", None)];

/// The longest input in bytes.
const LONGEST: usize = 4096;
/// A single input that takes so many seconds is a failure.
const SLOWEST: usize = 60;

/// Runs a target, or all, for so many seconds each. With a file: runs that input alone.
pub fn run(target: Option<&str>, seconds: u32, input: Option<&std::path::Path>) -> Result<()> {
    tools::need(&[("g++", "g++")])?;
    available()?;
    let targets: Vec<_> = TARGETS.into_iter().filter(|(name, _)| target.is_none_or(|wanted| wanted == *name)).collect();
    if targets.is_empty() {
        bail!("no target `{}`; there are {}", target.unwrap_or_default(), TARGETS.map(|(name, _)| name).join(", "));
    }
    let mut failed = Vec::new();
    for (name, further) in targets {
        let mut command = nightly(&["fuzz", "run", "--fuzz-dir", "fuzz/libfuzzer"]);
        command.arg("--target-dir").arg(shell::target().join("fuzz")).arg(name);
        if let Some(input) = input {
            command.arg(input);
        } else {
            command
                .arg(shell::scratch(&format!("fuzz/corpus/{name}"))?)
                .arg(format!("fuzz/corpus/{name}"))
                .args(further);
        }
        let failures = shell::scratch(&format!("fuzz/failures/{name}"))?;
        command.arg("--").arg(format!("-artifact_prefix={}/", failures.display()));
        command.args([format!("-max_len={LONGEST}"), format!("-timeout={SLOWEST}")]);
        if input.is_none() {
            command.args([format!("-max_total_time={seconds}"), "-print_final_stats=1".to_owned()]);
        }
        println!("{name}");
        let status = command.status().context("cannot start cargo")?;
        if !status.success() {
            failed.push(name);
        }
    }
    ensure!(
        failed.is_empty(),
        "failed: {}; the inputs lie in {}",
        failed.join(", "),
        shell::scratch("fuzz/failures")?.display()
    );
    Ok(())
}

/// Cargo of the nightly compiler.
pub fn nightly(arguments: &[&str]) -> Command {
    let mut command = shell::program("cargo");
    // What `cargo xtask` was started with is for the stable one.
    command.env_remove("CARGO").env_remove("RUSTC").env_remove("RUSTUP_TOOLCHAIN");
    command.arg("+nightly").args(arguments);
    command
}

fn available() -> Result<()> {
    for (arguments, advice) in [
        (&["--version"][..], "rustup toolchain install nightly --profile minimal"),
        (&["fuzz", "--version"][..], "cargo install cargo-fuzz"),
    ] {
        let found = nightly(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
        ensure!(found.is_ok_and(|status| status.success()), "missing; run `{advice}`, then this command again");
    }
    Ok(())
}
