//! Another library written in Rust, with its own std.

/// The length of the numbers 0 to n - 1 as text.
#[unsafe(no_mangle)]
pub extern "C" fn second_length(n: usize) -> usize {
    format!("{:?}", (0..n).map(|k| k as f64).collect::<Vec<_>>()).len()
}
