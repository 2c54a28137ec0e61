//! The five-point scheme, solved by a sine or cosine transform along one axis and tridiagonal systems along the other.

use super::{Equation, MassScale, Mesh, Monopole, Walls};
use crate::error::Result;
use crate::parallel::Executor;
use crate::real::Real;
use crate::space::Space;

/// What the solve needs beside the density and the potential.
#[derive(Debug)]
pub(super) struct Solver<'w, T: Real> {
    modes: &'w mut [T],
    line: &'w mut [T],
}

impl<'w, T: Real> Solver<'w, T> {
    pub(super) fn lay(space: &mut impl Space<'w>, mesh: &Mesh<T>, _: &Equation<T>, _workers: usize) -> Result<Self> {
        Ok(Self { modes: space.array(mesh.nodes())?, line: space.array(mesh.cells()[1] + 1)? })
    }

    pub(super) fn prepare(&mut self, _: &Mesh<T>, _: &Equation<T>) {}

    #[expect(clippy::too_many_arguments, reason = "for now")]
    #[allow(clippy::indexing_slicing, reason = "for now")]
    pub(super) fn solve(
        &mut self,
        mesh: &Mesh<T>,
        equation: &Equation<T>,
        monopole: &Monopole<T>,
        scale: MassScale,
        words: &[i64],
        potential: &mut [T],
        _executor: &dyn Executor,
    ) -> Result<()> {
        let [n, m] = mesh.cells();
        let [h, k] = mesh.spacing();
        let pitch = n + 1;
        let per_unit = scale.unit() / (h.to_f64() * k.to_f64());
        let no_flux = equation.walls == Walls::NoFlux;
        let at = |i: usize, j: usize| j * pitch + i;
        let (from, until_i, until_j) = if no_flux { (0, n + 1, m + 1) } else { (1, n, m) };
        let (hh, kk) = (h * h, k * k);
        // Density and border.
        for j in 0..=m {
            for i in 0..=n {
                let border_i = i == 0 || i == n;
                let border_j = j == 0 || j == m;
                potential[at(i, j)] = if no_flux {
                    let share = if border_i { 2.0 } else { 1.0 } * if border_j { 2.0 } else { 1.0 };
                    T::from_f64(words[at(i, j)] as f64 * per_unit * share)
                } else if border_i || border_j {
                    monopole.potential(mesh.node(i as isize, j as isize))
                } else {
                    T::from_f64(words[at(i, j)] as f64 * per_unit)
                };
            }
        }
        if !no_flux {
            for j in 1..m {
                let (left, right) = (potential[at(0, j)], potential[at(n, j)]);
                potential[at(1, j)] += -left / hh;
                potential[at(n - 1, j)] += -right / hh;
            }
            for i in 1..n {
                let (low, high) = (potential[at(i, 0)], potential[at(i, m)]);
                potential[at(i, 1)] += -low / kk;
                potential[at(i, m - 1)] += -high / kk;
            }
        }
        let angle = |i: usize, q: usize| T::PI * T::from_usize(i * q % (2 * n)) / T::from_usize(n);
        let basis = |i: usize, q: usize| {
            if no_flux { angle(i, q).cos() } else { angle(i, q).sin() }
        };
        let weight = |i: usize| if no_flux && (i == 0 || i == n) { T::HALF } else { T::ONE };
        for j in from..until_j {
            for q in from..until_i {
                let mut sum = T::ZERO;
                for i in from..until_i {
                    sum += weight(i) * potential[at(i, j)] * basis(i, q);
                }
                self.modes[at(q, j)] = sum * T::TWO / T::from_usize(n);
            }
        }
        let kappa = equation.screening;
        for q in from..until_i {
            let s = (T::PI * T::from_usize(q) / T::from_usize(2 * n)).sin();
            let b = T::TWO + kk * (T::from_f64(4.0) * s * s / hh + kappa * kappa);
            let singular = no_flux && q == 0 && kappa == T::ZERO;
            if singular {
                let mut mean = T::ZERO;
                for j in 0..=m {
                    mean += self.modes[at(q, j)] * if j == 0 || j == m { T::HALF } else { T::ONE };
                }
                mean /= T::from_usize(m);
                for j in 0..=m {
                    self.modes[at(q, j)] += -mean;
                }
            }
            let (mut e, mut g) = (T::ZERO, T::ZERO);
            for j in from..until_j {
                let f = -kk * self.modes[at(q, j)];
                let first = if no_flux && j == 0 { T::HALF } else { T::ONE };
                let last = if no_flux && j == m { T::TWO } else { T::ONE };
                let pivot = b - last * e;
                e = if singular && j == m { T::ZERO } else { T::ONE / pivot };
                g = (last * g + f) * e;
                e /= first;
                self.line[j] = e;
                self.modes[at(q, j)] = g;
            }
            let mut next = T::ZERO;
            for j in (from..until_j).rev() {
                next = self.modes[at(q, j)] + if j + 1 == until_j { T::ZERO } else { self.line[j] * next };
                self.modes[at(q, j)] = next;
            }
            if singular {
                let mut mean = T::ZERO;
                for j in 0..=m {
                    mean += self.modes[at(q, j)] * if j == 0 || j == m { T::HALF } else { T::ONE };
                }
                mean /= T::from_usize(m);
                for j in 0..=m {
                    self.modes[at(q, j)] += -mean;
                }
            }
        }
        for j in from..until_j {
            for i in from..until_i {
                let mut sum = T::ZERO;
                for q in from..until_i {
                    sum += weight(q) * self.modes[at(q, j)] * basis(i, q);
                }
                potential[at(i, j)] = sum;
            }
        }
        Ok(())
    }
}

/// Overwrites `gradient` with the centred differences.
#[allow(clippy::indexing_slicing, reason = "for now")]
pub(super) fn differences<T: Real>(
    mesh: &Mesh<T>,
    equation: &Equation<T>,
    monopole: &Monopole<T>,
    potential: &[T],
    gradient: &mut [[T; 2]],
    _executor: &dyn Executor,
) -> Result<()> {
    let [n, m] = mesh.cells().map(|n| n as isize);
    let [h, k] = mesh.spacing();
    let u = |i: isize, j: isize| {
        if equation.walls == Walls::NoFlux {
            let fold = |i: isize, n: isize| {
                if i < 0 {
                    -i
                } else if i > n {
                    2 * n - i
                } else {
                    i
                }
            };
            potential[(fold(j, m) * (n + 1) + fold(i, n)) as usize]
        } else if i < 0 || i > n || j < 0 || j > m {
            monopole.potential(mesh.node(i, j))
        } else {
            potential[(j * (n + 1) + i) as usize]
        }
    };
    for j in 0..=m {
        for i in 0..=n {
            gradient[(j * (n + 1) + i) as usize] =
                [(u(i + 1, j) - u(i - 1, j)) / (T::TWO * h), (u(i, j + 1) - u(i, j - 1)) / (T::TWO * k)];
        }
    }
    Ok(())
}
