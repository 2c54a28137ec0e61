//! A command from its arguments to its exit status.
//!
//! An error is printed to standard error and ends with status 1; what clap refuses ends with status 2. Where the reader of
//! standard output has gone, the command ends quietly with status 141, as a program ends that SIGPIPE stops.

use std::process::ExitCode;

use anyhow::Result;

use crate::{complain, console};

/// Status of a command whose standard output was closed: 128 and the number of SIGPIPE.
const CLOSED: u8 = 141;

/// The largest number of threads that can be asked for: as many as the library uses.
const THREADS: u64 = mollis_core::exec::MAX_WORKERS as u64;

/// Reads the value of an option `--threads`, from `least` on.
///
/// # Errors
/// What is allowed.
pub fn threads(text: &str, least: u64) -> Result<usize, String> {
    match text.parse::<u64>() {
        Ok(threads) if (least..=THREADS).contains(&threads) => Ok(threads as usize),
        _ => Err(format!("must be a whole number from {least} to {THREADS}")),
    }
}

/// Reads the arguments, runs the command and gives its status; errors are printed after `name`.
pub fn main<C: clap::Parser>(name: &str, run: impl FnOnce(C) -> Result<ExitCode>) -> ExitCode {
    parsed(run).unwrap_or_else(|error| {
        if console::is_closed(&error) {
            return ExitCode::from(CLOSED);
        }
        complain!("{name}: {error:#}");
        ExitCode::FAILURE
    })
}

fn parsed<C: clap::Parser>(run: impl FnOnce(C) -> Result<ExitCode>) -> Result<ExitCode> {
    match C::try_parse() {
        Ok(command) => run(command),
        Err(error) if error.use_stderr() => {
            // Where printing fails there is no place left to say so.
            let _ = error.print();
            Ok(ExitCode::from(2))
        }
        // The text that `--help` and `--version` ask for.
        Err(text) => {
            console::checked(text.print())?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_few() {
        assert_eq!((threads("0", 0), threads("256", 0)), (Ok(0), Ok(256)));
        for (text, least) in [("257", 0), ("100000", 0), ("0", 1), ("-1", 0), ("two", 0), ("18446744073709551616", 0)] {
            assert!(threads(text, least).unwrap_err().contains("from"), "{text}");
        }
    }
}
