//! The entry point of the engine and its instantiations.
//!
//! Generic code is compiled in the crate that uses it, which for the engine takes a minute. So the scalar and the dimension become values here, in a
//! call of plain slices, and the functions that turn them into types again have none: they are compiled with this crate, once.

use super::called::{Called, Radial};
use super::newtonian::{Newtonian, support};
use super::smooth::{Form, Smooth};
use super::tabulated::Tabulated;
use super::{Call, NearCall, sums};
use crate::error::{Error, Result};
use crate::exec::Run;
use crate::field::{Interaction, Options, Outputs, Sources, Wanted};
use crate::kernel::{Kernel, Table, TableHead};
use crate::mollifier::{Blob, Mollifier};
use crate::real::{Extended, Real};
use crate::simd::Rows;

/// A type-erased [`Interaction`].
struct ErasedInteraction<'a, T: Real, const D: usize>(&'a dyn Interaction<T, D>);

impl<T: Real, const D: usize> Radial for ErasedInteraction<'_, T, D> {
    fn pair(&self, r: f64, wanted: Wanted) -> [Extended; 3] {
        match self.0.sum() {
            Some(kernel) => kernel.pair_scaled(r, wanted.into()),
            None => self.0.pair_wide(r, wanted).map(|number| Extended::new(number, 0)),
        }
    }
    fn is_singular(&self) -> bool {
        self.0.is_singular()
    }
}

/// The arguments of a call, type-erased.
pub(in crate::field) struct ErasedCall<'a, T> {
    pub dimension: usize,
    pub potentials: bool,
    /// Coefficient, mollifier and delta of a Newtonian kernel.
    pub newtonian: Option<(T, Mollifier, T)>,
    pub table: Option<(&'a [T], TableHead)>,
    pub kernel: &'a dyn Radial,
    /// Where the kernel's mollifier ends, if it does.
    pub reach: T,
    pub options: &'a Options,
    pub positions: &'a [T],
    pub masses: &'a [T],
    pub radii: Option<&'a [T]>,
    pub target_radii: Option<&'a [T]>,
    pub strengths: Option<&'a [T]>,
    pub targets: &'a [T],
    pub potential: Option<&'a mut [T]>,
    pub gradient: Option<&'a mut [T]>,
    pub laplacian: Option<&'a mut [T]>,
    pub hessian: Option<&'a mut [T]>,
    pub near: Option<NearCall<'a, T>>,
}

impl<T: Real> ErasedCall<'_, T> {
    /// A sum of the same kernel, without sources, targets and outputs.
    pub fn kernel_alone(&self) -> ErasedCall<'_, T> {
        ErasedCall {
            dimension: self.dimension,
            potentials: self.potentials,
            newtonian: self.newtonian,
            table: self.table,
            kernel: self.kernel,
            reach: self.reach,
            options: self.options,
            positions: &[],
            masses: &[],
            radii: None,
            target_radii: None,
            strengths: None,
            targets: &[],
            potential: None,
            gradient: None,
            laplacian: None,
            hessian: None,
            near: None,
        }
    }
}

/// A sum of a scalar, with nothing generic left.
pub(in crate::field) type Sum<T> = fn(ErasedCall<'_, T>, &mut [u8], &mut Run<'_>) -> Result<()>;

/// Overwrites the outputs with the sum over all pairs. Not `FULL`: no potential is wanted, and the options are the defaults.
pub(in crate::field) fn evaluate<T: Real, const D: usize, const FULL: bool>(
    kernel: &dyn Interaction<T, D>,
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    erased(FULL, (in_single, in_double), kernel, call, workspace, run)
}

/// Calls the one of two functions that is for the scalar.
pub(in crate::field) fn erased<T: Real, const D: usize>(
    potentials: bool,
    (single, double): (Sum<f32>, Sum<f64>),
    kernel: &dyn Interaction<T, D>,
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    let others = cfg!(feature = "kernels");
    let newtonian = kernel.newtonian().map(|(coefficient, blob)| (coefficient, blob.mollifier(), blob.delta()));
    if newtonian.is_none() && !others {
        return Err(Error::Unsupported);
    }
    let table = kernel.sum().filter(|_| others).and_then(Kernel::table);
    let seen = ErasedInteraction(kernel);
    let blob = kernel.newtonian().map(|(_, blob)| blob).or(kernel.sum().map(Kernel::blob));
    let reach = blob.map_or(T::ZERO, |blob| support::<T>(D, blob.mollifier()).map_or(T::ZERO, |s| s * blob.delta()));
    let Call { options, sources, targets, outputs, near: _ } = call;
    let (positions, targets) = (sources.positions.as_flattened(), targets.as_flattened());
    let Outputs { potential, gradient, laplacian, hessian } = outputs;
    let gradient = gradient.map(<[[T; D]]>::as_flattened_mut);
    let hessian = hessian.map(|hessian| hessian.as_flattened_mut().as_flattened_mut());
    macro_rules! named {
        ($t:ty, $of:ident, $of_mut:ident, $sums:ident) => {
            if let (Some(positions), Some(masses), Some(targets)) =
                (T::$of(positions), T::$of(sources.masses), T::$of(targets))
            {
                let named = |x: T| x.to_f64() as $t;
                let call = ErasedCall {
                    dimension: D,
                    potentials,
                    newtonian: newtonian
                        .map(|(coefficient, mollifier, delta)| (named(coefficient), mollifier, named(delta))),
                    table: table.and_then(|table| Some((T::$of(table.rows.as_flattened())?, table.head))),
                    kernel: &seen,
                    reach: named(reach),
                    options,
                    positions,
                    masses,
                    radii: sources.radii.and_then(T::$of),
                    target_radii: sources.target_radii.and_then(T::$of),
                    strengths: sources.strengths.map(<[[T; D]]>::as_flattened).and_then(T::$of),
                    targets,
                    potential: potential.and_then(T::$of_mut),
                    gradient: gradient.and_then(T::$of_mut),
                    laplacian: laplacian.and_then(T::$of_mut),
                    hessian: hessian.and_then(T::$of_mut),
                    near: None,
                };
                return $sums(call, workspace, run);
            }
        };
    }
    named!(f32, singles, singles_mut, single);
    named!(f64, doubles, doubles_mut, double);
    Err(Error::Unsupported)
}

