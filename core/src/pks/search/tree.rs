//! The walk through the quadtree's nodes, which close one after the other from the leaves to the root.

use super::Charges;
use super::DEPTH;
use super::bound::Bound;
use super::mesh::{Areas, Mesh};
use super::moments::Moments;
use super::order::{LEVEL, particle};
use crate::build;
use crate::checked::Present;
use crate::grid::Variable;
use crate::pks::collision::{Criterion, Units};
use crate::pks::theory::Group;
use crate::real::Real;

/// Particles whose moments are summed together: few roundings, and they are in the nearest cache for the second pass.
const TOGETHER: usize = 64;
/// Particles that are read before they are looked at pair by pair; they lie on the stack.
const AHEAD: usize = if build::TILES { 64 } else { 2 };

/// A node of the quadtree that is still open.
#[derive(Clone, Copy, Default)]
pub struct Node<T> {
    /// The level of the cell that holds all its particles and at which they part.
    level: u32,
    first: u32,
    /// Clusters found before it.
    clusters: u32,
    /// Its moments are those of its particles before this one; none yet if it is the first.
    known: u32,
    mass: T,
}

/// The open nodes, from the root on.
#[derive(Debug)]
pub struct Stack<'w, T> {
    /// Level, first, clusters, known.
    pub nodes: &'w mut [[u32; 4]],
    pub masses: &'w mut [T],
    /// Stored separately, because few are read.
    pub moments: &'w mut [[T; 6]],
    pub height: usize,
}

/// The clusters found.
#[derive(Debug)]
pub struct Found<'w, T> {
    /// Where each begins in the sorted order, and how many it has.
    pub ranges: &'w mut [[u32; 2]],
    /// mass, pairs, moment, centre of each.
    pub values: &'w mut [[T; 5]],
    pub count: usize,
}

impl<T: Real> Stack<'_, T> {
    #[inline]
    fn node(&self, at: usize) -> Option<Node<T>> {
        let (&[level, first, clusters, known], &mass) = (self.nodes.get(at)?, self.masses.get(at)?);
        Some(Node { level, first, clusters, known, mass })
    }

    #[inline]
    fn set(&mut self, at: usize, node: &Node<T>) {
        let &Node { level, first, clusters, known, mass } = node;
        if let (Some(words), Some(slot)) = (self.nodes.get_mut(at), self.masses.get_mut(at)) {
            (*words, *slot) = ([level, first, clusters, known], mass);
        }
    }

    #[inline]
    fn moments(&self, at: usize) -> Moments<T> {
        self.moments.get(at).map_or(Moments::default(), |&numbers| numbers.into())
    }

    #[inline]
    fn set_moments(&mut self, at: usize, moments: Moments<T>) {
        if let Some(slot) = self.moments.get_mut(at) {
            *slot = moments.into();
        }
    }
}

/// What closing a node needs.
pub struct Tree<'a, 'w, T: Real> {
    pub mesh: &'a Mesh<T>,
    /// eta s^2 of the cells of each level.
    pub areas: Areas<T>,
    pub criterion: &'a Criterion<T>,
    pub words: &'a [u64],
    pub positions: &'a [[T; 2]],
    pub masses: &'a [T],
    pub charges: Option<Charges<'a, T>>,
    pub medium: Option<&'a Variable<'a, T>>,
    /// Levels that each particle shares with the one before it, where anything is asked of it: not within a leaf without pairs.
    pub shared: &'a [u8],
    /// Of what spans whole buckets, if there are any.
    pub bound: Option<&'a Bound<'a, T>>,
    pub found: &'a mut Found<'w, T>,
    /// Particles that lie before the end of the node that closes.
    pub seen: u32,
    /// If not all particles are known: which are.
    pub partial: Option<Partial<'a>>,
}

/// Which buckets' particles are all known. Of the others only pairs are.
pub struct Partial<'a> {
    /// [`KNOWN`], or [`ASKED`] if the moments of a node were asked for that holds others of the bucket, too; else 0.
    pub buckets: &'a mut [u8],
    /// Some are asked for: the walk has to be repeated with these.
    pub missing: bool,
}

/// All particles of the bucket are known.
pub const KNOWN: u8 = 1;
/// They should be.
pub const ASKED: u8 = 2;

