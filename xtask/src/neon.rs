//! Runs the tests on aarch64 in QEMU, where sums run at level `neon`.

use anyhow::Result;

use crate::{shell, tools};

const TARGET: &str = "aarch64-unknown-linux-gnu";

/// Builds the tests of the packages for aarch64 and runs them. `filter` is passed to `cargo test`.
pub fn run(filter: &[String]) -> Result<()> {
    tools::need(&[
        ("aarch64-linux-gnu-gcc", "gcc-aarch64-linux-gnu"),
        ("/usr/aarch64-linux-gnu/lib/libc.so.6", "libc6-dev-arm64-cross"),
        ("qemu-aarch64", "qemu-user"),
    ])?;
    shell::run(shell::program("rustup").args(["target", "add", TARGET]))?;
    let mut cargo = shell::cargo();
    cargo.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-gcc");
    cargo.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", "qemu-aarch64 -L /usr/aarch64-linux-gnu");
    // Optimised, because the machine is emulated.
    cargo.args(["test", "--release", "--no-fail-fast", "--target", TARGET, "-p", "mollis-core", "-p", "mollis-tests"]);
    shell::run(cargo.args(["--lib", "--tests"]).args(filter))
}
