//! Sorting numbers with their indices: stable, by digits of eight bits, in the caller's memory.

use crate::real::Real;

/// A key and the index it came with.
pub(super) type Entry = [u64; 2];

/// Bits of a finite number in an order that follows its value.
pub(super) fn ordered_bits<T: Real>(x: T) -> u64 {
    let bits = x.bits();
    let sign = 1_u64 << (8 * T::BYTES - 1);
    if bits & sign == 0 { bits | sign } else { !bits & (sign | (sign - 1)) }
}

/// Sorts `entries` by key; `spare` has the same length and ends as garbage. Cost: a pass for each byte in which keys differ.
pub(super) fn sort(entries: &mut [Entry], spare: &mut [Entry]) {
    let all = entries.iter().fold(u64::MAX, |and, e| and & e[0]);
    let any = entries.iter().fold(0, |or, e| or | e[0]);
    let (mut from, mut to) = (entries, spare);
    let mut swapped = false;
    for shift in (0..64).step_by(8) {
        if ((all ^ any) >> shift) & 0xFF == 0 {
            continue;
        }
        let mut places = [0_usize; 256];
        for [key, _] in from.iter() {
            if let Some(count) = places.get_mut((key >> shift) as usize & 0xFF) {
                *count += 1;
            }
        }
        let mut sum = 0;
        for place in &mut places {
            (*place, sum) = (sum, sum + *place);
        }
        for entry in from.iter() {
            if let Some(place) = places.get_mut((entry[0] >> shift) as usize & 0xFF) {
                if let Some(slot) = to.get_mut(*place) {
                    *slot = *entry;
                }
                *place += 1;
            }
        }
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
        assert!(ordered_bits(-1.0_f32) < ordered_bits(0.5_f32) && ordered_bits(-2.0_f32) < ordered_bits(-1.0_f32));
    }
}
