//! Isolated clusters of particles that may collide within the step (Zhelezov & Fatkullin, Section 3.3).
//!
//! The paper refines a coarse mesh until a cell is separated (3.1) and collidable, or holds too few particles. Here the same
//! cells come out of one sort: particles in the order of their Morton keys, and a pass over neighbours with a stack, in which the nodes
//! of the quadtree close one after the other, from the leaves to the root. A node that is separated and collidable replaces
//! the clusters found below it, so the coarsest such cell wins, as in a descent. Cells that hold the same particles are one node,
//! represented by the coarsest of them, where (3.1) is easiest. Cost O(n log n) whatever the positions; depth at most [`DEPTH`]. Of many particles only
//! those are sorted that may be part of a node of interest.
//!
//! Most nodes cannot collide whatever their shape: nu < 0 needs more mass than a few light particles have
//! ([`Criterion::possible`]). Their moments are summed only when a node around them can, and then every particle once.
//!
//! The mesh is shifted from step to step (by a sequence that depends on the step's number alone), so that a cluster which
//! lies across a coarse border in one step doesn't in the next.

mod bound;
#[cfg(not(feature = "small"))]
mod buckets;
#[cfg(feature = "small")]
#[path = "no_buckets.rs"]
mod buckets;
#[cfg(not(feature = "small"))]
mod key_layout;
mod mesh;
mod moments;
mod order;
mod shared;
#[cfg(not(feature = "small"))]
mod sieve;
mod tree;

use super::collision::Criterion;
use super::theory::Group;
pub use super::weights::Charges;
use crate::build;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Ranks, Resources};
use crate::grid::Variable;
use crate::memory::Space;
use crate::real::Real;
use crate::sort::words as sort;
use buckets::{Bucket, Buckets, LOADS, ROW};
use mesh::Areas;
pub use mesh::Mesh;
pub(super) use order::particle;
pub(super) use shared::{Part, Shared, WORDS_OF_RANK, bits, number};
use tree::{Found, Partial, Stack, Tree};

/// Levels of the quadtree below the coarsest cell.
pub const DEPTH: u32 = 32;
/// A node for each level, and one for the root.
const STACK: usize = DEPTH as usize + 2;
/// Particles that a cell holds on average at the level where light cells are told from others.
const FEW: usize = 24;

/// The mesh that the search starts from, and the isolation it asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search<T> {
    /// eta of (3.1): a cell is separated if `Y / s^2 < eta`, s being its diagonal.
    pub separation: T,
    /// Cells of the coarse mesh in x and in y, at least 1.
    pub mesh: [u32; 2],
    /// The box `[low, high]` the coarse mesh covers, together with all particles; `None`: the particles' bounding box, twice as large again.
    pub domain: Option<[[T; 2]; 2]>,
    /// Shift the mesh from step to step; it is then twice as large as the box. Without, the mesh is where the paper has it.
    pub shifted: bool,
}

impl<T: Real> Default for Search<T> {
    /// eta = 0.1 and a 1 x 1 mesh as in the paper, shifted.
    fn default() -> Self {
        Self { separation: T::from_f64(0.1), mesh: [1, 1], domain: None, shifted: true }
    }
}

/// A cluster: a range of the sorted particles, and its moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cluster<T> {
    /// Where its particles begin in the sorted order.
    pub first: usize,
    /// How many particles it has, at least 2.
    pub count: usize,
    /// What its index depends on; with weights the mass is their sum, and `pairs` that of the masses over the square of the largest sensitivity. In a medium `pairs` is multiplied by the smallest G over that at the centre, so that the index has the gamma of the place (4.30).
    pub group: Group<T>,
    /// Its second moment Y of (2.20): `(1 / M) sum m |x - c|^2`.
    pub moment: T,
    /// Its centre of mass c.
    pub centre: [T; 2],
}

/// The search's part of the workspace.
#[derive(Debug)]
pub struct Scratch<'w, T> {
    /// Key in the high half if it was sorted by it, the particle in the low half.
    words: &'w mut [u64],
    /// What only many particles need.
    many: Buckets<'w>,
    stack: Stack<'w, T>,
    /// Levels that a particle shares with the one before it.
    shared: &'w mut [u8],
    found: Found<'w, T>,
}

impl<'w, T: Real> Scratch<'w, T> {
    /// Lays out the scratch for `n` particles.
    ///
    /// # Errors
    /// Those of [`Space::try_array`]; [`Error::TooLarge`]: more particles than 32 bits count.
    pub fn layout(space: &mut impl Space<'w>, n: usize) -> Result<Self> {
        u32::try_from(n).ok().filter(|&n| n < u32::MAX).ok_or(Error::TooLarge)?;
        let scratch = Self::parts(space, n);
        space.finish()?;
        Ok(scratch)
    }

