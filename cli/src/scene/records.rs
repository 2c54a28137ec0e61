//! What a run of a scene records: the columns and rows of `diagnostics.csv`, and whether densities are carried.
//!
//! Stated once: the models fill these columns, and the checks of pictures and expectations rest on them.

use super::exact::Exact;
use super::types::{Law, Model, Sampling, Scene, Shape};

/// Rows of an interval of time may miss its ends by this part of a step: a time is a decimal, a row's time a rounded product.
pub const SLACK: f64 = 1e-6;

/// `value / unit` as a whole number, if it is one.
pub fn multiple(value: f64, unit: f64) -> Option<u64> {
    let ratio = value / unit;
    // Decimal steps and times carry one rounding each, and the quotient one more.
    ((ratio - ratio.round()).abs() <= 1e-9 * ratio.abs().max(1.0) && ratio < 1e15).then(|| ratio.round() as u64)
}

impl Scene {
    /// The names of the columns of diagnostics; the first is the time.
    pub fn columns(&self) -> Vec<String> {
        let mut columns: Vec<String> = Vec::new();
        let mut add = |names: &[&str]| columns.extend(names.iter().map(|&name| name.to_owned()));
        match self.model {
            Model::Profile => add(&["r", "density", "potential"]),
            Model::Cluster => {
                add(&["time", "second_moment", "plain", "corrected", "error_plain", "error_corrected"]);
            }
            Model::Pks => {
                add(&["time", "particles", "centre_x", "centre_y", "second_moment", "heaviest", "two_heaviest"]);
                let parts = self.initial.len();
                columns.extend((0..if parts > 1 { parts } else { 0 }).map(|part| format!("part_moment_{part}")));
            }
            Model::Blob | Model::Particle => {
                add(&["time"]);
                add(&["centre_x", "centre_y", "centre_z"][..self.dimension]);
                add(&["second_moment"]);
                if self.turns() {
                    add(&["axis_angle"]);
                }
                if self.output.energy {
                    add(&["energy"]);
                }
                let density = self.lacks_density().is_none();
                if density {
                    add(&["density_maximum", "overlap"]);
                }
                if self.exact().is_some() {
                    add(if density { &["error_positions", "error_density"] } else { &["error_positions"] });
                }
            }
        }
        columns
    }

    /// Whether there is a column of this name.
    pub fn has_column(&self, name: &str) -> bool {
        self.columns().iter().any(|column| column == name)
    }

    /// Why the run carries no density along trajectories; nothing if it carries one.
    pub fn lacks_density(&self) -> Option<&'static str> {
        match self.model {
            Model::Blob | Model::Particle if self.diffusion.is_some() => Some("with diffusion none is carried"),
            Model::Blob | Model::Particle if !self.output.density => Some("output.density is not set"),
            // Where the data give none, the sum of the blobs is the density.
            Model::Blob => None,
            Model::Particle if self.kernel.iter().any(|term| term.law == Law::Newtonian) => {
                Some("without a mollifier the density under a Newtonian kernel is one of point masses")
            }
            Model::Particle if !self.initial.iter().all(|part| part.shape.has_density()) => {
                Some("some points come without a density, and without a mollifier there is no sum of blobs")
            }
            Model::Particle => None,
            _ => Some("not of this model"),
        }
    }

    /// The exact solution that errors are measured against: L1 norms of densities need the cells of a grid; of given points distances are added.
    pub fn exact(&self) -> Option<Exact> {
        let given = self.initial.iter().all(|part| !part.shape.is_sampled());
        Exact::of(self).filter(|_| given || matches!(self.sampling, Some(Sampling::Grid { .. })))
    }

    /// Whether the velocity is partly a turned gradient.
    pub fn turns(&self) -> bool {
        self.combination[1] != 0.0
    }

    /// The step at which `time` is reached, if there is one.
    pub fn step_at(&self, time: f64) -> Option<u64> {
        multiple(time, self.dt).filter(|&step| step <= self.steps)
    }

    /// Whether a row of diagnostics is written at this step.
    pub fn has_row(&self, step: u64) -> bool {
        step.is_multiple_of(self.output.every) || step == self.steps
    }

    /// The number of rows from one time to another.
    pub fn rows_between(&self, from: f64, to: f64) -> u64 {
        let first = (from / self.dt - SLACK).ceil().max(0.0) as u64;
        let last = ((to / self.dt + SLACK).floor().max(-1.0) + 1.0) as u64;
        // Rows at multiples of `every` below a step, and the last one if it is none of them.
        let below = |step: u64| step.min(self.steps + 1).div_ceil(self.output.every);
        let extra = !self.steps.is_multiple_of(self.output.every) && (first..last).contains(&self.steps);
        below(last).saturating_sub(below(first)) + u64::from(extra)
    }
}

impl Shape {
    /// Whether particles are sampled from a density, not given.
    pub fn is_sampled(&self) -> bool {
        !matches!(self, Shape::Points(..) | Shape::File(..))
    }

    /// Whether every particle of this shape comes with a density.
    pub fn has_density(&self) -> bool {
        !matches!(self, Shape::Points(..) | Shape::File(_, false))
    }
}
