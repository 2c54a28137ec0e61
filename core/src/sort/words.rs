//! Sorting 64-bit words in the caller's memory: keys in the high half, indices in the low half.

use crate::build;
pub use crate::build::FEW;

/// Up to this many words radix passes are not faster.
const SMALL: usize = 48;
const DIGIT: u32 = 10;
/// Number of counts that the radix passes need.
pub const BUCKETS: usize = 1 << DIGIT;

/// Sorts `words` by their high 32 bits, stable, so equal ones stay in the order of the low half if they were in it. Few words, or any with
/// `spare` too short or `counts` shorter than [`BUCKETS`], are sorted as whole words. `spare` and `counts` are overwritten.
pub fn by_high_half(words: &mut [u64], spare: &mut [u64], counts: &mut [u32]) {
    match (spare.get_mut(..words.len()), counts.first_chunk_mut()) {
        (Some(spare), Some(counts)) if build::MANY && words.len() > SMALL => {
            for k in 0..2 {
                pass(words.iter(), spare, counts, 32 + 2 * k * DIGIT);
                pass(spare.iter(), words, counts, 32 + (2 * k + 1) * DIGIT);
            }
        }
        _ if !build::MANY => by_key(words, &|word| word),
        _ => heap(words, |&word| word),
    }
}

/// Stable sort of `words` by the low twenty bits of their high halves; the other high bits are equal in all of them. Few words are sorted as
/// whole words. `spare` has the same length and is overwritten.
pub fn by_20_bits(words: &mut [u64], spare: &mut [u64], counts: &mut [u32; BUCKETS]) {
    if words.len() <= SMALL {
        heap(words, |&word| word);
    } else {
        pass(words.iter(), spare, counts, 32);
        pass(spare.iter(), words, counts, 32 + DIGIT);
    }
}

/// One stable pass by the [`DIGIT`] bits from `shift` on.
#[inline]
fn pass<'a>(from: impl Iterator<Item = &'a u64> + Clone, to: &mut [u64], places: &mut [u32; BUCKETS], shift: u32) {
    places.fill(0);
    let digit = |word: u64| (word >> shift) as usize & (BUCKETS - 1);
    from.clone().for_each(|&word| {
        if let Some(count) = places.get_mut(digit(word)) {
            *count += 1;
        }
    });
    starts(places);
    from.for_each(|&word| {
        if let Some(place) = places.get_mut(digit(word)) {
            if let Some(slot) = to.get_mut(*place as usize) {
                *slot = word;
            }
            *place += 1;
        }
    });
}

/// Replaces the counts of the buckets by their starts.
pub fn starts(counts: &mut [u32]) {
    let mut start = 0;
    for count in counts {
        start += core::mem::replace(count, start);
    }
}

/// Sorts in place by a key, in O(n log n) for any order (O(n^2) without [`build::MANY`]), without a panic path. Not stable. One function for all keys.
pub fn by_key(words: &mut [u64], key: &dyn Fn(u64) -> u64) {
    if build::MANY {
        return heap(words, |&word| key(word));
    }
    // Insertion sort saves flash; the sums over all pairs take far longer.
    for end in 1..words.len() {
        let mut at = end;
        while let Some([a, b]) = words.get_mut(at.wrapping_sub(1)..).and_then(<[u64]>::first_chunk_mut) {
            if key(*a) <= key(*b) {
                break;
            }
            core::mem::swap(a, b);
            at -= 1;
        }
    }
}

fn heap(words: &mut [u64], key: impl Fn(&u64) -> u64) {
    // Insertion sort for short arrays.
    if words.len() <= 16 {
        for end in 1..words.len() {
            let mut at = end;
            while at > 0 && matches!((words.get(at - 1), words.get(at)), (Some(a), Some(b)) if key(a) > key(b)) {
                exchange(words, at - 1, at);
                at -= 1;
            }
        }
        return;
    }
    for root in (0..words.len() / 2).rev() {
        sift(words, root, &key);
    }
    for end in (1..words.len()).rev() {
        exchange(words, 0, end);
        if let Some(heap) = words.get_mut(..end) {
            sift(heap, 0, &key);
        }
    }
}

/// `swap` without its panic path.
fn exchange(words: &mut [u64], i: usize, j: usize) {
    if let Ok([a, b]) = words.get_disjoint_mut([i, j]) {
        core::mem::swap(a, b);
    }
}

fn sift(heap: &mut [u64], mut root: usize, key: &impl Fn(&u64) -> u64) {
    loop {
        let child = 2 * root + 1;
        let Some(left) = heap.get(child) else { return };
        let child = match heap.get(child + 1) {
            Some(right) if key(right) > key(left) => child + 1,
            _ => child,
        };
        match (heap.get(root), heap.get(child)) {
            (Some(above), Some(below)) if key(below) > key(above) => exchange(heap, root, child),
            _ => return,
        }
        root = child;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    #[test]
    fn sorts_like_the_standard_library() {
        let mut seed = 3_u64;
        let mut counts = vec![9; BUCKETS];
        for n in [0, 1, 2, 3, 15, 16, 17, 18, SMALL, SMALL + 1, 511, 512, 513, 5000] {
            for bits in [1, 8, 31, 32] {
                let words: Vec<u64> = (0..n as u64)
                    .map(|i| {
                        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                        (seed >> (64 - bits)) << 32 | i
                    })
                    .collect();
                let mut want = words.clone();
                want.sort_unstable();
                for spare in [0, n] {
                    let mut got = words.clone();
                    by_high_half(&mut got, &mut vec![7; spare], &mut counts);
                    assert_eq!(got, want, "{n} {bits}");
                }
                // Words with equal highest bits.
                let mut got: Vec<u64> = words.iter().map(|&w| w & !(0xFFF << 52)).collect();
                want = got.clone();
                want.sort_unstable();
                by_20_bits(&mut got, &mut vec![7; n], &mut [9; BUCKETS]);
                assert_eq!(got, want, "{n} {bits}");
            }
        }
    }
}
