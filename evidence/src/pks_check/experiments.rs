//! The experiments of Section 5, and long runs.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::{Context as _, ensure};
use mollis_core::Error;
use mollis_core::grid::{Mesh, Walls};
use mollis_core::pks::{CollisionLaw, Merging, Options, theory};
use mollis_core::random::Philox;
use mollis_core::real::DoubleWord;
use mollis_host::say;

use super::system::{Bump, Opposite, System};
use super::{Args, interval, slope};

/// The options that the arguments choose.
fn options(args: &Args, chi: f64, noise: f64) -> Options<f64> {
    Options {
        law: if args.printed { CollisionLaw::Printed } else { CollisionLaw::Exact },
        merging: if args.hard { Merging::Hard } else { Merging::All },
        ..Options::new(chi, noise)
    }
}

/// What the options have of the arguments.
fn choice(args: &Args) -> String {
    let chosen = options(args, 1.0, 1.0);
    let order = args.equation(Walls::Free).order;
    let heavy =
        args.heavy.map_or(String::new(), |mass| format!(", pairs with particles of at least {mass} critical masses"));
    format!("{:?} law, {:?} collisions merge, mesh of {order:?} order{heavy}", chosen.law, chosen.merging)
}

/// The mean of the second values over the times a..b.
fn mean(points: &[(f64, f64)], a: f64, b: f64) -> f64 {
    let chosen = window(points, a, b);
    chosen.iter().map(|p| p.1).sum::<f64>() / chosen.len() as f64
}

fn window(points: &[(f64, f64)], a: f64, b: f64) -> Vec<(f64, f64)> {
    points.iter().copied().filter(|p| p.0 > a - 1e-9 && p.0 < b + 1e-9).collect()
}

/// Section 5.2.1: M = 48 pi, 32 pi on a disc, 16 pi on an ellipse ten away.
pub fn transfer(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(40_000);
    let mass = 48.0 * PI;
    let mut results: [Vec<f64>; 4] = Default::default();
    say!("5.2.1: {n} particles, 270 x 270 on [-15, 15]^2, dt 0.001, {}", choice(args))?;
    say!(
        "seed | slope on [0, 0.02] (-20) | slope on [0.06, 0.1] (-12), alpha (2.4) of these particles | heavy / 8 pi (4) | particles | seconds"
    )?;
    for seed in args.seeds(8) {
        let start = Instant::now();
        let options = options(args, 1.0, theory::noise(mass, 1.0, n));
        let bumps = [
            Bump { centre: [-5.0, 0.0], axes: [1.0, 1.0], mass: mass * 2.0 / 3.0, count: n - n / 3 },
            Bump { centre: [5.0, 0.0], axes: [1.0, 7.0], mass: mass / 3.0, count: n / 3 },
        ];
        let mesh = Mesh::new([-15.0; 2], [15.0; 2], [270; 2])?;
        let mut system = System::new(&bumps, Some((mesh, args.equation(Walls::Free))), options, seed, args.threads)?;
        args.sum_heavy(&mut system)?;
        // All particles weigh the same.
        system.masses.iter_mut().for_each(|m| *m = mass / n as f64);
        let mut line = vec![(0.0, system.second_moment())];
        let mut drift = vec![(0.0, system.alpha())];
        let mut collapse = None;
        for _ in 0..100 {
            system.step(&mut Philox::new(seed), 1e-3)?;
            line.push((system.counters.time, system.second_moment()));
            drift.push((system.counters.time, system.alpha()));
            if collapse.is_none() && system.heaviest() > 0.5 * mass / 3.0 {
                collapse = Some(system.counters.time);
            }
            if args.verbose {
                say!(
                    "  t {:.3} Y {:.4} n {} heavy {:.3}",
                    system.counters.time,
                    system.second_moment(),
                    system.count(),
                    system.heaviest() / (8.0 * PI)
                )?;
            }
        }
        let values = [
            slope(&window(&line, 0.0, 0.02)),
            slope(&window(&line, 0.06, 0.1)),
            system.heaviest() / (8.0 * PI),
            system.count() as f64,
        ];
        say!(
            "{seed} | {:.2} | {:.2}, {:.2} | {:.4} | {} | {:.1} (collapse at {:.3})",
            values[0],
            values[1],
            mean(&drift, 0.06, 0.1),
            values[2],
            values[3],
            start.elapsed().as_secs_f64(),
            collapse.unwrap_or(f64::NAN)
        )?;
        results.iter_mut().zip(values).for_each(|(list, v)| list.push(v));
    }
    let mut passed = true;
    for (name, values, want, allowed) in
        [("before", &results[0], -20.0, 0.6), ("after", &results[1], -12.0, 0.6), ("heavy", &results[2], 4.0, 0.08)]
    {
        let (mean, half) = interval(values);
        say!("{name}: {mean:.3} +- {half:.3} (95%), theory {want} +- {allowed}")?;
        passed &= (mean - want).abs() <= allowed;
    }
    Ok(passed)
}

