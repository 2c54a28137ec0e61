//! Expands `ffi/abi/templates`: what is stated once for every dimension and scalar, into functions that cbindgen can read.
//!
//! A template is a file of items, each with its documentation, behind its `use` declarations. In an item `{d}` stands for the dimension, `{f}` for the suffix of the scalar, and
//! `{T}` for the scalar. The first expansion of an item, for the plane and double precision, keeps its documentation; the others follow without, as the
//! header says what they are.

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::shell;

const FROM: &str = "ffi/abi/templates";
const TO: &str = "ffi/abi/src/functions";

/// Writes the files, or checks that they are up to date.
pub fn run(check: bool) -> Result<()> {
    for template in shell::files(FROM, &["rs"])? {
        let name = template.file_name().context("no name")?;
        let fresh = formatted(&expand(&shell::read(&template)?, &shell::short(&template)))?;
        let path = shell::root().join(TO).join(name);
        if std::fs::read_to_string(&path).unwrap_or_default() == fresh {
            continue;
        }
        let short = shell::short(&path);
        if check {
            bail!("{short} is not what its template makes: run `cargo xtask header`");
        }
        std::fs::write(&path, fresh)?;
        println!("{short} written");
    }
    Ok(())
}

/// What an item is expanded for.
struct Variant {
    dimension: u32,
    suffix: &'static str,
    scalar: &'static str,
}

const VARIANTS: [Variant; 6] = {
    const fn of(dimension: u32, single: bool) -> Variant {
        let (suffix, scalar) = if single { ("_f32", "f32") } else { ("", "f64") };
        Variant { dimension, suffix, scalar }
    }
    [of(2, false), of(2, true), of(1, false), of(1, true), of(3, false), of(3, true)]
};

impl Variant {
    /// The attribute of a function that a build may leave out.
    fn condition(&self) -> &'static str {
        match (self.dimension, self.suffix) {
            (2, "") => "#[cfg(feature = \"double\")]\n",
            (2, _) => "",
            (_, "") => "#[cfg(all(feature = \"dimensions\", feature = \"double\"))]\n",
            _ => "#[cfg(feature = \"dimensions\")]\n",
        }
    }
}

fn expand(template: &str, name: &str) -> String {
    let mut out = format!(
        "//! Made from `{name}` by `cargo xtask header`: do not edit.\n\n#![allow(missing_docs, reason = \"documented at the plane's\")]\n\n"
    );
    let start = template.find("///").unwrap_or(template.len());
    let (uses, items) = template.split_at(start);
    out.push_str(uses);
    for item in
        items.split("\n\n///").enumerate().map(|(k, item)| if k > 0 { format!("///{item}") } else { item.into() })
    {
        let variants = match (item.contains("{d}"), item.contains("{f}")) {
            (true, _) => &VARIANTS[..],
            (_, true) => &VARIANTS[..2],
            _ => &VARIANTS[..1],
        };
        for (k, variant) in variants.iter().enumerate() {
            let code: String =
                item.split_inclusive('\n').filter(|line| k == 0 || !line.trim_start().starts_with("///")).collect();
            let mark = "#[unsafe(no_mangle)]\n";
            let condition = if variants.len() > 1 { variant.condition() } else { "" };
            let expanded = code
                .replace(mark, &format!("{condition}{mark}"))
                .replace("{d}", &variant.dimension.to_string())
                .replace("{f}", variant.suffix)
                .replace("{T}", variant.scalar);
            out.push_str(expanded.trim_end());
            out.push_str("\n\n");
        }
    }
    out
}

fn formatted(code: &str) -> Result<String> {
    let scratch = shell::scratch("templates")?.join("functions.rs");
    std::fs::write(&scratch, code)?;
    let config: &Path = &shell::root().join("rustfmt.toml");
    shell::run(shell::program("rustfmt").arg("--edition").arg("2024").arg("--config-path").arg(config).arg(&scratch))?;
    Ok(std::fs::read_to_string(&scratch)?)
}

#[cfg(test)]
mod tests {
    #[test]
    fn an_item_is_expanded_for_every_scalar_and_dimension() {
        let template = "use a::b;\n\n/// Of the plane.\n#[unsafe(no_mangle)]\nfn f{d}_x{f}(x: [{T}; {d}]) {}\n\n/// Once.\nfn g() {}\n";
        let out = super::expand(template, "t.rs");
        assert_eq!(out.matches("use a::b;").count(), 1);
        assert_eq!(out.matches("fn f").count(), 6);
        assert_eq!(out.matches("fn g").count(), 1);
        assert_eq!(out.matches("/// Of the plane.").count(), 1);
        assert!(out.contains("#[cfg(feature = \"dimensions\")]\n#[unsafe(no_mangle)]\nfn f3_x_f32(x: [f32; 3]) {}"));
    }
}
