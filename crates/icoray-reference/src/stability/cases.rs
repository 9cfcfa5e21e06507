//! The cases: meshes, layers, fields, transfer functions, cameras.

mod case;
mod fields;
mod rays;
mod shells;
mod transfers;

pub use case::{Case, CaseMesh};

use icoray::Result;

/// The groups in the order of the table.
pub const GROUPS: [&str; 8] = ["mesh", "shell", "Earth", "camera", "ray", "depth", "transfer", "field"];

/// Meshes that the suite needs, by number of bisections.
pub const LEVELS: [u32; 5] = [2, 3, 4, 5, 6];
/// The same for the fine meshes.
pub const LARGE_LEVELS: [u32; 3] = [7, 8, 9];

/// The cases on one mesh.
pub fn on(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = shells::meshes(mesh)?;
    match mesh.level {
        3 => {
            cases.extend(shells::thickness(mesh)?);
            cases.extend(rays::cameras(mesh)?);
            cases.extend(rays::rays(mesh)?);
            cases.extend(transfers::depths(mesh)?);
            cases.extend(transfers::transfers(mesh)?);
            cases.extend(fields::fields(mesh)?);
            cases.extend(fields::missing(mesh)?);
        }
        4 => cases.extend(shells::earth(mesh)?),
        _ => {}
    }
    Ok(cases)
}
