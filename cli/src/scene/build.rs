//! From a checked tree to a typed scene, and the checks that concern more than one key.

use std::path::{Path, PathBuf};

use mollis_core::mollifier::Mollifier;

use super::mistake::Mistake;
use super::records::multiple;
use super::tree::{Node, Value};
use super::types::{
    Diffusion, Expectation, Law, Model, Output, Part, Picture, Pks, Sampling, Scene, SceneFile, Shape, Slope,
    Softening, Study, Term,
};
use super::{folders, possible};

/// Looks into a file of points for so many dimensions: whether it holds densities, or why it can't be read.
pub type Probe<'a> = &'a dyn Fn(&Path, usize) -> anyhow::Result<bool>;

/// The scene of checked trees, one a case.
pub fn build(trees: &[(String, Node)], probe: Probe<'_>) -> Result<SceneFile, Vec<Mistake>> {
    let mut mistakes = Vec::new();
    let Some((_, first)) = trees.first() else {
        return Err(vec![Mistake { line: 1, text: "case: must hold at least one table".to_owned() }]);
    };
    let mut cases: Vec<Scene> = Vec::with_capacity(trees.len());
    for (name, tree) in trees {
        if cases.iter().any(|case| case.name == *name) {
            mistakes.push(Mistake { line: tree.line, text: format!("case {name:?} stands twice") });
        }
        match scene(name, tree, probe, &mut mistakes) {
            Some(case) => cases.push(case),
            None => break,
        }
    }
    let title = text(first, "title").unwrap_or_default();
    let pictures = pictures(first, &title, &cases, &mut mistakes);
    let expectations = expectations(first, &cases, &mut mistakes);
    // What a run can show and measure is only asked of runs that are possible themselves.
    if mistakes.is_empty() {
        let list = |key: &str| first.get(key).map_or(&[][..], Node::elements).iter().enumerate();
        for ((index, node), picture) in list("picture").zip(&pictures) {
            possible::picture(picture, node, index, &cases, &mut mistakes);
        }
        for ((index, node), expectation) in list("expect").zip(&expectations) {
            possible::expectation(expectation, node, index, &cases, &mut mistakes);
        }
    }
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    folders::assign(&mut cases, &pictures);
    Ok(SceneFile {
        text: String::new(),
        title,
        source: text(first, "source").unwrap_or_default(),
        note: text(first, "note").unwrap_or_default(),
        cases,
        pictures,
        expectations,
    })
}

fn text(node: &Node, key: &str) -> Option<String> {
    match node.get(key).map(|node| &node.value) {
        Some(Value::Text(text)) => Some(text.clone()),
        _ => None,
    }
}

fn number(node: &Node, key: &str) -> Option<f64> {
    node.get(key).and_then(Node::number)
}

fn flag(node: &Node, key: &str) -> Option<bool> {
    match node.get(key).map(|node| &node.value) {
        Some(Value::Flag(flag)) => Some(*flag),
        _ => None,
    }
}

fn numbers(node: &Node, key: &str) -> Option<Vec<f64>> {
    node.get(key).map(|node| node.elements().iter().filter_map(Node::number).collect())
}

fn pair(node: &Node, key: &str) -> Option<[f64; 2]> {
    numbers(node, key)?.try_into().ok()
}

