//! The search for clusters by sorting against the descent through cells, and what holds of any clusters.

use std::cell::Cell;

use mollis_core::exec::{Resources, Serial};
use mollis_core::memory::{Carve, Measure};
use mollis_core::pks::collision::Criterion;
use mollis_core::pks::extent::Extent;
use mollis_core::pks::search::{Mesh, Particles, Scratch, Search, find};
use mollis_core::pks::theory::{Constants, Group};
use mollis_core::pks::{CollisionLaw, Merging};
use mollis_reference::pks::clusters;

use crate::draw::Draw;

/// Cells are exact for coordinates on this lattice of the unit square.
const LATTICE: f64 = (1_u64 << 30) as f64;

/// The clusters of some particles.
pub fn search(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let positive = |draw: &mut Draw<'_>, least: i32, most: i32| {
        10_f64.powf(f64::from(least) + f64::from(draw.byte()) / 255.0 * f64::from(most - least))
    };
    let law = Constants::new(positive(&mut draw, -1, 4), positive(&mut draw, -3, 1));
    let dt = positive(&mut draw, -8, 0);
    let kind = draw.pick(&[CollisionLaw::Exact, CollisionLaw::Printed]);
    let merging = draw.pick(&[Merging::All, Merging::Hard]);
    let cells = draw.pick(&[1_u32, 2, 4, 8]);
    let separation = draw.pick(&[0.1, 0.25, 0.01, 1.0]);
    let shifted = draw.rarely(4);
    let equal = draw.rarely(2);
    let (mut positions, mut masses): (Vec<[f64; 2]>, Vec<f64>) = (Vec::new(), Vec::new());
    while !draw.is_empty() && positions.len() < 40 {
        let x = [0, 1].map(|_| f64::from(draw.byte()) * 256.0 + f64::from(draw.byte()));
        let shift = draw.byte();
        let x = match positions.last() {
            // Near the last one, or in its place.
            Some(last) if !shift.is_multiple_of(4) => {
                let size = 2_f64.powi(-i32::from(shift / 4 % 31));
                [0, 1].map(|k| last[k] + size * (x[k] - 32768.0) / 32768.0)
            }
            _ => x.map(|x| x / 65536.0),
        };
        positions.push(x.map(|x| (x.clamp(0.0, 1.0 - 1.0 / LATTICE) * LATTICE).floor() / LATTICE));
        masses.push(if equal { 1.0 } else { positive(&mut draw, -3, 3) });
    }

    let n = positions.len();
    let criterion = Criterion::new(law, kind, merging, 1e-4, dt);
    let settings = Search { separation, mesh: [cells; 2], domain: Some([[0.0; 2], [1.0; 2]]), shifted };
    let got = found(&settings, &criterion, &positions, &masses);
    let mut seen: Vec<usize> = got.concat();
    seen.sort_unstable();
    assert!(seen.windows(2).all(|pair| pair[0] < pair[1]), "clusters overlap");
    assert!(got.iter().all(|members| members.len() >= 2 && members.iter().all(|&i| i < n)));
    if shifted {
        return;
    }

    // Where rounding may decide a comparison either answer is good.
    let doubtful = Cell::new(false);
    let collidable = |count: f64, mass: f64, pairs: f64, moment: f64| {
        let ask = |pairs: f64, moment: f64| criterion.collidable(&Group { count, mass, pairs }, moment);
        let answer = ask(pairs, moment);
        for sign in [-1.0, 1.0] {
            let other = ask(pairs + sign * 1e-14 * mass * mass, moment * (1.0 + sign * 1e-9));
            doubtful.set(doubtful.get() || other != answer || ask(pairs, moment * (1.0 - sign * 1e-9)) != answer);
        }
        answer
    };
    let want = |eta: f64| {
        let side = 1.0 / f64::from(cells);
        let mut all = Vec::new();
        for cell in 0..cells * cells {
            let low = [f64::from(cell % cells) * side, f64::from(cell / cells) * side];
            let inside = |x: &[f64; 2]| (0..2).all(|k| x[k] >= low[k] && x[k] < low[k] + side);
            let members: Vec<usize> = (0..n).filter(|&i| inside(&positions[i])).collect();
            let part: Vec<[f64; 2]> = members.iter().map(|&i| positions[i]).collect();
            let weights: Vec<f64> = members.iter().map(|&i| masses[i]).collect();
            let clusters = clusters(&part, &weights, low, side, eta, 31, &collidable);
            all.extend(clusters.into_iter().map(|c| c.into_iter().map(|k| members[k]).collect::<Vec<_>>()));
        }
        all.sort();
        all
    };
    let wanted = want(separation);
    if doubtful.get() || want(separation * (1.0 + 1e-9)) != wanted || want(separation * (1.0 - 1e-9)) != wanted {
        return;
    }
    assert_eq!(got, wanted, "{kind:?} {merging:?}, {cells} cells each way: {positions:?} {masses:?}");
}

/// Lists of particles in ascending order.
fn found(
    settings: &Search<f64>,
    criterion: &Criterion<f64>,
    positions: &[[f64; 2]],
    masses: &[f64],
) -> Vec<Vec<usize>> {
    let n = positions.len();
    let bytes = Measure::of(|space| Scratch::<f64>::layout(space, n).map(|_| ())).expect("few");
    let mut memory = vec![0xAB_u8; bytes + 64];
    let start = memory.as_ptr().align_offset(64);
    let mut carve = Carve::reopen(&mut memory[start..start + bytes]).expect("aligned");
    let mut scratch = Scratch::layout(&mut carve, n).expect("as measured");
    let extent = Extent::of(positions, masses, &Serial).expect("sound particles");
    let mesh = Mesh::new(settings, &extent, 7, 1.0);
    let particles = Particles { positions, masses, charges: None, smallest: extent.smallest, medium: None };
    find(settings, criterion, &mesh, particles, Resources::default(), &mut scratch).expect("nothing stops it");
    let mut out = Vec::new();
    for cluster in scratch.clusters() {
        let mut members: Vec<usize> = scratch.members(cluster.first, cluster.count).collect();
        members.sort_unstable();
        out.push(members);
    }
    out.sort();
    out
}
