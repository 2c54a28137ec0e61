//! The functions of few arguments.

use std::ffi::CStr;

use mollis_abi::*;

use super::Calls;
use super::forms::Form;
use super::host::Run;

/// Fills a structure of options of any stated size.
macro_rules! init {
    ($calls:ident, $init:ident) => {{
        let size = usize::from($calls.draw.byte());
        let size = if $calls.draw.rarely(8) { usize::MAX - size } else { size };
        let held = if size > 300 { 0 } else { size };
        let words = vec![0_u64; held.div_ceil(8)];
        let start = $calls.pointer(&words, crate::memory::Role::Output);
        $calls.begin();
        // SAFETY: null, misaligned, or of this size; a size that is none of a structure's is refused.
        let status = unsafe { mollis_abi::$init(start.cast(), size) };
        $calls.end(stringify!($init), status);
    }};
}

impl Calls<'_, '_> {
    pub fn mollifier<T: Form<D>, const D: usize>(&mut self) {
        let (shape, delta, n) = (self.shape(), T::of(self.delta()), self.draw.below(20));
        let seven = T::of(7.0);
        let kind = self.draw.below(5);
        if kind == 0 {
            let x = self.points::<T, D>(n);
            let (x, stated) = (self.input(&x), self.stated(n));
            let (density, potential) = (self.perhaps(n, seven), self.perhaps(n, seven));
            let (gradient, hessian) = (self.perhaps(n, [seven; D]), self.perhaps(n, [[seven; D]; D]));
            self.begin();
            // SAFETY: every pointer is null, misaligned, or has its length.
            let status = unsafe { T::mollifier_field(shape, delta, stated, x, density, potential, gradient, hessian) };
            return self.end("mollifier_field", status);
        }
        if kind == 1 {
            let k = self.draw.pick(&[0, 1, 2, 7, 64, 65, u32::MAX]);
            let value = self.output(1, seven);
            self.begin();
            // SAFETY: as above.
            let status = unsafe { T::mollifier_moment(shape, delta, k, value) };
            return self.end("mollifier_moment", status);
        }
        let r = self.numbers::<T>(n);
        let (r, stated) = (self.input(&r), self.stated(n));
        if kind == 2 {
            let values = self.output(n, seven);
            self.begin();
            // SAFETY: as above.
            let status = unsafe { T::heaviside(shape, delta, stated, r, values) };
            return self.end("heaviside", status);
        }
        let [a, b, c, d, e, f] = std::array::from_fn(|_| self.perhaps(n, seven));
        if kind == 3 {
            self.begin();
            // SAFETY: as above.
            let status = unsafe { T::mollifier_eval(shape, delta, stated, r, a, b, c, d, e, f) };
            return self.end("mollifier_eval", status);
        }
        let parts = if self.draw.tame { 1 + self.draw.below(4) } else { self.draw.below(6) };
        let usual: Vec<T> =
            [1.0, 0.5, 0.75, 0.25, 0.125, 0.1][..parts].iter().map(|&x| T::of(self.draw.or_wild(x))).collect();
        let (radii, weights) = (self.input(&usual), self.perhaps(parts, seven));
        let parts = self.stated(parts);
        self.begin();
        // SAFETY: as above.
        let status =
            unsafe { T::mollifier_richardson(shape, delta, parts, radii, weights, stated, r, a, b, c, d, e, f) };
        self.end("mollifier_richardson", status);
    }