fn scene(name: &str, tree: &Node, probe: Probe<'_>, mistakes: &mut Vec<Mistake>) -> Option<Scene> {
    let dimension = number(tree, "dimension")? as usize;
    let model = match text(tree, "model")?.as_str() {
        "blob" => Model::Blob,
        "particle" => Model::Particle,
        "pks" => Model::Pks,
        "cluster" => Model::Cluster,
        _ => Model::Profile,
    };
    let empty = Node::empty();
    let part = |key: &str| tree.get(key).unwrap_or(&empty);
    if matches!(model, Model::Pks | Model::Cluster) && dimension != 2 {
        let text = format!("dimension = {dimension}: model = {:?} is planar: must be 2", text(tree, "model")?);
        mistakes.push(Mistake { line: tree.line_of("dimension"), text });
    }
    let kernel = kernel(part("kernel"), dimension, mistakes);
    let combination = combination(tree, dimension, mistakes);
    let diffusion = tree.get("diffusion").map(|node| {
        let on_grid = text(part("sampling"), "kind").as_deref() == Some("grid");
        diffusion(node, on_grid, mistakes)
    });
    let initial: Vec<Part> = part("initial")
        .elements()
        .iter()
        .enumerate()
        .map(|(index, node)| initial(node, index, dimension, probe, mistakes))
        .collect();
    let sampling_node = part("sampling");
    let sampling = match text(sampling_node, "kind").as_deref() {
        Some("grid") => Some(Sampling::Grid { h: number(sampling_node, "h")? }),
        Some(_) => Some(Sampling::Random { count: number(sampling_node, "count")? as u64 }),
        None => None,
    };
    // A particle carries the number of its part in a byte.
    if initial.len() > 256 {
        let text = format!("initial: {} parts: at most 256", initial.len());
        mistakes.push(Mistake { line: tree.line_of("initial"), text });
    }
    let given = |part: &Part| !part.shape.is_sampled();
    if sampling.is_none() && !initial.iter().all(given) {
        let text = "sampling: missing; a density needs `kind = \"grid\"` with `h`, or `kind = \"random\"` with `count`";
        mistakes.push(Mistake { line: tree.line, text: text.to_owned() });
    }
    let study = tree
        .get("study")
        .map(|node| Study { h: numbers(node, "h").unwrap_or_default(), reference: number(node, "reference") });
    let has_h = matches!(sampling, Some(Sampling::Grid { .. }));
    if let (Some(_), false) = (&study, has_h) {
        mistakes
            .push(Mistake { line: tree.line_of("study"), text: "study: needs sampling.kind = \"grid\"".to_owned() });
    }
    let mollifier = tree.get("mollifier").map(|node| softening(node, has_h || model == Model::Profile, mistakes));
    let time = part("time");
    let (end, dt) = (number(time, "end").unwrap_or(0.0), number(time, "dt").unwrap_or(1.0));
    let moves = model != Model::Profile;
    let steps = multiple(end, dt).filter(|&steps| steps > 0 || !moves).unwrap_or_else(|| {
        mistakes.push(Mistake {
            line: time.line_of("dt"),
            text: format!("time.dt = {dt}: time.end = {end} must be a whole number of steps"),
        });
        1
    });
    if let (Some(study), Some(node)) = (&study, tree.get("study")) {
        self::study(study, node, initial.iter().all(|part| !given(part)), mistakes);
    }
    let pks = tree.get("pks").map(|node| pks(node, mistakes));
    stochastic(model, &initial, pks.as_ref(), tree, mistakes);
    Some(Scene {
        name: name.to_owned(),
        folder: String::new(),
        model,
        dimension,
        seed: number(tree, "seed").unwrap_or(1.0) as u64,
        kernel,
        combination,
        diffusion,
        mollifier,
        initial,
        sampling,
        end,
        dt,
        steps,
        direct: text(part("method"), "sum").as_deref() == Some("direct"),
        tolerance: number(part("method"), "tolerance").unwrap_or(1e-12),
        pks,
        study,
        output: output(part("output"), end, dt, steps, mistakes),
    })
}

/// A study's spacings fall, and its reference holds their points.
fn study(study: &Study, node: &Node, sampled: bool, mistakes: &mut Vec<Mistake>) {
    let mut wrong = |key: &str, text: String| mistakes.push(Mistake { line: node.line_of(key), text });
    if let Some(pair) = study.h.windows(2).find(|pair| pair[1] >= pair[0]) {
        wrong("h", format!("study.h: {} after {}: must fall from coarse to fine", pair[1], pair[0]));
    }
    let Some(reference) = study.reference else { return };
    // Stricter than for times: the points themselves are compared.
    let divides = |h: f64| {
        let ratio = h / reference;
        ratio.round() >= 2.0 && (ratio - ratio.round()).abs() <= 1e-12 * ratio
    };
    if let Some(h) = study.h.iter().find(|&&h| !divides(h)) {
        let text = format!(
            "study.reference = {reference}: must divide every study.h two times or more; {h} is {} times as large",
            h / reference
        );
        wrong("reference", text);
    }
    if !sampled {
        wrong("reference", format!("study.reference = {reference}: needs densities on grids, not points"));
    }
}

