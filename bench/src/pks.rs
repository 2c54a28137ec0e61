//! `mollis-bench pks`: one sub-step of the Patlak-Keller-Segel particles (deposit, solve, gather, noise, move) and the same in
//! NumPy and SciPy.

use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;
use mollis_core::grid::{Equation, Grid, MassScale, Mesh};
use mollis_core::parallel::{Executor, Serial};
use mollis_core::random::Philox;
use mollis_core::space::{Chunks, each_piece};

use crate::field::{cpu_time, minimum, wall_time};

/// Particles that are gathered, given noise and moved together: their numbers stay in the nearest cache.
const TASK: usize = 1024;

/// How large, how often.
#[derive(Clone, Debug, Args)]
pub struct Pks {
    /// Particles, a normal bump in the middle of the mesh.
    #[arg(long, default_value_t = 1_000_000)]
    n: usize,
    /// Cells along each axis.
    #[arg(long, default_value_t = 320)]
    grid: usize,
    /// Threads; times are then wall times, else CPU times of the thread.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Sub-steps; each phase's least time counts.
    #[arg(long, default_value_t = 20)]
    repetitions: usize,
    /// Runs `peers/numpy_pks.py` with this interpreter too (it needs NumPy and SciPy).
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
    numpy_step_ns: Option<f64>,
    numpy_over_mollis: Option<f64>,
}

impl Pks {
    /// Measures and prints.
    pub fn run(&self) -> Result<()> {
        let mut report = self.measure()?;
        if let Some(python) = &self.python {
            let ns = self.peer(python)?;
            report.numpy_step_ns = Some(ns);
            report.numpy_over_mollis = Some(ns / report.step_ns);
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
        if let (Some(ns), Some(ratio)) = (report.numpy_step_ns, report.numpy_over_mollis) {
            println!("NumPy and SciPy: {ns:.1} ns a particle, {ratio:.1} times as long");
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

        let pool = (self.threads > 1).then(|| mollis_mt::Pool::new(self.threads)).transpose()?;
        let executor: &dyn Executor = pool.as_ref().map_or(&Serial, |p| p);
        let mesh = Mesh::new([-1.5, -1.5], [1.5, 1.5], [self.grid; 2])?;
        let bytes = Grid::workspace_bytes(&mesh, &Equation::POISSON, executor.workers())?;
        let mut memory = vec![0_u8; bytes + 64];
        let start = memory.as_ptr().align_offset(64);
        let mut grid = Grid::prepare(&mut memory[start..start + bytes], mesh, Equation::POISSON, executor.workers())?;
        // Masses change when particles merge, not in a sub-step.
        let scale = MassScale::of(&masses)?;
        let clock = if self.threads > 1 { wall_time } else { cpu_time };
        let mut seconds = [const { Vec::new() }; 4];
        for step in 1..=self.repetitions.max(1) as u32 {
            let times: [Duration; 4] = {
                let begin = clock();
                grid.begin(scale);
                grid.add(&positions, &masses, executor)?;
                let deposited = clock();
                grid.solve(executor)?;
                let solved = clock();
                let grid = &grid;
                let tasks = self.n.div_ceil(TASK);
                each_piece(executor, tasks, &Chunks::new(&mut positions, TASK), &(), &|task, positions, ()| {
                    let (mut gradient, mut normals) = ([[0.0; 2]; TASK], [[0.0; 2]; TASK]);
                    grid.interpolate_here(positions, &mut gradient);
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
            numpy_step_ns: None,
            numpy_over_mollis: None,
        })
    }

    fn peer(&self, python: &str) -> Result<f64> {
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
        value["nanoseconds_per_particle"].as_f64().context("the peer's answer has no time")
    }
}
