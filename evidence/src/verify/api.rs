//! The public interfaces that results come from: the Rust crate's and C's.

use std::collections::HashMap;
use std::ptr::null;

use anyhow::{Context, Result, anyhow, bail};
use mollis_abi as c;
use mollis_core::kernel::{Kernel, Law, Term};
use mollis_core::mollifier::{Blob, Mollifier, Quantity};
use mollis_core::{Error, Real};
use mollis_host::memory::Memory;

use super::decimal::Scalar;
use super::reference::Row;

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

/// The scalar as C's interface knows it: its functions of one dimension, for one radius.
trait InC: Real {
    /// `mollis_mollifier<D>_eval`; outputs in the order of [`Quantity::ALL`].
    fn mollifier(dimension: u32, mollifier: c::mollis_mollifier, delta: Self, r: Self) -> Result<[Self; 6]>;
    /// `mollis_kernel<D>_workspace_bytes`.
    fn kernel_bytes(dimension: u32, terms: &[c::mollis_kernel_term], mollifier: c::mollis_mollifier) -> Result<usize>;
    /// `mollis_kernel<D>_prepare`.
    fn prepare(
        dimension: u32,
        memory: &mut [u8],
        terms: &[c::mollis_kernel_term],
        mollifier: c::mollis_mollifier,
        delta: Self,
    ) -> Result<()>;
    /// `mollis_kernel<D>_eval`: value, gradient factor, Laplacian.
    fn kernel(dimension: u32, memory: &[u8], r: Self) -> Result<[Self; 3]>;
}

macro_rules! of_dimension {
    ($dimension:ident, ($one:ident $two:ident $three:ident)) => {
        match $dimension {
            1 => c::$one,
            2 => c::$two,
            3 => c::$three,
            _ => bail!("no dimension {}", $dimension),
        }
    };
}
macro_rules! in_c {
    ($t:ident, $mollifier:tt $bytes:tt $prepare:tt $kernel:tt) => {
        #[expect(unsafe_code, reason = "calls the C interface")]
        impl InC for $t {
            fn mollifier(dimension: u32, m: c::mollis_mollifier, delta: $t, r: $t) -> Result<[$t; 6]> {
                let function = of_dimension!(dimension, $mollifier);
                let [mut b, mut q, mut p, mut g, mut h, mut mass] = [0.0; 6];
                // SAFETY: one radius, and outputs of one value each that live through the call.
                checked(unsafe { function(m, delta, 1, &r, &mut b, &mut q, &mut p, &mut g, &mut h, &mut mass) })?;
                Ok([b, q, p, g, h, mass])
            }
            fn kernel_bytes(dimension: u32, terms: &[c::mollis_kernel_term], m: c::mollis_mollifier) -> Result<usize> {
                let function = of_dimension!(dimension, $bytes);
                let mut bytes = 0;
                // SAFETY: the terms and their number, no kernel of our own.
                checked(unsafe { function(terms.as_ptr(), terms.len(), null(), m, &mut bytes) })?;
                Ok(bytes)
            }
            fn prepare(
                dimension: u32,
                memory: &mut [u8],
                terms: &[c::mollis_kernel_term],
                m: c::mollis_mollifier,
                delta: $t,
            ) -> Result<()> {
                let function = of_dimension!(dimension, $prepare);
                let (start, bytes) = (memory.as_mut_ptr().cast(), memory.len());
                // SAFETY: the buffer and its length, the terms and their number.
                checked(unsafe { function(start, bytes, terms.as_ptr(), terms.len(), null(), m, delta) })
            }
            fn kernel(dimension: u32, memory: &[u8], r: $t) -> Result<[$t; 3]> {
                let function = of_dimension!(dimension, $kernel);
                let [mut value, mut gradient, mut laplacian] = [0.0; 3];
                let (start, bytes) = (memory.as_ptr().cast(), memory.len());
                // SAFETY: the buffer and its length, one radius, outputs of one value each.
                checked(unsafe { function(start, bytes, 1, &r, &mut value, &mut gradient, &mut laplacian) })?;
                Ok([value, gradient, laplacian])
            }
        }
    };
}
in_c!(f64,
    (mollis_mollifier1_eval mollis_mollifier2_eval mollis_mollifier3_eval)
    (mollis_kernel1_bytes mollis_kernel2_bytes mollis_kernel3_bytes)
    (mollis_kernel1_prepare mollis_kernel2_prepare mollis_kernel3_prepare)
    (mollis_kernel1_eval mollis_kernel2_eval mollis_kernel3_eval));
