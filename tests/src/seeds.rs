//! The seed corpus: small packages for fuzzing to start from, sound ones and damaged ones.

use crate::fixtures::{mixed_map, package, sample_map};
use crate::lies::{reseal, section_range};
use crate::materials::{Layer, material};
use crate::naive_lists;
use crate::small_surfaces;
use glintbake_bake::noise::{NoiseOptions, Transform, generate};
use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, NdfCopies, NdfMapRecipe, QuiltRecipe};
use glintbake_format::model::Interpolation::{CatmullRom, Linear, None as Constant};
use glintbake_format::model::{Kernel, LobeLattice, Method, Wrap};
use glintbake_format::records::InverseKind::{self, Forest, None as NoInverse, Tiles};
use glintbake_format::{Container, SectionEntry};
use glintbake_samples::Kind;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

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

/// The most bytes of a seed: fuzzing is quick where inputs are small. Sections begin at multiples of 256 and masking
/// takes 4096 bytes, so a package with all there is cannot be much smaller; only one has masking.
pub const MOST_BYTES: usize = 8192;

/// All seeds, baked and then damaged: every method, kind of index, wrap and section there is. Global NDFs are smaller than the
/// baker's.
pub fn seeds() -> Vec<Seed> {
    let mut seeds: Vec<Seed> = sound()
        .into_iter()
        .map(|(name, bytes)| Seed {
            name: format!("{SOUND}{name}.glint"),
            bytes,
        })
        .collect();
    seeds.extend(damaged(&[
        all_of_a_forest(),
        all_of_tiles(),
        all_of_lean(),
        all_of_a_tree(),
        all_of_lobes(),
        all_of_a_quilt(),
        all_of_a_material(),
        small_surfaces::package(
            &sample_map(Kind::Flakes, 9, 7, 5, Wrap::Repeat),
            Linear,
            &[0.1],
        ),
    ]));
    seeds
}

fn flakes(
    map: &NormalMap,
    roughness: &[f64],
    inverse: InverseKind,
    leaf_size: u32,
    exact_normals: bool,
) -> Vec<u8> {
    let recipe = MethodRecipe {
        inverse: Some(inverse),
        leaf_size,
        exact_normals,
        masking: false,
        ..MethodRecipe::new(Method::FlakeBins, roughness)
    };
    package(map, recipe)
}

fn specular(map: &NormalMap, bins: u32, inverse: InverseKind) -> Vec<u8> {
    let recipe = MethodRecipe {
        bins: Some(bins),
        inverse: Some(inverse),
        leaf_size: 2,
        masking: false,
        ..MethodRecipe::new(Method::SpecularBins, &[])
    };
    package(map, recipe)
}

fn lean(map: &NormalMap, roughness: &[f64], finest_level: u32) -> Vec<u8> {
    let recipe = MethodRecipe {
        finest_level: Some(finest_level),
        masking: false,
        ..MethodRecipe::new(Method::Lean, roughness)
    };
    package(map, recipe)
}

fn tree(map: &NormalMap, roughness: &[f64], kernel: Kernel) -> Vec<u8> {
    let recipe = MethodRecipe {
        kernel: Some(kernel),
        masking: false,
        ..MethodRecipe::new(Method::ClusterTree, roughness)
    };
    package(map, recipe)
}

fn lobes(map: &NormalMap, curved: bool, per_side: u8, alpha: f64) -> Vec<u8> {
    let recipe = MethodRecipe {
        lattice: Some(LobeLattice { curved, per_side }),
        masking: false,
        ..MethodRecipe::new(Method::Lobes, &[alpha])
    };
    package(map, recipe)
}

/// Blocks in 16 bits, wide ones and merged ones.
fn all_of_lobes() -> Vec<u8> {
    let texels = (0..20 * 7)
        .map(|texel| {
            let (x, y) = (texel % 20, f64::from(texel / 20));
            match x {
                3..13 => [0.1, -0.05],
                17..20 => [0.6 * (0.9 * f64::from(x) * y).sin() as f32, 0.4],
                _ => [0.1 + 0.01 * (0.3 * y).sin() as f32, -0.05],
            }
        })
        .collect();
    lobes(&NormalMap::new(20, 7, Wrap::Repeat, texels), true, 1, 0.004)
}

