//! The bits of results that are the same on every machine: sums at level `portable`, and functions without a level (fits of kernels, normals,
//! mesh fields, coalescing particles).
//!
//! The numbers were printed by this test on x86-64. `cargo xtask neon` runs it on aarch64.

use mollis_core::Real;
use mollis_core::exec::{Run, Serial};
use mollis_core::field::{self, Options, Outputs, Sources, Wanted};
use mollis_core::grid::{Equation, Grid, Mesh, Order};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::Mollifier;
use mollis_core::pks::{self, Attraction, Counters, Event, Events, Setting, State, theory};
use mollis_core::random::Philox;
use mollis_core::simd::Level;
use mollis_tests::Aligned;

/// A hash of the bits in order (FNV-1a, one word at a time).
struct Hash(u64);
impl Hash {
    fn add<T: Real>(&mut self, numbers: &[T]) {
        for x in numbers {
            self.0 = (self.0 ^ x.to_f64().to_bits()).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(7);
        }
    }
}

fn cloud<T: Real, const D: usize>(n: usize, step: u32) -> Vec<[T; D]> {
    let labels: Vec<u64> = (0..n as u64).collect();
    let (mut a, mut b) = (vec![[T::ZERO; 2]; n], vec![[T::ZERO; 2]; n]);
    Philox::new(11).normals(&labels, step, 0, &mut a);
    Philox::new(11).normals(&labels, step, 1, &mut b);
    a.iter().zip(&b).map(|(a, b)| std::array::from_fn(|k| [a[0], a[1], b[0]][k])).collect()
}

fn sums<T: Real, const D: usize>(kernel: &Kernel<'_, T, D>) -> u64 {
    let (sources, targets) = (cloud::<T, D>(333, 1), cloud::<T, D>(77, 2));
    let masses: Vec<T> = cloud::<T, 1>(333, 3).iter().map(|&[m]| m).collect();
    let wanted = Wanted { potential: true, gradient: true, laplacian: true, hessian: false };
    let plan = field::plan(kernel, sources.len(), targets.len(), wanted, &Options::default()).unwrap();
    let mut memory = Aligned::new(plan.workspace_bytes(1).unwrap());
    let (mut potential, mut gradient, mut laplacian) = (vec![T::ZERO; 77], vec![[T::ZERO; D]; 77], vec![T::ZERO; 77]);
    let outputs = Outputs {
        potential: Some(&mut potential),
        gradient: Some(&mut gradient),
        laplacian: Some(&mut laplacian),
        hessian: None,
    };
    let mut run = Run { level: Level::Portable, ..Run::default() };
    let sources = Sources::new(&sources, &masses);
    field::evaluate(&plan, kernel, sources, &targets, outputs, memory.bytes(), &mut run).unwrap();
    let mut hash = Hash(0);
    hash.add(&potential);
    hash.add(gradient.as_flattened());
    hash.add(&laplacian);
    hash.0
}

fn newtonian<T: Real, const D: usize>(order: u32) -> u64 {
    let mollifier = Mollifier::Compact { order, exponent: 3 };
    sums(&Kernel::<T, D>::newtonian(T::ONE, mollifier, T::from_f64(0.3)).unwrap())
}

fn fitted<T: Real, const D: usize>() -> u64 {
    let terms = [
        Term { law: Law::Power { exponent: 1.5 }, coefficient: 1.0 },
        Term { law: Law::Exponential { length: 0.7 }, coefficient: -2.0 },
        Term { law: Law::Screened { k: 1.3 }, coefficient: 0.5 },
    ];
    let mollifier = Mollifier::Compact { order: 4, exponent: 3 };
    let mut memory = Aligned::new(Kernel::<T, D>::workspace_bytes(&terms, mollifier).unwrap());
    sums(&Kernel::<T, D>::prepare(memory.bytes(), &terms, mollifier, T::from_f64(0.3)).unwrap())
}

/// Fifty steps of coalescing particles. Also returns the number that is left.
fn coalescing<T: Real>(order: Order) -> (u64, u64) {
    let (n, mass) = (1500, T::from_f64(60.0));
    let mut positions: Vec<[T; 2]> = cloud(n, 4);
    let mut masses = vec![mass / T::from_usize(n); n];
    let mut labels: Vec<u64> = (0..n as u64).collect();
    let c = T::from_f64;
    let mesh = Mesh::new([c(-3.0); 2], [c(3.0); 2], [48; 2]).unwrap();
    let options = pks::Options::new(T::ONE, theory::noise(mass, T::ONE, n));
    let equation = Equation { order, ..Equation::POISSON };
    let mut grid_memory = Aligned::new(Grid::workspace_bytes(&mesh, &equation, 1).unwrap());
    let mut grid = Grid::prepare(grid_memory.bytes(), mesh, equation, 1).unwrap();
    let mut memory = Aligned::new(pks::workspace_bytes(n, None, &options, 1).unwrap());
    let (mut log, mut absorbed) = (vec![Event::default(); n], vec![0; n]);
    let mut counters = Counters { count: n as u64, ..Counters::default() };
    for _ in 0..50 {
        let (mut written, mut labels_written) = (0, 0);
        pks::step(
            State { positions: &mut positions, masses: &mut masses, labels: &mut labels, species: None, weights: None },
            &mut counters,
            &mut Philox::new(5),
            c(0.01),
            Events {
                events: &mut log,
                labels: &mut absorbed,
                written: &mut written,
                labels_written: &mut labels_written,
            },
            memory.bytes(),
            Setting {
                options: &options,
                attraction: Attraction::Mesh(&mut grid, None),
                run: &mut Run { executor: &Serial, ..Run::default() },
                report: None,
            },
        )
        .unwrap();
    }
    let left = counters.count as usize;
    let mut hash = Hash(0);
    hash.add(positions[..left].as_flattened());
    hash.add(&masses[..left]);
    (hash.0, counters.count)
}

#[test]
fn the_bits_of_every_machine() {
    let (double, left) = coalescing::<f64>(Order::Second);
    let (single, left_single) = coalescing::<f32>(Order::Fourth);
    assert!((1..1500).contains(&left) && (1..1500).contains(&left_single), "{left} {left_single}");
    let got = [
        ("1D f64", newtonian::<f64, 1>(2), 0xcb05_523d_1661_eff0),
        ("1D f32", newtonian::<f32, 1>(4), 0x0b58_03eb_9108_ec72),
        ("2D f64", newtonian::<f64, 2>(2), 0x081c_07fa_2150_4fd4),
        ("2D f32", newtonian::<f32, 2>(4), 0x9418_ded7_09f5_02a2),
        ("3D f64", newtonian::<f64, 3>(2), 0x9984_be21_c708_fac0),
        ("3D f32", newtonian::<f32, 3>(4), 0xadb4_b46c_6d01_982b),
        ("fits 1D f64", fitted::<f64, 1>(), 0xcbe0_3af6_1800_3058),
        ("fits 2D f64", fitted::<f64, 2>(), 0xba93_8af3_bb73_9ecc),
        ("fits 2D f32", fitted::<f32, 2>(), 0xf573_97d9_c012_4c39),
        ("fits 3D f64", fitted::<f64, 3>(), 0x884a_e86b_6158_7203),
        ("coalescing f64", double, 0x3016_a201_a771_aa6e),
        ("coalescing f32, fourth order", single, 0x04e7_f161_f417_397c),
    ];
    let other: Vec<_> = got.iter().filter(|(_, got, want)| got != want).collect();
    assert!(other.is_empty(), "{other:#x?}");
}
