//! Moving the particles over one step, from the positions into a buffer beside them.
//!
//! Two ways. [`frozen`]: a field that stands still for the step (the mesh's), each particle with sub-steps of its own, in tiles that run
//! in parallel. [`together`]: a field that is summed anew for every sub-step, the same for all particles. [`strang`] is the
//! fixed-step alternative. All of them leave the positions as they are, so that a step which fails has changed nothing.

use super::close::Close;
use super::state::Options;
use super::weights;
use crate::build;
use crate::checked::Present;
use crate::error::{Error, Result};
use crate::exec::{Chunks, Resources, par_chunks};
use crate::random::{Generator, Philox, normals_of_labels};
use crate::real::{Real, length, normal_exponent};
use crate::rk4;
use crate::simd::{Level, Loops, with_simd};

/// Particles of a tile.
pub const TILE: usize = 256;

/// Overwrites the second with the gradient of the potential at the points of the first, and lowers the third, where there is one, to the longest
/// jumps that sub-steps from there may make.
pub type Gradient<'a, T> = dyn Fn(&[[T; 2]], &mut [[T; 2]], &mut [T]) + Sync + 'a;

/// A field that is constant during a step.
#[derive(Clone, Copy)]
pub struct Frozen<'a, T> {
    /// The field.
    pub gradient: &'a Gradient<'a, T>,
    /// Particles, by ascending index, that move in other ways: what is found for them is written over. Without any, no jump is limited.
    pub others: &'a [usize],
}

/// What moves.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a, T> {
    /// Where the particles are.
    pub positions: &'a [[T; 2]],
    /// Their masses.
    pub masses: &'a [T],
    /// Their weights, if these are not the masses.
    pub weights: Option<&'a [T]>,
    /// Their labels.
    pub labels: &'a [u64],
    /// Nonzero for particles whose Wiener increment is recorded; empty: none.
    pub recorded: &'a [u8],
    /// chi, mu~, sub-steps.
    pub options: &'a Options<T>,
    /// The step's length.
    pub dt: T,
    /// The step's number.
    pub step: u32,
    /// The instruction set.
    pub level: Level,
}

/// Where the motion goes, all as long as the particles but the last.
#[derive(Debug)]
pub struct Moved<'a, T> {
    /// New positions.
    pub positions: &'a mut [[T; 2]],
    /// The Wiener increments (3.5) of recorded particles; the others are left.
    pub increments: &'a mut [[T; 2]],
    /// Sub-steps of each tile: `n.div_ceil(TILE)`.
    pub substeps: &'a mut [u32],
}

/// Tiles of `n` particles.
pub const fn tiles_of(n: usize) -> usize {
    n / TILE + !n.is_multiple_of(TILE) as usize
}

/// At most `n` elements of `slice` from one on; none beyond the end.
fn piece<X>(slice: &[X], from: usize, n: usize) -> &[X] {
    let from = from.min(slice.len());
    let to = from.saturating_add(n).min(slice.len());
    slice.get(from..to).present_or(&[])
}

impl<T: Real> Moving<'_, T> {
    /// At most `n` particles from one on.
    fn piece(&self, from: usize, n: usize) -> Self {
        Self {
            positions: piece(self.positions, from, n),
            masses: piece(self.masses, from, n),
            weights: self.weights.map(|weights| piece(weights, from, n)),
            labels: piece(self.labels, from, n),
            recorded: piece(self.recorded, from, n),
            ..*self
        }
    }

    fn tile(&self, tile: usize) -> Self {
        self.piece(tile.saturating_mul(TILE), TILE)
    }

    /// What they diffuse by.
    #[inline(always)]
    fn weights(&self) -> &[T] {
        match self.weights {
            Some(weights) if build::WEIGHTS => weights,
            _ => self.masses,
        }
    }

    /// Multiplies the gradients at all particles by their sensitivities, if these are not 1.
    #[inline(always)]
    fn respond(&self, slopes: &mut [[T; 2]]) {
        if build::WEIGHTS
            && let Some(weights) = self.weights
        {
            weights::respond(slopes, self.masses, weights);
        }
    }
}

