//! The search for clusters by sorting, compared with the descent through cells.

use mollis_core::exec::{Resources, Serial};
use mollis_core::memory::{ALIGN, Carve, Measure};
use mollis_core::pks::collision::Criterion;
use mollis_core::pks::extent::Extent;
use mollis_core::pks::search::{Mesh, Particles, Scratch, Search, find};
use mollis_core::pks::theory::{Constants, Group};
use mollis_core::pks::{CollisionLaw, Merging};
use mollis_core::special::{incomplete_gamma, normal};
use mollis_tests::Split;

fn search(
    search: &Search<f64>,
    criterion: &Criterion<f64>,
    step: u64,
    positions: &[[f64; 2]],
    masses: &[f64],
) -> Vec<Vec<usize>> {
    let n = positions.len();
    let bytes = Measure::of(|space| Scratch::<f64>::layout(space, n).map(|_| ())).unwrap();
    // Arbitrary contents, between canaries.
    let mut memory = vec![0xAB_u8; bytes + 3 * ALIGN];
    let start = memory.as_ptr().align_offset(ALIGN) + ALIGN;
    let mut carve = Carve::reopen(&mut memory[start..start + bytes]).unwrap();
    let mut scratch = Scratch::layout(&mut carve, n).unwrap();
    let extent = Extent::of(positions, masses, &Serial).unwrap();
    let mesh = Mesh::new(search, &extent, step, 1.0);
    let particles = Particles { positions, masses, charges: None, smallest: extent.smallest, medium: None };
    find(search, criterion, &mesh, particles, Resources::default(), &mut scratch).unwrap();
    let mut out = Vec::new();
    for cluster in scratch.clusters() {
        let mut members: Vec<usize> = scratch.members(cluster.first, cluster.count).collect();
        members.sort_unstable();
        let mass: f64 = members.iter().map(|&i| masses[i]).sum();
        let centre = [0, 1].map(|k| members.iter().map(|&i| masses[i] * positions[i][k]).sum::<f64>() / mass);
        let square = |i: usize| (positions[i][0] - centre[0]).powi(2) + (positions[i][1] - centre[1]).powi(2);
        let moment = members.iter().map(|&i| masses[i] * square(i)).sum::<f64>() / mass;
        let pairs = mass * mass - members.iter().map(|&i| masses[i] * masses[i]).sum::<f64>();
        // The sums here cancel against coordinates of order one, with n roundings.
        let rounding = 8.0 * n as f64 * f64::EPSILON;
        assert!((cluster.group.mass / mass - 1.0).abs() < rounding && cluster.group.count == members.len() as f64);
        assert!((cluster.moment - moment).abs() <= rounding * (moment + moment.sqrt()), "{} {moment}", cluster.moment);
        assert!((cluster.group.pairs - pairs).abs() < rounding * mass * mass);
        assert!((0..2).all(|k| (cluster.centre[k] - centre[k]).abs() < rounding));
        out.push(members);
    }
    out.sort();
    assert!(memory[..start].iter().chain(&memory[start + bytes..]).all(|&b| b == 0xAB));
    out
}

/// Particles in random clumps, on a lattice of 2^-30 so that cells are exact in both programs.
fn clumps(random: &mut Split, n: usize) -> (Vec<[f64; 2]>, Vec<f64>) {
    let lattice = |v: f64| (v.clamp(0.0, 1.0 - 2.0_f64.powi(-30)) * 2.0_f64.powi(30)).floor() / 2.0_f64.powi(30);
    let mut centre = [0.5, 0.5];
    let mut size = 1.0;
    let mut positions: Vec<[f64; 2]> = Vec::new();
    for _ in 0..n {
        if random.uniform() < 0.1 {
            centre = [random.uniform(), random.uniform()];
            size = 10_f64.powf(-7.0 * random.uniform());
        }
        // Some particles coincide.
        let x = if random.uniform() < 0.05 && !positions.is_empty() {
            positions[positions.len() / 2]
        } else {
            centre.map(|c| lattice(c + size * (random.uniform() - 0.5)))
        };
        positions.push(x);
    }
    (positions, (0..n).map(|_| 10_f64.powf(2.0 * random.uniform() - 1.0)).collect())
}

