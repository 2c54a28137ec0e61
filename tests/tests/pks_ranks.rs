//! Coalescing particles spread over ranks: bit for bit what one process computes.

use mollis_core::exec::{Communicator, Executor, Run, Serial};
use mollis_core::grid::{Equation, Grid, Mesh, Walls};
use mollis_core::pks::{
    Attraction, Counters, Event, Events, Merging, Options, Report, Scheme, Setting, State, step, theory,
    workspace_bytes_on_ranks,
};
use mollis_core::random::{Generator, Philox};
use mollis_core::{Error, Real, Result};
use mollis_tests::ranks::World;
use mollis_tests::{Aligned, Split, Threads};

#[derive(Clone)]
struct Particles<T> {
    positions: Vec<[T; 2]>,
    masses: Vec<T>,
    labels: Vec<u64>,
    species: Vec<u32>,
}

/// What a run is made with.
#[derive(Clone)]
struct Case<T> {
    name: &'static str,
    particles: Particles<T>,
    options: Options<T>,
    /// None: no mesh.
    walls: Option<Walls>,
    dt: f64,
    steps: usize,
    workers: usize,
    /// Room for events, and for the labels absorbed.
    room: (usize, usize),
}

/// What a rank has after a run.
#[derive(Clone, Debug, PartialEq)]
struct Outcome {
    /// Bits of all that belongs to the particles alive.
    rows: Vec<[u64; 5]>,
    /// Bits of time, and step.
    time: [u64; 2],
    /// Time, label, mass, index and absorbed labels of each event.
    events: Vec<([u64; 4], Vec<u64>)>,
    report: Report,
    /// Times that the buffers were emptied within a step.
    full: usize,
    /// Calls of the communicator, and words.
    calls: [usize; 2],
}

const CELLS: usize = 24;

impl<T: Real> Case<T> {
    /// The particles of this range, on one rank.
    fn run(
        &self,
        range: std::ops::Range<usize>,
        room: usize,
        generator: &mut dyn Generator,
        communicator: Option<&mollis_tests::ranks::Rank<'_>>,
    ) -> Result<Outcome> {
        let n = range.len();
        // Garbage behind the particles.
        let fill = |of: &[T]| of[range.clone()].iter().copied().chain(vec![T::NAN; room - n]).collect::<Vec<T>>();
        let mut masses = fill(&self.particles.masses);
        let columns = [0, 1].map(|k| fill(&self.particles.positions.iter().map(|x| x[k]).collect::<Vec<T>>()));
        let mut positions: Vec<[T; 2]> = (0..room).map(|i| [columns[0][i], columns[1][i]]).collect();
        let mut labels = self.particles.labels[range.clone()].to_vec();
        labels.resize(room, 0);
        let mut species = self.particles.species[range].to_vec();
        species.resize(room, 0);
        let threads = Threads(self.workers);
        let executor: &dyn Executor = if self.workers == 1 { &Serial } else { &threads };
        let ranks = communicator.map_or(1, Communicator::ranks);
        let mut workspace =
            Aligned::new(workspace_bytes_on_ranks(room, ranks, None, &self.options, self.workers).unwrap());
        let mesh = Mesh::new([T::from_f64(-1.5); 2], [T::from_f64(1.5); 2], [CELLS; 2]).unwrap();
        let equation = Equation { walls: self.walls.unwrap_or(Walls::Free), ..Equation::POISSON };
        let mut memory = Aligned::new(Grid::workspace_bytes(&mesh, &equation, self.workers).unwrap());
        let mut grid = Grid::prepare(memory.bytes(), mesh, equation, self.workers).unwrap();
        let mut counters = Counters { count: n as u64, ..Counters::default() };
        let (mut events, mut absorbed) = (vec![Event::default(); self.room.0], vec![0; self.room.1]);
        let (mut all, mut full, mut report) = (Vec::new(), 0, Report::default());
        for _ in 0..self.steps {
            loop {
                let (mut written, mut labels_written) = (0, 0);
                let made = step(
                    State {
                        positions: &mut positions,
                        masses: &mut masses,
                        labels: &mut labels,
                        species: Some(&mut species),
                        weights: None,
                    },
                    &mut counters,
                    generator,
                    T::from_f64(self.dt),
                    Events {
                        events: &mut events,
                        labels: &mut absorbed,
                        written: &mut written,
                        labels_written: &mut labels_written,
                    },
                    workspace.bytes(),
                    Setting {
                        options: &self.options,
                        attraction: match self.walls {
                            Some(_) => Attraction::Mesh(&mut grid, None),
                            None => Attraction::None,
                        },
                        run: &mut Run { executor, communicator: communicator.map(|c| c as _), ..Run::default() },
                        report: Some(&mut report),
                    },
                );
                for event in &events[..written] {
                    let numbers = [event.time.to_bits(), event.label, event.mass.to_bits(), event.index.to_bits()];
                    let first = event.first as usize;
                    all.push((numbers, absorbed[first..first + event.absorbed as usize].to_vec()));
                }
                match made {
                    Err(Error::EventsFull) => full += 1,
                    made => break made?,
                }
            }
        }
        let rows = (0..counters.count as usize).map(|i| {
            let [x, y] = positions[i];
            [x.bits(), y.bits(), masses[i].bits(), labels[i], u64::from(species[i])]
        });
        Ok(Outcome {
            rows: rows.collect(),
            time: [counters.time.to_bits(), counters.step],
            events: all,
            report,
            full,
            calls: communicator.map_or([0; 2], |c| [c.calls(), c.words()]),
        })
    }

