//! Compiles the programs of `examples_c/` and the header itself with strict warnings, and runs the programs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::{shell, symbols, tools};

/// Compiler flags for C programs.
const C: &[&str] = &["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-g"];
/// Compiler flags for C++ programs that use the C header.
const CPP: &[&str] = &["-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-g"];
/// Compiler flags, besides the standard, for C++ programs that use mollis.hpp.
const HPP: &[&str] = &["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Werror", "-O1", "-g"];
/// The same for clang: all warnings but those about C++98, padding, a virtual function in a header, and comparisons of floating-point numbers.
const HPP_CLANG: &[&str] = &[
    "-Weverything",
    "-Wno-c++98-compat",
    "-Wno-c++98-compat-pedantic",
    "-Wno-padded",
    "-Wno-weak-vtables",
    "-Wno-float-equal",
    "-Werror",
    "-O1",
];
/// Compilers and flags with which the test of mollis.hpp must compile without warnings and pass.
const HPP_FORMS: &[(&str, &[&str], &[&str])] = &[
    ("g++", HPP, &["-std=c++23"]),
    ("g++", HPP, &["-std=c++17", "-fno-exceptions", "-fno-rtti"]),
    ("g++", HPP, &["-std=c++17", "-fsanitize=address,undefined", "-fno-sanitize-recover"]),
    ("clang++", HPP_CLANG, &["-std=c++20"]),
];
/// Compiler flags for Fortran programs.
const FORTRAN: &[&str] =
    &["-std=f2018", "-Wall", "-Wextra", "-Werror", "-O2", "-g", "-ffpe-trap=invalid,zero,overflow"];
/// The same for flang, which has no traps, and under `-std=f2018` refuses optional arguments of C functions as not portable.
const FLANG: &[&str] = &["-Werror", "-O2", "-g"];
/// What flang is called by Debian and by LLVM.
const FLANG_NAMES: [&str; 3] = ["flang-new-19", "flang-new", "flang"];

/// Standards and compilers with which the header alone must compile without warnings.
const HEADER: &[(&str, &str, &str)] =
    &[("gcc", "c", "-std=c99"), ("gcc", "c", "-std=c11"), ("g++", "c++", "-std=c++11"), ("g++", "c++", "-std=c++20")];

/// Builds the library and one program, and runs it.
pub fn run(name: &str, arguments: &[String]) -> Result<()> {
    let folder = symbols::build()?;
    let file = ["c", "cpp", "f90"].iter().map(|ending| shell::root().join(format!("examples_c/{name}.{ending}")));
    let file = file.into_iter().find(|path| path.exists()).with_context(|| format!("no examples_c/{name}.*"))?;
    let image = compile(&file, &folder, &shell::scratch("examples")?)?;
    shell::run(shell::program(image).args(arguments))
}

/// Compiles the header alone, as C and C++, and the README's programs.
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
    let folder = symbols::build()?;
    readme(&folder)?;
    Ok(HEADER.len() + 1 + templates(&folder)?)
}

/// The first block of code in this language on a page.
fn block(page: &str, language: &str) -> Result<String> {
    let text = shell::read(&shell::root().join(page))?;
    let (_, after) =
        text.split_once(&format!("```{language}\n")).with_context(|| format!("{page} holds no {language}"))?;
    Ok(after.split_once("```").with_context(|| format!("{page}: a block has no end"))?.0.to_owned())
}

/// Compiles the README's programs in C, C++, Fortran and Rust and compares what they print with what it says.
fn readme(folder: &Path) -> Result<()> {
    let scratch = shell::scratch("examples")?;
    for (language, ending) in [("c", "c"), ("cpp", "cpp"), ("fortran", "f90"), ("rust", "rs")] {
        let file = scratch.join("readme").with_extension(ending);
        std::fs::write(&file, block("README.md", language)?)?;
        let image = if ending == "rs" { rust(&file)? } else { compile(&file, folder, &scratch)? };
        let printed = shell::output(&mut shell::program(image))?;
        ensure!(printed == "0.159155\n", "the README's program in {language} prints {printed}");
    }
    Ok(())
}

