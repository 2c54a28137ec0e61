//! Accuracy against the formula, and statistics with fixed seeds.

use super::*;
use std::vec;
use std::vec::Vec;

/// 2^18 words, counter based.
fn bits(seed: u64, n: usize) -> Vec<u64> {
    let mut out = vec![0; n];
    Philox::new(seed).words(1, 2, 3, &mut out);
    out
}

#[test]
fn uniform_is_open_and_exact() {
    assert_eq!(uniform::<f64>(0), 2.0_f64.powi(-53));
    assert_eq!(uniform::<f64>(u64::MAX), 1.0 - 2.0_f64.powi(-53));
    assert_eq!(uniform::<f32>(0), 2.0_f32.powi(-24));
    assert_eq!(uniform::<f32>(u64::MAX), 1.0 - 2.0_f32.powi(-24));
}

#[test]
fn against_the_formula() {
    // Selected words (ends of the radius, quadrant borders) and random ones, compared with std's log, sin and cos. Errors in
    // units of u |radius|: 1 for the logarithm, halved by the root, 1/2 root, 1 sine, 1/2 product, and pi/4 for the rounding of the
    // argument. The formula in std has as much again. Angles near a multiple of pi/2 are compared relative to the
    // radius, not the component.
    let ends = [0, 1, 1 << 12, u64::MAX, u64::MAX - (1 << 12), 1 << 62, (1 << 62) - 1, 3 << 62, 1 << 63];
    let mut words: Vec<u64> = ends.iter().flat_map(|&a| ends.map(|b| [a, b])).flatten().collect();
    words.extend(bits(3, 40_000));
    let mut out = vec![0.0_f64; words.len()];
    normals(&words, &mut out);
    let mut single = vec![0.0_f32; words.len()];
    normals(&words, &mut single);
    for ((w, z), z32) in words.as_chunks::<2>().0.iter().zip(out.as_chunks::<2>().0).zip(single.as_chunks::<2>().0) {
        let u = ((w[0] >> 12) as f64 + 0.5) * 2.0_f64.powi(-52);
        let radius = (-2.0 * u.ln()).sqrt();
        // The angle is measured from the middle of its quadrant, because std's argument reduction would lose bits.
        let x = (((w[1] << 2) >> 12) as f64 + 0.5) * 2.0_f64.powi(-52) - 0.5;
        let (s, c) = (x * core::f64::consts::FRAC_PI_2).sin_cos();
        let want = match w[1] >> 62 {
            0 => [c, s],
            1 => [-s, c],
            2 => [-c, -s],
            _ => [s, -c],
        };
        for k in 0..2 {
            assert!((z[k] - radius * want[k]).abs() <= 4.0 * f64::EPSILON * radius, "{w:?} {z:?}");
            // f32: u itself is not rounded, only m - 1 and later results.
            assert!((f64::from(z32[k]) - radius * want[k]).abs() <= 4.0 * f64::from(f32::EPSILON) * radius, "{w:?}");
        }
        assert!(z[0].hypot(z[1]) <= 8.58);
    }
}

#[test]
fn odd_lengths_and_missing_words() {
    let words = bits(5, 8);
    let mut all = [0.0_f64; 8];
    normals(&words, &mut all);
    for n in 0..8 {
        let mut out = vec![9.0_f64; n];
        normals(&words[..super::words(n)], &mut out);
        assert_eq!(out, all[..n]);
    }
    let mut out = [9.0_f64; 5];
    normals(&words[..3], &mut out);
    assert_eq!((&out[..2], &out[2..]), (&all[..2], &[9.0; 3][..]));
}

/// The largest difference between the sample's distribution function and `law`, times sqrt(n).
fn kolmogorov(sample: &mut [f64], law: impl Fn(f64) -> f64) -> f64 {
    sample.sort_by(f64::total_cmp);
    let n = sample.len() as f64;
    let off = |(i, &x): (usize, &f64)| (law(x) - i as f64 / n).abs().max((law(x) - (i as f64 + 1.0) / n).abs());
    sample.iter().enumerate().map(off).fold(0.0, f64::max) * n.sqrt()
}

/// P(K > 1.95) = 2 e^{-2 1.95^2} = 0.001.
const KOLMOGOROV_0_001: f64 = 1.95;

