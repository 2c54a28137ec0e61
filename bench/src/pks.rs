//! `mollis-bench pks`: one sub-step of the Patlak-Keller-Segel particles (deposit, solve, gather, noise, move), and whole steps without
//! and with the search for clusters. NumPy and SciPy programs for the same are measured as well.

use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;
use mollis_core::exec::{Chunks, Executor, Resources, Run, Serial, par_chunks};
use mollis_core::grid::{Equation, Grid, MassScale, Mesh, Order};
use mollis_core::pks::{
    Attraction, Counters, Event, Events, Heavy, Merging, Options, Report as Made, Setting, State, step, theory,
    workspace_bytes,
};
use mollis_core::random::Philox;

use crate::field::{cpu_time, minimum, wall_time};
use crate::scene::aligned;

/// Number of particles that are gathered, given noise and moved together: their data fit into the L1 cache.
const TASK: usize = 1024;

/// Sizes and repetitions.
#[derive(Clone, Debug, Args)]
pub struct Pks {
    /// Number of particles. They have a normal distribution in the middle of the mesh.
    #[arg(long, default_value_t = 1_000_000)]
    n: usize,
    /// Cells along each axis.
    #[arg(long, default_value_t = 320)]
    grid: usize,
    /// The mesh's scheme of fourth order.
    #[arg(long)]
    fourth: bool,
    /// Threads; times are wall times with several threads, otherwise CPU times of the thread.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Sub-steps; the least time of each phase counts.
    #[arg(long, default_value_t = 20)]
    repetitions: usize,
    /// Number of heavy particles, each with a tenth of the mass. Whole steps sum their pairs beside the mesh.
    #[arg(long, default_value_t = 0)]
    heavy: usize,
    /// Also runs `peers/numpy_pks.py` with this interpreter (it needs NumPy and SciPy).
    #[arg(long)]
    python: Option<String>,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Debug, serde::Serialize)]
struct Report {
    n: usize,
    grid: usize,
    threads: usize,
    clock: &'static str,
    deposit_ns: f64,
    solve_ms: f64,
    gather_noise_move_ns: f64,
    step_ns: f64,
    checksum: String,
    /// Time of `pks::step` without the search. It also checks its arguments and keeps the old positions until the step has succeeded.
    whole_ns: f64,
    /// The same with the search.
    with_search_ns: f64,
    numpy: Option<Peer>,
}

/// Times of the NumPy program, and their ratios to those of mollis.
#[derive(Clone, Debug, serde::Serialize)]
struct Peer {
    step_ns: f64,
    step_ratio: f64,
    with_quadtree_ns: f64,
    with_quadtree_ratio: f64,
    with_kdtree_ns: f64,
    with_kdtree_ratio: f64,
}

impl Pks {
    fn equation(&self) -> Equation<f64> {
        let order = if self.fourth { Order::Fourth } else { Order::Second };
        Equation { order, ..Equation::POISSON }
    }

    /// Measures and prints.
    pub fn run(&self) -> Result<()> {
        let mut report = self.measure()?;
        if let Some(python) = &self.python {
            report.numpy = Some(self.peer(python, &report)?);
        }
        if self.json {
            println!("{}", serde_json::to_string(&report)?);
            return Ok(());
        }
        println!(
            "{} particles, {} x {} cells, {} thread(s), {} time: deposit {:.2} ns, solve {:.3} ms, gather + noise + move {:.2} ns, \
             together {:.2} ns a particle",
            report.n,
            report.grid,
            report.grid,
            report.threads,
            report.clock,
            report.deposit_ns,
            report.solve_ms,
            report.gather_noise_move_ns,
            report.step_ns
        );
        println!(
            "pks::step: {:.2} ns a particle without, {:.2} ns with the search for clusters",
            report.whole_ns, report.with_search_ns
        );
        if let Some(peer) = &report.numpy {
            println!(
                "NumPy and SciPy: {:.0} ns, {:.1} times as long; with the search by quadtree {:.0} ns, {:.1} times, by cKDTree {:.0} ns, {:.1} times",
                peer.step_ns,
                peer.step_ratio,
                peer.with_quadtree_ns,
                peer.with_quadtree_ratio,
                peer.with_kdtree_ns,
                peer.with_kdtree_ratio
            );
        }
        Ok(())
    }

