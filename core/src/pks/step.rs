//! One step: clusters, motion, collisions (Zhelezov & Fatkullin, Section 3.2).

use super::close::{self, Close};
use super::collision::{Criterion, Merging};
use super::extent::Extent;
use super::heavy::{Heavy, HeavySet};
use super::merge::{Queue, compact};
use super::motion::{self, Frozen, Moved, Moving};
use super::search::{self, Mesh, Part, Particles, WORDS_OF_RANK};
use super::state::{Counters, Events, Options, Report, Scheme, State};
use super::theory::Constants;
use super::weights::Charges;
use crate::build;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Ranks, Reduction, Resources, Run};
use crate::field::{self, Interaction, Outputs, Sources, Wanted};
use crate::grid::{Grid, Limits, MassScale, Parabolic, Variable, Walls};
use crate::memory::{Carve, Measure, Space, unsigned};
use crate::random::Generator;
use crate::real::{Real, Scalar};
use crate::rk4;

/// Where the particles' attraction comes from.
pub enum Attraction<'a, 'g, T: Real> {
    /// No attraction: no field is computed, whatever chi is. Refused with the feature `small`, as is chi = 0.
    None,
    /// The sum over all particles of a kernel, K = V: exact, without a mesh; all particles share their sub-steps, and each sub-step sums
    /// anew. A mollified kernel bounds the speed. Close pairs that do not merge ([`Merging::Hard`], [`Merging::Never`]) are moved
    /// so that their mean squared distance is exact (`docs/pks.md`), if there is noise.
    Sum(&'a dyn Interaction<T, 2>, &'a field::Options),
    /// A mesh's field, solved once a step, in which every particle takes its own sub-steps, whose expected jumps stay below the
    /// mesh width. In a box with no-flux walls particles are reflected. The grid is written over. Not with the feature `small`.
    ///
    /// With [`Heavy`], not in a box, heavy particles act pair by pair, both ways and at every distance; a stream of random numbers is drawn
    /// for them once more, after all particles.
    Mesh(&'a mut Grid<'g, T>, Option<&'a Heavy<'a, T>>),
    /// The field of a mesh in a medium, div(G grad c) - k^2 c (Zhelezov & Fatkullin, (1.2), Section 4.6), as [`Attraction::Mesh`] without heavy particles. Clusters
    /// have the index (4.30) with gamma = [`Options::gamma`] / G at their centres, which is 1 / (2 pi G) by default. A solve that does not reach its limits ends the step with
    /// [`Error::NotConverged`].
    Medium(&'a mut Variable<'g, T>, Limits<T>),
    /// The field of a mesh with a memory, epsilon c_t = Laplacian(c) - k^2 c + density (Zhelezov & Fatkullin, (6.1)), as [`Attraction::Mesh`] without heavy particles. A step advances c
    /// with the particles where they are, then moves them in the field of the new c: of first order in `dt`, and with epsilon -> 0 the step of [`Attraction::Mesh`]. A step that
    /// fails leaves c; without a particle, or with chi = 0, c stays too. Not with [`Scheme::StrangRk4`].
    ///
    /// Collisions are decided by the law of the elliptic model, for which attraction at a small distance is that of the logarithm at once. That holds to leading order in
    /// `epsilon noise / m`, the ratio of a particle's diffusivity to the attractant's, and once the attractant has been there for a time `epsilon r^2`; no law is known beyond.
    /// [`Merging::Never`] leaves the particles to what the mesh resolves.
    Parabolic(&'a mut Parabolic<'g, T>),
}

impl<T: Real> core::fmt::Debug for Attraction<'_, '_, T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Attraction::None => "None",
            Attraction::Sum(..) => "Sum",
            Attraction::Mesh(_, None) => "Mesh",
            Attraction::Mesh(_, Some(_)) => "Mesh and heavy pairs",
            Attraction::Medium(..) => "Medium",
            Attraction::Parabolic(..) => "Parabolic",
        })
    }
}

impl<'a, T: Real> Attraction<'a, '_, T> {
    /// What [`workspace_bytes`] asks for.
    #[must_use]
    pub fn summed(&self) -> Summed<'a, T> {
        match *self {
            Attraction::Sum(kernel, options) => Some((kernel, options)),
            _ => None,
        }
    }

    /// The mesh's field, if there is one.
    fn grid(&self) -> Option<&Grid<'_, T>> {
        match self {
            Attraction::Mesh(grid, _) => Some(grid),
            Attraction::Medium(field, _) => Some(field.grid()),
            Attraction::Parabolic(field) => Some(field.grid()),
            _ => None,
        }
    }

    /// Where G varies, if it does.
    fn medium(&self) -> Option<&Variable<'_, T>> {
        match self {
            Attraction::Medium(field, _) if build::MESHES => Some(field),
            _ => None,
        }
    }
}

