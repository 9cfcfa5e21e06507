//! What the gallery shows, in its order.

use crate::options::Size;

/// A scene and what is kept of its pictures.
pub struct Entry {
    pub title: &'static str,
    /// The scene's file in `examples/scenes`.
    pub scene: &'static str,
    pub subject: Subject,
    /// What is seen, in a sentence.
    pub seen: &'static str,
    pub pictures: &'static [Picture],
}

/// What a scene is drawn of.
pub enum Subject {
    /// Some times of a real file, with further options.
    File { name: &'static str, time: &'static str, options: &'static [&'static str] },
    /// The ocean that is made on a real mesh, for there is no real file small enough.
    MadeOcean,
    /// The model of `examples/c`.
    Tracer,
    /// The model of `examples/fortran`, over MPI.
    ShallowWater,
}

/// A picture that is kept.
pub struct Picture {
    /// What it is called below the folder that the scene is drawn into.
    pub drawn: &'static str,
    /// What it is called in the gallery.
    pub file: &'static str,
    pub what: &'static str,
}

const fn picture(drawn: &'static str, file: &'static str, what: &'static str) -> Picture {
    Picture { drawn, file, what }
}

/// A mesh of MPAS-Ocean, without fields.
pub const OCEAN_MESH: &str = "spherical_grid_500km_landculled.nc";

/// The tracer's size: pictures each half day.
pub const TRACER: Size = Size { level: 5, layers: 30, days: 4.0 };

const fn wave(time: &'static str) -> Subject {
    Subject::File { name: "mpas_jw_10242.nc", time, options: &[] }
}

/// Of scenes whose own pictures are larger than the page needs.
const SMALL_WAVE: Subject =
    Subject::File { name: "mpas_jw_10242.nc", time: "2", options: &["--size", "420x315"] };

