//! A register block of targets in lanes, its sums, and what all kernels share.

use super::BLOCK;
use crate::field::PairRadius;
use crate::real::Real;
use crate::simd::Isa;

/// The most vectors of targets in a register block.
pub(in crate::field) const WIDE: usize = 4;

/// The least and the largest coordinates of some points.
pub(in crate::field) type Bounds<T, const D: usize> = [[T; D]; 2];

/// Sources one after the other: positions and masses of equal length.
pub(in crate::field) type List<'a, T, const D: usize> = (&'a [[T; D]], &'a [T]);

/// A pass that sums gradients and Laplacians, as far as they are wanted.
pub(in crate::field) const GRADIENTS: u8 = 0;
/// A pass that sums potentials, and what [`super::Passes`] puts beside them.
pub(in crate::field) const POTENTIALS: u8 = 1;
/// A pass that sums a row of the second derivatives: the trace in the place of the Laplacian, and in that of the gradient the row of what is left without it.
pub(in crate::field) const HESSIANS: u8 = 2;

/// What is wanted of a pass.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::field) struct Want {
    pub potential: bool,
    pub gradient: bool,
    pub laplacian: bool,
    /// Of second derivatives: of which row. The gradient and the Laplacian are then what it is made of.
    pub row: Row,
}

/// A row of second derivatives, or none. (Not an `Option`: the compiler looks at the number ahead of the question whether there is one, which a checker of memory would report.)
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::field) struct Row(usize);

impl Row {
    pub const NONE: Self = Self(0);

    pub fn new(row: usize) -> Self {
        Self(row + 1)
    }

    #[inline(always)]
    pub fn get(self) -> Option<usize> {
        self.0.checked_sub(1)
    }

    #[inline(always)]
    pub fn is_some(self) -> bool {
        self.0 > 0
    }
}

/// One vector of targets: their coordinates and sums.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Group<V, const D: usize> {
    pub x: [V; D],
    /// The unit vector of a row of second derivatives; of no use to other passes.
    pub axis: [V; D],
    /// What is kept of the targets' core radii ([`kept`]), where a pair's radius depends on them.
    pub core: V,
    pub sums: Sums<V, D>,
}

/// Sums in the kernel's units.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Sums<V, const D: usize> {
    pub potential: V,
    pub gradient: [V; D],
    pub laplacian: V,
}

impl<V: Copy, const D: usize> Sums<V, D> {
    #[inline(always)]
    pub fn splat(value: V) -> Self {
        Self { potential: value, gradient: [value; D], laplacian: value }
    }
}

/// Sums of a vector of targets over the preceding blocks.
#[derive(Clone, Copy)]
pub(in crate::field) struct Total<V, const D: usize> {
    pub sums: Sums<V, D>,
    /// Low-order parts of `sums`, in compensated summation.
    low: Sums<V, D>,
}

impl<V: Copy, const D: usize> Total<V, D> {
    #[inline(always)]
    pub fn splat(value: V) -> Self {
        Self { sums: Sums::splat(value), low: Sums::splat(value) }
    }

    /// Adds a block's sums.
    #[inline(always)]
    pub fn add<T: Real, I: Isa<T, V = V>>(&mut self, isa: I, block: Sums<V, D>) {
        let Self { sums, .. } = self;
        sums.potential = isa.add(sums.potential, block.potential);
        for (sum, &term) in sums.gradient.iter_mut().zip(&block.gradient) {
            *sum = isa.add(*sum, term);
        }
        sums.laplacian = isa.add(sums.laplacian, block.laplacian);
    }

    /// The same in double-word arithmetic.
    #[inline(always)]
    pub fn add_compensated<T: Real, I: Isa<T, V = V>>(&mut self, isa: I, block: Sums<V, D>) {
        let Self { sums, low } = self;
        add_term(isa, [&mut sums.potential, &mut low.potential], block.potential);
        for ((sum, low), &term) in sums.gradient.iter_mut().zip(&mut low.gradient).zip(&block.gradient) {
            add_term(isa, [sum, low], term);
        }
        add_term(isa, [&mut sums.laplacian, &mut low.laplacian], block.laplacian);
    }
}

/// (sum, low) + term by Knuth's two-sum, then normalised.
#[inline(always)]
fn add_term<T: Real, I: Isa<T>>(isa: I, [sum, low]: [&mut I::V; 2], term: I::V) {
    let total = isa.add(*sum, term);
    let back = isa.sub(total, *sum);
    let error = isa.add(isa.sub(*sum, isa.sub(total, back)), isa.sub(term, back));
    let rest = isa.add(*low, error);
    *sum = isa.add(total, rest);
    *low = isa.sub(rest, isa.sub(*sum, total));
}

