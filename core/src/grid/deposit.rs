//! Cloud-in-cell deposit: each particle's mass onto the four nodes of its cell, by bilinear weights, in fixed point.

use super::fixed::nearest;
use super::mesh::{BLOCK, Locator, Mesh, OUTSIDE, Places};
use super::{MassScale, Walls};
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::real::{Real, Scalar};
use crate::simd::Loops;

/// Words after the masses of the nodes, for particles outside the mesh: count, mass, first moments about the mesh centre; padded to
/// a cache line.
pub(super) const TAIL: usize = 8;
/// Offsets of outside particles are clamped to 2^10 sides of the mesh. Their moments are in units of 2^-10 mass units.
const MOMENT: f64 = 1024.0;

/// Adds the particles to `words`: the masses of the nodes in units, then the tail.
pub(super) struct Deposit<'a, T> {
    pub mesh: &'a Mesh<T>,
    pub locator: Locator,
    pub walls: Walls,
    pub scale: MassScale,
    pub positions: &'a [[T; 2]],
    pub masses: &'a [T],
    /// Subtracts the particles; they were added before with the same positions and masses.
    pub remove: bool,
    pub words: &'a mut [i64],
}

impl<T: Real> Loops for Deposit<'_, T> {
    type Out = Result<()>;

    #[inline(always)]
    fn run(self) -> Result<()> {
        let Self { mesh, locator, walls, scale, positions, masses, remove, words } = self;
        let nodes = words.len().saturating_sub(TAIL);
        let (words, tail) = words.split_at_mut_checked(nodes).present()?;
        let tail = tail.first_chunk_mut::<TAIL>().present()?;
        // Rounding is symmetric in sign, so adding the opposite mass restores every bit.
        let one = if remove { -1 } else { 1 };
        let ([first, second], pitch) = (scale.per_mass(), mesh.cells()[0] + 1);
        let first = f64::from(one) * first;
        let mut places = Places::NONE;
        let mut shares = [[0_i64; BLOCK]; 4];
        for (positions, masses) in positions.chunks(BLOCK).zip(masses.chunks(BLOCK)) {
            locator.places(positions, &mut places);
            let Places { node, x, y } = &places;
            let [a, b, c, d] = &mut shares;
            for ((((((a, b), c), d), &x), &y), m) in a.iter_mut().zip(b).zip(c).zip(d).zip(x).zip(y).zip(masses) {
                [*a, *b, *c, *d] = divide(m.to_f64() * first * second, [x, y]);
            }
            let [a, b, c, d] = &shares;
            let shares = a.iter().zip(b).zip(c).zip(d);
            for ((&node, (((&a, &b), &c), &d)), (&x, m)) in node.iter().zip(shares).zip(positions.iter().zip(masses)) {
                if node == OUTSIDE {
                    let m = m.to_f64() * first * second;
                    outside(mesh, &locator, walls, x, m, i64::from(one), pitch, words, tail)?;
                } else {
                    scatter(words, pitch, node as usize, [a, b, c, d]);
                }
            }
        }
        Ok(())
    }
}

/// The four shares of `m` units for the nodes (0, 0), (1, 0), (0, 1), (1, 1) of the cell. They add up exactly to m, rounded.
#[inline(always)]
fn divide(m: f64, [fx, fy]: [f64; 2]) -> [i64; 4] {
    let (right, upper) = (m * fx, 1.0 - fy);
    let left = m - right;
    let (b, c, d) = (nearest(right * upper), nearest(left * fy), nearest(right * fy));
    [nearest(m).wrapping_sub(b).wrapping_sub(c).wrapping_sub(d), b, c, d]
}

#[inline(always)]
fn scatter(words: &mut [i64], pitch: usize, node: usize, shares: [i64; 4]) {
    let add = |words: &mut [i64], at: usize, a: i64, b: i64| {
        if let Some([left, right]) = words.get_mut(at..).and_then(|w| w.first_chunk_mut::<2>()) {
            *left = left.wrapping_add(a);
            *right = right.wrapping_add(b);
        }
    };
    add(words, node, shares[0], shares[1]);
    add(words, node.wrapping_add(pitch), shares[2], shares[3]);
}

