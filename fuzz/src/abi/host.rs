//! Functions of the host: executors, generators, kernels, questions.

use std::cell::Cell;
use std::ffi::c_void;

use mollis_abi::*;

use super::{Calls, OF_HOST};
use crate::memory::Role;

thread_local! {
    /// How often functions of the host were called in this call of the library.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() -> u64 {
    COUNT.replace(COUNT.get() + 1)
}

/// The context says how to behave: what to return from the n-th call on.
fn behaviour(context: *mut c_void) -> (usize, u64) {
    (context.addr() & 7, (context.addr() >> 3) as u64)
}

unsafe extern "C" fn parallel_for(context: *mut c_void, tasks: usize, task: mollis_task, data: *mut c_void) -> i32 {
    let (kind, last) = behaviour(context);
    let task = task.expect("the library passes a task");
    let refuses = count() >= last;
    for index in 0..tasks {
        let index = if kind & 1 == 1 { tasks - 1 - index } else { index };
        // An executor that forgets a task.
        if refuses && kind == 2 && index == tasks / 2 {
            continue;
        }
        // SAFETY: as the header says.
        let status = unsafe { task(data, index, 0) };
        assert_eq!(status, 0);
    }
    if refuses && kind >= 4 { OF_HOST[kind % 3] } else { 0 }
}

unsafe extern "C" fn should_stop(context: *mut c_void) -> i32 {
    let (_, last) = behaviour(context);
    i32::from(count() >= last)
}

unsafe extern "C" fn after_step(context: *mut c_void, _: usize, positions: *const c_void, _: *const c_void) -> i32 {
    assert!(!positions.is_null());
    let (_, last) = behaviour(context);
    i32::from(count() >= last)
}

unsafe extern "C" fn fill(state: *mut c_void, out: *mut u64, n: usize) -> i32 {
    let (kind, last) = behaviour(state);
    let mut seed = count();
    let refuses = seed >= last;
    for k in 0..n {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k as u64 + 1);
        let word = [seed, seed ^ seed >> 29, 0, u64::MAX, 1 << 63, 1, seed << 40, seed >> 40][kind];
        // SAFETY: as the header says.
        unsafe { out.add(k).write(word) };
    }
    if refuses { OF_HOST[kind % 3] } else { 0 }
}

unsafe extern "C" fn evaluate(context: *mut c_void, r: f64, out: *mut f64) -> i32 {
    let (kind, last) = behaviour(context);
    let refuses = count() >= last;
    let square = r * r + 0.04;
    let values = match kind {
        0 => [0.5 * r * r, 1.0, 2.0],
        1 => [-1.0 / square.sqrt(), square.powf(-1.5), 0.08 * square.powf(-2.5)],
        2 => [(-r).exp(), -(-r).exp() / r, (-r).exp()],
        3 => [0.0; 3],
        4 => [1e300, -1e300, 1e300],
        5 if refuses => [f64::NAN, 1.0, 1.0],
        6 => [r.sin(), r.cos() / r, -r.sin()],
        _ => [5e-324, 0.0, -0.0],
    };
    // SAFETY: as the header says.
    unsafe { out.cast::<[f64; 3]>().write_unaligned(values) };
    if refuses && kind == 7 { OF_HOST[0] } else { 0 }
}

impl Calls<'_, '_> {
    /// How a function of the host behaves, and from which call on.
    fn context(&mut self) -> *mut c_void {
        let last = match self.draw.below(4) {
            0 => usize::from(self.draw.byte() % 16),
            _ => 1 << 40,
        };
        std::ptr::without_provenance_mut(last << 3 | self.draw.below(8))
    }

    fn executor(&mut self) -> *const mollis_executor {
        if !self.draw.rarely(3) {
            return std::ptr::null();
        }
        let workers = if self.draw.tame { 1 } else { self.draw.pick(&[1, 2, 3, 7, 256, 0, 257, usize::MAX]) };
        let function = if !self.draw.tame && self.draw.rarely(20) { None } else { Some(parallel_for as _) };
        let executor = mollis_executor { context: self.context(), workers, parallel_for: function };
        self.input(&[executor])
    }

