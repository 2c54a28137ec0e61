//! Installs as a package's maker does, and builds and runs the programs of `tests/installed/`, which know the prefix alone.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::{LIBRARIES, Library, VERSION, dynamic, series, soname};
use crate::{shell, symbols, tools};

/// The suite. Returns the number of programs that ran, and of other facts that were checked.
pub fn check() -> Result<usize> {
    tools::need(&[
        ("pkg-config", "pkg-config"),
        ("make", "make"),
        ("cmake", "cmake"),
        ("gcc", "gcc"),
        ("g++", "g++"),
        ("nm", "binutils"),
        ("readelf", "binutils"),
    ])?;
    let work = shell::scratch("install")?.canonicalize()?;
    fs::remove_dir_all(&work)?;
    let (stage, prefix) = (work.join("stage"), work.join("prefix"));
    let mut checks = staged(&stage, &prefix)?;
    // What makes a package moves the files to their place.
    let staged = stage.join(prefix.strip_prefix("/")?);
    fs::rename(staged, &prefix)?;
    fs::remove_dir_all(&stage)?;
    for library in &LIBRARIES {
        checks += symbols_and_links(library, &prefix.join("lib"))?;
        checks += beside_another(library, &prefix, &work)?;
    }
    checks += made(&prefix, &work, "pkg-config")?;
    // Files that were moved: CMake finds them, with a space in their path as well, pkg-config when it is told to.
    let (spaced, moved) = (work.join("with space"), work.join("moved"));
    fs::rename(&prefix, &spaced)?;
    checks += cmade(&spaced, &work)?;
    checks += within(&work)?;
    fs::rename(&spaced, &moved)?;
    checks += made(&moved, &work, "pkg-config --define-prefix")?;
    fs::rename(&moved, &prefix)?;
    Ok(checks + repeated(&prefix)?)
}

/// Runs this program's command with the umask 077, so that a mode that is not set explicitly shows.
fn xtask(command: &str, prefix: &Path, destdir: Option<&Path>) -> Result<()> {
    let mut shell = shell::program("sh");
    shell.args(["-c", "umask 077 && exec \"$0\" \"$@\""]).arg(std::env::current_exe()?).arg(command).arg(prefix);
    shell::run(match destdir {
        Some(folder) => shell.env("DESTDIR", folder),
        None => shell.env_remove("DESTDIR"),
    })
}

/// Installs below DESTDIR. No file may name it, none may be written elsewhere, and everybody may read all. The removal leaves nothing.
fn staged(stage: &Path, prefix: &Path) -> Result<usize> {
    let inside = stage.join(prefix.strip_prefix("/")?);
    xtask("install", prefix, Some(stage))?;
    let installed = files(&inside)?;
    for header in ["mollis.h", "mollis.hpp", "mollis_mt.h", "mollis.f90"] {
        ensure!(installed.contains(&format!("include/{header}")), "{} holds no {header}", inside.display());
    }
    let parts = shell::read(&inside.join("share/mollis/sbom.cdx.json"))?;
    for (name, is_there) in
        [("mollis-core", true), ("libm", true), ("rayon-core", true), ("cbindgen", false), ("nalgebra", false)]
    {
        ensure!(parts.contains(&format!("\"name\": \"{name}\"")) == is_there, "the list of parts, {name}:\n{parts}");
    }
    xtask("uninstall", prefix, Some(stage))?;
    ensure!(fs::read_dir(&inside)?.next().is_none(), "{} is not empty after uninstall", inside.display());
    xtask("install", prefix, Some(stage))?;
    ensure!(!prefix.exists(), "DESTDIR was not respected");
    let (place, mut texts) = (prefix.display().to_string(), 0);
    for path in files(&inside)? {
        let file = inside.join(&path);
        let mode = fs::symlink_metadata(&file)?.permissions().mode() & 0o7777;
        let program = path.ends_with(&format!(".so.{VERSION}"));
        ensure!(file.is_symlink() || mode == if program { 0o755 } else { 0o644 }, "{path} has mode {mode:o}");
        let folder = fs::metadata(file.parent().context("no folder")?)?.permissions().mode() & 0o7777;
        ensure!(folder == 0o755, "the folder of {path} has mode {folder:o}");
        if path.ends_with(".pc") || path.ends_with(".cmake") {
            let text = shell::read(&file)?;
            ensure!(!text.contains(&*stage.to_string_lossy()), "{path} names DESTDIR");
            ensure!(path.ends_with(".pc") == text.contains(&place), "{path}: only pkg-config's files name the prefix");
            texts += 1;
        }
    }
    ensure!(texts == LIBRARIES.len() + 2, "{texts} files for pkg-config and CMake");
    Ok(4)
}

