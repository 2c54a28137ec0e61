//! `mollis-bench fmm2d`: the fast multipole method beside FMM2D (Flatiron Institute), a library that the user has built, at equal errors in the same run.
//!
//! Both sum the potentials and gradients of the same points at the points themselves. The error is that of the gradients in the l2 norm, relative to the gradients, over a sample of
//! targets whose sums are computed pair by pair in double words.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use mollis_core::exec::Run;
use mollis_core::field::{self, Method, Options, Plan, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_core::real::DoubleWord;

use crate::field::{Results, cpu_time, minimum};
use crate::scene::{Scene, aligned};

/// FMM2D's sum over sources at the sources: eps, n, positions, charges, potentials, gradients, status.
type Sum = unsafe extern "C" fn(*const f64, *const i32, *const f64, *const f64, *mut f64, *mut f64, *mut i32);

/// What FMM2D is asked for; its errors are smaller.
const PEER: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// The fast multipole method beside FMM2D.
#[derive(Clone, Debug, Args)]
pub struct Fmm2d {
    /// libfmm2d.so, built for one thread (`make lib OMP=OFF`); without it mollis alone is measured.
    #[arg(long)]
    library: Option<PathBuf>,
    /// Points, uniform in the unit square, masses of both signs.
    #[arg(long, default_value_t = 100_000)]
    n: usize,
    /// Repetitions, of which the fastest counts.
    #[arg(long, default_value_t = 5)]
    repetitions: usize,
    /// Computes the potential besides the gradient (FMM2D always does).
    #[arg(long)]
    potential: bool,
    /// Targets of which the error is measured.
    #[arg(long, default_value_t = 200)]
    sample: usize,
}

/// A setting, microseconds a point and the error.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The tolerance.
    pub setting: f64,
    /// Microseconds of CPU time a point.
    pub micros: f64,
    /// See [`error`].
    pub error: f64,
}

impl Fmm2d {
    /// Measures and prints.
    pub fn run(&self) -> Result<()> {
        let scene = Scene::<2>::uniform(self.n, None, 1);
        let exact = self.exact(&scene);
        let ours = (6..=52).map(|quarter| self.mollis(&scene, &exact, 10_f64.powf(-0.25 * f64::from(quarter))));
        let ours = ours.collect::<Result<Vec<Row>>>()?;
        println!("mollis: tolerance, us a point, error");
        for row in ours.iter().step_by(2) {
            println!("  {:8.1e} {:8.4} {:8.1e}", row.setting, row.micros, row.error);
        }
        println!("at errors: us a point");
        for error in PEER {
            let row = fastest(&ours, error).context("no tolerance has this error")?;
            println!("  {error:8.1e} {:8.4} (tolerance {:.1e})", row.micros, row.setting);
        }
        let Some(path) = &self.library else { return Ok(()) };
        println!("FMM2D: eps, us a point, error; mollis at no larger an error; ratio");
        for row in self.peers(path, &scene, &exact)? {
            let best = fastest(&ours, row.error).or(ours.last().copied()).context("rows")?;
            println!(
                "  {:8.1e} {:8.4} {:8.1e}   {:8.4} {:8.1e}   {:.1}",
                row.setting,
                row.micros,
                row.error,
                best.micros,
                best.error,
                row.micros / best.micros
            );
        }
        Ok(())
    }

    /// The measurement of so many points.
    pub fn of(n: usize) -> Self {
        Self { library: None, n, repetitions: 3, potential: false, sample: 200 }
    }

    /// FMM2D's times and errors.
    pub fn peers(&self, path: &Path, scene: &Scene<2>, exact: &[(usize, [f64; 2])]) -> Result<Vec<Row>> {
        // SAFETY: the user names the library, which has no code that runs when it is loaded.
        #[expect(unsafe_code, reason = "a library by path")]
        let library = unsafe { libloading::Library::new(path)? };
        // SAFETY: FMM2D's documentation has this signature.
        #[expect(unsafe_code, reason = "a function of a library")]
        let sum = unsafe { library.get::<Sum>(b"rfmm2d_s_c_g_\0")? };
        PEER.into_iter().map(|eps| self.peer(scene, exact, *sum, eps)).collect()
    }

