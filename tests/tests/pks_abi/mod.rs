//! Coalescing particles through the C ABI: the same bits as in Rust for every choice of options. Refused calls write nothing.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

mod closed_forms;
mod refusals;
mod small;

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_core::euler_maruyama::Control;
use mollis_core::exec::Run;
use mollis_core::field;
use mollis_core::grid::{Equation, Grid, Mesh, Order, Walls};
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::memory::ALIGN;
use mollis_core::mollifier::Mollifier;
use mollis_core::pks::search::Search;
use mollis_core::pks::{
    self, Attraction, CollisionLaw, Counters, Event, Events, Heavy, Merging, Options, Scheme, theory,
};
use mollis_core::random::{Generator, Philox};
use mollis_core::{Error, Real};
use mollis_tests::positional::*;
use mollis_tests::{Aligned, Split};

/// [`Split`] as a random stream of a C host.
unsafe extern "C" fn split(state: *mut c_void, out: *mut u64, n: usize) -> i32 {
    // SAFETY: the state is a live Split, and `out` has room for n words.
    let (state, out) = unsafe { (&mut *state.cast::<Split>(), std::slice::from_raw_parts_mut(out, n)) };
    out.iter_mut().for_each(|word| *word = state.next());
    0
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Force {
    None,
    Free,
    Box,
    Sum,
    /// A mesh in free space, and the kernel for heavy particles.
    Heavy,
}

/// One scene, to be run in both languages.
#[derive(Clone)]
struct Scene {
    force: Force,
    options: mollis_pks_options,
    stream: bool,
    steps: usize,
    dt: f64,
}

/// The least mass of a heavy particle.
const HEAVY: f64 = 0.11;

const MESH: mollis_mesh2 = mollis_mesh2 { lower: [-2.0, -2.0], upper: [2.0, 2.0], cells: [17, 20] };
const WALLS: f64 = 0.75;
const DELTA: f64 = 0.05;
const N: usize = 60;

/// The default options with an attraction and a noise.
pub(crate) fn options() -> mollis_pks_options {
    let mut options = std::mem::MaybeUninit::<mollis_pks_options>::uninit();
    // SAFETY: a live structure of this size, which the call fills.
    let mut options = unsafe {
        assert_eq!(mollis_pks_options_init(options.as_mut_ptr(), size_of::<mollis_pks_options>()), 0);
        options.assume_init()
    };
    (options.chi, options.noise) = (80.0, 0.02);
    options
}

/// The Rust options that correspond to the C options.
fn rust<T: Real>(o: &mollis_pks_options, force: Force) -> Options<T> {
    let c = T::from_f64;
    let [a, b, d, e] = o.domain.map(c);
    let given = (o.domain != [0.0; 4]).then_some([[a, b], [d, e]]);
    let meshed =
        matches!(force, Force::Free | Force::Box | Force::Heavy).then_some([MESH.lower.map(c), MESH.upper.map(c)]);
    Options {
        chi: c(o.chi),
        noise: c(o.noise),
        gamma: c(o.gamma),
        control: Control {
            width: if o.width == 0.0 { T::INFINITY } else { c(o.width) },
            at_least: o.at_least,
            at_most: o.at_most,
        },
        scheme: if o.scheme == MOLLIS_PKS_SCHEME_STRANG_RK4 { Scheme::StrangRk4 } else { Scheme::EulerMaruyama },
        search: Search { separation: c(o.separation), mesh: o.mesh, domain: given.or(meshed), shifted: o.shifted != 0 },
        probability: c(o.probability),
        law: if o.law == MOLLIS_PKS_LAW_PRINTED { CollisionLaw::Printed } else { CollisionLaw::Exact },
        merging: [Merging::All, Merging::Hard, Merging::Never][o.merging as usize],
    }
}

/// All outputs of a step as integers.
#[derive(Debug, PartialEq)]
struct Outcome {
    status: i32,
    positions: Vec<u64>,
    masses: Vec<u64>,
    labels: Vec<u64>,
    species: Vec<u32>,
    counters: [u64; 4],
    events: Vec<[u64; 6]>,
    absorbed: Vec<u64>,
    report: [u64; 7],
}

fn start<T: Real>() -> (Vec<[T; 2]>, Vec<T>, Vec<u64>, Vec<u32>) {
    let mut random = Split(11);
    let positions = (0..N).map(|_| [0, 1].map(|_| T::from_f64(0.6 * random.uniform() - 0.3))).collect();
    let masses = (0..N).map(|_| T::from_f64(0.02 + 0.1 * random.uniform())).collect();
    let labels = (0..N as u64).map(|k| (k * 37) % 101).collect();
    (positions, masses, labels, (0..N as u32).map(|k| k % 3).collect())
}

macro_rules! scalar {
    ($name:ident, $t:ty, $step:ident, $bytes:ident) => {
        mod $name {
            use super::*;

            fn words(values: &[$t]) -> Vec<u64> {
                values.iter().map(|v| u64::from(v.to_bits())).collect()
            }

            fn kernel(memory: &mut [u8]) -> Kernel<'_, $t, 2> {
                let terms = [Term { law: Law::Newtonian, coefficient: 1.0 }];
                let mollifier = Mollifier::Compact { order: 2, exponent: 4 };
                Kernel::prepare(memory, &terms, mollifier, DELTA as $t).unwrap()
            }

            fn kernel_block() -> Aligned {
                let terms = [Term { law: Law::Newtonian, coefficient: 1.0 }];
                let mollifier = Mollifier::Compact { order: 2, exponent: 4 };
                Aligned::new(Kernel::<$t, 2>::workspace_bytes(&terms, mollifier).unwrap())
            }

            pub fn in_c(scene: &Scene) -> (Outcome, usize) {
                let (mut positions, mut masses, mut labels, mut species) = start::<$t>();
                let mut block = kernel_block();
                kernel(block.bytes());
                let mut grid = std::mem::MaybeUninit::<mollis_grid2_options>::uninit();
                // SAFETY: a live structure of this size, which the call fills.
                let mut grid = unsafe {
                    assert_eq!(mollis_grid2_options_init(grid.as_mut_ptr(), size_of::<mollis_grid2_options>()), 0);
                    grid.assume_init()
                };
                (grid.walls, grid.screening, grid.order) = (MOLLIS_WALLS_NO_FLUX, WALLS, 4);
                let mesh = MESH;
                let attraction = mollis_pks_attraction {
                    kind: match scene.force {
                        Force::None => MOLLIS_PKS_ATTRACTION_NONE,
                        Force::Free | Force::Box | Force::Heavy => MOLLIS_PKS_ATTRACTION_MESH,
                        Force::Sum => MOLLIS_PKS_ATTRACTION_SUM,
                    },
                    reserved: 0,
                    mesh: &raw const mesh,
                    grid: if scene.force == Force::Box { &raw const grid } else { null() },
                    kernel: block.pointer().cast_const(),
                    kernel_bytes: block.bytes().len(),
                    tolerance: 0.0,
                    heavy: if scene.force == Force::Heavy { HEAVY } else { 0.0 },
                };
                let mut counters = mollis_pks_progress { time: 0.0, step: 0, count: N as u64, pending: 0 };
                let none = mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 };
                let (mut log, mut absorbed) = (vec![none; N], vec![0_u64; N]);
                let mut events = mollis_pks_events {
                    events: log.as_mut_ptr(),
                    room: N,
                    written: 0,
                    labels: absorbed.as_mut_ptr(),
                    labels_room: N,
                    labels_written: 0,
                };
                let mut report = mollis_pks_report {
                    substeps: 0,
                    normals: 0,
                    fields: 0,
                    searches: 0,
                    clusters: 0,
                    merges: 0,
                    absorbed: 0,
                };
                let mut stream = Split(5);
                let generator = mollis_generator { state: (&raw mut stream).cast(), fill: Some(split) };
                let mut bytes = 0;
                // SAFETY: live arrays of these lengths.
                let status = unsafe {
                    let options = &raw const scene.options;
                    assert_eq!($bytes(N, options, &raw const attraction, null(), &raw mut bytes), 0);
                    let mut workspace = Aligned::new(bytes);
                    $step(
                        options,
                        &raw const attraction,
                        N,
                        positions.as_mut_ptr(),
                        masses.as_mut_ptr(),
                        labels.as_mut_ptr(),
                        species.as_mut_ptr(),
                        &raw mut counters,
                        if scene.stream { &raw const generator } else { null() },
                        7,
                        scene.dt as $t,
                        scene.steps,
                        &raw mut events,
                        &raw mut report,
                        workspace.pointer(),
                        bytes,
                        null(),
                    )
                };
                let n = counters.count as usize;
                let outcome = Outcome {
                    status,
                    positions: words(positions[..n].as_flattened()),
                    masses: words(&masses[..n]),
                    labels: labels[..n].to_vec(),
                    species: species[..n].to_vec(),
                    counters: [counters.time.to_bits(), counters.step, counters.count, counters.pending],
                    events: log[..events.written]
                        .iter()
                        .map(|e| [e.time.to_bits(), e.label, e.mass.to_bits(), e.index.to_bits(), e.first, e.absorbed])
                        .collect(),
                    absorbed: absorbed[..events.labels_written].to_vec(),
                    report: [
                        report.substeps,
                        report.normals,
                        report.fields,
                        report.searches,
                        report.clusters,
                        report.merges,
                        report.absorbed,
                    ],
                };
                (outcome, bytes)
            }

            pub fn in_rust(scene: &Scene) -> (Outcome, usize) {
                let (mut positions, mut masses, mut labels, mut species) = start::<$t>();
                let options = rust::<$t>(&scene.options, scene.force);
                let mut block = kernel_block();
                let kernel = kernel(block.bytes());
                let mesh = Mesh::new(MESH.lower.map(|v| v as $t), MESH.upper.map(|v| v as $t), MESH.cells).unwrap();
                let equation = match scene.force {
                    Force::Box => Equation { screening: WALLS as $t, walls: Walls::NoFlux, order: Order::Fourth },
                    _ => Equation::POISSON,
                };
                let mut grid_block = Aligned::new(Grid::workspace_bytes(&mesh, &equation, 1).unwrap());
                let mut grid = Grid::prepare(grid_block.bytes(), mesh, equation, 1).unwrap();
                let exactly = field::Options::default();
                let summed: pks::Summed<'_, $t> = (scene.force == Force::Sum).then_some((&kernel as _, &exactly));
                let own = pks::workspace_bytes(N, summed, &options, 1).unwrap();
                let mut workspace = Aligned::new(own);
                let (mut philox, mut stream) = (Philox::new(7), Split(5));
                let mut counters = Counters { count: N as u64, ..Counters::default() };
                let (mut log, mut absorbed) = (vec![Event::default(); N], vec![0_u64; N]);
                let (mut written, mut labels_written, mut report) = (0, 0, pks::Report::default());
                let mut status = 0;
                for _ in 0..scene.steps {
                    let heavy = Heavy { kernel: &kernel, mass: HEAVY as $t, core: DELTA as $t };
                    let attraction = match scene.force {
                        Force::None => Attraction::None,
                        Force::Free | Force::Box => Attraction::Mesh(&mut grid, None),
                        Force::Heavy => Attraction::Mesh(&mut grid, Some(&heavy)),
                        Force::Sum => Attraction::Sum(&kernel, &exactly),
                    };
                    let done = pks::step(
                        pks::State {
                            positions: &mut positions,
                            masses: &mut masses,
                            labels: &mut labels,
                            species: Some(&mut species),
                            weights: None,
                        },
                        &mut counters,
                        if scene.stream { &mut stream as &mut dyn Generator } else { &mut philox },
                        scene.dt as $t,
                        Events {
                            events: &mut log,
                            labels: &mut absorbed,
                            written: &mut written,
                            labels_written: &mut labels_written,
                        },
                        workspace.bytes(),
                        pks::Setting {
                            options: &options,
                            attraction,
                            run: &mut Run::default(),
                            report: Some(&mut report),
                        },
                    );
                    if let Err(error) = done {
                        status = error as i32;
                        break;
                    }
                }
                let n = counters.count as usize;
                let outcome = Outcome {
                    status,
                    positions: words(positions[..n].as_flattened()),
                    masses: words(&masses[..n]),
                    labels: labels[..n].to_vec(),
                    species: species[..n].to_vec(),
                    counters: [counters.time.to_bits(), counters.step, counters.count, counters.pending],
                    events: log[..written]
                        .iter()
                        .map(|e| [e.time.to_bits(), e.label, e.mass.to_bits(), e.index.to_bits(), e.first, e.absorbed])
                        .collect(),
                    absorbed: absorbed[..labels_written].to_vec(),
                    report: [
                        report.substeps,
                        report.normals,
                        report.fields,
                        report.searches,
                        report.clusters,
                        report.merges,
                        report.absorbed,
                    ],
                };
                let meshed = matches!(scene.force, Force::Free | Force::Box | Force::Heavy);
                (outcome, own.next_multiple_of(ALIGN) + if meshed { grid_block.bytes().len() } else { 0 })
            }
        }
    };
}

