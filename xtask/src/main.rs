//! What a developer types: `cargo xtask ...`.

fn main() {}
