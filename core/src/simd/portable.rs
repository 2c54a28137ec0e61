//! Portable code: arrays of numbers, each operation rounded separately, in the written order. The bits are the same
//! on every machine. The compiler may use vectors, because lanes are independent.

use super::lanes::Isa;
use super::rows::{PANEL_BITS, ROW, ROWS, Rows};
use super::vectors::{LANES, MAX_LANES, both, each, first};
use crate::scalar::Scalar;

/// Uses no operation except + - * / and sqrt.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

/// Quotients and roots in single precision.
///
/// From scalar operations the compiler makes vector operations, of two numbers at times, whose other two lanes are zero. 0 / 0 raises an exception, which a
/// program may trap. So these operations are written for the whole register.
#[cfg(target_arch = "x86_64")]
mod single {
    use core::arch::x86_64::{__m128, _mm_div_ps, _mm_setr_ps, _mm_sqrt_ps, _mm_storeu_ps};

    #[inline(always)]
    fn vector([a, b, c, d]: [f32; 4]) -> __m128 {
        #[expect(unsafe_code, reason = "an instruction of every x86_64 processor")]
        // SAFETY: SSE is part of x86_64.
        unsafe {
            _mm_setr_ps(a, b, c, d)
        }
    }

    #[inline(always)]
    fn numbers(vector: __m128) -> [f32; 4] {
        let mut numbers = [0.0; 4];
        #[expect(unsafe_code, reason = "a store of four numbers")]
        // SAFETY: SSE is part of x86_64, and the array has room for four numbers.
        unsafe {
            _mm_storeu_ps(numbers.as_mut_ptr(), vector);
        }
        numbers
    }

    #[inline(always)]
    pub fn quotients(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        #[expect(unsafe_code, reason = "an instruction of every x86_64 processor")]
        // SAFETY: SSE is part of x86_64.
        numbers(unsafe { _mm_div_ps(vector(a), vector(b)) })
    }