    /// How a call runs.
    pub fn run(&mut self) -> Run {
        COUNT.set(0);
        if self.draw.rarely(3) {
            return Run::none();
        }
        let level =
            if self.draw.tame { self.draw.pick(&[-1, 0]) } else { self.draw.pick(&[-1, 0, 1, 2, 3, 4, i32::MIN]) };
        let needed = self.told(usize::MAX);
        let run = mollis_run {
            size: size_of::<mollis_run>() as u32,
            level,
            executor: self.executor(),
            should_stop: if self.draw.rarely(6) { Some(should_stop as _) } else { None },
            stop_context: self.context(),
            first_bad: self.told(0_u64),
            bytes_needed: needed,
            communicator: std::ptr::null(),
        };
        Run { options: self.options(run), needed }
    }

    pub fn blob_options(&mut self) -> *const mollis_blob_options {
        let combination =
            if self.draw.rarely(4) { [self.draw.or_wild(0.0), self.draw.or_wild(-1.0)] } else { [1.0, 0.0] };
        let diffusion = if self.draw.rarely(4) { self.draw.or_wild(0.1) } else { 0.0 };
        let exponents = [1.0, 2.0, 3.0, 1.5];
        let options = mollis_blob_options {
            size: size_of::<mollis_blob_options>() as u32,
            watch_energy: i32::from(self.draw.rarely(4)),
            tolerance: self.tolerance(),
            after_step: if self.draw.rarely(6) { Some(after_step as _) } else { None },
            context: self.context(),
            combination,
            diffusion,
            diffusion_exponent: self.draw.pick(&exponents),
            diffusion_mollifier: self.shape(),
            diffusion_length: self.draw.or_wild(0.3),
        };
        self.options(options)
    }

    /// The error that may be spent for speed.
    pub fn tolerance(&mut self) -> f64 {
        let usual = self.draw.pick(&[0.0, 0.0, 1e-13, 1e-6, 1e-2, 1e-5, 1.0]);
        self.draw.or_wild(usual)
    }

    pub fn generator(&mut self) -> *const mollis_generator {
        if !self.draw.rarely(3) {
            return std::ptr::null();
        }
        let fill = if !self.draw.tame && self.draw.rarely(20) { None } else { Some(fill as _) };
        let generator = mollis_generator { state: self.context(), fill };
        self.input(&[generator])
    }

    /// A kernel of the host's, or none.
    pub fn own(&mut self) -> *const mollis_radial_kernel {
        COUNT.set(0);
        if !self.draw.rarely(5) {
            return std::ptr::null();
        }
        let n = self.draw.pick(&[0, 0, 1, 2, 8]);
        let n = if self.draw.tame { n } else { self.draw.pick(&[n, n, n, 9]) };
        let mut knots: Vec<f64> = (1..=n).map(|k| k as f64 / 8.0).collect();
        if !self.draw.tame && self.draw.rarely(4) {
            knots = self.draw.numbers(n, true);
        }
        let evaluate = if !self.draw.tame && self.draw.rarely(20) { None } else { Some(evaluate as _) };
        let errors = if self.draw.rarely(2) { std::ptr::null_mut() } else { self.pointer(&[0.0; 3], Role::Scratch) };
        let (tolerance, least) = (self.draw.pick(&[f64::INFINITY, 0.0, 1e-3]), self.draw.pick(&[0.0, 1e-6]));
        let own = mollis_radial_kernel {
            context: self.context(),
            evaluate,
            coefficient: self.draw.or_wild(1.0),
            reach: self.draw.or_wild(4.0),
            tolerance: self.draw.or_wild(tolerance),
            least: self.draw.or_wild(least),
            n_knots: self.stated(n),
            knots: self.input(&knots),
            errors,
        };
        self.input(&[own])
    }
}

/// A `mollis_run`, and where it has the bytes written that a workspace lacks.
pub struct Run {
    pub options: *const mollis_run,
    needed: *const usize,
}

impl Run {
    /// The defaults.
    pub fn none() -> Self {
        Self { options: std::ptr::null(), needed: std::ptr::null() }
    }

    /// What was written there.
    pub fn bytes_needed(&self) -> Option<usize> {
        // SAFETY: null, or one number, perhaps misaligned.
        let told = (!self.needed.is_null()).then(|| unsafe { self.needed.read_unaligned() });
        told.filter(|&told| told != usize::MAX)
    }
}
