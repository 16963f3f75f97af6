//! Reading `report.json`, and what must be true of the numbers in one.

use super::document::{Errors, FORMAT, MapReport, Report, Row, Timing, VERSION};
use serde::Deserialize;
use serde_json::Value;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes of the largest report that is read.
pub const LARGEST: u64 = 256 << 20;

/// Why a report cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file is larger than [`LARGEST`].
    #[error("larger than {} MiB, which no report is", LARGEST >> 20)]
    TooLarge,
    /// The file is no JSON document, or ends too early.
    #[error("not a JSON document: {0}")]
    NotJson(serde_json::Error),
    /// The document says to be of another format, or of none.
    #[error("not a report: its format is {}, not \"{FORMAT}\"", .0.as_ref().map_or("not given".to_owned(), Value::to_string))]
    Format(Option<Value>),
    /// The report is of another version.
    #[error(
        "a report of version {}, where this glintbake reads version {VERSION}; make it again with this glintbake, or \
         read it with the one that made it",
        .0.as_ref().map_or("unknown".to_owned(), Value::to_string)
    )]
    Version(Option<Value>),
    /// A field is missing or of another type.
    #[error("a damaged report: {0}")]
    Fields(serde_json::Error),
    /// A number is none, or out of its range.
    #[error("a damaged report: {0}")]
    Number(NumberError),
}

/// A number that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} of {place} is {value}, which it cannot be")]
pub struct NumberError {
    /// The field.
    pub field: &'static str,
    /// The map, contestant and cell it is of.
    pub place: String,
    /// Its value.
    pub value: f64,
}

/// What every version says of itself.
#[derive(Deserialize)]
struct Probe {
    format: Option<Value>,
    version: Option<Value>,
}

/// The report in the file at `path`, checked as [`check`] does.
///
/// # Errors
/// [`ReadError`]; its message does not name the file.
pub fn read(path: &Path) -> Result<Report, ReadError> {
    let file = File::open(path)?;
    // A report that grows while it is read, or a device without a length, ends here as well.
    let mut bytes = Vec::new();
    file.take(LARGEST + 1).read_to_end(&mut bytes)?;
    parse(&bytes)
}

/// The report in `bytes`, checked as [`check`] does.
///
/// # Errors
/// [`ReadError`], but not [`ReadError::Io`].
pub fn parse(bytes: &[u8]) -> Result<Report, ReadError> {
    if bytes.len() as u64 > LARGEST {
        return Err(ReadError::TooLarge);
    }
    let sort = |error: serde_json::Error| {
        if error.is_data() {
            ReadError::Fields(error)
        } else {
            ReadError::NotJson(error)
        }
    };
    // Of a document of another format or version, the fields would only be missing.
    let probe: Probe = serde_json::from_slice(bytes).map_err(|error| {
        if error.is_data() {
            ReadError::Format(None)
        } else {
            ReadError::NotJson(error)
        }
    })?;
    if probe.format.as_ref().and_then(Value::as_str) != Some(FORMAT) {
        return Err(ReadError::Format(probe.format));
    }
    if probe.version.as_ref().and_then(Value::as_u64) != Some(u64::from(VERSION)) {
        return Err(ReadError::Version(probe.version));
    }
    let report: Report = serde_json::from_slice(bytes).map_err(sort)?;
    check(&report).map_err(ReadError::Number)?;
    Ok(report)
}

/// Asserts that every number is finite and in its range: nothing is below 0, sizes and roughnesses are above it, and
/// quartiles lie on their sides of medians.
///
/// # Errors
/// [`NumberError`] names the first that is not.
pub fn check(report: &Report) -> Result<(), NumberError> {
    let resolution = report.head.clock_resolution_ns;
    at_least(0.0, "clock-resolution-ns", resolution, || "head".to_owned())?;
    report.maps.iter().try_for_each(check_map)
}

fn check_map(map: &MapReport) -> Result<(), NumberError> {
    for package in &map.packages {
        let place = || format!("{}, package of {}", map.name, package.contestant.name());
        at_least(0.0, "bytes-per-texel", package.bytes_per_texel, place)?;
        at_least(0.0, "bake-seconds", package.bake_seconds, place)?;
        if let Some(roughness) = package.roughness {
            at_least(f64::MIN_POSITIVE, "roughness", roughness, place)?;
        }
    }
    for row in &map.rows {
        check_row(row, || {
            format!(
                "{}, {} at σ {}, {}:1",
                map.name,
                row.contestant.name(),
                row.cell.sigma,
                row.cell.anisotropy
            )
        })?;
    }
    for sources in &map.sources {
        let place = || format!("{}, sources at σ {}", map.name, sources.sigma);
        at_least(f64::MIN_POSITIVE, "roughness", sources.roughness, place)?;
        at_least(f64::MIN_POSITIVE, "sigma", sources.sigma, place)?;
        for (field, value) in [
            ("centres", sources.centres),
            ("truncation-45", sources.truncation_45),
            ("truncation-21", sources.truncation_21),
            ("boundary", sources.boundary),
            ("published", sources.published),
            ("ours", sources.ours),
        ] {
            at_least(0.0, field, value, place)?;
        }
    }
    Ok(())
}

