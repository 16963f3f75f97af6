//! Reports of error against run time: what is in one, the forms it is written in, and how two compare.

pub mod compare;
pub mod csv;
pub mod document;
pub mod html;
pub mod markup;
pub mod panel;
pub mod pareto;
pub mod plot;
pub mod read;
pub mod table;
pub mod units;

#[cfg(test)]
pub(crate) mod fixtures;

use document::Report;
use glintbake_bake::package::{PublishError, publish};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What [`write_all`] writes.
pub const FILES: [&str; 3] = ["report.json", "report.csv", "report.html"];

/// Writes `report.json`, `report.csv` and `report.html` into `folder`, each whole or not at all; returns their paths.
///
/// # Errors
/// [`PublishError`] if a file cannot be written, or, before any is, if a number of the report fails [`read::check`]: no
/// reader would take it back.
pub fn write_all(report: &Report, folder: &Path) -> Result<Vec<PathBuf>, PublishError> {
    let paths = FILES.map(|name| folder.join(name));
    let invalid = |error: io::Error| PublishError {
        path: paths[0].clone(),
        source: error,
    };
    read::check(report)
        .map_err(|error| invalid(io::Error::new(io::ErrorKind::InvalidData, error)))?;
    let mut document =
        serde_json::to_vec_pretty(report).map_err(|error| invalid(io::Error::from(error)))?;
    document.push(b'\n');
    let contents = [
        document,
        csv::text(report).into_bytes(),
        html::page(report).into_bytes(),
    ];
    for (path, content) in paths.iter().zip(&contents) {
        publish(path, |file| file.write_all(content))?;
    }
    Ok(paths.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_files_are_written_and_the_first_is_read_back() {
        let report = fixtures::report();
        let folder = tempfile::tempdir().unwrap();
        let paths = write_all(&report, folder.path()).unwrap();
        let names: Vec<_> = paths.iter().filter_map(|path| path.file_name()).collect();
        assert_eq!(names, FILES);
        assert_eq!(read::read(&paths[0]).unwrap(), report);
        let csv = std::fs::read_to_string(&paths[1]).unwrap();
        assert_eq!(csv.lines().count(), report.maps[0].rows.len() + 1);
        let html = std::fs::read_to_string(&paths[2]).unwrap();
        assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
    }

    #[test]
    fn a_number_that_is_none_is_refused_and_old_files_stay() {
        let mut report = fixtures::report();
        let folder = tempfile::tempdir().unwrap();
        write_all(&report, folder.path()).unwrap();
        let before = std::fs::read(folder.path().join("report.json")).unwrap();
        report.head.seed = 8;
        report.maps[0].rows[0].truth.rms = Some(f64::NAN);
        let error = write_all(&report, folder.path()).unwrap_err().to_string();
        assert!(error.contains("rms of waves.png"), "{error}");
        assert_eq!(
            std::fs::read(folder.path().join("report.json")).unwrap(),
            before
        );
    }
}
