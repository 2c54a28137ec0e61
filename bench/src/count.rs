//! `mollis-bench count`: fixed cases of which `cargo xtask counts` counts the instructions, by callgrind.
//!
//! What is counted is the function [`mollis_counted`], without the preparation around it. Cases run at level AVX2, the widest that callgrind knows, or portable.

use anyhow::{Context, Result, bail};
use clap::Args;
use mollis_core::aggregation::{self, Advance, Report, State, Trajectories};
use mollis_core::exec::Run;
use mollis_core::field::{self, Accumulation, Method, Options, Outputs, Sources, Wanted};
use mollis_core::grid::{Equation, Grid, MassScale, Mesh};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::real::Real;
use mollis_core::simd::Level;

use crate::field::{KernelName, Results, core_radii, prepared};
use crate::scene::{Scene, aligned};

const COMPACT: Mollifier = Mollifier::Compact { order: 2, exponent: 4 };
const GRADIENT: Wanted = Wanted { potential: false, gradient: true, laplacian: false, hessian: false };
const BOTH: Wanted = Wanted { potential: true, ..GRADIENT };

/// A sum of a case.
#[derive(Clone, Copy, Debug)]
struct Sum {
    n: usize,
    law: Law,
    mollifier: Mollifier,
    delta: f64,
    wanted: Wanted,
    method: Method,
    tolerance: f64,
    radii: bool,
    compensated: bool,
    level: Level,
}

/// A sum over all pairs.
const PAIRS: Sum = Sum {
    n: 1000,
    law: Law::Newtonian,
    mollifier: COMPACT,
    delta: 0.01,
    wanted: GRADIENT,
    method: Method::Direct,
    tolerance: 0.0,
    radii: false,
    compensated: false,
    level: Level::Avx2,
};
const TREE: Sum = Sum { n: 10_000, wanted: BOTH, delta: 0.02, method: Method::Tree, tolerance: 1e-4, ..PAIRS };
const FMM: Sum = Sum { n: 20_000, mollifier: Mollifier::None, delta: 0.0, method: Method::Fmm, ..PAIRS };

/// What runs.
#[derive(Clone, Copy, Debug)]
enum Case {
    /// In so many dimensions, in double or single precision.
    Double(usize, Sum),
    Single(usize, Sum),
    Vortices,
    Step,
    Mesh,
    Prepare,
    Mollifier,
}

const LAPLACIAN: Wanted = Wanted { potential: false, gradient: false, laplacian: true, hessian: false };
const HESSIAN: Wanted = Wanted { potential: false, gradient: false, laplacian: false, hessian: true };
const SINGULAR_POWER: Law = Law::Power { exponent: -0.5 };
const QUARTIC: Law = Law::Power { exponent: 4.0 };

const CASES: &[(&str, Case)] = &[
    ("2d-gradient", Case::Double(2, PAIRS)),
    ("2d-gradient-f32", Case::Single(2, PAIRS)),
    ("2d-gradient-portable", Case::Double(2, Sum { level: Level::Portable, ..PAIRS })),
    ("2d-potential-gradient", Case::Double(2, Sum { wanted: BOTH, ..PAIRS })),
    ("2d-some-near", Case::Double(2, Sum { delta: 0.126, ..PAIRS })),
    ("2d-all-near", Case::Double(2, Sum { delta: 2.0, ..PAIRS })),
    ("2d-core-radii", Case::Double(2, Sum { radii: true, ..PAIRS })),
    ("2d-compensated", Case::Double(2, Sum { compensated: true, ..PAIRS })),
    ("2d-hessian", Case::Double(2, Sum { wanted: HESSIAN, ..PAIRS })),
    ("2d-small", Case::Double(2, Sum { n: 8, ..PAIRS })),
    ("2d-gaussian", Case::Double(2, Sum { mollifier: Mollifier::Gaussian { order: 2 }, ..PAIRS })),
    ("3d-gradient", Case::Double(3, PAIRS)),
    ("3d-gradient-f32", Case::Single(3, PAIRS)),
    ("3d-potential-gradient", Case::Double(3, Sum { wanted: BOTH, ..PAIRS })),
    ("3d-plummer", Case::Double(3, Sum { mollifier: Mollifier::Plummer, ..PAIRS })),
    ("3d-vortices", Case::Vortices),
    ("power", Case::Double(2, Sum { law: SINGULAR_POWER, delta: 0.05, ..PAIRS })),
    ("screened", Case::Double(2, Sum { law: Law::Screened { k: 2.0 }, delta: 0.05, ..PAIRS })),
    ("1d-sorted", Case::Double(1, Sum { n: 20_000, method: Method::Sorted, ..PAIRS })),
    ("moments", Case::Double(2, Sum { n: 20_000, law: QUARTIC, method: Method::Moments, ..PAIRS })),
    ("neighbours", Case::Double(2, Sum { n: 20_000, wanted: LAPLACIAN, method: Method::Neighbours, ..PAIRS })),
    ("fmm-1e-3", Case::Double(2, Sum { tolerance: 1e-3, ..FMM })),
    ("fmm-1e-6", Case::Double(2, Sum { tolerance: 1e-6, ..FMM })),
    ("fmm-1e-12", Case::Double(2, Sum { tolerance: 1e-12, ..FMM })),
    ("fmm-3d", Case::Double(3, Sum { tolerance: 1e-6, ..FMM })),
    ("tree-3d", Case::Double(3, TREE)),
    ("tree-screened", Case::Double(2, Sum { law: Law::Screened { k: 2.0 }, ..TREE })),
    ("blob-step", Case::Step),
    ("mesh", Case::Mesh),
    ("prepare-power", Case::Prepare),
    ("mollifier", Case::Mollifier),
];

