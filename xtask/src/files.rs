//! Finds files by patterns.

use std::path::{Path, PathBuf};

use glob::Pattern;

/// The paths below a directory that fit a pattern, sorted. Directories that cannot be read count as empty.
pub fn fitting(directory: &Path, pattern: &str) -> Vec<PathBuf> {
    let directory = Pattern::escape(&directory.to_string_lossy());
    glob::glob(&format!("{directory}/{pattern}")).into_iter().flatten().flatten().collect()
}

pub fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
