//! At every moment: faces that know each other, wound one way by exact signs, around all of the centre.

use super::*;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, lon) = (2.0 * self.next() - 1.0, std::f64::consts::TAU * self.next());
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * lon.cos(), r * lon.sin(), z)
    }
}

fn assert_sound(patchwork: &Patchwork) {
    assert_eq!(patchwork.faces.len(), 2 * patchwork.vertices() - 4);
    for (f, face) in (0u32..).zip(&patchwork.faces) {
        let [a, b, c] = face.vertices;
        assert!(patchwork.side(a, b, patchwork.at(c)) > 0.0, "{f}: {face:?} is turned round or flat");
        for k in 0..3 {
            let other = patchwork.faces[face.beyond[k] as usize];
            let j = patchwork.place_of(face.beyond[k], f);
            let ends = [other.vertices[turn(j, 2)], other.vertices[turn(j, 1)]];
            assert_eq!(ends, [face.vertices[turn(k, 1)], face.vertices[turn(k, 2)]], "{f}, {k}");
        }
    }
    for v in 0..patchwork.vertices() as u32 {
        assert!(patchwork.ring(v).count() >= 3, "{v}");
    }
}

fn plain() -> Patchwork {
    Patchwork::new(1, DMat3::IDENTITY).unwrap()
}

#[test]
fn points_anywhere_are_worked_in() {
    let mut patchwork = plain();
    let mut random = Random(3);
    for _ in 0..400 {
        // Far from each other, and in clusters as fine as a rounding.
        let center = random.direction();
        patchwork.insert(center).unwrap();
        for part in [1e-3, 1e-9, 1e-14] {
            let _ = patchwork.insert((center + part * random.direction()).normalize());
        }
    }
    assert_sound(&patchwork);
}

#[test]
fn points_on_sides_split_them_and_points_on_vertices_clash() {
    let mut patchwork = plain();
    // Binary fractions, so that the middle is exact; near each other, so that a side joins them.
    let ends = [DVec3::new(1.0, 0.25, 0.5), DVec3::new(1.0, 0.25 + 1.0 / 1024.0, 0.5 + 1.0 / 2048.0)];
    let [a, b] = ends.map(|end| patchwork.insert(end).unwrap());
    assert!(patchwork.left_of(a, b).is_some());
    assert_eq!(patchwork.insert(ends[0] * 0.5), Err(Clash::Vertex(a)));
    let middle = patchwork.insert(0.5 * (ends[0] + ends[1])).unwrap();
    assert_sound(&patchwork);
    assert_eq!(patchwork.ring(middle).count(), 4);
    assert!(patchwork.left_of(a, b).is_none() && patchwork.left_of(a, middle).is_some());
    assert_eq!(patchwork.fix(a, b), Err(Clash::Vertex(middle)));
}

#[test]
fn sides_are_cleared_and_stay() {
    let mut random = Random(11);
    let (mut fixed, mut crossing) = (0, 0);
    for _ in 0..40 {
        let mut patchwork = plain();
        let first = patchwork.vertices() as u32;
        for _ in 0..60 {
            patchwork.insert(random.direction()).unwrap();
        }
        let mut sides = Vec::new();
        for _ in 0..40 {
            let mut any = || first + (random.next() * 60.0) as u32;
            let (a, b) = (any(), any());
            if a == b || patchwork.point(a).dot(patchwork.point(b)) < 0.0 {
                continue;
            }
            match patchwork.fix(a, b) {
                Ok(()) => sides.push((a, b)),
                Err(Clash::Side(..)) => crossing += 1,
                Err(clash) => panic!("{clash:?}"),
            }
            assert_sound(&patchwork);
            assert!(sides.iter().all(|&(a, b)| patchwork.left_of(a, b).is_some()));
        }
        fixed += sides.len();
    }
    assert!(fixed > 200 && crossing > 200, "{fixed} {crossing}");
}
