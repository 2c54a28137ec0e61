//! Names the shared library that is built from a package, so that a program finds the version it was linked with.
//!
//! `libNAME.so.MAJOR`, and `libNAME.so.0.MINOR` before 1.0: by semantic versioning, what may break a program changes this number.

use std::env::var;

fn main() {
    // Nothing of the package's files matters.
    println!("cargo:rerun-if-env-changed=CARGO_CFG_TARGET_OS");
    let [os, package, major, minor] =
        ["CARGO_CFG_TARGET_OS", "CARGO_PKG_NAME", "CARGO_PKG_VERSION_MAJOR", "CARGO_PKG_VERSION_MINOR"]
            .map(|name| var(name).unwrap_or_default());
    // Systems whose libraries are ELF files, with linkers that take this option.
    if ["linux", "android", "freebsd", "netbsd", "openbsd", "dragonfly"].contains(&os.as_str()) {
        let number = if major == "0" { format!("0.{minor}") } else { major };
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,lib{}.so.{number}", package.replace('-', "_"));
    }
}
