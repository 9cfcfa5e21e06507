//! The scenes of the gallery, in its order.

use crate::options::Size;

/// A scene, and its pictures in the gallery.
pub struct Entry {
    pub title: &'static str,
    /// The scene's file in `examples/scenes`.
    pub scene: &'static str,
    pub subject: Subject,
    /// A description of the pictures.
    pub seen: &'static str,
    pub pictures: &'static [Picture],
}

/// The data that a scene shows.
pub enum Subject {
    /// Times of a model file, with further options.
    File { name: &'static str, time: &'static str, options: &'static [&'static str] },
    /// An artificial ocean on a real mesh: no real file is small enough.
    MadeOcean,
    /// The model of `examples/c`.
    Tracer,
    /// The model of `examples/fortran`, over MPI.
    ShallowWater,
}

/// A picture of the gallery.
pub struct Picture {
    /// Its path below the directory that the scene is rendered to.
    pub drawn: &'static str,
    /// Its file name in the gallery.
    pub file: &'static str,
    pub what: &'static str,
}

impl Entry {
    const fn new(title: &'static str, scene: &'static str, subject: Subject) -> Self {
        Self { title, scene, subject, seen: "", pictures: &[] }
    }

    const fn shows(self, seen: &'static str, pictures: &'static [Picture]) -> Self {
        Self { seen, pictures, ..self }
    }
}

const fn picture(drawn: &'static str, file: &'static str, what: &'static str) -> Picture {
    Picture { drawn, file, what }
}

/// A mesh of MPAS-Ocean, without fields.
pub const OCEAN_MESH: &str = "spherical_grid_500km_landculled.nc";

/// The tracer's size: pictures each half day.
pub const TRACER: Size = Size { level: 5, layers: 30, days: 4.0 };