/// Indices, within a block, of sources that need the slow path.
#[derive(Debug)]
pub(in crate::field) struct Deferred {
    at: [u16; BLOCK],
    n: usize,
}

impl Deferred {
    /// None.
    #[inline(always)]
    pub fn new() -> Self {
        Self { at: [0; BLOCK], n: 0 }
    }

    #[inline(always)]
    pub fn push(&mut self, at: usize) {
        if let Some(slot) = self.at.get_mut(self.n) {
            *slot = at as u16;
            self.n += 1;
        }
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.n
    }

    /// The one of this number.
    #[inline(always)]
    pub fn at(&self, k: usize) -> usize {
        self.at.get(k).map_or(usize::MAX, |&at| usize::from(at))
    }

    /// Puts one that stays at this number, which is not above its own.
    #[inline(always)]
    pub fn keep(&mut self, k: usize, at: usize) {
        if let Some(slot) = self.at.get_mut(k) {
            *slot = at as u16;
        }
    }

    /// Drops all but the first `n`.
    #[inline(always)]
    pub fn truncate(&mut self, n: usize) {
        self.n = n;
    }

    /// Takes them all out.
    #[inline(always)]
    pub fn take(&mut self) -> impl Iterator<Item = usize> {
        let n = core::mem::take(&mut self.n);
        self.at.iter().take(n).map(|&at| usize::from(at))
    }
}

/// One bit for each of so many targets.
#[inline(always)]
pub(in crate::field) fn valid_lanes(targets: usize) -> u32 {
    if targets == 0 { 0 } else { u32::MAX >> (32 - targets.min(32) as u32) }
}

const RULES: [PairRadius; 4] = [PairRadius::Source, PairRadius::Maximum, PairRadius::Mean, PairRadius::RootMeanSquare];

/// What is kept of a core, which is a square, for [`cores`].
pub(in crate::field) fn kept<T: Real>(rule: PairRadius, core: T) -> T {
    match rule {
        PairRadius::Source | PairRadius::Maximum => core,
        PairRadius::Mean => T::HALF * core.sqrt(),
        PairRadius::RootMeanSquare => T::HALF * core,
    }
}

/// The cores of a source's pairs with each vector of targets. With more than one vector they are the source's: other rules are for passes of one ([`super::Pass`]).
#[inline(always)]
pub(in crate::field) fn cores<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    rule: PairRadius,
    core: T,
    groups: &[Group<I::V, D>; NB],
) -> [I::V; NB] {
    let core = isa.splat(core);
    let mut cores = [core; NB];
    if NB == 1 {
        // Weights instead of branches, of which the compiler would make a loop each.
        let mut weights = [isa.splat(T::ZERO); 4];
        for (weight, of) in weights.iter_mut().zip(RULES) {
            *weight = isa.splat(if of == rule { T::ONE } else { T::ZERO });
        }
        let [source, maximum, mean, square] = weights;
        for (to, group) in cores.iter_mut().zip(groups) {
            let sum = isa.add(core, group.core);
            let most = isa.select(isa.lt(core, group.core), group.core, core);
            let plain = isa.mul_add(source, core, isa.mul(maximum, most));
            *to = isa.mul_add(mean, isa.mul(sum, sum), isa.mul_add(square, sum, plain));
        }
    }
    cores
}

/// Numbers of core radii: of one source, or in the lanes of its pairs.
#[derive(Clone, Copy)]
pub(in crate::field) struct Core<C> {
    /// (delta / radius)^2.
    pub ratio_square: C,
    /// What a mass is multiplied by for the gradient and the density, and for the potential.
    pub factors: [C; 2],
    /// Added to S_D K, twice that in 2D.
    pub offset: C,
}

impl<T: Real> Core<T> {
    /// The same numbers in every lane of every vector.
    #[inline(always)]
    pub fn splat<I: Isa<T>, const NB: usize>(&self, isa: I) -> [Core<I::V>; NB] {
        let [gradient, potential] = self.factors;
        [Core {
            ratio_square: isa.splat(self.ratio_square),
            factors: [isa.splat(gradient), isa.splat(potential)],
            offset: isa.splat(self.offset),
        }; NB]
    }
}