/// Moves every particle in a field that stands still. The sub-steps of all particles are returned.
///
/// A stream of random numbers is drawn tile by tile of [`TILE`] particles: first a pair of normals for each particle of the tile, in
/// the order of the array, then what further sub-steps need, particle by particle.
///
/// # Errors
/// [`Error::TooManySubsteps`], [`Error::BecameNotFinite`], the generator's, the executor's.
pub fn frozen<T: Real>(
    moving: &Moving<'_, T>,
    field: Option<&Frozen<'_, T>>,
    generator: &mut dyn Generator,
    moved: Moved<'_, T>,
    resources: Resources<'_>,
) -> Result<u64> {
    let Moved { positions, increments, substeps } = moved;
    let philox = generator.counter_based();
    if build::TILES && (philox.is_some() || moving.options.noise == T::ZERO) {
        // Without noise nothing is drawn, so any generator will do.
        let philox = philox.unwrap_or(Philox::new(0));
        tiles(moving, positions, increments, substeps, resources, &|k, part, positions, increments| {
            let mut draw = |labels: &[u64], substep: u32, out: &mut [[T; 2]]| {
                philox.normals(labels, moving.step, substep, out);
                Ok(())
            };
            tile(&part, k, field, &mut draw, positions, increments)
        })?;
    } else {
        let chunks = positions.chunks_mut(TILE).zip(increments.chunks_mut(TILE)).zip(substeps.iter_mut());
        for (k, ((positions, increments), substeps)) in chunks.enumerate() {
            let mut draw = |labels: &[u64], substep: u32, out: &mut [[T; 2]]| {
                normals_of_labels(generator, labels, moving.step, substep, out)
            };
            *substeps = tile(&moving.tile(k), k, field, &mut draw, positions, increments)?;
        }
    }
    Ok(substeps.iter().fold(0, |sum, &s| sum + u64::from(s)))
}

type Body<'a, T> = dyn Fn(usize, Moving<'_, T>, &mut [[T; 2]], &mut [[T; 2]]) -> Result<u32> + Sync + 'a;

/// Runs the body over all tiles, through the executor.
fn tiles<T: Real>(
    moving: &Moving<'_, T>,
    positions: &mut [[T; 2]],
    increments: &mut [[T; 2]],
    substeps: &mut [u32],
    resources: Resources<'_>,
    body: &Body<'_, T>,
) -> Result<()> {
    if !build::WORKERS {
        let chunks = positions.chunks_mut(TILE).zip(increments.chunks_mut(TILE)).zip(substeps.iter_mut());
        for (k, ((positions, increments), substeps)) in chunks.enumerate() {
            *substeps = body(k, moving.tile(k), positions, increments)?;
        }
        return Ok(());
    }
    let tasks = tiles_of(positions.len());
    let outputs = (Chunks::new(positions, TILE), Chunks::new(increments, TILE), Chunks::new(substeps, 1));
    par_chunks(resources.executor, tasks, outputs, (), &|k, (positions, increments, substeps), ()| {
        let made = body(k, moving.tile(k), positions, increments)?;
        substeps.iter_mut().for_each(|s| *s = made);
        Ok(())
    })
}

