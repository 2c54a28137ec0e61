//! Every combination of Cargo features builds, and the example that needs one runs.

use anyhow::{Context, Result};

use crate::shell;

/// Checks `mollis` with each combination, which also builds `mollis-core` with each of those; and `mollis-core` with what `mollis` does not offer.
pub fn run() -> Result<()> {
    let listed = |manifest: &str| -> Result<Vec<String>> { Ok(features(&shell::read(&shell::root().join(manifest))?)) };
    let (library, core) = (listed("ffi/Cargo.toml")?, listed("core/Cargo.toml")?);
    let others: Vec<_> = core.iter().filter(|name| !library.contains(name)).cloned().collect();
    for (package, chosen) in
        [("mollis", combinations(&library)), ("mollis-core", others.iter().cloned().chain([core.join(",")]).collect())]
    {
        // A check keeps one core busy: two at a time, in folders of their own.
        let (ours, others) = chosen.split_at(chosen.len() / 2);
        std::thread::scope(|scope| {
            let second = scope.spawn(|| check(package, others, "features2"));
            check(package, ours, "features")?;
            second.join().ok().context("a thread failed")?
        })?;
        println!("{package}: {} combinations of features build", chosen.len());
    }
    let mut cargo = shell::cargo();
    cargo.args(["run", "--quiet", "--package", "mollis-core", "--features", "nalgebra", "--example", "tidal_field"]);
    // One sum over three masses: optimising the library once more for it would take minutes.
    cargo.args(["--config", "profile.dev.opt-level=0"]).arg("--target-dir").arg(shell::target().join("features"));
    shell::run(&mut cargo)
}

/// Checks a package with each of these combinations.
fn check(package: &str, combinations: &[String], folder: &str) -> Result<()> {
    for chosen in combinations {
        let mut cargo = shell::cargo();
        cargo.args(["check", "--quiet", "--package", package, "--no-default-features", "--features", chosen]);
        // A helper that only some combinations use is accepted. An unused import is not.
        cargo.env("RUSTFLAGS", "-Dwarnings -Adead_code").arg("--target-dir").arg(shell::target().join(folder));
        shell::run(&mut cargo).with_context(|| format!("{package} with features [{chosen}]"))?;
    }
    Ok(())
}

/// The names in a manifest's `[features]` except `default`.
fn features(manifest: &str) -> Vec<String> {
    let inside = manifest.lines().skip_while(|line| line.trim() != "[features]").skip(1);
    let rows = inside.take_while(|line| !line.starts_with('['));
    let names = rows.filter_map(|line| line.split_once('=')).map(|(name, _)| name.trim().to_owned());
    names.filter(|name| name != "default" && !name.starts_with('#')).collect()
}

/// All subsets, in cargo's format.
fn combinations(names: &[String]) -> Vec<String> {
    let subset = |mask: usize| {
        let chosen = names.iter().enumerate().filter(|(k, _)| mask >> k & 1 == 1).map(|(_, name)| name.as_str());
        chosen.collect::<Vec<_>>().join(",")
    };
    (0..1_usize << names.len()).map(subset).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn all_subsets() {
        let names = super::features(
            "[package]\nname = \"x\"\n[features]\ndefault = [\"a\"]\na = []\n# no\nb = [\"a\"]\n\n[lib]\nc = 1\n",
        );
        assert_eq!(names, ["a", "b"]);
        assert_eq!(super::combinations(&names), ["", "a", "b", "a,b"]);
    }
}
