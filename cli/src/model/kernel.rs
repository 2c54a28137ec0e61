//! From a scene's terms to a prepared kernel.

use anyhow::{Context, Result};
use mollis_core::aggregation::Diffusion;
use mollis_core::exec::{Executor, Run};
use mollis_core::field::{self, Interaction, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::{Kernel, Law as CoreLaw, Term as CoreTerm};
use mollis_core::mollifier::Mollifier;
use mollis_host::memory::Memory;

use crate::scene::{Law, Scene, Softening};

/// The mollifier of a scene.
pub fn mollifier(softening: Option<&Softening>) -> Mollifier {
    softening.map_or(Mollifier::None, |softening| softening.mollifier)
}

/// The diffusion of a scene on a grid of spacing `h`.
pub fn diffusion(scene: &Scene, h: Option<f64>) -> Option<Diffusion> {
    scene.diffusion.map(|diffusion| Diffusion {
        exponent: diffusion.exponent,
        coefficient: diffusion.coefficient,
        mollifier: mollifier(Some(&diffusion.mollifier)),
        length: diffusion.mollifier.delta(h),
    })
}

/// Prepares the kernel of a scene on a grid of spacing `h` and passes it on.
pub fn with<const D: usize, R>(
    scene: &Scene,
    h: Option<f64>,
    then: impl FnOnce(&dyn Interaction<f64, D>) -> Result<R>,
) -> Result<R> {
    let terms: Vec<CoreTerm> = scene
        .kernel
        .iter()
        .map(|term| CoreTerm {
            law: match term.law {
                Law::Newtonian => CoreLaw::Newtonian,
                Law::Power(exponent) => CoreLaw::Power { exponent },
                Law::Exponential(length) => CoreLaw::Exponential { length },
                Law::Screened(k) => CoreLaw::Screened { k },
            },
            coefficient: term.coefficient,
        })
        .collect();
    let mollifier = mollifier(scene.mollifier.as_ref());
    let delta = scene.mollifier.map_or(1.0, |softening| softening.delta(h));
    let bytes = Kernel::<f64, D>::workspace_bytes(&terms, mollifier).context("kernel")?;
    let mut memory = Memory::new(bytes);
    let kernel = Kernel::<f64, D>::prepare(memory.slice(), &terms, mollifier, delta).context("kernel")?;
    then(&kernel)
}

/// The density at `targets` as the sum of a scene's blobs, sum_j m_j psi_delta(x - x_j): the Laplacian of the attractive
/// Newtonian kernel with the scene's mollifier is the mollifier itself.
pub fn density<const D: usize>(
    scene: &Scene,
    h: Option<f64>,
    sources: Sources<'_, f64, D>,
    targets: &[[f64; D]],
    executor: &dyn Executor,
) -> Result<Vec<f64>> {
    let delta = scene.mollifier.map_or(1.0, |softening| softening.delta(h));
    let kernel = Kernel::<f64, D>::newtonian(1.0, mollifier(scene.mollifier.as_ref()), delta).context("mollifier")?;
    let wanted = Wanted { laplacian: true, ..Wanted::default() };
    let plan = field::plan(&kernel, sources.positions.len(), targets.len(), wanted, &Options::default())?;
    let mut memory = Memory::new(plan.workspace_bytes(executor.workers())?);
    let mut values = vec![0.0; targets.len()];
    let outputs = Outputs { laplacian: Some(&mut values), ..Outputs::default() };
    let mut run = Run { executor, ..Run::default() };
    field::evaluate(&plan, &kernel, sources, targets, outputs, memory.slice(), &mut run)?;
    Ok(values)
}
