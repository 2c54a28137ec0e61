//! The arguments of a step: checked, then answered.

use core::ffi::c_void;

use mollis_core::build;
use mollis_core::kernel::Kernel;
use mollis_core::memory::{ALIGN, Plain};
use mollis_core::pks::{self, Attraction, Counters, Event, Events, Report, Setting, State, Summed};
use mollis_core::random::{Generator, Philox};
use mollis_core::{Error, Real, Result};

use super::meshes::{MeshChoice, SumOptions, has_heavy, sum_options};
use super::options::*;

use crate::arrays::fetch;
use crate::buffers::{Input, Output, Range, aligned, disjoint, with_slack};
use crate::first_bad::first_bad;
use crate::kernel;
use crate::options as structures;
use crate::random::{HostGenerator, mollis_generator};
use crate::run::{CallReport, HostRun, mollis_run, with_run};
use crate::status::mollis_status;

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

    /// Where a medium's report goes, or the attractant.
    fn output(&self) -> Option<Range> {
        match self {
            Self::Mesh(choice) => choice.output(),
            _ => None,
        }
    }

    /// Bytes of the step's own workspace and of the grid behind it.
    fn bytes(&self, room: usize, options: &pks::Options<T>, run: &HostRun) -> Result<(usize, usize)> {
        let workers = run.workers();
        let own = pks::workspace_bytes_on_ranks(room, run.ranks(), self.summed(), options, workers)?;
        let own = own.checked_next_multiple_of(ALIGN).ok_or(Error::TooLarge)?;
        let grid = match self {
            Self::Mesh(choice) => choice.bytes(workers)?,
            _ => 0,
        };
        own.checked_add(grid).ok_or(Error::TooLarge)?;
        Ok((own, grid))
    }
}

pub(crate) unsafe fn size<T: Real>(
    room: usize,
    attraction: *const mollis_pks_attraction,
    options: *const mollis_pks_options,
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
    let (own, grid) = chosen.bytes(room, &options, &run)?;
    // SAFETY: as above.
    unsafe { bytes.slice() }.fill(with_slack(own.checked_add(grid).ok_or(Error::TooLarge)?)?);
    Ok(())
}

/// The kernel's block, if this kind of attraction looks at it.
fn kernel_of(attraction: &mollis_pks_attraction) -> Result<Option<Input<u8>>> {
    if has_heavy(attraction) || attraction.kind == MOLLIS_PKS_ATTRACTION_SUM {
        return Input::new(attraction.kernel.cast::<u8>(), attraction.kernel_bytes).map(Some);
    }
    Ok(None)
}

/// The layout of `mollis_pks_particles` and of its form in single precision.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "they stand where C programs read them")]
pub struct PksParticlesOf<T> {
    pub room: usize,
    pub positions: *mut [T; 2],
    pub masses: *mut T,
    pub labels: *mut u64,
    pub species: *mut u32,
    pub weights: *mut T,
}

/// The arguments of a step.
pub(crate) struct Call<T> {
    pub particles: *const PksParticlesOf<T>,
    pub progress: *mut mollis_pks_progress,
    pub attraction: *const mollis_pks_attraction,
    pub generator: *const mollis_generator,
    pub dt: f64,
    pub steps: usize,
    pub events: *mut mollis_pks_events,
    pub options: *const mollis_pks_options,
    pub run: *const mollis_run,
    pub workspace: *mut c_void,
    pub workspace_bytes: usize,
    pub report: *mut mollis_pks_report,
}

