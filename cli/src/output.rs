//! Where words go: results to standard output, progress and warnings to standard error.

use crate::exit::{CommandError, Failure};
use glintbake_bake::{Progress, Stage};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

/// How often progress is drawn where nothing is reported.
const TICK: Duration = Duration::from_millis(100);

/// Stages of known size.
const BAR: &str = "{spinner} {msg:8} {bar:32} {percent:>3} %, {elapsed} elapsed, {eta} left";

/// Work on something that has a name.
const NAMED_BAR: &str = "{spinner} {msg} {bar:32} {pos}/{len}, {elapsed} elapsed, {eta} left";

/// Stages that are one piece of work.
const SPINNER: &str = "{spinner} {msg:8} {elapsed}";

/// The two streams, and how much to say on them.
#[derive(Debug)]
pub struct Console {
    quiet: bool,
    json: bool,
    /// Why a line of a result did not reach standard output.
    lost: OnceLock<String>,
}

impl Console {
    /// A console that says nothing but results and errors if `quiet`, and those as JSON if `json`.
    pub fn new(quiet: bool, json: bool) -> Self {
        Self {
            quiet,
            json,
            lost: OnceLock::new(),
        }
    }

    /// Whether results are wanted as JSON.
    pub fn json(&self) -> bool {
        self.json
    }

    /// Prints one line of a result for people; nothing if results are JSON or `--quiet` is set.
    pub fn line(&self, text: impl std::fmt::Display) {
        if !self.json && !self.quiet {
            self.print(&text.to_string());
        }
    }

    /// Prints a line of a result that `--quiet` does not silence; nothing if results are JSON.
    pub fn result(&self, text: impl std::fmt::Display) {
        if !self.json {
            self.print(&text.to_string());
        }
    }

    /// Prints a result as one JSON document, if results are JSON.
    pub fn document(&self, value: &Value) {
        if self.json {
            self.print(&format!("{value:#}"));
        }
    }

    /// Prints a warning on standard error.
    pub fn warn(&self, text: impl std::fmt::Display) {
        if !self.quiet {
            complain(&format!("warning: {text}"));
        }
    }

    /// Prints the error on standard error, or as a JSON document on standard output.
    pub fn error(&self, error: &CommandError) {
        if self.json && error.failure != Failure::Findings {
            self.document(&json!({ "error": {
                "exit-code": error.failure.code(),
                "kind": error.failure.name(),
                "message": error.message,
            }}));
        } else if !error.message.is_empty() {
            complain(&format!("error: {}", error.message));
        }
    }

    /// Whether every line of the results was written.
    ///
    /// # Errors
    /// [`Failure::Output`] if standard output failed, unless its reader has closed it.
    pub fn finish(&self) -> Result<(), CommandError> {
        match self.lost.get() {
            None => Ok(()),
            Some(reason) => Err(CommandError::new(
                Failure::Output,
                format!("cannot write to standard output: {reason}"),
            )),
        }
    }

    /// A spinner on standard error that says what is being done, on a terminal only.
    pub fn progress(&self, what: &'static str) -> ProgressBar {
        if self.quiet || !io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new_spinner()
            .with_style(ProgressStyle::default_spinner())
            .with_message(what);
        bar.enable_steady_tick(TICK);
        bar
    }

    /// A bar on standard error that says what is done `to` what, on a terminal only.
    pub fn bar(&self, what: &'static str, to: &str) -> Bar {
        if self.quiet || !io::stderr().is_terminal() {
            return Bar(ProgressBar::hidden());
        }
        let style = ProgressStyle::with_template(NAMED_BAR)
            .expect("a template that has been tested")
            .progress_chars("=> ");
        let bar = ProgressBar::new(1)
            .with_style(style)
            .with_message(format!("{what} {to}"));
        bar.enable_steady_tick(TICK);
        Bar(bar)
    }

    /// The stages of a bake on standard error, on a terminal only: a bar and the time left where the size is known.
    pub fn stages(&self) -> Stages {
        Stages {
            hidden: self.quiet || !io::stderr().is_terminal(),
            shown: Mutex::new(None),
        }
    }

    fn print(&self, text: &str) {
        match writeln!(io::stdout().lock(), "{text}") {
            // `glintbake inspect … | head` has all it wants.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                self.lost.get_or_init(|| error.to_string());
            }
            _ => {}
        }
    }
}

/// One line that shows how far one piece of work has come, and goes when it is dropped.
#[derive(Debug)]
pub struct Bar(ProgressBar);

impl Bar {
    /// `done` of `total` are done.
    pub fn set(&self, done: u64, total: u64) {
        self.0.set_length(total);
        self.0.set_position(done);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// One line that shows the stage at hand, and goes when it is dropped.
#[derive(Debug)]
pub struct Stages {
    hidden: bool,
    shown: Mutex<Option<Shown>>,
}

/// The line of a stage.
#[derive(Debug)]
struct Shown {
    stage: Stage,
    bar: ProgressBar,
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Stages {
    /// Removes the line, before other lines are written.
    pub fn clear(&self) {
        *self.lock() = None;
    }

    fn lock(&self) -> MutexGuard<'_, Option<Shown>> {
        // A panic elsewhere leaves at worst the line of an older stage.
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Stages {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        if self.hidden {
            return;
        }
        let mut shown = self.lock();
        if let Some(shown) = shown.as_ref().filter(|shown| shown.stage == stage) {
            shown.bar.set_position(done);
            return;
        }
        // A new line for each: one that changes would show a stage with the numbers of another for a moment.
        *shown = None;
        let template = if total > 1 { BAR } else { SPINNER };
        let style = ProgressStyle::with_template(template)
            .expect("a template that has been tested")
            .progress_chars("=> ");
        let bar = ProgressBar::new(total)
            .with_style(style)
            .with_message(stage.name())
            .with_position(done);
        bar.enable_steady_tick(TICK);
        *shown = Some(Shown { stage, bar });
    }
}

/// Prints a line on standard error; where that is closed or full there is nobody left to tell.
fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// `bytes` in the unit a reader expects: bytes, KB or MB (decimal).
pub fn human_bytes(bytes: u64) -> String {
    match bytes {
        0..=9_999 => format!("{bytes} B"),
        10_000..=999_999 => format!("{:.1} KB", bytes as f64 / 1e3),
        _ => format!("{:.2} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_are_templates() {
        for template in [BAR, NAMED_BAR, SPINNER] {
            assert!(ProgressStyle::with_template(template).is_ok(), "{template}");
        }
    }
}
