//! The blob method for the aggregation equation, from the initial data to the error of the particles' positions.
//!
//! The problems are radial, in the plane, under Newtonian attraction (Craig & Bertozzi, section 4), so that the exact positions are known: with the mass M(r) within r of
//! the centre a particle that starts at distance r is at the distance sqrt(r^2 - M(r) t / pi). The error is the mean distance from there, weighted with masses.

use anyhow::{Context, Result, ensure};
use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::exact::radial::{Bump, contraction};
use mollis_core::exec::Run;
use mollis_core::field::Options;
use mollis_core::kernel::Law;
use mollis_core::mollifier::Mollifier;

use super::{Curve, Row, Study, Work, fastest};
use crate::field::{KernelName, cpu_time, prepared};
use crate::scene::aligned;

/// The time at the end.
const END: f64 = 0.5;

/// A choice of the method's parameters.
#[derive(Clone, Copy, Debug)]
struct Choice {
    mollifier: Mollifier,
    /// delta = factor h^0.9.
    factor: f64,
    h: f64,
    steps: usize,
    tolerance: f64,
}

/// Particles on a lattice.
struct Start {
    bump: Bump<f64>,
    positions: Vec<[f64; 2]>,
    masses: Vec<f64>,
}

impl Start {
    /// (1 - |x|^2)^exponent on the points of h Z^2.
    fn new(exponent: u32, h: f64) -> Result<Self> {
        let bump = Bump::new(1.0, 1.0, exponent)?;
        let side = (1.0 / h).ceil() as i32;
        let (mut positions, mut masses) = (Vec::new(), Vec::new());
        for (i, j) in (-side..=side).flat_map(|i| (-side..=side).map(move |j| (i, j))) {
            let x = [f64::from(i) * h, f64::from(j) * h];
            let r = x[0].hypot(x[1]);
            if r < 1.0 {
                positions.push(x);
                masses.push(bump.density(r) * h * h);
            }
        }
        Ok(Self { bump, positions, masses })
    }

    /// Where each particle is at the end.
    fn exact(&self) -> Vec<[f64; 2]> {
        let at_end = |x: &[f64; 2]| {
            let r = x[0].hypot(x[1]);
            let factor = contraction::<f64, 2>(1.0, self.bump.enclosed_mass::<2>(r), r, END);
            x.map(|x| x * factor)
        };
        self.positions.iter().map(at_end).collect()
    }

    /// The mean distance between two sets of positions, weighted with masses.
    fn distance(&self, a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
        let distances = a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        distances.zip(&self.masses).map(|(d, m)| d * m).sum::<f64>() / self.masses.iter().sum::<f64>()
    }
}

/// Positions at the end, and the CPU time of all: kernel, plan, workspace and steps.
fn run(start: &Start, choice: Choice) -> Result<(Vec<[f64; 2]>, f64)> {
    let Choice { mollifier, factor, h, steps, tolerance } = choice;
    let mut positions = start.positions.clone();
    let before = cpu_time();
    let mut memory = Vec::new();
    let kernel = prepared::<f64, 2>(&mut memory, KernelName::Law(Law::Newtonian), mollifier, factor * h.powf(0.9))?;
    let options = Options { tolerance, ..Options::default() };
    let plan = aggregation::plan(&kernel, positions.len(), 0, Wanted::default(), &options)?;
    let mut memory = vec![0_u8; plan.workspace_bytes::<f64, 2>(1)? + 64];
    let particles = Trajectories { positions: &mut positions, density: None, velocity: None, divergence: None };
    let state = State { masses: &start.masses, particles, tracers: Trajectories::none() };
    let advance = Advance { dt: END / steps as f64, steps, after_step: None };
    aggregation::step(
        &plan,
        &kernel,
        state,
        advance,
        aligned(&mut memory),
        &mut Run::default(),
        &mut Report::default(),
    )?;
    Ok((positions, (cpu_time() - before).as_secs_f64()))
}

/// first / sqrt(2)^k.
fn spacings(first: f64, n: i32) -> Vec<f64> {
    (0..n).map(|k| first * 2.0_f64.powf(-0.5 * f64::from(k))).collect()
}

/// A curve over the spacings, for data of an exponent.
fn curve(name: &str, exponent: u32, h: &[f64], choice: Choice) -> Result<Curve> {
    let row = |&h: &f64| {
        let start = Start::new(exponent, h)?;
        let (positions, time) = run(&start, Choice { h, ..choice })?;
        let error = start.distance(&positions, &start.exact());
        Ok(Row { setting: format!("h = {h:.4}, {} particles", start.masses.len()), time, error, spread: None })
    };
    Ok(Curve { name: name.to_owned(), rows: h.iter().map(row).collect::<Result<_>>()? })
}

fn compact(order: u32, exponent: u32) -> Mollifier {
    Mollifier::Compact { order, exponent }
}

const GAUSSIAN: Mollifier = Mollifier::Gaussian { order: 4 };

/// The rows of `numpy_blob.py`.
fn peer(path: &std::path::Path) -> Result<Curve> {
    let value: serde_json::Value = serde_json::from_slice(&std::fs::read(path)?)?;
    let kernel = value["kernel"].as_str().context("the peer has no kernel")?;
    let rows = value["rows"].as_array().context("the peer has no rows")?;
    let row = |row: &serde_json::Value| {
        let number = |name: &str| row[name].as_f64().with_context(|| format!("the peer's row has no {name}"));
        let setting = format!("h = {:.4}, {} particles", number("h")?, number("particles")?);
        Ok(Row { setting, time: number("seconds")?, error: number("error")?, spread: None })
    };
    let rows = rows.iter().map(row).collect::<Result<Vec<Row>>>()?;
    ensure!(!rows.is_empty(), "the peer has no rows");
    Ok(Curve { name: format!("NumPy and VODE: Gaussian, order 4, {kernel}"), rows })
}

