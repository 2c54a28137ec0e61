//! Coalescing particles.

use core::ffi::c_void;

use mollis_core::field;
use mollis_core::grid::Grid;
use mollis_core::kernel::Kernel;
use mollis_core::pks::{
    self, Attraction, CollisionLaw, Counters, Event, Events, Merging, Report, Scheme, Setting, State, Summed, theory,
};
use mollis_core::random::{Generator, Philox};
use mollis_core::space::{ALIGN, Plain};
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, disjoint, workspace};
use crate::grid::{equation, mollis_grid2_options, mollis_mesh2};
use crate::kernel;
use crate::options::{self, Options};
use crate::random::{HostGenerator, mollis_generator};
use crate::run::{HostRun, mollis_run};
use crate::status::{mollis_status, status};

/// Collisions by the law of the hitting time of zero.
pub const MOLLIS_PKS_LAW_EXACT: i32 = 0;
/// Collisions by one Gaussian increment of the second moment, as Zhelezov & Fatkullin print it, (3.11).
pub const MOLLIS_PKS_LAW_PRINTED: i32 = 1;
/// Every collision merges: nu < 0.
pub const MOLLIS_PKS_MERGE_ALL: i32 = 0;
/// Only collisions that must happen merge: nu <= -1.
pub const MOLLIS_PKS_MERGE_HARD: i32 = 1;
/// Nothing merges.
pub const MOLLIS_PKS_MERGE_NEVER: i32 = 2;
/// Adaptive Euler-Maruyama sub-steps.
pub const MOLLIS_PKS_SCHEME_EULER_MARUYAMA: i32 = 0;
/// One RK4 step of the drift between two half steps of the noise.
pub const MOLLIS_PKS_SCHEME_STRANG_RK4: i32 = 1;
/// No attraction.
pub const MOLLIS_PKS_ATTRACTION_NONE: i32 = 0;
/// The field of a mesh, solved once a step.
pub const MOLLIS_PKS_ATTRACTION_MESH: i32 = 1;
/// The sum of a prepared kernel over all particles, in every sub-step.
pub const MOLLIS_PKS_ATTRACTION_SUM: i32 = 2;

/// What a run is made with. Fill it with `mollis_pks_options_init`, then set at least chi and noise.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_options {
    /// Bytes of this structure, as `mollis_pks_options_init` sets it.
    pub size: u32,
    /// `MOLLIS_PKS_LAW_*`. Default: exact.
    pub law: i32,
    /// `MOLLIS_PKS_MERGE_*`. Default: all.
    pub merging: i32,
    /// `MOLLIS_PKS_SCHEME_*`. Default: Euler-Maruyama.
    pub scheme: i32,
    /// chi of (1.3), any sign; 0 solves no field. Default: 0.
    pub chi: f64,
    /// mu~ of (1.3), at least 0: a particle of mass m diffuses with noise / m. 0 draws no random number. Default: 0.
    pub noise: f64,
    /// The potential is gamma log r near zero. Default: 1 / (2 pi).
    pub gamma: f64,
    /// eta of (3.1), between 0 and 1. Default: 0.1.
    pub separation: f64,
    /// p of (3.2), between 0 and 1: clusters that collide with a smaller probability are left alone. Default: 1e-4.
    pub probability: f64,
    /// The expected jump of a sub-step stays below this length; 0: no limit but the mesh width. Default: 0.
    pub width: f64,
    /// At least so many sub-steps a step. Default: 1.
    pub at_least: u32,
    /// More sub-steps than this are refused with MOLLIS_ERR_TOO_MANY_SUBSTEPS. Default: 100,000.
    pub at_most: u32,
    /// Cells of the coarse mesh in which clusters are searched for. Default: 1, 1.
    pub mesh: [u32; 2],
    /// The box that this mesh covers, beside all particles: lower and upper corner. All 0: the mesh's rectangle, or twice the particles'
    /// bounding box. Default: 0.
    pub domain: [f64; 4],
    /// Nonzero: the coarse mesh is shifted from step to step, so that no cluster lies across the same border for long. Default: 1.
    pub shifted: i32,
    /// 0.
    pub reserved: i32,
}

