//! What a particle's word holds while its bucket is not in order.
//!
//! First, as it is *put* into a bucket: the bucket, the coordinates within it, the particle's number. Then, to be sorted: the *key*, coordinates finer
//! than the key's in the bits that the numbers leave free, the number.

use super::mesh::{interleave, part};
use super::order::{FIRST, LEVEL, key};

/// Levels beyond the key's that a word may hold beside the particle's number.
const BEYOND: u32 = 8;

/// How the bits are shared out.
#[derive(Clone, Copy, Debug)]
pub struct KeyLayout {
    /// How many levels beyond the key's are held.
    pub levels: u32,
}

impl KeyLayout {
    /// For the numbers below `n`.
    pub fn new(n: usize) -> Self {
        let free = (n.saturating_sub(1) as u32).leading_zeros();
        Self { levels: BEYOND.min(free / 2) }
    }

    /// Bits of a particle's number.
    #[inline(always)]
    fn bits(self) -> u32 {
        32 - 2 * self.levels
    }

    /// Levels below the bucket's.
    #[inline(always)]
    pub fn below(self) -> u32 {
        FIRST + self.levels - LEVEL
    }

    /// The word of a particle at these coordinates of the finest cells, to be put into its bucket.
    #[inline(always)]
    pub fn put(self, [cx, cy]: [u32; 2], i: usize) -> u64 {
        let spread = |c: u32| {
            let v = c >> (32 - LEVEL);
            let v = (v | v << 4) & 0x30F;
            let v = (v | v << 2) & 0x333;
            (v | v << 1) & 0x555
        };
        let local = |c: u32| u64::from((c << LEVEL) >> (32 - self.below()));
        let bucket = u64::from(spread(cx) | spread(cy) << 1);
        ((bucket << self.below() | local(cy)) << self.below() | local(cx)) << self.bits() | i as u64
    }

    /// The bucket of a word that was put.
    #[inline(always)]
    pub fn bucket(word: u64) -> usize {
        (word >> (64 - 2 * LEVEL)) as usize
    }

    /// The coordinates within the bucket of a word that was put.
    #[inline(always)]
    pub fn local(self, word: u64) -> [u32; 2] {
        let mask = (1 << self.below()) - 1;
        [(word >> self.bits()) as u32 & mask, (word >> (self.bits() + self.below())) as u32 & mask]
    }

    /// The coordinates of the keys in a bucket begin here.
    pub fn corner(bucket: usize) -> [u32; 2] {
        part(bucket as u32).map(|c| c << (FIRST - LEVEL))
    }

    /// The word with a key, of one that was put into the bucket that begins here.
    #[inline(always)]
    pub fn keyed(self, word: u64, [x, y]: [u32; 2]) -> u64 {
        let [p, q] = self.local(word);
        let mask = (1 << self.levels) - 1;
        let key = u64::from(interleave([x | p >> self.levels, y | q >> self.levels]));
        let fine = u64::from((q & mask) << self.levels | p & mask);
        key << 32 | fine << self.bits() | self.number(word)
    }

    /// The coordinates that a word with a key holds.
    #[inline(always)]
    pub fn place(self, word: u64) -> [u32; 2] {
        let [x, y] = part(key(word));
        let (mask, fine) = ((1 << self.levels) - 1, (u64::from(word as u32) >> self.bits()) as u32);
        [x << self.levels | fine & mask, y << self.levels | fine >> self.levels]
    }

    /// The word with a key, less the finer coordinates.
    #[inline(always)]
    pub fn strip(self, word: u64) -> u64 {
        word & !0xFFFF_FFFF | self.number(word)
    }

    /// The particle's number, which is a word without a key.
    #[inline(always)]
    pub fn number(self, word: u64) -> u64 {
        word & ((1 << self.bits()) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_hold_what_was_put_in() {
        for n in [1, 2, 513, 1 << 16, (1 << 16) + 1, 1_000_000, 1 << 24, u32::MAX as usize] {
            let beyond = KeyLayout::new(n);
            for [x, y] in [[0, 0], [u32::MAX, 0], [0x1234_5678, 0x9ABC_DEF0], [u32::MAX; 2]] {
                for i in [0, n / 2, n - 1] {
                    let put = beyond.put([x, y], i);
                    let bucket = interleave([x >> (32 - LEVEL), y >> (32 - LEVEL)]);
                    assert_eq!(KeyLayout::bucket(put), bucket as usize);
                    let place = [x, y].map(|c| c >> (FIRST - beyond.levels));
                    assert_eq!(beyond.local(put), place.map(|c| c & ((1 << beyond.below()) - 1)));
                    assert_eq!(beyond.number(put), i as u64);
                    let keyed = beyond.keyed(put, KeyLayout::corner(bucket as usize));
                    assert_eq!(beyond.place(keyed), place);
                    assert_eq!(key(keyed), interleave([x >> 16, y >> 16]));
                    assert_eq!(beyond.strip(keyed), u64::from(key(keyed)) << 32 | i as u64);
                }
            }
        }
    }
}