/// Patches, cuts, and cells of the sample and of the surface.
fn all_of_a_quilt() -> Vec<u8> {
    let sample = sample_map(Kind::Waves, 16, 16, 5, Wrap::Repeat);
    let quilt = QuiltRecipe {
        patch: Some(8),
        overlap: 1,
        ..QuiltRecipe::new([16, 8])
    };
    mip(&sample, Some(quilt))
}

/// A coat, flakes where an opacity map says, and a base.
fn all_of_a_material() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 5, 3, 5, Wrap::Repeat);
    let recipe = MethodRecipe {
        masking: false,
        ..MethodRecipe::new(Method::Lean, &[0.4])
    };
    let texels = (0..5 * 3).map(|texel: u8| texel.wrapping_mul(37)).collect();
    material(&[
        Layer::coat(1.5, 0.05),
        Layer::glints(&map, recipe, [0.9, 0.6, 0.3]).covering(5, 3, texels, Wrap::Repeat),
        Layer::base([0.04; 3], [0.1, 0.2, 0.5], 0.3),
    ])
}

/// Sixteen clusters a cell of lobes, one a texel, of `map` or of its quilt.
fn mip(map: &NormalMap, quilt: Option<QuiltRecipe>) -> Vec<u8> {
    let recipe = MethodRecipe {
        clusters: Some(16),
        lattice: LobeLattice::ALL.first().copied(),
        quilt,
        masking: false,
        ..MethodRecipe::new(Method::MipLobes, &[0.1])
    };
    package(map, recipe)
}

/// Images of an example of four texels a side, tiled or scattered.
fn copies(instances: Option<u32>) -> Vec<u8> {
    let example = sample_map(Kind::Waves, 2, 2, 5, Wrap::Repeat);
    let copies = match instances {
        None => NdfCopies::Tiled(Transform::default()),
        Some(count) => {
            let noise = generate(&NoiseOptions::new(count, 3));
            NdfCopies::Scattered(Arc::new(noise.expect("in range")))
        }
    };
    let recipe = MethodRecipe {
        ndf_maps: Some(NdfMapRecipe {
            size: Some(8),
            copies,
            ..NdfMapRecipe::default()
        }),
        masking: false,
        ..MethodRecipe::new(Method::NdfMaps, &[0.3])
    };
    package(&example, recipe)
}

fn sound() -> Vec<(&'static str, Vec<u8>)> {
    let repeat = sample_map(Kind::Flakes, 9, 7, 5, Wrap::Repeat);
    let clamp = sample_map(Kind::Noise, 7, 8, 2, Wrap::Clamp);
    let small = sample_map(Kind::Flakes, 5, 3, 5, Wrap::Repeat);
    let texel = sample_map(Kind::Flat, 1, 1, 0, Wrap::Clamp);
    let row = sample_map(Kind::Waves, 53, 1, 3, Wrap::Repeat);
    vec![
        ("all-of-a-forest", all_of_a_forest()),
        ("all-of-tiles", all_of_tiles()),
        ("dense-repeat", flakes(&repeat, &[0.9], Forest, 2, false)),
        ("dense-clamp", flakes(&clamp, &[0.7], Forest, 2, false)),
        ("dense-tiles", flakes(&clamp, &[0.7], Tiles, 1, true)),
        ("dense-none", flakes(&clamp, &[0.7], NoInverse, 1, false)),
        (
            "sparse-repeat",
            flakes(&repeat, &[0.004], Forest, 32, false),
        ),
        ("sparse-tiles", flakes(&repeat, &[0.004], Tiles, 1, false)),
        ("sparse-none", flakes(&repeat, &[0.004], NoInverse, 1, true)),
        (
            "sparse-clamp-exact",
            flakes(&clamp, &[0.002], Forest, 3, true),
        ),
        (
            "two-roughnesses",
            flakes(&repeat, &[0.9, 0.002], Tiles, 1, true),
        ),
        ("specular-dense", specular(&repeat, 4, Forest)),
        ("specular-sparse", specular(&clamp, 50, Tiles)),
        ("specular-none", specular(&clamp, 50, NoInverse)),
        ("lean", all_of_lean()),
        ("lean-coarse", lean(&clamp, &[0.002], 1)),
        ("lean-one-row", lean(&row, &[0.8], 0)),
        ("lean-one-texel", lean(&texel, &[0.5], 0)),
        ("lobes", all_of_lobes()),
        ("lobes-flat-clamp", lobes(&clamp, false, 1, 0.3)),
        ("lobes-of-quarters", lobes(&small, true, 2, 0.01)),
        ("lobes-one-texel", lobes(&texel, true, 1, 0.5)),
        ("mip-lobes", mip(&repeat, None)),
        ("mip-lobes-quilted", all_of_a_quilt()),
        ("ndf-maps", copies(None)),
        ("ndf-maps-scattered", copies(Some(12))),
        (
            "surface",
            small_surfaces::package(&repeat, Linear, &[0.1, 0.01]),
        ),
        (
            "surface-clamp",
            small_surfaces::package(&clamp, CatmullRom, &[0.05]),
        ),
        (
            "surface-of-texels",
            small_surfaces::package(&repeat, Constant, &[0.05]),
        ),
        ("material", all_of_a_material()),
        ("tree", all_of_a_tree()),
        ("tree-clamp", tree(&clamp, &[0.1], Kernel::Disk)),
        ("tree-one-texel", tree(&texel, &[0.5], Kernel::Beckmann)),
        ("tree-of-three-levels", {
            let row = sample_map(Kind::Brushed, 1, 258, 3, Wrap::Repeat);
            tree(&row, &[0.003], Kernel::Beckmann)
        }),
        ("one-texel", flakes(&texel, &[0.5], Forest, 1, true)),
        ("one-texel-tiles", flakes(&texel, &[0.5], Tiles, 1, false)),
        ("one-row", flakes(&row, &[0.8], Forest, 4, false)),
        ("one-row-tiles", flakes(&row, &[0.8], Tiles, 1, false)),
    ]
}

