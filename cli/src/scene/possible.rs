//! Pictures and expectations against what the run records: what can't be drawn or measured is a mistake of the scene, found
//! before the first step rather than after the last.

use super::exact::Exact;
use super::mistake::Mistake;
use super::tree::Node;
use super::types::{Expectation, Model, Picture, Sampling, Scene};

/// The largest number of panels side by side in one picture.
const PANELS: usize = 60;

/// A spacing named in an expectation may miss the study's by this part: both are printed decimals.
const SAME_SPACING: f64 = 1e-3;

/// Where mistakes are noted: a table of the scene.
struct Place<'a> {
    node: &'a Node,
    path: String,
    mistakes: &'a mut Vec<Mistake>,
}

impl Place<'_> {
    fn wrong(&mut self, key: &str, text: impl std::fmt::Display) {
        let shown = self.node.get(key).map(|node| format!(" = {}", node.shown())).unwrap_or_default();
        self.mistakes
            .push(Mistake { line: self.node.line_of(key), text: format!("{}.{key}{shown}: {text}", self.path) });
    }
}

/// The spacings and the time that a run's errors are known at, or why they are not: of positions (0) or of densities (1).
fn errors(scene: &Scene, which: usize) -> Result<(), String> {
    if !matches!(scene.model, Model::Blob | Model::Particle) {
        return Err("not of this model".to_owned());
    }
    if let (1, Some(reason)) = (which, scene.lacks_density()) {
        return Err(format!("the run carries no density: {reason}"));
    }
    if scene.study.as_ref().is_some_and(|study| study.reference.is_some()) {
        return Ok(());
    }
    match scene.exact() {
        None => Err("no exact solution of this scene is known, and there is no study.reference".to_owned()),
        Some(exact) if scene.end >= exact.blow_up() => {
            Err(format!("the exact solution blows up at t = {}, and time.end is {}", exact.blow_up(), scene.end))
        }
        Some(_) => Ok(()),
    }
}

/// Notes what a picture asks for and the run doesn't have.
pub fn picture(picture: &Picture, node: &Node, index: usize, cases: &[Scene], mistakes: &mut Vec<Mistake>) {
    let mut place = Place { node, path: format!("picture[{index}]"), mistakes };
    let drawn = || cases.iter().filter(|case| picture.case.as_ref().is_none_or(|name| case.name == *name));
    let Some(first) = drawn().next() else { return };
    let kind = picture.kind.as_str();
    for case in drawn() {
        let of = if drawn().count() > 1 { format!(" (case {:?})", case.name) } else { String::new() };
        let needed = match (kind, case.model) {
            ("profile", model) if model != Model::Profile => Some("model = \"profile\""),
            ("count" | "field", model) if model != Model::Pks => Some("model = \"pks\""),
            ("trajectories" | "density" | "moment" | "particles", Model::Profile) => {
                Some("a model in which something moves")
            }
            ("convergence", _) if case.study.is_none() => Some("a study"),
            ("trajectories", _) if case.output.trajectories == 0 => Some("output.trajectories above 0"),
            ("particles", _) if case.dimension == 1 => Some("two dimensions"),
            ("density", _) if case.dimension == 3 => Some("one or two dimensions"),
            ("density" | "particles" | "field", _) if case.output.snapshots.is_empty() => Some("output.snapshots"),
            _ => None,
        };
        if let Some(needed) = needed {
            place.wrong("kind", format!("needs {needed}{of}"));
            return;
        }
        let planar = matches!(kind, "trajectories" | "density" | "particles" | "profile");
        if planar && case.dimension != first.dimension {
            place.wrong(
                "kind",
                format!("draws cases of one dimension; there are {} and {}", first.dimension, case.dimension),
            );
            return;
        }
        if let Some(time) = picture
            .times
            .iter()
            .find(|&&time| !case.output.snapshots.iter().any(|&step| case.step_at(time) == Some(step)))
        {
            place.wrong("times", format!("there is no snapshot at {time}; see output.snapshots{of}"));
        }
        let parts = case.initial.len();
        if picture.parts && (case.model != Model::Pks || parts < 2) {
            place.wrong("parts", format!("needs model = \"pks\" with several parts of the initial data{of}"));
        }
    }
    match kind {
        "trajectories" => trajectories(picture, first, &mut place),
        "density" if first.dimension == 1 => {
            if drawn().count() > 1 {
                place.wrong("case", "missing; densities on a line are drawn of one case");
            }
            if let Some(reason) = first.lacks_density() {
                place.wrong("kind", format!("the run carries no density: {reason}"));
            }
            exact(picture, first, &mut place);
        }
        "density" | "particles" | "field" => {
            if picture.exact {
                place.wrong("exact", "densities are compared with the exact solution in one dimension");
            }
            let panels =
                |case: &Scene| if picture.times.is_empty() { case.output.snapshots.len() } else { picture.times.len() };
            let panels: usize = drawn().map(panels).sum();
            if panels > PANELS {
                place.wrong("times", format!("{panels} panels; at most {PANELS}"));
            }
        }
        "convergence" => {
            let wanted: &[usize] = match picture.quantity.as_str() {
                "potential" => {
                    place.wrong("quantity", "must be positions or density in a picture of errors");
                    return;
                }
                "positions" => &[0],
                "density" => &[1],
                _ => &[0, 1],
            };
            // A case without one of the errors is left out; one curve there must be.
            let reasons: Result<Vec<String>, ()> =
                drawn().flat_map(|case| wanted.iter().map(|&which| errors(case, which).err().ok_or(()))).collect();
            if let Ok(reasons) = reasons {
                place.wrong(
                    "kind",
                    format!("there are no errors to draw: {}", reasons.first().map_or("", String::as_str)),
                );
            }
        }
        "profile" if picture.quantity == "positions" => {
            place.wrong("quantity", "must be density or potential in a picture of a mollifier");
        }
        _ => {}
    }
    if matches!(kind, "trajectories") && drawn().count() > PANELS && picture.plane.as_deref() != Some("xt") {
        place.wrong("kind", format!("{} panels; at most {PANELS}", drawn().count()));
    }
    let logarithmic =
        [("x", picture.x, kind == "convergence"), ("y", picture.y, matches!(kind, "convergence" | "count"))];
    for (key, range, log) in logarithmic {
        if log && range.is_some_and(|[low, _]| low <= 0.0) {
            place.wrong(key, "must be above 0 on a logarithmic axis");
        }
    }
    for (index, slope) in picture.slopes.iter().enumerate() {
        if slope.at > first.end {
            place.wrong("slope", format!("slope[{index}].at = {} is beyond time.end = {}", slope.at, first.end));
        }
    }
}

