//! Rows and columns of positions as one dimension: longitudes and latitudes over (y, x), as in tripolar, rotated and
//! swath grids, or each over a separate dimension, as in lat-lon grids.
//!
//! A [`Raster`] shows two dimensions of a source as one, so that its fields are over columns like those of other
//! models. Formats: CF conventions 1.11, §5.1 and §5.2.

use crate::mesh;
use crate::source::{Attribute, Dimension, Source, Variable};
use crate::sources::Sources;
use icoray::{OwnedReals, Result};
use std::path::Path;

/// A source whose adjacent dimensions `y` and `x` are one dimension.
#[derive(Debug)]
struct Raster {
    source: Box<dyn Source>,
    variables: Vec<Variable>,
    rows: [Dimension; 2],
}

/// The sources, as rasters if they have no mesh of a known kind and one has longitudes and latitudes over two
/// dimensions.
pub(crate) fn flattened(sources: Sources) -> Result<Sources> {
    if mesh::is_known(&sources)? {
        return Ok(sources);
    }
    let rows = sources.others_first().find_map(rows);
    match rows {
        Some(rows) => Ok(sources.map(|source| Box::new(Raster::new(source, rows.clone())))),
        None => Ok(sources),
    }
}

/// The dimensions of rows and columns in a source.
fn rows(source: &dyn Source) -> Option<[Dimension; 2]> {
    let angles = |which: usize| {
        let found = source.each_variable().filter(move |found| mesh::is_angle(*found, which));
        found.map(|found| found.variable.after_time())
    };
    angles(0).find_map(|lon| match lon {
        [y, x] => angles(1).any(|lat| lat == [y.clone(), x.clone()]).then(|| [y.clone(), x.clone()]),
        [x] => angles(1).find_map(|lat| match lat {
            [y] if y != x => Some([y.clone(), x.clone()]),
            _ => None,
        }),
        _ => None,
    })
}

impl Raster {
    fn new(source: Box<dyn Source>, rows: [Dimension; 2]) -> Self {
        let mut raster = Raster { variables: source.variables().to_vec(), source, rows };
        let merged = raster.merged();
        let source = raster.source.as_ref();
        for (variable, original) in raster.variables.iter_mut().zip(source.variables()) {
            if let Some(at) = place(&raster.rows, original) {
                variable.dimensions.splice(at..at + 2, [merged.clone()]);
            } else if side(&raster.rows, source, original).is_some() {
                variable.dimensions = vec![merged.clone()];
            }
        }
        raster
    }

    fn merged(&self) -> Dimension {
        let [y, x] = &self.rows;
        Dimension::new(format!("{}, {}", y.name, x.name), y.len * x.len)
    }
}

/// The index of the two dimensions among those of a variable.
fn place(rows: &[Dimension; 2], variable: &Variable) -> Option<usize> {
    variable.dimensions.windows(2).position(|pair| pair == rows)
}

/// The one of the two dimensions over which a longitude or latitude lies.
fn side(rows: &[Dimension; 2], source: &dyn Source, variable: &Variable) -> Option<usize> {
    let is_angle = (0..2).any(|which| mesh::is_angle(source.with(variable), which));
    (0..2).find(|k| is_angle && variable.dimensions == rows[*k..=*k])
}

impl Source for Raster {
    fn path(&self) -> &Path {
        self.source.path()
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        let merged = self.merged();
        if name == merged.name { Ok(Some(merged.len)) } else { self.source.dimension_len(name) }
    }

    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>> {
        self.source.attribute(variable, name)
    }

    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
        let source = self.source.as_ref();
        let (original, [y, x]) = (source.expect(&variable.name)?, &self.rows);
        if let Some(side) = side(&self.rows, source, original) {
            let angles = source.reals(original, &[0], &[self.rows[side].len])?;
            let along = |i: usize| if side == 0 { i / x.len } else { i % x.len };
            return Ok(picked(&angles, (start[0]..start[0] + count[0]).map(along)));
        }
        let Some(at) = place(&self.rows, original) else { return source.reals(original, start, count) };
        // Reads whole rows, and leaves the ends of the first and the last out.
        let (first, end) = (start[at] / x.len, (start[at] + count[at]).div_ceil(x.len).min(y.len));
        let block = |of: &[usize], rows: [usize; 2]| [&of[..at], &rows, &of[at + 1..]].concat();
        let read = source.reals(original, &block(start, [first, 0]), &block(count, [end - first, x.len]))?;
        let (skipped, there) = (start[at] - first * x.len, (end - first) * x.len);
        if there == count[at] {
            return Ok(read);
        }
        let inner: usize = count[at + 1..].iter().product();
        let outer: usize = count[..at].iter().product();
        let kept = skipped * inner..(skipped + count[at]) * inner;
        Ok(picked(&read, (0..outer).flat_map(|block| kept.clone().map(move |i| block * there * inner + i))))
    }

    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>> {
        self.source.text_rows(variable, rows)
    }
}

