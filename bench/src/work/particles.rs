//! Coalescing particles of the Patlak-Keller-Segel system, against the known slope of the second moment.

use anyhow::Result;
use mollis_core::exec::Run;
use mollis_core::field::{self, Interaction};
use mollis_core::grid::{Equation, Grid, Mesh};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::pks::theory::{self, Constants, Group};
use mollis_core::pks::{self, Attraction, Counters, Event, Events, Options, Report, Setting, State};
use mollis_core::random::Philox;

use super::{Curve, Row, Study, Work};
use crate::field::cpu_time;
use crate::scene::aligned;

/// Critical masses of the disc.
const MASS: f64 = 16.0 * std::f64::consts::PI;
/// The slope is measured from 0 to here.
const END: f64 = 0.02;

/// How the particles attract each other.
#[derive(Clone, Copy, Debug)]
enum Field {
    /// On a mesh of so many cells a side.
    Mesh(usize),
    /// Pair by pair, softened over a small length.
    Pairs,
}

/// sum m |x|^2 about the centre of mass.
fn second_moment(x: &[[f64; 2]], m: &[f64]) -> f64 {
    let total: f64 = m.iter().sum();
    let centre = [0, 1].map(|k| x.iter().zip(m).map(|(x, m)| m * x[k]).sum::<f64>() / total);
    x.iter().zip(m).map(|(x, m)| m * ((x[0] - centre[0]).powi(2) + (x[1] - centre[1]).powi(2))).sum()
}

/// The relative error of the slope of the second moment over the mass, and the CPU time.
fn slope(attraction: Field, n: usize, steps: usize, seed: u64) -> Result<[f64; 2]> {
    let mut labels: Vec<u64> = (0..n as u64).collect();
    let mut positions = vec![[0.0_f64; 2]; n];
    // Not the steps' generator, whose first numbers would be the same.
    Philox::new(seed + 1000).normals(&labels, 0, 0, &mut positions);
    positions.iter_mut().flatten().for_each(|x| *x = (0.4 * *x).clamp(-1.4, 1.4));
    let mut masses = vec![MASS / n as f64; n];
    let noise = theory::noise(MASS, 1.0, n);
    let mesh = Mesh::new([-2.5, -2.5], [2.5, 2.5], [if let Field::Mesh(cells) = attraction { cells } else { 16 }; 2])?;
    let mut options = Options::new(1.0, noise);
    options.search.domain = Some([mesh.lower(), mesh.upper()]);
    let kernel = Blob::<f64, 2>::new(Mollifier::Compact { order: 2, exponent: 4 }, 1e-3)?;
    let alpha = Constants::new(1.0, noise).alpha(&Group::of(&masses));
    let begin = cpu_time();
    let mut grid_memory = vec![0; Grid::workspace_bytes(&mesh, &Equation::POISSON, 1)? + 64];
    let mut grid = Grid::prepare(aligned(&mut grid_memory), mesh, Equation::POISSON, 1)?;
    let direct = field::Options::default();
    let pairs = matches!(attraction, Field::Pairs).then_some(&kernel);
    let summed = pairs.map(|kernel| (kernel as &dyn Interaction<f64, 2>, &direct));
    let mut memory = vec![0; pks::workspace_bytes(n, summed, &options, 1)? + 64];
    let (mut events, mut absorbed) = (vec![Event::default(); n], vec![0; n]);
    let mut counters = Counters { count: n as u64, ..Counters::default() };
    let (mut written, mut labels_written) = (0, 0);
    let before = second_moment(&positions, &masses);
    // Until the first collapse the drift is alpha; noise of the second moment is averaged over seeds.
    for _ in 0..steps {
        let attraction = match pairs {
            Some(kernel) => Attraction::Sum(kernel, &direct),
            None => Attraction::Mesh(&mut grid, None),
        };
        pks::step(
            State { positions: &mut positions, masses: &mut masses, labels: &mut labels, species: None, weights: None },
            &mut counters,
            &mut Philox::new(seed),
            END / steps as f64,
            Events {
                events: &mut events,
                labels: &mut absorbed,
                written: &mut written,
                labels_written: &mut labels_written,
            },
            aligned(&mut memory),
            Setting { options: &options, attraction, run: &mut Run::default(), report: Some(&mut Report::default()) },
        )?;
    }
    let time = (cpu_time() - begin).as_secs_f64();
    let left = counters.count as usize;
    let after = second_moment(&positions[..left], &masses[..left]);
    Ok([(after - before) / (END * MASS * alpha) - 1.0, time])
}

/// The mean over seeds.
fn row(setting: String, field: Field, n: usize, steps: usize, seeds: u64) -> Result<Row> {
    let runs = (1..=seeds).map(|seed| slope(field, n, steps, seed)).collect::<Result<Vec<_>>>()?;
    let count = runs.len() as f64;
    let square = runs.iter().map(|run| run[0] * run[0]).sum::<f64>() / count;
    let mean = runs.iter().map(|run| run[0]).sum::<f64>() / count;
    Ok(Row {
        setting,
        time: runs.iter().map(|run| run[1]).sum::<f64>() / count,
        error: square.sqrt(),
        spread: Some((square - mean * mean).max(0.0).sqrt()),
    })
}

/// The study.
pub fn study(work: &Work) -> Result<Study> {
    let (seeds, largest) = if work.quick { (2, 1000) } else { (8, 30_000) };
    let sizes = [300, 1000, 3000, 10_000, 30_000];
    let sizes = || sizes.into_iter().filter(|&n| n <= largest);
    let over_n = |name: &str, field: Field, steps: usize, most: usize| -> Result<Curve> {
        let rows = sizes().filter(|&n| n <= most).map(|n| row(format!("{n} particles"), field, n, steps, seeds));
        Ok(Curve { name: name.to_owned(), rows: rows.collect::<Result<_>>()? })
    };
    let n = largest.min(10_000);
    let over = |name: &str, of: &dyn Fn(usize) -> (String, Field, usize), values: &[usize]| -> Result<Curve> {
        let rows = values.iter().map(|&value| {
            let (setting, field, steps) = of(value);
            row(setting, field, n, steps, seeds)
        });
        Ok(Curve { name: name.to_owned(), rows: rows.collect::<Result<_>>()? })
    };
    let curves = vec![
        over_n("mesh of 128 x 128, 20 steps", Field::Mesh(128), 20, largest)?,
        over_n("pairs, 20 steps", Field::Pairs, 20, 3000)?,
        over(
            &format!("{n} particles, 20 steps: meshes"),
            &|cells| (format!("{cells} x {cells} cells"), Field::Mesh(cells), 20),
            &[16, 32, 64, 256, 512],
        )?,
        over(
            &format!("{n} particles, mesh of 128 x 128: steps"),
            &|steps| (format!("{steps} steps"), Field::Mesh(128), steps),
            &[1, 2, 5, 100],
        )?,
    ];
    Ok(Study {
        name: "particles",
        question: "What do particles, meshes and steps buy in the coalescing particle system?",
        about: format!(
            "A normal cloud of two critical masses to t = {END}; the error is that of the slope of the second moment, whose value is known as long as no heavy particle has formed (Zhelezov & \
             Fatkullin (2.4)), in the root mean square over {seeds} seeds; bars are one standard deviation. What is left with many particles is noise, which falls with the root of their number."
        ),
        unit: "s",
        error: "error of the slope of the second moment, relative",
        digits: &[1, 2],
        curves,
        notes: vec![],
    })
}
