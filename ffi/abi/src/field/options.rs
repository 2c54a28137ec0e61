//! Options and counters of a field sum.

use mollis_core::field::{self, Accumulation, Method, PairRadius};
use mollis_core::memory::Plain;
use mollis_core::{Error, Result};

use crate::options;
use crate::status::{mollis_status, status};

/// The plan chooses.
pub const MOLLIS_METHOD_AUTO: i32 = 0;
/// All pairs.
pub const MOLLIS_METHOD_DIRECT: i32 = 1;
/// No pair: moments of the sources (even powers).
pub const MOLLIS_METHOD_MOMENTS: i32 = 2;
/// One dimension: one sort. All masses have one unit: those below 2^-126 (double: 2^-1022) of the largest lose digits, and count as zero in the end.
pub const MOLLIS_METHOD_SORTED: i32 = 3;
/// Pairs closer than delta alone (the Laplacian of a Newtonian kernel).
pub const MOLLIS_METHOD_NEIGHBOURS: i32 = 4;
/// Even powers from moments, the other terms over all pairs.
pub const MOLLIS_METHOD_SPLIT: i32 = 5;
/// Newtonian kernels in the plane and in space, without a mollifier or with a compact or Gaussian one: the fast multipole method, to the tolerance (at least 1e-13, in space 1e-12, single precision 1e-5). In
/// space potentials, gradients, Laplacians; vector strengths; core radii of sources, where cells are no narrower than the largest core. Masses
/// below 2^-1022 of the largest (single precision: 2^-126) count as zero in the end.
pub const MOLLIS_METHOD_FMM: i32 = 6;
/// Any kernel that is smooth away from zero, in one, two and three dimensions: cells, and the kernel interpolated between those that do not touch, to the tolerance (at least 1e-12,
/// single precision 1e-5). Potentials and gradients, and Laplacians of Newtonian kernels; vector strengths; core radii of sources under compact and Gaussian mollifiers, where cells are no narrower than the largest core. Where a kernel cannot be interpolated, as about
/// an edge of it, pairs are summed one by one. Masses below 2^-1022 of the largest (single precision: 2^-126) count as zero in the end.
pub const MOLLIS_METHOD_TREE: i32 = 7;

/// Terms are added up in blocks.
pub const MOLLIS_ACCUMULATION_BLOCKED: i32 = 0;
/// Each addition's error is carried along: for diagnostics.
pub const MOLLIS_ACCUMULATION_COMPENSATED: i32 = 1;

/// A pair's core radius is the source's.
pub const MOLLIS_PAIR_RADIUS_SOURCE: i32 = 0;
/// The larger one of the source's and the target's.
pub const MOLLIS_PAIR_RADIUS_MAXIMUM: i32 = 1;
/// Their mean.
pub const MOLLIS_PAIR_RADIUS_MEAN: i32 = 2;
/// The root of the mean of their squares.
pub const MOLLIS_PAIR_RADIUS_RMS: i32 = 3;

/// How a sum is computed. Fill it with `mollis_field_options_init`, then change what you want; null means the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_field_options {
    /// Bytes of this structure, as `mollis_field_options_init` sets it.
    pub size: u32,
    /// `MOLLIS_METHOD_...`.
    pub method: i32,
    /// `MOLLIS_ACCUMULATION_...`.
    pub accumulation: i32,
    /// `MOLLIS_PAIR_RADIUS_...`, with core radii of the sources. But for the first the targets need core radii too; then forces between two particles are equal and opposite.
    pub pair_radius: i32,
    /// (a, b): in 2D the gradient output is a grad u + b (grad u rotated by +90 degrees), of the rounded gradient; else (1, 0).
    pub combination: [f64; 2],
    /// The error that may be spent for speed (`MOLLIS_METHOD_FMM`, `MOLLIS_METHOD_TREE`): of each output, in the l2 norm over the targets, relative to that of sum_j |m_j| |K_j|; with
    /// masses of one sign relative to the output itself. 0 asks for rounding alone, and so does any tolerance that is too
    /// small for these methods, or where they serve no sum of this kind. Not negative.
    pub tolerance: f64,
}

options::options!(mollis_field_options {
    method: MOLLIS_METHOD_AUTO,
    accumulation: MOLLIS_ACCUMULATION_BLOCKED,
    pair_radius: MOLLIS_PAIR_RADIUS_SOURCE,
    combination: [1.0, 0.0],
    tolerance: 0.0
});

impl mollis_field_options {
    pub(super) fn to_core(self) -> Result<field::Options> {
        let [a, b] = self.combination;
        Ok(field::Options {
            accumulation: match self.accumulation {
                MOLLIS_ACCUMULATION_BLOCKED => Accumulation::Blocked,
                MOLLIS_ACCUMULATION_COMPENSATED => Accumulation::Compensated,
                _ => return Err(Error::UnknownValue),
            },
            combination: (a, b),
            tolerance: self.tolerance,
            radii: false,
            pair_radius: match self.pair_radius {
                MOLLIS_PAIR_RADIUS_SOURCE => PairRadius::Source,
                MOLLIS_PAIR_RADIUS_MAXIMUM => PairRadius::Maximum,
                MOLLIS_PAIR_RADIUS_MEAN => PairRadius::Mean,
                MOLLIS_PAIR_RADIUS_RMS => PairRadius::RootMeanSquare,
                _ => return Err(Error::UnknownValue),
            },
            strengths: false,
            method: match self.method {
                MOLLIS_METHOD_AUTO => None,
                MOLLIS_METHOD_DIRECT => Some(Method::Direct),
                MOLLIS_METHOD_MOMENTS => Some(Method::Moments),
                MOLLIS_METHOD_SORTED => Some(Method::Sorted),
                MOLLIS_METHOD_NEIGHBOURS => Some(Method::Neighbours),
                MOLLIS_METHOD_SPLIT => Some(Method::Split),
                MOLLIS_METHOD_FMM => Some(Method::Fmm),
                MOLLIS_METHOD_TREE => Some(Method::Tree),
                _ => return Err(Error::UnknownValue),
            },
        })
    }
}

/// What a sum did. Added to, when the call succeeds.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct mollis_field_counts {
    /// Pairs of a target and a source with mass; by the fast multipole method and the tree those that are summed one by one.
    pub pairs: u64,
    /// Of these, pairs closer than delta.
    pub near_pairs: u64,
    /// Blocks (a source against a block of targets) that evaluated the mollifier's polynomial.
    pub polynomial_blocks: u64,
    /// Of these, blocks with every target near, where nothing was divided.
    pub all_near_blocks: u64,
    /// Pairs outside the range of the fast path. Newtonian ones, without core radii and algebraic mollifiers, closer than 2^-28 of the largest coordinate (double: 2^-60) are summed in lanes in
    /// closer units, at about 3 times the usual cost. Those closer than 2^-84 (2^-180), coincident ones, and those of other kernels beyond the
    /// ends of their table are computed one by one: some 200 ns each.
    pub scaled_pairs: u64,
    /// Sources without mass that were dropped.
    pub massless_sources: u64,
    /// Pairs at least as far apart as the reach of a host's own kernel, which gives them nothing.
    pub beyond_reach: u64,
}

// SAFETY: seven numbers of eight bytes, no padding.
unsafe impl Plain for mollis_field_counts {}

/// Fills `options` with the defaults. `size` is `sizeof *options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field_options_init(options: *mut mollis_field_options, size: usize) -> mollis_status {
    // SAFETY: this function's own contract.
    status(unsafe { options::init(options, size) })
}