    /// As [`Scratch::layout`], for no more than 32 bits count, as parts of a layout that is asked for errors at its end.
    pub(super) fn parts(space: &mut impl Space<'w>, n: usize) -> Self {
        let stack = if n > 0 { STACK } else { 0 };
        Self {
            words: space.array(n),
            many: Buckets::layout(space, if n > sort::FEW { n } else { 0 }),
            stack: Stack {
                nodes: space.array(stack),
                masses: space.array(stack),
                moments: space.array(stack),
                height: 0,
            },
            shared: space.array(n),
            found: Found { ranges: space.array(n / 2), values: space.array(n / 2), count: 0 },
        }
    }

    /// Lays out what is known of the particles of so many ranks, `all` of them together.
    pub(super) fn shared(space: &mut impl Space<'w>, all: usize, ranks: usize) -> Shared<'w, T> {
        Shared::layout(space, all, ranks, (LOADS, ROW))
    }

    /// The number of clusters of the last search.
    #[must_use]
    pub fn len(&self) -> usize {
        self.found.count
    }

    /// Whether the last search found none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.found.count == 0
    }

    /// Finds again so many clusters that an earlier search left in the memory.
    pub fn resume(&mut self, clusters: usize) {
        self.found.count = clusters;
    }

    /// Discards the clusters.
    pub fn clear(&mut self) {
        self.found.count = 0;
    }

    /// The clusters of the last search, in the order of the quadtree, their numbers in the criterion's units.
    pub fn clusters(&self) -> impl Iterator<Item = Cluster<T>> + '_ {
        self.found.ranges.iter().zip(self.found.values.iter()).take(self.found.count).map(
            |(&[first, count], &[mass, pairs, moment, x, y])| Cluster {
                first: first as usize,
                count: count as usize,
                group: Group { count: T::from_usize(count as usize), mass, pairs },
                moment,
                centre: [x, y],
            },
        )
    }

    /// The particles of a cluster.
    pub fn members(&self, first: usize, count: usize) -> impl Iterator<Item = usize> + '_ {
        self.words.iter().skip(first).take(count).map(|&word| particle(word))
    }

    /// The particles of a cluster as words with the index in the low half, to reorder.
    pub fn members_mut(&mut self, first: usize, count: usize) -> &mut [u64] {
        self.words.get_mut(first..first.saturating_add(count)).present_or(&mut [])
    }
}

/// What is searched.
#[derive(Clone, Copy, Debug)]
pub struct Particles<'a, T: Real> {
    /// Where they are.
    pub positions: &'a [[T; 2]],
    /// Their masses, or weights, as many.
    pub masses: &'a [T],
    /// What attracts, if it is not proportional to these. The criterion's constants are then those of the largest sensitivity.
    pub charges: Option<Charges<'a, T>>,
    /// The smallest mass, or less.
    pub smallest: T,
    /// The medium, if gamma depends on the place. The criterion's is then that of the smallest G.
    pub medium: Option<&'a Variable<'a, T>>,
}

/// Finds the clusters of particles that may collide; the result is in `scratch`.
///
/// `mesh` is that of the step for these particles' extent, in the criterion's unit of length. Deterministic: the result does not depend on the executor.
///
/// # Errors
/// The executor's.
pub fn find<T: Real>(
    search: &Search<T>,
    criterion: &Criterion<T>,
    mesh: &Mesh<T>,
    particles: Particles<'_, T>,
    resources: Resources<'_>,
    scratch: &mut Scratch<'_, T>,
) -> Result<()> {
    scratch.clear();
    scratch.stack.height = 0;
    let Particles { positions, masses, charges, medium, .. } = particles;
    let n = positions.len();
    if n < 2 {
        return Ok(());
    }
    let Scratch { words, many, shared, found, stack } = scratch;
    // The state's arrays may have shrunk since the scratch was laid out.
    let (words, shared) = (words.get_mut(..n).present()?, shared.get_mut(..n).present()?);
    let is_many = build::MANY && n > sort::FEW;
    if is_many {
        many.sort(mesh, criterion, particles, resources, (words, shared))?;
    }
    if !is_many {
        order::sort_small(mesh, positions, words, shared);
    }
    let bound = is_many.then(|| many.bound(mesh, particles.smallest * criterion.units.mass));
    let areas = Areas::new(mesh, search);
    let mut tree = Tree {
        areas,
        mesh,
        criterion,
        words,
        positions,
        masses,
        charges,
        medium,
        shared,
        bound: bound.as_ref(),
        found,
        seen: 0,
        partial: None,
    };
    if is_many {
        walk_buckets(&mut tree, stack, many);
    }
    if !is_many {
        walk(&mut tree, stack, 0, n);
    }
    Ok(())
}

