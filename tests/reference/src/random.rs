//! Philox4x32-10 one word at a time, and Box & Muller's formula with the functions of the standard library.

/// Four 32-bit words from a counter and a key (Salmon et al. 2011, Section 3.3).
#[must_use]
pub fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let ([mut a, mut b, mut c, mut d], [mut k, mut l]) = (counter, key);
    for _ in 0..10 {
        let p = 0xD251_1F53_u64 * u64::from(a);
        let q = 0xCD9E_8D57_u64 * u64::from(c);
        (a, b, c, d) = ((q >> 32) as u32 ^ b ^ k, q as u32, (p >> 32) as u32 ^ d ^ l, p as u32);
        k = k.wrapping_add(0x9E37_79B9);
        l = l.wrapping_add(0xBB67_AE85);
    }
    [a, b, c, d]
}

/// The first `n` 64-bit words for (seed, label, step, substep).
#[must_use]
pub fn words(seed: u64, label: u64, step: u32, substep: u32, n: usize) -> Vec<u64> {
    let block = |key: u64, label: u64, step: u32, substep: u32| {
        let [a, b, c, d] =
            philox([label as u32, (label >> 32) as u32, step, substep], [key as u32, (key >> 32) as u32]);
        [u64::from(b) << 32 | u64::from(a), u64::from(d) << 32 | u64::from(c)]
    };
    (0..n)
        .map(|i| {
            let b = i as u64 / 2;
            let key = if b == 0 { seed } else { block(seed, b, u32::MAX, u32::MAX)[0] };
            block(key, label, step, substep)[i % 2]
        })
        .collect()
}

/// Two normals and their radius from two words.
#[must_use]
pub fn normals(words: [u64; 2]) -> ([f64; 2], f64) {
    let u = ((words[0] >> 12) as f64 + 0.5) / 2.0_f64.powi(52);
    let radius = (-2.0 * u.ln()).sqrt();
    // The two high bits give the quarter of the circle. The remaining bits give the angle from the middle of the quarter.
    let x = ((words[1] << 2 >> 12) as f64 + 0.5) / 2.0_f64.powi(52) - 0.5;
    let (s, c) = (x * std::f64::consts::FRAC_PI_2).sin_cos();
    let [c, s] = [[c, s], [-s, c], [-c, -s], [s, -c]][(words[1] >> 62) as usize];
    ([radius * c, radius * s], radius)
}
