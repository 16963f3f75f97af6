//! `stress`: stiff and extreme cases against the oracles.

use super::open;
use crate::args::StressArgs;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use crate::stress::maps::{self, NamedMap};
use crate::stress::{self, Outcome, QUICK_ROUGHNESSES, ROUGHNESSES, Verdict, table};
use glintbake_bake::image::HashedFile;
use glintbake_bake::normals;
use glintbake_format::{Fault, check};
use glintbake_runtime::Package;
use std::path::Path;

/// The most texels of a map: beyond, the oracles would take minutes.
const MOST_TEXELS: u64 = 1 << 24;

/// Runs the checks and prints what came of them.
///
/// # Errors
/// [`Failure::Findings`] if anything failed; as `verify` and `bake` if the input cannot be read.
pub fn run(arguments: &StressArgs, console: &Console) -> Result<(), CommandError> {
    let bar = console.bar("testing", "");
    let tick = |done, total| bar.set(done, total);
    let roughnesses: &[f64] = if arguments.quick {
        &QUICK_ROUGHNESSES
    } else {
        &ROUGHNESSES
    };
    let (name, outcomes) = match &arguments.subject {
        None => {
            let maps = maps::built_in(arguments.quick);
            let outcomes = stress::on_maps(&maps, roughnesses, &tick);
            ("built-in maps".to_owned(), outcomes)
        }
        Some(path) => {
            let outcomes = match in_package(path, &tick)? {
                Some(outcomes) => outcomes,
                None => stress::on_maps(&[read_map(path, arguments)?], roughnesses, &tick),
            };
            (path.display().to_string(), outcomes)
        }
    };
    drop(bar);
    report(console, &name, &outcomes)
}

/// The outcomes of the package at `path`, or `None` if the file does not begin as one does.
fn in_package(
    path: &Path,
    tick: &(dyn Fn(u64, u64) + Sync),
) -> Result<Option<Vec<Outcome>>, CommandError> {
    let bytes = open::bytes(path, false)?;
    let package = match Package::open(&bytes) {
        Err(finding) if matches!(finding.fault, Fault::NotAPackage) => return Ok(None),
        _ => open::package(path, &bytes)?,
    };
    let mut first = None;
    check::full(package.container(), &mut |finding| {
        first.get_or_insert(finding);
    });
    if let Some(finding) = first {
        return Err(CommandError::from(finding).in_file(path.display()));
    }
    let outcomes = stress::on_package(&path.display().to_string(), &package, tick)
        .map_err(|error| CommandError::from(error).in_file(path.display()))?;
    Ok(Some(outcomes))
}

fn read_map(path: &Path, arguments: &StressArgs) -> Result<NamedMap, CommandError> {
    let recipe = arguments.decode.recipe();
    let mut options = recipe.read_options();
    options.limits.texels = MOST_TEXELS;
    let file = HashedFile::open(path, &())?;
    let (map, _) = normals::read(&file, &options, &recipe.decode, &())?;
    Ok(NamedMap {
        name: path.display().to_string(),
        map,
    })
}

fn report(console: &Console, name: &str, outcomes: &[Outcome]) -> Result<(), CommandError> {
    for line in table::lines(outcomes) {
        console.line(line);
    }
    for remark in table::remarks(outcomes) {
        if remark.starts_with(Verdict::Fail.name()) {
            console.result(remark);
        } else {
            console.line(remark);
        }
    }
    console.document(&table::document(name, outcomes));
    match table::count(outcomes, Verdict::Fail) {
        0 => {
            console.line(format_args!(
                "{name}: {} checks pass, {} refuse as they must, {} skipped",
                table::count(outcomes, Verdict::Pass),
                table::count(outcomes, Verdict::Refused),
                table::count(outcomes, Verdict::Skipped)
            ));
            Ok(())
        }
        failed => Err(CommandError::new(
            Failure::Findings,
            format!(
                "{name}: {failed} of {} checks FAIL; please report them with the lines above",
                outcomes.len()
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_failure_among_passes_ends_with_the_exit_code_for_findings() {
        let console = Console::new(true, false);
        let skipped = || Outcome::skipped("energy", "it is a test");
        assert!(report(&console, "a map", &[skipped()]).is_ok());
        let outcomes = [skipped(), Outcome::failed("energy", "half of it went")];
        let error = report(&console, "a map", &outcomes).expect_err("one of them failed");
        assert_eq!(error.failure, Failure::Findings);
        assert!(error.message.contains("1 of 2 checks"), "{}", error.message);
    }
}
