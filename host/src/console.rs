//! Lines on standard output and standard error.
//!
//! `println!` panics where a line can't be written. Here a reader that has gone (`mollis ... | head`) ends the command
//! quietly, and every other failure (`> /dev/full`) is an error like any other.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

use anyhow::{Context, Result};

/// The reader of standard output has closed it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Closed;

impl std::fmt::Display for Closed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("standard output was closed")
    }
}

impl std::error::Error for Closed {}

fn write(out: &mut dyn Write, text: Arguments<'_>) -> Result<()> {
    checked(out.write_fmt(text).and_then(|()| out.flush()))
}

/// What came of a write to standard output, with a closed pipe as [`Closed`].
///
/// # Errors
/// The write's own.
pub fn checked(result: std::io::Result<()>) -> Result<()> {
    match result {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Err(Closed.into()),
        other => other.context("standard output"),
    }
}

/// Writes text to standard output.
///
/// # Errors
/// [`Closed`], or what else keeps the text from being written.
pub fn print(text: Arguments<'_>) -> Result<()> {
    write(&mut std::io::stdout().lock(), text)
}

/// Writes a line to standard error. Where that fails there is no place left to say so.
pub fn print_error(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Whether an error says that the reader of standard output has gone.
pub fn is_closed(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| cause.is::<Closed>())
}

/// A line on standard output, with the arguments of `println!`; a `Result` that must be looked at.
#[macro_export]
macro_rules! say {
    () => {
        $crate::console::print(format_args!("\n"))
    };
    ($format:literal $($rest:tt)*) => {
        $crate::console::print(format_args!("{}\n", format_args!($format $($rest)*)))
    };
}

/// A line on standard error, with the arguments of `eprintln!`.
#[macro_export]
macro_rules! complain {
    ($($text:tt)*) => {
        $crate::console::print_error(format_args!($($text)*))
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Failing(ErrorKind);

    impl Write for Failing {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_closed_pipe_is_told_from_other_failures() {
        let closed = write(&mut Failing(ErrorKind::BrokenPipe), format_args!("text")).unwrap_err();
        assert!(is_closed(&closed.context("with context")));
        let full = write(&mut Failing(ErrorKind::StorageFull), format_args!("text")).unwrap_err();
        assert!(!is_closed(&full) && format!("{full:#}").starts_with("standard output: "));
    }
}
