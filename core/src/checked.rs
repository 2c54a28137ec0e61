//! Access to what must be there.
//!
//! The library has no panic, so an access that cannot fail still has to say what happens if it does. In tests it panics, where the fault is; in a release build
//! the call ends with [`Error::Internal`].

use crate::error::{Error, Result};

/// A value that the code around it has arranged to be there.
pub(crate) trait Present<T> {
    /// The value.
    ///
    /// # Errors
    /// [`Error::Internal`]: it is not there.
    fn present(self) -> Result<T>;

    /// The value, in a function that returns no error: the other one instead.
    fn present_or(self, other: T) -> T;

    /// As [`Present::present_or`], with the default.
    fn present_or_default(self) -> T
    where
        T: Default;
}

impl<T> Present<T> for Option<T> {
    #[inline(always)]
    #[cfg_attr(debug_assertions, track_caller)]
    fn present(self) -> Result<T> {
        debug_assert!(self.is_some(), "an invariant of the library is broken");
        self.ok_or(Error::Internal)
    }

    #[inline(always)]
    #[cfg_attr(debug_assertions, track_caller)]
    fn present_or(self, other: T) -> T {
        debug_assert!(self.is_some(), "an invariant of the library is broken");
        self.unwrap_or(other)
    }

    #[inline(always)]
    #[cfg_attr(debug_assertions, track_caller)]
    fn present_or_default(self) -> T
    where
        T: Default,
    {
        debug_assert!(self.is_some(), "an invariant of the library is broken");
        self.unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_returned() {
        assert_eq!(Some(1).present(), Ok(1));
        assert_eq!(Some(1).present_or(2), 1);
    }

    #[cfg(debug_assertions)]
    #[test]
    #[should_panic(expected = "invariant")]
    fn what_is_not_there_stops_a_test() {
        let _ = None::<i32>.present();
    }

    #[cfg(not(debug_assertions))]
    #[test]
    fn what_is_not_there_is_an_error() {
        assert_eq!(None::<i32>.present(), Err(Error::Internal));
    }
}