/// Compiles a program in Rust, with core as cargo has built it.
fn rust(file: &Path) -> Result<PathBuf> {
    let (core, image) = (symbols::release()?, file.with_extension("rust"));
    let mut rustc = shell::program(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.args(["--edition=2024", "-Copt-level=3", "-Cpanic=abort", "--extern"]);
    rustc.arg(format!("mollis_core={}", core.display())).arg("-L").arg(core.with_file_name("deps"));
    shell::run(rustc.arg(file).arg("-o").arg(&image))?;
    Ok(image)
}

/// Compiles the test of mollis.hpp in every form and runs it, and the program of its page.
fn templates(folder: &Path) -> Result<usize> {
    tools::need(&[("g++", "g++"), ("clang++", "clang")])?;
    let scratch = shell::scratch("examples")?;
    let page = scratch.join("page.cpp");
    std::fs::write(&page, block("docs/cpp.md", "cpp")?)?;
    let tests = shell::files("tests/languages", &["cpp"])?;
    for &(compiler, flags, form) in HPP_FORMS {
        for (name, files) in [("test", tests.as_slice()), ("page", std::slice::from_ref(&page))] {
            // The page's program catches an error.
            if name == "page" && form.contains(&"-fno-exceptions") {
                continue;
            }
            let image = scratch.join(format!("hpp_{name}"));
            let mut command = shell::program(compiler);
            command.args(flags).args(form).arg("-Iinclude").args(files).arg(folder.join("libmollis.a"));
            shell::run(command.args(["-lm", "-o"]).arg(&image))?;
            println!("mollis.hpp, {name}: {compiler} {}", form.join(" "));
            shell::run(&mut shell::program(image))?;
        }
    }
    Ok(HPP_FORMS.len() + 1)
}

/// Compiles every program and runs it with the arguments in `examples_c/NAME.test`, under valgrind on request. Programs of one name in several languages
/// have to print the same. Those of MPI are run by [`on_ranks`].
pub fn all(valgrind: bool) -> Result<usize> {
    tools::need(&[("gcc", "gcc")])?;
    if valgrind {
        tools::need(&[("valgrind", "valgrind")])?;
    }
    let folder = symbols::build()?;
    let scratch = shell::scratch(if valgrind { "valgrind" } else { "examples" })?;
    let mut files = shell::files("examples_c", if valgrind { &["c"] } else { &["c", "cpp", "f90"] })?;
    // Programs of MPI are left out under valgrind, which reports much that MPI's own libraries do.
    files.retain(|file| !(valgrind && is_mpi(file)));
    ensure!(!files.is_empty(), "examples_c holds no program");
    if !valgrind {
        files.extend(shell::files("tests/languages", &["f90"])?);
    }
    let mut printed = BTreeMap::new();
    for file in &files {
        let image = compile(file, &folder, &scratch)?;
        if is_mpi(file) {
            on_ranks(file, &image)?;
            continue;
        }
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
        let (succeeded, text) = shell::tee(&mut command)?;
        ensure!(succeeded, "{} failed", shell::short(file));
        agree(&mut printed, file, text)?;
    }
    let again = if valgrind { 0 } else { by_flang(&files, &folder, &scratch, &mut printed)? };
    Ok(files.len() + again)
}

/// Compiles the Fortran programs with flang as well, if it is installed. They have to print what the others of their name do.
fn by_flang(files: &[PathBuf], folder: &Path, scratch: &Path, printed: &mut Printed) -> Result<usize> {
    let Some(compiler) = FLANG_NAMES.into_iter().find(|name| tools::found(name)) else {
        println!("Fortran by flang: NOT RUN, it is not installed");
        return Ok(0);
    };
    let mut count = 0;
    for file in files.iter().filter(|file| is_fortran(file)) {
        let mut command = shell::program(compiler);
        command.args(FLANG);
        let image = link(command, file, folder, scratch)?;
        println!("{}, {compiler}", shell::short(file));
        let (succeeded, text) = shell::tee(&mut shell::program(image))?;
        ensure!(succeeded, "{} failed", shell::short(file));
        agree(printed, file, text)?;
        count += 1;
    }
    Ok(count)
}

fn is_fortran(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "f90")
}

/// Whether a program is for several processes that exchange messages: `mpi_NAME.c`.
pub fn is_mpi(file: &Path) -> bool {
    file.file_stem().is_some_and(|name| name.to_string_lossy().starts_with("mpi_"))
}