    /// By one process.
    fn alone(&self) -> Outcome {
        let n = self.particles.masses.len();
        self.run(0..n, n, &mut Philox::new(7), None).unwrap()
    }

    /// By ranks whose particles end at these.
    fn on_ranks(&self, ends: &[usize], world: &World) -> Vec<Result<Outcome>> {
        let starts: Vec<usize> = std::iter::once(0).chain(ends.iter().copied()).collect();
        let room = starts.windows(2).map(|w| w[1] - w[0]).max().unwrap();
        world.run(|rank| {
            let range = starts[rank.rank()]..starts[rank.rank() + 1];
            self.run(range, room, &mut Philox::new(7), Some(rank))
        })
    }

    /// Ranks do what one process does.
    fn check(&self, ends: &[usize]) -> Vec<Outcome> {
        let one = self.alone();
        let all: Vec<Outcome> = self.on_ranks(ends, &World::new(ends.len())).into_iter().map(Result::unwrap).collect();
        let name = format!("{} on {ends:?}", self.name);
        let rows: Vec<[u64; 5]> = all.iter().flat_map(|outcome| outcome.rows.iter().copied()).collect();
        assert!(rows == one.rows, "{name}: {} and {} particles", rows.len(), one.rows.len());
        for outcome in &all {
            assert!(outcome.events == one.events, "{name}: {} events", outcome.events.len());
            assert_eq!((outcome.time, outcome.full), (one.time, one.full), "{name}");
            let told =
                |report: &Report| [report.searches, report.clusters, report.merges, report.absorbed, report.fields];
            assert_eq!(told(&outcome.report), told(&one.report), "{name}");
        }
        let sum = |of: &dyn Fn(&Report) -> u64| all.iter().map(|outcome| of(&outcome.report)).sum::<u64>();
        assert_eq!(sum(&|r| r.substeps), one.report.substeps, "{name}");
        assert_eq!(sum(&|r| r.normals), one.report.normals, "{name}");
        all
    }

    /// Merges of particles of several ranks.
    fn across(&self, ends: &[usize]) -> usize {
        let rank = |label: &u64| {
            let at = self.particles.labels.iter().position(|l| l == label).unwrap();
            ends.partition_point(|&end| end <= at)
        };
        let several =
            |(numbers, absorbed): &&([u64; 4], Vec<u64>)| absorbed.iter().any(|label| rank(label) != rank(&numbers[1]));
        self.alone().events.iter().filter(several).count()
    }
}

/// Ends of slices of about the same length.
fn slices(n: usize, ranks: usize) -> Vec<usize> {
    (1..=ranks).map(|r| n * r / ranks).collect()
}

