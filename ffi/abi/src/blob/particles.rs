//! What a caller says of its particles.

/// The layout of `mollis_particles1` and the like, which say what the members are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct ParticlesOf<T, const D: usize> {
    pub n: usize,
    pub positions: [*mut T; D],
    pub stride: usize,
    pub masses: *const T,
    pub mass_stride: usize,
    pub density: *mut T,
    pub density_stride: usize,
    pub velocity: [*mut T; D],
    pub velocity_stride: usize,
    pub divergence: *mut T,
    pub divergence_stride: usize,
}
