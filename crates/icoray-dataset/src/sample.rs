//! A dataset to try icoray on: two vortices that wind up a plume and the layers of the air.
//!
//! The wind blows along circles about one axis (R. D. Nair and C. Jablonowski, 2008, Moving vortices on the sphere,
//! [doi:10.1175/2007MWR2105.1](https://doi.org/10.1175/2007MWR2105.1), without their background flow), so that the
//! path of each parcel is known exactly. With ρ = ρ₀ cos φ', where φ' is the latitude about the axis, its speed is
//! U(z) (1 + a sin φ') V(ρ), where V = (3√3/2) sech²ρ tanh ρ has the maximum 1, U rises with height, and a makes the
//! two ends of the axis differ. The axis leans westward with height. Tracer and potential temperature are those of the
//! place where a parcel was at time 0.

use icoray::{IcosahedralMesh, OwnedReals};

/// Bisections of the icosahedron: 2,562 cells.
const LEVEL: u32 = 4;
const RADIUS_M: f64 = 6_371_229.0;
const LAYERS: usize = 16;
const TOP_M: f64 = 16e3;
/// Days since time 0 of the records.
const DAYS: [f64; 2] = [1.0, 2.0];
const SECONDS_PER_DAY: f64 = 86_400.0;
/// Longitude at the ground and latitude of the axis, degrees.
const AXIS_DEG: [f64; 2] = [-30.0, 45.0];
/// Westward shift of the axis from the ground to the top, degrees.
const TILT_DEG: f64 = 25.0;
/// ρ₀: the vortices have their largest wind at ρ = 0.66.
const SHARPNESS: f64 = 2.2;
/// U at the ground and at the top, m/s.
const WIND_M_S: [f64; 2] = [20.0, 40.0];
/// Fraction by which the northern vortex is stronger, and the southern one weaker.
const ASYMMETRY: f64 = 0.25;

/// Global attributes of the sample, besides its [`Sample::sphere_radius_m`].
const ATTRIBUTES: [(&str, &str); 2] =
    [("on_a_sphere", "YES"), ("title", "Two vortices on a sphere that wind up a tracer, computed by icoray")];

/// A dataset that follows the conventions of MPAS, in memory: 2,562 cells, 16 layers between 0 and 16 km, two times,
/// and the fields `tracer` (1), `theta` (K) and `vorticity` (1/s).
#[derive(Debug)]
pub struct Sample {
    /// Names and values of the global attributes that are text.
    pub attributes: [(&'static str, &'static str); 2],
    /// The global attribute `sphere_radius`, metres.
    pub sphere_radius_m: f64,
    /// Name and length of each dimension.
    pub dimensions: Vec<(&'static str, usize)>,
    /// Tables of the mesh, times, heights and fields.
    pub variables: Vec<SampleVariable>,
}

/// A variable of the sample.
#[derive(Debug)]
pub struct SampleVariable {
    /// Its name.
    pub name: &'static str,
    /// Names of its dimensions, the slowest first.
    pub dimensions: Vec<&'static str>,
    /// Its values, as many as the dimensions span.
    pub values: SampleValues,
    /// Names and values of its attributes.
    pub attributes: Vec<(&'static str, &'static str)>,
}

/// Values of a variable of the sample.
#[derive(Debug)]
pub enum SampleValues {
    /// Tables of indices from 1.
    Integers(Vec<i32>),
    /// Coordinates, times and fields.
    Reals(OwnedReals),
}

impl Sample {
    /// Computes the sample: about 2 MB.
    ///
    /// # Errors
    /// [`icoray::ErrorKind::Memory`] if the mesh does not fit.
    pub fn new() -> icoray::Result<Self> {
        let mesh = IcosahedralMesh::new(LEVEL)?;
        let dimensions = vec![
            ("nCells", mesh.cells()),
            ("nVertices", mesh.lon_corner_rad.len()),
            ("nEdges", mesh.edge_corner.len() / 2),
            ("maxEdges", 6),
            ("vertexDegree", 3),
            ("TWO", 2),
            ("nVertLevels", LAYERS),
            ("nVertLevelsP1", LAYERS + 1),
            ("Time", DAYS.len()),
        ];
        let sphere_radius_m = RADIUS_M;
        let mut sample = Sample { attributes: ATTRIBUTES, sphere_radius_m, dimensions, variables: Vec::new() };
        sample.add_mesh(&mesh);
        sample.add_fields(&mesh);
        Ok(sample)
    }

    fn add_mesh(&mut self, mesh: &IcosahedralMesh) {
        for (name, dimension, radians) in [
            ("lonCell", "nCells", &mesh.lon_center_rad),
            ("latCell", "nCells", &mesh.lat_center_rad),
            ("lonVertex", "nVertices", &mesh.lon_corner_rad),
            ("latVertex", "nVertices", &mesh.lat_corner_rad),
        ] {
            let values = SampleValues::Reals(OwnedReals::F64(radians.clone()));
            self.add(name, &[dimension], values, &[("units", "rad")]);
        }
        // A pentagon repeats its last corner in the mesh; in a file the entry is 0.
        let mut cell_corner: Vec<i32> = mesh.cell_corner.iter().map(|corner| corner + 1).collect();
        let mut count = vec![6; mesh.cells()];
        for (row, count) in cell_corner.chunks_exact_mut(6).zip(&mut count).filter(|(row, _)| row[4] == row[5]) {
            row[5] = 0;
            *count = 5;
        }
        self.add("nEdgesOnCell", &["nCells"], SampleValues::Integers(count), &[]);
        self.add("verticesOnCell", &["nCells", "maxEdges"], SampleValues::Integers(cell_corner), &[]);
        for (name, dimensions, table) in [
            ("cellsOnVertex", ["nVertices", "vertexDegree"], &mesh.corner_cell),
            ("edgesOnVertex", ["nVertices", "vertexDegree"], &mesh.corner_edge),
            ("verticesOnEdge", ["nEdges", "TWO"], &mesh.edge_corner),
        ] {
            self.add(name, &dimensions, SampleValues::Integers(table.iter().map(|index| index + 1).collect()), &[]);
        }
    }

