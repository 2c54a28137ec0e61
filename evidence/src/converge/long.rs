//! Long runs: steady states and conservation.

use anyhow::Result;
use mollis_core::diagnostics::{moments, stable_step};
use mollis_core::exact::{radial, steady};
use mollis_core::kernel::{Kernel, Law};
use mollis_core::mollifier::Mollifier;
use mollis_core::{Error, Real};
use mollis_host::say;

use super::run::{Cloud, kernel_memory, power, term};

const PSI4: Mollifier = Mollifier::Gaussian { order: 4 };

/// `C (1 - |x|^2)^2` of mass 1 on a lattice (4.7).
fn bump<T: Real>(h: f64) -> Result<Cloud<T, 2>> {
    let density = radial::Bump::new(1.0, 1.0, 2)?;
    let mut cloud = Cloud::on_lattice(h, |r| (r < 1.0).then(|| density.density(r)));
    cloud.normalise();
    Ok(cloud)
}

/// K = |x|^2 / 2 and unit mass: every particle approaches the centre of mass as e^-t. RK4 multiplies by its stability polynomial
/// in each step, which is what is left to compare: rounding.
pub fn contraction() -> Result<bool> {
    let terms = [power(1.0, 2.0)];
    say!("{:>9} {:>12} {:>14} {:>14}", "dt", "|x|/|x_0|", "over e^-t - 1", "over RK4's - 1")?;
    let mut good = true;
    for mollifier in [Mollifier::None, PSI4, Mollifier::Compact { order: 2, exponent: 4 }] {
        for steps in [10, 20, 40, 80] {
            let mut memory = kernel_memory::<f64, 2>(&terms, mollifier)?;
            let kernel = Kernel::prepare(memory.slice(), &terms, mollifier, 0.3)?;
            let mut cloud = bump::<f64>(0.1)?;
            let before = cloud.radii()?;
            let dt = 2.0 / f64::from(steps);
            cloud.advance(&kernel, dt, steps as usize, false, false).0?;
            let after = cloud.radii()?;
            let (mut factor, mut worst) = (0.0, 0.0_f64);
            let z = -dt;
            let polynomial = (1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))).powi(steps);
            for (a, b) in after.iter().zip(&before).filter(|(_, b)| **b > 0.1) {
                factor = a / b;
                worst = worst.max((factor / polynomial - 1.0).abs());
            }
            say!("{dt:9.4} {factor:12.8} {:14.3e} {worst:14.3e}", factor / (-2.0_f64).exp() - 1.0)?;
            // Some 4 n roundings of forces, 300 particles, 80 steps: below 1e-12.
            good &= worst < 1e-12;
        }
    }
    Ok(good)
}

/// Moves particles by 1e-3: the lattice's symmetry is a saddle, and its particle at the centre would stay there.
fn perturb(cloud: &mut Cloud<f64, 2>) {
    for (k, x) in cloud.x.iter_mut().enumerate() {
        let angle = 2.399_963 * k as f64;
        x[0] += 1e-3 * angle.cos();
        x[1] += 1e-3 * angle.sin();
    }
}

/// Runs to time `time` with steps below the estimate at the current state, looked up every few steps, and at most `longest`.
fn settle(cloud: &mut Cloud<f64, 2>, kernel: &Kernel<'_, f64, 2>, time: f64, longest: f64) -> Result<()> {
    let mut at = 0.0;
    while at < time {
        let dt = stable_step(kernel, &cloud.x, &cloud.m)?.min(longest);
        cloud.advance(kernel, dt, 25, false, false).0?;
        at += 25.0 * dt;
    }
    Ok(())
}

