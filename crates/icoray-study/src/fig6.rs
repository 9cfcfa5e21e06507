//! fig6
/// Options.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {}
/// Runs.
///
/// # Errors
/// Whatever the library says.
pub fn run(_: &Options) -> icoray::Result<()> {
    Ok(())
}