/// What coalescing particles ask of their data.
fn stochastic(model: Model, initial: &[Part], pks: Option<&Pks>, tree: &Node, mistakes: &mut Vec<Mistake>) {
    if !matches!(model, Model::Pks | Model::Cluster) {
        return;
    }
    let nodes = tree.get("initial").map_or(&[][..], Node::elements);
    let mut points = 0;
    let mut all_given = true;
    for (index, (part, node)) in initial.iter().zip(nodes).enumerate() {
        let Shape::Points(places, masses) = &part.shape else {
            all_given = false;
            continue;
        };
        points += places.len();
        if let Some((at, mass)) = masses.iter().enumerate().find(|(_, mass)| **mass <= 0.0) {
            let text = format!("initial[{index}].masses[{at}] = {mass}: must be above 0 with coalescing particles");
            mistakes.push(Mistake { line: node.line_of("masses"), text });
        }
    }
    if model == Model::Cluster && all_given && points != 3 {
        let text = format!("initial: {points} points: model = \"cluster\" needs three");
        mistakes.push(Mistake { line: tree.line_of("initial"), text });
    }
    if let (Model::Pks, Some(Pks { heavy: Some(_), mu: 0.0, chi, .. }), Some(node)) = (model, pks, tree.get("pks"))
        && *chi > 0.0
    {
        let text = "pks.heavy: is in critical masses, which are 0 for pks.mu = 0".to_owned();
        mistakes.push(Mistake { line: node.line_of("heavy"), text });
    }
    if let (Model::Pks, Some(Pks { heavy: Some(_), .. }), Some(node)) = (model, pks, tree.get("pks"))
        && initial.iter().any(|part| part.sensitivity.is_some())
    {
        let text = "pks.heavy: not used beside initial.sensitivity".to_owned();
        mistakes.push(Mistake { line: node.line_of("heavy"), text });
    }
}

fn combination(tree: &Node, dimension: usize, mistakes: &mut Vec<Mistake>) -> [f64; 2] {
    let read = pair(tree, "combination").unwrap_or([1.0, 0.0]);
    if dimension != 2 && read != [1.0, 0.0] {
        let text = format!("combination = {read:?}: only in two dimensions; else [1, 0]");
        mistakes.push(Mistake { line: tree.line_of("combination"), text });
    }
    read
}

fn diffusion(node: &Node, has_h: bool, mistakes: &mut Vec<Mistake>) -> Diffusion {
    let exponent = number(node, "exponent").unwrap_or(1.0);
    let empty = Node::empty();
    let blobs = node.get("mollifier").unwrap_or(&empty);
    let softening = softening(blobs, has_h, mistakes);
    let order = softening.mollifier.order();
    if exponent < 1.0 {
        let text = format!("diffusion.exponent = {exponent}: must be 1 or more");
        mistakes.push(Mistake { line: node.line_of("exponent"), text });
    }
    let whole = exponent > 1.0 && exponent <= 64.0 && exponent.fract() == 0.0;
    if order > 2 && !whole {
        let text = format!(
            "diffusion.mollifier.order = {order}: changes sign; must be 2, as diffusion.exponent = {exponent} is no whole number from 2 to 64"
        );
        mistakes.push(Mistake { line: blobs.line_of("order"), text });
    }
    if let Mollifier::Richardson { .. } = softening.mollifier {
        let text = "diffusion.mollifier.kind = \"richardson\": not of diffusion; must be \"compact\" or \"gaussian\""
            .to_owned();
        mistakes.push(Mistake { line: blobs.line_of("kind"), text });
    }
    if matches!(softening.mollifier, Mollifier::Compact { exponent: ..2, .. }) {
        let text =
            "diffusion.mollifier.exponent = 1: must be 2 or more, for blobs with a slope at their edge".to_owned();
        mistakes.push(Mistake { line: blobs.line_of("exponent"), text });
    }
    Diffusion { coefficient: number(node, "coefficient").unwrap_or(1.0), exponent, mollifier: softening }
}