    pub fn diagnostics<T: Form<D>, const D: usize>(&mut self) {
        let n = self.draw.count();
        let (seven, stated) = (T::of(7.0), self.stated(n));
        let (x, m) = (self.points::<T, D>(n), self.numbers::<T>(n));
        let (x, m) = (self.input(&x), self.input(&m));
        match self.draw.below(4) {
            0 => {
                let [mass, absolute, second] = std::array::from_fn(|_| self.perhaps(1, seven));
                let centre = self.perhaps(1, [seven; D]);
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::moments(stated, x, m, mass, absolute, centre, second) };
                self.end("moments", status);
            }
            1 => {
                let (block, step) = (self.kernel::<T, D>(), self.output(1, seven));
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::stable_step(block.start, block.bytes, stated, x, m, step) };
                self.end("stable_step", status);
                // SAFETY: written.
                assert!(status != 0 || unsafe { (*step).into() } > 0.0, "stable_step: not positive");
            }
            2 => {
                let (block, step) = (self.kernel::<T, D>(), self.output(1, seven));
                let (mass, diameter) = (self.draw.positive(), self.draw.positive());
                let (mass, diameter) = (T::of(self.draw.or_wild(mass)), T::of(self.draw.or_wild(diameter)));
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::stable_step_anywhere(block.start, block.bytes, mass, diameter, step) };
                self.end("stable_step_anywhere", status);
                // SAFETY: written.
                assert!(status != 0 || unsafe { (*step).into() } > 0.0, "stable_step_anywhere: not positive");
            }
            _ => {
                let densities = self.numbers::<T>(n);
                let (densities, delta) = (self.input(&densities), T::of(self.delta()));
                let smallest = self.output(1, seven);
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::overlap(stated, delta, m, densities, smallest) };
                self.end("overlap", status);
            }
        }
    }

    pub fn norms<T: Form<D>, const D: usize>(&mut self) {
        let n = self.draw.count();
        let (norm, stated) = (self.output(1, T::of(7.0)), self.stated(n));
        let (cell, p) = (self.draw.or_wild(0.5), self.draw.pick(&[1.0, 2.0, f64::INFINITY, 1.5]));
        let (cell, p) = (T::of(cell), T::of(self.draw.or_wild(p)));
        match self.draw.below(4) {
            0 => {
                let values = self.numbers::<T>(n);
                let values = self.input(&values);
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::norm(stated, values, cell, p, norm) };
                self.end("norm", status);
            }
            1 => {
                let (a, b) = (self.points::<T, D>(n), self.points::<T, D>(n));
                let (a, b) = (self.input(&a), self.input(&b));
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::distance_norm(stated, a, b, cell, p, norm) };
                self.end("distance_norm", status);
            }
            2 => {
                let each = self.draw.below(5);
                let values = self.numbers::<T>(n * each);
                let (values, first) = (self.input(&values), self.output(1, 7_u64));
                let each = self.stated(each);
                self.begin();
                // SAFETY: as above.
                let status = unsafe { T::first_bad(if each > 5 { n } else { stated }, each, values, first) };
                self.end("first_bad", status);
            }
            _ => self.dual_norm::<T, D>(norm),
        }
    }

    fn dual_norm<T: Form<D>, const D: usize>(&mut self, norm: *mut T) {
        let mut points: [usize; D] = std::array::from_fn(|_| self.draw.below(6));
        let mut margin = self.draw.below(4);
        let held = points.iter().product();
        let huge = !self.draw.tame && self.draw.rarely(12);
        if huge {
            let large = self.draw.pick(&[usize::MAX, 1 << 40, 1 << 62]);
            if self.draw.rarely(2) { margin = large } else { points[0] = large }
        }
        let (numbers, points) = (self.numbers::<T>(held), self.input(&[points]));
        let (values, needed) = (self.input(&numbers), self.output(1, 0_usize));
        self.begin();
        // SAFETY: as above.
        let asked = unsafe { T::dual_norm_bytes(points, margin, needed) };
        self.end("dual_norm_bytes", asked);
        if huge {
            return;
        }
        // SAFETY: written, as the query succeeded.
        let bytes = (asked == 0).then(|| unsafe { *needed });
        let Some((workspace, room, enough)) = self.workspace(bytes) else { return };
        let spacing = T::of(self.draw.or_wild(0.25));
        self.begin();
        // SAFETY: as above.
        let status = unsafe { T::dual_norm(points, spacing, margin, values, norm, workspace, room) };
        self.end("dual_norm", status);
        self.room("dual_norm", status, bytes, (room, enough), &Run::none());
    }

    pub fn without_form(&mut self) {
        let n = self.draw.count();
        let stated = self.stated(n);
        match self.draw.below(9) {
            0 => init!(self, mollis_run_init),
            1 => init!(self, mollis_field_options_init),
            2 => init!(self, mollis_blob_options_init),
            3 => match self.draw.below(2) {
                0 => init!(self, mollis_grid2_options_init),
                _ => init!(self, mollis_pks_options_init),
            },
            4 => {
                let mut numbers = || self.draw.wild();
                let [mass, mu, chi, moment] = std::array::from_fn(|_| numbers());
                let heavy = self.draw.numbers(n, true);
                let none = mollis_pks_prediction { critical_mass: 7.0, blow_up_bound: 7.0, second_moment_rate: 7.0 };
                let (heavy, out) = (self.input(&heavy), self.output(1, none));
                self.begin();
                // SAFETY: as above.
                let status = unsafe { mollis_pks_predict(mass, mu, chi, moment, stated, heavy, out) };
                self.end("pks_predict", status);
            }
            5 => {
                let masses = self.draw.numbers(n, true);
                let [chi, noise, gamma] = std::array::from_fn(|_| self.draw.or_wild(1.0));
                let (masses, index) = (self.input(&masses), self.output(3, 7.0));
                self.begin();
                // SAFETY: as above.
                let status = unsafe { mollis_pks_index(stated, masses, chi, noise, gamma, index) };
                self.end("pks_index", status);
            }
            6 => {
                let numbers = self.draw.numbers(3 * n, true);
                let species: Vec<_> = numbers
                    .chunks_exact(3)
                    .map(|x| mollis_pks_species { mass: x[0], mu: x[1], sensitivity: x[2] })
                    .collect();
                let species = self.input(&species);
                let (share, noise, rate) = (self.perhaps(n, 7.0), self.perhaps(1, 7.0), self.perhaps(1, 7.0));
                let particles = self.draw.pick(&[100, 0, 1, usize::MAX]);
                let chi = self.draw.or_wild(1.0);
                self.begin();
                // SAFETY: as above.
                let status =
                    unsafe { mollis_pks_represent_species(stated, species, chi, particles, share, noise, rate) };
                self.end("pks_represent_species", status);
            }
            7 => {
                let words: Vec<u64> = (0..=n).map(|k| [0, u64::MAX, k as u64, (k as u64) << 50][k % 4]).collect();
                let (step, substep) = (self.draw.pick(&[0, 1, u32::MAX]), self.draw.pick(&[0, 3, u32::MAX]));
                match self.draw.below(3) {
                    0 => {
                        let out = self.output(n, 7_u64);
                        let (seed, label) = (self.draw.word(), self.draw.word());
                        self.begin();
                        // SAFETY: as above.
                        let status = unsafe { mollis_philox_words(seed, label, step, substep, stated, out) };
                        self.end("philox_words", status);
                    }
                    1 => self.normals::<f64>(n, stated, &words, (step, substep)),
                    _ => self.normals::<f32>(n, stated, &words, (step, substep)),
                }
            }
            _ => {
                let status = self.draw.pick(&[0, -1, 5, 47, 48, i32::MAX, i32::MIN]);
                let text = mollis_status_text(status);
                // SAFETY: never null, and ends with a zero.
                assert!(!unsafe { CStr::from_ptr(text) }.is_empty());
                assert_eq!(mollis_abi_version(), 1);
            }
        }
    }

    fn normals<T: super::forms::Scalar>(&mut self, n: usize, stated: usize, words: &[u64], at: (u32, u32)) {
        let (words, seven) = (self.input(&words[..n + n % 2]), T::of(7.0));
        let (plain, pairs) = (self.output(n, seven), self.output(n, [seven; 2]));
        let seed = self.draw.word();
        self.begin();
        // SAFETY: as above.
        let status = unsafe { T::normals(stated, words, plain) };
        self.end("normals", status);
        if status == 0 {
            // SAFETY: written.
            let fine = (0..n).all(|k| unsafe { (*plain.add(k)).into() }.abs() <= 8.58);
            assert!(fine, "normals: beyond their range");
        }
        self.begin();
        // SAFETY: as above.
        let status = unsafe { T::philox_normals(seed, stated, words, at.0, at.1, pairs) };
        self.end("philox_normals", status);
    }
}
