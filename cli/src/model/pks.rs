//! Coalescing Patlak-Keller-Segel particles.

use anyhow::{Context, Result, bail, ensure};
use mollis_core::Error;
use mollis_core::exec::{Executor, Run};
use mollis_core::grid::{Equation, Grid, Mesh, Order, Walls};
use mollis_core::mollifier::Blob;
use mollis_core::pks::{
    self, Attraction, CollisionLaw, Counters, Events, Heavy, Merging, Options, Report, Setting, State, theory,
};
use mollis_core::random::Philox;
use mollis_core::simd::Level;
use mollis_host::memory::Memory;
use mollis_host::pool::Pool;

use super::simulation::{Simulation, choose};
use super::stop::stopped;
use crate::checkpoint::{Reader, Writer};
use crate::history::Event;
use crate::initial::diffusion;
use crate::particles::Particles;
use crate::scene::Scene;

/// Event capacity of one call; a step with more is continued by further calls.
const ROOM: usize = 4096;

/// A run.
pub struct Coalescing<'a> {
    scene: &'a Scene,
    pool: &'a Pool,
    options: Options<f64>,
    mesh: Mesh<f64>,
    equation: Equation<f64>,
    grid: Memory,
    workspace: Memory,
    positions: Vec<[f64; 2]>,
    masses: Vec<f64>,
    /// If parts have sensitivities.
    weights: Option<Vec<f64>>,
    labels: Vec<u64>,
    counters: Counters,
    report: Report,
    /// The part of the initial data that each label began in.
    parts: Vec<u8>,
    /// The kernel of particles that act pair by pair, and their least mass.
    heavy: Option<(Blob<f64, 2>, f64)>,
    /// With several parts, how much mass of each a label holds now.
    held: Vec<f64>,
    part_masses: Vec<f64>,
    /// The followed labels, and the labels that they ended in.
    followed: Vec<u64>,
    critical: f64,
    recent: Vec<Event>,
    /// The largest number of particles outside the mesh at the beginning of a step, and the step.
    outside: [u64; 2],
}

/// The mesh of a scene.
pub fn mesh(scene: &Scene) -> Result<Mesh<f64>> {
    let pks = scene.pks.context("pks")?;
    Mesh::new([pks.x[0], pks.y[0]], [pks.x[1], pks.y[1]], pks.mesh).context("pks.mesh")
}

impl<'a> Coalescing<'a> {
    /// The scene at its start.
    pub fn new(scene: &'a Scene, start: Particles, pool: &'a Pool) -> Result<Self> {
        let pks = scene.pks.context("pks")?;
        let n = start.len();
        if let Some(index) = start.masses.iter().position(|mass| *mass <= 0.0) {
            let (mass, part) = (start.masses[index], start.parts[index]);
            bail!("initial[{part}]: particle {index} has mass {mass}: must be above 0 with coalescing particles");
        }
        let noise = diffusion(scene, &start.masses);
        let mesh = mesh(scene)?;
        let mut options = Options::new(pks.chi, noise);
        options.law = if pks.printed { CollisionLaw::Printed } else { CollisionLaw::Exact };
        options.merging = if pks.hard { Merging::Hard } else { Merging::All };
        options.probability = pks.probability;
        options.search.separation = pks.separation;
        options.search.domain = Some([mesh.lower(), mesh.upper()]);
        let count = |[low, high]: [f64; 2]| ((high - low) / pks.cell).round().max(1.0) as usize;
        options.search.mesh = [count(pks.x), count(pks.y)].map(|n| n.try_into().unwrap_or(1));
        let workers = pool.workers();
        let walls = if pks.quadrupole { Walls::FreeQuadrupole } else { Walls::Free };
        let order = if pks.fourth { Order::Fourth } else { Order::Second };
        let equation = Equation { screening: 0.0, walls, order };
        let grid = Memory::new(Grid::workspace_bytes(&mesh, &equation, workers)?);
        let workspace = Memory::new(pks::workspace_bytes(n, None, &options, workers)?);
        let whole: f64 = start.masses.iter().sum();
        // mu~ = mu M / N, so mu also where several species make one.
        let critical = theory::critical_mass(noise * n as f64 / whole, pks.chi);
        let heavy = match pks.heavy {
            // Without attraction there is nothing to sum.
            Some(mass) if pks.chi > 0.0 => {
                ensure!(pks.mu > 0.0, "pks.heavy is in critical masses, which are zero for pks.mu = 0");
                Some((Heavy::softening(&mesh)?, mass * critical))
            }
            _ => None,
        };
        let kinds = scene.initial.len();
        let of = |part: &u8| scene.initial[*part as usize].sensitivity;
        let weights = scene.initial.iter().any(|part| part.sensitivity.is_some()).then(|| {
            let particles = start.masses.iter().zip(&start.parts);
            particles.map(|(mass, part)| mass / of(part).unwrap_or(1.0)).collect()
        });
        let mut part_masses = vec![0.0; kinds];
        let mut held = vec![0.0; if kinds > 1 { n * kinds } else { 0 }];
        for (label, (&part, &mass)) in start.parts.iter().zip(&start.masses).enumerate() {
            part_masses[part as usize] += mass;
            if kinds > 1 {
                held[label * kinds + part as usize] = mass;
            }
        }
        Ok(Self {
            scene,
            pool,
            options,
            mesh,
            equation,
            grid,
            workspace,
            positions: start.positions.as_chunks::<2>().0.to_vec(),
            masses: start.masses,
            weights,
            labels: (0..n as u64).collect(),
            counters: Counters { count: n as u64, ..Counters::default() },
            report: Report::default(),
            parts: start.parts,
            held,
            part_masses,
            followed: choose(n, scene.output.trajectories).into_iter().map(|index| index as u64).collect(),
            critical,
            heavy,
            recent: Vec::new(),
            outside: [0; 2],
        })
    }