/// The kernel of [`Attraction::Sum`] with its options, for size queries; `None` for the other kinds.
pub type Summed<'a, T> = Option<(&'a dyn Interaction<T, 2>, &'a field::Options)>;

/// What the workspace holds. Only the queue and the clusters outlive a call, and only one that ended with [`Error::EventsFull`].
struct Arrays<'w, T> {
    queue: Queue<'w, T>,
    found: search::Scratch<'w, T>,
    recorded: &'w mut [u8],
    moved: &'w mut [[T; 2]],
    increments: &'w mut [[T; 2]],
    substeps: &'w mut [u32],
    /// Of every particle the gradient, or what the scheme of Strang needs.
    gradient: &'w mut [[T; 2]],
    field: &'w mut [u8],
    close: close::Buffers<'w, T>,
    /// What ranks know of one another's particles.
    known: search::Shared<'w, T>,
}

/// The only statement of the layout. `n` is the room of the state's arrays on each of so many ranks, so that it does not change as particles merge.
fn layout<'w, T: Real>(
    space: &mut impl Space<'w>,
    (n, ranks): (usize, usize),
    summed: &Summed<'_, T>,
    options: &Options<T>,
    workers: usize,
) -> Result<Arrays<'w, T>> {
    let all = if build::RANKS { n.checked_mul(ranks).ok_or(Error::TooLarge)? } else { n };
    u32::try_from(all).ok().filter(|&n| n < u32::MAX).ok_or(Error::TooLarge)?;
    let fixed = build::STRANG && options.scheme == Scheme::StrangRk4;
    // Nothing is searched for where nothing merges.
    let clustered = if options.merging == Merging::Never { 0 } else { all };
    let field = match summed {
        Some((kernel, field)) => field_bytes(*kernel, n, field, workers)?,
        None => 0,
    };
    let arrays = Arrays {
        queue: Queue::layout(space, clustered),
        found: search::Scratch::parts(space, clustered),
        recorded: space.array(clustered.min(n)),
        moved: space.array(n),
        increments: space.array(n),
        substeps: space.array(motion::tiles_of(n)),
        gradient: space.array(match summed {
            _ if fixed => n.checked_mul(rk4::SLICES).ok_or(Error::TooLarge)?,
            Some(_) => n,
            None => 0,
        }),
        field: space.array(field),
        close: close::Buffers::layout(space, if summed.is_some() { n } else { 0 }, options),
        known: search::Scratch::shared(space, clustered, ranks),
    };
    space.finish()?;
    Ok(arrays)
}

/// Bytes of the sum's own workspace.
fn field_bytes<T: Real>(
    kernel: &dyn Interaction<T, 2>,
    n: usize,
    options: &field::Options,
    workers: usize,
) -> Result<usize> {
    if build::METHODS {
        return sum_plan(kernel, n, options)?.workspace_bytes(workers);
    }
    // Every sum is direct and by default options, so there is nothing to plan.
    if Scalar::is_finite(options.tolerance) { field::drift_bytes::<T, 2>(n) } else { Err(Error::NotFinite) }
}

fn sum_plan<T: Real>(kernel: &dyn Interaction<T, 2>, n: usize, options: &field::Options) -> Result<field::Plan> {
    let wanted = Wanted { gradient: true, ..Wanted::default() };
    field::plan(kernel, n, n, wanted, options)
}

/// Bytes that [`step`] needs for state arrays with room for `n` particles and an executor of so many workers.
///
/// # Errors
/// [`Error::TooLarge`]; those of [`Options::check`].
pub fn workspace_bytes<T: Real>(
    n: usize,
    summed: Summed<'_, T>,
    options: &Options<T>,
    workers: usize,
) -> Result<usize> {
    workspace_bytes_on_ranks(n, 1, summed, options, workers)
}

/// As [`workspace_bytes`], for a step with a [communicator](Run::communicator) of so many ranks, all of whose arrays have room for `n` particles.
///
/// In double precision it is about 180 bytes for each particle of all ranks, beside what the motion of a rank's own takes. A step touches some 30 bytes for each of the rank's share of
/// the particles, and 180 for each that may be part of a cluster.
///
/// # Errors
/// As [`workspace_bytes`].
pub fn workspace_bytes_on_ranks<T: Real>(
    n: usize,
    ranks: usize,
    summed: Summed<'_, T>,
    options: &Options<T>,
    workers: usize,
) -> Result<usize> {
    options.check()?;
    Measure::of(|space| layout(space, (n, ranks), &summed, options, workers).map(|_| ()))
}

/// Everything that a step is given beside the state.
#[derive(Debug)]
pub struct Setting<'a, 'g, 'r, T: Real> {
    /// Constants and choices; the same in every step of a run.
    pub options: &'a Options<T>,
    /// Where the attraction comes from.
    pub attraction: Attraction<'a, 'g, T>,
    /// Level, executor, `should_stop`.
    pub run: &'a mut Run<'r>,
    /// Added to; `None` counts nothing, which is all that the feature `small` can do.
    pub report: Option<&'a mut Report>,
}

