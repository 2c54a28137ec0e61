//! Cases: their changes and their folders; the scenes that come with the program.

use std::path::Path;

use super::keys::GOOD;
use super::{mistakes, parse, scene, wrong};
use crate::scene::Model;
use crate::scene::load;

#[test]
fn cases_change_the_scene() {
    let text =
        format!("{GOOD}[[case]]\nname = \"soft\"\n[[case]]\nname = \"hard\"\nmodel = \"particle\"\ntime.dt = 0.05\n");
    let file = parse(&text, false).unwrap();
    assert_eq!(file.cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>(), ["soft", "hard"]);
    assert_eq!(file.cases[1].model, Model::Particle);
    assert!(file.cases[0].mollifier.is_some() && file.cases[1].mollifier.is_none());
    let text = format!("{GOOD}[[case]]\nname = \"a\"\n[[case]]\nname = \"a\"\n");
    assert!(mistakes(&text)[0].contains("twice"));
}

#[test]
fn cases_have_folders_of_their_own() {
    let names = ["a b", "a/b", "A_B", "..", ".", "", "summary.json", "p.png", "P.SVG.new", "nul", "m = 4"];
    let long = "x".repeat(300);
    let cases =
        |names: &[&str]| -> String { names.iter().map(|name| format!("[[case]]\nname = \"{name}\"\n")).collect() };
    let picture = "[[picture]]\nname = \"p\"\nkind = \"count\"\n";
    let refused = scene("pks", "", &format!("{picture}{}", cases(&names)));
    assert!(wrong(&refused, "case[5]").ends_with(".name = \"\": must not be empty"));
    let names: Vec<&str> = names.into_iter().filter(|name| !name.is_empty()).chain([long.as_str()]).collect();
    let file = parse(&scene("pks", "", &format!("{picture}{}", cases(&names))), false).unwrap();
    let folders: Vec<&str> = file.cases.iter().map(|case| case.folder.as_str()).collect();
    let cut = &long[..100];
    assert_eq!(
        folders,
        ["a_b", "a_b-2", "A_B-3", "case", "case-2", "summary.json-2", "p.png-2", "P.SVG.new-2", "_nul", "m___4", cut]
    );
}

/// The scenes that come with the program, in both sizes.
#[test]
fn the_papers_scenes_are_good() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        for quick in [false, true] {
            load(&path, quick).unwrap_or_else(|error| panic!("{error:#}"));
        }
        count += 1;
    }
    assert!(count > 20);
}