// SAFETY: `repr(C)`, the size first; older versions are prefixes, and all members take any bytes an older caller wrote.
unsafe impl Options for mollis_pks_options {
    const DEFAULT: Self = Self {
        size: size_of::<Self>() as u32,
        law: MOLLIS_PKS_LAW_EXACT,
        merging: MOLLIS_PKS_MERGE_ALL,
        scheme: MOLLIS_PKS_SCHEME_EULER_MARUYAMA,
        chi: 0.0,
        noise: 0.0,
        gamma: theory::GAMMA,
        separation: 0.1,
        probability: 1e-4,
        width: 0.0,
        at_least: 1,
        at_most: 100_000,
        mesh: [1, 1],
        domain: [0.0; 4],
        shifted: 1,
        reserved: 0,
    };
}

/// Fills `options` with the defaults. `size` is `sizeof *options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_options_init(options: *mut mollis_pks_options, size: usize) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { options::init(options, size) })
}

fn core_options<T: Real>(options: &mollis_pks_options) -> Result<pks::Options<T>> {
    let mut out = pks::Options::new(T::from_f64(options.chi), T::from_f64(options.noise));
    out.law = match options.law {
        MOLLIS_PKS_LAW_EXACT => CollisionLaw::Exact,
        MOLLIS_PKS_LAW_PRINTED => CollisionLaw::Printed,
        _ => return Err(Error::UnknownValue),
    };
    out.merging = match options.merging {
        MOLLIS_PKS_MERGE_ALL => Merging::All,
        MOLLIS_PKS_MERGE_HARD => Merging::Hard,
        MOLLIS_PKS_MERGE_NEVER => Merging::Never,
        _ => return Err(Error::UnknownValue),
    };
    out.scheme = match options.scheme {
        MOLLIS_PKS_SCHEME_EULER_MARUYAMA => Scheme::EulerMaruyama,
        MOLLIS_PKS_SCHEME_STRANG_RK4 => Scheme::StrangRk4,
        _ => return Err(Error::UnknownValue),
    };
    out.gamma = T::from_f64(options.gamma);
    out.probability = T::from_f64(options.probability);
    out.control.width = if options.width == 0.0 { T::INFINITY } else { T::from_f64(options.width) };
    out.control.at_least = options.at_least;
    out.control.at_most = options.at_most;
    out.search.separation = T::from_f64(options.separation);
    out.search.mesh = options.mesh;
    out.search.shifted = options.shifted != 0;
    if options.domain != [0.0; 4] {
        let [a, b, c, d] = options.domain.map(T::from_f64);
        out.search.domain = Some([[a, b], [c, d]]);
    }
    out.check()?;
    Ok(out)
}

/// Where the attraction comes from; the members of the other kinds are not looked at.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_attraction {
    /// `MOLLIS_PKS_ATTRACTION_*`.
    pub kind: i32,
    /// 0.
    pub reserved: i32,
    /// MESH: its rectangle and cells.
    pub mesh: *const mollis_mesh2,
    /// MESH: walls and screening; null for free space without screening.
    pub grid: *const mollis_grid2_options,
    /// SUM: a kernel prepared by mollis_kernel2_prepare (or its _f32); its mollifier bounds the speed.
    pub kernel: *const c_void,
    /// SUM: the bytes of its buffer.
    pub kernel_bytes: usize,
    /// SUM: the relative error that may be spent for speed; 0 for rounding alone.
    pub tolerance: f64,
}

/// Time, and what a run counts. Zero it, then set `count`; it belongs to the state that a checkpoint saves.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_counters {
    /// The time reached.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Particles alive: the first so many elements of the arrays.
    pub count: u64,
    /// Merges of the current step that wait for room in the event buffer; 0 between steps.
    pub pending: u64,
}

/// One merge.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_event {
    /// When it happened, inside the step.
    pub time: f64,
    /// The label that goes on: the lowest.
    pub label: u64,
    /// The mass of the merged particle.
    pub mass: f64,
    /// The index nu of the cluster (2.7).
    pub index: f64,
    /// Where its absorbed labels begin in the label buffer.
    pub first: u64,
    /// How many labels were absorbed, at least 1; ascending.
    pub absorbed: u64,
}

/// What steps did; added to. What was skipped is not counted.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_report {
    /// Sub-steps of single particles.
    pub substeps: u64,
    /// Pairs of normals drawn.
    pub normals: u64,
    /// Fields solved or summed.
    pub fields: u64,
    /// Cluster searches made.
    pub searches: u64,
    /// Clusters that were decided.
    pub clusters: u64,
    /// Merges.
    pub merges: u64,
    /// Particles that ended in another one.
    pub absorbed: u64,
}

