//! The prepared block in the caller's buffer: head, records of terms and parts, tables. It contains no pointers, so it may be copied,
//! moved and saved, and opened on any machine of the same byte order.

use super::fit::{Builder, HOST_PANELS, Host, Task, capacity};
use super::fitted_term::{FittedTerm, Outer, RECORD};
use super::law::{Law, MAX_KNOTS, MAX_TERMS, Supplied, Term};
use super::profile::Profile;
use super::table::{self, Demands, Domain, Head, Table};
use super::{KEPT, Kernel, OTHERS, Others};
use crate::error::{Error, Result};
use crate::memory::{ALIGN, Carve, Measure, Space, View};
use crate::mollifier::{Blob, Mollifier};
use crate::real::{Real, Scalar, quotient};
use crate::simd::{ROW, ROWS};

/// "mollis K" in ASCII, as a number. Swapped bytes identify a block of the other byte order.
const MAGIC: u64 = 0x6D6F_6C6C_6973_204B;
/// Incremented whenever the format of a block changes.
const VERSION: u64 = 5;
/// Length of the head, in numbers.
const HEAD: usize = 8;
/// Length of a term's record, in numbers.
const TERM: usize = 3;
/// Length of the record before the terms: the bits of delta and of the Newtonian coefficient, the fit error, and those of a host's functions.
const START: usize = 6;
/// Length of all records, in numbers.
const RECORDS: usize = START + MAX_TERMS * (TERM + RECORD) + table::RECORD;

/// Bytes of a block without tables.
const BYTES: usize = (8 * HEAD).next_multiple_of(ALIGN) + (8 * RECORDS).next_multiple_of(ALIGN);

/// The tolerance of a user's kernel, if none is stated. Smooth kernels reach 1e-13 in double precision and 3e-6 in single, where roundings of the distance prevail.
/// In double precision it leaves room for functions that are not accurate to their last digits.
fn default_tolerance<T: Real>() -> f64 {
    if T::DIGITS > 24 { 1e-10 } else { 1e-5 }
}

/// The arrays of a block.
struct Arrays<'w, T> {
    head: &'w mut [u64],
    records: &'w mut [f64],
    /// Series for single distances, in double precision for both scalars.
    series: &'w mut [f64],
    /// The table for sums.
    rows: &'w mut [[T; ROW]],
}

/// Sizes of the arrays whose length depends on the terms.
#[derive(Clone, Copy)]
struct Sizes {
    series: usize,
    rows: usize,
}

fn layout<'w, T: Real>(space: &mut impl Space<'w>, sizes: Sizes) -> Result<Arrays<'w, T>> {
    Ok(Arrays {
        head: space.try_array(HEAD)?,
        records: space.try_array(RECORDS)?,
        series: space.try_array(sizes.series)?,
        rows: space.try_array(sizes.rows)?,
    })
}

/// Checks the terms and returns the sizes of their tables.
fn check<const D: usize>(terms: &[Term], supplied: bool, mollifier: Mollifier) -> Result<Sizes> {
    mollifier.check(D)?;
    let count = terms.len() + usize::from(supplied);
    if count == 0 || count > MAX_TERMS {
        return Err(Error::KernelTerms);
    }
    if !cfg!(feature = "kernels") {
        // The only coefficient is used as given, which avoids arithmetic in double precision.
        return match terms {
            [Term { law: Law::Newtonian, coefficient }] if !supplied => {
                if Scalar::is_finite(*coefficient) {
                    Ok(Sizes { series: 0, rows: 0 })
                } else {
                    Err(Error::NotFinite)
                }
            }
            _ => Err(Error::Unsupported),
        };
    }
    let profile = if cfg!(feature = "kernels") { Profile::new(mollifier, D) } else { None };
    // A term is prepared for each radius of a combination.
    let radii = mollifier.radii() as usize;
    let others = terms.iter().filter(|term| !term.law.is_newtonian(D)).count();
    if radii > 1 && others * radii > MAX_TERMS {
        return Err(Error::KernelTerms);
    }
    let mut series = 0;
    for term in terms {
        term.law.check(D)?;
        if !term.coefficient.is_finite() {
            return Err(Error::NotFinite);
        }
        let (law, _) = term.law.canonical(D);
        if law != Law::Newtonian && mollifier.is_algebraic() {
            return Err(Error::Unsupported);
        }
        if cfg!(feature = "kernels") && law != Law::Newtonian {
            series += radii * capacity(Some(law), profile.as_ref(), D);
        }
    }
    if supplied && (mollifier.is_algebraic() || radii > 1) {
        return Err(Error::Unsupported);
    }
    if cfg!(feature = "kernels") && supplied {
        series += capacity(None, profile.as_ref(), D);
    }
    let rows = if cfg!(feature = "kernels") && has_table(terms, supplied, mollifier, D) { ROWS } else { 0 };
    Ok(Sizes { series, rows })
}

