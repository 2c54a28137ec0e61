//! Two particles near a third: their second moment and two approximations of it (Zhelezov & Fatkullin, Section 2.4, Figure 2.3).

use std::f64::consts::PI;

use anyhow::{Result, ensure};
use mollis_core::random::{Generator, Philox, normals};

use super::simulation::Simulation;
use crate::checkpoint::{Reader, Writer};
use crate::particles::Particles;
use crate::scene::{Pks, Scene};

/// Expected jump of a sub-step as a fraction of the smallest distance.
const JUMP: f64 = 0.02;

/// A run of three particles.
pub struct Cluster<'a> {
    scene: &'a Scene,
    pks: Pks,
    positions: [[f64; 2]; 3],
    masses: [f64; 3],
    /// Approximations of the second moment: (2.21) and (2.29).
    plain: f64,
    corrected: f64,
    /// The largest error of each so far.
    errors: [f64; 2],
    step: u32,
    /// The first two have collided; nothing moves any more.
    collided: bool,
}

impl<'a> Cluster<'a> {
    /// The scene at its start.
    pub fn new(scene: &'a Scene, start: &Particles) -> Result<Self> {
        let Some(pks) = scene.pks else { anyhow::bail!("pks: missing") };
        let points = start.positions.as_chunks::<2>().0;
        ensure!(start.len() == 3, "model = \"cluster\" needs three points, there are {}", start.len());
        let positions = [points[0], points[1], points[2]];
        let masses = [start.masses[0], start.masses[1], start.masses[2]];
        ensure!(masses.iter().all(|mass| *mass > 0.0), "masses must be positive in model = \"cluster\"");
        let mut cluster = Self {
            scene,
            pks,
            positions,
            masses,
            plain: 0.0,
            corrected: 0.0,
            errors: [0.0; 2],
            step: 0,
            collided: false,
        };
        cluster.plain = cluster.moment();
        cluster.corrected = cluster.plain;
        Ok(cluster)
    }

    fn away(&self, i: usize, j: usize) -> [f64; 2] {
        let (a, b) = (self.positions[i], self.positions[j]);
        [a[0] - b[0], a[1] - b[1]]
    }

    /// (2.23).
    fn moment(&self) -> f64 {
        let [m1, m2, _] = self.masses;
        m1 * m2 / (m1 + m2).powi(2) * square(self.away(0, 1))
    }

    /// Velocities: V = log r / (2 pi).
    fn drift(&self) -> [[f64; 2]; 3] {
        let mut drift = [[0.0; 2]; 3];
        for (i, drift) in drift.iter_mut().enumerate() {
            for j in (0..3).filter(|&j| j != i) {
                let d = self.away(i, j);
                let factor = -self.pks.chi * self.masses[j] / (2.0 * PI * square(d));
                drift[0] += factor * d[0];
                drift[1] += factor * d[1];
            }
        }
        drift
    }
}

fn square(x: [f64; 2]) -> f64 {
    x[0] * x[0] + x[1] * x[1]
}

