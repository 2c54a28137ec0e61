//! Builds the C programs that mollis is compared with, with the compiler flags that a user of such a program would give.

fn main() {
    println!("cargo::rerun-if-changed=peers");
    cc::Build::new()
        .file("peers/direct.c")
        .file("peers/codes.c")
        .opt_level(3)
        .flag("-march=native")
        .flag("-ffast-math")
        .flag("-std=c11")
        .warnings(true)
        .compile("peers");
    println!("cargo::rustc-link-lib=m");
}
