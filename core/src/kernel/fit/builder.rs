//! Writes the panels of a fit into the block.

use crate::checked::Present;
use crate::error::{Error, Result};
use crate::kernel::chebyshev::Fit;
use crate::kernel::edge_series::LENGTH;
use crate::kernel::fitted_term::{HEADER, Panel, Variable, rooted};
use crate::kernel::profile::sphere;
use crate::real::{DoubleWord, Scalar};

/// The variable of a Chebyshev series: `scale` and `shift` map it to [-1, 1] after its power `root` is taken.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    pub(super) variable: Variable,
    pub(super) scale: f64,
    pub(super) shift: f64,
    pub(super) root: f64,
}

impl Axis {
    /// From v = `from` to v = `to`.
    pub(super) fn between(variable: Variable, root: f64, from: f64, to: f64) -> Self {
        let scale = 2.0 / (to - from);
        Self { variable, scale, shift: -1.0 - from * scale, root }
    }

    /// From t = 0, at the edge, to t = `to`.
    pub(super) fn edge(variable: Variable, root: f64, to: f64) -> Self {
        Self::between(variable, root, if root == 0.0 { rooted(0.0, root) } else { 0.0 }, rooted(to, root))
    }

    pub(super) fn powers(variable: Variable) -> Self {
        Self { variable, scale: 0.0, shift: 0.0, root: 1.0 }
    }

    /// t at x on an axis from the edge.
    pub(super) fn t(&self, x: f64) -> f64 {
        let v = ((x - self.shift) / self.scale).max(if self.root == 0.0 { f64::NEG_INFINITY } else { 0.0 });
        if self.root == 0.0 {
            Scalar::exp(v)
        } else if self.root == 0.5 {
            v * v
        } else if self.root == 0.25 {
            (v * v) * (v * v)
        } else {
            Scalar::pow(v, 1.0 / self.root)
        }
    }
}

