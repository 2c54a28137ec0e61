//! The gradient at the particles: bilinear interpolation of the centred differences, the adjoint of the deposit.

use super::Walls;
use super::mesh::{Locator, Mesh, Place};
use super::monopole::Monopole;
use crate::isa::Plain;
use crate::real::Real;

/// Particles that go through the vectorised part together.
const BLOCK: usize = 64;

/// Overwrites `out` with the gradient at `positions`.
pub(super) struct Interpolate<'a, T> {
    pub mesh: &'a Mesh<T>,
    pub locator: Locator,
    pub walls: Walls,
    pub monopole: Monopole<T>,
    /// The gradient at the nodes.
    pub gradient: &'a [[T; 2]],
    pub positions: &'a [[T; 2]],
    pub out: &'a mut [[T; 2]],
}

impl<T: Real> Plain for Interpolate<'_, T> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { mesh, locator, walls, monopole, gradient, positions, out } = self;
        let pitch = mesh.cells()[0] + 1;
        let mut places = [Place::default(); BLOCK];
        for (positions, out) in positions.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
            for (place, &x) in places.iter_mut().zip(positions) {
                *place = locator.place(x);
            }
            for ((out, place), &x) in out.iter_mut().zip(&places).zip(positions) {
                *out = if place.inside {
                    bilinear(gradient, pitch, place)
                } else {
                    away(mesh, &locator, walls, &monopole, gradient, x)
                };
            }
        }
    }
}

#[inline(always)]
fn bilinear<T: Real>(gradient: &[[T; 2]], pitch: usize, place: &Place) -> [T; 2] {
    let two = |at: usize| gradient.get(at..).and_then(|g| g.first_chunk::<2>()).copied().unwrap_or_default();
    let node = place.node as usize;
    let ([a, b], [c, d]) = (two(node), two(node.wrapping_add(pitch)));
    let [fx, fy] = place.fraction.map(T::from_f64);
    let (gx, gy) = (T::ONE - fx, T::ONE - fy);
    let (wa, wb, wc, wd) = (gx * gy, fx * gy, gx * fy, fx * fy);
    [(wa * a[0] + wb * b[0]) + (wc * c[0] + wd * d[0]), (wa * a[1] + wb * b[1]) + (wc * c[1] + wd * d[1])]
}

/// Outside: the monopole's gradient (3.8), or with no-flux walls that of the mirror place, mirrored.
#[inline(never)]
fn away<T: Real>(
    mesh: &Mesh<T>,
    locator: &Locator,
    walls: Walls,
    monopole: &Monopole<T>,
    gradient: &[[T; 2]],
    x: [T; 2],
) -> [T; 2] {
    match walls {
        Walls::Free => monopole.gradient(x),
        Walls::NoFlux => {
            let (x, odd) = mesh.reflect(x);
            let place = locator.place(x);
            if !place.inside {
                return [T::NAN; 2];
            }
            let [a, b] = bilinear(gradient, mesh.cells()[0] + 1, &place);
            [if odd[0] { -a } else { a }, if odd[1] { -b } else { b }]
        }
    }
}
