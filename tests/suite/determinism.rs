//! The same inputs and options give the same bytes, whatever the number of threads.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, Recipe, bake};
use glintbake_format::model::{Kernel, Method, Wrap};
use glintbake_format::records::InverseKind;
use glintbake_runtime::Package;
use glintbake_samples::Kind;
use glintbake_tests::fixtures::sample_map;

fn recipe() -> Recipe {
    let flakes = MethodRecipe {
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, &[0.002, 0.05])
    };
    Recipe::new(vec![flakes, MethodRecipe::new(Method::SpecularBins, &[])])
}

/// Every method, by its name's defaults.
fn recipe_of_all() -> Recipe {
    let mut recipe = recipe();
    for method in [
        Method::Lean,
        Method::ClusterTree,
        Method::Lobes,
        Method::Analytic,
    ] {
        recipe.methods.push(MethodRecipe::new(method, &[0.05]));
    }
    recipe
}

fn bytes_with_threads(kind: Kind, threads: usize) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a pool of a few threads starts");
    // Large enough that work is split, and generated anew so that the samples are covered as well.
    pool.install(|| {
        let map = sample_map(kind, 400, 700, 11, Wrap::Repeat);
        bake(&map, &recipe_of_all(), None)
            .expect("the recipe is in range")
            .to_bytes()
    })
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads_or_the_run() {
    for kind in [Kind::Flakes, Kind::Noise] {
        let one = bytes_with_threads(kind, 1);
        for threads in [1, 2, 8] {
            assert!(
                one == bytes_with_threads(kind, threads),
                "{} {threads}",
                kind.name()
            );
        }
    }
}

#[test]
fn the_recipe_hash_tells_recipes_apart() {
    let map = NormalMap::new(4, 4, Wrap::Repeat, vec![[0.0, 0.0]; 16]);
    let hash = |recipe: &Recipe| {
        let bytes = bake(&map, recipe, None).expect("in range").to_bytes();
        Package::open(&bytes)
            .expect("fresh")
            .container()
            .header()
            .recipe_hash
    };
    let base = recipe();
    let mut seen = vec![hash(&base)];
    let with_tree: fn(&mut Recipe) = |recipe| {
        recipe
            .methods
            .push(MethodRecipe::new(Method::ClusterTree, &[]));
    };
    let changes: [fn(&mut Recipe); 14] = [
        with_tree,
        |recipe| {
            let tree = MethodRecipe::new(Method::ClusterTree, &[0.1]);
            recipe.methods.push(tree);
        },
        |recipe| {
            let tree = MethodRecipe::new(Method::ClusterTree, &[]);
            let kernel = Some(Kernel::Disk);
            recipe.methods.push(MethodRecipe { kernel, ..tree });
        },
        |recipe| recipe.methods.push(MethodRecipe::new(Method::Lean, &[0.1])),
        |recipe| recipe.methods[0].inverse = Some(InverseKind::Forest),
        |recipe| recipe.methods[1].inverse = Some(InverseKind::None),
        |recipe| recipe.methods[0].roughness[0] = 0.003,
        |recipe| recipe.methods[0].leaf_size = 10,
        |recipe| recipe.methods[0].exact_normals = false,
        |recipe| recipe.methods[0].masking = false,
        |recipe| recipe.methods[1].bins = Some(63),
        |recipe| recipe.methods.truncate(1),
        |recipe| recipe.decode.repair = true,
        |recipe| recipe.exr_layer = Some("N".to_owned()),
    ];
    for change in changes {
        let mut changed = base.clone();
        change(&mut changed);
        let hash = hash(&changed);
        assert!(!seen.contains(&hash), "{changed:?}");
        seen.push(hash);
    }
    assert_eq!(hash(&base), seen[0]);
}

#[test]
fn baked_sections_match_their_snapshot() {
    let with = |inverse: Option<InverseKind>| {
        let mut recipe = recipe();
        for method in &mut recipe.methods {
            method.inverse = inverse;
        }
        sections(&recipe)
    };
    insta::assert_json_snapshot!("baked_sections", with(None));
    insta::assert_json_snapshot!("baked_sections_of_forests", with(Some(InverseKind::Forest)));
    let lean = MethodRecipe::new(Method::Lean, &[0.002, 0.05]);
    insta::assert_json_snapshot!("baked_sections_of_lean", sections(&Recipe::new(vec![lean])));
    let tree = MethodRecipe::new(Method::ClusterTree, &[0.002, 0.05]);
    insta::assert_json_snapshot!(
        "baked_sections_of_trees",
        sections(&Recipe::new(vec![tree]))
    );
    let none = with(Some(InverseKind::None));
    let of_maps = |line: &&String| !["LBLK", "LCNT", "LIST", "PAGE"].contains(&&line[..4]);
    let expected: Vec<_> = with(None).iter().filter(of_maps).skip(1).cloned().collect();
    assert_eq!(
        none[1..],
        expected,
        "the same without lists, but for the instances"
    );
}

/// Kind, instance, size and checksum of every section of a small map baked by `recipe`.
fn sections(recipe: &Recipe) -> Vec<String> {
    let map = sample_map(Kind::Flakes, 96, 64, 7, Wrap::Repeat);
    let bytes = bake(&map, recipe, None).expect("in range").to_bytes();
    let package = Package::open(&bytes).expect("fresh");
    package
        .container()
        .entries()
        .iter()
        .map(|entry| {
            // The metadata names the tool's version, so only its presence is pinned.
            let crc = match &entry.kind.0 {
                b"META" => "any".to_owned(),
                _ => format!("{:08x}", entry.crc.get()),
            };
            format!(
                "{} of {}: {} elements of {} bytes, CRC-32 {crc}",
                entry.kind,
                entry.instance.get(),
                if &entry.kind.0 == b"META" {
                    0
                } else {
                    entry.count.get()
                },
                entry.element_size.get(),
            )
        })
        .collect()
}
