//! Columns of points and elements, found by following the vertical edges of prisms.
//!
//! A vertical edge joins a point with the one above it in the same column, whatever the order of points and elements is
//! and however thin layers are: nothing is rounded. Which end of a column is inner is seen from the radii of its ends.

use crate::blueprint::bad;
use crate::elements::Elements;
use icoray::Result;
use std::collections::HashMap;

const NONE: u32 = u32::MAX;

/// The columns of a mesh of prisms on a sphere.
#[derive(Debug, Default)]
pub struct Columns {
    /// Number of points in a column; one more than elements.
    pub levels: usize,
    /// The points of each column from the innermost outwards, column by column, in the order of their innermost points.
    pub points: Vec<u32>,
    /// The columns of points around each column of elements.
    pub polygons: Vec<Vec<u32>>,
    /// The elements of each of these from the innermost outwards, in the order of their innermost elements.
    pub elements: Vec<u32>,
}

impl Columns {
    /// Finds the columns; `place` gives the place of a point.
    ///
    /// # Errors
    /// [`icoray::ErrorKind::Grid`] names point or element where elements are not in columns of one length.
    pub fn find(elements: &Elements, place: impl Fn(u32) -> [f64; 3]) -> Result<Self> {
        let links = Links::of(elements, &place)?;
        let (levels, points) = links.chains(&place)?;
        let (polygons, of_polygons) = stacks(elements, &place, levels, &points)?;
        Ok(Columns { levels, points, polygons, elements: of_polygons })
    }
}

/// The one or two points that vertical edges join each point with.
struct Links(Vec<[u32; 2]>);

impl Links {
    fn of(elements: &Elements, place: &impl Fn(u32) -> [f64; 3]) -> Result<Self> {
        let mut links = Links(vec![[NONE; 2]; elements.points()]);
        for element in 0..elements.len() {
            for [a, b] in elements.vertical_edges(element, place)? {
                if a == b {
                    return Err(bad(format!("element {element} has point {a} twice, one above the other")));
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
                return Err(bad(format!(
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
    fn chains(&self, place: &impl Fn(u32) -> [f64; 3]) -> Result<(usize, Vec<u32>)> {
        let mut is_seen = vec![false; self.0.len()];
        let mut chains: Vec<Vec<u32>> = Vec::new();
        for end in (0..self.0.len()).filter(|&point| self.is_end(point)) {
            if is_seen[end] {
                continue;
            }
            let (mut chain, mut last) = (vec![end as u32], NONE);
            while let Some(next) = self.0[chain[chain.len() - 1] as usize].into_iter().find(|p| *p != NONE && *p != last) {
                last = chain[chain.len() - 1];
                chain.push(next);
            }
            chain.iter().for_each(|point| is_seen[*point as usize] = true);
            let [first, last] = [chain[0], chain[chain.len() - 1]].map(|point| radius(place(point)));
            if first == last {
                return Err(bad(format!("the column of point {end} has no height: its ends are at radius {first}")));
            }
            if first > last {
                chain.reverse();
            }
            if let Some(other) = chains.first().filter(|other| other.len() != chain.len()) {
                return Err(bad(format!(
                    "the column of point {end} has {} points, that of point {} has {}; expected as many in all columns",
                    chain.len(),
                    other[0],
                    other.len()
                )));
            }
            chains.push(chain);
        }
        let left = (0..self.0.len()).find(|&point| self.0[point][0] != NONE && !is_seen[point]);
        if let Some(point) = left {
            return Err(bad(format!("the vertical edges of point {point} form a ring")));
        }
        chains.sort_unstable_by_key(|chain| chain[0]);
        let levels = chains.first().map_or(0, Vec::len);
        Ok((levels, chains.concat()))
    }
}

/// Columns of elements: the columns of points around each, and the elements from the innermost outwards.
fn stacks(
    elements: &Elements,
    place: &impl Fn(u32) -> [f64; 3],
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
            return Err(bad(format!(
                "element {element} is in level {} at point {} and in level {} at point {}",
                one.1, one.0, other.1, other.0
            )));
        }
        let polygon: Vec<u32> = edges.iter().map(|[a, _]| at[*a as usize].0).collect();
        let mut key = polygon.clone();
        key.sort_unstable();
        let stack = *known.entry(key).or_insert_with(|| {
            polygons.push(polygon);
            stacks.push(vec![NONE; layers]);
            stacks.len() - 1
        });
        let place = &mut stacks[stack][lower[0] as usize];
        if *place != NONE {
            return Err(bad(format!("elements {} and {element} are in the same place", *place)));
        }
        *place = element as u32;
    }
    for stack in &stacks {
        if let Some(level) = stack.iter().position(|element| *element == NONE) {
            let other = stack.iter().find(|element| **element != NONE).unwrap_or(&NONE);
            return Err(bad(format!("the column of element {other} has no element in level {level}")));
        }
    }
    let mut order: Vec<usize> = (0..stacks.len()).collect();
    order.sort_unstable_by_key(|&stack| stacks[stack][0]);
    let polygons = order.iter().map(|&stack| std::mem::take(&mut polygons[stack])).collect();
    Ok((polygons, order.iter().flat_map(|&stack| stacks[stack].iter().copied()).collect()))
}

/// The distance of a place from the origin.
pub fn radius(place: [f64; 3]) -> f64 {
    place.iter().map(|x| x * x).sum::<f64>().sqrt()
}
