//! `mollis-bench field`: pairs per second and error of a sum, compared with the same sum in C in the same run.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use mollis_core::exec::{Executor, Run, Serial, Statistics};
use mollis_core::field::{self, Accumulation, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, RadialKernel, Supplied, Term};
use mollis_core::mollifier::{Blob, Mollifier};
use mollis_core::real::Real;
use mollis_core::simd::Level;

use crate::peers::Peer;
use crate::scene::{Scene, aligned};

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum MethodName {
    Auto,
    Direct,
    Fmm,
    Tree,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Precision {
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum MollifierName {
    Compact,
    Gaussian,
    Plummer,
    Algebraic,
    Vatistas,
    Richardson,
}

/// A kernel's name and parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum KernelName {
    Law(Law),
    Own,
}

fn parse_kernel(text: &str) -> Result<KernelName> {
    let (name, number) = text.split_once('=').unwrap_or((text, ""));
    let number = || number.parse::<f64>().with_context(|| format!("{name} needs a number"));
    Ok(match name {
        "newtonian" => KernelName::Law(Law::Newtonian),
        "power" => KernelName::Law(Law::Power { exponent: number()? }),
        "exponential" => KernelName::Law(Law::Exponential { length: number()? }),
        "screened" => KernelName::Law(Law::Screened { k: number()? }),
        "own" => KernelName::Own,
        _ => bail!("no such kernel: {text}"),
    })
}

/// -(r^2 + e^2)^(-1/2) in D dimensions.
struct Plummer {
    dimension: f64,
}

impl RadialKernel for Plummer {
    fn at(&self, r: f64) -> [f64; 3] {
        let square = r * r + 0.0025;
        let root = 1.0 / square.sqrt();
        let g = root / square;
        [-root, g, self.dimension * g - 3.0 * r * r * g / square]
    }
}

/// A kernel of one term in a block of memory, which is made as large as it needs to be.
pub(crate) fn prepared<'k, T: Real, const D: usize>(
    memory: &'k mut Vec<u8>,
    name: KernelName,
    mollifier: Mollifier,
    delta: f64,
) -> Result<Kernel<'k, T, D>> {
    let plummer = Plummer { dimension: D as f64 };
    let (terms, own) = match name {
        KernelName::Law(law) => (vec![Term { law, coefficient: 1.0 }], None),
        KernelName::Own => (vec![], Some(Supplied::new(&plummer, 1.0, 4.0))),
    };
    let bytes = Kernel::<T, D>::workspace_bytes_with(&terms, own.is_some(), mollifier)?;
    memory.resize(bytes + 64, 0);
    Ok(Kernel::prepare_with(&mut aligned(memory)[..bytes], &terms, own, mollifier, T::from_f64(delta))?)
}

