//! `query`: a table of footprints and half vectors in, the same with densities out.

use super::open;
use crate::args::QueryArgs;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use glintbake_bake::package::publish;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_runtime::Ndf;
use rayon::prelude::*;
use serde_json::json;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// The columns a table must have, in the order a query is built from.
const COLUMNS: [&str; 8] = ["u", "v", "e1u", "e1v", "e2u", "e2v", "s", "t"];

/// The column that is added.
const RESULT: &str = "ndf";

/// Answers every row of the table.
///
/// # Errors
/// [`Failure::Input`] or [`Failure::Content`] for the table, with the line; [`Failure::NotBaked`] and
/// [`Failure::Package`] for the package; [`Failure::Output`].
pub fn run(arguments: &QueryArgs, console: &Console) -> Result<(), CommandError> {
    let bytes = open::checked(&arguments.open)?;
    let package = open::package(&arguments.open.package, &bytes)?;
    let chosen = arguments.settings.choose(&package)?;
    let progress = console.progress("reading the queries");
    let table = Table::read(&arguments.queries)?;
    progress.set_message("evaluating");
    let densities = table
        .rows
        .par_iter()
        .map(|row| {
            let (footprint, half_vector) = row.query();
            chosen.ndf.eval(&footprint, half_vector).map_err(|error| {
                CommandError::from(error).in_file(format_args!(
                    "{}, line {}",
                    arguments.queries.display(),
                    row.line
                ))
            })
        })
        .collect::<Result<Vec<f64>, _>>()?;
    progress.finish_and_clear();
    match &arguments.output {
        Some(path) => {
            publish(path, |file| {
                table.write(
                    &mut io::BufWriter::new(file),
                    &chosen.description,
                    &densities,
                )
            })?;
            console.line(format_args!(
                "{}: {} rows, {}",
                path.display(),
                densities.len(),
                chosen.description
            ));
            console.document(&json!({
                "output": path.display().to_string(),
                "rows": densities.len(),
                "setting": chosen.description,
            }));
        }
        None => table
            .write(&mut io::stdout().lock(), &chosen.description, &densities)
            .or_else(|error| match error.kind() {
                // `glintbake query … | head` has all it wants.
                io::ErrorKind::BrokenPipe => Ok(()),
                _ => Err(CommandError::new(
                    Failure::Output,
                    format!("standard output: {error}"),
                )),
            })?,
    }
    Ok(())
}

/// One query, with the text it came from.
struct Row {
    line: u64,
    record: csv::StringRecord,
    values: [f64; COLUMNS.len()],
}

impl Row {
    fn query(&self) -> (Footprint, HalfVector) {
        let [u, v, e1u, e1v, e2u, e2v, s, t] = self.values;
        (
            Footprint {
                centre: [u, v],
                edge_1: [e1u, e1v],
                edge_2: [e2u, e2v],
            },
            HalfVector { s, t },
        )
    }
}

struct Table {
    header: csv::StringRecord,
    /// Where a `ndf` column of the input is, to be replaced instead of doubled.
    result: Option<usize>,
    rows: Vec<Row>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, CommandError> {
        let name = path.display();
        let file = File::open(path).map_err(|error| {
            CommandError::new(Failure::Input, format!("{name}: cannot be opened: {error}"))
        })?;
        let malformed = |error: csv::Error| {
            let failure = if error.is_io_error() {
                Failure::Input
            } else {
                Failure::Content
            };
            CommandError::new(failure, format!("{name}: {error}"))
        };
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(file);
        let header = reader.headers().map_err(malformed)?.clone();
        let mut places = [0; COLUMNS.len()];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            *place = header.iter().position(|name| name == column).ok_or_else(|| {
                CommandError::new(
                    Failure::Content,
                    format!(
                        "{name}: has no column {column}; the first line must name the columns {}",
                        COLUMNS.join(",")
                    ),
                )
            })?;
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(malformed)?;
            let line = record.position().map_or(0, csv::Position::line);
            let mut values = [0.0; COLUMNS.len()];
            for ((value, place), column) in values.iter_mut().zip(places).zip(COLUMNS) {
                let text = record.get(place).unwrap_or_default();
                *value = text.parse().map_err(|_| {
                    CommandError::new(
                        Failure::Content,
                        format!(
                            "{name}, line {line}: column {column} holds {text:?}, not a number"
                        ),
                    )
                })?;
            }
            rows.push(Row {
                line,
                record,
                values,
            });
        }
        Ok(Self {
            result: header.iter().position(|name| name == RESULT),
            header,
            rows,
        })
    }

    fn write(
        &self,
        output: &mut dyn Write,
        description: &str,
        densities: &[f64],
    ) -> io::Result<()> {
        writeln!(output, "# {description}")?;
        let mut writer = csv::Writer::from_writer(output);
        writer.write_record(self.with_result(&self.header, RESULT))?;
        for (row, density) in self.rows.iter().zip(densities) {
            writer.write_record(self.with_result(&row.record, &density.to_string()))?;
        }
        writer.flush()
    }

    /// The fields of `record`, its result set to `value`, or that added.
    fn with_result<'r>(&self, record: &'r csv::StringRecord, value: &'r str) -> Vec<&'r str> {
        let mut fields: Vec<&str> = record.iter().collect();
        match self.result.and_then(|place| fields.get_mut(place)) {
            Some(field) => *field = value,
            None => fields.push(value),
        }
        fields
    }
}
