//! A scene after reading: typed, checked, defaults filled in.

use std::path::PathBuf;

use mollis_core::mollifier::Mollifier;

/// A scene file: one run or several that are compared.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Its text, which identifies a checkpoint.
    pub text: String,
    /// Above the gallery entry.
    pub title: String,
    /// Paper and figure.
    pub source: String,
    /// For the gallery.
    pub note: String,
    /// The runs; one with an empty name unless the file states cases.
    pub cases: Vec<Scene>,
    /// The pictures.
    pub pictures: Vec<Picture>,
    /// The numbers to be met.
    pub expectations: Vec<Expectation>,
}

/// One run (or, with a study, one a grid spacing).
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The case's name; empty for a scene without cases.
    pub name: String,
    /// The folder of its data, where there are several cases.
    pub folder: String,
    /// What moves.
    pub model: Model,
    /// Dimensions of space.
    pub dimension: usize,
    /// Of all random numbers.
    pub seed: u64,
    /// Terms of the kernel.
    pub kernel: Vec<Term>,
    /// (a, b): the velocity is -(a + b J) grad u, J the turn by +90 degrees.
    pub combination: [f64; 2],
    /// Diffusion besides.
    pub diffusion: Option<Diffusion>,
    /// What it is softened with; absent for the particle method.
    pub mollifier: Option<Softening>,
    /// Parts of the initial data.
    pub initial: Vec<Part>,
    /// How densities become particles.
    pub sampling: Option<Sampling>,
    /// When the run stops; 0 for a profile.
    pub end: f64,
    /// Step.
    pub dt: f64,
    /// Steps to the end.
    pub steps: u64,
    /// Only direct sums.
    pub direct: bool,
    /// Of fast sums.
    pub tolerance: f64,
    /// Patlak-Keller-Segel parameters.
    pub pks: Option<Pks>,
    /// Repeat on these grids.
    pub study: Option<Study>,
    /// What is recorded.
    pub output: Output,
}

/// What moves, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Aggregation equation, mollified kernel.
    Blob,
    /// The same without mollifier.
    Particle,
    /// Coalescing Patlak-Keller-Segel particles.
    Pks,
    /// Three particles: the second moment of the first two and its approximations.
    Cluster,
    /// Curves of a mollifier.
    Profile,
}

/// A term of the kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Its law.
    pub law: Law,
    /// Its factor.
    pub coefficient: f64,
}

/// A kernel's law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Laplacian = +Dirac.
    Newtonian,
    /// |x|^p / p.
    Power(f64),
    /// e^(-|x| / length).
    Exponential(f64),
    /// (Laplacian - k^2) K = Dirac.
    Screened(f64),
}

/// A mollifier and how its length follows from the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softening {
    /// The mollifier.
    pub mollifier: Mollifier,
    /// Its length, if stated.
    pub delta: Option<f64>,
    /// delta = scale h^power otherwise.
    pub scale: f64,
    /// See `scale`.
    pub power: f64,
}

impl Softening {
    /// The length on a grid of spacing `h`.
    pub fn delta(&self, h: Option<f64>) -> f64 {
        self.delta.unwrap_or_else(|| self.scale * h.unwrap_or(f64::NAN).powf(self.power))
    }
}

/// rho_t = nu Laplacian(rho^m) by blobs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffusion {
    /// nu.
    pub coefficient: f64,
    /// m.
    pub exponent: f64,
    /// The blobs.
    pub mollifier: Softening,
}

/// A part of the initial data.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its shape.
    pub shape: Shape,
    /// Half widths along the axes.
    pub axes: Vec<f64>,
    /// Its centre.
    pub center: Vec<f64>,
    /// Factor of the density.
    pub height: f64,
    /// Total mass, which replaces the height.
    pub mass: Option<f64>,
    /// Share of the particles under random sampling.
    pub share: Option<f64>,
    /// As a species of its own.
    pub diffusivity: Option<f64>,
    /// In units of chi.
    pub sensitivity: Option<f64>,
}