/// Where events go. The host empties the buffers by setting `written` and `labels_written` to 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_events {
    /// The events; appended to.
    pub events: *mut mollis_pks_event,
    /// Room for events.
    pub room: usize,
    /// Events written so far.
    pub written: usize,
    /// The labels absorbed, event by event; appended to.
    pub labels: *mut u64,
    /// Room for labels.
    pub labels_room: usize,
    /// Labels written so far.
    pub labels_written: usize,
}

// SAFETY: numbers of eight bytes, no padding; the last one holds pointers, which any bytes are, and is only read back for its numbers.
unsafe impl Plain for mollis_pks_counters {}
// SAFETY: as above.
unsafe impl Plain for mollis_pks_event {}
// SAFETY: as above.
unsafe impl Plain for mollis_pks_report {}
const _: () = assert!(
    size_of::<mollis_pks_event>() == size_of::<Event>() && align_of::<mollis_pks_event>() == align_of::<Event>()
);

/// A caller's choice of attraction, checked.
#[expect(clippy::large_enum_variant, reason = "one lives at a time, on the stack: there is no heap to box in")]
enum Chosen<'k, T: Real> {
    None,
    Mesh(mollis_core::grid::Mesh<T>, mollis_core::grid::Equation<T>),
    Sum(Kernel<'k, T, 2>, field::Options),
}

impl<T: Real> Chosen<'_, T> {
    /// # Safety
    /// The crate's contract for `attraction` and what it points to.
    unsafe fn read(attraction: *const mollis_pks_attraction) -> Result<Self> {
        if attraction.is_null() {
            return Err(Error::NullPointer);
        }
        if !attraction.is_aligned() {
            return Err(Error::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises an attraction there; the rest is passed on.
        unsafe {
            let given = *attraction;
            match given.kind {
                MOLLIS_PKS_ATTRACTION_NONE => Ok(Self::None),
                MOLLIS_PKS_ATTRACTION_MESH => {
                    Ok(Self::Mesh(mollis_mesh2::read(given.mesh)?, equation(&options::read(given.grid)?)?))
                }
                MOLLIS_PKS_ATTRACTION_SUM => {
                    let options = field::Options { tolerance: given.tolerance, ..field::Options::default() };
                    Ok(Self::Sum(kernel::open(given.kernel, given.kernel_bytes)?, options))
                }
                _ => Err(Error::UnknownValue),
            }
        }
    }

    fn summed(&self) -> Summed<'_, T> {
        match self {
            Self::Sum(kernel, options) => Some((kernel, *options)),
            _ => None,
        }
    }

    /// Bytes of the step's own workspace and of the grid behind it.
    fn bytes(&self, room: usize, options: &pks::Options<T>, workers: usize) -> Result<(usize, usize)> {
        let own = pks::workspace_bytes(room, self.summed(), options, workers)?;
        let own = own.checked_next_multiple_of(ALIGN).ok_or(Error::TooLarge)?;
        let grid = match self {
            Self::Mesh(mesh, equation) => Grid::workspace_bytes(mesh, equation, workers)?,
            _ => 0,
        };
        own.checked_add(grid).ok_or(Error::TooLarge)?;
        Ok((own, grid))
    }
}

unsafe fn size<T: Real>(
    room: usize,
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    run: *const mollis_run,
    bytes: *mut usize,
) -> Result<()> {
    let bytes = Output::new(bytes, 1)?;
    // SAFETY: the caller promises the crate's contract.
    let (options, chosen, run) =
        unsafe { (options::read(options)?, Chosen::<T>::read(attraction)?, HostRun::read(run)?) };
    let (own, grid) = chosen.bytes(room, &core_options(&options)?, run.workers())?;
    // SAFETY: as above.
    unsafe { bytes.slice() }.iter_mut().for_each(|slot| *slot = own + grid);
    Ok(())
}

/// The exact size of the workspace that mollis_pks_step needs for arrays with room for so many particles, with this run's executor.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_OPTIONS_SIZE, MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_NOT_FINITE,
/// MOLLIS_ERR_OUT_OF_DOMAIN (a negative noise, separation or probability not between 0 and 1, an empty mesh),
/// MOLLIS_ERR_TOO_LARGE, and those of an unprepared kernel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_workspace_bytes(
    room: usize,
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { size::<f64>(room, options, attraction, run, bytes) })
}

/// As mollis_pks_workspace_bytes, for mollis_pks_step_f32.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_workspace_bytes_f32(
    room: usize,
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { size::<f32>(room, options, attraction, run, bytes) })
}