/// K'/r is a normal number of double precision below and above 1 by this power of two.
const LARGEST_EXPONENT: i32 = 1020;

/// e^{-r/l} is zero in f64 beyond this many lengths l.
const EXPONENTIAL_REACH: f64 = 745.2;

/// The distance beyond which a term is zero, if any.
fn reach(law: Law) -> Option<f64> {
    match law {
        Law::Newtonian | Law::Power { .. } => None,
        Law::Exponential { length } => Some(EXPONENTIAL_REACH * length),
        Law::Screened { k } => Some(quotient(EXPONENTIAL_REACH, k)),
    }
}

/// Whether sums of these terms use a table.
///
/// Newtonian kernels with a compact mollifier or none have their own loops. Without a mollifier a table needs a length as its unit.
fn has_table(terms: &[Term], supplied: bool, mollifier: Mollifier, dimension: usize) -> bool {
    let mut others = terms.iter().filter(|term| !term.law.is_newtonian(dimension));
    match mollifier {
        Mollifier::Gaussian { .. } | Mollifier::Richardson { .. } => true,
        // Newtonian alone.
        Mollifier::Plummer | Mollifier::Algebraic | Mollifier::Vatistas => false,
        Mollifier::Compact { .. } => supplied || others.next().is_some(),
        Mollifier::None => supplied || others.any(|term| !matches!(term.law, Law::Newtonian | Law::Power { .. })),
    }
}

/// The domain of the table of these terms.
fn domain(
    terms: &[Term],
    supplied: Option<Supplied<'_>>,
    (mollifier, dimension): (Mollifier, usize),
    delta: f64,
) -> Domain {
    let longest = terms.iter().filter_map(|term| reach(term.law)).fold(0.0, f64::max);
    let all_end = terms.iter().all(|term| reach(term.law).is_some());
    let reach = supplied.map(|own| own.reach);
    let (until, ends) = match reach {
        Some(reach) if all_end && longest <= reach => (reach, true),
        None if all_end => (longest, true),
        // Where there is a host's kernel, its reach is a knot of the sum, which goes on.
        _ => (f64::INFINITY, false),
    };
    let edges = match mollifier {
        Mollifier::Compact { .. } => 1,
        // A Newtonian field is a polynomial between the radii.
        Mollifier::Richardson { .. } if !terms.iter().all(|term| term.law.is_newtonian(dimension)) => mollifier.radii(),
        _ => 0,
    };
    let (unit, shift) = match (mollifier, supplied) {
        (Mollifier::None, Some(own)) => {
            // The first knot, or the reach, is at a power of two; the reach at a u of 2^14 to 2^16, where the table ends, or of 1/4 to 1, if the sum goes on.
            let at_power = own.knots.first().copied().unwrap_or(own.reach);
            let parts = if ends { 256.0 } else { 1.0 };
            let (_, exponent) = Scalar::frexp(parts * quotient(at_power, own.reach));
            (Scalar::ldexp(at_power, 1 - exponent), 0.0)
        }
        // u is 1 at the 2^8-th part of the reach, so that powers of u stay in the range of f32.
        (Mollifier::None, None) => (if until.is_finite() { until } else { longest } / 256.0, 0.0),
        // The radii of a combination are halves of the unit: their u are borders of panels.
        (Mollifier::Richardson { .. }, _) => (2.0 * delta / f64::from(mollifier.radii()), table::SHIFT),
        _ => (delta, table::SHIFT),
    };
    let ratio = quotient(until, unit);
    Domain { unit, shift, until: ratio * ratio + shift, ends, edges, reach }
}

