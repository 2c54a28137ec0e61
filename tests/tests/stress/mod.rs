//! Sums, runs of the blob method and coalescing particles at and beyond the ends of what they are made for. Every case has one expected outcome, which follows from mathematics:
//! a stated error bound, a conserved quantity, an exact solution, or a status with the buffers that go with it.
//!
//! `cargo test` takes short sizes. `cargo xtask stress` sets `MOLLIS_STRESS=long`: more scales and seeds, and a million steps.

mod coalescing;
mod coincidence;
#[cfg(target_arch = "x86_64")]
mod environment;
mod long_runs;
mod not_finite;
mod pairs;
mod stiff;
mod sums;

use mollis_core::aggregation::{self, Advance, Plan, Report, State, Trajectories, Wanted};
use mollis_core::exec::{Executor, Run, Serial};
use mollis_core::field::{self, Interaction, Method, Options, Sources};
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;
use mollis_core::{Real, Result};
use mollis_reference::field::{self as twin, Soft};
use mollis_tests::{Aligned, Split};

use crate::field_bounds;
use crate::hessians::{self, Sums};

/// Whether the long sizes are asked for.
fn long() -> bool {
    std::env::var("MOLLIS_STRESS").is_ok_and(|asked| asked == "long")
}

/// One of two sizes.
fn size<N>(short: N, long: N) -> N {
    if self::long() { long } else { short }
}

/// The Newtonian kernel with this coefficient, under a compact mollifier or without.
fn kernel<T: Real, const D: usize>(coefficient: f64, soft: Option<Soft>) -> Kernel<'static, T, D> {
    let (mollifier, delta) = match soft {
        Some(soft) => (Mollifier::Compact { order: soft.order, exponent: soft.exponent }, soft.delta),
        None => (Mollifier::None, 0.0),
    };
    Kernel::newtonian(T::from_f64(coefficient), mollifier, T::from_f64(delta)).unwrap()
}

fn wide<T: Real, const D: usize>(points: &[[T; D]]) -> Vec<[f64; D]> {
    points.iter().map(|x| x.map(T::to_f64)).collect()
}

fn narrow<T: Real, const D: usize>(points: &[[f64; D]]) -> Vec<[T; D]> {
    points.iter().map(|x| x.map(T::from_f64)).collect()
}

/// Points of [-1, 1]^D.
fn cloud<const D: usize>(n: usize, seed: u64) -> Vec<[f64; D]> {
    let mut numbers = Split(seed);
    (0..n).map(|_| std::array::from_fn(|_| 2.0 * numbers.uniform() - 1.0)).collect()
}

/// Particles under the Newtonian kernel, rounded to the scalar, with sums of them in double-double arithmetic.
struct Scene<T, const D: usize> {
    x: Vec<[T; D]>,
    m: Vec<T>,
    soft: Option<Soft>,
    want: Vec<twin::Sums>,
}

impl<T: Real, const D: usize> Scene<T, D> {
    fn new(x: &[[f64; D]], m: &[f64], soft: Option<Soft>) -> Self {
        let (x, m): (Vec<[T; D]>, Vec<T>) = (narrow(x), m.iter().map(|&m| T::from_f64(m)).collect());
        let soft = soft.map(|soft| Soft { delta: T::from_f64(soft.delta).to_f64(), ..soft });
        // In double-double arithmetic products of subnormal masses would be rounded, so sums are of masses near 1.
        let unit = 0.5_f64.powi(if m.iter().all(|m| m.abs() < T::MIN_POSITIVE) { T::MAX_EXPONENT - 1 } else { 0 });
        let wide_m: Vec<f64> = m.iter().map(|m| m.to_f64() / unit).collect();
        let wide_x = wide(&x);
        let sums = |target| {
            let mut sums = twin::newtonian(soft, &wide_x, &wide_m, target);
            let each = [&mut sums.potential, &mut sums.laplacian].into_iter().chain(&mut sums.gradient);
            each.for_each(|sum| (sum.0, sum.1) = (sum.0 * unit, sum.1 * unit));
            let sizes = [&mut sums.potential_size, &mut sums.laplacian_size, &mut sums.mass];
            sizes.into_iter().chain(&mut sums.gradient_size).for_each(|size| *size *= unit);
            sums
        };
        let want = wide_x.iter().map(sums).collect();
        Self { x, m, soft, want }
    }

