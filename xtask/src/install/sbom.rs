//! What the installed libraries are made of, with licences, in the format CycloneDX 1.5 (JSON). It holds no time and no place: the same sources give the same file.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use super::VERSION;
use crate::shell;

/// Licences under which code may be in the libraries.
const LICENCES: [&str; 7] =
    ["MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "Unlicense", "Zlib"];

/// The list for these packages of the workspace: they, and every package that they depend on on this platform, but not for builds and tests alone.
///
/// # Errors
/// A package under another licence.
pub fn text(roots: &[&str]) -> Result<String> {
    let compiler = shell::output(shell::program("rustc").arg("-vV"))?;
    let field =
        |name: &str| compiler.lines().find_map(|line| line.strip_prefix(name)).context("rustc's version has changed");
    let mut cargo = shell::cargo();
    cargo.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", field("host: ")?]);
    let metadata: Value = serde_json::from_str(&shell::output(&mut cargo)?)?;
    let by_id = |rows: &'static str, of: &Value| -> Result<BTreeMap<String, Value>> {
        let rows = of[rows].as_array().with_context(|| format!("cargo lists no {rows}"))?;
        rows.iter().map(|row| Ok((row["id"].as_str().context("no id")?.to_owned(), row.clone()))).collect()
    };
    let (packages, nodes) = (by_id("packages", &metadata)?, by_id("nodes", &metadata["resolve"])?);
    let word = |id: &str, name: &str| packages.get(id).and_then(|package| package[name].as_str()).unwrap_or_default();
    let mut ids: Vec<String> = packages.keys().filter(|id| roots.contains(&word(id, "name"))).cloned().collect();
    ensure!(ids.len() == roots.len(), "cargo does not list {roots:?}");
    let mut links = BTreeMap::new();
    while let Some(id) = ids.pop() {
        let used: Vec<String> = nodes.get(&id).map(normal).unwrap_or_default();
        ids.extend(used.iter().filter(|used| !links.contains_key(*used)).cloned());
        links.insert(id, used);
    }
    let url = |id: &str| format!("pkg:cargo/{}@{}", word(id, "name"), word(id, "version"));
    let mut components = Vec::new();
    for id in links.keys() {
        let licence = word(id, "license");
        ensure!(permitted(licence), "{} is under {licence}, which `xtask/src/install/sbom.rs` does not list", url(id));
        components.push(json!({
            "type": "library", "bom-ref": url(id), "name": word(id, "name"), "version": word(id, "version"), "purl": url(id),
            "licenses": [{ "expression": licence }],
        }));
    }
    let dependencies: Vec<_> = links
        .iter()
        .map(|(id, used)| json!({ "ref": url(id), "dependsOn": used.iter().map(|id| url(id)).collect::<Vec<_>>() }))
        .collect();
    let list = json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {
            "component": { "type": "library", "name": "mollis", "version": VERSION },
            "tools": { "components": [{ "type": "application", "name": "rustc", "version": field("release: ")? }] },
        },
        "components": components, "dependencies": dependencies,
    });
    Ok(serde_json::to_string_pretty(&list)? + "\n")
}

/// The packages that are linked with this one.
fn normal(node: &Value) -> Vec<String> {
    let linked = |used: &&Value| {
        used["dep_kinds"].as_array().is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()))
    };
    let all = node["deps"].as_array().into_iter().flatten();
    all.filter(linked).filter_map(|used| Some(used["pkg"].as_str()?.to_owned())).collect()
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
