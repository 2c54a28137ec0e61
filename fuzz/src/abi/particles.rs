//! The blob method: size query and steps.

use mollis_abi::*;

use super::Calls;
use super::forms::{Form, Scalar};
use super::sums::Placed;
use crate::memory::Role;

impl Calls<'_, '_> {
    fn moved<T: Scalar, const D: usize>(&mut self, n: usize, massless: bool, density: bool) -> ParticlesOf<T, D> {
        let Placed(positions, stride) = self.layout::<T, D>(n, Role::Output);
        let (masses, mass_stride) =
            if massless { (std::ptr::null_mut(), 0) } else { self.column::<T>(n, false, Role::Input) };
        let nothing = (std::ptr::null_mut(), 0);
        let (density, density_stride) = if density { self.column::<T>(n, true, Role::Output) } else { nothing };
        let mut velocity = Placed([std::ptr::null_mut(); D], 0);
        if self.draw.rarely(3) {
            velocity = self.layout::<T, D>(n, Role::Output);
        }
        let wanted = !massless && self.draw.rarely(3) || !self.draw.tame && self.draw.rarely(20);
        let (divergence, divergence_stride) = if wanted { self.column::<T>(n, false, Role::Output) } else { nothing };
        ParticlesOf {
            n: self.stated(n),
            positions,
            stride,
            masses,
            mass_stride,
            density,
            density_stride,
            velocity: velocity.0,
            velocity_stride: velocity.1,
            divergence,
            divergence_stride,
        }
    }

    pub fn blob<T: Form<D>, const D: usize>(&mut self) {
        let block = self.kernel::<T, D>();
        let n = self.draw.count();
        let density = self.draw.rarely(3);
        let particles = self.moved::<T, D>(n, false, density);
        let particles = self.input(&[particles]);
        let mut tracers = std::ptr::null();
        if self.draw.rarely(4) {
            let m = self.draw.below(20);
            let others = density ^ (!self.draw.tame && self.draw.rarely(12));
            let given = self.moved::<T, D>(m, true, others);
            tracers = self.input(&[given]);
        }
        let options = self.blob_options();
        let run = self.run();
        let needed = self.output(1, 0_usize);
        self.begin();
        // SAFETY: every pointer is null, misaligned, or has its length.
        let asked =
            unsafe { T::blob_bytes(block.start, block.bytes, particles, tracers, options, run.options, needed) };
        self.end("blob_bytes", asked);
        // SAFETY: written, as the query succeeded.
        let bytes = (asked == 0).then(|| unsafe { *needed });
        let Some((workspace, room, enough)) = self.workspace(bytes) else { return };
        let none = mollis_blob_report { steps: 0, first_bad: 0, energy_first: 0.0, energy_last: 0.0 };
        let report = self.told(none);
        let (dt, steps) = (self.draw.pick(&[1e-3, 0.1, 1.0]), self.draw.below(4));
        let dt = self.draw.or_wild(dt);
        self.begin();
        // SAFETY: as above.
        let status = unsafe {
            T::blob_step(
                block.start,
                block.bytes,
                particles,
                tracers,
                dt,
                steps,
                options,
                run.options,
                workspace,
                room,
                report,
            )
        };
        self.end("blob_step", status);
        self.room("blob_step", status, bytes, (room, enough && block.whole), &run);
        if status == 0 && n > 0 {
            // SAFETY: the call read the structure, and the first coordinate where it points to.
            let first: f64 = unsafe { (*(*particles).positions[0]).into() };
            assert!(first.is_finite(), "blob_step: succeeded with a position that is not finite");
        }
    }
}