#[test]
fn as_the_descent_through_cells() {
    let mut random = Split(4);
    let mut found = 0;
    for round in 0..60 {
        for n in [0, 1, 2, 3, 5, 17, 60, 600] {
            if n == 600 && round > 8 {
                continue;
            }
            let (positions, masses) = clumps(&mut random, n);
            let noise = 10_f64.powf(2.0 * random.uniform() - 2.0);
            let law = Constants::new(10_f64.powf(3.0 * random.uniform()), noise);
            let dt = 10_f64.powf(-6.0 * random.uniform() - 2.0);
            for (kind, merging) in [
                (CollisionLaw::Exact, Merging::All),
                (CollisionLaw::Exact, Merging::Hard),
                (CollisionLaw::Printed, Merging::All),
            ] {
                let p = 1e-4;
                let criterion = Criterion::new(law, kind, merging, p, dt);
                let collidable = |count: f64, mass: f64, pairs: f64, moment: f64| {
                    let nu = count - 2.0 - law.chi * pairs / (8.0 * core::f64::consts::PI * noise);
                    if !(if merging == Merging::Hard { nu <= -1.0 } else { nu < 0.0 }) {
                        return false;
                    }
                    match kind {
                        CollisionLaw::Exact => incomplete_gamma::upper(-nu, moment * mass / (4.0 * noise * dt)) > p,
                        CollisionLaw::Printed => {
                            let alpha =
                                4.0 * noise * (count - 1.0) / mass - law.chi * pairs / mass / core::f64::consts::TAU;
                            let beta = (2.0 * noise / mass).sqrt();
                            moment + alpha * dt + 2.0 * beta * (moment * dt).sqrt() * normal::quantile(p) < 0.0
                        }
                    }
                };
                for (mesh, coarse) in [([1, 1], 1.0), ([3, 2], 1.0 / 3.0), ([4, 4], 0.25)] {
                    let domain = Some([[0.0; 2], [1.0; 2]]);
                    let settings = Search { separation: 0.1, mesh, domain, shifted: false };
                    let got = search(&settings, &criterion, 7, &positions, &masses);
                    let mut want = Vec::new();
                    if mesh[0] == 3 {
                        // Cells of side 1/3 are not on the lattice: here the clusters are only checked to be disjoint.
                        let mut seen: Vec<usize> = got.concat();
                        seen.sort_unstable();
                        seen.dedup();
                        assert_eq!(seen.len(), got.concat().len(), "clusters overlap");
                        continue;
                    }
                    let cells = (1.0 / coarse) as usize;
                    for i in 0..cells * cells {
                        let low = [(i % cells) as f64 * coarse, (i / cells) as f64 * coarse];
                        let inside = |x: &[f64; 2]| (0..2).all(|k| x[k] >= low[k] && x[k] < low[k] + coarse);
                        let members: Vec<usize> = (0..n).filter(|&i| inside(&positions[i])).collect();
                        let part: Vec<[f64; 2]> = members.iter().map(|&i| positions[i]).collect();
                        let weights: Vec<f64> = members.iter().map(|&i| masses[i]).collect();
                        let clusters =
                            mollis_reference::pks::clusters(&part, &weights, low, coarse, 0.1, 31, &collidable);
                        want.extend(
                            clusters.into_iter().map(|c| c.into_iter().map(|k| members[k]).collect::<Vec<_>>()),
                        );
                    }
                    want.sort();
                    assert_eq!(got, want, "round {round} n {n} {kind:?} {merging:?} mesh {mesh:?}");
                    found += got.len();
                }
            }
        }
    }
    assert!(found > 1000, "{found}");
}

