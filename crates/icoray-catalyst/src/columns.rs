//! Columns of points and elements, found by following the vertical edges of prisms, or by the directions of points.
//!
//! A vertical edge joins a point with the one above it in the same column, for any order of points and elements and for
//! layers of any thickness: nothing is rounded. The radii of a column's ends determine which of them is the inner one.
//! Points without edges are in one column if they have the same direction from the origin.

use crate::elements::Elements;
use glam::DVec3;
use icoray::{Error, Result};
use icoray_dataset::DistinctPoints;
use std::collections::HashMap;

const NONE: u32 = u32::MAX;

/// Points that are no farther apart, as seen from the origin, are in one column, radians: hosts have places in 32 bits.
const SAME: f64 = 1e-6;

/// The columns of a mesh on a sphere.
#[derive(Debug, Default)]
pub struct Columns {
    /// Number of points in a column.
    pub levels: usize,
    /// Number of elements in a column: one less for prisms, and as many for elements on a sphere and for points.
    pub layers: usize,
    /// The points of each column from the innermost outwards, column by column, in the order of their innermost points.
    pub points: Vec<u32>,
    /// The columns of points around each column of elements; none if elements are points.
    pub polygons: Vec<Vec<u32>>,
    /// The elements of each of these from the innermost outwards, in the order of their innermost elements.
    pub elements: Vec<u32>,
}

impl Columns {
    /// Finds the columns, all of one length; `place` gives the place of a point.
    pub fn find(elements: &Elements, place: impl Fn(u32) -> DVec3) -> Result<Self> {
        if elements.len() >= NONE as usize {
            return Err(Error::grid(format!("{} elements on one rank, expected fewer than {NONE}", elements.len())));
        }
        match elements.points_on_sphere() {
            Some(1) => Self::of_points(elements, place),
            Some(_) => Self::on_sphere(elements),
            None => {
                let (levels, points) = Links::of(elements, &place)?.chains(&place)?;
                let (polygons, of_polygons) = stacks(elements, &place, levels, &points)?;
                Ok(Columns { levels, layers: levels.saturating_sub(1), points, polygons, elements: of_polygons })
            }
        }
    }

    /// The columns of elements that are points.
    fn of_points(elements: &Elements, place: impl Fn(u32) -> DVec3) -> Result<Self> {
        let (mut directions, mut columns) = (DistinctPoints::new(SAME), Vec::<Vec<PointElement>>::new());
        for element in 0..elements.len() {
            let point = elements.numbers_of(element)?[0];
            let (DVec3 { x, y, z }, radius) = (place(point), place(point).length());
            if !(radius > 0.0 && radius.is_finite()) {
                return Err(Error::grid(format!(
                    "point {point} at ({x}, {y}, {z}), expected a place around the origin"
                )));
            }
            let column = directions.find_or_add([x, y, z].map(|x| x / radius));
            columns.resize_with(columns.len().max(column + 1), Vec::new);
            columns[column].push(PointElement { radius, point, element: element as u32 });
        }
        for column in &mut columns {
            column.sort_by(|a, b| a.radius.total_cmp(&b.radius));
            if let Some(pair) = column.windows(2).find(|pair| pair[0].radius == pair[1].radius) {
                let [a, b] = [0, 1].map(|k| pair[k].point);
                return Err(Error::grid(format!("points {a} and {b} are in one place, expected each once")));
            }
        }
        columns.sort_unstable_by_key(|column| column[0].point);
        let of = |number: fn(&PointElement) -> u32| -> Vec<Vec<u32>> {
            columns.iter().map(|column| column.iter().map(number).collect()).collect()
        };
        let points = of(|element| element.point);
        let levels = common_length(&points)
            .map_err(|e| e.within(format_args!("points of one direction from the origin, within {SAME} radians")))?;
        let elements = of(|element| element.element).concat();
        Ok(Columns { levels, layers: levels, points: points.concat(), polygons: Vec::new(), elements })
    }

