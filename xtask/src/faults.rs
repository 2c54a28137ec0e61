//! Faults in a copy of the sources, to see whether the tests notice them.
//!
//! `tests/faults.toml` lists them: an expression, what stands there instead, and the tests that have to fail. All are compiled at once: each expression becomes
//! a choice that an environment variable makes when the tests run. So a fault takes as long as its tests, and not as long as a build.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use crate::{shell, tools};

/// The least part of the faults that has to be noticed.
const LEAST: f64 = 0.95;
/// A test that takes so many seconds has noticed the fault.
const LONGEST: &str = "200";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    fault: Vec<Fault>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fault {
    file: String,
    /// An expression that stands once in the file.
    find: String,
    replace: String,
    /// Filters of names, of tests in `tests/`.
    #[serde(default)]
    tests: Vec<String>,
    /// The same, of unit tests of core.
    #[serde(default)]
    unit: Vec<String>,
    /// Why no test notices it.
    survives: Option<String>,
}

/// The function that the copies of core and of the C interface call.
const CHOICE: &str = r#"
#[cfg(not(test))]
extern crate std;
/// Whether this fault is there.
#[must_use]
pub fn fault(k: usize) -> bool {
    static CHOSEN: std::sync::OnceLock<usize> = std::sync::OnceLock::new();
    let chosen = || std::env::var("MOLLIS_FAULT").ok().and_then(|k| k.parse().ok()).unwrap_or(usize::MAX);
    *CHOSEN.get_or_init(chosen) == k
}
"#;

/// Tries the faults of files whose paths contain `filter`.
pub fn run(filter: &str) -> Result<()> {
    tools::need(&[("timeout", "coreutils")])?;
    let list: List = toml::from_str(&shell::read(&shell::root().join("tests/faults.toml"))?)?;
    let folder = shell::scratch("faults")?.canonicalize()?;
    copy(&list.fault, &folder.join("sources"))?;
    let programs = build(&folder)?;
    let chosen: Vec<_> = list.fault.iter().enumerate().filter(|(_, fault)| fault.file.contains(filter)).collect();
    ensure!(!chosen.is_empty(), "no fault in a file whose path contains `{filter}`");
    // Without a fault all pass, or a failure would say nothing.
    let sets: BTreeSet<_> = chosen.iter().flat_map(|(_, fault)| fault.runs()).collect();
    for (program, filters) in sets {
        ensure!(passes(&programs, program, filters, None)?, "{} fails without a fault", filters.join(" "));
    }
    let (mut noticed, mut unexplained) = (0, Vec::new());
    for &(k, fault) in &chosen {
        let mut seen = false;
        for (program, filters) in fault.runs() {
            seen = seen || !passes(&programs, program, filters, Some(k))?;
        }
        noticed += usize::from(seen);
        let result = if seen { "noticed" } else { "SURVIVES" };
        println!("{k:>3} {result:<8} {}: {} -> {}", fault.file, line(&fault.find), line(&fault.replace));
        match &fault.survives {
            Some(reason) if !seen => println!("    {reason}"),
            Some(_) => bail!("it is listed as one that no test notices"),
            None if !seen => unexplained.push(k),
            None => {}
        }
    }
    println!("{noticed} of {} faults noticed; not explained: {unexplained:?}", chosen.len());
    ensure!(unexplained.is_empty(), "some faults survive that the list does not explain");
    ensure!(noticed as f64 >= LEAST * chosen.len() as f64, "too few");
    Ok(())
}

/// A text on one line.
fn line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Fault {
    /// Programs of tests, and filters.
    fn runs(&self) -> impl Iterator<Item = (&'static str, &[String])> {
        [("mollis_core", &*self.unit), ("all", &*self.tests)].into_iter().filter(|(_, filters)| !filters.is_empty())
    }

    /// Puts the fault into a text. Each fault is looked for in the file as it is, and has to be there still when those before it are in.
    fn put(&self, k: usize, original: &str, text: &str) -> Result<String> {
        let Self { file, find, replace, .. } = self;
        for text in [original, text] {
            let times = text.matches(find.as_str()).count();
            ensure!(times == 1, "fault {k}: `{}` stands {times} times in {file}", line(find));
        }
        ensure!(!self.tests.is_empty() || !self.unit.is_empty(), "fault {k} has no test");
        Ok(text.replace(find.as_str(), &format!("(if crate::fault({k}) {{ {replace} }} else {{ {find} }})")))
    }
}

