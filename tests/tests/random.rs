//! The built-in generator and the normals against their reference implementations, and through the C ABI.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]

use mollis_abi::*;
use mollis_core::Error;
use mollis_core::random::{Generator, Philox, normals, normals_of_labels};
use mollis_reference::random as twin;

#[test]
fn words_are_the_twins() {
    for (seed, label, step, substep) in
        [(0, 0, 0, 0), (1, 2, 3, 4), (u64::MAX, u64::MAX, u32::MAX, 7), (0x0123_4567_89AB_CDEF, 1 << 40, 9, 1 << 31)]
    {
        for n in [0, 1, 2, 3, 7, 64] {
            let mut words = vec![0; n];
            Philox::new(seed).fill(label, step, substep, &mut words).unwrap();
            assert_eq!(words, twin::words(seed, label, step, substep, n));
        }
    }
}

#[test]
fn normals_are_the_twins_to_rounding() {
    let labels: Vec<u64> = (0..10_001).map(|i| i * i).collect();
    let mut pairs = vec![[f64::NAN; 2]; labels.len()];
    normals_of_labels(&mut Philox::new(5), &labels, 6, 7, &mut pairs).unwrap();
    for (&label, pair) in labels.iter().zip(&pairs) {
        let words = twin::words(5, label, 6, 7, 2);
        let (want, radius) = twin::normals([words[0], words[1]]);
        let mut one = [f64::NAN; 2];
        normals(&words, &mut one);
        assert_eq!(one, *pair);
        for k in 0..2 {
            // 4 units in the last place of the radius, as `normals` states.
            assert!((pair[k] - want[k]).abs() <= 4.0 * f64::EPSILON * radius);
        }
    }
}

#[test]
fn the_c_interface_gives_the_same_words_and_normals() {
    let labels = [5_u64, 6, u64::MAX];
    let (mut words, mut want) = ([0_u64; 5], [0_u64; 5]);
    let (mut pairs, mut single) = ([[0.0_f64; 2]; 3], [0.0_f64; 2]);
    // SAFETY: live arrays of these lengths.
    unsafe {
        assert_eq!(mollis_philox_words(1, 2, 3, 4, 5, words.as_mut_ptr()), 0);
        assert_eq!(mollis_philox_normals(1, 3, labels.as_ptr(), 7, 8, pairs.as_mut_ptr()), 0);
        for (&label, pair) in labels.iter().zip(&pairs) {
            let mut two = [0_u64; 2];
            assert_eq!(mollis_philox_words(1, label, 7, 8, 2, two.as_mut_ptr()), 0);
            assert_eq!(mollis_normals(2, two.as_ptr(), single.as_mut_ptr()), 0);
            assert_eq!(*pair, single);
        }
        // The same memory as input and output is refused, untouched.
        let before = words;
        assert_eq!(mollis_normals(4, words.as_ptr(), words.as_mut_ptr().cast()), Error::Overlap as i32);
        assert_eq!(words, before);
        assert_eq!(mollis_philox_words(0, 0, 0, 0, 1, std::ptr::null_mut()), Error::NullPointer as i32);
        assert_eq!(mollis_philox_words(0, 0, 0, 0, 0, std::ptr::null_mut()), 0);
        let mut floats = [[0.0_f32; 2]; 3];
        assert_eq!(mollis_philox_normals_f32(1, 3, labels.as_ptr(), 7, 8, floats.as_mut_ptr()), 0);
        assert!((f64::from(floats[0][1]) - pairs[0][1]).abs() < 1e-5);
        let mut three = [0.0_f32; 3];
        assert_eq!(mollis_normals_f32(3, words.as_ptr(), three.as_mut_ptr()), 0);
    }
    Philox::new(1).words(2, 3, 4, &mut want);
    assert_eq!(words, want);
}
