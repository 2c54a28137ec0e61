//! Isolated clusters of particles that may collide within the step (Zhelezov & Fatkullin, Section 3.3).
//!
//! The paper refines a coarse mesh until a cell is separated (3.1) and collidable, or holds too few particles. Here the same
//! cells come out of one sort: particles in the order of their Morton keys, and a pass over neighbours with a stack, in which the nodes
//! of the quadtree close one after the other, from the leaves to the root. A node that is separated and collidable replaces
//! the clusters found below it, so the coarsest such cell wins, as in a descent. Cells that hold the same particles are one node,
//! represented by the coarsest of them, where (3.1) is easiest. Cost O(n log n) whatever the positions, no pairwise work; depth at
//! most [`DEPTH`].
//!
//! Most nodes cannot collide whatever their shape: nu < 0 needs more mass than a few light particles have
//! ([`Criterion::possible`]). Their moments are summed only when a node around them can, and then every particle once.
//!
//! The mesh is shifted from step to step (by a sequence that depends on the step's number alone), so that a cluster which
//! lies across a coarse border in one step doesn't in the next.

use super::collision::Criterion;
use super::sort;
use super::theory::Group;
use crate::error::{Error, Result};
use crate::real::Real;
use crate::space::Space;

/// Levels of the quadtree below the coarsest cell.
pub const DEPTH: u32 = 32;
/// Levels that the first sort resolves.
const FIRST: u32 = 16;
/// A node for each level, and one for the root.
const STACK: usize = DEPTH as usize + 2;
/// Cells that particles are first put into, by the highest bits of their keys, so that what follows reads and writes near by.
const BUCKETS: usize = 1 << 12;
/// Particles that a cell holds on average at the level where light cells are told from others.
const FEW: usize = 24;
/// Particles whose moments are summed together: few roundings, and they are in the nearest cache for the second pass.
const TOGETHER: usize = 64;
/// Particles that are read before they are looked at pair by pair; they lie on the stack.
const AHEAD: usize = if cfg!(feature = "small") { 2 } else { 64 };

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
    /// What its index depends on.
    pub group: Group<T>,
    /// Its second moment Y of (2.20): `(1 / M) sum m |x - c|^2`.
    pub moment: T,
    /// Its centre of mass c.
    pub centre: [T; 2],
}

/// The search's part of the workspace.
#[derive(Debug)]
pub struct Scratch<'w, T> {
    /// Morton key in the high half; in the low half the particle's place among the [`Sorted`], for members of clusters the particle.
    words: &'w mut [u64],
    many: [Many<'w>; MANY],
    /// The quadtree's open nodes: their numbers, masses, and moments.
    nodes: &'w mut [[u32; 4]],
    weights: &'w mut [T],
    moments: &'w mut [[T; 6]],
    /// Levels that a particle shares with the one before it.
    shared: &'w mut [u8],
    ranges: &'w mut [[u32; 2]],
    /// mass, pairs, moment, centre of each cluster.
    values: &'w mut [[T; 5]],
    found: usize,
}

/// Whether there may be many particles.
const MANY: usize = if cfg!(feature = "small") { 0 } else { 1 };

/// What many particles need; few are sorted in place.
#[derive(Debug)]
struct Many<'w> {
    spare: &'w mut [u64],
    /// The particle at each place.
    particles: &'w mut [u32],
    buckets: &'w mut [u32],
    /// Counts of the sort within a bucket.
    counts: &'w mut [u32],
}

impl<'w, T: Real> Scratch<'w, T> {
    /// Lays out the scratch for `n` particles.
    ///
    /// # Errors
    /// Those of [`Space::array`]; [`Error::TooLarge`]: more particles than 32 bits count.
    pub fn lay(space: &mut impl Space<'w>, n: usize) -> Result<Self> {
        u32::try_from(n).ok().filter(|&n| n < u32::MAX).ok_or(Error::TooLarge)?;
        let scratch = Self::parts(space, n);
        space.finish()?;
        Ok(scratch)
    }

