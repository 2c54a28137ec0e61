//! In place of `communicator`, in a build without ranks.

use core::convert::Infallible;

use mollis_core::exec::Communicator;
use mollis_core::{Error, Result};

use super::mollis_communicator;
use crate::status::mollis_status;

/// Never there.
pub(super) struct HostRanks(Infallible);

impl HostRanks {
    /// # Safety
    /// None is needed.
    pub unsafe fn read(communicator: *const mollis_communicator) -> Result<Option<Self>> {
        if communicator.is_null() { Ok(None) } else { Err(Error::Unsupported) }
    }

    pub fn refused(&self) -> mollis_status {
        match self.0 {}
    }

    pub fn count(&self) -> usize {
        match self.0 {}
    }

    pub fn as_dyn(&self) -> &dyn Communicator {
        match self.0 {}
    }
}
