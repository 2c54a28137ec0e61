//! Finds the programs that a suite needs. Missing ones are installed on Debian as root, otherwise an error names them.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Result, bail};

use crate::shell;

/// Whether a program of this name can be started, or a file of this absolute path exists.
pub fn found(name: &str) -> bool {
    if name.starts_with('/') {
        return Path::new(name).exists();
    }
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&paths).any(|folder| folder.join(name).is_file())
}

/// Makes sure that each program (or file) is present. Installs the Debian package named with it if necessary.
pub fn need(pairs: &[(&str, &str)]) -> Result<()> {
    let missing: Vec<_> = pairs.iter().filter(|(name, _)| !found(name)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let mut packages: Vec<&str> = missing.iter().map(|(_, package)| *package).collect();
    packages.sort_unstable();
    packages.dedup();
    let names: Vec<&str> = missing.iter().map(|(name, _)| *name).collect();
    let sentence = format!("missing: {} (Debian packages: {})", names.join(", "), packages.join(" "));
    if !(found("apt-get") && is_root()) {
        bail!("{sentence}; install them and run again");
    }
    // Two suites run at a time.
    let lock = std::fs::File::create(shell::scratch("tools")?.join("lock"))?;
    lock.lock()?;
    println!("{sentence}; installing");
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments).stdout(Stdio::null());
        shell::run(&mut command)
    };
    apt(&["update", "-q"])?;
    let install = ["install", "-q", "-y", "--no-install-recommends"];
    apt(&install.iter().chain(&packages).copied().collect::<Vec<_>>())?;
    match pairs.iter().find(|(name, _)| !found(name)) {
        Some((name, package)) => bail!("{name} is still missing after installing {package}"),
        None => Ok(()),
    }
}

fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.starts_with(b"0\n"))
}
