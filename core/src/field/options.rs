//! What a caller asks for beyond the outputs, and the methods there are.

/// How terms are added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accumulation {
    /// In blocks of sources: the error grows with the block length and the number of blocks, not with their product.
    #[default]
    Blocked,
    /// Each addition's error is carried along: for diagnostics, at about twice the cost.
    Compensated,
}

/// The core radius of a pair, where sources have core radii ([`super::Sources::radii`]). All but the first depend on source and target in the same way, so that the forces between two
/// particles are equal and opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PairRadius {
    /// The source's.
    #[default]
    Source,
    /// The larger one of the source's and the target's.
    Maximum,
    /// Their mean.
    Mean,
    /// The root of the mean of their squares.
    RootMeanSquare,
}

/// What a caller asks for beyond the outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How terms are added up.
    pub accumulation: Accumulation,
    /// In two dimensions the gradient output is `a grad u + b (grad u rotated by +90 degrees)`: `(1, 0)` is the
    /// gradient, `(0, 1)` its rotation (vortex flow). Other dimensions take `(1, 0)` only. The blob method moves particles by minus
    /// this output, so there vortices have `(0, -1)`.
    pub combination: (f64, f64),
    /// Error allowed to [`Method::Fmm`] and [`Method::Tree`], in the l2 norm over targets relative to that of `sum_j |m_j| |K_j|`, for each output; masses of one sign: relative to the output
    /// itself. From 1e-13 on (in space and the tree: 1e-12; f32: 1e-5) the plan may choose these methods; below, 0 included, only rounding is allowed. Not negative.
    pub tolerance: f64,
    /// Forces a method; `None` lets the plan choose.
    pub method: Option<Method>,
    /// Whether sources come with core radii of their own ([`super::Sources::radii`]).
    pub radii: bool,
    /// What core radius a pair has. But for [`PairRadius::Source`] the targets need radii too ([`super::Sources::target_radii`]).
    pub pair_radius: PairRadius,
    /// Whether sources have vector strengths instead of masses ([`super::Sources::strengths`]).
    pub strengths: bool,
}

impl Options {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        accumulation: Accumulation::Blocked,
        combination: (1.0, 0.0),
        tolerance: 0.0,
        method: None,
        radii: false,
        pair_radius: PairRadius::Source,
        strengths: false,
    };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How the sum is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// All pairs.
    Direct,
    /// No pair: the field is a polynomial of the target's position, from moments of the sources.
    Moments,
    /// One dimension: one sort, then running moments from either side; pairs within the mollifier's reach one by one. All masses have one unit:
    /// those below 2^-126 (f64: 2^-1022) of the largest lose digits, and count as zero in the end.
    Sorted,
    /// Pairs closer than delta alone; of Gaussian blobs ([`super::Density`]) than 6.3 times the largest width (f32: 4.5), where they are below e^-40 (e^-20) of their largest value.
    Neighbours,
    /// Even powers from moments; the other terms over all pairs.
    Split,
    /// Newtonian kernels in the plane and in space, without a mollifier or with a compact or Gaussian one or a combination: the fast multipole method, to [`Options::tolerance`] (forced with less than
    /// its least one: to that). Second derivatives and core radii of pairs in the plane alone. Masses below 2^-1022 of the largest (f32: 2^-126) count as zero in the end.
    Fmm,
    /// Any kernel that is smooth away from zero, in one, two and three dimensions: cells, and interpolation of the kernel between those that are not adjacent, to
    /// [`Options::tolerance`] (forced with less than its least one: to that). Masses below 2^-1022 of the largest (f32: 2^-126) count as zero in the end.
    Tree,
}

/// Why a method was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Reason {
    /// The caller forced it.
    Forced,
    /// Every term is an even power.
    EvenPowers,
    /// In one dimension every term is a polynomial of the distance beyond the mollifier's reach.
    OneDimension,
    /// Only the Laplacian of a Newtonian kernel is wanted, which is the mollifier, of compact support.
    CompactLaplacian,
    /// The kernel itself is a mollifier, and zero or below rounding beyond some lengths ([`super::Density`]).
    ShortRange,
    /// Some terms are even powers.
    SomeEvenPowers,
    /// The tolerance and the number of particles are large enough.
    Tolerance,
    /// No faster method serves this kernel and size.
    NothingFaster,
}