/// The ring of K = |x|^4/4 - |x|^1.5/1.5.
pub fn ring() -> Result<bool> {
    let radius: f64 = steady::ring_radius(4.0, 1.5)?;
    say!("radius of the ring in closed form: {radius:.8}")?;
    say!("{:>9} {:>9} {:>12} {:>12} {:>12}", "delta", "particles", "mean radius", "off by", "spread")?;
    let terms = [power(1.0, 4.0), power(-1.0, 1.5)];
    let mut last = f64::INFINITY;
    for delta in [0.3, 0.2, 0.1, 0.05, 0.0] {
        let mollifier = if delta > 0.0 { PSI4 } else { Mollifier::None };
        let mut memory = kernel_memory::<f64, 2>(&terms, mollifier)?;
        let kernel = Kernel::prepare(memory.slice(), &terms, mollifier, delta)?;
        let mut cloud = bump::<f64>(0.2)?;
        perturb(&mut cloud);
        settle(&mut cloud, &kernel, 100.0, 0.1)?;
        let radii = cloud.radii()?;
        // Unequal masses: the ring's radius is the mean by mass.
        let mean: f64 = radii.iter().zip(&cloud.m).map(|(r, m)| r * m).sum();
        let spread = radii.iter().map(|r| (r - mean).abs()).fold(0.0, f64::max);
        last = (mean - radius).abs();
        say!("{delta:9.3} {:9} {mean:12.8} {:12.3e} {spread:12.3e}", radii.len(), mean - radius)?;
        if delta == 0.05 && last > 1e-3 {
            return Ok(false);
        }
    }
    Ok(last < 1e-3)
}

/// Groups of particles closer than `apart` to each other, by growing from each particle, and the largest distance within one.
fn count_clusters(cloud: &Cloud<f64, 2>, apart: f64) -> (usize, f64) {
    let mut left: Vec<[f64; 2]> = cloud.x.clone();
    let (mut clusters, mut size) = (0, 0.0_f64);
    while let Some(first) = left.pop() {
        clusters += 1;
        let mut edge = vec![first];
        let mut members: Vec<[f64; 2]> = Vec::new();
        while let Some(x) = edge.pop() {
            size = members.iter().map(|y| (x[0] - y[0]).hypot(x[1] - y[1])).fold(size, f64::max);
            members.push(x);
            let near = |y: &[f64; 2]| (x[0] - y[0]).hypot(x[1] - y[1]) < apart;
            edge.extend(left.iter().filter(|y| near(y)).copied().collect::<Vec<_>>());
            left.retain(|y| !near(y));
        }
    }
    (clusters, size)
}

/// The ring of K = |x|^7/7 - |x|^1.5/1.5 breaks; large delta leaves three clusters.
pub fn clusters() -> Result<bool> {
    say!(
        "{:>9} {:>9} {:>9} {:>12} {:>12} {:>12}",
        "delta",
        "particles",
        "clusters",
        "diameter",
        "mean radius",
        "spread"
    )?;
    let terms = [power(1.0, 7.0), power(-1.0, 1.5)];
    let mut found = Vec::new();
    for delta in [0.0, 0.05, 0.32] {
        let mollifier = if delta > 0.0 { PSI4 } else { Mollifier::None };
        let mut memory = kernel_memory::<f64, 2>(&terms, mollifier)?;
        let kernel = Kernel::prepare(memory.slice(), &terms, mollifier, delta)?;
        let mut cloud = bump::<f64>(0.15)?;
        perturb(&mut cloud);
        settle(&mut cloud, &kernel, 150.0, 0.1)?;
        let radii = cloud.radii()?;
        let mean: f64 = radii.iter().zip(&cloud.m).map(|(r, m)| r * m).sum();
        let spread = radii.iter().map(|r| (r - mean).abs()).fold(0.0, f64::max);
        let (clusters, diameter) = count_clusters(&cloud, 0.05);
        found.push(clusters);
        say!("{delta:9.3} {:9} {clusters:9} {diameter:12.3e} {mean:12.6} {spread:12.3e}", radii.len())?;
    }
    Ok(found.last() == Some(&3) && found.first().is_some_and(|&n| n > 1))
}

