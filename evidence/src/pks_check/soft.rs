//! Five equal particles of index -1.8 whose pairs, threes and fours collide and do not merge: the time at which all five do, against the exact law.

use core::f64::consts::TAU;

use mollis_core::exec::Run;
use mollis_core::field;
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::pks::{
    Attraction, Counters, Event, Events, Merging, Options, Report, Scheme, Setting, State, step, workspace_bytes,
};
use mollis_core::random::Philox;
use mollis_core::special::incomplete_gamma;
use mollis_host::memory::Memory;

use super::Args;

/// Later than 97% of the law, and no later time is told from another.
const HORIZON: f64 = 8.0;

/// The share of the law below a time: Y_0 = 1, M = 5, mu~ = 1.
fn law(t: f64) -> f64 {
    incomplete_gamma::upper(1.8, 1.25 / t)
}

/// Sorted times, those beyond the horizon infinite.
fn times(scheme: Scheme, delta: f64, dt: f64, paths: usize, seed: u64) -> anyhow::Result<Vec<f64>> {
    // nu = N - 2 - gamma chi N (N - 1) / (4 mu~) = 3 - 5 gamma chi.
    let options = Options { merging: Merging::Hard, scheme, ..Options::new(4.8 / 5.0 * TAU, 1.0) };
    let kernel = Blob::new(Mollifier::Compact { order: 2, exponent: 4 }, delta)?;
    let exactly = field::Options::default();
    let bytes = workspace_bytes(5, Some((&kernel, &exactly)), &options, 1)?;
    let mut memory = Memory::new(bytes);
    let memory = memory.slice();
    let mut times = Vec::with_capacity(paths);
    for path in 0..paths as u64 {
        let mut positions: Vec<[f64; 2]> =
            (0..5).map(|k| (TAU * f64::from(k) / 5.0).sin_cos()).map(|(y, x)| [x, y]).collect();
        let (mut masses, mut labels) = ([1.0; 5], [0, 1, 2, 3, 4]);
        let mut counters = Counters { count: 5, ..Counters::default() };
        let (mut events, mut absorbed, mut written, mut labels_written) = ([Event::default()], [0; 4], 0, 0);
        let mut report = Report::default();
        while written == 0 && counters.time < HORIZON {
            step(
                State {
                    positions: &mut positions,
                    masses: &mut masses,
                    labels: &mut labels,
                    species: None,
                    weights: None,
                },
                &mut counters,
                &mut Philox::new(seed.wrapping_add(path)),
                dt,
                Events {
                    events: &mut events,
                    labels: &mut absorbed,
                    written: &mut written,
                    labels_written: &mut labels_written,
                },
                memory,
                Setting {
                    options: &options,
                    attraction: Attraction::Sum(&kernel, &exactly),
                    run: &mut Run::default(),
                    report: Some(&mut report),
                },
            )?;
        }
        times.push(if written > 0 { events[0].time } else { f64::INFINITY });
    }
    times.sort_by(f64::total_cmp);
    Ok(times)
}

/// Medians over lengths of the mollifier and steps, for both schemes.
pub fn run(args: &Args) -> anyhow::Result<bool> {
    let paths = args.particles(10_000);
    let exact = 1.25 / incomplete_gamma::upper_inverse(1.8, 0.5);
    println!(
        "{paths} paths each, Y_0 = 1, mu~ = 1: the law's median is {exact:.4}; standard error of the law at a median {:.4}",
        0.5 / (paths as f64).sqrt()
    );
    let steps = if args.dt > 0.0 { vec![args.dt] } else { vec![1e-2, 1e-3] };
    let mut passed = true;
    for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
        for &dt in &steps {
            for delta in [1e-9, 1e-6, 1e-2] {
                let times = times(scheme, delta, dt, paths, args.first << 32)?;
                let median = 0.5 * (times[(paths - 1) / 2] + times[paths / 2]);
                let n = paths as f64;
                let off =
                    |(k, &t): (usize, &f64)| (law(t) - k as f64 / n).abs().max((law(t) - (k + 1) as f64 / n).abs());
                let distance = times.iter().filter(|t| t.is_finite()).enumerate().map(off).fold(0.0, f64::max);
                println!(
                    "{scheme:?}, dt = {dt:e}, delta = {delta:e}: median {median:.4}, {:+.1}%, at {:.4} of the law; D = {distance:.4}",
                    100.0 * (median / exact - 1.0),
                    law(median)
                );
                // Four standard errors, and the bias of the step.
                let most = 2.0 / n.sqrt() + if dt > 1e-3 { 0.05 } else { 0.02 };
                passed &= (law(median) - 0.5).abs() < most;
            }
        }
    }
    Ok(passed)
}
