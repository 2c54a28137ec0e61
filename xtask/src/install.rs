//! Installs the libraries, their headers and pkg-config files below a prefix.

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::{header, shell, symbols, text, tools};

/// A library to install.
struct Library {
    package: &'static str,
    name: &'static str,
    about: &'static str,
    /// Libraries that a program must link with the archive (`rustc --print native-static-libs`).
    private: &'static str,
}

const LIBRARIES: [Library; 2] = [
    Library {
        package: "mollis",
        name: "mollis",
        about: "Particles that interact through softened potentials",
        private: "-lm",
    },
    Library {
        package: "mollis-mt",
        name: "mollis_mt",
        about: "mollis with a pool of threads",
        private: "-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc",
    },
];

/// Builds for release and copies the files.
pub fn run(prefix: &Path) -> Result<()> {
    tools::need(&[("readelf", "binutils")])?;
    std::fs::create_dir_all(prefix).with_context(|| format!("cannot make {}", prefix.display()))?;
    let prefix = prefix.canonicalize()?;
    for header in shell::files("include", &["h", "hpp", "f90"])? {
        copy(&header, &prefix.join("include"), name_of(&header)?)?;
    }
    let (folder, version) = (prefix.join("lib"), env!("CARGO_PKG_VERSION"));
    let (place, template) = (prefix.display().to_string(), shell::read(&shell::root().join("ffi/mollis.pc.in"))?);
    for Library { package, name, about, private } in &LIBRARIES {
        let built = symbols::package(package)?;
        copy(&built.join(format!("lib{name}.a")), &folder, &format!("lib{name}.a"))?;
        // The file name has the full version. Programs load the library by its SONAME, linkers find it by the name without a version.
        let (shared, file) = (format!("lib{name}.so"), format!("lib{name}.so.{version}"));
        copy(&built.join(&shared), &folder, &file)?;
        let asked = soname(&folder.join(&file))?;
        link(&file, &folder.join(&asked))?;
        link(&asked, &folder.join(&shared))?;
        let filled = [
            ("@PREFIX@", place.as_str()),
            ("@NAME@", name),
            ("@ABOUT@", about),
            ("@VERSION@", version),
            ("@PRIVATE@", private),
        ];
        let filled = filled.iter().fold(template.clone(), |text, (mark, value)| text.replace(mark, value));
        std::fs::create_dir_all(folder.join("pkgconfig"))?;
        std::fs::write(folder.join(format!("pkgconfig/{name}.pc")), filled)?;
    }
    println!("installed below {}", prefix.display());
    Ok(())
}

fn name_of(file: &Path) -> Result<&str> {
    file.file_name().and_then(|name| name.to_str()).context("no name")
}

fn copy(file: &Path, folder: &Path, name: &str) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let to = folder.join(name);
    // A link from an earlier installation must not be followed.
    remove(&to)?;
    std::fs::copy(file, &to).with_context(|| format!("cannot copy to {}", to.display()))?;
    Ok(())
}

fn link(to: &str, at: &Path) -> Result<()> {
    remove(at)?;
    symlink(to, at).with_context(|| format!("cannot make {}", at.display()))
}

fn remove(file: &Path) -> Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot replace {}", file.display()))
        }
        _ => Ok(()),
    }
}

/// The entries of this kind, `SONAME` or `NEEDED`, in the dynamic section of an ELF file.
fn dynamic(file: &Path, kind: &str) -> Result<Vec<String>> {
    let listed = shell::output(shell::program("readelf").args(["--dynamic", "--wide"]).arg(file).env("LC_ALL", "C"))?;
    let names = listed.lines().filter(|line| line.contains(&format!("({kind})")));
    Ok(names.filter_map(|line| Some(line.split_once('[')?.1.split_once(']')?.0.to_owned())).collect())
}

/// The name by which programs load a shared library.
fn soname(library: &Path) -> Result<String> {
    let names = dynamic(library, "SONAME")?;
    names.into_iter().next().with_context(|| format!("{} has no SONAME", library.display()))
}

/// Installs below a scratch folder, then builds and runs programs with only the information that `pkg-config` gives.
pub fn check() -> Result<usize> {
    tools::need(&[("pkg-config", "pkg-config"), ("gcc", "gcc"), ("nm", "binutils")])?;
    let prefix = shell::scratch("install")?;
    run(&prefix)?;
    // Also over an existing installation.
    run(&prefix)?;
    let folder = prefix.join("lib").canonicalize()?;
    let functions = header::functions()?;
    let mut checks = 0;
    for Library { name, .. } in &LIBRARIES {
        let mut functions = functions.clone();
        if *name == "mollis_mt" {
            let header = text::code_only(&shell::read(&prefix.join("include/mollis_mt.h"))?);
            let words = text::identifiers(&header).map(|(_, word)| word);
            let own = words.filter(|word| word.starts_with("mollis_pool_")).map(str::to_owned);
            functions.extend(own.collect::<std::collections::BTreeSet<_>>());
        }
        let shared = folder.join(format!("lib{name}.so"));
        let faults = symbols::exports(&shared, &functions)?;
        ensure!(faults.is_empty(), "{}", faults.join("\n"));
        let expected = expected_soname(name, env!("CARGO_PKG_VERSION"));
        ensure!(soname(&shared)? == expected, "{} calls itself {}", shared.display(), soname(&shared)?);
        ensure!(std::fs::read_link(&shared)?.as_os_str() == expected.as_str(), "{} is no link", shared.display());
        let whole = format!("lib{name}.so.{}", env!("CARGO_PKG_VERSION"));
        ensure!(std::fs::read_link(folder.join(&expected))?.as_os_str() == whole.as_str(), "{expected} is no link");
        for linked_statically in [false, true] {
            let image = program(&prefix, &folder, name, linked_statically)?;
            let ours: Vec<_> = dynamic(&image, "NEEDED")?.into_iter().filter(|n| n.contains("mollis")).collect();
            let wanted = if linked_statically { vec![] } else { vec![expected.clone()] };
            ensure!(ours == wanted, "{} needs {ours:?}, not {wanted:?}", image.display());
            shell::run(shell::program(&image).env("LD_LIBRARY_PATH", &folder))?;
            checks += 1;
        }
    }
    Ok(checks)
}