/// Advances the particles by one step of length `dt`: finds the clusters that may collide, moves every particle, decides the collisions and
/// merges.
///
/// `counters.count` particles are alive; merging lowers it and keeps the order of the others. `workspace` needs
/// [`workspace_bytes`] for the length of the state's arrays. It is garbage afterwards, except when the step ended with
/// [`Error::EventsFull`]: then the particles have moved, `counters.pending` merges are left, absorbed particles still stand in the arrays
/// with mass zero, and the next call (same workspace content, same arrays; `dt` and the generator are not used) goes on with the merges and
/// ends the step.
///
/// Deterministic: with a counter-based generator the result does not depend on the executor.
///
/// With a [communicator](Run::communicator) of more than one rank the particles are those of all ranks, each of which passes its own, in arrays of the same room, and its own workspace of
/// [`workspace_bytes_on_ranks`]. The result is bit for bit that of one process whose arrays are the ranks' one after the other (unless 1.001 times the mass of all is within its rounding of a power of two). All ranks get all events, for which they
/// have to have the same room, and the merged particle stays where that of the lowest label was. The report counts a rank's own sub-steps and normals, and what all ranks do together.
/// An error of one rank is one of all, but for [`Error::EventsFull`], which they meet together.
///
/// With [weights](State::weights) clusters are searched for by these, with the largest sensitivity for all; three passes over the particles are added.
///
/// Cost: O(n log n) for the search, O(n) for the motion, plus the field.
///
/// # Errors
/// Before anything has changed: [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::Mass`], [`Error::TimeStep`], [`Error::OutOfDomain`],
/// [`Error::WorkspaceTooSmall`], [`Error::Misaligned`], [`Error::TooLarge`] (2^32 steps or particles), those of the field and the generator,
/// [`Error::TooManySubsteps`], [`Error::BecameNotFinite`] (in the motion; [`Error::NotFinite`] is what was given), [`Error::Stopped`]. A stream generator may have been drawn from.
/// With more than one rank also [`Error::Unsupported`]: an attraction by a sum, heavy particles, a medium, an attractant with a memory, noise from a stream; [`Error::Communicator`]: ranks have different steps, time steps
/// or room; the communicator's.
/// With [weights](State::weights) [`Error::Mass`], [`Error::NotFinite`] for them, too; [`Error::OutOfDomain`]: a sensitivity, or chi or gamma times the largest, is out of range;
/// [`Error::Unsupported`]: heavy particles, more than one rank, a sum with noise and another merging than [`Merging::All`], the feature `small`.
/// [`Error::EventsFull`]: see above. [`Error::NotPrepared`]: merges are pending, but the workspace does not hold them.
pub fn step<T: Real>(
    state: State<'_, T>,
    counters: &mut Counters,
    generator: &mut dyn Generator,
    dt: T,
    mut events: Events<'_>,
    workspace: &mut [u8],
    setting: Setting<'_, '_, '_, T>,
) -> Result<()> {
    let Setting { options, mut attraction, run, mut report } = setting;
    let ranks = run.communicator.filter(|with| build::RANKS && with.ranks() > 1).map(Ranks::new);
    let ranks = ranks.as_ref();
    let checked = check(&state, counters, dt, options, &attraction, ranks.map(|_| generator.counter_based().is_some()));
    // Merges that are left are the same on all ranks, and need nothing of others.
    let (n, number) = together(ranks.filter(|_| counters.pending == 0), checked)?;
    let room = (state.positions.len(), ranks.map_or(1, Ranks::count));
    let layout = Layout { room, summed: attraction.summed(), options, resources: run.resources(), ranks };
    if counters.pending > 0 {
        let to = Log { events: &mut events, counters, report };
        return layout.commit(workspace, state, Part { own: n, ..Part::default() }, dt, to, None);
    }
    let before = Before {
        positions: part(state.positions, n)?,
        masses: part(state.masses, n)?,
        weights: state.weights.as_deref().map(|weights| part(weights, n)).transpose()?,
        labels: part(state.labels, n)?,
    };
    // In a medium the largest gamma, which bounds what may collide; the search knows those of clusters.
    let gamma = attraction.medium().map_or(options.gamma, |field| options.gamma / field.least_diffusivity());
    let mut criterion = Criterion::new(
        Constants { chi: options.chi, noise: options.noise, gamma },
        options.law,
        options.merging,
        options.probability,
        dt,
    );

    // Section 3.2 (1): clusters.
    let attracted = !matches!(attraction, Attraction::None) && options.chi != T::ZERO;
    let searched = layout.search(workspace, &mut criterion, &before, counters.step, attracted.then_some(&attraction));
    let Searched { found, part, total, largest } = together(ranks, searched)?;
    if let Some(clusters) = found {
        Report { searches: 1, clusters: clusters as u64, ..Report::default() }.add_to(&mut report);
    }
    let found = found.unwrap_or(0);
    if build::MESHES
        && let Attraction::Mesh(_, heavy) = &mut attraction
    {
        // No search if no particle reaches the mass of a heavy one.
        *heavy = heavy.filter(|heavy| largest >= heavy.mass);
    }

    // (2): motion, into the workspace.
    let start =
        Start { before: &before, total, attracted: attracted && part.all > 0, clustered: found > 0, dt, number };
    let moved = layout.advance(workspace, &start, attraction, generator, run, &mut report).map_err(in_run);
    together(ranks, moved)?;

    // (3): collisions, decided on the positions before the motion.
    let to = Log { events: &mut events, counters, report };
    layout.commit(workspace, state, part, dt, to, Some((&criterion, found)))
}

