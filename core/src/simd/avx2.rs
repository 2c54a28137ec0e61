//! 256-bit vectors with fused multiply-add (x86-64-v3).

use core::arch::x86_64::*;

use super::Level;
use super::lanes::{Isa, Job, MAX_LANES, paired_quotients, seeded_over_cube, seeded_root};
use super::rows::{PANEL_BITS, ROW, ROWS, Rows, starts};

/// Proof that the processor has AVX2 and FMA and that the operating system saves their registers.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, if this machine has the features.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        Level::Avx2.is_available().then_some(Self(()))
    }
}

/// Runs the job with the features enabled.
#[inline]
#[expect(unsafe_code, reason = "enters the machine")]
pub fn run<T: crate::scalar::Scalar, J: Job<T>>(machine: Avx2, job: J) -> J::Out
where
    Avx2: Isa<T>,
{
    #[target_feature(enable = "avx2,fma")]
    fn inside<T: crate::scalar::Scalar, J: Job<T>>(machine: Avx2, job: J) -> J::Out
    where
        Avx2: Isa<T>,
    {
        job.run(machine)
    }
    // SAFETY: `machine` exists, so the processor has the features.
    unsafe { inside(machine, job) }
}

/// The columns of the rows of eight numbers at these addresses. Two 128-bit halves, from two rows, form a vector. Unpacking it with the vector of the two other rows
/// gives two columns.
macro_rules! transposed_pd {
    ($rows:expr) => {{
        let [a, b, c, d] = $rows;
        let mut columns = [_mm256_setzero_pd(); ROW];
        let (pairs, _) = columns.as_chunks_mut::<2>();
        for (k, [even, odd]) in pairs.iter_mut().enumerate() {
            let (a, b, c, d) = (a.add(2 * k), b.add(2 * k), c.add(2 * k), d.add(2 * k));
            let ac = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(c));
            let bd = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(b)), _mm_loadu_pd(d));
            *even = _mm256_unpacklo_pd(ac, bd);
            *odd = _mm256_unpackhi_pd(ac, bd);
        }
        columns
    }};
}

/// The same of eight rows. Four numbers of row k and four of row k + 4 form a vector. Four such vectors are transposed within their halves.
macro_rules! transposed_ps {
    ($rows:expr) => {{
        let [a, b, c, d, e, f, g, h] = $rows;
        let mut columns = [_mm256_setzero_ps(); ROW];
        let (fours, _) = columns.as_chunks_mut::<4>();
        for (k, four) in fours.iter_mut().enumerate() {
            let (a, b, c, d) = (a.add(4 * k), b.add(4 * k), c.add(4 * k), d.add(4 * k));
            let (e, f, g, h) = (e.add(4 * k), f.add(4 * k), g.add(4 * k), h.add(4 * k));
            let ae = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(a)), _mm_loadu_ps(e));
            let bf = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(b)), _mm_loadu_ps(f));
            let cg = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(c)), _mm_loadu_ps(g));
            let dh = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(d)), _mm_loadu_ps(h));
            let (ab_low, cd_low) = (_mm256_unpacklo_ps(ae, bf), _mm256_unpacklo_ps(cg, dh));
            let (ab_high, cd_high) = (_mm256_unpackhi_ps(ae, bf), _mm256_unpackhi_ps(cg, dh));
            *four = [
                _mm256_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
                _mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
            ];
        }
        columns
    }};
}

/// Wraps one instruction.
macro_rules! op {
    ($call:expr) => {{
        // SAFETY: `self` exists, so the processor has the instruction; loads and stores stay inside the arrays.
        #[expect(unsafe_code, reason = "an instruction that `self` proves to be there")]
        unsafe {
            $call
        }
    }};
}

