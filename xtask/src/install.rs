//! The library, its headers and a pkg-config file below a prefix.

use std::path::Path;

use anyhow::{Context, Result};

use crate::{shell, symbols};

/// Builds for release and copies.
pub fn run(prefix: &Path) -> Result<()> {
    let built = symbols::build()?;
    std::fs::create_dir_all(prefix).with_context(|| format!("cannot make {}", prefix.display()))?;
    let prefix = prefix.canonicalize()?;
    for header in shell::files("include", &["h", "hpp", "f90"])? {
        copy(&header, &prefix.join("include"))?;
    }
    for library in ["libmollis.so", "libmollis.a"] {
        copy(&built.join(library), &prefix.join("lib"))?;
    }
    let template = shell::read(&shell::root().join("ffi/mollis.pc.in"))?;
    let filled = template.replace("@PREFIX@", &prefix.display().to_string());
    let folder = prefix.join("lib/pkgconfig");
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("mollis.pc"), filled.replace("@VERSION@", env!("CARGO_PKG_VERSION")))?;
    println!("installed below {}", prefix.display());
    Ok(())
}

fn copy(file: &Path, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let to = folder.join(file.file_name().context("no name")?);
    std::fs::copy(file, &to).with_context(|| format!("cannot copy to {}", to.display()))?;
    Ok(())
}
