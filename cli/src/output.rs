//! Files that a run leaves: tables, particles, the summary.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};

use crate::files::write;
use crate::history::{Event, History};
use crate::particles::Particles;

/// A number that reads back as the same: whole ones below ten million in plain digits, others as they are shortest.
fn number(value: f64) -> String {
    // Rust prints as many digits as tell the number from its neighbours.
    let plain = format!("{value}");
    let scientific = format!("{value:e}");
    let whole = value.fract() == 0.0 && value.abs() < 1e7;
    if whole || plain.len() <= scientific.len() { plain } else { scientific }
}

/// Writes a table with a header.
pub fn table(path: &Path, header: &[String], rows: &[Vec<f64>]) -> Result<()> {
    write(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(header)?;
        for row in rows {
            writer.write_record(row.iter().map(|&value| number(value)))?;
        }
        Ok(writer.flush()?)
    })
}

/// Writes coalescences: absorbed labels are separated by spaces.
pub fn events(path: &Path, events: &[Event]) -> Result<()> {
    write(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(["time", "label", "absorbed", "mass", "index"])?;
        for event in events {
            let absorbed: Vec<String> = event.absorbed.iter().map(u64::to_string).collect();
            writer.write_record([
                number(event.time),
                event.label.to_string(),
                absorbed.join(" "),
                number(event.mass),
                number(event.index),
            ])?;
        }
        Ok(writer.flush()?)
    })
}

/// All that a case may leave.
pub const FILES: [&str; 6] =
    ["diagnostics.csv", "events.csv", "convergence.csv", "particles.npy", "particles.vtp", "particles.csv"];

/// Writes particles in the formats asked for, and the tables of a run.
pub fn history(folder: &Path, history: &History, formats: &[String], with_events: bool) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))?;
    table(&folder.join("diagnostics.csv"), &history.columns, &history.rows)?;
    if with_events {
        events(&folder.join("events.csv"), &history.events)?;
    }
    let particles = &history.end;
    if particles.len() == 0 {
        return Ok(());
    }
    for format in formats {
        match format.as_str() {
            "npy" => npy(&folder.join("particles.npy"), particles)?,
            "vtk" => vtk(&folder.join("particles.vtp"), particles)?,
            _ => particles_csv(&folder.join("particles.csv"), particles)?,
        }
    }
    Ok(())
}

/// Coordinates and mass as an array of shape (n, d + 1), which a scene can read again.
fn npy(path: &Path, particles: &Particles) -> Result<()> {
    use npyz::WriterBuilder;
    let d = particles.dimension;
    write(path, |file| {
        let mut writer = npyz::WriteOptions::new()
            .default_dtype()
            .shape(&[particles.len() as u64, d as u64 + 1])
            .writer(file)
            .begin_nd()?;
        for (position, mass) in particles.positions.chunks_exact(d).zip(&particles.masses) {
            writer.extend(position.iter().chain([mass]))?;
        }
        Ok(writer.finish()?)
    })
}

fn particles_csv(path: &Path, particles: &Particles) -> Result<()> {
    let d = particles.dimension;
    let mut header: Vec<String> = ["x", "y", "z"][..d].iter().map(|&axis| axis.to_owned()).collect();
    header.push("mass".to_owned());
    let mut rows: Vec<Vec<f64>> = particles
        .positions
        .chunks_exact(d)
        .zip(&particles.masses)
        .map(|(position, mass)| position.iter().chain([mass]).copied().collect())
        .collect();
    // A density that the run doesn't carry is no column.
    if !particles.densities.is_empty() {
        header.push("density".to_owned());
        rows.iter_mut().zip(&particles.densities).for_each(|(row, &density)| row.push(density));
    }
    table(path, &header, &rows)
}

