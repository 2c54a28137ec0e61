//! Runs `mollis-evidence`.

use std::process::Command;

use anyhow::{Context, Result};

use crate::shell;

/// Builds it for release and runs it in the folder of the caller, with its exit status if that isn't 0.
pub fn run(arguments: &[String]) -> Result<()> {
    shell::run(shell::cargo().args(["build", "--quiet", "--release", "-p", "mollis-evidence"]))?;
    let program = shell::target().join("release").join("mollis-evidence");
    let status = Command::new(&program).args(arguments).status().with_context(|| format!("{}", program.display()))?;
    if !status.success() {
        std::process::exit(status.code().unwrap_or(1));
    }
    Ok(())
}
