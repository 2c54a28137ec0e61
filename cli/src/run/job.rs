//! The runs that a scene asks for.

use anyhow::{Result, bail};
use mollis_host::pool::Pool;

use crate::model::{Simulation, blob, cluster, kernel, pks};
use crate::particles::Particles;
use crate::scene::{Model, Sampling, Scene, SceneFile};

/// What a run of a case is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// The case itself.
    Whole,
    /// One grid of a study, of this spacing.
    Study(f64),
    /// The grid that those of a study are compared with, of this spacing.
    Reference(f64),
}

/// One run of a case.
pub struct Job<'a> {
    /// The case.
    pub scene: &'a Scene,
    /// What it is for.
    pub role: Role,
}

impl Job<'_> {
    /// The spacing of its grid.
    pub fn h(&self) -> Option<f64> {
        match (self.role, self.scene.sampling) {
            (Role::Study(h) | Role::Reference(h), _) | (Role::Whole, Some(Sampling::Grid { h })) => Some(h),
            _ => None,
        }
    }

    /// The case and the spacing, for people.
    pub fn label(&self) -> String {
        let h = match self.role {
            Role::Whole => String::new(),
            Role::Study(h) => format!("h = {h:.4}"),
            Role::Reference(h) => format!("reference, h = {h:.4}"),
        };
        [self.scene.name.as_str(), &h].iter().filter(|text| !text.is_empty()).copied().collect::<Vec<_>>().join(", ")
    }
}

/// The runs of a scene, in order.
pub fn jobs(file: &SceneFile) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for scene in &file.cases {
        match &scene.study {
            None => jobs.push(Job { scene, role: Role::Whole }),
            Some(study) => {
                jobs.extend(study.reference.map(|h| Job { scene, role: Role::Reference(h) }));
                jobs.extend(study.h.iter().map(|&h| Job { scene, role: Role::Study(h) }));
            }
        }
    }
    jobs
}

/// Makes a job's simulation and passes it on.
pub fn build<R>(
    job: &Job<'_>,
    start: Particles,
    pool: &Pool,
    then: impl FnOnce(&mut dyn Simulation) -> Result<R>,
) -> Result<R> {
    match (job.scene.model, job.scene.dimension) {
        (Model::Blob | Model::Particle, 1) => flow::<1, R>(job, start, pool, then),
        (Model::Blob | Model::Particle, 2) => flow::<2, R>(job, start, pool, then),
        (Model::Blob | Model::Particle, _) => flow::<3, R>(job, start, pool, then),
        (Model::Pks, _) => then(&mut pks::Coalescing::new(job.scene, start, pool)?),
        (Model::Cluster, _) => then(&mut cluster::Cluster::new(job.scene, &start)?),
        (Model::Profile, _) => bail!("a profile has nothing that moves"),
    }
}

fn flow<const D: usize, R>(
    job: &Job<'_>,
    start: Particles,
    pool: &Pool,
    then: impl FnOnce(&mut dyn Simulation) -> Result<R>,
) -> Result<R> {
    kernel::with::<D, R>(job.scene, job.h(), |kernel| {
        then(&mut blob::Flow::<D>::new(job.scene, start, job.h(), kernel, pool)?)
    })
}
