//! Pictures of the plane: density maps, particles, the field of the chemical.

use anyhow::{Context, Result, ensure};
use mollis_core::exec::{Executor, Resources};
use mollis_core::field::Sources;
use mollis_core::grid::{Equation, Grid};
use mollis_host::memory::Memory;

use super::axis::Axis;
use super::canvas::Canvas;
use super::chart::{COLORS, Chart, Curve, Map, sheet};
use crate::history::Snapshot;
use crate::model::{kernel, pks};
use crate::results::CaseResult;
use crate::scene::{Model, Picture};

/// Pixels of a map along its longer side.
const CELLS: usize = 180;

/// The snapshots that a picture shows.
pub fn chosen<'a>(picture: &Picture, result: &'a CaseResult<'_>) -> Result<Vec<&'a Snapshot>> {
    let all = &result.main.snapshots;
    ensure!(!all.is_empty(), "output.snapshots is empty");
    if picture.times.is_empty() {
        return Ok(all.iter().collect());
    }
    let step = |time: f64| result.scene.step_at(time);
    let of = |time: &f64| {
        let found = all.iter().find(|snapshot| step(snapshot.time).is_some_and(|at| step(*time) == Some(at)));
        found.with_context(|| format!("there is no snapshot at time {time}"))
    };
    picture.times.iter().map(of).collect()
}

/// A square region around all particles of the snapshots, or the picture's own.
fn region(picture: &Picture, snapshots: &[&Snapshot]) -> [Axis; 2] {
    let of = |axis: usize| {
        let coordinates = snapshots.iter().flat_map(move |snapshot| {
            snapshot.particles.positions.chunks_exact(snapshot.particles.dimension).map(move |x| x[axis])
        });
        Axis::around(coordinates, false)
    };
    let mut axes = [0, 1].map(of);
    let half = axes.iter().map(|axis| (axis.high - axis.low) / 2.0).fold(0.0, f64::max);
    for axis in &mut axes {
        let middle = (axis.low + axis.high) / 2.0;
        *axis = Axis { low: middle - half, high: middle + half, log: false }.rounded();
    }
    [picture.x.map_or(axes[0], Axis::fixed), picture.y.map_or(axes[1], Axis::fixed)]
}

/// The number of cells of a map of this region.
fn cells(axes: &[Axis; 2]) -> [usize; 2] {
    let spans = axes.map(|axis| axis.high - axis.low);
    let longest = spans[0].max(spans[1]);
    spans.map(|span| ((span / longest * CELLS as f64).round() as usize).max(8))
}

fn panels(title: &str, charts: &[Chart]) -> Canvas {
    let columns = match charts.len() {
        1 => 1,
        2 | 4 => 2,
        _ => 3,
    };
    let size = if charts.len() == 1 { [640, 560] } else { [450, 390] };
    let title = if charts.len() == 1 { "" } else { title };
    sheet(title, charts, columns, size[0], size[1])
}

fn named(picture: &Picture, results: usize, result: &CaseResult<'_>, time: f64, panels: usize) -> String {
    let time = super::shown(time);
    match (results, panels) {
        (1, 1) => format!("{}, t = {time}", picture.title),
        (1, _) => format!("t = {time}"),
        _ => format!("{}, t = {time}", result.scene.name),
    }
}

