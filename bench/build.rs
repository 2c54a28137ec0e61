//! Builds the peers: the sums as a competent user writes them in C, with the flags such a user gives.

fn main() {
    println!("cargo::rerun-if-changed=peers");
    cc::Build::new()
        .file("peers/direct.c")
        .opt_level(3)
        .flag("-march=native")
        .flag("-ffast-math")
        .flag("-std=c11")
        .warnings(true)
        .compile("peers");
    println!("cargo::rustc-link-lib=m");
}
