//! Numbers that a scene expects of its run.

use std::collections::HashMap;

use anyhow::{Context, Result, bail, ensure};

use crate::history::History;
use crate::particles::Particles;
use crate::results::CaseResult;
use crate::scene::{Expectation, SLACK};

/// What came of an expectation.
#[derive(Clone, Debug)]
pub struct Check {
    /// What was expected.
    pub expectation: Expectation,
    /// The number that the run gave.
    pub value: f64,
    /// Whether it is within the bounds.
    pub passed: bool,
    /// Why there is no number, if there is none.
    pub error: Option<String>,
}

/// Measures one expectation. What can't be measured is not met, and costs no other number.
pub fn check(expectation: &Expectation, results: &[CaseResult<'_>]) -> Check {
    let name = expectation.case.as_deref();
    let result = results.iter().find(|result| name.is_none_or(|name| result.scene.name == name));
    let measured = result.context("no such case").and_then(|result| measure(expectation, result));
    let (value, error) = match measured {
        Ok(value) => (value, None),
        Err(error) => (f64::NAN, Some(format!("{error:#}"))),
    };
    // Not a number is never within bounds.
    let passed = value >= expectation.least && value <= expectation.most;
    Check { expectation: expectation.clone(), value, passed, error }
}

fn measure(expectation: &Expectation, result: &CaseResult<'_>) -> Result<f64> {
    let history = &result.main;
    let interval = [expectation.from.unwrap_or(f64::NEG_INFINITY), expectation.to.unwrap_or(f64::INFINITY)];
    let slack = SLACK * result.scene.dt;
    let within = |points: &[[f64; 2]]| within(points, interval, slack);
    let column = |name: &str| history.column(name).with_context(|| format!("the run has no column {name}"));
    let at = |name: &str| -> Result<f64> {
        let points = column(name)?;
        let time = expectation.at.unwrap_or(f64::INFINITY);
        let nearest = points.iter().min_by(|a, b| (a[0] - time).abs().total_cmp(&(b[0] - time).abs()));
        match expectation.at {
            Some(_) => nearest.map(|point| point[1]).context("no row"),
            None => points.last().map(|point| point[1]).context("no row"),
        }
    };
    let part_column = format!("part_moment_{}", expectation.part);
    Ok(match expectation.quantity.as_str() {
        "error_positions" => errors(result, 0, expectation.at)?,
        "error_density" => errors(result, 1, expectation.at)?,
        "rate_positions" => rate(result, 0, expectation.at, interval)?,
        "rate_density" => rate(result, 1, expectation.at, interval)?,
        "slope" => fit(&within(&column("second_moment")?))?.slope,
        "slope_error" => fit(&within(&column("second_moment")?))?.error,
        "decay_rate" => {
            let logs = |points: Vec<[f64; 2]>| points.into_iter().map(|[t, y]| [t, y.ln()]).collect::<Vec<_>>();
            fit(&logs(within(&column("second_moment")?)))?.slope
        }
        "rotation_rate" => fit(&within(&column("axis_angle")?))?.slope,
        "part_slope" => fit(&within(&column(&part_column)?))?.slope,
        "part_nonlinearity" => {
            let points = within(&column(&part_column)?);
            let line = fit(&points)?;
            let deviation = points.iter().map(|[t, y]| (y - line.at(*t)).abs()).fold(0.0, f64::max);
            let (first, last) = (points[0][0], points[points.len() - 1][0]);
            deviation / (line.slope * (last - first)).abs()
        }
        "heavy_mass" => at("heaviest")?,
        "particles" => at("particles")?,
        "second_moment" => at("second_moment")?,
        "density_maximum" => at("density_maximum")?,
        "approximation_ratio" => at("error_plain")? / at("error_corrected")?,
        "mean_radius" => radii(&history.end).mean,
        "radius_spread" => radii(&history.end).spread,
        "largest_radius" => radii(&history.end).largest,
        "clusters" => clusters(&history.end) as f64,
        "merges" => history.events.len() as f64,
        "density_at_zero" => history.rows.first().context("no row")?[1],
        "potential_at_zero" => history.rows.first().context("no row")?[2],
        "centre_drift" => {
            let axes: Vec<_> =
                ["centre_x", "centre_y", "centre_z"].iter().filter_map(|name| history.column(name)).collect();
            let drift = |row: usize| axes.iter().map(|axis| (axis[row][1] - axis[0][1]).powi(2)).sum::<f64>().sqrt();
            (0..history.rows.len()).map(drift).fold(0.0, f64::max)
        }
        "energy_rise" => {
            let energy = column("energy")?;
            let scale = energy.iter().map(|point| point[1].abs()).fold(0.0, f64::max);
            energy.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / scale).fold(f64::NEG_INFINITY, f64::max)
        }
        "energy_drift" => {
            let energy = column("energy")?;
            let first = energy.first().context("no row")?[1];
            energy.iter().map(|point| ((point[1] - first) / first).abs()).fold(0.0, f64::max)
        }
        other => bail!("{other} is not measured"),
    })
}