/// Every file below a folder, relative to it.
fn files(folder: &Path) -> Result<BTreeSet<String>> {
    let (mut found, mut folders) = (BTreeSet::new(), vec![folder.to_path_buf()]);
    while let Some(inner) = folders.pop() {
        for entry in fs::read_dir(&inner).with_context(|| format!("cannot list {}", inner.display()))? {
            let path = entry?.path();
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            } else {
                found.insert(path.strip_prefix(folder)?.display().to_string());
            }
        }
    }
    Ok(found)
}

/// Both forms of the library show the functions of its headers and nothing else; the shared one has its names.
fn symbols_and_links(library: &Library, folder: &Path) -> Result<usize> {
    let (name, functions) = (library.name, library.functions()?);
    let shared = folder.join(format!("lib{name}.so"));
    let mut faults = symbols::exports(&shared, &functions)?;
    let archive = folder.join(format!("lib{name}.a"));
    let mut nm = shell::program("nm");
    let listed = shell::output(nm.args(["-g", "--defined-only", "--format=posix"]).arg(&archive))?;
    // A line without a space names a member.
    let shown: BTreeSet<_> = listed.lines().filter_map(|line| Some(line.split_once(' ')?.0)).collect();
    let wanted: BTreeSet<_> = functions.iter().map(String::as_str).collect();
    faults.extend(shown.symmetric_difference(&wanted).map(|other| format!("{}: {other}", archive.display())));
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    let expected = format!("lib{name}.so.{}", series(VERSION));
    ensure!(soname(&shared)? == expected, "{} calls itself {}", shared.display(), soname(&shared)?);
    ensure!(fs::read_link(&shared)?.as_os_str() == expected.as_str(), "{} is no link", shared.display());
    let whole = format!("lib{name}.so.{VERSION}");
    ensure!(fs::read_link(folder.join(&expected))?.as_os_str() == whole.as_str(), "{expected} is no link");
    Ok(3)
}

