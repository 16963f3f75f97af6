//! Outputs that cannot be written, must not be, or are interrupted: the old file stays whole.

use crate::workshop::{PROGRAM, Run, Workshop};
use std::fs;

/// Every command that writes, with its output option left to add.
const WRITERS: [&[&str]; 5] = [
    &["sample", "flat", "--size=8"],
    &["bake", "map.png", "--roughness=0.3", "--force"],
    &["query", "map.glint", "--queries=q.csv"],
    &["picture", "ndf", "map.glint", "--pixels=8"],
    &["picture", "ball", "map.glint", "--pixels=8"],
];

fn workshop() -> Workshop {
    let workshop = Workshop::with_package();
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.5,0.1,0,0,0.1,0,0\n",
    );
    workshop
}

/// Every writer must refuse to write to `output`.
fn all_refuse(workshop: &Workshop, code: i32, output: &str, says: &[&str]) {
    for writer in WRITERS {
        workshop.refuses(code, &[writer, &["-o", output]].concat(), says);
    }
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let workshop = workshop();
    all_refuse(
        &workshop,
        7,
        "none/deep/out",
        &[
            "cannot write none/deep/out: ",
            "no folder none/deep",
            "create it first",
        ],
    );
}

/// Stands for a folder without write permission too: root, as whom tests often run, may write to any folder.
#[test]
fn a_folder_below_a_file_is_no_folder() {
    let workshop = workshop();
    all_refuse(&workshop, 7, "map.png/out", &["cannot write map.png/out: "]);
}

#[cfg(unix)]
#[test]
fn a_folder_without_write_permission_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let workshop = workshop();
    let folder = workshop.path("sealed");
    fs::create_dir(&folder).expect("a folder");
    let seal = |mode| fs::set_permissions(&folder, fs::Permissions::from_mode(mode));
    seal(0o555).expect("permissions");
    if fs::write(folder.join("probe"), "").is_ok() {
        eprintln!("skipped: this user may write to any folder");
    } else {
        all_refuse(
            &workshop,
            7,
            "sealed/out",
            &["cannot write sealed/out: ", "permissions"],
        );
    }
    seal(0o755).expect("permissions");
}

#[test]
fn a_folder_is_not_replaced_by_a_file() {
    let workshop = workshop();
    fs::create_dir(workshop.path("folder")).expect("a folder");
    for output in ["folder", "folder/", "."] {
        all_refuse(
            &workshop,
            7,
            output,
            &[&format!(
                "cannot write {output}: there is a folder of that name"
            )],
        );
    }
    assert!(
        fs::read_dir(workshop.path("folder"))
            .expect("the folder")
            .next()
            .is_none()
    );
}

