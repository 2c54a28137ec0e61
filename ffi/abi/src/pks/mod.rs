//! Coalescing particles: the size of the workspace, and the step.

#[cfg_attr(feature = "small", path = "no_meshes.rs")]
mod meshes;
mod options;
mod theory;

pub use options::*;
pub use theory::*;

use core::ffi::c_void;

use mollis_core::build;
use mollis_core::kernel::Kernel;
use mollis_core::memory::{ALIGN, Plain};
use mollis_core::pks::{self, Attraction, Counters, Event, Events, Report, Setting, State, Summed};
use mollis_core::random::{Generator, Philox};
use mollis_core::{Error, Real, Result};

use meshes::{MeshChoice, SumOptions, has_heavy, sum_options};

use crate::arrays::fetch;
use crate::buffers::{Input, Output, disjoint, workspace};
use crate::first_bad::first_bad;
use crate::kernel;
use crate::random::{HostGenerator, mollis_generator};
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::{mollis_status, status};

/// A caller's choice of attraction, checked.
enum Chosen<'k, T: Real> {
    None,
    Mesh(MeshChoice<'k, T>),
    Sum(Kernel<'k, T, 2>, SumOptions),
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
                MOLLIS_PKS_ATTRACTION_MESH => MeshChoice::read(&given).map(Self::Mesh),
                MOLLIS_PKS_ATTRACTION_SUM => {
                    Ok(Self::Sum(kernel::open(given.kernel, given.kernel_bytes)?, sum_options(given.tolerance)?))
                }
                _ => Err(Error::UnknownValue),
            }
        }
    }

    fn summed(&self) -> Summed<'_, T> {
        match self {
            Self::Sum(kernel, options) => Some((kernel, options)),
            _ => None,
        }
    }

    /// Bytes of the step's own workspace and of the grid behind it.
    fn bytes(&self, room: usize, options: &pks::Options<T>, workers: usize) -> Result<(usize, usize)> {
        let own = pks::workspace_bytes(room, self.summed(), options, workers)?;
        let own = own.checked_next_multiple_of(ALIGN).ok_or(Error::TooLarge)?;
        let grid = match self {
            Self::Mesh(choice) => choice.bytes(workers)?,
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
    if let Some(kernel) = kernel_of(&unsafe { fetch(attraction) }?)? {
        disjoint(&[Some(bytes.range())], &[kernel.range()])?;
    }
    // SAFETY: as above.
    let (options, chosen, run) =
        unsafe { (read_options::<T>(options)?, Chosen::<T>::read(attraction)?, HostRun::read(run)?) };
    let (own, grid) = chosen.bytes(room, &options, run.workers())?;
    // SAFETY: as above.
    unsafe { bytes.slice() }.iter_mut().for_each(|slot| *slot = own + grid);
    Ok(())
}

/// The kernel's block, if this kind of attraction looks at it.
fn kernel_of(attraction: &mollis_pks_attraction) -> Result<Option<Input<u8>>> {
    if has_heavy(attraction) || attraction.kind == MOLLIS_PKS_ATTRACTION_SUM {
        return Input::new(attraction.kernel.cast::<u8>(), attraction.kernel_bytes).map(Some);
    }
    Ok(None)
}

/// The exact size of the workspace that mollis_pks_step needs for arrays with room for so many particles, with this run's executor.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_OPTIONS_SIZE, MOLLIS_ERR_NOT_INITIALISED, MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_NOT_FINITE,
/// MOLLIS_ERR_OUT_OF_DOMAIN (a negative noise, separation or probability not between 0 and 1, an empty mesh),
/// MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_UNSUPPORTED (heavy particles in a box, or by a singular kernel), and those of an unprepared kernel.
#[cfg(feature = "double")]
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

/// The arguments of a step.
struct Call<T> {
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
    workspace: *mut c_void,
    workspace_bytes: usize,
    run: *const mollis_run,
}

/// Its arrays.
struct Buffers<T> {
    positions: Output<[T; 2]>,
    masses: Output<T>,
    labels: Output<u64>,
    species: Option<Output<u32>>,
    log: Output<mollis_pks_event>,
    absorbed: Output<u64>,
    memory: Output<u8>,
}

impl<T: Real> Call<T>
where
    [T; 2]: Plain,
{
    /// The arrays, checked. Apart from the rest, so that this takes no stack of what follows.
    ///
    /// # Safety
    /// The crate's contract.
    unsafe fn buffers(&self, host: &HostRun) -> Result<Buffers<T>> {
        let room = self.room;
        let (positions, masses) = (Output::new(self.positions, room)?, Output::new(self.masses, room)?);
        // Who brings no report pays nothing for counting.
        if !build::REPORTS && !self.report.is_null() {
            return Err(Error::Unsupported);
        }
        let (labels, species) = (Output::new(self.labels, room)?, Output::optional(self.species, room)?);
        let (counted, reported) = (Output::new(self.counters, 1)?, Output::optional(self.report, 1)?);
        let memory = workspace(self.workspace, self.workspace_bytes)?;
        // SAFETY: the caller promises the crate's contract.
        let given = unsafe { fetch(self.events)? };
        let log = Output::new(given.events, given.room)?;
        let absorbed = Output::new(given.labels, given.labels_room)?;
        let own_log = Input::new(self.events.cast::<u8>(), size_of::<mollis_pks_events>())?;
        // Firmware leaves out this check, for which it has no flash.
        let mut kernel = own_log;
        if build::MESHES {
            // SAFETY: as above.
            kernel = kernel_of(&unsafe { fetch(self.attraction)? })?.unwrap_or(own_log);
        }
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
                host.first_bad(),
            ],
            &[own_log.range(), kernel.range()],
        )?;
        if given.written > given.room || given.labels_written > given.labels_room {
            return Err(Error::OutOfDomain);
        }
        Ok(Buffers { positions, masses, labels, species, log, absorbed, memory })
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn step(self) -> mollis_status {
        // SAFETY: passed on.
        unsafe { with_run(self.run, |run, told| self.advance(run, told)) }
    }

    /// # Safety
    /// The crate's contract.
    unsafe fn advance(&self, run: &HostRun, told: &mut CallReport) -> Result<()> {
        // SAFETY: the caller promises the crate's contract, here and below.
        let options = unsafe { read_options::<T>(self.options) };
        // Looked at where it is: moving it out would take its size of the stack once more.
        let options = options.as_ref().map_err(|&error| error)?;
        // SAFETY: as above.
        let chosen = unsafe { Chosen::<T>::read(self.attraction) };
        let chosen = chosen.as_ref().map_err(|&error| error)?;
        let mut whole;
        let options = match chosen {
            Chosen::Mesh(choice) if options.search.domain.is_none() => {
                whole = *options;
                whole.search.domain = Some(choice.domain());
                &whole
            }
            _ => options,
        };
        // SAFETY: as above.
        let buffers = unsafe { self.buffers(run)? };
        // Without a grid the step finds out by itself whether the workspace is large enough.
        let bytes = self.workspace_bytes;
        let (own, grid_bytes) =
            if build::MESHES { chosen.bytes(self.room, options, run.workers())? } else { (bytes, 0) };
        if bytes < own + grid_bytes {
            return Err(Error::WorkspaceTooSmall);
        }
        // The built-in generator would stay linked for those who bring their own.
        if self.generator.is_null() && !build::PHILOX {
            return Err(Error::Unsupported);
        }
        let mut host = if self.generator.is_null() {
            None
        } else {
            // SAFETY: as above.
            Some(unsafe { HostGenerator::read(self.generator) }?)
        };
        let mut philox = Philox::new(self.seed);
        let source: &mut dyn Generator = match &mut host {
            Some(host) => host,
            None => &mut philox,
        };
        // SAFETY: as above; counters, events and report have the same layout as core's, which is checked beside them.
        let (mut state, log, absorbed, memory, counted, events, mut report) = unsafe {
            let log = buffers.log.slice();
            let log = core::slice::from_raw_parts_mut(log.as_mut_ptr().cast::<Event>(), log.len());
            let state = State {
                positions: buffers.positions.slice(),
                masses: buffers.masses.slice(),
                labels: buffers.labels.slice(),
                species: buffers.species.map(|s| s.slice()),
            };
            (
                state,
                log,
                buffers.absorbed.slice(),
                buffers.memory.slice(),
                &mut *self.counters.cast::<Counters>(),
                &mut *self.events,
                self.report.cast::<Report>().as_mut(),
            )
        };
        let (own_memory, rest) = memory.split_at_mut_checked(own).ok_or(Error::WorkspaceTooSmall)?;
        let result = run.enter(|with| {
            let (mut grid, heavy) = match chosen {
                Chosen::Mesh(choice) => (Some(choice.grid(rest, with.executor.workers())?), choice.heavy()),
                _ => (None, None),
            };
            for number in 0..self.steps {
                let attraction = match chosen {
                    Chosen::Mesh(_) => {
                        grid.as_mut().map_or(Attraction::None, |grid| Attraction::Mesh(grid, heavy.as_ref()))
                    }
                    Chosen::Sum(kernel, options) => Attraction::Sum(kernel, options),
                    _ => Attraction::None,
                };
                let State { positions, masses, labels, species } = &mut state;
                let made = pks::step(
                    State { positions, masses, labels, species: species.as_deref_mut() },
                    counted,
                    &mut *source,
                    self.dt,
                    Events {
                        events: log,
                        labels: absorbed,
                        written: &mut events.written,
                        labels_written: &mut events.labels_written,
                    },
                    own_memory,
                    Setting { options, attraction, run: &mut *with, report: report.as_deref_mut() },
                );
                match made {
                    Err(Error::NotFinite) if number > 0 => return Err(Error::BecameNotFinite),
                    Err(Error::NotFinite) => {
                        let alive = usize::try_from(counted.count).unwrap_or(usize::MAX).min(self.room);
                        let (x, m) = (state.positions.get(..alive), state.masses.get(..alive));
                        told.first_bad = first_bad(x.unwrap_or_default(), m.unwrap_or_default());
                        return made;
                    }
                    _ => made?,
                }
                // A step is completed although the executor refuses to copy its result.
                if run.refused() != 0 {
                    break;
                }
            }
            Ok(())
        });
        told.generator = host.map_or(0, |host| host.refused);
        result
    }
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
/// | generator |         | the host's stream, drawn in array order, then for heavy particles; null: the built-in one with `seed`, a stream a label |
/// | events    | 1       | every merge is appended                                                                     |
/// | report    | 1       | added to; may be null                                                                       |
///
/// Merging lowers counters->count; the particles that are left keep their order. Arrays, counters and the generator's state are all that a
/// run is: copied away and back between calls it continues bit for bit. With the built-in generator the result does not
/// depend on the executor.
///
/// Range: the result does not depend on the units, up to rounding; a mesh in free space loses digits by the logarithm of its size. Masses, and chi, noise and gamma where they are not 0, have to be normal
/// numbers of the scalar (MOLLIS_ERR_OUT_OF_DOMAIN), and the gradient (mass / length) and chi times it have to be
/// in range, as must mass / length^2 for heavy particles; what leaves the range ends in MOLLIS_ERR_BECAME_NOT_FINITE or MOLLIS_ERR_TOO_MANY_SUBSTEPS. An attraction so strong against
/// a positive noise that indices are out of range (chi M^2 / noise above 1e38 for f32, M being the mass of all particles) is MOLLIS_ERR_OUT_OF_DOMAIN.
/// Masses below 1e-19 of M (f32; 1e-154 for f64) do not collide with one another.
///
/// MOLLIS_ERR_EVENTS_FULL: the step stopped before a merge that has no room; empty the buffers (or give larger ones) and call again with the
/// same workspace content: it goes on with counters->pending merges. Any other status leaves the state of the last completed step:
/// MOLLIS_ERR_TOO_MANY_SUBSTEPS, MOLLIS_ERR_BECAME_NOT_FINITE, MOLLIS_ERR_STOPPED, the generator's or executor's own, as they returned it. Refused with nothing
/// written: MOLLIS_ERR_NOT_FINITE (run->first_bad: the particle), MOLLIS_ERR_MASS, MOLLIS_ERR_TIME_STEP, MOLLIS_ERR_OUT_OF_DOMAIN, MOLLIS_ERR_LENGTH_MISMATCH (count > room),
/// MOLLIS_ERR_OVERLAP, MOLLIS_ERR_UNSUPPORTED (heavy particles in a box, or by a singular kernel), MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED (pending merges that the workspace does not hold).
#[cfg(feature = "double")]
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
    let call = Call {
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
    };
    // SAFETY: the caller promises the crate's contract.
    unsafe { call.step() }
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
    let call = Call {
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
    };
    // SAFETY: the caller promises the crate's contract.
    unsafe { call.step() }
}
