//! Several fields of columns that are spread over ranks, and heights.

use super::*;
use icoray::{Heights, Volume};

/// The field t beside q, on layers that lie at heights of their own.
pub(super) fn rich_scene() -> Scene {
    let mut scene = scene("");
    let transfer = scene.volumes[0].transfer.clone();
    scene.volumes.extend([Volume { field: "t".into(), transfer, coloring: None, opacity: None }]);
    scene.scenery.heights = Heights::Native;
    scene
}

/// Values of q, of t, and heights of some cells, in a layout each.
struct Rich([Vec<f64>; 2], Vec<f32>, [Shape; 3]);

impl Rich {
    fn of(cells: &[usize], layouts: [Layout; 3]) -> Self {
        let height = |cell: usize, layer: usize| 6e3 * layer as f64 + 2e3 * (0.3 * cell as f64).sin();
        let [q, t, heights] = layouts;
        let wide = [q.lay(cells, |c, l| value(c, l, 1)), heights.lay(cells, height)];
        let t = t.lay(cells, |c, l| value(c, LAYERS - 1 - l, 2) as f32);
        Rich(wide, t, layouts.map(|layout| layout.shape(cells.len())))
    }

    fn fields(&self) -> Fields<'_> {
        let Rich([q, heights], t, shapes) = self;
        let field = |samples, shape, fill| Field::new(samples, shape, Location::Center, fill).unwrap();
        let t = field(t.as_slice().into(), shapes[1], Some(f64::from(FILL as f32)));
        let q = field(q.as_slice().into(), shapes[0], Some(FILL));
        // In another order than the scene has them, and with one that it does not need.
        let fields = Fields::new([("t", t), ("unused", q), ("q", q)]);
        fields.with_heights(field(heights.as_slice().into(), shapes[2], None))
    }
}

#[test]
fn all_fields_and_heights_that_a_scene_needs_are_put_together() {
    use Layout::{Blocked, CellFastest, LevelFastest};
    let (mesh, grid) = icosahedral(3);
    let all: Vec<usize> = (0..mesh.cells()).collect();
    let whole = Rich::of(&all, [LevelFastest; 3]);
    let whole = Renderer::new(1).unwrap().render(&rich_scene(), &grid, &layers(), whole.fields()).unwrap();
    for (node_of, layouts) in [
        (&[0, 0][..], [LevelFastest, CellFastest, Blocked]),
        (&[0, 1, 0], [CellFastest, Blocked, LevelFastest]),
        (&[2, 1, 1, 0], [Blocked, LevelFastest, CellFastest]),
    ] {
        let locals = locals(mesh, node_of.len(), &partitions(all.len(), node_of.len())[1]);
        let (frame, reports) = picture(on_nodes(node_of, |ranks| {
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local).unwrap();
            let rich = Rich::of(&local.cells, layouts);
            // First one field only, so that the memory has to grow.
            let plain = scene("");
            render(ranks, &plain, &grid, &decomposition, rich.fields().get("q").unwrap()).unwrap();
            render(ranks, &rich_scene(), &grid, &decomposition, rich.fields()).unwrap()
        }));
        assert!(bits(&frame) == bits(&whole), "{node_of:?}");
        let bytes = all.len() * LAYERS * (8 + 4 + 8);
        assert_bytes_copied(node_of, &reports, bytes, &format!("{node_of:?}"));
    }
}

#[test]
fn every_field_and_heights_are_agreed_on() {
    let (mesh, grid) = icosahedral(2);
    let locals = locals(mesh, 3, &partitions(mesh.cells(), 3)[1]);
    let wide = vec![0.5; 4000];
    type Damage = for<'f> fn(Field<'f>, Field<'f>) -> Fields<'f>;
    let cases: [(Damage, ErrorKind, &str); 5] = [
        (
            |good, odd| Fields::new([("q", good), ("t", odd)]).with_heights(good),
            ErrorKind::Mpi,
            "has \"t\" of 3 layers of 64 bits, but \"t\" of 4 layers of 64 bits on rank 0",
        ),
        (
            |good, odd| Fields::new([("q", good), ("t", good)]).with_heights(odd),
            ErrorKind::Mpi,
            "has heights of 3 layers of 64 bits, but heights of 4 layers",
        ),
        (
            |good, _| Fields::new([("q", good), ("u", good)]).with_heights(good),
            ErrorKind::Scene,
            "the scene shows field \"t\", and there is [\"q\", \"u\"]",
        ),
        (|good, _| Fields::new([("q", good), ("t", good)]), ErrorKind::Scene, "the scene has heights = \"native\""),
        (
            |good, odd| Fields::new([("q", odd), ("t", good)]).with_heights(good),
            ErrorKind::Mpi,
            "has \"q\" of 3 layers",
        ),
    ];
    for (damage, kind, words) in cases {
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local).unwrap();
            let of = |layers| at_centers(&wide[..local.cells.len() * layers], layers);
            let (good, odd) = (of(LAYERS), of(LAYERS - 1));
            let right = Fields::new([("q", good), ("t", good)]).with_heights(good);
            let fields = if ranks.rank() == 1 { damage(good, odd) } else { right };
            refusal(render(ranks, &rich_scene(), &grid, &decomposition, fields))
        });
        assert_same_refusal(&refusals, kind, &format!("rank 1: {words}"));
    }
}
