//! Converts the stored numbers of a variable to values: unpacks packed numbers, and replaces marks of missing values,
//! and values outside of the valid range, by NaN.

use crate::source::{Kind, SourceVariable};
use crate::values::{AssumedMark, ShapedValues};
use icoray::{Result, Shape};

/// NetCDF's default fill value (`NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number).
const UNWRITTEN: f64 = 9.969_209_968_386_869e36;
/// That of integers of 32 and of 64 bits (`NC_FILL_INT` and `NC_FILL_INT64`); shorter ones may be any value.
const UNWRITTEN_INTEGERS: [f64; 2] = [-2_147_483_647.0, -9_223_372_036_854_775_806.0];

/// Factor and offset of packed values, according to CF conventions 1.11, §8.1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Packing {
    scale: f64,
    offset: f64,
}

impl Packing {
    /// The packing of a variable; `None` if it is not packed.
    pub(crate) fn of(found: SourceVariable) -> Result<Option<Self>> {
        let first = |attribute: &str| Ok(found.numbers(attribute)?.first().copied());
        let [scale, offset] = [first("scale_factor")?, first("add_offset")?];
        let is_packed = scale.is_some() || offset.is_some();
        Ok(is_packed.then(|| Packing { scale: scale.unwrap_or(1.0), offset: offset.unwrap_or(0.0) }))
    }
}

/// The values that a variable's `valid_range`, `valid_min` and `valid_max` admit, according to CF conventions 1.11,
/// §2.5.1.
#[derive(Debug)]
struct Valid {
    ends: [f64; 2],
    /// Whether the ends are of values as stored, as CF §8.1 requires for packed ones. The NetCDF Users Guide permits
    /// real ends of packed integers to be of unpacked values.
    is_of_stored: bool,
}

impl Valid {
    fn of(found: SourceVariable) -> Result<Self> {
        let (mut ends, mut is_real) = ([f64::NEG_INFINITY, f64::INFINITY], false);
        for (attribute, which) in [("valid_range", [0, 1]), ("valid_min", [0, 0]), ("valid_max", [1, 1])] {
            let numbers = found.numbers(attribute)?;
            is_real |= !numbers.is_empty() && found.is_real(attribute)?;
            for (end, number) in which.into_iter().zip(numbers) {
                ends[end] = if end == 0 { ends[0].max(number) } else { ends[1].min(number) };
            }
        }
        Ok(Valid { ends, is_of_stored: found.variable.kind != Kind::Integer || !is_real })
    }

    /// Sets values outside to NaN, if `applies`.
    fn mask_outside(&self, values: &mut ShapedValues, applies: bool) {
        if applies && self.ends != [f64::NEG_INFINITY, f64::INFINITY] {
            let [low, high] = self.ends.map(|end| values.rounded(end));
            values.mask(|value| value < low || value > high);
        }
    }
}

/// The conversion of a variable's numbers to values.
#[derive(Debug)]
pub(crate) struct Decoder {
    /// Marks of missing values; at least one.
    marks: Vec<f64>,
    /// Whether attributes or the user specify a mark.
    has_specified_mark: bool,
    valid: Valid,
    packing: Option<Packing>,
}

impl Decoder {
    /// The decoder of a variable; `missing` are further marks.
    pub(crate) fn of(found: SourceVariable, missing: &[f64]) -> Result<Self> {
        let fill = found.numbers("_FillValue")?;
        let others = [&found.numbers("missing_value")?, missing].concat();
        let has_specified_mark = !fill.is_empty() || !others.is_empty();
        let unwritten = if found.variable.kind == Kind::Integer { &UNWRITTEN_INTEGERS[..] } else { &[UNWRITTEN] };
        let marks = [if fill.is_empty() { unwritten } else { &fill }, &others].concat();
        Ok(Decoder { marks, has_specified_mark, valid: Valid::of(found)?, packing: Packing::of(found)? })
    }

    /// Sets values that look like marks to NaN if no mark is specified; returns these.
    pub(crate) fn take_assumed_marks(&self, values: &mut ShapedValues) -> Vec<AssumedMark> {
        let mut taken = Vec::new();
        if self.has_specified_mark {
            return taken;
        }
        while let Some(mark) = values.outlier() {
            if mark.value == values.rounded(UNWRITTEN) {
                break;
            }
            values.mask(|value| value == mark.value);
            taken.push(mark);
        }
        taken
    }

    /// Unpacks values and masks invalid ones. Returns the one mark that may remain among them.
    pub(crate) fn decode(&self, values: &mut ShapedValues) -> f64 {
        let fill = values.rounded(self.marks[0]);
        // A field has one mark; further ones become NaN, which counts as missing too.
        for mark in &self.marks[1..] {
            let mark = values.rounded(*mark);
            if mark != fill {
                values.mask(|value| value == mark);
            }
        }
        self.valid.mask_outside(values, self.valid.is_of_stored);
        let Some(Packing { scale, offset }) = self.packing else { return fill };
        values.mask(|value| value == fill);
        values.each(|value| scale * value + offset);
        self.valid.mask_outside(values, !self.valid.is_of_stored);
        f64::NAN
    }
}

impl SourceVariable<'_> {
    /// Reads a block as values, NaN where they are missing.
    pub(crate) fn decoded(self, start: &[usize], count: &[usize], missing: &[f64]) -> Result<ShapedValues> {
        let read = self.source.reals(self.variable, start, count)?;
        let shape = Shape::level_fastest(read.as_reals().len(), 1);
        let mut values = ShapedValues::new(read.into(), shape, [None, None]);
        let decoder = Decoder::of(self, missing)?;
        decoder.take_assumed_marks(&mut values);
        let fill = decoder.decode(&mut values);
        values.mask(|value| value == fill);
        Ok(values)
    }
}
