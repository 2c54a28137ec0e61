//! The results of a scene: its cases, and the studies of their grids.

use crate::history::History;
use crate::scene::Scene;

/// One case of a scene after its run.
pub struct CaseResult<'a> {
    /// The case.
    pub scene: &'a Scene,
    /// Its run; with a study the one on the finest grid.
    pub main: History,
    /// The study, coarse to fine.
    pub study: Vec<StudyPoint>,
}

/// One run of a study.
#[derive(Clone, Debug)]
pub struct StudyPoint {
    /// Spacing.
    pub h: f64,
    /// Particles.
    pub particles: usize,
    /// L1 errors of positions and densities at the end; NaN where there is none.
    pub errors: [f64; 2],
}

/// The columns of a study's table.
pub const STUDY_COLUMNS: [&str; 6] =
    ["h", "particles", "error_positions", "rate_positions", "error_density", "rate_density"];

/// The rows of a study's table: a rate compares a spacing with the coarser one before it.
pub fn study_rows(study: &[StudyPoint]) -> Vec<Vec<f64>> {
    let rate = |i: usize, which: usize| match i.checked_sub(1).and_then(|i| study.get(i)) {
        Some(coarse) => (coarse.errors[which] / study[i].errors[which]).ln() / (coarse.h / study[i].h).ln(),
        None => f64::NAN,
    };
    let row = |(i, point): (usize, &StudyPoint)| {
        vec![point.h, point.particles as f64, point.errors[0], rate(i, 0), point.errors[1], rate(i, 1)]
    };
    study.iter().enumerate().map(row).collect()
}
