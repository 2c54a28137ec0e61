//! Curves of a mollifier over the radius: Anderson, Figure 1.

use anyhow::{Context, Result};
use mollis_core::mollifier::Blob;

use super::kernel::mollifier;
use crate::history::History;
use crate::scene::Scene;

/// Points of a curve.
const POINTS: usize = 300;

/// Density and potential from 0 to 1.5 delta, a row each.
pub fn curves(scene: &Scene) -> Result<History> {
    match scene.dimension {
        1 => sample::<1>(scene),
        2 => sample::<2>(scene),
        _ => sample::<3>(scene),
    }
}

fn sample<const D: usize>(scene: &Scene) -> Result<History> {
    let softening = scene.mollifier.as_ref();
    let delta = softening.map_or(1.0, |softening| softening.delta(Some(1.0)));
    let blob = Blob::<f64, D>::new(mollifier(softening), delta).context("mollifier")?;
    let row = |i: usize| {
        let r = 1.5 * delta * i as f64 / POINTS as f64;
        vec![r, blob.density(r), blob.potential(r)]
    };
    let plan = vec!["skipped: everything that moves".to_owned()];
    Ok(History {
        columns: scene.columns(),
        rows: (0..=POINTS).map(row).collect(),
        plan,
        done: true,
        ..History::default()
    })
}
