//! Compiles each package without features and with each feature alone, as users select them.
//!
//! The other checks compile the workspace with one set of features, in which a package may use an item that only a
//! feature of another package enables.

use serde_json::Value;

use super::suite::Suite;
use crate::error::Error;
use crate::step::Step;

/// Packages without features that are selected beside each feature, so that cargo selects the same features of crates
/// from crates.io for all of them, and compiles these crates once. Each package is compiled alone without features.
const COMPANIONS: [&str; 6] = ["icoray-gpu", "icoray-live", "icoray-mpi", "icoray-netcdf", "icoray-reference", "xtask"];

/// Features that are left out: they compile NetCDF and HDF5, which takes minutes and a newer CMake than Debian's.
const LEFT_OUT: [&str; 1] = ["static"];

/// Checks that every package with features compiles without any, and with each alone.
pub fn check(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    let metadata = suite.workspace.cargo(["metadata", "--no-deps", "--format-version", "1"]).quiet().read()?;
    let sets = sets(&metadata)?;
    let mut failures = Vec::new();
    for (package, feature) in &sets {
        let mut cargo = suite.workspace.cargo(["check", "--no-default-features", "--package", package]);
        if let Some(feature) = feature {
            cargo = cargo.arg(format!("--features={package}/{feature}"));
            cargo = cargo.args(COMPANIONS.iter().flat_map(|companion| ["--package", companion]));
        }
        if let Err(error) = step.quiet(cargo) {
            failures.push(format!("{package} with {}: {error}", feature.as_deref().unwrap_or("no feature")));
        }
    }
    step.note(&format!("{} sets of features", sets.len()));
    if failures.is_empty() { Ok(()) } else { Err(Error(failures.join("\n"))) }
}

/// Each package of the workspace that has features, without any and with each.
fn sets(metadata: &str) -> Result<Vec<(String, Option<String>)>, Error> {
    let metadata: Value = serde_json::from_str(metadata).map_err(Error::while_doing("cargo metadata"))?;
    let mut sets = Vec::new();
    for package in metadata["packages"].as_array().into_iter().flatten() {
        let (Some(name), Some(features)) = (package["name"].as_str(), package["features"].as_object()) else {
            continue;
        };
        let features = features.keys().filter(|feature| *feature != "default");
        let features: Vec<_> = features.filter(|feature| !LEFT_OUT.contains(&feature.as_str())).collect();
        if !features.is_empty() {
            sets.push((name.to_owned(), None));
            sets.extend(features.into_iter().map(|feature| (name.to_owned(), Some(feature.clone()))));
        }
    }
    if sets.is_empty() { Err(Error("cargo metadata names no feature".into())) } else { Ok(sets) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_none_and_each_feature_alone() {
        let metadata = r#"{"packages": [{"name": "a", "features": {}}, {"name": "b", "features": {"static": []}},
            {"name": "c", "features": {"default": ["gpu"], "gpu": [], "mpi": [], "static": []}}]}"#;
        let set = |feature: Option<&str>| ("c".to_owned(), feature.map(str::to_owned));
        assert_eq!(sets(metadata), Ok(vec![set(None), set(Some("gpu")), set(Some("mpi"))]));
        assert!(sets("no JSON").is_err() && sets(r#"{"packages": []}"#).is_err());
    }
}