/// Section 5.2.2 and Figure 5.4: two bumps collapse, then move towards each other.
pub fn singularities(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(400_000);
    let mass = 64.0 * PI;
    let dt = if args.dt == 0.0 { 2e-3 } else { args.dt };
    say!("5.2.2: {n} particles, 270 x 270 on [-15, 15]^2, dt {dt}, {}", choice(args))?;
    let mut slopes = Vec::new();
    for seed in args.seeds(8) {
        let start = Instant::now();
        let options = options(args, 1.0, theory::noise(mass, 1.0, n));
        let light = (0.3 * n as f64).round() as usize;
        let bumps = [
            Bump { centre: [3.0, 1.0], axes: [1.0; 2], mass: 0.3 * mass, count: light },
            Bump { centre: [-3.0, -1.0], axes: [1.0; 2], mass: 0.7 * mass, count: n - light },
        ];
        let mesh = Mesh::new([-15.0; 2], [15.0; 2], [270; 2])?;
        let mut system = System::new(&bumps, Some((mesh, args.equation(Walls::Free))), options, seed, args.threads)?;
        args.sum_heavy(&mut system)?;
        let (mut line, mut drift, mut begun) = (Vec::new(), Vec::new(), None);
        // The moment starts at about 8.9 and falls at 13.44: all is over before t = 2.
        while system.counters.time < 2.0 {
            system.step(&mut Philox::new(seed), dt).context("step")?;
            let mut heavy: Vec<f64> = system.masses[..system.count()].to_vec();
            heavy.sort_by(|a, b| b.total_cmp(a));
            let two = heavy.iter().take(2).sum::<f64>() / mass;
            if args.verbose {
                say!(
                    "  t {:.3} Y {:.4} n {} two hold {:.4}: {:.4} {:.4}",
                    system.counters.time,
                    system.second_moment(),
                    system.count(),
                    two,
                    heavy[0] / (8.0 * PI),
                    heavy.get(1).unwrap_or(&0.0) / (8.0 * PI)
                )?;
            }
            if heavy[0] > 0.9 * mass {
                say!("seed {seed}: merged at t = {:.3}", system.counters.time)?;
                break;
            }
            if two >= 0.99 {
                begun.get_or_insert((system.counters.time, system.count(), two));
                line.push((system.counters.time, system.second_moment()));
                drift.push((system.counters.time, system.alpha()));
            }
        }
        let Some((time, count, two)) = begun else {
            say!("seed {seed}: two particles never held 99% of the mass")?;
            return Ok(false);
        };
        let value = slope(&line);
        say!(
            "seed {seed}: from t = {time:.3} ({count} particles, two hold {:.2}%) over {} steps: slope {value:.3} (theory {:.2}; alpha (2.4) of these particles {:.3}), {:.0} s",
            100.0 * two,
            line.len(),
            theory::second_moment_rate(mass, 1.0, 1.0, &[0.3 * mass, 0.7 * mass]),
            mean(&drift, 0.0, 2.0),
            start.elapsed().as_secs_f64()
        )?;
        slopes.push(value);
    }
    let (mean, half) = interval(&slopes);
    say!("slope {mean:.3} +- {half:.3} (95%), theory -13.44")?;
    Ok((mean + 13.44).abs() <= half)
}

