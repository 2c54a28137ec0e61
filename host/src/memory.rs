//! Memory aligned as the library asks.

use mollis_core::memory::ALIGN;

/// Bytes at a multiple of [`ALIGN`].
#[derive(Debug)]
pub struct Memory(Vec<u8>);

impl Memory {
    /// This many bytes, zeros.
    #[must_use]
    pub fn new(bytes: usize) -> Self {
        Self(vec![0; bytes + ALIGN])
    }

    /// This many bytes, not zeros: for checks that nothing depends on what a buffer held.
    #[must_use]
    pub fn dirty(bytes: usize) -> Self {
        Self(vec![0xA5; bytes + ALIGN])
    }

    fn range(&self) -> std::ops::Range<usize> {
        let start = self.0.as_ptr().align_offset(ALIGN);
        start..start + self.0.len() - ALIGN
    }

    /// The bytes, to write.
    pub fn slice(&mut self) -> &mut [u8] {
        let range = self.range();
        &mut self.0[range]
    }

    /// The bytes, to read.
    #[must_use]
    pub fn read(&self) -> &[u8] {
        &self.0[self.range()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_aligned() {
        for bytes in [0, 1, 63, 64, 1000] {
            let mut memory = Memory::new(bytes);
            assert_eq!((memory.slice().len(), memory.slice().as_ptr().align_offset(ALIGN)), (bytes, 0));
        }
    }
}
