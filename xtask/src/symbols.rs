//! Checks the symbols of the shared library, and of a C program that refers to every function of the static one.
//!
//! Both are linked without unreferenced sections, so a symbol that remains can be reached.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use crate::{header, shell, tools};

/// Functions that every C library must offer: compilers replace loops by calls of these.
const MEMORY: [&str; 5] = ["memcpy", "memmove", "memset", "memcmp", "bcmp"];
/// Weak symbols that the linker's own start files need.
const LINKER: [&str; 5] = [
    "_ITM_deregisterTMCloneTable",
    "_ITM_registerTMCloneTable",
    "__cxa_finalize",
    "__gmon_start__",
    "__libc_start_main",
];
/// Parts of names that belong to panics, unwinding, formatting or an allocator; and `core_arch`, an instruction that became a function, because a loop or a
/// closure was compiled without the instruction set.
const FORBIDDEN_PARTS: [&str; 15] = [
    "core_arch",
    "panic",
    "unwind",
    "Unwind",
    "eh_personality",
    "core::fmt",
    "4core3fmt",
    "unwrap_failed",
    "expect_failed",
    "slice_index_fail",
    "__rust_alloc",
    "__rust_dealloc",
    "alloc::",
    "5alloc",
    "printf",
];
/// C functions that allocate, end the program, read or write.
const FORBIDDEN: [&str; 18] = [
    "malloc",
    "calloc",
    "realloc",
    "free",
    "sbrk",
    "_sbrk",
    "abort",
    "exit",
    "__assert_fail",
    "write",
    "read",
    "open",
    "fwrite",
    "fputs",
    "puts",
    "putchar",
    "fopen",
    "signal",
];

/// Builds the library and returns its folder.
pub fn build() -> Result<PathBuf> {
    packages(&["mollis"])
}

/// Builds some of the libraries for release and returns their folder. Each is optimised as a whole, by one thread: two are built in the time of one.
pub fn packages(names: &[&str]) -> Result<PathBuf> {
    let mut cargo = shell::cargo();
    cargo.args(["build", "--quiet", "--profile", "library"]);
    names.iter().for_each(|name| {
        cargo.args(["--package", name]);
    });
    shell::run(&mut cargo)?;
    Ok(shell::target().join("library"))
}

/// Checks the shared library and a C program linked with the static one.
pub fn run() -> Result<()> {
    tools::need(&[("nm", "binutils"), ("gcc", "gcc")])?;
    // Suite `install` needs the other one.
    let folder = packages(&["mollis", "mollis-mt"])?;
    the_check_can_fail()?;
    let library = folder.join("libmollis.so");
    let functions = header::functions()?;
    let mut faults = exports(&library, &functions)?;
    faults.extend(check(&library)?);
    faults.extend(check(&program(&folder, &functions)?)?);
    faults.extend(instructions_as_functions(&library)?);
    faults.extend(instructions_as_functions(&release()?)?);
    if !faults.is_empty() {
        bail!("{}", faults.join("\n"));
    }
    println!("release build of core: no instruction is a function");
    println!(
        "libmollis.so ({} functions) and a C program with all of libmollis.a: only {} needed; no panic, unwinding, \
         allocator, formatting or I/O",
        functions.len(),
        MEMORY.join(", ")
    );
    Ok(())
}

/// Builds core as Rust programs link it and returns its archive.
pub fn release() -> Result<PathBuf> {
    shell::run(shell::cargo().args(["build", "--quiet", "--release", "--package", "mollis-core"]))?;
    Ok(shell::target().join("release/libmollis_core.rlib"))
}

/// Lists instructions that became functions, because what uses them (a loop, a closure) was compiled without the instruction set, which costs a factor of ten.
fn instructions_as_functions(image: &Path) -> Result<Vec<String>> {
    let listed = shell::output(shell::program("nm").args(["--demangle", "--format=bsd"]).arg(image))?;
    ensure!(listed.contains("mollis_core::simd"), "{} holds no function of core", shell::short(image));
    // Asking the processor for its features is no operation on lanes.
    let is_one = |name: &str| {
        name.contains("core_arch") && !name.contains("xgetbv") && !name.contains("cpuid")
            || name.contains("simd::avx") && name.contains("closure")
    };
    Ok(listed.lines().filter(|line| is_one(line)).map(|line| format!("{} holds {line}", shell::short(image))).collect())
}