/// The radial steady state of K = |x|^4/4 - log|x|/(2 pi).
///
/// Its density is compared with the sum of blobs. The density along the trajectories is printed too, but it is no measure of a
/// steady state: its logarithm integrates the divergence over time, and what the divergence is off by adds up.
pub fn radial() -> Result<bool> {
    let state = steady::QuarticLogarithmic::<f64>::new();
    say!("radius {:.6}, second moment {:.8}", state.radius, state.second_moment)?;
    say!(
        "{:>9} {:>9} {:>12} {:>12} {:>14} {:>14} {:>14}",
        "h",
        "particles",
        "radius",
        "second",
        "off by",
        "blobs off",
        "along it off"
    )?;
    let terms = [power(1.0, 4.0), term(-1.0, Law::Newtonian)];
    let mut last = (f64::INFINITY, f64::INFINITY);
    let mut good = true;
    for h in [0.2, 0.1414, 0.1, 0.0707] {
        // Blobs of 1.4 spacings at the end, where the particles stand twice as close as at the start.
        let delta = 0.5 * f64::powf(h, 0.9);
        let mut memory = kernel_memory::<f64, 2>(&terms, PSI4)?;
        let kernel = Kernel::prepare(memory.slice(), &terms, PSI4, delta)?;
        let mut cloud = bump::<f64>(h)?;
        cloud.advance(&kernel, 0.05, 400, true, false).0?;
        let second = moments(&cloud.x, &cloud.m)?.second;
        let radii = cloud.radii()?;
        let outer = radii.iter().copied().fold(0.0, f64::max);
        let off = (second - state.second_moment).abs() / state.second_moment;
        // Mean over the mass that stands well inside the support.
        let mean = |density: &[f64]| {
            let all = radii.iter().zip(density).zip(&cloud.m);
            let inside = all.filter(|((r, _), _)| **r < state.radius - 3.0 * delta);
            let (sum, mass) = inside.fold((0.0, 0.0), |(sum, mass), ((&r, &rho), &m)| {
                (sum + m * (rho / state.density(r) - 1.0).abs(), mass + m)
            });
            sum / mass
        };
        let (blobs, along) = (mean(&cloud.blob_density(PSI4, delta)?), mean(&cloud.rho));
        say!("{h:9.4} {:9} {outer:12.6} {second:12.8} {off:14.3e} {blobs:14.3e} {along:14.3e}", radii.len())?;
        // The density converges with order 1.5 in h at least (2 is found), the moment whatever its order.
        good &= off < last.0 && blobs < 0.6 * last.1;
        last = (off, blobs);
    }
    Ok(good && last.0 < 1e-3)
}

/// 1e5 steps in each scalar.
pub fn conservation() -> Result<bool> {
    say!(
        "{:>6} {:>9} {:>8} {:>14} {:>22} {:>12}",
        "scalar",
        "particles",
        "steps",
        "drift/radius",
        "over u sqrt(steps)",
        "energy rose"
    )?;
    let double = drift::<f64>("f64")?;
    let single = drift::<f32>("f32")?;
    Ok(double && single)
}

/// The stated constant: the drift is below this times u sqrt(steps) of the radius.
const DRIFT: f64 = 4.0;

fn drift<T: Real>(name: &str) -> Result<bool> {
    let terms = [power(1.0, 4.0), power(-1.0, 1.5)];
    let mollifier = Mollifier::Compact { order: 4, exponent: 9 };
    let mut memory = kernel_memory::<T, 2>(&terms, mollifier)?;
    let kernel = Kernel::<T, 2>::prepare(memory.slice(), &terms, mollifier, T::from_f64(0.2))?;
    let mut cloud = bump::<T>(0.3)?;
    // Off the lattice's symmetry, so that sums do not cancel by it.
    for (k, x) in cloud.x.iter_mut().enumerate() {
        let angle = 2.399_963 * k as f64;
        *x = [x[0] + T::from_f64(0.05 * angle.cos() + 0.3), x[1] + T::from_f64(0.05 * angle.sin() - 0.2)];
    }
    let before = moments(&cloud.x, &cloud.m)?;
    let steps = 100_000;
    let (result, report) = cloud.advance(&kernel, 0.01, steps, false, true);
    let rose = result == Err(Error::EnergyRose);
    if !rose {
        result?;
    }
    let after = moments(&cloud.x, &cloud.m)?;
    let apart =
        before.centre.iter().zip(&after.centre).map(|(a, b)| (a.to_f64() - b.to_f64()).powi(2)).sum::<f64>().sqrt();
    let radius = cloud.radii()?.into_iter().fold(0.0, f64::max);
    let unit = T::EPSILON.to_f64() / 2.0 * (steps as f64).sqrt();
    let constant = apart / radius / unit;
    say!(
        "{name:>6} {:9} {:8} {:14.3e} {constant:22.3} {:>12}",
        cloud.x.len(),
        report.steps,
        apart / radius,
        if rose { "yes" } else { "no" }
    )?;
    Ok(!rose && constant <= DRIFT)
}
