//! Charts of curves: paths, densities on a line, moments, counts, errors, mollifiers.

use anyhow::{Context, Result, ensure};

use super::axis::Axis;
use super::canvas::{Canvas, Color};
use super::chart::{COLORS, Chart, Curve, DASHED, DASHES, DOTTED, MARKS, sheet};
use crate::results::CaseResult;
use crate::scene::{Exact, Picture};

const WIDTH: u32 = 720;
const HEIGHT: u32 = 540;
const GREY: Color = [150, 150, 150];

/// The axes of a picture: its own ranges, or around the curves.
fn fit(picture: &Picture, chart: &mut Chart) {
    let of = |axis: usize| chart.curves.iter().flat_map(move |curve| curve.points.iter().map(move |point| point[axis]));
    let (x_log, y_log) = (chart.x.log, chart.y.log);
    chart.x = picture
        .x
        .map_or_else(|| Axis::around(of(0), x_log), |range| Axis { low: range[0], high: range[1], log: x_log });
    chart.y = picture
        .y
        .map_or_else(|| Axis::around(of(1), y_log), |range| Axis { low: range[0], high: range[1], log: y_log });
}

fn empty(picture: &Picture, x: &str, y: &str, logs: [bool; 2]) -> Chart {
    let axis = |log| Axis { low: 1.0, high: 2.0, log };
    Chart::new(&picture.title, x, y, axis(logs[0]), axis(logs[1]))
}

fn single(chart: Chart) -> Canvas {
    sheet("", &[chart], 1, WIDTH, HEIGHT)
}

/// Paths of the followed particles.
pub fn trajectories(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    let d = results[0].scene.dimension;
    let plane = picture.plane.as_deref().unwrap_or(if d == 1 { "xt" } else { "xy" });
    ensure!(d > 1 || plane == "xt", "plane {plane:?} needs two dimensions");
    match plane {
        "xt" => in_time(picture, results, d),
        _ => in_space(picture, results, d, plane == "xyt"),
    }
}

