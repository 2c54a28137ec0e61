//! The machine: lanes, instruction sets and the one dispatch. The only place, with `space`, that holds `unsafe` in core.

pub(crate) mod root;
