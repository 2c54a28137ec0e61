//! The aggregation equation: blob method and particle method.

use std::f64::consts::PI;

use anyhow::{Context, Result, ensure};
use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::diagnostics;
use mollis_core::exec::Run;
use mollis_core::field::{self, Interaction, Options, Outputs, Sources};
use mollis_core::simd::Level;
use mollis_host::memory::Memory;
use mollis_host::pool::Pool;

use super::kernel;
use super::simulation::{Simulation, choose};
use super::stop::stopped;
use crate::checkpoint::{Reader, Writer};
use crate::particles::Particles;
use crate::scene::{Exact, Law, Model, Scene};

/// How the energy is computed.
enum Energy {
    /// From the kernel's potentials.
    Forces(field::Plan),
    /// By a run of no step, which adds the entropy of diffusion.
    WithEntropy(Box<aggregation::Plan>),
}

/// A run of the blob or the particle method.
pub struct Flow<'a, const D: usize> {
    scene: &'a Scene,
    pool: &'a Pool,
    kernel: &'a dyn Interaction<f64, D>,
    plan: aggregation::Plan,
    energy: Option<Energy>,
    memory: Memory,
    positions: Vec<[f64; D]>,
    density: Option<Vec<f64>>,
    /// Particles whose first density is the sum of the blobs there.
    summed: usize,
    start: Particles,
    followed: Vec<usize>,
    exact: Option<Exact>,
    /// h^d, or 1 for given points.
    cell: f64,
    /// The direction of the longest axis at the last row, for its angle to be continuous.
    axis: Option<f64>,
    delta: Option<f64>,
    /// Of the grid.
    h: Option<f64>,
    step: u64,
}

impl<'a, const D: usize> Flow<'a, D> {
    /// The scene at its start.
    pub fn new(
        scene: &'a Scene,
        start: Particles,
        h: Option<f64>,
        kernel: &'a dyn Interaction<f64, D>,
        pool: &'a Pool,
    ) -> Result<Self> {
        let n = start.len();
        let carried = scene.lacks_density().is_none();
        let (density, summed) = if carried { density::<D>(scene, &start, h, pool)? } else { (Vec::new(), 0) };
        let wanted = Wanted { density: carried, ..Wanted::default() };
        let plan = planned(scene, h, kernel, n, wanted)?;
        let energy = scene.output.energy.then(|| Energy::new(scene, h, kernel, n)).transpose()?;
        let workers = mollis_core::exec::Executor::workers(pool);
        let mut bytes = plan.workspace_bytes::<f64, D>(workers)?;
        if let Some(energy) = &energy {
            bytes = bytes.max(energy.workspace_bytes::<D>(workers)?);
        }
        Ok(Self {
            scene,
            pool,
            kernel,
            plan,
            energy,
            memory: Memory::new(bytes),
            positions: start.positions.as_chunks::<D>().0.to_vec(),
            density: carried.then_some(density),
            summed,
            followed: choose(n, scene.output.trajectories),
            exact: scene.exact(),
            start,
            cell: h.map_or(1.0, |h| h.powi(D as i32)),
            axis: None,
            delta: scene.mollifier.map(|softening| softening.delta(h)),
            h,
            step: 0,
        })
    }

    fn time(&self) -> f64 {
        self.step as f64 * self.scene.dt
    }

    fn energy(&mut self) -> Result<Option<f64>> {
        let plan = match &self.energy {
            None => return Ok(None),
            Some(Energy::WithEntropy(plan)) => {
                let mut positions = self.positions.clone();
                let particles = Trajectories { positions: &mut positions, ..Trajectories::none() };
                let state = State { masses: &self.start.masses, particles, tracers: Trajectories::none() };
                let (advance, mut report) =
                    (Advance { dt: self.scene.dt, steps: 0, after_step: None }, Report::default());
                let mut run = run(self.pool);
                aggregation::step(plan, self.kernel, state, advance, self.memory.slice(), &mut run, &mut report)?;
                return Ok(report.energy.map(|(energy, _)| energy));
            }
            Some(Energy::Forces(plan)) => plan,
        };
        let mut potential = vec![0.0; self.positions.len()];
        let sources = Sources::new(&self.positions, &self.start.masses);
        let outputs = Outputs { potential: Some(&mut potential), ..Outputs::default() };
        let mut run = run(self.pool);
        field::evaluate(plan, self.kernel, sources, &self.positions, outputs, self.memory.slice(), &mut run)?;
        Ok(Some(aggregation::energy_of(&self.start.masses, &potential)))
    }

