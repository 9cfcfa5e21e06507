//! Converts the stored numbers of a variable to values: unpacks packed numbers, and replaces marks of missing values,
//! and values outside of the valid range, by NaN.

use crate::source::{Kind, Source, Variable};
use crate::values::ShapedValues;
use icoray::{Result, Shape};

/// NetCDF's default fill value (`NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number).
const UNWRITTEN: f64 = 9.969_209_968_386_869e36;
/// That of integers of 32 and of 64 bits (`NC_FILL_INT` and `NC_FILL_INT64`); shorter ones may be any value.
const UNWRITTEN_INTEGERS: [f64; 2] = [-2_147_483_647.0, -9_223_372_036_854_775_806.0];

/// Factor and offset of packed values, according to CF conventions 1.11, §8.1.
pub(crate) fn packing(source: &dyn Source, name: &str) -> Result<Option<[f64; 2]>> {
    let first = |attribute: &str| Ok(source.numbers_of(name, attribute)?.first().copied());
    let (scale, offset) = (first("scale_factor")?, first("add_offset")?);
    let is_packed = scale.is_some() || offset.is_some();
    Ok(is_packed.then(|| [scale.unwrap_or(1.0), offset.unwrap_or(0.0)]))
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
    fn of(source: &dyn Source, variable: &Variable) -> Result<Self> {
        let name = &variable.name;
        let (mut ends, mut is_real) = ([f64::NEG_INFINITY, f64::INFINITY], false);
        for (attribute, which) in [("valid_range", [0, 1]), ("valid_min", [0, 0]), ("valid_max", [1, 1])] {
            let numbers = source.numbers_of(name, attribute)?;
            is_real |= !numbers.is_empty() && source.is_real_of(name, attribute)?;
            for (end, number) in which.into_iter().zip(numbers) {
                ends[end] = if end == 0 { ends[0].max(number) } else { ends[1].min(number) };
            }
        }
        Ok(Valid { ends, is_of_stored: variable.kind != Kind::Integer || !is_real })
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
    is_said: bool,
    valid: Valid,
    packing: Option<[f64; 2]>,
}

impl Decoder {
    /// The decoder of a variable; `missing` are further marks.
    pub(crate) fn of(source: &dyn Source, variable: &Variable, missing: &[f64]) -> Result<Self> {
        let name = &variable.name;
        let mut marks = source.numbers_of(name, "_FillValue")?;
        let mut is_said = !marks.is_empty();
        if marks.is_empty() {
            let unwritten = if variable.kind == Kind::Integer { &UNWRITTEN_INTEGERS[..] } else { &[UNWRITTEN] };
            marks.extend(unwritten);
        }
        let others = [&source.numbers_of(name, "missing_value")?, missing].concat();
        is_said |= !others.is_empty();
        marks.extend(others);
        let (valid, packing) = (Valid::of(source, variable)?, packing(source, name)?);
        Ok(Decoder { marks, is_said, valid, packing })
    }

    /// Sets values that look like marks to NaN if no mark is specified; returns these, and the number of each.
    pub(crate) fn take_unsaid_marks(&self, values: &mut ShapedValues) -> Vec<(f64, usize)> {
        let mut taken = Vec::new();
        if self.is_said {
            return taken;
        }
        while let Some((mark, count)) = values.outlier() {
            if mark == values.rounded(UNWRITTEN) {
                break;
            }
            values.mask(|value| value == mark);
            taken.push((mark, count));
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
        let Some([scale, offset]) = self.packing else { return fill };
        values.mask(|value| value == fill);
        values.each(|value| scale * value + offset);
        self.valid.mask_outside(values, !self.valid.is_of_stored);
        f64::NAN
    }
}

/// Reads a block of a variable as values, NaN where they are missing.
pub(crate) fn decoded(
    source: &dyn Source,
    variable: &Variable,
    (start, count): (&[usize], &[usize]),
    missing: &[f64],
) -> Result<ShapedValues> {
    let read = source.reals(variable, start, count)?;
    let shape = Shape::level_fastest(read.as_reals().len(), 1);
    let mut values = ShapedValues::new(read.into(), shape, [None, None]);
    let decoder = Decoder::of(source, variable, missing)?;
    decoder.take_unsaid_marks(&mut values);
    let fill = decoder.decode(&mut values);
    values.mask(|value| value == fill);
    Ok(values)
}
