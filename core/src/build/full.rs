//! A build for machines with memory for programs: everything.

/// An executor of the host's runs tasks.
pub const WORKERS: bool = true;
/// Sums over many particles that skip pairs: moments, sorted sums, neighbours.
pub const METHODS: bool = true;
/// Sums call the kernel's functions of a distance. If every sum is Newtonian they are not called, and need not be linked.
pub const KERNELS: bool = true;
/// Particle methods compute potentials, velocities and divergences besides positions and densities.
pub const BESIDES: bool = true;
/// Massless particles that follow the flow.
pub const TRACERS: bool = true;
/// A function of the host is called after each step of the blob method.
pub const AFTER_STEP: bool = true;
/// Fields on a mesh, for coalescing particles.
pub const MESHES: bool = true;
/// Coalescing particles without noise.
pub const NOISELESS: bool = true;
/// The collision law as printed.
pub const PRINTED_LAW: bool = true;
/// Strang's splitting with RK4.
pub const STRANG: bool = true;
/// What steps did is counted.
pub const REPORTS: bool = true;
/// A generator of the library's own where the host brings none.
pub const PHILOX: bool = true;
/// Up to this many words are sorted, and particles searched, without arrays of further memory.
pub const FEW: usize = 512;
/// Loops over many particles are written for vectors, in tiles on the stack.
pub const TILES: bool = true;
/// The machine has double precision.
pub const DOUBLE: bool = true;
/// Data structures and sorts for many particles, at the cost of further memory.
pub const MANY: bool = true;
/// Coalescing particles may have weights beside their masses.
pub const WEIGHTS: bool = true;
/// Particles may be spread over the processes of a host.
pub const RANKS: bool = true;
/// Short functions of arithmetic are one function for all callers.
pub const SHARED: bool = false;

/// A short function of arithmetic: in line.
macro_rules! shared {
    ($($function:tt)*) => { #[inline(always)] $($function)* };
}
pub(crate) use shared;
