//! The `glintbake` command line: bake normal maps into packages; inspect, verify, query and picture them.
//!
//! One file per verb in [`commands`]; each parses nothing and prints little: arguments come typed from [`args`],
//! results go to standard output (as JSON with `--json`), progress and warnings to standard error.

pub mod args;
pub mod commands;
pub mod exit;
pub mod measure;
pub mod output;
pub mod picture;
pub mod rebuild;
pub mod report;
pub mod stress;

use args::{Cli, Command};
use clap::Parser;
use exit::{CommandError, Failure};
use output::Console;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

const DEFECT: &str = "this is a defect of glintbake, not of your files; please report it with the command that \
                      led to it. No output was replaced by a part of one";

/// Runs the command line of this process; returns its exit code.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let console = Console::new(cli.quiet, cli.command.wants_json());
    // The panic's own lines are on standard error by then; this adds whose fault it is, and the documented code.
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| run(&cli, &console)))
        .unwrap_or_else(|_| Err(CommandError::new(Failure::Internal, DEFECT)))
        .and_then(|()| console.finish());
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            console.error(&error);
            ExitCode::from(error.failure.code())
        }
    }
}

/// Runs one parsed command line.
///
/// # Errors
/// [`CommandError`] with the exit code and the sentence for the user.
pub fn run(cli: &Cli, console: &Console) -> Result<(), CommandError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(cli.threads.into())
        .build()
        .map_err(|error| CommandError::new(Failure::Usage, format!("--threads: {error}")))?;
    pool.install(|| match &cli.command {
        Command::Sample(arguments) => commands::sample::run(arguments, console),
        Command::Bake(arguments) => commands::bake::run(arguments, console),
        Command::Expand(arguments) => commands::expand::run(arguments, console),
        Command::Inspect(arguments) => commands::inspect::run(arguments, console),
        Command::Verify(arguments) => commands::verify::run(arguments, console),
        Command::Query(arguments) => commands::query::run(arguments, console),
        Command::Picture(arguments) => commands::picture::run(arguments, console),
        Command::Report(arguments) => commands::report::run(arguments, console),
        Command::Stress(arguments) => commands::stress::run(arguments, console),
    })
}
