//! Outlines of a GeoJSON file (RFC 7946): its lines, and the rings of its polygons.

use geojson::{GeoJson, Geometry, GeometryValue, Position};
use icoray_grid::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::SystemTime;

/// Largest size of a file, bytes. Natural Earth's countries at 1:10 million take 25 million.
const MAX_BYTES: u64 = 64 << 20;

/// Most pieces of a degree that the lines of a file may have.
const MAX_PIECES: f64 = 2e6;

/// Lines in longitude and latitude, degrees, straight in both from point to point.
#[derive(Debug, Default, PartialEq)]
pub struct Outlines {
    runs: Vec<Vec<[f64; 2]>>,
}

/// A file as it was read last: its path, length and time of modification.
type Version = (PathBuf, u64, Option<SystemTime>);

impl Outlines {
    /// Reads the lines and polygons of a GeoJSON file. Points in it are left out. A file that has not changed is not read
    /// again while its outlines are in use.
    ///
    /// # Errors
    /// A file that cannot be read, is larger than 64 MiB, is no GeoJSON, has neither lines nor polygons or too many of
    /// them; longitudes beyond ±360 and latitudes beyond ±90 degrees, by feature and coordinate.
    pub fn read(path: &Path) -> Result<Arc<Self>> {
        static READ: Mutex<Vec<(Version, Weak<Outlines>)>> = Mutex::new(Vec::new());
        let failed = |kind, what: String| Error::new(kind, format!("{}: {what}", path.display()));
        let unread = |cause: std::io::Error| failed(ErrorKind::Io, cause.to_string());
        // Opened only then: a pipe would wait for who writes to it.
        let metadata = path.metadata().map_err(unread)?;
        if !metadata.is_file() || metadata.len() > MAX_BYTES {
            let what =
                format!("expected a file of at most {} MiB; ogr2ogr -simplify makes smaller ones", MAX_BYTES >> 20);
            return Err(failed(ErrorKind::Io, what));
        }
        let version = (path.to_owned(), metadata.len(), metadata.modified().ok());
        let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
        read.retain(|(_, outlines)| outlines.strong_count() > 0);
        let known = read.iter().find(|(known, _)| *known == version);
        if let Some(outlines) = known.and_then(|(_, outlines)| outlines.upgrade()) {
            return Ok(outlines);
        }
        let mut text = String::new();
        File::open(path).and_then(|file| file.take(MAX_BYTES).read_to_string(&mut text)).map_err(unread)?;
        let outlines = Arc::new(Self::parse(&text).map_err(|what| failed(ErrorKind::Scene, what))?);
        read.push((version, Arc::downgrade(&outlines)));
        Ok(outlines)
    }

    /// Runs of two points or more, each of longitude and latitude in degrees.
    pub fn runs(&self) -> &[Vec<[f64; 2]>] {
        &self.runs
    }

    fn parse(text: &str) -> std::result::Result<Self, String> {
        let json: GeoJson = text.parse().map_err(|cause| format!("is no GeoJSON: {cause}"))?;
        let geometries: Vec<Option<&Geometry>> = match &json {
            GeoJson::Geometry(geometry) => vec![Some(geometry)],
            GeoJson::Feature(feature) => vec![feature.geometry.as_ref()],
            GeoJson::FeatureCollection(all) => all.features.iter().map(|feature| feature.geometry.as_ref()).collect(),
        };
        let (mut outlines, mut pieces) = (Self::default(), 0.0);
        for (feature, geometry) in geometries.into_iter().enumerate() {
            let mut first = 0;
            for line in geometry.map(lines).unwrap_or_default() {
                let run =
                    run(line).map_err(|(i, what)| format!("feature {feature}, coordinate {}: {what}", first + i))?;
                first += line.len();
                pieces += run.windows(2).map(|pair| pieces_between(pair[0], pair[1])).sum::<f64>();
                if pieces > MAX_PIECES {
                    return Err(format!(
                        "feature {feature}: more than {MAX_PIECES} pieces of lines, expected fewer; ogr2ogr -simplify \
                         leaves points out"
                    ));
                }
                outlines.runs.extend(Some(run).filter(|run| run.len() > 1));
            }
        }
        if outlines.runs.is_empty() { Err("has no lines and no polygons".into()) } else { Ok(outlines) }
    }
}

/// The lines of a geometry, and the rings of its polygons.
fn lines(geometry: &Geometry) -> Vec<&[Position]> {
    match &geometry.value {
        GeometryValue::Point { .. } | GeometryValue::MultiPoint { .. } => Vec::new(),
        GeometryValue::LineString { coordinates } => vec![coordinates],
        GeometryValue::MultiLineString { coordinates } | GeometryValue::Polygon { coordinates } => {
            coordinates.iter().map(Vec::as_slice).collect()
        }
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().flatten().map(Vec::as_slice).collect(),
        GeometryValue::GeometryCollection { geometries } => geometries.iter().flat_map(lines).collect(),
    }
}

