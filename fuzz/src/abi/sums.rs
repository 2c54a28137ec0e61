//! Sums: size query, text, evaluation.

use mollis_abi::*;

use super::Calls;
use super::forms::{Form, Scalar};
use super::host::Run;
use crate::memory::Role;

/// Points in an array: pointers, stride.
pub struct Placed<T, const D: usize>(pub [*mut T; D], pub usize);

impl Calls<'_, '_> {
    /// A stride for elements of this width: usually 0 or the width.
    fn stride(&mut self, n: usize, width: usize) -> (usize, usize) {
        let stride = match self.draw.below(6) {
            0..=2 => 0,
            3 => width,
            4 => width + self.draw.below(4),
            _ if self.draw.tame => width,
            // Too short for points; or, with several elements, longer than memory.
            _ => self.draw.pick(&[1, 2, 1 << 62, usize::MAX]),
        };
        let held = if stride == 0 { width } else { stride };
        let span = if n == 0 { 0 } else { (n - 1).saturating_mul(held).saturating_add(width) };
        // What can't be held is refused before it is looked at.
        (stride, if span > 6000 { width } else { span })
    }

    /// Points from these numbers, in an array of their own each coordinate, or together.
    pub fn layout<T: Scalar, const D: usize>(&mut self, n: usize, role: Role) -> Placed<T, D> {
        let apart = D > 1 && self.draw.rarely(4);
        let width = if apart { 1 } else { D };
        let (stride, span) = self.stride(n, width);
        let mut pointers = [std::ptr::null_mut(); D];
        for pointer in pointers.iter_mut().take(if apart { D } else { 1 }) {
            let numbers = self.numbers::<T>(span);
            *pointer = self.pointer(&numbers, role);
        }
        Placed(pointers, stride)
    }

    /// A column: pointer and stride; positive numbers or any.
    pub fn column<T: Scalar>(&mut self, n: usize, positive: bool, role: Role) -> (*mut T, usize) {
        let (stride, span) = self.stride(n, 1);
        let numbers = if positive { self.positive::<T>(span) } else { self.numbers::<T>(span) };
        (self.pointer(&numbers, role), stride)
    }

    pub fn sources<T: Scalar, const D: usize>(&mut self, n: usize) -> SourcesOf<T, D> {
        let Placed(positions, stride) = self.layout::<T, D>(n, Role::Input);
        let (masses, mass_stride) = self.column::<T>(n, false, Role::Input);
        let (mut radii, mut radius_stride) = (std::ptr::null_mut(), 0);
        if self.draw.rarely(6) {
            (radii, radius_stride) = self.column::<T>(n, true, Role::Input);
        }
        let mut strengths = Placed([std::ptr::null_mut(); D], 0);
        if self.draw.rarely(if D == 3 { 4 } else { 30 }) {
            strengths = self.layout::<T, D>(n, Role::Input);
        }
        SourcesOf {
            n: self.stated(n),
            positions: positions.map(<*mut T>::cast_const),
            stride,
            masses,
            mass_stride,
            radii,
            radius_stride,
            strengths: strengths.0.map(<*mut T>::cast_const),
            strength_stride: strengths.1,
        }
    }

    /// Targets, or null for the sources: pointer and number.
    pub fn targets<T: Scalar, const D: usize>(&mut self, sources: usize) -> (*const TargetsOf<T, D>, usize) {
        if self.draw.rarely(2) {
            return (std::ptr::null(), sources);
        }
        let n = self.draw.count();
        let Placed(positions, stride) = self.layout::<T, D>(n, Role::Input);
        let (mut radii, mut radius_stride) = (std::ptr::null_mut(), 0);
        if self.draw.rarely(8) {
            (radii, radius_stride) = self.column::<T>(n, true, Role::Input);
        }
        let targets = TargetsOf {
            n: self.stated(n),
            positions: positions.map(<*mut T>::cast_const),
            stride,
            radii,
            radius_stride,
        };
        (self.input(&[targets]), n)
    }