/// Copies a structure of a caller's out, or refuses the pointer.
///
/// # Safety
/// The crate's contract for `pointer`.
unsafe fn fetch<X: Copy>(pointer: *const X) -> Result<X> {
    if pointer.is_null() {
        return Err(Error::NullPointer);
    }
    if !pointer.is_aligned() {
        return Err(Error::Misaligned);
    }
    // SAFETY: not null, aligned, and the caller promises an initialised value there.
    Ok(unsafe { pointer.read() })
}

#[expect(clippy::too_many_arguments, reason = "the arrays of a state, and what works on them")]
unsafe fn step<T: Real>(
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    room: usize,
    positions: *mut [T; 2],
    masses: *mut T,
    labels: *mut u64,
    species: *mut u32,
    counters: *mut mollis_pks_counters,
    generator: *const mollis_generator,
    seed: u64,
    dt: T,
    steps: usize,
    events: *mut mollis_pks_events,
    report: *mut mollis_pks_report,
    memory: *mut c_void,
    bytes: usize,
    run: *const mollis_run,
) -> Result<()> {
    // SAFETY: the caller promises the crate's contract, here and below.
    let (options, chosen, run) =
        unsafe { (options::read(options)?, Chosen::<T>::read(attraction)?, HostRun::read(run)?) };
    let mut options = core_options::<T>(&options)?;
    if let (Chosen::Mesh(mesh, _), None) = (&chosen, options.search.domain) {
        options.search.domain = Some([mesh.lower(), mesh.upper()]);
    }
    let (positions, masses) = (Output::new(positions, room)?, Output::new(masses, room)?);
    let (labels, species) = (Output::new(labels, room)?, Output::optional(species, room)?);
    let (counted, reported) = (Output::new(counters, 1)?, Output::optional(report, 1)?);
    let memory = workspace(memory, bytes)?;
    // SAFETY: as above.
    let (given, total) = unsafe { (fetch(events)?, reported.map(|_| fetch(report)).transpose()?) };
    let log = Output::new(given.events, given.room)?;
    let absorbed = Output::new(given.labels, given.labels_room)?;
    let own_log = Input::new(events.cast::<u8>(), size_of::<mollis_pks_events>())?;
    disjoint(
        &[
            Some(positions.range()),
            Some(masses.range()),
            Some(labels.range()),
            species.map(Output::range),
            Some(counted.range()),
            reported.map(Output::range),
            Some(log.range()),
            Some(absorbed.range()),
            Some(memory.range()),
        ],
        &[own_log.range()],
    )?;
    if given.written > given.room || given.labels_written > given.labels_room {
        return Err(Error::OutOfDomain);
    }
    let (own, grid_bytes) = chosen.bytes(room, &options, run.workers())?;
    if bytes < own + grid_bytes {
        return Err(Error::WorkspaceTooSmall);
    }
    // SAFETY: as above.
    let mut host = if generator.is_null() { None } else { Some(unsafe { HostGenerator::read(generator) }?) };
    let mut philox = Philox::new(seed);
    let source: &mut dyn Generator = match &mut host {
        Some(host) => host,
        None => &mut philox,
    };
    // SAFETY: as above; the event structures have the same layout, checked above.
    let (positions, masses, labels, species, log, absorbed, memory, counted) = unsafe {
        let log = log.slice();
        let log = core::slice::from_raw_parts_mut(log.as_mut_ptr().cast::<Event>(), log.len());
        (
            positions.slice(),
            masses.slice(),
            labels.slice(),
            species.map(|s| s.slice()),
            log,
            absorbed.slice(),
            memory.slice(),
            counted.slice(),
        )
    };
    let (Some(counted), Some((own_memory, rest))) = (counted.first_mut(), memory.split_at_mut_checked(own)) else {
        return Err(Error::WorkspaceTooSmall);
    };
    let mollis_pks_counters { time, step, count, pending } = *counted;
    let mut state = State { positions, masses, labels, species };
    let mut now = Counters { time, step, count, pending };
    let (mut written, mut labels_written, mut done) = (given.written, given.labels_written, Report::default());
    let result = run.enter(|run| {
        let mut grid = match &chosen {
            Chosen::Mesh(mesh, equation) => Some(Grid::prepare(rest, *mesh, *equation, run.executor.workers())?),
            _ => None,
        };
        for _ in 0..steps {
            let attraction = match (&mut grid, &chosen) {
                (Some(grid), _) => Attraction::Mesh(grid),
                (None, Chosen::Sum(kernel, options)) => Attraction::Sum(kernel, *options),
                _ => Attraction::None,
            };
            let State { positions, masses, labels, species } = &mut state;
            pks::step(
                State { positions, masses, labels, species: species.as_deref_mut() },
                &mut now,
                &mut *source,
                dt,
                Events { events: log, labels: absorbed, written: &mut written, labels_written: &mut labels_written },
                own_memory,
                Setting { options: &options, attraction, run, report: &mut done },
            )?;
        }
        Ok(())
    });
    let Counters { time, step, count, pending } = now;
    *counted = mollis_pks_counters { time, step, count, pending };
    // SAFETY: as above.
    unsafe {
        (*events).written = written;
        (*events).labels_written = labels_written;
        if let (Some(mut total), Some(slot)) = (total, reported) {
            total.substeps = total.substeps.saturating_add(done.substeps);
            total.normals = total.normals.saturating_add(done.normals);
            total.fields = total.fields.saturating_add(done.fields);
            total.searches = total.searches.saturating_add(done.searches);
            total.clusters = total.clusters.saturating_add(done.clusters);
            total.merges = total.merges.saturating_add(done.merges);
            total.absorbed = total.absorbed.saturating_add(done.absorbed);
            slot.slice().iter_mut().for_each(|slot| *slot = total);
        }
    }
    result
}

