//! `verify`: numbered findings.

use super::open;
use crate::args::VerifyArgs;
use crate::exit::{CommandError, Failure};
use crate::output::Console;
use glintbake_format::{Container, Finding, check};
use serde_json::{Value, json};

/// Checks the package and prints what it finds.
///
/// # Errors
/// [`Failure::Findings`] if anything is wrong, [`Failure::Input`] if the file cannot be read.
pub fn run(arguments: &VerifyArgs, console: &Console) -> Result<(), CommandError> {
    let path = &arguments.package;
    let bytes = open::bytes(path, arguments.no_mmap)?;
    let mut findings = Vec::new();
    let progress = console.progress("verifying");
    match Container::open(&bytes) {
        Ok(container) if arguments.structure => {
            check::structure(&container, &mut |finding| findings.push(finding));
        }
        Ok(container) => check::full(&container, &mut |finding| findings.push(finding)),
        Err(finding) => findings.push(finding),
    }
    progress.finish_and_clear();
    let checked = if arguments.structure {
        "structure"
    } else {
        "structure, checksums and hash"
    };
    for finding in &findings {
        console.result(finding);
    }
    console.document(&json!({
        "checked": if arguments.structure { "structure" } else { "full" },
        "findings": findings.iter().map(document).collect::<Vec<_>>(),
        "sound": findings.is_empty(),
    }));
    if findings.is_empty() {
        console.line(format_args!("{}: sound ({checked})", path.display()));
        Ok(())
    } else {
        Err(CommandError::new(
            Failure::Findings,
            format!(
                "{}: {} {}; bake it again or restore it from a copy",
                path.display(),
                findings.len(),
                if findings.len() == 1 {
                    "finding"
                } else {
                    "findings"
                }
            ),
        ))
    }
}

fn document(finding: &Finding) -> Value {
    json!({
        "at": finding.element,
        "expected": finding.expected,
        "got": finding.got,
        "number": finding.fault.number(),
        "section": finding.section.map(|section| section.to_string()),
        "text": finding.fault.text(),
    })
}