/// Copies the sources with all faults. Files that are the same already are left alone, so that cargo does not compile them again.
fn copy(faults: &[Fault], folder: &Path) -> Result<()> {
    let mut changed = BTreeMap::new();
    for (k, fault) in faults.iter().enumerate() {
        let original = shell::read(&shell::root().join(&fault.file))?;
        let text = changed.remove(&fault.file).unwrap_or_else(|| original.clone());
        changed.insert(fault.file.clone(), fault.put(k, &original, &text)?);
    }
    for (file, choice) in [("core/src/lib.rs", CHOICE), ("ffi/abi/src/lib.rs", "\npub use mollis_core::fault;\n")] {
        let text = changed.remove(file).map_or_else(|| shell::read(&shell::root().join(file)), Ok)?;
        changed.insert(file.to_owned(), text + choice);
    }
    let mut git = shell::program("git");
    let listed = shell::output(git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]))?;
    for file in listed.split_terminator('\0') {
        let (from, to) = (shell::root().join(file), folder.join(file));
        // A file that was removed is still listed.
        if !from.is_file() {
            continue;
        }
        let bytes = changed.get(file).map_or_else(|| std::fs::read(&from), |text| Ok(text.clone().into_bytes()))?;
        if std::fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        std::fs::create_dir_all(to.parent().context("no folder")?)?;
        std::fs::write(&to, bytes).with_context(|| format!("cannot write {}", to.display()))?;
    }
    Ok(())
}

/// Compiles the tests of the copy. Returns the programs by name.
fn build(folder: &Path) -> Result<BTreeMap<String, PathBuf>> {
    let mut programs = BTreeMap::new();
    for which in [&["-p", "mollis-core", "--lib"][..], &["-p", "mollis-tests", "--test", "all"]] {
        let mut cargo = shell::cargo();
        cargo.current_dir(folder.join("sources")).env("CARGO_TARGET_DIR", folder.join("target"));
        cargo.env("RUSTFLAGS", "-Awarnings").args(["test", "--quiet", "--no-run"]).args(which);
        programs.extend(shell::programs(&mut cargo)?);
    }
    Ok(programs)
}

/// Whether the tests that the filters choose all pass, with a fault or without.
fn passes(
    programs: &BTreeMap<String, PathBuf>,
    program: &str,
    filters: &[String],
    fault: Option<usize>,
) -> Result<bool> {
    let image = programs.get(program).with_context(|| format!("cargo names no program `{program}`"))?;
    let mut tests = shell::program("timeout");
    tests.arg(LONGEST).arg(image).args(filters).env("MOLLIS_FAULT", fault.map_or_else(String::new, |k| k.to_string()));
    let output = tests.stderr(Stdio::null()).output()?;
    let none = String::from_utf8_lossy(&output.stdout).contains("running 0 tests");
    ensure!(!none, "no test is called {}", filters.join(" "));
    Ok(output.status.success())
}

#[cfg(test)]
mod tests {
    use super::Fault;

    #[test]
    fn a_fault_is_a_choice() {
        let fault = |find: &str| Fault {
            file: "x.rs".into(),
            find: find.into(),
            replace: "b".into(),
            tests: vec!["t".into()],
            unit: Vec::new(),
            survives: None,
        };
        let text = "let x = a + c;";
        assert_eq!(fault("a").put(7, "f(a)", "f(a)").ok().as_deref(), Some("f((if crate::fault(7) { b } else { a }))"));
        assert!(fault("a + c").put(7, text, text).is_ok());
        // Not there, there twice, and within another fault.
        assert!(fault("d").put(7, text, text).is_err() && fault("e").put(7, "e e", "e e").is_err());
        assert!(fault("a + c").put(7, text, "let x = (a) + c;").is_err());
    }
}