in_c!(f32,
    (mollis_mollifier1_eval_f32 mollis_mollifier2_eval_f32 mollis_mollifier3_eval_f32)
    (mollis_kernel1_bytes_f32 mollis_kernel2_bytes_f32 mollis_kernel3_bytes_f32)
    (mollis_kernel1_prepare_f32 mollis_kernel2_prepare_f32 mollis_kernel3_prepare_f32)
    (mollis_kernel1_eval_f32 mollis_kernel2_eval_f32 mollis_kernel3_eval_f32));

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

/// Evaluates places, keeping kernels that it prepared.
pub struct Evaluator {
    api: Api,
    scalar: Scalar,
    prepared: HashMap<String, Memory>,
}

impl Evaluator {
    pub fn new(api: Api, scalar: Scalar) -> Self {
        Self { api, scalar, prepared: HashMap::new() }
    }

    /// The row's quantities under another mollifier, at another distance.
    pub fn evaluate(&mut self, row: &Row, mollifier: Mollifier, r: f64) -> Result<Values> {
        match self.scalar {
            Scalar::F64 => self.generic::<f64>(row, mollifier, r),
            Scalar::F32 => self.generic::<f32>(row, mollifier, r),
        }
    }

    fn generic<T: InC>(&mut self, row: &Row, mollifier: Mollifier, r: f64) -> Result<Values> {
        let (delta, r) = (T::from_f64(row.delta), T::from_f64(r));
        let columns = row.values.iter().map(|&(column, _)| column);
        if let Some(name) = &row.kernel {
            let all = self.kernel(row.dimension, name, mollifier, delta, r)?;
            let place = |column| ["value", "grad_factor", "laplacian"].iter().position(|&c| c == column);
            let pick = |column| place(column).map(|k| (column, all[k].to_f64())).context("a column kernels lack");
            return columns.map(pick).collect();
        }
        let all = match self.api {
            Api::Rust => match row.dimension {
                1 => blob::<T, 1>(mollifier, delta, r),
                2 => blob::<T, 2>(mollifier, delta, r),
                3 => blob::<T, 3>(mollifier, delta, r),
                dimension => bail!("no dimension {dimension}"),
            },
            Api::C => T::mollifier(row.dimension, mollifier_in_c(mollifier), delta, r),
        }?;
        columns.map(|column| Ok((column, pick(column, &all)?.to_f64()))).collect()
    }

    fn kernel<T: InC>(&mut self, dimension: u32, name: &str, mollifier: Mollifier, delta: T, r: T) -> Result<[T; 3]> {
        let terms = terms(name)?;
        let key = format!("{dimension} {name} {mollifier:?} {delta}");
        let prepared = &mut self.prepared;
        match (self.api, dimension) {
            (Api::C, _) => {
                let in_c: Vec<_> = terms.iter().map(|&term| term_in_c(term)).collect();
                let m = mollifier_in_c(mollifier);
                if !prepared.contains_key(&key) {
                    let mut block = Memory::dirty(T::kernel_bytes(dimension, &in_c, m)?);
                    T::prepare(dimension, block.slice(), &in_c, m, delta)?;
                    prepared.insert(key.clone(), block);
                }
                T::kernel(dimension, prepared[&key].read(), r)
            }
            (Api::Rust, 1) => kernel::<T, 1>(prepared, key, &terms, mollifier, delta, r),
            (Api::Rust, 2) => kernel::<T, 2>(prepared, key, &terms, mollifier, delta, r),
            (Api::Rust, 3) => kernel::<T, 3>(prepared, key, &terms, mollifier, delta, r),
            _ => bail!("no dimension {dimension}"),
        }
    }
}

