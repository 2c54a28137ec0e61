//! Pictures of runs, written as PNG and SVG.
//!
//! [`canvas`] draws, [`axis`] finds round ticks, [`chart`] makes frames with curves, maps and legends; `curves` and
//! `planes` turn runs into charts.

pub mod axis;
pub mod canvas;
pub mod chart;
mod curves;
mod planes;

use anyhow::{Result, bail, ensure};
use mollis_core::exec::Executor;

use crate::results::CaseResult;
use crate::scene::Picture;
use canvas::Canvas;

/// Draws a picture of a scene's results.
pub fn picture(picture: &Picture, results: &[CaseResult<'_>], executor: &dyn Executor) -> Result<Canvas> {
    let wanted = |result: &&CaseResult<'_>| picture.case.as_ref().is_none_or(|name| result.scene.name == *name);
    let results: Vec<&CaseResult<'_>> = results.iter().filter(wanted).collect();
    ensure!(!results.is_empty(), "no case to draw");
    match picture.kind.as_str() {
        "trajectories" => curves::trajectories(picture, &results),
        "moment" => curves::moment(picture, &results),
        "count" => curves::count(picture, &results),
        "convergence" => curves::convergence(picture, &results),
        "profile" => curves::profile(picture, &results),
        "density" if results[0].scene.dimension == 1 => curves::density(picture, &results),
        "density" => planes::density(picture, &results, executor),
        "particles" => planes::particles(picture, &results),
        "field" => planes::field(picture, &results, executor),
        other => bail!("{other}: no such kind"),
    }
}

/// A time as a caption shows it: multiples of a decimal step carry roundings that nobody wants to read.
fn shown(time: f64) -> String {
    format!("{time:.6e}").parse::<f64>().map_or_else(|_| time.to_string(), |rounded| rounded.to_string())
}

#[cfg(test)]
mod tests {
    #[test]
    fn captions_are_short() {
        assert_eq!(super::shown(140.0 * 0.01), "1.4");
        assert_eq!(super::shown(200.0 * 2e-6), "0.0004");
        assert_eq!(super::shown(0.0), "0");
    }
}
