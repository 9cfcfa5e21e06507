//! Elements of a topology: prisms, as pairs of points, one above the other; polygons on a sphere; single points.

use crate::conduit::{Array, Node};
use glam::DVec3;
use icoray::{Error, Result};
use xxhash_rust::xxh3::Xxh3;

/// The elements of a topology. Their points are below `points`.
pub enum Elements<'a> {
    /// Elements of one shape. Without a connectivity they are the points.
    Uniform { shape: &'static Shape, connectivity: Option<Array<'a>>, points: usize },
    /// Faces each, and the points of each face.
    Polyhedra { faces: Box<Lists<'a>>, face_points: Box<Lists<'a>>, points: usize },
}

/// A shape of elements that have as many points each.
pub struct Shape {
    name: &'static str,
    /// Number of points of a cap.
    sides: usize,
    /// Number of caps: 2 of prisms, whose points are in the same order in both, and 1 of elements on a sphere.
    caps: usize,
}

const SHAPES: [Shape; 5] = [
    Shape { name: "wedge", sides: 3, caps: 2 },
    Shape { name: "hex", sides: 4, caps: 2 },
    Shape { name: "tri", sides: 3, caps: 1 },
    Shape { name: "quad", sides: 4, caps: 1 },
    POINT,
];
const POINT: Shape = Shape { name: "point", sides: 1, caps: 1 };

/// Places of the points of a hexahedron: the edges along each of its three axes, in order around it.
const EDGES_OF_HEXAHEDRON: [[[usize; 2]; 4]; 3] =
    [[[0, 4], [1, 5], [2, 6], [3, 7]], [[0, 1], [3, 2], [7, 6], [4, 5]], [[0, 3], [1, 2], [5, 6], [4, 7]]];

/// Lists of numbers, one behind the other or at offsets.
pub struct Lists<'a> {
    what: &'static str,
    numbers: Array<'a>,
    sizes: Array<'a>,
    offsets: Option<Array<'a>>,
    /// Where offsets are missing: the sums of sizes.
    sums: Vec<i64>,
    /// Numbers are below this.
    end: usize,
}

impl<'a> Elements<'a> {
    /// The elements of a topology's node over so many points.
    pub fn of(topology: Node<'a>, points: usize) -> Result<Self> {
        let elements = topology.at("elements").ok_or_else(|| Error::grid("no elements"))?;
        let name = elements.text_at("shape").unwrap_or_default();
        if name == "polyhedral" {
            let faces = topology.at("subelements").ok_or_else(|| Error::grid("no subelements"))?;
            let face_points = Lists::of(faces, "subelements/connectivity", points)?;
            let faces = Lists::of(elements, "elements/connectivity", face_points.len())?;
            return Ok(Elements::Polyhedra { faces: Box::new(faces), face_points: Box::new(face_points), points });
        }
        let shape = Shape::named(&name).ok_or_else(|| {
            let known: Vec<_> = SHAPES.iter().map(|shape| format!("{:?}", shape.name)).collect();
            Error::grid(format!(
                "elements of shape {name:?}, expected \"polyhedral\" (prisms) or one of {}",
                known.join(", ")
            ))
        })?;
        let connectivity = integers(elements, "elements/connectivity", "connectivity")?;
        if !connectivity.len().is_multiple_of(shape.points()) {
            let [found, expected] = [connectivity.len(), shape.points()];
            let what = format!("elements/connectivity has {found} numbers, expected {expected} per {name}");
            return Err(Error::grid(what));
        }
        Ok(Elements::Uniform { shape, connectivity: Some(connectivity), points })
    }

    /// All points of a topology.
    pub fn of_points(points: usize) -> Self {
        Elements::Uniform { shape: &POINT, connectivity: None, points }
    }

    pub fn len(&self) -> usize {
        match self {
            Elements::Uniform { shape, connectivity: Some(all), .. } => all.len() / shape.points(),
            Elements::Uniform { points, .. } => *points,
            Elements::Polyhedra { faces, .. } => faces.len(),
        }
    }

    /// Number of points that elements may have.
    pub fn points(&self) -> usize {
        match self {
            Elements::Uniform { points, .. } | Elements::Polyhedra { points, .. } => *points,
        }
    }

    /// Number of points of each element on a sphere, 1 if elements are points; `None` for prisms.
    pub fn points_on_sphere(&self) -> Option<usize> {
        match self {
            Elements::Uniform { shape, .. } if shape.caps == 1 => Some(shape.sides),
            _ => None,
        }
    }

    /// The points of an element, or the faces of a polyhedron, in their order. Fails for numbers out of range.
    pub fn numbers_of(&self, element: usize) -> Result<Vec<u32>> {
        match self {
            Elements::Uniform { shape, connectivity, points } => {
                let number = |k: usize| connectivity.map_or(k as i64, |all| all.integer(k));
                let places = shape.points() * element..shape.points() * (element + 1);
                places.map(|k| point(number(k), *points, element)).collect()
            }
            Elements::Polyhedra { faces, .. } => faces.list(element),
        }
    }