/// Many particles take another path than few: they are distributed to buckets, and only what the keys cannot exclude is examined.
#[test]
fn many_particles_as_the_descent_through_cells() {
    let mut random = Split(9);
    let (mut pairs, mut groups, mut whole) = (0, 0, 0);
    for round in 0..37_usize {
        // The last round has more than one block of 32,768 particles.
        let n = if round == 36 { 40_000 } else { [513, 700, 2000, 6000][round % 4] + round };
        let lattice = |v: f64| (v.clamp(0.0, 1.0 - 2.0_f64.powi(-30)) * 2.0_f64.powi(30)).floor() / 2.0_f64.powi(30);
        let (mut positions, mut masses) = clumps(&mut random, n);
        // Uniform, in one clump, or in clumps of any size.
        match round % 3 {
            0 => positions.iter_mut().flatten().for_each(|x| *x = lattice(random.uniform())),
            1 => positions.iter_mut().flatten().for_each(|x| *x = lattice(0.3 + 0.01 * random.uniform())),
            _ => (),
        }
        // Equal masses, one heavy particle among them, or random masses.
        if round % 5 < 3 {
            masses.fill(1.0);
        }
        if round % 5 == 1 {
            masses[n / 3] = 0.3 * n as f64;
        }
        let mass: f64 = masses.iter().sum();
        // The critical value is gamma chi M = 4 mu with mu~ = mu M / n. The excess ranges from far below to far above it.
        let excess = 10_f64.powf(5.0 * random.uniform() - 1.0);
        let noise = 1e-3 * mass / n as f64;
        let law = Constants::new(excess * 8.0 * core::f64::consts::PI * 1e-3 / mass, noise);
        let dt = 10_f64.powf(-8.0 * random.uniform());
        for (kind, merging) in [
            (CollisionLaw::Exact, Merging::All),
            (CollisionLaw::Exact, Merging::Hard),
            (CollisionLaw::Printed, Merging::All),
        ] {
            let criterion = Criterion::new(law, kind, merging, 1e-4, dt);
            let collidable = |count: f64, mass: f64, pairs: f64, moment: f64| {
                criterion.collidable(&Group { count, mass, pairs }, moment)
            };
            let domain = Some([[0.0; 2], [1.0; 2]]);
            let settings = Search { domain, shifted: false, ..Search::default() };
            let got = search(&settings, &criterion, 7, &positions, &masses);
            let mut want = mollis_reference::pks::clusters(&positions, &masses, [0.0; 2], 1.0, 0.1, 31, &collidable);
            want.iter_mut().for_each(|members| members.sort_unstable());
            want.sort();
            assert_eq!(got, want, "round {round} n {n} {kind:?} {merging:?} excess {excess} dt {dt}");
            for members in got {
                match members.len() {
                    2 => pairs += 1,
                    k if k > n / 2 => whole += 1,
                    _ => groups += 1,
                }
            }
        }
    }
    assert!(pairs > 1000 && groups > 500 && whole > 3, "{pairs} {groups} {whole}");
}

#[test]
fn a_shift_finds_what_lies_across_a_border() {
    // Two particles on both sides of the middle of the domain, others far away. Unshifted, only the whole domain holds both.
    let positions = [[0.5 - 1e-6, 0.5], [0.5 + 1e-6, 0.5], [0.9, 0.9], [0.1, 0.1], [0.1, 0.9], [0.9, 0.1]];
    let masses = [1.0; 6];
    let criterion = Criterion::new(Constants::new(5.0, 1.0), CollisionLaw::Exact, Merging::All, 1e-4, 1e-6);
    let domain = Some([[0.0; 2], [1.0; 2]]);
    let fixed = Search { domain, shifted: false, ..Search::default() };
    let shifted = Search { domain, ..Search::default() };
    let hits = |settings: &Search<f64>| {
        (0..100).filter(|&step| search(settings, &criterion, step, &positions, &masses) == [[0, 1]]).count()
    };
    assert_eq!(hits(&fixed), 0);
    assert!(hits(&shifted) > 95);
}
