//! Points and masses of the user's own: tables of text with a header, or NPY. A bad file is refused with the line that is bad.
//!
//! A table is read as people and programs write it: commas, semicolons, tabs or spaces between columns; names in either case,
//! quoted or not; comments after `#`, one of which may be the header, as NumPy writes it; Fortran's exponents.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::particles::Particles;

/// The most bytes before the first value of an NPY file.
const HEADER: u64 = 4096;

/// What the name of a table may end in.
const TABLES: [&str; 4] = ["csv", "tsv", "txt", "dat"];

enum Format {
    Table,
    Npy,
}

fn format(path: &Path) -> Result<Format> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase();
    match ending.as_str() {
        "npy" => Ok(Format::Npy),
        ending if TABLES.contains(&ending) => Ok(Format::Table),
        _ => bail!("{}: must end in .npy, or .{} for a table", path.display(), TABLES.join(", .")),
    }
}

/// Whether a file for `dimension` dimensions holds densities. Only its head is read.
pub fn has_density(path: &Path, dimension: usize) -> Result<bool> {
    Ok(match format(path)? {
        Format::Table => Head::read(path, dimension)?.density.is_some(),
        Format::Npy => {
            npy_head(path, dimension)?;
            false
        }
    })
}

/// Appends the particles of a file. Returns what a user should know about it.
pub fn read(path: &Path, part: usize, particles: &mut Particles) -> Result<Vec<String>> {
    let before = particles.len();
    let notes = match format(path)? {
        Format::Table => table(path, part, particles)?,
        Format::Npy => {
            npy(path, part, particles)?;
            Vec::new()
        }
    };
    ensure!(particles.len() > before, "{}: holds no particle", path.display());
    Ok(notes)
}

/// The text before a table's first row of numbers.
struct Head {
    separator: u8,
    /// The header is the first record; otherwise it is a comment.
    is_record: bool,
    /// Columns of a record.
    columns: usize,
    /// The columns of the coordinates and of the mass.
    needed: Vec<usize>,
    density: Option<usize>,
    ignored: Vec<String>,
}

impl Head {
    fn read(path: &Path, dimension: usize) -> Result<Self> {
        let shown = path.display();
        let axes = &["x", "y", "z"][..dimension];
        let wanted = format!("a header of {}, mass and perhaps density", axes.join(", "));
        let mut reader = BufReader::new(File::open(path).with_context(|| format!("{shown}"))?);
        let mut comment = None;
        let (mut bytes, mut line) = (Vec::new(), 0);
        let first = loop {
            bytes.clear();
            line += 1;
            let length = reader.read_until(b'\n', &mut bytes).with_context(|| format!("{shown}:{line}"))?;
            ensure!(length > 0, "{shown}:{line}: empty; needs {wanted}");
            // A byte order mark, which Windows programs write.
            let text = String::from_utf8_lossy(&bytes);
            let text = text.trim_start_matches('\u{feff}').trim();
            match text.strip_prefix('#') {
                Some(rest) => comment = Some((line, rest.trim().to_owned())),
                None if text.is_empty() => {}
                None => break text.to_owned(),
            }
        };
        let separator = separator(&first);
        let names = fields(&first, separator)?;
        let numbers = names.iter().all(|name| number(name).is_some());
        let (at, names, is_record) = match comment {
            _ if !numbers => (line, names, true),
            Some((at, text)) => {
                // The header's own separator: NumPy writes `# x y` above `1 2`, others `# x, y`.
                let own = self::separator(&text);
                (at, fields(&text, own)?, false)
            }
            None => bail!("{shown}:{line}: the first row holds numbers; needs {wanted}"),
        };
        let names: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
        let column = |name: &str| -> Result<Option<usize>> {
            let mut places = names.iter().enumerate().filter(|(_, other)| *other == name).map(|(place, _)| place);
            let place = places.next();
            ensure!(places.next().is_none(), "{shown}:{at}: column {name} stands twice");
            Ok(place)
        };
        for name in &["x", "y", "z"][dimension..] {
            ensure!(
                column(name)?.is_none(),
                "{shown}:{at}: column {name}: a scene in {dimension} dimension(s) needs {wanted}"
            );
        }
        let mut needed = Vec::with_capacity(dimension + 1);
        for name in axes.iter().chain(&["mass"]) {
            needed.push(
                column(name)?.with_context(|| format!("{shown}:{at}: column {name} is missing; needs {wanted}"))?,
            );
        }
        let density = column("density")?;
        let used = |place: &usize| needed.contains(place) || density == Some(*place);
        let ignored = (0..names.len()).filter(|place| !used(place) && !names[*place].is_empty());
        let ignored = ignored.map(|place| names[place].clone()).collect();
        Ok(Self { separator, is_record, columns: names.len(), needed, density, ignored })
    }
}

