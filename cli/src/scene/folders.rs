//! Names of files and folders that every file system takes, and that differ on those that ignore case.

use super::types::{Picture, Scene};

/// The longest name, in bytes; file systems take 255 and a suffix is added to some.
pub const LONGEST: usize = 100;

/// What `mollis run` writes into its folder beside pictures and the folders of cases.
pub const SUMMARY: &str = "summary.json";
/// See [`SUMMARY`].
pub const CHECKPOINT: &str = "checkpoint.mollis";

/// Names that Windows keeps for devices, with any ending.
pub fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or("").to_ascii_lowercase();
    let numbered =
        |kind: &str| stem.strip_prefix(kind).is_some_and(|n| n.len() == 1 && n.as_bytes()[0].is_ascii_digit());
    ["con", "prn", "aux", "nul"].contains(&stem.as_str()) || numbered("com") || numbered("lpt")
}

/// A text as the name of a folder: letters, digits, `+`, `-`, `.` and `_`, without dots at its ends.
fn plain(text: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() || "+-.".contains(c) { c } else { '_' };
    let name: String = text.chars().map(allowed).take(LONGEST).collect();
    let name = name.trim_matches('.');
    match name {
        "" => "case".to_owned(),
        name if is_device(name) => format!("_{name}"),
        name => name.to_owned(),
    }
}

/// Gives every case a folder of its own name, or of that name with a number where another has taken it.
pub fn assign(cases: &mut [Scene], pictures: &[Picture]) {
    let mut taken: Vec<String> = [SUMMARY, CHECKPOINT].map(str::to_owned).to_vec();
    taken.extend(pictures.iter().flat_map(|picture| ["png", "svg"].map(|ending| format!("{}.{ending}", picture.name))));
    // A file is written under this name first.
    taken.extend(taken.clone().into_iter().map(|name| format!("{name}.new")));
    taken.iter_mut().for_each(|name| name.make_ascii_lowercase());
    for case in cases {
        let name = plain(&case.name);
        let numbered = (2_u64..).map(|n| format!("{name}-{n}"));
        let free =
            std::iter::once(name.clone()).chain(numbered).find(|name| !taken.contains(&name.to_ascii_lowercase()));
        case.folder = free.unwrap_or(name);
        taken.push(case.folder.to_ascii_lowercase());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain() {
        for (text, name) in [
            ("m = 4", "m___4"),
            ("delta = 0.32", "delta___0.32"),
            ("..", "case"),
            ("...x..", "x"),
            ("../../etc", "_.._etc"),
            ("/", "_"),
            ("", "case"),
            ("Gr\u{f6}\u{df}e", "Gr__e"),
            ("nul", "_nul"),
            ("COM1.x", "_COM1.x"),
            ("company", "company"),
            ("a\0b\nc", "a_b_c"),
        ] {
            assert_eq!(plain(text), name, "{text:?}");
        }
        assert_eq!(plain(&"x".repeat(300)).len(), LONGEST);
    }
}