    fn measure(&self) -> Result<Report> {
        if self.n == 0 {
            bail!("no particles");
        }
        let philox = Philox::new(1);
        let labels: Vec<u64> = (0..self.n as u64).collect();
        let mut positions = vec![[0.0_f64; 2]; self.n];
        philox.normals(&labels, 0, 0, &mut positions);
        for x in positions.iter_mut().flatten() {
            *x = (0.25 * *x).clamp(-1.4, 1.4);
        }
        let masses = vec![16.0 * std::f64::consts::PI / self.n as f64; self.n];
        let (chi, noise, dt) = (1.0, 0.02, 1e-6_f64);

        let pool = (self.threads > 1).then(|| mollis_host::pool::Pool::new(self.threads)).transpose()?;
        let executor: &dyn Executor = pool.as_ref().map_or(&Serial, |p| p);
        let mesh = Mesh::new([-1.5, -1.5], [1.5, 1.5], [self.grid; 2])?;
        let bytes = Grid::workspace_bytes(&mesh, &self.equation(), executor.workers())?;
        let mut memory = vec![0_u8; bytes + 64];
        let mut grid = Grid::prepare(aligned(&mut memory), mesh, self.equation(), executor.workers())?;
        // Masses change when particles merge, not within a sub-step.
        let scale = MassScale::of(&masses)?;
        let resources = Resources { executor, ..Resources::default() };
        let clock = if self.threads > 1 { wall_time } else { cpu_time };
        let mut seconds = [const { Vec::new() }; 4];
        for step in 1..=self.repetitions.max(1) as u32 {
            let times: [Duration; 4] = {
                let begin = clock();
                grid.begin(scale);
                grid.add(&positions, &masses, resources)?;
                let deposited = clock();
                grid.solve(resources)?;
                let solved = clock();
                let grid = &grid;
                let tasks = self.n.div_ceil(TASK);
                par_chunks(executor, tasks, Chunks::new(&mut positions, TASK), (), &|task, positions, ()| {
                    let (mut gradient, mut normals) = ([[0.0; 2]; TASK], [[0.0; 2]; TASK]);
                    grid.interpolate_here(positions, &mut gradient, resources.level);
                    philox.normals(&labels[task * TASK..][..positions.len()], step, 0, &mut normals);
                    let spread = noise * dt.sqrt();
                    for ((x, g), z) in positions.iter_mut().zip(&gradient).zip(&normals) {
                        *x = [x[0] - chi * dt * g[0] + spread * z[0], x[1] - chi * dt * g[1] + spread * z[1]];
                    }
                    Ok(())
                })?;
                let moved = clock();
                [deposited - begin, solved - deposited, moved - solved, moved - begin]
            };
            for (seconds, time) in seconds.iter_mut().zip(times) {
                seconds.push(time.as_secs_f64());
            }
        }
        let per_particle = |seconds: &[f64]| 1e9 * minimum(seconds) / self.n as f64;
        let checksum = positions.iter().flatten().fold(0_u64, |sum, x| sum.rotate_left(1) ^ x.to_bits());
        Ok(Report {
            n: self.n,
            grid: self.grid,
            threads: self.threads,
            clock: if self.threads > 1 { "wall" } else { "CPU" },
            deposit_ns: per_particle(&seconds[0]),
            solve_ms: 1e3 * minimum(&seconds[1]),
            gather_noise_move_ns: per_particle(&seconds[2]),
            step_ns: per_particle(&seconds[3]),
            checksum: format!("{checksum:016x}"),
            whole_ns: self.whole(Merging::Never, executor)?,
            with_search_ns: self.whole(Merging::All, executor)?,
            numpy: None,
        })
    }

