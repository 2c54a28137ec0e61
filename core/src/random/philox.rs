//! Philox4x32-10 (Salmon, Moraes, Dror & Shaw, *Parallel random numbers: as easy as 1, 2, 3*, 2011).

use super::{Generator, normal};
use crate::error::Result;
use crate::real::Real;
use crate::simd::{Level, Loops, with_simd};

/// Multipliers of the rounds.
const MULTIPLY: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
/// Increments of the two key words per round: the golden ratio and sqrt(3) - 1.
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
const ROUNDS: usize = 10;
/// Number of counters whose normals are computed together.
const LANES: usize = 32;
/// Number of counters whose rounds are computed together. Their words fit in sixteen AVX2 registers.
const GROUP: usize = 8;

/// The built-in counter-based generator. It is stateless, so it may be copied and used from any thread.
///
/// Block 0 of (label, step, sub-step) is Philox4x32-10 with key = (low, high half of the seed) and counter = (low, high half
/// of the label, step, sub-step). Its four 32-bit words w0..w3 form two 64-bit words w0 + 2^32 w1, w2 + 2^32 w3. Longer
/// requests use blocks b = 1, 2, ... with the same counter and the key of block b: the first 64-bit word of the seed's
/// block at label b, step and sub-step both 2^32 - 1. That step is reserved for keys, so a run should end before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Philox {
    /// The key. Runs with different seeds are independent.
    pub seed: u64,
}

impl Philox {
    /// A generator with this seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The two 64-bit words of a counter with a key.
    fn block(key: u64, label: u64, step: u32, substep: u32) -> [u64; 2] {
        let [[a], [b], [c], [d]] =
            rounds(halves(key), [[label], [label >> 32], [u64::from(step)], [u64::from(substep)]]);
        [join(a, b), join(c, d)]
    }

    /// The key of block `b`.
    fn key(self, b: u64) -> u64 {
        if b == 0 {
            return self.seed;
        }
        let [key, _] = Self::block(self.seed, b, u32::MAX, u32::MAX);
        key
    }

    /// As [`Generator::fill`], through a shared reference.
    pub fn words(&self, label: u64, step: u32, substep: u32, out: &mut [u64]) {
        for (b, two) in out.chunks_mut(2).enumerate() {
            let block = Self::block(self.key(b as u64), label, step, substep);
            two.iter_mut().zip(block).for_each(|(word, value)| *word = value);
        }
    }

    /// Overwrites `out[i]` with two independent standard normals for `labels[i]`: block 0 through [`super::normals`].
    ///
    /// The slices should have equal length. Elements beyond the shorter one are not changed.
    pub fn normals<T: Real>(&self, labels: &[u64], step: u32, substep: u32, out: &mut [[T; 2]]) {
        self.normals_at(Level::best(), labels, step, substep, out);
    }

    fn normals_at<T: Real>(&self, level: Level, labels: &[u64], step: u32, substep: u32, out: &mut [[T; 2]]) {
        with_simd(level, Normals { philox: *self, labels, step, substep, out });
    }
}

struct Normals<'a, T> {
    philox: Philox,
    labels: &'a [u64],
    step: u32,
    substep: u32,
    out: &'a mut [[T; 2]],
}

impl<T: Real> Loops for Normals<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { philox, labels, step, substep, out } = self;
        let key = halves(philox.seed);
        let (blocks, rest) = labels.as_chunks::<LANES>();
        let (out_blocks, out_rest) = out.split_at_mut_checked(blocks.len() * LANES).unwrap_or((&mut [], &mut []));
        for (labels, out) in blocks.iter().zip(out_blocks.as_chunks_mut::<LANES>().0) {
            let mut words = [[0_u64; LANES]; 2];
            let [first, second] = &mut words;
            let (first, second) = (first.as_chunks_mut::<GROUP>().0, second.as_chunks_mut::<GROUP>().0);
            for ((labels, first), second) in labels.as_chunks::<GROUP>().0.iter().zip(first).zip(second) {
                // Loops instead of `map`, which is not always inlined and would then be compiled for the baseline.
                let mut counter = [[0_u64; GROUP], [0; GROUP], [u64::from(step); GROUP], [u64::from(substep); GROUP]];
                let [low, high, ..] = &mut counter;
                for ((low, high), &label) in low.iter_mut().zip(high).zip(labels) {
                    (*low, *high) = (label, label >> 32);
                }
                let [a, b, c, d] = rounds(key, counter);
                for (((((first, second), a), b), c), d) in first.iter_mut().zip(second).zip(a).zip(b).zip(c).zip(d) {
                    *first = join(a, b);
                    *second = join(c, d);
                }
            }
            let [first, second] = &words;
            normal::pairs([first, second], out);
        }
        for (&label, out) in rest.iter().zip(out_rest) {
            *out = normal::pair(Philox::block(philox.seed, label, step, substep));
        }
    }
}