    fn add_fields(&mut self, mesh: &IcosahedralMesh) {
        let days = SampleValues::Reals(OwnedReals::F64(DAYS.into()));
        self.add("Time", &["Time"], days, &[("units", "days since 2000-01-01 00:00:00"), ("calendar", "standard")]);
        let interfaces = (0..=LAYERS).map(|interface| TOP_M * interface as f64 / LAYERS as f64);
        let heights = (0..mesh.cells()).flat_map(|_| interfaces.clone().map(|height_m| height_m as f32)).collect();
        let attributes = [("units", "m"), ("long_name", "Geometric height of layer interfaces")];
        let heights = SampleValues::Reals(OwnedReals::F32(heights));
        self.add("zgrid", &["nCells", "nVertLevelsP1"], heights, &attributes);
        let middles = (0..LAYERS).map(|layer| TOP_M * (layer as f64 + 0.5) / LAYERS as f64);
        let mut places = Vec::with_capacity(mesh.cells() * LAYERS);
        for (lon, lat) in mesh.lon_center_rad.iter().zip(&mesh.lat_center_rad) {
            places.extend(middles.clone().map(|height_m| Place::at(*lon, *lat, height_m)));
        }
        let mut add = |name, units, long_name, value: fn(&Place, f64) -> f64| {
            let at = |day| places.iter().map(move |place| value(place, SECONDS_PER_DAY * day) as f32);
            let values = SampleValues::Reals(OwnedReals::F32(DAYS.into_iter().flat_map(at).collect()));
            let attributes = [("units", units), ("long_name", long_name)];
            self.add(name, &["Time", "nCells", "nVertLevels"], values, &attributes);
        };
        add("tracer", "1", "Tracer mixing ratio", Place::tracer);
        add("theta", "K", "Potential temperature", Place::theta);
        add("vorticity", "s-1", "Relative vorticity", Place::vorticity);
    }

    fn add(
        &mut self,
        name: &'static str,
        dimensions: &[&'static str],
        values: SampleValues,
        attributes: &[(&'static str, &'static str)],
    ) {
        let (dimensions, attributes) = (dimensions.to_vec(), attributes.to_vec());
        self.variables.push(SampleVariable { name, dimensions, values, attributes });
    }
}

/// A place on the unit sphere: along the axis of the vortices at its height, and eastward and northward at the axis.
struct Place {
    height_m: f64,
    along: f64,
    east: f64,
    north: f64,
}

impl Place {
    fn at(lon_rad: f64, lat_rad: f64, height_m: f64) -> Self {
        let axis_lon = (AXIS_DEG[0] - TILT_DEG * height_m / TOP_M).to_radians();
        let axis_lat = AXIS_DEG[1].to_radians();
        let (turned, up) = ((lon_rad - axis_lon).cos() * lat_rad.cos(), lat_rad.sin());
        Place {
            height_m,
            along: axis_lat.cos() * turned + axis_lat.sin() * up,
            east: (lon_rad - axis_lon).sin() * lat_rad.cos(),
            north: axis_lat.cos() * up - axis_lat.sin() * turned,
        }
    }

    /// The position of the parcel `seconds` seconds ago.
    fn before(&self, seconds: f64) -> Self {
        let (sin, cos) = (-self.angular_speed(self.along) * seconds).sin_cos();
        Place { east: cos * self.east - sin * self.north, north: sin * self.east + cos * self.north, ..*self }
    }

    /// Angular speed about the axis at this height, 1/s, at the sine `along` of the latitude about it.
    fn angular_speed(&self, along: f64) -> f64 {
        let cosine = (1.0 - along * along).max(0.0).sqrt();
        // At the axis the quotient has the limit of nearby values.
        let rho = (SHARPNESS * cosine).max(1e-6);
        let speed = 1.5 * 3f64.sqrt() * rho.cosh().powi(-2) * rho.tanh();
        let wind_m_s = (WIND_M_S[0] + (WIND_M_S[1] - WIND_M_S[0]) * self.height_m / TOP_M) * (1.0 + ASYMMETRY * along);
        wind_m_s * speed * SHARPNESS / (rho * RADIUS_M)
    }

    /// A plume that began as an arc from west to east through the axis, thickest at 6 km.
    fn tracer(&self, seconds: f64) -> f64 {
        let Place { along, north, .. } = self.before(seconds);
        let near = 0.5 * (1.0 + (3.0 * along).tanh());
        0.02 + near * (-(north / 0.28).powi(2) - ((self.height_m - 6e3) / 3e3).powi(2)).exp()
    }

    /// Warm at the equator, cold at the poles, and warmer with height, at time 0; K.
    fn theta(&self, seconds: f64) -> f64 {
        let axis_lat = AXIS_DEG[1].to_radians();
        let Place { along, north, .. } = self.before(seconds);
        let sin_lat = along * axis_lat.sin() + north * axis_lat.cos();
        303.0 - 45.0 * sin_lat * sin_lat + 4e-3 * self.height_m
    }

    /// The radial component of the wind's curl, 1/s: -d(ω cos²φ')/d(sin φ').
    fn vorticity(&self, _: f64) -> f64 {
        let [low, high] = [-1e-4, 1e-4].map(|step| {
            let along = (self.along + step).clamp(-1.0, 1.0);
            (along, self.angular_speed(along) * (1.0 - along * along))
        });
        (low.1 - high.1) / (high.0 - low.0)
    }
}
