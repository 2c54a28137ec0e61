//! Points and masses of the user's own: CSV with a header, or NPY. A bad file is refused with the line that is bad.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use super::Particles;

/// Appends the particles of a file.
pub fn read(path: &Path, part: usize, particles: &mut Particles) -> Result<()> {
    let before = particles.len();
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("csv") => csv(path, part, particles)?,
        Some("npy") => npy(path, part, particles)?,
        _ => bail!("{}: must end in .csv or .npy", path.display()),
    }
    ensure!(particles.len() > before, "{}:1: holds no particle", path.display());
    Ok(())
}

fn csv(path: &Path, part: usize, particles: &mut Particles) -> Result<()> {
    let shown = path.display();
    let d = particles.dimension;
    let axes = &["x", "y", "z"][..d];
    let wanted = format!("a header of {}, mass and perhaps density", axes.join(", "));
    let file = File::open(path).with_context(|| format!("{shown}"))?;
    // Numbers need no quotes, so a line is a row: its number in a message is what an editor shows.
    let mut lines = BufReader::new(file).lines().enumerate();
    let first =
        lines.next().map(|(_, line)| line).transpose().with_context(|| format!("{shown}:1"))?.unwrap_or_default();
    ensure!(!first.trim().is_empty(), "{shown}:1: empty; needs {wanted}");
    let header: Vec<&str> = first.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
    let mut known: Vec<&str> = axes.to_vec();
    known.extend(["mass", "density"]);
    for name in &header {
        ensure!(known.contains(name), "{shown}:1: column {name:?}: a scene in {d} dimension(s) needs {wanted}");
    }
    let column = |name: &str| header.iter().position(|&other| other == name);
    let mut needed = Vec::with_capacity(d + 1);
    for name in axes.iter().chain(&["mass"]) {
        needed.push(column(name).with_context(|| format!("{shown}:1: column {name} is missing; needs {wanted}"))?);
    }
    let density = column("density");
    let mut point = vec![0.0; d];
    for (index, text) in lines {
        let line = index + 1;
        let text = text.with_context(|| format!("{shown}:{line}"))?;
        if text.trim().is_empty() {
            continue;
        }
        let record: Vec<&str> = text.split(',').map(str::trim).collect();
        ensure!(
            record.len() == header.len(),
            "{shown}:{line}: {} columns, the header has {}",
            record.len(),
            header.len()
        );
        let value = |at: usize| -> Result<f64> {
            let text = record.get(at).copied().unwrap_or("");
            let name = header.get(at).copied().unwrap_or("");
            let value: f64 =
                text.parse().ok().with_context(|| format!("{shown}:{line}: {name} = {text:?}: not a number"))?;
            ensure!(value.is_finite(), "{shown}:{line}: {name} = {text}: must be finite");
            Ok(value)
        };
        for (x, &at) in point.iter_mut().zip(&needed) {
            *x = value(at)?;
        }
        let rho = density.map_or(Ok(0.0), value)?;
        particles.push(&point, value(needed[d])?, rho, part);
    }
    Ok(())
}

fn npy(path: &Path, part: usize, particles: &mut Particles) -> Result<()> {
    let shown = path.display();
    let d = particles.dimension;
    let open = || -> Result<_> {
        let file = File::open(path).with_context(|| format!("{shown}"))?;
        npyz::NpyFile::new(BufReader::new(file)).with_context(|| format!("{shown}: not an NPY file"))
    };
    let array = open()?;
    let shape = array.shape().to_vec();
    let wanted = d as u64 + 1;
    ensure!(
        shape.len() == 2 && shape[1] == wanted && array.order() == npyz::Order::C,
        "{shown}: shape {shape:?}: a scene in {d} dimension(s) needs (n, {wanted}) in C order: coordinates, mass"
    );
    let values: Vec<f64> = match array.into_vec::<f64>() {
        Ok(values) => values,
        Err(_) => {
            let single = open()?.into_vec::<f32>().with_context(|| format!("{shown}: must hold float64 or float32"))?;
            single.into_iter().map(f64::from).collect()
        }
    };
    for (row, values) in values.chunks_exact(d + 1).enumerate() {
        ensure!(values.iter().all(|value| value.is_finite()), "{shown}: row {row}: {values:?}: must be finite");
        particles.push(&values[..d], values[d], 0.0, part);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        let path = std::env::temp_dir().join(format!("mollis-points-{}-{}.csv", std::process::id(), text.len()));
        std::fs::write(&path, text).unwrap();
        let mut particles = Particles { dimension: 2, ..Particles::default() };
        let result = read(&path, 0, &mut particles);
        std::fs::remove_file(&path).unwrap();
        let message = result.map_or_else(|error| format!("{error:#}"), |()| format!("{} particles", particles.len()));
        message.rsplit_once(".csv:").map_or(message.clone(), |(_, rest)| rest.to_owned())
    }

    #[test]
    fn broken_files_are_refused_with_the_line() {
        assert_eq!(refused("x,y,mass\n0,1,2\n3,4,5\n"), "2 particles");
        assert_eq!(refused("mass, y, x\n0, 1, 2\n"), "1 particles");
        assert_eq!(refused("x,y,mass\n0,1,2\n3,nan,5\n"), "3: y = nan: must be finite");
        assert_eq!(refused("x,y,mass\n0,1,2\n3,,5\n"), "3: y = \"\": not a number");
        assert!(refused("x,mass\n0,1\n").starts_with("1: column y is missing"));
        assert!(refused("x,y\n0,1\n").starts_with("1: column mass is missing"));
        assert!(refused("").starts_with("1: empty"));
        assert!(refused("x,y,mass\n").starts_with("1: holds no particle"));
        assert!(refused("x,y,z,mass\n0,1,2,3\n").starts_with("1: column \"z\": a scene in 2"));
        assert!(refused("0,1,2\n0,1,2\n").starts_with("1: column \"0\""));
        assert_eq!(refused("x,y,mass\n0,1,2\n0,1\n"), "3: 2 columns, the header has 3");
        assert_eq!(refused("x,y,mass\n0,1,2\n\n0,1,2,7\n"), "4: 4 columns, the header has 3");
    }
}
