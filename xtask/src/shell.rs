//! Runs programs and gives the paths of the repository.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the root").to_path_buf()
}

/// The folder for build results.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// A folder for xtask below `target/`; created if missing.
pub fn scratch(name: &str) -> Result<PathBuf> {
    let path = target().join("xtask").join(name);
    std::fs::create_dir_all(&path).with_context(|| format!("cannot make {}", path.display()))?;
    Ok(path)
}

/// A program to be run in the root of the repository.
pub fn program(name: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(name);
    command.current_dir(root());
    command
}

/// The cargo that runs this program.
pub fn cargo() -> Command {
    program(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Runs a program. On failure the error names it.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {}", line(command)))?;
    ensure!(status.success(), "failed ({status}): {}", line(command));
    Ok(())
}

/// Runs a program and returns what it wrote to standard output.
pub fn output(command: &mut Command) -> Result<String> {
    let output =
        command.stderr(Stdio::inherit()).output().with_context(|| format!("cannot start {}", line(command)))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    ensure!(output.status.success(), "failed ({}): {}\n{text}", output.status, line(command));
    Ok(text)
}

/// Runs a program and prints its standard output line by line. Returns that output and whether the program succeeded.
pub fn tee(command: &mut Command) -> Result<(bool, String)> {
    let mut child =
        command.stdout(Stdio::piped()).spawn().with_context(|| format!("cannot start {}", line(command)))?;
    let mut text = String::new();
    let pipe = child.stdout.take().context("no pipe")?;
    for row in BufReader::new(pipe).lines() {
        let row = row?;
        writeln!(std::io::stdout(), "{row}")?;
        text.push_str(&row);
        text.push('\n');
    }
    Ok((child.wait()?.success(), text))
}

/// Runs a command of cargo that builds programs, such as `test --no-run`, and returns these by the names of their targets.
pub fn programs(cargo: &mut Command) -> Result<BTreeMap<String, PathBuf>> {
    let messages = output(cargo.arg("--message-format=json"))?;
    let program = |row: &str| {
        let message: serde_json::Value = serde_json::from_str(row).ok()?;
        Some((message["target"]["name"].as_str()?.to_owned(), message.get("executable")?.as_str()?.into()))
    };
    Ok(messages.lines().filter_map(program).collect())
}

/// A command as it would be typed.
fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|w| w.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// Every file below `folder` (relative to the root) with one of the extensions, sorted.
pub fn files(folder: &str, endings: &[&str]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        if !folder.is_dir() {
            continue;
        }
        for entry in std::fs::read_dir(&folder).with_context(|| format!("cannot list {}", folder.display()))? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| endings.iter().any(|&ending| e == ending)) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// A path for messages, relative to the root.
pub fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// The text of a file. On failure the error names it.
pub fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", short(path)))
}