/// What stands between the columns of a line.
fn separator(line: &str) -> u8 {
    // Outside quotes, within which a name may hold anything.
    let outside: String = line.split('"').step_by(2).collect();
    [b'\t', b';', b','].into_iter().find(|&byte| outside.contains(char::from(byte))).unwrap_or(b' ')
}

fn reader(separator: u8) -> csv::ReaderBuilder {
    let mut builder = csv::ReaderBuilder::new();
    // Lengths are checked here, where the message can name the line.
    builder.has_headers(false).flexible(true).delimiter(separator).comment(Some(b'#')).trim(csv::Trim::All);
    builder
}

/// The columns of a line.
fn fields(line: &str, separator: u8) -> Result<Vec<String>> {
    let mut record = csv::ByteRecord::new();
    reader(separator).from_reader(line.as_bytes()).read_byte_record(&mut record)?;
    Ok(columns(&record, separator).map(|field| String::from_utf8_lossy(field).trim().to_owned()).collect())
}

/// The columns of a record; several spaces separate like one.
fn columns(record: &csv::ByteRecord, separator: u8) -> impl Iterator<Item = &[u8]> {
    record.iter().filter(move |field| separator != b' ' || !field.is_empty())
}

/// A number as C, Python or Fortran writes it: `1.5`, `1e-5`, `1d-5`, `1.5-123`.
fn number(text: &str) -> Option<f64> {
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    // Not the words `inf` and `nan`, which Rust has read already if they are numbers.
    let text = text.replace(['d', 'D'], "e");
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    // Fortran leaves out the letter before an exponent of three digits.
    let sign = text.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-'))?.0;
    let (mantissa, exponent) = text.split_at(sign);
    let plain = mantissa.ends_with(|c: char| c.is_ascii_digit() || c == '.');
    (plain && exponent.len() == 4).then(|| format!("{mantissa}e{exponent}").parse().ok()).flatten()
}

fn table(path: &Path, part: usize, particles: &mut Particles) -> Result<Vec<String>> {
    let shown = path.display();
    let d = particles.dimension;
    let head = Head::read(path, d)?;
    let file = File::open(path).with_context(|| format!("{shown}"))?;
    let mut reader = reader(head.separator).from_reader(BufReader::new(file));
    let mut record = csv::ByteRecord::new();
    let mut fields: Vec<&[u8]>;
    let mut point = vec![0.0; d];
    let mut row = 0;
    while reader.read_byte_record(&mut record).with_context(|| format!("{shown}"))? {
        fields = columns(&record, head.separator).collect();
        // A line of spaces, or a comment after spaces.
        if fields.is_empty() || fields == [b""] || fields[0].starts_with(b"#") {
            continue;
        }
        row += 1;
        if row == 1 && head.is_record {
            continue;
        }
        let place = || format!("{shown}:{}", line_of(path, row).unwrap_or(row));
        ensure!(fields.len() == head.columns, "{}: {} columns, the header has {}", place(), fields.len(), head.columns);
        let value = |at: usize, name: &str| -> Result<f64> {
            let text = String::from_utf8_lossy(fields[at]);
            let text = text.trim();
            let value = number(text).with_context(|| format!("{}: {name} = {text:?}: not a number", place()))?;
            ensure!(value.is_finite(), "{}: {name} = {text}: must be finite", place());
            Ok(value)
        };
        for (axis, x) in point.iter_mut().enumerate() {
            *x = value(head.needed[axis], ["x", "y", "z"][axis])?;
        }
        let density = head.density.map(|at| value(at, "density")).transpose()?;
        particles.push(&point, value(head.needed[d], "mass")?, density, part);
    }
    let ignored = head.ignored.join(", ");
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(if ignored.is_empty() { Vec::new() } else { vec![format!("ignored: columns of {name}: {ignored}")] })
}

