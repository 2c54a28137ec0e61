//! One solution: particles on a lattice, advanced by the library, and what is measured of it.

use anyhow::Result;
use mollis_core::aggregation::{self, Advance, Report, State, Trajectories, Wanted};
use mollis_core::diagnostics;
use mollis_core::exec::Run;
use mollis_core::field::{self, Options, Outputs, Sources};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::{Error, Real};
use mollis_host::memory::Memory;

/// Memory for a kernel sum.
pub fn kernel_memory<T: Real, const D: usize>(terms: &[Term], mollifier: Mollifier) -> Result<Memory> {
    Ok(Memory::new(Kernel::<T, D>::workspace_bytes(terms, mollifier)?))
}

/// One term of a kernel sum.
pub fn term(coefficient: f64, law: Law) -> Term {
    Term { law, coefficient }
}

/// |x|^p / p.
pub fn power(coefficient: f64, exponent: f64) -> Term {
    term(coefficient, Law::Power { exponent })
}

/// Particles with what moves along.
#[derive(Clone, Debug)]
pub struct Cloud<T, const D: usize> {
    /// Positions.
    pub x: Vec<[T; D]>,
    /// Masses.
    pub m: Vec<T>,
    /// Densities.
    pub rho: Vec<T>,
}

impl<T: Real, const D: usize> Cloud<T, D> {
    /// The points of `h Z^D` where `density(|x|)` is some number, with mass density times h^D.
    pub fn on_lattice(h: f64, density: impl Fn(f64) -> Option<f64>) -> Self {
        let reach = (1.0 / h).ceil() as i32 + 1;
        let side = (2 * reach + 1) as usize;
        let (mut x, mut m, mut rho) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..side.pow(D as u32) {
            let point: [f64; D] =
                std::array::from_fn(|k| h * f64::from((index / side.pow(k as u32) % side) as i32 - reach));
            let r = point.iter().map(|c| c * c).sum::<f64>().sqrt();
            if let Some(value) = density(r) {
                x.push(point.map(T::from_f64));
                m.push(T::from_f64(value * h.powi(D as i32)));
                rho.push(T::from_f64(value));
            }
        }
        Self { x, m, rho }
    }

    /// Advances by `steps` steps; densities and the watch of the energy as asked.
    pub fn advance(
        &mut self,
        kernel: &Kernel<'_, T, D>,
        dt: f64,
        steps: usize,
        density: bool,
        energy: bool,
    ) -> (Result<(), Error>, Report) {
        let mut report = Report::default();
        let wanted = Wanted { density, energy, ..Wanted::default() };
        let mut attempt = || {
            let plan = aggregation::plan(kernel, self.x.len(), 0, wanted, &Options::default())?;
            let mut memory = Memory::new(plan.workspace_bytes::<T, D>(1)?);
            let particles = Trajectories {
                positions: &mut self.x,
                density: density.then_some(&mut self.rho[..]),
                velocity: None,
                divergence: None,
            };
            let state = State { masses: &self.m, particles, tracers: Trajectories::none() };
            let advance = Advance { dt: T::from_f64(dt), steps, after_step: None };
            aggregation::step(&plan, kernel, state, advance, memory.slice(), &mut Run::default(), &mut report)
        };
        let result = attempt();
        (result, report)
    }

    /// The density as the sum of blobs at the particles, which is the Laplacian of the mollified Newtonian kernel.
    pub fn blob_density(&self, mollifier: Mollifier, delta: T) -> Result<Vec<T>> {
        let kernel = Kernel::<T, D>::newtonian(T::ONE, mollifier, delta)?;
        let wanted = field::Wanted { laplacian: true, ..field::Wanted::default() };
        let plan = field::plan(&kernel, self.x.len(), self.x.len(), wanted, &Options::default())?;
        let mut memory = Memory::new(plan.workspace_bytes(1)?);
        let mut density = vec![T::ZERO; self.x.len()];
        let outputs = Outputs { laplacian: Some(&mut density[..]), ..Outputs::default() };
        let sources = Sources::new(&self.x, &self.m);
        field::evaluate(&plan, &kernel, sources, &self.x, outputs, memory.slice(), &mut Run::default())?;
        Ok(density)
    }

    /// Makes the total mass 1.
    pub fn normalise(&mut self) {
        let total = self.m.iter().map(|m| m.to_f64()).sum::<f64>();
        for v in self.m.iter_mut().chain(&mut self.rho) {
            *v = T::from_f64(v.to_f64() / total);
        }
    }

    /// Distances from the centre of mass.
    pub fn radii(&self) -> Result<Vec<f64>> {
        let centre = diagnostics::moments(&self.x, &self.m)?.centre;
        let apart = |x: &[T; D]| x.iter().zip(&centre).map(|(a, c)| (a.to_f64() - c.to_f64()).powi(2)).sum::<f64>();
        Ok(self.x.iter().map(|x| apart(x).sqrt()).collect())
    }
}