/// Overwrites `to` with `from`, which is as long, through the executor, or if that fails without.
pub fn copy<T: Real>(to: &mut [[T; 2]], from: &[[T; 2]], resources: Resources<'_>) {
    if build::WORKERS {
        const EACH: usize = 1 << 15;
        let copied =
            par_chunks(resources.executor, from.len().div_ceil(EACH), Chunks::new(to, EACH), (), &|task, to, ()| {
                let from = from.get(task * EACH..).present()?;
                to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
                Ok(())
            });
        if copied.is_ok() {
            return;
        }
    }
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// The noise of a time: `sqrt(2 mu~ s / m)` for a mass m, in factors that stay in range for all normal masses. All scaling is exact.
#[derive(Clone, Copy)]
struct Spread<T> {
    noise: T,
    s: T,
    /// A power of two: `2 mu~ s` is the other two's `2 noise s`, which is from 1/4 to 2, times its square.
    unit: T,
}

impl<T: Real> Spread<T> {
    #[inline]
    fn new(noise: T, s: T) -> Self {
        let ((noise, a), (s, b)) = (noise.frexp(), s.frexp());
        let both = a + b;
        Self { noise, s: s.ldexp(-(both & 1)), unit: T::ONE.ldexp((both + 1) >> 1) }
    }

    #[inline(always)]
    fn of(self, m: T) -> T {
        (T::TWO * self.noise * self.s / m).sqrt() * self.unit
    }

    /// As [`Spread::of`], from the diffusivity.
    fn of_one(self, m: T) -> T {
        (T::TWO * (self.noise / m) * self.s).sqrt() * self.unit
    }
}

/// Draws a pair of normals for each label in a sub-step.
type Draw<'a, T> = dyn FnMut(&[u64], u32, &mut [[T; 2]]) -> Result<()> + 'a;

/// One tile, the `number`th: most particles need one sub-step, which is made for all of them at once; then the others one by one.
fn tile<T: Real>(
    part: &Moving<'_, T>,
    number: usize,
    field: Option<&Frozen<'_, T>>,
    draw: &mut Draw<'_, T>,
    positions: &mut [[T; 2]],
    increments: &mut [[T; 2]],
) -> Result<u32> {
    let mut slopes = [[T::ZERO; 2]; TILE];
    let mut normals = [[T::ZERO; 2]; TILE];
    let n = part.positions.len();
    let (Some(slopes), Some(normals)) = (slopes.get_mut(..n), normals.get_mut(..n)) else {
        return Err(Error::TooLarge);
    };
    let others = field.map_or(&[][..], |field| field.others);
    let mut jumps = [T::ZERO; TILE];
    let jumps = if others.is_empty() { &mut [] } else { jumps.get_mut(..n).present()? };
    jumps.fill(part.options.control.width);
    if let Some(field) = field {
        (field.gradient)(part.positions, slopes, jumps);
        part.respond(slopes);
    }
    if part.options.noise > T::ZERO {
        draw(part.labels, 0, normals)?;
    }
    let mut enough = [true; TILE];
    let job = Once { part, slopes, normals, positions: &mut *positions, enough: &mut enough };
    if !with_simd(part.level, job) {
        return Err(Error::BecameNotFinite);
    }
    let root = part.dt.sqrt();
    if !part.recorded.is_empty() {
        for ((&recorded, z), to) in part.recorded.iter().zip(normals.iter()).zip(increments.iter_mut()) {
            if recorded != 0 {
                *to = [root * z[0], root * z[1]];
            }
        }
    }
    for (enough, &jump) in enough.iter_mut().zip(&*jumps) {
        *enough &= jump >= part.options.control.width;
    }
    for index in others {
        index.checked_sub(number * TILE).and_then(|k| enough.get_mut(k)).into_iter().for_each(|enough| *enough = true);
    }
    let mut made = n as u32;
    if enough.iter().take(n).all(|&e| e) {
        return Ok(made);
    }
    for (k, _) in enough.iter().enumerate().take(n).filter(|(_, enough)| !**enough) {
        let (Some(&x), Some(&m), Some(&label)) = (part.positions.get(k), part.weights().get(k), part.labels.get(k))
        else {
            continue;
        };
        let (Some(&slope), Some(&normal)) = (slopes.get(k), normals.get(k)) else { continue };
        let jump = jumps.get(k).copied().unwrap_or(part.options.control.width);
        // Where jumps are limited one sub-step may be enough all the same: then it is made once more.
        let walker = Walker { x, m, label, slope, normal, jump };
        let (to, increment, done) = substep(&part.piece(k, 1), field, draw, walker)?;
        if !(to[0].is_finite() && to[1].is_finite()) {
            return Err(Error::BecameNotFinite);
        }
        if let Some(slot) = positions.get_mut(k) {
            *slot = to;
        }
        if let (Some(1..), Some(slot)) = (part.recorded.get(k), increments.get_mut(k)) {
            *slot = increment;
        }
        made = made.saturating_add(done - 1);
    }
    Ok(made)
}

/// One sub-step for all particles of a tile; says whether all of them end at finite places, or will not end there.
struct Once<'a, T> {
    part: &'a Moving<'a, T>,
    slopes: &'a [[T; 2]],
    normals: &'a [[T; 2]],
    positions: &'a mut [[T; 2]],
    /// Whether one sub-step is enough.
    enough: &'a mut [bool; TILE],
}