/// The line of the n-th record, from 1, that is neither empty nor a comment.
fn line_of(path: &Path, n: usize) -> Option<usize> {
    let lines = BufReader::new(File::open(path).ok()?).split(b'\n').map_while(Result::ok);
    let is_record = |line: &[u8]| {
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line).trim_ascii();
        !line.starts_with(b"#") && !line.is_empty()
    };
    lines.enumerate().filter(|(_, line)| is_record(line)).nth(n - 1).map(|(index, _)| index + 1)
}

/// Refuses an NPY header whose sizes have a product that overflows, which the reader of headers takes without a check, and returns to its start. What is no NPY
/// file passes.
fn check_sizes(reader: &mut BufReader<File>) -> Result<()> {
    let mut bytes = Vec::new();
    reader.by_ref().take(HEADER).read_to_end(&mut bytes)?;
    reader.rewind()?;
    // The length of the text has two bytes in version 1, four later.
    let (start, length) = match bytes[..] {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, a, b, ..] => (10, usize::from(a) | usize::from(b) << 8),
        [0x93, b'N', b'U', b'M', b'P', b'Y', _, _, a, b, c, d, ..] => (12, u32::from_le_bytes([a, b, c, d]) as usize),
        _ => return Ok(()),
    };
    ensure!(length <= HEADER as usize - 12, "its header has {length} bytes");
    let text = &bytes[start..bytes.len().min(start + length)];
    let mut product = 1_u64;
    for word in text.split(|byte| !byte.is_ascii_alphanumeric()) {
        if word.first().is_some_and(u8::is_ascii_digit) {
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<u64>().ok());
            let number = number.context("its header holds a size that is no whole number below 2^64")?;
            product = product.checked_mul(number.max(1)).context("its header states too many values")?;
        }
    }
    Ok(())
}

/// An NPY file at its first value, and its number of rows.
fn npy_head(path: &Path, d: usize) -> Result<(npyz::NpyFile<BufReader<File>>, usize)> {
    let shown = path.display();
    let file = File::open(path).with_context(|| format!("{shown}"))?;
    let length = file.metadata().with_context(|| format!("{shown}"))?.len();
    let mut reader = BufReader::new(file);
    check_sizes(&mut reader).with_context(|| format!("{shown}"))?;
    let header = npyz::NpyHeader::from_reader(&mut reader)
        .with_context(|| format!("{shown}: not an NPY file, or cut short in its header"))?;
    let shape = header.shape().to_vec();
    let wanted = d as u64 + 1;
    let [rows, columns] = shape[..] else {
        bail!("{shown}: shape {shape:?}: a scene in {d} dimension(s) needs (n, {wanted}): coordinates, mass")
    };
    ensure!(
        columns == wanted,
        "{shown}: shape {shape:?}: a scene in {d} dimension(s) needs (n, {wanted}): coordinates, mass"
    );
    let size = header.dtype().num_bytes().unwrap_or(0) as u64;
    let held = length.saturating_sub(reader.stream_position().with_context(|| format!("{shown}"))?);
    let size = columns.saturating_mul(size);
    let stated = rows.saturating_mul(size);
    ensure!(
        held >= stated,
        "{shown}: cut short: its header states {rows} rows of {size} bytes, and {held} bytes follow it"
    );
    let rows = usize::try_from(rows).with_context(|| format!("{shown}"))?;
    Ok((npyz::NpyFile::with_header(header, reader), rows))
}