    /// The vertical edges of a prism, in order around it. `place` gives the place of a point.
    pub fn vertical_edges(&self, element: usize, place: impl Fn(u32) -> DVec3) -> Result<Vec<[u32; 2]>> {
        let numbers = self.numbers_of(element)?;
        match self {
            Elements::Uniform { shape: Shape { sides: 4, .. }, .. } => {
                let edges = EDGES_OF_HEXAHEDRON.map(|edges| edges.map(|edge| edge.map(|k| numbers[k])).to_vec());
                Ok(most_upright(edges, place).unwrap_or_default())
            }
            Elements::Uniform { shape: Shape { sides, .. }, .. } => {
                Ok((0..*sides).map(|k| [numbers[k], numbers[k + sides]]).collect())
            }
            Elements::Polyhedra { face_points, .. } => {
                let faces = numbers.into_iter().map(|face| face_points.list(face as usize));
                let faces = faces.collect::<Result<Vec<_>>>()?;
                prism(&faces, place).ok_or_else(|| {
                    let sizes: Vec<_> = faces.iter().map(|face| face.len().to_string()).collect();
                    Error::grid(format!("element {element} is no prism: its faces have {} points", sizes.join(", ")))
                })
            }
        }
    }

    /// Adds all numbers to a fingerprint.
    pub fn hash(&self, to: &mut Xxh3) {
        match self {
            Elements::Uniform { shape, connectivity, .. } => {
                to.update(shape.name.as_bytes());
                connectivity.iter().for_each(|all| all.hash(to));
            }
            Elements::Polyhedra { faces, face_points, .. } => {
                for lists in [faces, face_points] {
                    lists.numbers.hash(to);
                    lists.sizes.hash(to);
                    lists.offsets.iter().for_each(|offsets| offsets.hash(to));
                }
            }
        }
    }
}

impl Shape {
    /// The shape that Blueprint calls so.
    pub fn named(name: &str) -> Option<&'static Self> {
        SHAPES.iter().find(|shape| shape.name == name)
    }

    fn points(&self) -> usize {
        self.sides * self.caps
    }
}

impl<'a> Lists<'a> {
    fn of(node: Node<'a>, what: &'static str, end: usize) -> Result<Self> {
        let numbers = integers(node, what, "connectivity")?;
        let sizes = integers(node, what, "sizes")?;
        let offsets = node.at("offsets").and_then(Node::array).filter(|offsets| !offsets.is_empty());
        if let Some(offsets) = offsets.filter(|offsets| offsets.len() != sizes.len()) {
            return Err(Error::grid(format!("{what}: {} offsets for {} sizes", offsets.len(), sizes.len())));
        }
        let sums = if offsets.is_none() { sums(&sizes) } else { Vec::new() };
        Ok(Lists { what, numbers, sizes, offsets, sums, end })
    }

    fn len(&self) -> usize {
        self.sizes.len()
    }

    fn list(&self, i: usize) -> Result<Vec<u32>> {
        let size = self.sizes.integer(i);
        let start = self.offsets.map_or_else(|| self.sums[i], |offsets| offsets.integer(i));
        let all = self.numbers.len() as i64;
        if size < 0 || start < 0 || start.checked_add(size).is_none_or(|end| end > all) {
            let what = format!("{}: list {i} of {size} numbers at {start}, and there are {all}", self.what);
            return Err(Error::grid(what));
        }
        (start..start + size).map(|k| point(self.numbers.integer(k as usize), self.end, i)).collect()
    }
}

/// The sum of all sizes before each.
fn sums(sizes: &Array) -> Vec<i64> {
    let next = |sum: &mut i64, i: usize| {
        let before = *sum;
        *sum = before.saturating_add(sizes.integer(i).max(0));
        Some(before)
    };
    (0..sizes.len()).scan(0, next).collect()
}

/// An array of integers of a node, of any type if it is empty.
fn integers<'a>(node: Node<'a>, what: &str, name: &str) -> Result<Array<'a>> {
    let found = node.at(name);
    let array = found.and_then(Node::array).filter(|array| array.kind().is_integer() || array.is_empty());
    array.ok_or_else(|| {
        let found = found.map_or_else(|| "nothing".into(), Node::described);
        Error::grid(format!("{what}: {name} is {found}, expected integers"))
    })
}

fn point(number: i64, end: usize, element: usize) -> Result<u32> {
    let fits = usize::try_from(number).is_ok_and(|number| number < end.min(u32::MAX as usize));
    if fits {
        return Ok(number as u32);
    }
    Err(Error::grid(format!("element {element} has {number}, expected 0 to {}", end as i64 - 1)))
}

