//! Installs the libraries below a prefix, with what build systems need to find them, and removes them again.
//!
//! `archive` makes the static libraries that are installed, `sbom` lists what they are made of, `files` writes and removes what is listed here, `check` is the suite.

mod archive;
mod check;
mod files;
mod sbom;

use std::path::Path;

use anyhow::{Context, Result};

use crate::{header, shell, symbols, text, tools};
pub use check::check;
use files::{Content, Entry, Place};

/// A library to install.
struct Library {
    package: &'static str,
    name: &'static str,
    about: &'static str,
    /// Libraries that a program must link with the installed archive, besides those that every compiler adds (gcc_s, c).
    needs: &'static [&'static str],
}

const LIBRARIES: [Library; 2] = [
    Library {
        package: "mollis",
        name: "mollis",
        about: "Particles that interact through softened potentials",
        needs: &[],
    },
    Library {
        package: "mollis-mt",
        name: "mollis_mt",
        about: "mollis with a pool of threads",
        needs: &["pthread", "dl"],
    },
];

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Builds for release and installs below `$DESTDIR/PREFIX` what is to be used below PREFIX.
pub fn run(prefix: &Path) -> Result<()> {
    tools::need(&[
        ("readelf", "binutils"),
        ("ld", "binutils"),
        ("objcopy", "binutils"),
        ("nm", "binutils"),
        ("ar", "binutils"),
    ])?;
    let place = Place::new(prefix, std::env::var_os("DESTDIR"))?;
    let entries = entries(place.prefix()?)?;
    place.install(&entries)?;
    println!("installed {} files below {}", entries.len(), place.root().display());
    Ok(())
}

/// Removes what is installed below `$DESTDIR/PREFIX`.
pub fn remove(prefix: &Path) -> Result<()> {
    let place = Place::new(prefix, std::env::var_os("DESTDIR"))?;
    println!("removed {} files below {}", place.uninstall()?, place.root().display());
    Ok(())
}

/// Everything that is installed. Text that names a place names `prefix`.
fn entries(prefix: &str) -> Result<Vec<Entry>> {
    let mut all = Vec::new();
    for file in shell::files("include", &["h", "hpp", "f90"])? {
        all.push(Entry::copy("include", file)?);
    }
    for file in shell::files("examples_c", &["c", "cpp", "f90"])? {
        all.push(Entry::copy("share/doc/mollis/examples", file)?);
    }
    for file in ["LICENSE", "LICENSE-APACHE", "LICENSE-MIT"] {
        all.push(Entry::copy("share/licenses/mollis", shell::root().join(file))?);
    }
    let parts = sbom::text(&LIBRARIES.map(|library| library.package))?;
    all.push(Entry::new("share/mollis/sbom.cdx.json".into(), Content::Text(parts)));
    for library in &LIBRARIES {
        let name = library.name;
        let built = symbols::packages(&[library.package])?;
        let archive = archive::closed(&built.join(format!("lib{name}.a")), &library.functions()?)?;
        all.push(Entry::copy("lib", archive)?);
        // The file name has the full version. Programs load the library by its SONAME, linkers find it by the name without a version.
        let shared = built.join(format!("lib{name}.so"));
        let (whole, asked) = (format!("lib{name}.so.{VERSION}"), soname(&shared)?);
        all.push(Entry::new(format!("lib/lib{name}.so"), Content::Link(asked.clone())));
        all.push(Entry::new(format!("lib/{asked}"), Content::Link(whole.clone())));
        all.push(Entry::new(format!("lib/{whole}"), Content::Program(shared)));
        let needs = library.needs.iter().map(|need| format!("-l{need}")).collect::<Vec<_>>().join(" ");
        let marks = [("PREFIX", prefix), ("NAME", name), ("ABOUT", library.about), ("NEEDS", &needs)];
        all.push(Entry::new(format!("lib/pkgconfig/{name}.pc"), Content::Text(filled("mollis.pc", &marks)?)));
    }
    let [single, pool] = &LIBRARIES;
    let (needs, pool_needs, pointer) = (single.needs.join(";"), pool.needs.join(";"), size_of::<usize>().to_string());
    let marks = [("NEEDS", needs.as_str()), ("POOL_NEEDS", &pool_needs), ("POINTER_BYTES", &pointer)];
    for name in ["MollisConfig.cmake", "MollisConfigVersion.cmake"] {
        all.push(Entry::new(format!("lib/cmake/Mollis/{name}"), Content::Text(filled(name, &marks)?)));
    }
    Ok(all)
}

/// The template `ffi/NAME.in` with its marks, such as `@VERSION@`, replaced.
fn filled(name: &str, marks: &[(&str, &str)]) -> Result<String> {
    let template = shell::read(&shell::root().join(format!("ffi/{name}.in")))?;
    let versions = [("VERSION", VERSION), ("SERIES", series(VERSION))];
    Ok(marks.iter().chain(&versions).fold(template, |text, (mark, value)| text.replace(&format!("@{mark}@"), value)))
}

/// The number that compatible versions share: the major one, before 1.0 with the minor one.
fn series(version: &str) -> &str {
    let numbers = if version.starts_with("0.") { 2 } else { 1 };
    version.match_indices('.').nth(numbers - 1).map_or(version, |(end, _)| &version[..end])
}

impl Library {
    /// The functions that the library's headers declare.
    fn functions(&self) -> Result<Vec<String>> {
        let mut functions = header::functions()?;
        if self.name == "mollis_mt" {
            let header = text::code_only(&shell::read(&shell::root().join("include/mollis_mt.h"))?);
            let words = text::identifiers(&header).map(|(_, word)| word);
            let own = words.filter(|word| word.starts_with("mollis_pool_")).map(str::to_owned);
            functions.extend(own.collect::<std::collections::BTreeSet<_>>());
        }
        Ok(functions)
    }
}

/// The entries of this kind, `SONAME` or `NEEDED`, in the dynamic section of an ELF file.
pub fn dynamic(file: &Path, kind: &str) -> Result<Vec<String>> {
    let listed = shell::output(shell::program("readelf").args(["--dynamic", "--wide"]).arg(file).env("LC_ALL", "C"))?;
    let names = listed.lines().filter(|line| line.contains(&format!("({kind})")));
    Ok(names.filter_map(|line| Some(line.split_once('[')?.1.split_once(']')?.0.to_owned())).collect())
}

/// The name by which programs load a shared library.
fn soname(library: &Path) -> Result<String> {
    let names = dynamic(library, "SONAME")?;
    names.into_iter().next().with_context(|| format!("{} has no SONAME", library.display()))
}

#[cfg(test)]
mod tests {
    #[test]
    fn compatible_versions() {
        for (version, series) in
            [("0.1.0", "0.1"), ("0.2.7", "0.2"), ("1.4.2", "1"), ("12.0.0", "12"), ("0.13.1", "0.13")]
        {
            assert_eq!(super::series(version), series);
        }
    }
}
