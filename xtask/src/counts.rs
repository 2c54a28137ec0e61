//! Counts the instructions of fixed cases, and compares them with those in `bench/counts.txt`.
//!
//! The counts depend on the compiler, little on the machine (copies by the C library), and not at all on what else it does. So a change that costs time shows without a quiet one.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::{Context, Result, bail};

use crate::{shell, tools};

const FILE: &str = "bench/counts.txt";

/// A count that is larger than the recorded one by more than this is an error.
const SLACK: f64 = 0.02;

/// Counts the cases, or those named, and compares them; if `write`, records them instead.
pub fn run(write: bool, names: &[String]) -> Result<()> {
    tools::need(&[("valgrind", "valgrind")])?;
    shell::run(shell::cargo().args(["build", "--quiet", "--release", "-p", "mollis-bench"]))?;
    let program = shell::target().join("release/mollis-bench");
    let listed = shell::output(shell::program(&program).arg("count"))?;
    let path = shell::root().join(FILE);
    let recorded = parse(&std::fs::read_to_string(&path).unwrap_or_default())?;
    let (mut counts, mut larger) = (recorded.clone(), Vec::new());
    for name in listed.lines().filter(|name| names.is_empty() || names.iter().any(|wanted| wanted == name)) {
        let count = count(&program, name)?;
        let before = recorded.get(name).copied();
        let change = before.map_or(0.0, |before| count as f64 / before as f64 - 1.0);
        println!("{name:24} {count:>12} {:+.2} %", 100.0 * change);
        if before.is_none() && !write {
            larger.push(format!("{name} is not recorded"));
        } else if change > SLACK {
            larger.push(format!("{name}: {:+.1} %", 100.0 * change));
        }
        counts.insert(name.to_owned(), count);
    }
    if write {
        let mut text = String::new();
        for (name, count) in &counts {
            writeln!(text, "{name} {count}")?;
        }
        return std::fs::write(&path, text).with_context(|| format!("cannot write {FILE}"));
    }
    if larger.is_empty() {
        return Ok(());
    }
    bail!("more instructions than in {FILE} (`--write` records them): {}", larger.join(", "))
}

fn parse(text: &str) -> Result<BTreeMap<String, u64>> {
    let row = |line: &str| {
        let (name, count) = line.split_once(' ').with_context(|| format!("{FILE}: {line}"))?;
        Ok((name.to_owned(), count.parse()?))
    };
    text.lines().map(row).collect()
}

/// The instructions of a case's counted function.
fn count(program: &std::path::Path, name: &str) -> Result<u64> {
    let mut valgrind = shell::program("valgrind");
    valgrind.args(["--tool=callgrind", "--toggle-collect=mollis_counted", "--callgrind-out-file=/dev/null"]);
    let output = valgrind.arg(program).args(["count", name]).output().context("cannot start valgrind")?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().filter_map(|line| line.split_once("Collected :")).next();
    match count {
        Some((_, count)) if output.status.success() => Ok(count.trim().parse()?),
        _ => bail!("{name}: {text}"),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_record_is_read() {
        let counts = super::parse("a 12\nb-c 3\n").expect("two rows");
        assert_eq!((counts["a"], counts["b-c"], counts.len()), (12, 3, 2));
        assert!(super::parse("a\n").is_err() && super::parse("a b\n").is_err());
    }
}