impl Simulation for Cluster<'_> {
    fn columns(&self) -> Vec<String> {
        self.scene.columns()
    }

    fn step(&mut self) -> Result<()> {
        let Self { masses, pks, .. } = *self;
        let [m1, m2, m3] = masses;
        let pair = m1 + m2;
        let smallest = masses.iter().copied().fold(f64::INFINITY, f64::min);
        let mut generator = Philox::new(self.scene.seed);
        let (mut left, mut substep) = (self.scene.dt, 0_u32);
        while left > 0.0 && !self.collided {
            let distance = (0..3).map(|i| square(self.away(i, (i + 1) % 3))).fold(f64::INFINITY, f64::min).sqrt();
            let drift = self.drift();
            let speed = drift.iter().map(|v| square(*v)).fold(0.0, f64::max).sqrt();
            // mu is mu~ here: the system is not an approximation of a density.
            let by_noise = (JUMP * distance).powi(2) * smallest / (4.0 * pks.mu);
            let h = left.min(JUMP * distance / speed).min(by_noise);
            let mut z = [[0.0; 2]; 3];
            for (label, z) in z.iter_mut().enumerate() {
                let mut words = [0; 2];
                generator.fill(label as u64, self.step, substep, &mut words)?;
                normals(&words, z);
            }
            // dQ: (2.21) with the noise (2.22) of the particles themselves.
            let decay =
                4.0 * pks.mu / pair - pks.chi * pair / (2.0 * PI) * (1.0 - (m1 / pair).powi(2) - (m2 / pair).powi(2));
            let d = self.away(0, 1);
            let weight = |i: usize, other: f64, sign: f64| {
                sign * other * masses[i].sqrt() * (d[0] * z[i][0] + d[1] * z[i][1]) * h.sqrt()
            };
            let noise = 2.0 * (2.0 * pks.mu).sqrt() / pair.powi(2) * (weight(0, m2, 1.0) + weight(1, m1, -1.0));
            // (2.26) to (2.29) with V'' = -1 / (2 pi r^2), but with the other sign than printed: the relative motion of two
            // particles side by side of the third, (2.24) with the difference of its fractions, is compressed, not stretched.
            let centre = [0, 1].map(|axis| (m1 * self.positions[0][axis] + m2 * self.positions[1][axis]) / pair);
            let far = [centre[0] - self.positions[2][0], centre[1] - self.positions[2][1]];
            let cosine = (d[0] * far[0] + d[1] * far[1]) / (square(d) * square(far)).sqrt();
            let pull = pks.chi * m3 / (PI * square(far)) * (2.0 * cosine * cosine - 1.0);
            self.plain += decay * h + noise;
            self.corrected += (decay + pull * self.corrected) * h + noise;
            for i in 0..3 {
                let spread = (2.0 * pks.mu / masses[i] * h).sqrt();
                for axis in 0..2 {
                    self.positions[i][axis] += drift[i][axis] * h + spread * z[i][axis];
                }
            }
            let moment = self.moment();
            self.errors[0] = self.errors[0].max((self.plain - moment).abs());
            self.errors[1] = self.errors[1].max((self.corrected - moment).abs());
            left -= h;
            substep += 1;
            // Closer than a thousandth of a first distance, the sub-steps would shrink without end.
            self.collided = moment < 1e-8;
            ensure!(substep < 10_000_000, "more sub-steps than are sensible; make time.dt smaller");
        }
        self.step += 1;
        Ok(())
    }

    fn row(&mut self) -> Result<Vec<f64>> {
        let time = f64::from(self.step) * self.scene.dt;
        if self.collided {
            return Ok(vec![time, 0.0, f64::NAN, f64::NAN, self.errors[0], self.errors[1]]);
        }
        Ok(vec![time, self.moment(), self.plain, self.corrected, self.errors[0], self.errors[1]])
    }

    fn particles(&self) -> Particles {
        Particles {
            dimension: 2,
            positions: self.positions.as_flattened().to_vec(),
            masses: self.masses.to_vec(),
            densities: Vec::new(),
            parts: vec![0; 3],
        }
    }

    fn followed(&self) -> Vec<f64> {
        self.positions.as_flattened().to_vec()
    }

    fn plan(&self, _particles: usize) -> Result<Vec<String>> {
        Ok(vec![
            "drift: all pairs; adaptive Euler-Maruyama".to_owned(),
            "skipped: coalescence (the run stands still at the collision)".to_owned(),
        ])
    }

    fn save(&self, writer: &mut Writer) {
        writer.numbers(self.positions.as_flattened());
        writer.numbers(&[self.plain, self.corrected, self.errors[0], self.errors[1]]);
        writer.counts(&[u64::from(self.step), u64::from(self.collided)]);
    }

    fn restore(&mut self, reader: &mut Reader) -> Result<()> {
        let (positions, numbers, counts) = (reader.numbers()?, reader.numbers()?, reader.counts()?);
        let (&[a, b, c], &[plain, corrected, first, second], &[step, collided]) =
            (positions.as_chunks::<2>().0, numbers.as_slice(), counts.as_slice())
        else {
            anyhow::bail!("the checkpoint is of another scene")
        };
        self.positions = [a, b, c];
        (self.plain, self.corrected, self.errors) = (plain, corrected, [first, second]);
        (self.step, self.collided) = (step as u32, collided == 1);
        Ok(())
    }
}
