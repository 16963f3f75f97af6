//! `report.csv`: one line for each row of every map, all numbers flat.

use super::document::{Errors, HalfVectors, MapReport, Report, Role, Row, Timing};
use super::panel;

/// The header, in this order; docs/REPORT.md says what each column is.
pub const COLUMNS: [&str; 56] = [
    "map",
    "blake3",
    "width",
    "height",
    "role",
    "method",
    "variant",
    "kernel",
    "filter",
    "roughness",
    "sigma",
    "anisotropy",
    "half-vectors",
    "queries",
    "lit",
    "truth-relative-l1",
    "truth-rms",
    "truth-percentile-99",
    "truth-worst",
    "truth-worst-unlit",
    "model-relative-l1",
    "model-rms",
    "model-percentile-99",
    "model-worst",
    "model-worst-unlit",
    "energy-share",
    "energy-standard-error",
    "eval-median-ns",
    "eval-low-ns",
    "eval-high-ns",
    "eval-repetitions",
    "eval-calls",
    "eval-coherent-median-ns",
    "eval-coherent-low-ns",
    "eval-coherent-high-ns",
    "eval-coherent-repetitions",
    "eval-coherent-calls",
    "sample-median-ns",
    "sample-low-ns",
    "sample-high-ns",
    "sample-repetitions",
    "sample-calls",
    "pdf-median-ns",
    "pdf-low-ns",
    "pdf-high-ns",
    "pdf-repetitions",
    "pdf-calls",
    "point-sampling-error",
    "package-roughness",
    "package-bytes",
    "package-bytes-per-texel",
    "bake-seconds",
    "bake-peak-bytes",
    "glintbake",
    "seed",
    "surface",
];

/// The file, UTF-8 with a header; a cell without a value is empty. Numbers have as many digits as they need to be read
/// back unchanged.
pub fn text(report: &Report) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(COLUMNS)
        .expect("memory takes any record");
    for map in &report.maps {
        for row in &map.rows {
            writer
                .write_record(record(report, map, row))
                .expect("every record has a field for each column");
        }
    }
    let bytes = writer.into_inner().expect("memory takes any record");
    String::from_utf8(bytes).expect("all fields are text")
}

fn record(report: &Report, map: &MapReport, row: &Row) -> Vec<String> {
    let cell = &row.cell;
    let role = match row.contestant.role {
        Role::Method => "method",
        Role::Paper => "paper",
        Role::Baseline => "baseline",
    };
    let half_vectors = match cell.half_vectors {
        HalfVectors::Found => "found",
        HalfVectors::Uniform => "uniform",
    };
    let mut record = vec![
        map.name.clone(),
        map.blake3.clone(),
        map.width.to_string(),
        map.height.to_string(),
        role.to_owned(),
        row.contestant.method.clone(),
        row.contestant.variant.clone(),
        row.kernel.clone(),
        cell.filter.clone(),
        optional(cell.roughness),
        cell.sigma.to_string(),
        cell.anisotropy.to_string(),
        half_vectors.to_owned(),
        row.queries.to_string(),
        row.lit.to_string(),
    ];
    record.extend(errors(Some(&row.truth)));
    record.extend(errors(row.model.as_ref()));
    record.push(optional(row.energy.map(|energy| energy.share)));
    record.push(optional(row.energy.map(|energy| energy.standard_error)));
    let times = &row.times;
    for timing in [
        Some(times.eval),
        Some(times.eval_coherent),
        times.sample,
        times.pdf,
    ] {
        record.extend(timed(timing));
    }
    record.push(optional(times.point_sampling_error));
    let package = panel::package(map, &row.contestant, cell.roughness);
    record.extend([
        optional(package.and_then(|package| package.roughness)),
        optional(package.map(|package| package.bytes)),
        optional(package.map(|package| package.bytes_per_texel)),
        optional(package.map(|package| package.bake_seconds)),
        optional(package.and_then(|package| package.bake_peak_bytes)),
        report.head.glintbake.clone(),
        report.head.seed.to_string(),
        row.surface.clone(),
    ]);
    record
}

fn optional(value: Option<impl ToString>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn errors(errors: Option<&Errors>) -> [String; 5] {
    [
        optional(errors.and_then(|errors| errors.relative_l1)),
        optional(errors.and_then(|errors| errors.rms)),
        optional(errors.and_then(|errors| errors.percentile_99)),
        optional(errors.and_then(|errors| errors.worst)),
        optional(errors.map(|errors| errors.worst_unlit)),
    ]
}

fn timed(timing: Option<Timing>) -> [String; 5] {
    [
        optional(timing.map(|timing| timing.median_ns)),
        optional(timing.map(|timing| timing.low_ns)),
        optional(timing.map(|timing| timing.high_ns)),
        optional(timing.map(|timing| timing.repetitions)),
        optional(timing.map(|timing| timing.calls)),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;

    #[test]
    fn every_row_is_a_line_and_numbers_come_back_unchanged() {
        let mut report = fixtures::report();
        report.maps[0].name = "a, \"b\"\n.png".to_owned();
        let text = text(&report);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        assert_eq!(reader.headers().expect("a header"), COLUMNS.as_slice());
        let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let map = &report.maps[0];
        assert_eq!(records.len(), map.rows.len());
        let column = |name: &str| COLUMNS.iter().position(|column| *column == name).unwrap();
        for (record, row) in records.iter().zip(&map.rows) {
            let number = |name: &str| record[column(name)].parse::<f64>().ok();
            assert_eq!(&record[0], map.name);
            assert_eq!(number("truth-relative-l1"), row.truth.relative_l1);
            assert_eq!(number("truth-worst-unlit"), Some(row.truth.worst_unlit));
            assert_eq!(
                number("model-worst"),
                row.model.and_then(|model| model.worst)
            );
            assert_eq!(number("roughness"), row.cell.roughness);
            assert_eq!(
                number("pdf-high-ns"),
                row.times.pdf.map(|timing| timing.high_ns)
            );
            assert_eq!(
                number("eval-coherent-median-ns"),
                Some(row.times.eval_coherent.median_ns)
            );
            assert_eq!(
                number("point-sampling-error"),
                row.times.point_sampling_error
            );
            let package = panel::package(map, &row.contestant, row.cell.roughness).unwrap();
            assert_eq!(number("package-bytes"), Some(package.bytes as f64));
            assert_eq!(number("bake-seconds"), Some(package.bake_seconds));
            assert_eq!(number("seed"), Some(7.0));
        }
    }

    #[test]
    fn every_column_is_documented() {
        let document = include_str!("../../../docs/REPORT.md");
        for column in COLUMNS {
            // Four columns of a kind are documented once, by what they end in.
            let is_documented = document.contains(&format!("`{column}`"))
                || [
                    "truth-",
                    "model-",
                    "eval-coherent-",
                    "eval-",
                    "sample-",
                    "pdf-",
                ]
                .iter()
                .filter_map(|kind| column.strip_prefix(kind))
                .any(|end| document.contains(&format!("`…-{end}`")));
            assert!(is_documented, "{column}");
        }
    }
}
