//! Each function of the header is called by a test or an example.

use std::collections::BTreeSet;

use anyhow::{Result, bail, ensure};

use crate::{header, shell, text};

/// Folders that are searched for calls.
const CALLERS: [&str; 4] = ["tests", "examples_c", "ffi/abi/src", "evidence"];

/// Fails with the list of functions that are never called.
pub fn run() -> Result<()> {
    let mut called = BTreeSet::new();
    for folder in CALLERS {
        for path in shell::files(folder, &["rs", "c", "cpp", "h", "f90", "py"])? {
            let code = text::code_only(&shell::read(&path)?);
            let mut last = "";
            for (at, word) in text::identifiers(&code) {
                // Rust tests may also pass a name to a macro, which calls it.
                let named = folder == "tests" && !code[at + word.len()..].trim_start().starts_with("::");
                let call = code[at + word.len()..].trim_start().starts_with('(');
                if word.starts_with("mollis_") && (call || named) && last != "fn" {
                    called.insert(word.to_owned());
                }
                last = word;
            }
        }
    }
    let functions = header::functions()?;
    ensure!(!functions.is_empty(), "the header has no function");
    let missing: Vec<&str> = functions.iter().filter(|f| !called.contains(*f)).map(String::as_str).collect();
    if !missing.is_empty() {
        bail!(
            "{} of {} functions are called by no test or example:\n{}",
            missing.len(),
            functions.len(),
            missing.join("\n")
        );
    }
    println!("all {} functions of the header are called by a test or an example", functions.len());
    Ok(())
}