/// The vertical edges of a prism with these faces, in the order of one of its two caps.
fn prism(faces: &[Vec<u32>], place: impl Fn(u32) -> DVec3) -> Option<Vec<[u32; 2]>> {
    let sides = faces.len().checked_sub(2).filter(|sides| *sides >= 3)?;
    let caps: Vec<usize> = (0..faces.len()).filter(|&i| faces[i].len() == sides).collect();
    let pairs = caps.iter().enumerate().flat_map(|(k, &i)| caps[k + 1..].iter().map(move |&j| (i, j)));
    most_upright(pairs.filter_map(|(i, j)| edges_between(faces, i, j)), place)
}

/// Of edges between two opposite faces, those whose faces are one above the other, seen from the origin: a hexahedron has
/// three pairs of such faces.
fn most_upright(all: impl IntoIterator<Item = Vec<[u32; 2]>>, place: impl Fn(u32) -> DVec3) -> Option<Vec<[u32; 2]>> {
    let apart = |edges: &[[u32; 2]]| {
        let [a, b] = [0, 1].map(|end| edges.iter().map(|edge| place(edge[end])).sum::<DVec3>().normalize());
        a.distance_squared(b)
    };
    all.into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// The edges from each point of face `i` to the one of face `j`, of faces that are all quadrilaterals but these.
fn edges_between(faces: &[Vec<u32>], i: usize, j: usize) -> Option<Vec<[u32; 2]>> {
    let (lower, upper) = (&faces[i], &faces[j]);
    let mut above: Vec<Option<u32>> = vec![None; lower.len()];
    for (_, side) in faces.iter().enumerate().filter(|(k, _)| *k != i && *k != j) {
        if side.len() != 4 {
            return None;
        }
        for at in 0..4 {
            for [from, to] in [[side[at], side[(at + 1) % 4]], [side[(at + 1) % 4], side[at]]] {
                let Some(place) = lower.iter().position(|point| *point == from).filter(|_| upper.contains(&to)) else {
                    continue;
                };
                if above[place].is_some_and(|other| other != to) {
                    return None;
                }
                above[place] = Some(to);
            }
        }
    }
    lower.iter().zip(above).map(|(from, to)| Some([*from, to?])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conduit::NumberType;

    /// A prism over `n` points around the axis z, numbered by `number`, with its faces in `order`.
    fn prism_of(n: u32, number: impl Fn(u32, u32) -> u32) -> Vec<Vec<u32>> {
        let cap = |level| (0..n).map(|k| number(k, level)).collect::<Vec<_>>();
        let side = |k: u32| vec![number(k, 0), number(k, 1), number((k + 1) % n, 1), number((k + 1) % n, 0)];
        [cap(0)].into_iter().chain((0..n).map(side)).chain([cap(1)]).collect()
    }

    #[test]
    fn prisms_of_all_polygons_have_their_vertical_edges() {
        for n in [3, 4, 5, 6, 7] {
            // Levels alternate; over the north pole, flat as cells are.
            let place = |point: u32| {
                let (angle, level) = (f64::from(point / 2) * 0.9, f64::from(point % 2));
                DVec3::new(0.01 * angle.cos(), 0.01 * angle.sin(), 1.0) * (1.0 + 0.001 * level)
            };
            let faces = prism_of(n, |k, level| 2 * k + level);
            let edges = prism(&faces, place).unwrap();
            assert_eq!(edges, (0..n).map(|k| [2 * k, 2 * k + 1]).collect::<Vec<_>>(), "{n}");
        }
    }

    #[test]
    fn sizes_of_any_value_are_added() {
        let sizes = [2, -1, 3, i64::MAX, i64::MAX, 1];
        // SAFETY: the numbers of the array.
        let array = unsafe { Array::new(sizes.as_ptr().cast(), NumberType::I64, sizes.len(), 8) };
        assert_eq!(sums(&array), [0, 2, 2, 5, i64::MAX, i64::MAX]);
    }

    #[test]
    fn other_polyhedra_are_no_prisms() {
        let place = |_| DVec3::Z;
        assert_eq!(prism(&[vec![0, 1, 2], vec![0, 1, 3], vec![1, 2, 3], vec![0, 2, 3]], place), None);
        // A pyramid over a hexagon.
        let sides = (0..6).map(|k| vec![k, (k + 1) % 6, 6]);
        let faces: Vec<_> = sides.chain([(0..6).collect()]).collect();
        assert_eq!(prism(&faces, place), None);
        // Two caps that share points.
        let mut faces = prism_of(5, |k, level| 2 * k + level);
        faces[6] = faces[0].clone();
        assert_eq!(prism(&faces, place), None);
        assert_eq!(prism(&[], place), None);
    }
}