impl<'k, T: Real, const D: usize> Kernel<'k, T, D> {
    /// A kernel without terms.
    pub(super) fn empty(blob: Blob<T, D>) -> Self {
        let outer = Outer::Bare { factor: 0.0 };
        let part = FittedTerm { law: Law::Newtonian, radius: 0.0, panels: 0, plain: 0, first: 0, outer };
        let term = Term { law: Law::Newtonian, coefficient: 0.0 };
        Self {
            #[cfg(feature = "kernels")]
            polynomials: blob.polynomials_of_part(),
            blob,
            newtonian: T::ZERO,
            terms: [term; KEPT],
            count: 0,
            others: [Others {
                parts: [part; MAX_TERMS],
                used: 0,
                series: &[],
                table: None,
                fit_error: 0.0,
                fit_errors: [0.0; 3],
            }; OTHERS],
        }
    }

    /// The exact size of a block for these terms under this mollifier, in bytes.
    ///
    /// # Errors
    /// As [`Kernel::prepare`].
    pub fn workspace_bytes(terms: &[Term], mollifier: Mollifier) -> Result<usize> {
        Self::workspace_bytes_with(terms, false, mollifier)
    }

    /// As [`Kernel::workspace_bytes`], with a user's kernel.
    ///
    /// # Errors
    /// As [`Kernel::prepare`].
    pub fn workspace_bytes_with(terms: &[Term], supplied: bool, mollifier: Mollifier) -> Result<usize> {
        let sizes = check::<D>(terms, supplied, mollifier)?;
        Measure::of(|space| layout::<T>(space, sizes).map(|_| ()))
    }

    /// Prepares the sum of `terms`, mollified over the length `delta` (ignored for [`Mollifier::None`]), in
    /// `memory`, which needs [`Kernel::workspace_bytes`]. Tables are computed in double precision for both scalars.
    ///
    /// Cost: microseconds for closed forms, some milliseconds for fits (tens of them for 2D exponentials and general powers).
    ///
    /// # Errors
    /// [`Error::KernelTerms`]: no term, or more than [`MAX_TERMS`], where under a Richardson combination each one that is not Newtonian counts for as many as it has radii. [`Error::KernelParameter`], [`Error::NotFinite`]: a
    /// parameter. [`Error::Delta`], [`Error::Dimension`], [`Error::Order`], [`Error::Exponent`]: the mollifier.
    /// [`Error::WorkspaceTooSmall`], [`Error::Misaligned`]: the memory. [`Error::Unsupported`]: k delta (delta/l) is too
    /// large (about 600 for compact mollifiers, 13 to 26 for Gaussians), so that the exterior factor overflows; the mollifier is too rough
    /// for a power's Laplacian (M = 1 with 0 < p + d - 1 < 0.08), or algebraic, for a kernel other than the Newtonian one; or a mollified power is above about 20, and its fits do not converge. [`Error::OutOfDomain`]: a coefficient, or the exterior factor, leaves the
    /// range of the scalar (in single precision k delta above about 90, 4.7 to 13 for Gaussians), or K'/r of a kernel that isn't Newtonian leaves
    /// that of double precision at distances of about delta (without a mollifier: of about its length). After an error `memory` holds no block.
    pub fn prepare(memory: &'k mut [u8], terms: &[Term], mollifier: Mollifier, delta: T) -> Result<Self> {
        Self::prepare_with(memory, terms, None, mollifier, delta)
    }

    /// As [`Kernel::prepare`], with a user's kernel added to the sum.
    ///
    /// # Errors
    /// As [`Kernel::prepare`]; [`Error::Unsupported`]: the mollifier is a Richardson combination; [`Error::NotFinite`]: the user's kernel returned a value that is not finite; [`Error::KernelFit`]: it is not met within
    /// its tolerance; [`Error::KernelReach`], [`Error::KernelKnots`], [`Error::OutOfDomain`]: see [`Supplied::check`]; [`Error::Unsupported`]: its reach is
    /// beyond 2^40 delta.
    pub fn prepare_with(
        memory: &'k mut [u8],
        terms: &[Term],
        supplied: Option<Supplied<'_>>,
        mollifier: Mollifier,
        delta: T,
    ) -> Result<Self> {
        Self::write(memory, terms, supplied, mollifier, delta)?;
        Self::open(memory)
    }

