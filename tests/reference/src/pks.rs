//! The search of Zhelezov & Fatkullin, Section 3.3, as described there: cells of a mesh, refined into four.

/// The numbers of a cell for the test whether its particles may collide: count, total mass, `M^2 - sum m^2`, second moment.
pub type Collidable<'a> = &'a dyn Fn(f64, f64, f64, f64) -> bool;

/// The clusters of a square with corner `origin` and this side, refined at most `depth` times: lists of particles in ascending order.
///
/// A cell is kept if `Y / s^2 < eta` (s is its diagonal) and it is collidable. Otherwise it is refined if it holds more than one particle.
pub fn clusters(
    positions: &[[f64; 2]],
    masses: &[f64],
    origin: [f64; 2],
    side: f64,
    eta: f64,
    depth: u32,
    collidable: Collidable<'_>,
) -> Vec<Vec<usize>> {
    let mut out = Vec::new();
    refine(positions, masses, (0..positions.len()).collect(), origin, side, eta, depth, collidable, &mut out);
    out.sort();
    out
}

#[allow(clippy::too_many_arguments)]
fn refine(
    positions: &[[f64; 2]],
    masses: &[f64],
    members: Vec<usize>,
    origin: [f64; 2],
    side: f64,
    eta: f64,
    depth: u32,
    collidable: Collidable<'_>,
    out: &mut Vec<Vec<usize>>,
) {
    if members.len() < 2 {
        return;
    }
    let mass: f64 = members.iter().map(|&i| masses[i]).sum();
    let squares: f64 = members.iter().map(|&i| masses[i] * masses[i]).sum();
    // (2.20), pair by pair.
    let mut moment = 0.0;
    for &i in &members {
        for &j in &members {
            let d = [positions[i][0] - positions[j][0], positions[i][1] - positions[j][1]];
            moment += masses[i] * masses[j] * (d[0] * d[0] + d[1] * d[1]) / (2.0 * mass * mass);
        }
    }
    let separated = moment / (2.0 * side * side) < eta;
    if separated && collidable(members.len() as f64, mass, mass * mass - squares, moment) {
        out.push(members);
        return;
    }
    if depth == 0 {
        return;
    }
    let half = side / 2.0;
    for quarter in 0..4 {
        let low = [origin[0] + half * f64::from(quarter % 2), origin[1] + half * f64::from(quarter / 2)];
        let inside = |&i: &usize| (0..2).all(|k| positions[i][k] >= low[k] && positions[i][k] < low[k] + half);
        let members = members.iter().copied().filter(|i| inside(i)).collect();
        refine(positions, masses, members, low, half, eta, depth - 1, collidable, out);
    }
}
