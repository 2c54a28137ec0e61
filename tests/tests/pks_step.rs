//! A whole step: what it conserves, reports, refuses and skips. A run may be interrupted anywhere.

use mollis_core::euler_maruyama::Control;
use mollis_core::exec::{Executor, Run, Serial};
use mollis_core::field::{self, Interaction};
use mollis_core::grid::{Equation, Grid, Mesh, Walls};
use mollis_core::memory::ALIGN;
use mollis_core::pks::{
    Attraction, Counters, Event, Events, Heavy, Merging, Options, Report, Scheme, Setting, State, step, theory,
    workspace_bytes,
};
use mollis_core::random::{Generator, Philox, Stream};
use mollis_core::real::DoubleWord;
use mollis_core::{Error, Real, Result};
use mollis_tests::{Split, Threads};

/// V = log r / (2 pi), softened by Plummer's law, so that everything is finite.
struct Plummer;
impl<T: Real> Interaction<T, 2> for Plummer {
    fn value(&self, r: T) -> T {
        (r * r + T::from_f64(1e-4)).log() / (T::from_i32(4) * T::PI)
    }
    fn gradient_factor(&self, r: T) -> T {
        T::ONE / (T::TWO * T::PI * (r * r + T::from_f64(1e-4)))
    }
    fn laplacian(&self, _: T) -> T {
        T::ZERO
    }
    fn is_singular(&self) -> bool {
        false
    }
}