/// The points of a line; an error has the number of the point.
fn run(line: &[Position]) -> std::result::Result<Vec<[f64; 2]>, (usize, String)> {
    let point = |(i, position): (usize, &Position)| match *position.as_slice() {
        [lon, lat, ..] if lon.abs() <= 360.0 && lat.abs() <= 90.0 => Ok([lon, lat]),
        ref other => Err((
            i,
            format!(
                "{other:?}, expected a longitude of -360 to 360 and a latitude of -90 to 90 degrees; ogr2ogr -t_srs \
                 EPSG:4326 makes degrees of other coordinates"
            ),
        )),
    };
    line.iter().enumerate().map(point).collect()
}

/// Pieces of at most half a degree of longitude and a degree of latitude from point to point.
fn pieces_between(from: [f64; 2], to: [f64; 2]) -> f64 {
    (2.0 * (to[0] - from[0]).abs()).max((to[1] - from[1]).abs()).ceil().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        Outlines::parse(text).unwrap_err()
    }

    #[test]
    fn lines_and_rings_of_all_geometries_are_taken() {
        let line = r#"{"type": "LineString", "coordinates": [[1, 2], [3, 4, 100]]}"#;
        let polygon = r#"{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [0, 9], [0, 0]], [[1, 1], [2, 1], [1, 2], [1, 1]]]}"#;
        let point = r#"{"type": "Point", "coordinates": [0, 0]}"#;
        let several = format!(r#"{{"type": "GeometryCollection", "geometries": [{line}, {point}, {polygon}]}}"#);
        let counts = |text: &str| Outlines::parse(text).unwrap().runs().iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!(Outlines::parse(line).unwrap().runs(), [[[1.0, 2.0], [3.0, 4.0]]]);
        assert_eq!(counts(&several), [2, 4, 4]);
        let feature =
            |geometry: &str| format!(r#"{{"type": "Feature", "properties": {{"a": 1}}, "geometry": {geometry}}}"#);
        let all = [feature(line), feature("null"), feature(&several)].join(",");
        assert_eq!(counts(&format!(r#"{{"type": "FeatureCollection", "features": [{all}]}}"#)), [2, 2, 4, 4]);
        assert!(refused(point).contains("no lines and no polygons"));
        assert!(refused("{}").contains("is no GeoJSON: "));

        let bad = r#"{"type": "MultiLineString", "coordinates": [[[1, 2], [3, 4]], [[5, 6], [7e5, 80]]]}"#;
        let all = [feature(line), feature(bad)].join(",");
        let message = refused(&format!(r#"{{"type": "FeatureCollection", "features": [{all}]}}"#));
        assert!(message.starts_with("feature 1, coordinate 3: [700000.0, 80.0], expected a longitude"), "{message}");
        assert!(
            refused(r#"{"type": "LineString", "coordinates": [[1, 90.5], [3, 4]]}"#)
                .contains("coordinate 0: [1.0, 90.5]")
        );
    }

    #[test]
    fn sizes_are_bounded() {
        let ring = "[-360, 0], [360, 0],".repeat(2000);
        let text = format!(r#"{{"type": "LineString", "coordinates": [{ring} [0, 0]]}}"#);
        assert!(refused(&text).contains("feature 0: more than 2000000 pieces"));
        let deep = r#"{"type": "GeometryCollection", "geometries": ["#.repeat(100_000);
        assert!(refused(&deep).contains("is no GeoJSON"));
        assert!(
            Outlines::read(Path::new("/dev/zero"))
                .unwrap_err()
                .to_string()
                .contains("expected a file of at most 64 MiB")
        );
    }

    #[test]
    fn a_file_is_read_again_when_it_has_changed() {
        let path = std::env::temp_dir().join(format!("icoray-outlines-{}.geojson", std::process::id()));
        let write = |end: &str| {
            std::fs::write(&path, format!(r#"{{"type": "LineString", "coordinates": [[1, 2], {end}]}}"#)).unwrap();
            Outlines::read(&path).unwrap()
        };
        let first = write("[3, 4]");
        assert!(Arc::ptr_eq(&first, &Outlines::read(&path).unwrap()));
        assert_eq!(write("[30, 40]").runs(), [[[1.0, 2.0], [30.0, 40.0]]]);
        std::fs::remove_file(&path).unwrap();
        let message = Outlines::read(&path).unwrap_err().to_string();
        assert!(message.contains(path.to_str().unwrap()), "{message}");
    }
}