fn kernel<T: Real, const D: usize>(
    prepared: &mut HashMap<String, Memory>,
    key: String,
    terms: &[Term],
    mollifier: Mollifier,
    delta: T,
    r: T,
) -> Result<[T; 3]> {
    if !prepared.contains_key(&key) {
        let mut block = Memory::dirty(Kernel::<T, D>::workspace_bytes(terms, mollifier)?);
        Kernel::<T, D>::prepare(block.slice(), terms, mollifier, delta)?;
        prepared.insert(key.clone(), block);
    }
    let kernel = Kernel::<T, D>::open(prepared[&key].read())?;
    Ok([kernel.value(r), kernel.gradient_factor(r), kernel.laplacian(r)])
}

fn blob<T: Real, const D: usize>(mollifier: Mollifier, delta: T, r: T) -> Result<[T; 6]> {
    let blob = Blob::<T, D>::new(mollifier, delta)?;
    Ok(Quantity::ALL.map(|quantity| blob.evaluate(quantity, r)))
}

/// The kernels that files name: `p<p>` is |x|^p/p, `log`, `morse`, `k0_<k>` and `screened_<k>`.
fn terms(name: &str) -> Result<Vec<Term>> {
    let one = |law| Ok(vec![Term { law, coefficient: 1.0 }]);
    if name == "morse" {
        // e^-|x| - 2 e^(-|x|/2)
        let term = |length, coefficient| Term { law: Law::Exponential { length }, coefficient };
        return Ok(vec![term(1.0, 1.0), term(2.0, -2.0)]);
    }
    if name == "log" {
        return one(Law::Power { exponent: 0.0 });
    }
    if let Some(k) = name.strip_prefix("k0_").or_else(|| name.strip_prefix("screened_")) {
        return one(Law::Screened { k: k.parse()? });
    }
    let exponent = name.strip_prefix('p').with_context(|| format!("unknown kernel {name}"))?;
    one(Law::Power { exponent: exponent.parse().with_context(|| format!("unknown kernel {name}"))? })
}

fn term_in_c(term: Term) -> c::mollis_kernel_term {
    let (kind, parameter) = match term.law {
        Law::Newtonian => (c::MOLLIS_KERNEL_NEWTONIAN, 0.0),
        Law::Power { exponent } => (c::MOLLIS_KERNEL_POWER, exponent),
        Law::Exponential { length } => (c::MOLLIS_KERNEL_EXPONENTIAL, length),
        Law::Screened { k } => (c::MOLLIS_KERNEL_SCREENED, k),
    };
    c::mollis_kernel_term { kind, reserved: 0, coefficient: term.coefficient, parameter: [parameter, 0.0] }
}

fn pick<T: Copy>(column: &str, all: &[T; 6]) -> Result<T> {
    let wanted = quantity(column).ok_or_else(|| anyhow!("mollifiers have no column {column}"))?;
    let found = Quantity::ALL.iter().zip(all).find(|&(&q, _)| q == wanted);
    found.map(|(_, &value)| value).ok_or_else(|| anyhow!("no quantity {wanted:?}"))
}

fn mollifier_in_c(mollifier: Mollifier) -> c::mollis_mollifier {
    let (kind, order, exponent) = match mollifier {
        Mollifier::None => (c::MOLLIS_MOLLIFIER_NONE, 0, 0),
        Mollifier::Compact { order, exponent } => (c::MOLLIS_MOLLIFIER_COMPACT, order, exponent),
        Mollifier::Gaussian { order } => (c::MOLLIS_MOLLIFIER_GAUSSIAN, order, 0),
        Mollifier::Plummer => (c::MOLLIS_MOLLIFIER_PLUMMER, 0, 0),
        Mollifier::Algebraic => (c::MOLLIS_MOLLIFIER_ALGEBRAIC, 0, 0),
        Mollifier::Vatistas => (c::MOLLIS_MOLLIFIER_VATISTAS, 0, 0),
        Mollifier::Richardson { order, exponent } => (c::MOLLIS_MOLLIFIER_RICHARDSON, order, exponent),
    };
    c::mollis_mollifier { kind, order: order as i32, exponent: exponent as i32 }
}