#[cfg(unix)]
#[test]
fn a_device_is_not_replaced_by_a_file() {
    let workshop = workshop();
    // A link to it, so that a failing test does no harm to the machine.
    std::os::unix::fs::symlink("/dev/null", workshop.path("null")).expect("a link");
    all_refuse(&workshop, 7, "null", &["a pipe or a device, not a file"]);
    assert!(workshop.path("null").is_symlink());
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link_to_the_new_file() {
    let workshop = workshop();
    fs::create_dir(workshop.path("store")).expect("a folder");
    workshop.write("store/real", "old");
    std::os::unix::fs::symlink("store/real", workshop.path("link")).expect("a link");
    for writer in WRITERS {
        workshop.write("store/real", "old");
        workshop.succeeds(&[writer, &["-o=link"]].concat());
        assert!(workshop.path("link").is_symlink(), "{writer:?}");
        assert_ne!(workshop.read("store/real"), b"old", "{writer:?}");
        let left: Vec<_> = fs::read_dir(workshop.path("store"))
            .expect("the folder")
            .collect();
        assert_eq!(left.len(), 1, "{left:?}");
    }
}

#[test]
fn an_input_is_not_replaced_by_its_own_output() {
    let workshop = workshop();
    let absolute = |name: &str| workshop.path(name).to_str().expect("Unicode").to_owned();
    let bake = &["bake", "map.png", "--roughness=0.3"][..];
    let lost = "it is the input, which would be lost; name another file";
    for output in ["map.png", "./map.png", &absolute("map.png")] {
        workshop.refuses(2, &[bake, &["-o", output]].concat(), &["--output", lost]);
    }
    let to_new = [bake, &["-o=new.glint"]].concat();
    workshop.refuses(
        2,
        &[&to_new[..], &["--depfile=map.png"]].concat(),
        &["--depfile", lost],
    );
    workshop.refuses(
        2,
        &[&to_new[..], &["--preview=map.png"]].concat(),
        &["--preview", lost],
    );
    workshop.refuses(
        2,
        &[&to_new[..], &["--depfile=./new.glint"]].concat(),
        &["--depfile", "the file of --output as well"],
    );
    workshop.refuses(
        2,
        &[&to_new[..], &["--depfile=d", "--preview=d"]].concat(),
        &["--preview", "the file of --depfile as well"],
    );
    for writer in &WRITERS[2..] {
        workshop.refuses(
            2,
            &[writer, &["-o=map.glint"][..]].concat(),
            &["--output", lost],
        );
    }
}

#[test]
fn a_table_may_be_replaced_by_its_own_answers() {
    let workshop = workshop();
    let query = ["query", "map.glint", "--queries=q.csv", "-o=q.csv"];
    workshop.succeeds(&query);
    let answered = workshop.text("q.csv");
    assert!(answered.contains(",ndf\n"), "{answered}");
    workshop.succeeds(&query);
    assert_eq!(
        workshop.text("q.csv"),
        answered,
        "the answers replace themselves"
    );
}

#[test]
fn side_outputs_are_checked_before_the_bake() {
    let workshop = workshop();
    for option in ["--depfile", "--preview"] {
        let side = format!("{option}=none/side");
        workshop.refuses(
            7,
            &["bake", "map.png", "-o=new.glint", "--roughness=0.3", &side],
            &["cannot write none/side: "],
        );
    }
}

/// `glintbake arguments…` where no file may grow beyond a few kilobytes: to a program the same as a full disk.
#[cfg(target_os = "linux")]
fn run_on_a_full_disk(workshop: &Workshop, arguments: &[&str]) -> Run {
    let mut command = assert_cmd::Command::new("sh");
    command
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 8; exec \"$0\" \"$@\"",
            PROGRAM,
        ])
        .args(arguments);
    workshop.finish(command)
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_files_and_no_others() {
    let workshop = workshop();
    let mut table = "u,v,e1u,e1v,e2u,e2v,s,t\n".to_owned();
    for _ in 0..3000 {
        table.push_str("0.5,0.5,0.1,0,0,0.1,0,0\n");
    }
    workshop.write("q.csv", table);
    workshop.write("old", "whole");
    let writers: [&[&str]; 4] = [
        &["sample", "noise", "--size=128", "-o=old"],
        &["bake", "map.png", "--roughness=0.3", "-o=map.glint"],
        &[
            "bake",
            "map.png",
            "--roughness=0.3",
            "-o=new.glint",
            "--depfile=d",
        ],
        &["query", "map.glint", "--queries=q.csv", "-o=old"],
    ];
    let before = workshop.files();
    for writer in writers {
        let run = run_on_a_full_disk(&workshop, writer);
        run.error(7, &["cannot write ", "File too large"]);
        assert!(run.stdout.is_empty(), "{run:#?}");
        assert!(workshop.files() == before, "{run:#?}");
    }
    for writer in &writers[1..] {
        let error = run_on_a_full_disk(&workshop, writer).error(7, &[]);
        assert!(
            error.contains("ulimit -f"),
            "the remedy is missing: {error}"
        );
    }
}

/// What is left of a killed bake is the old package, and at most temporary files of a name of their own.
#[cfg(unix)]
#[test]
fn a_killed_bake_leaves_the_old_package() {
    use std::os::unix::process::ExitStatusExt;
    let workshop = Workshop::with_package();
    let old = workshop.read("map.glint");
    workshop.succeeds(&["sample", "noise", "--size=640", "-o=large.png"]);
    let mut killed = 0;
    for milliseconds in [2, 10, 25, 50, 80, 120, 170, 230, 300] {
        let mut bake = std::process::Command::new(PROGRAM)
            .args([
                "bake",
                "large.png",
                "-o=map.glint",
                "--roughness=0.1,0.01,0.003",
            ])
            .args(["--method=flake-bins", "--exact-normals", "--quiet"])
            .current_dir(workshop.folder())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        bake.kill().expect("it was started here");
        let status = bake.wait().expect("it has ended");
        if status.signal() == Some(9) {
            killed += 1;
        }
        let found = workshop.read("map.glint");
        if found != old {
            // It was done in time, or killed after the renaming: then the new package is whole.
            workshop.succeeds(&["verify", "map.glint"]);
            workshop.write("map.glint", &old);
        }
        for name in workshop.files().keys() {
            let known = ["map.png", "large.png", "map.glint"].contains(&name.as_str());
            let temporary = name.starts_with(".glintbake-") && name.ends_with(".tmp");
            assert!(known || temporary, "{name}");
        }
    }
    assert!(killed > 0, "the test must be able to kill");
}

#[test]
fn bakes_of_one_output_at_once_leave_one_of_them_whole() {
    let workshop = Workshop::with_map();
    let bakes: Vec<_> = ["0.1", "0.2", "0.3", "0.4"]
        .into_iter()
        .map(|alpha| {
            std::process::Command::new(PROGRAM)
                .args(["bake", "map.png", "-o=map.glint", "--quiet", "--roughness"])
                .arg(alpha)
                .current_dir(workshop.folder())
                .spawn()
                .expect("the program starts")
        })
        .collect();
    for mut bake in bakes {
        let status = bake.wait().expect("it has ended");
        assert!(status.success(), "{status}");
    }
    workshop.succeeds(&["verify", "map.glint"]);
    let files = workshop.files();
    assert!(
        files.keys().eq(["map.glint", "map.png"]),
        "{:?}",
        files.keys()
    );
}