/// Time upwards, one curve a particle. The exact solution is solid and lighter, the computed one dashed over it.
fn in_time(picture: &Picture, results: &[&CaseResult<'_>], d: usize) -> Result<Canvas> {
    let mut chart = empty(picture, "position x", "time t", [false; 2]);
    if picture.exact {
        let result = results[0];
        let exact = Exact::of(result.scene).context("no exact solution of this scene is known")?;
        let times: Vec<f64> = (0..=200).map(|i| result.scene.end.min(exact.blow_up()) * f64::from(i) / 200.0).collect();
        for (index, start) in result.main.followed.chunks_exact(d).enumerate() {
            let points = times.iter().map(|&t| [exact.position(start, t)[0], t]).collect();
            let label = if index == 0 { "exact" } else { "" };
            chart.curves.push(Curve { width: 2.4, ..Curve::line(label, points, [170, 185, 205]) });
        }
    }
    for (case, result) in results.iter().enumerate() {
        let paths = &result.main.paths;
        ensure!(!paths.is_empty(), "output.trajectories is 0");
        for index in 0..result.main.followed.len() / d {
            let points = paths.iter().map(|(t, x)| [x[index * d], *t]).collect();
            let name = if result.scene.name.is_empty() { "computed" } else { &result.scene.name };
            let label = if index == 0 && (picture.exact || results.len() > 1) { name } else { "" };
            let dash = if picture.exact { DASHED } else { DASHES[case % DASHES.len()] };
            chart.curves.push(Curve { dash, width: 1.3, ..Curve::line(label, points, COLORS[case % COLORS.len()]) });
        }
    }
    fit(picture, &mut chart);
    Ok(single(chart))
}

/// Paths in the plane, or in an oblique view with time upwards; open circles where they start, discs where they end.
fn in_space(picture: &Picture, results: &[&CaseResult<'_>], d: usize, oblique: bool) -> Result<Canvas> {
    let mut charts = Vec::new();
    for result in results {
        let paths = &result.main.paths;
        ensure!(!paths.is_empty(), "output.trajectories is 0");
        let (first, last) = (paths[0].0, paths[paths.len() - 1].0);
        let reach = result.main.followed.iter().fold(0.0_f64, |reach, x| reach.max(x.abs())).max(1e-300);
        // Cavalier view: y recedes to the upper right, and the whole time is twice the set's radius high.
        let place = |t: f64, x: &[f64]| {
            if oblique {
                [x[0] + 0.4 * x[1], 0.28 * x[1] + 2.6 * reach * (t - first) / (last - first)]
            } else {
                [x[0], x[1]]
            }
        };
        let title = if results.len() > 1 { result.scene.name.clone() } else { picture.title.clone() };
        let (x, y) = if oblique { ("x and (receding) y", "time upwards") } else { ("x", "y") };
        let mut chart = Chart::new(&title, x, y, Axis::fixed([0.0, 1.0]), Axis::fixed([0.0, 1.0]));
        let count = result.main.followed.len() / d;
        let path = |index: usize| paths.iter().map(|(t, x)| place(*t, &x[index * d..])).collect::<Vec<_>>();
        let at = |row: usize| {
            let (t, x) = &paths[row];
            (0..count).map(|index| place(*t, &x[index * d..])).collect::<Vec<_>>()
        };
        for index in 0..count {
            let few = oblique || count <= 30;
            let color = if few { COLORS[1 + index % 4] } else { GREY };
            chart.curves.push(Curve { width: if few { 1.3 } else { 0.8 }, ..Curve::line("", path(index), color) });
        }
        let small = if count > 400 { 1.4 } else { 2.4 };
        chart.curves.push(Curve::dots(&format!("t = {}", super::shown(first)), at(0), COLORS[5], small));
        chart.curves.push(Curve::dots(
            &format!("t = {}", super::shown(last)),
            at(paths.len() - 1),
            COLORS[0],
            small + 0.3,
        ));
        if oblique {
            oblique_axes(&mut chart, reach, [first, last], &place);
        }
        fit(picture, &mut chart);
        chart.equal = true;
        if oblique {
            chart.frame = false;
        }
        charts.push(chart);
    }
    let title = if charts.len() > 1 { picture.title.as_str() } else { "" };
    let size = if charts.len() > 1 { [470, 470] } else { [600, 580] };
    Ok(sheet(title, &charts, 3.min(charts.len()), size[0], size[1]))
}

/// The square that holds all paths, at the start, and the time above its nearest corner.
fn oblique_axes(chart: &mut Chart, reach: f64, [first, last]: [f64; 2], place: &impl Fn(f64, &[f64]) -> [f64; 2]) {
    let edge = [[-reach, -reach], [reach, -reach], [reach, reach], [-reach, reach], [-reach, -reach]];
    let base = edge.iter().map(|x| place(first, x)).collect();
    chart.curves.push(Curve { width: 1.0, ..Curve::line("", base, GREY) });
    let corner = edge[0];
    let mut upright = vec![place(first, &corner), place(last, &corner)];
    upright.dedup();
    chart.curves.push(Curve { width: 1.0, ..Curve::line("", upright, GREY) });
    for k in 0..=4 {
        let t = first + (last - first) * f64::from(k) / 4.0;
        let [x, y] = place(t, &corner);
        chart.curves.push(Curve { width: 1.0, ..Curve::line("", vec![[x - 0.03 * reach, y], [x, y]], GREY) });
        chart.notes.push(([x - 0.16 * reach, y], format!("t = {}", super::shown(t))));
    }
    let below = |x: &[f64]| {
        let [a, b] = place(first, x);
        [a, b - 0.09 * reach]
    };
    let shown = super::shown(reach);
    chart.notes.push((below(&edge[0]), format!("x = y = -{shown}")));
    chart.notes.push((below(&edge[1]), format!("x = {shown}")));
    let [x, y] = place(first, &edge[2]);
    chart.notes.push(([x + 0.2 * reach, y], format!("y = {shown}")));
}

/// Densities on a line at the snapshots' times.
pub fn density(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    let mut chart = empty(picture, "position x", "density \u{3c1}", [false; 2]);
    let result = results[0];
    let exact = picture
        .exact
        .then(|| Exact::of(result.scene).context("no exact solution of this scene is known"))
        .transpose()?;
    for (index, snapshot) in super::planes::chosen(picture, result)?.into_iter().enumerate() {
        let (t, color) = (snapshot.time, COLORS[index % COLORS.len()]);
        if let Some(exact) = exact.as_ref().filter(|exact| t < exact.blow_up()) {
            let (low, high) =
                result.main.start.positions.iter().fold((0.0_f64, 0.0_f64), |(a, b), &x| (a.min(x), b.max(x)));
            let place = |i: i32| [low + (high - low) * f64::from(i) / 400.0];
            let mut points: Vec<[f64; 2]> =
                (0..=400).map(|i| [exact.position(&place(i), t)[0], exact.density(&place(i), t)]).collect();
            // The density is zero outside the support.
            points.insert(0, [points[0][0], 0.0]);
            points.push([points[points.len() - 1][0], 0.0]);
            chart.curves.push(Curve {
                width: 2.4,
                ..Curve::line(&format!("t = {}, exact", super::shown(t)), points, lighter(color))
            });
        }
        ensure!(!snapshot.particles.densities.is_empty(), "the run carries no density");
        let mut points: Vec<[f64; 2]> =
            snapshot.particles.positions.iter().zip(&snapshot.particles.densities).map(|(&x, &rho)| [x, rho]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        chart
            .curves
            .push(Curve { dash: DASHED, ..Curve::line(&format!("t = {}, blobs", super::shown(t)), points, color) });
    }
    fit(picture, &mut chart);
    Ok(single(chart))
}

fn lighter(color: Color) -> Color {
    color.map(|channel| (f64::from(channel) + 0.55 * (255.0 - f64::from(channel))) as u8)
}

/// Second moment over time, with predicted slopes.
pub fn moment(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    over_time(picture, results, "second_moment", "second moment about the centre / mass", false)
}

/// Number of particles over time.
pub fn count(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    over_time(picture, results, "particles", "particles", true)
}

fn over_time(picture: &Picture, results: &[&CaseResult<'_>], column: &str, label: &str, log: bool) -> Result<Canvas> {
    let mut chart = empty(picture, "time t", label, [false, log]);
    let mut ranges = Vec::new();
    for (case, result) in results.iter().enumerate() {
        let points = result.main.column(column).with_context(|| format!("the run has no column {column}"))?;
        ensure!(!points.is_empty(), "the run has no rows");
        let color = COLORS[case % COLORS.len()];
        let several = results.len() > 1;
        let name = if several { result.scene.name.clone() } else { "computed".to_owned() };
        ranges.push(Curve::line(&name, points.clone(), color));
        let approximations = [("plain", "approximated by (2.20)"), ("corrected", "approximated by (2.29)")];
        for (index, (column, name)) in approximations.into_iter().enumerate() {
            if let Some(points) = result.main.column(column) {
                let curve = Curve::line(name, points, COLORS[index + 1]);
                ranges.push(Curve { dash: DASHES[index + 1], ..curve });
            }
        }
        if picture.parts {
            for part in 0..result.scene.initial.len() {
                let Some(points) = result.main.column(&format!("part_moment_{part}")) else { continue };
                let name = if several { format!("{name}, part {part}") } else { format!("part {part}") };
                let curve =
                    Curve::line(&name, points, COLORS[(case + if several { 0 } else { part + 1 }) % COLORS.len()]);
                ranges.push(Curve { dash: DASHES[(part + 1) % DASHES.len()], ..curve });
            }
        }
    }
    chart.curves = ranges;
    fit(picture, &mut chart);
    // Predictions are drawn over the range of what was computed.
    let lines: Vec<Curve> = picture
        .slopes
        .iter()
        .enumerate()
        .filter_map(|(index, slope)| {
            let base = &chart.curves[0].points;
            let nearest = base.iter().min_by(|a, b| (a[0] - slope.at).abs().total_cmp(&(b[0] - slope.at).abs()))?;
            let points = [chart.x.low, chart.x.high].map(|t| [t, nearest[1] + slope.value * (t - nearest[0])]).to_vec();
            let curve = Curve::line(&slope.label, points, COLORS[(index + 1) % COLORS.len()]);
            Some(Curve { dash: if index % 2 == 0 { DASHED } else { DOTTED }, width: 1.8, ..curve })
        })
        .collect();
    chart.curves.extend(lines);
    Ok(single(chart))
}

/// Errors over the spacing, with lines of given slope.
pub fn convergence(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    let which: &[usize] = match picture.quantity.as_str() {
        "positions" => &[0],
        "density" => &[1],
        _ => &[0, 1],
    };
    let label = match which {
        [0] => "L1 error of positions",
        [1] => "L1 error of density",
        _ => "L1 error",
    };
    let mut chart = empty(picture, "spacing h", label, [true, true]);
    for result in results {
        ensure!(!result.study.is_empty(), "the scene has no study");
        for &quantity in which {
            let points: Vec<[f64; 2]> = result
                .study
                .iter()
                .map(|point| [point.h, point.errors[quantity]])
                .filter(|point| point[1] > 0.0)
                .collect();
            if points.is_empty() {
                continue;
            }
            let index = chart.curves.len();
            let kind = ["positions", "density"][quantity];
            let name = match (which.len(), results.len()) {
                (1, _) if !result.scene.name.is_empty() => result.scene.name.clone(),
                (_, 1) => kind.to_owned(),
                _ => format!("{}, {kind}", result.scene.name),
            };
            let mark = Some((MARKS[index % MARKS.len()], 4.0));
            chart.curves.push(Curve { mark, ..Curve::line(&name, points, COLORS[index % COLORS.len()]) });
        }
    }
    // Lines for comparison start at the coarsest error of the first curve that is left to take one.
    let computed = chart.curves.clone();
    ensure!(
        !computed.is_empty(),
        "every error is zero or not a number: there is nothing to draw on a logarithmic axis"
    );
    for (index, &rate) in picture.rates.iter().enumerate() {
        let base = &computed[index.min(computed.len() - 1)].points;
        let [h, error] = base[0];
        let last = base[base.len() - 1][0];
        let points = [h, last].map(|x| [x, error * 1.6 * (x / h).powf(rate)]).to_vec();
        chart.curves.push(Curve {
            dash: DASHES[1 + index % 3],
            width: 1.2,
            ..Curve::line(&format!("h^{rate}"), points, GREY)
        });
    }
    fit(picture, &mut chart);
    Ok(single(chart))
}

/// Mollifiers, or their potentials beside the exact one.
pub fn profile(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    let column = if picture.quantity == "potential" { "potential" } else { "density" };
    let label = if column == "potential" { "potential \u{3c6}" } else { "mollifier \u{3c8}" };
    let mut chart = empty(picture, "distance r", label, [false; 2]);
    for (index, result) in results.iter().enumerate() {
        let points = result.main.column(column).context("no curve")?;
        let curve = Curve::line(&result.scene.name, points, COLORS[(index + 1) % COLORS.len()]);
        chart.curves.push(Curve { dash: DASHES[index % DASHES.len()], width: 2.0, ..curve });
    }
    fit(picture, &mut chart);
    if column == "potential" {
        let d = results[0].scene.dimension;
        let exact = |r: f64| match d {
            1 => r / 2.0,
            2 => r.ln() / std::f64::consts::TAU,
            _ => -1.0 / (2.0 * std::f64::consts::TAU * r),
        };
        let points = (1..=600).map(|i| chart.x.high * f64::from(i) / 600.0).map(|r| [r, exact(r)]).collect();
        chart.curves.push(Curve { width: 1.4, ..Curve::line("exact", points, COLORS[0]) });
    }
    Ok(single(chart))
}
