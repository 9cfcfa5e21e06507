//! Arrays of numbers of the host's, read in place.

use std::fmt;
use std::marker::PhantomData;
use xxhash_rust::xxh3::Xxh3;

/// Types of numbers, in the order of Conduit's numbers for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberType {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
}

const NUMBER_TYPES: [(NumberType, &str, usize); 10] = [
    (NumberType::I8, "int8", 1),
    (NumberType::I16, "int16", 2),
    (NumberType::I32, "int32", 4),
    (NumberType::I64, "int64", 8),
    (NumberType::U8, "uint8", 1),
    (NumberType::U16, "uint16", 2),
    (NumberType::U32, "uint32", 4),
    (NumberType::U64, "uint64", 8),
    (NumberType::F32, "float32", 4),
    (NumberType::F64, "float64", 8),
];

impl NumberType {
    /// The type of a `conduit_datatype_id`, if it is one of numbers.
    pub fn of_id(id: i64) -> Option<Self> {
        let place = usize::try_from(id.checked_sub(3)?).ok()?;
        NUMBER_TYPES.get(place).map(|kind| kind.0)
    }

    pub fn bytes(self) -> usize {
        NUMBER_TYPES[self as usize].2
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, NumberType::F32 | NumberType::F64)
    }
}

impl fmt::Display for NumberType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(NUMBER_TYPES[*self as usize].1)
    }
}

/// Numbers at equal distances, alive for `'a`.
#[derive(Debug, Clone, Copy)]
pub struct Array<'a> {
    data: *const u8,
    kind: NumberType,
    count: usize,
    /// Bytes from one number to the next.
    stride: isize,
    life: PhantomData<&'a [u8]>,
}

impl Array<'_> {
    /// # Safety
    /// So many numbers lie there, alive and unchanged for the array's lifetime.
    pub unsafe fn new(data: *const u8, kind: NumberType, count: usize, stride: isize) -> Self {
        Array { data, kind, count, stride, life: PhantomData }
    }

    pub fn len(&self) -> usize {
        self.count
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub fn kind(&self) -> NumberType {
        self.kind
    }

    pub fn stride(&self) -> isize {
        self.stride
    }

    pub fn address(&self, i: usize) -> *const u8 {
        assert!(i < self.count, "number {i} of {}", self.count);
        // SAFETY: the maker of the array promises so many numbers.
        unsafe { self.data.offset(i as isize * self.stride) }
    }

    fn read<T: Copy>(&self, i: usize) -> T {
        assert_eq!(size_of::<T>(), self.kind.bytes());
        // SAFETY: a number of this type lies there, which need not be aligned.
        unsafe { self.address(i).cast::<T>().read_unaligned() }
    }

    pub fn real(&self, i: usize) -> f64 {
        match self.kind {
            NumberType::F32 => f64::from(self.read::<f32>(i)),
            NumberType::F64 => self.read(i),
            NumberType::U64 => self.read::<u64>(i) as f64,
            _ => self.integer(i) as f64,
        }
    }

    /// An integer; real numbers are truncated.
    pub fn integer(&self, i: usize) -> i64 {
        match self.kind {
            NumberType::I8 => i64::from(self.read::<i8>(i)),
            NumberType::I16 => i64::from(self.read::<i16>(i)),
            NumberType::I32 => i64::from(self.read::<i32>(i)),
            NumberType::I64 => self.read(i),
            NumberType::U8 => i64::from(self.read::<u8>(i)),
            NumberType::U16 => i64::from(self.read::<u16>(i)),
            NumberType::U32 => i64::from(self.read::<u32>(i)),
            NumberType::U64 => i64::try_from(self.read::<u64>(i)).unwrap_or(i64::MAX),
            NumberType::F32 => self.read::<f32>(i) as i64,
            NumberType::F64 => self.read::<f64>(i) as i64,
        }
    }

    /// Adds type and numbers to a fingerprint.
    pub fn hash(&self, to: &mut Xxh3) {
        to.update(&[self.kind as u8]);
        to.update(&self.count.to_ne_bytes());
        let bytes = self.kind.bytes();
        if self.count > 0 && self.stride == bytes as isize {
            // SAFETY: the maker promises so many numbers, which lie one behind the other.
            to.update(unsafe { std::slice::from_raw_parts(self.data, self.count * bytes) });
            return;
        }
        for i in 0..self.count {
            // SAFETY: a number of so many bytes lies there.
            to.update(unsafe { std::slice::from_raw_parts(self.address(i), bytes) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<T>(values: &[T], kind: NumberType, count: usize, stride: isize) -> Array<'_> {
        // SAFETY: numbers of the slice.
        unsafe { Array::new(values.as_ptr().cast(), kind, count, stride) }
    }

    #[test]
    fn numbers_of_all_types_are_read_with_their_strides() {
        assert_eq!(NumberType::of_id(5), Some(NumberType::I32));
        assert_eq!(NumberType::of_id(12), Some(NumberType::F64));
        assert_eq!((NumberType::of_id(2), NumberType::of_id(13), NumberType::of_id(i64::MIN)), (None, None, None));
        let every_second = of(&[1.5_f32, 9.0, -2.5, 9.0], NumberType::F32, 2, 8);
        assert_eq!((every_second.real(1), every_second.integer(1)), (-2.5, -2));
        assert_eq!(of(&[-7_i8, 3], NumberType::I8, 2, 1).real(0), -7.0);
        assert_eq!(of(&[u64::MAX], NumberType::U64, 1, 8).integer(0), i64::MAX);
        assert_eq!(of(&[u64::MAX], NumberType::U64, 1, 8).real(0), u64::MAX as f64);
        // Backwards from the last one.
        let values = [1_i64, 2, 3];
        // SAFETY: the three numbers of the array, from its end.
        let backwards = unsafe { Array::new(values.as_ptr().add(2).cast(), NumberType::I64, 3, -8) };
        assert_eq!([0, 1, 2].map(|i| backwards.integer(i)), [3, 2, 1]);
    }

    #[test]
    fn fingerprints_are_of_values_not_of_places() {
        let fingerprint = |array: Array| {
            let mut hash = Xxh3::new();
            array.hash(&mut hash);
            hash.digest128()
        };
        let (dense, spread, other) = ([1.0, 2.0], [1.0, 7.0, 2.0], [1.0, 2.5]);
        assert_eq!(fingerprint(of(&dense, NumberType::F64, 2, 8)), fingerprint(of(&spread, NumberType::F64, 2, 16)));
        assert_ne!(fingerprint(of(&dense, NumberType::F64, 2, 8)), fingerprint(of(&other, NumberType::F64, 2, 8)));
    }
}
