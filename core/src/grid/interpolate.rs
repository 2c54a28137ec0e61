//! The gradient at the particles: bilinear interpolation of centred differences. It is the adjoint of the deposit.

use super::Walls;
use super::mesh::{BLOCK, Locator, Mesh, OUTSIDE, Places};
use super::monopole::Monopole;
use crate::checked::Present;
use crate::real::Real;
use crate::simd::Loops;

/// Overwrites `out` with the gradient at `positions`.
pub(super) struct Interpolate<'a, T> {
    pub mesh: &'a Mesh<T>,
    pub locator: Locator,
    pub walls: Walls,
    /// With masses in units of their bound.
    pub monopole: Monopole<T>,
    /// That unit, as two factors.
    pub unit: [T; 2],
    /// The gradient at the nodes.
    pub gradient: &'a [[T; 2]],
    pub positions: &'a [[T; 2]],
    pub out: &'a mut [[T; 2]],
}

impl<T: Real> Loops for Interpolate<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { mesh, locator, walls, monopole, unit, gradient, positions, out } = self;
        let pitch = mesh.cells()[0] + 1;
        let mut places = Places::NONE;
        for (positions, out) in positions.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
            locator.places(positions, &mut places);
            let Places { node, x, y } = &places;
            for ((((out, &node), &x), &y), &position) in out.iter_mut().zip(node).zip(x).zip(y).zip(positions) {
                *out = if node == OUTSIDE {
                    outside(mesh, &locator, walls, (&monopole, unit), gradient, position)
                } else {
                    bilinear(gradient, pitch, node, [x, y])
                };
            }
        }
    }
}

#[inline(always)]
fn bilinear<T: Real>(gradient: &[[T; 2]], pitch: usize, node: u64, fraction: [f64; 2]) -> [T; 2] {
    let two = |at: usize| gradient.get(at..).and_then(|g| g.first_chunk::<2>()).copied().present_or_default();
    let node = node as usize;
    let ([a, b], [c, d]) = (two(node), two(node.wrapping_add(pitch)));
    let [fx, fy] = fraction.map(T::from_f64);
    let (gx, gy) = (T::ONE - fx, T::ONE - fy);
    let (wa, wb, wc, wd) = (gx * gy, fx * gy, gx * fy, fx * fy);
    [(wa * a[0] + wb * b[0]) + (wc * c[0] + wd * d[0]), (wa * a[1] + wb * b[1]) + (wc * c[1] + wd * d[1])]
}

/// The gradient outside the mesh: the monopole's (3.8), or with no-flux walls the mirrored one of the mirror image. NaN for a
/// position that is not finite.
#[inline(never)]
fn outside<T: Real>(
    mesh: &Mesh<T>,
    locator: &Locator,
    walls: Walls,
    (monopole, [first, second]): (&Monopole<T>, [T; 2]),
    gradient: &[[T; 2]],
    x: [T; 2],
) -> [T; 2] {
    if !x.iter().all(|v| v.is_finite()) {
        return [T::NAN; 2];
    }
    match walls {
        Walls::Free | Walls::FreeQuadrupole => monopole.gradient(x).map(|g| g * first * second),
        Walls::NoFlux => {
            let (x, odd) = mesh.reflect(x);
            let (node, fraction) = locator.place(x);
            let [a, b] = bilinear(gradient, mesh.cells()[0] + 1, node, fraction);
            [if odd[0] { -a } else { a }, if odd[1] { -b } else { b }]
        }
    }
}