/// How many times as long a row takes as the fastest of these curves with at most its error.
fn ratio(curves: &[Curve], peer: &Row) -> Option<String> {
    let (_, best) = fastest(curves, peer.error)?;
    Some(format!("{:.0} times as long at {:.1e}", peer.time / best.time, peer.error))
}

/// The paper's data, beside the paper's way to compute.
pub fn paper(work: &Work) -> Result<Study> {
    let h = spacings(0.1, if work.quick { 3 } else { 9 });
    let common = Choice { mollifier: GAUSSIAN, factor: 1.0, h: 0.0, steps: 6, tolerance: 1e-8 };
    let mut curves = vec![
        curve("mollis: Gaussian, order 4, delta = h^0.9", 2, &h, common)?,
        curve(
            "the same in 20 steps, all pairs",
            2,
            h.get(..6).unwrap_or(&h),
            Choice { steps: 20, tolerance: 0.0, ..common },
        )?,
        curve(
            "mollis: compact, M = 9, order 4, delta = 4 h^0.9",
            2,
            &h,
            Choice { mollifier: compact(4, 9), factor: 4.0, ..common },
        )?,
        curve("mollis: particle method", 2, &h, Choice { mollifier: Mollifier::None, ..common })?,
    ];
    let peers = work.numpy.iter().map(|path| peer(path)).collect::<Result<Vec<Curve>>>()?;
    let note = |peer: &Curve| {
        let ratios: Vec<String> = peer.rows.iter().filter_map(|row| ratio(&curves, row)).collect();
        format!("{}, over the fastest above with at most its error: {}.", peer.name, ratios.join(", "))
    };
    let notes = peers.iter().map(note).collect();
    curves.extend(peers);
    Ok(Study {
        name: "blob",
        question: "How long does the blob method take to a given error, beside the way that its authors describe?",
        about: "Craig & Bertozzi, Figure 5: attraction in the plane, initial density (1 - |x|^2)^2, to t = 0.5, from a coarse lattice to a fine one. mollis takes 6 steps of RK4, whose error is \
                below 1e-8 (study `steps`), and sums to a tolerance of 1e-8; VODE chooses its steps for 1e-9 (1e-10 absolute), about 70 right-hand sides. The peer computes each pair once and takes \
                the closed form of the gradient (exact) or a table."
            .to_owned(),
        unit: "s",
        error: "mean distance of particles from their exact positions",
        digits: &[3, 4, 5, 6, 7],
        notes,
        curves,
    })
}

/// Which order of the mollifier pays.
pub fn orders(work: &Work) -> Result<Study> {
    let h = spacings(0.1, if work.quick { 3 } else { 9 });
    let common = Choice { mollifier: GAUSSIAN, factor: 1.0, h: 0.0, steps: 20, tolerance: 1e-12 };
    let cases = [
        ("order 2, M = 4, delta = 2.5 h^0.9", compact(2, 4), 2.5),
        ("order 4, M = 4, delta = 3 h^0.9", compact(4, 4), 3.0),
        ("order 4, M = 9, delta = 4 h^0.9", compact(4, 9), 4.0),
        ("order 6, M = 9, delta = 5 h^0.9", compact(6, 9), 5.0),
        ("order 8, M = 9, delta = 6 h^0.9", compact(8, 9), 6.0),
        ("order 8, M = 9, delta = 4.5 h^0.9", compact(8, 9), 4.5),
        ("Gaussian of order 4, delta = h^0.9", GAUSSIAN, 1.0),
        ("particle method", Mollifier::None, 1.0),
    ];
    let of = |&(name, mollifier, factor): &(&str, Mollifier, f64)| {
        curve(name, 10, &h, Choice { mollifier, factor, ..common })
    };
    Ok(Study {
        name: "orders",
        question: "Which order of the mollifier pays at which accuracy?",
        about: "The same for smooth data, (1 - |x|^2)^10, in 20 steps, tolerance 1e-12.".to_owned(),
        unit: "s",
        error: "mean distance of particles from their exact positions",
        digits: &[3, 6, 8, 10],
        curves: cases.iter().map(of).collect::<Result<_>>()?,
        notes: vec![],
    })
}

/// How many steps are needed.
pub fn steps(work: &Work) -> Result<Study> {
    let h = if work.quick { 0.1 } else { 0.0125 };
    let start = Start::new(10, h)?;
    let choice = Choice { mollifier: compact(6, 9), factor: 5.0, h, steps: 640, tolerance: 1e-12 };
    let (fine, _) = run(&start, choice)?;
    let row = |&steps: &usize| {
        let (positions, time) = run(&start, Choice { steps, ..choice })?;
        Ok(Row { setting: format!("{steps} steps"), time, error: start.distance(&positions, &fine), spread: None })
    };
    let curve = Curve {
        name: "RK4".to_owned(),
        rows: [1, 2, 3, 5, 10, 20, 40, 80, 160].iter().map(row).collect::<Result<_>>()?,
    };
    Ok(Study {
        name: "steps",
        question: "How many steps of RK4 does a run need?",
        about: format!(
            "The same smooth data on {} particles (h = {h}), compact mollifier of order 6; the error is that of time alone, against 640 steps. The particles' distances shrink to two thirds at the centre.",
            start.masses.len()
        ),
        unit: "s",
        error: "mean distance of particles from their positions after 640 steps",
        digits: &[3, 6, 10],
        curves: vec![curve],
        notes: vec![],
    })
}