/// What a step is given, checked but for the particles' data: how many they are, and the step's number.
#[inline]
fn check<T: Real>(
    state: &State<'_, T>,
    counters: &Counters,
    dt: T,
    options: &Options<T>,
    attraction: &Attraction<'_, '_, T>,
    counter_based_on_ranks: Option<bool>,
) -> Result<(usize, u32)> {
    let room = state.positions.len();
    let lengths = state.masses.len() == room
        && state.labels.len() == room
        && state.weights.as_ref().is_none_or(|w| w.len() == room)
        && state.species.as_ref().is_none_or(|s| s.len() == room);
    let n = usize::try_from(counters.count).ok().filter(|&n| n <= room).ok_or(Error::LengthMismatch)?;
    if !lengths {
        return Err(Error::LengthMismatch);
    }
    options.check()?;
    let number = u32::try_from(counters.step).map_err(|_| Error::TooLarge)?;
    if !(dt > T::ZERO && dt.is_finite()) {
        return Err(Error::TimeStep);
    }
    if build::MESHES
        && let Attraction::Mesh(grid, Some(heavy)) = attraction
    {
        heavy.check(grid.equation())?;
    }
    if state.weights.is_some() {
        // Whose pair forces know masses alone.
        let by_masses = match attraction {
            Attraction::Mesh(_, heavy) => heavy.is_some(),
            Attraction::Sum(..) => options.merging != Merging::All && options.noise > T::ZERO,
            Attraction::None | Attraction::Medium(..) | Attraction::Parabolic(_) => false,
        };
        if !build::WEIGHTS || by_masses || counter_based_on_ranks.is_some() {
            return Err(Error::Unsupported);
        }
    }
    if build::MESHES && options.scheme == Scheme::StrangRk4 && matches!(attraction, Attraction::Parabolic(_)) {
        return Err(Error::Unsupported);
    }
    if build::RANKS
        && let Some(counter_based) = counter_based_on_ranks
    {
        // What acts pair by pair, and a stream of random numbers, would need all particles.
        let mesh = matches!(attraction, Attraction::None | Attraction::Mesh(_, None));
        if !mesh || options.noise > T::ZERO && !counter_based {
            return Err(Error::Unsupported);
        }
    }
    Ok((n, number))
}

/// The result, if all ranks have one.
#[inline]
fn together<X>(ranks: Option<&Ranks<'_>>, result: Result<X>) -> Result<X> {
    match ranks {
        Some(ranks) if build::RANKS => ranks.agree(result),
        _ => result,
    }
}

/// What all ranks' particles are together, and which of them are this one's: the extent is that of those, of an array with so much room.
fn join<T: Real>(
    ranks: &Ranks<'_>,
    (extent, n): (Extent<T>, usize),
    same: [u64; 3],
    words: &mut [u64],
) -> Result<(Extent<T>, Part)> {
    let Extent { low, high, smallest, largest, total } = extent;
    let numbers = [low[0], low[1], high[0], high[1], smallest, largest, total].map(search::bits);
    let mut told = [n as u64; WORDS_OF_RANK];
    told.iter_mut().skip(1).zip(numbers.into_iter().chain(same)).for_each(|(to, word)| *to = word);
    let words = words.get_mut(..WORDS_OF_RANK * ranks.count()).present()?;
    ranks.gather(&told, words)?;
    let mut part = Part { own: n, ..Part::default() };
    let mut whole = None;
    let (told, _) = words.as_chunks::<WORDS_OF_RANK>();
    for (rank, &[n, a, b, c, d, smallest, largest, total, ref others @ ..]) in told.iter().enumerate() {
        if *others != same {
            return Err(Error::Communicator);
        }
        let n = n as usize;
        part.all += n;
        part.first += if rank < ranks.rank() { n } else { 0 };
        let [low, high] = [[a, b], [c, d]].map(|corner| corner.map(search::number));
        let [smallest, largest, total] = [smallest, largest, total].map(search::number);
        let extent = Extent { low, high, smallest, largest, total };
        // No box holds no particles.
        if n > 0 {
            whole = Some(whole.map_or(extent, |whole: Extent<T>| whole.with(&extent)));
        }
    }
    let whole = whole.unwrap_or(extent);
    if whole.total.is_finite() { Ok((whole, part)) } else { Err(Error::NotFinite) }
}

