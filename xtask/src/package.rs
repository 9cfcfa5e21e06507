//! `cargo xtask package`: the source archive of a release, and the recipes of package managers that have its checksum.
//!
//! The archive holds the commit `HEAD`, whatever the working tree is. `.gitattributes` leaves `packaging` out of it: a
//! recipe in the archive could not hold the archive's checksum. Two archives of one commit are equal byte by byte.

use std::path::{Path, PathBuf};

use xshell::cmd;

use crate::error::Error;
use crate::step::{Steps, print_line};
use crate::workspace::Workspace;

/// The version of the whole workspace.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The recipes, below `target/package`; their templates, with the ending `.in`, are below `packaging`.
const RECIPES: [&str; 2] = ["spack/package.py", "conda/recipe.yaml"];

/// Writes the archive and the recipes to `target/package`.
pub fn run(workspace: &Workspace) -> Result<(), Error> {
    let directory = workspace.products("package");
    let mut steps = Steps::new(3);
    let archive = steps.run("archiving the commit", |step| {
        if !cmd!(workspace.shell, "git status --porcelain --untracked-files=no").quiet().read()?.is_empty() {
            step.note("the working tree has changes; the archive holds HEAD without them");
        }
        archive(workspace, &directory)
    })?;
    steps.run("checking the archive", |_| check(workspace, &archive))?;
    let checksum = sha256(workspace, &archive)?;
    let recipes = steps.run("filling in the recipes", |_| fill_recipes(workspace, &checksum, &directory))?;
    print_line(&format!("\n{checksum}  {}", workspace.shown(&archive)));
    recipes.iter().for_each(|recipe| print_line(&workspace.shown(recipe)));
    Ok(())
}

/// Writes the archive to a directory; returns its path.
fn archive(workspace: &Workspace, directory: &Path) -> Result<PathBuf, Error> {
    let sh = &workspace.shell;
    let name = format!("icoray-{VERSION}");
    let archive = sh.create_dir(directory)?.join(format!("{name}.tar.gz"));
    // Neither the user's settings nor the time go into the archive.
    let settings = ["-c", "tar.umask=0022", "-c", "tar.tar.gz.command=gzip -n"];
    cmd!(sh, "git {settings...} archive --format=tar.gz --prefix={name}/ --output={archive} HEAD").quiet().run()?;
    Ok(archive)
}

/// Fails if the archive is not a workspace of this version that cargo can read.
fn check(workspace: &Workspace, archive: &Path) -> Result<(), Error> {
    let sh = &workspace.shell;
    let scratch = workspace.products("tmp").join("package");
    sh.remove_path(&scratch)?;
    sh.create_dir(&scratch)?;
    cmd!(sh, "tar -xzf {archive} -C {scratch}").quiet().run()?;
    let manifest = scratch.join(format!("icoray-{VERSION}/Cargo.toml"));
    let metadata = workspace.cargo(["metadata", "--format-version=1", "--no-deps", "--offline", "--manifest-path"]);
    let metadata = metadata.arg(manifest).quiet().read()?;
    if !metadata.contains(&format!(r#""name":"icoray","version":"{VERSION}""#)) {
        return Err(Error::Failed(format!("the crate icoray of HEAD is not of version {VERSION}: commit Cargo.toml")));
    }
    sh.remove_path(&scratch)?;
    Ok(())
}

/// The SHA-256 of a file, in hexadecimal digits.
fn sha256(workspace: &Workspace, file: &Path) -> Result<String, Error> {
    let line = cmd!(workspace.shell, "sha256sum {file}").quiet().read()?;
    Ok(line.split_whitespace().next().unwrap_or_default().to_owned())
}

/// Writes the recipes of this version, for an archive with this checksum; returns their paths.
fn fill_recipes(workspace: &Workspace, checksum: &str, directory: &Path) -> Result<Vec<PathBuf>, Error> {
    let sh = &workspace.shell;
    let mut written = Vec::new();
    for recipe in RECIPES {
        // Read here and not at compile time, as the archive builds this program without the templates.
        let template = sh.read_file(workspace.root.join("packaging").join(format!("{recipe}.in")))?;
        let path = directory.join(recipe);
        sh.write_file(&path, filled(&template, checksum))?;
        written.push(path);
    }
    Ok(written)
}

/// A template with its values.
fn filled(template: &str, checksum: &str) -> String {
    let rust_version = env!("CARGO_PKG_RUST_VERSION");
    let values = [("@VERSION@", VERSION), ("@SHA256@", checksum), ("@RUST_VERSION@", rust_version)];
    values.iter().fold(template.to_owned(), |text, (name, value)| text.replace(name, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn archives_of_a_commit_are_equal_and_recipes_have_their_checksum() {
        let workspace = Workspace::find().unwrap();
        if !workspace.root.join(".git").exists() {
            return println!("skipped: the sources are not a clone");
        }
        let sh = &workspace.shell;
        let directory = sh.create_temp_dir().unwrap();
        let [one, other] = ["one", "other"].map(|name| archive(&workspace, &directory.path().join(name)).unwrap());
        assert!(sh.read_binary_file(&one).unwrap() == sh.read_binary_file(&other).unwrap());

        let listing = cmd!(sh, "tar -tzf {one}").quiet().read().unwrap();
        let holds = |path: &str| listing.lines().any(|line| line == format!("icoray-{VERSION}/{path}"));
        assert!(holds("Cargo.lock") && holds(".cargo/config.toml") && !holds("packaging/"), "{listing}");

        let checksum = sha256(&workspace, &one).unwrap();
        assert!(checksum.len() == 64 && checksum.bytes().all(|digit| digit.is_ascii_hexdigit()), "{checksum}");
        for recipe in fill_recipes(&workspace, &checksum, directory.path()).unwrap() {
            let text = sh.read_file(&recipe).unwrap();
            assert!(text.contains(&checksum) && text.contains(VERSION), "{}: {text}", recipe.display());
            // Spack's `rust@1.2` is no placeholder.
            let mut after = text.split('@').skip(1);
            assert_eq!(after.find(|rest| rest.starts_with(char::is_uppercase)), None);
        }
    }

    #[test]
    fn the_citation_has_the_version_of_the_workspace() {
        let citation = Workspace::find().unwrap().shell.read_file("CITATION.cff").unwrap();
        assert!(citation.lines().any(|line| line == format!("version: {VERSION}")), "{citation}");
    }
}
