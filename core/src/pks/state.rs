//! What a run consists of: the host's arrays, two small plain structures, options, and what a step reports.

use super::collision::{CollisionLaw, Merging};
use super::search::Search;
use super::theory::GAMMA;
use crate::build;
use crate::error::{Error, Result};
use crate::euler_maruyama::Control;
use crate::real::Real;

/// The particles: the host's arrays, of which the first [`Counters::count`] elements are alive.
///
/// Together with [`Counters`] and the generator's state this is the complete state of a run: restored from a copy, it continues bit for bit.
#[derive(Debug)]
pub struct State<'a, T> {
    /// Positions.
    pub positions: &'a mut [[T; 2]],
    /// Masses, positive.
    pub masses: &'a mut [T],
    /// Identities, all different: a counter-based generator gives each its own stream, and merging keeps the lowest.
    pub labels: &'a mut [u64],
    /// Anything that should travel with the particles, such as their species; a merged particle keeps its lowest label's.
    pub species: Option<&'a mut [u32]>,
    /// Weights `w_i = m_i / chi_i`, positive, for particles of different sensitivities: chi_i is that of particle i in units of [`Options::chi`], and `m_i` is what it attracts others by.
    /// It drifts by `chi_i` times the attraction and diffuses with `noise / w_i`. A merged particle has the sum of masses, the sum of weights, and is at the centre of the weights.
    /// `None`: every chi_i is 1, so weights are masses, and nothing is computed for them.
    pub weights: Option<&'a mut [T]>,
}

/// Time, and what a step counts. A plain structure of the host's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Counters {
    /// The time reached.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Particles alive.
    pub count: u64,
    /// Merges of the current step that wait for room in the event buffer; 0 between steps.
    pub pending: u64,
}

/// One merge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Event {
    /// When it happened, inside the step.
    pub time: f64,
    /// The label of the merged particle: the lowest.
    pub label: u64,
    /// The mass of the merged particle: `hi` of the running sum [`DoubleWord::plus`](crate::real::DoubleWord::plus) in the run's scalar,
    /// which starts with the kept particle's mass and adds the absorbed ones' in the order of their labels. It is the exact sum rounded once
    /// (to `u + 2 n u^2` for n particles, u being half of [`EPSILON`](crate::Scalar::EPSILON)); what a merge rounds off is lost, so a particle lighter than
    /// u times the kept one may add nothing.
    pub mass: f64,
    /// The index nu of the cluster; -inf without noise.
    pub index: f64,
    /// Where its absorbed labels begin in the label buffer.
    pub first: u64,
    /// How many labels were absorbed, at least 1; ascending.
    pub absorbed: u64,
}

/// Where events go: buffers of the host's, appended to. The host empties them by setting the two lengths to zero.
#[derive(Debug)]
pub struct Events<'a> {
    /// The events.
    pub events: &'a mut [Event],
    /// The labels absorbed, event by event.
    pub labels: &'a mut [u64],
    /// Events written so far.
    pub written: &'a mut usize,
    /// Labels written so far.
    pub labels_written: &'a mut usize,
}

/// How a step moves the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Scheme {
    /// Adaptive Euler-Maruyama sub-steps.
    #[default]
    EulerMaruyama,
    /// One step of classical RK4 for the drift between two half steps of the noise (Strang). Fixed: [`Options::control`] is not used.
    /// Without noise it is the blob method's step.
    StrangRk4,
}

/// What a run is made with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<T> {
    /// chi of (1.3), any sign; 0 solves no field.
    pub chi: T,
    /// mu with a tilde of (1.3), at least 0: a particle of mass m diffuses with `noise / m`, one of weight w with `noise / w`. 0 draws no random number.
    pub noise: T,
    /// V is `gamma log r` near zero: 1 / (2 pi) for (1.4a) and (1.4b).
    pub gamma: T,
    /// Sub-steps.
    pub control: Control<T>,
    /// How particles are moved.
    pub scheme: Scheme,
    /// How clusters are found.
    pub search: Search<T>,
    /// p of (3.2): clusters that collide with a smaller probability are left alone.
    pub probability: T,
    /// How collisions are decided.
    pub law: CollisionLaw,
    /// Which collisions merge.
    pub merging: Merging,
}

impl<T: Real> Options<T> {
    /// The paper's constants (eta = 0.1, a 1 x 1 mesh), p = 1e-4, the exact law, at most 100,000 sub-steps and no limit on the jump.
    #[must_use]
    pub fn new(chi: T, noise: T) -> Self {
        Self {
            chi,
            noise,
            gamma: T::from_f64(GAMMA),
            control: Control { width: T::INFINITY, at_least: 1, at_most: 100_000 },
            scheme: Scheme::EulerMaruyama,
            search: Search::default(),
            probability: T::from_f64(1e-4),
            law: CollisionLaw::Exact,
            merging: Merging::All,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::NotFinite`]: chi, noise or gamma. [`Error::OutOfDomain`]: noise < 0, width not positive, eta or p outside (0, 1), a mesh
    /// without cells or with more than 65,536 a side, a domain that is empty or not finite, no sub-step allowed.
    /// [`Error::Unsupported`], with the feature `small`: no noise, the printed law, the scheme of Strang.
    pub fn check(&self) -> Result<()> {
        if !(self.chi.is_finite() && self.noise.is_finite() && self.gamma.is_finite()) {
            return Err(Error::NotFinite);
        }
        let within = |v: T| v > T::ZERO && v < T::ONE;
        let domain = self
            .search
            .domain
            .is_none_or(|[low, high]| low.iter().zip(&high).all(|(l, h)| l.is_finite() && h.is_finite() && l < h));
        let fine = self.noise >= T::ZERO
            && self.control.width > T::ZERO
            && self.control.at_most > 0
            && self.control.at_least <= self.control.at_most
            && within(self.search.separation)
            && within(self.probability)
            && self.search.mesh.iter().all(|&n| n > 0 && n <= 1 << 16)
            && domain;
        if !fine {
            return Err(Error::OutOfDomain);
        }
        let absent = !build::NOISELESS && self.noise == T::ZERO
            || !build::PRINTED_LAW && self.law == CollisionLaw::Printed
            || !build::STRANG && self.scheme == Scheme::StrangRk4;
        if absent { Err(Error::Unsupported) } else { Ok(()) }
    }
}

/// What steps did; added to by every call. What was skipped is zero here: tests count it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Report {
    /// Sub-steps of single particles.
    pub substeps: u64,
    /// Pairs of normals drawn.
    pub normals: u64,
    /// Fields solved or summed.
    pub fields: u64,
    /// Cluster searches made.
    pub searches: u64,
    /// Clusters that were decided.
    pub clusters: u64,
    /// Merges.
    pub merges: u64,
    /// Particles that ended in another one.
    pub absorbed: u64,
}

impl Report {
    /// Adds this to the caller's, if there is one.
    #[inline(always)]
    pub(super) fn add_to(self, report: &mut Option<&mut Self>) {
        if build::REPORTS
            && let Some(report) = report
        {
            report.substeps += self.substeps;
            report.normals += self.normals;
            report.fields += self.fields;
            report.searches += self.searches;
            report.clusters += self.clusters;
            report.merges += self.merges;
            report.absorbed += self.absorbed;
        }
    }
}