/// Checks that the exported names are exactly those of the header.
pub fn exports(library: &Path, functions: &[String]) -> Result<Vec<String>> {
    let mut faults = Vec::new();
    let listed = shell::output(shell::program("nm").args(["-D", "--defined-only", "--format=posix"]).arg(library))?;
    let exported: Vec<&str> = listed.lines().filter_map(|line| line.split(' ').next()).collect();
    for name in &exported {
        if !functions.iter().any(|f| f == name) {
            faults.push(format!("{} exports {name}, which is not in the header", shell::short(library)));
        }
    }
    for name in functions.iter().filter(|f| !exported.contains(&f.as_str())) {
        faults.push(format!("{} lacks {name}", shell::short(library)));
    }
    Ok(faults)
}

/// Lists the forbidden symbols that a linked image needs or holds.
fn check(image: &Path) -> Result<Vec<String>> {
    let listed = shell::output(shell::program("nm").args(["--demangle", "--format=bsd"]).arg(image))?;
    let mut faults = Vec::new();
    let mut symbols = 0;
    for line in listed.lines() {
        // The format is "address type name"; the address is blank for an undefined symbol.
        let Some((kind, name)) = line.get(17..).and_then(|tail| tail.split_once(' ')) else { continue };
        symbols += 1;
        let plain = name.split('@').next().unwrap_or(name);
        let undefined = matches!(kind, "U" | "w" | "v");
        if undefined && !MEMORY.contains(&plain) && !LINKER.contains(&plain) {
            faults.push(format!("{} needs {name}", shell::short(image)));
        }
        // A name at address 0 is only defined to satisfy the linker (see `ffi`).
        let nothing = line.starts_with("0000000000000000 ") && !undefined;
        if forbidden(name) && !nothing {
            faults.push(format!("{} holds {name}", shell::short(image)));
        }
    }
    ensure!(symbols > 0, "{} has no symbol table", shell::short(image));
    Ok(faults)
}

/// Whether a symbol must not be linked.
pub fn forbidden(name: &str) -> bool {
    let plain = name.split('@').next().unwrap_or(name);
    FORBIDDEN.contains(&plain) || FORBIDDEN_PARTS.iter().any(|part| name.contains(part))
}

/// Builds a C program that takes the address of every function, linked with the static library.
fn program(folder: &Path, functions: &[String]) -> Result<PathBuf> {
    let scratch = shell::scratch("symbols")?;
    let mut source =
        String::from("#include \"mollis.h\"\ntypedef void (*function)(void);\nfunction volatile all[] = {\n");
    for name in functions {
        writeln!(source, "  (function)&{name},")?;
    }
    source.push_str("  0};\nint main(void) { return all[0] == 0; }\n");
    let (file, image) = (scratch.join("all.c"), scratch.join("all"));
    std::fs::write(&file, source)?;
    let mut gcc = shell::program("gcc");
    gcc.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-Iinclude", "-Wl,--gc-sections", "-o"]);
    shell::run(gcc.arg(&image).arg(&file).arg(folder.join("libmollis.a")))?;
    shell::run(&mut shell::program(&image))?;
    Ok(image)
}

/// A library with a deliberate panic must be refused. This shows that the check can fail.
fn the_check_can_fail() -> Result<()> {
    let scratch = shell::scratch("symbols")?;
    let (file, image) = (scratch.join("planted.rs"), scratch.join("libplanted.so"));
    std::fs::write(&file, PLANTED)?;
    let mut rustc = shell::program(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.args(["--edition=2024", "--crate-type=cdylib", "-Copt-level=3", "-Cpanic=abort", "-Clto=fat", "-o"]);
    shell::run(rustc.arg(&image).arg(&file)).context("cannot build the control")?;
    let faults = check(&image)?;
    ensure!(faults.iter().any(|f| f.contains("panic")), "a planted panic was not found: {faults:?}");
    Ok(())
}

const PLANTED: &str = "#![no_std]
#[panic_handler]
fn handler(_: &core::panic::PanicInfo<'_>) -> ! { loop {} }
#[unsafe(no_mangle)]
pub extern \"C\" fn mollis_planted(index: usize) -> u8 { [1_u8, 2, 3][index] }
";

#[cfg(test)]
mod tests {
    #[test]
    fn names() {
        for bad in [
            "core::panicking::panic_fmt",
            "rust_eh_personality",
            "malloc",
            "<u8 as core::fmt::Display>::fmt",
            "vfprintf",
        ] {
            assert!(super::forbidden(bad), "{bad}");
        }
        for good in ["mollis_blob2_step", "memcpy", "mollis_core::field::Outputs::check"] {
            assert!(!super::forbidden(good), "{good}");
        }
    }
}
