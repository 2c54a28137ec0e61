//! Mass, centre and second moment of a node's particles.

use crate::pks::theory::Group;
use crate::real::Real;

/// Moments of the particles of a node.
#[derive(Clone, Copy, Default)]
pub struct Moments<T> {
    pub group: Group<T>,
    pub centre: [T; 2],
    /// sum m |x - c|^2
    pub spread: T,
}

impl<T: Real> Moments<T> {
    /// The moments of a few particles: differences from one of them, so a tight cluster far from the origin loses nothing.
    #[inline]
    pub fn of(members: impl Iterator<Item = ([T; 2], T)> + Clone) -> Self {
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
    pub fn with(&self, other: &Self) -> Self {
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
