//! A scene file with its cases and its quick size, from text to typed scenes.

use std::path::Path;

use super::build::{self, Probe};
use super::check;
use super::mistake::{Mistake, Mistakes};
use super::schema;
use super::tree::{self, Node, Value};
use super::types::SceneFile;
use crate::points;

/// Reads and checks a scene file.
pub fn load(path: &Path, quick: bool) -> anyhow::Result<SceneFile> {
    let text = std::fs::read_to_string(path).map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let probe = |file: &Path, dimension: usize| points::has_density(&folder.join(file), dimension);
    Ok(parse(&text, quick, &probe).map_err(|list| Mistakes { path: path.to_owned(), list })?)
}

/// The scene of a text; files that it names are left to `probe`.
pub fn parse(text: &str, quick: bool, probe: Probe<'_>) -> Result<SceneFile, Vec<Mistake>> {
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