/// Source minus target, and its square, for every vector.
#[inline(always)]
pub(in crate::field) fn distances<T: Real, I: Isa<T>, const D: usize, const NB: usize>(
    isa: I,
    source: &[T; D],
    groups: &[Group<I::V, D>; NB],
) -> ([[I::V; D]; NB], [I::V; NB]) {
    let zero = isa.splat(T::ZERO);
    let mut at = [zero; D];
    at.iter_mut().zip(source).for_each(|(at, &x)| *at = isa.splat(x));
    let (mut d, mut r2) = ([[zero; D]; NB], [zero; NB]);
    for ((d, r2), group) in d.iter_mut().zip(&mut r2).zip(groups) {
        for (k, ((d, &at), &x)) in d.iter_mut().zip(&at).zip(&group.x).enumerate() {
            *d = isa.sub(at, x);
            *r2 = if k == 0 { isa.mul(*d, *d) } else { isa.mul_add(*d, *d, *r2) };
        }
    }
    (d, r2)
}

/// How far squares are above bounds of their own: below zero where they are not.
#[inline(always)]
pub(in crate::field) fn margins<T: Real, I: Isa<T>, const NB: usize>(
    isa: I,
    r2: &[I::V; NB],
    bounds: &[I::V; NB],
) -> [I::V; NB] {
    let mut margins = *r2;
    for (margin, &bound) in margins.iter_mut().zip(bounds) {
        *margin = isa.sub(*margin, bound);
    }
    margins
}

/// Differences, or if `VECTOR`, in space, their vector products with a source's strength.
#[inline(always)]
pub(in crate::field) fn arms<T: Real, I: Isa<T>, const D: usize, const NB: usize, const VECTOR: bool>(
    isa: I,
    d: &[[I::V; D]; NB],
    strength: &[T; D],
) -> [[I::V; D]; NB] {
    let mut arms = *d;
    if VECTOR && let Some(&[a, b, c]) = strength.first_chunk() {
        let (a, b, c) = (isa.splat(a), isa.splat(b), isa.splat(c));
        for arm in &mut arms {
            if let [x, y, z] = arm.as_mut_slice() {
                let (u, v, w) = (*x, *y, *z);
                *x = isa.neg_mul_add(w, b, isa.mul(v, c));
                *y = isa.neg_mul_add(u, c, isa.mul(w, a));
                *z = isa.neg_mul_add(v, a, isa.mul(u, b));
            }
        }
    }
    arms
}

impl<V: Copy, const D: usize> Group<V, D> {
    /// Adds g d to the gradient.
    #[inline(always)]
    pub fn add_gradient<T: Real, I: Isa<T, V = V>, const P: u8>(&mut self, isa: I, g: V, d: &[V; D]) {
        if P == HESSIANS {
            self.add_row(isa, isa.mul(isa.splat(T::ZERO - T::from_usize(D)), g), d);
            return;
        }
        for (sum, &d) in self.sums.gradient.iter_mut().zip(d) {
            *sum = isa.mul_add(g, d, *sum);
        }
    }

    /// Adds c times a row of d d^T / |d|^2 - I / D; of zero for d = 0. The second derivatives of a radial function with gradient factor g and Laplacian L are L I / D and, without
    /// a trace, this with c = L - D g.
    #[inline(always)]
    fn add_row<T: Real, I: Isa<T, V = V>>(&mut self, isa: I, c: V, d: &[V; D]) {
        let (zero, least) = (isa.splat(T::ZERO), isa.splat(T::MIN_POSITIVE));
        let (mut r2, mut along) = (zero, zero);
        for (&d, &axis) in d.iter().zip(&self.axis) {
            (r2, along) = (isa.mul_add(d, d, r2), isa.mul_add(axis, d, along));
        }
        let inverse = isa.div(isa.splat(T::ONE), isa.select(isa.lt(r2, least), least, r2));
        let (along, part) =
            (isa.mul(along, inverse), isa.mul(r2, isa.mul(inverse, isa.splat(T::ONE / T::from_usize(D)))));
        for ((sum, &d), &axis) in self.sums.gradient.iter_mut().zip(d).zip(&self.axis) {
            *sum = isa.mul_add(c, isa.neg_mul_add(axis, part, isa.mul(along, d)), *sum);
        }
    }

    /// Adds m k to the potential.
    #[inline(always)]
    pub fn add_potential<T: Real, I: Isa<T, V = V>>(&mut self, isa: I, m: V, k: V) {
        self.sums.potential = isa.mul_add(m, k, self.sums.potential);
    }

    /// Adds m b to the Laplacian; d is the pair's difference.
    #[inline(always)]
    pub fn add_laplacian<T: Real, I: Isa<T, V = V>, const P: u8>(&mut self, isa: I, m: V, b: V, d: &[V; D]) {
        self.sums.laplacian = isa.mul_add(m, b, self.sums.laplacian);
        if P == HESSIANS {
            self.add_row(isa, isa.mul(m, b), d);
        }
    }
}