    #[inline(always)]
    pub fn roots(a: [f32; 4]) -> [f32; 4] {
        #[expect(unsafe_code, reason = "an instruction of every x86_64 processor")]
        // SAFETY: SSE is part of x86_64.
        numbers(unsafe { _mm_sqrt_ps(vector(a)) })
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod single {
    use super::{LANES, Scalar, both, each};

    #[inline(always)]
    pub fn quotients(a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        both(a, b, |a, b| a / b)
    }

    #[inline(always)]
    pub fn roots(a: [f32; LANES]) -> [f32; LANES] {
        each(a, Scalar::sqrt)
    }
}

/// Quotients and roots in double precision: two numbers fill a register.
mod double {
    use super::{LANES, Scalar, both, each};

    #[inline(always)]
    pub fn quotients(a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        both(a, b, |a, b| a / b)
    }

    #[inline(always)]
    pub fn roots(a: [f64; LANES]) -> [f64; LANES] {
        each(a, Scalar::sqrt)
    }
}

macro_rules! portable {
    ($t:ty, $mask:ty, $own:ident, $digits:literal, $bias:literal, $mantissa:literal) => {
        impl Isa<$t> for Portable {
            type V = [$t; LANES];
            // All bits or none: a choice by truth values would be a branch in every lane.
            type M = [$mask; LANES];
            type R = [usize; LANES];
            type Row = [$t; LANES];
            const LANES: usize = LANES;
            const IN_ORDER: bool = true;
            #[inline(always)]
            fn in_blocks<J: super::lanes::BlockJob<$t>>(self, job: J) -> J::Out {
                job.run::<Self, 1>(self)
            }

            #[inline(always)]
            fn splat(self, a: $t) -> Self::V {
                [a; LANES]
            }
            #[inline(always)]
            fn load(self, from: &[$t; MAX_LANES]) -> Self::V {
                first(from)
            }
            #[inline(always)]
            fn store(self, a: Self::V) -> [$t; MAX_LANES] {
                let mut to = [0.0; MAX_LANES];
                to.iter_mut().zip(a).for_each(|(to, a)| *to = a);
                to
            }
            #[inline(always)]
            fn load_row(self, from: &Self::Row) -> Self::V {
                *from
            }
            #[inline(always)]
            fn store_row(self, a: Self::V) -> Self::Row {
                a
            }
            #[inline(always)]
            fn add(self, a: Self::V, b: Self::V) -> Self::V {
                both(a, b, |a, b| a + b)
            }
            #[inline(always)]
            fn sub(self, a: Self::V, b: Self::V) -> Self::V {
                both(a, b, |a, b| a - b)
            }
            #[inline(always)]
            fn mul(self, a: Self::V, b: Self::V) -> Self::V {
                both(a, b, |a, b| a * b)
            }
            #[inline(always)]
            fn div(self, a: Self::V, b: Self::V) -> Self::V {
                $own::quotients(a, b)
            }
            #[inline(always)]
            fn sqrt(self, a: Self::V) -> Self::V {
                $own::roots(a)
            }
            #[inline(always)]
            fn abs(self, a: Self::V) -> Self::V {
                each(a, Scalar::abs)
            }
            #[inline(always)]
            fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
                Isa::<$t>::add(self, Isa::<$t>::mul(self, a, b), c)
            }
            #[inline(always)]
            fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
                Isa::<$t>::sub(self, c, Isa::<$t>::mul(self, a, b))
            }
            #[inline(always)]
            fn lt(self, a: Self::V, b: Self::V) -> Self::M {
                both(a, b, |a, b| <$mask>::from(a < b).wrapping_neg())
            }
            #[inline(always)]
            fn select(self, m: Self::M, yes: Self::V, no: Self::V) -> Self::V {
                let yes = both(m, yes, |m, yes| m & yes.to_bits());
                let no = both(m, no, |m, no| !m & no.to_bits());
                both(yes, no, |yes, no| <$t>::from_bits(yes | no))
            }
            #[inline(always)]
            fn bits(self, m: Self::M) -> u32 {
                m.iter().rev().fold(0, |bits, &m| bits << 1 | (m & 1) as u32)
            }
            #[inline(always)]
            fn any_below<const N: usize>(self, a: &[Self::V; N], bound: Self::V) -> bool {
                a.iter().fold(0, |any, &a| Isa::<$t>::lt(self, a, bound).iter().fold(any, |any, &below| any | below))
                    != 0
            }
            #[inline(always)]
            fn all_below<const N: usize>(self, a: &[Self::V; N], bound: Self::V) -> bool {
                a.iter().fold(<$mask>::MAX, |all, &a| {
                    Isa::<$t>::lt(self, a, bound).iter().fold(all, |all, &below| all & below)
                }) != 0
            }
            // One division per lane: a quotient that depends on other lanes would depend on the number of lanes.
            #[inline(always)]
            fn quotients<const N: usize>(self, m: Self::V, a: [Self::V; N]) -> [Self::V; N] {
                let mut result = a;
                result.iter_mut().for_each(|a| *a = Isa::<$t>::div(self, m, *a));
                result
            }
            #[inline(always)]
            fn rows(self, u: Self::V) -> (Self::R, Self::V) {
                let shift = $digits - 1 - PANEL_BITS;
                let row = each(u, |u| (u.to_bits() >> shift) as usize % ROWS);
                (row, each(u, |u| <$t>::from_bits(u.to_bits() >> shift << shift)))
            }
            #[inline(always)]
            fn look_up(self, table: &Rows<$t>, rows: Self::R) -> [Self::V; ROW] {
                let mut columns = [[0.0; LANES]; ROW];
                for (lane, row) in rows.into_iter().enumerate() {
                    for (column, &number) in columns.iter_mut().zip(table.get(row).unwrap_or(&[<$t>::NAN; ROW])) {
                        column.get_mut(lane).into_iter().for_each(|slot| *slot = number);
                    }
                }
                columns
            }
            #[inline(always)]
            fn split(self, a: Self::V) -> (Self::V, Self::V) {
                let root = (core::f64::consts::FRAC_1_SQRT_2 as $t).to_bits();
                let k = each(a, |a| a.to_bits().wrapping_add((1.0 as $t).to_bits() - root));
                let f = each(k, |k| <$t>::from_bits((k & $mantissa) + root));
                (f, each(k, |k| ((k >> ($digits - 1)) as i32 - $bias) as $t))
            }
        }
    };
}
portable!(f32, u32, single, 24, 127, 0x007F_FFFF);
portable!(f64, u64, double, 53, 1023, 0x000F_FFFF_FFFF_FFFF);
