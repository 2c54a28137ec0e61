//! Programs in C and C++ under gcc's sanitizers and valgrind, and the library itself where a nightly compiler can instrument it.
//!
//! AddressSanitizer and UndefinedBehaviorSanitizer: every program of `examples_c/` (but those of MPI) and `tests/sanitize/`. ThreadSanitizer:
//! `tests/sanitize/`, whose threads are its own. Of the library two forms are linked: the one for release, in which only the functions of the C library that it
//! calls are watched, and one instrumented by `-Zsanitizer`, in which every load and store is.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context, Result, ensure};

use crate::{examples, fuzz, shell, symbols, tools};

const TARGET: &str = "x86_64-unknown-linux-gnu";

/// A sanitizer: its name for Rust, gcc's option, and what else is set.
struct Sanitizer {
    rust: &'static str,
    c: &'static str,
    environment: (&'static str, &'static str),
}

const ADDRESS: Sanitizer = Sanitizer {
    rust: "address",
    c: "-fsanitize=address,undefined",
    environment: ("ASAN_OPTIONS", "detect_stack_use_after_return=1:strict_string_checks=1"),
};
const THREAD: Sanitizer =
    Sanitizer { rust: "thread", c: "-fsanitize=thread", environment: ("TSAN_OPTIONS", "halt_on_error=1") };

/// Runs all of it.
pub fn run() -> Result<()> {
    tools::need(&[("gcc", "gcc"), ("g++", "g++")])?;
    let plain = symbols::build()?.join("libmollis.a");
    let threads = shell::files("tests/sanitize", &["c"])?;
    let mut programs = shell::files("examples_c", &["c", "cpp"])?;
    programs.retain(|file| !examples::is_mpi(file));
    ensure!(!threads.is_empty() && !programs.is_empty(), "no program");
    programs.extend(threads.iter().cloned());
    let mut count = 0;
    for (sanitizer, files) in [(&ADDRESS, &programs), (&THREAD, &threads)] {
        let mut libraries = vec![("as released", plain.clone())];
        if instruments() {
            libraries.push(("instrumented", instrumented(sanitizer)?));
        } else {
            println!("no nightly compiler with rust-src: the library itself is not instrumented");
        }
        for (form, library) in libraries {
            for file in files {
                println!("{} {}, library {form}", sanitizer.c, shell::short(file));
                program(file, sanitizer, &library)?;
                count += 1;
            }
        }
    }
    if tools::found("valgrind") {
        count += examples::all(true)?;
    } else {
        println!("valgrind is not installed");
    }
    println!("{count} runs, no finding");
    Ok(())
}

/// Whether there is a nightly compiler with the source of `core`, which the library needs instrumented too.
fn instruments() -> bool {
    let mut rustc = shell::program("rustc");
    rustc.env_remove("RUSTUP_TOOLCHAIN").args(["+nightly", "--print", "sysroot"]).stderr(Stdio::null());
    let sysroot = rustc.output().ok().filter(|output| output.status.success());
    let sysroot = sysroot.and_then(|output| String::from_utf8(output.stdout).ok());
    cfg!(all(target_arch = "x86_64", target_os = "linux"))
        && sysroot.is_some_and(|path| Path::new(path.trim()).join("lib/rustlib/src/rust/library/core").is_dir())
}

/// The static library and `core` in it, instrumented.
fn instrumented(sanitizer: &Sanitizer) -> Result<PathBuf> {
    let folder = shell::target().join("sanitize").join(sanitizer.rust);
    let mut cargo =
        fuzz::nightly(&["build", "--quiet", "--release", "-p", "mollis", "-Zbuild-std=core", "--target", TARGET]);
    cargo.env("RUSTFLAGS", format!("-Zsanitizer={} -Cpanic=abort", sanitizer.rust));
    shell::run(cargo.arg("--target-dir").arg(&folder))?;
    Ok(folder.join(TARGET).join("release/libmollis.a"))
}

/// Compiles and runs a program. A finding ends it with another status than 0.
fn program(file: &Path, sanitizer: &Sanitizer, library: &Path) -> Result<()> {
    let image = shell::scratch("sanitize")?.join(file.file_stem().context("no name")?);
    let source = shell::read(file)?;
    let is_c = file.extension().is_some_and(|ending| ending == "c");
    let mut compiler = shell::program(if is_c { "gcc" } else { "g++" });
    compiler.arg(if is_c { "-std=gnu11" } else { "-std=c++17" });
    compiler.args(["-O1", "-g", "-fno-omit-frame-pointer", "-fno-sanitize-recover=all", "-Iinclude", sanitizer.c]);
    if source.contains("<omp.h>") {
        compiler.arg("-fopenmp");
    }
    compiler.arg(file).arg(library).args(["-lm", "-pthread", "-o"]).arg(&image);
    shell::run(&mut compiler)?;
    let mut command = shell::program(image);
    let (name, value) = sanitizer.environment;
    command.env(name, value).env("UBSAN_OPTIONS", "print_stacktrace=1").stdout(Stdio::null());
    let arguments = file.with_extension("test");
    if arguments.exists() {
        command.args(shell::read(&arguments)?.split_whitespace());
    }
    shell::run(&mut command)
}