impl<T: Real> Loops for Once<'_, T> {
    type Out = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { part, slopes, normals, positions, enough } = self;
        let Options { chi, noise, ref control, .. } = *part.options;
        // E|N| = sqrt(pi / 2), and the noise's part of the jump is sqrt(2 D dt) E|N|.
        let (dt, scale, mean) = (part.dt, Spread::new(noise, part.dt), (T::HALF * T::PI).sqrt());
        // Of speeds that matter squares are in range in this unit, which is exact.
        let exponent = normal_exponent::<T>(control.width.frexp().1 - dt.frexp().1);
        let (unit, per_unit) = (T::ONE.ldexp(exponent), T::ONE.ldexp(-exponent));
        let one = control.at_least <= 1;
        let mut finite = true;
        let parts = part.positions.iter().zip(part.weights()).zip(slopes.iter()).zip(normals.iter());
        for ((((x, &m), g), z), (to, enough)) in parts.zip(positions.iter_mut().zip(enough.iter_mut())) {
            let v = [-(chi * g[0]), -(chi * g[1])];
            let spread = scale.of(m);
            *to = [x[0] + v[0] * dt + spread * z[0], x[1] + v[1] * dt + spread * z[1]];
            let v = [v[0] * per_unit, v[1] * per_unit];
            let speed = (v[0] * v[0] + v[1] * v[1]).sqrt() * unit;
            *enough = one & (speed * dt + mean * spread <= control.width);
            finite &= !*enough | (to[0].is_finite() & to[1].is_finite());
        }
        finite
    }
}

/// One particle at the start of its sub-steps.
struct Walker<T> {
    x: [T; 2],
    /// Its weight.
    m: T,
    label: u64,
    slope: [T; 2],
    normal: [T; 2],
    jump: T,
}

/// Sub-steps of the particle of `part`: where it ends, its Wiener increment, how many they were.
fn substep<T: Real>(
    part: &Moving<'_, T>,
    field: Option<&Frozen<'_, T>>,
    draw: &mut Draw<'_, T>,
    walker: Walker<T>,
) -> Result<([T; 2], [T; 2], u32)> {
    let Options { chi, noise, mut control, .. } = *part.options;
    let Walker { mut x, m, label, slope, normal, jump } = walker;
    control.width = jump;
    let (mut slope, mut normal) = ([slope], [normal]);
    let diffusivity = noise / m;
    let (mut left, mut done, mut sum) = (part.dt, 0, [T::ZERO; 2]);
    loop {
        let [g] = slope;
        let [z] = normal;
        let mut v = [-(chi * g[0]), -(chi * g[1])];
        let speed = length(&v);
        let s = control.next(part.dt, left, done, speed, diffusivity)?;
        if let Some(field) = field
            && control.width < part.options.control.width
        {
            // Near a heavy particle the drift grows on the way: that of half the way. A jump of a quarter of the distance then loses 2% of
            // the fall instead of 12%.
            let half = T::HALF * s;
            (field.gradient)(&[[x[0] + v[0] * half, x[1] + v[1] * half]], &mut slope, &mut []);
            part.respond(&mut slope);
            let [g] = slope;
            v = [-(chi * g[0]), -(chi * g[1])];
        }
        let (root, spread) = (s.sqrt(), Spread::new(noise, s).of_one(m));
        x = [x[0] + v[0] * s + spread * z[0], x[1] + v[1] * s + spread * z[1]];
        sum = [sum[0] + root * z[0], sum[1] + root * z[1]];
        left -= s;
        done += 1;
        if left <= T::ZERO {
            return Ok((x, sum, done));
        }
        if let Some(field) = field {
            let mut jump = [part.options.control.width];
            (field.gradient)(&[x], &mut slope, &mut jump);
            part.respond(&mut slope);
            [control.width] = jump;
        }
        if noise > T::ZERO {
            draw(&[label], done, &mut normal)?;
        }
    }
}

