//! `mollis-bench fmm2d` and `fmm3d`: the fast multipole method beside FMM2D and FMM3D (Flatiron Institute), libraries that the user has built, at equal errors in the same run.
//!
//! Both sum the potentials and gradients of the same points at the points themselves. The error is that of the gradients in the l2 norm, relative to the gradients, over a sample of
//! targets whose sums are computed pair by pair in double words.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use mollis_core::exec::Run;
use mollis_core::field::{self, Method, Options, Plan, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_core::real::DoubleWord;

use crate::field::{Results, cpu_time, minimum};
use crate::scene::{Scene, aligned};

/// The libraries' sums over sources at the sources: eps, n (an integer of 32 bits in FMM2D, of 64 in FMM3D), positions, charges, potentials, gradients, status.
type Sum = unsafe extern "C" fn(*const f64, *const i64, *const f64, *const f64, *mut f64, *mut f64, *mut i64);

/// What they are asked for; their errors are smaller.
const PEER: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// The fast multipole method beside FMM2D or FMM3D.
#[derive(Clone, Debug, Args)]
pub struct Fmm {
    /// libfmm2d.so or libfmm3d.so (FMM3D: `make lib FAST_KER=ON`, and `OMP_NUM_THREADS=1` in the environment); without it mollis alone is measured.
    #[arg(long)]
    library: Option<PathBuf>,
    /// Points, with masses of both signs.
    #[arg(long, default_value_t = 100_000)]
    n: usize,
    /// Repetitions, of which the fastest counts.
    #[arg(long, default_value_t = 5)]
    repetitions: usize,
    /// Computes the potential besides the gradient (the libraries always do).
    #[arg(long)]
    potential: bool,
    /// Targets of which the error is measured.
    #[arg(long, default_value_t = 200)]
    sample: usize,
    /// Where the points are.
    #[arg(long, value_enum, default_value_t = Shape::Uniform)]
    points: Shape,
}

/// Where points are.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Shape {
    /// Uniform in the unit square or cube.
    Uniform,
    /// On the circle or sphere in it.
    Sphere,
    /// Half of them in seven cubes of a thousandth of the side.
    Clusters,
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

impl Fmm {
    /// Measures and prints.
    pub fn run<const D: usize>(&self) -> Result<()> {
        let mut scene = Scene::<D>::uniform(self.n, None, 1);
        match self.points {
            Shape::Uniform => {}
            Shape::Sphere => scene.positions.iter_mut().for_each(|x| {
                let centred = x.map(|x| x - 0.5);
                let length = centred.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
                *x = centred.map(|x| 0.5 + 0.5 * x / length);
            }),
            Shape::Clusters => scene.positions.iter_mut().enumerate().filter(|(k, _)| k % 2 == 0).for_each(|(k, x)| {
                let centre: [f64; D] = std::array::from_fn(|axis| ((k / 2 % 7 + axis * 3) % 7) as f64 / 7.0 + 0.05);
                x.iter_mut().zip(centre).for_each(|(x, centre)| *x = centre + 1e-3 * *x);
            }),
        }
        let exact = self.exact(&scene);
        let ours = (6..=52).map(|quarter| self.mollis(&scene, &exact, 10_f64.powf(-0.25 * f64::from(quarter))));
        let ours = ours.collect::<Result<Vec<Row>>>()?;
        println!("mollis: tolerance, us a point, error");
        for row in ours.iter().step_by(2) {
            println!("  {:8.1e} {:8.4} {:8.1e}", row.setting, row.micros, row.error);
        }
        println!("at errors: us a point");
        for error in PEER {
            let Some(row) = fastest(&ours, error) else { continue };
            println!("  {error:8.1e} {:8.4} (tolerance {:.1e})", row.micros, row.setting);
        }
        let Some(path) = &self.library else { return Ok(()) };
        println!("FMM{D}D: eps, us a point, error; mollis at no larger an error; ratio");
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
        Self { library: None, n, repetitions: 3, potential: false, sample: 200, points: Shape::Uniform }
    }

    /// The library's times and errors.
    pub fn peers<const D: usize>(
        &self,
        path: &Path,
        scene: &Scene<D>,
        exact: &[(usize, [f64; D])],
    ) -> Result<Vec<Row>> {
        // SAFETY: the user names the library, which has no code that runs when it is loaded.
        #[expect(unsafe_code, reason = "a library by path")]
        let library = unsafe { libloading::Library::new(path)? };
        let name: &[u8] = if D == 2 { b"rfmm2d_s_c_g_\0" } else { b"lfmm3d_s_c_g_\0" };
        // SAFETY: the documentation has this signature; of little-endian integers the lower half is read.
        #[expect(unsafe_code, reason = "a function of a library")]
        let sum = unsafe { library.get::<Sum>(name)? };
        PEER.into_iter().map(|eps| self.peer(scene, exact, *sum, eps)).collect()
    }

    /// The targets of the sample and their gradients.
    pub fn exact<const D: usize>(&self, scene: &Scene<D>) -> Vec<(usize, [f64; D])> {
        let step = self.n.div_ceil(self.sample.max(1)).max(1);
        let area = if D == 2 { std::f64::consts::TAU } else { 2.0 * std::f64::consts::TAU };
        let gradient = |i: usize| {
            let mut sums = [DoubleWord::<f64>::ZERO; D];
            for (x, &m) in scene.positions.iter().zip(&scene.masses) {
                let d: [f64; D] = std::array::from_fn(|axis| scene.positions[i][axis] - x[axis]);
                let square = d.iter().map(|d| d * d).sum::<f64>();
                if square > 0.0 {
                    let power = if D == 2 { square } else { square * square.sqrt() };
                    sums.iter_mut().zip(d).for_each(|(sum, d)| *sum = sum.plus(m * d / (power * area)));
                }
            }
            sums.map(|sum| sum.hi)
        };
        (0..self.n).step_by(step).map(|i| (i, gradient(i))).collect()
    }

    fn mollis<const D: usize>(&self, scene: &Scene<D>, exact: &[(usize, [f64; D])], tolerance: f64) -> Result<Row> {
        let kernel = Kernel::<f64, D>::newtonian(1.0, Mollifier::None, 0.0)?;
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

    fn peer<const D: usize>(&self, scene: &Scene<D>, exact: &[(usize, [f64; D])], sum: Sum, eps: f64) -> Result<Row> {
        let n = i64::try_from(self.n)?;
        let (mut potential, mut gradient, mut status) = (vec![0.0; self.n], vec![[0.0; D]; self.n], 0);
        let mut seconds = Vec::new();
        for _ in 0..=self.repetitions {
            let before = cpu_time();
            // SAFETY: arrays of n numbers or pairs, as the documentation asks for.
            #[expect(unsafe_code, reason = "a function of a library")]
            unsafe {
                let (x, m) = (scene.positions.as_flattened().as_ptr(), scene.masses.as_ptr());
                let (p, g) = (potential.as_mut_ptr(), gradient.as_flattened_mut().as_mut_ptr());
                sum(&raw const eps, &raw const n, x, m, p, g, &raw mut status);
            }
            seconds.push((cpu_time() - before).as_secs_f64());
        }
        if status != 0 {
            bail!("the library's status is {status}");
        }
        // Its kernels are log r and 1 / (4 pi r), ours log r / (2 pi) and -1 / (4 pi r).
        let factor = if D == 2 { 1.0 / std::f64::consts::TAU } else { -1.0 };
        let gradient = |i: usize| gradient[i].map(|g: f64| g * factor);
        Ok(Row { setting: eps, micros: 1e6 * minimum(&seconds) / self.n as f64, error: error(exact, gradient) })
    }
}

/// The fastest row with no larger an error.
fn fastest(rows: &[Row], error: f64) -> Option<Row> {
    rows.iter().filter(|row| row.error <= error).min_by(|a, b| a.micros.total_cmp(&b.micros)).copied()
}

/// The relative error of gradients in the l2 norm.
pub fn error<const D: usize>(exact: &[(usize, [f64; D])], of: impl Fn(usize) -> [f64; D]) -> f64 {
    let (mut difference, mut size) = (0.0, 0.0);
    for &(i, exact) in exact {
        for (value, exact) in of(i).into_iter().zip(exact) {
            difference += (value - exact) * (value - exact);
            size += exact * exact;
        }
    }
    (difference / size).sqrt()
}