/// The expected SONAME: `libNAME.so.MAJOR`, before 1.0 with the minor number.
fn expected_soname(name: &str, version: &str) -> String {
    let mut numbers = version.split('.');
    match (numbers.next(), numbers.next()) {
        (Some("0"), Some(minor)) => format!("lib{name}.so.0.{minor}"),
        (major, _) => format!("lib{name}.so.{}", major.unwrap_or_default()),
    }
}

/// Links a program with one of the libraries.
fn program(prefix: &Path, folder: &Path, name: &str, linked_statically: bool) -> Result<PathBuf> {
    let (file, image) = (prefix.join(format!("{name}.c")), prefix.join(format!("{name}_{linked_statically}")));
    std::fs::write(&file, PROGRAM)?;
    let asked = |what: &[&str]| -> Result<Vec<String>> {
        let mut tool = shell::program("pkg-config");
        tool.args(what).arg(name).env("PKG_CONFIG_PATH", folder.join("pkgconfig"));
        Ok(shell::output(&mut tool)?.split_whitespace().map(str::to_owned).collect())
    };
    let mut gcc = shell::program("gcc");
    gcc.args(["-std=c99", "-Wall", "-Wextra", "-Werror"]).args(asked(&["--cflags"])?);
    if name == "mollis_mt" {
        gcc.arg("-DPOOL");
    }
    gcc.arg(&file);
    if linked_statically {
        // The archive is named by its file, because the shared library is in the same folder. The libraries that it needs follow.
        let archive = folder.join(format!("lib{name}.a"));
        let rest = asked(&["--libs", "--static"])?.into_iter().filter(|word| *word != format!("-l{name}"));
        gcc.arg(archive).args(rest);
    } else {
        gcc.args(asked(&["--libs"])?);
    }
    shell::run(gcc.arg("-o").arg(&image))?;
    Ok(image)
}

/// Total mass and centre of 5000 equal points on a line, through the mesh and with the pool if there is one. Expected: 1250 and the middle.
const PROGRAM: &str = "#ifdef POOL
#include \"mollis_mt.h\"
#else
#include \"mollis.h\"
#endif
#include <stdlib.h>

enum { N = 5000 };
static double x[N][2], m[N], gradient[N][2];

int main(void) {
  const mollis_mesh2 mesh = {{0.0, 0.0}, {1.0, 1.0}, {16, 16}};
  mollis_run run;
  mollis_sources2 sources;
  mollis_grid2_outputs outputs;
  size_t bytes, k;
  void *memory;
  double total[3];
  mollis_run_init(&run, sizeof run);
#ifdef POOL
  mollis_pool *pool;
  mollis_executor executor;
  if (mollis_pool_init(2, &pool) || mollis_pool_executor(pool, &executor)) return 1;
  run.executor = &executor;
#endif
  for (k = 0; k < N; ++k) {
    x[k][0] = ((double)k + 0.5) / N;
    x[k][1] = 0.5;
    m[k] = 0.25;
  }
  memset(&sources, 0, sizeof sources);
  memset(&outputs, 0, sizeof outputs);
  sources.n = N;
  sources.positions[0] = &x[0][0];
  sources.masses = m;
  outputs.gradient[0] = &gradient[0][0];
  outputs.total = &total;
  if (mollis_grid2_workspace_bytes(&mesh, &sources, 0, &outputs, 0, &run, &bytes)) return 2;
  memory = malloc(bytes);
  if (memory == 0) return 3;
  if (mollis_grid2_eval(&mesh, &sources, 0, &outputs, 0, &run, memory, bytes)) return 4;
  free(memory);
#ifdef POOL
  mollis_pool_free(pool);
#endif
  /* Each mass is rounded by at most 2^-50 of the whole: 6e-9 for all. */
  return total[0] - 1250.0 > 1e-8 || total[0] - 1250.0 < -1e-8 || total[1] < 0.499999 || total[1] > 0.500001;
}
";

#[cfg(test)]
mod tests {
    #[test]
    fn names_inside_shared_libraries() {
        for (version, name) in [("0.1.0", "libx.so.0.1"), ("0.2.7", "libx.so.0.2"), ("1.4.2", "libx.so.1")] {
            assert_eq!(super::expected_soname("x", version), name);
        }
    }
}