    /// The columns of polygons on a sphere: of one point and one element each.
    fn on_sphere(elements: &Elements) -> Result<Self> {
        let polygon = |element| polygon_of(element, elements.numbers_of(element)?.into_iter());
        let mut polygons = (0..elements.len()).map(polygon).collect::<Result<Vec<_>>>()?;
        let mut points = polygons.concat();
        points.sort_unstable();
        points.dedup();
        let mut column_of = vec![NONE; elements.points()];
        points.iter().enumerate().for_each(|(column, point)| column_of[*point as usize] = column as u32);
        polygons.iter_mut().flatten().for_each(|point| *point = column_of[*point as usize]);
        let elements = (0..elements.len() as u32).collect();
        Ok(Columns { levels: usize::from(!points.is_empty()), layers: 1, points, polygons, elements })
    }
}

/// An element that is a point.
struct PointElement {
    radius: f64,
    point: u32,
    element: u32,
}

/// The number of points of all columns.
fn common_length(columns: &[Vec<u32>]) -> Result<usize> {
    let Some(first) = columns.first() else { return Ok(0) };
    match columns.iter().find(|column| column.len() != first.len()) {
        None => Ok(first.len()),
        Some(other) => Err(Error::grid(format!(
            "the column of point {} has {} points, that of point {} has {}; expected as many in all columns",
            other[0],
            other.len(),
            first[0],
            first.len()
        ))),
    }
}

/// The one or two points that vertical edges join each point with.
struct Links(Vec<[u32; 2]>);

impl Links {
    fn of(elements: &Elements, place: &impl Fn(u32) -> DVec3) -> Result<Self> {
        let mut links = Links(vec![[NONE; 2]; elements.points()]);
        for element in 0..elements.len() {
            for [a, b] in elements.vertical_edges(element, place)? {
                if a == b {
                    return Err(Error::grid(format!("element {element} has point {a} twice, one above the other")));
                }
                links.join(a, b)?;
                links.join(b, a)?;
            }
        }
        Ok(links)
    }

    fn join(&mut self, from: u32, to: u32) -> Result<()> {
        let places = &mut self.0[from as usize];
        if places.contains(&to) {
            return Ok(());
        }
        match places.iter_mut().find(|place| **place == NONE) {
            Some(place) => *place = to,
            None => {
                let [a, b] = *places;
                return Err(Error::grid(format!(
                    "point {from} has vertical edges to the points {a}, {b} and {to}: elements are in no columns"
                )));
            }
        }
        Ok(())
    }

    fn is_end(&self, point: usize) -> bool {
        self.0[point][0] != NONE && self.0[point][1] == NONE
    }

    /// The number of points in a column, and the points of all columns, each from the innermost outwards.
    fn chains(&self, place: &impl Fn(u32) -> DVec3) -> Result<(usize, Vec<u32>)> {
        let mut is_seen = vec![false; self.0.len()];
        let mut chains: Vec<Vec<u32>> = Vec::new();
        for end in (0..self.0.len()).filter(|&point| self.is_end(point)) {
            if is_seen[end] {
                continue;
            }
            let (mut chain, mut last) = (vec![end as u32], NONE);
            while let Some(next) =
                self.0[chain[chain.len() - 1] as usize].into_iter().find(|p| *p != NONE && *p != last)
            {
                last = chain[chain.len() - 1];
                chain.push(next);
            }
            chain.iter().for_each(|point| is_seen[*point as usize] = true);
            let [first, last] = [chain[0], chain[chain.len() - 1]].map(|point| place(point).length());
            if first == last {
                return Err(Error::grid(format!(
                    "the column of point {end} has no height: its ends are at radius {first}"
                )));
            }
            if first > last {
                chain.reverse();
            }
            chains.push(chain);
        }
        let levels = common_length(&chains)?;
        let left = (0..self.0.len()).find(|&point| self.0[point][0] != NONE && !is_seen[point]);
        if let Some(point) = left {
            return Err(Error::grid(format!("the vertical edges of point {point} form a ring")));
        }
        chains.sort_unstable_by_key(|chain| chain[0]);
        Ok((levels, chains.concat()))
    }
}

/// The corners of an element: a quadrilateral with a point twice, as at the pole of a lat-lon grid, is a triangle.
fn polygon_of(element: usize, corners: impl Iterator<Item = u32>) -> Result<Vec<u32>> {
    let mut polygon: Vec<u32> = corners.collect();
    polygon.dedup();
    if polygon.len() > 1 && polygon.first() == polygon.last() {
        polygon.pop();
    }
    if polygon.len() < 3 {
        return Err(Error::grid(format!(
            "element {element} has {} different corners, expected 3 or more",
            polygon.len()
        )));
    }
    Ok(polygon)
}