fn errors(result: &CaseResult<'_>, which: usize, h: Option<f64>) -> Result<f64> {
    let found = match h {
        Some(h) => result.study.iter().find(|point| (point.h - h).abs() < 1e-3 * h),
        None => result.study.last(),
    };
    match found {
        Some(point) => Ok(point.errors[which]),
        None => {
            ensure!(result.study.is_empty(), "the study has no such h");
            let name = ["error_positions", "error_density"][which];
            let column =
                result.main.column(name).with_context(|| format!("the run has no column {name} and no study"))?;
            column.last().map(|point| point[1]).context("no row")
        }
    }
}

/// The observed order: between two neighbouring spacings, or by least squares over an interval of them.
fn rate(result: &CaseResult<'_>, which: usize, h: Option<f64>, interval: [f64; 2]) -> Result<f64> {
    if let Some(h) = h {
        let at =
            result.study.iter().position(|point| (point.h - h).abs() < 1e-3 * h).context("the study has no such h")?;
        ensure!(at > 0, "the coarsest h has no rate");
        let (coarse, fine) = (&result.study[at - 1], &result.study[at]);
        return Ok((coarse.errors[which] / fine.errors[which]).ln() / (coarse.h / fine.h).ln());
    }
    let logs: Vec<[f64; 2]> = result
        .study
        .iter()
        .filter(|point| point.h >= interval[0] * 0.999 && point.h <= interval[1] * 1.001)
        .map(|point| [point.h.ln(), point.errors[which].ln()])
        .collect();
    Ok(fit(&logs)?.slope)
}

fn within(points: &[[f64; 2]], [from, to]: [f64; 2], slack: f64) -> Vec<[f64; 2]> {
    points.iter().copied().filter(|point| point[0] >= from - slack && point[0] <= to + slack).collect()
}

/// A straight line by least squares.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Its slope.
    pub slope: f64,
    /// The slope's standard error if deviations were independent (in a random walk they are not).
    pub error: f64,
    middle: [f64; 2],
}

impl Line {
    /// Its value.
    pub fn at(&self, x: f64) -> f64 {
        self.middle[1] + self.slope * (x - self.middle[0])
    }
}

/// Fits a line through points.
pub fn fit(points: &[[f64; 2]]) -> Result<Line> {
    ensure!(points.len() > 1, "a slope needs at least two rows in its interval");
    let n = points.len() as f64;
    let middle = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / n);
    let spread: f64 = points.iter().map(|point| (point[0] - middle[0]).powi(2)).sum();
    let slope = points.iter().map(|point| (point[0] - middle[0]) * (point[1] - middle[1])).sum::<f64>() / spread;
    let line = Line { slope, error: 0.0, middle };
    let rest: f64 = points.iter().map(|point| (point[1] - line.at(point[0])).powi(2)).sum();
    Ok(Line { error: (rest / (n - 2.0).max(1.0) / spread).sqrt(), ..line })
}

struct Radii {
    mean: f64,
    spread: f64,
    largest: f64,
}

/// Distances from the centre of mass, weighted by mass; massless particles don't count.
fn radii(particles: &Particles) -> Radii {
    let d = particles.dimension;
    let points = || particles.positions.chunks_exact(d).zip(&particles.masses).filter(|(_, mass)| **mass != 0.0);
    let mass: f64 = points().map(|(_, mass)| mass).sum();
    let centre: Vec<f64> = (0..d).map(|axis| points().map(|(x, mass)| x[axis] * mass).sum::<f64>() / mass).collect();
    let radius = |x: &[f64]| x.iter().zip(&centre).map(|(x, c)| (x - c) * (x - c)).sum::<f64>().sqrt();
    let mean = points().map(|(x, mass)| radius(x) * mass).sum::<f64>() / mass;
    let square = points().map(|(x, mass)| (radius(x) - mean).powi(2) * mass).sum::<f64>() / mass;
    Radii { mean, spread: square.sqrt() / mean, largest: points().map(|(x, _)| radius(x)).fold(0.0, f64::max) }
}

/// Groups of particles closer than a tenth of the whole's radius to some other of the group.
fn clusters(particles: &Particles) -> usize {
    let d = particles.dimension;
    let near = 0.1 * radii(particles).largest;
    let points: Vec<&[f64]> = particles
        .positions
        .chunks_exact(d)
        .zip(&particles.masses)
        .filter(|(_, mass)| **mass != 0.0)
        .map(|(x, _)| x)
        .collect();
    let mut group: Vec<usize> = (0..points.len()).collect();
    fn root(group: &mut [usize], mut at: usize) -> usize {
        while group[at] != at {
            group[at] = group[group[at]];
            at = group[at];
        }
        at
    }
    for i in 0..points.len() {
        for j in 0..i {
            let distance: f64 = points[i].iter().zip(points[j]).map(|(a, b)| (a - b) * (a - b)).sum();
            if distance <= near * near {
                let (a, b) = (root(&mut group, i), root(&mut group, j));
                group[a.max(b)] = a.min(b);
            }
        }
    }
    (0..points.len()).filter(|&i| group[i] == i).count()
}

