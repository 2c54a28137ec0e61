//! Runs the inputs in `corpus/`, each whole and cut short, and some that are made of them.

use std::fs;
use std::path::Path;

use mollis_fuzz::TARGETS;

fn replay(name: &str) {
    let (_, check) = TARGETS.into_iter().find(|(other, _)| *other == name).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 10, "{name}: the corpus is gone");
    check(&[]);
    for path in files {
        // Shown if the check fails.
        println!("{}", path.display());
        let mut bytes = fs::read(&path).unwrap();
        check(&bytes);
        bytes.truncate(bytes.len() / 2);
        println!("the first half");
        check(&bytes);
    }
}

#[test]
fn abi() {
    replay("abi");
}

#[test]
fn scene() {
    replay("scene");
}

#[test]
fn points() {
    replay("points");
}

#[test]
fn fmm() {
    replay("fmm");
}

#[test]
fn search() {
    replay("search");
}
