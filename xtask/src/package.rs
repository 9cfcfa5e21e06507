//! `cargo xtask package`: the source archive of a release, and the recipes of package managers that have its checksum, by
//! `packaging/package.sh`.

use std::path::Path;

use xshell::Cmd;

use crate::error::Error;
use crate::step::Steps;
use crate::workspace::Workspace;

/// Writes the archive and the recipes to `target/package`.
pub fn run(workspace: &Workspace) -> Result<(), Error> {
    let package = package(workspace, &workspace.products("package"));
    Steps::new(1).run("packing the commit", |step| step.echoed(package, || {}).1)
}

/// The command that writes them to a directory.
fn package<'a>(workspace: &'a Workspace, directory: &Path) -> Cmd<'a> {
    // Not in archives, of which this program can be built.
    workspace.shell.cmd("bash").arg("packaging/package.sh").arg(directory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::install::VERSION;
    use xshell::cmd;

    #[test]
    fn archives_of_a_commit_are_equal_and_recipes_have_their_checksum() {
        let workspace = Workspace::find().unwrap();
        if !workspace.root.join(".git").exists() {
            return println!("skipped: the sources are not a clone");
        }
        let sh = &workspace.shell;
        let scratch = sh.create_temp_dir().unwrap();
        let [one, other] = ["one", "other"].map(|name| {
            let directory = scratch.path().join(name);
            package(&workspace, &directory).quiet().ignore_stdout().run().unwrap();
            directory
        });
        let archive = |directory: &Path| directory.join(format!("icoray-{VERSION}.tar.gz"));
        assert!(sh.read_binary_file(archive(&one)).unwrap() == sh.read_binary_file(archive(&other)).unwrap());

        let archive = archive(&one);
        let listing = cmd!(sh, "tar -tzf {archive}").quiet().read().unwrap();
        let holds = |path: &str| listing.lines().any(|line| line == format!("icoray-{VERSION}/{path}"));
        assert!(holds("Cargo.lock") && holds(".cargo/config.toml") && !holds("packaging/"), "{listing}");

        let line = cmd!(sh, "sha256sum {archive}").quiet().read().unwrap();
        let checksum = line.split_whitespace().next().unwrap();
        assert!(checksum.len() == 64 && checksum.bytes().all(|digit| digit.is_ascii_hexdigit()), "{checksum}");
        for recipe in ["spack/package.py", "conda/recipe.yaml"] {
            let text = sh.read_file(one.join(recipe)).unwrap();
            assert!(text.contains(checksum) && text.contains(VERSION), "{recipe}: {text}");
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