    fn count(&self) -> usize {
        self.counters.count as usize
    }

    fn alive(&self) -> impl Iterator<Item = (&[f64; 2], &f64, &u64)> {
        let all = self.positions.iter().zip(self.masses.iter().zip(&self.labels));
        all.take(self.count()).map(|(x, (mass, label))| (x, mass, label))
    }

    fn keep(&mut self, event: Event) {
        let kinds = self.part_masses.len();
        if kinds > 1 {
            for &label in &event.absorbed {
                for part in 0..kinds {
                    self.held[event.label as usize * kinds + part] += self.held[label as usize * kinds + part];
                }
            }
        }
        for label in &mut self.followed {
            if event.absorbed.contains(label) {
                *label = event.label;
            }
        }
        self.recent.push(event);
    }
}

impl Simulation for Coalescing<'_> {
    fn columns(&self) -> Vec<String> {
        self.scene.columns()
    }

    fn step(&mut self) -> Result<()> {
        let mut grid = Grid::prepare(self.grid.slice(), self.mesh, self.equation, self.pool.workers())?;
        let mut run = Run {
            level: Level::best(),
            executor: self.pool,
            should_stop: Some(&stopped),
            counters: None,
            communicator: None,
        };
        let mut events = vec![pks::Event::default(); ROOM];
        let mut absorbed = vec![0; self.positions.len()];
        let mut generator = Philox::new(self.scene.seed);
        let heavy = self.heavy.as_ref().map(|(kernel, mass)| Heavy { kernel, mass: *mass, core: kernel.delta() });
        let mut list = Vec::new();
        loop {
            let (mut written, mut labels_written) = (0, 0);
            let done = pks::step(
                State {
                    positions: &mut self.positions,
                    masses: &mut self.masses,
                    labels: &mut self.labels,
                    species: None,
                    weights: self.weights.as_deref_mut(),
                },
                &mut self.counters,
                &mut generator,
                self.scene.dt,
                Events {
                    events: &mut events,
                    labels: &mut absorbed,
                    written: &mut written,
                    labels_written: &mut labels_written,
                },
                self.workspace.slice(),
                Setting {
                    options: &self.options,
                    attraction: Attraction::Mesh(&mut grid, heavy.as_ref()),
                    run: &mut run,
                    report: Some(&mut self.report),
                },
            );
            for event in &events[..written] {
                let from = event.first as usize;
                list.push(Event {
                    time: event.time,
                    label: event.label,
                    absorbed: absorbed[from..from + event.absorbed as usize].to_vec(),
                    mass: event.mass,
                    index: event.index,
                });
            }
            match done {
                Err(Error::EventsFull) => {}
                Err(error) => return Err(error.into()),
                Ok(()) => break,
            }
        }
        // Without attraction no field is solved, and nothing is outside of it.
        let outside = if self.options.chi > 0.0 { grid.outside() } else { 0 };
        if outside > self.outside[0] {
            self.outside = [outside, self.counters.step - 1];
        }
        list.into_iter().for_each(|event| self.keep(event));
        Ok(())
    }

    fn row(&mut self) -> Result<Vec<f64>> {
        let n = self.count();
        let weights = self.weights.as_ref().unwrap_or(&self.masses);
        let moments = mollis_core::diagnostics::moments(&self.positions[..n], &weights[..n])?;
        let mass: f64 = self.masses[..n].iter().sum();
        let mut heaviest = [0.0_f64; 2];
        for (_, &mass, _) in self.alive() {
            if mass > heaviest[0] {
                heaviest = [mass, heaviest[0]];
            } else if mass > heaviest[1] {
                heaviest[1] = mass;
            }
        }
        let [x, y] = moments.centre;
        let mut row = vec![self.scene.dt * self.counters.step as f64, n as f64, x, y, moments.second / moments.mass];
        row.extend([heaviest[0] / self.critical, (heaviest[0] + heaviest[1]) / mass]);
        let kinds = self.part_masses.len();
        if kinds > 1 {
            let mut sums = vec![0.0; kinds];
            for (position, _, &label) in self.alive() {
                let square = (position[0] - x).powi(2) + (position[1] - y).powi(2);
                let held = &self.held[label as usize * kinds..(label as usize + 1) * kinds];
                sums.iter_mut().zip(held).for_each(|(sum, mass)| *sum += mass * square);
            }
            row.extend(sums.iter().zip(&self.part_masses).map(|(sum, mass)| sum / mass));
        }
        Ok(row)
    }

    fn particles(&self) -> Particles {
        let n = self.count();
        Particles {
            dimension: 2,
            positions: self.positions[..n].as_flattened().to_vec(),
            masses: self.masses[..n].to_vec(),
            densities: Vec::new(),
            parts: self.labels[..n].iter().map(|&label| self.parts[label as usize]).collect(),
        }
    }

    fn followed(&self) -> Vec<f64> {
        let labels = &self.labels[..self.count()];
        let place = |label: &u64| labels.binary_search(label).map_or([f64::NAN; 2], |index| self.positions[index]);
        self.followed.iter().flat_map(place).collect()
    }

    fn events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.recent)
    }

    fn plan(&self, _particles: usize) -> Result<Vec<String>> {
        let [nx, ny] = self.mesh.cells();
        let mut lines = vec![format!(
            "drift: deposit, Poisson solve on {nx} x {ny} cells and interpolation, once a step; {:?} collision law",
            self.options.law
        )];
        if self.options.chi == 0.0 {
            lines.push("skipped: field and cluster search (chi = 0)".to_owned());
        }
        if self.options.noise == 0.0 {
            lines.push("skipped: random numbers (mu = 0)".to_owned());
        }
        lines.push("skipped: density along trajectories, energy (not of this model)".to_owned());
        Ok(lines)
    }

    fn notes(&self) -> Vec<String> {
        let [most, step] = self.outside;
        if most == 0 {
            return Vec::new();
        }
        let at = self.scene.dt * step as f64;
        let left = self.alive().filter(|(x, ..)| !self.mesh.contains(**x)).count();
        vec![format!(
            "outside the mesh, where the field is that of all mass at its centre: {most} particles at most (at time {at}), {left} at the end"
        )]
    }

    fn save(&self, writer: &mut Writer) {
        let n = self.count();
        writer.counts(&[self.counters.step, self.counters.count, self.counters.pending]);
        writer.number(self.counters.time);
        writer.numbers(self.positions[..n].as_flattened());
        writer.numbers(&self.masses[..n]);
        if let Some(weights) = &self.weights {
            writer.numbers(&weights[..n]);
        }
        writer.counts(&self.labels[..n]);
        writer.numbers(&self.held);
        writer.counts(&self.followed);
        writer.counts(&self.outside);
    }

    fn restore(&mut self, reader: &mut Reader) -> Result<()> {
        let counters = reader.counts()?;
        let [step, count, pending] = counters[..] else { bail!("the checkpoint is of another scene") };
        self.counters = Counters { time: reader.number()?, step, count, pending };
        let (positions, masses) = (reader.numbers()?, reader.numbers()?);
        let weights = self.weights.as_ref().map(|_| reader.numbers()).transpose()?;
        let labels = reader.counts()?;
        let n = count as usize;
        ensure!(
            n <= self.masses.len()
                && positions.len() == 2 * n
                && masses.len() == n
                && labels.len() == n
                && weights.as_ref().is_none_or(|weights| weights.len() == n),
            "the checkpoint is of another scene"
        );
        self.positions[..n].copy_from_slice(positions.as_chunks::<2>().0);
        self.masses[..n].copy_from_slice(&masses);
        if let (Some(to), Some(weights)) = (&mut self.weights, &weights) {
            to[..n].copy_from_slice(weights);
        }
        self.labels[..n].copy_from_slice(&labels);
        let (held, followed, outside) = (reader.numbers()?, reader.counts()?, reader.counts()?);
        ensure!(
            held.len() == self.held.len() && followed.len() == self.followed.len() && outside.len() == 2,
            "the checkpoint is of another scene"
        );
        (self.held, self.followed, self.outside) = (held, followed, [outside[0], outside[1]]);
        Ok(())
    }
}
