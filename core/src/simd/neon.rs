//! 128-bit vectors, available on every aarch64.

use core::arch::aarch64::*;

use super::lanes::{Isa, MAX_LANES};
use super::rows::{PANEL_BITS, ROW, ROWS, Rows};

/// Every aarch64 has these vectors, so no proof is needed.
#[derive(Clone, Copy, Debug)]
pub struct Neon;

/// Wraps one instruction.
macro_rules! op {
    ($call:expr) => {{
        // SAFETY: every aarch64 has the instruction; loads and stores stay inside the arrays.
        #[allow(unused_unsafe, reason = "intrinsics without pointers are safe where the target has them")]
        #[expect(unsafe_code, reason = "an instruction of every aarch64")]
        unsafe {
            $call
        }
    }};
}

macro_rules! neon {
    ($t:ty, $v:ty, $m:ty, $lanes:literal, $bits:ty, $digits:literal, $bias:literal, $mantissa:literal,
     $dup:ident $ld:ident $st:ident $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $fma:ident $fms:ident
     $abs:ident $clt:ident $bsl:ident $stm:ident) => {
        impl Isa<$t> for Neon {
            type V = $v;
            type M = $m;
            type R = [usize; $lanes];
            type Row = [$t; $lanes];
            const LANES: usize = $lanes;
            #[inline(always)]
            fn in_blocks<J: super::lanes::BlockJob<$t>>(self, job: J) -> J::Out {
                job.run::<Self, 4>(self)
            }

            #[inline(always)]
            fn splat(self, a: $t) -> $v {
                op!($dup(a))
            }
            #[inline(always)]
            fn load(self, from: &[$t; MAX_LANES]) -> $v {
                op!($ld(from.as_ptr()))
            }
            #[inline(always)]
            fn store(self, a: $v) -> [$t; MAX_LANES] {
                let mut to = [0.0; MAX_LANES];
                op!($st(to.as_mut_ptr(), a));
                to
            }
            #[inline(always)]
            fn load_row(self, from: &Self::Row) -> Self::V {
                op!($ld(from.as_ptr()))
            }
            #[inline(always)]
            fn store_row(self, a: Self::V) -> Self::Row {
                let mut to = [0.0; $lanes];
                op!($st(to.as_mut_ptr(), a));
                to
            }
            #[inline(always)]
            fn add(self, a: $v, b: $v) -> $v {
                op!($add(a, b))
            }
            #[inline(always)]
            fn sub(self, a: $v, b: $v) -> $v {
                op!($sub(a, b))
            }
            #[inline(always)]
            fn mul(self, a: $v, b: $v) -> $v {
                op!($mul(a, b))
            }
            #[inline(always)]
            fn div(self, a: $v, b: $v) -> $v {
                op!($div(a, b))
            }
            #[inline(always)]
            fn sqrt(self, a: $v) -> $v {
                op!($sqrt(a))
            }
            #[inline(always)]
            fn abs(self, a: $v) -> $v {
                op!($abs(a))
            }
            #[inline(always)]
            fn mul_add(self, a: $v, b: $v, c: $v) -> $v {
                op!($fma(c, a, b))
            }
            #[inline(always)]
            fn neg_mul_add(self, a: $v, b: $v, c: $v) -> $v {
                op!($fms(c, a, b))
            }
            #[inline(always)]
            fn lt(self, a: $v, b: $v) -> $m {
                op!($clt(a, b))
            }
            #[inline(always)]
            fn select(self, m: $m, yes: $v, no: $v) -> $v {
                op!($bsl(m, yes, no))
            }
            #[inline(always)]
            fn bits(self, m: $m) -> u32 {
                let mut words: [$bits; $lanes] = [0; $lanes];
                op!($stm(words.as_mut_ptr(), m));
                words.iter().rev().fold(0, |bits, &word| bits << 1 | u32::from(word != 0))
            }
            #[inline(always)]
            fn any_below<const N: usize>(self, a: &[$v; N], bound: $v) -> bool {
                let mut least = bound;
                for &a in a {
                    least = Isa::<$t>::select(self, Isa::<$t>::lt(self, a, least), a, least);
                }
                Isa::<$t>::any(self, Isa::<$t>::lt(self, least, bound))
            }
            #[inline(always)]
            fn all_below<const N: usize>(self, a: &[$v; N], bound: $v) -> bool {
                a.iter().all(|&a| Isa::<$t>::bits(self, Isa::<$t>::lt(self, a, bound)) == (1 << $lanes) - 1)
            }
            #[inline(always)]
            fn quotients<const N: usize>(self, m: $v, a: [$v; N]) -> [$v; N] {
                super::lanes::paired_quotients::<$t, Self, N>(self, m, a)
            }
            #[inline(always)]
            fn rows(self, u: $v) -> ([usize; $lanes], $v) {
                let shift = $digits - 1 - PANEL_BITS;
                let (mut rows, mut least) = ([0; $lanes], [0.0; MAX_LANES]);
                for ((row, least), u) in rows.iter_mut().zip(&mut least).zip(Isa::<$t>::store(self, u)) {
                    *row = (u.to_bits() >> shift) as usize % ROWS;
                    *least = <$t>::from_bits(u.to_bits() >> shift << shift);
                }
                (rows, Isa::<$t>::load(self, &least))
            }
            #[inline(always)]
            fn look_up(self, table: &Rows<$t>, rows: [usize; $lanes]) -> [$v; ROW] {
                let mut columns = [[0.0; MAX_LANES]; ROW];
                for (lane, row) in rows.into_iter().enumerate() {
                    for (column, &number) in columns.iter_mut().zip(table.get(row).unwrap_or(&[<$t>::NAN; ROW])) {
                        column.get_mut(lane).into_iter().for_each(|slot| *slot = number);
                    }
                }
                columns.map(|column| Isa::<$t>::load(self, &column))
            }
            #[inline(always)]
            fn split(self, a: $v) -> ($v, $v) {
                let root = (core::f64::consts::FRAC_1_SQRT_2 as $t).to_bits();
                let (mut f, mut e) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
                let a = Isa::<$t>::store(self, a);
                for ((f, e), a) in f.iter_mut().zip(&mut e).zip(a).take($lanes) {
                    let k = a.to_bits().wrapping_add((1.0 as $t).to_bits() - root);
                    *f = <$t>::from_bits((k & $mantissa) + root);
                    *e = ((k >> ($digits - 1)) as i32 - $bias) as $t;
                }
                (Isa::<$t>::load(self, &f), Isa::<$t>::load(self, &e))
            }
        }
    };
}
neon!(f64, float64x2_t, uint64x2_t, 2, u64, 53, 1023, 0x000F_FFFF_FFFF_FFFF, vdupq_n_f64 vld1q_f64 vst1q_f64 vaddq_f64
      vsubq_f64 vmulq_f64 vdivq_f64 vsqrtq_f64 vfmaq_f64 vfmsq_f64 vabsq_f64 vcltq_f64 vbslq_f64 vst1q_u64);
neon!(f32, float32x4_t, uint32x4_t, 4, u32, 24, 127, 0x007F_FFFF, vdupq_n_f32 vld1q_f32 vst1q_f32 vaddq_f32 vsubq_f32
      vmulq_f32 vdivq_f32 vsqrtq_f32 vfmaq_f32 vfmsq_f32 vabsq_f32 vcltq_f32 vbslq_f32 vst1q_u32);