fn kernel(list: &Node, dimension: usize, mistakes: &mut Vec<Mistake>) -> Vec<Term> {
    let elements = list.elements();
    if elements.len() > 8 {
        mistakes.push(Mistake { line: list.line, text: format!("kernel: {} terms: at most 8", elements.len()) });
    }
    let term = |(index, node): (usize, &Node)| {
        let law = match text(node, "kind").as_deref() {
            Some("power") => {
                let p = number(node, "p").unwrap_or(f64::NAN);
                let low = 1.0 - dimension as f64;
                // A power's gradient |x|^(p-1) must be integrable: p > 1 - d.
                if p <= low {
                    mistakes.push(Mistake {
                        line: node.line_of("p"),
                        text: format!("kernel[{index}].p = {p}: must be above 1 - d = {low}"),
                    });
                }
                Law::Power(p)
            }
            Some("exponential") => Law::Exponential(number(node, "length").unwrap_or(1.0)),
            Some("screened") => Law::Screened(number(node, "k").unwrap_or(1.0)),
            Some("newtonian") | None => Law::Newtonian,
            Some(kind) => {
                mistakes.push(Mistake {
                    line: node.line_of("kind"),
                    text: format!("kernel[{index}].kind: unknown: {kind}"),
                });
                Law::Newtonian
            }
        };
        Term { law, coefficient: number(node, "coefficient").unwrap_or(1.0) }
    };
    elements.iter().enumerate().map(term).collect()
}

fn softening(node: &Node, has_h: bool, mistakes: &mut Vec<Mistake>) -> Softening {
    let order = number(node, "order").unwrap_or(4.0) as u32;
    let exponent = number(node, "exponent").unwrap_or(4.0) as u32;
    let mollifier = match text(node, "kind").as_deref() {
        Some("compact") => Mollifier::Compact { order, exponent },
        Some("richardson") => Mollifier::Richardson { order, exponent },
        _ => Mollifier::Gaussian { order },
    };
    let mut wrong = |text: &str| {
        mistakes.push(Mistake { line: node.line_of("order"), text: format!("mollifier.order = {order}: {text}") })
    };
    match mollifier {
        Mollifier::Compact { order, .. } if order % 2 == 1 => wrong("must be 2, 4, 6 or 8"),
        Mollifier::Richardson { order, .. } if !matches!(order, 4 | 6 | 8) => {
            wrong("a combination has order 4, 6 or 8")
        }
        Mollifier::Gaussian { order } if !matches!(order, 2 | 4 | 6) => wrong("a gaussian has order 2, 4 or 6"),
        _ => {}
    }
    let delta = number(node, "delta");
    if delta.is_none() && !has_h {
        mistakes.push(Mistake {
            line: node.line,
            text: "mollifier.delta: missing; only a grid has a spacing h to take it from".to_owned(),
        });
    }
    if let (Some(_), Some(other)) = (delta, ["scale", "power"].iter().find(|key| node.get(key).is_some())) {
        mistakes.push(Mistake {
            line: node.line_of(other),
            text: format!("mollifier.{other}: not used beside mollifier.delta"),
        });
    }
    Softening {
        mollifier,
        delta,
        scale: number(node, "scale").unwrap_or(1.0),
        power: number(node, "power").unwrap_or(0.9),
    }
}

fn initial(node: &Node, index: usize, dimension: usize, probe: Probe<'_>, mistakes: &mut Vec<Mistake>) -> Part {
    let mut wrong = |key: &str, text: String| {
        mistakes.push(Mistake { line: node.line_of(key), text: format!("initial[{index}].{key}{text}") })
    };
    let shape = match text(node, "shape").as_deref() {
        Some("polynomial") => Shape::Polynomial(number(node, "k").unwrap_or(0.0) as u32),
        Some("bump") => Shape::Bump,
        Some("star") => {
            if dimension != 2 {
                wrong("shape", " = \"star\": only in two dimensions".to_owned());
            }
            Shape::Star
        }
        Some("points") => {
            let coordinates = |point: &Node| point.elements().iter().filter_map(Node::number).collect::<Vec<_>>();
            let points: Vec<Vec<f64>> =
                node.get("points").map_or(Vec::new(), |p| p.elements().iter().map(coordinates).collect());
            let masses = numbers(node, "masses").unwrap_or_default();
            if masses.len() != points.len() {
                wrong("masses", format!(": {} masses for {} points", masses.len(), points.len()));
            }
            Shape::Points(points, masses)
        }
        Some("file") => {
            let path = PathBuf::from(text(node, "path").unwrap_or_default());
            let density = probe(&path, dimension).unwrap_or_else(|error| {
                wrong("path", format!(": {error:#}"));
                false
            });
            Shape::File(path, density)
        }
        other => {
            if other == Some("ellipse") && node.get("axes").is_none() {
                wrong("axes", ": missing; half the width along each axis".to_owned());
            }
            Shape::Flat
        }
    };
    if node.get("radius").is_some() && node.get("axes").is_some() {
        wrong("radius", ": not used beside axes".to_owned());
    }
    if node.get("height").is_some() && node.get("mass").is_some() {
        wrong("height", ": not used beside mass".to_owned());
    }
    Part {
        shape,
        axes: numbers(node, "axes").unwrap_or_else(|| vec![number(node, "radius").unwrap_or(1.0); dimension]),
        center: numbers(node, "center").unwrap_or_else(|| vec![0.0; dimension]),
        height: number(node, "height").unwrap_or(1.0),
        mass: number(node, "mass"),
        share: number(node, "share"),
        diffusivity: number(node, "diffusivity"),
        sensitivity: number(node, "sensitivity"),
    }
}

