//! Elements of a topology as prisms: pairs of points, one above the other.

use crate::conduit::{Array, Node};
use glam::DVec3;
use icoray::{Error, Result};
use xxhash_rust::xxh3::Xxh3;

/// The elements of a topology. Their points are below `points`.
pub enum Elements<'a> {
    /// Six points each: a triangle, and the points above or below its own in the same order.
    Wedges { connectivity: Array<'a>, points: usize },
    /// Faces each, and the points of each face.
    Polyhedra { faces: Box<Lists<'a>>, face_points: Box<Lists<'a>>, points: usize },
}

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
    ///
    /// # Errors
    /// [`icoray::ErrorKind::Grid`] for shapes that are no prisms, and for arrays that are missing or too short.
    pub fn of(topology: Node<'a>, points: usize) -> Result<Self> {
        let elements = topology.at("elements").ok_or_else(|| Error::grid("no elements"))?;
        let shape = elements.text_at("shape").unwrap_or_default();
        match shape.as_str() {
            "wedge" => {
                let connectivity = integers(elements, "elements/connectivity", "connectivity")?;
                if !connectivity.len().is_multiple_of(6) {
                    let what =
                        format!("elements/connectivity has {} numbers, expected 6 per wedge", connectivity.len());
                    return Err(Error::grid(what));
                }
                Ok(Elements::Wedges { connectivity, points })
            }
            "polyhedral" => {
                let faces = topology.at("subelements").ok_or_else(|| Error::grid("no subelements"))?;
                let face_points = Lists::of(faces, "subelements/connectivity", points)?;
                let faces = Lists::of(elements, "elements/connectivity", face_points.len())?;
                Ok(Elements::Polyhedra { faces: Box::new(faces), face_points: Box::new(face_points), points })
            }
            _ => Err(Error::grid(format!(
                "elements of shape {shape:?}, expected \"wedge\" (a triangle of three columns) or \"polyhedral\" (prisms)"
            ))),
        }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Elements::Wedges { connectivity, .. } => connectivity.len() / 6,
            Elements::Polyhedra { faces, .. } => faces.len(),
        }
    }

    /// Number of points that elements may have.
    pub fn points(&self) -> usize {
        match self {
            Elements::Wedges { points, .. } | Elements::Polyhedra { points, .. } => *points,
        }
    }

    /// The vertical edges of an element, in order around it. `place` gives the place of a point.
    ///
    /// # Errors
    /// [`icoray::ErrorKind::Grid`] names the element that is no prism, or a number out of range.
    pub fn vertical_edges(&self, element: usize, place: impl Fn(u32) -> DVec3) -> Result<Vec<[u32; 2]>> {
        match self {
            Elements::Wedges { connectivity, points } => (0..3)
                .map(|k| {
                    let of = |k| point(connectivity.integer(6 * element + k), *points, element);
                    Ok([of(k)?, of(k + 3)?])
                })
                .collect(),
            Elements::Polyhedra { faces, face_points, .. } => {
                let faces = faces.list(element)?.into_iter().map(|face| face_points.list(face as usize));
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
            Elements::Wedges { connectivity, .. } => connectivity.hash(to),
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

/// The vertical edges of a prism with these faces, in the order of one of its two caps. The caps of a hexahedron are the
/// two opposite faces that are one above the other, seen from the origin.
fn prism(faces: &[Vec<u32>], place: impl Fn(u32) -> DVec3) -> Option<Vec<[u32; 2]>> {
    let sides = faces.len().checked_sub(2).filter(|sides| *sides >= 3)?;
    let caps: Vec<usize> = (0..faces.len()).filter(|&i| faces[i].len() == sides).collect();
    let pairs = caps.iter().enumerate().flat_map(|(k, &i)| caps[k + 1..].iter().map(move |&j| (i, j)));
    let mut found: Option<(f64, Vec<[u32; 2]>)> = None;
    for (i, j) in pairs {
        let Some(edges) = edges_between(faces, i, j) else { continue };
        let [a, b] = [i, j].map(|cap| direction(&faces[cap], &place));
        let apart = a.distance_squared(b);
        if found.as_ref().is_none_or(|(nearest, _)| apart < *nearest) {
            found = Some((apart, edges));
        }
    }
    found.map(|(_, edges)| edges)
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

/// The direction of a face from the origin.
fn direction(face: &[u32], place: impl Fn(u32) -> DVec3) -> DVec3 {
    face.iter().map(|point| place(*point)).sum::<DVec3>().normalize()
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