/// The sum and the way it is computed.
#[derive(Clone, Debug, Args)]
pub struct Field {
    /// Dimension: 1, 2 or 3.
    #[arg(long, default_value_t = 2)]
    dim: usize,
    /// Sources, uniform in the unit cube, masses of both signs.
    #[arg(long, default_value_t = 8192)]
    n: usize,
    /// Targets: the first of the sources; all of them if not given.
    #[arg(long)]
    targets: Option<usize>,
    /// The method.
    #[arg(long, value_enum, default_value = "direct")]
    method: MethodName,
    /// The tolerance of approximate methods.
    #[arg(long, default_value_t = 0.0)]
    tolerance: f64,
    /// A list of potential, gradient, laplacian, hessian.
    #[arg(long, default_value = "gradient")]
    outputs: String,
    /// The mollifier's length; no mollifier if not given.
    #[arg(long)]
    delta: Option<f64>,
    /// Chooses delta so that about this fraction of the pairs is near; 1 gives the diagonal of the cube.
    #[arg(long, conflicts_with = "delta")]
    near: Option<f64>,
    /// newtonian, power=P, exponential=LENGTH, screened=K, or own: a function of the host (Plummer's potential, softened over 0.05).
    #[arg(long, default_value = "newtonian", value_parser = parse_kernel)]
    kernel: KernelName,
    /// The mollifier, with --delta or --near.
    #[arg(long, value_enum, default_value = "compact")]
    mollifier: MollifierName,
    /// A core radius for each source, from 3/4 to 5/4 of delta.
    #[arg(long)]
    radii: bool,
    /// In space: vector strengths in place of masses, whose gradient is the velocity of vortex elements.
    #[arg(long)]
    vectors: bool,
    /// The mollifier's order.
    #[arg(long, default_value_t = 2)]
    order: u32,
    /// The mollifier's exponent M.
    #[arg(long, default_value_t = 4)]
    exponent: u32,
    #[arg(long, value_enum, default_value = "f64")]
    scalar: Precision,
    /// Threads; times are wall times with several threads, otherwise CPU times of the thread.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// auto, portable, neon, avx2 or avx512.
    #[arg(long, default_value = "auto")]
    level: String,
    /// Compensated accumulation.
    #[arg(long)]
    compensated: bool,
    /// Leaves out the C loop.
    #[arg(long)]
    no_peer: bool,
    /// Repetitions of each program, interleaved.
    #[arg(long, default_value_t = 60)]
    repetitions: usize,
    /// Complete measurements; the ratio is their median.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

/// Minimum and spread of repeated times.
#[derive(Clone, Copy, Debug, serde::Serialize)]
struct Times {
    seconds_min: f64,
    seconds_median: f64,
    pairs_per_second: f64,
}

#[derive(Debug, serde::Serialize)]
struct Report {
    dim: usize,
    n: usize,
    targets: usize,
    method: String,
    reason: String,
    outputs: String,
    delta: Option<f64>,
    kernel: String,
    scalar: String,
    threads: usize,
    level: &'static str,
    compensated: bool,
    tolerance: f64,
    workspace_bytes: usize,
    /// Pairs that were summed one by one.
    pairs: u64,
    near_fraction: f64,
    polynomial_blocks: u64,
    mollis: Times,
    relative_error: f64,
    c_loop: Option<Times>,
    ratio_median: Option<f64>,
    ratios: Vec<f64>,
}

impl Field {
    /// Measures and prints.
    pub fn run(&self) -> Result<()> {
        let report = match (self.dim, self.scalar) {
            (1, Precision::F64) => self.measure::<f64, 1>()?,
            (2, Precision::F64) => self.measure::<f64, 2>()?,
            (3, Precision::F64) => self.measure::<f64, 3>()?,
            (1, Precision::F32) => self.measure::<f32, 1>()?,
            (2, Precision::F32) => self.measure::<f32, 2>()?,
            (3, Precision::F32) => self.measure::<f32, 3>()?,
            _ => bail!("the dimension is 1, 2 or 3"),
        };
        if self.json {
            println!("{}", serde_json::to_string(&report)?);
            return Ok(());
        }
        println!(
            "{}D {} {} {}: {:.3e} pairs/s (min; median {:.3e} s), relative error {:.1e}, near {:.2} %",
            report.dim,
            report.scalar,
            report.level,
            report.method,
            report.mollis.pairs_per_second,
            report.mollis.seconds_median,
            report.relative_error,
            100.0 * report.near_fraction
        );
        println!(
            "{:.4} us a target, {:.0} workspace bytes a target",
            1e6 * report.mollis.seconds_min / report.targets as f64,
            report.workspace_bytes as f64 / report.targets as f64
        );
        if let (Some(c), Some(ratio)) = (report.c_loop, report.ratio_median) {
            println!(
                "C loop (f64): {:.3e} pairs/s; ratio {ratio:.2} (median of {:?})",
                c.pairs_per_second, report.ratios
            );
        }
        Ok(())
    }

    fn delta<const D: usize>(&self) -> Option<f64> {
        let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI];
        self.delta.or_else(|| self.near.map(|f| if f >= 1.0 { 2.0 } else { (f / ball[D - 1]).powf(1.0 / D as f64) }))
    }