/// As [`find`], for particles that are spread over ranks: `particles` are this rank's, `smallest` and `total` are those of all masses. All ranks find the same clusters; their words hold places in `known`.
///
/// # Errors
/// The executor's and the communicator's.
#[expect(clippy::too_many_arguments, reason = "as many parts, which have nothing else in common")]
pub(super) fn find_on_ranks<T: Real>(
    search: &Search<T>,
    criterion: &Criterion<T>,
    mesh: &Mesh<T>,
    (particles, total): (Particles<'_, T>, T),
    (ranks, part): (&Ranks<'_>, Part),
    known: &mut Shared<'_, T>,
    resources: Resources<'_>,
    scratch: &mut Scratch<'_, T>,
) -> Result<()> {
    scratch.clear();
    let (mut some, mut again) = (part.all > sort::FEW, false);
    while some {
        scratch.clear();
        scratch.stack.height = 0;
        let Scratch { words, many, shared, found, stack } = &mut *scratch;
        let (words, shared) = (words.get_mut(..part.all).present()?, shared.get_mut(..part.all).present()?);
        let to = (&mut *words, &mut *shared);
        if again {
            some = many.complete_on_ranks((ranks, part), known, (mesh, criterion), particles, resources, to)?;
        } else {
            many.sort_on_ranks((ranks, part), known, (mesh, criterion), (particles, total), resources, to)?;
        }
        if !some {
            break;
        }
        again = true;
        let bound = many.bound(mesh, particles.smallest * criterion.units.mass);
        let mut tree = Tree {
            areas: Areas::new(mesh, search),
            mesh,
            criterion,
            words,
            positions: known.positions,
            masses: known.masses,
            charges: None,
            medium: None,
            shared,
            bound: Some(&bound),
            found,
            seen: 0,
            partial: Some(Partial { buckets: &mut *known.buckets, missing: false }),
        };
        walk_buckets(&mut tree, stack, many);
        if tree.partial.is_none_or(|partial| !partial.missing) {
            return Ok(());
        }
    }
    known.take_all(ranks, part, &particles)?;
    let (positions, masses) = (known.positions.get(..part.all), known.masses.get(..part.all));
    let particles = Particles { positions: positions.present()?, masses: masses.present()?, ..particles };
    find(search, criterion, mesh, particles, resources, scratch)
}

/// Adds the particles of all buckets to the tree.
fn walk_buckets<T: Real>(tree: &mut Tree<'_, '_, T>, stack: &mut Stack<'_, T>, many: &Buckets<'_>) {
    for bucket in many.iter() {
        let Bucket { first, count, mass, pairs } = bucket;
        if let Some(pairs) = pairs {
            let clusters = tree.found.count;
            pairs.iter().for_each(|&k| tree.noted(first + k as usize));
            tree.leaf(stack, [first, count, clusters], T::from_f64(mass) * tree.criterion.units.mass);
        } else {
            walk(tree, stack, first, count);
        }
    }
}

/// Adds so many particles, which are all of some cell, to the tree: cell by cell of a level at which they hold few.
#[inline]
fn walk<T: Real>(tree: &mut Tree<'_, '_, T>, stack: &mut Stack<'_, T>, first: usize, count: usize) {
    let shared = tree.shared;
    let level = fine(shared.get(first..first + count).present_or(&[]));
    let (mut first, end) = (first, first + count);
    while first < end {
        // The particles of a cell of this level.
        let after = shared.get(first + 1..end).present_or(&[]);
        let count = 1 + after.iter().position(|&s| u32::from(s) < level).unwrap_or(after.len());
        let mass = tree.members(first, count).fold(T::ZERO, |sum, (_, m)| sum + m);
        if count > 2 && !tree.criterion.possible(3, mass) {
            // Too light for any cluster of more than two.
            let clusters = tree.found.count;
            tree.pairs(first, count);
            tree.leaf(stack, [first, count, clusters], mass);
        } else {
            for k in first..first + count {
                let clusters = tree.found.count;
                let mass = tree.members(k, 1).next().map_or(T::ZERO, |(_, m)| m);
                tree.leaf(stack, [k, 1, clusters], mass);
            }
        }
        first += count;
    }
}

/// The coarsest level whose cells hold few particles on average.
fn fine(shared: &[u8]) -> u32 {
    let mut parts = [0_u32; DEPTH as usize + 1];
    for &level in shared {
        if let Some(count) = parts.get_mut(usize::from(level)) {
            *count += 1;
        }
    }
    let (mut level, mut cells) = (0, 0);
    for &count in &parts {
        if cells * FEW > shared.len() {
            break;
        }
        cells += count as usize;
        level += 1;
    }
    level
}