    /// As [`Kernel::prepare_with`], without opening the block.
    ///
    /// # Errors
    /// As [`Kernel::prepare_with`].
    pub fn write(
        memory: &mut [u8],
        terms: &[Term],
        supplied: Option<Supplied<'_>>,
        mollifier: Mollifier,
        delta: T,
    ) -> Result<()> {
        let supplied =
            if cfg!(feature = "kernels") || supplied.is_none() { supplied } else { return Err(Error::Unsupported) };
        let sizes = check::<D>(terms, supplied.is_some(), mollifier)?;
        let length = Blob::<T, D>::check(mollifier, delta)?;
        if let Some(own) = &supplied {
            own.check()?;
        }
        let bytes =
            if cfg!(feature = "kernels") { Measure::of(|space| layout::<T>(space, sizes).map(|_| ()))? } else { BYTES };
        if memory.len() < bytes {
            return Err(Error::WorkspaceTooSmall);
        }
        let Arrays { head, records, series, rows } = layout::<T>(&mut Carve::block(memory)?, sizes)?;
        // What stood here before is a block no more, also if this one is refused.
        head.fill(0);
        let (start, rest) = records.split_first_chunk_mut::<START>().ok_or(Error::WorkspaceTooSmall)?;
        let (mut newtonian, mut used, mut error, mut errors) = (0.0, 0_usize, 0.0, [0.0; 3]);
        if cfg!(feature = "kernels") {
            let (term_records, rest) = rest.split_at_mut_checked(MAX_TERMS * TERM).ok_or(Error::WorkspaceTooSmall)?;
            let (part_records, table_record) =
                rest.split_at_mut_checked(MAX_TERMS * RECORD).ok_or(Error::WorkspaceTooSmall)?;
            for (term, slot) in terms.iter().zip(term_records.as_chunks_mut::<TERM>().0) {
                let (kind, parameter) = term.law.to_numbers();
                *slot = [kind, parameter, term.coefficient];
            }
            let delta = length.to_f64();
            let profile = Profile::new(mollifier, D);
            let mut builder = Builder::new(series, T::MAX.to_f64());
            let mut part_slots = part_records.as_chunks_mut::<RECORD>().0.iter_mut();
            let mut store = |part: FittedTerm<f64>| -> Result<()> {
                *part_slots.next().ok_or(Error::KernelTerms)? = part.to_record();
                used += 1;
                Ok(())
            };
            for term in terms {
                let (law, factor) = term.law.canonical(D);
                let coefficient = factor * term.coefficient;
                // 1/l overflows for a subnormal length
                let rate = if let Law::Exponential { length } = law { quotient(1.0, length) } else { 0.0 };
                if !(Scalar::is_finite(coefficient) && Scalar::is_finite(rate)) {
                    return Err(Error::OutOfDomain);
                }
                if law == Law::Newtonian {
                    newtonian += coefficient;
                }
            }
            for (weight, radius) in mollifier.parts() {
                let delta = radius * delta;
                for term in terms {
                    let (law, factor) = term.law.canonical(D);
                    let coefficient = weight * (factor * term.coefficient);
                    if law != Law::Newtonian {
                        let task = Task { dimension: D, profile: profile.as_ref(), delta, coefficient };
                        store(task.prepare::<D>(law, &mut builder)?)?;
                    }
                }
                builder.finish(D, delta)?;
            }
            let tolerance = match supplied {
                Some(own) if own.tolerance > 0.0 => own.tolerance,
                _ => default_tolerance::<T>(),
            };
            if let Some(own) = &supplied {
                let unit = if profile.is_some() { delta } else { own.reach };
                let host = Host { own, profile: profile.as_ref(), unit, tolerance };
                store(host.prepare::<D>(&mut builder)?)?;
            }
            error = builder.error;
            errors = builder.errors;
            if let Ok(rows) = <&mut crate::simd::Rows<T>>::try_from(rows) {
                let mut kernel = Kernel::<f64, D>::empty(Blob::new(mollifier, delta)?);
                // The table of a Newtonian kernel is that of the coefficient 1.
                kernel.newtonian = if used == 0 { 1.0 } else { newtonian };
                if let Some(others) = kernel.others.first_mut() {
                    others.read(part_records, used)?;
                    others.series = series;
                }
                let domain = domain(terms, supplied, (mollifier, D), delta);
                let sample = |r: f64| kernel.pair_scaled(r, [true; 3]);
                let exponent = table::exponent(&domain, &sample);
                // Newtonian kernels have exponents of their own. What others give are plain numbers: K'/r has to be one, and zero only if the kernel is, or
                // its terms cancel.
                let in_range = match exponent {
                    Some(exponent) => (exponent - 2 * Scalar::frexp(domain.unit).1).abs() <= LARGEST_EXPONENT,
                    None => {
                        let nonzero = terms.iter().any(|term| term.coefficient != 0.0);
                        let series = kernel.others.first().map_or(&[][..], |others| others.series);
                        let seen = |part: &FittedTerm<f64>| {
                            table::exponent(&domain, &|r| part.scaled::<D>(series, r)).is_some()
                        };
                        supplied.is_some() || !nonzero || kernel.parts().iter().any(seen)
                    }
                };
                if used > 0 && !in_range {
                    return Err(Error::OutOfDomain);
                }
                let built = table::build::<T, D>(rows, &domain, exponent.unwrap_or(0), &sample);
                let mut head = built.map_err(|error| if supplied.is_some() { error } else { Error::OutOfDomain })?;
                if let Some(own) = supplied {
                    let sizes = |r: f64| kernel.sizes_scaled(r);
                    let mut knots = [f64::INFINITY; MAX_KNOTS + 1];
                    let of_sum = own.knots.iter().filter(|_| profile.is_none());
                    let reach = Some(&own.reach).filter(|_| !domain.ends);
                    knots.iter_mut().zip(of_sum.chain(reach)).for_each(|(to, &knot)| *to = knot);
                    // Roundings do not make a panel one to be left out.
                    let goal = (0.25 * tolerance).max(if T::DIGITS > 24 { 2e-13 } else { 4e-6 });
                    let demands = Demands { sample: &sample, sizes: &sizes, knots: &knots, goal };
                    let of_table = table::compare::<T, D>(rows, &mut head, &demands);
                    // Twice what was found, as not every distance is tried.
                    errors.iter_mut().zip(of_table).for_each(|(sum, more)| *sum = 2.0 * (*sum + more));
                    error = errors.iter().fold(error, |most, &e| most.max(e));
                    if let Some(achieved) = own.achieved {
                        achieved.set(errors);
                    }
                    if !errors.iter().all(|&e| e <= tolerance) {
                        return Err(Error::KernelFit);
                    }
                }
                table_record.iter_mut().zip(head.to_record()).for_each(|(to, number)| *to = number);
            }
        } else if let ([only], Some(slot)) = (terms, rest.first_chunk_mut::<TERM>()) {
            // The kind and the parameter of a Newtonian term are zero.
            newtonian = only.coefficient;
            *slot = [0.0, 0.0, newtonian];
        }
        let (newtonian, wide) = (T::from_wide(newtonian), newtonian);
        if !newtonian.is_finite() || (newtonian.abs() < T::MIN_POSITIVE && Scalar::abs(wide) > 0.0) {
            return Err(Error::OutOfDomain);
        }
        let [of_value, of_factor, of_laplacian] = errors;
        let [length, newtonian] = [length, newtonian].map(|number| f64::from_bits(number.bits()));
        *start = [length, newtonian, error, of_value, of_factor, of_laplacian];
        let (kind, order, exponent) = match mollifier {
            Mollifier::None => (0, 0, 0),
            Mollifier::Compact { order, exponent } => (1, order, exponent),
            Mollifier::Gaussian { order } => (2, order, 0),
            Mollifier::Plummer => (3, 0, 0),
            Mollifier::Algebraic => (4, 0, 0),
            Mollifier::Vatistas => (5, 0, 0),
            Mollifier::Richardson { order, exponent } => (6, order, exponent),
        };
        let head = head.first_chunk_mut::<HEAD>().ok_or(Error::WorkspaceTooSmall)?;
        *head = [
            MAGIC,
            VERSION,
            u64::from(T::BYTES),
            D as u64,
            terms.len() as u64,
            used as u64,
            (sizes.rows as u64) << 32 | sizes.series as u64,
            u64::from(exponent << 16 | order << 8 | kind),
        ];
        Ok(())
    }

