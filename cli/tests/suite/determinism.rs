//! The same map and options give the same bytes, whoever bakes, where, by which path and on how many threads.

use crate::workshop::Workshop;
use assert_cmd::Command;
use std::fs::File;
use std::time::{Duration, SystemTime};

const OPTIONS: [&str; 4] = [
    "--method=cluster-tree,flake-bins,specular-bins,lean",
    "--roughness=0.1,0.01",
    "--exact-normals",
    "--force",
];

/// A map of more than one chunk of parallel work.
fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "noise", "--size=300x260", "-o=map.png"]);
    workshop
}

fn baked(workshop: &Workshop, image: &str, output: &str, extra: &[&str]) -> Vec<u8> {
    let bake = ["bake", image, "-o", output];
    workshop.succeeds(&[&bake, &OPTIONS[..], extra].concat());
    workshop.read(output)
}

#[test]
fn threads_and_repetition_change_no_byte() {
    let workshop = workshop();
    let first = baked(&workshop, "map.png", "a.glint", &["--threads=1"]);
    for threads in ["--threads=1", "--threads=2", "--threads=8", "--threads=0"] {
        let again = baked(&workshop, "map.png", "b.glint", &[threads]);
        assert!(again == first, "{threads} changed the package");
    }
    let other = baked(&workshop, "map.png", "c.glint", &["--index=none"]);
    assert!(other != first, "the comparison must be able to fail");
}

#[test]
fn paths_and_working_directories_change_no_byte() {
    let workshop = Workshop::with_map();
    let first = baked(&workshop, "map.png", "a.glint", &[]);
    let absolute = workshop.path("map.png");
    let absolute = absolute.to_str().expect("Unicode");
    assert!(baked(&workshop, absolute, "b.glint", &[]) == first);
    std::fs::create_dir(workshop.path("elsewhere")).expect("a folder");
    assert!(baked(&workshop, "elsewhere/../map.png", "b.glint", &[]) == first);

    let moved = Workshop::new();
    moved.write("map.png", workshop.read("map.png"));
    assert!(baked(&moved, "map.png", "package-of-another-name", &[]) == first);

    let from_below = Command::new(crate::workshop::PROGRAM)
        .current_dir(workshop.path("elsewhere"))
        .args(["bake", "../map.png", "-o=d.glint"])
        .args(OPTIONS)
        .output()
        .expect("the program starts");
    assert!(from_below.status.success(), "{from_below:?}");
    assert!(workshop.read("elsewhere/d.glint") == first);
}

#[cfg(unix)]
#[test]
fn a_linked_folder_changes_no_byte() {
    let workshop = Workshop::with_map();
    let first = baked(&workshop, "map.png", "a.glint", &[]);
    std::os::unix::fs::symlink(workshop.folder(), workshop.path("link")).expect("a link");
    assert!(baked(&workshop, "link/map.png", "link/b.glint", &[]) == first);
}

#[test]
fn a_package_names_no_folder_machine_or_user() {
    let workshop = Workshop::with_map();
    let user = "wilhelmine-von-glint";
    let mut command = Command::new(crate::workshop::PROGRAM);
    command
        .env("USER", user)
        .env("LOGNAME", user)
        .env("HOSTNAME", user)
        .env("HOME", format!("/home/{user}"))
        .arg("bake")
        .arg(workshop.path("map.png"))
        .args(["-o=a.glint"])
        .args(OPTIONS);
    assert_eq!(workshop.finish(command).code, Some(0));
    let package = workshop.read("a.glint");
    let contains = |text: &str| {
        package
            .windows(text.len())
            .any(|window| window == text.as_bytes())
    };
    let folder = workshop.folder();
    let mut secrets = vec![user.to_owned()];
    secrets.extend(
        folder
            .iter()
            .map(|part| part.to_string_lossy().into_owned()),
    );
    secrets.extend(std::fs::read_to_string("/etc/hostname").map(|name| name.trim().to_owned()));
    // A name of a letter or two would be found in any binary.
    for secret in secrets.iter().filter(|secret| secret.len() > 3) {
        assert!(!contains(secret), "{secret:?}");
    }
    assert!(
        contains("\"name\":\"map.png\""),
        "the search must be able to find what is there"
    );
}

#[test]
fn neither_the_clock_nor_the_age_of_the_map_changes_a_byte() {
    let workshop = Workshop::with_map();
    let first = baked(&workshop, "map.png", "a.glint", &[]);
    // The coarsest clock that could have been written into a file counts seconds.
    std::thread::sleep(Duration::from_millis(1100));
    File::options()
        .write(true)
        .open(workshop.path("map.png"))
        .and_then(|map| map.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(86_400)))
        .expect("a file of another age");
    assert!(baked(&workshop, "map.png", "b.glint", &[]) == first);
}

#[cfg(unix)]
#[test]
fn the_environment_changes_no_byte() {
    let workshop = Workshop::with_map();
    let first = baked(&workshop, "map.png", "a.glint", &[]);
    let mut command = Command::new(crate::workshop::PROGRAM);
    command
        .env_clear()
        .env("LC_ALL", "de_DE.UTF-8")
        .env("TZ", "Asia/Tokyo")
        .env("SOURCE_DATE_EPOCH", "0")
        .args(["bake", "map.png", "-o=b.glint"])
        .args(OPTIONS);
    assert_eq!(workshop.finish(command).code, Some(0));
    assert!(workshop.read("b.glint") == first);
}
