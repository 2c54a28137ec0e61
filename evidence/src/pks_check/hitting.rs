//! Two particles: the time of their collision against the exact law `tau = M Y_0 / (4 mu~ U)`, U ~ Gamma(|nu|, 1).

use super::Args;
use mollis_core::euler_maruyama::Control;
use mollis_core::exec::Run;
use mollis_core::field::{self, Interaction};
use mollis_core::pks::{
    Attraction, CollisionLaw, Counters, Event, Events, Options, Report, Setting, State, step, workspace_bytes,
};
use mollis_core::random::Philox;
use mollis_core::special::incomplete_gamma;
use mollis_host::memory::Memory;
use mollis_host::say;

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
fn times(nu: f64, law: CollisionLaw, n: usize, seed: u64, horizon: f64, smallest: f64) -> anyhow::Result<Times> {
    let mut options = Options::new(-2.0 * nu * core::f64::consts::TAU, 1.0);
    options.law = law;
    options.probability = 1e-12;
    options.control = Control { width: f64::INFINITY, at_least: 64, at_most: 1000 };
    let exactly = field::Options::default();
    let attraction = Attraction::Sum(&Log, &exactly);
    let bytes = workspace_bytes(2, attraction.summed(), &options, 1)?;
    let mut memory = Memory::new(bytes);
    let memory = memory.slice();
    let mut out = Times { tau: Vec::new(), censored: 0 };
    for sample in 0..n {
        let (mut positions, mut masses, mut labels) = ([[0.0_f64, 0.0], [1.0, 0.0]], [1.0; 2], [0, 1]);
        let mut counters = Counters { count: 2, ..Counters::default() };
        let (mut events, mut absorbed, mut written, mut labels_written) = ([Event::default()], [0], 0, 0);
        let mut report = Report::default();
        loop {
            let d = [positions[0][0] - positions[1][0], positions[0][1] - positions[1][1]];
            let moment = 0.25 * (d[0] * d[0] + d[1] * d[1]);
            // Far apart a longer step changes nothing: P(hit) = Q(|nu|, 10) at most.
            let dt = (moment / 20.0).max(smallest);
            step(
                State {
                    positions: &mut positions,
                    masses: &mut masses,
                    labels: &mut labels,
                    species: None,
                    weights: None,
                },
                &mut counters,
                &mut Philox::new(seed.wrapping_add(sample as u64)),
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
            )?;
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
    Ok(out)
}

/// sqrt(n) times the largest distances of the sample's distribution function from the law's, over times below the horizon: below it
/// (too late) and above it (too early).
fn kolmogorov(nu: f64, times: &Times, horizon: f64) -> (f64, f64) {
    let mut tau: Vec<f64> = times.tau.iter().copied().filter(|&t| t <= horizon).collect();
    tau.sort_by(f64::total_cmp);
    let n = (times.tau.len() + times.censored) as f64;
    let law = |t: f64| incomplete_gamma::upper(-nu, 0.25 / (2.0 * t));
    let off = |(k, &t): (usize, &f64)| (law(t) - k as f64 / n, (k + 1) as f64 / n - law(t));
    let larger = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.max(b.1));
    let (late, early) = tau.iter().enumerate().map(off).fold((0.0, 0.0), larger);
    (late * n.sqrt(), early * n.sqrt())
}

/// Kolmogorov's law: P(K > x), for x not too small.
fn p_value(x: f64) -> f64 {
    (1..40)
        .map(|k| 2.0 * if k % 2 == 1 { 1.0 } else { -1.0 } * (-2.0 * f64::from(k * k) * x * x).exp())
        .sum::<f64>()
        .clamp(0.0, 1.0)
}

/// nu = -1/2, -3/2, -4, both laws.
pub fn run(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(20_000);
    say!(
        "{n} pairs each, 64 sub-steps a step, dt = max(Y / 20, s) with Y_0 = 1/4, beta = 1; times beyond the 90% point count as later"
    )?;
    let mut passed = true;
    // A pair that comes within Y ~ dt and escapes again does so with a chance ~ dt^|nu|, which one step does not resolve: soft collisions
    // need the smaller step.
    for (nu, smallest) in [(-0.5, 2e-4), (-1.5, 3e-3), (-4.0, 3e-3)] {
        let horizon = 0.125 / incomplete_gamma::upper_inverse(-nu, 0.9);
        let own = args.shortest == 0.0;
        let smallest = if own { smallest } else { args.shortest };
        for law in [CollisionLaw::Exact, CollisionLaw::Printed] {
            if law == CollisionLaw::Printed && !own {
                continue;
            }
            let times = times(nu, law, n, args.first << 32, horizon, smallest)?;
            let (late, early) = kolmogorov(nu, &times, horizon);
            let k = late.max(early);
            say!(
                "nu {nu:4}, s = {smallest}, {law:?}: sqrt(n) D = {k:.3} (late {late:.3}, early {early:.3}), D = {:.4}, p = {:.2e} ({} collided before t = {horizon:.3})",
                k / (n as f64).sqrt(),
                p_value(k),
                times.tau.len()
            )?;
            passed &= (p_value(k) > 1e-3) == (law == CollisionLaw::Exact);
        }
    }
    Ok(passed)
}
