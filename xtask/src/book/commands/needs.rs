//! The software and files that blocks of commands need.

use crate::requirements;
use crate::workspace::Workspace;

/// Names that blocks use, and their Debian packages. `data` is the data files and the software that reads them.
const NEEDS: [(&str, &[&str]); 5] = [
    ("data", &["libnetcdf-dev", "pkg-config"]),
    ("gfortran", &["gfortran"]),
    ("gpu", &["mesa-vulkan-drivers"]),
    ("mpi", &["libopenmpi-dev", "openmpi-bin", "libclang-dev"]),
    ("pkg-config", &["pkg-config"]),
];

/// The file that `FILE.nc` in a page stands for.
pub const FILE: &str = "mpas_jw_10242.nc";

/// Whether a name is in the list.
pub fn is_known(need: &str) -> bool {
    NEEDS.iter().any(|(name, _)| *name == need)
}

/// The names.
pub fn known() -> String {
    NEEDS.map(|(name, _)| name).join(", ")
}

/// Whether the machine has it.
pub fn is_met(workspace: &Workspace, need: &str) -> bool {
    if need == "data" && !workspace.data().join(FILE).is_file() {
        return false;
    }
    let packages = NEEDS.iter().find(|(name, _)| *name == need).map_or(&[][..], |(_, packages)| packages);
    let mut needed = requirements::FOR_TEST_ALL.iter().filter(|known| packages.contains(&known.name));
    needed.all(|known| known.check().is_ok())
}
