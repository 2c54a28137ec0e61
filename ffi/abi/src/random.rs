//! Random numbers: the host's generator, the ready Philox, and words to normals.

use core::ffi::c_void;

use mollis_core::memory::Plain;
use mollis_core::random::{self, Generator, Philox};
use mollis_core::{Error, Real, Result};

use crate::buffers::{Input, Output, disjoint};
use crate::status::{mollis_status, status};

/// A host's random generator: one stream of uniform bits, drawn serially in the order of the arrays.
///
/// `fill` overwrites out[0 .. n] with uniform 64-bit words and returns 0; another status ends the call and comes back unchanged. A
/// run continues bit for bit when the host saves its state with the buffers.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_generator {
    /// Passed to `fill`.
    pub state: *mut c_void,
    /// Draws the next n words.
    pub fill: Option<unsafe extern "C" fn(state: *mut c_void, out: *mut u64, n: usize) -> i32>,
}

/// A C caller's generator as core's, remembering a status that it returned: that is no error of the library's, whatever its number.
pub(crate) struct HostGenerator {
    state: *mut c_void,
    fill: unsafe extern "C" fn(*mut c_void, *mut u64, usize) -> i32,
    /// 0: none but success.
    pub(crate) refused: mollis_status,
}

impl HostGenerator {
    /// # Safety
    /// The crate's contract for `generator` and what it points to.
    pub(crate) unsafe fn read(generator: *const mollis_generator) -> Result<Self> {
        if generator.is_null() {
            return Err(Error::NullPointer);
        }
        if !generator.is_aligned() {
            return Err(Error::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises a generator there.
        let mollis_generator { state, fill } = unsafe { *generator };
        Ok(Self { state, fill: fill.ok_or(Error::NullPointer)?, refused: 0 })
    }
}

impl Generator for HostGenerator {
    fn fill(&mut self, _: u64, _: u32, _: u32, out: &mut [u64]) -> Result<()> {
        // SAFETY: the host's own function, with what its contract says.
        self.refused = unsafe { (self.fill)(self.state, out.as_mut_ptr(), out.len()) };
        if self.refused == 0 { Ok(()) } else { Err(Error::Generator) }
    }
}

/// Overwrites out[0 .. n] with uniform 64-bit words of the built-in generator for the particle `label` at time step `step`,
/// sub-step `substep`.
///
/// Words 0 and 1 are Philox4x32-10 (Salmon et al. 2011) with key = (low, high half of the seed) and counter = (low, high half of the
/// label, step, substep), its 32-bit results w0..w3 joined as w0 + 2^32 w1 and w2 + 2^32 w3. Later pairs b = 1, 2, ... have
/// the same counter and as key the first 64-bit word of label b, step = substep = 2^32 - 1 under the seed. No state.
///
/// Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_philox_words(
    seed: u64,
    label: u64,
    step: u32,
    substep: u32,
    n: usize,
    out: *mut u64,
) -> mollis_status {
    status(Output::new(out, n).map(|out| {
        // SAFETY: the caller promises the crate's contract.
        Philox::new(seed).words(label, step, substep, unsafe { out.slice() });
    }))
}

pub(crate) unsafe fn philox_normals<T: Real>(
    seed: u64,
    n: usize,
    labels: *const u64,
    step: u32,
    substep: u32,
    normals: *mut [T; 2],
) -> Result<()>
where
    [T; 2]: Plain,
{
    let (labels, normals) = (Input::new(labels, n)?, Output::new(normals, n)?);
    disjoint(&[Some(normals.range())], &[labels.range()])?;
    // SAFETY: the caller promises the crate's contract.
    Philox::new(seed).normals(unsafe { labels.slice() }, step, substep, unsafe { normals.slice() });
    Ok(())
}

pub(crate) unsafe fn normals<T: Real>(n: usize, words: *const u64, out: *mut T) -> Result<()> {
    let n_words = n.checked_add(n % 2).ok_or(Error::TooLarge)?;
    let (words, out) = (Input::new(words, n_words)?, Output::new(out, n)?);
    disjoint(&[Some(out.range())], &[words.range()])?;
    // SAFETY: the caller promises the crate's contract.
    random::normals(unsafe { words.slice() }, unsafe { out.slice() });
    Ok(())
}
