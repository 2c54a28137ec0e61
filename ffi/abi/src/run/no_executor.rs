//! In place of `executor`, in a build without executors.

use core::convert::Infallible;

use mollis_core::exec::Executor;
use mollis_core::{Error, Result};

use super::mollis_executor;
use crate::status::mollis_status;

/// Never there.
pub(super) struct Host(Infallible);

impl Host {
    /// # Safety
    /// None is needed.
    pub unsafe fn read(executor: *const mollis_executor) -> Result<Option<Self>> {
        if executor.is_null() { Ok(None) } else { Err(Error::Unsupported) }
    }

    pub fn refused(&self) -> mollis_status {
        match self.0 {}
    }
}

impl Executor for Host {
    fn workers(&self) -> usize {
        match self.0 {}
    }

    fn run(&self, _tasks: usize, _task: &(dyn Fn(usize) + Sync)) -> Result<()> {
        match self.0 {}
    }
}