macro_rules! common {
    ($t:ty, $v:ty, $lanes:literal, $set1:ident $loadu:ident $storeu:ident $add:ident $sub:ident $mul:ident $div:ident
     $sqrt:ident $fmadd:ident $fnmadd:ident $andnot:ident $and:ident $or:ident $cmp:ident $blendv:ident $movemask:ident) => {
        type V = $v;
        type M = $v;
        type R = __m256i;
        type Row = [$t; $lanes];
        const LANES: usize = $lanes;
        #[inline(always)]
        fn in_blocks<J: super::lanes::BlockJob<$t>>(self, job: J) -> J::Out {
            job.run::<Self, 2>(self)
        }

        #[inline(always)]
        fn apart<P: super::lanes::Part<$t, Self>>(self, part: P) -> P::Out {
            #[target_feature(enable = "avx2,fma")]
            #[inline(never)]
            fn inside<P: super::lanes::Part<$t, Avx2>>(machine: Avx2, part: P) -> P::Out {
                super::aligned_stack();
                part.run(machine)
            }
            op!(inside(self, part))
        }

        #[inline(always)]
        fn splat(self, a: $t) -> $v {
            op!($set1(a))
        }
        #[inline(always)]
        fn load(self, from: &[$t; MAX_LANES]) -> $v {
            op!($loadu(from.as_ptr()))
        }
        #[inline(always)]
        fn store(self, a: $v) -> [$t; MAX_LANES] {
            let mut to = [0.0; MAX_LANES];
            op!($storeu(to.as_mut_ptr(), a));
            to
        }
        #[inline(always)]
        fn load_row(self, from: &Self::Row) -> Self::V {
            op!($loadu(from.as_ptr()))
        }
        #[inline(always)]
        fn store_row(self, a: Self::V) -> Self::Row {
            let mut to = [0.0; $lanes];
            op!($storeu(to.as_mut_ptr(), a));
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
            op!($andnot($set1(-0.0), a))
        }
        #[inline(always)]
        fn mul_add(self, a: $v, b: $v, c: $v) -> $v {
            op!($fmadd(a, b, c))
        }
        #[inline(always)]
        fn neg_mul_add(self, a: $v, b: $v, c: $v) -> $v {
            op!($fnmadd(a, b, c))
        }
        #[inline(always)]
        fn lt(self, a: $v, b: $v) -> $v {
            op!($cmp::<_CMP_LT_OQ>(a, b))
        }
        #[inline(always)]
        fn select(self, m: $v, yes: $v, no: $v) -> $v {
            op!($blendv(no, yes, m))
        }
        #[inline(always)]
        fn bits(self, m: $v) -> u32 {
            op!($movemask(m)) as u32
        }
        // Tests the signs of a - bound. Subtractions use units that the multiplications leave idle; comparisons do not.
        #[inline(always)]
        fn any_below<const N: usize>(self, a: &[$v; N], bound: $v) -> bool {
            let mut signs = Isa::<$t>::splat(self, 0.0);
            for &a in a {
                signs = op!($or(signs, $sub(a, bound)));
            }
            Isa::<$t>::bits(self, signs) != 0
        }
        #[inline(always)]
        fn all_below<const N: usize>(self, a: &[$v; N], bound: $v) -> bool {
            let mut signs = Isa::<$t>::splat(self, -0.0);
            for &a in a {
                signs = op!($and(signs, $sub(a, bound)));
            }
            Isa::<$t>::bits(self, signs) == (1 << $lanes) - 1
        }
    };
}

impl Isa<f64> for Avx2 {
    common! { f64, __m256d, 4, _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd _mm256_add_pd _mm256_sub_pd
    _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd _mm256_fmadd_pd _mm256_fnmadd_pd _mm256_andnot_pd _mm256_and_pd _mm256_or_pd
    _mm256_cmp_pd _mm256_blendv_pd _mm256_movemask_pd }

    #[inline(always)]
    fn quotients<const N: usize>(self, m: __m256d, a: [__m256d; N]) -> [__m256d; N] {
        paired_quotients::<f64, _, N>(self, m, a)
    }

    #[inline(always)]
    fn rows(self, u: __m256d) -> (__m256i, __m256d) {
        const SHIFT: i32 = 52 - PANEL_BITS as i32;
        op!({
            let bits = _mm256_castpd_si256(u);
            let least = _mm256_and_si256(bits, _mm256_set1_epi64x(-1 << SHIFT));
            let rows = _mm256_and_si256(_mm256_srli_epi64::<SHIFT>(bits), _mm256_set1_epi64x(ROWS as i64 - 1));
            (rows, _mm256_castsi256_pd(least))
        })
    }

    #[inline(always)]
    fn look_up(self, table: &Rows<f64>, rows: __m256i) -> [__m256d; ROW] {
        op!({
            let base = table.as_ptr().cast::<f64>();
            let (low, high) = (_mm256_castsi256_si128(rows), _mm256_extracti128_si256::<1>(rows));
            // Row numbers are below ROWS, so every load lies in the table.
            let a = base.add(ROW * _mm_cvtsi128_si64(low) as usize);
            let b = base.add(ROW * _mm_extract_epi64::<1>(low) as usize);
            let c = base.add(ROW * _mm_cvtsi128_si64(high) as usize);
            let d = base.add(ROW * _mm_extract_epi64::<1>(high) as usize);
            transposed_pd!([a, b, c, d])
        })
    }

    #[inline(always)]
    fn columns(self, rows: &[&[f64; ROW]; MAX_LANES]) -> [__m256d; ROW] {
        op!(transposed_pd!(starts::<f64, 4>(rows)))
    }