/// Advances coalescing particles by `steps` steps of length dt (Zhelezov & Fatkullin, Section 3.2): finds the clusters that may collide, moves
/// every particle by chi times the attraction and its own noise, decides the collisions and merges at the centre of mass.
///
/// | argument  | shape   |                                                                                             |
/// |-----------|---------|---------------------------------------------------------------------------------------------|
/// | positions | room, 2 | read and written; the first counters->count are alive                                       |
/// | masses    | room    | positive; a merged particle has the sum                                                     |
/// | labels    | room    | all different; a merged particle keeps its lowest                                           |
/// | species   | room    | travels with the particles; may be null                                                     |
/// | counters  | 1       | read and written                                                                            |
/// | generator |         | the host's stream, drawn in array order; null: the built-in one with `seed`, a stream a label |
/// | events    | 1       | every merge is appended                                                                     |
/// | report    | 1       | added to; may be null                                                                       |
///
/// Merging lowers counters->count; the particles that are left keep their order. Arrays, counters and the generator's state are all that a
/// run is: copied away and back between calls it continues bit for bit. With the built-in generator the result does not
/// depend on the executor.
///
/// MOLLIS_ERR_EVENTS_FULL: the step stopped before a merge that has no room; empty the buffers (or give larger ones) and call again with the
/// same workspace content: it goes on with counters->pending merges. Any other status leaves the state of the last completed step:
/// MOLLIS_ERR_TOO_MANY_SUBSTEPS, MOLLIS_ERR_BECAME_NOT_FINITE, MOLLIS_ERR_STOPPED, the generator's or executor's own. Refused with nothing
/// written: MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_MASS, MOLLIS_ERR_TIME_STEP, MOLLIS_ERR_OUT_OF_DOMAIN, MOLLIS_ERR_LENGTH_MISMATCH (count > room),
/// MOLLIS_ERR_OVERLAP, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED (pending merges that the workspace does not hold).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_step(
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    room: usize,
    positions: *mut [f64; 2],
    masses: *mut f64,
    labels: *mut u64,
    species: *mut u32,
    counters: *mut mollis_pks_counters,
    generator: *const mollis_generator,
    seed: u64,
    dt: f64,
    steps: usize,
    events: *mut mollis_pks_events,
    report: *mut mollis_pks_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe {
        step(
            options,
            attraction,
            room,
            positions,
            masses,
            labels,
            species,
            counters,
            generator,
            seed,
            dt,
            steps,
            events,
            report,
            workspace,
            workspace_bytes,
            run,
        )
    })
}

/// As mollis_pks_step, in single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_step_f32(
    options: *const mollis_pks_options,
    attraction: *const mollis_pks_attraction,
    room: usize,
    positions: *mut [f32; 2],
    masses: *mut f32,
    labels: *mut u64,
    species: *mut u32,
    counters: *mut mollis_pks_counters,
    generator: *const mollis_generator,
    seed: u64,
    dt: f32,
    steps: usize,
    events: *mut mollis_pks_events,
    report: *mut mollis_pks_report,
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe {
        step(
            options,
            attraction,
            room,
            positions,
            masses,
            labels,
            species,
            counters,
            generator,
            seed,
            dt,
            steps,
            events,
            report,
            workspace,
            workspace_bytes,
            run,
        )
    })
}

