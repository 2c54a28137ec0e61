//! Particles in the order of their cells at the finest level.

use super::mesh::Mesh;
use crate::real::Real;
use crate::sort::words as sort;

/// Levels that the first sort resolves.
pub const FIRST: u32 = 16;

/// Of many particles: the buckets are the cells of this level.
pub const LEVEL: u32 = 6;

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
pub fn sort_small<T: Real>(mesh: &Mesh<T>, positions: &[[T; 2]], words: &mut [u64], shared: &mut [u8]) {
    for (i, (word, x)) in words.iter_mut().zip(positions).enumerate() {
        *word = mesh.word(x, i);
    }
    sort::by_key(words, &|word| word);
    let mut before = None;
    for (level, &word) in shared.iter_mut().zip(words.iter()) {
        *level = before.map_or(0, |before| levels(before, key(word)));
        before = Some(key(word));
    }
    refine_ties(mesh, positions, words, &mut [], &mut [], shared);
}

/// Sorts those that share all of the first levels by the next sixteen. The keys are lost, and the marks.
#[inline]
pub fn refine_ties<T: Real>(
    mesh: &Mesh<T>,
    positions: &[[T; 2]],
    words: &mut [u64],
    spare: &mut [u64],
    counts: &mut [u32],
    shared: &mut [u8],
) {
    let deepest = |&level: &u8| u32::from(level & !MARK) == FIRST;
    let mut from = 1;
    // Most share fewer.
    while let Some(next) = shared.get(from..).and_then(|rest| rest.iter().position(deepest)) {
        let begin = from + next;
        let run = shared.iter().skip(begin).take_while(|level| deepest(level)).count();
        let (Some(words), Some(shared)) = (words.get_mut(begin - 1..begin + run), shared.get_mut(begin..begin + run))
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
        from = begin + run;
    }
}