fn trajectories(picture: &Picture, first: &Scene, place: &mut Place<'_>) {
    let line = if first.dimension == 1 { "xt" } else { "xy" };
    let plane = picture.plane.as_deref().unwrap_or(line);
    if plane != "xt" {
        if first.dimension == 1 {
            place.wrong("plane", "needs two dimensions; in one there is xt");
        }
        if picture.exact {
            place.wrong("exact", "exact paths are drawn in the plane xt");
        }
    } else {
        exact(picture, first, place);
    }
}

fn exact(picture: &Picture, first: &Scene, place: &mut Place<'_>) {
    if picture.exact && Exact::of(first).is_none() {
        place.wrong("exact", "no exact solution of this scene is known");
    }
}

/// Notes what an expectation asks for and the run doesn't have.
pub fn expectation(expected: &Expectation, node: &Node, index: usize, cases: &[Scene], mistakes: &mut Vec<Mistake>) {
    let mut place = Place { node, path: format!("expect[{index}]"), mistakes };
    let Some(case) = cases.iter().find(|case| expected.case.as_ref().is_none_or(|name| case.name == *name)) else {
        return;
    };
    let quantity = expected.quantity.as_str();
    let part_column = format!("part_moment_{}", expected.part);
    let column = match quantity {
        "slope" | "slope_error" | "decay_rate" | "second_moment" => "second_moment",
        "part_slope" | "part_nonlinearity" => part_column.as_str(),
        "heavy_mass" => "heaviest",
        "particles" | "merges" => "particles",
        "density_maximum" => "density_maximum",
        "centre_drift" => "centre_x",
        "energy_rise" | "energy_drift" => "energy",
        "rotation_rate" => "axis_angle",
        "approximation_ratio" => "error_plain",
        "density_at_zero" | "potential_at_zero" => "potential",
        _ => "",
    };
    if !column.is_empty() && !case.has_column(column) {
        let hint = match column {
            "density_maximum" => case.lacks_density().unwrap_or(""),
            "energy" => "output.energy is not set",
            "axis_angle" => "combination has no turned gradient",
            _ => "",
        };
        let hint = if hint.is_empty() { String::new() } else { format!(" ({hint})") };
        place.wrong("quantity", format!("the run has no {column}{hint}; it has {}", case.columns().join(", ")));
        return;
    }
    match quantity {
        "error_positions" | "error_density" | "rate_positions" | "rate_density" => {
            if let Err(reason) = errors(case, usize::from(quantity.ends_with("density"))) {
                place.wrong("quantity", reason);
                return;
            }
            if quantity.starts_with("error") {
                error_at(expected, case, &mut place)
            } else {
                rate(expected, case, &mut place)
            }
        }
        "mean_radius" | "radius_spread" | "largest_radius" | "clusters" if case.model == Model::Profile => {
            place.wrong("quantity", "needs a model in which something moves");
        }
        "heavy_mass" if case.pks.is_some_and(|pks| pks.chi == 0.0) => {
            place.wrong("quantity", "is in critical masses, which are infinite for pks.chi = 0");
        }
        _ => {}
    }
    if !column.is_empty() && case.model != Model::Profile {
        in_time(expected, case, &mut place);
    }
}

