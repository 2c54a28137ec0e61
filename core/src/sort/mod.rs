//! Sorting in the caller's memory, without a panic path.
//!
//! * [`radix`]: floating-point keys with their indices, and the order of points along an axis
//! * [`words`]: 64-bit words with the key in the high half and an index in the low half; small sorts in place

pub(crate) mod radix;
pub(crate) mod words;
