//! Stable sorting of numbers with their indices, by digits of eight bits, in the caller's memory.
//!
//! [`order`] sorts one word per point: the position between least and greatest value in 32 bits, and the index. It then orders
//! the points of equal position by insertion; if they are many, it sorts by all bits.

use crate::checked::Present;
use crate::real::{Real, quotient};

/// A key and its original index.
pub type Entry = [u64; 2];

/// The bits of a finite number, mapped so that their order is that of the values.
pub fn ordered_bits<T: Real>(x: T) -> u64 {
    let bits = x.bits();
    let sign = 1_u64 << (8 * T::BYTES - 1);
    if bits & sign == 0 { bits | sign } else { !bits & (sign | (sign - 1)) }
}

/// Sorts `entries` by key. `spare` has the same length and is overwritten. Cost: one pass per byte in which keys differ.
pub fn sort(entries: &mut [Entry], spare: &mut [Entry]) {
    let all = entries.iter().fold(u64::MAX, |and, e| and & e[0]);
    let any = entries.iter().fold(0, |or, e| or | e[0]);
    let (mut from, mut to) = (entries, spare);
    let mut swapped = false;
    for shift in (0..64).step_by(8) {
        if ((all ^ any) >> shift).trailing_zeros() >= 8 {
            continue;
        }
        let digit = |&[key, _]: &Entry| (key >> shift) as usize & 0xFF;
        let mut places = [0_usize; 256];
        for entry in from.iter() {
            if let Some(count) = places.get_mut(digit(entry)) {
                *count += 1;
            }
        }
        scatter(from, to, &mut places, digit);
        core::mem::swap(&mut from, &mut to);
        swapped = !swapped;
    }
    if swapped {
        // `to` is the caller's `entries`
        for (slot, entry) in to.iter_mut().zip(from.iter()) {
            *slot = *entry;
        }
    }
}

/// Copies into `to` in the order of digits, stable. `places` holds the count of each digit and is overwritten.
#[inline]
fn scatter<W: Copy>(from: &[W], to: &mut [W], places: &mut [usize; 256], digit: impl Fn(&W) -> usize) {
    let mut sum = 0;
    for place in places.iter_mut() {
        (*place, sum) = (sum, sum + *place);
    }
    for item in from {
        if let Some(place) = places.get_mut(digit(item)) {
            if let Some(slot) = to.get_mut(*place) {
                *slot = *item;
            }
            *place += 1;
        }
    }
}

/// `keys / width`. None if all numbers are equal, or so close that the quotient would overflow, or their difference does.
pub(crate) fn keys_per_width<T: Real>(keys: T, width: T) -> Option<T> {
    // A function divides, so that the compiler does not before the test.
    (width > T::MIN_POSITIVE.ldexp(36) && width.is_finite()).then(|| quotient(keys, width))
}

/// Writes the order of the points `0 .. n` by `value`, as their indices, into the first words of `entries`. Points without a
/// value are omitted. Returns the number of points with a value. Equal values keep the order of their indices.
pub fn order<T: Real>(
    n: usize,
    value: impl Fn(usize) -> Option<T>,
    entries: &mut [Entry],
    spare: &mut [Entry],
) -> usize {
    let (least, greatest) = (0..n)
        .filter_map(&value)
        .fold((T::INFINITY, -T::INFINITY), |(least, greatest), x| (least.min(x), greatest.max(x)));
    let width = greatest - least;
    let Some(scale) = keys_per_width(T::from_f64(4_294_967_040.0), width).filter(|_| u32::try_from(n).is_ok()) else {
        return order_by_all_bits(n, value, entries, spare);
    };
    // Monotone in x, as each rounding is.
    let key = |x: T| (((x - least) * scale).to_f64() as u64).min(u64::from(u32::MAX));
    let mut count = 0;
    let mut places = [[0_usize; 256]; 4];
    for (index, x) in (0..n).filter_map(|index| Some((index, value(index)?))) {
        let word = key(x) << 32 | index as u64;
        if let Some(slot) = entries.as_flattened_mut().get_mut(count) {
            *slot = word;
            count += 1;
        }
        for (digit, places) in places.iter_mut().enumerate() {
            if let Some(place) = places.get_mut((word >> (32 + 8 * digit)) as usize & 0xFF) {
                *place += 1;
            }
        }
    }
    // after four passes the result is in `entries`
    let (mut from, mut to) = (entries.as_flattened_mut(), spare.as_flattened_mut());
    for (digit, places) in places.iter_mut().enumerate() {
        let digit = |&word: &u64| (word >> (32 + 8 * digit)) as usize & 0xFF;
        scatter(from.get(..count).present_or_default(), to, places, digit);
        core::mem::swap(&mut from, &mut to);
    }
    // insertion among equal keys: few moves, unless many points are in a 2^-32nd part of the interval
    let index = |word: u64| (word & u64::from(u32::MAX)) as usize;
    let mut moves = 4 * count;
    for k in 1..count {
        let mut at = k;
        while let Some(&[before, word]) = at.checked_sub(1).and_then(|b| from.get(b..at + 1)?.first_chunk::<2>()) {
            let in_order = before >> 32 < word >> 32
                || value(index(before)).zip(value(index(word))).is_none_or(|(before, x)| before <= x);
            if in_order {
                break;
            }
            at -= 1;
            if let Some([a, b]) = from.get_mut(at..).and_then(|rest| rest.first_chunk_mut::<2>()) {
                core::mem::swap(a, b);
            }
            moves = moves.saturating_sub(1);
        }
        if moves == 0 {
            return order_by_all_bits(n, value, entries, spare);
        }
    }
    from.iter_mut().take(count).for_each(|word| *word &= u64::from(u32::MAX));
    count
}

