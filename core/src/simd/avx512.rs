//! 512-bit vectors (x86-64-v4).

use core::arch::x86_64::*;

use super::Level;
use super::lanes::{Isa, Job, MAX_LANES, fourfold_quotients, paired_quotients, seeded_over_cube, seeded_root};
use super::rows::{PANEL_BITS, ROW, ROWS, Rows, starts};

/// Proof that the processor has AVX-512 F, DQ, BW, VL and that the operating system saves their registers.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx512 {
    /// The proof, if this machine has the features.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        Level::Avx512.is_available().then_some(Self(()))
    }
}

/// Runs the job with the features enabled.
#[inline]
#[expect(unsafe_code, reason = "enters the machine")]
pub fn run<T: crate::scalar::Scalar, J: Job<T>>(machine: Avx512, job: J) -> J::Out
where
    Avx512: Isa<T>,
{
    #[target_feature(enable = "avx2,fma,avx512f,avx512dq,avx512bw,avx512vl")]
    fn inside<T: crate::scalar::Scalar, J: Job<T>>(machine: Avx512, job: J) -> J::Out
    where
        Avx512: Isa<T>,
    {
        job.run(machine)
    }
    // SAFETY: `machine` exists, so the processor has the features.
    unsafe { inside(machine, job) }
}

/// The k-th four numbers of four rows in one vector. (Not a function or closure, which may be compiled without the instructions.)
macro_rules! fours {
    ($k:ident, $a:ident, $b:ident, $c:ident, $d:ident) => {{
        let first = _mm512_castps128_ps512(_mm_loadu_ps($a.add(4 * $k)));
        let second = _mm512_insertf32x4::<1>(first, _mm_loadu_ps($b.add(4 * $k)));
        let third = _mm512_insertf32x4::<2>(second, _mm_loadu_ps($c.add(4 * $k)));
        _mm512_insertf32x4::<3>(third, _mm_loadu_ps($d.add(4 * $k)))
    }};
}

/// Of four vectors, each of four pairs of numbers, the four vectors of first, second, third and fourth pairs.
macro_rules! quarters {
    ($ab:ident, $cd:ident, $ef:ident, $gh:ident) => {{
        // Pairs 0 and 2, and 1 and 3, of two vectors; then the same again.
        let abcd02 = _mm512_shuffle_f64x2::<0b10_00_10_00>($ab, $cd);
        let abcd13 = _mm512_shuffle_f64x2::<0b11_01_11_01>($ab, $cd);
        let efgh02 = _mm512_shuffle_f64x2::<0b10_00_10_00>($ef, $gh);
        let efgh13 = _mm512_shuffle_f64x2::<0b11_01_11_01>($ef, $gh);
        [
            _mm512_shuffle_f64x2::<0b10_00_10_00>(abcd02, efgh02),
            _mm512_shuffle_f64x2::<0b10_00_10_00>(abcd13, efgh13),
            _mm512_shuffle_f64x2::<0b11_01_11_01>(abcd02, efgh02),
            _mm512_shuffle_f64x2::<0b11_01_11_01>(abcd13, efgh13),
        ]
    }};
}

/// The columns of the rows of eight numbers at these addresses. A row is a vector. Eight rows are transposed by pairs of numbers, then by pairs of pairs, then by halves.
macro_rules! transposed_pd {
    ($rows:expr) => {{
        let [a, b, c, d, e, f, g, h] = $rows;
        let (a, b, c, d) = (_mm512_loadu_pd(a), _mm512_loadu_pd(b), _mm512_loadu_pd(c), _mm512_loadu_pd(d));
        let (e, f, g, h) = (_mm512_loadu_pd(e), _mm512_loadu_pd(f), _mm512_loadu_pd(g), _mm512_loadu_pd(h));
        let (ab0, ab1) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
        let (cd0, cd1) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
        let (ef0, ef1) = (_mm512_unpacklo_pd(e, f), _mm512_unpackhi_pd(e, f));
        let (gh0, gh1) = (_mm512_unpacklo_pd(g, h), _mm512_unpackhi_pd(g, h));
        let [c0, c2, c4, c6] = quarters!(ab0, cd0, ef0, gh0);
        let [c1, c3, c5, c7] = quarters!(ab1, cd1, ef1, gh1);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }};
}

