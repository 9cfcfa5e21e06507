//! Arrays in one block of bytes, for memory that processes share: one of them writes it, all read it in place.
//!
//! A block begins with a directory, the offset and the length of each array in bytes; arrays begin at cache lines.

use crate::error::{Error, ErrorKind, Result};
use bytemuck::Pod;

/// Offset and length of an array.
type Entry = [u64; 2];

/// Bytes of a cache line: no record of an array lies in two if its size divides this.
const LINE: usize = 64;

/// The directory of a block, and the block's length in bytes.
fn directory(arrays: &[&[u8]]) -> (Vec<Entry>, usize) {
    let mut end = size_of::<Entry>() * arrays.len();
    let entry = |array: &&[u8]| {
        let start = end.next_multiple_of(LINE);
        end = start + array.len();
        [start as u64, array.len() as u64]
    };
    let entries = arrays.iter().map(entry).collect();
    (entries, end)
}

/// Length in bytes of a block of these arrays.
pub fn length(arrays: &[&[u8]]) -> usize {
    directory(arrays).1
}

/// Writes a block: calls `put` with the offsets and the bytes of its parts.
pub fn write(arrays: &[&[u8]], mut put: impl FnMut(usize, &[u8])) {
    let (entries, _) = directory(arrays);
    put(0, bytemuck::cast_slice(&entries));
    for ([start, _], array) in entries.iter().zip(arrays) {
        put(*start as usize, array);
    }
}

/// An array of a block, by its number.
///
/// # Errors
/// [`ErrorKind::Internal`] if the block, aligned to 8 bytes, does not have such an array of whole elements.
pub fn array<T: Pod>(block: &[u8], number: usize) -> Result<&[T]> {
    let wrong = || Error::new(ErrorKind::Internal, format!("array {number} of a block of {} bytes", block.len()));
    let entry = block.get(size_of::<Entry>() * number..).and_then(|from| from.get(..size_of::<Entry>()));
    let [start, length] = bytemuck::pod_read_unaligned::<Entry>(entry.ok_or_else(wrong)?).map(|value| value as usize);
    let bytes = start.checked_add(length).and_then(|end| block.get(start..end));
    bytemuck::try_cast_slice(bytes.ok_or_else(wrong)?).map_err(|_| wrong())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_read_in_place_and_wrong_ones_refused() {
        let (first, second) = ([1u8, 2, 3], [4.5f64, -1.0]);
        let arrays: [&[u8]; 3] = [&first, &[], bytemuck::cast_slice(&second)];
        let mut words = vec![0u64; length(&arrays).div_ceil(8)];
        let block: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        write(&arrays, |at, bytes| block[at..at + bytes.len()].copy_from_slice(bytes));
        assert_eq!(array::<u8>(block, 0).unwrap(), first);
        assert_eq!(array::<u32>(block, 1).unwrap(), [0; 0]);
        assert_eq!(array::<f64>(block, 2).unwrap(), second);
        let wrong = |block: &[u8], number: usize| array::<u64>(block, number).unwrap_err().kind();
        assert_eq!(wrong(block, 0), ErrorKind::Internal);
        assert_eq!(wrong(&block[..8], 0), ErrorKind::Internal);
        let end = block.len() - 8;
        assert_eq!(wrong(&block[..end], 2), ErrorKind::Internal);
    }
}
