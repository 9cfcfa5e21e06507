//! Description of data that a scene does not need and that would cost bytes or time.

use icoray_grid::Grid;
use icoray_scene::{Ground, Heights, Method, Pattern, Scene};

/// The table of the corners of cells, with which fields at corners are averaged.
pub(crate) const CELL_CORNER: &str = "table cell_corner";

/// Describes the data that are left out for a field of `layers` layers; a field at corners needs the table
/// `cell_corner`.
pub(super) fn left_out(scene: &Scene, grid: &Grid, layers: usize, from_corners: bool) -> Vec<String> {
    let scenery = &scene.scenery;
    let (values, is_lit) = (grid.cells() * layers, scene.lighting.is_some());
    let has_lines = |is: fn(&Pattern) -> bool| scenery.lines.iter().any(|lines| is(&lines.pattern));
    let has_edges = has_lines(|pattern| *pattern == Pattern::Cells);
    let has_coasts = has_lines(|pattern| *pattern == Pattern::Coast) || scenery.ground != Ground::default();
    let has_surfaces = !(scenery.surfaces.is_empty() && scenery.isosurfaces.is_empty());
    let shown = scene.shown_fields();
    let has_derived = scenery.derived.iter().any(|derived| shown.contains(&derived.name.as_str()));
    [
        (is_lit, format!("gradients ({} bytes)", values * size_of::<[f32; 3]>())),
        (is_lit || from_corners || has_edges, CELL_CORNER.into()),
        (has_edges, "table corner".into()),
        (scene.core.is_none(), "the far side behind the core".into()),
        (scene.model_fields().len() > 1, "other fields".into()),
        (has_derived, "derived fields".into()),
        (has_surfaces, "surfaces".into()),
        (!scenery.lines.is_empty(), "lines".into()),
        (has_coasts, "table of coasts".into()),
        (has_lines(|pattern| *pattern == Pattern::Borders), "table of borders".into()),
        (!scenery.clips.is_empty(), "clips".into()),
        (scenery.heights == Heights::Native, "native heights".into()),
        (
            scene.method == Method::Exact || scene.has_one_field_of_volume(),
            "method \"paper\", which supports a single volume only".into(),
        ),
    ]
    .into_iter()
    .filter_map(|(is_needed, what)| (!is_needed).then_some(what))
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_grid::IcosahedralMesh;

    #[test]
    fn data_that_a_scene_uses_are_not_left_out() {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let left_out = |scene: &Scene| left_out(scene, &grid, 10, false);
        let scene = |text: &str| Scene::parse(&format!("field = 'q'\n{text}")).unwrap();
        let gradients = "gradients (5040 bytes)";
        let words = [
            gradients,
            "table cell_corner",
            "table corner",
            "the far side behind the core",
            "other fields",
            "derived fields",
            "surfaces",
            "lines",
            "table of coasts",
            "table of borders",
            "clips",
            "native heights",
        ];
        assert_eq!(left_out(&scene("")), words);
        let surface = "[[surfaces]]\nlayer = \"top\"\n";
        let cells = "[[lines]]\npattern = \"cells\"";
        for (text, used) in [
            ("[light]\nkind = \"headlight\"", &[gradients, "table cell_corner"][..]),
            (cells, &["table cell_corner", "table corner", "lines"]),
            ("[[lines]]\npattern = \"triangles\"", &["lines"]),
            ("[[lines]]\npattern = \"coast\"", &["lines", "table of coasts"]),
            ("[[lines]]\npattern = \"borders\"", &["lines", "table of borders"]),
            ("[ground]\nland = \"red\"", &["table of coasts"]),
            ("core = \"transparent\"", &["the far side behind the core"]),
            (&format!("{surface}color = \"red\""), &["surfaces"]),
            (&format!("{surface}field = \"q\"\ntransfer = {{ range = [0, 1] }}"), &["surfaces"]),
            (&format!("{surface}field = \"w\"\ntransfer = {{ range = [0, 1] }}"), &["other fields", "surfaces"]),
            ("[[isosurfaces]]\nfield = \"q\"\nvalue = 0\ncolor = \"red\"", &["surfaces"]),
            ("[[clip]]\ncut = \"inside\"\nlat = [0, 9]", &["clips"]),
            ("heights = \"native\"", &["native heights"]),
            ("method = \"paper\"", &[]),
            ("[[derive]]\nname = \"q\"\nsum = { u = 1 }", &["derived fields"]),
            ("[[derive]]\nname = \"q\"\nsum = { u = 1, v = 1 }", &["other fields", "derived fields"]),
            ("[[derive]]\nname = \"r\"\nsum = { u = 1, v = 1 }", &[]),
        ] {
            let expected: Vec<&str> = words.into_iter().filter(|word| !used.contains(word)).collect();
            assert_eq!(left_out(&scene(text)), expected, "{text}");
        }
        let mut several = scene("method = \"paper\"");
        several.volumes.push(several.volumes[0].clone());
        assert_eq!(left_out(&several).last().unwrap(), "method \"paper\", which supports a single volume only");
    }
}
