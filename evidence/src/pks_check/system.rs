//! A run: particles, grid and workspace in one place.

use mollis_core::exec::{Executor, Resources};
use mollis_core::grid::{Equation, Grid, Mesh};
use mollis_core::mollifier::Blob;
use mollis_core::pks::theory::{Constants, Group};
use mollis_core::pks::{self, Attraction, Counters, Event, Events, Heavy, Options, Report, Setting, State};
use mollis_core::random::{Generator, Philox};
use mollis_core::{Error, Result};
use mollis_host::memory::Memory;

/// Runs tasks on scoped threads.
pub struct Threads(pub usize);

impl Executor for Threads {
    fn workers(&self) -> usize {
        self.0
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        let next = std::sync::atomic::AtomicUsize::new(0);
        let work = |worker| {
            while next.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < tasks {
                task(worker);
            }
        };
        std::thread::scope(|scope| {
            for worker in 1..self.0.min(tasks) {
                let work = &work;
                // A thread that can't be started leaves its tasks to the others.
                if std::thread::Builder::new().spawn_scoped(scope, move || work(worker)).is_err() {
                    break;
                }
            }
            work(0);
        });
        Ok(())
    }
}

/// Particles on a bump `exp(1 / (|x|^2 - 1))` stretched to an ellipse.
#[derive(Clone, Copy)]
pub struct Bump {
    pub centre: [f64; 2],
    pub axes: [f64; 2],
    pub mass: f64,
    pub count: usize,
}

/// All that a run owns.
pub struct System {
    pub positions: Vec<[f64; 2]>,
    pub masses: Vec<f64>,
    pub labels: Vec<u64>,
    pub species: Vec<u32>,
    pub counters: Counters,
    pub options: Options<f64>,
    pub report: Report,
    /// Events since the start, and the labels they absorbed.
    pub log: Vec<(Event, Vec<u64>)>,
    mesh: Option<(Mesh<f64>, Equation<f64>, Memory)>,
    /// The kernel of heavy particles and their least mass.
    pub heavy: Option<(Blob<f64, 2>, f64)>,
    workspace: Memory,
    threads: usize,
}

impl System {
    pub fn new(
        bumps: &[Bump],
        mesh: Option<(Mesh<f64>, Equation<f64>)>,
        options: Options<f64>,
        seed: u64,
        threads: usize,
    ) -> Result<Self> {
        let mut random = Split(seed);
        let (mut positions, mut masses, mut species) = (Vec::new(), Vec::new(), Vec::new());
        for (k, bump) in bumps.iter().enumerate() {
            for _ in 0..bump.count {
                let x = random.bump();
                positions.push([bump.centre[0] + bump.axes[0] * x[0], bump.centre[1] + bump.axes[1] * x[1]]);
                masses.push(bump.mass / bump.count as f64);
                species.push(k as u32);
            }
        }
        let n = positions.len();
        let mut options = options;
        let mesh = match mesh {
            Some((mesh, equation)) => {
                options.search.domain = Some([mesh.lower(), mesh.upper()]);
                Some((mesh, equation, Memory::new(Grid::workspace_bytes(&mesh, &equation, threads)?)))
            }
            None => None,
        };
        let workspace = Memory::new(pks::workspace_bytes(n, None, &options, threads)?);
        let counters = Counters { count: n as u64, ..Counters::default() };
        let labels = (0..n as u64).collect();
        let report = Report::default();
        Ok(Self {
            positions,
            masses,
            labels,
            species,
            counters,
            options,
            report,
            log: Vec::new(),
            mesh,
            heavy: None,
            workspace,
            threads,
        })
    }

    /// From now on particles of at least this mass act pair by pair, softened over a quarter of a mesh width.
    pub fn sum_heavy(&mut self, mass: f64) -> Result<()> {
        let Some((mesh, ..)) = &self.mesh else { return Err(Error::Unsupported) };
        self.heavy = Some((Heavy::softening(mesh)?, mass));
        Ok(())
    }

    /// One step; events are appended to the log.
    pub fn step(&mut self, generator: &mut dyn Generator, dt: f64) -> Result<()> {
        let executor = Threads(self.threads);
        let mut run = mollis_core::exec::Run { executor: &executor, ..Default::default() };
        let mut grid = match &mut self.mesh {
            Some((mesh, equation, memory)) => Some(Grid::prepare(memory.slice(), *mesh, *equation, self.threads)?),
            None => None,
        };
        let heavy = self.heavy.as_ref().map(|(kernel, mass)| Heavy { kernel, mass: *mass, core: kernel.delta() });
        let mut events = vec![Event::default(); 4096];
        let mut labels = vec![0; self.positions.len()];
        loop {
            let (mut written, mut labels_written) = (0, 0);
            let attraction = match &mut grid {
                Some(grid) => Attraction::Mesh(grid, heavy.as_ref()),
                None => Attraction::None,
            };
            let done = pks::step(
                State {
                    positions: &mut self.positions,
                    masses: &mut self.masses,
                    labels: &mut self.labels,
                    species: Some(&mut self.species),
                    weights: None,
                },
                &mut self.counters,
                generator,
                dt,
                Events {
                    events: &mut events,
                    labels: &mut labels,
                    written: &mut written,
                    labels_written: &mut labels_written,
                },
                self.workspace.slice(),
                Setting { options: &self.options, attraction, run: &mut run, report: Some(&mut self.report) },
            );
            for event in &events[..written] {
                let from = event.first as usize;
                self.log.push((*event, labels[from..from + event.absorbed as usize].to_vec()));
            }
            match done {
                Err(Error::EventsFull) => {}
                other => return other,
            }
        }
    }