/// Bytes at an aligned address.
struct Memory(Vec<u8>, usize);
impl Memory {
    fn new(bytes: usize) -> Self {
        Self(vec![0xAB; bytes + 3 * ALIGN], bytes)
    }
    fn start(&self) -> usize {
        self.0.as_ptr().align_offset(ALIGN) + ALIGN
    }
    fn get(&mut self) -> &mut [u8] {
        let (start, bytes) = (self.start(), self.1);
        &mut self.0[start..start + bytes]
    }
    fn canaries_live(&self) -> bool {
        let start = self.start();
        self.0[..start].iter().chain(&self.0[start + self.1..]).all(|&b| b == 0xAB)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Force {
    None,
    Sum,
    Mesh(Walls),
    /// A mesh in free space, and heavy particles beside it.
    Heavy,
}

impl Force {
    fn walls(self) -> Walls {
        match self {
            Force::Mesh(walls) => walls,
            _ => Walls::Free,
        }
    }
}

#[derive(Clone, PartialEq, Debug)]
struct Particles<T> {
    positions: Vec<[T; 2]>,
    masses: Vec<T>,
    labels: Vec<u64>,
    species: Vec<u32>,
    counters: Counters,
}

struct Rig<T: Real> {
    p: Particles<T>,
    options: Options<T>,
    force: Force,
    workspace: Memory,
    grid: Memory,
    events: Vec<Event>,
    absorbed: Vec<u64>,
    written: [usize; 2],
    report: Report,
    workers: usize,
}

const CELLS: usize = 32;

impl<T: Real> Rig<T> {
    fn new(p: Particles<T>, options: Options<T>, force: Force, room: (usize, usize), workers: usize) -> Self {
        let n = p.positions.len();
        let exactly = field::Options::default();
        let summed: Option<(&dyn Interaction<T, 2>, _)> = (force == Force::Sum).then_some((&Plummer, &exactly));
        let workspace = Memory::new(workspace_bytes(n, summed, &options, workers).unwrap());
        let grid = Memory::new(match force {
            Force::Mesh(_) | Force::Heavy => {
                Grid::workspace_bytes(&Self::mesh(), &Self::equation(force.walls()), workers).unwrap()
            }
            _ => 0,
        });
        let (events, absorbed) = (vec![Event::default(); room.0], vec![0; room.1]);
        Self {
            p,
            options,
            force,
            workspace,
            grid,
            events,
            absorbed,
            written: [0; 2],
            report: Report::default(),
            workers,
        }
    }

    fn mesh() -> Mesh<T> {
        Mesh::new([T::from_f64(-1.0); 2], [T::ONE; 2], [CELLS; 2]).unwrap()
    }

    fn equation(walls: Walls) -> Equation<T> {
        Equation { screening: T::ZERO, walls, ..Equation::POISSON }
    }

    fn step(&mut self, generator: &mut dyn Generator, dt: f64) -> Result<()> {
        let threads = Threads(self.workers);
        let executor: &dyn Executor = if self.workers == 1 { &Serial } else { &threads };
        let mut grid = match self.force {
            Force::Mesh(_) | Force::Heavy => {
                let equation = Self::equation(self.force.walls());
                Some(Grid::prepare(self.grid.get(), Self::mesh(), equation, self.workers).unwrap())
            }
            _ => None,
        };
        let exactly = field::Options::default();
        // Beyond Plummer's softening this is the potential of the mesh.
        let heavy = Heavy { kernel: &Plummer, mass: T::from_f64(0.5), core: T::from_f64(0.01) };
        let attraction = match (&mut grid, self.force) {
            (Some(grid), Force::Heavy) => Attraction::Mesh(grid, Some(&heavy)),
            (Some(grid), _) => Attraction::Mesh(grid, None),
            (None, Force::Sum) => Attraction::Sum(&Plummer, &exactly),
            _ => Attraction::None,
        };
        let [written, labels_written] = &mut self.written;
        let done = step(
            State {
                positions: &mut self.p.positions,
                masses: &mut self.p.masses,
                labels: &mut self.p.labels,
                species: Some(&mut self.p.species),
                weights: None,
            },
            &mut self.p.counters,
            generator,
            T::from_f64(dt),
            Events { events: &mut self.events, labels: &mut self.absorbed, written, labels_written },
            self.workspace.get(),
            Setting {
                options: &self.options,
                attraction,
                run: &mut Run { executor, ..Run::default() },
                report: Some(&mut self.report),
            },
        );
        assert!(self.workspace.canaries_live() && self.grid.canaries_live());
        done
    }

    fn n(&self) -> usize {
        self.p.counters.count as usize
    }

    /// The bits of all data of live particles.
    fn bits(&self) -> (Vec<[u64; 4]>, [u64; 3]) {
        let rows = (0..self.n()).map(|i| {
            let [x, y] = self.p.positions[i];
            [x.bits(), y.bits(), self.p.masses[i].bits(), self.p.labels[i] << 8 | u64::from(self.p.species[i])]
        });
        (rows.collect(), [self.p.counters.time.to_bits(), self.p.counters.step, self.p.counters.count])
    }
}

/// A dense clump of supercritical mass with shuffled labels, and a thin cloud.
fn collapsing<T: Real>(n: usize, seed: u64) -> (Particles<T>, Options<T>) {
    let mut random = Split(seed);
    let mass = 60.0;
    let mut positions = Vec::new();
    for i in 0..n {
        let size = if i % 3 == 0 { 0.9 } else { 0.15 };
        positions.push([0.2, -0.1].map(|c| T::from_f64(c + size * (random.uniform() + random.uniform() - 1.0))));
    }
    let mut labels: Vec<u64> = (0..n as u64).map(|k| 3 * k + 5).collect();
    for i in (1..n).rev() {
        labels.swap(i, (random.next() % (i as u64 + 1)) as usize);
    }
    let particles = Particles {
        positions,
        masses: (0..n).map(|i| T::from_f64(mass / n as f64 * (1.0 + 0.5 * (i % 2) as f64))).collect(),
        labels,
        species: (0..n as u32).map(|i| i % 3).collect(),
        counters: Counters { count: n as u64, ..Counters::default() },
    };
    (particles, Options::new(T::ONE, T::from_f64(theory::noise(mass * 1.25, 1.0, n.max(1)))))
}

/// [`collapsing`], with three particles that are heavy from the start in cases with heavy pairs.
fn collapsing_by<T: Real>(force: Force, n: usize, seed: u64) -> (Particles<T>, Options<T>) {
    let (mut particles, options) = collapsing::<T>(n, seed);
    if force == Force::Heavy {
        particles.masses.iter_mut().step_by(n / 3).take(3).for_each(|m| *m = T::from_f64(0.75));
    }
    (particles, options)
}

const ALL: [Force; 5] = [Force::None, Force::Sum, Force::Mesh(Walls::Free), Force::Mesh(Walls::NoFlux), Force::Heavy];

#[test]
fn the_event_log_replays_every_mass_bitwise_and_the_order_is_kept() {
    fn check<T: Real>(force: Force) {
        let (start, options) = collapsing_by::<T>(force, 700, 1);
        let mut rig = Rig::new(start.clone(), options, force, (1000, 1000), 1);
        for _ in 0..25 {
            rig.step(&mut Philox::new(5), 1e-3).unwrap();
        }
        assert!(rig.n() < 300 && rig.report.merges > 20, "{} {:?}", rig.n(), rig.report);
        assert_eq!(rig.report.absorbed as usize, 700 - rig.n());
        // From the labels to the masses.
        let mut masses: std::collections::BTreeMap<u64, T> =
            start.labels.iter().copied().zip(start.masses.iter().copied()).collect();
        let mut time = 0.0;
        for event in &rig.events[..rig.written[0]] {
            let mut mass = DoubleWord::from(masses[&event.label]);
            let from = event.first as usize;
            let mut before = event.label;
            for &label in &rig.absorbed[from..from + event.absorbed as usize] {
                assert!(label > before, "ascending, the lowest is kept");
                before = label;
                mass = mass.plus(masses.remove(&label).unwrap());
            }
            masses.insert(event.label, mass.hi);
            assert_eq!(mass.hi.to_f64(), event.mass);
            assert!(event.index < 0.0 && event.time >= time - 1e-3 - 1e-12 && event.time <= rig.p.counters.time);
            time = event.time.max(time);
        }
        assert_eq!(masses.len(), rig.n());
        for i in 0..rig.n() {
            assert_eq!(masses[&rig.p.labels[i]].bits(), rig.p.masses[i].bits());
        }
        // Compaction is stable: the remaining particles keep their order and their species.
        let place = |label: u64| start.labels.iter().position(|&l| l == label).unwrap();
        let places: Vec<usize> = rig.p.labels[..rig.n()].iter().map(|&l| place(l)).collect();
        assert!(places.windows(2).all(|w| w[0] < w[1]));
        assert!((0..rig.n()).all(|i| rig.p.species[i] == start.species[places[i]]));
    }
    for force in [Force::Sum, Force::Mesh(Walls::Free), Force::Heavy] {
        check::<f64>(force);
        check::<f32>(force);
    }
}

/// A million particles merge at once. Their mass is the sum rounded once, and their index is that of the exact masses.
#[test]
fn a_million_particles_merge_without_losing_mass() {
    fn check<T: Real>() {
        const N: usize = 1 << 20;
        let mut random = Split(31);
        // Multiples of 2^-20 between 1 and 2: their sum is exact as an integer.
        let whole: Vec<u64> = (0..N).map(|_| 1 << 20 | random.next() >> 44).collect();
        let unit = 2_f64.powi(-20);
        let (sum, squares) = whole.iter().fold((0_u128, 0_u128), |(sum, squares), &m| {
            (sum + u128::from(m), squares + u128::from(m) * u128::from(m))
        });
        let p = Particles {
            // They are so close together that they collide.
            positions: (0..N).map(|_| [0.5, 0.25].map(|c| T::from_f64(c + 2e-6 * random.uniform()))).collect(),
            masses: whole.iter().map(|&m| T::from_f64(m as f64 * unit)).collect(),
            labels: (0..N as u64).collect(),
            species: vec![0; N],
            counters: Counters { count: N as u64, ..Counters::default() },
        };
        let chi = 2_f64.powi(-13);
        let options = Options::new(T::from_f64(chi), T::ONE);
        let mut rig = Rig::new(p, options, Force::Mesh(Walls::Free), (1, N), 1);
        rig.step(&mut Philox::new(5), 1e-6).unwrap();
        assert_eq!((rig.n(), rig.written[0]), (1, 1));
        let (mass, event) = (rig.p.masses[0].to_f64(), rig.events[0]);
        let exact = sum as f64 * unit;
        let u = 0.5 * T::EPSILON.to_f64();
        // u for the last rounding and 2 n u^2 for the sum of two numbers: n u is 1/16 in f32.
        assert!((mass - exact).abs() <= u * (1.0 + 2.0 * N as f64 * u) * exact, "{mass} {exact}");
        assert_eq!(mass, event.mass);
        // nu: `pairs` adds over blocks of 64 particles, then over twenty levels of halves or cells, with three roundings each.
        let pull = (sum * sum - squares) as f64 * unit * unit * chi * theory::GAMMA / 4.0;
        let index = N as f64 - 2.0 - pull;
        assert!((event.index - index).abs() <= 3.0 * (64.0 + 20.0 + 4.0) * u * pull, "{} {index}", event.index);
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn merging_keeps_the_centre_of_mass() {
    // No noise and almost no motion by attraction: chi only determines the index, so a step merges particles and moves them little.
    let (start, options) = collapsing::<f64>(700, 2);
    let mut rig = Rig::new(start, options, Force::Mesh(Walls::Free), (1000, 1000), 1);
    for _ in 0..10 {
        let mut twin = Rig::new(rig.p.clone(), Options { merging: Merging::Never, ..options }, rig.force, (0, 0), 1);
        let n = rig.n();
        twin.step(&mut Philox::new(5), 1e-3).unwrap();
        rig.step(&mut Philox::new(5), 1e-3).unwrap();
        let centre = |p: &Particles<f64>, n: usize, k: usize| {
            let mass: f64 = p.masses[..n].iter().sum();
            (0..n).map(|i| p.masses[i] * p.positions[i][k]).sum::<f64>() / mass
        };
        for k in 0..2 {
            let moved = centre(&rig.p, rig.n(), k) - centre(&twin.p, n, k);
            assert!(moved.abs() < 1e-12, "{moved:e}");
        }
    }
    assert!(rig.report.merges > 10, "{:?}", rig.report);
}

#[test]
fn a_run_continues_bit_for_bit_from_copies() {
    for force in ALL {
        for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
            let (start, mut options) = collapsing_by::<f64>(force, 300, 3);
            options.scheme = scheme;
            let run = |cut: Option<usize>| {
                let mut rig = Rig::new(start.clone(), options, force, (1000, 1000), 1);
                let mut stream = Split(9);
                for k in 0..12 {
                    if cut == Some(k) {
                        // Only state, counters and generator are kept.
                        rig = Rig::new(rig.p.clone(), options, force, (1000, 1000), 1);
                        stream = Split(stream.0);
                    }
                    rig.step(&mut stream, 1e-3).unwrap();
                }
                rig.bits()
            };
            assert_eq!(run(None), run(Some(5)));
        }
    }
}

#[test]
fn a_full_event_buffer_stops_before_the_merge_and_goes_on() {
    for force in [Force::Sum, Force::Mesh(Walls::Free), Force::Heavy] {
        let (start, options) = collapsing_by::<f64>(force, 700, 4);
        let mut whole = Rig::new(start.clone(), options, force, (1000, 1000), 1);
        let mut parts = Rig::new(start, options, force, (1, 700), 1);
        let (mut log, mut stops) = (Vec::new(), 0);
        let mut streams = [Split(3), Split(3)];
        for _ in 0..20 {
            whole.step(&mut streams[0], 1e-3).unwrap();
            loop {
                let done = parts.step(&mut streams[1], 1e-3);
                log.extend(
                    parts.events[..parts.written[0]].iter().map(|e| (e.label, e.mass, e.time, e.index, e.absorbed)),
                );
                parts.written = [0; 2];
                if done == Ok(()) {
                    break;
                }
                assert_eq!(done, Err(Error::EventsFull));
                assert!(parts.p.counters.pending > 0);
                stops += 1;
            }
            assert_eq!(parts.p.counters.pending, 0);
            assert_eq!(whole.bits(), parts.bits());
            assert_eq!(streams[0].0, streams[1].0);
        }
        assert!(stops > 20, "{stops}");
        let all: Vec<_> =
            whole.events[..whole.written[0]].iter().map(|e| (e.label, e.mass, e.time, e.index, e.absorbed)).collect();
        assert_eq!(all, log);
        // Without the workspace that holds them, pending merges are refused instead of lost.
        let (start, options) = collapsing_by::<f64>(force, 700, 4);
        let mut none = Rig::new(start, options, force, (0, 0), 1);
        let mut k = 0;
        while none.step(&mut Split(3), 1e-3) == Ok(()) {
            k += 1;
            assert!(k < 50);
        }
        let pending = none.p.counters.pending;
        assert!(pending > 0);
        none.workspace.get().fill(0);
        assert_eq!(none.step(&mut Split(3), 1e-3), Err(Error::NotPrepared));
        assert_eq!(none.p.counters.pending, pending);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut bits = Vec::new();
    for force in ALL {
        let (start, mut options) = collapsing_by::<f64>(force, if force == Force::Sum { 2000 } else { 20_000 }, 6);
        options.control.width = 0.01;
        let run = |workers| {
            let mut rig = Rig::new(start.clone(), options, force, (20_000, 20_000), workers);
            for _ in 0..if force == Force::Sum { 1 } else { 4 } {
                rig.step(&mut Philox::new(8), 1e-4).unwrap();
            }
            rig.bits()
        };
        let one = run(1);
        assert!(one == run(2) && one == run(5));
        bits.push(one);
    }
    // Each attraction is a different one; pairs with heavy particles are included.
    assert!((1..bits.len()).all(|k| !bits[..k].contains(&bits[k])));
}

#[test]
fn what_a_scene_does_not_need_is_skipped() {
    let (start, options) = collapsing::<f64>(400, 7);
    let count = |options: Options<f64>, force, generator: &mut dyn Generator| {
        let mut rig = Rig::new(start.clone(), options, force, (1000, 1000), 1);
        for _ in 0..3 {
            rig.step(generator, 1e-5).unwrap();
        }
        rig.report
    };
    /// A generator that fails if it is called.
    struct Refuses;
    impl Generator for Refuses {
        fn fill(&mut self, _: u64, _: u32, _: u32, _: &mut [u64]) -> Result<()> {
            Err(Error::Generator)
        }
    }
    for force in ALL {
        for scheme in [Scheme::EulerMaruyama, Scheme::StrangRk4] {
            let options = Options { scheme, ..options };
            let full = count(options, force, &mut Philox::new(1));
            // Everything is used.
            let attracted = force != Force::None;
            assert_eq!((full.normals > 0, full.fields > 0, full.searches > 0), (true, attracted, attracted));
            // No noise: no random numbers.
            let quiet = count(Options { noise: 0.0, ..options }, force, &mut Refuses);
            assert_eq!((quiet.normals, quiet.fields), (0, full.fields));
            // No attraction: no field and no search.
            let free = count(Options { chi: 0.0, ..options }, force, &mut Philox::new(1));
            assert_eq!(
                (free.fields, free.searches, free.normals),
                (0, 0, if scheme == Scheme::StrangRk4 { 2400 } else { 1200 })
            );
            // Repulsion: a field, but no collisions.
            let repelled = count(Options { chi: -1.0, ..options }, force, &mut Philox::new(1));
            assert_eq!((repelled.fields > 0, repelled.searches), (attracted, 0));
            // Hard collisions below the critical mass are impossible by a bound.
            let hard = Options { merging: Merging::Hard, chi: 0.1, ..options };
            assert_eq!(count(hard, force, &mut Philox::new(1)).searches, 0);
        }
    }
    // Light particles take one sub-step, particles near a heavy one more.
    let mut positions = vec![[0.06, 0.0]];
    positions.extend((0..400).map(|i| [-0.9 + 0.002 * f64::from(i), 0.9]));
    let mut masses = vec![1e-3; 401];
    positions.push([0.0, 0.0]);
    masses.push(10.0);
    let n = positions.len();
    let p = Particles {
        positions,
        masses,
        labels: (0..n as u64).collect(),
        species: vec![0; n],
        counters: Counters { count: n as u64, ..Counters::default() },
    };
    let options = Options { merging: Merging::Never, ..Options::new(900.0, 1e-4) };
    let mut rig = Rig::new(p, options, Force::Mesh(Walls::Free), (0, 0), 1);
    rig.step(&mut Philox::new(1), 2e-5).unwrap();
    let more = rig.report.substeps - n as u64;
    assert!((1..20).contains(&more), "{more}");
}

/// What noise is drawn for: particle, step and sub-step.
struct Recorded(Vec<(u64, u32, u32)>, Philox);

impl Generator for Recorded {
    fn fill(&mut self, label: u64, step: u32, substep: u32, out: &mut [u64]) -> Result<()> {
        self.0.push((label, step, substep));
        self.1.fill(label, step, substep, out)
    }
}

#[test]
fn each_sub_step_draws_its_own_noise() {
    let (start, mut options) = collapsing::<f64>(12, 5);
    (options.merging, options.control.at_least) = (Merging::Never, 3);
    for force in [Force::Mesh(Walls::Free), Force::Heavy, Force::Sum] {
        let mut rig = Rig::new(start.clone(), options, force, (0, 0), 1);
        let mut generator = Recorded(Vec::new(), Philox::new(3));
        for _ in 0..2 {
            rig.step(&mut generator, 1e-6).unwrap();
        }
        // Some numbers of a first sub-step are drawn again where more follow.
        let mut drawn = generator.0;
        drawn.sort_unstable();
        drawn.dedup();
        assert_eq!(drawn.len() as u64, rig.report.substeps);
        assert!(drawn.len() >= 6 * start.labels.len());
        for of_step in drawn.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            assert!(of_step.iter().map(|&(_, _, substep)| substep).eq(0..of_step.len() as u32));
        }
    }
}

#[test]
fn refused_calls_change_nothing() {
    let (start, options) = collapsing::<f64>(50, 9);
    let mut refused = 0;
    let mut check = |change: &dyn Fn(&mut Rig<f64>), dt: f64, want: Error| {
        for force in ALL {
            let mut rig = Rig::new(start.clone(), options, force, (100, 100), 1);
            change(&mut rig);
            let before = rig.p.clone();
            assert_eq!(rig.step(&mut Split(1), dt), Err(want));
            assert!(format!("{:?}", rig.p) == format!("{before:?}") && rig.written == [0; 2]);
            refused += 1;
        }
    };
    let keep = |_: &mut Rig<f64>| ();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        check(&keep, dt, Error::TimeStep);
    }
    check(&|rig| rig.p.positions[3][1] = f64::NAN, 1e-3, Error::NotFinite);
    check(&|rig| rig.p.masses[3] = f64::INFINITY, 1e-3, Error::NotFinite);
    check(&|rig| rig.p.masses[3] = 0.0, 1e-3, Error::Mass);
    check(&|rig| rig.p.masses[3] = -1.0, 1e-3, Error::Mass);
    check(&|rig| rig.p.counters.count = 51, 1e-3, Error::LengthMismatch);
    check(
        &|rig| {
            rig.p.labels.pop();
        },
        1e-3,
        Error::LengthMismatch,
    );
    check(
        &|rig| {
            rig.p.species.pop();
        },
        1e-3,
        Error::LengthMismatch,
    );
    check(&|rig| rig.p.counters.step = 1 << 32, 1e-3, Error::TooLarge);
    check(&|rig| rig.workspace.1 -= 1, 1e-3, Error::WorkspaceTooSmall);
    check(&|rig| rig.options.chi = f64::NAN, 1e-3, Error::NotFinite);
    check(&|rig| rig.options.noise = -1.0, 1e-3, Error::OutOfDomain);
    check(&|rig| rig.options.probability = 0.0, 1e-3, Error::OutOfDomain);
    check(&|rig| rig.options.search.separation = 1.0, 1e-3, Error::OutOfDomain);
    check(&|rig| rig.options.search.mesh = [0, 1], 1e-3, Error::OutOfDomain);
    check(&|rig| rig.options.search.domain = Some([[0.0; 2], [0.0; 2]]), 1e-3, Error::OutOfDomain);
    check(&|rig| rig.options.control = Control { width: 1e-3, at_least: 1, at_most: 2 }, 1e-1, Error::TooManySubsteps);
    assert_eq!(refused, 20 * 5);
    // Jumps beyond the range.
    let light = Particles { masses: vec![1e-300; start.masses.len()], ..start.clone() };
    let mut rig = Rig::new(light.clone(), Options { noise: 1e300, ..options }, Force::None, (0, 0), 1);
    assert_eq!(rig.step(&mut Split(1), 1e100), Err(Error::BecameNotFinite));
    assert!(rig.p == light);
    // The product of noise and time is beyond it, the jumps are not.
    let mut rig = Rig::new(start, Options { noise: 1e300, ..options }, Force::None, (0, 0), 1);
    assert_eq!(rig.step(&mut Split(1), 1e100), Ok(()));
    assert!(rig.p.positions.as_flattened().iter().all(|x| x.is_finite() && x.abs() > 1e190));
}

#[test]
fn without_noise_the_fixed_scheme_is_the_classical_step() {
    // Compared with RK4 written out on the same field: the same bits, chi = 1.
    let (start, mut options) = collapsing::<f64>(40, 11);
    options.noise = 0.0;
    options.merging = Merging::Never;
    options.scheme = Scheme::StrangRk4;
    let mut rig = Rig::new(start.clone(), options, Force::Sum, (0, 0), 1);
    rig.step(&mut Philox::new(1), 1e-2).unwrap();
    let slope = |x: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let n = x.len();
        let plan = field::plan(
            &Plummer as &dyn Interaction<f64, 2>,
            n,
            n,
            field::Wanted { gradient: true, ..Default::default() },
            &field::Options::default(),
        )
        .unwrap();
        let mut out = vec![[0.0; 2]; n];
        let mut memory = Memory::new(plan.workspace_bytes(1).unwrap());
        field::evaluate(
            &plan,
            &Plummer,
            field::Sources::new(x, &start.masses),
            x,
            field::Outputs { gradient: Some(&mut out), ..Default::default() },
            memory.get(),
            &mut Run { executor: &Serial, ..Run::default() },
        )
        .unwrap();
        out.iter().map(|g| [-g[0], -g[1]]).collect()
    };
    let dt = 1e-2;
    let along = |k: &[[f64; 2]], s: f64| -> Vec<[f64; 2]> {
        start.positions.iter().zip(k).map(|(x, k)| [x[0] + s * k[0], x[1] + s * k[1]]).collect()
    };
    let k1 = slope(&start.positions);
    let k2 = slope(&along(&k1, dt * 0.5));
    let k3 = slope(&along(&k2, dt * 0.5));
    let k4 = slope(&along(&k3, dt));
    for i in 0..40 {
        for k in 0..2 {
            let sum = k1[i][k] + 2.0 * k2[i][k] + 2.0 * k3[i][k];
            assert_eq!(rig.p.positions[i][k], start.positions[i][k] + dt / 6.0 * (sum + k4[i][k]));
        }
    }
}

/// The stream with the trait of other crates.
struct Words(Split);

impl rand_core::TryRng for Words {
    type Error = core::convert::Infallible;
    fn try_next_u32(&mut self) -> core::result::Result<u32, Self::Error> {
        Ok(self.0.next() as u32)
    }
    fn try_next_u64(&mut self) -> core::result::Result<u64, Self::Error> {
        Ok(self.0.next())
    }
    fn try_fill_bytes(&mut self, out: &mut [u8]) -> core::result::Result<(), Self::Error> {
        out.fill_with(|| self.0.next() as u8);
        Ok(())
    }
}

#[test]
fn a_rand_core_stream_drives_it() {
    let (start, options) = collapsing::<f64>(100, 12);
    let run = |generator: &mut dyn Generator| {
        let mut rig = Rig::new(start.clone(), options, Force::Mesh(Walls::Free), (100, 100), 1);
        for _ in 0..5 {
            rig.step(generator, 1e-4).unwrap();
        }
        rig.bits()
    };
    assert_eq!(run(&mut Stream(Words(Split(77)))), run(&mut Split(77)));
}

#[test]
fn sizes_around_the_tile_and_none() {
    for n in [0, 1, 2, 31, 32, 33, 255, 256, 257, 513] {
        for force in ALL {
            let (start, options) = collapsing::<f64>(n, 20 + n as u64);
            let mut rig = Rig::new(start, options, force, (1000, 1000), 1);
            let mass: f64 = rig.p.masses.iter().sum();
            for _ in 0..3 {
                rig.step(&mut Philox::new(1), 1e-4).unwrap();
            }
            // n additions of positive terms, in two orders.
            let after: f64 = rig.p.masses[..rig.n()].iter().sum();
            assert!((mass - after).abs() <= 2.0 * n as f64 * f64::EPSILON * mass);
        }
    }
}

#[test]
fn reflected_particles_stay_in_the_box() {
    let (start, mut options) = collapsing::<f64>(500, 30);
    options.merging = Merging::Never;
    let mut rig = Rig::new(start, options, Force::Mesh(Walls::NoFlux), (0, 0), 1);
    for _ in 0..20 {
        rig.step(&mut Philox::new(1), 0.05).unwrap();
    }
    assert!(rig.p.positions.iter().flatten().all(|x| x.abs() <= 1.0));
}