/// The search has checked the particles, so what the motion finds otherwise has become so.
fn in_run(error: Error) -> Error {
    if error == Error::NotFinite { Error::BecameNotFinite } else { error }
}

/// What the layout depends on. Each part of a step lays the workspace out for itself, so that the arrays of one take no stack of
/// another.
struct Layout<'a, T: Real> {
    /// On each rank, and how many ranks there are.
    room: (usize, usize),
    summed: Summed<'a, T>,
    options: &'a Options<T>,
    resources: Resources<'a>,
    ranks: Option<&'a Ranks<'a>>,
}

/// What the search tells.
struct Searched<T> {
    /// How many clusters may collide; `None`: none can, so none was looked for.
    found: Option<usize>,
    /// Which particles of all are this rank's.
    part: Part,
    /// The sum of the masses.
    total: T,
    /// The largest mass.
    largest: T,
}

/// Where a step's end is told.
struct Log<'a, 'e> {
    events: &'a mut Events<'e>,
    counters: &'a mut Counters,
    report: Option<&'a mut Report>,
}

/// The particles before the step.
struct Before<'a, T> {
    positions: &'a [[T; 2]],
    masses: &'a [T],
    weights: Option<&'a [T]>,
    labels: &'a [u64],
}

/// Where the motion starts.
struct Start<'a, T> {
    before: &'a Before<'a, T>,
    /// Of the masses.
    total: T,
    attracted: bool,
    /// Whether some particles are marked.
    clustered: bool,
    dt: T,
    /// The step's number.
    number: u32,
}

/// The parts of the workspace that the motion uses.
struct Motion<'w, T> {
    recorded: &'w [u8],
    moved: Moved<'w, T>,
    gradient: &'w mut [[T; 2]],
    field: &'w mut [u8],
    close: close::Buffers<'w, T>,
}

