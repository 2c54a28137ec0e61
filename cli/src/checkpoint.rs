//! The bytes of a checkpoint: numbers and texts in a fixed order, little-endian, with a checksum at the end.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::files;

/// What the file begins with; the last figure is the format's version.
const MAGIC: &[u8] = b"mollis checkpoint 3\n";

/// Collects what a checkpoint holds.
#[derive(Debug, Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// A whole number.
    pub fn count(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A number, bit for bit.
    pub fn number(&mut self, value: f64) {
        self.count(value.to_bits());
    }

    /// A list of numbers.
    pub fn numbers(&mut self, values: &[f64]) {
        self.count(values.len() as u64);
        for &value in values {
            self.number(value);
        }
    }

    /// A list of whole numbers.
    pub fn counts(&mut self, values: &[u64]) {
        self.count(values.len() as u64);
        for &value in values {
            self.count(value);
        }
    }

    /// Bytes.
    pub fn bytes(&mut self, values: &[u8]) {
        self.count(values.len() as u64);
        self.0.extend_from_slice(values);
    }

    /// Writes the file so that a reader finds the old one or the new one, whatever happens in between.
    pub fn write(&self, path: &Path) -> Result<()> {
        files::write(path, |file| {
            file.write_all(MAGIC)?;
            file.write_all(&self.0)?;
            Ok(file.write_all(&checksum(&self.0).to_le_bytes())?)
        })
    }
}

/// Gives back what a checkpoint holds, in the order in which it was written.
#[derive(Debug)]
pub struct Reader {
    bytes: Vec<u8>,
    at: usize,
}

impl Reader {
    /// Opens a checkpoint.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).with_context(|| format!("{}", path.display()))?;
        let inner = bytes
            .strip_prefix(MAGIC)
            .with_context(|| format!("{}: not a checkpoint of this version", path.display()))?;
        let (body, sum) = inner.split_last_chunk::<8>().with_context(|| format!("{}: cut short", path.display()))?;
        ensure!(checksum(body) == u64::from_le_bytes(*sum), "{}: damaged", path.display());
        Ok(Self { bytes: body.to_vec(), at: 0 })
    }

    fn take(&mut self, n: usize) -> Result<&[u8]> {
        let from = self.at;
        let Some(bytes) = self.bytes.get(from..from.saturating_add(n)) else {
            bail!("the checkpoint is of another scene")
        };
        self.at += n;
        Ok(bytes)
    }

    /// A whole number.
    pub fn count(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.take(8)?.try_into()?))
    }

    /// A number.
    pub fn number(&mut self) -> Result<f64> {
        Ok(f64::from_bits(self.count()?))
    }

    /// A list of numbers.
    pub fn numbers(&mut self) -> Result<Vec<f64>> {
        let n = self.count()?;
        (0..n).map(|_| self.number()).collect()
    }

    /// A list of whole numbers.
    pub fn counts(&mut self) -> Result<Vec<u64>> {
        let n = self.count()?;
        (0..n).map(|_| self.count()).collect()
    }

    /// Bytes.
    pub fn bytes(&mut self) -> Result<Vec<u8>> {
        let n = self.count()?;
        Ok(self.take(usize::try_from(n)?)?.to_vec())
    }
}

/// FNV-1a over 64 bits (Fowler, Noll & Vo): detects accidental damage, not tampering.
pub fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let path = std::env::temp_dir().join(format!("mollis-store-{}", std::process::id()));
        let mut writer = Writer::default();
        writer.count(7);
        writer.numbers(&[1.5, f64::NAN, -0.0]);
        writer.counts(&[u64::MAX]);
        writer.bytes(b"text");
        writer.write(&path).unwrap();
        let mut reader = Reader::open(&path).unwrap();
        assert_eq!(reader.count().unwrap(), 7);
        let bits: Vec<u64> = reader.numbers().unwrap().iter().map(|x| x.to_bits()).collect();
        assert_eq!(bits, [1.5_f64.to_bits(), f64::NAN.to_bits(), (-0.0_f64).to_bits()]);
        assert_eq!(reader.counts().unwrap(), [u64::MAX]);
        assert_eq!(reader.bytes().unwrap(), b"text");
        assert!(reader.count().is_err());
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, &bytes).unwrap();
        assert!(Reader::open(&path).unwrap_err().to_string().ends_with("damaged"));
        fs::write(&path, &bytes[..middle]).unwrap();
        assert!(Reader::open(&path).is_err());
        fs::remove_file(&path).unwrap();
    }
}