/// The times of an expectation lie in the run, at rows.
fn in_time(expected: &Expectation, case: &Scene, place: &mut Place<'_>) {
    if let Some(at) = expected.at {
        match case.step_at(at) {
            Some(step) if case.has_row(step) => {}
            _ if at > case.end => place.wrong("at", format!("is beyond time.end = {}", case.end)),
            _ => place.wrong(
                "at",
                format!("no row of diagnostics is of this time; rows are {} apart", case.output.every as f64 * case.dt),
            ),
        }
    }
    let least = match expected.quantity.as_str() {
        "slope" | "decay_rate" | "rotation_rate" | "part_slope" | "part_nonlinearity" => 2,
        // Two points are on their line: they have no deviation.
        "slope_error" => 3,
        _ => return,
    };
    let end = case.steps as f64 * case.dt;
    let (from, to) = (expected.from.unwrap_or(0.0), expected.to.unwrap_or(end));
    for (key, time) in [("from", expected.from), ("to", expected.to)] {
        if time.is_some_and(|time| time > case.end) {
            place.wrong(key, format!("is beyond time.end = {}", case.end));
            return;
        }
    }
    let rows = case.rows_between(from, to);
    if from > to {
        place.wrong("from", format!("is above to = {to}"));
    } else if rows < least {
        let key = if expected.to.is_some() { "to" } else { "from" };
        place.wrong(
            key,
            format!("there are {rows} rows of diagnostics from {from} to {to}; {} needs {least}", expected.quantity),
        );
    }
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_SPACING * b
}

fn error_at(expected: &Expectation, case: &Scene, place: &mut Place<'_>) {
    let Some(at) = expected.at else { return };
    let spacings = match (&case.study, case.sampling) {
        (Some(study), _) => study.h.clone(),
        (None, Some(Sampling::Grid { h })) => vec![h],
        _ => Vec::new(),
    };
    if !spacings.iter().any(|&h| same(h, at)) {
        place.wrong("at", format!("there is no run of this spacing; there are {spacings:?}"));
    }
}

fn rate(expected: &Expectation, case: &Scene, place: &mut Place<'_>) {
    let Some(study) = &case.study else {
        place.wrong("quantity", "needs a study");
        return;
    };
    let spacings = &study.h;
    if let Some(at) = expected.at {
        if let Some(key) = ["from", "to"].into_iter().find(|key| place.node.get(key).is_some()) {
            place.wrong(key, "not used beside at");
        }
        match spacings.iter().position(|&h| same(h, at)) {
            None => place.wrong("at", format!("the study has no such spacing; it has {spacings:?}")),
            Some(0) => place.wrong("at", "the coarsest spacing has no rate"),
            Some(_) => {}
        }
        return;
    }
    let (from, to) = (expected.from.unwrap_or(0.0), expected.to.unwrap_or(f64::INFINITY));
    let held = spacings.iter().filter(|&&h| h >= from * (1.0 - SAME_SPACING) && h <= to * (1.0 + SAME_SPACING)).count();
    if from > to {
        place.wrong("from", format!("is above to = {to}"));
    } else if held < 2 {
        let key =
            ["to", "from", "quantity"].into_iter().find(|key| place.node.get(key).is_some()).unwrap_or("quantity");
        place.wrong(key, format!("{held} of the study's spacings {spacings:?} count; a rate needs two"));
    }
}
