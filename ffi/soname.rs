//! Sets the SONAME of the shared library of a package, so that a program finds the version it was linked with.
//!
//! The name is `libNAME.so.MAJOR`, and `libNAME.so.0.MINOR` before 1.0. In semantic versioning an incompatible change changes this number.

use std::env::var;

/// Prints the linker's option for cargo.
pub fn main() {
    // The result does not depend on the files of the package.
    println!("cargo:rerun-if-env-changed=CARGO_CFG_TARGET_OS");
    let [os, package, major, minor] =
        ["CARGO_CFG_TARGET_OS", "CARGO_PKG_NAME", "CARGO_PKG_VERSION_MAJOR", "CARGO_PKG_VERSION_MINOR"]
            .map(|name| var(name).unwrap_or_default());
    // Systems with ELF shared libraries, whose linkers take this option.
    if ["linux", "android", "freebsd", "netbsd", "openbsd", "dragonfly"].contains(&os.as_str()) {
        let number = if major == "0" { format!("0.{minor}") } else { major };
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,lib{}.so.{number}", package.replace('-', "_"));
    }
}