    /// The sums at the particles.
    fn sums(&self, method: Option<Method>, (level, executor): (Level, &dyn Executor)) -> Sums<T, D> {
        let options = Options { method, ..Options::default() };
        let sources = (Sources::new(&self.x, &self.m), &self.x[..]);
        hessians::run(&kernel(1.0, self.soft), sources, field_bounds::ALL, &options, (level, executor))
    }

    /// Fails unless every result is within (c + 256 + n / 256) u S, the bound of the header with c = 24, which covers sorted sums. Results out of range are not compared. `more` is a
    /// multiple of that bound.
    fn check(&self, got: &Sums<T, D>, more: f64, what: &str) {
        let (largest, least) = (T::MAX.to_f64(), T::MIN_POSITIVE.to_f64());
        let bound = more * (24.0 + 256.0 + self.m.len() as f64 / 256.0) * 0.5 * T::EPSILON.to_f64();
        for (i, want) in self.want.iter().enumerate() {
            let near = |name: &str, got: T, want: f64, size: f64| {
                let (error, allowed) = ((got.to_f64() - want).abs(), bound * size + 64.0 * least);
                let in_range = size <= largest / 16.0;
                assert!(
                    !in_range || error <= allowed,
                    "{what}, {D}D, {:?}, {name} {i}: {got} for {want:e}, {} of the bound",
                    self.soft,
                    error / allowed
                );
            };
            // The logarithm's argument is rounded.
            let flat = if D == 2 { want.mass / (2.0 * std::f64::consts::PI) } else { 0.0 };
            near("potential", got.potential[i], want.potential.value(), want.potential_size + flat);
            near("Laplacian", got.laplacian[i], want.laplacian.value(), want.laplacian_size);
            for k in 0..D {
                near("gradient", got.gradient[i][k], want.gradient[k].value(), want.gradient_size[k]);
            }
        }
    }

    /// The same at every level of this machine, by all pairs and by what the plan chooses.
    fn check_everywhere(&self, what: &str) {
        for level in Level::available() {
            for method in [Some(Method::Direct), None] {
                let got = self.sums(method, (level, &Serial));
                self.check(&got, 1.0, &format!("{what}, {} {method:?}", level.name()));
            }
        }
    }

    /// sum m u / 2, and the same of magnitudes.
    fn energy(&self) -> [f64; 2] {
        self.m.iter().zip(&self.want).fold([0.0; 2], |[sum, size], (m, want)| {
            let m = m.to_f64();
            [sum + 0.5 * m * want.potential.value(), size + 0.5 * m.abs() * want.potential_size]
        })
    }
}

/// A run of the blob method whose steps are asked for one after the other.
struct Stepper<'k, T: Real, const D: usize> {
    kernel: &'k dyn Interaction<T, D>,
    plan: Plan,
    memory: Aligned,
    level: Level,
}

impl<'k, T: Real, const D: usize> Stepper<'k, T, D> {
    fn new(kernel: &'k dyn Interaction<T, D>, n: usize, wanted: Wanted, options: &field::Options) -> Self {
        let plan = aggregation::plan(kernel, n, 0, wanted, options).unwrap();
        let memory = Aligned::new(plan.workspace_bytes::<T, D>(1).unwrap());
        Self { kernel, plan, memory, level: Level::best() }
    }

    fn plain(kernel: &'k dyn Interaction<T, D>, n: usize) -> Self {
        Self::new(kernel, n, Wanted::default(), &Options::default())
    }

    fn step(&mut self, x: &mut [[T; D]], m: &[T], dt: T, steps: usize) -> (Result<()>, Report) {
        let particles = Trajectories { positions: x, ..Trajectories::none() };
        let state = State { masses: m, particles, tracers: Trajectories::none() };
        let advance = Advance { dt, steps, after_step: None };
        let (mut run, mut report) = (Run { level: self.level, ..Run::default() }, Report::default());
        let memory = self.memory.bytes();
        let result = aggregation::step(&self.plan, self.kernel, state, advance, memory, &mut run, &mut report);
        (result, report)
    }
}

/// sum m x, and the sum of its magnitudes.
fn first_moment<T: Real, const D: usize>(x: &[[T; D]], m: &[T]) -> ([f64; D], f64) {
    let (mut sum, mut size) = ([0.0; D], 0.0);
    for (x, m) in x.iter().zip(m) {
        for (sum, x) in sum.iter_mut().zip(x) {
            *sum += m.to_f64() * x.to_f64();
            size += (m.to_f64() * x.to_f64()).abs();
        }
    }
    (sum, size)
}
