//! The seed corpus: small packages for fuzzing to start from, sound ones and damaged ones.

use crate::fixtures::{package, sample_map};
use crate::lies::{reseal, section_range};
use glintbake_bake::MethodRecipe;
use glintbake_bake::normals::NormalMap;
use glintbake_format::Container;
use glintbake_format::model::{Method, Wrap};
use glintbake_samples::Kind;
use std::path::{Path, PathBuf};

/// A file of the corpus.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Name of the file.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// Where the corpus is committed.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/package")
}

/// What a seed's name begins with if the package is sound; the others are damaged.
pub const SOUND: &str = "sound-";

/// The most bytes of a seed: fuzzing is quick where inputs are small. Sections begin at multiples of 256, so a package
/// of two instances with all there is cannot be much smaller.
pub const MOST_BYTES: usize = 6144;

/// All seeds, baked and then damaged: every method, kind of index, wrap and section there is.
pub fn seeds() -> Vec<Seed> {
    let mut seeds: Vec<Seed> = sound()
        .into_iter()
        .map(|(name, bytes)| Seed {
            name: format!("{SOUND}{name}.glint"),
            bytes,
        })
        .collect();
    seeds.extend(damaged(&all_sections()));
    seeds
}

fn flakes(map: &NormalMap, roughness: &[f64], leaf_size: u32, exact_normals: bool) -> Vec<u8> {
    let recipe = MethodRecipe {
        leaf_size,
        exact_normals,
        ..MethodRecipe::new(Method::FlakeBins, roughness)
    };
    package(map, recipe)
}

fn specular(map: &NormalMap, bins: u32) -> Vec<u8> {
    let recipe = MethodRecipe {
        bins: Some(bins),
        leaf_size: 2,
        ..MethodRecipe::new(Method::SpecularBins, &[])
    };
    package(map, recipe)
}

fn sound() -> Vec<(&'static str, Vec<u8>)> {
    let repeat = sample_map(Kind::Flakes, 9, 7, 5, Wrap::Repeat);
    let clamp = sample_map(Kind::Noise, 7, 8, 2, Wrap::Clamp);
    vec![
        ("dense-repeat", flakes(&repeat, &[0.9], 2, false)),
        ("dense-clamp", flakes(&clamp, &[0.7], 2, false)),
        ("sparse-repeat", flakes(&repeat, &[0.004], 32, false)),
        ("sparse-clamp-exact", flakes(&clamp, &[0.002], 3, true)),
        ("all-sections", all_sections()),
        ("two-roughnesses", flakes(&repeat, &[0.9, 0.002], 32, true)),
        ("specular-dense", specular(&repeat, 4)),
        ("specular-sparse", specular(&clamp, 50)),
        (
            "one-texel",
            flakes(
                &sample_map(Kind::Flat, 1, 1, 0, Wrap::Clamp),
                &[0.5],
                1,
                true,
            ),
        ),
        (
            "one-row",
            flakes(
                &sample_map(Kind::Waves, 53, 1, 3, Wrap::Repeat),
                &[0.8],
                4,
                false,
            ),
        ),
    ]
}

/// A package whose one instance has every kind of section: flakes share bins, so that there are few and long lists.
fn all_sections() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 9, 7, 5, Wrap::Repeat);
    flakes(&map, &[0.004], 2, true)
}

/// `sound` cut, flipped, and with one resealed lie in each of its sections.
fn damaged(sound: &[u8]) -> Vec<Seed> {
    let mut flipped = sound.to_vec();
    let last = flipped.len() - 1;
    flipped[last] ^= 1;
    let mut seeds = vec![
        Seed {
            name: "cut.glint".to_owned(),
            bytes: sound[..sound.len() / 2].to_vec(),
        },
        Seed {
            name: "flipped-bit.glint".to_owned(),
            bytes: flipped,
        },
    ];
    let container = Container::open(sound).expect("a fresh package opens");
    for entry in container.entries() {
        let range = section_range(sound, entry.kind, entry.instance.get());
        let mut bytes = sound.to_vec();
        // One element in the middle, or its last bytes if it is large.
        let size = (entry.element_size.get() as usize).min(8);
        let middle = range.start + range.len() / 2;
        let end = middle.next_multiple_of(size).min(range.end);
        bytes[end - size..end].fill(0xFF);
        let resealed = reseal(&mut bytes);
        assert!(resealed, "a sound package has room for its table");
        let kind = entry.kind.to_string().to_lowercase();
        seeds.push(Seed {
            name: format!("lie-{kind}.glint"),
            bytes,
        });
    }
    seeds
}
