//! The context of a call: its executor and instruction set, the division of outputs among tasks, and its counters.
//!
//! * [`Run`]: level, executor, stop request; [`Resources`]: the first two; [`Statistics`]: the counters of a sum
//! * [`Communicator`]: exchanges words among the processes of the host
//! * [`Executor`]: runs independent tasks for the host; [`Serial`]: in the calling thread
//! * [`par_chunks`]: runs tasks, each with its own piece of the outputs ([`Partition`]) and of the scratch
//!
//! Work is split into tasks whose number depends on the problem's size alone, so results are bit for bit the same for any number of threads.

mod columns;
mod communicator;
mod executor;
mod partition;
mod run;

pub use columns::{Block, Columns};
pub(crate) use communicator::Ranks;
pub use communicator::{Communicator, Reduction};
pub use executor::{Executor, Serial};
pub use partition::{Body, Chunks, MAX_WORKERS, Partition, Ranges, par_chunks};
pub use run::{Resources, Run, Statistics};
