//! Scene files: what they may say, read with every mistake named by file, line and key.
//!
//! [`tree`] reads TOML with lines, [`schema`] states every key, [`check`] holds one against the other, [`build`] makes the
//! typed [`Scene`] of it and checks what concerns more than one key, [`records`] says what its run records, [`possible`]
//! refuses pictures and expectations that such a run can't give, [`folders`] names where the data of cases go.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mollis_host::{complain, console, say};

mod build;
mod check;
mod folders;
mod possible;
mod records;
mod schema;
mod tree;
mod types;

pub use folders::{CHECKPOINT, SUMMARY};
pub use records::SLACK;
pub use types::*;

use crate::initial;
use build::Probe;
use tree::{Node, Value};

/// Arguments of `mollis scene`.
#[derive(clap::Args)]
pub struct Args {
    /// Print every key with its unit, range, default and meaning.
    #[arg(long)]
    schema: bool,
    /// Scene files to check without running them.
    #[arg(required_unless_present = "schema")]
    scenes: Vec<PathBuf>,
}

/// Runs `mollis scene`.
pub fn main(args: Args) -> anyhow::Result<ExitCode> {
    if args.schema {
        console::print(format_args!("{}", schema::print()))?;
    }
    let mut code = ExitCode::SUCCESS;
    for path in &args.scenes {
        for quick in [false, true] {
            match load(path, quick) {
                Ok(file) if !quick => say!("{}: good; {} run(s)", path.display(), file.cases.len())?,
                Ok(_) => {}
                Err(error) => {
                    complain!("{error:#}");
                    code = ExitCode::FAILURE;
                    break;
                }
            }
        }
    }
    Ok(code)
}

/// One mistake in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Line in the file, from 1.
    pub line: usize,
    /// Key, value and what is allowed.
    pub text: String,
}

/// All mistakes of a scene file, one a line.
#[derive(Debug)]
pub struct Mistakes {
    path: PathBuf,
    list: Vec<Mistake>,
}

impl std::fmt::Display for Mistakes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, mistake) in self.list.iter().enumerate() {
            let end = if index + 1 < self.list.len() { "\n" } else { "" };
            write!(f, "{}:{}: {}{end}", self.path.display(), mistake.line, mistake.text)?;
        }
        Ok(())
    }
}

impl std::error::Error for Mistakes {}

/// Reads and checks a scene file.
pub fn load(path: &Path, quick: bool) -> anyhow::Result<SceneFile> {
    let text = std::fs::read_to_string(path).map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let probe = |file: &Path, dimension: usize| initial::has_density(&folder.join(file), dimension);
    Ok(parse(&text, quick, &probe).map_err(|list| Mistakes { path: path.to_owned(), list })?)
}

/// The scene of a text; files that it names are left to `probe`.
fn parse(text: &str, quick: bool, probe: Probe<'_>) -> Result<SceneFile, Vec<Mistake>> {
    let whole = tree::parse(text).map_err(|mistake| vec![mistake])?;
    let mut base = whole.without("case").without("quick");
    if let (true, Some(quick)) = (quick, whole.get("quick")) {
        base = base.overlaid(quick);
    }
    let mut mistakes = Vec::new();
    let mut trees = Vec::new();
    match whole.get("case").map(|node| (node.line, &node.value)) {
        None => trees.push((String::new(), base.clone())),
        Some((_, Value::List(cases))) if !cases.is_empty() => {
            for (index, case) in cases.iter().enumerate() {
                match lay_case(&base, case, index, quick) {
                    Ok(case) => trees.push(case),
                    Err(mistake) => mistakes.push(mistake),
                }
            }
        }
        Some((line, _)) => mistakes.push(Mistake { line, text: "case: must be a list of tables: [[case]]".to_owned() }),
    }
    for (_, tree) in &trees {
        mistakes.extend(check::check(tree));
    }
    if mistakes.is_empty() {
        match build::build(&trees, probe) {
            Ok(mut file) => {
                text.clone_into(&mut file.text);
                return Ok(file);
            }
            Err(list) => mistakes = list,
        }
    }
    // Cases share most lines, hence most mistakes.
    mistakes.sort_by(|a, b| (a.line, &a.text).cmp(&(b.line, &b.text)));
    mistakes.dedup();
    Err(mistakes)
}