/// All scenes: those of the method's paper first.
pub const GALLERY: &[Entry] = &[
    Entry {
        title: "The whole globe",
        scene: "vorticity_globe.toml",
        subject: wave("2"),
        seen: "Day 9: cyclones (red) and anticyclones (blue) of the breaking wave between 30°N and 75°N, lit by a sun.",
        pictures: &[picture("vorticity_globe_0000-01-10.png", "vorticity_globe.png", "relative vorticity")],
    },
    Entry {
        title: "A close-up of it",
        scene: "jw_vorticity.toml",
        subject: SMALL_WAVE,
        seen: "Two cyclones with the bands of vorticity along their cold fronts, seen from the south, lit from the eye.",
        pictures: &[picture("vorticity_0000-01-10.png", "jw_vorticity.png", "relative vorticity")],
    },
    Entry {
        title: "Tubes, polar cap and mesh",
        scene: "tubes_cap_mesh.toml",
        subject: wave("2"),
        seen: "Tubes of cyclonic vorticity in yellow, the dome of polar air in blue, one field through the other, over the mesh's cells.",
        pictures: &[picture(
            "tubes_cap_mesh_0000-01-10.png",
            "tubes_cap_mesh.png",
            "vorticity, potential temperature, cells",
        )],
    },
    Entry {
        title: "A region, from mesh to lit volume",
        scene: "close_up.toml",
        subject: wave("2"),
        seen: "The lowest layer's cells; its potential temperature, smooth and as the model has it; vorticity by two transfer functions, \
               each unlit and lit.",
        pictures: &[
            picture("close_up_mesh.png", "close_up_mesh.png", "mesh"),
            picture("close_up_smooth.png", "close_up_smooth.png", "layer, smooth"),
            picture("close_up_cells.png", "close_up_cells.png", "layer, by cell"),
            picture("close_up_both_signs_unlit.png", "close_up_both_signs_unlit.png", "both signs, unlit"),
            picture("close_up_both_signs_lit.png", "close_up_both_signs_lit.png", "both signs, lit"),
            picture("close_up_cyclones_unlit.png", "close_up_cyclones_unlit.png", "cyclones, unlit"),
            picture("close_up_cyclones_lit.png", "close_up_cyclones_lit.png", "cyclones, lit"),
        ],
    },
    Entry {
        title: "Over a map",
        scene: "overlay.toml",
        subject: wave("2"),
        seen: "The same vortices over land and sea, coasts and a graticule; the test case itself knows no land.",
        pictures: &[picture("overlay_0000-01-10.png", "overlay.png", "vorticity over a map")],
    },
    Entry {
        title: "Isosurfaces",
        scene: "isosurfaces.toml",
        subject: wave("2"),
        seen: "The jets, where the wind towards the east is 32.5 m/s, coloured by potential temperature: whole in the south, torn by the \
               wave in the north, around the dome of polar air.",
        pictures: &[picture("isosurfaces_0000-01-10.png", "isosurfaces.png", "jets and polar air")],
    },
    Entry {
        title: "Shells of potential temperature",
        scene: "jw_theta.toml",
        subject: SMALL_WAVE,
        seen: "Three isentropes as thin shells of a volume: cold air breaks out to the south behind the fronts.",
        pictures: &[picture("theta_0000-01-10.png", "jw_theta.png", "potential temperature")],
    },
    Entry {
        title: "Rising and sinking air",
        scene: "jw_w.toml",
        subject: SMALL_WAVE,
        seen: "Air rises (red) along the fronts and sinks (blue) behind them.",
        pictures: &[picture("w_0000-01-10.png", "jw_w.png", "vertical velocity")],
    },
    Entry {
        title: "A cut",
        scene: "cut_away.toml",
        subject: wave("2"),
        seen: "The lowest 18 km without a quarter of the north: surfaces of equal potential temperature rise from the tropics over the cold \
               air at the pole.",
        pictures: &[picture("cut_away_0000-01-10.png", "cut_away.png", "potential temperature, cut")],
    },
    Entry {
        title: "Heights of columns",
        scene: "terrain.toml",
        subject: Subject::File { name: "mpas_jw_10242.nc", time: "2", options: &["--layers", "0..2"] },
        seen: "The ground at each column's own height, times 2000: in this test case it falls towards the poles, in balance with the jets.",
        pictures: &[picture("terrain.png", "terrain.png", "height of the ground")],
    },
    Entry {
        title: "All times of a file",
        scene: "growth.toml",
        subject: wave("all"),
        seen: "The lowest layer's potential temperature above the pole, its colours the same on days 0, 6 and 9: the wave is not seen at \
               first, then bends the front between cold and warm air, then rolls it up.",
        pictures: &[
            picture("growth_01-01.png", "growth_01-01.png", "day 0"),
            picture("growth_01-07.png", "growth_01-07.png", "day 6"),
            picture("growth_01-10.png", "growth_01-10.png", "day 9"),
        ],
    },
    Entry {
        title: "Several views",
        scene: "jw_views.toml",
        subject: wave("all"),
        seen: "A camera that goes along a path, one that goes round the planet, and, as the vortices are strong, six sides of the polar \
               air for a Cinema viewer; here one of the orbit and one of the sides.",
        pictures: &[
            picture("around_000002.png", "views_around.png", "orbit, day 9"),
            picture("theta.cdb/2_70_190.png", "views_sides.png", "one of six sides"),
        ],
    },
    Entry {
        title: "ICON",
        scene: "icon.toml",
        subject: Subject::File { name: "psyplot_icon_test.nc", time: "0", options: &[] },
        seen: "Temperature between 1000 and 850 hPa in January 1979, with coasts: summer in southern Africa, frost in the north.",
        pictures: &[picture("icon_t2m_1979-01-31.png", "icon.png", "temperature")],
    },
    Entry {
        title: "An ocean with land",
        scene: "ocean.toml",
        subject: Subject::MadeOcean,
        seen: "Water ends at coasts and at its floor. Cells and coasts are those of a real mesh of MPAS-Ocean; temperatures and depths are \
               made, by the test `the_ocean_ends_at_coasts_and_at_its_floor` of icoray-cli, which leaves ocean.nc in the folder that \
               ICORAY_TEST_KEEP names.",
        pictures: &[picture("ocean_temperature_0010-07-01.png", "ocean.png", "ocean temperature")],
    },
    Entry {
        title: "A simulation in C that draws itself",
        scene: "tracer.toml",
        subject: Subject::Tracer,
        seen: "Day 4 of two bells of a tracer, which the deformational flow carries around the planet and draws out into ribbons; the model is examples/c.",
        pictures: &[picture("tracer_000472.png", "tracer.png", "mixing ratio")],
    },
    Entry {
        title: "A simulation in Fortran that draws itself",
        scene: "shallow_water.toml",
        subject: Subject::ShallowWater,
        seen: "Day 5 of a barotropic jet over the north that rolls up into vortices, on two ranks of MPI; the model is \
               examples/fortran/shallow_water.",
        pictures: &[picture("vorticity_001350.png", "shallow_water.png", "relative vorticity")],
    },
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