/// The density as a map: the sum of the blobs, or for pks the mass in each pixel.
pub fn density(picture: &Picture, results: &[&CaseResult<'_>], executor: &dyn Executor) -> Result<Canvas> {
    let mut charts = Vec::new();
    for result in results {
        let snapshots = chosen(picture, result)?;
        let axes = region(picture, &snapshots);
        for snapshot in &snapshots {
            let (values, log) = match result.scene.model {
                Model::Blob => (blobs(result, snapshot, &axes, executor)?, false),
                _ => (masses(snapshot, &axes), true),
            };
            let top = values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            let least = values.iter().copied().fold(0.0, f64::min);
            // A mollifier of higher order has negative lobes: they are shown, not cut.
            let bottom = if log { top * 1e-5 } else { least };
            let name = named(picture, results.len(), result, snapshot.time, snapshots.len());
            let mut chart = Chart::new(&name, "x", "y", axes[0], axes[1]);
            chart.equal = true;
            let [x, y] = axes.map(|axis| [axis.low, axis.high]);
            chart.map =
                Some(Map { cells: cells(&axes), values, x, y, range: [bottom, top], log, label: "\u{3c1}".to_owned() });
            charts.push(chart);
        }
    }
    Ok(panels(&picture.title, &charts))
}

/// Centres of a map's cells.
fn centres(axes: &[Axis; 2]) -> Vec<[f64; 2]> {
    let [nx, ny] = cells(axes);
    let at = |axis: &Axis, i: usize, n: usize| axis.low + (axis.high - axis.low) * (i as f64 + 0.5) / n as f64;
    (0..ny)
        .flat_map(|j| (0..nx).map(move |i| (i, j)))
        .map(|(i, j)| [at(&axes[0], i, nx), at(&axes[1], j, ny)])
        .collect()
}

/// sum_j m_j psi_delta(x - x_j): the Laplacian of the mollified Newtonian potential.
fn blobs(result: &CaseResult<'_>, snapshot: &Snapshot, axes: &[Axis; 2], executor: &dyn Executor) -> Result<Vec<f64>> {
    ensure!(result.scene.dimension == 2, "maps are drawn in two dimensions");
    let h = (result.main.h > 0.0).then_some(result.main.h);
    let positions = snapshot.particles.positions.as_chunks::<2>().0;
    let sources = Sources::new(positions, &snapshot.particles.masses);
    kernel::density(result.scene, h, sources, &centres(axes), executor)
}

/// Mass per area in each cell.
fn masses(snapshot: &Snapshot, axes: &[Axis; 2]) -> Vec<f64> {
    let [nx, ny] = cells(axes);
    let area = (axes[0].high - axes[0].low) * (axes[1].high - axes[1].low) / (nx * ny) as f64;
    let mut values = vec![0.0; nx * ny];
    let particles = &snapshot.particles;
    for (position, mass) in particles.positions.chunks_exact(particles.dimension).zip(&particles.masses) {
        let (i, j) = (axes[0].place(position[0]) * nx as f64, axes[1].place(position[1]) * ny as f64);
        // The last cells hold the upper border: the region ends at round numbers, where a particle may lie.
        if i >= 0.0 && j >= 0.0 && i <= nx as f64 && j <= ny as f64 {
            values[(j as usize).min(ny - 1) * nx + (i as usize).min(nx - 1)] += mass / area;
        }
    }
    values
}

/// Particles in the plane, a panel a snapshot; those that hold at least a thousandth of the mass as larger discs.
pub fn particles(picture: &Picture, results: &[&CaseResult<'_>]) -> Result<Canvas> {
    let mut charts = Vec::new();
    for result in results {
        ensure!(result.scene.dimension > 1, "particles are drawn in two dimensions");
        let snapshots = chosen(picture, result)?;
        let axes = region(picture, &snapshots);
        for snapshot in &snapshots {
            let particles = &snapshot.particles;
            let name = named(picture, results.len(), result, snapshot.time, snapshots.len());
            let mut chart = Chart::new(&name, "x", "y", axes[0], axes[1]);
            chart.equal = true;
            let whole: f64 = particles.masses.iter().sum();
            let stochastic = matches!(result.scene.model, Model::Pks | Model::Cluster);
            let heavy = |mass: f64| stochastic && mass > 1e-3 * whole;
            let points =
                || particles.positions.chunks_exact(particles.dimension).map(|x| [x[0], x[1]]).zip(&particles.masses);
            let light: Vec<[f64; 2]> = points().filter(|(_, mass)| !heavy(**mass)).map(|(x, _)| x).collect();
            // With more points than pixels only every k-th is drawn.
            let every = light.len().div_ceil(20_000).max(1);
            let radius = if light.len() > 2000 { 0.7 } else { 1.8 };
            let light = light.into_iter().step_by(every).collect();
            chart.curves.push(Curve::dots("", light, COLORS[1], radius));
            for (x, mass) in points().filter(|(_, mass)| heavy(**mass)) {
                chart.curves.push(Curve::dots("", vec![x], COLORS[2], 2.0 + 7.0 * (mass / whole).sqrt()));
            }
            charts.push(chart);
        }
    }
    Ok(panels(&picture.title, &charts))
}

/// The chemical's concentration c on the mesh: Laplacian(c) = -density, so c is minus the mesh's potential.
pub fn field(picture: &Picture, results: &[&CaseResult<'_>], executor: &dyn Executor) -> Result<Canvas> {
    let mut charts = Vec::new();
    for result in results {
        let snapshots = chosen(picture, result)?;
        let mesh = pks::mesh(result.scene)?;
        let bytes = Grid::workspace_bytes(&mesh, &Equation::POISSON, executor.workers())?;
        let mut memory = Memory::new(bytes);
        let mut grid = Grid::prepare(memory.slice(), mesh, Equation::POISSON, executor.workers())?;
        let ([nx, ny], [hx, hy]) = (mesh.cells(), mesh.spacing());
        let (low, high) = (mesh.lower(), mesh.upper());
        let axes = [0, 1].map(|axis| Axis::fixed([low[axis], high[axis]]));
        let axes = [picture.x.map_or(axes[0], Axis::fixed), picture.y.map_or(axes[1], Axis::fixed)];
        let resources = Resources { executor, ..Resources::default() };
        for snapshot in &snapshots {
            grid.deposit(snapshot.particles.positions.as_chunks::<2>().0, &snapshot.particles.masses, resources)?;
            grid.solve(resources)?;
            let mut values = vec![0.0; (nx + 1) * (ny + 1)];
            grid.potential(&mut values)?;
            values.iter_mut().for_each(|u| *u = -*u);
            let inside = |node: usize| {
                let (x, y) = (low[0] + hx * (node % (nx + 1)) as f64, low[1] + hy * (node / (nx + 1)) as f64);
                x >= axes[0].low && x <= axes[0].high && y >= axes[1].low && y <= axes[1].high
            };
            let shown = || values.iter().enumerate().filter(|(node, _)| inside(*node)).map(|(_, c)| *c);
            let range = [shown().fold(f64::INFINITY, f64::min), shown().fold(f64::NEG_INFINITY, f64::max)];
            let name = named(picture, results.len(), result, snapshot.time, snapshots.len());
            let mut chart = Chart::new(&name, "x", "y", axes[0], axes[1]);
            chart.equal = true;
            // A node's value fills the cell around it.
            let (x, y) = ([low[0] - hx / 2.0, high[0] + hx / 2.0], [low[1] - hy / 2.0, high[1] + hy / 2.0]);
            chart.map = Some(Map { cells: [nx + 1, ny + 1], values, x, y, range, log: false, label: "c".to_owned() });
            charts.push(chart);
        }
    }
    Ok(panels(&picture.title, &charts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Particles;

    /// A map holds the mass of every particle in its region, borders included.
    #[test]
    fn a_map_holds_all_mass() {
        let particles = Particles {
            dimension: 2,
            positions: vec![-1.0, -1.0, 1.0, 1.0, 0.3, 1.0, 1.0, -1.0, 1.5, 0.0],
            masses: vec![1.0, 2.0, 4.0, 8.0, 16.0],
            ..Particles::default()
        };
        let axes = [Axis::fixed([-1.0, 1.0]), Axis::fixed([-1.0, 1.0])];
        let values = masses(&Snapshot { time: 0.0, particles }, &axes);
        let [nx, ny] = cells(&axes);
        // The last particle is outside. Each cell and the sum take a few roundings of 15.
        let held = values.iter().sum::<f64>() * 4.0 / (nx * ny) as f64;
        assert!((held - 15.0).abs() < 1e-12, "{held}");
        assert!(values[0] > 0.0 && values[nx - 1] > 0.0 && values[nx * ny - 1] > 0.0);
    }
}
