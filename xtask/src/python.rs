//! Builds the Python package of `python/` as a user does, runs its tests against the installed wheel, and looks at its source distribution.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context, Result, ensure};

use crate::{install, shell, tools};

/// Libraries that the shared library in the wheel may need: the C library's.
const ALLOWED: [&str; 4] = ["libc.so", "libm.so", "libpthread.so", "ld-linux"];

/// The suite. Returns the number of tests that passed, and of other facts that were checked.
pub fn check() -> Result<usize> {
    tools::need(&[("python3", "python3"), ("readelf", "binutils")])?;
    let folder = shell::scratch("python")?.canonicalize()?;
    let environment = environment(&folder, &["numpy", "cffi", "pytest", "setuptools>=77"])?;
    let wheel = wheel(&environment, &folder.join("wheel"))?;
    let name = wheel.file_name().context("no name")?.to_string_lossy().into_owned();
    ensure!(
        name.contains("-py3-none-") && !name.ends_with("-any.whl"),
        "{name} is not a wheel for any Python 3 of this platform"
    );
    shell::run(pip(&environment, &["install", "--force-reinstall", "--no-deps"]).arg(&wheel))?;
    // Nothing of the build is on the path, neither is the checkout.
    let mut python = shell::program(environment.join("bin/python"));
    python.current_dir(&folder).env_clear().env("PATH", "").args(["-I", "-c", IMPORT]);
    let package = PathBuf::from(shell::output(&mut python)?.trim());
    ensure!(package.starts_with(&environment), "{} was imported", package.display());
    for needed in install::dynamic(&package.with_file_name("libmollis_mt.so"), "NEEDED")? {
        ensure!(ALLOWED.iter().any(|name| needed.starts_with(name)), "the library in the wheel needs {needed}");
    }
    if cfg!(all(target_os = "linux", target_env = "gnu")) {
        ensure!(name.contains("-manylinux_2_"), "{name} does not say which glibc it needs");
    }
    source_distribution(&environment, &folder.join("source"))?;
    Ok(5 + tests(&environment)?)
}

/// A program that uses the package and prints where it lies.
const IMPORT: &str = "import mollis
kernel = mollis.Kernel(mollis.kernels.newtonian(), mollis.mollifiers.plummer(), 0.1)
assert mollis.field(kernel, [[0.0, 0.0], [1.0, 0.0]], 1.0, gradient=True).gradient[1, 0] > 0.1
print(mollis.__file__)";

/// A virtual environment with some packages, from the package index that pip is configured with.
pub fn environment(folder: &Path, packages: &[&str]) -> Result<PathBuf> {
    let environment = folder.join("environment");
    if !environment.join("bin/pip").exists() {
        // Debian has the module that puts pip into an environment in a package of its own.
        let mut python = shell::program("python3");
        python.args(["-c", "import sysconfig; print(sysconfig.get_path('stdlib'))"]);
        let ensurepip = format!("{}/ensurepip/__init__.py", shell::output(&mut python)?.trim());
        tools::need(&[(&ensurepip, "python3-venv")])?;
        shell::run(shell::program("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
    }
    shell::run(pip(&environment, &["install"]).args(packages))?;
    Ok(environment)
}

/// Builds the wheel, by the cargo command that suite `install` uses.
fn wheel(environment: &Path, folder: &Path) -> Result<PathBuf> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    shell::run(pip(environment, &["wheel", "--no-deps", "--wheel-dir"]).arg(folder).arg(shell::root().join("python")))?;
    let mut found = fs::read_dir(folder)?;
    let wheel = found.next().context("no wheel was built")??.path();
    ensure!(found.next().is_none(), "{} holds several wheels", folder.display());
    Ok(wheel)
}

/// Builds the source distribution, and checks that cargo finds there what the library is made of. (To build that would take two minutes.)
fn source_distribution(environment: &Path, folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    let mut python = shell::program(environment.join("bin/python"));
    python.current_dir(shell::root().join("python")).args(["-c", SOURCE]).arg(folder);
    let printed = shell::output(&mut python)?;
    let name =
        printed.lines().last().and_then(|line| line.strip_suffix(".tar.gz")).context("no source distribution")?;
    shell::run(shell::program("tar").arg("xzf").arg(folder.join(format!("{name}.tar.gz"))).arg("-C").arg(folder))?;
    let manifest = folder.join(name).join("library/Cargo.toml");
    let mut cargo = shell::cargo();
    cargo.args(["tree", "--quiet", "--package", "mollis-mt", "--manifest-path"]).arg(manifest);
    shell::run(cargo.stdout(Stdio::null()))
}

/// Builds the source distribution as pip and build do; the file's name is the last line.
const SOURCE: &str = "import sys
from setuptools import build_meta
print(build_meta.build_sdist(sys.argv[1]))";

fn pip(environment: &Path, arguments: &[&str]) -> std::process::Command {
    let mut pip = shell::program(environment.join("bin/python"));
    pip.args(["-m", "pip", "--disable-pip-version-check", "--quiet"]).args(arguments);
    pip
}

/// Runs pytest and returns how many tests passed. None may fail or be skipped.
fn tests(environment: &Path) -> Result<usize> {
    let mut pytest = shell::program(environment.join("bin/pytest"));
    pytest.args(["-p", "no:cacheprovider", "--rootdir=python", "--config-file=python/pyproject.toml", "python/tests"]);
    let (succeeded, text) = shell::tee(pytest.env("PYTHONDONTWRITEBYTECODE", "1"))?;
    let last = text.lines().last().unwrap_or_default();
    // "139 passed in 10.55s".
    let passed = last.split_once(" passed in ").and_then(|(number, _)| number.parse().ok());
    let passed = passed.filter(|_| succeeded);
    passed.with_context(|| format!("pytest: {last}"))
}
