//! Any `rand_core` generator as one stream.

use super::Generator;
use crate::error::Result;

/// A user's generator: one stream, drawn serially in the order of the arrays. Label, step and sub-step are not used.
///
/// The generator holds the state. A run continues bit for bit if the generator is saved and restored with the buffers.
#[derive(Clone, Copy, Debug)]
pub struct Stream<R>(pub R);

impl<R: rand_core::Rng> Generator for Stream<R> {
    fn fill(&mut self, _: u64, _: u32, _: u32, out: &mut [u64]) -> Result<()> {
        out.iter_mut().for_each(|word| *word = self.0.next_u64());
        Ok(())
    }
}