/// Columns of elements: the columns of points around each, and the elements from the innermost outwards.
fn stacks(
    elements: &Elements,
    place: &impl Fn(u32) -> DVec3,
    levels: usize,
    points: &[u32],
) -> Result<(Vec<Vec<u32>>, Vec<u32>)> {
    let mut at = vec![(NONE, 0_u32); elements.points()];
    for (i, point) in points.iter().enumerate() {
        at[*point as usize] = ((i / levels) as u32, (i % levels) as u32);
    }
    let layers = levels.saturating_sub(1);
    let mut known: HashMap<Vec<u32>, usize> = HashMap::new();
    let (mut polygons, mut stacks): (Vec<Vec<u32>>, Vec<Vec<u32>>) = (Vec::new(), Vec::new());
    for element in 0..elements.len() {
        let edges = elements.vertical_edges(element, place)?;
        let lower = edges.iter().map(|[a, b]| at[*a as usize].1.min(at[*b as usize].1)).collect::<Vec<_>>();
        if let Some(other) = lower.iter().position(|level| *level != lower[0]) {
            let [one, other] = [0, other].map(|k| (edges[k][0], lower[k]));
            return Err(Error::grid(format!(
                "element {element} is in level {} at point {} and in level {} at point {}",
                one.1, one.0, other.1, other.0
            )));
        }
        let polygon = polygon_of(element, edges.iter().map(|[a, _]| at[*a as usize].0))?;
        let mut key = polygon.clone();
        key.sort_unstable();
        let stack = *known.entry(key).or_insert_with(|| {
            polygons.push(polygon);
            stacks.push(vec![NONE; layers]);
            stacks.len() - 1
        });
        let place = &mut stacks[stack][lower[0] as usize];
        if *place != NONE {
            return Err(Error::grid(format!("elements {} and {element} are in the same place", *place)));
        }
        *place = element as u32;
    }
    for stack in &stacks {
        if let Some(level) = stack.iter().position(|element| *element == NONE) {
            let other = stack.iter().find(|element| **element != NONE).unwrap_or(&NONE);
            return Err(Error::grid(format!("the column of element {other} has no element in level {level}")));
        }
    }
    let mut order: Vec<usize> = (0..stacks.len()).collect();
    order.sort_unstable_by_key(|&stack| stacks[stack][0]);
    let polygons = order.iter().map(|&stack| std::mem::take(&mut polygons[stack])).collect();
    Ok((polygons, order.iter().flat_map(|&stack| stacks[stack].iter().copied()).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conduit::{Array, NumberType};
    use crate::elements::Shape;
    use icoray::IcosahedralMesh;

    /// The wedges of layers over the triangles of an icosahedral mesh, whose points and elements are numbered so.
    fn wedges(
        mesh: &IcosahedralMesh,
        layers: u64,
        point: impl Fn(u64) -> u64,
        element: impl Fn(u64) -> u64,
    ) -> Vec<i64> {
        let triangles = mesh.corner_cell.len() as u64 / 3;
        let mut table = vec![0; (6 * triangles * layers) as usize];
        for i in 0..triangles * layers {
            let (triangle, layer, at) = (i / layers, i % layers, element(i));
            for k in 0..6 {
                // Every third one is upside down and turned.
                let turn = u64::from(at % 3 == 1);
                let cell = mesh.corner_cell[(3 * triangle + (k + turn) % 3) as usize] as u64;
                let level = layer + (u64::from(k >= 3) ^ turn);
                table[(6 * at + k) as usize] = point(cell * (layers + 1) + level) as i64;
            }
        }
        table
    }

    fn elements(table: &[i64], points: usize) -> Elements<'_> {
        elements_of("wedge", table, points)
    }

    fn elements_of<'a>(shape: &str, table: &'a [i64], points: usize) -> Elements<'a> {
        // SAFETY: the numbers of the slice.
        let connectivity = unsafe { Array::new(table.as_ptr().cast(), NumberType::I64, table.len(), 8) };
        Elements::Uniform { shape: Shape::named(shape).unwrap(), connectivity: Some(connectivity), points }
    }

    /// A step through all numbers below `count`, in no order.
    fn shuffle(i: u64, count: u64) -> u64 {
        (i * 7919 + 13) % count
    }

    #[test]
    fn columns_of_shuffled_wedges_are_found() {
        let (mesh, layers) = (IcosahedralMesh::new(5).unwrap(), 20);
        let points = mesh.cells() as u64 * (layers + 1);
        let count = mesh.corner_cell.len() as u64 / 3 * layers;
        let table = wedges(&mesh, layers, |i| shuffle(i, points), |i| shuffle(i, count));
        // The number of a point before it was shuffled, by the inverse of the step.
        let mut before = vec![0; points as usize];
        (0..points).for_each(|i| before[shuffle(i, points) as usize] = i);
        // Layers as thin as rounding allows.
        let place = |point: u32| DVec3::new(0.0, 0.0, 1.0 + (before[point as usize] % (layers + 1)) as f64 * 1e-15);
        let found = Columns::find(&elements(&table, points as usize), place).unwrap();
        assert_eq!((found.levels, found.points.len() as u64), (layers as usize + 1, points));
        let cells: Vec<u64> = found
            .points
            .chunks_exact(found.levels)
            .map(|column| {
                let cell = before[column[0] as usize] / (layers + 1);
                let is_whole = (0..=layers).all(|l| before[column[l as usize] as usize] == cell * (layers + 1) + l);
                assert!(is_whole, "the column of cell {cell}");
                cell
            })
            .collect();
        let mut element_before = vec![0; count as usize];
        (0..count).for_each(|i| element_before[shuffle(i, count) as usize] = i);
        assert_eq!(found.polygons.len() * 3, mesh.corner_cell.len());
        for (stack, polygon) in found.elements.chunks_exact(layers as usize).zip(&found.polygons) {
            let triangle = element_before[stack[0] as usize] / layers;
            assert!((0..layers).all(|l| element_before[stack[l as usize] as usize] == triangle * layers + l));
            let mut corners: Vec<u64> = polygon.iter().map(|column| cells[*column as usize]).collect();
            let mut expected: Vec<u64> = (0..3).map(|k| mesh.corner_cell[(3 * triangle + k) as usize] as u64).collect();
            corners.sort_unstable();
            expected.sort_unstable();
            assert_eq!(corners, expected);
        }
    }

    #[test]
    fn more_elements_than_numbers_are_refused() {
        // All numbers are the same one.
        // SAFETY: a number, at no distance from itself.
        let connectivity = unsafe { Array::new([0_i64].as_ptr().cast(), NumberType::I64, 6 << 32, 0) };
        let wedge = Shape::named("wedge").unwrap();
        let elements = Elements::Uniform { shape: wedge, connectivity: Some(connectivity), points: 6 };
        let error = Columns::find(&elements, |_| DVec3::ZERO).unwrap_err().to_string();
        assert!(error.contains("4294967296 elements on one rank, expected fewer than 4294967295"), "{error}");
    }

    #[test]
    fn hexahedra_stand_in_columns_along_any_of_their_axes() {
        // Thin ones: points 0 to 3 in order around the axis z, and the same twice above.
        let place = |point: u32| {
            let [x, y] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][point as usize % 4];
            DVec3::new(0.01 * x, 0.01 * y, 1.0) * (1.0 + 1e-5 * f64::from(point / 4))
        };
        for lower in [[0, 1, 2, 3, 4, 5, 6, 7], [0, 4, 5, 1, 3, 7, 6, 2], [1, 2, 6, 5, 0, 3, 7, 4]] {
            let table = [[4, 5, 6, 7, 8, 9, 10, 11], lower].concat();
            let found = Columns::find(&elements_of("hex", &table, 12), place).unwrap();
            assert_eq!((found.levels, found.layers, &found.elements[..]), (3, 2, &[1, 0][..]));
            assert_eq!(found.points, [0, 4, 8, 1, 5, 9, 2, 6, 10, 3, 7, 11]);
            assert_eq!(found.polygons, [[0, 1, 2, 3]]);
        }
    }

    #[test]
    fn points_of_one_direction_are_a_column() {
        // Three columns from the top, in which places are rounded.
        let place = |point: u32| {
            let at = [DVec3::X, DVec3::Y, DVec3::Z][point as usize % 3] + f64::from(point / 3) * 1e-7;
            at.normalize() * (7.0 - f64::from(point / 3))
        };
        let found = Columns::find(&Elements::of_points(12), place).unwrap();
        assert_eq!((found.levels, found.layers, found.polygons.len()), (4, 4, 0));
        assert_eq!(found.points, [9, 6, 3, 0, 10, 7, 4, 1, 11, 8, 5, 2]);
        let found = Columns::find(&elements_of("point", &[4, 2, 1, 5], 12), place).unwrap();
        assert_eq!((found.levels, &found.points[..], &found.elements[..]), (2, &[4, 1, 5, 2][..], &[0, 2, 3, 1][..]));
        let refused = |points: usize, place: &dyn Fn(u32) -> DVec3| {
            Columns::find(&Elements::of_points(points), place).unwrap_err().to_string()
        };
        let message = refused(11, &place);
        assert!(message.contains("the column of point 9 has 4 points, that of point 8 has 3"), "{message}");
        assert!(message.contains("one direction from the origin, within 0.000001 radians"), "{message}");
        let message = refused(12, &|point| place(point.min(10)));
        assert!(message.contains("points 10 and 11 are in one place, expected each once"), "{message}");
        let message = refused(3, &|point| DVec3::new(f64::NAN, 0.0, f64::from(point)));
        assert!(message.contains("point 0 at (NaN, 0, 0), expected a place around the origin"), "{message}");
    }

    #[test]
    fn elements_on_a_sphere_are_columns_of_one() {
        // The last one is a triangle at a pole.
        let found = |quads: &[i64]| Columns::find(&elements_of("quad", quads, 8), |_| DVec3::X);
        let columns = found(&[1, 2, 4, 3, 3, 4, 6, 5, 5, 6, 7, 7]).unwrap();
        assert_eq!((columns.levels, columns.layers, &columns.elements[..]), (1, 1, &[0, 1, 2][..]));
        assert_eq!(columns.points, [1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(columns.polygons, [&[0, 1, 3, 2][..], &[2, 3, 5, 4], &[4, 5, 6]]);
        let message = found(&[1, 2, 4, 3, 5, 6, 6, 5]).unwrap_err().to_string();
        assert!(message.contains("element 1 has 2 different corners, expected 3 or more"), "{message}");
        assert_eq!(Columns::find(&elements_of("tri", &[], 7), |_| DVec3::X).unwrap().levels, 0);
    }

    #[test]
    fn elements_without_columns_are_refused() {
        let place = |point: u32| DVec3::new(0.0, 0.0, 1.0 + f64::from(point / 4));
        let refused = |table: &[i64], points| Columns::find(&elements(table, points), place).unwrap_err().to_string();
        let contains = |message: String, part: &str| assert!(message.contains(part), "{message}");
        // Two wedges beside each other, then each of its faults.
        let good = [0, 1, 2, 4, 5, 6, 1, 3, 2, 5, 7, 6];
        assert_eq!(Columns::find(&elements(&good, 8), place).unwrap().polygons, [[0, 1, 2], [1, 3, 2]]);
        contains(refused(&[0, 1, 2, 4, 5, 9], 8), "element 0 has 9, expected 0 to 7");
        contains(refused(&[0, 1, 2, 4, 5, 2], 8), "element 0 has point 2 twice");
        contains(
            refused(&[0, 1, 2, 4, 5, 6, 0, 1, 2, 8, 5, 6, 0, 1, 2, 9, 5, 6], 10),
            "point 0 has vertical edges to the points 4, 8 and 9",
        );
        contains(refused(&[0, 1, 2, 4, 5, 6, 4, 5, 6, 0, 9, 10], 12), "expected as many in all columns");
        contains(refused(&[0, 1, 2, 4, 5, 6, 2, 1, 0, 6, 5, 4], 8), "elements 0 and 1 are in the same place");
        contains(
            refused(&[0, 1, 2, 4, 5, 6, 4, 5, 6, 8, 9, 10, 4, 1, 3, 8, 5, 7], 12),
            "expected as many in all columns",
        );
        let flat = |_: u32| DVec3::Z;
        contains(Columns::find(&elements(&good, 8), flat).unwrap_err().to_string(), "has no height");
    }
}
