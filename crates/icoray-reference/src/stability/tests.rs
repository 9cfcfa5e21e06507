//! The reference against a closed form, and the suite with its limits.

use super::cases::{self, CaseMesh};
use super::{RUNS, Row, measure_level, part_between};
use crate::columns::columns;
use crate::oracle::{Data, NamedField, Oracle, PANEL};
use crate::ray::Ray;
use crate::sphere::Sphere;
use crate::tests::scene;
use glam::DVec3;
use icoray::{Grid, IcosahedralMesh, Layers, Renderer};
use std::collections::HashSet;

/// A constant field absorbs `1 - e^(-κ L)`, L being the length of the ray in the shell, without its hollow core.
#[test]
fn stability_reference_is_the_closed_form_where_all_is_constant() {
    let sphere = Sphere::new(2, 4, [1.0, 1.6], |_| 0.25).unwrap();
    let grid = sphere.grid().unwrap();
    let scene = scene(
        1,
        "unit_length = 1\n\
         knots = [{ value = 0, color = \"white\", extinction = 1 }, { value = 1, color = \"white\", extinction = 3 }]",
    );
    let fields = [NamedField { name: "f", values: vec![0.25; sphere.values.len()] }];
    let data = Data { grid: &grid, layers: &sphere.layers, heights: &[], fields: &fields };
    let oracle = Oracle::new(&scene, data, PANEL).unwrap();
    let eye = DVec3::new(2.0, 1.3, -0.7);
    for aim in [DVec3::ZERO, DVec3::new(0.3, 0.9, -0.1), DVec3::new(-0.2, 0.4, 1.1), DVec3::new(0.1, -0.9, 0.2)] {
        let ray = Ray { eye, dir: (aim - eye).normalize() };
        let columns = columns(&grid, &ray, 1.6, None).unwrap();
        let parts = columns.iter().filter_map(|column| part_between(column, [1.0, 1.6]));
        let length: f64 = parts.map(|[from, to]| to - from).sum();
        let expected = -(-1.5 * length).exp_m1();
        let light = oracle.pixel(&ray).unwrap();
        assert!(length > 0.5, "{ray:?}");
        assert!(light.iter().all(|c| (c - expected).abs() < 1e-14), "{light:?} against {expected}");
    }
}

/// Layers one ulp apart differ; a shell that is compressed until they do not is refused.
#[test]
fn stability_of_layers_one_ulp_apart() {
    let thin = Layers::new(vec![1.0, 1.0f64.next_up()], 1.0).unwrap();
    assert!(thin.shell(1.0).is_ok() && thin.shell(0.1).is_err());
}

/// The largest error in f64, and in f32 where the tolerance is next to nothing.
const LIMIT: [f64; 2] = [1e-9, 1e-5];

/// The case in which errors in f32 may be larger: the two knots of a spike, 1e-6 of the range apart, are rounded to
/// f32.
const LOOSE: [(&str, f64); 1] = [("spike 1e-6 wide among wide knots", 0.3)];

fn check(row: &Row) {
    let single = LOOSE.iter().find(|(part, _)| row.name.contains(part)).map_or(LIMIT[1], |(_, limit)| *limit);
    assert!(row.lost == 0 && row.run.iter().all(|run| run.not_finite == 0), "{row:?}");
    assert!(row.run[0].error <= LIMIT[0], "f64: {row:?}");
    assert!(row.run[1].error <= single, "f32: {row:?}");
    assert!(row.run[2].error <= single + RUNS[2].1, "f32 at the default tolerance: {row:?}");
}

/// Every case on all but the largest meshes, with its limits.
#[test]
fn stability_suite_holds_its_limits() {
    let renderer = Renderer::new(0).unwrap();
    let rows: Vec<Row> = cases::LEVELS.into_iter().flat_map(|n| measure_level(&renderer, n, "").unwrap()).collect();
    let names: HashSet<_> = rows.iter().map(|row| (row.group, &row.name)).collect();
    assert_eq!(names.len(), rows.len(), "two cases bear one name");
    assert!(rows.iter().all(|row| cases::GROUPS.contains(&row.group)), "a group is not in the table");
    rows.iter().for_each(check);
    let seen: usize = rows.iter().map(|row| row.seen).sum();
    assert!(rows.len() >= 200 && seen > 15_000, "{} cases, {seen} rays that see something", rows.len());
    for row in &rows {
        assert!(row.run.iter().all(|run| run.over_bound == 0), "a pixel's error is above the reported one: {row:?}");
    }
    earth(&rows);
}

/// f32 with 100 m layers on the Earth, true to scale, has at most 10 times the error of a shell of a tenth.
fn earth(rows: &[Row]) {
    for view in ["globe", "limb"] {
        let of = |scale: &str| {
            let name = format!("{scale}: {view}");
            rows.iter().find(|row| row.name == name).expect("the pair is in the suite")
        };
        let (thin, thick) = (of("100 m layers, to scale"), of("a 10% shell"));
        assert!(thin.seen > 80 && thick.seen > 80, "{thin:?} {thick:?}");
        assert!(thin.run[1].error <= 10.0 * thick.run[1].error, "{thin:?} {thick:?}");
        assert!(thin.run[1].error < 1e-5, "{thin:?}");
    }
}

/// The page that lies beside this crate's sources is written by the command; it must list the cases that there are.
#[test]
fn stability_page_lists_the_cases() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/STABILITY.md");
    let page = std::fs::read_to_string(path).unwrap();
    for level in cases::LEVELS {
        let mesh = IcosahedralMesh::new(level).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        for case in cases::on(&CaseMesh { level, grid: &grid }).unwrap() {
            let line = format!("| {} | {} |", case.name, case.scene.width * case.scene.height);
            assert!(page.contains(&line), "{path} lacks {line}; icoray-study stability --large --out writes it anew");
        }
    }
}