/// The sum in single precision.
#[inline(never)]
pub(in crate::field) fn in_single(call: ErasedCall<'_, f32>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    by_dimension(call, workspace, run)
}

/// The sum in double precision.
#[inline(never)]
pub(in crate::field) fn in_double(call: ErasedCall<'_, f64>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    by_dimension(call, workspace, run)
}

#[inline(always)]
fn by_dimension<T: Real>(call: ErasedCall<'_, T>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    match call.dimension {
        1 => of_kernel::<T, 1>(call, workspace, run),
        2 => of_kernel::<T, 2>(call, workspace, run),
        _ => of_kernel::<T, 3>(call, workspace, run),
    }
}

/// The sum, by what is known of the kernel.
fn of_kernel<T: Real, const D: usize>(call: ErasedCall<'_, T>, workspace: &mut [u8], run: &mut Run<'_>) -> Result<()> {
    let ErasedCall {
        potentials,
        newtonian,
        table,
        kernel,
        options,
        positions,
        masses,
        radii,
        target_radii,
        strengths,
        targets,
        ..
    } = call;
    let outputs = Outputs {
        potential: call.potential,
        gradient: call.gradient.map(|g| g.as_chunks_mut::<D>().0),
        laplacian: call.laplacian,
        hessian: call.hessian.map(|h| h.as_chunks_mut::<D>().0.as_chunks_mut::<D>().0),
    };
    let strengths = strengths.map(|strengths| strengths.as_chunks::<D>().0);
    let sources = Sources { positions: positions.as_chunks::<D>().0, masses, radii, target_radii, strengths };
    let call = Call { options, sources, targets: targets.as_chunks::<D>().0, outputs, near: call.near };
    let table = table.and_then(|(numbers, head)| {
        let rows: &Rows<T> = numbers.as_chunks().0.try_into().ok()?;
        Some(Tabulated { table: Table { rows, head }, kernel })
    });
    match (newtonian, table) {
        (Some((coefficient, mollifier, delta)), table) => {
            let blob = Blob::<T, D>::new(mollifier, delta)?;
            let given = (&blob, coefficient, table);
            // Vectors in space alone.
            if D == 3 && strengths.is_some() {
                of_newtonian::<T, D, true>(potentials, given, call, workspace, run)
            } else {
                of_newtonian::<T, D, false>(potentials, given, call, workspace, run)
            }
        }
        (None, Some(table)) if cfg!(feature = "kernels") => sums(potentials, &table, call, workspace, run),
        (None, None) if cfg!(feature = "kernels") => sums(potentials, &Called(kernel), call, workspace, run),
        _ => Err(Error::Unsupported),
    }
}

/// The sum of a Newtonian kernel, by its mollifier; if `VECTOR` of vector strengths.
fn of_newtonian<T: Real, const D: usize, const VECTOR: bool>(
    potentials: bool,
    (blob, coefficient, table): (&Blob<T, D>, T, Option<Tabulated<'_, T>>),
    call: Call<'_, T, D>,
    workspace: &mut [u8],
    run: &mut Run<'_>,
) -> Result<()> {
    if const { VECTOR && D != 3 } {
        return Err(Error::Unsupported);
    }
    let each = call.sources.radii.is_some();
    let largest = if each { call.sources.largest_radius() } else { blob.delta() };
    if let Some(form) = Form::of(blob.mollifier(), D) {
        return sums(
            potentials,
            &Smooth::<_, _, VECTOR> { blob, coefficient, largest, each, form },
            call,
            workspace,
            run,
        );
    }
    if VECTOR || each {
        let kernel = Newtonian::<_, _, true, VECTOR> { blob, coefficient, largest, table };
        sums(potentials, &kernel, call, workspace, run)
    } else {
        let kernel = Newtonian::<_, _, false, false> { blob, coefficient, largest: blob.delta(), table };
        sums(potentials, &kernel, call, workspace, run)
    }
}
