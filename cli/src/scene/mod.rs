//! Scene files: what they may say, read with every mistake named by file, line and key.

use std::process::ExitCode;

/// Arguments of `mollis scene`.
#[derive(clap::Args)]
pub struct Args {
    /// Print every key with its unit, range, default and meaning.
    #[arg(long)]
    schema: bool,
}

/// Runs `mollis scene`.
pub fn main(_args: Args) -> anyhow::Result<ExitCode> {
    anyhow::bail!("scenes are not there yet")
}