/// Deposits a particle outside the mesh: at its mirror image with no-flux walls, into the tail in free space.
#[expect(clippy::too_many_arguments, reason = "the rare branch of one loop")]
#[inline(never)]
fn outside<T: Real>(
    mesh: &Mesh<T>,
    locator: &Locator,
    walls: Walls,
    x: [T; 2],
    m: f64,
    one: i64,
    pitch: usize,
    words: &mut [i64],
    tail: &mut [i64; TAIL],
) -> Result<()> {
    if !x.iter().all(|v| v.is_finite()) {
        return Err(Error::NotFinite);
    }
    match walls {
        Walls::NoFlux => {
            // The mirror image is inside the mesh.
            let (node, fraction) = locator.place(mesh.reflect(x).0);
            scatter(words, pitch, node as usize, divide(m, fraction));
        }
        Walls::Free | Walls::FreeQuadrupole => {
            let offset = |x: T, l: T, u: T| {
                let (l, u) = (l.to_f64(), u.to_f64());
                let offset = (x.to_f64() - middle(l, u)) / (u - l);
                if offset.abs() <= MOMENT { offset } else { MOMENT.copysign(offset) }
            };
            let (lower, upper) = (mesh.lower(), mesh.upper());
            let moment = |offset: f64| nearest(m / MOMENT * offset);
            let add =
                [one, nearest(m), moment(offset(x[0], lower[0], upper[0])), moment(offset(x[1], lower[1], upper[1]))];
            for (word, add) in tail.iter_mut().zip(add) {
                *word = word.wrapping_add(add);
            }
        }
    }
    Ok(())
}

/// Total mass in units and its centre, computed from the integers alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub outside: u64,
    pub units: i64,
    pub centre: [f64; 2],
}

pub(super) fn sum<T: Real>(mesh: &Mesh<T>, words: &[i64]) -> Sum {
    let pitch = mesh.cells()[0] + 1;
    let (mut units, mut moment_x, mut moment_y) = (0_i64, 0_i128, 0_i128);
    let nodes = words.len().saturating_sub(TAIL);
    let (words, tail) = words.split_at_checked(nodes).unwrap_or((words, &[]));
    for (j, row) in words.chunks(pitch.max(1)).enumerate() {
        // The sum of a row fits in 64 bits. Its first moment may not, as i <= 2^20.
        let mut in_row = 0_i64;
        let mut first = 0_i64;
        let mut wide = 0_i128;
        for (block, words) in row.chunks(256).enumerate() {
            let mut of_block = 0_i64;
            let mut of_block_first = 0_i64;
            for (i, &w) in (0_i64..).zip(words) {
                of_block = of_block.wrapping_add(w);
                of_block_first = of_block_first.wrapping_add(i.wrapping_mul(w));
            }
            in_row = in_row.wrapping_add(of_block);
            first = first.wrapping_add(of_block_first);
            wide = wide.wrapping_add(i128::from(of_block).wrapping_mul(256 * block as i128));
        }
        units = units.wrapping_add(in_row);
        moment_x = moment_x.wrapping_add(wide).wrapping_add(i128::from(first));
        moment_y = moment_y.wrapping_add(i128::from(in_row).wrapping_mul(j as i128));
    }
    let inside = units as f64;
    let tail = tail.first_chunk::<4>().copied().unwrap_or_default();
    units = units.wrapping_add(tail[1]);
    let (lower, upper, cells) = (mesh.lower(), mesh.upper(), mesh.cells());
    let centre = |l: T, u: T, n: usize, moment: i128, outside: i64| {
        let (l, u) = (l.to_f64(), u.to_f64());
        let middle = middle(l, u);
        if units == 0 {
            return middle;
        }
        // First moments about the middle, in sides of the mesh: of the nodes and of the tail.
        let from_middle = moment as f64 / n as f64 - 0.5 * inside + outside as f64 * MOMENT;
        middle + (u - l) * (from_middle / units as f64)
    };
    Sum {
        outside: tail[0] as u64,
        units,
        centre: [
            centre(lower[0], upper[0], cells[0], moment_x, tail[2]),
            centre(lower[1], upper[1], cells[1], moment_y, tail[3]),
        ],
    }
}

fn middle(l: f64, u: f64) -> f64 {
    0.5 * (l + u)
}

/// [sum w (x^2 - y^2), sum 2 w x y] of the masses of the nodes in units, about `centre`. Lengths are in units of 2^`unit`.
pub(super) fn second_moments<T: Real>(mesh: &Mesh<T>, words: &[i64], centre: [f64; 2], unit: i32) -> [f64; 2] {
    let pitch = mesh.cells()[0] + 1;
    let words = words.get(..words.len().saturating_sub(TAIL)).present_or_default();
    let scaled = |lengths: [T; 2]| lengths.map(|v| v.to_f64().ldexp(-unit));
    let ([lower_x, lower_y], [h, k]) = (scaled(mesh.lower()), scaled(mesh.spacing()));
    let centre = centre.map(|v| v.ldexp(-unit));
    let mut moments = [0.0; 2];
    for (j, row) in words.chunks(pitch.max(1)).enumerate() {
        let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
        for (i, &w) in row.iter().enumerate() {
            let (w, x) = (w as f64, lower_x + h * i as f64 - centre[0]);
            (mass, first, second) = (mass + w, first + w * x, second + w * x * x);
        }
        let y = lower_y + k * j as f64 - centre[1];
        moments = [moments[0] + second - mass * y * y, moments[1] + 2.0 * first * y];
    }
    moments
}