/// What is known in closed form of one kind of particles with total mass `mass`, diffusivity mu and sensitivity chi.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_prediction {
    /// 8 pi mu / chi (1.6).
    pub critical_mass: f64,
    /// The bound on the time of blow-up (1.8), infinite for a subcritical mass.
    pub blow_up_bound: f64,
    /// The rate of the second moment divided by the mass, heavy point masses beside the regular part (4.12).
    pub second_moment_rate: f64,
}
// SAFETY: numbers of eight bytes, no padding.
unsafe impl Plain for mollis_pks_prediction {}

/// Overwrites `out` with what is known of a mass: `second_moment` is the integral of |x|^2 rho about its centre, `heavy` the n_heavy masses that
/// have become points (their sum at most the mass).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_prediction_eval(
    mass: f64,
    mu: f64,
    chi: f64,
    second_moment: f64,
    n_heavy: usize,
    heavy: *const f64,
    out: *mut mollis_pks_prediction,
) -> mollis_status {
    status((|| {
        let (heavy, out) = (Input::new(heavy, n_heavy)?, Output::new(out, 1)?);
        disjoint(&[Some(out.range())], &[heavy.range()])?;
        if ![mass, mu, chi, second_moment].iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        // SAFETY: the caller promises the crate's contract.
        let (heavy, out) = unsafe { (heavy.slice(), out.slice()) };
        for slot in out {
            *slot = mollis_pks_prediction {
                critical_mass: theory::critical_mass(mu, chi),
                blow_up_bound: theory::blow_up_bound(mass, mu, chi, second_moment),
                second_moment_rate: theory::second_moment_rate(mass, mu, chi, heavy),
            };
        }
        Ok(())
    })())
}

/// Overwrites index[0] with nu of (2.7), (4.30) for n particles of these masses, and index[1], index[2] with alpha and beta^2 of (2.4).
///
/// gamma: the potential is gamma log r near zero, 1 / (2 pi) for the logarithmic and the screened one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_index_eval(
    n: usize,
    masses: *const f64,
    chi: f64,
    noise: f64,
    gamma: f64,
    index: *mut f64,
) -> mollis_status {
    status((|| {
        let (masses, index) = (Input::new(masses, n)?, Output::new(index, 3)?);
        disjoint(&[Some(index.range())], &[masses.range()])?;
        // SAFETY: the caller promises the crate's contract.
        let (masses, index) = unsafe { (masses.slice(), index.slice()) };
        if ![chi, noise, gamma].iter().chain(masses).all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        let (law, group) = (theory::Law { chi, noise, gamma }, theory::Group::of(masses));
        let values = [law.index(&group), law.alpha(&group), law.beta_squared(&group)];
        index.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
        Ok(())
    })())
}

/// One species: its total mass and diffusivity.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_species {
    /// Total mass M_i.
    pub mass: f64,
    /// Diffusivity mu_i.
    pub mu: f64,
}
// SAFETY: two numbers of eight bytes.
unsafe impl Plain for mollis_pks_species {}

