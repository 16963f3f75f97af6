//! `report`: every method measured on maps of the user's own.

use super::paths;
use crate::args::ReportArgs;
use crate::exit::{CommandError, Failure};
use crate::measure::clock::Clock;
use crate::measure::machine;
use crate::measure::plan::Plan;
use crate::measure::run::{MeasureError, Step, measure};
use crate::output::{Bar, Console};
use crate::report;
use crate::report::compare::compare;
use crate::report::document::{FORMAT, Head, MapReport, Report, VERSION};
use crate::report::read::read;
use glintbake_bake::image::{HashedFile, InputFile};
use glintbake_bake::normals::{self, NormalMap};
use serde_json::json;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// What has been measured is written after each cell, unless so many times what the last writing took has not passed.
const SAVE_AFTER: u32 = 10;

/// Measures, and writes the report after every few cells, so that an interruption loses little.
///
/// # Errors
/// [`Failure::Usage`] for the plan, those of reading for the images, [`Failure::Output`], and [`Failure::Findings`] if
/// something is worse than `--fail-on` allows.
pub fn run(arguments: &ReportArgs, console: &Console) -> Result<(), CommandError> {
    let plan = arguments.plan()?;
    let folder = &arguments.output;
    let is_new = check_folder(folder)?;
    let before = arguments.compare.as_deref().map(read_before).transpose()?;
    let maps = read_maps(arguments, console)?;
    if is_new {
        fs::create_dir(folder).map_err(|error| cannot_use(folder, &error.to_string()))?;
    }
    let clock = Clock::new(plan.effort.seconds, plan.effort.repetitions);
    let mut whole = Report {
        format: FORMAT.to_owned(),
        version: VERSION,
        complete: false,
        head: head(&plan, clock),
        maps: Vec::new(),
    };
    let mut saver = Saver {
        folder,
        next: Instant::now(),
    };
    for (input, map) in &maps {
        let blake3 = input.blake3.iter().map(|byte| format!("{byte:02x}"));
        let blake3 = blake3.collect();
        let map_report = MapReport::new(input.name.clone(), blake3, map.width(), map.height());
        whole.maps.push(map_report);
        let bar = console.bar("measuring", &input.name);
        measure_map(map, &plan, clock, &mut whole, &bar, &mut saver)?;
    }
    whole.complete = true;
    let files = report::write_all(&whole, folder)?;
    console.line(report::table::text(&whole));
    for file in &files {
        console.line(file.display());
    }
    let comparison = before.map(|before| compare(&before, &whole));
    let violations = match (&comparison, &arguments.fail_on) {
        (Some(comparison), Some(limits)) => comparison.violations(limits),
        _ => Vec::new(),
    };
    let mut document = json!(whole);
    if let Some(comparison) = &comparison {
        console.line(comparison);
        document["comparison"] = comparison.to_json();
        document["violations"] = json!(violations);
    }
    console.document(&document);
    match violations.as_slice() {
        [] => Ok(()),
        [first, others @ ..] => {
            let others = match others.len() {
                0 => String::new(),
                count => format!(", and {count} more"),
            };
            let message = format!("--fail-on: {first}{others}");
            Err(CommandError::new(Failure::Findings, message))
        }
    }
}

/// The report to compare with, read before this one may replace it.
fn read_before(path: &Path) -> Result<Report, CommandError> {
    read(path).map_err(|error| {
        CommandError::new(Failure::Input, error.to_string()).in_file(path.display())
    })
}

/// Refuses a folder that reports could not be written to, before anything is measured; whether it is still to be made.
fn check_folder(folder: &Path) -> Result<bool, CommandError> {
    if folder.is_dir() {
        let files = report::FILES.map(|name| folder.join(name));
        let outputs: Vec<_> = files
            .iter()
            .map(|file| ("--output", file.as_path()))
            .collect();
        paths::check(None, &outputs)?;
        return Ok(false);
    }
    if folder.exists() {
        return Err(cannot_use(folder, "it is a file; name a folder"));
    }
    paths::check(None, &[("--output", folder)])?;
    Ok(true)
}

fn cannot_use(folder: &Path, reason: &str) -> CommandError {
    let message = format!("--output {}: {reason}", folder.display());
    CommandError::new(Failure::Output, message)
}

/// The maps, in the order of the command line.
fn read_maps(
    arguments: &ReportArgs,
    console: &Console,
) -> Result<Vec<(InputFile, NormalMap)>, CommandError> {
    let stages = console.stages();
    let recipe = arguments.decode.recipe();
    arguments
        .images
        .iter()
        .map(|image| {
            let file = HashedFile::open(image, &stages)?;
            let (map, _) = normals::read(&file, &recipe.read_options(), &recipe.decode, &stages)?;
            Ok((file.identity().clone(), map))
        })
        .collect()
}

/// Writes what there is of a report, often enough that an interruption loses little, rarely enough to cost little.
struct Saver<'f> {
    folder: &'f Path,
    next: Instant,
}

impl Saver<'_> {
    fn save<'r>(&mut self, report: impl FnOnce() -> &'r Report) -> Result<(), CommandError> {
        let start = Instant::now();
        if start >= self.next {
            report::write_all(report(), self.folder)?;
            self.next = start + SAVE_AFTER * start.elapsed();
        }
        Ok(())
    }
}

fn measure_map(
    map: &NormalMap,
    plan: &Plan,
    clock: Clock,
    whole: &mut Report,
    bar: &Bar,
    saver: &mut Saver<'_>,
) -> Result<(), CommandError> {
    let Some(mut current) = whole.maps.pop() else {
        return Ok(());
    };
    whole.maps.push(current.clone());
    let mut listen = |so_far: &MapReport, Step { done, total }: Step| {
        bar.set(done as u64, total as u64);
        saver.save(|| {
            if let Some(last) = whole.maps.last_mut() {
                last.clone_from(so_far);
            }
            &*whole
        })
    };
    measure(map, plan, clock, &mut current, &mut listen)?;
    if let Some(last) = whole.maps.last_mut() {
        *last = current;
    }
    Ok(())
}

fn head(plan: &Plan, clock: Clock) -> Head {
    Head {
        glintbake: env!("CARGO_PKG_VERSION").to_owned(),
        command: command_line(std::env::args_os()),
        seed: plan.seed,
        processor: machine::processor(),
        threads: rayon::current_num_threads(),
        target: machine::target(),
        target_features: machine::target_features(),
        compiler: env!("GLINTBAKE_COMPILER").to_owned(),
        optimised: !cfg!(debug_assertions),
        clock_resolution_ns: clock.step * 1e9,
    }
}

/// The command line, each file by its name alone: where files lie is nobody's concern but their owner's.
fn command_line(arguments: impl Iterator<Item = impl AsRef<OsStr>>) -> String {
    let words: Vec<_> = arguments
        .enumerate()
        .map(|(place, argument)| {
            let path = Path::new(&argument);
            let word = if place == 0 {
                "glintbake".as_ref()
            } else {
                path.file_name().unwrap_or(argument.as_ref())
            };
            word.to_string_lossy().into_owned()
        })
        .collect();
    words.join(" ")
}

impl From<MeasureError> for CommandError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Bake(error) => error.into(),
            MeasureError::Query(error) => error.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_stay_out_of_the_command_line() {
        let line = [
            "a/glintbake",
            "report",
            "b/c/map.png",
            "-o",
            "d/e",
            "--quick",
        ];
        assert_eq!(
            command_line(line.into_iter()),
            "glintbake report map.png -o e --quick"
        );
    }
}
