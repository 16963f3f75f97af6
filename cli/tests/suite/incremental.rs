//! Baking again: only what has changed, and a depfile that make believes.

use crate::files;
use crate::workshop::Workshop;
use serde_json::Value;
use std::fs;
use std::process::Command;
use std::time::SystemTime;

const BAKE: [&str; 4] = ["bake", "map.png", "-o=map.glint", "--roughness=0.1,0.03"];

/// What changes when a file is replaced by another, even one of the same bytes.
fn identity(workshop: &Workshop) -> (SystemTime, u64) {
    let metadata = fs::metadata(workshop.path("map.glint")).expect("a package");
    #[cfg(unix)]
    let inode = std::os::unix::fs::MetadataExt::ino(&metadata);
    #[cfg(not(unix))]
    let inode = 0;
    (metadata.modified().expect("a time"), inode)
}

/// Whether `bake` with `extra` replaced the package; its words must agree.
fn rebakes(workshop: &Workshop, extra: &[&str]) -> bool {
    let before = identity(workshop);
    let said = workshop.succeeds(&[&BAKE, extra].concat());
    let replaced = identity(workshop) != before;
    assert_eq!(said.contains("(up to date)"), !replaced, "{said}");
    replaced
}

#[test]
fn a_second_bake_leaves_the_package_alone_until_it_is_forced() {
    let workshop = Workshop::with_map();
    let first = workshop.succeeds(&BAKE);
    assert!(!first.contains("up to date"), "{first}");
    let bytes = workshop.read("map.glint");
    assert!(!rebakes(&workshop, &[]));
    assert!(!rebakes(&workshop, &["--threads=1"]));
    let absolute = workshop.path("map.png");
    workshop.succeeds(&[
        "bake",
        absolute.to_str().expect("Unicode"),
        "-o=map.glint",
        "--roughness=0.1,0.03",
    ]);
    assert!(
        !rebakes(&workshop, &[]),
        "the folder of the map is no part of the recipe"
    );
    assert!(rebakes(&workshop, &["--force"]));
    assert!(workshop.read("map.glint") == bytes);
    let document: Value = workshop.document(&[&BAKE[..], &["--json"]].concat());
    assert_eq!(document["up-to-date"], true);
    let document = workshop.document(&[&BAKE[..], &["--json", "--force"]].concat());
    assert_eq!(document["up-to-date"], false);
}

#[test]
fn every_option_that_decides_a_byte_bakes_again() {
    let workshop = Workshop::new();
    files::rgba8(&workshop.path("map.png"), (20, 12), |column, row| {
        let [s, t, z] = files::leaning(column, row);
        [s, t, z, 128]
    });
    workshop.succeeds(&BAKE);
    for extra in [
        "--intrinsic-roughness=0.2",
        "--method=flake-bins",
        "--method=flake-bins,specular-bins",
        "--method=flake-bins --index=forest",
        "--method=flake-bins --index=forest --leaf-size=8",
        "--method=flake-bins --index=none",
        "--method=flake-bins --exact-normals",
        "--kernel=disk",
        "--filter=gaussian",
        "--no-masking",
        "--input=height",
        "--height-scale=2",
        "--channels=xy",
        "--y=dx",
        "--range=unorm",
        "--zero=128",
        "--wrap=clamp",
        "--repair",
    ] {
        let options: Vec<_> = extra.split(' ').collect();
        assert!(rebakes(&workshop, &options), "{extra}");
        assert!(!rebakes(&workshop, &options), "{extra} a second time");
        assert!(rebakes(&workshop, &[]), "without {extra} again");
    }
}