/// Section 5.3: chi = 4, two species with (5.7), three initial conditions.
pub fn species(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(1_000_000);
    let kinds = [theory::Species::new(4.0, 17.5), theory::Species::new(24.0, 35.0 / 12.0)];
    let chi = 4.0;
    let (mass, mu) = (28.0, theory::species_mu(&kinds));
    let first = (theory::species_share(&kinds, &kinds[0]) * n as f64).floor() as usize;
    let a = 0.35;
    let disc = |centre| ([centre, [a, a]], ());
    let cases = [
        ("radial", disc([0.0, 0.0]).0, disc([0.0, 0.0]).0),
        ("ellipse", disc([0.0, 0.0]).0, [[0.1, 0.0], [a / 2.0, 2.0 * a]]),
        ("disjoint", disc([a, -a]).0, disc([-a, a]).0),
    ];
    let want = theory::second_moment_rate_of_species(&kinds, chi);
    // The martingale part of F has variance 8 mu~ F a unit time, so over a time T its rate has the standard error sqrt(8 mu~ F / T),
    // 1.4 for these, and the rate itself is the difference of two nine times as large: each run has a twin with the opposite noise,
    // whose martingale part is the opposite to first order.
    let (dt, steps) = (2e-6, if args.steps == 0 { 250 } else { args.steps });
    say!(
        "5.3: {n} particles, 320 x 320 on [-1.5, 1.5]^2, {:?}, {steps} steps of {dt}, {}; total rate (4.28) {want:.3}",
        args.walls(),
        choice(args)
    )?;
    let mut passed = true;
    for (name, one, two) in cases {
        let bumps = [
            Bump { centre: one[0], axes: one[1], mass: kinds[0].mass, count: first },
            Bump { centre: two[0], axes: two[1], mass: kinds[1].mass, count: n - first },
        ];
        let mut rates: [Vec<f64>; 3] = Default::default();
        for seed in args.seeds(4) {
            let mut of_pair = [0.0; 3];
            for opposite in [false, true] {
                let start = Instant::now();
                let options = options(args, chi, theory::noise(mass, mu, n));
                let mesh = Mesh::new([-1.5; 2], [1.5; 2], [320; 2])?;
                let mut system =
                    System::new(&bumps, Some((mesh, args.equation(args.walls()))), options, seed, args.threads)?;
                let spread: f64 = kinds.iter().map(|kind| 4.0 * kind.mu * kind.mass).sum();
                let first_rate = spread + system.pull()?;
                let mut lines = [const { Vec::new() }; 3];
                let (mut philox, mut mirrored) = (Philox::new(seed), Opposite(Philox::new(seed)));
                for _ in 0..=steps {
                    let t = system.counters.time;
                    // About the fixed centre of mass of all, as (4.28) has it.
                    let (centre, _) = system.centre(|_| true);
                    let parts = [0, 1].map(|s| system.spread(centre, |i| system.species[i] == s));
                    let values = [parts[0], parts[1], parts[0] + parts[1]];
                    lines.iter_mut().zip(values).for_each(|(line, y)| line.push((t, y)));
                    system.step(if opposite { &mut mirrored } else { &mut philox }, dt)?;
                }
                let of_run = lines.each_ref().map(|line| slope(line));
                let off = [0, 1, 2].map(|k| residual(&lines[k], of_run[k]));
                of_pair.iter_mut().zip(of_run).for_each(|(sum, rate)| *sum += 0.5 * rate);
                say!(
                    "{name} seed {seed}{}: rates {:.2} {:.2} total {:.3} (at the start by the mesh's field, without noise, {first_rate:.3}); 1 - R^2 {:.1e} {:.1e} {:.1e}; {} particles, heaviest {:.4}, {:.1} sub-steps a particle and step, {:.0} s",
                    if opposite { ", opposite noise" } else { "" },
                    of_run[0],
                    of_run[1],
                    of_run[2],
                    off[0],
                    off[1],
                    off[2],
                    system.count(),
                    system.heaviest(),
                    system.report.substeps as f64 / (n as f64 * f64::from(steps + 1)),
                    start.elapsed().as_secs_f64()
                )?;
                passed &= off[0] < 1e-2 && off[1] < 1e-2;
            }
            rates.iter_mut().zip(of_pair).for_each(|(list, rate)| list.push(rate));
        }
        let [(one, _), (two, _), (all, half)] = rates.map(|r| interval(&r));
        passed &= one > 0.0 && two < 0.0 && (all / want - 1.0).abs() < 0.02;
        say!(
            "{name}: components {one:+.2} {two:+.2}, total {all:.3} +- {half:.3} (95%) = {:+.2}% off",
            100.0 * (all / want - 1.0)
        )?;
    }
    Ok(passed)
}

