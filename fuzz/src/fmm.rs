//! The fast multipole method, and the sum over all pairs, against sums in double-double arithmetic: the error that the header promises.

use std::f64::consts::TAU;

use mollis_core::exec::Run;
use mollis_core::field::{self, Method, Options, Outputs, Sources, Wanted};
use mollis_core::kernel::Kernel;
use mollis_core::mollifier::Mollifier;
use mollis_reference::field::{Dd, Soft, newtonian};

use crate::draw::Draw;

const WANTED: Wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };

/// Points in a few clumps of any size, some of them in one place.
fn points(draw: &mut Draw<'_>, n: usize) -> Vec<[f64; 2]> {
    let clumps = 1 + draw.below(4);
    let mut out: Vec<[f64; 2]> = Vec::new();
    for clump in 0..clumps {
        let centre = [draw.plain(), draw.plain()];
        let size = 2_f64.powi(-i32::from(draw.byte() % 48));
        let line = draw.rarely(4);
        let numbers = draw.numbers(2 * n / clumps, false);
        for x in numbers.chunks_exact(2) {
            let x = if line { [x[0], x[0]] } else { [x[0], x[1]] };
            out.push([0, 1].map(|k| centre[k] + size * x[k]));
        }
        for _ in 0..draw.below(6) {
            out.push([0, 1].map(|k| centre[k] + size * draw.plain()));
        }
        if clump > 0 && !out.is_empty() && draw.rarely(3) {
            let last = out.len() - 1;
            out[last] = out[0];
        }
    }
    // In other units the sums are others; all lengths stay where squares are in range.
    let unit = 2_f64.powi(draw.pick(&[0, 0, 0, 1, -20, 30, -200, 200]));
    out.iter_mut().flatten().for_each(|x| *x *= unit);
    out
}

/// The sum of some points and masses.
pub fn fmm(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let tolerance = draw.pick(&[1e-3, 1e-6, 1e-9, 1e-12, 1e-13, 0.1]);
    let soft = match draw.below(3) {
        0 => None,
        _ => Some((draw.pick(&[2, 4]), draw.pick(&[4_u32, 1, 2, 9]))),
    };
    let delta = 2_f64.powi(i32::from(draw.byte() % 24) - 16);
    let n = usize::from(draw.byte()) * 2;
    let x = points(&mut draw, n);
    let n = x.len();
    let mut m = draw.numbers(n, false);
    if draw.rarely(3) {
        m.iter_mut().for_each(|m| *m = m.abs());
    }
    let with_radii = soft.is_some() && draw.rarely(4);
    let radii: Vec<f64> = if with_radii { draw.numbers(n, true) } else { Vec::new() };
    // Some of the sources, and points among them.
    let mut targets: Vec<[f64; 2]> =
        (0..20).map(|_| if n > 0 { x[usize::from(draw.byte()) * 7 % n] } else { [0.0; 2] }).collect();
    for target in targets.iter_mut().step_by(3) {
        let scale = target[0].abs().max(target[1].abs());
        *target = [0, 1].map(|k| target[k] + scale * draw.plain());
    }

    if std::env::var_os("MOLLIS_FUZZ_LOG").is_some() {
        eprintln!("tolerance {tolerance:e}, mollifier {soft:?}, delta {delta:e}, radii {radii:?}");
        eprintln!("sources {x:?}\nmasses {m:?}\ntargets {targets:?}");
    }
    let sources = Sources::new(&x, &m);
    let sources = if with_radii { sources.with_radii(&radii) } else { sources };
    let mollifier = soft.map_or(Mollifier::None, |(order, exponent)| Mollifier::Compact { order, exponent });
    let kernel = Kernel::<f64, 2>::newtonian(1.0, mollifier, delta).expect("a sound kernel");
    let exact = Exact::of(&x, &m, &targets, |j| {
        soft.map(|(order, exponent)| Soft { order, exponent, delta: if with_radii { radii[j] } else { delta } })
    });
    let rounding = (112.0 + 256.0 + n as f64 / 256.0) * 0.5 * f64::EPSILON;
    for (method, tolerance, allowed) in
        [(Method::Direct, 0.0, rounding), (Method::Fmm, tolerance, tolerance + rounding)]
    {
        let options = Options { method: Some(method), tolerance, radii: with_radii, ..Options::default() };
        let plan = field::plan(&kernel, n, targets.len(), WANTED, &options).expect("a sound plan");
        let mut memory = vec![0xA5; plan.workspace_bytes(1).expect("few") + 64];
        let start = memory.as_ptr().align_offset(64);
        let mut got =
            (vec![f64::NAN; targets.len()], vec![[f64::NAN; 2]; targets.len()], vec![f64::NAN; targets.len()]);
        let outputs = Outputs {
            potential: Some(&mut got.0),
            gradient: Some(&mut got.1),
            laplacian: Some(&mut got.2),
            hessian: None,
        };
        field::evaluate(&plan, &kernel, sources, &targets, outputs, &mut memory[start..], &mut Run::default())
            .expect("sound arguments");
        exact.check(&format!("{method:?} {tolerance:e}"), &got.0, &got.1, allowed);
        assert!(got.2.iter().all(|x| x.is_finite()), "{method:?}: a Laplacian is not finite");
    }
}

