//! References for the pictures of icoray, which share no code with its kernels.
//!
//! - [`oracle`] renders scenes to ten digits in f64;
//! - [`stability`] compares hard cases, and [`random`] random scenes, with [`oracle`], ray by ray;
//! - [`radial`] is the paper's Figure 6: perfect spheres;
//! - [`methods`] are the rendering methods that the paper compares with.

mod columns;
pub mod comparison;
mod double_double;
pub mod job;
pub mod methods;
pub mod oracle;
pub mod radial;
pub mod random;
pub mod ray;
pub mod shading;
pub mod sphere;
pub mod stability;

// The meshes with holes of icoray's own tests; they name these types of their parent.
#[path = "../../icoray/tests/suite/culled/mod.rs"]
#[doc(hidden)]
pub mod culled;
use icoray::{Grid, GridTables, IcosahedralMesh, LonLat};

#[cfg(test)]
mod tests {
    /// A hollow globe before no background, with the text of its transfer function and of further tables.
    pub fn scene(size: u32, transfer: &str) -> icoray::Scene {
        icoray::Scene::parse(&format!(
            "field = \"f\"\nantialias = false\ncore = \"transparent\"\nbackground = \"transparent\"\n\
             image = {{ width = {size}, height = {size} }}\n\
             camera = {{ lon = 20, lat = 35, distance = 3.5, fov = 40 }}\n[transfer]\n{transfer}"
        ))
        .unwrap()
    }
}
