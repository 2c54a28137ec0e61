//! Sums without pairs: `mollis-bench skips`.
//!
//! Prints the best of several runs on one core and the limit. Ends with an error if a limit is exceeded.

use mollis_core::exec::Run;
use mollis_core::field::{Options, Outputs, Sources, Wanted, evaluate, plan};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;

use crate::field::cpu_time;
use crate::scene::aligned;

const N: usize = 1_000_000;

fn numbers(n: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..n).map(|_| next()).collect()
}

/// The least time of an evaluation of the gradient, in seconds, over half a second of evaluations and at least five.
fn time<const D: usize>(law: Law, mollifier: Mollifier, delta: f64) -> f64 {
    let terms = [Term { law, coefficient: 1.0 }];
    let values = numbers(D * N);
    let positions: Vec<[f64; D]> = values.as_chunks::<D>().0.to_vec();
    let masses = vec![1.0 / N as f64; N];
    let bytes = Kernel::<f64, D>::workspace_bytes(&terms, mollifier).expect("a good kernel");
    let mut block = vec![0_u8; bytes + 64];
    let kernel = Kernel::<f64, D>::prepare(aligned(&mut block), &terms, mollifier, delta).expect("prepared");
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    let plan = plan(&kernel, N, N, wanted, &Options::default()).expect("a plan");
    let bytes = plan.workspace_bytes(1).expect("a size");
    let mut workspace = vec![0_u8; bytes + 64];
    let memory = aligned(&mut workspace);
    let mut gradient = vec![[0.0; D]; positions.len()];
    let (start, mut count) = (std::time::Instant::now(), 0);
    let best = std::iter::repeat_with(|| {
        let outputs = Outputs { gradient: Some(&mut gradient[..]), ..Outputs::default() };
        let sources = Sources::new(&positions, &masses);
        let begin = cpu_time();
        evaluate(&plan, &kernel, sources, &positions, outputs, memory, &mut Run::default()).expect("a sum");
        (cpu_time() - begin).as_secs_f64()
    });
    let best = best.take_while(|_| {
        count += 1;
        count <= 5 || start.elapsed().as_secs_f64() < 0.5
    });
    let best = best.fold(f64::INFINITY, f64::min);
    println!("{D}D {law:?} {mollifier:?}: {:?}, {best:.4} s for {N} particles", plan.method());
    best
}

/// Measures all sums. An error if a limit is exceeded.
pub fn run() -> anyhow::Result<()> {
    let compact = Mollifier::Compact { order: 4, exponent: 4 };
    let cubic = Law::Power { exponent: 3.0 };
    let quartic = Law::Power { exponent: 4.0 };
    // delta = 4 spacings: h^0.9 for h = 1e-6
    let delta = 4e-6;
    let results = [
        (time::<1>(Law::Newtonian, Mollifier::None, delta), 0.25),
        (time::<1>(Law::Newtonian, compact, delta), 0.25),
        (time::<1>(cubic, compact, delta), 0.25),
        (time::<2>(quartic, Mollifier::None, delta), 0.01),
        (time::<2>(quartic, compact, 1e-3), 0.01),
    ];
    let missed = results.iter().filter(|(seconds, limit)| seconds > limit).count();
    println!("{missed} of {} limits missed", results.len());
    anyhow::ensure!(missed == 0, "a limit was missed");
    Ok(())
}
