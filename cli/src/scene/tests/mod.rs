//! What the tests of scene files share: a good scene of every model, and what is wrong with a changed one.

use std::path::Path;

use super::mistake::Mistake;
use super::types::SceneFile;

mod cases;
mod data;
mod expectations;
mod keys;
mod pictures;
mod studies;

/// Files named `dense` hold densities, those named `none` can't be read.
fn probe(path: &Path, _: usize) -> anyhow::Result<bool> {
    let name = path.to_string_lossy();
    anyhow::ensure!(!name.starts_with("none"), "no such file");
    Ok(name.starts_with("dense"))
}

fn parse(text: &str, quick: bool) -> Result<SceneFile, Vec<Mistake>> {
    super::read::parse(text, quick, &probe)
}

fn mistakes(text: &str) -> Vec<String> {
    match parse(text, false) {
        Ok(_) => Vec::new(),
        Err(list) => list.iter().map(|mistake| format!("{}: {}", mistake.line, mistake.text)).collect(),
    }
}

/// A scene of a model, with this output and these pictures and expectations.
fn scene(model: &str, output: &str, rest: &str) -> String {
    let own = match model {
        "line" => {
            "model = \"blob\"\ndimension = 1\n[[kernel]]\nkind = \"newtonian\"\n\
             [mollifier]\nkind = \"gaussian\"\norder = 4\n[[initial]]\nshape = \"polynomial\"\nk = 20\n\
             [sampling]\nkind = \"grid\"\nh = 0.04\n"
        }
        "blob" => {
            "model = \"blob\"\ndimension = 2\n[[kernel]]\nkind = \"power\"\np = 3\n\
             [mollifier]\nkind = \"compact\"\norder = 4\n[[initial]]\nshape = \"disc\"\n\
             [sampling]\nkind = \"grid\"\nh = 0.1\n"
        }
        "particle" => {
            "model = \"particle\"\ndimension = 3\n[[kernel]]\nkind = \"power\"\np = 3\n\
             [[initial]]\nshape = \"disc\"\n[sampling]\nkind = \"grid\"\nh = 0.2\n"
        }
        "pks" => {
            "model = \"pks\"\ndimension = 2\n[pks]\nchi = 1\nmu = 1\n[[initial]]\nshape = \"bump\"\n\
             [sampling]\nkind = \"random\"\ncount = 100\n"
        }
        "species" => {
            "model = \"pks\"\ndimension = 2\n[pks]\nchi = 1\nmu = 1\n[[initial]]\nshape = \"bump\"\n\
             [[initial]]\nshape = \"bump\"\n[sampling]\nkind = \"random\"\ncount = 100\n"
        }
        "cluster" => {
            "model = \"cluster\"\ndimension = 2\n[pks]\nchi = 1\nmu = 1\n[[initial]]\nshape = \"points\"\n\
             points = [[0, 0], [1, 0], [0, 1]]\nmasses = [1, 1, 1]\n"
        }
        _ => "model = \"profile\"\ndimension = 3\n[mollifier]\nkind = \"compact\"\norder = 2\ndelta = 1\n",
    };
    let time = if model == "profile" { "" } else { "[time]\nend = 0.5\ndt = 0.01\n" };
    let output = if model == "profile" { String::new() } else { format!("[output]\nevery = 0.1\n{output}\n") };
    format!("title = \"T\"\n{own}{time}{output}{rest}")
}

/// The only mistake after its place, or `good`.
fn wrong(text: &str, path: &str) -> String {
    match mistakes(text).as_slice() {
        [] => "good".to_owned(),
        [one] => one.split_once(path).unwrap_or_else(|| panic!("{one}")).1.to_owned(),
        several => panic!("{several:?}"),
    }
}