/// The baroclinic wave, computed by MPAS-Atmosphere.
const fn wave(time: &'static str, options: &'static [&'static str]) -> Subject {
    Subject::File { name: "mpas_jw_10242.nc", time, options }
}

/// The wave on the last day, for scenes whose own pictures are larger than the page needs.
const SMALL_WAVE: Subject = wave("2", &["--size", "420x315"]);

/// All scenes: those of the method's paper first.
pub const GALLERY: &[Entry] = &[
    Entry::new("The whole globe", "vorticity_globe.toml", wave("2", &[])).shows(
        "Day 9: cyclones (red) and anticyclones (blue) of the breaking wave between 30°N and 75°N, lit by a sun.",
        &[picture("vorticity_globe_0000-01-10.png", "vorticity_globe.png", "relative vorticity")],
    ),
    Entry::new("A close-up of it", "jw_vorticity.toml", SMALL_WAVE).shows(
        "Two cyclones with the bands of vorticity along their cold fronts, seen from the south, lit from the eye.",
        &[picture("vorticity_0000-01-10.png", "jw_vorticity.png", "relative vorticity")],
    ),
    Entry::new("Tubes, polar cap and mesh", "tubes_cap_mesh.toml", wave("2", &[])).shows(
        "Tubes of cyclonic vorticity in yellow, the dome of polar air in blue, one field through the other, over the \
         mesh's cells.",
        &[picture("tubes_cap_mesh_0000-01-10.png", "tubes_cap_mesh.png", "vorticity, potential temperature, cells")],
    ),
    Entry::new("A region, from mesh to lit volume", "close_up.toml", wave("2", &[])).shows(
        "The lowest layer's cells; its potential temperature, smooth and as the model has it; vorticity by two \
         transfer functions, each unlit and lit.",
        &[
            picture("close_up_mesh.png", "close_up_mesh.png", "mesh"),
            picture("close_up_smooth.png", "close_up_smooth.png", "layer, smooth"),
            picture("close_up_cells.png", "close_up_cells.png", "layer, by cell"),
            picture("close_up_both_signs_unlit.png", "close_up_both_signs_unlit.png", "both signs, unlit"),
            picture("close_up_both_signs_lit.png", "close_up_both_signs_lit.png", "both signs, lit"),
            picture("close_up_cyclones_unlit.png", "close_up_cyclones_unlit.png", "cyclones, unlit"),
            picture("close_up_cyclones_lit.png", "close_up_cyclones_lit.png", "cyclones, lit"),
        ],
    ),
    Entry::new("Over a map", "overlay.toml", wave("2", &[])).shows(
        "The same vortices over land and sea, coasts and a graticule; the test case itself knows no land.",
        &[picture("overlay_0000-01-10.png", "overlay.png", "vorticity over a map")],
    ),
    Entry::new("Isosurfaces", "isosurfaces.toml", wave("2", &[])).shows(
        "The jets, where the wind towards the east is 32.5 m/s, coloured by potential temperature: whole in the south, \
         torn by the wave in the north, around the dome of polar air.",
        &[picture("isosurfaces_0000-01-10.png", "isosurfaces.png", "jets and polar air")],
    ),
    Entry::new("Shells of potential temperature", "jw_theta.toml", SMALL_WAVE).shows(
        "Three isentropes as thin shells of a volume: cold air breaks out to the south behind the fronts.",
        &[picture("theta_0000-01-10.png", "jw_theta.png", "potential temperature")],
    ),
    Entry::new("Rising and sinking air", "jw_w.toml", SMALL_WAVE).shows(
        "Air rises (red) along the fronts and sinks (blue) behind them.",
        &[picture("w_0000-01-10.png", "jw_w.png", "vertical velocity")],
    ),
    Entry::new("A cut", "cut_away.toml", wave("2", &[])).shows(
        "The lowest 18 km without a quarter of the north: surfaces of equal potential temperature rise from the \
         tropics over the cold air at the pole.",
        &[picture("cut_away_0000-01-10.png", "cut_away.png", "potential temperature, cut")],
    ),
    Entry::new("Heights of columns", "terrain.toml", wave("2", &["--layers", "0..2"])).shows(
        "The ground at each column's own height, times 2000: in this test case it falls towards the poles, in balance \
         with the jets.",
        &[picture("terrain.png", "terrain.png", "height of the ground")],
    ),
    Entry::new("All times of a file", "growth.toml", wave("all", &[])).shows(
        "The lowest layer's potential temperature above the pole, its colours the same on days 0, 6 and 9: the wave is \
         not seen at first, then bends the front between cold and warm air, then rolls it up.",
        &[
            picture("growth_01-01.png", "growth_01-01.png", "day 0"),
            picture("growth_01-07.png", "growth_01-07.png", "day 6"),
            picture("growth_01-10.png", "growth_01-10.png", "day 9"),
        ],
    ),
    Entry::new("Several views", "jw_views.toml", wave("all", &[])).shows(
        "A camera that goes along a path, one that goes round the planet, and, as the vortices are strong, six sides \
         of the polar air for a Cinema viewer; here one of the orbit and one of the sides.",
        &[
            picture("around_000002.png", "views_around.png", "orbit, day 9"),
            picture("theta.cdb/2_70_190.png", "views_sides.png", "one of six sides"),
        ],
    ),
    Entry::new("ICON", "icon.toml", Subject::File { name: "psyplot_icon_test.nc", time: "0", options: &[] }).shows(
        "Temperature between 1000 and 850 hPa in January 1979, with coasts: summer in southern Africa, frost in the \
         north.",
        &[picture("icon_t2m_1979-01-31.png", "icon.png", "temperature")],
    ),
    Entry::new("An ocean with land", "ocean.toml", Subject::MadeOcean).shows(
        "Water ends at coasts and at its floor. Cells and coasts are those of a real mesh of MPAS-Ocean; temperatures \
         and depths are made, by the test `the_ocean_ends_at_coasts_and_at_its_floor` of icoray-cli, which leaves \
         ocean.nc in the folder that ICORAY_TEST_KEEP names.",
        &[picture("ocean_temperature_0010-07-01.png", "ocean.png", "ocean temperature")],
    ),
    Entry::new("A simulation in C that draws itself", "tracer.toml", Subject::Tracer).shows(
        "Day 4 of two bells of a tracer, which the deformational flow carries around the planet and draws out into \
         ribbons; the model is examples/c.",
        &[picture("tracer_000472.png", "tracer.png", "mixing ratio")],
    ),
    Entry::new("A simulation in Fortran that draws itself", "shallow_water.toml", Subject::ShallowWater).shows(
        "Day 5 of a barotropic jet over the north that rolls up into vortices, on two ranks of MPI; the model is \
         examples/fortran/shallow_water.",
        &[picture("vorticity_001350.png", "shallow_water.png", "relative vorticity")],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use std::path::Path;

    #[test]
    fn scenes_are_there_and_names_are_distinct() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes");
        let mut seen = HashSet::new();
        for entry in GALLERY {
            assert!(scenes.join(entry.scene).is_file(), "{}", entry.scene);
            for name in [entry.scene, entry.title].into_iter().chain(entry.pictures.iter().map(|p| p.file)) {
                assert!(seen.insert(name), "{name} twice");
            }
        }
    }

    #[test]
    fn all_scenes_are_shown() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes");
        for file in scenes.read_dir().unwrap() {
            let name = file.unwrap().file_name();
            assert!(GALLERY.iter().any(|entry| name == entry.scene), "{}", name.display());
        }
    }
}