/// Overwrites the second with the gradient of the potential of the particles at the first, all of them at once.
pub type Sum<'a, T> = dyn FnMut(&[[T; 2]], &mut [[T; 2]]) -> Result<()> + 'a;

/// Moves all particles by common sub-steps, the field being summed anew for each, and `close` pairs as that says. Returns the sub-steps.
///
/// A stream is drawn for each sub-step in the order of the array.
///
/// # Errors
/// [`Error::TooManySubsteps`], [`Error::BecameNotFinite`]; the field's and the generator's.
pub fn together<T: Real>(
    moving: &Moving<'_, T>,
    sum: &mut Sum<'_, T>,
    mut close: Option<&mut Close<'_, T>>,
    generator: &mut dyn Generator,
    moved: Moved<'_, T>,
    gradient: &mut [[T; 2]],
) -> Result<u64> {
    let Options { chi, noise, ref control, .. } = *moving.options;
    let Moved { positions, increments, .. } = moved;
    positions.iter_mut().zip(moving.positions).for_each(|(to, from)| *to = *from);
    if !moving.recorded.is_empty() {
        increments.fill([T::ZERO; 2]);
    }
    let (mut left, mut done) = (moving.dt, 0);
    loop {
        sum(positions, gradient)?;
        let mut s = left;
        let mut near = None;
        if let Some(close) = &mut close {
            s = control.next(moving.dt, left, done, T::ZERO, close.diffusivity())?;
            near = close.seek(positions, s).then_some(&**close);
        }
        if let Some(near) = near {
            near.leave(positions, gradient);
        }
        moving.respond(gradient);
        for (g, &m) in gradient.iter().zip(moving.weights()) {
            let speed = chi.abs() * length(g);
            s = s.min(control.next(moving.dt, left, done, speed, noise / m)?);
        }
        for (g, x) in gradient.iter().zip(positions.iter_mut()) {
            *x = [x[0] - chi * g[0] * s, x[1] - chi * g[1] * s];
        }
        jump(moving, generator, s, done, positions, increments)?;
        if let Some(near) = near {
            near.draw(s, gradient, positions);
        }
        left -= s;
        done += 1;
        if left <= T::ZERO {
            return finite(positions).map(|()| u64::from(done));
        }
    }
}

fn finite<T: Real>(points: &[[T; 2]]) -> Result<()> {
    // Zero times each number: NaN once one is not finite.
    let poison = points.as_flattened().iter().fold(T::ZERO, |sum, &x| sum + x * T::ZERO);
    if poison.is_nan() { Err(Error::BecameNotFinite) } else { Ok(()) }
}