fn npy(path: &Path, part: usize, particles: &mut Particles) -> Result<()> {
    let shown = path.display();
    let d = particles.dimension;
    let (array, rows) = npy_head(path, d)?;
    let by_columns = array.order() == npyz::Order::Fortran;
    let values: Vec<f64> = match array.try_data::<f64>() {
        Ok(values) => values.collect::<std::io::Result<_>>().with_context(|| format!("{shown}"))?,
        Err(array) => {
            let kind = array.dtype().descr();
            let Ok(values) = array.try_data::<f32>() else {
                bail!("{shown}: holds {kind}: must hold float64 or float32")
            };
            let values = values.map(|value| value.map(f64::from));
            values.collect::<std::io::Result<_>>().with_context(|| format!("{shown}"))?
        }
    };
    let mut numbers = vec![0.0; d + 1];
    for row in 0..rows {
        for (column, number) in numbers.iter_mut().enumerate() {
            *number = values[if by_columns { column * rows + row } else { row * (d + 1) + column }];
        }
        ensure!(numbers.iter().all(|value| value.is_finite()), "{shown}: row {row}: {numbers:?}: must be finite");
        particles.push(&numbers[..d], numbers[d], None, part);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of the test's own, removed at its end.
    struct Points(std::path::PathBuf);

    impl Points {
        fn new(name: &str, bytes: &[u8]) -> Self {
            let path = std::env::temp_dir().join(format!("mollis-points-{}-{name}", std::process::id()));
            std::fs::write(&path, bytes).unwrap();
            Self(path)
        }

        /// The particles, or the message after the path.
        fn read(&self, dimension: usize) -> Result<(Particles, Vec<String>), String> {
            let mut particles = Particles { dimension, ..Particles::default() };
            match read(&self.0, 0, &mut particles) {
                Ok(notes) => {
                    let has = has_density(&self.0, dimension).unwrap();
                    assert_eq!(has, !particles.densities.iter().any(|rho| rho.is_nan()));
                    Ok((particles, notes))
                }
                Err(error) => {
                    let (message, path) = (format!("{error:#}"), self.0.display().to_string());
                    assert!(message.starts_with(&path), "{message}");
                    Err(message[path.len() + 1..].to_owned())
                }
            }
        }
    }

    impl Drop for Points {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(&self.0);
        }
    }

    fn refused(name: &str, text: &str) -> String {
        Points::new(name, text.as_bytes()).read(2).map_or_else(|message| message, |_| "read".to_owned())
    }

    #[test]
    fn broken_tables_are_refused_with_the_line() {
        let refused = |text: &str| refused("broken.csv", text);
        assert_eq!(refused("x,y,mass\n0,1,2\n3,4,5\n"), "read");
        assert_eq!(refused("x,y,mass\n0,1,2\n3,nan,5\n"), "3: y = nan: must be finite");
        assert_eq!(refused("x,y,mass\n0,1,2\n3,-Infinity,5\n"), "3: y = -Infinity: must be finite");
        assert_eq!(refused("x,y,mass\n0,1,2\n3,,5\n"), "3: y = \"\": not a number");
        assert_eq!(refused("x,y,mass\n0,1,2\n3,1.2.3,5\n"), "3: y = \"1.2.3\": not a number");
        assert_eq!(refused("x;y;mass\n0;1,5;2\n"), "2: y = \"1,5\": not a number");
        assert!(refused("x,mass\n0,1\n").starts_with("1: column y is missing"));
        assert!(refused("x,y\n0,1\n").starts_with("1: column mass is missing"));
        assert!(refused("# made by hand\nx,y\n0,1\n").starts_with("2: column mass is missing"));
        assert!(refused("").starts_with("1: empty"));
        assert!(refused("# x,y,mass\n\n").starts_with("3: empty"));
        assert!(refused("x,y,mass\n").starts_with(" holds no particle"));
        assert!(refused("x,y,z,mass\n0,1,2,3\n").starts_with("1: column z: a scene in 2"));
        assert!(refused("0,1,2\n0,1,2\n").starts_with("1: the first row holds numbers; needs a header of x, y, mass"));
        assert!(refused("# nothing\n0,1,2\n").starts_with("1: column x is missing"));
        assert_eq!(refused("x,y,mass\n0,1,2\n0,1\n"), "3: 2 columns, the header has 3");
        assert_eq!(refused("x,y,mass\n0,1,2\n\n# note\n  \n0,1,2,7\n"), "6: 4 columns, the header has 3");
        for twice in ["x,y,mass,x", "x,Y,mass,y", "x,y,mass,\"Mass\"", "density,x,y,mass,Density"] {
            assert!(refused(&format!("{twice}\n1,1,1,1\n")).ends_with("stands twice"), "{twice}");
        }
    }

    #[test]
    fn tables_of_many_programs_are_read() {
        let plain = "x,y,mass\n0.25,-1,2e-3\n1e100,4,5\n";
        let same = [
            ("plain.csv", plain.to_owned()),
            ("ending.CSV", plain.replace('\n', "\r\n")),
            ("mark.csv", format!("\u{feff}{plain}")),
            ("open.csv", plain.trim_end().to_owned()),
            ("spaced.csv", plain.replace(',', " , ").replace('\n', "  \n")),
            ("tab.tsv", plain.replace(',', "\t")),
            ("semicolon.txt", plain.replace(',', ";")),
            ("order.csv", "mass,y,x\n2e-3,-1,0.25\n5,4,1e100\n".to_owned()),
            ("quoted.csv", "\"X\",\"Y\",\"Mass\"\n\"0.25\",-1,0.002\n1E100,4,5\n".to_owned()),
            ("marked.csv", format!("\u{feff}# by hand\n  # by hand\n{plain}")),
            ("comments.csv", format!("# by hand\n#\n\n{}\n# end\n", plain.replacen('\n', "\n# the points\n\n", 1))),
            // Fortran: D exponents, and none where the exponent has three digits; leading and repeated spaces.
            ("fortran.dat", "   x       y      mass\n  0.25D0  -1.0d+00  0.2D-02\n  .1+101   4.  5\n".to_owned()),
            ("fortran.csv", "X, Y, MASS\n 0.25D+00, -0.1D+1, 2.0d-3\n 1.0+100, 4.0, 5.0\n".to_owned()),
            // NumPy's savetxt: the header is a comment.
            ("numpy.txt", "# x y mass\n2.5e-01 -1.0e+00 2.0e-03\n1.0e+100 4.0 5.0\n".to_owned()),
            ("numpy.csv", "# run 7\n# x, y, mass\n0.25,-1,0.002\n1e100,4,5\n".to_owned()),
        ];
        for (name, text) in same {
            let (particles, notes) =
                Points::new(name, text.as_bytes()).read(2).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(particles.positions, [0.25, -1.0, 1e100, 4.0], "{name}");
            assert_eq!(particles.masses, [2e-3, 5.0], "{name}");
            assert!(particles.densities.iter().all(|rho| rho.is_nan()) && notes.is_empty(), "{name}");
        }
    }

    #[test]
    fn further_columns_are_ignored_and_named() {
        let text = "id,x,\"speed, m/s\",y,mass,Density,\n7,1,9,2,3,4,\n";
        let (particles, notes) = Points::new("further.csv", text.as_bytes()).read(2).unwrap();
        assert_eq!(
            (particles.positions, particles.masses, particles.densities),
            (vec![1.0, 2.0], vec![3.0], vec![4.0])
        );
        assert_eq!(notes.len(), 1);
        assert!(notes[0].starts_with("ignored: columns of ") && notes[0].ends_with("further.csv: id, speed, m/s"));
    }

    #[test]
    fn numbers_of_other_languages() {
        for (text, value) in [
            ("1.5", 1.5),
            ("+.5", 0.5),
            ("1D3", 1e3),
            ("-1.25d-02", -0.0125),
            ("1.5-123", 1.5e-123),
            ("1.5+099", 1.5e99),
            ("-1.+100", -1e100),
            ("1e5", 1e5),
        ] {
            assert_eq!(number(text), Some(value), "{text}");
        }
        for text in ["", "d", "1d", "--1", "1.5-", "1-2-3", "0x10", "1 2", "1.5e3-2", "dd1", "2020-11"] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    /// An NPY file of format 1.0, from the text of its header.
    fn array(header: &str, values: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        let padded = (header.len() + 11).next_multiple_of(64) - 10;
        bytes.extend((padded as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.resize(10 + padded - 1, b' ');
        bytes.push(b'\n');
        bytes.extend(values);
        bytes
    }

    #[test]
    fn arrays_of_both_orders_and_scalars_are_read() {
        let rows = [[0.0, 1.0, 2.0], [3.0, 4.5, 6.0]];
        let by_rows: Vec<f64> = rows.as_flattened().to_vec();
        let by_columns: Vec<f64> = (0..3).flat_map(|column| rows.map(|row| row[column])).collect();
        let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let header =
            |kind: &str, fortran: &str| format!("{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': (2, 3), }}");
        let single: Vec<u8> = by_columns.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect();
        let big: Vec<u8> = by_rows.iter().flat_map(|x| x.to_be_bytes()).collect();
        for (header, values) in [
            (header("<f8", "False"), little(&by_rows)),
            (header("<f8", "True"), little(&by_columns)),
            (header("<f4", "True"), single),
            (header(">f8", "False"), big),
        ] {
            let (particles, _) = Points::new("order.npy", &array(&header, &values)).read(2).unwrap();
            assert_eq!(particles.positions, [0.0, 1.0, 3.0, 4.5], "{header}");
            assert_eq!(particles.masses, [2.0, 6.0], "{header}");
        }
    }

    #[test]
    fn broken_arrays_are_refused() {
        let header =
            |kind: &str, shape: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        let refused = |bytes: &[u8]| Points::new("broken.npy", bytes).read(2).unwrap_err();
        let whole = array(&header("<f8", "(2, 3)"), &[0; 48]);
        assert!(Points::new("whole.npy", &whole).read(2).is_ok());
        for cut in [1, 24, 47] {
            let message = refused(&whole[..whole.len() - cut]);
            let held = 48 - cut;
            assert_eq!(
                message,
                format!(" cut short: its header states 2 rows of 24 bytes, and {held} bytes follow it")
            );
        }
        for length in [0, 5, 9, 40] {
            assert!(refused(&whole[..length]).starts_with(" not an NPY file, or cut short in its header"), "{length}");
        }
        assert!(refused(&array(&header("<f8", "(999999999999999, 3)"), &[0; 48])).starts_with(" cut short"));
        // What would overflow in the reader of headers.
        let product = refused(&array(&header("<f8", "(6148914691236517206, 3)"), &[0; 48]));
        assert_eq!(product, " its header states too many values");
        assert!(refused(&array(&header("<f8", "(18446744073709551616, 3)"), &[0; 48])).contains("below 2^64"));
        assert!(refused(&array(&header("<f8", &"(".repeat(3000)), &[])).starts_with(" not an NPY file"));
        assert!(refused(&array(&header("<f8", &"(".repeat(60_000)), &[])).ends_with(" bytes"));
        assert!(refused(&array(&header("<f8", "(3, 2)"), &[0; 48])).starts_with(" shape [3, 2]"));
        assert!(refused(&array(&header("<f8", "(6,)"), &[0; 48])).starts_with(" shape [6]"));
        assert!(refused(&array(&header("<i8", "(2, 3)"), &[0; 48])).contains("must hold float64 or float32"));
        assert!(refused(&array(&header("<f8", "(0, 3)"), &[])).starts_with(" holds no particle"));
        let infinite: Vec<u8> = [0.0, f64::INFINITY, 1.0].iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
        assert!(refused(&array(&header("<f8", "(1, 3)"), &infinite)).starts_with(" row 0"));
    }
}