/// Particles of these places, of 60 in all if `heavy` is 0, with shuffled labels; the first ones have `heavy` each.
fn spread<T: Real>(places: Vec<[f64; 2]>, seed: u64, heavy: &[f64]) -> Particles<T> {
    let (n, mut random) = (places.len(), Split(seed));
    let mut labels: Vec<u64> = (0..n as u64).map(|k| 3 * k + 5).collect();
    for i in (1..n).rev() {
        labels.swap(i, (random.next() % (i as u64 + 1)) as usize);
    }
    let mass = |i: usize| {
        heavy
            .get(i / 7)
            .filter(|_| i.is_multiple_of(7))
            .copied()
            .unwrap_or(60.0 / n as f64 * (1.0 + 0.5 * (i % 2) as f64))
    };
    Particles {
        positions: places.into_iter().map(|x| x.map(T::from_f64)).collect(),
        masses: (0..n).map(|i| T::from_f64(mass(i))).collect(),
        labels,
        species: (0..n as u32).map(|i| i % 5).collect(),
    }
}

/// A thin cloud and a clump in it.
fn clump(n: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Split(seed);
    let mut place = |i: usize| {
        let size = if i.is_multiple_of(3) { 0.9 } else { 0.15 };
        [0.2, -0.1].map(|c| c + size * (random.uniform() + random.uniform() - 1.0))
    };
    (0..n).map(&mut place).collect()
}

/// Uniform in a square.
fn square(n: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Split(seed);
    (0..n).map(|_| [0, 1].map(|_| 2.0 * random.uniform() - 1.0)).collect()
}

fn cases<T: Real>() -> Vec<Case<T>> {
    let options = |n: usize| Options::new(T::ONE, T::from_f64(theory::noise(75.0, 1.0, n)));
    let case = |name, places: Vec<[f64; 2]>, heavy: &[f64]| {
        let n = places.len();
        Case {
            name,
            particles: spread(places, n as u64, heavy),
            options: options(n),
            walls: Some(Walls::Free),
            dt: 1e-3,
            steps: 6,
            workers: 1,
            room: (10_000, 10_000),
        }
    };
    let few = case("few", clump(300, 3), &[]);
    let many = case("many in a clump", clump(4000, 4), &[]);
    let light = Case { dt: 1e-5, ..case("light ones", square(20_000, 5), &[]) };
    let heavy = case("heavy ones", square(6000, 6), &[5.0, 8.0, 13.0]);
    let mut same = square(3000, 9);
    for i in 0..200 {
        // At the same places, or nearly so.
        same[2999 - i] = same[i].map(|x| x + if i % 2 == 0 { 0.0 } else { 1e-9 });
    }
    let mut box_of = Case { walls: Some(Walls::NoFlux), ..many.clone() };
    box_of.options.search.domain = Some([[T::from_f64(-1.5); 2], [T::from_f64(1.5); 2]]);
    let mut strang = many.clone();
    strang.options.scheme = Scheme::StrangRk4;
    let mut never = many.clone();
    never.options.merging = Merging::Never;
    let mut hard = Case { name: "hard", steps: 12, ..heavy.clone() };
    hard.options.merging = Merging::Hard;
    // All at once: more than pairs of buckets collapse.
    let mut collapse = Case { name: "collapse", steps: 3, dt: 0.5, ..case("", clump(2000, 8), &[]) };
    collapse.options.control.at_most = 1 << 30;
    vec![
        Case { workers: 3, name: "three workers", ..many.clone() },
        Case { room: (7, 40), name: "short buffers", ..many.clone() },
        Case { name: "a box", ..box_of },
        Case { name: "by Strang's scheme", ..strang },
        Case { name: "no merging", ..never },
        Case { name: "no attraction", walls: None, ..many.clone() },
        case("same places", same, &[]),
        few,
        many,
        light,
        heavy,
        hard,
        collapse,
    ]
}

#[test]
fn ranks_do_what_one_process_does() {
    let mut across = 0;
    for case in cases::<f64>() {
        let n = case.particles.masses.len();
        for ranks in 1..=4 {
            case.check(&slices(n, ranks));
        }
        across += case.across(&slices(n, 3));
        // Without particles; with few; with all.
        case.check(&[0, n / 3, n / 3, n]);
        case.check(&[0, n]);
        case.check(&[1, n - 1, n]);
    }
    assert!(across > 300, "{across}");
    for case in cases::<f32>() {
        case.check(&slices(case.particles.masses.len(), 3));
    }
}

