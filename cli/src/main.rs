//! The `mollis` command.

fn main() {}
