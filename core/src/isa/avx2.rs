//! 256-bit vectors with fused multiply-add (x86-64-v3).

use core::arch::x86_64::*;

use super::Level;
use super::lanes::{Isa, Job, MAX_LANES, paired_quotients, seeded_over_cube, seeded_root};

/// Proof that the processor has AVX2 and FMA, and that the system saves their registers.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, where it holds.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        Level::Avx2.is_available().then_some(Self(()))
    }
}

/// Runs the job with the features on.
#[inline]
#[expect(unsafe_code, reason = "enters the machine")]
pub fn run<T: crate::Real, J: Job<T>>(machine: Avx2, job: J) -> J::Out
where
    Avx2: Isa<T>,
{
    #[target_feature(enable = "avx2,fma")]
    fn inside<T: crate::Real, J: Job<T>>(machine: Avx2, job: J) -> J::Out
    where
        Avx2: Isa<T>,
    {
        job.run(machine)
    }
    // SAFETY: `machine` exists, so the processor has the features.
    unsafe { inside(machine, job) }
}

/// One instruction.
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
        const LANES: usize = $lanes;
        #[inline(always)]
        fn in_blocks<J: super::lanes::BlockJob<$t>>(self, job: J) -> J::Out {
            job.run::<Self, 2>(self)
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
        // The signs of a - bound: subtractions run on units that multiplications leave free, comparisons do not.
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
    fn split(self, a: __m256d) -> (__m256d, __m256d) {
        let (one, root) = (1.0_f64.to_bits() as i64, core::f64::consts::FRAC_1_SQRT_2.to_bits() as i64);
        op!({
            let k = _mm256_add_epi64(_mm256_castpd_si256(a), _mm256_set1_epi64x(one - root));
            let fraction = _mm256_and_si256(k, _mm256_set1_epi64x(0x000F_FFFF_FFFF_FFFF));
            let f = _mm256_castsi256_pd(_mm256_add_epi64(fraction, _mm256_set1_epi64x(root)));
            // The biased exponent as the low bits of 2^52 + e: a conversion that AVX2 lacks.
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

    // The seed has 12 bits: e < 2^-10.4, and the series is cut below 2.2 e^3 < 2^-30.
    #[inline(always)]
    fn inverse_root(self, a: __m256) -> __m256 {
        seeded_root::<f32, _, 2>(self, a, op!(_mm256_rsqrt_ps(a)))
    }

    #[inline(always)]
    fn over_cubed_roots<const N: usize>(self, m: __m256, a: [__m256; N]) -> [__m256; N] {
        let mut result = a;
        result.iter_mut().for_each(|a| *a = seeded_over_cube::<f32, _, 2>(self, m, *a, op!(_mm256_rsqrt_ps(*a))));
        result
    }

    #[inline(always)]
    fn quotients<const N: usize>(self, m: __m256, a: [__m256; N]) -> [__m256; N] {
        paired_quotients::<f32, _, N>(self, m, a)
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
