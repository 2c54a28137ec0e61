//! Sets the SONAME, and links the compiler's unwinder, which std refers to, from its archive: the shared library then needs the C library alone.

use std::env::var;

#[path = "../soname.rs"]
mod soname;

fn main() {
    soname::main();
    let is = |name: &str, value: &str| var(format!("CARGO_CFG_TARGET_{name}")).is_ok_and(|found| found == value);
    if is("OS", "linux") && is("ENV", "gnu") {
        // Not copied into the archive and the rlib: programs have the compiler's own.
        println!("cargo:rustc-link-lib=static:-bundle=gcc_eh");
    }
}