/// How much of the change is not on the line of this slope: 1 - R^2.
fn residual(line: &[(f64, f64)], rate: f64) -> f64 {
    let n = line.len() as f64;
    let (t, y) = line.iter().fold((0.0, 0.0), |(a, b), p| (a + p.0 / n, b + p.1 / n));
    let off: f64 = line.iter().map(|p| (p.1 - y - rate * (p.0 - t)).powi(2)).sum();
    let all: f64 = line.iter().map(|p| (p.1 - y).powi(2)).sum();
    off / all
}

/// M = 4 pi mu / chi: half the critical mass. The slope is judged where only collisions that must happen merge: with N particles a
/// pair's index lies just below zero, and the paper's rule merges such pairs, which the limit equation knows nothing of.
pub fn subcritical(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(40_000);
    let mass = 4.0 * PI;
    let want = theory::second_moment_rate(mass, 1.0, 1.0, &[]);
    say!("subcritical: {n} particles, M = 4 pi, 1000 steps of 0.001, slope 4 mu - chi M / (2 pi) = {want:.3}")?;
    let mut passed = true;
    for hard in [false, true] {
        let args = Args { hard, ..args.clone() };
        say!("{}", choice(&args))?;
        let (mut slopes, mut excess) = (Vec::new(), Vec::new());
        let mut heaviest: f64 = 0.0;
        for seed in args.seeds(8) {
            let options = options(&args, 1.0, theory::noise(mass, 1.0, n));
            let bump = Bump { centre: [0.0; 2], axes: [1.0; 2], mass, count: n };
            let mesh = Mesh::new([-15.0; 2], [15.0; 2], [270; 2])?;
            let mut system =
                System::new(&[bump], Some((mesh, args.equation(Walls::Free))), options, seed, args.threads)?;
            let mut line = vec![(0.0, system.second_moment())];
            // The line that alpha of the particles there are, step by step, would draw.
            let mut own = vec![(0.0, 0.0)];
            for _ in 0..1000 {
                let (from, alpha) = (own.last().map_or(0.0, |p| p.1), system.alpha());
                system.step(&mut Philox::new(seed), 1e-3)?;
                line.push((system.counters.time, system.second_moment()));
                own.push((system.counters.time, from + 1e-3 * alpha));
            }
            excess.push(slope(&line) - slope(&own));
            say!(
                "seed {seed}: slope {:.3}, by alpha (2.4) of these particles {:.3}, heaviest {:.2e} of the critical mass, {} particles",
                slope(&line),
                slope(&own),
                system.heaviest() / (8.0 * PI),
                system.count()
            )?;
            slopes.push(slope(&line));
            heaviest = heaviest.max(system.heaviest());
        }
        let (off, width) = interval(&excess);
        say!("slope less that of alpha (2.4): {off:.4} +- {width:.4} (95%)")?;
        let (mean, half) = interval(&slopes);
        say!(
            "slope {mean:.4} +- {half:.4} (95%), theory {want:.4}; heaviest {:.2e} of 8 pi mu / chi",
            heaviest / (8.0 * PI)
        )?;
        passed &= heaviest < 0.01 * 8.0 * PI && (!hard || (mean - want).abs() <= half);
    }
    Ok(passed)
}