impl<T: Real> Layout<'_, T> {
    /// Nothing is zeroed: what follows writes before it reads.
    fn open<'w>(&self, workspace: &'w mut [u8]) -> Result<Arrays<'w, T>> {
        let workers = if build::WORKERS { self.resources.executor.workers() } else { 1 };
        layout(&mut Carve::reopen(workspace)?, self.room, &self.summed, self.options, workers)
    }

    /// Checks the particles, finds the clusters that may collide, unless none can, and marks their particles. Gives the criterion units.
    fn search(
        &self,
        workspace: &mut [u8],
        criterion: &mut Criterion<T>,
        before: &Before<'_, T>,
        step: u64,
        attraction: Option<&Attraction<'_, '_, T>>,
    ) -> Result<Searched<T>> {
        let &Before { positions, masses, weights, .. } = before;
        // Sizes before data. Not moved, as stacks may be short.
        let mut arrays = self.open(workspace);
        let Arrays { queue, found, recorded, known, .. } = arrays.as_mut().map_err(|error| *error)?;
        let (mesh, by, charges, [largest, total], part, in_range) = {
            let (mut extent, n) = (Extent::of(positions, masses, self.resources.executor), positions.len());
            let mut part = Part { first: 0, own: n, all: n };
            if build::RANKS
                && let Some(ranks) = self.ranks
            {
                let same = [step, self.room.0 as u64, search::bits(criterion.dt)];
                let (whole, which) = join(ranks, (ranks.agree(extent)?, n), same, known.words)?;
                (extent, part) = (Ok(whole), which);
            }
            let extent = extent?;
            let (mut by, mut charges) = (extent, None);
            if build::WEIGHTS
                && let Some(weights) = weights
            {
                by = Extent::of(positions, weights, self.resources.executor)?;
                let sensitivity;
                (charges, sensitivity) = Charges::of(masses, weights)?;
                criterion.respond(sensitivity)?;
            }
            let in_range = criterion.scale(&by);
            let mesh = Mesh::new(&self.options.search, &by, step, criterion.units.length);
            (mesh, by, charges, [extent.largest, extent.total], part, in_range)
        };
        queue.clear();
        found.clear();
        let unit = criterion.units.mass;
        let none = Searched { found: None, part, total, largest };
        let Some(attraction) = attraction else { return Ok(none) };
        if part.all < 2 || criterion.impossible(by.largest * unit, by.total * unit) {
            return Ok(none);
        }
        if !in_range {
            return Err(Error::OutOfDomain);
        }
        let (masses, smallest) = (weights.unwrap_or(masses), by.smallest);
        let particles = Particles { positions, masses, charges, smallest, medium: attraction.medium() };
        match self.ranks {
            Some(ranks) if build::RANKS => {
                let (given, on) = ((particles, total), (ranks, part));
                search::find_on_ranks(&self.options.search, criterion, &mesh, given, on, known, self.resources, found)?;
            }
            _ => search::find(&self.options.search, criterion, &mesh, particles, self.resources, found)?,
        }
        if !found.is_empty() {
            recorded.fill(0);
            for cluster in found.clusters() {
                for k in found.members(cluster.first, cluster.count) {
                    let own = match self.ranks {
                        Some(_) if build::RANKS => known.numbers.get(k).and_then(|&number| part.index(number)),
                        _ => Some(k),
                    };
                    if let Some(flag) = own.and_then(|k| recorded.get_mut(k)) {
                        *flag = 1;
                    }
                }
            }
        }
        Ok(Searched { found: Some(found.len()), part, total, largest })
    }

    /// Moves the particles into the workspace, with what the search marked recorded.
    fn advance(
        &self,
        workspace: &mut [u8],
        start: &Start<'_, T>,
        mut attraction: Attraction<'_, '_, T>,
        generator: &mut dyn Generator,
        run: &mut Run<'_>,
        report: &mut Option<&mut Report>,
    ) -> Result<()> {
        let &Start { before, total, attracted, clustered, dt, number: step } = start;
        let &Before { positions, masses, weights, labels } = before;
        let mut limited;
        let mut options = self.options;
        if build::MESHES
            && let Some(grid) = attraction.grid()
        {
            let [h, k] = grid.mesh().spacing();
            limited = *options;
            limited.control.width = limited.control.width.min(h).min(k);
            options = &limited;
        }
        let Motion { recorded, moved, gradient, field, close } = self.motion(workspace, positions.len(), clustered)?;
        let Moved { positions: ends, increments, substeps } = moved;
        let moving = Moving { positions, masses, weights, labels, recorded, options, dt, step, level: run.level };
        let moved = Moved { positions: &mut *ends, increments, substeps };
        let force = if attracted { &mut attraction } else { &mut Attraction::None };
        move_particles(
            &moving,
            total,
            moved,
            force,
            generator,
            Buffers { gradient, field, close },
            (run, self.ranks),
            report,
        )?;
        if build::MESHES
            && let Some(grid) = attraction.grid()
            && grid.equation().walls == Walls::NoFlux
        {
            // Sub-steps beyond a wall were made in the mirrored field: folding the end is reflecting the path.
            ends.iter_mut().for_each(|x| *x = grid.mesh().reflect(*x).0);
        }
        if build::MESHES
            && attracted
            && let Attraction::Parabolic(field) = &mut attraction
        {
            // Nothing can fail from here on.
            field.keep();
        }
        Ok(())
    }

    fn motion<'w>(&self, workspace: &'w mut [u8], n: usize, clustered: bool) -> Result<Motion<'w, T>> {
        let arrays = self.open(workspace)?;
        let recorded: &[u8] = arrays.recorded;
        let of = |points: &'w mut [[T; 2]]| points.get_mut(..n).present();
        Ok(Motion {
            recorded: if clustered { recorded.get(..n).present()? } else { &[] },
            moved: Moved {
                positions: of(arrays.moved)?,
                increments: of(arrays.increments)?,
                substeps: arrays.substeps.get_mut(..motion::tiles_of(n)).present()?,
            },
            gradient: arrays.gradient,
            field: arrays.field,
            close: arrays.close,
        })
    }

    /// Decides the clusters, if there is a criterion (else merges are pending), takes the new positions over, merges, and ends the step.
    fn commit(
        &self,
        workspace: &mut [u8],
        mut state: State<'_, T>,
        which: Part,
        dt: T,
        to: Log<'_, '_>,
        criterion: Option<(&Criterion<T>, usize)>,
    ) -> Result<()> {
        let mut arrays = self.open(workspace);
        let Arrays { queue, found, moved, increments, known, .. } = arrays.as_mut().map_err(|error| *error)?;
        let Log { events, counters, mut report } = to;
        let n = which.own;
        let mut merges = true;
        if let Some((criterion, clusters)) = criterion {
            let moved = moved.get(..n).present()?;
            if clusters > 0 {
                found.resume(clusters);
                let masses = state.weights.as_deref().unwrap_or(state.masses);
                let (positions, masses, labels) = (part(state.positions, n)?, part(masses, n)?, part(state.labels, n)?);
                match self.ranks {
                    Some(ranks) if build::RANKS => {
                        known.fill_moved(ranks, which, found, &|i| {
                            let (x, w) = (*moved.get(i).present()?, *increments.get(i).present()?);
                            Ok((x, w, *labels.get(i).present()?))
                        })?;
                        let before = (&*known.positions, &*known.masses, &*known.labels);
                        queue.decide(criterion, found, before, (known.increments, dt), counters);
                    }
                    _ => queue.decide(criterion, found, (positions, masses, labels), (increments, dt), counters),
                }
            }
            let positions = state.positions.get_mut(..n).present()?;
            motion::copy(positions, moved, self.resources);
            merges = clusters > 0 && queue.left(counters)? > 0;
        }
        if merges {
            if build::RANKS && self.ranks.is_some() {
                let (positions, masses, labels) = (&mut *known.moved, &mut *known.masses, &mut *known.labels);
                let merged = &mut State { positions, masses, labels, species: None, weights: None };
                queue.run(merged, found, events, counters, &mut report)?;
                found.resume(queue.clusters());
                known.give_back(found, state.positions, state.masses);
            } else {
                queue.run(&mut state, found, events, counters, &mut report)?;
            }
            counters.count = compact(&mut state, n) as u64;
            queue.clear();
        }
        counters.pending = 0;
        counters.time = dt.add_to(counters.time);
        counters.step += 1;
        Ok(())
    }
}

