//! Invariants at every moment: faces that refer to each other, wound one way by exact signs, around all of the centre.

use super::*;
use icoray_test_support::Random;

fn assert_sound(triangulation: &ConstrainedDelaunay) {
    assert_eq!(triangulation.faces.len(), 2 * triangulation.vertices() - 4);
    for (f, face) in (0u32..).zip(&triangulation.faces) {
        let [a, b, c] = face.vertices;
        assert!(triangulation.side(a, b, triangulation.at(c)) > 0.0, "{f}: {face:?} is turned round or flat");
        for k in 0..3 {
            let other = triangulation.faces[face.beyond[k] as usize];
            let j = triangulation.place_of(face.beyond[k], f);
            let ends = [other.vertices[turn(j, 2)], other.vertices[turn(j, 1)]];
            assert_eq!(ends, [face.vertices[turn(k, 1)], face.vertices[turn(k, 2)]], "{f}, {k}");
        }
    }
    for v in 0..triangulation.vertices() as u32 {
        assert!(triangulation.ring(v).count() >= 3, "{v}");
    }
}

fn plain() -> ConstrainedDelaunay {
    ConstrainedDelaunay::new(1, DMat3::IDENTITY).unwrap()
}

#[test]
fn points_anywhere_are_worked_in() {
    let mut triangulation = plain();
    let mut random = Random::new(3);
    for _ in 0..400 {
        // Far from each other, and in clusters as fine as a rounding.
        let center = DVec3::from_array(random.direction());
        triangulation.insert(center).unwrap();
        for part in [1e-3, 1e-9, 1e-14] {
            let _ = triangulation.insert((center + part * DVec3::from_array(random.direction())).normalize());
        }
    }
    assert_sound(&triangulation);
}

#[test]
fn points_on_sides_split_them_and_points_on_vertices_clash() {
    let mut triangulation = plain();
    // Binary fractions, so that the middle is exact; near each other, so that a side joins them.
    let ends = [DVec3::new(1.0, 0.25, 0.5), DVec3::new(1.0, 0.25 + 1.0 / 1024.0, 0.5 + 1.0 / 2048.0)];
    let [a, b] = ends.map(|end| triangulation.insert(end).unwrap());
    assert!(triangulation.left_of(a, b).is_some());
    assert_eq!(triangulation.insert(ends[0] * 0.5), Err(ConstraintError::Vertex(a)));
    let middle = triangulation.insert(0.5 * (ends[0] + ends[1])).unwrap();
    assert_sound(&triangulation);
    assert_eq!(triangulation.ring(middle).count(), 4);
    assert!(triangulation.left_of(a, b).is_none() && triangulation.left_of(a, middle).is_some());
    assert_eq!(triangulation.insert_constraint(a, b), Err(ConstraintError::Vertex(middle)));
}

#[test]
fn sides_are_cleared_and_stay() {
    let mut random = Random::new(11);
    let (mut fixed, mut crossing) = (0, 0);
    for _ in 0..40 {
        let mut triangulation = plain();
        let first = triangulation.vertices() as u32;
        for _ in 0..60 {
            triangulation.insert(DVec3::from_array(random.direction())).unwrap();
        }
        let mut sides = Vec::new();
        for _ in 0..40 {
            let mut any = || first + (random.unit() * 60.0) as u32;
            let (a, b) = (any(), any());
            if a == b || triangulation.point(a).dot(triangulation.point(b)) < 0.0 {
                continue;
            }
            match triangulation.insert_constraint(a, b) {
                Ok(()) => sides.push((a, b)),
                Err(ConstraintError::Side(..)) => crossing += 1,
                Err(clash) => panic!("{clash:?}"),
            }
            assert_sound(&triangulation);
            assert!(sides.iter().all(|&(a, b)| triangulation.left_of(a, b).is_some()));
        }
        fixed += sides.len();
    }
    assert!(fixed > 200 && crossing > 200, "{fixed} {crossing}");
}