fn pks(node: &Node, mistakes: &mut Vec<Mistake>) -> Pks {
    let mesh = numbers(node, "mesh").unwrap_or_else(|| vec![270.0, 270.0]);
    let read = Pks {
        chi: number(node, "chi").unwrap_or(1.0),
        mu: number(node, "mu").unwrap_or(1.0),
        mesh: [mesh[0] as usize, mesh[1] as usize],
        x: pair(node, "x").unwrap_or([-15.0, 15.0]),
        y: pair(node, "y").unwrap_or([-15.0, 15.0]),
        quadrupole: text(node, "border").as_deref() == Some("quadrupole"),
        fourth: text(node, "scheme").as_deref() == Some("fourth"),
        heavy: number(node, "heavy"),
        printed: text(node, "law").as_deref() == Some("printed"),
        hard: text(node, "collapse").as_deref() == Some("hard"),
        cell: number(node, "cell").unwrap_or(1.0),
        separation: number(node, "separation").unwrap_or(0.1),
        probability: number(node, "probability").unwrap_or(1e-4),
    };
    let side = |[low, high]: [f64; 2], cells: usize| (high - low) / cells as f64;
    let (h, k) = (side(read.x, read.mesh[0]), side(read.y, read.mesh[1]));
    if read.fourth && h.max(k) > 1.25 * h.min(k) {
        let text = format!(
            "pks.scheme = \"fourth\": needs cells whose sides are within a factor of 1.25; they are {h} and {k}"
        );
        mistakes.push(Mistake { line: node.line_of("scheme"), text });
    }
    read
}

fn output(node: &Node, end: f64, dt: f64, steps: u64, mistakes: &mut Vec<Mistake>) -> Output {
    let mut wrong = |key: &str, text: String| mistakes.push(Mistake { line: node.line_of(key), text });
    let every = match number(node, "every") {
        Some(every) => multiple(every, dt).filter(|&steps| steps > 0).unwrap_or_else(|| {
            wrong("every", format!("output.every = {every}: must be a whole number of steps of time.dt = {dt}"));
            1
        }),
        None => steps.div_ceil(100).max(1),
    };
    let snapshots = numbers(node, "snapshots").unwrap_or_default();
    let snapshots = snapshots.iter().enumerate().map(|(index, &time)| match multiple(time, dt) {
        Some(step) if step <= steps => step,
        _ => {
            wrong("snapshots", format!("output.snapshots[{index}] = {time}: must be a whole number of steps of {dt}, up to time.end = {end}"));
            0
        }
    });
    let snapshots = snapshots.collect();
    let particles = node.get("particles").map_or_else(
        || vec!["npy".to_owned()],
        |list| {
            list.elements()
                .iter()
                .filter_map(|element| match &element.value {
                    Value::Text(text) => Some(text.clone()),
                    _ => None,
                })
                .collect()
        },
    );
    Output {
        every,
        trajectories: number(node, "trajectories").unwrap_or(0.0) as usize,
        snapshots,
        particles,
        density: flag(node, "density").unwrap_or(false),
        energy: flag(node, "energy").unwrap_or(false),
        events: flag(node, "events").unwrap_or(true),
    }
}

fn known_case(node: &Node, path: &str, cases: &[Scene], mistakes: &mut Vec<Mistake>) -> Option<String> {
    let name = text(node, "case")?;
    if !cases.iter().any(|case| case.name == name) {
        let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
        let text = format!("{path}.case = {name:?}: no such case; there are: {}", names.join(", "));
        mistakes.push(Mistake { line: node.line_of("case"), text });
    }
    Some(name)
}

