//! Packages that are cut short, flipped, of the future, or no packages.

use crate::workshop::Workshop;
use glintbake_format::{Container, ENTRY_LENGTH, HEADER_LENGTH};

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "flakes", "--size=20x12", "-o=map.png"]);
    workshop.succeeds(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--method=flake-bins,specular-bins",
        "--roughness=0.3",
        "--index=forest",
        "--leaf-size=2",
        "--exact-normals",
    ]);
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.5,0.3,0,0,0.3,0,0\n",
    );
    workshop
}

const READERS: [&[&str]; 4] = [
    &["inspect", "bad.glint"],
    &["query", "bad.glint", "--queries=q.csv"],
    &["picture", "ndf", "bad.glint", "-o=new.png"],
    &["picture", "ball", "bad.glint", "-o=new.png"],
];

/// `bad.glint` must be refused by whatever reads it, and found faulty by `verify` with number `fault`, if given.
fn is_bad(workshop: &Workshop, bytes: &[u8], fault: Option<u16>) {
    workshop.write("bad.glint", bytes);
    let number = fault.map_or(String::new(), |fault| format!("[{fault}] "));
    for reader in READERS {
        workshop.refuses(5, reader, &["bad.glint: [", &number]);
    }
    found_by_verify(workshop, &number);
}

/// `verify` must find faults in `bad.glint`, among them `number`.
fn found_by_verify(workshop: &Workshop, number: &str) {
    for option in ["--full", "--no-mmap"] {
        let run = workshop.run(&["verify", "bad.glint", option]);
        run.error(1, &["bad.glint: ", "finding", "bake it again"]);
        assert!(
            run.stdout.lines().count() > 0 && run.stdout.contains(number),
            "{number}: {run:#?}"
        );
    }
}

#[test]
fn a_package_cut_short_anywhere_is_refused() {
    let workshop = workshop();
    let whole = workshop.read("map.glint");
    let last = whole.len() - 1;
    for length in [0, 1, 11, 12, 127] {
        is_bad(&workshop, &whole[..length], Some(1001));
    }
    let table = HEADER_LENGTH + ENTRY_LENGTH;
    for length in [128, 129, table, 1000, whole.len() / 2, last - 1, last] {
        is_bad(&workshop, &whole[..length], Some(1005));
    }
    is_bad(&workshop, &[&whole[..], b"x"].concat(), Some(1005));
}

#[test]
fn a_flipped_bit_is_refused_wherever_a_checksum_covers_it() {
    let workshop = workshop();
    let whole = workshop.read("map.glint");
    let container = Container::open(&whole).expect("a sound package");
    let mut flips: Vec<usize> = (0..HEADER_LENGTH).step_by(9).collect();
    flips.extend(
        (HEADER_LENGTH..HEADER_LENGTH + ENTRY_LENGTH * container.entries().len()).step_by(67),
    );
    for entry in container.entries() {
        let start = entry.offset.get() as usize;
        let length = entry.length.get() as usize;
        flips.extend([start, start + length / 2, start + length - 1]);
    }
    for place in flips {
        let mut flipped = whole.clone();
        flipped[place] ^= 0x04;
        is_bad(&workshop, &flipped, None);
    }
}

#[test]
fn flipped_padding_is_found_by_verify_and_harmless_to_the_rest() {
    let workshop = workshop();
    let whole = workshop.read("map.glint");
    let container = Container::open(&whole).expect("a sound package");
    let entry = container.entries().first().expect("a section");
    let mut flipped = whole.clone();
    flipped[(entry.offset.get() + entry.length.get()) as usize] = 1;
    workshop.write("bad.glint", &flipped);
    found_by_verify(&workshop, "[2010] ");
    workshop.succeeds(&["inspect", "bad.glint"]);
    workshop.succeeds(&["query", "bad.glint", "--queries=q.csv"]);
}

#[test]
fn trust_skips_the_checksums_and_still_gives_no_nonsense() {
    let workshop = workshop();
    let whole = workshop.read("map.glint");
    let container = Container::open(&whole).expect("a sound package");
    for entry in container.entries() {
        let middle = entry.offset.get() + entry.length.get() / 2;
        let mut flipped = whole.clone();
        flipped[middle as usize] ^= 0x80;
        workshop.write("bad.glint", &flipped);
        let run = workshop.run(&["query", "bad.glint", "--queries=q.csv", "--trust"]);
        match run.code {
            Some(0) => {
                let answer = run.stdout.trim_end().rsplit(',').next().expect("a field");
                let density: f64 = answer.parse().expect("a number");
                assert!(density.is_finite() && density >= 0.0, "{run:#?}");
            }
            _ => drop(run.error(5, &["bad.glint: "])),
        }
    }
}

#[test]
fn a_package_of_the_future_is_refused_by_its_version() {
    let workshop = workshop();
    let mut bytes = workshop.read("map.glint");
    bytes[12] += 1;
    is_bad(&workshop, &bytes, Some(1003));
    let error = workshop.refuses(5, READERS[0], &["expected 1, got 2"]);
    assert!(
        error.contains("the glintbake release that wrote it"),
        "{error}"
    );
}

#[test]
fn other_files_are_no_packages() {
    let workshop = workshop();
    let map = workshop.read("map.png");
    is_bad(&workshop, &map, Some(1002));
    is_bad(&workshop, &[0; 4096], Some(1002));
    is_bad(&workshop, &[b'x'; 200], Some(1002));
}

#[test]
fn a_package_that_is_missing_or_a_folder_is_no_readable_input() {
    let workshop = workshop();
    std::fs::create_dir(workshop.path("folder")).expect("a folder");
    for (name, says) in [
        ("none.glint", "cannot be opened"),
        ("folder", "folder, not a package"),
    ] {
        let named = format!("{name}: ");
        let readers: [&[&str]; 4] = [
            &["inspect", name],
            &["verify", name],
            &["query", name, "--queries=q.csv"],
            &["picture", "ball", name, "-o=new.png"],
        ];
        for reader in readers {
            workshop.refuses(3, reader, &[&named, says]);
        }
    }
}

#[test]
fn structure_finds_what_checksums_would_without_reading_them() {
    let workshop = workshop();
    let whole = workshop.read("map.glint");
    let container = Container::open(&whole).expect("a sound package");
    let positions = container
        .entries()
        .iter()
        .find(|entry| entry.kind.to_string() == "IBMP")
        .expect("an inverse bin map");
    let mut lying = whole.clone();
    lying[positions.offset.get() as usize + 1] = 0xff;
    workshop.write("bad.glint", &lying);
    let run = workshop.run(&["verify", "bad.glint", "--structure"]);
    run.error(1, &["bad.glint: "]);
    assert!(
        run.stdout.contains("[3004] ") && !run.stdout.contains("[5001] "),
        "{run:#?}"
    );
    found_by_verify(&workshop, "[5001] ");
}
