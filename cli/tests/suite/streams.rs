//! Standard output and error that are closed, full, or to be kept silent.

use crate::workshop::{PROGRAM, Workshop};
use std::io::Read;
use std::process::{Command, Stdio};

fn workshop_with_large_table() -> Workshop {
    let workshop = Workshop::with_package();
    let mut table = "u,v,e1u,e1v,e2u,e2v,s,t\n".to_owned();
    for row in 0..4000 {
        table.push_str(&format!("0.5,0.5,0.01,0,0,0.01,0,0.{row:04}\n"));
    }
    workshop.write("q.csv", table);
    workshop
}

const TALKERS: [&[&str]; 4] = [
    &["query", "map.glint", "--queries=q.csv"],
    &["inspect", "map.glint"],
    &["inspect", "map.glint", "--json"],
    &["verify", "map.glint"],
];

#[test]
fn a_reader_that_has_enough_is_no_error() {
    let workshop = workshop_with_large_table();
    for talker in TALKERS {
        let mut child = Command::new(PROGRAM)
            .args(talker)
            .current_dir(workshop.folder())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut stdout = child.stdout.take().expect("a pipe");
        let mut some = [0; 16];
        stdout.read_exact(&mut some).expect("the first bytes");
        drop(stdout);
        let output = child.wait_with_output().expect("it has ended");
        assert!(output.status.success(), "{talker:?}: {output:?}");
        assert!(output.stderr.is_empty(), "{talker:?}: {output:?}");
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_reads_nothing_is_no_error() {
    let workshop = workshop_with_large_table();
    for talker in TALKERS {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = Command::new(PROGRAM)
            .args(talker)
            .current_dir(workshop.folder())
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .expect("the program starts");
        assert!(output.status.success(), "{talker:?}: {output:?}");
        assert!(output.stderr.is_empty(), "{talker:?}: {output:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_an_error() {
    let workshop = workshop_with_large_table();
    for talker in TALKERS {
        let full = std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .expect("the device that is always full");
        let output = Command::new(PROGRAM)
            .args(talker)
            .current_dir(workshop.folder())
            .stdout(full)
            .stderr(Stdio::piped())
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(7), "{talker:?}: {output:?}");
        if !talker.contains(&"--json") {
            let error = String::from_utf8_lossy(&output.stderr);
            assert!(
                error.contains("cannot write to standard output: No space left"),
                "{error}"
            );
        }
    }
}

#[cfg(unix)]
#[test]
fn a_closed_standard_error_changes_no_exit_code() {
    let workshop = Workshop::with_map();
    let runs: [(i32, &[&str]); 3] = [
        (3, &["bake", "none.png", "-o=new.glint", "--roughness=0.1"]),
        (2, &["bake", "map.png", "-o=new.glint", "--roughness=7"]),
        (
            7,
            &["bake", "map.png", "-o=none/new.glint", "--roughness=0.1"],
        ),
    ];
    for (code, arguments) in runs {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let status = Command::new(PROGRAM)
            .args(arguments)
            .current_dir(workshop.folder())
            .stderr(writer)
            .status()
            .expect("the program starts");
        assert_eq!(status.code(), Some(code), "{arguments:?}");
    }
}

#[test]
fn quiet_leaves_results_and_errors() {
    let workshop = Workshop::with_map();
    for silent in [
        &["sample", "flat", "--size=8", "-o=flat.png", "--quiet"][..],
        &[
            "bake",
            "map.png",
            "-o=map.glint",
            "--roughness=0.1",
            "--quiet",
        ],
        &[
            "--quiet",
            "bake",
            "map.png",
            "-o=map.glint",
            "--roughness=0.1",
        ],
        &["verify", "map.glint", "-q"],
    ] {
        assert_eq!(workshop.succeeds(silent), "", "{silent:?}");
    }
    workshop.write("q.csv", "u,v,e1u,e1v,e2u,e2v,s,t\n");
    let query = ["query", "map.glint", "--queries=q.csv", "--quiet"];
    assert_eq!(
        workshop.succeeds(&query).lines().count(),
        2,
        "the table is the result"
    );
    assert_eq!(workshop.succeeds(&[&query[..], &["-o=a.csv"]].concat()), "");
    workshop.refuses(3, &["inspect", "none.glint", "--quiet"], &["none.glint"]);
}
