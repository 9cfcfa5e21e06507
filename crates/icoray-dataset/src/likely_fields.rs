//! Selects the variables of a file that look like physical fields.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use crate::source::without_group;

/// Variables of heights, thicknesses, the vertical grid and the mesh: lower case, with blanks between.
const GRID_VARIABLES: &str = "\
    zgrid zz zxu zb zb3 fzm fzp rdzw rdzu dzu dss z_ifc z_mc zghalf zg zfull hhl hsurf geometric_height \
    ddqz_z_full ddqz_z_half height altitude depth layerthickness restingthickness timemonthly_avg_layerthickness zs dzs zmid ztop deriv_two areacell \
    areatriangle meshdensity cellquality gridspacing trianglequality triangleanglequality nominalmindc fcell \
    fvertex angleedge cell_area cell_area_p dual_area dual_area_p cell_elevation area cell_quality \
    maxlevelcell minlevelcell nlevels nlevels_nod2d ulevels ulevels_nod2d elem_area nod_area \
    lonedge latedge xedge yedge zedge dcedge dvedge fedge \
    grid_area grid_imask siglay siglev siglay_center siglev_center x y xc yc art1 art2";
/// Name endings of base states, which do not change.
const BASE: [&str; 2] = ["_base", "_ref"];
/// Words, in lower case, that mark a geometric quantity if they are in the long name of a variable in units of length.
const GEOMETRY: [&str; 5] = ["height", "altitude", "thickness", "depth", "elevation"];

impl Dataset {
    /// The fields that are worth showing, the likeliest first: those of at least 2 layers that change with time, in the
    /// file's order (those of MPAS's soil and categories after those on its levels), then others with layers, then 2D
    /// fields in the same way. Heights, thicknesses, base states, weights of the vertical grid, and areas and qualities
    /// of the mesh are left out.
    pub fn likely_fields(&self) -> Vec<&FieldInfo> {
        let mut fields: Vec<&FieldInfo> = self.fields.iter().filter(|info| is_physical(info)).collect();
        fields.sort_by_key(|info| (info.is_2d(), !info.time_dependent, is_beside_levels(info), info.is_from_edges()));
        fields
    }
}

/// Whether the layers are not the levels of MPAS's models, such as those of the soil.
fn is_beside_levels(info: &FieldInfo) -> bool {
    let is_mpas = matches!(info.layer_dimension.as_bytes(), [b'n', b'A'..=b'Z', ..]);
    is_mpas && !info.layer_dimension.starts_with("nVertLevels")
}

fn is_physical(info: &FieldInfo) -> bool {
    let name = without_group(&info.name).to_ascii_lowercase();
    let long_name = info.description.long_name.as_deref().unwrap_or("").to_ascii_lowercase();
    let is_of_grid = GRID_VARIABLES.split(' ').any(|known| known == name) || BASE.iter().any(|end| name.ends_with(end));
    let is_geometry = info.description.is_length() && GEOMETRY.iter().any(|word| long_name.contains(word));
    // A height of each column, such as the sea surface's or the topography's, is worth showing.
    !is_of_grid && (info.is_2d() || !is_geometry)
}
