//! Where words go: results to standard output, progress and warnings to standard error.

use crate::exit::CommandError;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// The two streams, and how much to say on them.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    quiet: bool,
    json: bool,
}

impl Console {
    /// A console that says nothing but results and errors if `quiet`, and those as JSON if `json`.
    pub fn new(quiet: bool, json: bool) -> Self {
        Self { quiet, json }
    }

    /// Whether results are wanted as JSON.
    pub fn json(&self) -> bool {
        self.json
    }

    /// Prints one line of a result for people; nothing if results are JSON or `--quiet` is set.
    pub fn line(&self, text: impl std::fmt::Display) {
        if !self.json && !self.quiet {
            print_line(&text.to_string());
        }
    }

    /// Prints a line of a result that `--quiet` does not silence; nothing if results are JSON.
    pub fn result(&self, text: impl std::fmt::Display) {
        if !self.json {
            print_line(&text.to_string());
        }
    }

    /// Prints a result as one JSON document, if results are JSON.
    pub fn document(&self, value: &Value) {
        if self.json {
            print_line(&format!("{value:#}"));
        }
    }

    /// Prints a warning on standard error.
    pub fn warn(&self, text: impl std::fmt::Display) {
        if !self.quiet {
            eprintln!("warning: {text}");
        }
    }

    /// Prints the error on standard error, or as a JSON document on standard output.
    pub fn error(&self, error: &CommandError) {
        if self.json && error.failure != crate::exit::Failure::Findings {
            print_line(&format!(
                "{:#}",
                json!({ "error": {
                    "exit-code": error.failure.code(),
                    "kind": error.failure.name(),
                    "message": error.message,
                }})
            ));
        } else if !error.message.is_empty() {
            eprintln!("error: {}", error.message);
        }
    }

    /// A spinner on standard error that says what is being done, on a terminal only.
    pub fn progress(&self, what: &'static str) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new_spinner()
            .with_style(ProgressStyle::default_spinner())
            .with_message(what);
        bar.enable_steady_tick(Duration::from_millis(100));
        bar
    }
}

/// Prints a line; a closed pipe (`glintbake inspect … | head`) is no error of ours.
fn print_line(text: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "{text}");
}

/// `bytes` in the unit a reader expects: bytes, KB or MB (decimal).
pub fn human_bytes(bytes: u64) -> String {
    match bytes {
        0..=9_999 => format!("{bytes} B"),
        10_000..=999_999 => format!("{:.1} KB", bytes as f64 / 1e3),
        _ => format!("{:.2} MB", bytes as f64 / 1e6),
    }
}
