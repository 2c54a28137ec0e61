//! The public interfaces that results come from: the Rust crate's and C's.

use anyhow::{Result, anyhow, bail};
use mollis_abi as c;
use mollis_core::mollifier::{Blob, Mollifier, Quantity};
use mollis_core::{Error, Real};

use super::decimal::Scalar;
use super::reference::Row;
use super::tolerance::Family;

/// Which interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Api {
    /// The crate mollis-core.
    Rust,
    /// The functions of mollis.h, called as C calls them.
    C,
}

/// The results at one place, by column name.
pub type Values = Vec<(&'static str, f64)>;

/// The scalar as both interfaces know it.
trait Both: Real {
    /// `mollis_mollifier<D>_eval` for one radius; outputs in the order of [`Quantity::ALL`].
    fn mollifier(dimension: u32, mollifier: c::mollis_mollifier, delta: Self, r: Self) -> Result<[Self; 6]>;
}

macro_rules! both {
    ($t:ident, $one:ident $two:ident $three:ident) => {
        impl Both for $t {
            #[expect(unsafe_code, reason = "calls the C interface")]
            fn mollifier(dimension: u32, m: c::mollis_mollifier, delta: $t, r: $t) -> Result<[$t; 6]> {
                let function = match dimension {
                    1 => c::$one,
                    2 => c::$two,
                    3 => c::$three,
                    _ => bail!("no dimension {dimension}"),
                };
                let [mut b, mut q, mut p, mut g, mut h, mut mass] = [0.0; 6];
                // SAFETY: one radius, and outputs of one value each that live through the call.
                let status = unsafe { function(m, delta, 1, &r, &mut b, &mut q, &mut p, &mut g, &mut h, &mut mass) };
                checked(status)?;
                Ok([b, q, p, g, h, mass])
            }
        }
    };
}
both!(f64, mollis_mollifier1_eval mollis_mollifier2_eval mollis_mollifier3_eval);
both!(f32, mollis_mollifier1_eval_f32 mollis_mollifier2_eval_f32 mollis_mollifier3_eval_f32);

fn checked(status: i32) -> Result<()> {
    match (status, Error::from_code(status)) {
        (0, _) => Ok(()),
        (_, Some(error)) => Err(error.into()),
        _ => Err(anyhow!("status {status}")),
    }
}

fn quantity(column: &str) -> Option<Quantity> {
    Some(match column {
        "B" | "psi" => Quantity::Density,
        "Bprime_over_r" | "psiprime_over_r" => Quantity::DensitySlope,
        "phi" => Quantity::Potential,
        "grad_factor" => Quantity::GradientFactor,
        "hess_factor" => Quantity::HessianFactor,
        "mass" => Quantity::EnclosedMass,
        _ => return None,
    })
}

/// The row's quantities at distance `r` instead of the row's own; `None` where the kernel is not offered.
pub fn evaluate(api: Api, scalar: Scalar, row: &Row, r: f64) -> Result<Option<Values>> {
    match scalar {
        Scalar::F64 => generic::<f64>(api, row, r),
        Scalar::F32 => generic::<f32>(api, row, r),
    }
}

fn generic<T: Both>(api: Api, row: &Row, r: f64) -> Result<Option<Values>> {
    match row.family {
        Family::Compact | Family::Gaussian => {
            let (delta, r) = (T::from_f64(row.delta), T::from_f64(r));
            let all = match api {
                Api::Rust => in_rust(row.dimension, row.mollifier, delta, r)?,
                Api::C => T::mollifier(row.dimension, in_c(row.mollifier), delta, r)?,
            };
            let columns = row.values.iter().map(|&(column, _)| column);
            columns.map(|column| Ok((column, pick(column, &all)?.to_f64()))).collect::<Result<_>>().map(Some)
        }
        Family::Kernel => Ok(None),
    }
}

fn pick<T: Copy>(column: &str, all: &[T; 6]) -> Result<T> {
    let wanted = quantity(column).ok_or_else(|| anyhow!("mollifiers have no column {column}"))?;
    let found = Quantity::ALL.iter().zip(all).find(|&(&q, _)| q == wanted);
    found.map(|(_, &value)| value).ok_or_else(|| anyhow!("no quantity {wanted:?}"))
}

fn in_rust<T: Real>(dimension: u32, mollifier: Mollifier, delta: T, r: T) -> Result<[T; 6]> {
    fn at<T: Real, const D: usize>(mollifier: Mollifier, delta: T, r: T) -> Result<[T; 6]> {
        let blob = Blob::<T, D>::new(mollifier, delta)?;
        Ok(Quantity::ALL.map(|quantity| blob.evaluate(quantity, r)))
    }
    match dimension {
        1 => at::<T, 1>(mollifier, delta, r),
        2 => at::<T, 2>(mollifier, delta, r),
        3 => at::<T, 3>(mollifier, delta, r),
        _ => bail!("no dimension {dimension}"),
    }
}

fn in_c(mollifier: Mollifier) -> c::mollis_mollifier {
    let (kind, order, exponent) = match mollifier {
        Mollifier::None => (c::MOLLIS_MOLLIFIER_NONE, 0, 0),
        Mollifier::Compact { order, exponent } => (c::MOLLIS_MOLLIFIER_COMPACT, order, exponent),
        Mollifier::Gaussian { order } => (c::MOLLIS_MOLLIFIER_GAUSSIAN, order, 0),
    };
    c::mollis_mollifier { kind, order: order as i32, exponent: exponent as i32 }
}