    fn measure<T: Real, const D: usize>(&self) -> Result<Report> {
        let scene = Scene::<D>::uniform(self.n, self.delta::<D>(), 1);
        let n_targets = self.targets.unwrap_or(self.n).min(self.n);
        let level = match Level::ALL.into_iter().find(|l| l.name() == self.level) {
            Some(level) => level,
            None if self.level == "auto" => Level::best(),
            None => bail!("no such level: {}", self.level),
        };
        let (mut wanted, names) = (Wanted::default(), self.outputs.split(','));
        for name in names {
            match name {
                "potential" => wanted.potential = true,
                "gradient" => wanted.gradient = true,
                "laplacian" => wanted.laplacian = true,
                "hessian" => wanted.hessian = true,
                _ => bail!("outputs are potential, gradient, laplacian, hessian"),
            }
        }
        let mollifier = match scene.delta {
            Some(_) => match self.mollifier {
                MollifierName::Compact => Mollifier::Compact { order: self.order, exponent: self.exponent },
                MollifierName::Gaussian => Mollifier::Gaussian { order: self.order },
                MollifierName::Plummer => Mollifier::Plummer,
                MollifierName::Algebraic => Mollifier::Algebraic,
                MollifierName::Vatistas => Mollifier::Vatistas,
                MollifierName::Richardson => Mollifier::Richardson { order: self.order, exponent: self.exponent },
            },
            None => Mollifier::None,
        };
        let delta = scene.delta.unwrap_or(0.0);
        let mut blocks = [Vec::new(), Vec::new()];
        let [block, accurate] = &mut blocks;
        let kernel = prepared::<T, D>(block, self.kernel, mollifier, delta)?;
        let accurate = prepared::<f64, D>(accurate, self.kernel, mollifier, kernel.delta().to_f64())?;
        let positions: Vec<[T; D]> = scene.positions.iter().map(|x| x.map(T::from_f64)).collect();
        let masses: Vec<T> = scene.masses.iter().map(|&m| T::from_f64(m)).collect();
        let radii: Vec<T> = core_radii(kernel.delta().to_f64(), self.n);
        let vectors = Scene::<D>::uniform(self.n, None, 2).positions;
        let vectors: Vec<[T; D]> = vectors.iter().map(|s| s.map(|s| T::from_f64(s - 0.5))).collect();
        let vectors = self.vectors.then_some(&vectors[..]);
        let targets = &positions[..n_targets];
        let options = Options {
            accumulation: if self.compensated { Accumulation::Compensated } else { Accumulation::Blocked },
            method: match self.method {
                MethodName::Auto => None,
                MethodName::Direct => Some(Method::Direct),
                MethodName::Fmm => Some(Method::Fmm),
                MethodName::Tree => Some(Method::Tree),
            },
            tolerance: self.tolerance,
            radii: self.radii,
            strengths: self.vectors,
            ..Options::default()
        };
        let plan = field::plan(&kernel, self.n, n_targets, wanted, &options)?;
        let pool = (self.threads > 1).then(|| mollis_host::pool::Pool::new(self.threads)).transpose()?;
        let executor: &dyn Executor = pool.as_ref().map_or(&Serial, |p| p);
        let bytes = plan.workspace_bytes(executor.workers())?;
        let mut memory = vec![0_u8; bytes + 64];
        let workspace = aligned(&mut memory);
        let mut results = Results::zeros(n_targets);
        let mut counters = Statistics::default();
        let mut once = |counters: Option<&mut Statistics>| {
            let sources = vectors.map_or(Sources::new(&positions, &masses), |s| Sources::vortices(&positions, s));
            let sources = if self.radii { sources.with_radii(&radii) } else { sources };
            let outputs = results.outputs(wanted);
            let mut run = Run { level, executor, counters, ..Run::default() };
            field::evaluate(&plan, &kernel, sources, targets, outputs, workspace, &mut run)
        };
        once(Some(&mut counters))?;
        let mut peer = if self.no_peer
            || self.radii
            || self.vectors
            || self.mollifier != MollifierName::Compact
            || self.kernel != KernelName::Law(Law::Newtonian)
        {
            None
        } else {
            Peer::new(&scene, n_targets, wanted.gradient, wanted.potential)
        };
        let pairs = self.n as f64 * n_targets as f64;
        let clock = if self.threads > 1 { wall_time } else { cpu_time };
        let (mut ours, mut theirs, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..self.rounds.max(1) {
            let (mut round, mut peer_round) = (Vec::new(), Vec::new());
            for _ in 0..self.repetitions.max(1) {
                let before = clock();
                once(None)?;
                round.push((clock() - before).as_secs_f64());
                if let Some(peer) = &mut peer {
                    let before = clock();
                    peer.run();
                    peer_round.push((clock() - before).as_secs_f64());
                }
            }
            if peer.is_some() {
                ratios.push(minimum(&peer_round) / minimum(&round));
            }
            ours.extend(round);
            theirs.extend(peer_round);
        }
        ratios.sort_by(f64::total_cmp);
        let times = |seconds: &mut Vec<f64>| {
            seconds.sort_by(f64::total_cmp);
            let (least, median) = (seconds[0], seconds[seconds.len() / 2]);
            Times { seconds_min: least, seconds_median: median, pairs_per_second: pairs / least }
        };
        let each = self.radii.then_some(&radii[..]);
        let relative_error = if self.vectors || matches!(plan.method(), Method::Fmm | Method::Tree) {
            error_of_sample::<T, D>(&scene, &accurate, (each, vectors), wanted, &results)?
        } else {
            error::<T, D>(&scene, &accurate, each, wanted, &results)?
        };
        Ok(Report {
            dim: D,
            n: self.n,
            targets: n_targets,
            method: format!("{:?}", plan.method()).to_lowercase(),
            reason: format!("{:?}", plan.reason()),
            outputs: self.outputs.clone(),
            delta: scene.delta,
            kernel: format!("{:?}", self.kernel),
            scalar: format!("{:?}", self.scalar).to_lowercase(),
            threads: self.threads,
            level: level.name(),
            compensated: self.compensated,
            tolerance: self.tolerance,
            workspace_bytes: bytes,
            pairs: counters.pairs,
            near_fraction: counters.near_pairs as f64 / pairs,
            polynomial_blocks: counters.polynomial_blocks,
            mollis: times(&mut ours),
            relative_error,
            c_loop: peer.is_some().then(|| times(&mut theirs)),
            ratio_median: ratios.get(ratios.len() / 2).copied(),
            ratios,
        })
    }
}

pub(crate) fn minimum(seconds: &[f64]) -> f64 {
    seconds.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Core radii from 3/4 to 5/4 of delta.
pub(crate) fn core_radii<T: Real>(delta: f64, n: usize) -> Vec<T> {
    (0..n).map(|k| T::from_f64(delta * (0.75 + 0.5 * (k % 64) as f64 / 64.0))).collect()
}

/// What a sum writes.
pub(crate) struct Results<T, const D: usize> {
    potential: Vec<T>,
    pub(crate) gradient: Vec<[T; D]>,
    laplacian: Vec<T>,
    hessian: Vec<[[T; D]; D]>,
}

impl<T: Real, const D: usize> Results<T, D> {
    pub(crate) fn zeros(n: usize) -> Self {
        let zero = T::ZERO;
        let (potential, gradient) = (vec![zero; n], vec![[zero; D]; n]);
        Self { potential, gradient, laplacian: vec![zero; n], hessian: vec![[[zero; D]; D]; n] }
    }

    pub(crate) fn outputs(&mut self, wanted: Wanted) -> Outputs<'_, T, D> {
        Outputs {
            potential: wanted.potential.then_some(&mut self.potential[..]),
            gradient: wanted.gradient.then_some(&mut self.gradient[..]),
            laplacian: wanted.laplacian.then_some(&mut self.laplacian[..]),
            hessian: wanted.hessian.then_some(&mut self.hessian[..]),
        }
    }
}

/// The relative l2 error over up to 32 targets, the largest of the outputs. The reference is an f64 sum of accurate terms at
/// the same particles (those in f32 are converted exactly).
fn error<T: Real, const D: usize>(
    scene: &Scene<D>,
    kernel: &Kernel<'_, f64, D>,
    radii: Option<&[T]>,
    wanted: Wanted,
    results: &Results<T, D>,
) -> Result<f64> {
    let blobs: Vec<Blob<f64, D>> = radii
        .unwrap_or_default()
        .iter()
        .map(|radius| Blob::new(kernel.mollifier(), radius.to_f64()))
        .collect::<Result<_, _>>()?;
    let Results { potential, gradient, laplacian, hessian } = results;
    // Squares of difference and size, for each of the outputs.
    let mut norms = [[0.0_f64; 2]; 4];
    for i in (0..gradient.len()).step_by(gradient.len().div_ceil(32).max(1)) {
        let (mut u, mut du, mut ddu, mut all) = (0.0, [0.0; D], 0.0, [[0.0; D]; D]);
        for (j, (x, &m)) in scene.positions.iter().zip(&scene.masses).enumerate() {
            let d: [f64; D] = std::array::from_fn(|k| scene.positions[i][k] - x[k]);
            let r = d.iter().map(|d| d * d).sum::<f64>().sqrt();
            if r == 0.0 && kernel.is_singular() {
                continue;
            }
            let [value, factor, laplacian] = match blobs.get(j) {
                Some(blob) => [blob.potential(r), blob.gradient_factor(r), blob.density(r)],
                None => kernel.at(r),
            };
            u += m * value;
            (0..D).for_each(|k| du[k] += m * factor * d[k]);
            ddu += m * laplacian;
            for k in 0..D {
                for l in 0..D {
                    let unit = if r > 0.0 { d[k] * d[l] / (r * r) } else { 0.0 };
                    let trace = if k == l { factor } else { 0.0 };
                    all[k][l] += m * (trace + (laplacian - D as f64 * factor) * unit);
                }
            }
        }
        let mut add = |which: usize, got: T, want: f64| {
            norms[which][0] += (got.to_f64() - want).powi(2);
            norms[which][1] += want.powi(2);
        };
        if wanted.potential {
            add(0, potential[i], u);
        }
        if wanted.gradient {
            (0..D).for_each(|k| add(1, gradient[i][k], du[k]));
        }
        if wanted.laplacian {
            add(2, laplacian[i], ddu);
        }
        if wanted.hessian {
            let got = hessian[i].as_flattened();
            got.iter().zip(all.as_flattened()).for_each(|(&got, &want)| add(3, got, want));
        }
    }
    Ok(norms.iter().filter(|n| n[1] > 0.0).map(|n| (n[0] / n[1]).sqrt()).fold(0.0, f64::max))
}

/// The relative l2 error over about 100 targets, the largest of the outputs, against the sum over all pairs in f64 with compensated additions, which is exact to a few
/// units in the last place.
fn error_of_sample<T: Real, const D: usize>(
    scene: &Scene<D>,
    kernel: &Kernel<'_, f64, D>,
    (radii, vectors): (Option<&[T]>, Option<&[[T; D]]>),
    wanted: Wanted,
    results: &Results<T, D>,
) -> Result<f64> {
    let Results { potential, gradient, laplacian, hessian } = results;
    let vectors: Option<Vec<[f64; D]>> = vectors.map(|all| all.iter().map(|s| s.map(T::to_f64)).collect());
    let each = gradient.len().div_ceil(100).max(1);
    let targets: Vec<[f64; D]> = scene.positions.iter().take(gradient.len()).step_by(each).copied().collect();
    let radii: Option<Vec<f64>> = radii.map(|radii| radii.iter().map(|r| r.to_f64()).collect());
    let options = Options {
        accumulation: Accumulation::Compensated,
        method: Some(Method::Direct),
        radii: radii.is_some(),
        strengths: vectors.is_some(),
        ..Options::default()
    };
    let plan = field::plan(kernel, scene.positions.len(), targets.len(), wanted, &options)?;
    let mut memory = vec![0_u8; plan.workspace_bytes(1)? + 64];
    let n = targets.len();
    let mut exact = Results::zeros(n);
    let outputs = exact.outputs(wanted);
    let sources = Sources::new(&scene.positions, &scene.masses);
    let sources = vectors.as_deref().map_or(sources, |s| Sources::vortices(&scene.positions, s));
    let sources = radii.as_deref().map_or(sources, |radii| sources.with_radii(radii));
    field::evaluate(&plan, kernel, sources, &targets, outputs, aligned(&mut memory), &mut Run::default())?;
    let relative = |pairs: &mut dyn Iterator<Item = (T, f64)>| {
        let (mut error, mut size) = (0.0_f64, 0.0_f64);
        for (got, want) in pairs {
            error += (got.to_f64() - want).powi(2);
            size += want.powi(2);
        }
        if size > 0.0 { (error / size).sqrt() } else { 0.0 }
    };
    let mut worst = 0.0_f64;
    if wanted.potential {
        worst = worst.max(relative(&mut potential.iter().step_by(each).copied().zip(exact.potential)));
    }
    if wanted.gradient {
        let got = gradient.iter().step_by(each).flatten().copied();
        worst = worst.max(relative(&mut got.zip(exact.gradient.into_iter().flatten())));
    }
    if wanted.laplacian {
        worst = worst.max(relative(&mut laplacian.iter().step_by(each).copied().zip(exact.laplacian)));
    }
    if wanted.hessian {
        let got = hessian.iter().step_by(each).flatten().flatten().copied();
        worst = worst.max(relative(&mut got.zip(exact.hessian.into_iter().flatten().flatten())));
    }
    Ok(worst)
}

pub(crate) fn wall_time() -> Duration {
    use std::sync::OnceLock;
    static START: OnceLock<std::time::Instant> = OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}

/// CPU time of the thread, which depends least on other programs.
pub(crate) fn cpu_time() -> Duration {
    let mut now = Timespec { seconds: 0, nanoseconds: 0 };
    const THREAD_CPU: i32 = 3;
    // SAFETY: the call writes one structure of this layout (64-bit Linux).
    #[expect(unsafe_code, reason = "the thread's CPU clock is not in std")]
    let status = unsafe { clock_gettime(THREAD_CPU, &mut now) };
    assert_eq!(status, 0, "no CPU clock");
    Duration::new(now.seconds as u64, now.nanoseconds as u32)
}

#[repr(C)]
struct Timespec {
    seconds: i64,
    nanoseconds: i64,
}

#[expect(unsafe_code, reason = "the thread's CPU clock is not in std")]
unsafe extern "C" {
    fn clock_gettime(clock: i32, time: *mut Timespec) -> i32;
}
