//! What a run of coalescing particles is made with, consists of and reports: plain structures.

use core::ffi::c_void;

use mollis_core::euler_maruyama::Control;
use mollis_core::memory::Plain;
use mollis_core::pks::search::Search;
use mollis_core::pks::{self, CollisionLaw, Counters, Event, Merging, Report, Scheme, theory};
use mollis_core::{Error, Real, Result};

use crate::grid::{mollis_grid2_options, mollis_mesh2};
use crate::options;
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
    ///
    /// With HARD and NEVER there are pairs that collide and do not merge. Under MOLLIS_PKS_ATTRACTION_SUM, with noise, both schemes then move close
    /// pairs so that their mean squared distance is exact, whatever delta is, in no more sub-steps: five equal particles of index -1.8,
    /// Y_0 = 1, mu~ = m = 1, collapse at a median within 2.5% of the law's for dt = 1e-3 and within 8% for dt = 1e-2. A pair is close if its attraction
    /// moves it by more than a sixteenth of what the noise does; steps without a close pair are as they would be with ALL. With NEVER,
    /// pairs of an index of -1 or less stay together once they have met. The law of collisions is that of a logarithm: take delta below
    /// sqrt(noise dt / m), as particles within delta of one another attract each other less.
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
    /// The seed of the built-in generator. Default: 0.
    pub seed: u64,
}

options::options!(mollis_pks_options {
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
    seed: 0
});

/// Fills `options` with the defaults. `size` is `sizeof *options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_options_init(options: *mut mollis_pks_options, size: usize) -> mollis_status {
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { options::init(options, size) })
}

/// The caller's options, checked.
///
/// # Safety
/// The crate's contract for `options`.
pub(super) unsafe fn read_options<T: Real>(options: *const mollis_pks_options) -> Result<pks::Options<T>> {
    // SAFETY: the caller promises the crate's contract.
    let options = unsafe { options::read(options)? };
    // By bits, as a comparison of doubles is a function where there are none.
    let zero = |x: f64| x.to_bits() as u32 | ((x.to_bits() >> 32) as u32) << 1 == 0;
    let [a, b, c, d] = options.domain;
    let mesh = !options.domain.iter().all(|&x| zero(x));
    let given =
        [options.chi, options.noise, options.gamma, options.separation, options.probability, options.width, a, b, c, d];
    let mut numbers = [T::ZERO; 10];
    numbers.iter_mut().zip(&given).for_each(|(to, &x)| *to = T::from_wide(x));
    // chi, noise, gamma: what is not zero must not become so, or lose digits.
    if numbers.iter().zip(&given).take(3).any(|(number, &x)| !zero(x) && number.abs() < T::MIN_POSITIVE) {
        return Err(Error::OutOfDomain);
    }
    let [chi, noise, gamma, separation, probability, width, a, b, c, d] = numbers;
    let read = pks::Options {
        chi,
        noise,
        gamma,
        control: Control {
            width: if zero(options.width) { T::INFINITY } else { width },
            at_least: options.at_least,
            at_most: options.at_most,
        },
        scheme: match options.scheme {
            MOLLIS_PKS_SCHEME_EULER_MARUYAMA => Scheme::EulerMaruyama,
            MOLLIS_PKS_SCHEME_STRANG_RK4 => Scheme::StrangRk4,
            _ => return Err(Error::UnknownValue),
        },
        search: Search {
            separation,
            mesh: options.mesh,
            domain: if mesh { Some([[a, b], [c, d]]) } else { None },
            shifted: options.shifted != 0,
        },
        probability,
        law: match options.law {
            MOLLIS_PKS_LAW_EXACT => CollisionLaw::Exact,
            MOLLIS_PKS_LAW_PRINTED => CollisionLaw::Printed,
            _ => return Err(Error::UnknownValue),
        },
        merging: match options.merging {
            MOLLIS_PKS_MERGE_ALL => Merging::All,
            MOLLIS_PKS_MERGE_HARD => Merging::Hard,
            MOLLIS_PKS_MERGE_NEVER => Merging::Never,
            _ => return Err(Error::UnknownValue),
        },
    };
    read.check()?;
    Ok(read)
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
    /// MESH: walls, screening, medium, memory; null for free space without screening. In a medium clusters have the index (4.30) of the paper, with gamma / G at their centres.
    pub grid: *const mollis_grid2_options,
    /// SUM, and MESH with heavy particles: a kernel prepared by mollis_kernel2_prepare (or its _f32); its mollifier bounds the speed.
    pub kernel: *const c_void,
    /// The bytes of its buffer.
    pub kernel_bytes: usize,
    /// SUM: the relative error that may be spent for speed; 0 for rounding alone.
    pub tolerance: f64,
    /// MESH: particles of at least this mass, the 64 heaviest at most (of equal masses those that come first in the arrays), act by `kernel` pair
    /// by pair, both ways and at every distance, and not through the mesh, which is wrong within some widths of a particle, and on which a mass below
    /// 4.4e-16 of the total adds nothing (see mollis_grid2_eval). The kernel is V of the mesh's equation, mollified over
    /// a part of a mesh width (a quarter, say); sub-steps become short near them. Not with no-flux walls, nor in a medium, nor with a memory, nor with a singular kernel. 0: none.
    pub heavy: f64,
}

/// Time, and what a run counts. Zero it, then set `count`; it belongs to the state that a checkpoint saves.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_progress {
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
    /// The mass of the merged particle: the sum of the kept one's mass and the absorbed ones' in the order of their labels, rounded once.
    ///
    /// To the bit, in the run's scalar: s = the kept mass, c = 0; for each absorbed mass m: t = s + m, b = t - s,
    /// e = (s - (t - b)) + (m - b) + c, s = t + e, c = e - (s - t); the mass is s. What is rounded off is lost: a particle lighter than the
    /// last bit of the kept one may add nothing.
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
unsafe impl Plain for mollis_pks_progress {}
// SAFETY: as above.
unsafe impl Plain for mollis_pks_event {}
// SAFETY: as above.
unsafe impl Plain for mollis_pks_report {}
const _: () = assert!(
    size_of::<mollis_pks_progress>() == size_of::<Counters>()
        && align_of::<mollis_pks_progress>() == align_of::<Counters>()
);
const _: () = assert!(
    size_of::<mollis_pks_report>() == size_of::<Report>() && align_of::<mollis_pks_report>() == align_of::<Report>()
);
const _: () = assert!(
    size_of::<mollis_pks_event>() == size_of::<Event>() && align_of::<mollis_pks_event>() == align_of::<Event>()
);
