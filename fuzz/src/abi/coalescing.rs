//! Coalescing particles: size query and steps, continued where the buffer of events was full.

use mollis_abi::*;

use super::Calls;
use super::forms::Form;
use crate::memory::Role;

impl Calls<'_, '_> {
    fn attraction<T: Form<2>>(&mut self) -> (*const mollis_pks_attraction, bool) {
        let kind = if self.draw.tame { self.draw.pick(&[0, 1, 2]) } else { self.draw.pick(&[0, 1, 2, 2, 1, 3, -1]) };
        let block = self.kernel::<T, 2>();
        let mut rectangle = self.rectangle();
        rectangle.cells = rectangle.cells.map(|c| if c > 1 << 20 { 16 } else { c });
        let heavy = if self.draw.rarely(3) { self.draw.positive() } else { 0.0 };
        let attraction = mollis_pks_attraction {
            kind,
            reserved: 0,
            mesh: if !self.draw.tame && self.draw.rarely(30) { std::ptr::null() } else { self.input(&[rectangle]) },
            grid: self.mesh_options(),
            kernel: block.start,
            kernel_bytes: block.bytes,
            tolerance: self.tolerance(),
            heavy: self.draw.or_wild(heavy),
        };
        (self.input(&[attraction]), block.whole)
    }

    fn step_options(&mut self) -> mollis_pks_options {
        let choice = |calls: &mut Self, most: i32| {
            let wild = !calls.draw.tame && calls.draw.rarely(30);
            if wild { calls.draw.wild() as i32 } else { i32::from(calls.draw.byte()) % most }
        };
        let (law, merging, scheme) = (choice(self, 2), choice(self, 3), choice(self, 2));
        let (chi, noise) = (self.draw.pick(&[20.0, 0.0, 200.0, -3.0, 1.0]), self.draw.pick(&[1.0, 0.0, 1e-3, 10.0]));
        let mut domain = [0.0; 4];
        if self.draw.rarely(5) {
            domain = [-3.0, -3.0, 3.0, 3.0].map(|x| self.draw.or_wild(x));
        }
        mollis_pks_options {
            size: size_of::<mollis_pks_options>() as u32,
            law,
            merging,
            scheme,
            chi: self.draw.or_wild(chi),
            noise: self.draw.or_wild(noise),
            gamma: self.draw.or_wild(1.0 / std::f64::consts::TAU),
            separation: self.draw.or_wild(0.1),
            probability: self.draw.or_wild(1e-4),
            width: if self.draw.rarely(4) { self.draw.or_wild(0.5) } else { 0.0 },
            at_least: self.draw.pick(if self.draw.tame { &[1, 2, 5] } else { &[1, 2, 0, 20, u32::MAX] }),
            // Long runs are not what is looked for here.
            at_most: self.draw.pick(if self.draw.tame { &[60, 300] } else { &[60, 0, 1, 300] }),
            mesh: self.draw.pick(if self.draw.tame {
                &[[1, 1], [3, 2]]
            } else {
                &[[1, 1], [0, 1], [1000, 7], [u32::MAX; 2]]
            }),
            domain,
            shifted: i32::from(self.draw.rarely(2)),
            reserved: 0,
            seed: self.draw.word(),
        }
    }

    pub fn coalescing<T: Form<2>>(&mut self) {
        let (attraction, whole) = self.attraction::<T>();
        let options = self.step_options();
        let options = self.options(options);
        let run = self.run();
        let generator = self.generator();
        let room = self.draw.count();
        let stated = self.stated(room);
        let needed = self.output(1, 0_usize);
        self.begin();
        // SAFETY: every pointer is null, misaligned, or has its length.
        let asked = unsafe { T::pks_bytes(stated, attraction, options, run.options, needed) };
        self.end("pks_bytes", asked);
        // SAFETY: written, as the query succeeded.
        let bytes = (asked == 0).then(|| unsafe { *needed });
        let Some((workspace, given, enough)) = self.workspace(bytes) else { return };

        let (positions, masses) = (self.points::<T, 2>(room), self.positive::<T>(room));
        let labels: Vec<u64> = (0..room as u64).map(|k| k.wrapping_mul(0x9E37_79B9_7F4A_7C15)).collect();
        let positions = self.pointer(&positions, Role::Output);
        let (masses, labels) = (self.pointer(&masses, Role::Output), self.pointer(&labels, Role::Output));
        let species = self.perhaps(room, 3_u32);
        let weights = self.draw.rarely(2).then(|| self.positive::<T>(room));
        let weights = weights.map_or(std::ptr::null_mut(), |weights| self.pointer(&weights, Role::Output));
        let particles = PksParticlesOf { room: stated, positions, masses, labels, species, weights };
        let particles = self.input(&[particles]);
        let mut count = room as u64 - room as u64 / 4;
        let mut pending = 0;
        if !self.draw.tame && self.draw.rarely(16) {
            count = self.draw.pick(&[0, 1, room as u64 + 1, u64::MAX]);
        }
        if !self.draw.tame && self.draw.rarely(24) {
            pending = self.draw.pick(&[1, u64::MAX, 2]);
        }
        let progress = mollis_pks_progress {
            time: self.draw.or_wild(0.0),
            step: self.draw.pick(&[0, 7, u64::MAX]),
            count,
            pending,
        };
        let progress = self.pointer(&[progress], Role::Output);
        let none = mollis_pks_event { time: 0.0, label: 0, mass: 0.0, index: 0.0, first: 0, absorbed: 0 };
        let (events_room, labels_room) = (self.draw.below(12), self.draw.below(40));
        let written = if !self.draw.tame && self.draw.rarely(16) { self.draw.pick(&[1, 100, usize::MAX]) } else { 0 };
        let events = mollis_pks_events {
            events: self.pointer(&vec![none; events_room], Role::Output),
            room: events_room,
            written,
            labels: self.pointer(&vec![0; labels_room], Role::Output),
            labels_room,
            labels_written: written.min(labels_room),
        };
        let events = self.pointer(&[events], Role::Output);
        let none =
            mollis_pks_report { substeps: 0, normals: 0, fields: 0, searches: 0, clusters: 0, merges: 0, absorbed: 0 };
        let report = self.told(none);
        let (dt, steps) = (self.draw.pick(&[1e-3, 1e-2, 1.0]), self.draw.below(3));
        let dt = self.draw.or_wild(dt);
        for _ in 0..4 {
            self.begin();
            // SAFETY: as above.
            let status = unsafe {
                T::pks_step(
                    particles,
                    progress,
                    attraction,
                    generator,
                    dt,
                    steps,
                    events,
                    options,
                    run.options,
                    workspace,
                    given,
                    report,
                )
            };
            self.end("pks_step", status);
            self.room("pks_step", status, bytes, (given, enough && whole), &run);
            // Others may stop before the arrays were looked at.
            if steps > 0 && [0, 40, 42, 43].contains(&status) {
                // SAFETY: the call read them, and wrote them.
                unsafe {
                    let alive = (*progress).count as usize;
                    assert!(alive <= room, "pks_step: {alive} particles in room for {room}");
                    assert!((*events).written <= events_room && (*events).labels_written <= labels_room);
                    for k in 0..alive {
                        let (x, m) = (*positions.add(k), *masses.add(k));
                        let fine = x.iter().all(|&x| x.into().is_finite()) && m.into() > 0.0;
                        assert!(fine, "pks_step, status {status}: particle {k} is not finite");
                    }
                }
            }
            if status != 42 {
                break;
            }
            // SAFETY: as above.
            unsafe { ((*events).written, (*events).labels_written) = (0, 0) };
        }
    }
}
