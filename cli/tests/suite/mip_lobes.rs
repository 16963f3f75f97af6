//! `mip-lobes`: quilted surfaces, and the maps that they stand for, as a user types it.

use crate::densities::{QUERY, asked, error, query, write_queries};
use crate::workshop::Workshop;
use glintbake_bake::image::{self, ReadOptions};
use glintbake_bake::normals::{self, DecodeOptions, NormalMap};
use glintbake_bake::oracle::lobes::Prepared;
use glintbake_format::model::LobeLattice;
use serde_json::json;

const BAKE: [&str; 4] = ["bake", "map.png", "-o=map.glint", "--method=mip-lobes"];

/// A folder with a smooth sample, `map.glint` baked for `mip-lobes` with `options`, and `q.csv`.
fn workshop(options: &[&str]) -> Workshop {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=48x32", "-o=map.png"]);
    workshop.succeeds(&[&BAKE, options].concat());
    write_queries(&workshop);
    workshop
}

/// The normals of the image `name`.
fn normals_of(workshop: &Workshop, name: &str) -> NormalMap {
    let raster = image::read(&workshop.path(name), &ReadOptions::default()).expect("a map");
    let (map, _) = normals::decode(raster, &DecodeOptions::default()).expect("normals");
    map
}

#[test]
fn a_quilt_is_baked_expanded_and_answers_as_the_lobes_of_what_it_expands_to() {
    let workshop = workshop(&[
        "--target=96x64",
        "--patch=16",
        "--overlap=3",
        "--clusters=16",
        "--seed=5",
    ]);
    let line = "instance 1: mip-lobes 96 x 64, any roughness (0.02 by default), 4 lobes a texel, 16 clusters a cell from level 2 to 7, \
                quilted from 48 x 32 by patches of 16 + 3, repeat";
    let text = workshop.succeeds(&["inspect", "map.glint"]);
    assert!(text.contains(line), "{text}");
    assert!(text.contains("24 patches of 16 texels"), "{text}");
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    assert_eq!(document["metadata"]["quilted"][0]["patches"], 24);
    let quilt = &document["instances"][0]["quilt"];
    assert_eq!(
        *quilt,
        json!({"grid": 8, "overlap": 3, "patch": 16, "patches": [6, 4], "sample": [48, 32]})
    );
    assert_eq!(
        document["metadata"]["recipe"]["methods"][0]["quilt"]["seed"],
        5
    );
    let verified = workshop.succeeds(&["verify", "map.glint"]);
    assert!(verified.contains("sound"), "{verified}");

    let said = workshop.succeeds(&["expand", "map.glint", "-o=large.png"]);
    assert!(
        said.contains("96 x 64 texels of instance 1, mip-lobes"),
        "{said}"
    );
    let document = workshop.document(&["expand", "map.glint", "-o=large.png", "--json"]);
    assert_eq!(
        json!([document["width"], document["height"]]),
        json!([96, 64])
    );
    let map = normals_of(&workshop, "large.png");

    // The least footprint is answered by lobes themselves; 16 bits round normals by 1e-5.
    let (comment, found) = query(&workshop, &["--roughness=0.1"]);
    assert_eq!(
        comment,
        "# method=mip-lobes kernel=disk filter=gaussian roughness=0.1 clusters=16 setting=default"
    );
    let lattice = LobeLattice {
        curved: true,
        per_side: 2,
    };
    let expected: Vec<f64> = asked()
        .map(|(footprint, h)| Prepared::new(&map, &footprint, lattice, true).ndf(h, 0.1))
        .collect();
    assert!(
        (found[3] - expected[3]).abs() < 1e-3 * expected[3],
        "{found:?} {expected:?}"
    );
    assert!(error(&found, &expected) < 0.2, "{found:?} {expected:?}");
    let (comment, by_area) = query(&workshop, &["--roughness=0.1", "--paper"]);
    assert!(comment.ends_with("setting=paper"), "{comment}");
    assert_ne!(found, by_area);
}

#[test]
fn without_a_target_the_map_is_the_surface() {
    let workshop = workshop(&["--lobes=curved", "--clusters=16"]);
    let text = workshop.succeeds(&["inspect", "map.glint"]);
    let line = "mip-lobes 48 x 32, any roughness (0.02 by default), 1 lobes a texel, 16 clusters a cell from level 3 to 6, repeat";
    assert!(text.contains(line), "{text}");
    workshop.succeeds(&["expand", "map.glint", "-o=same.png"]);
    let texels = |name: &str| normals_of(&workshop, name).texels().to_vec();
    for (same, texel) in texels("same.png").iter().zip(texels("map.png")) {
        // Decoding makes vectors as long as 1, and encoding rounds them again.
        let near = |axis: usize| (same[axis] - texel[axis]).abs() < 4e-5;
        assert!(near(0) && near(1), "{same:?} {texel:?}");
    }
    // What a tree keeps is expanded as well.
    workshop.succeeds(&["bake", "map.png", "-o=tree.glint"]);
    workshop.succeeds(&["expand", "tree.glint", "-o=tree.png"]);
    workshop.refuses(
        2,
        &["expand", "tree.glint", "--instance=3", "-o=tree.png"],
        &["there is no instance 3"],
    );
    workshop.refuses(
        2,
        &["expand", "map.glint", "-o=map.glint"],
        &["--output map.glint", "it is the input"],
    );
}

#[test]
fn what_cannot_be_quilted_is_refused() {
    let workshop = workshop(&[]);
    for (options, says) in [
        (
            &["--target=64", "--patch=64"][..],
            "64 + 2 texels are larger than the sample",
        ),
        (
            &["--target=64", "--patch=16", "--overlap=16"],
            "--overlap 16",
        ),
        (&["--target=100", "--patch=16"], "give 112"),
        (&["--target=64", "--patch=24"], "a power of two"),
        (&["--target=wide"], "give a side in texels"),
        (&["--patch=16"], "--target <SIZE>"),
        (&["--clusters=17"], "a multiple of 16"),
        (&["--target=64", "--quilt-error=-1"], "between 0 and 1000"),
        (&["--lobes=flat"], "give curved, curved-4"),
        (&["--filter=box"], "Gaussian footprints"),
        (&["--wrap=clamp"], "quilt one with --target"),
    ] {
        workshop.refuses(2, &[&BAKE, options].concat(), &[says]);
    }
    workshop.refuses(
        2,
        &[
            "bake",
            "map.png",
            "-o=map.glint",
            "--method=lobes",
            "--target=64",
        ],
        &["lobes has no surface to quilt", "--method mip-lobes"],
    );
    workshop.refuses(2, &[&QUERY[..], &["--filter=box"]].concat(), &["mip-lobes"]);
}