    /// Opens a block written by [`Kernel::prepare`], also on another machine.
    ///
    /// # Errors
    /// [`Error::NotPrepared`]: no block, or one of another dimension. [`Error::WrongVersion`], [`Error::WrongScalar`],
    /// [`Error::WrongByteOrder`]: version, scalar or byte order differ. [`Error::WorkspaceTooSmall`]: bytes are missing. [`Error::Misaligned`].
    pub fn open(memory: &'k [u8]) -> Result<Self> {
        let mut view = View::new(memory)?;
        let head: &[u64] = view.try_array(HEAD).map_err(|_| Error::NotPrepared)?;
        let &[magic, version, bytes, dimension, count, used, size, shape] =
            head.first_chunk::<HEAD>().ok_or(Error::NotPrepared)?;
        if magic == MAGIC.swap_bytes() {
            return Err(Error::WrongByteOrder);
        }
        if magic != MAGIC {
            return Err(Error::NotPrepared);
        }
        if version != VERSION {
            return Err(Error::WrongVersion);
        }
        if bytes != u64::from(T::BYTES) {
            return Err(Error::WrongScalar);
        }
        if dimension != D as u64 {
            return Err(Error::NotPrepared);
        }
        let records: &[f64] = view.try_array(RECORDS)?;
        let (start, rest) = records.split_at_checked(START).ok_or(Error::NotPrepared)?;
        let &[delta, newtonian, fit_error, of_value, of_factor, of_laplacian] =
            start.first_chunk::<START>().ok_or(Error::NotPrepared)?;
        let (order, exponent) = ((shape >> 8) as u32 & 0xFF, (shape >> 16) as u32 & 0xFF);
        let mollifier = match shape as u32 & 0xFF {
            0 => Mollifier::None,
            1 => Mollifier::Compact { order, exponent },
            2 => Mollifier::Gaussian { order },
            3 => Mollifier::Plummer,
            4 => Mollifier::Algebraic,
            5 => Mollifier::Vatistas,
            6 => Mollifier::Richardson { order, exponent },
            _ => return Err(Error::NotPrepared),
        };
        let blob = Blob::new(mollifier, T::from_bits(delta.to_bits())).map_err(|_| Error::NotPrepared)?;
        let mut kernel = Self::empty(blob);
        kernel.newtonian = T::from_bits(newtonian.to_bits());
        let Some(others) = kernel.others.first_mut() else {
            // This build prepares only a single Newtonian term.
            let &[_, _, coefficient] = rest.first_chunk::<TERM>().ok_or(Error::NotPrepared)?;
            kernel.terms = [Term { law: Law::Newtonian, coefficient }; KEPT];
            kernel.count = KEPT;
            return if used == 0 { Ok(kernel) } else { Err(Error::Unsupported) };
        };
        others.fit_error = fit_error;
        others.fit_errors = [of_value, of_factor, of_laplacian];
        others.series = view.try_array((size & 0xFFFF_FFFF) as usize)?;
        let rows: &[[T; ROW]] = view.try_array((size >> 32) as usize)?;
        kernel.count = usize::try_from(count).unwrap_or(0).min(MAX_TERMS);
        let (terms, rest) = rest.split_at_checked(MAX_TERMS * TERM).ok_or(Error::NotPrepared)?;
        let (parts, table_record) = rest.split_at_checked(MAX_TERMS * RECORD).ok_or(Error::NotPrepared)?;
        for (slot, &[kind, parameter, coefficient]) in kernel.terms.iter_mut().zip(terms.as_chunks::<TERM>().0) {
            let law = Law::from_numbers(kind, parameter).ok_or(Error::NotPrepared)?;
            *slot = Term { law, coefficient };
        }
        others.read(parts, usize::try_from(used).unwrap_or(0))?;
        if let (Ok(rows), Some(record)) = (rows.try_into(), table_record.first_chunk()) {
            others.table = Head::from_record(record).map(|head| Table { rows, head });
        }
        Ok(kernel)
    }
}

impl<T> Others<'_, T> {
    /// Reads the parts of a block.
    fn read(&mut self, records: &[f64], used: usize) -> Result<()> {
        self.used = used.min(MAX_TERMS);
        for (slot, record) in self.parts.iter_mut().zip(records.as_chunks::<RECORD>().0) {
            *slot = FittedTerm::from_record(record).ok_or(Error::NotPrepared)?;
            slot.panels = slot.panels.min(HOST_PANELS);
            slot.plain = slot.plain.min(slot.panels);
        }
        Ok(())
    }
}
