//! Coalescing particles and their steps.

use mollis_core::Result;
use mollis_core::exec::Run;
use mollis_core::pks::{Attraction, Counters, Event, Events, Options, Setting, State, step, workspace_bytes};
use mollis_core::random::Philox;

use crate::Aligned;

/// Particles that are advanced with a stream of their own.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// Where they are.
    pub positions: Vec<[f64; 2]>,
    /// Their masses.
    pub masses: Vec<f64>,
    /// 0 to n - 1.
    pub labels: Vec<u64>,
    /// Time, and how many are alive.
    pub counters: Counters,
    /// All merges.
    pub events: Vec<Event>,
}

impl Cloud {
    /// Particles before a step that is not the first, whose mesh of the search has borders through the outermost particles.
    #[must_use]
    pub fn new(positions: Vec<[f64; 2]>, masses: Vec<f64>) -> Self {
        let n = positions.len();
        let counters = Counters { count: n as u64, step: 7, ..Counters::default() };
        Self { positions, masses, labels: (0..n as u64).collect(), counters, events: Vec::new() }
    }

    /// One step.
    ///
    /// # Errors
    /// Those of [`step`].
    pub fn step(&mut self, options: &Options<f64>, attraction: Attraction<'_, '_, f64>, dt: f64) -> Result<()> {
        let n = self.positions.len();
        let mut memory = Aligned::new(workspace_bytes(n, None, options, 1).expect("a size"));
        self.step_with_room(options, attraction, dt, (&mut memory, n))
    }

    /// One step in this memory, with room for so many events.
    ///
    /// # Errors
    /// Those of [`step`].
    pub fn step_with_room(
        &mut self,
        options: &Options<f64>,
        attraction: Attraction<'_, '_, f64>,
        dt: f64,
        (memory, room): (&mut Aligned, usize),
    ) -> Result<()> {
        let (mut events, mut absorbed) = (vec![Event::default(); room], vec![0; self.positions.len()]);
        let (mut written, mut labels_written) = (0, 0);
        let made = step(
            State {
                positions: &mut self.positions,
                masses: &mut self.masses,
                labels: &mut self.labels,
                species: None,
                weights: None,
            },
            &mut self.counters,
            &mut Philox::new(3),
            dt,
            Events {
                events: &mut events,
                labels: &mut absorbed,
                written: &mut written,
                labels_written: &mut labels_written,
            },
            memory.bytes(),
            Setting { options, attraction, run: &mut Run::default(), report: None },
        );
        self.events.extend(&events[..written]);
        made
    }

    /// Positions and masses of the particles alive.
    #[must_use]
    pub fn alive(&self) -> (&[[f64; 2]], &[f64]) {
        let n = self.counters.count as usize;
        (&self.positions[..n], &self.masses[..n])
    }
}
