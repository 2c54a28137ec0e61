//! What a run keeps of itself: rows of diagnostics, paths, snapshots, events.

use anyhow::Result;

use crate::checkpoint::{Reader, Writer};
use crate::particles::Particles;

/// One coalescence.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub time: f64,
    /// The label that goes on.
    pub label: u64,
    /// The labels that ended in it.
    pub absorbed: Vec<u64>,
    /// The mass of the merged particle.
    pub mass: f64,
    /// The index of the cluster.
    pub index: f64,
}

/// All particles at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// When.
    pub time: f64,
    /// The particles then.
    pub particles: Particles,
}

/// What one run leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// The spacing of the grid, or 0.
    pub h: f64,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows of diagnostics.
    pub rows: Vec<Vec<f64>>,
    /// When paths were recorded, and the followed particles' coordinates then.
    pub paths: Vec<(f64, Vec<f64>)>,
    /// Where the followed particles started.
    pub followed: Vec<f64>,
    /// Snapshots.
    pub snapshots: Vec<Snapshot>,
    /// Coalescences.
    pub events: Vec<Event>,
    /// The particles at the start.
    pub start: Particles,
    /// The particles at the end.
    pub end: Particles,
    /// How sums are evaluated and what is skipped.
    pub plan: Vec<String>,
    /// Seconds by phase.
    pub seconds: Vec<(String, f64)>,
    /// Whether the run has reached its end.
    pub done: bool,
}

impl History {
    /// A column over time, as points (time, value).
    pub fn column(&self, name: &str) -> Option<Vec<[f64; 2]>> {
        let at = self.columns.iter().position(|column| column == name)?;
        Some(self.rows.iter().map(|row| [row[0], row[at]]).collect())
    }

    /// Adds time to a phase.
    pub fn spent(&mut self, phase: &str, seconds: f64) {
        match self.seconds.iter_mut().find(|(name, _)| name == phase) {
            Some((_, sum)) => *sum += seconds,
            None => self.seconds.push((phase.to_owned(), seconds)),
        }
    }

    /// Into a checkpoint.
    pub fn save(&self, writer: &mut Writer) {
        writer.number(self.h);
        texts(writer, &self.columns);
        writer.count(self.rows.len() as u64);
        for row in &self.rows {
            writer.numbers(row);
        }
        writer.count(self.paths.len() as u64);
        for (time, points) in &self.paths {
            writer.number(*time);
            writer.numbers(points);
        }
        writer.numbers(&self.followed);
        writer.count(self.snapshots.len() as u64);
        for snapshot in &self.snapshots {
            writer.number(snapshot.time);
            save_particles(writer, &snapshot.particles);
        }
        writer.count(self.events.len() as u64);
        for event in &self.events {
            writer.numbers(&[event.time, event.mass, event.index]);
            writer.count(event.label);
            writer.counts(&event.absorbed);
        }
        save_particles(writer, &self.start);
        save_particles(writer, &self.end);
        texts(writer, &self.plan);
        writer.count(self.seconds.len() as u64);
        for (phase, seconds) in &self.seconds {
            writer.bytes(phase.as_bytes());
            writer.number(*seconds);
        }
        writer.count(u64::from(self.done));
    }

    /// From a checkpoint.
    pub fn restore(reader: &mut Reader) -> Result<Self> {
        let h = reader.number()?;
        let columns = read_texts(reader)?;
        let rows = (0..reader.count()?).map(|_| reader.numbers()).collect::<Result<_>>()?;
        let paths = (0..reader.count()?).map(|_| Ok((reader.number()?, reader.numbers()?))).collect::<Result<_>>()?;
        let followed = reader.numbers()?;
        let snapshots = (0..reader.count()?)
            .map(|_| Ok(Snapshot { time: reader.number()?, particles: restore_particles(reader)? }))
            .collect::<Result<_>>()?;
        let event = |reader: &mut Reader| {
            let numbers = reader.numbers()?;
            let [time, mass, index] = numbers[..] else { anyhow::bail!("the checkpoint is of another scene") };
            Ok(Event { time, mass, index, label: reader.count()?, absorbed: reader.counts()? })
        };
        let events = (0..reader.count()?).map(|_| event(reader)).collect::<Result<_>>()?;
        let (start, end) = (restore_particles(reader)?, restore_particles(reader)?);
        let plan = read_texts(reader)?;
        let seconds = (0..reader.count()?)
            .map(|_| Ok((String::from_utf8(reader.bytes()?)?, reader.number()?)))
            .collect::<Result<_>>()?;
        let done = reader.count()? == 1;
        Ok(Self { h, columns, rows, paths, followed, snapshots, events, start, end, plan, seconds, done })
    }
}

fn texts(writer: &mut Writer, texts: &[String]) {
    writer.count(texts.len() as u64);
    for text in texts {
        writer.bytes(text.as_bytes());
    }
}

fn read_texts(reader: &mut Reader) -> Result<Vec<String>> {
    (0..reader.count()?).map(|_| Ok(String::from_utf8(reader.bytes()?)?)).collect()
}

fn save_particles(writer: &mut Writer, particles: &Particles) {
    writer.count(particles.dimension as u64);
    writer.numbers(&particles.positions);
    writer.numbers(&particles.masses);
    writer.numbers(&particles.densities);
    writer.bytes(&particles.parts);
}

fn restore_particles(reader: &mut Reader) -> Result<Particles> {
    Ok(Particles {
        dimension: reader.count()? as usize,
        positions: reader.numbers()?,
        masses: reader.numbers()?,
        densities: reader.numbers()?,
        parts: reader.bytes()?,
    })
}