/// A package whose one instance has every kind of section that goes with a forest: flakes share bins, so that there are
/// few and long lists.
fn all_of_a_forest() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 9, 7, 5, Wrap::Repeat);
    let recipe = MethodRecipe {
        inverse: Some(Forest),
        leaf_size: 2,
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, &[0.004])
    };
    package(&map, recipe)
}

/// A package whose one instance has every kind of section that goes with tiles, and blocks that reach beyond the map.
fn all_of_tiles() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 16, 13, 5, Wrap::Repeat);
    naive_lists::package(&map, 0.004)
}

/// A package of two instances that share a pyramid, whose first level cuts texels and whose others do not.
fn all_of_lean() -> Vec<u8> {
    let map = sample_map(Kind::Flakes, 9, 7, 5, Wrap::Repeat);
    lean(&map, &[0.4, 0.02], 0)
}

/// A package of two instances that share a tree of two levels of tiles, with leaves of every kind.
fn all_of_a_tree() -> Vec<u8> {
    let map = mixed_map(65, 3, 3, Wrap::Repeat);
    tree(&map, &[0.02, 0.4], Kernel::Beckmann)
}

/// The first of `sound` cut and flipped, and each with one resealed lie in each section of a kind not yet lied in.
fn damaged(sound: &[Vec<u8>]) -> Vec<Seed> {
    let [first, ..] = sound else {
        return Vec::new();
    };
    let mut flipped = first.clone();
    let last = flipped.len() - 1;
    flipped[last] ^= 1;
    let mut seeds = vec![
        Seed {
            name: "cut.glint".to_owned(),
            bytes: first[..first.len() / 2].to_vec(),
        },
        Seed {
            name: "flipped-bit.glint".to_owned(),
            bytes: flipped,
        },
    ];
    let mut kinds = BTreeSet::new();
    for sound in sound {
        let container = Container::open(sound).expect("a fresh package opens");
        for entry in container.entries() {
            if kinds.insert(entry.kind) {
                seeds.push(lie_in(sound, entry));
            }
        }
    }
    seeds
}

/// `sound` with a lie in the section of `entry`.
fn lie_in(sound: &[u8], entry: &SectionEntry) -> Seed {
    let range = section_range(sound, entry.kind, entry.instance.get());
    let mut bytes = sound.to_vec();
    // One element in the middle, or its last bytes if it is large.
    let size = (entry.element_size.get() as usize).min(8);
    let middle = (range.start + range.len() / 2).max(range.start + 1);
    let end = (range.start + (middle - range.start).next_multiple_of(size)).min(range.end);
    bytes[end - size..end].fill(0xFF);
    let resealed = reseal(&mut bytes);
    assert!(resealed, "a sound package has room for its table");
    let kind = entry.kind.to_string().to_lowercase();
    Seed {
        name: format!("lie-{kind}.glint"),
        bytes,
    }
}