/// One case: its name and the whole scene with its changes.
fn lay_case(base: &Node, case: &Node, index: usize, quick: bool) -> Result<(String, Node), Mistake> {
    let wrong = |line, text| Mistake { line, text };
    let Some(Value::Text(name)) = case.get("name").map(|node| &node.value) else {
        return Err(wrong(case.line, format!("case[{index}].name: missing; text: the name of the case")));
    };
    if name.trim().is_empty() {
        return Err(wrong(case.line, format!("case[{index}].name = {name:?}: must not be empty")));
    }
    for key in ["picture", "expect", "case", "title", "source"] {
        if let Some(node) = case.get(key) {
            return Err(wrong(
                node.line,
                format!("case[{index}].{key}: belongs to the scene, not to one of its cases"),
            ));
        }
    }
    let mut changes = case.without("name").without("quick");
    if let (true, Some(quick)) = (quick, case.get("quick")) {
        changes = changes.overlaid(quick);
    }
    let mut laid = base.overlaid(&changes);
    // A case of another model drops what only the scene's own model uses.
    if let Some(Value::Text(model)) = changes.get("model").map(|node| &node.value) {
        let used = |key: &str| {
            let when = schema::SCENE.iter().find(|field| field.key == key).and_then(|field| field.when);
            when.is_none_or(|(_, models)| models.contains(&model.as_str()))
        };
        let entries =
            laid.entries().iter().filter(|(key, _)| used(key) || changes.get(key).is_some()).cloned().collect();
        laid = Node { value: Value::Table(entries), line: laid.line };
    }
    Ok((name.clone(), laid))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
title = "A bump"
model = "blob"
dimension = 2
[[kernel]]
kind = "newtonian"
[[kernel]]
kind = "power"
p = 3
[mollifier]
kind = "compact"
order = 4
[[initial]]
shape = "polynomial"
k = 2
[sampling]
kind = "grid"
h = 0.1
[time]
end = 0.5
dt = 0.025
[output]
trajectories = 5
[[picture]]
name = "paths"
kind = "trajectories"
[quick]
sampling.h = 0.2
"#;

    /// Files named `dense` hold densities, those named `none` can't be read.
    fn probe(path: &Path, _: usize) -> anyhow::Result<bool> {
        let name = path.to_string_lossy();
        anyhow::ensure!(!name.starts_with("none"), "no such file");
        Ok(name.starts_with("dense"))
    }

    fn parse(text: &str, quick: bool) -> Result<SceneFile, Vec<Mistake>> {
        super::parse(text, quick, &probe)
    }

    fn mistakes(text: &str) -> Vec<String> {
        match parse(text, false) {
            Ok(_) => Vec::new(),
            Err(list) => list.iter().map(|mistake| format!("{}: {}", mistake.line, mistake.text)).collect(),
        }
    }

    fn changed(from: &str, to: &str) -> Vec<String> {
        assert!(GOOD.contains(from), "{from}");
        mistakes(&GOOD.replacen(from, to, 1))
    }

    #[test]
    fn a_good_scene_is_read() {
        let file = parse(GOOD, false).unwrap();
        let scene = &file.cases[0];
        assert_eq!((scene.dimension, scene.kernel.len(), scene.sampling), (2, 2, Some(Sampling::Grid { h: 0.1 })));
        assert_eq!(parse(GOOD, true).unwrap().cases[0].sampling, Some(Sampling::Grid { h: 0.2 }));
    }

    #[test]
    fn mistakes_name_line_key_and_what_is_allowed() {
        assert_eq!(changed("p = 3", "p = -3"), ["9: kernel[1].p = -3: must be above 1 - d = -1"]);
        assert_eq!(changed("k = 2", "k = 2\nq = 1").len(), 1);
        assert!(
            changed("k = 2", "k = 2\nq = 1")[0]
                .starts_with("16: initial[0].q: unknown key; allowed here: shape, k, radius")
        );
        assert!(
            changed("k = 2", "path = \"x\"")
                .iter()
                .any(|m| m.contains("not used with initial[0].shape = \"polynomial\""))
        );
        assert!(changed("k = 2", "").iter().any(|m| m.starts_with("13: initial[0].k: missing")));
        assert_eq!(changed("h = 0.1", "h = 0"), ["18: sampling.h = 0: must be above 0"]);
        assert_eq!(changed("h = 0.1", "h = nan"), ["18: sampling.h = NaN: must be above 0"]);
        assert_eq!(changed("order = 4", "order = 5"), ["12: mollifier.order = 5: must be 2, 4, 6 or 8"]);
        assert_eq!(
            changed("dt = 0.025", "dt = 0.03"),
            ["21: time.dt = 0.03: time.end = 0.5 must be a whole number of steps"]
        );
        assert_eq!(
            changed("\"newtonian\"", "\"newton\"")[0],
            "6: kernel[0].kind = \"newton\": must be one of newtonian, power, exponential, screened"
        );
        assert_eq!(changed("dimension = 2", "dimension = 4"), ["4: dimension = 4: must be a whole number from 1 to 3"]);
        assert_eq!(changed("[time]", "[tyme]").len(), 2);
        assert!(changed("title = \"A bump\"", "title = \"A bump").iter().all(|m| m.starts_with("2: not TOML")));
    }

    #[test]
    fn gaussians_have_few_orders() {
        let text = GOOD.replace("\"compact\"", "\"gaussian\"").replace("order = 4", "order = 6");
        assert_eq!(mistakes(&text), ["12: mollifier.order = 6: a gaussian has order 4 or 6 in 1D, 4 in 2D"]);
    }

    #[test]
    fn cases_change_the_scene() {
        let text = format!(
            "{GOOD}[[case]]\nname = \"soft\"\n[[case]]\nname = \"hard\"\nmodel = \"particle\"\ntime.dt = 0.05\n"
        );
        let file = parse(&text, false).unwrap();
        assert_eq!(file.cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>(), ["soft", "hard"]);
        assert_eq!(file.cases[1].model, Model::Particle);
        assert!(file.cases[0].mollifier.is_some() && file.cases[1].mollifier.is_none());
        let text = format!("{GOOD}[[case]]\nname = \"a\"\n[[case]]\nname = \"a\"\n");
        assert!(mistakes(&text)[0].contains("twice"));
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

    /// What is wrong with one picture of a scene, without its place.
    fn picture(model: &str, output: &str, keys: &str) -> String {
        let text = scene(model, output, &format!("[[picture]]\nname = \"p\"\n{keys}\n"));
        wrong(&text, "picture[0].")
    }

    /// What is wrong with one expectation.
    fn expect(model: &str, output: &str, keys: &str) -> String {
        let bound = if ["least", "most", "value"].iter().any(|key| keys.contains(key)) { "" } else { "most = 1" };
        let text = scene(model, output, &format!("[[expect]]\n{keys}\n{bound}\nreason = \"r\"\n"));
        wrong(&text, "expect[0]")
    }

    fn wrong(text: &str, path: &str) -> String {
        match mistakes(text).as_slice() {
            [] => "good".to_owned(),
            [one] => one.split_once(path).unwrap_or_else(|| panic!("{one}")).1.to_owned(),
            several => panic!("{several:?}"),
        }
    }

    const SNAPSHOTS: &str = "snapshots = [0, 0.2, 0.5]";

    #[test]
    fn pictures_that_a_run_cannot_give_are_mistakes() {
        for (model, output, keys) in [
            ("line", "trajectories = 3", "kind = \"trajectories\"\nexact = true"),
            ("blob", "trajectories = 3", "kind = \"trajectories\"\nplane = \"xyt\""),
            ("blob", "trajectories = 3", "kind = \"trajectories\"\nplane = \"xt\""),
            ("line", "density = true\nsnapshots = [0.2]", "kind = \"density\"\nexact = true\ntimes = [0.2]"),
            ("blob", SNAPSHOTS, "kind = \"density\"\ntimes = [0.5, 0]"),
            ("pks", SNAPSHOTS, "kind = \"density\""),
            ("pks", SNAPSHOTS, "kind = \"field\"\ntimes = [0.2]"),
            ("pks", SNAPSHOTS, "kind = \"particles\""),
            ("particle", SNAPSHOTS, "kind = \"particles\""),
            ("pks", "", "kind = \"count\"\ny = [1, 100]"),
            ("species", "", "kind = \"moment\"\nparts = true"),
            ("blob", "", "kind = \"moment\"\nslope = [{ value = 1, at = 0.5 }]"),
            ("profile", "", "kind = \"profile\"\nquantity = \"potential\""),
            ("cluster", "trajectories = 3", "kind = \"trajectories\""),
        ] {
            assert_eq!(picture(model, output, keys), "good", "{model} {keys}");
        }
        for (model, output, keys, words) in [
            ("line", SNAPSHOTS, "kind = \"particles\"", "kind = \"particles\": needs two dimensions"),
            ("blob", "", "kind = \"trajectories\"", "kind = \"trajectories\": needs output.trajectories above 0"),
            (
                "line",
                "trajectories = 3",
                "kind = \"trajectories\"\nplane = \"xy\"",
                "plane = \"xy\": needs two dimensions",
            ),
            (
                "line",
                "trajectories = 3",
                "kind = \"trajectories\"\nplane = \"xyt\"",
                "plane = \"xyt\": needs two dimensions",
            ),
            (
                "blob",
                "trajectories = 3",
                "kind = \"trajectories\"\nexact = true",
                "exact = true: exact paths are drawn in the plane xt",
            ),
            (
                "blob",
                "trajectories = 3",
                "kind = \"trajectories\"\nplane = \"xt\"\nexact = true",
                "exact = true: no exact solution",
            ),
            (
                "profile",
                "",
                "kind = \"trajectories\"",
                "kind = \"trajectories\": needs a model in which something moves",
            ),
            ("profile", "", "kind = \"moment\"", "kind = \"moment\": needs a model in which something moves"),
            ("line", "density = true", "kind = \"density\"", "kind = \"density\": needs output.snapshots"),
            (
                "line",
                SNAPSHOTS,
                "kind = \"density\"",
                "kind = \"density\": the run carries no density: output.density is not set",
            ),
            ("particle", SNAPSHOTS, "kind = \"density\"", "kind = \"density\": needs one or two dimensions"),
            ("blob", SNAPSHOTS, "kind = \"density\"\nexact = true", "exact = true: densities are compared"),
            (
                "blob",
                SNAPSHOTS,
                "kind = \"density\"\ntimes = [0.2, 0.3]",
                "times = [0.2, 0.3]: there is no snapshot at 0.3",
            ),
            (
                "blob",
                SNAPSHOTS,
                "kind = \"density\"\ntimes = [0.205]",
                "times = [0.205]: there is no snapshot at 0.205",
            ),
            ("blob", SNAPSHOTS, "kind = \"particles\"\ntimes = [2]", "times = [2]: there is no snapshot at 2"),
            ("pks", "", "kind = \"field\"", "kind = \"field\": needs output.snapshots"),
            ("blob", SNAPSHOTS, "kind = \"field\"", "kind = \"field\": needs model = \"pks\""),
            ("cluster", SNAPSHOTS, "kind = \"field\"", "kind = \"field\": needs model = \"pks\""),
            ("blob", "", "kind = \"count\"", "kind = \"count\": needs model = \"pks\""),
            ("cluster", "", "kind = \"count\"", "kind = \"count\": needs model = \"pks\""),
            ("pks", "", "kind = \"count\"\ny = [0, 100]", "y = [0, 100]: must be above 0 on a logarithmic axis"),
            ("blob", "", "kind = \"convergence\"", "kind = \"convergence\": needs a study"),
            ("blob", "", "kind = \"profile\"", "kind = \"profile\": needs model = \"profile\""),
            (
                "profile",
                "",
                "kind = \"profile\"\nquantity = \"positions\"",
                "quantity = \"positions\": must be density or potential",
            ),
            ("pks", "", "kind = \"moment\"\nparts = true", "parts = true: needs model = \"pks\" with several parts"),
            ("blob", "", "kind = \"moment\"\nparts = true", "parts = true: needs model = \"pks\" with several parts"),
            (
                "blob",
                "",
                "kind = \"moment\"\nslope = [{ value = 1, at = 0.6 }]",
                "slope = [{ ... }]: slope[0].at = 0.6 is beyond time.end = 0.5",
            ),
            ("blob", "", "kind = \"moment\"\nexact = true", "exact: not used with picture[0].kind = \"moment\""),
        ] {
            let found = picture(model, output, keys);
            assert!(found.starts_with(words), "{model} {keys}: {found}");
        }
        let many: Vec<String> = (0..=50).map(|step| format!("{}", f64::from(step) / 100.0)).collect();
        let many =
            format!("snapshots = [{}, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1]", many.join(", "));
        assert!(picture("pks", &many, "kind = \"density\"").contains("61 panels; at most 60"));
        let long = "x".repeat(200);
        for name in ["", "a b", "../p", long.as_str(), "nul"] {
            let text = scene("pks", "", &format!("[[picture]]\nname = \"{name}\"\nkind = \"count\"\n"));
            assert!(mistakes(&text)[0].contains(&format!("picture[0].name = \"{name}\": must be")), "{name}");
        }
        let text = scene(
            "pks",
            "",
            "[[picture]]\nname = \"a\"\nkind = \"count\"\n[[picture]]\nname = \"A\"\nkind = \"count\"\n",
        );
        assert!(mistakes(&text)[0].contains("must be unique"));
    }

    #[test]
    fn expectations_that_a_run_cannot_meet_are_mistakes() {
        for (model, output, keys) in [
            ("line", "density = true", "quantity = \"error_density\""),
            ("line", "", "quantity = \"error_positions\"\nat = 0.04"),
            ("blob", "", "quantity = \"second_moment\"\nat = 0.3"),
            ("blob", "every = 0.04", "quantity = \"second_moment\"\nat = 0.5"),
            ("blob", "", "quantity = \"slope\"\nfrom = 0.4\nto = 0.5"),
            ("blob", "", "quantity = \"slope_error\"\nfrom = 0.3"),
            ("blob", "energy = true", "quantity = \"energy_rise\""),
            ("blob", "density = true", "quantity = \"density_maximum\"\nat = 0"),
            ("particle", "density = true", "quantity = \"density_maximum\""),
            ("pks", "", "quantity = \"heavy_mass\""),
            ("pks", "", "quantity = \"merges\"\nleast = 3\nmost = 3"),
            ("species", "", "quantity = \"part_slope\"\npart = 1"),
            ("cluster", "", "quantity = \"approximation_ratio\"\nat = 0.1"),
            ("profile", "", "quantity = \"density_at_zero\""),
        ] {
            let output = if output.contains("every") { "" } else { output };
            assert_eq!(expect(model, output, keys), "good", "{model} {keys}");
        }
        for (model, output, keys, words) in [
            ("blob", "", "quantity = \"clusters\"\nleast = 3\nmost = 2", ": no number is at least 3 and at most 2"),
            (
                "blob",
                "",
                "quantity = \"clusters\"\nvalue = 3\nband = 1\nmost = 1",
                ": no number is at least 2 and at most 1",
            ),
            (
                "blob",
                "",
                "quantity = \"clusters\"\nvalue = 3\nband = 1\nrelative = 1",
                ".relative: not used beside band",
            ),
            ("blob", "", "quantity = \"slope\"\nfrom = 0.4\nto = 0.2", ".from = 0.4: is above to = 0.2"),
            ("blob", "", "quantity = \"slope\"\nfrom = 0.2\nto = 0.6", ".to = 0.6: is beyond time.end = 0.5"),
            ("blob", "", "quantity = \"slope\"\nfrom = 0.7", ".from = 0.7: is beyond time.end = 0.5"),
            (
                "blob",
                "",
                "quantity = \"decay_rate\"\nfrom = 0.2\nto = 0.29",
                ".to = 0.29: there are 1 rows of diagnostics from 0.2 to 0.29",
            ),
            ("blob", "", "quantity = \"slope_error\"\nfrom = 0.4", ".from = 0.4: there are 2 rows"),
            ("blob", "", "quantity = \"slope\"\nat = 0.4", ".at: not used with expect[0].quantity = \"slope\""),
            ("blob", "", "quantity = \"slope\"\npart = 1", ".part: not used with expect[0].quantity = \"slope\""),
            ("blob", "", "quantity = \"clusters\"\nat = 0.4", ".at: not used with"),
            ("blob", "", "quantity = \"second_moment\"\nfrom = 0.4", ".from: not used with"),
            ("blob", "", "quantity = \"second_moment\"\nat = 0.6", ".at = 0.6: is beyond time.end = 0.5"),
            ("pks", "", "quantity = \"heavy_mass\"\nat = 7", ".at = 7: is beyond time.end = 0.5"),
            (
                "pks",
                "",
                "quantity = \"particles\"\nat = 0.25",
                ".at = 0.25: no row of diagnostics is of this time; rows are 0.1 apart",
            ),
            ("blob", "", "quantity = \"particles\"", ".quantity = \"particles\": the run has no particles"),
            ("blob", "", "quantity = \"merges\"", ".quantity = \"merges\": the run has no particles"),
            ("blob", "", "quantity = \"heavy_mass\"", ".quantity = \"heavy_mass\": the run has no heaviest"),
            (
                "blob",
                "",
                "quantity = \"energy_rise\"",
                ".quantity = \"energy_rise\": the run has no energy (output.energy is not set)",
            ),
            ("pks", "", "quantity = \"energy_rise\"", ".quantity = \"energy_rise\": the run has no energy"),
            (
                "blob",
                "",
                "quantity = \"density_maximum\"",
                ".quantity = \"density_maximum\": the run has no density_maximum (output.density is not set)",
            ),
            ("pks", "", "quantity = \"part_slope\"", ".quantity = \"part_slope\": the run has no part_moment_0"),
            (
                "species",
                "",
                "quantity = \"part_slope\"\npart = 2",
                ".quantity = \"part_slope\": the run has no part_moment_2",
            ),
            ("blob", "", "quantity = \"density_at_zero\"", ".quantity = \"density_at_zero\": the run has no potential"),
            ("profile", "", "quantity = \"slope\"", ".quantity = \"slope\": the run has no second_moment"),
            (
                "profile",
                "",
                "quantity = \"mean_radius\"",
                ".quantity = \"mean_radius\": needs a model in which something moves",
            ),
            ("cluster", "", "quantity = \"centre_drift\"", ".quantity = \"centre_drift\": the run has no centre_x"),
            (
                "pks",
                "",
                "quantity = \"approximation_ratio\"",
                ".quantity = \"approximation_ratio\": the run has no error_plain",
            ),
            ("blob", "", "quantity = \"error_positions\"", ".quantity = \"error_positions\": no exact solution"),
            (
                "line",
                "",
                "quantity = \"error_positions\"\nat = 0.02",
                ".at = 0.02: there is no run of this spacing; there are [0.04]",
            ),
            (
                "line",
                "",
                "quantity = \"error_density\"",
                ".quantity = \"error_density\": the run carries no density: output.density is not set",
            ),
            ("line", "", "quantity = \"rate_positions\"", ".quantity = \"rate_positions\": needs a study"),
            ("pks", "", "quantity = \"rate_positions\"", ".quantity = \"rate_positions\": not of this model"),
        ] {
            let found = expect(model, output, keys);
            assert!(found.starts_with(words), "{model} {keys}: {found}");
        }
        let late = scene("line", "", "[[expect]]\nquantity = \"error_positions\"\nmost = 1\nreason = \"r\"\n");
        assert!(
            wrong(&late.replace("end = 0.5", "end = 1"), "expect[0]").contains("the exact solution blows up at t = 1")
        );
        let infinite = scene("pks", "", "[[expect]]\nquantity = \"heavy_mass\"\nmost = 1\nreason = \"r\"\n");
        assert!(wrong(&infinite.replace("chi = 1", "chi = 0"), "expect[0]").contains("infinite for pks.chi = 0"));
    }

    #[test]
    fn studies_that_cannot_be_compared_are_mistakes() {
        let with = |study: &str, rest: &str| {
            let text = scene("blob", "density = true", &format!("[study]\n{study}\n{rest}"));
            wrong(&text, ": ")
        };
        let expect = |keys: &str| format!("[[expect]]\n{keys}\nmost = 1\nreason = \"r\"\n");
        let good = "h = [0.2, 0.1]\nreference = 0.05";
        assert_eq!(with(good, ""), "good");
        assert_eq!(with("h = [0.3, 0.1]\nreference = 0.1e-1", ""), "good");
        for (study, words) in [
            (
                "h = [0.2, 0.1]\nreference = 0.03",
                "study.reference = 0.03: must divide every study.h two times or more; 0.2 is",
            ),
            (
                "h = [0.2, 0.1]\nreference = 0.1",
                "study.reference = 0.1: must divide every study.h two times or more; 0.1 is 1",
            ),
            ("h = [0.2, 0.1]\nreference = 0.4", "study.reference = 0.4: must divide every"),
            ("h = [0.2, 0.1]\nreference = 0.0333333", "study.reference = 0.0333333: must divide"),
            ("h = [0.1, 0.2]\nreference = 0.05", "study.h: 0.2 after 0.1: must fall"),
            ("h = [0.1, 0.1]\nreference = 0.05", "study.h: 0.1 after 0.1: must fall"),
        ] {
            assert!(with(study, "").starts_with(words), "{study}: {}", with(study, ""));
        }
        let picture = "[[picture]]\nname = \"p\"\nkind = \"convergence\"\n";
        for rest in [
            picture.to_owned(),
            expect("quantity = \"rate_density\"\nat = 0.1"),
            expect("quantity = \"rate_positions\""),
            expect("quantity = \"error_density\"\nat = 0.2"),
        ] {
            assert_eq!(with(good, &rest), "good", "{rest}");
            assert!(with("h = [0.2, 0.1]", &rest).contains("no exact solution of this scene is known"), "{rest}");
        }
        for (keys, words) in [
            ("quantity = \"rate_positions\"\nat = 0.2", "the coarsest spacing has no rate"),
            ("quantity = \"rate_positions\"\nat = 0.15", "the study has no such spacing"),
            ("quantity = \"rate_positions\"\nat = 0.1\nto = 0.2", "not used beside at"),
            ("quantity = \"rate_positions\"\nfrom = 0.2\nto = 0.1", "is above to"),
            ("quantity = \"rate_positions\"\nto = 0.15", "1 of the study's spacings"),
            ("quantity = \"error_positions\"\nat = 0.15", "there is no run of this spacing"),
        ] {
            let found = with(good, &expect(keys));
            assert!(found.contains(words), "{keys}: {found}");
        }
        let found = with(good, &format!("{picture}x = [0, 1]\n"));
        assert!(found.contains("picture[0].x") || found.contains("must be above 0"), "{found}");
        let points = scene("blob", "", &format!("[study]\n{good}\n"))
            .replace("shape = \"disc\"", "shape = \"file\"\npath = \"dense\"");
        assert!(wrong(&points, ": ").contains("needs densities on grids, not points"));
    }

    #[test]
    fn data_that_a_model_cannot_take_are_mistakes() {
        let of = |model: &str, from: &str, to: &str| {
            let text = scene(model, "", "");
            assert!(text.contains(from), "{from}");
            wrong(&text.replacen(from, to, 1), ": ")
        };
        assert!(of("cluster", "[1, 1, 1]", "[1, 0, 1]").starts_with("initial[0].masses[1] = 0: must be above 0"));
        let four = of(
            "cluster",
            "points = [[0, 0], [1, 0], [0, 1]]\nmasses = [1, 1, 1]",
            "points = [[0, 0], [1, 1]]\nmasses = [1, 1]",
        );
        assert_eq!(four, "initial: 2 points: model = \"cluster\" needs three");
        assert!(of("pks", "mu = 1", "mu = 0\nheavy = 1").starts_with("pks.heavy: is in critical masses"));
        assert!(of("pks", "end = 0.5\ndt = 0.01", "end = 1e-12\ndt = 0.1").starts_with("time.dt = 0.1: time.end"));
        assert!(
            of("pks", "shape = \"bump\"", "shape = \"file\"\npath = \"none.csv\"")
                .starts_with("initial[0].path: no such file")
        );
    }

    /// Points without densities: the blob method sums its blobs, the particle method has none to sum.
    #[test]
    fn densities_of_points_are_carried_where_there_are_some() {
        let lacks = |model: &str, file: &str| {
            let text = scene(model, "density = true", "")
                .replace("shape = \"disc\"", &format!("shape = \"file\"\npath = \"{file}\""));
            let file = parse(&text, false).unwrap();
            (file.cases[0].lacks_density().is_some(), file.cases[0].has_column("density_maximum"))
        };
        assert_eq!((lacks("blob", "dense"), lacks("blob", "bare")), ((false, true), (false, true)));
        assert_eq!((lacks("particle", "dense"), lacks("particle", "bare")), ((false, true), (true, false)));
    }

    #[test]
    fn rows_are_counted_as_they_are_written() {
        let file = parse(&scene("blob", "", "").replace("every = 0.1", "every = 0.04"), false).unwrap();
        let case = &file.cases[0];
        let times: Vec<f64> =
            (0..=case.steps).filter(|&step| case.has_row(step)).map(|step| step as f64 * case.dt).collect();
        // 0, 0.04 ... 0.48, and the end.
        assert_eq!(times.len(), 14);
        for from in 0..60 {
            for to in from..60 {
                let (from, to) = (f64::from(from) * 0.01, f64::from(to) * 0.01);
                let counted = times.iter().filter(|&&t| t > from - 1e-8 && t < to + 1e-8).count() as u64;
                assert_eq!(case.rows_between(from, to), counted, "{from} {to}");
            }
        }
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
            [
                "a_b",
                "a_b-2",
                "A_B-3",
                "case",
                "case-2",
                "summary.json-2",
                "p.png-2",
                "P.SVG.new-2",
                "_nul",
                "m___4",
                cut
            ]
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
}
