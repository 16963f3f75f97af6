//! A folder of its own to run the program in, and what every run must keep to.

use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

/// The program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_glintbake");

/// Longer than any run of the suite by far: a run that takes so long hangs.
const PATIENCE: Duration = Duration::from_secs(60);

/// The codes that `--help` documents, without the one that is ours to avoid.
const KNOWN_CODES: std::ops::RangeInclusive<i32> = 0..=7;

/// A temporary folder in which the program is run.
pub struct Workshop {
    folder: TempDir,
}

impl Workshop {
    /// An empty folder.
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a temporary folder"),
        }
    }

    /// A folder with `map.png`, a 16-bit map of 96 × 40 texels.
    pub fn with_map() -> Self {
        let workshop = Self::new();
        workshop.succeeds(&["sample", "flakes", "--size", "96x40", "-o", "map.png"]);
        workshop
    }

    /// A folder with `map.png` as above and `map.glint`, baked from it for roughness 0.2 and 0.02 and for mirrors.
    pub fn with_package() -> Self {
        let workshop = Self::with_map();
        workshop.succeeds(&[
            "bake",
            "map.png",
            "-o",
            "map.glint",
            "--method=flake-bins,specular-bins",
            "--roughness=0.2,0.02",
        ]);
        workshop
    }

    /// The folder, absolute.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The absolute path of `name` in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect(name);
    }

    /// The bytes of a file.
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect(name)
    }

    /// The text of a file.
    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect(name)
    }

    /// Every file in the folder, with its content.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        fs::read_dir(self.folder())
            .expect("the folder")
            .map(|entry| entry.expect("an entry"))
            .filter(|entry| entry.path().is_file())
            .map(|entry| {
                let name = entry.file_name().to_string_lossy().into_owned();
                let bytes = fs::read(entry.path()).expect(&name);
                (name, bytes)
            })
            .collect()
    }

    /// The outcome of `glintbake arguments…` in this folder.
    pub fn run(&self, arguments: &[&str]) -> Run {
        let mut command = Command::new(PROGRAM);
        command.args(arguments);
        self.finish(command)
    }

    /// The outcome of `command` in this folder.
    pub fn finish(&self, mut command: Command) -> Run {
        let output = command
            .current_dir(self.folder())
            .timeout(PATIENCE)
            .output()
            .expect("the program starts");
        let run = Run {
            words: format!("{command:?}"),
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        };
        assert!(!run.stderr.contains("panicked"), "{run:#?}");
        assert!(
            run.code.is_some_and(|code| KNOWN_CODES.contains(&code)),
            "{run:#?}"
        );
        run
    }

    /// Runs the program, which must succeed and say nothing on standard error; its standard output.
    pub fn succeeds(&self, arguments: &[&str]) -> String {
        let run = self.run(arguments);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{run:#?}");
        run.stdout
    }

    /// The JSON document of a run that must succeed.
    pub fn document(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.succeeds(arguments)).expect("a JSON document")
    }

    /// Runs the program, which must fail with `code`, print nothing but an error that holds every text of `says`,
    /// and leave every file of the folder as it was; the error.
    pub fn refuses(&self, code: i32, arguments: &[&str], says: &[&str]) -> String {
        let before = self.files();
        let run = self.run(arguments);
        let error = run.error(code, says);
        assert!(
            run.stdout.is_empty(),
            "a failure has no result, but: {run:#?}"
        );
        let after = self.files();
        assert!(
            before.keys().eq(after.keys()),
            "files came or went: {:?} -> {:?} after {run:#?}",
            before.keys(),
            after.keys()
        );
        assert!(before == after, "a file was changed by {run:#?}");
        error
    }
}

/// How a run ended.
#[derive(Debug)]
pub struct Run {
    /// What was run, for messages.
    #[expect(dead_code, reason = "read by Debug, when a test fails")]
    pub words: String,
    /// The exit code; none if a signal ended the run.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Run {
    /// The error of a run that must have failed with `code` and said every text of `says`.
    pub fn error(&self, code: i32, says: &[&str]) -> String {
        assert_eq!(self.code, Some(code), "{self:#?}");
        let error = self
            .stderr
            .strip_prefix("error: ")
            .unwrap_or_else(|| panic!("an error begins so: {self:#?}"));
        for text in says {
            assert!(
                error.contains(text),
                "the error must say {text:?}: {self:#?}"
            );
        }
        // A line of our own is one sentence; clap adds its usage.
        assert!(
            code == 2 || error.trim_end().lines().count() == 1,
            "{self:#?}"
        );
        assert!(
            !error.contains("tmp\"") && !error.contains(".glintbake-"),
            "temporary files are no concern of the user: {self:#?}"
        );
        error.to_owned()
    }
}