scalar!(double, f64, pks_step, pks_workspace_bytes);
scalar!(single, f32, pks_step_f32, pks_workspace_bytes_f32);

#[test]
fn every_choice_gives_the_bits_of_rust() {
    let base = Scene { force: Force::Free, options: options(), stream: false, steps: 12, dt: 2e-3 };
    let with = |change: &dyn Fn(&mut mollis_pks_options)| {
        let mut scene = base.clone();
        change(&mut scene.options);
        scene
    };
    let mut scenes = vec![
        with(&|_| ()),
        with(&|o| o.law = MOLLIS_PKS_LAW_PRINTED),
        with(&|o| (o.chi, o.merging) = (30.0, MOLLIS_PKS_MERGE_HARD)),
        with(&|o| o.chi = 30.0),
        with(&|o| o.merging = MOLLIS_PKS_MERGE_NEVER),
        with(&|o| o.scheme = MOLLIS_PKS_SCHEME_STRANG_RK4),
        with(&|o| (o.chi, o.noise) = (-3.0, 0.1)),
        with(&|o| o.noise = 0.0),
        with(&|o| o.gamma = 0.5),
        with(&|o| (o.noise, o.probability) = (0.5, 0.9)),
        with(&|o| (o.noise, o.separation) = (0.5, 1e-5)),
        with(&|o| o.noise = 0.5),
        with(&|o| (o.width, o.at_least, o.at_most) = (0.01, 3, 50_000)),
        with(&|o| (o.mesh, o.domain, o.shifted) = ([3, 2], [-4.0, -3.0, 3.5, 4.5], 0)),
        with(&|o| (o.width, o.at_most) = (1e-6, 9)),
    ];
    for force in [Force::None, Force::Box, Force::Sum, Force::Heavy] {
        for scheme in [MOLLIS_PKS_SCHEME_EULER_MARUYAMA, MOLLIS_PKS_SCHEME_STRANG_RK4] {
            scenes.push(Scene { force, ..with(&|o| o.scheme = scheme) });
        }
    }
    scenes.push(Scene { stream: true, ..base.clone() });
    scenes.push(Scene { stream: true, force: Force::Sum, ..base.clone() });
    let (mut merges, mut differ) = (0, Vec::new());
    for (k, scene) in scenes.iter().enumerate() {
        let (c, bytes) = double::in_c(scene);
        let (rust, needed) = double::in_rust(scene);
        assert_eq!(c, rust, "scene {k}, {:?}", scene.force);
        assert_eq!(bytes, needed + ALIGN - 1, "scene {k}");
        let (c32, bytes) = single::in_c(scene);
        let (rust32, needed) = single::in_rust(scene);
        assert_eq!(c32, rust32, "scene {k} in single precision, {:?}", scene.force);
        assert_eq!(bytes, needed + ALIGN - 1, "scene {k} in single precision");
        merges += c.report[5];
        differ.push(c);
    }
    assert!(differ[0].report[5] > 0 && merges > 10, "too few merges to compare: {merges}");
    assert_eq!(differ[14].status, Error::TooManySubsteps as i32);
    // Each choice changes the result, so every option reaches the library.
    for (i, a) in differ.iter().enumerate() {
        assert!(differ[..i].iter().all(|b| a != b), "scene {i} is that of another: {a:?}");
    }
}
