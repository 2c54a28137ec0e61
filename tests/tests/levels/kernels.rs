//! The sums of every kernel, in one to three dimensions and both scalars, against a plain loop over the kernel's value at one distance.

use mollis_core::Real;
use mollis_core::exec::{Run, Statistics};
use mollis_core::field::{self, Accumulation, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;
use mollis_core::simd::Level;

use super::{Random, levels};

/// Memory at an aligned place.
fn aligned<R>(bytes: usize, body: impl FnOnce(&mut [u8]) -> R) -> R {
    let mut memory = vec![0xA5; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);
    body(&mut memory[start..start + bytes])
}

/// The gradient's components; potential and Laplacian. Each is a sum and the sum of its terms' sizes.
type Sums<const D: usize> = ([[f64; 2]; D], [[f64; 2]; 2]);

/// Sources, targets and the sums in double precision, each with the sum of the terms' sizes.
struct Twin<const D: usize> {
    positions: Vec<[f64; D]>,
    masses: Vec<f64>,
    targets: Vec<[f64; D]>,
    /// One a target.
    sums: Vec<Sums<D>>,
}

impl<const D: usize> Twin<D> {
    /// A loop over the kernel's functions at one distance.
    fn new(kernel: &Kernel<'_, f64, D>, delta: f64) -> Self {
        let mut random = Random::new(41);
        // More than a vector of targets, and sources on, near and far from them.
        let mut point = || std::array::from_fn::<f64, D, _>(|_| random.number());
        let targets: Vec<[f64; D]> = (0..35).map(|_| point()).collect();
        let mut positions: Vec<[f64; D]> = (0..23).map(|_| point()).collect();
        positions[..3].copy_from_slice(&targets[..3]);
        positions[3] = targets[3].map(|x| x + 2.0_f64.powi(-10));
        let masses: Vec<f64> = (0..positions.len()).map(|k| [1.0, -0.5, 0.75, 0.0][k % 4]).collect();
        // What a table of a smoothed kernel is accurate to: its size at delta and at the centre.
        let [edge, _, edge_laplacian] = if delta > 0.0 { kernel.at(delta) } else { [0.0; 3] };
        let centre = if delta > 0.0 { kernel.at(0.0)[2] } else { 0.0 };
        let sums = targets.iter().map(|target| {
            let (mut gradient, mut others) = ([[0.0; 2]; D], [[0.0; 2]; 2]);
            for (source, &mass) in positions.iter().zip(&masses) {
                let d: [f64; D] = std::array::from_fn(|k| target[k] - source[k]);
                let r = d.iter().map(|d| d * d).sum::<f64>().sqrt();
                if mass == 0.0 || r == 0.0 && delta == 0.0 {
                    continue;
                }
                let [value, factor, laplacian] = kernel.at(r);
                let add = |sum: &mut [f64; 2], term: f64, scale: f64| {
                    *sum = [sum[0] + mass * term, sum[1] + mass.abs() * scale];
                };
                add(&mut others[0], value, value.abs() + edge.abs() + 0.16);
                gradient.iter_mut().zip(d).for_each(|(sum, d)| add(sum, factor * d, factor.abs() * r));
                let scale = laplacian.abs() + edge_laplacian.abs() + centre.abs() + D as f64 * factor.abs();
                add(&mut others[1], laplacian, scale);
            }
            (gradient, others)
        });
        let sums = sums.collect();
        Self { positions, masses, targets, sums }
    }

    /// Compares the engine's sums.
    fn check<T: Real>(&self, kernel: &Kernel<'_, T, D>, level: Level, accumulation: Accumulation) {
        let points = |points: &[[f64; D]]| points.iter().map(|x| x.map(T::from_f64)).collect::<Vec<_>>();
        let (positions, targets) = (points(&self.positions), points(&self.targets));
        let masses: Vec<T> = self.masses.iter().map(|&m| T::from_f64(m)).collect();
        let n = targets.len();
        let (mut potential, mut gradient, mut laplacian) = (vec![T::NAN; n], vec![[T::NAN; D]; n], vec![T::NAN; n]);
        let wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
        let options = Options { accumulation, method: Some(Method::Direct), ..Options::default() };
        let plan = field::plan(kernel, positions.len(), n, wanted, &options).unwrap();
        let mut statistics = Statistics::default();
        aligned(plan.workspace_bytes(1).unwrap(), |workspace| {
            let outputs = Outputs {
                potential: Some(&mut potential),
                gradient: Some(&mut gradient),
                laplacian: Some(&mut laplacian),
                hessian: None,
            };
            let mut run = Run { level, counters: Some(&mut statistics), ..Run::default() };
            let sources = Sources::new(&positions, &masses);
            field::evaluate(&plan, kernel, sources, &targets, outputs, workspace, &mut run).unwrap();
        });
        let massive = self.masses.iter().filter(|&&m| m != 0.0).count();
        assert_eq!(statistics.pairs, (n * massive) as u64);
        let u = T::EPSILON.to_f64() / 2.0;
        for (i, (of_gradient, others)) in self.sums.iter().enumerate() {
            let check = |name: &str, got: T, [want, scale]: [f64; 2], more: f64| {
                // The terms' c and the additions.
                let bound = (112.0 + 23.0) * u + more;
                let error = (got.to_f64() - want).abs() / scale;
                assert!(
                    error <= bound,
                    "{} {D}D {name} of {i}: {:e}, not {want:e}: {error:e}",
                    level.name(),
                    got.to_f64()
                );
            };
            check("potential", potential[i], others[0], 0.0);
            gradient[i].iter().zip(of_gradient).for_each(|(&got, &want)| check("gradient", got, want, 0.0));
            check("laplacian", laplacian[i], others[1], if T::DIGITS > 24 { 1e-13 } else { 0.0 });
        }
    }
}

/// The sums of one kernel at all levels, in both scalars.
fn kernel_sums<const D: usize>(terms: &[Term], mollifier: Mollifier, delta: f64) {
    println!("{D}D {terms:?} {mollifier:?} {delta}");
    let both = [Accumulation::Blocked, Accumulation::Compensated];
    aligned(Kernel::<f64, D>::workspace_bytes(terms, mollifier).unwrap(), |memory| {
        let kernel = Kernel::<f64, D>::prepare(memory, terms, mollifier, delta).unwrap();
        let twin = Twin::new(&kernel, delta);
        aligned(Kernel::<f32, D>::workspace_bytes(terms, mollifier).unwrap(), |memory| {
            let single = Kernel::<f32, D>::prepare(memory, terms, mollifier, delta as f32).unwrap();
            for level in levels() {
                both.iter().for_each(|&accumulation| twin.check(&kernel, level, accumulation));
                both.iter().for_each(|&accumulation| twin.check(&single, level, accumulation));
            }
        });
    });
}

/// With `MOLLIS_THIN` set, kernels that are fitted are taken in the plane alone: an emulator is slow.
#[test]
fn sums_of_every_kernel() {
    let thin = std::env::var_os("MOLLIS_THIN").is_some();
    let term = |law, coefficient| Term { law, coefficient };
    let power = |exponent| term(Law::Power { exponent }, 1.0);
    let newtonian = term(Law::Newtonian, -1.0);
    let fitted = [
        vec![power(1.5)],
        vec![power(4.0), term(Law::Newtonian, 0.5)],
        vec![term(Law::Exponential { length: 0.4 }, 2.0), term(Law::Exponential { length: 0.7 }, -1.0)],
        vec![term(Law::Screened { k: 2.0 }, 1.0)],
    ];
    // Lengths that are the same in both scalars.
    let mollifiers = [
        (Mollifier::Compact { order: 4, exponent: 5 }, 0.375),
        (Mollifier::None, 0.0),
        (Mollifier::Gaussian { order: 4 }, 0.1875),
        (Mollifier::Compact { order: 2, exponent: 3 }, 0.375),
        (Mollifier::Compact { order: 2, exponent: 4 }, 4.0),
    ];
    for (mollifier, delta) in mollifiers {
        kernel_sums::<1>(&[newtonian], mollifier, delta);
        kernel_sums::<2>(&[newtonian], mollifier, delta);
        if !matches!(mollifier, Mollifier::Gaussian { .. }) {
            kernel_sums::<3>(&[newtonian], mollifier, delta);
        }
    }
    for (mollifier, delta) in mollifiers.into_iter().take(if thin { 2 } else { 5 }) {
        for terms in &fitted {
            kernel_sums::<2>(terms, mollifier, delta);
            if !thin {
                kernel_sums::<1>(terms, mollifier, delta);
                if !matches!(mollifier, Mollifier::Gaussian { .. }) {
                    kernel_sums::<3>(terms, mollifier, delta);
                }
            }
        }
    }
}
