//! `cargo xtask evidence verify`: compares what the library returns with reference values of 25 digits.
//!
//! A reference file is CSV with comment lines and named columns; `tests/data` holds some. Its rows are evaluated through a
//! public interface and compared with the decimals in double-word arithmetic, so errors are those of the results alone.

mod api;
mod decimal;
mod reference;
mod report;
mod tolerance;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use mollis_host::say;

use api::Api;
use decimal::Scalar;

/// Compare results with reference values: one JSON object a quantity and order, status 1 above a tolerance.
#[derive(clap::Args)]
pub struct Args {
    /// Reference files.
    #[arg(required = true, value_name = "FILE.csv")]
    files: Vec<PathBuf>,
    /// The interface to call.
    #[arg(long, value_enum, default_value_t = Api::Rust)]
    api: Api,
    /// The scalar to compute in. Rows whose inputs it cannot hold exactly are skipped, and counted.
    #[arg(long, value_enum, default_value_t = Scalar::F64)]
    scalar: Scalar,
    /// Print lines of `docs/accuracy.csv` instead: the largest errors by dimension, exponent M and order, in the tolerance table's units.
    #[arg(long)]
    table: bool,
}

/// Runs the command.
pub fn main(args: Args) -> Result<ExitCode> {
    let mut passed = true;
    for path in &args.files {
        let report = report::Report::new(&reference::read(path)?, args.api, args.scalar)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if args.table {
            for line in report.lines(&name, args.scalar.name()) {
                say!("{line}")?;
            }
        } else {
            for object in report.json(&name) {
                say!("{object}")?;
            }
        }
        passed &= report.passed();
    }
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