/// Ten thousand steps past blow-up, with extreme constants: mass is conserved, nothing is lost, no NaN, no hang.
pub fn stress(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(400);
    let mut passed = true;
    for (chi, dt) in
        [(1.0, 1e-8), (1.0, 1e-3), (1e3, 1e-4), (1e6, 1e-8), (1e6, 1e-4), (1e6, 1.0), (1e3, 1.0), (1.0, 1.0)]
    {
        let steps = 10_000;
        let start = Instant::now();
        let mass = 64.0 * PI;
        let mut options = options(args, chi, theory::noise(mass, 1.0, n));
        options.control.at_most = 10_000;
        let bump = Bump { centre: [0.3, -0.1], axes: [1.0; 2], mass: 0.01 * mass, count: n - 1 };
        let heavy = Bump { centre: [0.0; 2], axes: [0.0; 2], mass: 0.99 * mass, count: 1 };
        let mesh = Mesh::new([-15.0; 2], [15.0; 2], [64; 2])?;
        let mut system =
            System::new(&[heavy, bump], Some((mesh, args.equation(Walls::Free))), options, 1, args.threads)?;
        args.sum_heavy(&mut system)?;
        let initial = system.masses.clone();
        let mut refused = 0;
        for _ in 0..steps {
            match system.step(&mut Philox::new(args.first), dt) {
                Ok(()) => {}
                Err(Error::TooManySubsteps | Error::BecameNotFinite) => {
                    refused += 1;
                    break;
                }
                other => other?,
            }
        }
        let total: f64 = system.masses[..system.count()].iter().sum();
        let finite = system.positions[..system.count()].iter().flatten().all(|x| x.is_finite());
        let replayed = replay(&initial, &system);
        say!(
            "chi {chi:e} dt {dt:e}: {} of {steps} steps{}, {} particles left, mass off by {:.1e}, replay {}, {:.1} s",
            system.counters.step,
            if refused > 0 { ", then refused with a status" } else { "" },
            system.count(),
            total / mass - 1.0,
            if replayed { "bitwise" } else { "DIFFERS" },
            start.elapsed().as_secs_f64()
        )?;
        passed &= finite && replayed && (total / mass - 1.0).abs() < 1e-12;
    }
    Ok(passed)
}

/// Whether the event log makes the final masses out of the initial ones, bit for bit, and names every lost label once.
fn replay(initial: &[f64], system: &System) -> bool {
    let mut masses: Vec<Option<f64>> = initial.iter().copied().map(Some).collect();
    for (event, absorbed) in &system.log {
        let Some(mass) = masses[event.label as usize] else { return false };
        let mut mass = DoubleWord::from(mass);
        for &label in absorbed {
            let Some(m) = masses[label as usize].take() else { return false };
            mass = mass.plus(m);
        }
        let mass = mass.hi;
        masses[event.label as usize] = Some(mass);
        if mass.to_bits() != event.mass.to_bits() {
            return false;
        }
    }
    let alive: Vec<(u64, f64)> = masses.iter().enumerate().filter_map(|(k, m)| m.map(|m| (k as u64, m))).collect();
    let n = system.count();
    alive.len() == n
        && alive
            .iter()
            .zip(system.labels[..n].iter().zip(&system.masses[..n]))
            .all(|((k, m), (l, w))| k == l && m.to_bits() == w.to_bits())
}

/// Nanoseconds a particle and step at 1e6 particles on 320 x 320.
pub fn speed(args: &Args) -> anyhow::Result<bool> {
    let n = args.particles(1_000_000);
    let mass = 48.0 * PI;
    for (name, merging) in [("without", Merging::Never), ("with", Merging::All)] {
        let options = Options { merging, ..Options::new(1.0, theory::noise(mass, 1.0, n)) };
        let bump = Bump { centre: [0.0; 2], axes: [7.0; 2], mass, count: n };
        let mesh = Mesh::new([-15.0; 2], [15.0; 2], [320; 2])?;
        let mut system = System::new(&[bump], Some((mesh, args.equation(Walls::Free))), options, 1, args.threads)?;
        let mut best = f64::INFINITY;
        for _ in 0..30 {
            let before = system.report.substeps;
            let start = Instant::now();
            system.step(&mut Philox::new(1), 1e-4)?;
            best = best.min(start.elapsed().as_secs_f64());
            ensure!(system.report.substeps - before < 2 * n as u64, "more than one sub-step a particle");
        }
        say!(
            "{name} cluster search: {:.1} ns a particle and step ({} particles left)",
            1e9 * best / n as f64,
            system.count()
        )?;
    }
    Ok(true)
}
