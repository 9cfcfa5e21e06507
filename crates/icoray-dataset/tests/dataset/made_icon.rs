//! Small ICON files.

use crate::made::{Made, RECORDS, Values, value};
use icoray::IcosahedralMesh;

pub const LAYERS: usize = 3;

/// How a file gives angles.
#[derive(Clone, Copy)]
pub enum Angles {
    Radians,
    Degrees,
    /// In single precision, as the CDO write them with `-b F32`.
    Degrees32,
}

impl Angles {
    fn values(self, rad: impl Iterator<Item = f64>) -> Values {
        match self {
            Angles::Radians => Values::F64(rad.collect()),
            Angles::Degrees => Values::F64(rad.map(f64::to_degrees).collect()),
            Angles::Degrees32 => Values::F32(rad.map(|a| a.to_degrees() as f32).collect()),
        }
    }

    fn units(self) -> &'static str {
        match self {
            Angles::Radians => "radian",
            Angles::Degrees | Angles::Degrees32 => "degrees",
        }
    }
}

impl Made {
    /// Adds positions in radians or degrees, given in radians.
    pub fn angles(&mut self, name: &'static str, dimensions: &[&'static str], angles: Angles, rad: &[f64]) {
        self.add(name, dimensions, angles.values(rad.iter().copied()));
        self.last().attributes = vec![("units", angles.units().into())];
    }

    /// The triangles' centres.
    fn icon_centres(&mut self, mesh: &IcosahedralMesh, angles: Angles, dimension: &'static str) {
        self.angles("clon", &[dimension], angles, &mesh.lon_corner_rad);
        self.angles("clat", &[dimension], angles, &mesh.lat_corner_rad);
    }

    /// An ICON grid file.
    pub fn icon_grid() -> Self {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let triangles = mesh.corner_cell.len() / 3;
        let mut made = Made::of(
            [("cell", triangles), ("vertex", mesh.cells()), ("nv", 3)],
            [("sphere_radius", 6_371_229.0.into()), ("grid_geometry", 1.into())],
        );
        made.icon_centres(&mesh, Angles::Radians, "cell");
        made.angles("vlon", &["vertex"], Angles::Radians, &mesh.lon_center_rad);
        made.angles("vlat", &["vertex"], Angles::Radians, &mesh.lat_center_rad);
        let by_column = (0..3).flat_map(|k| (0..triangles).map(move |t| (k, t)));
        let table = by_column.map(|(k, t)| mesh.corner_cell[3 * t + k] + 1).collect();
        made.add("vertex_of_cell", &["nv", "cell"], Values::I32(table));
        made
    }

    /// An ICON file with fields and bounds, as ICON and the CDO write them.
    pub fn icon_data(angles: Angles) -> Self {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let triangles = mesh.corner_cell.len() / 3;
        let mut made = Made::of(
            [("ncells", triangles), ("vertices", 3), ("lev", LAYERS), ("time", 0)],
            [("CDI", "Climate Data Interface".into())],
        );
        made.icon_centres(&mesh, angles, "ncells");
        made.variable("clon").attributes.push(("bounds", "clon_bnds".into()));
        for (name, of) in [("clon_bnds", &mesh.lon_center_rad), ("clat_bnds", &mesh.lat_center_rad)] {
            // Longitudes of a pole's triangles differ, and each triangle has digits of its own.
            let own = |(i, &cell): (usize, &i32)| {
                let is_pole = mesh.lat_center_rad[cell as usize].abs() > 1.57;
                let noise = if is_pole && name == "clon_bnds" { 0.1 * i as f64 } else { 1e-9 * (i % 7) as f64 };
                of[cell as usize] - noise
            };
            let bounds: Vec<f64> = mesh.corner_cell.iter().enumerate().map(own).collect();
            made.add(name, &["ncells", "vertices"], angles.values(bounds.into_iter()));
        }
        made.add("lev", &["lev"], Values::F64(vec![100_000.0, 85_000.0, 50_000.0]));
        made.last().attributes = vec![("units", "Pa".into()), ("positive", "down".into())];
        made.add("time", &["time"], Values::F64((0..RECORDS).map(|t| 0.25 * t as f64).collect()));
        made.last().attributes =
            vec![("units", "days since 1979-01-31 18:00:00".into()), ("calendar", "proleptic_gregorian".into())];
        let records = (0..RECORDS).flat_map(|t| (0..LAYERS).map(move |l| (t, l)));
        let t2m = records.flat_map(|(t, l)| (0..triangles).map(move |c| value(t, c, l) as f32)).collect();
        made.add("ta", &["time", "lev", "ncells"], Values::F32(t2m));
        made.last().attributes = vec![("units", "K".into()), ("long_name", "Temperature".into())];
        made
    }

    /// A file of DYNAMICO: hexagons and pentagons with their points, `ta` on pressures and `ps`.
    pub fn dynamico(angles: Angles) -> Self {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let mut made = Made::of(
            [("cell", mesh.cells()), ("nvertex", 6), ("lev", LAYERS), ("time", 0)],
            [("Conventions", "CF-1.6".into())],
        );
        made.angles("lon", &["cell"], angles, &mesh.lon_center_rad);
        made.angles("lat", &["cell"], angles, &mesh.lat_center_rad);
        for (name, of) in [("lon", &mesh.lon_corner_rad), ("lat", &mesh.lat_corner_rad)] {
            let bounds = if name == "lon" { "lon_bnds" } else { "lat_bnds" };
            made.variable(name).attributes.push(("bounds", bounds.into()));
            let values: Vec<f64> = mesh.cell_corner.iter().map(|corner| of[*corner as usize]).collect();
            made.angles(bounds, &["cell", "nvertex"], angles, &values);
        }
        made.add("lev", &["lev"], Values::F64(vec![100_000.0, 85_000.0, 50_000.0]));
        made.last().attributes = vec![("units", "Pa".into())];
        let cells = mesh.cells();
        let records = (0..RECORDS).flat_map(|t| (0..LAYERS).map(move |l| (t, l)));
        let ta = records.flat_map(|(t, l)| (0..cells).map(move |c| value(t, c, l) as f32)).collect();
        made.add("ta", &["time", "lev", "cell"], Values::F32(ta));
        let ps = (0..RECORDS).flat_map(|t| (0..cells).map(move |c| value(t, c, 0) as f32)).collect();
        made.add("ps", &["time", "cell"], Values::F32(ps));
        made
    }
}