impl Generator for Philox {
    fn fill(&mut self, label: u64, step: u32, substep: u32, out: &mut [u64]) -> Result<()> {
        self.words(label, step, substep, out);
        Ok(())
    }

    fn counter_based(&self) -> Option<Philox> {
        Some(*self)
    }
}

const fn halves(word: u64) -> [u32; 2] {
    [word as u32, (word >> 32) as u32]
}

/// One word from the low halves of two.
#[inline(always)]
const fn join(low: u64, high: u64) -> u64 {
    low & 0xFFFF_FFFF | high << 32
}

/// The ten rounds over several counters with one key. A 32-bit word is stored in the low half of 64 bits, so that each product
/// is one widening multiplication of vector registers.
#[inline(always)]
fn rounds<const L: usize>(mut key: [u32; 2], mut counter: [[u64; L]; 4]) -> [[u64; L]; 4] {
    let low = |word: u64| word & 0xFFFF_FFFF;
    for _ in 0..ROUNDS {
        let [c0, c1, c2, c3] = &mut counter;
        let [k0, k1] = [u64::from(key[0]), u64::from(key[1])];
        for (((c0, c1), c2), c3) in c0.iter_mut().zip(c1).zip(c2).zip(c3) {
            let p0 = u64::from(MULTIPLY[0]) * low(*c0);
            let p1 = u64::from(MULTIPLY[1]) * low(*c2);
            *c0 = p1 >> 32 ^ *c1 ^ k0;
            *c1 = p1;
            *c2 = p0 >> 32 ^ *c3 ^ k1;
            *c3 = p0;
        }
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers_of_random123() {
        // kat_vectors of Random123 1.09, "philox4x32 10": counter, key, result.
        for (counter, key, answer) in [
            ([0, 0, 0, 0], [0, 0], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ] {
            let lows = |words: [u64; 5]| words.map(|word| word as u32);
            let five = rounds(key, counter.map(|word: u32| [u64::from(word) | 7 << 40; 5]));
            assert_eq!(five.map(lows), answer.map(|word| [word; 5]));
            // The same through the public `words`: counter = (label, step, sub-step).
            let mut words = [0; 2];
            let wide = |low, high| u64::from(low) | u64::from(high) << 32;
            Philox::new(wide(key[0], key[1])).words(wide(counter[0], counter[1]), counter[2], counter[3], &mut words);
            assert_eq!(words, [wide(answer[0], answer[1]), wide(answer[2], answer[3])]);
        }
    }

    #[test]
    fn every_level_gives_the_same_bits() {
        let labels: std::vec::Vec<u64> = (0..1000).collect();
        let run = |level| {
            let mut out = std::vec![[0.0_f64; 2]; labels.len()];
            Philox::new(3).normals_at(level, &labels, 1, 2, &mut out);
            out
        };
        for level in Level::available() {
            assert_eq!(run(level), run(Level::Portable), "{level:?}");
        }
    }

    #[test]
    fn longer_requests_begin_as_shorter_ones_and_blocks_differ() {
        let philox = Philox::new(42);
        let mut long = [0; 9];
        philox.words(7, 8, 9, &mut long);
        for n in 0..9 {
            let mut short = std::vec![0; n];
            philox.words(7, 8, 9, &mut short);
            assert_eq!(short, long[..n]);
        }
        let mut sorted = long;
        sorted.sort_unstable();
        assert!(sorted.windows(2).all(|w| w[0] != w[1]));
    }
}