/// Runs a program of MPI on 1, 2 and 4 ranks for each line of `examples_c/NAME.test`, `ARGUMENTS # TOLERANCE # WORD`: the lines that it prints have to be the same, up
/// to the tolerance in numbers, and hold the word.
fn on_ranks(file: &Path, image: &Path) -> Result<()> {
    tools::need(&[("mpirun", "openmpi-bin")])?;
    let tests = shell::read(&file.with_extension("test"))?;
    for test in tests.lines() {
        let parts: Vec<&str> = test.split('#').map(str::trim).collect();
        let [arguments, tolerance, word] = parts[..] else { bail!("{}: {test}", shell::short(file)) };
        let tolerance: f64 = tolerance.parse().context("not a tolerance")?;
        let mut one = None;
        for ranks in ["1", "2", "4"] {
            println!("{}, {arguments}, {ranks} ranks", shell::short(file));
            let mut command = shell::program("mpirun");
            command.args(["--allow-run-as-root", "--oversubscribe", "-n", ranks]).arg(image);
            let (succeeded, text) = shell::tee(command.args(arguments.split_whitespace()))?;
            ensure!(succeeded, "{} failed on {ranks} ranks", shell::short(file));
            ensure!(text.contains(word), "{} does not print `{word}` on {ranks} ranks", shell::short(file));
            let one = one.get_or_insert_with(|| text.clone());
            ensure!(is_near(one, &text, tolerance), "{}: {ranks} ranks differ from 1 rank", shell::short(file));
        }
    }
    Ok(())
}

/// Whether two texts are the same but for numbers that differ by at most the tolerance, relative to those above 1.
fn is_near(one: &str, other: &str, tolerance: f64) -> bool {
    let same = |(a, b): (&str, &str)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(x), Ok(y)) if tolerance > 0.0 => (x - y).abs() <= tolerance * x.abs().max(1.0),
        _ => a == b,
    };
    let (one, other): (Vec<&str>, Vec<&str>) = (one.split_whitespace().collect(), other.split_whitespace().collect());
    one.len() == other.len() && one.into_iter().zip(other).all(same)
}

/// What the first program of a name printed, and which one that is.
type Printed = BTreeMap<PathBuf, (PathBuf, String)>;

/// Notes what a program printed. It must be what the program of the same name in another language printed.
fn agree(printed: &mut Printed, file: &Path, text: String) -> Result<()> {
    let (first, wanted) = printed.entry(file.with_extension("")).or_insert_with(|| (file.into(), text.clone()));
    ensure!(*wanted == text, "{} and {} print different lines", shell::short(first), shell::short(file));
    Ok(())
}

fn compile(file: &Path, folder: &Path, scratch: &Path) -> Result<PathBuf> {
    let (compiler, package, flags) = match file.extension().and_then(|e| e.to_str()) {
        Some("c") if is_mpi(file) => ("mpicc", "libopenmpi-dev", C),
        Some("c") => ("gcc", "gcc", C),
        Some("cpp") => ("g++", "g++", CPP),
        _ => ("gfortran", "gfortran", FORTRAN),
    };
    // `cc` replaces a missing gcc.
    let compiler = if compiler == "gcc" && !tools::found("gcc") && tools::found("cc") { "cc" } else { compiler };
    tools::need(&[(compiler, package)])?;
    let mut command = shell::program(compiler);
    let source = shell::read(file)?;
    if source.contains("mollis.hpp") {
        command.arg("-std=c++17").args(HPP);
    } else {
        command.args(flags);
    }
    if source.contains("<omp.h>") {
        command.arg("-fopenmp");
    }
    link(command, file, folder, scratch)
}

/// Compiles a program, by a compiler with its flags, and links it with the library in `folder`. The program lies in `scratch`.
fn link(mut command: Command, file: &Path, folder: &Path, scratch: &Path) -> Result<PathBuf> {
    let image = scratch.join(file.file_stem().context("no name")?);
    command.arg("-Iinclude");
    if is_fortran(file) {
        command.arg("-J").arg(scratch).arg("include/mollis.f90");
    }
    command.arg(file).arg(folder.join("libmollis.a")).args(["-lm", "-o"]).arg(&image);
    shell::run(&mut command)?;
    Ok(image)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use super::{agree, is_near};

    #[test]
    fn programs_of_one_name_agree() {
        let mut printed = BTreeMap::new();
        let mut check = |file: &str, text: &str| agree(&mut printed, Path::new(file), text.into()).is_ok();
        assert!(check("a.c", "1\n") && check("b.c", "2\n") && check("a.cpp", "1\n"));
        assert!(!check("a.f90", "2\n"));
    }

    #[test]
    fn texts_that_are_near() {
        assert!(is_near("t 0.5 x 1e-9", "t 0.5 x 2e-9", 1e-6));
        assert!(is_near("2000.001", "2000", 1e-6));
        for other in ["t 0.5 x 1e-5", "t 0.5 y 1e-9", "t 0.5 x", "t 0.5 x NaN"] {
            assert!(!is_near("t 0.5 x 1e-9", other, 1e-6), "{other}");
        }
        assert!(!is_near("1e-9", "1.0e-9", 0.0));
    }
}
