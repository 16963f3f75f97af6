//! `query`: a table of footprints and half vectors in, the same with densities out.

use super::{lattice, open, paths};
use crate::args::QueryArgs;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use glintbake_bake::package::publish;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_runtime::{Accuracy, Ndf, QueryError, SurfaceNdf};
use rayon::prelude::*;
use serde_json::json;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// The columns a table must have, in the order a query is built from.
const COLUMNS: [&str; 8] = ["u", "v", "e1u", "e1v", "e2u", "e2v", "s", "t"];

/// What lines that are no rows begin with.
const COMMENT: u8 = b'#';

/// The column that is added.
const RESULT: &str = "ndf";

/// The one that strict answers add as well.
const BOUND: &str = "ndf-bound";

/// Answers every row of the table.
///
/// # Errors
/// [`Failure::Usage`] for `--strict` of what has no bounds; [`Failure::Input`] or [`Failure::Content`] for the table,
/// with the line; [`Failure::NotBaked`] and [`Failure::Package`] for the package; [`Failure::Output`].
pub fn run(arguments: &QueryArgs, console: &Console) -> Result<(), CommandError> {
    let path = &arguments.open.package;
    if let Some(output) = &arguments.output {
        // The table itself may be replaced: it is read as a whole before, and its rows are in the new one.
        paths::check(Some(path), &[("--output", output)])?;
    }
    let bytes = open::checked(&arguments.open)?;
    let choose = if arguments.strict {
        open::choose_strict
    } else {
        open::choose
    };
    let chosen = choose(&arguments.open, &arguments.settings, &bytes)?;
    let progress = console.progress("reading the queries");
    let table = Table::read(&arguments.queries)?;
    progress.set_message("evaluating");
    let answers: Vec<_> = table
        .rows
        .par_iter()
        .map(|row| {
            let (footprint, half_vector) = row.query();
            Answer::to(&chosen.ndf, &footprint, half_vector)
        })
        .collect();
    // Looked through in order, so that the first bad line is named whichever thread met one first.
    let answers = table
        .rows
        .iter()
        .zip(answers)
        .map(|(row, answer)| answer.map_err(|error| refused(error, arguments, row.line)))
        .collect::<Result<Vec<Answer>, _>>()?;
    progress.finish_and_clear();
    lattice::warn_of_query(console, &arguments.open, &chosen, &bytes);
    match &arguments.output {
        Some(path) => {
            publish(path, |file| {
                table.write(
                    &mut io::BufWriter::new(file),
                    &chosen.description,
                    &answers,
                    arguments.strict,
                )
            })?;
            let mut document = json!({
                "output": path.display().to_string(),
                "rows": answers.len(),
                "setting": chosen.description,
            });
            let mut of_bounds = String::new();
            if let SurfaceNdf::ClusterTree(tree) = &chosen.ndf
                && arguments.strict
            {
                let proof = Proof::of(&answers, tree.accuracy().eps());
                document["greatest-bound"] = json!(proof.greatest);
                document["rows-within-eps"] = json!(proof.within);
                of_bounds = format!(
                    ", bounds up to {}, {} within eps",
                    shortest(proof.greatest),
                    proof.within
                );
            }
            console.line(format_args!(
                "{}: {} rows{of_bounds}, {}",
                path.display(),
                answers.len(),
                chosen.description
            ));
            console.document(&document);
        }
        None => table
            .write(
                &mut io::stdout().lock(),
                &chosen.description,
                &answers,
                arguments.strict,
            )
            .or_else(|error| match error.kind() {
                // `glintbake query … | head` has all it wants.
                io::ErrorKind::BrokenPipe => Ok(()),
                _ => Err(CommandError::new(
                    Failure::Output,
                    format!("cannot write to standard output: {error}"),
                )),
            })?,
    }
    Ok(())
}

/// What a row is answered with.
#[derive(Clone, Copy, Debug)]
struct Answer {
    density: f64,
    /// How far it can be from the sum over texels, of a strict answer.
    bound: Option<f64>,
}

impl Answer {
    fn to(
        ndf: &SurfaceNdf<'_>,
        footprint: &Footprint,
        half_vector: HalfVector,
    ) -> Result<Self, QueryError> {
        if let SurfaceNdf::ClusterTree(tree) = ndf
            && let Accuracy::Strict(_) = tree.accuracy()
        {
            let bounded = tree.eval_bounded(footprint, half_vector)?;
            return Ok(Self {
                density: bounded.density,
                bound: Some(bounded.bound),
            });
        }
        let density = ndf.eval(footprint, half_vector)?;
        Ok(Self {
            density,
            bound: None,
        })
    }
}

/// What the bounds of a table come to.
#[derive(Clone, Copy, Debug)]
struct Proof {
    greatest: f64,
    /// Rows whose bound is at most the share of the density that was asked for.
    within: usize,
}

impl Proof {
    fn of(answers: &[Answer], eps: f64) -> Self {
        let bounds = || {
            let with_bound = |answer: &Answer| Some((answer.density, answer.bound?));
            answers.iter().filter_map(with_bound)
        };
        Self {
            greatest: bounds().fold(0.0, |most: f64, (_, bound)| most.max(bound)),
            within: bounds()
                .filter(|(density, bound)| *bound <= eps * density)
                .count(),
        }
    }
}

/// Why a row has no answer, with the file that is to blame: the package if it is damaged, else the table's line.
fn refused(error: QueryError, arguments: &QueryArgs, line: u64) -> CommandError {
    let error = CommandError::from(error);
    if error.failure == Failure::Package {
        return error.in_file(arguments.open.package.display());
    }
    error.in_file(format_args!("{}, line {line}", arguments.queries.display()))
}