    pub fn count(&self) -> usize {
        self.counters.count as usize
    }

    /// Centre of mass and mass of the particles that `keep` holds of.
    pub fn centre(&self, keep: impl Fn(usize) -> bool) -> ([f64; 2], f64) {
        let mut sum = [0.0; 3];
        for i in (0..self.count()).filter(|&i| keep(i)) {
            sum[0] += self.masses[i] * self.positions[i][0];
            sum[1] += self.masses[i] * self.positions[i][1];
            sum[2] += self.masses[i];
        }
        ([sum[0] / sum[2], sum[1] / sum[2]], sum[2])
    }

    /// sum m |x - c|^2 of the particles that `keep` holds of, not divided by the mass.
    pub fn spread(&self, c: [f64; 2], keep: impl Fn(usize) -> bool) -> f64 {
        let square = |x: [f64; 2]| (x[0] - c[0]).powi(2) + (x[1] - c[1]).powi(2);
        (0..self.count()).filter(|&i| keep(i)).map(|i| self.masses[i] * square(self.positions[i])).sum()
    }

    /// The second moment about the centre of mass, divided by the mass.
    pub fn second_moment(&self) -> f64 {
        let (centre, mass) = self.centre(|_| true);
        self.spread(centre, |_| true) / mass
    }

    /// alpha of (2.4): the drift of the second moment of the particles that there are.
    pub fn alpha(&self) -> f64 {
        let Options { chi, noise, gamma, .. } = self.options;
        Constants { chi, noise, gamma }.alpha(&Group::of(&self.masses[..self.count()]))
    }

    /// What the mesh's field contributes to the rate of sum m |x|^2: `-2 chi sum m x . grad u`. No chance is in it but the positions'.
    pub fn pull(&mut self) -> Result<f64> {
        let n = self.count();
        let Some((mesh, equation, memory)) = &mut self.mesh else { return Ok(0.0) };
        let mut grid = Grid::prepare(memory.slice(), *mesh, *equation, 1)?;
        let (positions, masses) = (&self.positions[..n], &self.masses[..n]);
        let mut gradient = vec![[0.0; 2]; n];
        grid.deposit(positions, masses, Resources::default())?;
        grid.solve(Resources::default())?;
        grid.interpolate(positions, &mut gradient, Resources::default())?;
        let inner = |x: &[f64; 2], g: &[f64; 2]| x[0] * g[0] + x[1] * g[1];
        let sum: f64 = positions.iter().zip(&gradient).zip(masses).map(|((x, g), m)| m * inner(x, g)).sum();
        Ok(-2.0 * self.options.chi * sum)
    }

    pub fn heaviest(&self) -> f64 {
        self.masses[..self.count()].iter().copied().fold(0.0, f64::max)
    }
}

/// The same words with the directions of Box & Muller's normals turned round: every normal is the opposite.
pub struct Opposite(pub Philox);

impl Generator for Opposite {
    fn fill(&mut self, label: u64, step: u32, substep: u32, out: &mut [u64]) -> Result<()> {
        self.0.fill(label, step, substep, out)?;
        out.iter_mut().skip(1).step_by(2).for_each(|word| *word ^= 1 << 63);
        Ok(())
    }
}

/// SplitMix64, for initial conditions.
pub struct Split(pub u64);

impl Split {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point of the unit disc with density proportional to exp(1 / (|x|^2 - 1)), by rejection.
    fn bump(&mut self) -> [f64; 2] {
        loop {
            let x = [2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0];
            let square = x[0] * x[0] + x[1] * x[1];
            if square < 1.0 && self.uniform() < (1.0 + 1.0 / (square - 1.0)).exp() {
                return x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mollis_core::random::normals_of_labels;

    #[test]
    fn opposite_noise_is_the_opposite() {
        let labels: Vec<u64> = (0..100).collect();
        let (mut one, mut two) = (vec![[0.0; 2]; 100], vec![[0.0; 2]; 100]);
        normals_of_labels(&mut Philox::new(3), &labels, 4, 5, &mut one).unwrap();
        normals_of_labels(&mut Opposite(Philox::new(3)), &labels, 4, 5, &mut two).unwrap();
        for (a, b) in one.as_flattened().iter().zip(two.as_flattened()) {
            let error: f64 = a + b;
            assert!(error.abs() < 1e-14, "{a} {b}");
        }
    }
}
