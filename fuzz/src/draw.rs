//! Choices from a fuzzer's bytes. When these are used up, every choice is the first one, and every number 0.

use arbitrary::Unstructured;

/// Bytes that are used up one after another.
pub struct Draw<'a> {
    rest: Unstructured<'a>,
    /// Nothing but usual values.
    pub tame: bool,
}

/// Numbers that are special to something.
const SPECIAL: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    2.2e-308,
    1e300,
    1e-300,
    1e150,
    1e-150,
    f32::MAX as f64,
    f32::MIN_POSITIVE as f64,
    1e-45,
    1e-40,
    1e30,
    1e-30,
    f64::EPSILON,
];

impl<'a> Draw<'a> {
    /// All of these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: Unstructured::new(bytes), tame: true }
    }

    /// Whether none is left.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        self.rest.arbitrary().unwrap_or(0)
    }

    /// The next eight.
    pub fn word(&mut self) -> u64 {
        self.rest.arbitrary().unwrap_or(0)
    }

    /// One of 0 .. n, n at most 256.
    pub fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    /// One of these.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// True for one byte in n.
    pub fn rarely(&mut self, n: usize) -> bool {
        self.below(n) == n - 1
    }

    /// A number of a harmless size: a multiple of 1/64 from -2 to 2.
    pub fn plain(&mut self) -> f64 {
        f64::from(self.byte() as i8) / 64.0
    }

    /// A positive one.
    pub fn positive(&mut self) -> f64 {
        f64::from(self.byte().wrapping_add(31) | 1) / 32.0
    }

    /// Any number.
    pub fn wild(&mut self) -> f64 {
        match self.below(4) {
            0 => self.pick(&SPECIAL),
            1 => f64::from_bits(self.word()),
            2 => 2_f64.powi(i32::from(self.byte() as i8) * 8) * self.plain(),
            _ => self.plain(),
        }
    }

    /// Mostly `usual`, else any number.
    pub fn or_wild(&mut self, usual: f64) -> f64 {
        if !self.tame && self.rarely(12) { self.wild() } else { usual }
    }

    /// As many numbers: random, on a lattice, all equal, or of every size, a few of them wild.
    pub fn numbers(&mut self, n: usize, positive: bool) -> Vec<f64> {
        let kind = self.below(5);
        let mut seed = u64::from(self.byte()) << 8 | u64::from(self.byte());
        let mut next = || {
            seed = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let z = (seed ^ seed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut all: Vec<f64> = (0..n)
            .map(|k| match kind {
                0 => 2.0 * next() - 1.0,
                1 => (8.0 * next()).floor() / 4.0 - 1.0,
                2 => 0.5,
                3 => (2.0 * next() - 1.0) * 10_f64.powf(16.0 * next() - 8.0),
                _ => k as f64 / 16.0,
            })
            .collect();
        if positive {
            all.iter_mut().for_each(|x| *x = x.abs() + 1e-9);
        }
        if !self.tame && (1..=256).contains(&n) && self.rarely(4) {
            for _ in 0..=self.below(3) {
                let at = self.below(n);
                all[at] = self.wild();
            }
        }
        all
    }

    /// A number of elements: small, at most 300.
    pub fn count(&mut self) -> usize {
        match self.below(16) {
            15 => 45 + self.byte() as usize,
            14 => self.below(65),
            _ => self.below(20),
        }
    }
}
