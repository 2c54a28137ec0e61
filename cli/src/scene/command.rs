//! `mollis scene`: the schema of scene files, and scene files checked without running them.

use std::path::PathBuf;
use std::process::ExitCode;

use mollis_host::{complain, console, say};

use super::read::load;
use super::schema;

/// Arguments of `mollis scene`.
#[derive(clap::Args)]
pub struct Args {
    /// Print every key with its unit, range, default and meaning.
    #[arg(long)]
    schema: bool,
    /// Scene files to check without running them.
    #[arg(required_unless_present = "schema")]
    scenes: Vec<PathBuf>,
}

/// Runs `mollis scene`.
pub fn main(args: Args) -> anyhow::Result<ExitCode> {
    if args.schema {
        console::print(format_args!("{}", schema::print()))?;
    }
    let mut code = ExitCode::SUCCESS;
    for path in &args.scenes {
        for quick in [false, true] {
            match load(path, quick) {
                Ok(file) if !quick => say!("{}: good; {} run(s)", path.display(), file.cases.len())?,
                Ok(_) => {}
                Err(error) => {
                    complain!("{error:#}");
                    code = ExitCode::FAILURE;
                    break;
                }
            }
        }
    }
    Ok(code)
}