    /// The centre of mass and the second moment about it over the whole mass. Where that is zero, the first moment and the second one about the origin over the
    /// sum of |m|, which vortices keep.
    fn moments(&self) -> Result<([f64; D], f64)> {
        let moments = diagnostics::moments(&self.positions, &self.start.masses)?;
        if moments.mass != 0.0 {
            return Ok((moments.centre, moments.second / moments.mass));
        }
        let mut first = [0.0; D];
        for (x, m) in self.positions.iter().zip(&self.start.masses) {
            first.iter_mut().zip(x).for_each(|(sum, x)| *sum += m * x / moments.absolute_mass);
        }
        Ok((first, moments.second / moments.absolute_mass))
    }

    /// The angle of the longest axis of the second moments about `centre`, in two dimensions, continued over rows that are less than a quarter turn apart.
    fn axis_angle(&mut self, centre: &[f64; D]) -> f64 {
        let (mut difference, mut mixed) = (0.0, 0.0);
        for (point, m) in self.positions.iter().zip(&self.start.masses) {
            let [x, y] = [0, 1].map(|k| point[k] - centre[k]);
            difference += m * (x * x - y * y);
            mixed += m * 2.0 * x * y;
        }
        let angle = 0.5 * mixed.atan2(difference);
        let turns = self.axis.map_or(0.0, |last| ((last - angle) / PI).round());
        *self.axis.insert(angle + turns * PI)
    }

    /// L1 errors of positions and of densities against the exact solution, while there is one.
    fn errors(&self) -> Result<[f64; 2]> {
        let Some(exact) = self.exact.as_ref().filter(|exact| self.time() < exact.blow_up()) else {
            return Ok([f64::NAN; 2]);
        };
        let mut positions = Vec::with_capacity(self.positions.len());
        let mut differences = Vec::new();
        for (index, start) in self.start.positions.as_chunks::<D>().0.iter().enumerate() {
            let mut point = [0.0; D];
            point.iter_mut().zip(exact.position(start, self.time())).for_each(|(to, from)| *to = from);
            positions.push(point);
            if let Some(density) = &self.density {
                differences.push(density[index] - exact.density(start, self.time()));
            }
        }
        let of_positions = diagnostics::distance(&self.positions, &positions, self.cell, 1.0)?;
        let of_density =
            if self.density.is_some() { diagnostics::norm(&differences, self.cell, 1.0)? } else { f64::NAN };
        Ok([of_positions, of_density])
    }
}

/// Densities at the start: as the data give them, elsewhere the sum of the blobs. Also the number of the latter.
fn density<const D: usize>(scene: &Scene, start: &Particles, h: Option<f64>, pool: &Pool) -> Result<(Vec<f64>, usize)> {
    let mut density = start.densities.clone();
    let missing: Vec<usize> = (0..density.len()).filter(|&index| density[index].is_nan()).collect();
    if !missing.is_empty() {
        ensure!(scene.model == Model::Blob, "without a mollifier there is no sum of blobs");
        let positions = start.positions.as_chunks::<D>().0;
        let targets: Vec<[f64; D]> = missing.iter().map(|&index| positions[index]).collect();
        let sources = Sources::new(positions, &start.masses);
        let sums = kernel::density(scene, h, sources, &targets, pool)?;
        missing.iter().zip(sums).for_each(|(&index, sum)| density[index] = sum);
    }
    Ok((density, missing.len()))
}

/// The plan of a run, with the scene's diffusion.
fn planned<const D: usize>(
    scene: &Scene,
    h: Option<f64>,
    kernel: &dyn Interaction<f64, D>,
    n: usize,
    wanted: Wanted,
) -> Result<aggregation::Plan> {
    let options = options(scene);
    let plan = aggregation::plan(kernel, n, 0, wanted, &options).context("plan")?;
    match kernel::diffusion(scene, h) {
        Some(diffusion) => plan.with_diffusion::<f64, D>(&diffusion, &options).context("diffusion"),
        None => Ok(plan),
    }
}

impl Energy {
    fn new<const D: usize>(scene: &Scene, h: Option<f64>, kernel: &dyn Interaction<f64, D>, n: usize) -> Result<Self> {
        if scene.diffusion.is_some() {
            let wanted = Wanted { energy: true, ..Wanted::default() };
            return Ok(Self::WithEntropy(Box::new(planned(scene, h, kernel, n, wanted)?)));
        }
        let outputs = field::Wanted { potential: true, ..field::Wanted::default() };
        Ok(Self::Forces(field::plan(kernel, n, n, outputs, &options(scene))?))
    }

    fn workspace_bytes<const D: usize>(&self, workers: usize) -> Result<usize> {
        Ok(match self {
            Self::Forces(plan) => plan.workspace_bytes(workers)?,
            Self::WithEntropy(plan) => plan.workspace_bytes::<f64, D>(workers)?,
        })
    }
}