/// What is wrong with the table at `path`, in terms of its lines.
fn malformed(path: &Path, text: &[u8], error: &csv::Error) -> CommandError {
    let name = path.display();
    let line = line_of(text, error.position());
    let message = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!(
            "{name}, line {line}: has {len} fields where the first line names {expected_len} columns"
        ),
        csv::ErrorKind::Utf8 { .. } => {
            format!("{name}, line {line}: is not UTF-8 text; save the table as UTF-8")
        }
        _ => format!("{name}, line {line}: {error}"),
    };
    CommandError::new(Failure::Content, message)
}

/// The line, counted from 1, on which the record begins that the reader began to look for at `start`.
fn line_of(text: &[u8], start: Option<&csv::Position>) -> u64 {
    let Some(start) = start else { return 1 };
    let mut line = start.line();
    let mut rest = text.get(start.byte() as usize..).unwrap_or_default();
    loop {
        let skipped = match rest.first() {
            Some(b'\r') => 1,
            Some(b'\n') => {
                line += 1;
                1
            }
            Some(&COMMENT) => rest
                .iter()
                .position(|&byte| byte == b'\n')
                .unwrap_or(rest.len()),
            _ => return line,
        };
        rest = &rest[skipped..];
    }
}

/// The system's error inside of `error`, its kind kept: a closed pipe and a full disk have to be told apart.
fn as_io(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
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
    /// Likewise of a `ndf-bound` column, which is emptied if answers are not strict: an older bound is not theirs.
    bound: Option<usize>,
    rows: Vec<Row>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, CommandError> {
        let name = path.display();
        let mut text = fs::read(path).map_err(|error| {
            CommandError::new(Failure::Input, format!("{name}: cannot be read: {error}"))
        })?;
        // The CSV reader takes a comment for a row if the file ends before the line does.
        text.push(b'\n');
        let malformed = |error| malformed(path, &text, &error);
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(COMMENT))
            .trim(csv::Trim::Headers)
            .from_reader(text.as_slice());
        let header = reader.headers().map_err(malformed)?.clone();
        let column = |column: &str| {
            let mut places = (0..).zip(&header).filter(|&(_, name)| name == column);
            match (places.next(), places.next()) {
                (Some((place, _)), None) => Ok(Some(place)),
                (None, _) => Ok(None),
                (Some(_), Some(_)) => Err(CommandError::new(
                    Failure::Content,
                    format!("{name}: has two columns {column}; rename one of them"),
                )),
            }
        };
        let mut places = [0; COLUMNS.len()];
        for (place, wanted) in places.iter_mut().zip(COLUMNS) {
            *place = column(wanted)?.ok_or_else(|| {
                CommandError::new(
                    Failure::Content,
                    format!(
                        "{name}: has no column {wanted}; the first line must name the columns {}",
                        COLUMNS.join(",")
                    ),
                )
            })?;
        }
        let (result, bound) = (column(RESULT)?, column(BOUND)?);
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(malformed)?;
            let line = line_of(&text, record.position());
            let mut values = [0.0; COLUMNS.len()];
            for ((value, place), column) in values.iter_mut().zip(places).zip(COLUMNS) {
                let text = record.get(place).unwrap_or_default().trim();
                let wrong = match text.parse::<f64>() {
                    Ok(number) if number.is_finite() => {
                        *value = number;
                        continue;
                    }
                    Ok(_) => "not a finite number",
                    Err(_) => "not a number",
                };
                return Err(CommandError::new(
                    Failure::Content,
                    format!("{name}, line {line}: column {column} holds {text:?}, {wrong}"),
                ));
            }
            rows.push(Row {
                line,
                record,
                values,
            });
        }
        Ok(Self {
            result,
            bound,
            header,
            rows,
        })
    }

    fn write(
        &self,
        output: &mut dyn Write,
        description: &str,
        answers: &[Answer],
        strict: bool,
    ) -> io::Result<()> {
        writeln!(output, "# {description}")?;
        let mut writer = csv::WriterBuilder::new()
            // Quotes fields that would begin a comment, so that the table can be read back.
            .comment(Some(COMMENT))
            .from_writer(output);
        let has_bound = strict || self.bound.is_some();
        writer
            .write_record(self.with_results(&self.header, RESULT, has_bound.then_some(BOUND)))
            .map_err(as_io)?;
        for (row, answer) in self.rows.iter().zip(answers) {
            let density = shortest(answer.density);
            let bound = answer.bound.map(shortest).unwrap_or_default();
            writer
                .write_record(self.with_results(&row.record, &density, has_bound.then_some(&bound)))
                .map_err(as_io)?;
        }
        writer.flush()
    }

    /// The fields of `record`, its results set to `density` and, if there is to be one, `bound`, or these added.
    fn with_results<'r>(
        &self,
        record: &'r csv::StringRecord,
        density: &'r str,
        bound: Option<&'r str>,
    ) -> Vec<&'r str> {
        let mut fields: Vec<&str> = record.iter().collect();
        for (place, value) in [(self.result, Some(density)), (self.bound, bound)] {
            let Some(value) = value else { continue };
            match place.and_then(|place| fields.get_mut(place)) {
                Some(field) => *field = value,
                None => fields.push(value),
            }
        }
        fields
    }
}

/// The shortest text that reads back as `value`: plain where that is short, else with an exponent.
fn shortest(value: f64) -> String {
    if value == 0.0 || (1e-4..1e15).contains(&value) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