/// What [`move_particles`] writes on the way.
struct Buffers<'s, T> {
    gradient: &'s mut [[T; 2]],
    field: &'s mut [u8],
    close: close::Buffers<'s, T>,
}

/// Moves all particles, of this mass: chooses the way, sums or solves the field, counts.
#[expect(clippy::too_many_arguments, reason = "one caller; a structure of them would stand on short stacks")]
#[inline]
fn move_particles<T: Real>(
    moving: &Moving<'_, T>,
    total: T,
    moved: Moved<'_, T>,
    force: &mut Attraction<'_, '_, T>,
    generator: &mut dyn Generator,
    buffers: Buffers<'_, T>,
    (run, ranks): (&mut Run<'_>, Option<&Ranks<'_>>),
    report: &mut Option<&mut Report>,
) -> Result<()> {
    let n = moving.positions.len();
    let noisy = moving.options.noise > T::ZERO;
    let fixed = build::STRANG && moving.options.scheme == Scheme::StrangRk4;
    let resources = run.resources();
    let stop = |run: &Run<'_>| if run.should_stop.is_some_and(|stop| stop()) { Err(Error::Stopped) } else { Ok(()) };
    // The unit of masses on a mesh, with a margin for the rounding of the sum.
    let scale = || MassScale::for_total(T::from_f64(1.001) * total);
    let (mut fields, mut drawn) = (0, 0);
    let mut close = match force {
        Attraction::Sum(kernel, _) => Close::new(*kernel, moving.options, moving.masses, buffers.close),
        _ => None,
    };
    let close = close.as_mut();
    if !build::METHODS {
        // Only common sub-steps in a field summed over pairs are available.
        let Attraction::Sum(kernel, _) = force else { return Err(Error::Unsupported) };
        let mut sum = |points: &[[T; 2]], slopes: &mut [[T; 2]]| {
            stop(run)?;
            fields += 1;
            field::drift(*kernel, Sources::new(points, moving.masses), slopes, buffers.field, run)
        };
        let gradient = buffers.gradient.get_mut(..n).present()?;
        let made = n as u64 * motion::together(moving, &mut sum, close, generator, moved, gradient)?;
        let normals = if noisy { made } else { 0 };
        Report { fields, substeps: made, normals, ..Report::default() }.add_to(report);
        return Ok(());
    }
    let (made, draws) = match (fixed, force) {
        (false, Attraction::None) => (motion::frozen(moving, None, generator, moved, resources)?, 1),
        (false, Attraction::Mesh(grid, heavy)) => {
            stop(run)?;
            let picked = solve(grid, *heavy, scale()?, (moving.positions, moving.masses), resources, ranks)?;
            fields += 1;
            stop(run)?;
            let grid = &**grid;
            let gradient = |points: &[[T; 2]], out: &mut [[T; 2]], jumps: &mut [T]| {
                grid.interpolate_here(points, out, resources.level);
                if let Some(picked) = &picked {
                    picked.attract(points, out, jumps, resources.level);
                }
            };
            let others = picked.as_ref().map_or(&[][..], HeavySet::indices);
            let Moved { positions, increments, substeps } = moved;
            let field = Frozen { gradient: &gradient, others };
            let to = Moved { positions: &mut *positions, increments: &mut *increments, substeps };
            let mut made = motion::frozen(moving, Some(&field), generator, to, resources)?;
            if let Some(picked) = &picked {
                let to = Moved { positions, increments, substeps: &mut [] };
                // In place of the one that was made and written over.
                drawn += picked.indices().len() as u64;
                made = made.saturating_sub(drawn) + picked.advance(grid, moving, generator, to, resources)?;
            }
            (made, 1)
        }
        (false, force @ (Attraction::Medium(..) | Attraction::Parabolic(_))) => {
            stop(run)?;
            let particles = (moving.positions, moving.masses);
            match force {
                Attraction::Medium(field, limits) => solve_in_medium(field, limits, scale()?, particles, resources)?,
                Attraction::Parabolic(field) => look_ahead(field, moving.dt, scale()?, particles, resources)?,
                _ => return Err(Error::Internal),
            }
            fields += 1;
            stop(run)?;
            let grid = force.grid().present()?;
            let gradient = |points: &[[T; 2]], out: &mut [[T; 2]], _: &mut [T]| {
                grid.interpolate_here(points, out, resources.level);
            };
            let field = Frozen { gradient: &gradient, others: &[] };
            (motion::frozen(moving, Some(&field), generator, moved, resources)?, 1)
        }
        (fixed, force) => {
            // Its plan is for the particles alive.
            let plan = force.summed().map(|(kernel, field)| sum_plan(kernel, n, field)).transpose()?;
            let none = matches!(force, Attraction::None);
            let mut sum = |points: &[[T; 2]], slopes: &mut [[T; 2]]| -> Result<()> {
                stop(run)?;
                fields += 1;
                match (&mut *force, &plan) {
                    (Attraction::Mesh(grid, heavy), _) => {
                        let particles = (points, moving.masses);
                        match solve(grid, *heavy, scale()?, particles, resources, ranks)? {
                            Some(picked) => picked.gradient(grid, particles, slopes, resources),
                            None => grid.interpolate(points, slopes, resources),
                        }
                    }
                    (Attraction::Medium(field, limits), _) => {
                        solve_in_medium(field, limits, scale()?, (points, moving.masses), resources)?;
                        field.grid().interpolate(points, slopes, resources)
                    }
                    (Attraction::Sum(kernel, _), Some(plan)) => {
                        let outputs = Outputs { gradient: Some(slopes), ..Outputs::default() };
                        let sources = Sources::new(points, moving.masses);
                        field::flow(plan, *kernel, sources, points, outputs, buffers.field, run)
                    }
                    _ => Err(Error::Unsupported),
                }
            };
            let all = n as u64;
            if fixed {
                let stages = buffers.gradient.get_mut(..rk4::SLICES * n).present()?;
                let stages = &mut rk4::Scratch::split(stages.as_flattened_mut());
                let sum: Option<&mut motion::Sum<'_, T>> = if none { None } else { Some(&mut sum) };
                (all * motion::strang(moving, sum, close, generator, moved, stages)?, 2)
            } else {
                let gradient = buffers.gradient.get_mut(..n).present()?;
                (all * motion::together(moving, &mut sum, close, generator, moved, gradient)?, 1)
            }
        }
    };
    let normals = if noisy { made * draws + drawn } else { 0 };
    Report { fields, substeps: made, normals, ..Report::default() }.add_to(report);
    Ok(())
}

