//! Sums over sources, by method and tolerance.

use anyhow::Result;
use mollis_core::exec::Run;
use mollis_core::field::{self, Accumulation, Method, Options, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_core::real::Real;
use mollis_core::simd::Level;

use super::{Curve, Row, Study, Work, least_time};
use crate::field::Results;
use crate::fmm::{self, Fmm};
use crate::peers::Peer;
use crate::scene::{Scene, aligned};

/// One gradient at every source, of this scalar, and its error.
fn row<T: Real>(
    scene: &Scene<2>,
    exact: &[(usize, [f64; 2])],
    setting: String,
    options: &Options,
    level: Level,
) -> Result<Row> {
    let positions: Vec<[T; 2]> = scene.positions.iter().map(|x| x.map(T::from_f64)).collect();
    let masses: Vec<T> = scene.masses.iter().map(|&m| T::from_f64(m)).collect();
    let n = positions.len();
    let kernel = Kernel::<T, 2>::newtonian(T::ONE, Mollifier::None, T::ZERO)?;
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    let plan = field::plan(&kernel, n, n, wanted, options)?;
    let mut memory = vec![0_u8; plan.workspace_bytes(1)? + 64];
    let mut results = Results::<T, 2>::zeros(n);
    let seconds = least_time(|| {
        let outputs = results.outputs(wanted);
        let sources = Sources::new(&positions, &masses);
        let mut run = Run { level, ..Run::default() };
        field::evaluate(&plan, &kernel, sources, &positions, outputs, aligned(&mut memory), &mut run)?;
        Ok(())
    })?;
    let error = fmm::error(exact, |i| results.gradient[i].map(T::to_f64));
    Ok(Row { setting, time: 1e6 * seconds / n as f64, error, spread: None })
}

/// The study.
pub fn study(work: &Work) -> Result<Study> {
    let n = if work.quick { 3000 } else { 100_000 };
    let scene = Scene::<2>::uniform(n, None, 1);
    let peer = Fmm::of(n);
    let exact = peer.exact(&scene);
    let best = Level::best();
    let fmm = |tolerance: f64| Options { tolerance, method: Some(Method::Fmm), ..Options::default() };
    let powers = |last: i32| (2..=last).map(|digits| 10_f64.powi(-digits));
    let direct = Options { method: Some(Method::Direct), ..Options::default() };
    let compensated = Options { accumulation: Accumulation::Compensated, ..direct };
    let of = |tolerance: f64| format!("tolerance {tolerance:.0e}");
    let mut curves = vec![
        Curve {
            name: "mollis: fast multipole method, f64".to_owned(),
            rows: powers(13).map(|t| row::<f64>(&scene, &exact, of(t), &fmm(t), best)).collect::<Result<_>>()?,
        },
        Curve {
            name: "mollis: fast multipole method, f32".to_owned(),
            rows: powers(5).map(|t| row::<f32>(&scene, &exact, of(t), &fmm(t), best)).collect::<Result<_>>()?,
        },
        Curve {
            name: format!("mollis: all pairs, {best:?}"),
            rows: vec![
                row::<f32>(&scene, &exact, "f32".to_owned(), &direct, best)?,
                row::<f32>(&scene, &exact, "f32, compensated".to_owned(), &compensated, best)?,
                row::<f64>(&scene, &exact, "f64".to_owned(), &direct, best)?,
                row::<f64>(&scene, &exact, "f64, compensated".to_owned(), &compensated, best)?,
            ],
        },
        Curve {
            name: "mollis: all pairs, portable".to_owned(),
            rows: vec![row::<f64>(&scene, &exact, "f64".to_owned(), &direct, Level::Portable)?],
        },
    ];
    // Within so small a length there is no other particle, but the loop divides by the distance from the particle to itself without one.
    let softened = Scene::<2>::uniform(n, Some(1e-6), 1);
    if let Some(mut plain) = Peer::new(&softened, n, true, false) {
        let seconds = least_time(|| {
            plain.run();
            Ok(())
        })?;
        let error = fmm::error(&exact, |i| plain.gradient(i).map(|g| g / std::f64::consts::TAU));
        let row = Row { setting: "f64".to_owned(), time: 1e6 * seconds / n as f64, error, spread: None };
        curves.push(Curve { name: "a loop in C (-O3 -march=native -ffast-math)".to_owned(), rows: vec![row] });
    }
    if let Some(library) = &work.fmm2d {
        let rows = peer.peers(library, &scene, &exact)?;
        let rows = rows.into_iter().map(|row| Row {
            setting: format!("eps {:.0e}", row.setting),
            time: row.micros,
            error: row.error,
            spread: None,
        });
        curves.push(Curve { name: "FMM2D".to_owned(), rows: rows.collect() });
    }
    Ok(Study {
        name: "sums",
        question: "Which method computes a sum over sources in the plane to how many digits, and in what time?",
        about: format!(
            "Gradients of the Newtonian potential of {n} points, uniform in the unit square, masses of both signs, at the points themselves. (FMM2D computes the potentials too.)"
        ),
        unit: "us a target",
        error: "error of the gradients in the l2 norm, relative to them",
        digits: &[3, 6, 10, 13],
        curves,
        notes: vec![],
    })
}
