//! Sorting 64-bit words in the caller's memory: keys in the high half, indices in the low half.

/// Buckets of one radix pass.
pub const BUCKETS: usize = 2048;
const DIGIT: u32 = 11;
/// Below this many words a heap sort is as fast as the radix passes and needs no histogram.
pub const FEW: usize = 512;

/// Sorts `words` by their high 32 bits, equal ones in the order of the low half if they came so (whole words for few).
///
/// `spare` (at least as long) is overwritten; `histogram` needs [`BUCKETS`] entries, else few-word sorting is used throughout.
pub fn by_high_half(words: &mut [u64], spare: &mut [u64], histogram: &mut [u32]) {
    let n = words.len();
    let (Some(spare), Some(histogram)) = (spare.get_mut(..n), histogram.get_mut(..BUCKETS)) else {
        return heap(words, |&w| w);
    };
    if n <= FEW {
        return heap(words, |&w| w);
    }
    // 11 + 11 + 10 bits: an odd number of passes ends in `spare`.
    pass(words, spare, histogram, 32);
    pass(spare, words, histogram, 32 + DIGIT);
    pass(words, spare, histogram, 32 + 2 * DIGIT);
    words.iter_mut().zip(spare.iter()).for_each(|(to, &from)| *to = from);
}

/// One stable pass by the 11 bits from `shift` on.
fn pass(from: &[u64], to: &mut [u64], histogram: &mut [u32], shift: u32) {
    histogram.fill(0);
    let digit = |word: u64| (word >> shift) as usize & (BUCKETS - 1);
    for &word in from {
        if let Some(count) = histogram.get_mut(digit(word)) {
            *count += 1;
        }
    }
    let mut start = 0;
    for count in histogram.iter_mut() {
        start += core::mem::replace(count, start);
    }
    for &word in from {
        if let Some(place) = histogram.get_mut(digit(word)) {
            if let Some(slot) = to.get_mut(*place as usize) {
                *slot = word;
            }
            *place += 1;
        }
    }
}

/// Sorts by a key in place, O(n log n) whatever the order, without a panic path. Not stable.
pub fn heap<W, K: PartialOrd>(words: &mut [W], key: impl Fn(&W) -> K) {
    // Straight insertion for the shortest.
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
fn exchange<W>(words: &mut [W], i: usize, j: usize) {
    if let Ok([a, b]) = words.get_disjoint_mut([i, j]) {
        core::mem::swap(a, b);
    }
}

fn sift<W, K: PartialOrd>(heap: &mut [W], mut root: usize, key: &impl Fn(&W) -> K) {
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
        for n in [0, 1, 2, 3, 15, 16, 17, 18, FEW - 1, FEW, FEW + 1, 5000] {
            for bits in [1, 8, 31, 32] {
                let words: Vec<u64> = (0..n as u64)
                    .map(|i| {
                        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                        (seed >> (64 - bits)) << 32 | i
                    })
                    .collect();
                let mut want = words.clone();
                want.sort_unstable();
                for histogram in [0, BUCKETS] {
                    let mut got = words.clone();
                    by_high_half(&mut got, &mut vec![0; n], &mut vec![9; histogram]);
                    assert_eq!(got, want, "{n} {bits}");
                }
            }
        }
    }
}