#[test]
fn no_particles_and_one() {
    let all = &cases::<f64>()[0];
    for n in [0, 1, 2] {
        let mut case = all.clone();
        case.particles.positions.truncate(n);
        case.particles.masses.truncate(n);
        case.particles.labels.truncate(n);
        case.particles.species.truncate(n);
        case.check(&[n / 2, n]);
        case.check(&[0, n, n]);
    }
}

/// A call of the communicator fails: the step ends with its error on all ranks, and nothing has changed.
#[test]
fn a_failing_call_ends_the_step() {
    let mut case = cases::<f64>().swap_remove(0);
    (case.steps, case.workers) = (1, 1);
    let n = case.particles.masses.len();
    let calls = case.check(&[n / 2, n])[0].calls[0];
    assert!(calls > 10, "{calls}");
    for fails_at in 0..calls {
        for result in case.on_ranks(&[n / 2, n], &World::failing(2, fails_at)) {
            assert_eq!(result, Err(Error::Executor), "{fails_at}");
        }
    }
}

/// What is wrong on one rank ends the step on all.
#[test]
fn an_error_of_one_rank_is_that_of_all() {
    let mut case = cases::<f64>().swap_remove(0);
    (case.steps, case.workers) = (1, 1);
    let n = case.particles.masses.len();
    let ends = [n / 3, 2 * n / 3, n];
    let check = |case: &Case<f64>, want: Error| {
        for result in case.on_ranks(&ends, &World::new(3)) {
            assert_eq!(result, Err(want));
        }
    };
    let mut bad = case.clone();
    bad.particles.positions[n / 2][1] = f64::NAN;
    check(&bad, Error::NotFinite);
    let mut bad = case.clone();
    bad.particles.masses[5] = 0.0;
    check(&bad, Error::Mass);
    // The sum of all masses is out of range, that of each rank's is not.
    let mut bad = case.clone();
    bad.particles.masses.fill(1.5e308 / (n / 3) as f64);
    check(&bad, Error::NotFinite);
    // On one rank only: the fast particle.
    let mut bad = case.clone();
    bad.options.control.at_most = 2;
    bad.particles.masses[n - 1] = 1e-9;
    check(&bad, Error::TooManySubsteps);
}

/// What would need all particles is refused, as are ranks that were given different things.
#[test]
fn what_is_refused_on_ranks() {
    let case = cases::<f64>().swap_remove(0);
    let mut streams = Case { steps: 1, workers: 1, ..case.clone() };
    let n = case.particles.masses.len();
    let refused = |case: &Case<f64>, generator: &(dyn Fn() -> Box<dyn Generator> + Sync)| {
        World::new(2).run(|rank| {
            let half = n / 2;
            let range = if rank.rank() == 0 { 0..half } else { half..n };
            case.run(range, n - half, &mut *generator(), Some(rank)).map(|_| ())
        })
    };
    let stream: &(dyn Fn() -> Box<dyn Generator> + Sync) = &|| Box::new(mollis_tests::Split(3));
    assert_eq!(refused(&streams, stream), [Err(Error::Unsupported); 2]);
    // Without noise nothing is drawn.
    streams.options.noise = 0.0;
    assert_eq!(refused(&streams, stream), [Ok(()); 2]);
    let lengths = World::new(2).run(|rank| {
        let case = Case { steps: 1, workers: 1, dt: 1e-3 * (1.0 + rank.rank() as f64), ..case.clone() };
        case.run(0..n / 2, n / 2, &mut Philox::new(7), Some(rank)).map(|_| ())
    });
    assert_eq!(lengths, [Err(Error::Communicator); 2]);
    let rooms = World::new(2).run(|rank| {
        let case = Case { steps: 1, workers: 1, ..case.clone() };
        case.run(0..n / 2, n / 2 + rank.rank(), &mut Philox::new(7), Some(rank)).map(|_| ())
    });
    assert_eq!(rooms, [Err(Error::Communicator); 2]);
}
