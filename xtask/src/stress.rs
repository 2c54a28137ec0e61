//! Runs the stability tests of `tests/tests/stress/` in their long sizes.

use anyhow::Result;

use crate::shell;

/// Runs them, or those whose names contain `filter`.
pub fn run(filter: &str) -> Result<()> {
    let mut cargo = shell::cargo();
    // Optimised, as they take a million steps.
    cargo.env("MOLLIS_STRESS", "long").args(["test", "--release", "-p", "mollis-tests", "--test", "all", "--"]);
    shell::run(cargo.arg(format!("stress::{filter}")))
}