/// Writes the tables of successive parts.
pub(crate) struct Builder<'a> {
    pub(super) tables: &'a mut [f64],
    pub(super) headers: usize,
    pub(super) next: usize,
    /// The largest error of a fit, relative to the function's size on its panel.
    pub(crate) error: f64,
    /// By how much the fits of a host's kernel miss its value, gradient factor and Laplacian, relative to their sizes.
    pub(crate) errors: [f64; 3],
    /// An upper bound of the panels' ends.
    pub(super) limit: f64,
    /// The largest coefficient that the sum's scalar can hold.
    pub(super) largest: f64,
    /// The sum of the screened terms inside a compact mollifier, in powers of t and units of delta, and its reserved place in the tables. For
    /// small delta psi and the Newtonian parts of the terms are large and cancel in a Morse potential, so they are added before rounding.
    pub(super) screened: [[DoubleWord<f64>; 3]; LENGTH],
    pub(super) reserved: Option<(usize, usize)>,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(tables: &'a mut [f64], largest: f64) -> Self {
        Self {
            tables,
            headers: 0,
            next: 0,
            error: 0.0,
            errors: [0.0; 3],
            limit: f64::INFINITY,
            largest,
            screened: [[DoubleWord::ZERO; 3]; LENGTH],
            reserved: None,
        }
    }

    /// Reserves headers for a part and returns the position of the first.
    pub(super) fn begin(&mut self, panels: usize) -> usize {
        self.headers = self.next;
        self.next += panels * HEADER;
        self.headers
    }

    /// Returns an error for a number that the sum's scalar cannot hold.
    pub(super) fn hold(&self, value: f64) -> Result<f64> {
        if value.abs() <= self.largest { Ok(value) } else { Err(Error::OutOfDomain) }
    }

    /// Stores a panel's header.
    pub(super) fn header(&mut self, end: f64, axis: Axis, start: usize, len: usize) -> Result<()> {
        let Axis { variable, scale, shift, root } = axis;
        let header = Panel { end: end.min(self.limit), variable, start, len, scale, shift, root };
        let place = self.tables.get_mut(self.headers..).and_then(|t| t.first_chunk_mut::<HEADER>());
        *place.ok_or(Error::Unsupported)? = header.to_header();
        self.headers += HEADER;
        Ok(())
    }

    /// Reserves the next triples of the tables.
    pub(super) fn triples(&mut self, len: usize) -> Result<&mut [[f64; 3]]> {
        let free = self.tables.get_mut(self.next..).ok_or(Error::Unsupported)?;
        self.next += 3 * len;
        free.as_chunks_mut::<3>().0.get_mut(..len).ok_or(Error::Unsupported)
    }

    /// Stores a panel of powers in two words: coefficients times `factors`.
    pub(super) fn powers(
        &mut self,
        end: f64,
        variable: Variable,
        coefficients: &[[DoubleWord<f64>; 3]],
        factors: [f64; 3],
    ) -> Result<()> {
        let (len, start) = (coefficients.len(), self.next);
        let mut low = [[0.0; 3]; LENGTH];
        for (k, c) in coefficients.iter().enumerate() {
            let mut high = [0.0; 3];
            for (n, (slot, (&c, factor))) in high.iter_mut().zip(c.iter().zip(factors)).enumerate() {
                let product = c * factor;
                *slot = self.hold(product.hi)?;
                if let Some(low) = low.get_mut(k).and_then(|low| low.get_mut(n)) {
                    // the second word is invalid where the product leaves the normal range
                    *low = if product.lo.is_finite() { product.lo } else { 0.0 };
                }
            }
            for slot in self.triples(1)? {
                *slot = high;
            }
        }
        self.triples(len)?.iter_mut().zip(low).for_each(|(slot, low)| *slot = low);
        self.header(end, Axis::powers(variable), start, len)
    }

    /// Stores a fit: coefficients times `factors`.
    pub(super) fn fitted(&mut self, end: f64, axis: Axis, fit: &Fit, factors: [f64; 3]) -> Result<()> {
        let (len, start) = (fit.len, self.next);
        for c in fit.coefficients.iter().take(len) {
            let [u, g, l] = factors;
            let c = [self.hold(c[0] * u)?, self.hold(c[1] * g)?, self.hold(c[2] * l)?];
            self.triples(1)?.iter_mut().for_each(|slot| *slot = c);
        }
        self.error = self.error.max(fit.error);
        self.header(end, axis, start, len)
    }

    /// Writes the sum of the screened terms to its reserved place, and begins another. Must be called after all terms under a mollifier.
    pub(crate) fn finish(&mut self, dimension: usize, delta: f64) -> Result<()> {
        let Some((headers, start)) = self.reserved.take() else { return Ok(()) };
        let a = 2.0 - dimension as f64;
        let s = sphere(dimension);
        let factors = [Scalar::pow(delta, a) / s, Scalar::pow(delta, a - 2.0) / s, Scalar::pow(delta, a - 2.0) / s];
        let screened = core::mem::replace(&mut self.screened, [[DoubleWord::ZERO; 3]; LENGTH]);
        let size = screened
            .iter()
            .fold([0.0_f64; 3], |m, c| [m[0].max(c[0].hi.abs()), m[1].max(c[1].hi.abs()), m[2].max(c[2].hi.abs())]);
        let matters = |c: &[DoubleWord<f64>; 3]| c.iter().zip(size).any(|(v, s)| v.hi.abs() > 1e-18 * s);
        let len = screened.iter().rposition(matters).map_or(1, |last| last + 1);
        let (keep_headers, keep_next) = (self.headers, self.next);
        (self.headers, self.next) = (headers, start);
        self.powers(delta, Variable::EdgePowers, screened.get(..len).present()?, factors)?;
        (self.headers, self.next) = (keep_headers, keep_next);
        Ok(())
    }
}
