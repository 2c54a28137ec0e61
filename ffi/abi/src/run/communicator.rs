//! The host's communicator.

use core::cell::Cell;
use core::ffi::c_void;

use mollis_core::exec::{Communicator, Reduction};
use mollis_core::{Error, Result};

use super::{MOLLIS_REDUCE_MAX, MOLLIS_REDUCE_SUM, mollis_communicator};
use crate::status::mollis_status;

/// The host's communicator as core's, remembering a status that it returned: that is no error of the library's, whatever its number.
pub(super) struct HostRanks {
    communicator: mollis_communicator,
    reduce: unsafe extern "C" fn(*mut c_void, i32, *mut u64, usize) -> i32,
    exchange: unsafe extern "C" fn(*mut c_void, *const u64, *const usize, *mut u64, *const usize) -> i32,
    refused: Cell<i32>,
}

impl HostRanks {
    /// The host's communicator, if there is one.
    ///
    /// # Safety
    /// The crate's contract for `communicator`.
    pub unsafe fn read(communicator: *const mollis_communicator) -> Result<Option<Self>> {
        if communicator.is_null() {
            return Ok(None);
        }
        if !communicator.is_aligned() {
            return Err(Error::Misaligned);
        }
        // SAFETY: not null, aligned, and the caller promises a communicator there.
        let communicator = unsafe { *communicator };
        let (Some(reduce), Some(exchange)) = (communicator.reduce, communicator.exchange) else {
            return Err(Error::NullPointer);
        };
        if communicator.rank >= communicator.ranks {
            return Err(Error::OutOfDomain);
        }
        Ok(Some(Self { communicator, reduce, exchange, refused: Cell::new(0) }))
    }

    /// The status that it returned; 0: none but success.
    pub fn refused(&self) -> mollis_status {
        self.refused.get()
    }

    /// How many ranks there are.
    pub fn count(&self) -> usize {
        self.communicator.ranks
    }

    pub fn as_dyn(&self) -> &dyn Communicator {
        self
    }

    fn result(&self, status: i32) -> Result<()> {
        if status == 0 {
            return Ok(());
        }
        self.refused.set(status);
        Err(Error::Communicator)
    }
}

impl Communicator for HostRanks {
    fn rank(&self) -> usize {
        self.communicator.rank
    }

    fn ranks(&self) -> usize {
        self.communicator.ranks
    }

    fn reduce(&self, reduction: Reduction, words: &mut [u64]) -> Result<()> {
        let operation = match reduction {
            Reduction::Sum => MOLLIS_REDUCE_SUM,
            Reduction::Max => MOLLIS_REDUCE_MAX,
        };
        // SAFETY: the host's function, with what its contract says.
        self.result(unsafe { (self.reduce)(self.communicator.context, operation, words.as_mut_ptr(), words.len()) })
    }

    fn exchange(&self, outgoing: &[u64], starts: &[usize], incoming: &mut [u64], froms: &[usize]) -> Result<()> {
        let (outgoing, starts, froms) = (outgoing.as_ptr(), starts.as_ptr(), froms.as_ptr());
        // SAFETY: as above.
        let status =
            unsafe { (self.exchange)(self.communicator.context, outgoing, starts, incoming.as_mut_ptr(), froms) };
        self.result(status)
    }
}