    #[inline(always)]
    fn split(self, a: __m256d) -> (__m256d, __m256d) {
        let (one, root) = (1.0_f64.to_bits() as i64, core::f64::consts::FRAC_1_SQRT_2.to_bits() as i64);
        op!({
            let k = _mm256_add_epi64(_mm256_castpd_si256(a), _mm256_set1_epi64x(one - root));
            let fraction = _mm256_and_si256(k, _mm256_set1_epi64x(0x000F_FFFF_FFFF_FFFF));
            let f = _mm256_castsi256_pd(_mm256_add_epi64(fraction, _mm256_set1_epi64x(root)));
            // The biased exponent e as the low bits of 2^52 + e, because AVX2 has no conversion from 64-bit integers.
            let magic = 4_503_599_627_370_496.0_f64;
            let e = _mm256_or_si256(_mm256_srli_epi64::<52>(k), _mm256_set1_epi64x(magic.to_bits() as i64));
            (f, _mm256_sub_pd(_mm256_castsi256_pd(e), _mm256_set1_pd(magic + 1023.0)))
        })
    }
}

impl Isa<f32> for Avx2 {
    common! { f32, __m256, 8, _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_add_ps _mm256_sub_ps
    _mm256_mul_ps _mm256_div_ps _mm256_sqrt_ps _mm256_fmadd_ps _mm256_fnmadd_ps _mm256_andnot_ps _mm256_and_ps _mm256_or_ps
    _mm256_cmp_ps _mm256_blendv_ps _mm256_movemask_ps }

    // The seed has 12 bits: e < 2^-10.4. The series is truncated with an error below 2.2 e^3 < 2^-30.
    #[inline(always)]
    fn inverse_roots<const N: usize>(self, a: [__m256; N]) -> [__m256; N] {
        let mut result = a;
        for a in &mut result {
            *a = seeded_root::<f32, _, 2>(self, *a, op!(_mm256_rsqrt_ps(*a)));
        }
        result
    }

    #[inline(always)]
    fn over_cubed_roots<const N: usize>(self, m: __m256, a: [__m256; N]) -> [__m256; N] {
        let mut result = a;
        for a in &mut result {
            *a = seeded_over_cube::<f32, _, 2>(self, m, *a, op!(_mm256_rsqrt_ps(*a)));
        }
        result
    }

    #[inline(always)]
    fn quotients<const N: usize>(self, m: __m256, a: [__m256; N]) -> [__m256; N] {
        paired_quotients::<f32, _, N>(self, m, a)
    }

    #[inline(always)]
    fn rows(self, u: __m256) -> (__m256i, __m256) {
        const SHIFT: i32 = 23 - PANEL_BITS as i32;
        op!({
            let bits = _mm256_castps_si256(u);
            let least = _mm256_and_si256(bits, _mm256_set1_epi32(-1 << SHIFT));
            let rows = _mm256_and_si256(_mm256_srli_epi32::<SHIFT>(bits), _mm256_set1_epi32(ROWS as i32 - 1));
            (rows, _mm256_castsi256_ps(least))
        })
    }

    #[inline(always)]
    fn look_up(self, table: &Rows<f32>, rows: __m256i) -> [__m256; ROW] {
        op!({
            let base = table.as_ptr().cast::<f32>();
            let mut at = [0_i32; 8];
            _mm256_storeu_si256(at.as_mut_ptr().cast(), rows);
            // Row numbers are below ROWS, so every load lies in the table.
            transposed_ps!(at.map(|row| base.add(ROW * row as usize)))
        })
    }

    #[inline(always)]
    fn columns(self, rows: &[&[f32; ROW]; MAX_LANES]) -> [__m256; ROW] {
        op!(transposed_ps!(starts::<f32, 8>(rows)))
    }

    #[inline(always)]
    fn split(self, a: __m256) -> (__m256, __m256) {
        let (one, root) = (1.0_f32.to_bits() as i32, core::f32::consts::FRAC_1_SQRT_2.to_bits() as i32);
        op!({
            let k = _mm256_add_epi32(_mm256_castps_si256(a), _mm256_set1_epi32(one - root));
            let fraction = _mm256_and_si256(k, _mm256_set1_epi32(0x007F_FFFF));
            let f = _mm256_castsi256_ps(_mm256_add_epi32(fraction, _mm256_set1_epi32(root)));
            let e = _mm256_sub_epi32(_mm256_srli_epi32::<23>(k), _mm256_set1_epi32(127));
            (f, _mm256_cvtepi32_ps(e))
        })
    }
}