/// Some of the values, in their precision.
fn picked(values: &OwnedReals, of: impl Iterator<Item = usize>) -> OwnedReals {
    match values {
        OwnedReals::F32(values) => OwnedReals::F32(of.map(|i| values[i]).collect()),
        OwnedReals::F64(values) => OwnedReals::F64(of.map(|i| values[i]).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{Kind, SourceVariable};
    use crate::sources::DatasetOptions;

    /// Variables whose values are their places in memory.
    #[derive(Debug)]
    struct Places(Vec<Variable>);

    impl Source for Places {
        fn path(&self) -> &Path {
            Path::new("places")
        }

        fn variables(&self) -> &[Variable] {
            &self.0
        }

        fn attribute(&self, _: Option<&str>, _: &str) -> Result<Option<Attribute>> {
            Ok(None)
        }

        fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
            let mut places = vec![0];
            for (dimension, (start, count)) in variable.dimensions.iter().zip(start.iter().zip(count)) {
                let along = |place: usize| (*start..start + count).map(move |i| place * dimension.len + i);
                places = places.into_iter().flat_map(along).collect();
            }
            Ok(OwnedReals::F64(places.into_iter().map(|place| place as f64).collect()))
        }

        fn text_rows(&self, _: &Variable, _: usize) -> Vec<Option<String>> {
            Vec::new()
        }
    }

    #[test]
    fn blocks_of_columns_begin_and_end_within_rows() {
        let variable = |name: &str, dimensions: &[(&str, usize)]| Variable {
            name: name.into(),
            kind: Kind::F64,
            dimensions: dimensions.iter().map(|(name, len)| Dimension::new((*name).into(), *len)).collect(),
        };
        let (lat, lon) = (variable("lat", &[("y", 4)]), variable("lon", &[("x", 5)]));
        let field = variable("field", &[("lev", 2), ("y", 4), ("x", 5), ("n", 3)]);
        let sources = Sources::new(Box::new(Places(vec![lat, lon, field])), Vec::new(), DatasetOptions::default());
        let raster = flattened(sources).unwrap();
        let SourceVariable { source, variable: field } = raster.find("field").unwrap();
        assert_eq!(field.to_string(), "field(lev = 2, y, x = 20, n = 3) of double");
        assert_eq!(source.dimension_len("y, x").unwrap(), Some(20));
        let read = |source: &dyn Source, variable: &Variable, start: &[usize], count: &[usize]| -> Vec<f64> {
            let reals = source.reals(variable, start, count).unwrap();
            (0..reals.as_reals().len()).map(|i| reals.as_reals().get(i)).collect()
        };
        for (first, count) in [(0, 20), (0, 1), (3, 4), (5, 5), (7, 13), (19, 1)] {
            let (start, count) = ([0, first, 1], [2, count, 2]);
            let expected = read(&Places(Vec::new()), field, &start, &count);
            assert_eq!(read(source, field, &start, &count), expected, "{start:?} {count:?}");
        }
        let [lon, lat] = ["lon", "lat"].map(|name| source.find(name).unwrap().all_numbers().unwrap());
        assert_eq!([lon[13], lat[13]], [3.0, 2.0]);
        assert_eq!(read(source, source.variable("lat").unwrap(), &[4], &[2]), [0.0, 1.0]);
    }
}
