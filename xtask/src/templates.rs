//! Expands `ffi/abi/templates`: what is stated once for every dimension and scalar, in functions that cbindgen can read.

use std::fmt::Write as _;

use anyhow::{Result, bail};

use crate::shell;

/// Template, text that stands only at the plane's function in double precision, and the file that is made.
const FIELD: [&str; 3] =
    ["ffi/abi/templates/field.rs", "ffi/abi/templates/field_evaluation.txt", "ffi/abi/src/field/functions.rs"];

const IMPORTS: &str = "#![allow(missing_docs, reason = \"members are documented at the plane's\")]

use core::ffi::{c_char, c_void};

use super::call::Ask;
use super::options::{mollis_counters, mollis_field_options};
use crate::run::mollis_run;
use crate::status::{mollis_status, status};
";

/// Writes the files, or checks that they are up to date.
pub fn run(check: bool) -> Result<()> {
    let [template, evaluation, to] = FIELD;
    let (template, evaluation) =
        (shell::read(&shell::root().join(template))?, shell::read(&shell::root().join(evaluation))?);
    let mut all =
        format!("//! Made from `ffi/abi/templates/field.rs` by `cargo xtask header`: do not edit.\n\n{IMPORTS}");
    for (dimension, name) in [(2, "the plane"), (1, "one dimension"), (3, "space")] {
        for (scalar, suffix, c) in [("f64", "", "double"), ("f32", "_f32", "float")] {
            let of_plane = dimension == 2 && suffix.is_empty();
            let features = match (dimension, suffix) {
                (2, "") => "#[cfg(feature = \"double\")]\n",
                (2, _) => "",
                (_, "") => "#[cfg(all(feature = \"dimensions\", feature = \"double\"))]\n",
                _ => "#[cfg(feature = \"dimensions\")]\n",
            };
            let place = format!("in {name}{}", if suffix.is_empty() { "" } else { ", single precision" });
            let template = if of_plane { template.clone() } else { shortened(&template, &place) };
            let expanded = template
                .replace("#[cfg({features})]\n", features)
                .replace("/// {evaluation}", evaluation.trim_end())
                .replace("{d}", &dimension.to_string())
                .replace("{f}", suffix)
                .replace("{T}", scalar)
                .replace("{dimension}", name)
                .replace("{scalar}", c)
                .replace("{{", "{")
                .replace("}}", "}");
            all.push('\n');
            all.push_str(&expanded);
        }
    }
    let scratch = shell::scratch("templates")?.join("functions.rs");
    std::fs::write(&scratch, all)?;
    let config = shell::root().join("rustfmt.toml");
    shell::run(shell::program("rustfmt").arg("--edition").arg("2024").arg("--config-path").arg(config).arg(&scratch))?;
    let fresh = std::fs::read_to_string(&scratch)?;
    let path = shell::root().join(to);
    if std::fs::read_to_string(&path).unwrap_or_default() == fresh {
        return Ok(());
    }
    if check {
        bail!("{to} is not what its template makes: run `cargo xtask header`");
    }
    std::fs::write(&path, fresh)?;
    println!("{to} written");
    Ok(())
}

/// The template with the documentation of every item shortened to that it is as the plane's, and without that of members.
fn shortened(template: &str, place: &str) -> String {
    let (mut out, mut at, mut documented) = (String::new(), 0, false);
    for line in template.split_inclusive('\n') {
        let rest = &template[at..];
        at += line.len();
        if line.trim_start().starts_with("///") {
            documented |= line.starts_with("///");
            continue;
        }
        if std::mem::take(&mut documented)
            && let Some(item) = item_of(rest)
        {
            let _ = writeln!(out, "/// As {}, {place}.", item.replace("{d}", "2").replace("{f}", ""));
        }
        out.push_str(line);
    }
    out
}

/// The name of the first item.
fn item_of(rest: &str) -> Option<&str> {
    let start = rest.find("mollis_")?;
    let name = &rest[start..];
    name.find(|c: char| !(c.is_alphanumeric() || "_{}".contains(c))).map(|end| &name[..end])
}
