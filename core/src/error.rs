//! The table of errors: enum, C codes and texts.

use core::ffi::CStr;

/// The result of every fallible function of mollis.
pub type Result<T> = core::result::Result<T, Error>;

macro_rules! errors {
    ($($code:literal $name:ident $text:literal $doc:literal)*) => {
        /// The reason why a call was refused or a run stopped.
        ///
        /// The number is the C code (`MOLLIS_ERR_*`); 0 is success. Numbers are never reused or changed, and are below 256.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        #[repr(i32)]
        pub enum Error {
            $(#[doc = $doc] $name = $code,)*
        }

        impl Error {
            /// Every error, in the order of the codes.
            pub const ALL: &'static [Error] = &[$(Error::$name,)*];

            /// The variant's name, from which the C constant is formed: `NullPointer` is `MOLLIS_ERR_NULL_POINTER`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Error::$name => stringify!($name),)* }
            }

            /// An English sentence without a final full stop. Static, never empty.
            #[must_use]
            pub const fn text(self) -> &'static CStr {
                match self { $(Error::$name => $text,)* }
            }

            /// The error with this code.
            #[must_use]
            pub const fn from_code(code: i32) -> Option<Self> {
                match code { $($code => Some(Error::$name),)* _ => None }
            }
        }
    };
}

errors! {
    1 NullPointer c"a required pointer is null" "A required pointer is null (C only)."
    2 Misaligned c"a pointer is not aligned as its type or the workspace needs" "A pointer is not aligned as its type or the workspace needs."
    3 WorkspaceTooSmall c"the workspace is smaller than its size query asked" "The buffer is smaller than its size query asked."
    4 TooLarge c"a size overflows" "A count or a byte size overflows."
    5 LengthMismatch c"arrays that belong together have different lengths" "Arrays that belong together have different lengths."
    6 Overlap c"an output overlaps another buffer" "An output overlaps another buffer of the call."
    7 NotPrepared c"the buffer holds no prepared object of this kind" "The buffer holds no prepared object of this kind."
    8 WrongVersion c"the prepared object was made by another version of the library" "The prepared object was made by another version of the library."
    9 WrongScalar c"the prepared object is for the other scalar type" "The prepared object is for the other scalar type."
    10 WrongByteOrder c"the prepared object was made on a machine of other byte order" "The prepared object was made on a machine of the other byte order."
    11 OptionsSize c"the options structure's size is none that this library knows" "The size in an options structure is none that this library knows: larger than the structure, or within one of its members (C only)."
    12 NotInitialised c"the options structure was not filled by its _init function" "The size in an options structure is 0: it was not filled by its `_init` function (C only)."
    20 NotFinite c"an input value is not finite" "An input coordinate, mass or parameter is not finite."
    21 Delta c"delta must be positive and finite" "delta, the mollifier's length, must be positive and finite."
    22 Dimension c"the dimension must be 1, 2 or 3" "The dimension must be 1, 2 or 3."
    23 Exponent c"the mollifier's exponent M must be 1 to 9" "The mollifier's exponent M must be 1 to 9."
    24 Order c"the mollifier has no such order in this dimension" "The mollifier has no such order in this dimension."
    25 UnknownValue c"an enumerated value is unknown" "An enumerated value is unknown."
    26 TimeStep c"the time step must be positive and finite" "The time step must be positive and finite."
    27 KernelParameter c"a kernel parameter is outside its range" "A kernel parameter is outside its range: a power needs p > 1 - d, a screening k > 0, a length > 0."
    28 KernelTerms c"a kernel sum has no term or too many" "A kernel sum has no term or more than its fixed capacity."
    29 Mass c"masses must be positive here" "Masses must be positive here."
    30 OutOfDomain c"a parameter is outside its documented range" "A parameter is outside its documented range."
    31 Unsupported c"this combination is not offered" "The combination of kernel, mollifier, dimension or method is not offered."
    32 KernelFit c"a host's kernel is not met within its tolerance" "A host's kernel is not met within its tolerance: it is not smooth where no knot was stated, not accurate itself, or its three functions do not belong together."
    33 KernelReach c"the reach of a host's kernel must be positive and finite" "The reach of a host's kernel must be positive and finite: 1e-150 to 1e150."
    34 KernelKnots c"knots must increase strictly between zero and the reach" "The knots of a host's kernel must increase strictly between its least distance and its reach, and be no more than their fixed capacity."
    35 NoRoom c"the arrays for the results are too short; how many there are is told" "The arrays for the results are too short; how many there are is told."
    36 SignChange c"the mollifier changes sign where a positive one is needed" "The mollifier changes sign (its order is above 2) where the density of blobs has to be positive."
    40 BecameNotFinite c"a value became non-finite; the state is that of the last completed step" "A value became non-finite in a run; the state is that of the last completed step."
    41 Stopped c"stopped at the host's request" "The host's `should_stop` or step callback asked to stop."
    42 EventsFull c"the event buffer is full; no event was lost" "The event buffer is full; the step stopped before the merge, no event is lost."
    43 TooManySubsteps c"a particle needs more sub-steps than allowed" "A particle needs more sub-steps than allowed."
    44 EnergyRose c"the energy rose beyond rounding" "The energy rose beyond rounding along a gradient flow."
    45 Generator c"the random generator reported an error" "The user's random generator reported an error."
    46 Executor c"the executor did not run every task" "The executor did not run every task, ran them with more workers than it stated, or reported an error."
    47 Internal c"an invariant of the library is broken" "An invariant of the library is broken: please report it. Outputs are partly written."
    48 NotConverged c"the iteration did not reach its tolerance" "An iteration did not reach its tolerance within the allowed number of iterations; the result is the last iterate."
    49 Communicator c"the communicator reported an error, or what the ranks were given differs" "The communicator reported an error, or what the ranks were given and has to be the same on all differs."
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        // The texts are ASCII literals, so the conversion cannot fail.
        f.write_str(self.text().to_str().unwrap_or(""))
    }
}

impl core::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::Error;

    #[test]
    fn codes_are_unique_and_round_trip() {
        for pair in Error::ALL.windows(2) {
            assert!((pair[0] as i32) < (pair[1] as i32), "{pair:?}");
        }
        for &e in Error::ALL {
            assert_eq!(Error::from_code(e as i32), Some(e));
            // `exec::par_chunks` stores a code in eight bits, and the C header reserves the remaining codes for hosts.
            assert!((1..256).contains(&(e as i32)));
            assert!(!e.text().is_empty() && e.text().to_bytes().is_ascii());
        }
        assert_eq!(Error::from_code(0), None);
    }
}
