//! Writes the seed corpus of `fuzz/` anew: `cargo run -p glintbake-tests --example corpus`.
//!
//! To be run, and its result committed, when packages have gained or changed a section.

use glintbake_tests::seeds::{MOST_BYTES, folder, seeds};
use std::{fs, io};

fn main() -> io::Result<()> {
    let folder = folder();
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    for seed in seeds() {
        assert!(
            seed.bytes.len() <= MOST_BYTES,
            "{} has {} bytes; make its map smaller",
            seed.name,
            seed.bytes.len()
        );
        fs::write(folder.join(&seed.name), &seed.bytes)?;
        println!("{:>5} bytes  {}", seed.bytes.len(), seed.name);
    }
    Ok(())
}
