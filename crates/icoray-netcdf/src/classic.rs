//! Where a classic NetCDF file (CDF-1, CDF-2, CDF-5) keeps each variable.
//!
//! The NetCDF library reads zeros, without an error, where a classic file is cut off. Only the offsets in the header
//! distinguish a value from a hole, and the library does not return them; so the header is read here, before the
//! library opens the file: some damaged headers would end the process there. Format:
//! <https://docs.unidata.ucar.edu/nug/current/file_format_specifications.html>.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// Names longer than this are not NetCDF's (`NC_MAX_NAME` is 256).
const MAX_NAME: u64 = 1024;

/// Tags of the header's lists.
const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;

/// Where the variables of a classic file lie.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ClassicLayout {
    variables: HashMap<String, Extent>,
    record_bytes: u64,
}

/// Whether the file at `path` is a classic one, by its first bytes.
pub(crate) fn is_classic(path: &Path) -> io::Result<bool> {
    let mut magic = [0; 4];
    Ok(File::open(path)?.read_exact(&mut magic).is_ok() && matches!(&magic, b"CDF\x01" | b"CDF\x02" | b"CDF\x05"))
}

/// The bytes of one variable, or of its first record.
#[derive(Debug, Clone, PartialEq)]
struct Extent {
    begin: u64,
    bytes: u64,
    is_record: bool,
}

impl ClassicLayout {
    /// Reads the header of the file at `path`; `None` when it is not a classic file.
    pub(crate) fn read(path: &Path) -> io::Result<Option<Self>> {
        let mut reader = BufReader::new(File::open(path)?);
        let mut magic = [0; 4];
        if reader.read_exact(&mut magic).is_err() || &magic[..3] != b"CDF" {
            return Ok(None);
        }
        let (wide_counts, wide_offsets) = match magic[3] {
            1 => (false, false),
            2 => (false, true),
            5 => (true, true),
            _ => return Ok(None),
        };
        Header { reader, wide_counts, wide_offsets }.layout().map(Some)
    }

    /// The offset just behind the last byte of `name`, or of its records before `records` when it is a record variable;
    /// `None` when the file has no such variable.
    pub(crate) fn end(&self, name: &str, records: usize) -> Option<u64> {
        let place = self.variables.get(name)?;
        let before = if place.is_record { (records as u64).saturating_sub(1) } else { 0 };
        let start = place.begin.saturating_add(before.saturating_mul(self.record_bytes));
        Some(start.saturating_add(place.bytes))
    }

    /// Number of records of which a file of `length` bytes has any byte; `None` where there are no record variables.
    pub(crate) fn begun_records(&self, length: u64) -> Option<usize> {
        let begin = self.variables.values().filter(|place| place.is_record).map(|place| place.begin).min()?;
        let begun = length.saturating_sub(begin).div_ceil(self.record_bytes.max(1));
        Some(usize::try_from(begun).unwrap_or(usize::MAX))
    }
}

struct Header {
    reader: BufReader<File>,
    /// CDF-5: sizes and counts take 8 bytes.
    wide_counts: bool,
    /// CDF-2 and CDF-5: offsets take 8 bytes.
    wide_offsets: bool,
}

impl Header {
    fn layout(mut self) -> io::Result<ClassicLayout> {
        self.count()?; // number of records; the library gives it
        let dimensions = self.dimensions()?;
        self.skip_attributes()?;
        let mut variables = HashMap::new();
        let mut record_bytes = 0u64;
        let mut records = Vec::new();
        for _ in 0..self.list(VARIABLES)? {
            let name = self.name()?;
            let mut bytes = 1u64;
            let mut is_record = false;
            for position in 0..self.count()? {
                let id = self.count()?;
                let known = usize::try_from(id).ok().and_then(|id| dimensions.get(id));
                let &length = known.ok_or_else(|| bad(format!("{name}: dimension {id} is not declared")))?;
                if position == 0 && length == 0 {
                    is_record = true;
                } else {
                    bytes = bytes.saturating_mul(length);
                }
            }
            self.skip_attributes()?;
            let code = self.u32()?;
            let size = type_bytes(code).ok_or_else(|| bad(format!("{name}: type {code} is unknown")))?;
            bytes = bytes.saturating_mul(size);
            self.count()?; // the stored size, which is not reliable for large variables
            let begin = if self.wide_offsets { self.u64()? } else { u64::from(self.u32()?) };
            if is_record {
                records.push(bytes);
                record_bytes = record_bytes.saturating_add(padded(bytes));
            }
            variables.insert(name, Extent { begin, bytes, is_record });
        }
        // A lone record variable is packed without padding.
        if let [only] = records[..] {
            record_bytes = only;
        }
        Ok(ClassicLayout { variables, record_bytes })
    }

    /// Lengths of the dimensions; 0 for the record dimension.
    fn dimensions(&mut self) -> io::Result<Vec<u64>> {
        let mut lengths = Vec::new();
        for _ in 0..self.list(DIMENSIONS)? {
            self.name()?;
            lengths.push(self.count()?);
        }
        Ok(lengths)
    }

    fn skip_attributes(&mut self) -> io::Result<()> {
        for _ in 0..self.list(ATTRIBUTES)? {
            let name = self.name()?;
            let code = self.u32()?;
            let size = type_bytes(code).ok_or_else(|| bad(format!("attribute {name}: type {code} is unknown")))?;
            let bytes = padded(self.count()?.saturating_mul(size));
            let bytes = i64::try_from(bytes).map_err(|_| bad(format!("attribute {name}: {bytes} bytes")))?;
            self.reader.seek_relative(bytes)?;
        }
        Ok(())
    }

    /// Number of entries of a list that bears `tag`; an absent list has none.
    fn list(&mut self, tag: u32) -> io::Result<u64> {
        match (self.u32()?, self.count()?) {
            (0, 0) => Ok(0),
            (found, entries) if found == tag => Ok(entries),
            (found, entries) => Err(bad(format!("a list of {entries} entries has tag {found}, expected {tag}"))),
        }
    }

    fn name(&mut self) -> io::Result<String> {
        let length = self.count()?;
        if length > MAX_NAME {
            return Err(bad(format!("a name of {length} bytes")));
        }
        let mut bytes = vec![0; padded(length) as usize];
        self.reader.read_exact(&mut bytes)?;
        bytes.truncate(length as usize);
        match String::from_utf8(bytes) {
            Ok(name) if !name.is_empty() && !name.contains('\0') => Ok(name),
            Ok(name) => Err(bad(format!("name {name:?} is empty or holds a NUL"))),
            Err(e) => Err(bad(format!("name {:?} is not UTF-8", String::from_utf8_lossy(e.as_bytes())))),
        }
    }

    fn count(&mut self) -> io::Result<u64> {
        if self.wide_counts { self.u64() } else { self.u32().map(u64::from) }
    }

    fn u32(&mut self) -> io::Result<u32> {
        let mut bytes = [0; 4];
        self.reader.read_exact(&mut bytes)?;
        Ok(u32::from_be_bytes(bytes))
    }

    fn u64(&mut self) -> io::Result<u64> {
        let mut bytes = [0; 8];
        self.reader.read_exact(&mut bytes)?;
        Ok(u64::from_be_bytes(bytes))
    }
}

fn padded(bytes: u64) -> u64 {
    bytes.checked_next_multiple_of(4).unwrap_or(u64::MAX)
}

fn type_bytes(code: u32) -> Option<u64> {
    // byte, char, short, int, float, double, and of CDF-5 ubyte, ushort, uint, int64, uint64
    [1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8].get(code.checked_sub(1)? as usize).copied()
}

fn bad(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}