/// Adds the noise of a time `s` to all positions, and to the recorded increments.
fn jump<T: Real>(
    moving: &Moving<'_, T>,
    generator: &mut dyn Generator,
    s: T,
    substep: u32,
    positions: &mut [[T; 2]],
    increments: &mut [[T; 2]],
) -> Result<()> {
    let noise = moving.options.noise;
    if build::NOISELESS && noise == T::ZERO {
        return Ok(());
    }
    let (scale, root) = (Spread::new(noise, s), s.sqrt());
    if !build::TILES {
        // One by one, which draws the same from a stream.
        for (k, ((&label, &m), x)) in moving.labels.iter().zip(moving.weights()).zip(positions).enumerate() {
            let mut normals = [[T::ZERO; 2]];
            normals_of_labels(generator, &[label], moving.step, substep, &mut normals)?;
            let [z] = normals;
            let spread = scale.of(m);
            *x = [x[0] + spread * z[0], x[1] + spread * z[1]];
            if let (Some(1..), Some(to)) = (moving.recorded.get(k), increments.get_mut(k)) {
                *to = [to[0] + root * z[0], to[1] + root * z[1]];
            }
        }
        return Ok(());
    }
    // A smaller tile, for short stacks.
    const FEW: usize = 32;
    let mut from = 0;
    while from < moving.labels.len() {
        let to = from.saturating_add(FEW).min(moving.labels.len());
        let part = from..to;
        from = to;
        let (weights, labels) =
            (moving.weights().get(part.clone()).present()?, moving.labels.get(part.clone()).present()?);
        let (positions, increments) =
            (positions.get_mut(part.clone()).present()?, increments.get_mut(part.clone()).present()?);
        let mut normals = [[T::ZERO; 2]; FEW];
        let normals = normals.get_mut(..labels.len()).present()?;
        normals_of_labels(generator, labels, moving.step, substep, normals)?;
        for ((x, z), &m) in positions.iter_mut().zip(normals.iter()).zip(weights) {
            let spread = scale.of(m);
            *x = [x[0] + spread * z[0], x[1] + spread * z[1]];
        }
        // None is recorded where no cluster was found.
        let recorded = moving.recorded.get(part).unwrap_or(&[]);
        for ((&recorded, z), to) in recorded.iter().zip(normals.iter()).zip(increments) {
            if recorded != 0 {
                *to = [to[0] + root * z[0], to[1] + root * z[1]];
            }
        }
    }
    Ok(())
}

/// Half the noise, one RK4 step of the drift, half the noise (Strang 1968), and `close` pairs as that says. Returns 1.
///
/// # Errors
/// The field's, the generator's; [`Error::BecameNotFinite`].
pub fn strang<T: Real>(
    moving: &Moving<'_, T>,
    sum: Option<&mut Sum<'_, T>>,
    close: Option<&mut Close<'_, T>>,
    generator: &mut dyn Generator,
    moved: Moved<'_, T>,
    stages: &mut rk4::Scratch<'_, T>,
) -> Result<u64> {
    let chi = moving.options.chi;
    let Moved { positions, increments, .. } = moved;
    positions.iter_mut().zip(moving.positions).for_each(|(to, from)| *to = *from);
    if !moving.recorded.is_empty() {
        increments.fill([T::ZERO; 2]);
    }
    let near = close.and_then(|close| close.seek(positions, moving.dt).then_some(&*close));
    let half = T::HALF * moving.dt;
    jump(moving, generator, half, 0, positions, increments)?;
    if let Some(sum) = sum {
        rk4::step(positions.as_flattened_mut(), stages, moving.dt, |_, y, dy| {
            let (points, slopes) = (y.as_chunks::<2>().0, dy.as_chunks_mut::<2>().0);
            sum(points, slopes)?;
            if let Some(near) = near {
                near.leave(points, slopes);
            }
            moving.respond(slopes);
            dy.iter_mut().for_each(|v| *v = -(chi * *v));
            Ok(())
        })?;
    }
    jump(moving, generator, half, 1, positions, increments)?;
    if let Some(near) = near {
        near.draw(moving.dt, stages.spare().as_chunks_mut().0, positions);
    }
    finite(positions).map(|()| 1)
}