/// The sums, and those of magnitudes.
struct Exact {
    potential: Vec<(f64, f64)>,
    gradient: Vec<([f64; 2], f64)>,
}

impl Exact {
    fn of(x: &[[f64; 2]], m: &[f64], targets: &[[f64; 2]], soft: impl Fn(usize) -> Option<Soft>) -> Self {
        let (mut potential, mut gradient) = (Vec::new(), Vec::new());
        for target in targets {
            let (mut u, mut g, mut sizes) = (Dd::default(), [Dd::default(); 2], [0.0; 2]);
            for (j, (x, &m)) in x.iter().zip(m).enumerate() {
                let pair = newtonian::<2>(soft(j), &[*x], &[m], target);
                u = u + pair.potential;
                g = [g[0] + pair.gradient[0], g[1] + pair.gradient[1]];
                sizes[0] += pair.potential_size;
                sizes[1] += pair.gradient_size[0].hypot(pair.gradient_size[1]);
                // A kernel that vanishes at some distance is computed with the rounding of 1 / (2 pi).
                sizes[0] += m.abs() / TAU;
            }
            potential.push((u.value(), sizes[0]));
            gradient.push((g.map(Dd::value), sizes[1]));
        }
        Self { potential, gradient }
    }

    /// Errors in the l2 norm over the targets.
    fn check(&self, what: &str, potential: &[f64], gradient: &[[f64; 2]], allowed: f64) {
        // Relative to the largest, so that squares are in range.
        let ratio = |errors: Vec<f64>, sizes: Vec<f64>| {
            let largest = sizes.iter().copied().fold(0.0, f64::max);
            let square = |all: Vec<f64>| all.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt();
            if largest == 0.0 { errors.iter().copied().fold(0.0, f64::max) } else { square(errors) / square(sizes) }
        };
        let errors = potential.iter().zip(&self.potential).map(|(got, (want, _))| (got - want).abs()).collect();
        let error = ratio(errors, self.potential.iter().map(|(_, size)| *size).collect());
        assert!(error <= allowed, "{what}: potential off by {error:e}, allowed {allowed:e}");
        let errors = gradient.iter().zip(&self.gradient).map(|(g, (w, _))| (g[0] - w[0]).hypot(g[1] - w[1])).collect();
        let error = ratio(errors, self.gradient.iter().map(|(_, size)| *size).collect());
        assert!(error <= allowed, "{what}: gradient off by {error:e}, allowed {allowed:e}");
    }
}