    /// As [`Scratch::lay`], for no more than 32 bits count, as parts of a layout that is asked for errors at its end.
    pub(super) fn parts(space: &mut impl Space<'w>, n: usize) -> Self {
        let many = n > sort::FEW;
        let stack = if n > 0 { STACK } else { 0 };
        Self {
            words: space.part(n),
            many: core::array::from_fn(|_| Many {
                spare: if many { space.part(n) } else { &mut [] },
                particles: if many { space.part(n) } else { &mut [] },
                buckets: if many { space.part(BUCKETS) } else { &mut [] },
                counts: if many { space.part(sort::BUCKETS) } else { &mut [] },
            }),
            nodes: space.part(stack),
            weights: space.part(stack),
            moments: space.part(stack),
            shared: space.part(n),
            ranges: space.part(n / 2),
            values: space.part(n / 2),
            found: 0,
        }
    }

    /// The number of clusters of the last search.
    #[must_use]
    pub fn len(&self) -> usize {
        self.found
    }

    /// Whether the last search found none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.found == 0
    }

    /// Finds again so many clusters that an earlier search left in the memory.
    pub fn resume(&mut self, clusters: usize) {
        self.found = clusters;
    }

    /// Forgets the clusters.
    pub fn clear(&mut self) {
        self.found = 0;
    }

    /// The clusters of the last search, in the order of the quadtree.
    pub fn clusters(&self) -> impl Iterator<Item = Cluster<T>> + '_ {
        self.ranges.iter().zip(self.values.iter()).take(self.found).map(
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
        self.words.iter().skip(first).take(count).map(|&word| (word & 0xFFFF_FFFF) as usize)
    }

    /// The particles of a cluster as words with the index in the low half, to reorder.
    pub fn members_mut(&mut self, first: usize, count: usize) -> &mut [u64] {
        self.words.get_mut(first..first.saturating_add(count)).unwrap_or(&mut [])
    }
}

/// The particles, those of a coarse cell together: room for as many as there are, which the search writes over.
#[derive(Debug)]
pub struct Sorted<'s, T> {
    /// Positions.
    pub positions: &'s mut [[T; 2]],
    /// Masses.
    pub masses: &'s mut [T],
}

/// Moments of the particles of a node.
#[derive(Clone, Copy, Default)]
struct Moments<T> {
    group: Group<T>,
    centre: [T; 2],
    /// sum m |x - c|^2
    spread: T,
}

impl<T: Real> Moments<T> {
    /// The moments of a few particles: differences from one of them, so a tight cluster far from the origin loses nothing.
    #[inline]
    fn of(members: impl Iterator<Item = ([T; 2], T)> + Clone) -> Self {
        let Some((start, _)) = members.clone().next() else { return Self::default() };
        let away = |x: [T; 2]| [x[0] - start[0], x[1] - start[1]];
        let (mut group, mut first) = (Group::default(), [T::ZERO; 2]);
        for (x, mass) in members.clone() {
            let [dx, dy] = away(x);
            first = [first[0] + mass * dx, first[1] + mass * dy];
            group = group.with(Group { count: T::ONE, mass, pairs: T::ZERO });
        }
        let centre = [first[0] / group.mass, first[1] / group.mass];
        let spread = members.fold(T::ZERO, |sum, (x, mass)| {
            let [dx, dy] = away(x);
            let [dx, dy] = [dx - centre[0], dy - centre[1]];
            sum + mass * (dx * dx + dy * dy)
        });
        Self { group, centre: [start[0] + centre[0], start[1] + centre[1]], spread }
    }

    /// The moments of the union: only sums of positive terms.
    #[inline]
    fn with(&self, other: &Self) -> Self {
        let group = self.group.with(other.group);
        let [dx, dy] = [other.centre[0] - self.centre[0], other.centre[1] - self.centre[1]];
        let share = other.group.mass / group.mass;
        Self {
            group,
            centre: [self.centre[0] + dx * share, self.centre[1] + dy * share],
            spread: self.spread + other.spread + (dx * dx + dy * dy) * (self.group.mass * share),
        }
    }
}

impl<T: Real> From<[T; 6]> for Moments<T> {
    fn from([count, mass, pairs, x, y, spread]: [T; 6]) -> Self {
        Self { group: Group { count, mass, pairs }, centre: [x, y], spread }
    }
}

impl<T: Real> From<Moments<T>> for [T; 6] {
    fn from(Moments { group: Group { count, mass, pairs }, centre: [x, y], spread }: Moments<T>) -> Self {
        [count, mass, pairs, x, y, spread]
    }
}

