//! The quadtree's cells: where a particle lies at each level.

use super::{DEPTH, Search};
use crate::build;
use crate::pks::extent::Extent;
use crate::real::Real;

/// The mesh of one step: a square whose halvings are the quadtree's cells.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<T> {
    /// What positions are multiplied by first; the rest is in that unit.
    unit: T,
    origin: [T; 2],
    /// Of the square.
    pub(super) side: T,
    /// Fixed-point coordinates for one length unit: 2^32 / side.
    scale: T,
    /// Cells coarser than this level are not cells of the coarse mesh.
    pub(super) coarsest: u32,
}

impl<T: Real> Mesh<T> {
    /// The mesh for particles of this extent; `step` chooses its shift, and `unit` is what all lengths are multiplied by, a power of two.
    pub fn new(search: &Search<T>, extent: &Extent<T>, step: u64, unit: T) -> Self {
        let Extent { mut low, mut high, .. } = *extent;
        if let Some([lower, upper]) = &search.domain {
            for ((low, high), (&l, &h)) in low.iter_mut().zip(&mut high).zip(lower.iter().zip(upper)) {
                *low = if l < *low { l } else { *low };
                *high = if h > *high { h } else { *high };
            }
        }
        let [low, high] = [low, high].map(|corner| corner.map(|x| x * unit));
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
        Self { unit, origin, side, scale: T::ONE.ldexp(32) / side, coarsest: levels }
    }

    /// The cell coordinates at the finest level.
    #[inline]
    pub(super) fn cell(&self, x: &[T; 2]) -> [u32; 2] {
        // Conversions saturate.
        let at = |x: T, origin: T| ((x * self.unit - origin) * self.scale).to_u32();
        [at(x[0], self.origin[0]), at(x[1], self.origin[1])]
    }

    /// As [`Mesh::cell`], in operations that are compiled for several particles at a time.
    #[inline(always)]
    pub(super) fn cell_in_lanes(&self, x: &[T; 2]) -> [u32; 2] {
        // 2^52: added to a number below, it leaves the nearest whole number in the low bits.
        const ROUND: f64 = 4_503_599_627_370_496.0;
        let at = |x: T, origin: T| {
            let place = ((x * self.unit - origin) * self.scale).to_f64();
            let place = if place > 0.0 { place } else { 0.0 };
            let place = if place < f64::from(u32::MAX) { place } else { f64::from(u32::MAX) };
            let rounded = place + ROUND;
            let up = u32::from(rounded - ROUND > place);
            (rounded.to_bits() as u32).wrapping_sub(up)
        };
        [at(x[0], self.origin[0]), at(x[1], self.origin[1])]
    }

    /// The key of the first sixteen levels in the high half, `i` in the low half.
    pub(super) fn word(&self, x: &[T; 2], i: usize) -> u64 {
        let [cx, cy] = self.cell(x);
        u64::from(interleave([cx >> 16, cy >> 16])) << 32 | i as u64
    }

    /// The key of the other sixteen levels in the high half, `i` in the low half.
    pub(super) fn deep_word(&self, x: &[T; 2], i: u64) -> u64 {
        let [cx, cy] = self.cell(x);
        u64::from(interleave([cx & 0xFFFF, cy & 0xFFFF])) << 32 | i
    }
}

/// eta s^2 for the cells of each level, s being the diagonal: a table, or where stacks are short the first one, from which a power of
/// two leads to the others.
pub struct Areas<T>([T; if build::TILES { DEPTH as usize + 1 } else { 1 }]);

impl<T: Real> Areas<T> {
    pub fn new(mesh: &Mesh<T>, search: &Search<T>) -> Self {
        Self(core::array::from_fn(|level| {
            let side = mesh.side.ldexp(-(level as i32));
            search.separation * (T::TWO * side * side)
        }))
    }

    /// None beyond the finest.
    #[inline]
    pub fn of(&self, level: u32) -> Option<T> {
        if build::TILES {
            return self.0.get(level as usize).copied();
        }
        let [area, ..] = self.0;
        (level <= DEPTH).then(|| area.ldexp(-2 * level as i32))
    }
}

/// The bits of two 16-bit numbers in turn: the first one's are the even bits.
#[inline(always)]
pub fn interleave([x, y]: [u32; 2]) -> u32 {
    let spread = |v: u32| {
        let v = (v | v << 8) & 0x00FF_00FF;
        let v = (v | v << 4) & 0x0F0F_0F0F;
        let v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    spread(x) | spread(y) << 1
}

/// Undoes [`interleave`].
#[inline(always)]
pub fn part(key: u32) -> [u32; 2] {
    let gather = |v: u32| {
        let v = v & 0x5555_5555;
        let v = (v | v >> 1) & 0x3333_3333;
        let v = (v | v >> 2) & 0x0F0F_0F0F;
        let v = (v | v >> 4) & 0x00FF_00FF;
        (v | v >> 8) & 0x0000_FFFF
    };
    [gather(key), gather(key >> 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pks::testing::Uniform;

    #[test]
    fn cells_in_lanes_are_those_of_one() {
        fn check<T: Real>() {
            let c = T::from_f64;
            let extent =
                Extent { low: [c(-1.0); 2], high: [c(1.0); 2], smallest: c(1.0), largest: c(1.0), total: c(1.0) };
            for shifted in [false, true] {
                let mesh = Mesh::new(&Search { shifted, ..Search::default() }, &extent, 3, T::ONE);
                let mut uniform = Uniform(7);
                for i in 0..20_000_u32 {
                    let x = c(8.0 * uniform.next() - 4.0);
                    // On cells' borders too, and next to them.
                    let border = mesh.origin[1] + c(f64::from(i) / 64.0) / mesh.scale;
                    for y in [border, border * (T::ONE - T::EPSILON), border * (T::ONE + T::EPSILON)] {
                        assert_eq!(mesh.cell(&[x, y]), mesh.cell_in_lanes(&[x, y]));
                    }
                }
            }
        }
        check::<f64>();
        check::<f32>();
    }
}
