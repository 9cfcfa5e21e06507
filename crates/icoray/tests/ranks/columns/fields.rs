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

/// The form of a rank's field: by how many its columns are too many, layers, bits, place, and the mark of what is missing.
#[derive(Clone, Copy)]
struct Form {
    more: usize,
    layers: usize,
    is_wide: bool,
    location: Location,
    fill: Option<f64>,
}

const GOOD: Form = Form { more: 0, layers: LAYERS, is_wide: true, location: Location::Center, fill: None };
const FEWER_LAYERS: Form = Form { layers: LAYERS - 1, ..GOOD };

/// One rank has other fields or heights than the scene needs or the other ranks have.
#[test]
fn fields_that_do_not_fit_are_refused_on_all_ranks() {
    let (mesh, grid) = icosahedral(2);
    let locals = locals(mesh, 3, &partitions(mesh.cells(), 3)[1]);
    let (narrow, wide) = (vec![0.5f32; 4000], vec![0.5; 4000]);
    let (of_field, of_mpi, of_scene) = (ErrorKind::Field, ErrorKind::Mpi, ErrorKind::Scene);
    let at_corners = format!("\"q\": {} columns, expected 320, one per corner", locals[1].cells.len());
    let (t, heights) = (("t", GOOD), Some(GOOD));
    let cases = [
        (Form { more: 1, ..GOOD }, t, heights, of_field, "\"q\": "),
        (FEWER_LAYERS, t, heights, of_mpi, "has \"q\" of 3 layers of 64 bits, but \"q\" of 4 "),
        (Form { is_wide: false, ..GOOD }, t, heights, of_mpi, "has \"q\" of 4 layers of 32 bits"),
        (Form { fill: Some(7.0), ..GOOD }, t, heights, of_mpi, "has \"q\" with missing values marked by Some(7.0)"),
        (Form { location: Location::Corner, ..GOOD }, t, heights, of_field, at_corners.as_str()),
        (
            GOOD,
            ("t", FEWER_LAYERS),
            heights,
            of_mpi,
            "has \"t\" of 3 layers of 64 bits, but \"t\" of 4 layers of 64 bits on rank 0",
        ),
        (GOOD, t, Some(FEWER_LAYERS), of_mpi, "has heights of 3 layers of 64 bits, but heights of 4 layers"),
        (GOOD, ("u", GOOD), heights, of_scene, "the scene shows field \"t\", and there is [\"q\", \"u\"]"),
        (GOOD, t, None, of_scene, "the scene has heights = \"native\""),
    ];
    for (q, other, of_heights, kind, words) in cases {
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local).unwrap();
            let field = |form: Form| {
                let samples = if form.is_wide { wide.as_slice().into() } else { narrow.as_slice().into() };
                let shape = Shape::level_fastest(local.cells.len() + form.more, form.layers);
                Field::new(samples, shape, form.location, form.fill).unwrap()
            };
            let (q, (name, other), of_heights) =
                if ranks.rank() == 1 { (q, other, of_heights) } else { (GOOD, t, heights) };
            let fields = Fields::new([("q", field(q)), (name, field(other))]);
            let fields = match of_heights {
                Some(heights) => fields.with_heights(field(heights)),
                None => fields,
            };
            let refusal = refusal(render(ranks, &rich_scene(), &grid, &decomposition, fields));
            render(ranks, &scene(""), &grid, &decomposition, &field(GOOD)).unwrap();
            refusal
        });
        assert_same_refusal(&refusals, kind, &format!("rank 1: {words}"));
    }
}
