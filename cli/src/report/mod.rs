//! Reports of error against run time: what is in one, and the forms it is written in.

pub mod document;

use document::Report;
use glintbake_bake::package::{PublishError, publish};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What [`write_all`] writes.
pub const FILES: [&str; 1] = ["report.json"];

/// Writes report.json.
///
/// # Errors
/// [`PublishError`].
pub fn write_all(report: &Report, folder: &Path) -> Result<Vec<PathBuf>, PublishError> {
    let path = folder.join("report.json");
    publish(&path, |file| {
        serde_json::to_writer_pretty(&mut *file, report)?;
        file.write_all(b"\n")
    })?;
    Ok(vec![path])
}
