//! From densities to particles: on the grid h Z^d, or at random.

use anyhow::{Result, bail, ensure};
use mollis_core::pks::theory::{self, Species};
use mollis_core::random::{Generator, Philox, uniform};

use crate::particles::Particles;
use crate::scene::{Density, Model, Part, Sampling, Scene};

/// Random draws of the initial data have labels from here on, which no particle of a run has.
const LABELS: u64 = 1 << 63;

/// The points of h Z^d in the support, with masses rho h^d: Craig & Bertozzi, Definition 2.2. The shape's centre need not
/// be a grid point. Returns how many points have no mass and were left out; with `keep` they stay.
pub fn grid(density: &Density, h: f64, part: usize, keep: bool, particles: &mut Particles) -> Result<usize> {
    let (center, half) = density.bounds();
    let d = center.len();
    let low: Vec<i64> = (0..d).map(|axis| ((center[axis] - half[axis]) / h).floor() as i64).collect();
    let counts: Vec<u64> = (0..d).map(|axis| (2.0 * half[axis] / h).ceil() as u64 + 2).collect();
    let cells = counts.iter().map(|&n| n as f64).product::<f64>();
    ensure!(cells < 1e10, "sampling.h = {h}: {cells:.1e} grid points are too many");
    let volume = h.powi(d as i32);
    let mut index = vec![0_u64; d];
    let mut point = vec![0.0; d];
    let mut massless = 0;
    for _ in 0..cells as u64 {
        for axis in 0..d {
            point[axis] = (low[axis] + index[axis] as i64) as f64 * h;
        }
        if let Some(rho) = density.at(&point) {
            let mass = rho * volume;
            if mass > 0.0 || keep {
                particles.push(&point, mass, Some(rho), part);
            } else {
                massless += 1;
            }
        }
        for axis in 0..d {
            index[axis] += 1;
            if index[axis] < counts[axis] {
                break;
            }
            index[axis] = 0;
        }
    }
    Ok(massless)
}

/// About how many particles are sampled: exact for random ones, the support over a cell for a grid.
pub fn about(scene: &Scene, h: Option<f64>) -> f64 {
    let supports = || {
        let sampled = scene.initial.iter().filter(|part| part.shape.is_sampled());
        sampled.map(|part| Density::new(part, scene.dimension).support())
    };
    match scene.sampling {
        Some(Sampling::Random { count }) if supports().next().is_some() => count as f64,
        Some(Sampling::Grid { h: own }) => supports().sum::<f64>() / h.unwrap_or(own).powi(scene.dimension as i32),
        _ => 0.0,
    }
}

/// Under random sampling: how many particles each part gets, and its mass.
pub fn shares(scene: &Scene) -> Result<Vec<(u64, f64)>> {
    let Some(Sampling::Random { count }) = scene.sampling else { return Ok(vec![(0, 0.0); scene.initial.len()]) };
    let masses: Vec<f64> = scene
        .initial
        .iter()
        .map(|part| if part.shape.is_sampled() { Density::new(part, scene.dimension).integral() } else { 0.0 })
        .collect();
    let weights: Vec<f64> = match species(scene, &masses) {
        Some(all) => all.iter().map(|one| theory::species_share(&all, one)).collect(),
        None => scene
            .initial
            .iter()
            .zip(&masses)
            .map(|(part, mass)| if *mass > 0.0 { part.share.unwrap_or(*mass) } else { 0.0 })
            .collect(),
    };
    let whole: f64 = weights.iter().sum();
    let last = weights.iter().rposition(|&weight| weight > 0.0);
    let mut left = count;
    let mut shares = Vec::new();
    for (index, (weight, mass)) in weights.iter().zip(&masses).enumerate() {
        let mine = if Some(index) == last { left } else { ((weight / whole * count as f64).floor() as u64).min(left) };
        if *weight > 0.0 && mine == 0 {
            bail!("sampling.count = {count}: initial[{index}] gets no particle");
        }
        left -= mine;
        shares.push((mine, *mass));
    }
    Ok(shares)
}

/// The species, if the scene states any diffusivity, or sensitivities of parts whose shares follow from them.
fn species(scene: &Scene, masses: &[f64]) -> Option<Vec<Species<f64>>> {
    let own = scene.pks.map_or(1.0, |pks| pks.mu);
    let random = matches!(scene.sampling, Some(Sampling::Random { .. }));
    let states = |part: &Part| part.diffusivity.is_some() || random && part.sensitivity.is_some();
    let stated = scene.model == Model::Pks && scene.initial.iter().any(states);
    let one = |(part, &mass): (&Part, &f64)| Species {
        mass,
        mu: part.diffusivity.unwrap_or(own),
        sensitivity: part.sensitivity.unwrap_or(1.0),
    };
    stated.then(|| scene.initial.iter().zip(masses).map(one).collect())
}

/// mu~ of the particle system, with mu from the species if there are several.
pub fn diffusion(scene: &Scene, masses: &[f64]) -> f64 {
    let own: Vec<f64> = shares(scene).unwrap_or_default().iter().map(|(_, mass)| *mass).collect();
    let mu = match species(scene, &own) {
        Some(all) => theory::species_mu(&all),
        None => scene.pks.map_or(0.0, |pks| pks.mu),
    };
    theory::noise(masses.iter().sum(), mu, masses.len().max(1))
}

/// `count` particles of equal mass by rejection; particle i's draws depend on the seed, the part and i alone.
pub fn random(
    density: &Density,
    count: u64,
    mass: f64,
    part: usize,
    seed: u64,
    particles: &mut Particles,
) -> Result<()> {
    let (center, half) = density.bounds();
    let (center, top) = (center.to_vec(), density.maximum());
    let mut generator = Philox::new(seed);
    let mut point = vec![0.0; center.len()];
    for index in 0..count {
        let label = LABELS | (part as u64) << 48 | index;
        let mut attempt = 0_u32;
        loop {
            let mut words = [0; 4];
            generator.fill(label, attempt, 0, &mut words)?;
            for (axis, x) in point.iter_mut().enumerate() {
                *x = center[axis] + half[axis] * (2.0 * uniform::<f64>(words[axis]) - 1.0);
            }
            match density.at(&point) {
                Some(rho) if uniform::<f64>(words[3]) * top < rho => {
                    particles.push(&point, mass / count as f64, Some(rho), part);
                    break;
                }
                _ => attempt += 1,
            }
            ensure!(attempt < 1_000_000, "initial[{part}]: a particle was rejected a million times");
        }
    }
    Ok(())
}
