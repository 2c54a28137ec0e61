//! Particles in the order of their cells at the finest level.

use super::mesh::Mesh;
use crate::pks::sort;
use crate::real::Real;

/// Levels that the first sort resolves.
pub const FIRST: u32 = 16;

/// A mark beside the shared levels, which are fewer.
pub const MARK: u8 = 0x80;

/// The particle of a word.
#[inline(always)]
pub fn particle(word: u64) -> usize {
    (word & 0xFFFF_FFFF) as usize
}

/// The key of a word.
#[inline(always)]
pub fn key(word: u64) -> u32 {
    (word >> 32) as u32
}

/// Levels that two keys share.
#[inline(always)]
pub fn levels(a: u32, b: u32) -> u8 {
    ((a ^ b).leading_zeros() / 2) as u8
}

/// Orders few particles: their words, and the levels that each shares with the one before it.
#[cfg_attr(feature = "small", inline(never))]
pub fn few<T: Real>(mesh: &Mesh<T>, positions: &[[T; 2]], words: &mut [u64], shared: &mut [u8]) {
    for (i, (word, x)) in words.iter_mut().zip(positions).enumerate() {
        *word = mesh.word(x, i);
    }
    sort::by_key(words, &|word| word);
    let mut before = None;
    for (level, &word) in shared.iter_mut().zip(words.iter()) {
        *level = before.map_or(0, |before| levels(before, key(word)));
        before = Some(key(word));
    }
    deepen(mesh, positions, words, &mut [], &mut [], shared);
}

/// Sorts those that share all of the first levels by the next sixteen. The keys are lost, and the marks.
#[inline]
pub fn deepen<T: Real>(
    mesh: &Mesh<T>,
    positions: &[[T; 2]],
    words: &mut [u64],
    spare: &mut [u64],
    counts: &mut [u32],
    shared: &mut [u8],
) {
    let mut from = 0;
    while from < words.len() {
        let run = 1 + shared.iter().skip(from + 1).take_while(|&&level| u32::from(level & !MARK) == FIRST).count();
        if run > 1 {
            let (Some(words), Some(shared)) = (words.get_mut(from..from + run), shared.get_mut(from + 1..from + run))
            else {
                return;
            };
            for word in words.iter_mut() {
                let i = particle(*word);
                *word = positions.get(i).map_or(0, |x| mesh.deep_word(x, i as u64));
            }
            sort::by_high_half(words, spare, counts);
            let keys = words.iter().map(|&word| key(word));
            for (level, (a, b)) in shared.iter_mut().zip(keys.clone().zip(keys.skip(1))) {
                *level = FIRST as u8 + levels(a, b);
            }
        }
        from += run;
    }
}
