//! What the installed libraries are made of, with licences, in the format CycloneDX 1.5 (JSON). It holds no time and no place: the same sources give the same file.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, ensure};
use serde_json::json;

use super::VERSION;
use crate::shell;

/// Licences under which code may be in the libraries.
const LICENCES: [&str; 7] =
    ["MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "Unlicense", "Zlib"];

/// A package: name, version, licence.
type Package = [String; 3];

/// The list for these packages of the workspace: they, and every package that they depend on on this platform, but not for builds and tests alone.
///
/// # Errors
/// A package under another licence.
pub fn text(roots: &[&str]) -> Result<String> {
    let links = links(roots)?;
    let url = |[name, version, _]: &Package| format!("pkg:cargo/{name}@{version}");
    let mut components = Vec::new();
    for package in links.keys() {
        let [name, version, licence] = package;
        ensure!(permitted(licence), "{name} is under {licence}, which `xtask/src/install/sbom.rs` does not list");
        components.push(json!({
            "type": "library", "bom-ref": url(package), "name": name, "version": version, "purl": url(package),
            "licenses": [{ "expression": licence.replace('/', " OR ") }],
        }));
    }
    let dependencies: Vec<_> = links
        .iter()
        .map(|(package, used)| json!({ "ref": url(package), "dependsOn": used.iter().map(url).collect::<Vec<_>>() }))
        .collect();
    let compiler = shell::output(shell::program("rustc").arg("--version"))?;
    let list = json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {
            "component": { "type": "library", "name": "mollis", "version": VERSION },
            "tools": { "components": [{ "type": "application", "name": "rustc", "version": compiler.trim() }] },
        },
        "components": components, "dependencies": dependencies,
    });
    Ok(serde_json::to_string_pretty(&list)? + "\n")
}

/// Each package, and what it is linked with.
fn links(roots: &[&str]) -> Result<BTreeMap<Package, BTreeSet<Package>>> {
    let mut cargo = shell::cargo();
    cargo.args(["tree", "--quiet", "--locked", "--edges", "normal,no-proc-macro", "--prefix", "depth", "--no-dedupe"]);
    cargo.args(["--format", "\t{p}\t{l}"]).args(roots.iter().flat_map(|root| ["--package", *root]));
    // A line is `DEPTH<tab>NAME vVERSION ...<tab>LICENCE`. A package is linked with those one level deeper that follow it.
    let (mut links, mut above) = (BTreeMap::<Package, BTreeSet<Package>>::new(), Vec::<Package>::new());
    for line in shell::output(&mut cargo)?.lines().filter(|line| !line.is_empty()) {
        let parts: Vec<_> = line.split('\t').collect();
        let [depth, package, licence] = parts[..] else { anyhow::bail!("cargo tree prints {line}") };
        let mut words = package.split(' ');
        let name = words.next().unwrap_or_default();
        let version = words.next().and_then(|word| word.strip_prefix('v')).context("a package without a version")?;
        let package = [name, version, licence].map(str::to_owned);
        above.truncate(depth.parse()?);
        if let Some(user) = above.last() {
            links.entry(user.clone()).or_default().insert(package.clone());
        }
        links.entry(package.clone()).or_default();
        above.push(package);
    }
    ensure!(roots.iter().all(|root| links.keys().any(|[name, ..]| name == root)), "cargo does not list {roots:?}");
    Ok(links)
}

/// Whether one of the alternatives of an expression (`A OR B AND C`, without parentheses; a slash is OR) holds listed licences alone.
fn permitted(expression: &str) -> bool {
    let one = |alternative: &str| alternative.split(" AND ").all(|name| LICENCES.contains(&name));
    expression.split(" OR ").flat_map(|part| part.split('/')).any(one)
}

#[cfg(test)]
mod tests {
    use super::permitted;

    #[test]
    fn licences() {
        for yes in ["MIT", "MIT OR Apache-2.0", "Unlicense/MIT", "GPL-3.0 OR MIT", "MIT AND Zlib"] {
            assert!(permitted(yes), "{yes}");
        }
        for no in ["", "GPL-3.0", "MIT AND GPL-3.0", "MIT-0", "(MIT OR Zlib) AND GPL-3.0"] {
            assert!(!permitted(no), "{no}");
        }
    }
}