/// VTK PolyData in XML with raw appended data: each block is its length in bytes (64 bits), then the values.
fn vtk(path: &Path, particles: &Particles) -> Result<()> {
    let (n, d) = (particles.len(), particles.dimension);
    let mut points = Vec::with_capacity(3 * n);
    for position in particles.positions.chunks_exact(d) {
        points.extend((0..3).map(|axis| position.get(axis).copied().unwrap_or(0.0)));
    }
    let part: Vec<f64> = particles.parts.iter().map(|&part| f64::from(part)).collect();
    let mut blocks: Vec<(&str, &[f64], usize)> = vec![("mass", &particles.masses, 1)];
    if !particles.densities.is_empty() {
        blocks.push(("density", &particles.densities, 1));
    }
    blocks.extend([("part", &part[..], 1), ("points", &points[..], 3)]);
    let mut offset = 0;
    let mut arrays = Vec::new();
    for (name, values, components) in &blocks {
        arrays.push(format!(
            "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>"
        ));
        offset += 8 + 8 * values.len();
    }
    let verts = offset;
    let ends = verts + 8 + 8 * n;
    let place = arrays.pop().unwrap_or_default();
    let of_points = arrays.join("\n");
    write(path, |file| {
        write!(
            file,
            "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <PolyData><Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n\
         <PointData Scalars=\"mass\">\n{of_points}\n</PointData>\n<Points>\n{place}\n</Points>\n\
         <Verts>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"appended\" offset=\"{verts}\"/>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"appended\" offset=\"{ends}\"/>\n</Verts>\n\
         </Piece></PolyData>\n<AppendedData encoding=\"raw\">\n_"
        )?;
        for (_, values, _) in &blocks {
            file.write_all(&(8 * values.len() as u64).to_le_bytes())?;
            for value in *values {
                file.write_all(&value.to_le_bytes())?;
            }
        }
        for first in [0, 1] {
            file.write_all(&(8 * n as u64).to_le_bytes())?;
            for index in 0..n as u64 {
                file.write_all(&(index + first).to_le_bytes())?;
            }
        }
        Ok(writeln!(file, "\n</AppendedData>\n</VTKFile>")?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particles() -> Particles {
        Particles {
            dimension: 2,
            positions: vec![0.0, 1.0, 2.5, -3.0],
            masses: vec![1.0, 2.0],
            densities: vec![0.5, 0.25],
            parts: vec![0, 1],
        }
    }

    #[test]
    fn vtk_blocks_lie_at_their_offsets() {
        vtk_of(&particles(), &[("density", vec![0.5, 0.25])]);
        vtk_of(&Particles { densities: Vec::new(), ..particles() }, &[]);
    }

    /// The blocks that there always are, and these further ones.
    fn vtk_of(particles: &Particles, further: &[(&str, Vec<f64>)]) {
        let path = std::env::temp_dir().join(format!("mollis-{}-{}.vtp", std::process::id(), further.len()));
        vtk(&path, particles).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let start = bytes.windows(14).position(|w| w == b"encoding=\"raw\"").unwrap() + 17;
        assert_eq!(bytes[start - 1], b'_');
        let text = String::from_utf8_lossy(&bytes[..start]).into_owned();
        let offset = |name: &str| -> usize {
            let at = text.find(&format!("Name=\"{name}\"")).unwrap();
            let rest = &text[at..];
            rest[rest.find("offset=\"").unwrap() + 8..].split('"').next().unwrap().parse().unwrap()
        };
        let word = |at: usize| u64::from_le_bytes(bytes[start + at..start + at + 8].try_into().unwrap());
        assert_eq!(text.contains("density"), !further.is_empty());
        let always =
            [("mass", vec![1.0, 2.0]), ("part", vec![0.0, 1.0]), ("points", vec![0.0, 1.0, 0.0, 2.5, -3.0, 0.0])];
        for (name, values) in always.iter().chain(further) {
            let at = offset(name);
            assert_eq!(word(at), 8 * values.len() as u64, "{name}");
            for (i, value) in values.iter().enumerate() {
                assert_eq!(f64::from_bits(word(at + 8 + 8 * i)), *value, "{name}");
            }
        }
        assert_eq!((word(offset("offsets")), word(offset("offsets") + 8), word(offset("offsets") + 16)), (16, 1, 2));
    }

    #[test]
    fn numbers_are_short_and_read_back() {
        for (value, text) in [
            (0.0, "0"),
            (40_000.0, "40000"),
            (-1e6, "-1000000"),
            (1e7, "1e7"),
            (0.25, "0.25"),
            (1e-5, "1e-5"),
            (1e-300, "1e-300"),
            (1.5e300, "1.5e300"),
            (123_456_789.5, "123456789.5"),
            (0.012_345, "0.012345"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), text);
        }
        let mut bits = 1_u64;
        for _ in 0..20_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let value = f64::from_bits(bits);
            let text = number(value);
            assert!(text.parse::<f64>().unwrap().to_bits() == bits || value.is_nan(), "{text}");
            // A sign, seventeen digits, a point and an exponent.
            assert!(text.len() <= 24, "{text}");
        }
    }

    #[test]
    fn npy_is_read_back() {
        let path = std::env::temp_dir().join(format!("mollis-{}.npy", std::process::id()));
        npy(&path, &particles()).unwrap();
        let array = npyz::NpyFile::new(std::fs::File::open(&path).unwrap()).unwrap();
        assert_eq!(array.shape(), [2, 3]);
        assert_eq!(array.into_vec::<f64>().unwrap(), [0.0, 1.0, 1.0, 2.5, -3.0, 2.0]);
        std::fs::remove_file(&path).unwrap();
    }
}