fn options(scene: &Scene) -> Options {
    Options {
        combination: scene.combination.into(),
        tolerance: if scene.direct { 0.0 } else { scene.tolerance },
        method: scene.direct.then_some(field::Method::Direct),
        ..Options::default()
    }
}

fn run(pool: &Pool) -> Run<'_> {
    Run { level: Level::best(), executor: pool, should_stop: Some(&stopped), counters: None, communicator: None }
}

impl<const D: usize> Simulation for Flow<'_, D> {
    fn columns(&self) -> Vec<String> {
        self.scene.columns()
    }

    fn step(&mut self) -> Result<()> {
        let state = State {
            masses: &self.start.masses,
            particles: Trajectories {
                positions: &mut self.positions,
                density: self.density.as_deref_mut(),
                velocity: None,
                divergence: None,
            },
            tracers: Trajectories::none(),
        };
        let advance = Advance { dt: self.scene.dt, steps: 1, after_step: None };
        let mut report = Report::default();
        aggregation::step(
            &self.plan,
            self.kernel,
            state,
            advance,
            self.memory.slice(),
            &mut run(self.pool),
            &mut report,
        )?;
        self.step += 1;
        Ok(())
    }

    fn row(&mut self) -> Result<Vec<f64>> {
        let (centre, second) = self.moments()?;
        let mut row = vec![self.time()];
        row.extend(centre);
        row.push(second);
        if self.scene.turns() {
            row.push(self.axis_angle(&centre));
        }
        row.extend(self.energy()?);
        if let Some(density) = &self.density {
            row.push(density.iter().copied().fold(0.0, f64::max));
            // Without a mollifier nothing overlaps.
            let overlap = match self.delta {
                Some(delta) => diagnostics::smallest_overlap::<f64, D>(delta, &self.start.masses, density)?,
                None => None,
            };
            row.push(overlap.unwrap_or(f64::NAN));
        }
        if self.exact.is_some() {
            let [of_positions, of_density] = self.errors()?;
            row.push(of_positions);
            if self.density.is_some() {
                row.push(of_density);
            }
        }
        Ok(row)
    }

    fn particles(&self) -> Particles {
        let mut particles = self.start.clone();
        particles.positions = self.positions.as_flattened().to_vec();
        particles.densities = self.density.clone().unwrap_or_default();
        particles
    }

    fn followed(&self) -> Vec<f64> {
        self.followed.iter().flat_map(|&index| self.positions[index]).collect()
    }

    fn plan(&self, particles: usize) -> Result<Vec<String>> {
        let wanted = Wanted { density: self.density.is_some(), ..Wanted::default() };
        let plan = planned(self.scene, self.h, self.kernel, particles, wanted)?;
        let line =
            |what: &str, field: &field::Plan| format!("{what}: {:?} sum, because {:?}", field.method(), field.reason());
        let mut lines = vec![line("velocity", plan.field())];
        if let Some(field) = plan.diffusion_field() {
            lines.push(line("diffusion", field));
            if self.scene.kernel.iter().all(|term| term.law == Law::Newtonian && term.coefficient == 0.0) {
                lines.push("skipped: sums of the kernel, whose coefficient is 0".to_owned());
            }
        }
        let massless = self.start.masses.iter().filter(|mass| **mass == 0.0).count();
        if massless > 0 && particles == self.start.len() {
            lines.push(format!("skipped: {massless} sources without mass"));
        }
        if let Some(reason) = self.scene.lacks_density() {
            lines.push(format!("skipped: density along trajectories ({reason})"));
        }
        if self.summed > 0 {
            let all = if self.summed < self.start.len() { self.summed.to_string() } else { "all".to_owned() };
            lines.push(format!("density at the start: the sum of the blobs, at {all} particles"));
        }
        if self.energy.is_none() {
            lines.push("skipped: energy (output.energy is not set)".to_owned());
        }
        if self.exact.is_none() {
            lines.push("skipped: errors (no exact solution of this scene is known)".to_owned());
        }
        Ok(lines)
    }

    fn save(&self, writer: &mut Writer) {
        writer.count(self.step);
        writer.numbers(self.positions.as_flattened());
        writer.numbers(self.density.as_deref().unwrap_or(&[]));
        writer.numbers(self.axis.as_slice());
    }

    fn restore(&mut self, reader: &mut Reader) -> Result<()> {
        self.step = reader.count()?;
        let positions = reader.numbers()?;
        let density = reader.numbers()?;
        self.axis = reader.numbers()?.first().copied();
        let fits =
            positions.len() == self.positions.len() * D && density.len() == self.density.as_ref().map_or(0, Vec::len);
        anyhow::ensure!(fits, "the checkpoint is of another scene");
        self.positions = positions.as_chunks::<D>().0.to_vec();
        self.density = self.density.is_some().then_some(density);
        Ok(())
    }
}
