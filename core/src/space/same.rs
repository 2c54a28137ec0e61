//! Two names of one type.
//!
//! Generic code is compiled in the crate that uses it, which for the sums means minutes, again and again. A function that
//! has found out that its types are f64 and two dimensions can go on in one that was compiled with this crate.

use core::any::TypeId;
use core::marker::PhantomData;

/// Proof that two types are one.
#[derive(Debug)]
pub(crate) struct Same<A, B>(PhantomData<(A, B)>);

impl<A, B> Clone for Same<A, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A, B> Copy for Same<A, B> {}

#[expect(unsafe_code, reason = "references to one type under its two names")]
impl<A: 'static, B: 'static> Same<A, B> {
    /// The proof, where it holds.
    #[inline(always)]
    pub fn proof() -> Option<Self> {
        (TypeId::of::<A>() == TypeId::of::<B>()).then_some(Self(PhantomData))
    }

    /// The reference under the other name.
    #[inline(always)]
    pub fn reference(self, a: &A) -> &B {
        // SAFETY: A and B are one type.
        unsafe { &*core::ptr::from_ref(a).cast::<B>() }
    }

    /// The slice under the other name.
    #[inline(always)]
    pub fn slice(self, a: &[A]) -> &[B] {
        // SAFETY: A and B are one type.
        unsafe { core::slice::from_raw_parts(a.as_ptr().cast::<B>(), a.len()) }
    }

    /// The slice under the other name.
    #[inline(always)]
    pub fn slice_mut(self, a: &mut [A]) -> &mut [B] {
        // SAFETY: A and B are one type; the borrow passes on.
        unsafe { core::slice::from_raw_parts_mut(a.as_mut_ptr().cast::<B>(), a.len()) }
    }
}

#[cfg(test)]
mod tests {
    use super::Same;

    #[test]
    fn only_one_type_is_the_same() {
        assert!(Same::<f32, f64>::proof().is_none());
        assert!(Same::<[f64; 2], [f64; 3]>::proof().is_none());
        assert!(Same::<u64, f64>::proof().is_none());
        let same = Same::<[f64; 2], [f64; 2]>::proof().unwrap();
        let mut x = [[1.0, 2.0], [3.0, 4.0]];
        assert_eq!(same.slice(&x), &x);
        assert_eq!(same.reference(&x[1]), &[3.0, 4.0]);
        same.slice_mut(&mut x)[0] = [5.0, 6.0];
        assert_eq!(x[0], [5.0, 6.0]);
    }
}