/// Fixed cases whose instructions are counted.
#[derive(Clone, Debug, Args)]
pub struct Count {
    /// The case; prints the names of all without one.
    case: Option<String>,
}

impl Count {
    /// Runs the case.
    pub fn run(&self) -> Result<()> {
        let Some(name) = &self.case else {
            CASES.iter().for_each(|(name, _)| println!("{name}"));
            return Ok(());
        };
        let (_, case) = CASES.iter().find(|(case, _)| case == name).context("no such case")?;
        match *case {
            Case::Double(1, sum) => run_sum::<f64, 1>(sum),
            Case::Double(2, sum) => run_sum::<f64, 2>(sum),
            Case::Double(_, sum) => run_sum::<f64, 3>(sum),
            Case::Single(2, sum) => run_sum::<f32, 2>(sum),
            Case::Single(_, sum) => run_sum::<f32, 3>(sum),
            Case::Vortices => vortices(),
            Case::Step => step(),
            Case::Mesh => mesh(),
            Case::Prepare => prepare(),
            Case::Mollifier => mollifier(),
        }
    }
}

/// Runs a job; its instructions are counted.
#[inline(never)]
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "a name that callgrind can be told")]
pub fn mollis_counted(job: &mut dyn FnMut()) {
    job();
}

/// Runs a job that may fail.
fn counted<E>(mut job: impl FnMut() -> Result<(), E>) -> Result<()>
where
    anyhow::Error: From<E>,
{
    let mut result = Ok(());
    mollis_counted(&mut || result = job());
    Ok(result?)
}

fn run_sum<T: Real, const D: usize>(sum: Sum) -> Result<()> {
    let scene = Scene::<D>::uniform(sum.n, None, 1);
    let x: Vec<[T; D]> = scene.positions.iter().map(|x| x.map(T::from_f64)).collect();
    let m: Vec<T> = scene.masses.iter().map(|&m| T::from_f64(m)).collect();
    let radii: Vec<T> = core_radii(sum.delta, sum.n);
    let mut block = Vec::new();
    let kernel = prepared::<T, D>(&mut block, KernelName::Law(sum.law), sum.mollifier, sum.delta)?;
    let options = Options {
        method: Some(sum.method),
        tolerance: sum.tolerance,
        radii: sum.radii,
        accumulation: if sum.compensated { Accumulation::Compensated } else { Accumulation::Blocked },
        ..Options::default()
    };
    let plan = field::plan(&kernel, sum.n, sum.n, sum.wanted, &options)?;
    let mut memory = vec![0_u8; plan.workspace_bytes(1)? + 64];
    let mut results = Results::zeros(sum.n);
    if !sum.level.is_available() {
        bail!("this processor has no level {}", sum.level.name());
    }
    counted(|| {
        let outputs = results.outputs(sum.wanted);
        let sources = Sources::new(&x, &m);
        let sources = if sum.radii { sources.with_radii(&radii) } else { sources };
        let mut run = Run { level: sum.level, ..Run::default() };
        field::evaluate(&plan, &kernel, sources, &x, outputs, aligned(&mut memory), &mut run)
    })
}