/// Solves for the field of all particles but the heavy ones, which are returned.
fn solve<'h, T: Real>(
    grid: &mut Grid<'_, T>,
    heavy: Option<&'h Heavy<'h, T>>,
    scale: MassScale,
    (positions, masses): (&[[T; 2]], &[T]),
    resources: Resources<'_>,
    ranks: Option<&Ranks<'_>>,
) -> Result<Option<HeavySet<'h, T>>> {
    let picked = heavy.and_then(|heavy| HeavySet::of(heavy, positions, masses));
    grid.begin(scale);
    let added = grid.add(positions, masses, resources);
    together(ranks, added)?;
    if let Some(ranks) = ranks {
        ranks.reduce(Reduction::Sum, unsigned(grid.words_mut()))?;
    }
    if let Some(picked) = &picked {
        picked.remove_from(grid, resources)?;
    }
    grid.solve(resources)?;
    Ok(picked)
}

/// Solves for the field of all particles.
fn solve_in_medium<T: Real>(
    field: &mut Variable<'_, T>,
    limits: &Limits<T>,
    scale: MassScale,
    (positions, masses): (&[[T; 2]], &[T]),
    resources: Resources<'_>,
) -> Result<()> {
    field.begin(scale);
    field.add(positions, masses, resources)?;
    field.solve(limits, resources).map(|_| ())
}

/// Computes the attractant after a time `dt` with all particles where they are.
fn look_ahead<T: Real>(
    field: &mut Parabolic<'_, T>,
    dt: T,
    scale: MassScale,
    (positions, masses): (&[[T; 2]], &[T]),
    resources: Resources<'_>,
) -> Result<()> {
    field.begin(scale);
    field.add(positions, masses, resources)?;
    field.look_ahead(dt, resources)
}

/// The first `n` elements.
fn part<X>(slice: &[X], n: usize) -> Result<&[X]> {
    slice.get(..n).present()
}
