//! Arrays of numbers in NumPy's format NPY: float64 and float32 are read, float64 is written.

use std::io::{Read, Write};

use anyhow::{Context, Result, bail, ensure};

const MAGIC: &[u8] = b"\x93NUMPY";

/// What stands before the numbers.
#[derive(Debug)]
pub struct Head {
    /// The array's shape.
    pub shape: Vec<u64>,
    /// Whether the first index runs fastest.
    pub by_columns: bool,
    /// Bytes of a number: 8 or 4.
    pub size: u64,
    big_endian: bool,
}

impl Head {
    /// Reads up to the first number.
    pub fn read(file: &mut impl Read) -> Result<Self> {
        const NONE: &str = "not an NPY file, or cut short in its header";
        let mut start = [0; 8];
        file.read_exact(&mut start).context(NONE)?;
        ensure!(start.starts_with(MAGIC), NONE);
        let mut length = [0; 4];
        let digits = if start[6] == 1 { 2 } else { 4 };
        file.read_exact(&mut length[..digits]).context(NONE)?;
        let length = u64::from(u32::from_le_bytes(length));
        let mut text = Vec::new();
        file.take(length).read_to_end(&mut text)?;
        ensure!(text.len() as u64 == length, NONE);
        Self::parse(&String::from_utf8_lossy(&text))
    }

    /// Reads Python's dictionary with the keys `descr`, `fortran_order` and `shape`.
    fn parse(text: &str) -> Result<Self> {
        let value = |key: &str| -> Result<&str> {
            let places = ['\'', '"'].map(|quote| text.split_once(&format!("{quote}{key}{quote}")));
            let rest = places.into_iter().flatten().next().and_then(|(_, rest)| rest.trim_start().strip_prefix(':'));
            Ok(rest.with_context(|| format!("its header has no {key}"))?.trim_start())
        };
        let by_columns = match value("fortran_order")? {
            order if order.starts_with("True") => true,
            order if order.starts_with("False") => false,
            _ => bail!("its header has no fortran_order"),
        };
        let shape = value("shape")?.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(inside, _)| inside);
        let shape = shape.context("its header has no shape")?.split(',').map(str::trim).filter(|side| !side.is_empty());
        let shape: Vec<u64> =
            shape.map(|side| side.parse().context("its shape is not of numbers")).collect::<Result<_>>()?;
        let kind = value("descr")?;
        let kind = match kind.chars().next() {
            Some(quote @ ('\'' | '"')) => kind[1..].split(quote).next().unwrap_or(""),
            _ => "a structure",
        };
        let (big_endian, size) = match kind {
            "<f8" => (false, 8),
            ">f8" => (true, 8),
            "<f4" => (false, 4),
            ">f4" => (true, 4),
            _ => bail!("holds {kind}: must hold float64 or float32"),
        };
        Ok(Self { shape, by_columns, size, big_endian })
    }

    /// Reads the next `count` numbers.
    pub fn numbers(&self, file: &mut impl Read, count: usize) -> Result<Vec<f64>> {
        let mut numbers = Vec::with_capacity(count);
        let mut bytes = [0; 8];
        for _ in 0..count {
            let bytes = &mut bytes[..self.size as usize];
            file.read_exact(bytes)?;
            if self.big_endian {
                bytes.reverse();
            }
            numbers.push(match *bytes {
                [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
                [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
                _ => bail!("numbers of {} bytes", self.size),
            });
        }
        Ok(numbers)
    }
}

/// Writes an array of this many rows and columns, row by row.
pub fn write(file: &mut impl Write, [rows, columns]: [usize; 2], numbers: impl Iterator<Item = f64>) -> Result<()> {
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // Format 1.0: numbers begin at a multiple of 64 bytes, after spaces and a line feed.
    let padded = (MAGIC.len() + 4 + text.len() + 1).next_multiple_of(64) - MAGIC.len() - 4;
    file.write_all(MAGIC)?;
    file.write_all(&[1, 0])?;
    file.write_all(&u16::try_from(padded)?.to_le_bytes())?;
    file.write_all(format!("{text:<width$}\n", width = padded - 1).as_bytes())?;
    for number in numbers {
        file.write_all(&number.to_le_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let numbers = [0.0, 1.0, 1.0, 2.5, -3.0, f64::MIN_POSITIVE];
        let mut bytes = Vec::new();
        write(&mut bytes, [2, 3], numbers.into_iter()).unwrap();
        assert_eq!((bytes.len(), bytes[127]), (128 + 48, b'\n'));
        let mut rest = &bytes[..];
        let head = Head::read(&mut rest).unwrap();
        assert_eq!((&head.shape[..], head.by_columns, head.size), (&[2, 3][..], false, 8));
        assert_eq!(head.numbers(&mut rest, 6).unwrap(), numbers);
        assert!(rest.is_empty() && head.numbers(&mut rest, 1).is_err());
    }

    #[test]
    fn headers_of_other_programs_are_read() {
        // Keys in any order, either quote, format 2.0.
        let text = b"{\"shape\" : ( 7 ,), \"fortran_order\":True, \"descr\":\">f4\"}\n";
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text);
        bytes.extend(1.5_f32.to_be_bytes());
        let mut rest = &bytes[..];
        let head = Head::read(&mut rest).unwrap();
        assert_eq!((&head.shape[..], head.by_columns, head.size), (&[7][..], true, 4));
        assert_eq!(head.numbers(&mut rest, 1).unwrap(), [1.5]);
        for (text, words) in [
            ("{'descr': '<f8', 'fortran_order': False}", "no shape"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (2, x)}", "not of numbers"),
            ("{'descr': '<f8', 'fortran_order': 0, 'shape': (2,)}", "no fortran_order"),
            ("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (2,)}", "holds a structure"),
            ("{'descr': '<i8', 'fortran_order': False, 'shape': (2,)}", "holds <i8: must hold float64 or float32"),
        ] {
            assert!(Head::parse(text).unwrap_err().to_string().contains(words), "{text}");
        }
    }
}