/// A node of the quadtree that is still open.
#[derive(Clone, Copy, Default)]
struct Node<T> {
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
struct Stack<'s, T> {
    /// Level, first, clusters, known.
    nodes: &'s mut [[u32; 4]],
    masses: &'s mut [T],
    /// Apart, as few are ever looked at.
    moments: &'s mut [[T; 6]],
    height: usize,
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

/// The mesh of one step.
struct Mesh<T> {
    origin: [T; 2],
    side: T,
    /// Fixed-point coordinates for one length unit: 2^32 / side.
    scale: T,
    /// Cells coarser than this level are not cells of the coarse mesh.
    coarsest: u32,
}

impl<T: Real> Mesh<T> {
    #[cfg_attr(feature = "small", inline(never))]
    fn new(search: &Search<T>, positions: &[[T; 2]], step: u64) -> Self {
        let first = positions.first().copied().unwrap_or_default();
        let (mut low, mut high) = (first, first);
        let mut include = |x: &[T; 2]| {
            for ((low, high), &x) in low.iter_mut().zip(&mut high).zip(x) {
                *low = if x < *low { x } else { *low };
                *high = if x > *high { x } else { *high };
            }
        };
        positions.iter().for_each(&mut include);
        if let Some(corners) = &search.domain {
            corners.iter().for_each(&mut include);
        }
        let [nx, ny] = search.mesh;
        let (nx, ny) = (nx.max(1), ny.max(1));
        let extent = [high[0] - low[0], high[1] - low[1]];
        let cell = (extent[0] / T::from_usize(nx as usize)).max(extent[1] / T::from_usize(ny as usize));
        // The bounding box of a few particles is no domain: seen from it nothing is separated.
        let cell = if search.domain.is_none() { T::TWO * cell } else { cell };
        let cell = if cell > T::ZERO { cell } else { T::ONE };
        let levels = u32::BITS - nx.max(ny).saturating_sub(1).leading_zeros();
        let cells = T::ONE.ldexp(levels as i32);
        let (side, free) = if search.shifted {
            // R2 sequence (Roberts): fractions of step times the powers of the plastic number's inverse.
            let fraction = |multiplier: u64| {
                // 53 bits; the scaling is exact.
                T::from_f64((step.wrapping_mul(multiplier) >> 11) as f64).ldexp(-53)
            };
            // 0.75487766624669276, 0.56984029099805327 in units of 2^-64.
            (T::TWO * cell * cells, [fraction(0xC13F_A9A9_02A6_328F), fraction(0x91E1_0DA5_C79E_7B1D)])
        } else {
            (cell * cells, [T::HALF; 2])
        };
        let corner = |low: T, extent: T, free: T| low - free * (side - extent).max(T::ZERO);
        let origin = [corner(low[0], extent[0], free[0]), corner(low[1], extent[1], free[1])];
        Self { origin, side, scale: T::ONE.ldexp(32) / side, coarsest: levels }
    }

    /// The cell coordinates at the finest level.
    #[inline]
    fn cell(&self, x: &[T; 2]) -> [u32; 2] {
        // Conversions saturate.
        let at = |x: T, origin: T| ((x - origin) * self.scale).to_u32();
        [at(x[0], self.origin[0]), at(x[1], self.origin[1])]
    }
}

impl<T: Real> Mesh<T> {
    /// The key of the first sixteen levels in the high half, `i` in the low half.
    #[cfg_attr(feature = "small", inline(never))]
    #[cfg_attr(not(feature = "small"), inline)]
    fn word(&self, x: &[T; 2], i: usize) -> u64 {
        let [cx, cy] = self.cell(x);
        u64::from(interleave(cx >> 16, cy >> 16)) << 32 | i as u64
    }
}

/// eta s^2 for the cells of each level, s being the diagonal: a table, or where stacks are short the first one, from which a power of
/// two leads to the others.
struct Areas<T>([T; if cfg!(feature = "small") { 1 } else { DEPTH as usize + 1 }]);

impl<T: Real> Areas<T> {
    fn new(mesh: &Mesh<T>, search: &Search<T>) -> Self {
        let mut area = search.separation * (T::TWO * mesh.side * mesh.side);
        Self(core::array::from_fn(|_| {
            let quarter = area * T::from_f64(0.25);
            core::mem::replace(&mut area, quarter)
        }))
    }

