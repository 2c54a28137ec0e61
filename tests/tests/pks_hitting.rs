//! Two particles: the distribution of their collision time against the exact law.

use mollis_core::euler_maruyama::Control;
use mollis_core::exec::Run;
use mollis_core::field::{self, Interaction};
use mollis_core::pks::{
    Attraction, CollisionLaw, Counters, Event, Events, Options, Report, Setting, State, step, workspace_bytes,
};
use mollis_core::random::Philox;
use mollis_core::special::incomplete_gamma;

/// V = log r / (2 pi), unmollified.
struct Log;
impl Interaction<f64, 2> for Log {
    fn value(&self, r: f64) -> f64 {
        r.ln() / core::f64::consts::TAU
    }
    fn gradient_factor(&self, r: f64) -> f64 {
        1.0 / (core::f64::consts::TAU * r * r)
    }
    fn laplacian(&self, _: f64) -> f64 {
        0.0
    }
    fn is_singular(&self) -> bool {
        true
    }
}

struct Times {
    tau: Vec<f64>,
    censored: usize,
}

/// Collision times of `n` independent pairs of unit masses at distance 1, mu~ = 1: Y_0 = 1/4, beta^2 = 1.
fn times(nu: f64, law: CollisionLaw, n: usize, horizon: f64) -> Times {
    let mut options = Options::new(-2.0 * nu * core::f64::consts::TAU, 1.0);
    options.law = law;
    options.probability = 1e-12;
    options.control = Control { width: f64::INFINITY, at_least: 64, at_most: 1000 };
    let exactly = field::Options::default();
    let attraction = Attraction::Sum(&Log, &exactly);
    let bytes = workspace_bytes(2, attraction.summed(), &options, 1).unwrap();
    let mut memory = vec![0_u8; bytes + 64];
    let start = memory.as_ptr().align_offset(64);
    let memory = &mut memory[start..start + bytes];
    let mut out = Times { tau: Vec::new(), censored: 0 };
    for sample in 0..n {
        let (mut positions, mut masses, mut labels) = ([[0.0_f64, 0.0], [1.0, 0.0]], [1.0; 2], [0, 1]);
        let mut counters = Counters { count: 2, ..Counters::default() };
        let (mut events, mut absorbed, mut written, mut labels_written) = ([Event::default()], [0], 0, 0);
        let mut report = Report::default();
        loop {
            let d = [positions[0][0] - positions[1][0], positions[0][1] - positions[1][1]];
            let moment = 0.25 * (d[0] * d[0] + d[1] * d[1]);
            // Far apart a longer step changes little: P(hit) is at most Q(|nu|, 5) of it.
            let dt = (moment / 10.0).max(0.01);
            step(
                State {
                    positions: &mut positions,
                    masses: &mut masses,
                    labels: &mut labels,
                    species: None,
                    weights: None,
                },
                &mut counters,
                &mut Philox::new(sample as u64),
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
                    attraction: Attraction::Sum(&Log, &exactly),
                    run: &mut Run::default(),
                    report: Some(&mut report),
                },
            )
            .unwrap();
            if counters.count == 1 {
                out.tau.push(events[0].time);
                break;
            }
            if counters.time > horizon {
                out.censored += 1;
                break;
            }
        }
        assert_eq!(report.substeps, 2 * 64 * counters.step);
    }
    out
}

/// sqrt(n) times the largest difference between the distribution functions of the sample and of the law, over times below the horizon.
fn kolmogorov(nu: f64, times: &Times, horizon: f64) -> f64 {
    let mut tau: Vec<f64> = times.tau.iter().copied().filter(|&t| t <= horizon).collect();
    tau.sort_by(f64::total_cmp);
    let n = (times.tau.len() + times.censored) as f64;
    let law = |t: f64| incomplete_gamma::upper(-nu, 0.25 / (2.0 * t));
    let off = |(k, &t): (usize, &f64)| (law(t) - k as f64 / n).abs().max((law(t) - (k + 1) as f64 / n).abs());
    tau.iter().enumerate().map(off).fold(0.0, f64::max) * n.sqrt()
}

/// The 99.9% point of Kolmogorov's law: 2 exp(-2 1.95^2) = 0.001.
const LIMIT: f64 = 1.95;

/// The short form of `cargo xtask evidence pks-check hitting`.
#[test]
fn collision_times_follow_the_law_and_the_printed_test_does_not() {
    for (nu, n) in [(-0.5, 500), (-1.5, 3000), (-4.0, 3000)] {
        // Times beyond the 90% point count as later, because for nu = -1/2 their mean is infinite.
        let horizon = 0.125 / incomplete_gamma::upper_inverse(-nu, 0.9);
        let exact = kolmogorov(nu, &times(nu, CollisionLaw::Exact, n, horizon), horizon);
        assert!(exact < LIMIT, "nu {nu}: {exact}");
    }
    let horizon = 0.125 / incomplete_gamma::upper_inverse(1.5, 0.9);
    let printed = kolmogorov(-1.5, &times(-1.5, CollisionLaw::Printed, 3000, horizon), horizon);
    assert!(printed > LIMIT, "{printed}");
}