#[test]
fn the_law_is_normal_along_labels_steps_and_substeps() {
    let n = 200_000_usize;
    let labels: Vec<u64> = (0..n as u64).collect();
    let mut philox = Philox::new(2026);
    let mut pairs = vec![[0.0_f64; 2]; n];
    let phi = |x: f64| 0.5 * libm::erfc(-x / 2.0_f64.sqrt());
    for step in 0..3 {
        normals_of_labels(&mut philox, &labels, step, 0, &mut pairs).unwrap();
        for k in 0..2 {
            let mut z: Vec<f64> = pairs.iter().map(|p| p[k]).collect();
            // Standard deviations of the sample's moments: 1, sqrt 2, sqrt 15, sqrt 96, over sqrt n. The limit is four of them.
            let moment = |q: i32| z.iter().map(|v| v.powi(q)).sum::<f64>() / n as f64;
            let limit = |variance: f64| 4.0 * (variance / n as f64).sqrt();
            assert!(moment(1).abs() < limit(1.0) && (moment(2) - 1.0).abs() < limit(2.0));
            assert!(moment(3).abs() < limit(15.0) && (moment(4) - 3.0).abs() < limit(96.0));
            // Normals of consecutive labels are uncorrelated.
            let lag = z.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n as f64;
            assert!(lag.abs() < limit(1.0));
            assert!(kolmogorov(&mut z, phi) < KOLMOGOROV_0_001);
        }
        let cross = pairs.iter().map(|p| p[0] * p[1]).sum::<f64>() / n as f64;
        let squares = pairs.iter().map(|p| (p[0] * p[0] - 1.0) * (p[1] * p[1] - 1.0)).sum::<f64>() / n as f64;
        assert!(cross.abs() < 4.0 / (n as f64).sqrt() && squares.abs() < 8.0 / (n as f64).sqrt());
    }
    // One particle through its sub-steps.
    let mut z: Vec<f64> = (0..20_000)
        .flat_map(|substep| {
            let mut pair = [[0.0_f64; 2]];
            normals_of_labels(&mut philox, &[77], 5, substep, &mut pair).unwrap();
            pair[0]
        })
        .collect();
    let lag = z.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / z.len() as f64;
    assert!(lag.abs() < 4.0 / (z.len() as f64).sqrt());
    assert!(kolmogorov(&mut z, phi) < KOLMOGOROV_0_001);
    let mut u: Vec<f64> = bits(9, 100_000).into_iter().map(uniform).collect();
    assert!(kolmogorov(&mut u, |x| x) < KOLMOGOROV_0_001);
}

/// A counting generator, to observe the order in which a stream is drawn.
struct Count(u64);
impl Generator for Count {
    fn fill(&mut self, label: u64, _: u32, _: u32, out: &mut [u64]) -> Result<()> {
        if label == 13 {
            return Err(crate::Error::Generator);
        }
        out.iter_mut().for_each(|w| {
            self.0 += 1;
            *w = self.0 << 40;
        });
        Ok(())
    }
}

#[test]
fn batches_are_the_same_bits_as_one_by_one() {
    for n in [0, 1, 15, 16, 17, 31, 32, 33, 100] {
        let labels: Vec<u64> = (0..n as u64).map(|i| i.wrapping_mul(0x9E37_79B9_7F4A_7C15)).collect();
        let mut philox = Philox::new(11);
        let (mut batch, mut batch32) = (vec![[0.0_f64; 2]; n], vec![[0.0_f32; 2]; n]);
        normals_of_labels(&mut philox, &labels, 4, 5, &mut batch).unwrap();
        normals_of_labels(&mut philox, &labels, 4, 5, &mut batch32).unwrap();
        let mut count = Count(0);
        let mut stream = vec![[0.0_f64; 2]; n];
        normals_of_labels(&mut count, &labels, 4, 5, &mut stream).unwrap();
        for (i, &label) in labels.iter().enumerate() {
            let (mut words, mut one, mut one32) = ([0; 2], [0.0_f64; 2], [0.0_f32; 2]);
            philox.fill(label, 4, 5, &mut words).unwrap();
            normals(&words, &mut one);
            normals(&words, &mut one32);
            assert_eq!((one, one32), (batch[i], batch32[i]));
            let i = i as u64;
            normals(&[(2 * i + 1) << 40, (2 * i + 2) << 40], &mut one);
            assert_eq!(one, stream[i as usize]);
        }
        assert_eq!(
            normals_of_labels(&mut philox, &labels, 4, 5, &mut vec![[0.0_f64; 2]; n + 1]),
            Err(crate::Error::LengthMismatch)
        );
    }
    let mut out = [[0.0_f64; 2]; 2];
    assert_eq!(normals_of_labels(&mut Count(0), &[1, 13], 0, 0, &mut out), Err(crate::Error::Generator));
}

#[test]
fn any_rand_core_generator_is_one_stream() {
    /// SplitMix64 (Steele, Lea & Flood 2014).
    struct Split(u64);
    impl rand_core::TryRng for Split {
        type Error = core::convert::Infallible;
        fn try_next_u32(&mut self) -> core::result::Result<u32, Self::Error> {
            self.try_next_u64().map(|w| w as u32)
        }
        fn try_next_u64(&mut self) -> core::result::Result<u64, Self::Error> {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            Ok(z ^ z >> 31)
        }
        fn try_fill_bytes(&mut self, out: &mut [u8]) -> core::result::Result<(), Self::Error> {
            out.fill(0);
            Ok(())
        }
    }
    let (mut once, mut twice) = (Stream(Split(1)), Stream(Split(1)));
    let (mut long, mut short) = ([0; 6], [0; 3]);
    once.fill(0, 0, 0, &mut long).unwrap();
    twice.fill(9, 9, 9, &mut short).unwrap();
    assert_eq!(short, long[..3]);
    twice.fill(9, 9, 9, &mut short).unwrap();
    assert_eq!(short, long[3..]);
    assert!(once.counter_based().is_none());
}