    fn outputs<T: Scalar, const D: usize>(&mut self, n: usize) -> OutputsOf<T, D> {
        let column = |calls: &mut Self| {
            if calls.draw.rarely(3) { (std::ptr::null_mut(), 0) } else { calls.column::<T>(n, false, Role::Output) }
        };
        let (potential, potential_stride) = column(self);
        let (laplacian, laplacian_stride) = column(self);
        let mut gradient = Placed([std::ptr::null_mut(); D], 0);
        if !self.draw.rarely(4) {
            gradient = self.layout::<T, D>(n, Role::Output);
        }
        let (mut hessian, mut hessian_stride) = (std::ptr::null_mut(), 0);
        if self.draw.rarely(4) {
            let (stride, span) = self.stride(n, D * D);
            let numbers = self.numbers::<T>(span);
            (hessian, hessian_stride) = (self.pointer(&numbers, Role::Output), stride);
        }
        let factor = self.draw.pick(&[0.0, 1.0, -2.5]);
        OutputsOf {
            potential,
            potential_stride,
            gradient: gradient.0,
            gradient_stride: gradient.1,
            laplacian,
            laplacian_stride,
            hessian,
            hessian_stride,
            factor: self.draw.or_wild(factor),
            add: self.draw.pick(if self.draw.tame { &[0, 1] } else { &[0, 1, 2, -1] }),
            reserved: 0,
        }
    }

    fn field_options(&mut self) -> *const mollis_field_options {
        let any = if self.draw.tame { 0 } else { 30 };
        let choice = |calls: &mut Self, most: i32| {
            if any > 0 && calls.draw.rarely(any) {
                calls.draw.wild() as i32
            } else {
                i32::from(calls.draw.byte()) % most
            }
        };
        let (method, accumulation, pair_radius) = (choice(self, 8), choice(self, 2), choice(self, 4));
        let pair_radius = if self.draw.rarely(3) { pair_radius } else { 0 };
        let combination =
            if self.draw.rarely(4) { [self.draw.or_wild(0.5), self.draw.or_wild(-1.0)] } else { [1.0, 0.0] };
        let options = mollis_field_options {
            size: size_of::<mollis_field_options>() as u32,
            method: if self.draw.rarely(2) { method } else { 0 },
            accumulation,
            pair_radius,
            combination,
            tolerance: self.tolerance(),
        };
        self.options(options)
    }

    pub fn sum<T: Form<D>, const D: usize>(&mut self) {
        let block = self.kernel::<T, D>();
        let n = self.draw.count();
        let sources = self.sources::<T, D>(n);
        let sources = self.input(&[sources]);
        let (targets, m) = self.targets::<T, D>(n);
        let outputs = self.outputs::<T, D>(m);
        let outputs = self.input(&[outputs]);
        let options = self.field_options();
        let run = self.run();
        let needed = self.output(1, 0_usize);
        self.begin();
        // SAFETY: every pointer is null, misaligned, or has its length.
        let asked = unsafe {
            T::field_bytes(block.start, block.bytes, sources, targets, outputs, options, run.options, needed)
        };
        self.end("field_bytes", asked);
        if self.draw.rarely(5) {
            let room = self.draw.pick(&[0, 1, 5, 400]);
            let (text, length) = (self.output(room, b'x'), self.perhaps(1, 0_usize));
            self.begin();
            // SAFETY: as above.
            let status = unsafe {
                T::field_text(block.start, block.bytes, sources, targets, outputs, options, text.cast(), room, length)
            };
            self.end("field_text", status);
        }
        // SAFETY: written, as the query succeeded.
        let bytes = (asked == 0).then(|| unsafe { *needed });
        let Some((workspace, room, enough)) = self.workspace(bytes) else { return };
        let counts = if self.draw.rarely(3) {
            std::ptr::null_mut()
        } else {
            let none = mollis_field_counts {
                pairs: 0,
                near_pairs: 0,
                polynomial_blocks: 0,
                all_near_blocks: 0,
                scaled_pairs: 0,
                massless_sources: 0,
                beyond_reach: 0,
            };
            self.output(1, none)
        };
        self.begin();
        // SAFETY: as above.
        let status = unsafe {
            T::field_eval(
                block.start,
                block.bytes,
                sources,
                targets,
                outputs,
                options,
                run.options,
                workspace,
                room,
                counts,
            )
        };
        self.end("field_eval", status);
        self.room("field_eval", status, bytes, (room, enough && block.whole), &run);
    }

    /// A workspace of the bytes that were asked for suffices, and one that lacks more than its alignment does not; the run is told the same bytes.
    pub fn room(&self, what: &str, status: i32, needed: Option<usize>, (given, enough): (usize, bool), run: &Run) {
        if let (Some(needed), 3) = (needed, status) {
            let told = run.bytes_needed();
            assert!(told.is_none_or(|told| told == needed || told == 0), "{what}: needs {needed} bytes, told {told:?}");
        }
        assert!(!(enough && status == 3), "{what}: {needed:?} bytes, as asked for, are too few");
        if let (Some(needed), 0) = (needed, status) {
            assert!(given + 64 > needed, "{what}: succeeded in {given} of {needed} bytes");
        }
    }
}
