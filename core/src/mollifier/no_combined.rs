//! Without kernels other than the Newtonian one there are no combinations, and no number of one takes memory: this file stands for `combined.rs`.

use core::convert::Infallible;
use core::marker::PhantomData;

use super::distance::Distance;
use super::scaled::Scaled;
use super::series::Exact;
use super::{Mollifier, Quantity};
use crate::real::{DoubleWord, Real};

pub(super) const RICHARDSON: bool = false;

impl Mollifier {
    pub(crate) fn radii(self) -> u32 {
        1
    }

    #[allow(dead_code, reason = "what asks is left out too")]
    pub(crate) fn parts(self) -> impl Iterator<Item = (f64, f64)> {
        core::iter::once((1.0, 1.0))
    }

    pub(crate) fn part(self) -> Self {
        self
    }
}

/// There is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combined<T, const D: usize>(Infallible, PhantomData<T>);

/// There is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<'a, T, const D: usize>(Infallible, PhantomData<&'a T>);

impl<T: Real, const D: usize> Combined<T, D> {
    pub fn of(_: Mollifier) -> Option<Self> {
        None
    }

    pub fn series(&self) -> &Exact<T, D> {
        match self.0 {}
    }

    pub fn inside(&self, _: Distance<T>, _: Distance<T>) -> Parts<'_, T, D> {
        match self.0 {}
    }

    pub fn moment(&self, _: u32) -> DoubleWord<T> {
        match self.0 {}
    }
}

impl<T: Real, const D: usize> Parts<'_, T, D> {
    pub fn value(&self, _: Quantity) -> Scaled<T> {
        match self.0 {}
    }
}
