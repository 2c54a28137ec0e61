//! Coalescing particles of a Patlak-Keller-Segel equation: 200 particles, twice the critical mass, merge until one holds nearly everything.
//!
//!     cargo run --release -p mollis-core --example coalescing_particles
#![allow(clippy::disallowed_methods, reason = "a program with std")]

use mollis_core::Result;
use mollis_core::exec::Run;
use mollis_core::field;
use mollis_core::kernel::Kernel;
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;
use mollis_core::pks::{self, Attraction, Counters, Event, Events, Options, Setting, State};
use mollis_core::random::Philox;

fn main() -> Result<()> {
    // Zhelezov & Fatkullin (1.3): dX = -chi grad sum m V dt + sqrt(2 mu / m) dW. With mu = (total mass) / n the density diffuses with 1.
    let (n, chi) = (200_u32, 1.0);
    let total = 16.0 * std::f64::consts::PI / chi;
    let noise = total / f64::from(n);
    let mut x: Vec<[f64; 2]> =
        (1..=n).map(|k| [0.754_877_666, 0.569_840_291].map(|a| (a * f64::from(k)).fract() - 0.5)).collect();
    let mut mass = vec![total / f64::from(n); x.len()];
    let mut labels: Vec<u64> = (0..u64::from(n)).collect();

    // The attraction is a sum over all particles; the mollifier bounds the speed at small distances.
    let kernel = Kernel::<f64, 2>::newtonian(1.0, Mollifier::Compact { order: 2, exponent: 4 }, 1e-3)?;
    let sum = field::Options::default();
    let options = Options::new(chi, noise);
    let bytes = pks::workspace_bytes(x.len(), Some((&kernel, &sum)), &options, 1)?;
    let mut memory = vec![0; bytes + ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN);

    let mut generator = Philox::new(2016);
    let mut counters = Counters { count: u64::from(n), ..Counters::default() };
    let (mut log, mut absorbed) = (vec![Event::default(); x.len()], vec![0; x.len()]);
    for step in 0..120 {
        let (mut written, mut labels_written) = (0, 0);
        let events = Events {
            events: &mut log,
            written: &mut written,
            labels: &mut absorbed,
            labels_written: &mut labels_written,
        };
        let state = State { positions: &mut x, masses: &mut mass, labels: &mut labels, species: None, weights: None };
        let setting = Setting {
            options: &options,
            attraction: Attraction::Sum(&kernel, &sum),
            run: &mut Run::default(),
            report: None,
        };
        let workspace = &mut memory[start..start + bytes];
        pks::step(state, &mut counters, &mut generator, 1e-3, events, workspace, setting)?;
        if step % 24 == 23 {
            let alive = counters.count as usize;
            let largest = mass[..alive].iter().copied().fold(0.0, f64::max);
            println!(
                "t = {:.2}: {alive} particles, the largest holds {:.0}% of the mass",
                counters.time,
                100.0 * largest / total
            );
        }
    }
    Ok(())
}