/// Links all of the archive beside all of another Rust library.
fn beside_another(library: &Library, prefix: &Path, work: &Path) -> Result<usize> {
    let source = shell::root().join("tests/installed");
    let second = work.join("libsecond.a");
    let mut rustc = shell::program(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.args(["--edition=2024", "--crate-type=staticlib", "-Cpanic=abort", "-o"]);
    shell::run(rustc.arg(&second).arg(source.join("second.rs")))?;
    let image = work.join(format!("beside_{}", library.name));
    let mut gcc = shell::program("gcc");
    gcc.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"])
        .arg(prefix.join("include"))
        .arg(source.join("beside.c"));
    gcc.arg("-Wl,--whole-archive").arg(prefix.join(format!("lib/lib{}.a", library.name))).arg(&second);
    shell::run(gcc.args(["-Wl,--no-whole-archive", "-lpthread", "-ldl", "-lm", "-o"]).arg(&image))?;
    shell::run(&mut shell::program(&image))?;
    Ok(1)
}

/// A fresh folder with the programs' sources.
fn consumer(work: &Path, name: &str) -> Result<PathBuf> {
    let folder = work.join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir(&folder)?;
    for file in ["total.c", "total.cpp", "Makefile", "CMakeLists.txt"] {
        fs::copy(shell::root().join("tests/installed").join(file), folder.join(file))?;
    }
    Ok(folder)
}

/// Builds with make and pkg-config and runs: shared (in C and C++), the archive, and wholly static.
fn made(prefix: &Path, work: &Path, tool: &str) -> Result<usize> {
    let folder = consumer(work, "make")?;
    let mut make = shell::program("make");
    make.arg("--directory").arg(&folder).arg(format!("PKG_CONFIG_PATH={}", prefix.join("lib/pkgconfig").display()));
    shell::run(make.arg(format!("PKG_CONFIG={tool}")).arg("--silent"))?;
    for Library { name, .. } in &LIBRARIES {
        for form in ["shared", "archive", "static", "cpp"] {
            let library = ["shared", "cpp"].contains(&form).then_some(*name);
            ran(&folder.join(format!("{name}_{form}")), library, Some(&prefix.join("lib")))?;
        }
    }
    Ok(4 * LIBRARIES.len())
}

/// Builds with CMake and runs. CMake notes in the programs where the libraries are.
fn cmade(prefix: &Path, work: &Path) -> Result<usize> {
    let folder = consumer(work, "cmake")?;
    let build = folder.join("build");
    let mut configure = shell::program("cmake");
    configure.arg("-S").arg(&folder).arg("-B").arg(&build).arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
    shell::output(configure.arg(format!("-DWANTED={}", series(VERSION))))?;
    shell::output(shell::program("cmake").arg("--build").arg(&build))?;
    let targets = [
        ("mollis", Some("mollis")),
        ("static", None),
        ("mt", Some("mollis_mt")),
        ("mt_static", None),
        ("cpp", Some("mollis_mt")),
    ];
    for (target, library) in targets {
        ran(&build.join(target), library, None)?;
    }
    Ok(targets.len())
}

/// Builds within a CMake project and runs: there is no installation.
fn within(work: &Path) -> Result<usize> {
    let build = work.join("subdirectory");
    if build.exists() {
        fs::remove_dir_all(&build)?;
    }
    let mut configure = shell::program("cmake");
    configure.arg("-S").arg(shell::root().join("tests/installed/subdirectory")).arg("-B").arg(&build);
    shell::output(configure.arg(format!("-DMOLLIS={}", shell::root().display())))?;
    shell::output(shell::program("cmake").arg("--build").arg(&build))?;
    let targets = [("static", None), ("cpp", Some("mollis_mt"))];
    for (target, library) in targets {
        ran(&build.join(target), library, None)?;
    }
    Ok(targets.len())
}

/// Runs a program that needs this shared library of ours, or none. It looks for the library in `folder`, or knows where.
fn ran(image: &Path, library: Option<&str>, folder: Option<&Path>) -> Result<()> {
    let ours: Vec<_> = dynamic(image, "NEEDED")?.into_iter().filter(|name| name.contains("mollis")).collect();
    let wanted: Vec<_> = library.iter().map(|name| format!("lib{name}.so.{}", series(VERSION))).collect();
    ensure!(ours == wanted, "{} needs {ours:?}, not {wanted:?}", image.display());
    let mut program = shell::program(image);
    shell::run(match folder {
        Some(folder) => program.env("LD_LIBRARY_PATH", folder),
        None => program.env_remove("LD_LIBRARY_PATH"),
    })
}

/// Installs over what is there, removes, and finds exactly what others have put below the prefix.
fn repeated(prefix: &Path) -> Result<usize> {
    let before = files(prefix)?;
    for other in ["lib/libother.so", "share/other/file"] {
        fs::create_dir_all(prefix.join(other).parent().context("no folder")?)?;
        fs::write(prefix.join(other), "")?;
    }
    xtask("install", prefix, None)?;
    let installed = files(prefix)?;
    ensure!(before.iter().all(|file| installed.contains(file)) && installed.len() == before.len() + 2, "{installed:?}");
    xtask("uninstall", prefix, None)?;
    let left = files(prefix)?;
    ensure!(left.iter().eq(["lib/libother.so", "share/other/file"]), "left: {left:?}");
    ensure!(!prefix.join("include").exists() && !prefix.join("lib/cmake").exists(), "empty folders are left");
    Ok(2)
}