/// Its arrays.
struct Buffers<T> {
    positions: Output<[T; 2]>,
    masses: Output<T>,
    labels: Output<u64>,
    species: Option<Output<u32>>,
    weights: Option<Output<T>>,
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
    unsafe fn buffers(&self, host: &HostRun, told: Option<Range>) -> Result<Buffers<T>> {
        // SAFETY: the caller promises the crate's contract.
        let PksParticlesOf { room, positions, masses, labels, species, weights } = unsafe { fetch(self.particles)? };
        let (positions, masses) = (Output::new(positions, room)?, Output::new(masses, room)?);
        // Who brings no report pays nothing for counting.
        if !build::REPORTS && !self.report.is_null() {
            return Err(Error::Unsupported);
        }
        let (labels, species) = (Output::new(labels, room)?, Output::optional(species, room)?);
        let weights = Output::optional(weights, room)?;
        let (counted, reported) = (Output::new(self.progress, 1)?, Output::optional(self.report, 1)?);
        let memory = Output::new(self.workspace.cast::<u8>(), self.workspace_bytes)?;
        // SAFETY: the caller promises the crate's contract.
        let given = unsafe { fetch(self.events)? };
        let log = Output::new(given.events, given.room)?;
        let absorbed = Output::new(given.labels, given.labels_room)?;
        let own_log = Input::new(self.events.cast::<u8>(), size_of::<mollis_pks_events>())?;
        let own_particles = Input::new(self.particles.cast::<u8>(), size_of::<PksParticlesOf<T>>())?;
        let [first_bad, needed] = host.outputs();
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
                weights.map(Output::range),
                Some(counted.range()),
                reported.map(Output::range),
                Some(log.range()),
                Some(absorbed.range()),
                Some(memory.range()),
                first_bad,
                needed,
                told,
            ],
            &[own_log.range(), own_particles.range(), kernel.range()],
        )?;
        if given.written > given.room || given.labels_written > given.labels_room {
            return Err(Error::OutOfDomain);
        }
        Ok(Buffers { positions, masses, labels, species, weights, log, absorbed, memory })
    }

    /// # Safety
    /// The crate's contract.
    pub(crate) unsafe fn step(self) -> mollis_status {
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
        let buffers = unsafe { self.buffers(run, chosen.output())? };
        // Without a grid the step finds out by itself whether the workspace is large enough.
        // SAFETY: as above.
        let mut memory = aligned(unsafe { buffers.memory.slice() });
        let own = if build::MESHES {
            let (own, grid) = chosen.bytes(buffers.positions.len(), options, run)?;
            let needed = with_slack(own.checked_add(grid).ok_or(Error::TooLarge)?)?;
            if self.workspace_bytes < needed {
                return told.too_small(needed);
            }
            own
        } else {
            // As many as a query would have asked for, less what alignment may take.
            let own = self.workspace_bytes.saturating_sub(ALIGN - 1);
            memory = memory.get_mut(..own).unwrap_or_default();
            own
        };
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
        // SAFETY: as above.
        let mut philox = Philox::new(if build::PHILOX { unsafe { structures::read(self.options)? }.seed } else { 0 });
        let source: &mut dyn Generator = match &mut host {
            Some(host) => host,
            None => &mut philox,
        };
        // SAFETY: as above; counters, events and report have the same layout as core's, which is checked beside them.
        let (mut state, log, absorbed, counted, events, mut report) = unsafe {
            let log = buffers.log.slice();
            let log = core::slice::from_raw_parts_mut(log.as_mut_ptr().cast::<Event>(), log.len());
            let state = State {
                positions: buffers.positions.slice(),
                masses: buffers.masses.slice(),
                labels: buffers.labels.slice(),
                species: buffers.species.map(|s| s.slice()),
                weights: buffers.weights.map(|w| w.slice()),
            };
            (
                state,
                log,
                buffers.absorbed.slice(),
                &mut *self.progress.cast::<Counters>(),
                &mut *self.events,
                self.report.cast::<Report>().as_mut(),
            )
        };
        let (own_memory, rest) = memory.split_at_mut_checked(own).ok_or(Error::WorkspaceTooSmall)?;
        let result = run.enter(|with| {
            let (mut field, heavy) = match chosen {
                // SAFETY: as above.
                Chosen::Mesh(choice) => (Some(unsafe { choice.field(rest, with.resources())? }), choice.heavy()),
                _ => (None, None),
            };
            for _ in 0..self.steps {
                let attraction = match chosen {
                    Chosen::Mesh(_) => {
                        field.as_mut().map_or(Attraction::None, |field| field.attraction(heavy.as_ref()))
                    }
                    Chosen::Sum(kernel, options) => Attraction::Sum(kernel, options),
                    _ => Attraction::None,
                };
                let State { positions, masses, labels, species, weights } = &mut state;
                let made = pks::step(
                    State {
                        positions,
                        masses,
                        labels,
                        species: species.as_deref_mut(),
                        weights: weights.as_deref_mut(),
                    },
                    counted,
                    &mut *source,
                    T::from_wide(self.dt),
                    Events {
                        events: log,
                        labels: absorbed,
                        written: &mut events.written,
                        labels_written: &mut events.labels_written,
                    },
                    own_memory,
                    Setting { options, attraction, run: &mut *with, report: report.as_deref_mut() },
                );
                if let Some(field) = &mut field {
                    // SAFETY: as above.
                    unsafe { field.tell() };
                    // A step that waits for room for its events has moved the particles.
                    if matches!(made, Ok(()) | Err(Error::EventsFull)) {
                        // SAFETY: as above.
                        unsafe { field.save()? };
                    }
                }
                match made {
                    Err(Error::NotFinite) => {
                        let alive = usize::try_from(counted.count).unwrap_or(usize::MAX).min(state.positions.len());
                        let (x, m) = (state.positions.get(..alive), state.masses.get(..alive));
                        let bad = first_bad(x.unwrap_or_default(), m.unwrap_or_default());
                        let weights = state.weights.as_deref().and_then(|weights| weights.get(..alive));
                        let weight = weights.unwrap_or_default().iter().position(|w| !w.is_finite());
                        told.first_bad = bad.into_iter().chain(weight).min();
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
