//! The floors of `core`, as its crate page lists them: no module uses one that stands above it, and `unsafe` stays in
//! its rooms.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Result, bail, ensure};

use crate::{shell, text};

/// The rooms of `core` that may hold `unsafe`.
const UNSAFE_ROOMS: [&str; 2] = ["space", "isa"];

/// Checks every file of `core/src`.
pub fn run() -> Result<()> {
    let source = shell::root().join("core/src");
    let floors = floors(&shell::read(&source.join("lib.rs"))?)?;
    let mut faults = Vec::new();
    let mut files = 0;
    for path in shell::files("core/src", &["rs"])? {
        let Some(module) = module(&path, &source) else { continue };
        ensure!(floors.contains_key(&module), "core/src/lib.rs gives no floor for `{module}`");
        files += 1;
        let faulty = check(&shell::read(&path)?, &module, &floors, path.ends_with("tests.rs"));
        faults.extend(faulty.into_iter().map(|fault| format!("{}: {fault}", shell::short(&path))));
    }
    ensure!(files > 0, "no file found below core/src");
    if !faults.is_empty() {
        bail!("{}", faults.join("\n"));
    }
    println!("{files} files of core: every use points down, unsafe stays in {UNSAFE_ROOMS:?}");
    Ok(())
}

/// The top module a file belongs to; none for `lib.rs`.
fn module(path: &Path, source: &Path) -> Option<String> {
    let first = path.strip_prefix(source).ok()?.components().next()?;
    let name = first.as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned();
    (name != "lib").then_some(name)
}

/// Module to floor, from the numbered list of the crate's page.
fn floors(lib: &str) -> Result<BTreeMap<String, u32>> {
    let mut floors = BTreeMap::new();
    let mut floor = 0;
    for line in lib.lines().filter_map(|line| line.strip_prefix("//! ")) {
        match line.split_once(". ").and_then(|(number, _)| number.parse().ok()) {
            Some(number) => floor = number,
            None if !line.starts_with(' ') => floor = 0,
            None => {}
        }
        if floor > 0 {
            for name in line.split("[`").skip(1).filter_map(|part| part.split_once("`]")).map(|(name, _)| name) {
                floors.insert(name.to_owned(), floor);
            }
        }
    }
    ensure!(floors.len() > 1, "core/src/lib.rs lists no floors");
    Ok(floors)
}

/// What a file does against the rules.
fn check(source: &str, module: &str, floors: &BTreeMap<String, u32>, tests: bool) -> Vec<String> {
    let code = text::code_only(source);
    let mut faults = Vec::new();
    if !UNSAFE_ROOMS.contains(&module) && text::identifiers(&code).any(|(_, word)| word == "unsafe") {
        faults.push("`unsafe` outside its rooms".to_owned());
    }
    // Tests may look up: they ship nothing.
    if tests {
        return faults;
    }
    let code = text::without_tests(&code);
    let own = floors.get(module).copied().unwrap_or(0);
    for used in uses(&code) {
        if let Some(&floor) = floors.get(used).filter(|&&floor| floor > own) {
            faults.push(format!("`{module}` (floor {own}) uses `{used}` (floor {floor})"));
        }
    }
    faults
}

/// The top modules named after `crate::`, alone or in braces.
fn uses(code: &str) -> Vec<&str> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let tail = &code[at + "crate::".len()..];
        if !tail.starts_with('{') {
            found.extend(text::identifiers(tail).next().map(|(_, word)| word));
            continue;
        }
        let (mut depth, mut first) = (0, false);
        for (k, c) in tail.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                break;
            }
            if depth == 1 && (c == '{' || c == ',') {
                first = true;
            } else if first && !c.is_whitespace() {
                first = false;
                found.extend(text::identifiers(&tail[k..]).next().map(|(_, word)| word));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIB: &str =
        "//! Floors:\n//!\n//! 1. [`error`], [`space`]\n//!    and [`isa`]\n//! 2. [`field`]\n//! 3. [`blob`] \n";

    #[test]
    fn floors_are_read() {
        let floors = floors(LIB).unwrap();
        assert_eq!(floors["isa"], 1);
        assert_eq!(floors["blob"], 3);
    }

    #[test]
    fn upward_uses_are_refused() {
        let floors = floors(LIB).unwrap();
        let faults = |source: &str| check(source, "field", &floors, false).len();
        assert_eq!(faults("use crate::space::Carve; use crate::{error::{self, blob}, isa};"), 0);
        assert_eq!(faults("use crate::blob::Step;"), 1);
        assert_eq!(faults("use crate::{error::Error, blob::Step};"), 1);
        assert_eq!(faults("fn f() { crate::blob::g() }"), 1);
        assert_eq!(faults("// use crate::blob;\n#[cfg(test)]\nmod tests { use crate::blob; }"), 0);
    }

    #[test]
    fn unsafe_is_refused_outside_its_rooms() {
        let floors = floors(LIB).unwrap();
        assert_eq!(check("unsafe fn f() {}", "field", &floors, false).len(), 1);
        assert_eq!(check("unsafe fn f() {}", "space", &floors, false).len(), 0);
        assert_eq!(check("#![expect(unsafe_code)] // unsafe", "field", &floors, false).len(), 0);
    }
}