/// The same of sixteen rows. Four numbers each of rows k, k + 4, k + 8, k + 12 form a vector. Four such vectors are transposed within their quarters.
macro_rules! transposed_ps {
    ($rows:expr) => {{
        let [r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12, r13, r14, r15] = $rows;
        let mut columns = [_mm512_setzero_ps(); ROW];
        let (fours, _) = columns.as_chunks_mut::<4>();
        for (k, four) in fours.iter_mut().enumerate() {
            let p = fours!(k, r0, r4, r8, r12);
            let q = fours!(k, r1, r5, r9, r13);
            let r = fours!(k, r2, r6, r10, r14);
            let s = fours!(k, r3, r7, r11, r15);
            let (pq_low, rs_low) = (_mm512_unpacklo_ps(p, q), _mm512_unpacklo_ps(r, s));
            let (pq_high, rs_high) = (_mm512_unpackhi_ps(p, q), _mm512_unpackhi_ps(r, s));
            *four = [
                _mm512_shuffle_ps::<0b01_00_01_00>(pq_low, rs_low),
                _mm512_shuffle_ps::<0b11_10_11_10>(pq_low, rs_low),
                _mm512_shuffle_ps::<0b01_00_01_00>(pq_high, rs_high),
                _mm512_shuffle_ps::<0b11_10_11_10>(pq_high, rs_high),
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
    ($t:ty, $v:ty, $m:ty, $lanes:literal, $set1:ident $loadu:ident $storeu:ident $add:ident $sub:ident $mul:ident $div:ident
     $sqrt:ident $fmadd:ident $fnmadd:ident $abs:ident $and:ident $or:ident $cmp:ident $blend:ident $signs:ident $cast:ident) => {
        type V = $v;
        type M = $m;
        type R = __m512i;
        type Row = [$t; $lanes];
        const LANES: usize = $lanes;
        #[inline(always)]
        fn in_blocks<J: super::lanes::BlockJob<$t>>(self, job: J) -> J::Out {
            job.run::<Self, 4>(self)
        }

        #[inline(always)]
        fn apart<P: super::lanes::Part<$t, Self>>(self, part: P) -> P::Out {
            #[target_feature(enable = "avx2,fma,avx512f,avx512dq,avx512bw,avx512vl")]
            #[inline(never)]
            fn inside<P: super::lanes::Part<$t, Avx512>>(machine: Avx512, part: P) -> P::Out {
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
            op!($abs(a))
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
        fn lt(self, a: $v, b: $v) -> $m {
            op!($cmp::<_CMP_LT_OQ>(a, b))
        }
        #[inline(always)]
        fn select(self, m: $m, yes: $v, no: $v) -> $v {
            op!($blend(m, no, yes))
        }
        #[inline(always)]
        fn bits(self, m: $m) -> u32 {
            u32::from(m)
        }
        // Tests the signs of a - bound. Subtractions use units that the multiplications leave idle; comparisons do not.
        #[inline(always)]
        fn any_below<const N: usize>(self, a: &[$v; N], bound: $v) -> bool {
            let mut signs = Isa::<$t>::splat(self, 0.0);
            for &a in a {
                signs = op!($or(signs, $sub(a, bound)));
            }
            op!($signs($cast(signs))) != 0
        }
        #[inline(always)]
        fn all_below<const N: usize>(self, a: &[$v; N], bound: $v) -> bool {
            let mut signs = Isa::<$t>::splat(self, -0.0);
            for &a in a {
                signs = op!($and(signs, $sub(a, bound)));
            }
            op!($signs($cast(signs))) == <$m>::MAX
        }
    };
}

impl Isa<f64> for Avx512 {
    common! { f64, __m512d, __mmask8, 8, _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd _mm512_add_pd _mm512_sub_pd
    _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd _mm512_fmadd_pd _mm512_fnmadd_pd _mm512_abs_pd _mm512_and_pd _mm512_or_pd
    _mm512_cmp_pd_mask _mm512_mask_blend_pd _mm512_movepi64_mask _mm512_castpd_si512 }

    // The seed has 14 bits: e < 2^-13. (1 - e)^(-3/2) is truncated with an error below 2.5 e^4 < 2^-50.7.
    #[inline(always)]
    fn inverse_roots<const N: usize>(self, a: [__m512d; N]) -> [__m512d; N] {
        let mut result = a;
        for a in &mut result {
            *a = seeded_root::<f64, _, 3>(self, *a, op!(_mm512_rsqrt14_pd(*a)));
        }
        result
    }

    #[inline(always)]
    fn over_cubed_roots<const N: usize>(self, m: __m512d, a: [__m512d; N]) -> [__m512d; N] {
        let mut result = a;
        for a in &mut result {
            *a = seeded_over_cube::<f64, _, 3>(self, m, *a, op!(_mm512_rsqrt14_pd(*a)));
        }
        result
    }

    #[inline(always)]
    fn quotients<const N: usize>(self, m: __m512d, a: [__m512d; N]) -> [__m512d; N] {
        if N.is_multiple_of(4) {
            fourfold_quotients::<f64, _, N>(self, m, a)
        } else {
            paired_quotients::<f64, _, N>(self, m, a)
        }
    }

    #[inline(always)]
    fn rows(self, u: __m512d) -> (__m512i, __m512d) {
        const SHIFT: u32 = 52 - PANEL_BITS;
        op!({
            let bits = _mm512_castpd_si512(u);
            let least = _mm512_and_si512(bits, _mm512_set1_epi64(-1 << SHIFT));
            let rows = _mm512_and_si512(_mm512_srli_epi64::<SHIFT>(bits), _mm512_set1_epi64(ROWS as i64 - 1));
            (rows, _mm512_castsi512_pd(least))
        })
    }

    #[inline(always)]
    fn look_up(self, table: &Rows<f64>, rows: __m512i) -> [__m512d; ROW] {
        op!({
            let base = table.as_ptr().cast::<f64>();
            let mut at = [0_i64; 8];
            _mm512_storeu_si512(at.as_mut_ptr().cast(), rows);
            // Row numbers are below ROWS, so every load lies in the table.
            transposed_pd!(at.map(|row| base.add(ROW * row as usize)))
        })
    }

    #[inline(always)]
    fn columns(self, rows: &[&[f64; ROW]; MAX_LANES]) -> [__m512d; ROW] {
        op!(transposed_pd!(starts::<f64, 8>(rows)))
    }

    #[inline(always)]
    fn split(self, a: __m512d) -> (__m512d, __m512d) {
        let (one, root) = (1.0_f64.to_bits() as i64, core::f64::consts::FRAC_1_SQRT_2.to_bits() as i64);
        op!({
            let k = _mm512_add_epi64(_mm512_castpd_si512(a), _mm512_set1_epi64(one - root));
            let fraction = _mm512_and_si512(k, _mm512_set1_epi64(0x000F_FFFF_FFFF_FFFF));
            let f = _mm512_castsi512_pd(_mm512_add_epi64(fraction, _mm512_set1_epi64(root)));
            let e = _mm512_sub_epi64(_mm512_srli_epi64::<52>(k), _mm512_set1_epi64(1023));
            (f, _mm512_cvtepi64_pd(e))
        })
    }
}

impl Isa<f32> for Avx512 {
    common! { f32, __m512, __mmask16, 16, _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_add_ps _mm512_sub_ps
    _mm512_mul_ps _mm512_div_ps _mm512_sqrt_ps _mm512_fmadd_ps _mm512_fnmadd_ps _mm512_abs_ps _mm512_and_ps _mm512_or_ps
    _mm512_cmp_ps_mask _mm512_mask_blend_ps _mm512_movepi32_mask _mm512_castps_si512 }

    // e < 2^-13; truncation error below 1.9 e^2 < 2^-25.
    #[inline(always)]
    fn inverse_roots<const N: usize>(self, a: [__m512; N]) -> [__m512; N] {
        let mut result = a;
        for a in &mut result {
            *a = seeded_root::<f32, _, 1>(self, *a, op!(_mm512_rsqrt14_ps(*a)));
        }
        result
    }

    #[inline(always)]
    fn over_cubed_roots<const N: usize>(self, m: __m512, a: [__m512; N]) -> [__m512; N] {
        let mut result = a;
        for a in &mut result {
            *a = seeded_over_cube::<f32, _, 1>(self, m, *a, op!(_mm512_rsqrt14_ps(*a)));
        }
        result
    }

    // The approximation has 14 bits. With e = 1 - a y, m / a = m y (1 + e) up to e^2 < 2^-28.
    #[inline(always)]
    fn quotients<const N: usize>(self, m: __m512, a: [__m512; N]) -> [__m512; N] {
        let mut result = a;
        for a in &mut result {
            let y = op!(_mm512_rcp14_ps(*a));
            let (e, q) =
                (Isa::<f32>::neg_mul_add(self, *a, y, Isa::<f32>::splat(self, 1.0)), Isa::<f32>::mul(self, m, y));
            *a = Isa::<f32>::mul_add(self, q, e, q);
        }
        result
    }

    #[inline(always)]
    fn rows(self, u: __m512) -> (__m512i, __m512) {
        const SHIFT: u32 = 23 - PANEL_BITS;
        op!({
            let bits = _mm512_castps_si512(u);
            let least = _mm512_and_si512(bits, _mm512_set1_epi32(-1 << SHIFT));
            let rows = _mm512_and_si512(_mm512_srli_epi32::<SHIFT>(bits), _mm512_set1_epi32(ROWS as i32 - 1));
            (rows, _mm512_castsi512_ps(least))
        })
    }

    #[inline(always)]
    fn look_up(self, table: &Rows<f32>, rows: __m512i) -> [__m512; ROW] {
        op!({
            let base = table.as_ptr().cast::<f32>();
            let mut at = [0_i32; 16];
            _mm512_storeu_si512(at.as_mut_ptr().cast(), rows);
            // Row numbers are below ROWS, so every load lies in the table.
            transposed_ps!(at.map(|row| base.add(ROW * row as usize)))
        })
    }

    #[inline(always)]
    fn columns(self, rows: &[&[f32; ROW]; MAX_LANES]) -> [__m512; ROW] {
        op!(transposed_ps!(starts::<f32, 16>(rows)))
    }

    #[inline(always)]
    fn split(self, a: __m512) -> (__m512, __m512) {
        let (one, root) = (1.0_f32.to_bits() as i32, core::f32::consts::FRAC_1_SQRT_2.to_bits() as i32);
        op!({
            let k = _mm512_add_epi32(_mm512_castps_si512(a), _mm512_set1_epi32(one - root));
            let fraction = _mm512_and_si512(k, _mm512_set1_epi32(0x007F_FFFF));
            let f = _mm512_castsi512_ps(_mm512_add_epi32(fraction, _mm512_set1_epi32(root)));
            let e = _mm512_sub_epi32(_mm512_srli_epi32::<23>(k), _mm512_set1_epi32(127));
            (f, _mm512_cvtepi32_ps(e))
        })
    }
}
