//! Test data: particles in the unit cube with masses of both signs, the same for the same seed.

/// Sources. The first of them are also the targets.
pub struct Scene<const D: usize> {
    /// Positions.
    pub positions: Vec<[f64; D]>,
    /// Masses in -1/2..1/2.
    pub masses: Vec<f64>,
    /// The length of the mollifier, if there is one.
    pub delta: Option<f64>,
}

impl<const D: usize> Scene<D> {
    /// Uniform in the unit cube, by splitmix64.
    pub fn uniform(n: usize, delta: Option<f64>, seed: u64) -> Self {
        let mut state = seed;
        let mut next = move || {
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            // 24 bits, so that the particles are exact in f32.
            ((z ^ (z >> 31)) >> 40) as f64 / f64::from(1_u32 << 24)
        };
        let positions = (0..n).map(|_| std::array::from_fn(|_| next())).collect();
        Self { positions, masses: (0..n).map(|_| next() - 0.5).collect(), delta }
    }
}

/// The part of the memory that is aligned as a workspace must be, 64 bytes shorter.
pub fn aligned(memory: &mut [u8]) -> &mut [u8] {
    let start = memory.as_ptr().align_offset(64);
    let end = memory.len() - 64 + start;
    &mut memory[start..end]
}