/// A part's shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// (1 - s)^k.
    Polynomial(u32),
    /// e^(1/(s - 1)).
    Bump,
    /// 1: disc and ellipse.
    Flat,
    /// 1 for r < (sin^2(5 theta/2) + 1/2)/4: Craig & Bertozzi (4.6).
    Star,
    /// Given points and masses.
    Points(Vec<Vec<f64>>, Vec<f64>),
    /// Points and masses of a file, and whether it holds densities.
    File(PathBuf, bool),
}

/// How densities become particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// The grid h Z^d.
    Grid {
        /// Spacing.
        h: f64,
    },
    /// Rejection.
    Random {
        /// Particles.
        count: u64,
    },
}

/// Patlak-Keller-Segel parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pks {
    /// Chemosensitivity.
    pub chi: f64,
    /// Diffusivity.
    pub mu: f64,
    /// Mesh cells.
    pub mesh: [usize; 2],
    /// The mesh along x.
    pub x: [f64; 2],
    /// The mesh along y.
    pub y: [f64; 2],
    /// Second moments in the field on the mesh's border.
    pub quadrupole: bool,
    /// The mesh's scheme of fourth order.
    pub fourth: bool,
    /// Least mass of particles that act pair by pair, in critical masses.
    pub heavy: Option<f64>,
    /// The printed increment test instead of the exact law.
    pub printed: bool,
    /// Only clusters of index at most -1 merge.
    pub hard: bool,
    /// Root cells of the cluster search.
    pub cell: f64,
    /// eta of (3.1).
    pub separation: f64,
    /// Least probability of a collision that is looked at.
    pub probability: f64,
}

/// Repetition on finer and finer grids.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Spacings.
    pub h: Vec<f64>,
    /// Spacing of the reference run; otherwise the exact solution.
    pub reference: Option<f64>,
}

/// What is recorded and written.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Steps between rows of diagnostics.
    pub every: u64,
    /// Particles followed.
    pub trajectories: usize,
    /// Steps at which all particles are kept.
    pub snapshots: Vec<u64>,
    /// Formats of the final particles.
    pub particles: Vec<String>,
    /// Carry the density along trajectories.
    pub density: bool,
    /// The regularised energy.
    pub energy: bool,
    /// Coalescences.
    pub events: bool,
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// File name without ending.
    pub name: String,
    /// trajectories, density, ...
    pub kind: String,
    /// Above it.
    pub title: String,
    /// Only this case.
    pub case: Option<String>,
    /// Horizontal range.
    pub x: Option<[f64; 2]>,
    /// Vertical range.
    pub y: Option<[f64; 2]>,
    /// The exact solution beneath.
    pub exact: bool,
    /// xt, xy or xyt.
    pub plane: Option<String>,
    /// Which snapshots; all if empty.
    pub times: Vec<f64>,
    /// Which error or curve.
    pub quantity: String,
    /// Slopes drawn for comparison.
    pub rates: Vec<f64>,
    /// One curve a part.
    pub parts: bool,
    /// Predicted slopes.
    pub slopes: Vec<Slope>,
}

/// A predicted slope.
#[derive(Clone, Debug, PartialEq)]
pub struct Slope {
    /// The slope.
    pub value: f64,
    /// It goes through the curve here.
    pub at: f64,
    /// In the legend.
    pub label: String,
}

/// A number to be met.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// Which number.
    pub quantity: String,
    /// Of which case.
    pub case: Option<String>,
    /// Spacing or time.
    pub at: Option<f64>,
    /// Start of an interval.
    pub from: Option<f64>,
    /// End of an interval.
    pub to: Option<f64>,
    /// Part of the initial data.
    pub part: usize,
    /// What it should be.
    pub value: Option<f64>,
    /// Lower bound.
    pub least: f64,
    /// Upper bound.
    pub most: f64,
    /// What the paper states.
    pub paper: String,
    /// Why.
    pub reason: String,
}