impl<T: Real> Tree<'_, '_, T> {
    /// Positions and masses of `count` particles in the sorted order, in the criterion's units.
    #[inline]
    pub fn members(&self, first: usize, count: usize) -> impl Iterator<Item = ([T; 2], T)> + Clone + use<'_, T> {
        let words = self.words.get(first..first.saturating_add(count)).present_or(&[]);
        let (positions, masses, Units { mass, length, .. }) = (self.positions, self.masses, self.criterion.units);
        words.iter().map(move |&word| {
            let i = particle(word);
            let [x, y] = positions.get(i).copied().present_or_default();
            ([x * length, y * length], masses.get(i).copied().present_or_default() * mass)
        })
    }

    /// The level that a particle shares with the one before it.
    #[inline]
    fn level(&self, k: usize) -> u32 {
        self.shared.get(k).map_or(0, |&level| u32::from(level))
    }

    /// Tests the nodes of two particles in a cell of more than two.
    #[inline]
    pub fn pairs(&mut self, first: usize, count: usize) {
        // One that is nearer to the next than to the one before, and the next to it than to the one after.
        let (mut before, mut here) = (self.level(first), self.level(first + 1));
        let mut from = 0;
        while from + 1 < count {
            // Read in a loop that does nothing else, so that many scattered reads are under way at once.
            let mut near = [([T::ZERO; 2], T::ZERO); AHEAD];
            if build::TILES {
                let members = self.members(first + from, AHEAD.min(count - from));
                near.iter_mut().zip(members).for_each(|(to, member)| *to = member);
            }
            for (k, pair) in (first + from..first + count - 1).zip(near.windows(2)) {
                let after = self.level(k + 2);
                if here > before && here > after {
                    let moments = if build::TILES { Moments::of(pair.iter().copied()) } else { self.moments(k, 2) };
                    self.pair(k, [before, here, after], &moments);
                }
                (before, here) = (here, after);
            }
            from += AHEAD - 1;
        }
    }

    /// Tests the node of the two particles from this one on, which share more levels with one another than with those around.
    #[inline]
    pub fn noted(&mut self, k: usize) {
        self.pair(k, [self.level(k), self.level(k + 1), self.level(k + 2)], &self.moments(k, 2));
    }

    #[inline]
    fn pair(&mut self, k: usize, [before, here, after]: [u32; 3], moments: &Moments<T>) {
        if here >= self.mesh.coarsest {
            let node = Node { level: here, first: k as u32, clusters: self.found.count as u32, ..Node::default() };
            self.test(&node, 2, moments, Some(before.max(after)));
        }
    }

    /// The moments of a few particles in the sorted order.
    fn moments(&self, first: usize, count: usize) -> Moments<T> {
        Moments::of(self.members(first, count))
    }

    /// Adds the particles of a cell none of whose nodes is of interest: one, or too light ones. Given are the first, how many they are, and
    /// the clusters found before them.
    #[inline]
    pub fn leaf(&mut self, stack: &mut Stack<'_, T>, [first, count, clusters]: [usize; 3], mass: T) {
        let end = first + count;
        self.seen = end as u32;
        let node = Node { level: DEPTH, first: first as u32, clusters: clusters as u32, known: first as u32, mass };
        self.close(stack, node, self.shared.get(end).map(|&level| u32::from(level)));
    }

    /// Adds the finished node to the open ones, closing those that part deeper than `level` (all, at the end).
    #[inline]
    fn close(&mut self, stack: &mut Stack<'_, T>, leaf: Node<T>, level: Option<u32>) {
        let mut finished = leaf;
        // Whose moments, if there are any, are still where the node was.
        let mut from = stack.height;
        while let Some(at) = stack.height.checked_sub(1) {
            let Some(mut top) = stack.node(at) else { return };
            if level.is_some_and(|level| top.level < level) {
                break;
            }
            top.mass += finished.mass;
            if finished.known > finished.first && !self.is_beyond(&top, false) {
                let mut moments = stack.moments(at);
                self.complete(&mut top, &mut moments, finished.first);
                stack.set_moments(at, moments.with(&stack.moments(from)));
                top.known = finished.known;
            }
            if level == Some(top.level) {
                stack.set(at, &top);
                return;
            }
            finished = top;
            from = at;
            stack.height = at;
            // Its largest cell is one level below where the next particle, or the node around it, parts from it.
            let around = at.checked_sub(1).and_then(|top| stack.nodes.get(top)).map(|&[level, ..]| level);
            let parent = match (around, level) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
            self.finish(stack, at, &mut finished, parent);
        }
        if let Some(level) = level {
            // Its moments are here already: `from` is this place, or there are none.
            stack.set(stack.height, &Node { level, ..finished });
            stack.height += 1;
        }
    }

    /// Tests a node of at least two particles that is complete, whose moments are at this place; `parent` is the level of the
    /// cell around its largest cell.
    #[inline]
    fn finish(&mut self, stack: &mut Stack<'_, T>, at: usize, node: &mut Node<T>, parent: Option<u32>) {
        let count = self.seen - node.first;
        if node.level < self.mesh.coarsest || !self.criterion.possible(count, node.mass) {
            return;
        }
        if build::MANY
            && let Some(bound) = self.bound
            && let Some(spread) = bound.spread(node.first, self.seen)
            && (!self.separated(spread, node.mass, parent)
                || self.criterion.excludes(count, node.mass, spread / node.mass))
        {
            return;
        }
        if self.is_beyond(node, true) {
            return;
        }
        let mut moments = stack.moments(at);
        self.complete(node, &mut moments, self.seen);
        stack.set_moments(at, moments);
        self.test(node, count, &moments, parent);
    }

    /// Whether not all particles of the node, up to now, are known; then asks for them, or not.
    #[inline]
    fn is_beyond(&mut self, node: &Node<T>, ask: bool) -> bool {
        if !build::RANKS || node.level >= LEVEL {
            return false;
        }
        let (Some(partial), Some(bound)) = (&mut self.partial, self.bound) else { return false };
        let from = bound.starts.partition_point(|&start| start < node.first);
        let buckets = bound.starts.partition_point(|&start| start < self.seen).saturating_sub(from);
        let mut beyond = false;
        for bucket in partial.buckets.iter_mut().skip(from).take(buckets).filter(|bucket| **bucket != KNOWN) {
            beyond = true;
            if ask {
                (*bucket, partial.missing) = (ASKED, true);
            }
        }
        beyond
    }

    /// Y / s^2 < eta (3.1) for the node's largest cell.
    #[inline]
    fn separated(&self, spread: T, mass: T, parent: Option<u32>) -> bool {
        let level = parent.map_or(0, |p| p + 1).max(self.mesh.coarsest);
        self.areas.of(level).is_some_and(|area| spread < area * mass)
    }

    /// Notes a node that is separated and collidable, in the place of the clusters found in it.
    #[inline]
    fn test(&mut self, node: &Node<T>, count: u32, moments: &Moments<T>, parent: Option<u32>) {
        let Moments { group, spread, centre } = moments;
        if !self.separated(*spread, group.mass, parent) {
            return;
        }
        let moment = *spread / group.mass;
        let weakened = |pairs: T| match self.medium {
            Some(medium) if build::MESHES => {
                let at = centre.map(|x| x / self.criterion.units.length);
                pairs * (medium.least_diffusivity() / medium.diffusivity_at(at)).min(T::ONE)
            }
            _ => pairs,
        };
        let mut group = Group { pairs: weakened(group.pairs), ..*group };
        if !self.criterion.collidable(&group, moment) {
            return;
        }
        if build::WEIGHTS
            && let Some(charges) = self.charges
        {
            let words = self.words.iter().skip(node.first as usize).take(count as usize);
            group.pairs = weakened(charges.pairs(words.map(|&word| particle(word)), self.criterion.units.mass));
            if !self.criterion.collidable(&group, moment) {
                return;
            }
        }
        let at = node.clusters as usize;
        let Found { ranges, values, count: found } = &mut *self.found;
        if let (Some(range), Some(value)) = (ranges.get_mut(at), values.get_mut(at)) {
            *range = [node.first, count];
            *value = [group.mass, group.pairs, moment, centre[0], centre[1]];
            *found = at + 1;
        }
    }

    /// The moments of many particles in the sorted order: of halves, so that n particles cost log n roundings. At most 26 calls deep.
    fn sum(&self, first: usize, count: usize) -> Moments<T> {
        if count <= TOGETHER {
            return self.moments(first, count);
        }
        let half = count.div_ceil(2).div_ceil(TOGETHER) * TOGETHER;
        self.sum(first, half).with(&self.sum(first + half, count - half))
    }

    /// Adds the particles before `end` to the node's moments.
    #[inline]
    fn complete(&self, node: &mut Node<T>, moments: &mut Moments<T>, end: u32) {
        if node.known >= end {
            return;
        }
        let sum = self.sum(node.known as usize, (end - node.known) as usize);
        *moments = if node.known > node.first { moments.with(&sum) } else { sum };
        node.known = end;
    }
}
