//! What ranks say to each other, as bytes. All run the same program, so the form is nobody else's business; a message that
//! is not of that form is an error all the same.

use crate::error::{Error, ErrorKind, Result};
use crate::frame::Counts;

/// Bytes that are being written.
#[derive(Debug, Clone, Default)]
pub(crate) struct Words(pub Vec<u8>);

impl Words {
    pub fn put(&mut self, number: u64) -> &mut Self {
        self.0.extend_from_slice(&number.to_le_bytes());
        self
    }

    pub fn put_f64(&mut self, number: f64) -> &mut Self {
        self.put(number.to_bits())
    }

    pub fn put_f32(&mut self, number: f32) -> &mut Self {
        self.0.extend_from_slice(&number.to_bits().to_le_bytes());
        self
    }

    pub fn put_counts(&mut self, counts: &Counts) -> &mut Self {
        counts.numbers().into_iter().for_each(|number| {
            self.put(number);
        });
        self
    }

    /// Bytes of a length that the other side knows.
    pub fn put_raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.extend_from_slice(bytes);
        self
    }

    pub fn put_bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.put(bytes.len() as u64).put_raw(bytes)
    }
}

/// Bytes that are being read.
#[derive(Debug)]
pub(crate) struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: u64) -> Result<&'a [u8]> {
        let cut = || Error::new(ErrorKind::Mpi, "a message between ranks is shorter than it says");
        let (taken, rest) =
            self.0.split_at_checked(usize::try_from(count).map_err(|_| cut())?).ok_or_else(cut)?;
        self.0 = rest;
        Ok(taken)
    }

    pub fn get(&mut self) -> Result<u64> {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(bytes))
    }

    pub fn get_f64(&mut self) -> Result<f64> {
        self.get().map(f64::from_bits)
    }

    pub fn get_f32(&mut self) -> Result<f32> {
        let mut bytes = [0; 4];
        bytes.copy_from_slice(self.take(4)?);
        Ok(f32::from_bits(u32::from_le_bytes(bytes)))
    }

    pub fn get_counts(&mut self) -> Result<Counts> {
        let mut numbers = [0; 6];
        for number in &mut numbers {
            *number = self.get()?;
        }
        Ok(Counts::of_numbers(numbers))
    }

    pub fn get_raw(&mut self, count: usize) -> Result<&'a [u8]> {
        self.take(count as u64)
    }

    pub fn get_bytes(&mut self) -> Result<&'a [u8]> {
        let count = self.get()?;
        self.take(count)
    }

    pub fn get_text(&mut self) -> Result<String> {
        self.get_bytes().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_back_and_cut_ones_are_errors() {
        let mut words = Words::default();
        words.put(7).put_f64(-0.0).put_f32(f32::NAN).put_bytes(b"rank");
        let mut reader = Reader(&words.0);
        assert_eq!((reader.get().unwrap(), reader.get_f64().unwrap().to_bits()), (7, (-0.0f64).to_bits()));
        assert_eq!(reader.get_f32().unwrap().to_bits(), f32::NAN.to_bits());
        assert_eq!(reader.get_text().unwrap(), "rank");
        assert_eq!(reader.get().unwrap_err().kind(), ErrorKind::Mpi);
        let mut cut = Reader(&words.0[..words.0.len() - 1]);
        cut.take(20).unwrap();
        assert!(cut.get_bytes().is_err());
    }
}
