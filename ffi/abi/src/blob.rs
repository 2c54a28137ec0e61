//! The blob method.
