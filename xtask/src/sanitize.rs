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

/// A sanitizer: its name for Rust, gcc's options with the library as released and with an instrumented one, and what else is set.
struct Sanitizer {
    rust: &'static str,
    c: &'static str,
    with_rust: &'static str,
    /// The library that is linked with an instrumented one: gcc's own lacks functions that Rust calls.
    runtime: &'static str,
    environment: (&'static str, &'static str),
}

const ADDRESS: Sanitizer = Sanitizer {
    rust: "address",
    c: "-fsanitize=address,undefined",
    with_rust: "-fsanitize=address",
    runtime: "librustc-nightly_rt.asan.a",
    environment: ("ASAN_OPTIONS", "detect_stack_use_after_return=1:strict_string_checks=1"),
};
const THREAD: Sanitizer = Sanitizer {
    rust: "thread",
    c: "-fsanitize=thread",
    with_rust: "-fsanitize=thread",
    runtime: "librustc-nightly_rt.tsan.a",
    environment: ("TSAN_OPTIONS", "halt_on_error=1"),
};

/// A form of the library.
enum Library {
    Released(PathBuf),
    /// With the folder of the nightly compiler's libraries.
    Instrumented(PathBuf, PathBuf),
}

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
        let mut libraries = vec![("as released", Library::Released(plain.clone()))];
        if let Some(sysroot) = nightly() {
            let runtimes = sysroot.join("lib/rustlib").join(TARGET).join("lib");
            libraries.push(("instrumented", Library::Instrumented(instrumented(sanitizer)?, runtimes)));
        } else {
            println!("no nightly compiler with rust-src: the library itself is not instrumented");
        }
        for (form, library) in &libraries {
            for file in files {
                println!("{} {}, library {form}", sanitizer.c, shell::short(file));
                program(file, sanitizer, library)?;
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

/// The folder of a nightly compiler with the source of `core`, which the library needs instrumented too.
fn nightly() -> Option<PathBuf> {
    let mut rustc = shell::program("rustc");
    rustc.env_remove("RUSTUP_TOOLCHAIN").args(["+nightly", "--print", "sysroot"]).stderr(Stdio::null());
    let output = rustc.output().ok().filter(|output| output.status.success())?;
    let path = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim());
    let complete = path.join("lib/rustlib/src/rust/library/core").is_dir();
    (complete && cfg!(all(target_arch = "x86_64", target_os = "linux"))).then_some(path)
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
fn program(file: &Path, sanitizer: &Sanitizer, library: &Library) -> Result<()> {
    let image = shell::scratch("sanitize")?.join(file.file_stem().context("no name")?);
    let object = image.with_extension("o");
    let source = shell::read(file)?;
    let is_c = file.extension().is_some_and(|ending| ending == "c");
    let (name, standard) = if is_c { ("gcc", "-std=gnu11") } else { ("g++", "-std=c++17") };
    let option = match library {
        Library::Released(_) => sanitizer.c,
        Library::Instrumented(..) => sanitizer.with_rust,
    };
    let openmp = if source.contains("<omp.h>") { &["-fopenmp"][..] } else { &[] };
    let mut compiler = shell::program(name);
    compiler.args([standard, "-O1", "-g", "-fno-omit-frame-pointer", "-fno-sanitize-recover=all", "-Iinclude", option]);
    shell::run(compiler.args(openmp).arg("-c").arg(file).arg("-o").arg(&object))?;
    let mut linker = shell::program(name);
    linker.args(openmp).arg(&object);
    match library {
        Library::Released(archive) => linker.arg(option).arg(archive),
        Library::Instrumented(archive, runtimes) => {
            linker.arg(archive).arg("-rdynamic").arg("-Wl,--whole-archive").arg(runtimes.join(sanitizer.runtime));
            linker.args(["-Wl,--no-whole-archive", "-ldl", "-lrt"])
        }
    };
    shell::run(linker.args(["-lm", "-pthread", "-o"]).arg(&image))?;
    let mut command = shell::program(image);
    let (name, value) = sanitizer.environment;
    command.env(name, value).env("UBSAN_OPTIONS", "print_stacktrace=1").stdout(Stdio::null());
    let arguments = file.with_extension("test");
    if arguments.exists() {
        command.args(shell::read(&arguments)?.split_whitespace());
    }
    shell::run(&mut command)
}
