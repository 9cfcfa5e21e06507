//! Small datasets of MPAS and MPAS-Ocean, declared as data so that a test can spoil one part.

use icoray::IcosahedralMesh;

pub const LAYERS: usize = 4;
pub const RECORDS: usize = 3;
pub const RADIUS_M: f64 = 6_371_229.0;
/// Heights of the interfaces, any spacing.
pub const HEIGHT_M: [f64; LAYERS + 1] = [0.0, 100.0, 400.0, 1500.0, 9000.0];

#[derive(Debug, Clone)]
pub enum Values {
    F32(Vec<f32>),
    F64(Vec<f64>),
    I32(Vec<i32>),
    Text(Vec<u8>),
}

impl Values {
    pub fn len(&self) -> usize {
        match self {
            Values::F32(values) => values.len(),
            Values::F64(values) => values.len(),
            Values::I32(values) => values.len(),
            Values::Text(values) => values.len(),
        }
    }
}

macro_rules! from {
    ($($type:ty, $value:ident => $values:expr;)*) => {
        $(impl From<$type> for Values {
            fn from($value: $type) -> Self {
                $values
            }
        })*
    };
}

// Of attributes.
from! {
    f32, value => Values::F32(vec![value]);
    f64, value => Values::F64(vec![value]);
    i32, value => Values::I32(vec![value]);
    &str, value => Values::Text(value.as_bytes().to_vec());
}