fn pictures(tree: &Node, title: &str, cases: &[Scene], mistakes: &mut Vec<Mistake>) -> Vec<Picture> {
    let mut pictures: Vec<Picture> = Vec::new();
    for (index, node) in tree.get("picture").map_or(&[][..], Node::elements).iter().enumerate() {
        let path = format!("picture[{index}]");
        let name = text(node, "name").unwrap_or_default();
        let plain = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
        let mut wrong = |text: &str| {
            mistakes.push(Mistake { line: node.line_of("name"), text: format!("{path}.name = {name:?}: {text}") });
        };
        // Some file systems take a and A for the same letter.
        if !plain || pictures.iter().any(|picture| picture.name.eq_ignore_ascii_case(&name)) {
            wrong("must be unique and hold only letters, digits, - and _");
        } else if name.len() > folders::LONGEST || folders::is_device(&name) {
            wrong(&format!("must be a file's name: at most {} letters, and no device's", folders::LONGEST));
        }
        let slope = |node: &Node| {
            let value = number(node, "value")?;
            let label = text(node, "label").unwrap_or_else(|| format!("slope {value}"));
            Some(Slope { value, at: number(node, "at")?, label })
        };
        pictures.push(Picture {
            name,
            kind: text(node, "kind").unwrap_or_default(),
            title: text(node, "title").unwrap_or_else(|| title.to_owned()),
            case: known_case(node, &path, cases, mistakes),
            x: pair(node, "x"),
            y: pair(node, "y"),
            exact: flag(node, "exact").unwrap_or(false),
            plane: text(node, "plane"),
            times: numbers(node, "times").unwrap_or_default(),
            quantity: text(node, "quantity").unwrap_or_default(),
            rates: numbers(node, "rates").unwrap_or_default(),
            parts: flag(node, "parts").unwrap_or(false),
            slopes: node.get("slope").map_or(Vec::new(), |list| list.elements().iter().filter_map(slope).collect()),
        });
    }
    pictures
}

fn expectations(tree: &Node, cases: &[Scene], mistakes: &mut Vec<Mistake>) -> Vec<Expectation> {
    let mut expectations = Vec::new();
    for (index, node) in tree.get("expect").map_or(&[][..], Node::elements).iter().enumerate() {
        let path = format!("expect[{index}]");
        let value = number(node, "value");
        let band = number(node, "band").or_else(|| Some(number(node, "relative")? * value?.abs()));
        let (least, most) = (number(node, "least"), number(node, "most"));
        match (value, band, least.or(most)) {
            (Some(_), Some(_), _) | (None, None, Some(_)) => {}
            _ => {
                let text = format!("{path}: needs `value` with `band` or `relative`, or else `least` or `most`");
                mistakes.push(Mistake { line: node.line, text });
            }
        }
        if node.get("band").is_some() && node.get("relative").is_some() {
            let text = format!("{path}.relative: not used beside band");
            mistakes.push(Mistake { line: node.line_of("relative"), text });
        }
        if cases.len() > 1 && node.get("case").is_none() {
            let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
            mistakes
                .push(Mistake { line: node.line, text: format!("{path}.case: missing; one of: {}", names.join(", ")) });
        }
        let case = known_case(node, &path, cases, mistakes);
        let low = value.zip(band).map_or(f64::NEG_INFINITY, |(v, b)| v - b);
        let high = value.zip(band).map_or(f64::INFINITY, |(v, b)| v + b);
        let (least, most) = (least.map_or(low, |l| l.max(low)), most.map_or(high, |m| m.min(high)));
        if least > most {
            let text = format!("{path}: no number is at least {least} and at most {most}");
            mistakes.push(Mistake { line: node.line, text });
        }
        expectations.push(Expectation {
            quantity: text(node, "quantity").unwrap_or_default(),
            case,
            at: number(node, "at"),
            from: number(node, "from"),
            to: number(node, "to"),
            part: number(node, "part").unwrap_or(0.0) as usize,
            value,
            least,
            most,
            paper: text(node, "paper").unwrap_or_default(),
            reason: text(node, "reason").unwrap_or_default(),
        });
    }
    expectations
}