    /// The targets of the sample and their gradients.
    pub fn exact(&self, scene: &Scene<2>) -> Vec<(usize, [f64; 2])> {
        let step = self.n.div_ceil(self.sample.max(1)).max(1);
        let gradient = |i: usize| {
            let mut sums = [DoubleWord::<f64>::ZERO; 2];
            for (x, &m) in scene.positions.iter().zip(&scene.masses) {
                let d = [scene.positions[i][0] - x[0], scene.positions[i][1] - x[1]];
                let square = d[0] * d[0] + d[1] * d[1];
                if square > 0.0 {
                    sums.iter_mut()
                        .zip(d)
                        .for_each(|(sum, d)| *sum = sum.plus(m * d / (square * std::f64::consts::TAU)));
                }
            }
            sums.map(|sum| sum.hi)
        };
        (0..self.n).step_by(step).map(|i| (i, gradient(i))).collect()
    }

    fn mollis(&self, scene: &Scene<2>, exact: &[(usize, [f64; 2])], tolerance: f64) -> Result<Row> {
        let kernel = Kernel::<f64, 2>::newtonian(1.0, Mollifier::None, 0.0)?;
        let options = Options { tolerance, method: Some(Method::Fmm), ..Options::default() };
        let wanted = Wanted { potential: self.potential, gradient: true, ..Wanted::default() };
        let plan: Plan = field::plan(&kernel, self.n, self.n, wanted, &options)?;
        let mut memory = vec![0_u8; plan.workspace_bytes(1)? + 64];
        let mut results = Results::zeros(self.n);
        let mut seconds = Vec::new();
        for _ in 0..=self.repetitions {
            let before = cpu_time();
            let outputs = results.outputs(wanted);
            let sources = Sources::new(&scene.positions, &scene.masses);
            let workspace = aligned(&mut memory);
            field::evaluate(&plan, &kernel, sources, &scene.positions, outputs, workspace, &mut Run::default())?;
            seconds.push((cpu_time() - before).as_secs_f64());
        }
        Ok(Row {
            setting: tolerance,
            micros: 1e6 * minimum(&seconds) / self.n as f64,
            error: error(exact, |i| results.gradient[i]),
        })
    }

    fn peer(&self, scene: &Scene<2>, exact: &[(usize, [f64; 2])], sum: Sum, eps: f64) -> Result<Row> {
        let n = i32::try_from(self.n)?;
        let (mut potential, mut gradient, mut status) = (vec![0.0; self.n], vec![[0.0; 2]; self.n], 0);
        let mut seconds = Vec::new();
        for _ in 0..=self.repetitions {
            let before = cpu_time();
            // SAFETY: arrays of n numbers or pairs, as FMM2D's documentation asks for.
            #[expect(unsafe_code, reason = "a function of a library")]
            unsafe {
                let (x, m) = (scene.positions.as_flattened().as_ptr(), scene.masses.as_ptr());
                let (p, g) = (potential.as_mut_ptr(), gradient.as_flattened_mut().as_mut_ptr());
                sum(&raw const eps, &raw const n, x, m, p, g, &raw mut status);
            }
            seconds.push((cpu_time() - before).as_secs_f64());
        }
        if status != 0 {
            bail!("FMM2D's status is {status}");
        }
        // Its kernel is log r, ours log r / (2 pi).
        let gradient = |i: usize| gradient[i].map(|g: f64| g / std::f64::consts::TAU);
        Ok(Row { setting: eps, micros: 1e6 * minimum(&seconds) / self.n as f64, error: error(exact, gradient) })
    }
}

/// The fastest row with no larger an error.
fn fastest(rows: &[Row], error: f64) -> Option<Row> {
    rows.iter().filter(|row| row.error <= error).min_by(|a, b| a.micros.total_cmp(&b.micros)).copied()
}

/// The relative error of gradients in the l2 norm.
pub fn error(exact: &[(usize, [f64; 2])], of: impl Fn(usize) -> [f64; 2]) -> f64 {
    let (mut difference, mut size) = (0.0, 0.0);
    for &(i, [x, y]) in exact {
        let [u, v] = of(i);
        difference += (u - x) * (u - x) + (v - y) * (v - y);
        size += x * x + y * y;
    }
    (difference / size).sqrt()
}