    /// None beyond the finest.
    #[inline]
    fn of(&self, level: u32) -> Option<T> {
        if cfg!(not(feature = "small")) {
            return self.0.get(level as usize).copied();
        }
        let [area, ..] = self.0;
        (level <= DEPTH).then(|| area.ldexp(-2 * level as i32))
    }
}

/// Interleaves two 16-bit numbers.
#[inline]
fn interleave(x: u32, y: u32) -> u32 {
    let spread = |v: u32| {
        let v = (v | v << 8) & 0x00FF_00FF;
        let v = (v | v << 4) & 0x0F0F_0F0F;
        let v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    spread(x) | spread(y) << 1
}

/// Finds the clusters of `positions` and `masses` (equally long, masses positive) that may collide; the result is in `scratch`.
///
/// `step` chooses the mesh's shift. Deterministic: it depends on positions, masses and the arguments alone. `sorted` is for the
/// search alone and garbage afterwards.
#[cfg_attr(feature = "small", inline(never))]
pub fn find<T: Real>(
    search: &Search<T>,
    criterion: &Criterion<T>,
    step: u64,
    positions: &[[T; 2]],
    masses: &[T],
    sorted: Sorted<'_, T>,
    scratch: &mut Scratch<'_, T>,
) {
    scratch.found = 0;
    if positions.len() < 2 {
        return;
    }
    let mesh = Mesh::new(search, positions, step);
    let n = positions.len();
    // Few particles are near one another as they are.
    let gathered = cfg!(not(feature = "small")) && n > sort::FEW;
    let Sorted { positions: places, masses: weights } = sorted;
    let (Some(places), Some(weights)) = (places.get_mut(..n), weights.get_mut(..n)) else { return };
    let (places, weights) = if gathered {
        gather(&mesh, positions, masses, places, weights, scratch);
        (&*places, &*weights)
    } else {
        for (i, (word, x)) in scratch.words.iter_mut().zip(positions).enumerate() {
            *word = mesh.word(x, i);
        }
        (positions, masses)
    };
    order(&mesh, places, scratch);
    let Scratch { words, many, shared, ranges, values, found, nodes, weights: masses_of_nodes, moments } = scratch;
    let Some(words) = words.get_mut(..n) else { return };
    let shared = shared.get(..n).unwrap_or(&[]);
    let mut tree = Tree {
        areas: Areas::new(&mesh, search),
        mesh: &mesh,
        criterion,
        words,
        places,
        weights,
        ranges,
        values,
        found: 0,
        seen: 0,
    };
    let mut stack = Stack { nodes, masses: masses_of_nodes, moments, height: 0 };
    let level = fine(shared);
    let mut first = 0;
    while first < n {
        // The particles of a cell of this level.
        let after = shared.get(first + 1..).unwrap_or(&[]);
        let count = 1 + after.iter().position(|&s| u32::from(s) < level).unwrap_or(after.len());
        let mass = tree.members(first, count).fold(T::ZERO, |sum, (_, m)| sum + m);
        if count > 2 && !criterion.possible(3, mass) {
            // Too light for any cluster of more than two.
            let clusters = tree.found;
            tree.pairs(shared, first, count);
            tree.leaf(&mut stack, [first, count, clusters], mass, shared);
        } else {
            for k in first..first + count {
                let clusters = tree.found;
                let mass = tree.members(k, 1).next().map_or(T::ZERO, |(_, m)| m);
                tree.leaf(&mut stack, [k, 1, clusters], mass, shared);
            }
        }
        first += count;
    }
    *found = tree.found;
    if let Some(Many { particles, .. }) = many.first().filter(|_| gathered) {
        // Members by their numbers.
        for &[first, count] in ranges.iter().take(*found) {
            for word in words.iter_mut().skip(first as usize).take(count as usize) {
                let particle = particles.get((*word & 0xFFFF_FFFF) as usize).copied().unwrap_or(0);
                *word = *word & !0xFFFF_FFFF | u64::from(particle);
            }
        }
    }
}

/// The coarsest level whose cells hold few particles on average.
#[cfg_attr(feature = "small", inline(never))]
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

/// What closing a node needs.
struct Tree<'a, 'w, T> {
    mesh: &'a Mesh<T>,
    /// eta s^2 of the cells of each level.
    areas: Areas<T>,
    criterion: &'a Criterion<T>,
    words: &'a [u64],
    places: &'a [[T; 2]],
    weights: &'a [T],
    ranges: &'a mut &'w mut [[u32; 2]],
    values: &'a mut &'w mut [[T; 5]],
    found: usize,
    /// Particles that lie before the end of the node that closes.
    seen: u32,
}

impl<T: Real> Tree<'_, '_, T> {
    /// Positions and masses of `count` particles in the sorted order.
    #[inline]
    fn members(&self, first: usize, count: usize) -> impl Iterator<Item = ([T; 2], T)> + Clone + use<'_, T> {
        let words = self.words.get(first..first.saturating_add(count)).unwrap_or(&[]);
        words.iter().map(|&word| {
            let place = (word & 0xFFFF_FFFF) as usize;
            (self.places.get(place).copied().unwrap_or_default(), self.weights.get(place).copied().unwrap_or_default())
        })
    }

    /// Tests the nodes of two particles in a cell of more than two. `shared` is that of all particles.
    #[inline]
    fn pairs(&mut self, shared: &[u8], first: usize, count: usize) {
        let level = |k: usize| shared.get(k).map_or(0, |&level| u32::from(level));
        // One that is nearer to the next than to the one before, and the next to it than to the one after.
        let (mut before, mut here) = (level(first), level(first + 1));
        let mut from = 0;
        while from + 1 < count {
            // Read in a loop that does nothing else, so that many scattered reads are under way at once.
            let mut near = [([T::ZERO; 2], T::ZERO); AHEAD];
            if cfg!(not(feature = "small")) {
                let members = self.members(first + from, AHEAD.min(count - from));
                near.iter_mut().zip(members).for_each(|(to, member)| *to = member);
            }
            for (k, pair) in (first + from..first + count - 1).zip(near.windows(2)) {
                let after = level(k + 2);
                if here > before && here > after && here >= self.mesh.coarsest {
                    let node = Node { level: here, first: k as u32, clusters: self.found as u32, ..Node::default() };
                    let moments =
                        if cfg!(feature = "small") { self.moments(k, 2) } else { Moments::of(pair.iter().copied()) };
                    self.test(&node, 2, &moments, Some(before.max(after)));
                }
                (before, here) = (here, after);
            }
            from += AHEAD - 1;
        }
    }

    /// The moments of a few particles in the sorted order.
    #[cfg_attr(feature = "small", inline(never))]
    fn moments(&self, first: usize, count: usize) -> Moments<T> {
        Moments::of(self.members(first, count))
    }

    /// Adds the particles of a cell none of whose nodes is of interest: one, or too light ones. Given are the first, how many they are, and
    /// the clusters found before them.
    #[inline]
    fn leaf(&mut self, stack: &mut Stack<'_, T>, [first, count, clusters]: [usize; 3], mass: T, shared: &[u8]) {
        let end = first + count;
        self.seen = end as u32;
        let node = Node { level: DEPTH, first: first as u32, clusters: clusters as u32, known: first as u32, mass };
        self.close(stack, node, shared.get(end).map(|&level| u32::from(level)));
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
            if finished.known > finished.first {
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
        let mut moments = stack.moments(at);
        self.complete(node, &mut moments, self.seen);
        stack.set_moments(at, moments);
        self.test(node, count, &moments, parent);
    }

    /// Notes a node that is separated and collidable, in the place of the clusters found in it.
    #[cfg_attr(feature = "small", inline(never))]
    #[cfg_attr(not(feature = "small"), inline)]
    fn test(&mut self, node: &Node<T>, count: u32, moments: &Moments<T>, parent: Option<u32>) {
        let level = parent.map_or(0, |p| p + 1).max(self.mesh.coarsest);
        let Moments { group, spread, centre } = moments;
        // Y / s^2 < eta
        if self.areas.of(level).is_none_or(|area| *spread >= area * group.mass) {
            return;
        }
        let moment = *spread / group.mass;
        if !self.criterion.collidable(group, moment) {
            return;
        }
        let at = node.clusters as usize;
        if let (Some(range), Some(value)) = (self.ranges.get_mut(at), self.values.get_mut(at)) {
            *range = [node.first, count];
            *value = [group.mass, group.pairs, moment, centre[0], centre[1]];
            self.found = at + 1;
        }
    }

    /// Adds the particles before `end` to the node's moments.
    #[cfg_attr(feature = "small", inline(never))]
    #[cfg_attr(not(feature = "small"), inline)]
    fn complete(&self, node: &mut Node<T>, moments: &mut Moments<T>, end: u32) {
        if node.known >= end {
            return;
        }
        let mut known = node.known > node.first;
        let mut from = node.known as usize;
        while from < end as usize {
            let count = TOGETHER.min(end as usize - from);
            let part = self.moments(from, count);
            *moments = if known { moments.with(&part) } else { part };
            known = true;
            from += count;
        }
        node.known = end;
    }
}

/// Puts the particles of each coarse cell together, and makes their words.
fn gather<T: Real>(
    mesh: &Mesh<T>,
    positions: &[[T; 2]],
    masses: &[T],
    places: &mut [[T; 2]],
    weights: &mut [T],
    scratch: &mut Scratch<'_, T>,
) {
    let Scratch { words, many, .. } = scratch;
    let Some(Many { spare, particles, buckets, counts }) = many.first_mut() else { return };
    let bucket = |word: u64| (word >> (64 - BUCKETS.ilog2())) as usize;
    buckets.fill(0);
    for (i, (word, x)) in spare.iter_mut().zip(positions).enumerate() {
        *word = mesh.word(x, i);
        if let Some(count) = buckets.get_mut(bucket(*word)) {
            *count += 1;
        }
    }
    sort::starts(buckets);
    for (((i, &word), &x), &mass) in (0_u32..).zip(spare.iter()).zip(positions).zip(masses) {
        let Some(next) = buckets.get_mut(bucket(word)) else { continue };
        let at = *next as usize;
        *next += 1;
        if let (Some(to), Some(place), Some(weight), Some(particle)) =
            (words.get_mut(at), places.get_mut(at), weights.get_mut(at), particles.get_mut(at))
        {
            (*to, *place, *weight, *particle) = (word & !0xFFFF_FFFF | at as u64, x, mass, i);
        }
    }
    // What was the beginning of a bucket is its end now.
    let mut start = 0;
    for &end in buckets.iter() {
        let (start, end) = (core::mem::replace(&mut start, end as usize), end as usize);
        if let (Some(words), Some(spare)) = (words.get_mut(start..end), spare.get_mut(start..end)) {
            sort::by_20_bits(words, spare, counts);
        }
    }
}

/// Sorts the particles by their cells at the finest level, and says how many levels neighbours share. They come in the order of their first
/// levels, or they are few.
#[cfg_attr(feature = "small", inline(never))]
fn order<T: Real>(mesh: &Mesh<T>, places: &[[T; 2]], scratch: &mut Scratch<'_, T>) {
    let Scratch { words, many, shared, .. } = scratch;
    let (spare, counts) = match many.first_mut() {
        Some(Many { spare, counts, .. }) => (&mut **spare, &mut **counts),
        None => Default::default(),
    };
    // The state's arrays may have shrunk since the scratch was laid out.
    let n = places.len();
    let (Some(words), Some(shared)) = (words.get_mut(..n), shared.get_mut(..n)) else { return };
    if n <= sort::FEW {
        sort::by_key(words, &|word| word);
    }
    let mut before = None;
    for (level, &word) in shared.iter_mut().zip(words.iter()) {
        let key = (word >> 32) as u32;
        *level = before.map_or(0, |b: u32| ((b ^ key).leading_zeros() / 2) as u8);
        before = Some(key);
    }
    // Particles of one cell of the first sixteen levels: sort them by the next sixteen.
    let mut from = 0;
    while from < words.len() {
        let run = 1 + shared.iter().skip(from + 1).take_while(|&&level| u32::from(level) == FIRST).count();
        if run > 1 {
            let (Some(words), Some(shared)) = (words.get_mut(from..from + run), shared.get_mut(from + 1..from + run))
            else {
                return;
            };
            for word in words.iter_mut() {
                let place = *word & 0xFFFF_FFFF;
                let [cx, cy] = places.get(place as usize).map_or([0; 2], |x| mesh.cell(x));
                *word = u64::from(interleave(cx & 0xFFFF, cy & 0xFFFF)) << 32 | place;
            }
            sort::by_high_half(words, spare, counts);
            let keys = words.iter().map(|word| (word >> 32) as u32);
            for (level, (a, b)) in shared.iter_mut().zip(keys.clone().zip(keys.skip(1))) {
                *level = (FIRST + (a ^ b).leading_zeros() / 2) as u8;
            }
        }
        from += run;
    }
}