/// Vortex elements in space.
fn vortices() -> Result<()> {
    let (scene, strengths) = (Scene::<3>::uniform(PAIRS.n, None, 1), Scene::<3>::uniform(PAIRS.n, None, 2).positions);
    let kernel = Kernel::<f64, 3>::newtonian(1.0, COMPACT, 0.05)?;
    let options = Options { strengths: true, ..Options::default() };
    let plan = field::plan(&kernel, PAIRS.n, PAIRS.n, GRADIENT, &options)?;
    let mut memory = vec![0_u8; plan.workspace_bytes(1)? + 64];
    let mut gradient = vec![[0.0; 3]; PAIRS.n];
    counted(|| {
        let outputs = Outputs { gradient: Some(&mut gradient), ..Outputs::default() };
        let sources = Sources::vortices(&scene.positions, &strengths);
        let mut run = Run { level: Level::Avx2, ..Run::default() };
        field::evaluate(&plan, &kernel, sources, &scene.positions, outputs, aligned(&mut memory), &mut run)
    })
}

/// Ten steps of the blob method with densities.
fn step() -> Result<()> {
    let mut scene = Scene::<2>::uniform(500, None, 1);
    let masses = vec![1.0 / 500.0; 500];
    let mut density = vec![1.0; 500];
    let kernel = Kernel::<f64, 2>::newtonian(1.0, COMPACT, 0.1)?;
    let wanted = aggregation::Wanted { density: true, ..aggregation::Wanted::default() };
    let plan = aggregation::plan(&kernel, 500, 0, wanted, &Options::default())?;
    let mut memory = vec![0_u8; plan.workspace_bytes::<f64, 2>(1)? + 64];
    counted(|| {
        let state = State {
            masses: &masses,
            particles: Trajectories {
                positions: &mut scene.positions,
                density: Some(&mut density),
                ..Trajectories::none()
            },
            tracers: Trajectories::none(),
        };
        let advance = Advance { dt: 1e-3, steps: 10, after_step: None };
        let mut run = Run { level: Level::Avx2, ..Run::default() };
        let memory = aligned(&mut memory);
        aggregation::step(&plan, &kernel, state, advance, memory, &mut run, &mut Report::default())
    })
}

/// A field on a mesh: deposit, solve, interpolate.
fn mesh() -> Result<()> {
    use mollis_core::exec::Resources;
    let scene = Scene::<2>::uniform(20_000, None, 1);
    let masses: Vec<f64> = scene.masses.iter().map(|m| m.abs()).collect();
    let mesh = Mesh::new([-0.1, -0.1], [1.1, 1.1], [64; 2])?;
    let mut memory = vec![0_u8; Grid::workspace_bytes(&mesh, &Equation::POISSON, 1)? + 64];
    let mut grid = Grid::prepare(aligned(&mut memory), mesh, Equation::POISSON, 1)?;
    let scale = MassScale::of(&masses)?;
    let mut gradient = vec![[0.0; 2]; scene.positions.len()];
    let resources = Resources { level: Level::Avx2, ..Resources::default() };
    counted(|| {
        grid.begin(scale);
        grid.add(&scene.positions, &masses, resources)?;
        grid.solve(resources)?;
        grid.interpolate_here(&scene.positions, &mut gradient, resources.level);
        Ok::<(), mollis_core::Error>(())
    })
}

/// The table of a mollified power.
fn prepare() -> Result<()> {
    let terms = [Term { law: SINGULAR_POWER, coefficient: 1.0 }];
    let mut block = vec![0_u8; Kernel::<f64, 2>::workspace_bytes(&terms, COMPACT)? + 64];
    counted(|| Kernel::<f64, 2>::prepare(aligned(&mut block), &terms, COMPACT, 0.05).map(|_| ()))
}

/// A mollifier's functions at a thousand distances.
fn mollifier() -> Result<()> {
    let blob = Blob::<f64, 2>::new(Mollifier::Compact { order: 4, exponent: 6 }, 1.0)?;
    let mut sum = 0.0;
    counted(|| {
        for k in 0..1000 {
            let r = f64::from(k) * 1e-3;
            sum += blob.density(r) + blob.gradient_factor(r);
        }
        Ok::<(), mollis_core::Error>(())
    })?;
    if sum.is_finite() { Ok(()) } else { bail!("not finite") }
}
