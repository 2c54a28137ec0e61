//! Isolated clusters of particles that may collide within the step (Zhelezov & Fatkullin, Section 3.3).
//!
//! The paper refines a coarse mesh until a cell is separated (3.1) and collidable, or holds too few particles. Here the same
//! cells come out of one sort: particles in the order of their Morton keys, and a pass over neighbours with a stack, in which the nodes
//! of the quadtree close one after the other, from the leaves to the root. A node that is separated and collidable replaces
//! the clusters found below it, so the coarsest such cell wins, as in a descent. Cells that hold the same particles are one node,
//! represented by the coarsest of them, where (3.1) is easiest. Cost O(n log n) whatever the positions, no pairwise work; depth at
//! most [`DEPTH`].
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
    /// Morton key in the high half, particle in the low half.
    words: &'w mut [u64],
    spare: &'w mut [u64],
    histogram: &'w mut [u32],
    /// Levels that a particle shares with the one before it.
    shared: &'w mut [u8],
    ranges: &'w mut [[u32; 2]],
    /// mass, pairs, moment, centre of each cluster.
    values: &'w mut [[T; 5]],
    found: usize,
}

impl<'w, T: Real> Scratch<'w, T> {
    /// Lays out the scratch for `n` particles.
    ///
    /// # Errors
    /// Those of [`Space::array`]; [`Error::TooLarge`]: more particles than 32 bits count.
    pub fn lay(space: &mut impl Space<'w>, n: usize) -> Result<Self> {
        u32::try_from(n).ok().filter(|&n| n < u32::MAX).ok_or(Error::TooLarge)?;
        Ok(Self {
            words: space.array(n)?,
            // Few particles are sorted in place.
            spare: space.array(if n > sort::FEW { n } else { 0 })?,
            histogram: space.array(if n > sort::FEW { sort::BUCKETS } else { 0 })?,
            shared: space.array(n)?,
            ranges: space.array(n / 2)?,
            values: space.array(n / 2)?,
            found: 0,
        })
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

/// Moments of the particles of a node.
#[derive(Clone, Copy, Default)]
struct Moments<T> {
    group: Group<T>,
    centre: [T; 2],
    /// sum m |x - c|^2
    spread: T,
}

impl<T: Real> Moments<T> {
    /// The moments of the union: only sums of positive terms, so a tight cluster far from the origin loses nothing.
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

/// A node of the quadtree that is still open.
#[derive(Clone, Copy, Default)]
struct Node<T> {
    /// The level of the cell that holds all its particles and at which they part.
    level: u32,
    first: u32,
    /// Clusters found before it.
    clusters: u32,
    moments: Moments<T>,
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
    fn new(search: &Search<T>, positions: &[[T; 2]], step: u64) -> Self {
        let first = positions.first().copied().unwrap_or_default();
        let (mut low, mut high) = positions.iter().fold((first, first), |(low, high), x| {
            ([low[0].min(x[0]), low[1].min(x[1])], [high[0].max(x[0]), high[1].max(x[1])])
        });
        if let Some([from, to]) = search.domain {
            low = [low[0].min(from[0]), low[1].min(from[1])];
            high = [high[0].max(to[0]), high[1].max(to[1])];
        }
        let [nx, ny] = search.mesh.map(|n| n.max(1));
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
                T::from_f64((step.wrapping_mul(multiplier) >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0))
            };
            // 0.75487766624669276, 0.56984029099805327 in units of 2^-64.
            (T::TWO * cell * cells, [fraction(0xC13F_A9A9_02A6_328F), fraction(0x91E1_0DA5_C79E_7B1D)])
        } else {
            (cell * cells, [T::HALF; 2])
        };
        let origin = core::array::from_fn(|k| {
            let (low, extent, free) = match (low, extent, free) {
                ([l, _], [e, _], [f, _]) if k == 0 => (l, e, f),
                ([_, l], [_, e], [_, f]) => (l, e, f),
            };
            low - free * (side - extent).max(T::ZERO)
        });
        Self { origin, side, scale: T::ONE.ldexp(32) / side, coarsest: levels }
    }

    /// The cell coordinates at the finest level.
    #[inline]
    fn cell(&self, x: &[T; 2]) -> [u32; 2] {
        // Conversions saturate.
        [0, 1].map(|k| {
            let (x, origin) = if k == 0 { (x[0], self.origin[0]) } else { (x[1], self.origin[1]) };
            ((x - origin) * self.scale).to_f64() as u32
        })
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
/// `step` chooses the mesh's shift. Deterministic: it depends on positions, masses and the arguments alone.
pub fn find<T: Real>(
    search: &Search<T>,
    criterion: &Criterion<T>,
    step: u64,
    positions: &[[T; 2]],
    masses: &[T],
    scratch: &mut Scratch<'_, T>,
) {
    scratch.found = 0;
    if positions.len() < 2 {
        return;
    }
    let mesh = Mesh::new(search, positions, step);
    order(&mesh, positions, scratch);
    let Scratch { words, shared, ranges, values, found, .. } = scratch;
    let (words, shared) = (words.iter().take(positions.len()), shared.iter());
    let mut tree = Tree { mesh: &mesh, search, criterion, ranges, values, found: 0, seen: 0 };

    let mut stack = [Node::<T>::default(); STACK];
    let mut height = 0_usize;
    let mut leaf: Option<Node<T>> = None;
    for (i, (&word, &level)) in words.zip(shared).enumerate() {
        let particle = (word & 0xFFFF_FFFF) as usize;
        let (Some(&centre), Some(&mass)) = (positions.get(particle), masses.get(particle)) else { continue };
        tree.seen = i as u32;
        if let Some(finished) = leaf {
            close(&mut stack, &mut height, finished, Some(u32::from(level)), &mut tree);
        }
        let group = Group { count: T::ONE, mass, pairs: T::ZERO };
        let moments = Moments { group, centre, spread: T::ZERO };
        leaf = Some(Node { level: DEPTH, first: i as u32, clusters: tree.found as u32, moments });
    }
    tree.seen = positions.len() as u32;
    if let Some(finished) = leaf {
        close(&mut stack, &mut height, finished, None, &mut tree);
    }
    *found = tree.found;
}

/// Adds the finished node to the open ones, closing those that part deeper than `level` (all, at the end).
#[inline]
fn close<T: Real>(
    stack: &mut [Node<T>; STACK],
    height: &mut usize,
    leaf: Node<T>,
    level: Option<u32>,
    tree: &mut Tree<'_, '_, T>,
) {
    let mut finished = leaf;
    while let Some(top) = height.checked_sub(1).and_then(|top| stack.get_mut(top)) {
        if level.is_some_and(|level| top.level < level) {
            break;
        }
        top.moments = top.moments.with(&finished.moments);
        if level == Some(top.level) {
            return;
        }
        finished = *top;
        *height -= 1;
        // Its largest cell is one level below where the next particle, or the node around it, parts from it.
        let around = height.checked_sub(1).and_then(|top| stack.get(top)).map(|node| node.level);
        let parent = match (around, level) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        tree.finish(&finished, parent);
    }
    if let (Some(level), Some(slot)) = (level, stack.get_mut(*height)) {
        *slot = Node { level, ..finished };
        *height += 1;
    }
}

/// What closing a node needs.
struct Tree<'a, 'w, T> {
    mesh: &'a Mesh<T>,
    search: &'a Search<T>,
    criterion: &'a Criterion<T>,
    ranges: &'a mut &'w mut [[u32; 2]],
    values: &'a mut &'w mut [[T; 5]],
    found: usize,
    /// Particles that lie before the end of the node that closes.
    seen: u32,
}

impl<T: Real> Tree<'_, '_, T> {
    /// Tests a node of at least two particles; `parent` is the level of the cell around its largest cell.
    #[inline]
    fn finish(&mut self, node: &Node<T>, parent: Option<u32>) {
        if node.level < self.mesh.coarsest {
            return;
        }
        let level = parent.map_or(0, |p| p + 1).max(self.mesh.coarsest);
        let Moments { group, spread, centre } = node.moments;
        let side = self.mesh.side.ldexp(-(level as i32));
        // Y / s^2 < eta, s^2 = 2 side^2
        let separated = spread < self.search.separation * group.mass * (T::TWO * side * side);
        if !separated {
            return;
        }
        let moment = spread / group.mass;
        if !self.criterion.collidable(&group, moment) {
            return;
        }
        let count = self.seen - node.first;
        let at = node.clusters as usize;
        if let (Some(range), Some(value)) = (self.ranges.get_mut(at), self.values.get_mut(at)) {
            *range = [node.first, count];
            *value = [group.mass, group.pairs, moment, centre[0], centre[1]];
            self.found = at + 1;
        }
    }
}

/// Sorts the particles by their cells at the finest level and says how many levels neighbours share.
fn order<T: Real>(mesh: &Mesh<T>, positions: &[[T; 2]], scratch: &mut Scratch<'_, T>) {
    let Scratch { words, spare, histogram, shared, .. } = scratch;
    // The state's arrays may have shrunk since the scratch was laid out.
    let n = positions.len();
    let (Some(words), Some(shared)) = (words.get_mut(..n), shared.get_mut(..n)) else { return };
    for (i, (word, x)) in words.iter_mut().zip(positions).enumerate() {
        let [cx, cy] = mesh.cell(x);
        *word = u64::from(interleave(cx >> 16, cy >> 16)) << 32 | i as u64;
    }
    sort::by_high_half(words, spare, histogram);
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
                let particle = *word & 0xFFFF_FFFF;
                let [cx, cy] = positions.get(particle as usize).map_or([0; 2], |x| mesh.cell(x));
                *word = u64::from(interleave(cx & 0xFFFF, cy & 0xFFFF)) << 32 | particle;
            }
            sort::by_high_half(words, spare, histogram);
            let keys = words.iter().map(|word| (word >> 32) as u32);
            for (level, (a, b)) in shared.iter_mut().zip(keys.clone().zip(keys.skip(1))) {
                *level = (FIRST + (a ^ b).leading_zeros() / 2) as u8;
            }
        }
        from += run;
    }
}
