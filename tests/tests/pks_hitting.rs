//! Two particles: the time of their collision against the exact law.

use mollis_core::euler_maruyama::Control;
use mollis_core::field::{self, Interaction, Run};
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
    steps: u64,
}

/// Collision times of `n` independent pairs of unit masses at distance 1, mu~ = 1: Y_0 = 1/4, beta^2 = 1.
fn times(nu: f64, law: CollisionLaw, n: usize, x0: f64, smallest: f64, horizon: f64, substeps: u32, p: f64) -> Times {
    let mut options = Options::new(-2.0 * nu * core::f64::consts::TAU, 1.0);
    options.law = law;
    options.probability = p;
    options.control = Control { width: f64::INFINITY, at_least: substeps, at_most: 1000 };
    let attraction = Attraction::Sum(&Log, field::Options::default());
    let bytes = workspace_bytes(2, attraction.summed(), &options, 1).unwrap();
    let mut memory = vec![0_u8; bytes + 64];
    let start = memory.as_ptr().align_offset(64);
    let memory = &mut memory[start..start + bytes];
    let mut out = Times { tau: Vec::new(), censored: 0, steps: 0 };
    for sample in 0..n {
        let (mut positions, mut masses, mut labels) = ([[0.0, 0.0], [1.0, 0.0]], [1.0; 2], [0, 1]);
        let mut counters = Counters { count: 2, ..Counters::default() };
        let (mut events, mut absorbed, mut written, mut labels_written) = ([Event::default()], [0], 0, 0);
        let mut report = Report::default();
        loop {
            let d = [positions[0][0] - positions[1][0], positions[0][1] - positions[1][1]];
            let moment = 0.25 * (d[0] * d[0] + d[1] * d[1]);
            let dt = (moment / (2.0 * x0)).max(smallest).min(0.1 * horizon);
            step(
                State { positions: &mut positions, masses: &mut masses, labels: &mut labels, species: None },
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
                    attraction: Attraction::Sum(&Log, field::Options::default()),
                    run: &mut Run::default(),
                    report: &mut report,
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
        out.steps += counters.step;
    }
    out
}

/// sqrt(n) times the largest distance of the sample's distribution function from the law's, over times below the horizon.
fn kolmogorov(nu: f64, times: &Times, horizon: f64) -> f64 {
    let mut tau: Vec<f64> = times.tau.iter().copied().filter(|&t| t <= horizon).collect();
    tau.sort_by(f64::total_cmp);
    let n = (times.tau.len() + times.censored) as f64;
    let law = |t: f64| incomplete_gamma::upper(-nu, 0.25 / (2.0 * t));
    let off = |(k, &t): (usize, &f64)| (law(t) - k as f64 / n).abs().max((law(t) - (k + 1) as f64 / n).abs());
    tau.iter().enumerate().map(off).fold(0.0, f64::max) * n.sqrt()
}

#[test]
fn explore() {
    let n = std::env::var("N").map_or(2000, |v| v.parse().unwrap());
    for nu in [-0.5, -1.5, -4.0] {
        let horizon = 0.125 / incomplete_gamma::upper_inverse(-nu, 0.9);
        for (x0, smallest) in [(1e9, 0.003), (1e9, 0.01), (1e9, 0.03), (5.0, 0.003), (2.0, 0.003)] {
            let start = std::time::Instant::now();
            let t = times(nu, CollisionLaw::Exact, n, x0, smallest, horizon, 64, 1e-12);
            println!(
                "nu {nu} x0 {x0} dt {smallest}: KS {:.2} of {} censored {} steps {} {:?}",
                kolmogorov(nu, &t, horizon),
                t.tau.len(),
                t.censored,
                t.steps,
                start.elapsed()
            );
            let t = times(nu, CollisionLaw::Printed, n, x0, smallest, horizon, 64, 1e-12);
            println!("     printed: KS {:.2} of {} censored {}", kolmogorov(nu, &t, horizon), t.tau.len(), t.censored);
        }
    }
}