fn check_row(row: &Row, place: impl Fn() -> String + Copy) -> Result<(), NumberError> {
    at_least(f64::MIN_POSITIVE, "sigma", row.cell.sigma, place)?;
    at_least(1.0, "anisotropy", row.cell.anisotropy, place)?;
    if let Some(roughness) = row.cell.roughness {
        at_least(f64::MIN_POSITIVE, "roughness", roughness, place)?;
    }
    for errors in [Some(row.truth), row.model].into_iter().flatten() {
        let Errors {
            relative_l1,
            rms,
            percentile_99,
            worst,
            worst_unlit,
        } = errors;
        for (field, value) in [
            ("relative-l1", relative_l1),
            ("rms", rms),
            ("percentile-99", percentile_99),
            ("worst", worst),
            ("worst-unlit", Some(worst_unlit)),
        ] {
            at_least(0.0, field, value.unwrap_or(0.0), place)?;
        }
    }
    if let Some(energy) = row.energy {
        at_least(0.0, "share", energy.share, place)?;
        at_least(0.0, "standard-error", energy.standard_error, place)?;
    }
    let times = &row.times;
    let timings = [
        Some(times.eval),
        Some(times.eval_coherent),
        times.sample,
        times.pdf,
    ];
    for timing in timings.into_iter().flatten() {
        let Timing {
            median_ns,
            low_ns,
            high_ns,
            ..
        } = timing;
        at_least(0.0, "low-ns", low_ns, place)?;
        at_least(low_ns, "median-ns", median_ns, place)?;
        at_least(median_ns, "high-ns", high_ns, place)?;
    }
    at_least(
        0.0,
        "point-sampling-error",
        times.point_sampling_error.unwrap_or(0.0),
        place,
    )
}

fn at_least(
    least: f64,
    field: &'static str,
    value: f64,
    place: impl Fn() -> String,
) -> Result<(), NumberError> {
    if value.is_finite() && value >= least {
        Ok(())
    } else {
        Err(NumberError {
            field,
            place: place(),
            value,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;

    fn json(report: &Report) -> Value {
        serde_json::to_value(report).expect("a report is a document")
    }

    fn read_back(document: &Value) -> Result<Report, ReadError> {
        parse(document.to_string().as_bytes())
    }

    #[test]
    fn what_is_written_is_read() {
        let report = fixtures::report();
        assert_eq!(read_back(&json(&report)).unwrap(), report);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        std::fs::write(&path, json(&report).to_string()).unwrap();
        assert_eq!(read(&path).unwrap(), report);
    }

    #[test]
    fn rows_of_reports_without_surfaces_are_of_texels() {
        let report = fixtures::report();
        let mut document = json(&report);
        for row in document["maps"][0]["rows"].as_array_mut().unwrap() {
            row.as_object_mut().unwrap().remove("surface").unwrap();
        }
        assert_eq!(read_back(&document).unwrap(), report);
    }

    #[test]
    fn other_documents_are_told_apart() {
        let mut document = json(&fixtures::report());
        let bytes = document.to_string().into_bytes();
        let cut = parse(&bytes[..bytes.len() / 2]);
        assert!(matches!(cut, Err(ReadError::NotJson(_))), "{cut:?}");
        assert!(matches!(parse(b"glint"), Err(ReadError::NotJson(_))));
        assert!(matches!(parse(b"[1]"), Err(ReadError::Format(_))));
        assert!(matches!(parse(b"{}"), Err(ReadError::Format(None))));
        document["version"] = 2.into();
        let message = read_back(&document).unwrap_err().to_string();
        assert!(
            message.contains("version 2") && message.contains("version 1"),
            "{message}"
        );
        document["version"] = VERSION.into();
        document["format"] = "glintbake-suite".into();
        let message = read_back(&document).unwrap_err().to_string();
        assert!(message.contains("\"glintbake-suite\""), "{message}");
        let mut document = json(&fixtures::report());
        document["head"]["seed"] = "seven".into();
        assert!(matches!(read_back(&document), Err(ReadError::Fields(_))));
        // What would be written for a number that is none.
        document["head"]["seed"] = 7.into();
        document["maps"][0]["rows"][0]["times"]["eval"]["median-ns"] = Value::Null;
        assert!(matches!(read_back(&document), Err(ReadError::Fields(_))));
    }

    #[test]
    fn numbers_that_cannot_be_are_named() {
        type Spoil = fn(&mut Report);
        let spoiled: [(&str, Spoil); 6] = [
            ("relative-l1", |report| {
                report.maps[0].rows[3].truth.relative_l1 = Some(-0.1)
            }),
            ("relative-l1", |report| {
                report.maps[0].rows[3].truth.relative_l1 = Some(f64::NAN);
            }),
            ("high-ns", |report| {
                report.maps[0].rows[1].times.eval.high_ns = f64::INFINITY
            }),
            ("median-ns", |report| {
                report.maps[0].rows[1].times.eval.low_ns = 1e12
            }),
            ("sigma", |report| report.maps[0].rows[0].cell.sigma = 0.0),
            ("boundary", |report| {
                report.maps[0].sources[0].boundary = f64::NAN
            }),
        ];
        for (field, spoil) in spoiled {
            let mut report = fixtures::report();
            assert_eq!(check(&report), Ok(()));
            spoil(&mut report);
            let error = check(&report).unwrap_err();
            assert_eq!(error.field, field);
            assert!(error.to_string().contains("waves.png"), "{error}");
        }
    }
}