/// What represents n species by `particles` particles with one noise: overwrites share[i] with eta_i, the share of the particles that species i
/// gets, noise with mu~ for the step's options, and rate with the rate of the second moment of all species together (4.28). Each output may be null.
///
/// From (4.25), mu_i = M eta_i mu / M_i.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_species_eval(
    n: usize,
    species: *const mollis_pks_species,
    chi: f64,
    particles: usize,
    share: *mut f64,
    noise: *mut f64,
    rate: *mut f64,
) -> mollis_status {
    status((|| {
        let species = Input::new(species, n)?;
        let (share, noise, rate) =
            (Output::optional(share, n)?, Output::optional(noise, 1)?, Output::optional(rate, 1)?);
        disjoint(&[share.map(Output::range), noise.map(Output::range), rate.map(Output::range)], &[species.range()])?;
        // SAFETY: the caller promises the crate's contract.
        let given = unsafe { species.slice() };
        if !(chi.is_finite() && given.iter().all(|s| s.mass.is_finite() && s.mu.is_finite())) {
            return Err(Error::NotFinite);
        }
        if !given.iter().all(|s| s.mass > 0.0 && s.mu > 0.0) || n == 0 || particles == 0 {
            return Err(Error::OutOfDomain);
        }
        // SAFETY: as above; the two structures have the same two members in `repr(C)`.
        let given = unsafe { core::slice::from_raw_parts(given.as_ptr().cast::<theory::Species<f64>>(), given.len()) };
        let mass = given.iter().map(|s| s.mass).sum();
        // SAFETY: as above, for each output.
        unsafe {
            if let Some(out) = share {
                out.slice().iter_mut().zip(given).for_each(|(slot, s)| *slot = theory::species_share(given, s));
            }
            if let Some(out) = noise {
                let value = theory::noise(mass, theory::species_mu(given), particles);
                out.slice().iter_mut().for_each(|slot| *slot = value);
            }
            if let Some(out) = rate {
                let value = theory::second_moment_rate_of_species(given, chi);
                out.slice().iter_mut().for_each(|slot| *slot = value);
            }
        }
        Ok(())
    })())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ptr::{null, null_mut};

    #[repr(align(64))]
    struct Aligned([u8; 1 << 16]);

    const NOTHING: mollis_pks_attraction = mollis_pks_attraction {
        kind: MOLLIS_PKS_ATTRACTION_NONE,
        reserved: 0,
        mesh: null(),
        grid: null(),
        kernel: null(),
        kernel_bytes: 0,
        tolerance: 0.0,
    };

    #[test]
    fn a_pair_on_a_mesh_merges_and_bad_calls_write_nothing() {
        let mesh = mollis_mesh2 { lower: [-1.0; 2], upper: [1.0; 2], cells: [8, 8] };
        let attraction = mollis_pks_attraction { kind: MOLLIS_PKS_ATTRACTION_MESH, mesh: &raw const mesh, ..NOTHING };
        let options = mollis_pks_options { chi: 1e3, noise: 1.0, ..mollis_pks_options::DEFAULT };
        let mut memory = std::boxed::Box::new(Aligned([0xAA; 1 << 16]));
        let memory = memory.0.as_mut_ptr().cast::<c_void>();
        let (mut x, mut m) = ([[0.1, 0.1], [0.1, 0.100_001], [-0.9, 0.3]], [1.0, 3.0, 0.5]);
        let (mut labels, mut species) = ([9_u64, 4, 6], [1_u32, 2, 3]);
        let mut counters = mollis_pks_counters { time: 0.0, step: 0, count: 3, pending: 0 };
        let mut log = [mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 }; 2];
        let mut absorbed = [0_u64; 2];
        let mut events = mollis_pks_events {
            events: log.as_mut_ptr(),
            room: 2,
            written: 0,
            labels: absorbed.as_mut_ptr(),
            labels_room: 2,
            labels_written: 0,
        };
        let mut report =
            mollis_pks_report { substeps: 0, normals: 0, fields: 0, searches: 0, clusters: 0, merges: 0, absorbed: 0 };
        let mut bytes = 0;
        // SAFETY: live arrays of these lengths.
        unsafe {
            assert_eq!(
                mollis_pks_workspace_bytes(3, &raw const options, &raw const attraction, null(), &raw mut bytes),
                0
            );
            assert!(bytes <= 1 << 16);
            let mut call = |options: *const mollis_pks_options, attraction, species: *mut u32, bytes, dt| {
                mollis_pks_step(
                    options,
                    attraction,
                    3,
                    x.as_mut_ptr(),
                    m.as_mut_ptr(),
                    labels.as_mut_ptr(),
                    species,
                    &raw mut counters,
                    null(),
                    7,
                    dt,
                    1,
                    &raw mut events,
                    &raw mut report,
                    memory,
                    bytes,
                    null(),
                )
            };
            let unknown = mollis_pks_options { law: 5, ..options };
            let negative = mollis_pks_options { noise: -1.0, ..options };
            let kind = mollis_pks_attraction { kind: 9, ..NOTHING };
            let good = (&raw const options, &raw const attraction, species.as_mut_ptr());
            for (status, error) in [
                (call(&raw const unknown, good.1, good.2, bytes, 1e-4), Error::UnknownValue),
                (call(&raw const negative, good.1, good.2, bytes, 1e-4), Error::OutOfDomain),
                (call(good.0, &raw const kind, good.2, bytes, 1e-4), Error::UnknownValue),
                (call(good.0, null(), good.2, bytes, 1e-4), Error::NullPointer),
                (call(good.0, good.1, memory.cast(), bytes, 1e-4), Error::Overlap),
                (call(good.0, good.1, good.2, bytes - 1, 1e-4), Error::WorkspaceTooSmall),
                (call(good.0, good.1, good.2, bytes, -1.0), Error::TimeStep),
            ] {
                assert_eq!(status, error as i32);
            }
            assert_eq!(call(good.0, good.1, good.2, bytes, 1e-4), 0);
        }
        assert_eq!((counters.count, counters.step, counters.time, counters.pending), (2, 1, 1e-4, 0));
        assert_eq!((labels[0], labels[1], m[0], m[1], species[0], species[1]), (4, 6, 4.0, 0.5, 2, 3));
        assert_eq!((events.written, events.labels_written, absorbed[0]), (1, 1, 9));
        assert_eq!((log[0].label, log[0].mass, log[0].absorbed), (4, 4.0, 1));
        assert!(log[0].index < -1.0 && report.merges == 1 && report.normals == 3 && report.fields == 1);
    }

    #[test]
    fn single_precision_without_attraction_diffuses() {
        let options = mollis_pks_options { noise: 1.0, ..mollis_pks_options::DEFAULT };
        let mut memory = std::boxed::Box::new(Aligned([0xAA; 1 << 16]));
        let (mut x, mut m, mut labels) = ([[0.0_f32; 2]; 5], [1.0_f32; 5], [0_u64, 1, 2, 3, 4]);
        let mut counters = mollis_pks_counters { time: 0.0, step: 0, count: 5, pending: 0 };
        let mut events = mollis_pks_events {
            events: null_mut(),
            room: 0,
            written: 0,
            labels: null_mut(),
            labels_room: 0,
            labels_written: 0,
        };
        let mut bytes = 0;
        // SAFETY: live arrays of these lengths.
        unsafe {
            let sized = mollis_pks_workspace_bytes_f32(5, &raw const options, &NOTHING, null(), &raw mut bytes);
            assert!(sized == 0 && bytes <= 1 << 16);
            let done = mollis_pks_step_f32(
                &raw const options,
                &NOTHING,
                5,
                x.as_mut_ptr(),
                m.as_mut_ptr(),
                labels.as_mut_ptr(),
                null_mut(),
                &raw mut counters,
                null(),
                7,
                0.5,
                3,
                &raw mut events,
                null_mut(),
                memory.0.as_mut_ptr().cast(),
                bytes,
                null(),
            );
            assert_eq!(done, 0);
        }
        assert_eq!((counters.count, counters.step, counters.time), (5, 3, 1.5));
        assert!(x.iter().flatten().all(|v| *v != 0.0 && v.abs() < 10.0));
    }

    #[test]
    fn the_theory_in_c() {
        let mut index = [0.0; 3];
        let masses = [1.0, 1.0];
        let species = [mollis_pks_species { mass: 4.0, mu: 17.5 }, mollis_pks_species { mass: 24.0, mu: 35.0 / 12.0 }];
        let (mut share, mut noise, mut rate) = ([0.0; 2], 0.0, 0.0);
        let mut prediction = mollis_pks_prediction { critical_mass: 0.0, blow_up_bound: 0.0, second_moment_rate: 0.0 };
        // SAFETY: live arrays of these lengths.
        unsafe {
            assert_eq!(mollis_pks_index_eval(2, masses.as_ptr(), 3.0, 1.0, 1.0, index.as_mut_ptr()), 0);
            let done = mollis_pks_species_eval(
                2,
                species.as_ptr(),
                4.0,
                100,
                share.as_mut_ptr(),
                &raw mut noise,
                &raw mut rate,
            );
            assert_eq!(done, 0);
            assert_eq!(mollis_pks_prediction_eval(2.0, 1.0, 1.0, 1.0, 0, null(), &raw mut prediction), 0);
            let none = mollis_pks_species_eval(0, null(), 4.0, 100, null_mut(), &raw mut noise, null_mut());
            assert_eq!(none, Error::OutOfDomain as i32);
        }
        // (2.7) with gamma 1: 0 - 3 * 2 / 4; (2.4): (4 - 3 * 2) / 2 and 2 / 2.
        assert_eq!(index, [-1.5, -1.0, 1.0]);
        assert!(share.iter().all(|s| (s - 0.5).abs() < 1e-15) && (noise - 1.4).abs() < 1e-14 && rate.is_finite());
        assert_eq!(prediction.blow_up_bound, f64::INFINITY);
        assert!((prediction.critical_mass - 8.0 * core::f64::consts::PI).abs() < 1e-14);
    }
}
