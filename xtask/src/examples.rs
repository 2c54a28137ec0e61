//! Compiles the programs of `examples_c/` and the header itself with strict warnings, and runs the programs.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::{shell, symbols, tools};

/// Compiler flags for C programs.
const C: &[&str] = &["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-g"];
/// Compiler flags for C++ programs.
const CPP: &[&str] = &["-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-g"];
/// Compiler flags for Fortran programs.
const FORTRAN: &[&str] = &["-std=f2018", "-Wall", "-Wextra", "-Werror", "-O2", "-g"];

/// Standards and compilers with which the header alone must compile without warnings.
const HEADER: &[(&str, &str, &str)] =
    &[("gcc", "c", "-std=c99"), ("gcc", "c", "-std=c11"), ("g++", "c++", "-std=c++11"), ("g++", "c++", "-std=c++20")];

/// Builds the library and one program, and runs it.
pub fn run(name: &str, arguments: &[String]) -> Result<()> {
    let folder = symbols::build()?;
    let file = ["c", "cpp", "f90"].iter().map(|ending| shell::root().join(format!("examples_c/{name}.{ending}")));
    let file = file.into_iter().find(|path| path.exists()).with_context(|| format!("no examples_c/{name}.*"))?;
    let image = compile(&file, &folder)?;
    shell::run(shell::program(image).args(arguments))
}

/// Compiles the header alone, as C and C++, and the README's program.
pub fn header() -> Result<usize> {
    tools::need(&[("gcc", "gcc"), ("g++", "g++")])?;
    let file = shell::scratch("examples")?.join("header.c");
    std::fs::write(
        &file,
        "#include \"mollis.h\"\nint only_the_header(void);\nint only_the_header(void) { return MOLLIS_OK; }\n",
    )?;
    for &(compiler, language, standard) in HEADER {
        let mut command = shell::program(compiler);
        command.args([
            "-x",
            language,
            standard,
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-fsyntax-only",
            "-Iinclude",
        ]);
        shell::run(command.arg(&file))?;
    }
    readme()?;
    Ok(HEADER.len() + 1)
}

/// Compiles the README's program in C.
fn readme() -> Result<()> {
    let text = shell::read(&shell::root().join("README.md"))?;
    let (_, after) = text.split_once("```c\n").context("README.md holds no program in C")?;
    let (program, _) = after.split_once("```").context("README.md: a block has no end")?;
    let file = shell::scratch("examples")?.join("readme.c");
    std::fs::write(&file, program)?;
    let mut gcc = shell::program("gcc");
    gcc.args(["-std=c11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-Iinclude"]);
    shell::run(gcc.arg(&file))
}

/// Compiles every program and runs it with the arguments in `examples_c/NAME.test`, under valgrind on request.
pub fn all(valgrind: bool) -> Result<usize> {
    tools::need(&[("gcc", "gcc")])?;
    if valgrind {
        tools::need(&[("valgrind", "valgrind")])?;
    }
    let folder = symbols::build()?;
    let files = shell::files("examples_c", if valgrind { &["c"] } else { &["c", "cpp", "f90"] })?;
    ensure!(!files.is_empty(), "examples_c holds no program");
    for file in &files {
        let image = compile(file, &folder)?;
        let mut command = if valgrind {
            let mut command = shell::program("valgrind");
            command.args(["--quiet", "--error-exitcode=9", "--leak-check=full", "--show-leak-kinds=all"]);
            let known = file.with_extension("supp");
            if known.exists() {
                command.arg(format!("--suppressions={}", known.display()));
            }
            command.arg(image);
            command
        } else {
            shell::program(image)
        };
        // valgrind does not support AVX-512.
        let arguments = file.with_extension("test");
        if arguments.exists() {
            command.args(shell::read(&arguments)?.split_whitespace());
        }
        println!("{}", shell::short(file));
        shell::run(&mut command)?;
    }
    Ok(files.len())
}

fn compile(file: &Path, folder: &Path) -> Result<PathBuf> {
    let (compiler, package, flags) = match file.extension().and_then(|e| e.to_str()) {
        Some("c") => ("gcc", "gcc", C),
        Some("cpp") => ("g++", "g++", CPP),
        _ => ("gfortran", "gfortran", FORTRAN),
    };
    // `cc` replaces a missing gcc.
    let compiler = if compiler == "gcc" && !tools::found("gcc") && tools::found("cc") { "cc" } else { compiler };
    tools::need(&[(compiler, package)])?;
    let scratch = shell::scratch("examples")?;
    let image = scratch.join(file.file_stem().context("no name")?);
    let mut command = shell::program(compiler);
    command.args(flags).arg("-Iinclude");
    if shell::read(file)?.contains("<omp.h>") {
        command.arg("-fopenmp");
    }
    if compiler == "gfortran" {
        command.arg("-J").arg(&scratch).arg("include/mollis.f90");
    }
    command.arg(file).arg(folder.join("libmollis.a")).args(["-lm", "-o"]).arg(&image);
    shell::run(&mut command)?;
    Ok(image)
}
