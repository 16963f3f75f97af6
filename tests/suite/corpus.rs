//! The fuzzing corpus on the stable toolchain: every file as it is, and some thousand seeded mutations of each.

use glintbake_format::{Container, check};
use glintbake_tests::exercise::exercise;
use glintbake_tests::fixtures::Stream;
use glintbake_tests::lies::reseal;
use glintbake_tests::seeds::{MOST_BYTES, SOUND, folder, seeds};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs;

/// Mutations of each file.
const MUTATIONS: u64 = 300;

/// Names and bytes of the committed files, by name.
fn files() -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder())
        .expect("the corpus is committed")
        .map(|entry| {
            let path = entry.expect("a readable folder").path();
            let name = path.file_name().expect("a file").to_string_lossy();
            (name.into_owned(), fs::read(&path).expect("a readable file"))
        })
        .collect();
    files.sort();
    files
}

#[test]
fn the_corpus_is_complete_and_what_its_names_say() {
    let files = files();
    let committed: BTreeSet<_> = files.iter().map(|(name, _)| name.clone()).collect();
    let generated: BTreeSet<_> = seeds().into_iter().map(|seed| seed.name).collect();
    assert_eq!(
        committed, generated,
        "run `cargo run -p glintbake-tests --example corpus` and commit what it writes"
    );
    for (name, bytes) in files {
        assert!(bytes.len() <= MOST_BYTES, "{name} is small");
        let mut findings = Vec::new();
        match Container::open(&bytes) {
            Ok(container) => check::full(&container, &mut |finding| findings.push(finding)),
            Err(finding) => findings.push(finding),
        }
        assert_eq!(
            findings.is_empty(),
            name.starts_with(SOUND),
            "{name}: {findings:?}"
        );
    }
}

#[test]
fn every_file_of_the_corpus_is_survived() {
    for (name, bytes) in files() {
        let _named = Named(&name, 0);
        exercise(&bytes);
    }
}

#[test]
fn mutations_of_the_corpus_are_survived() {
    let files = files();
    let opened: usize = files
        .par_iter()
        .enumerate()
        .map(|(number, (name, bytes))| {
            let mut opened = 0;
            for mutation in 0..MUTATIONS {
                let mut stream = Stream::new(number as u64 * MUTATIONS + mutation);
                let mut mutant = bytes.clone();
                let donor = &files[below(&mut stream, files.len())].1;
                for _ in 0..1 + below(&mut stream, 4) {
                    mutate(&mut mutant, donor, &mut stream);
                }
                let _named = Named(name, mutation);
                exercise(&mutant);
                let opens = reseal(&mut mutant) && Container::open(&mutant).is_ok();
                opened += usize::from(opens);
            }
            opened
        })
        .sum();
    let all = files.len() * MUTATIONS as usize;
    assert!(
        opened > all / 4,
        "only {opened} of {all} mutants open once resealed"
    );
}

/// Says which mutant it was when a test fails.
struct Named<'n>(&'n str, u64);

impl Drop for Named<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("that was mutation {} of {}", self.1, self.0);
        }
    }
}

fn below(stream: &mut Stream, end: usize) -> usize {
    (stream.uniform() * end as f64) as usize
}

/// Changes `bytes` in one of the ways fuzzers do; `donor` is another file of the corpus.
fn mutate(bytes: &mut Vec<u8>, donor: &[u8], stream: &mut Stream) {
    if bytes.is_empty() {
        return;
    }
    let place = below(stream, bytes.len());
    match below(stream, 8) {
        // Flip a bit; set a byte.
        0 | 1 => bytes[place] ^= 1 << below(stream, 8),
        2 => bytes[place] = below(stream, 256) as u8,
        // Set a number, of any width, to one that tends to be overlooked.
        3 | 4 => {
            let width = 1 << below(stream, 4);
            let place = place / width * width;
            let numbers = [0, 1, u64::MAX, 1 << 63, 0x7FFF_FFFF, 0x8000, 0x1_0000, 2];
            let number = numbers[below(stream, numbers.len())].to_le_bytes();
            for (byte, new) in bytes[place..].iter_mut().zip(&number[..width]) {
                *byte = *new;
            }
        }
        // Splice: the same place of another file, or another place of this one.
        5 => {
            let end = (place + 1 + below(stream, 64)).min(donor.len());
            if let Some(spliced) = donor.get(place..end) {
                let end = end.min(bytes.len());
                bytes[place..end].copy_from_slice(&spliced[..end - place]);
            }
        }
        6 => {
            let length = 1 + below(stream, 64.min(bytes.len() - place));
            let from = below(stream, bytes.len() - length + 1);
            bytes.copy_within(from..from + length, place);
        }
        // Cut the end off, rarely: little of what is cut so opens.
        _ => {
            if below(stream, 8) == 0 {
                bytes.truncate(place);
            }
        }
    }
}