#[test]
fn a_map_of_other_content_bakes_again_whatever_its_age() {
    let workshop = Workshop::with_map();
    workshop.succeeds(&BAKE);
    let modified = |name: &str| fs::metadata(workshop.path(name)).and_then(|file| file.modified());
    let age = modified("map.png").expect("a time");
    workshop.succeeds(&["sample", "flakes", "--size=96x40", "--seed=1", "-o=map.png"]);
    fs::File::options()
        .write(true)
        .open(workshop.path("map.png"))
        .and_then(|map| map.set_modified(age))
        .expect("the age of the older map");
    assert!(rebakes(&workshop, &[]));
    let bytes = workshop.read("map.png");
    workshop.write("map.png", bytes);
    assert!(!rebakes(&workshop, &[]), "newer, but the same content");
}

#[test]
fn a_damaged_package_of_the_same_recipe_is_baked_again() {
    let workshop = Workshop::with_map();
    workshop.succeeds(&BAKE);
    let sound = workshop.read("map.glint");
    let last = sound.len() - 1;
    for place in [0, 60, 130, 700, sound.len() / 2, last] {
        let mut damaged = sound.clone();
        damaged[place] ^= 1;
        workshop.write("map.glint", &damaged);
        assert!(rebakes(&workshop, &[]), "byte {place}");
        assert!(workshop.read("map.glint") == sound);
    }
    for bytes in [&sound[..last], &sound[..100], b"", b"no package at all"] {
        workshop.write("map.glint", bytes);
        assert!(rebakes(&workshop, &[]), "{} bytes", bytes.len());
        assert!(workshop.read("map.glint") == sound);
    }
}

#[test]
fn a_depfile_quotes_as_make_reads() {
    let workshop = Workshop::with_map();
    let map = workshop.read("map.png");
    for (name, quoted) in [
        ("plain.png", "plain.png"),
        ("red paint.png", "red\\ paint.png"),
        ("5$ flakes.png", "5$$\\ flakes.png"),
        ("#1.png", "\\#1.png"),
        ("Größe.png", "Größe.png"),
        ("back\\slash.png", "back\\slash.png"),
        ("back\\ blank.png", "back\\\\\\ blank.png"),
    ] {
        if cfg!(windows) && name.contains('\\') {
            continue;
        }
        workshop.write(name, &map);
        let bake = ["bake", name, "-o=out put.glint", "--roughness=0.1"];
        workshop.succeeds(&[&bake[..], &["--depfile=map.d"]].concat());
        assert_eq!(
            workshop.text("map.d"),
            format!("out\\ put.glint: {quoted}\n")
        );
        // Up to date now; the rule is written all the same.
        fs::remove_file(workshop.path("map.d")).expect("the depfile");
        let said = workshop.succeeds(&[&bake[..], &["--depfile=map.d"]].concat());
        assert!(said.contains("(up to date)"), "{said}");
        assert!(workshop.path("map.d").exists());
    }
}

/// Skipped where there is no make.
#[test]
fn make_bakes_when_the_map_is_newer_and_only_then() {
    let workshop = Workshop::with_map();
    let map = workshop.read("map.png");
    workshop.write("5$ #1.png", &map);
    let makefile = "\
all: p.glint
p.glint:
\t@$(PROGRAM) bake '5$$ #1.png' -o p.glint --roughness=0.1 --depfile=p.d --force
-include p.d
";
    workshop.write(
        "Makefile",
        makefile.replace("$(PROGRAM)", crate::workshop::PROGRAM),
    );
    let make = || {
        let output = Command::new("make").current_dir(workshop.folder()).output();
        output.ok().map(|output| {
            assert!(output.status.success(), "{output:?}");
            String::from_utf8_lossy(&output.stdout).contains("instance 1")
        })
    };
    let Some(baked) = make() else {
        eprintln!("skipped: there is no make");
        return;
    };
    assert!(baked, "the first time");
    assert_eq!(make(), Some(false), "nothing has changed");
    let future = SystemTime::now() + std::time::Duration::from_secs(60);
    fs::File::options()
        .write(true)
        .open(workshop.path("5$ #1.png"))
        .and_then(|map| map.set_modified(future))
        .expect("a newer map");
    assert_eq!(make(), Some(true), "the map is newer");
}
