//! The layout of a caller's workspace.
//!
//! A layout is written once, generic over [`Space`], and run twice: [`Measure`] counts bytes, [`Carve`]
//! hands out the arrays. So a size query and the call that needs the memory always agree:
//!
//! ```
//! use mollis_core::memory::{Carve, Measure, Space};
//! use mollis_core::Result;
//! struct Arrays<'w> { x: &'w mut [f64], y: &'w mut [f64] }
//! fn layout<'w>(space: &mut impl Space<'w>, n: usize) -> Result<Arrays<'w>> {
//!     Ok(Arrays { x: space.try_array(n)?, y: space.try_array(n)? })
//! }
//! let bytes = Measure::of(|space| layout(space, 3).map(|_| ()))?;
//! let mut memory = vec![0xAA_u8; bytes + 63];
//! let start = memory.as_ptr().align_offset(64);
//! let arrays = layout(&mut Carve::new(&mut memory[start..])?, 3)?;
//! assert_eq!((arrays.x.len(), arrays.y[2]), (3, 0.0));
//! # Ok::<(), mollis_core::Error>(())
//! ```
//!
//! A layout must not access the elements of an array, because `Measure` returns empty slices.

mod carve;

pub(crate) use carve::unsigned;
pub use carve::{ALIGN, BLOCK_ALIGN, Carve, Measure, Plain, Space, View};