#[derive(Debug, Clone)]
pub struct Made {
    /// Name of the file.
    pub path: &'static str,
    /// Length 0 makes the record dimension.
    pub dimensions: Vec<(&'static str, usize)>,
    pub attributes: Vec<(&'static str, Values)>,
    pub variables: Vec<MadeVariable>,
}

#[derive(Debug, Clone)]
pub struct MadeVariable {
    pub name: &'static str,
    pub dimensions: Vec<&'static str>,
    pub values: Values,
    pub attributes: Vec<(&'static str, Values)>,
}

/// What the fields hold: different at every record, column and layer.
pub fn value(time: usize, column: usize, layer: usize) -> f64 {
    (1000 * time + column) as f64 + 0.125 * layer as f64
}

fn field(columns: usize, layers: usize, records: std::ops::Range<usize>) -> Vec<f64> {
    let each = |t| (0..columns).flat_map(move |c| (0..layers).map(move |l| value(t, c, l)));
    records.flat_map(each).collect()
}

fn single(values: &[f64]) -> Values {
    Values::F32(values.iter().map(|v| *v as f32).collect())
}

impl Made {
    /// A dataset without variables.
    pub fn of<const D: usize, const A: usize>(
        dimensions: [(&'static str, usize); D],
        attributes: [(&'static str, Values); A],
    ) -> Self {
        Made { path: "made.nc", dimensions: dimensions.into(), attributes: attributes.into(), variables: Vec::new() }
    }

    /// A bisected icosahedron without fields; coordinates in single precision when `single`.
    pub fn mesh(in_single: bool) -> Self {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let real = |v: &[f64]| {
            if in_single { single(v) } else { Values::F64(v.to_vec()) }
        };
        let index = |v: &[i32]| Values::I32(v.iter().map(|i| i + 1).collect());
        // As in MPAS files: entries behind the last corner of a pentagon are 0.
        let mut corners: Vec<i32> = mesh.cell_corner.iter().map(|i| i + 1).collect();
        let mut count = vec![6; mesh.cells()];
        for (row, count) in corners.chunks_exact_mut(6).zip(&mut count).filter(|(row, _)| row[4] == row[5]) {
            (row[5], *count) = (0, 5);
        }
        let (cells, vertices) = (mesh.cells(), mesh.lon_corner_rad.len());
        let mut made = Made::of(
            [
                ("nCells", cells),
                ("nVertices", vertices),
                ("nEdges", mesh.edge_corner.len() / 2),
                ("maxEdges", 6),
                ("vertexDegree", 3),
                ("TWO", 2),
            ],
            [("on_a_sphere", "YES             ".into()), ("sphere_radius", RADIUS_M.into())],
        );
        made.add("latCell", &["nCells"], real(&mesh.lat_center_rad));
        made.add("lonCell", &["nCells"], real(&mesh.lon_center_rad));
        made.add("latVertex", &["nVertices"], real(&mesh.lat_corner_rad));
        made.add("lonVertex", &["nVertices"], real(&mesh.lon_corner_rad));
        made.add("nEdgesOnCell", &["nCells"], Values::I32(count));
        made.add("verticesOnCell", &["nCells", "maxEdges"], Values::I32(corners));
        made.add("cellsOnVertex", &["nVertices", "vertexDegree"], index(&mesh.corner_cell));
        made.add("edgesOnVertex", &["nVertices", "vertexDegree"], index(&mesh.corner_edge));
        made.add("verticesOnEdge", &["nEdges", "TWO"], index(&mesh.edge_corner));
        let shared = mesh.edge_corner.chunks_exact(2).flat_map(|ends| {
            let [one, other] = [ends[0], ends[1]].map(|c| &mesh.corner_cell[3 * c as usize..3 * c as usize + 3]);
            one.iter().copied().filter(|cell| other.contains(cell))
        });
        made.add("cellsOnEdge", &["nEdges", "TWO"], index(&shared.collect::<Vec<i32>>()));
        made
    }

    /// [`Made::mesh`] with heights, times and fields: `theta` (f32), `w` (f64, on interfaces), `vorticity` (f64, at
    /// corners), `rho` (f32, without time), and variables that are not fields.
    pub fn history() -> Self {
        let mut made = Made::mesh(true);
        made.add_fields();
        made
    }

    /// Adds what [`Made::history`] has beside the mesh.
    pub fn add_fields(&mut self) {
        let (cells, vertices) = (self.dimension("nCells"), self.dimension("nVertices"));
        self.dimensions.extend([("nVertLevels", LAYERS), ("nVertLevelsP1", LAYERS + 1), ("StrLen", 64), ("Time", 0)]);
        let heights: Vec<f64> = (0..cells).flat_map(|_| HEIGHT_M).collect();
        self.add("zgrid", &["nCells", "nVertLevelsP1"], single(&heights));
        let time = |day: usize| format!("{:<64}", format!("2013-10-{:02}_00:00:00", 25 + day)).into_bytes();
        self.add("xtime", &["Time", "StrLen"], Values::Text((0..RECORDS).flat_map(time).collect()));
        self.add("theta", &["Time", "nCells", "nVertLevels"], single(&field(cells, LAYERS, 0..RECORDS)));
        self.last().attributes = vec![("units", "K".into()), ("long_name", "Potential temperature".into())];
        self.add("w", &["Time", "nCells", "nVertLevelsP1"], Values::F64(field(cells, LAYERS + 1, 0..RECORDS)));
        self.add("vorticity", &["Time", "nVertices", "nVertLevels"], Values::F64(field(vertices, LAYERS, 0..RECORDS)));
        self.add("rho", &["nCells", "nVertLevels"], single(&field(cells, LAYERS, 0..1)));
        self.add("surface_pressure", &["Time", "nCells"], single(&field(cells, 1, 0..RECORDS)));
        self.add("levels", &["nCells", "nVertLevels"], Values::I32(vec![7; cells * LAYERS]));
    }

    /// Adds a variable, and returns it.
    pub fn add(&mut self, name: &'static str, dimensions: &[&'static str], values: Values) -> &mut MadeVariable {
        self.variables.push(MadeVariable { name, dimensions: dimensions.to_vec(), values, attributes: Vec::new() });
        self.last()
    }

    /// The variable added last.
    pub fn last(&mut self) -> &mut MadeVariable {
        self.variables.last_mut().unwrap()
    }

    pub fn variable(&mut self, name: &str) -> &mut MadeVariable {
        self.variables.iter_mut().find(|v| v.name == name).unwrap()
    }

    /// The values of a variable in single precision.
    pub fn f32s(&mut self, name: &str) -> &mut Vec<f32> {
        let Values::F32(values) = &mut self.variable(name).values else { panic!("{name} is not f32") };
        values
    }

    /// The values of a variable in double precision.
    pub fn f64s(&mut self, name: &str) -> &mut Vec<f64> {
        let Values::F64(values) = &mut self.variable(name).values else { panic!("{name} is not f64") };
        values
    }

    /// The values of a variable of integers.
    pub fn i32s(&mut self, name: &str) -> &mut Vec<i32> {
        let Values::I32(values) = &mut self.variable(name).values else { panic!("{name} is not i32") };
        values
    }

    pub fn remove(&mut self, name: &str) {
        self.variables.retain(|v| v.name != name);
        self.attributes.retain(|(n, _)| *n != name);
    }

    pub fn remove_all(&mut self, names: &[&str]) {
        names.iter().for_each(|name| self.remove(name));
    }

    pub fn set(&mut self, attribute: &'static str, value: impl Into<Values>) {
        self.remove(attribute);
        self.attributes.push((attribute, value.into()));
    }

    /// Length of a dimension; of the record dimension, the most records that a variable has.
    pub fn dimension(&self, name: &str) -> usize {
        let len = self.dimensions.iter().find(|(n, _)| *n == name).unwrap().1;
        if len > 0 {
            return len;
        }
        let variables = self.variables.iter().filter(|variable| variable.dimensions.first() == Some(&name));
        let records =
            variables.map(|v| v.values.len() / v.dimensions[1..].iter().map(|d| self.dimension(d)).product::<usize>());
        records.max().unwrap_or(0)
    }
}

/// Depth of each layer's bottom where the ocean is deep enough.
pub const DEPTH_M: [f64; LAYERS] = [10.0, 30.0, 100.0, 500.0];

/// How many layers a cell has: all, or fewer where the sea is shallow, or none.
pub fn levels(cell: usize) -> usize {
    match cell {
        7 => 0,
        cell if cell % 5 == 0 => 2,
        _ => LAYERS,
    }
}

impl Made {
    /// A history of temperature, salinity at interfaces and vorticity at corners; below the sea floor all hold -1e34,
    /// which no attribute declares. The shallow cells' last layer is 1 m thinner.
    pub fn ocean() -> Self {
        let mut made = Made::history();
        made.remove("zgrid");
        let cells = made.dimension("nCells");
        for name in ["theta", "rho", "w", "vorticity"] {
            let variable = made.variable(name);
            variable.attributes.clear();
            let row = if name == "w" { LAYERS + 1 } else { LAYERS };
            let is_dry = |i: usize| {
                let (cell, layer) = (i / row % cells, i % row);
                name != "vorticity" && (levels(cell) == 0 || layer >= levels(cell) + usize::from(name == "w"))
            };
            match &mut variable.values {
                Values::F32(v) => (0..v.len()).filter(|&i| is_dry(i)).for_each(|i| v[i] = -1e34),
                Values::F64(v) => (0..v.len()).filter(|&i| is_dry(i)).for_each(|i| v[i] = -1e34),
                _ => panic!("{name} is real"),
            }
        }
        made.add("maxLevelCell", &["nCells"], Values::I32((0..cells).map(|c| levels(c) as i32).collect()));
        made
    }

    pub fn with_thickness(mut self, name: &'static str, dimensions: &[&'static str]) -> Self {
        let cells = self.dimension("nCells");
        let thickness = |cell: usize, layer: usize| {
            let full = DEPTH_M[layer] - if layer == 0 { 0.0 } else { DEPTH_M[layer - 1] };
            let is_last = levels(cell) < LAYERS && layer + 1 == levels(cell);
            if layer >= levels(cell) { -1e34 } else { full - f64::from(u8::from(is_last)) }
        };
        let one = (0..cells).flat_map(|c| (0..LAYERS).map(move |l| thickness(c, l)));
        let records = if dimensions.len() == 3 { RECORDS } else { 1 };
        let all: Vec<f64> = std::iter::repeat_n(one.collect::<Vec<_>>(), records).flatten().collect();
        self.add(name, dimensions, Values::F64(all));
        let depth = (0..cells).map(|cell| (0..levels(cell)).map(|layer| thickness(cell, layer)).sum());
        self.add("bottomDepth", &["nCells"], Values::F64(depth.collect()));
        self
    }
}