/// Where the particles of a run begin among those of a run on a finer grid of spacing `h`, which must hold them.
pub fn matches(start: &Particles, reference: &Particles, h: f64) -> Result<Vec<usize>> {
    let d = start.dimension;
    // Parts may overlap: a point of the grid is then several particles.
    let key =
        |(x, part): (&[f64], &u8)| -> (Vec<i64>, u8) { (x.iter().map(|x| (x / h).round() as i64).collect(), *part) };
    let points = |particles: &'_ Particles| -> Vec<(Vec<i64>, u8)> {
        particles.positions.chunks_exact(d).zip(&particles.parts).map(key).collect()
    };
    let known: HashMap<_, usize> = points(reference).into_iter().enumerate().map(|(index, key)| (key, index)).collect();
    let find = |(index, key): (usize, (Vec<i64>, u8))| -> Result<usize> {
        let x = &start.positions[index * d..(index + 1) * d];
        let other = *known.get(&key).with_context(|| format!("study.reference: its grid does not hold {x:?}"))?;
        let same = &reference.positions[other * d..(other + 1) * d];
        let close = x.iter().zip(same).all(|(a, b)| (a - b).abs() <= 1e-6 * h);
        ensure!(close, "study.reference: its grid does not hold {x:?}");
        Ok(other)
    };
    points(start).into_iter().enumerate().map(find).collect()
}

/// Errors of a run against a finer one that holds its starting points, in h times the sum over the coarse run's particles; not
/// a number for densities that are not carried.
pub fn errors_against(run: &History, reference: &History, cell: f64) -> Result<[f64; 2]> {
    let d = run.start.dimension;
    let mut sums = [0.0; 2];
    for (index, other) in matches(&run.start, &reference.start, reference.h)?.into_iter().enumerate() {
        let (x, y) =
            (&run.end.positions[index * d..(index + 1) * d], &reference.end.positions[other * d..(other + 1) * d]);
        sums[0] += x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt() * cell;
        sums[1] += match (run.end.densities.get(index), reference.end.densities.get(other)) {
            (Some(own), Some(finer)) => (own - finer).abs() * cell,
            _ => f64::NAN,
        };
    }
    Ok(sums)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found() {
        let line = fit(&[[0.0, 1.0], [1.0, 3.0], [2.0, 5.0]]).unwrap();
        assert_eq!((line.slope, line.at(3.0), line.error), (2.0, 7.0, 0.0));
        assert!(fit(&[[0.0, 1.0]]).is_err());
    }

    #[test]
    fn groups_are_counted() {
        let mut particles = Particles { dimension: 2, ..Particles::default() };
        for (x, y) in [(0.0, 1.0), (0.01, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, -0.99)] {
            particles.positions.extend([x, y]);
            particles.masses.push(1.0);
        }
        assert_eq!(clusters(&particles), 3);
    }

    /// Points of the grid h Z^2, each with a part.
    fn on_grid(h: f64, points: &[(f64, f64, u8)]) -> Particles {
        let positions = points.iter().flat_map(|&(i, j, _)| [i * h, j * h]).collect();
        let parts = points.iter().map(|point| point.2).collect();
        Particles { dimension: 2, positions, masses: vec![1.0; points.len()], densities: Vec::new(), parts }
    }

    #[test]
    fn runs_are_compared_at_equal_points_of_equal_parts() {
        // Two parts that overlap in (1, 0) of the coarse grid.
        let coarse = on_grid(0.2, &[(0.0, 0.0, 0), (1.0, 0.0, 0), (1.0, 0.0, 1), (-1.0, 2.0, 1)]);
        let fine = on_grid(0.1, &[(2.0, 0.0, 1), (1.0, 0.0, 0), (2.0, 0.0, 0), (-2.0, 4.0, 1), (0.0, 0.0, 0)]);
        assert_eq!(matches(&coarse, &fine, 0.1).unwrap(), [4, 2, 0, 3]);
        let missing = on_grid(0.2, &[(3.0, 0.0, 0)]);
        assert!(matches(&missing, &fine, 0.1).unwrap_err().to_string().contains("does not hold [0.6"));
        let between = on_grid(0.101, &[(1.0, 0.0, 0)]);
        assert!(matches(&between, &fine, 0.1).is_err());
        // Densities that are not carried have no error, rather than one of 0.
        let history = |end: Particles, h: f64| History { h, start: end.clone(), end, ..History::default() };
        let errors = errors_against(&history(coarse, 0.2), &history(fine, 0.1), 0.04).unwrap();
        assert!(errors[0] < 1e-15 && errors[1].is_nan());
    }
}
