//! The built-in generator and the normals against their reference implementations.

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
