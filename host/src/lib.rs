//! What a program with std gives mollis: a pool of threads and aligned memory.
//!
//! With the feature `command` also what the project's commands share: arguments, lines on standard output, exit statuses.

#[cfg(feature = "command")]
pub mod command;
#[cfg(feature = "command")]
pub mod console;
pub mod memory;
pub mod pool;
