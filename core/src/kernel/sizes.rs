//! The sizes that errors of a host's kernel are relative to: those of sums from tables (module `field::pairs::tabulated`).

/// Parts of an octave, so many that even steep kernels change little in one.
const PARTS: usize = 64;
/// 2^(1 / PARTS).
const PART: f64 = 1.010_889_286_051_700_5;

/// |K| or r^2 |K'/r| if that is larger (a logarithm is zero somewhere), |K'/r|, and the larger of |Laplacian| and D |K'/r|.
pub(crate) fn magnitudes<const D: usize>(r: f64, [value, factor, laplacian]: [f64; 3]) -> [f64; 3] {
    let factor = factor.abs();
    [value.abs().max(r * (r * factor)), factor, laplacian.abs().max(D as f64 * factor)]
}

/// The larger of each.
pub(crate) fn larger(most: [f64; 3], other: [f64; 3]) -> [f64; 3] {
    let ([a, b, c], [x, y, z]) = (most, other);
    [a.max(x), b.max(y), c.max(z)]
}

/// The largest magnitudes at distances from r/2 to r, and to delta from zero where r < delta, as far as they have been seen: distances ascend.
#[derive(Clone)]
pub(crate) struct Sizes {
    /// delta, and the largest magnitudes below it.
    inside: (f64, [f64; 3]),
    /// Those at the last distances, each for a part of an octave of r; all but one of an octave, so that no size is too large.
    parts: [[f64; 3]; PARTS - 1],
    /// Where the current part ends.
    end: f64,
    /// No size is smaller.
    least: [f64; 3],
}

impl Sizes {
    /// `inside`: delta, or 0 without a mollifier, and the magnitudes below it. Smaller sizes than `least` count as that.
    pub(crate) fn new(inside: (f64, [f64; 3]), least: [f64; 3]) -> Self {
        Self { inside, parts: [[0.0; 3]; PARTS - 1], end: 0.0, least }
    }

    /// The sizes at r, where the magnitudes are these.
    pub(crate) fn at(&mut self, r: f64, magnitudes: [f64; 3]) -> [f64; 3] {
        if r >= self.end {
            let mut steps = 0;
            if self.end == 0.0 {
                self.end = r;
            }
            while r >= self.end && steps < PARTS {
                self.parts.rotate_right(1);
                self.parts.iter_mut().take(1).for_each(|part| *part = [0.0; 3]);
                self.end *= PART;
                steps += 1;
            }
            if r >= self.end {
                self.end = r * PART;
            }
        }
        self.parts.iter_mut().take(1).for_each(|part| *part = larger(*part, magnitudes));
        let seen = self.parts.iter().fold(self.least, |most, &part| larger(most, part));
        if r < self.inside.0 { larger(seen, self.inside.1) } else { seen }
    }
}

/// The larger of the errors so far and of those at one distance, relative to the sizes.
pub(crate) fn relative_errors(worst: [f64; 3], got: [f64; 3], want: [f64; 3], sizes: [f64; 3]) -> [f64; 3] {
    let mut worst = worst;
    for ((worst, size), (got, want)) in worst.iter_mut().zip(sizes).zip(got.into_iter().zip(want)) {
        let error = (got - want).abs();
        // A NaN counts.
        if error.is_nan() || error > *worst * size {
            *worst = if size > 0.0 && error.is_finite() { error / size } else { f64::INFINITY };
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_the_last_octave() {
        // 1/r: the size at r is nearly that at r/2, and never more.
        let mut sizes = Sizes::new((0.0, [0.0; 3]), [1e-3; 3]);
        let mut r = 1e-3;
        while r < 4e3 {
            let [size, _, least] = sizes.at(r, [1.0 / r, 0.0, 0.0]);
            let largest = (1.0 / r.max(1e-3)).max(2.0 / r).max(1e-3);
            assert!(size <= largest && (r < 2e-3 || size > 0.9 * largest), "{r} {size}");
            assert_eq!(least, 1e-3);
            r *= 1.003;
        }
        // Below delta what is known of it counts.
        let mut sizes = Sizes::new((1.0, [5.0; 3]), [0.0; 3]);
        assert_eq!(sizes.at(0.5, [1.0; 3]), [5.0; 3]);
        assert_eq!(sizes.at(1.5, [1.0; 3]), [1.0; 3]);
    }

    #[test]
    fn a_nan_is_an_error() {
        let errors = relative_errors([0.0; 3], [f64::NAN, 1.0, 2.0], [1.0; 3], [1.0, 1.0, 4.0]);
        assert_eq!(errors, [f64::INFINITY, 0.0, 0.25]);
    }
}