/// As [`order`].
#[cold]
fn order_by_all_bits<T: Real>(
    n: usize,
    value: impl Fn(usize) -> Option<T>,
    entries: &mut [Entry],
    spare: &mut [Entry],
) -> usize {
    let mut count = 0;
    for (index, x) in (0..n).filter_map(|index| Some((index, value(index)?))) {
        if let Some(slot) = entries.get_mut(count) {
            *slot = [ordered_bits(x), index as u64];
            count += 1;
        }
    }
    if let (Some(entries), Some(spare)) = (entries.get_mut(..count), spare.get_mut(..count)) {
        sort(entries, spare);
    }
    // word k is read before it is written, because entry k is at words 2k and 2k + 1
    let words = entries.as_flattened_mut();
    for k in 0..count {
        if let Some(&index) = words.get(2 * k + 1)
            && let Some(slot) = words.get_mut(k)
        {
            *slot = index;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn sorts_as_the_standard_library_does() {
        for n in [0_usize, 1, 2, 7, 255, 256, 257, 3000] {
            let value = |k: usize| ((k as f64) * 0.618_033_988_75).sin() * (10.0_f64).powi((k % 13) as i32 - 6);
            let mut entries: Vec<Entry> = (0..n).map(|k| [ordered_bits(value(k / 2)), k as u64]).collect();
            let mut want: Vec<usize> = (0..n).collect();
            want.sort_by(|&a, &b| value(a / 2).total_cmp(&value(b / 2)));
            let mut spare = entries.clone();
            sort(&mut entries, &mut spare);
            assert!(entries.iter().map(|e| e[1] as usize).eq(want), "{n}");
        }
        for (n, case) in [(0_usize, 0), (1, 0), (2, 0), (700, 0), (700, 1), (700, 2), (700, 3), (700, 4)] {
            let value = |k: usize| match case {
                0 => ((k as f64) * 0.618_033_988_75).sin(),
                // few different keys and a distant one
                1 => {
                    if k == 5 {
                        1e9
                    } else {
                        ((k as f64) * 0.618).sin()
                    }
                }
                2 => 3.0,
                3 => {
                    if k.is_multiple_of(2) {
                        f64::MAX
                    } else {
                        -f64::MAX
                    }
                }
                // pairs that differ only in the last bit
                _ => ((k / 2) as f64) + if k.is_multiple_of(2) { 1e-13 } else { 0.0 },
            };
            let some = |k: usize| (k % 7 != 3).then(|| value(k));
            let mut want: Vec<usize> = (0..n).filter(|&k| some(k).is_some()).collect();
            want.sort_by(|&a, &b| value(a).total_cmp(&value(b)));
            let (mut entries, mut spare) = (std::vec![[9, 9]; n], std::vec![[9, 9]; n]);
            let count = order(n, some, &mut entries, &mut spare);
            assert_eq!(count, want.len());
            assert!(entries.as_flattened()[..count].iter().map(|&e| e as usize).eq(want), "{n} {case}");
        }
        assert!(ordered_bits(-1.0_f32) < ordered_bits(0.5_f32) && ordered_bits(-2.0_f32) < ordered_bits(-1.0_f32));
    }
}