    /// The least time of a whole step with mass 16 pi, chi = mu = 1 and one sub-step a particle.
    fn whole(&self, merging: Merging, executor: &dyn Executor) -> Result<f64> {
        let (n, mass) = (self.n, 16.0 * std::f64::consts::PI);
        let philox = Philox::new(1);
        let mut labels: Vec<u64> = (0..n as u64).collect();
        let mut positions = vec![[0.0_f64; 2]; n];
        philox.normals(&labels, 0, 0, &mut positions);
        for x in positions.iter_mut().flatten() {
            *x = (0.25 * *x).clamp(-1.4, 1.4);
        }
        let mut masses = vec![mass / n as f64; n];
        masses.iter_mut().take(self.heavy).for_each(|m| *m = 0.1 * mass);
        let mesh = Mesh::new([-1.5, -1.5], [1.5, 1.5], [self.grid; 2])?;
        let mut options = Options { merging, ..Options::new(1.0, theory::noise(mass, 1.0, n)) };
        options.search.domain = Some([mesh.lower(), mesh.upper()]);
        let workers = executor.workers();
        let mut grid_memory = vec![0; Grid::workspace_bytes(&mesh, &self.equation(), workers)? + 64];
        let mut grid = Grid::prepare(aligned(&mut grid_memory), mesh, self.equation(), workers)?;
        let mut memory = vec![0; workspace_bytes(n, None, &options, workers)? + 64];
        let memory = aligned(&mut memory);
        let kernel = Heavy::softening(&mesh)?;
        let heavy = Heavy { kernel: &kernel, mass: 0.1 * mass, core: kernel.delta() };
        let (mut events, mut absorbed) = (vec![Event::default(); n / 2 + 1], vec![0; n]);
        let mut counters = Counters { count: n as u64, ..Counters::default() };
        let mut made = Made::default();
        let clock = if self.threads > 1 { wall_time } else { cpu_time };
        let mut seconds = Vec::new();
        for _ in 0..self.repetitions.max(1) {
            let (mut written, mut labels_written) = (0, 0);
            let begin = clock();
            step(
                State {
                    positions: &mut positions,
                    masses: &mut masses,
                    labels: &mut labels,
                    species: None,
                    weights: None,
                },
                &mut counters,
                &mut Philox::new(1),
                1e-5,
                Events {
                    events: &mut events,
                    labels: &mut absorbed,
                    written: &mut written,
                    labels_written: &mut labels_written,
                },
                memory,
                Setting {
                    options: &options,
                    attraction: Attraction::Mesh(&mut grid, (self.heavy > 0).then_some(&heavy)),
                    run: &mut Run { executor, ..Run::default() },
                    report: Some(&mut made),
                },
            )?;
            seconds.push((clock() - begin).as_secs_f64());
        }
        Ok(1e9 * minimum(&seconds) / n as f64)
    }

    fn peer(&self, python: &str, report: &Report) -> Result<Peer> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/numpy_pks.py");
        let output = Command::new(python)
            .args([script, "--n", &self.n.to_string(), "--grid", &self.grid.to_string()])
            .env("OMP_NUM_THREADS", "1")
            .env("OPENBLAS_NUM_THREADS", "1")
            .output()
            .with_context(|| format!("running {python}"))?;
        if !output.status.success() {
            bail!("{script}: {}", String::from_utf8_lossy(&output.stderr));
        }
        let value: serde_json::Value = serde_json::from_slice(&output.stdout)?;
        let time = |name: &str| value[name].as_f64().with_context(|| format!("the peer's answer has no {name}"));
        let (step, quadtree, kdtree) =
            (time("nanoseconds_per_particle")?, time("with_quadtree")?, time("with_kdtree")?);
        Ok(Peer {
            step_ns: step,
            step_ratio: step / report.step_ns,
            with_quadtree_ns: quadtree,
            with_quadtree_ratio: quadtree / report.with_search_ns,
            with_kdtree_ns: kdtree,
            with_kdtree_ratio: kdtree / report.with_search_ns,
        })
    }
}
