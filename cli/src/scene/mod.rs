//! Scene files: what they may say, read with every mistake named by file, line and key.
//!
//! [`tree`] reads TOML with lines, [`schema`] states every key, [`check`] holds one against the other, [`build`] makes the
//! typed [`Scene`] of it and checks what concerns more than one key.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

mod build;
mod check;
mod schema;
mod tree;
mod types;

pub use types::*;

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
        print!("{}", schema::print());
    }
    let mut code = ExitCode::SUCCESS;
    for path in &args.scenes {
        for quick in [false, true] {
            match load(path, quick) {
                Ok(file) if !quick => println!("{}: good; {} run(s)", path.display(), file.cases.len()),
                Ok(_) => {}
                Err(error) => {
                    eprintln!("{error}");
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
    Ok(parse(&text, quick).map_err(|list| Mistakes { path: path.to_owned(), list })?)
}

/// The scene of a text; paths in it are not looked at.
fn parse(text: &str, quick: bool) -> Result<SceneFile, Vec<Mistake>> {
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
        match build::build(&trees) {
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
[[picture]]
name = "paths"
kind = "trajectories"
[quick]
sampling.h = 0.2
"#;

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
}
