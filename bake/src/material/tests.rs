use super::file::parse;
use super::*;
use crate::recipe::MethodRecipe;
use glintbake_format::model::{Filter, Method, Wrap};
use glintbake_format::records::LayerKind;
use std::path::Path;

fn read(text: &str) -> Result<MaterialRecipe, MaterialError> {
    parse("paint.toml", Path::new("folder"), text)
}

/// What is said of `text`, which is wrong.
fn wrong(text: &str) -> String {
    read(text).expect_err(text).to_string()
}

#[test]
fn keys_become_recipes_and_what_is_left_out_has_defaults() {
    let recipe = read(
        r#"
            [[layer]]
            kind = "coat"

            [[layer]]
            kind = "glints"
            map = "maps/flakes.png"
            method = "flake-bins"
            intrinsic-roughness = 0.1
            scale = [4, 2.5]
            f0 = [1, 0.5, 0.25]
            filter = "gaussian"
            y = "dx"
            wrap = "clamp"
            opacity = 0.5
            opacity-map = "mask.png"
            masking = false

            [[layer]]
            kind = "base"
            diffuse = 0.5
            roughness = 1
        "#,
    )
    .unwrap();
    let [coat, glints, base] = &*recipe.layers else {
        panic!("three layers");
    };
    assert_eq!(
        (coat.kind, coat.ior, coat.lobe),
        (LayerKind::Coat, 1.5, 0.001)
    );
    assert_eq!(
        (coat.colour, coat.f0, coat.opacity),
        ([1.0; 3], [0.0; 3], 1.0)
    );
    assert!(coat.map.is_none() && coat.opacity_map.is_none());
    assert_eq!((glints.scale, glints.f0), ([4.0, 2.5], [1.0, 0.5, 0.25]));
    assert_eq!((glints.opacity, glints.opacity_wrap), (0.5, Wrap::Clamp));
    assert_eq!(
        glints.opacity_map.as_deref(),
        Some(Path::new("folder/mask.png"))
    );
    let map = glints.map.as_ref().unwrap();
    assert_eq!(map.path, Path::new("folder/maps/flakes.png"));
    assert_eq!(map.recipe.decode.green.name(), "dx");
    assert_eq!(map.recipe.decode.wrap, Wrap::Clamp);
    let expected = MethodRecipe {
        filter: Filter::Gaussian,
        masking: false,
        ..MethodRecipe::new(Method::FlakeBins, &[0.1 * std::f64::consts::SQRT_2])
    };
    assert_eq!(map.recipe.methods, [expected]);
    assert_eq!(
        (base.lobe, base.colour, base.f0),
        (1.0, [0.5; 3], [0.04; 3])
    );
    let one = read("layer = [{ kind = \"glints\", map = \"a.png\" }]").unwrap();
    let method = &one.layers[0].map.as_ref().unwrap().recipe.methods[0];
    // As on the command line: the tree takes queries of any roughness, and stores one for those that name none.
    assert_eq!(
        (method.method, method.roughness.len()),
        (Method::ClusterTree, 0)
    );
}

#[test]
fn what_is_no_toml_is_named_with_its_line() {
    for (text, line, part) in [
        ("[[layer]]\nkind = \"coat\"\nior == 2", 3, ""),
        (
            "[[layer]]\nkind = \"coat\"\nroughnes = 0.1",
            3,
            "unknown field `roughnes`, expected one of",
        ),
        ("[[layers]]\nkind = \"coat\"", 1, "unknown field `layers`"),
        (
            "[[layer]]\nkind = \"clearcoat\"",
            2,
            "kind: \"clearcoat\" is none of coat, glints, base",
        ),
        ("[[layer]]\nior = 1.5", 1, "missing field `kind`"),
        (
            "[[layer]]\nkind = \"base\"\nf0 = [1, 2]",
            3,
            "f0: invalid length 2, expected a number, or 3 in brackets",
        ),
        (
            "[[layer]]\nkind = \"base\"\nf0 = [1, 2, 3, 4]",
            3,
            "f0: invalid length 4",
        ),
        (
            "[[layer]]\nkind = \"base\"\nf0 = \"white\"",
            3,
            "f0: invalid type: string \"white\", expected a number, or 3",
        ),
        (
            "[[layer]]\nkind = \"glints\"\nmap = \"a\"\nbins = -1",
            4,
            "bins: ",
        ),
        (
            "[[layer]]\nkind = \"glints\"\nmap = \"a\"\nmethod = \"lobe\"",
            4,
            "method: \"lobe\" is none of flake-bins, ",
        ),
        (
            "[[layer]]\nkind = \"glints\"\nmap = \"a\"\ny = \"up\"",
            4,
            "y: unknown variant `up`, expected `gl` or `dx`",
        ),
    ] {
        let error = wrong(text);
        assert!(
            error.starts_with(&format!("paint.toml, line {line}: ")),
            "{error}"
        );
        assert!(error.contains(part), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn what_cannot_be_baked_is_named_with_layer_key_and_line() {
    let second = |kind: &str, keys: &str| {
        format!(
            "[[layer]]\nkind = \"coat\"\n\n[[layer]] # the second\nkind = \"{kind}\"\n{keys}\n\n[[layer]]\nkind = \"base\"\nior = 3"
        )
    };
    for (kind, keys, line, key, reason) in [
        (
            "coat",
            "f0 = 0.1",
            6,
            "f0",
            "index of refraction, ior; leave the key out",
        ),
        ("coat", "diffuse = 0.1", 6, "diffuse", "colour"),
        (
            "coat",
            "ior = 0.5",
            6,
            "ior",
            "0.5: it must lie between 1 and 4; lacquer has 1.5",
        ),
        ("coat", "ior = nan", 6, "ior", "NaN: it must lie between"),
        (
            "coat",
            "roughness = 0",
            6,
            "roughness",
            "0: it must lie between 0.0001 and 1",
        ),
        (
            "coat",
            "method = \"lean\"",
            6,
            "method",
            "only a layer with a map has it",
        ),
        (
            "coat",
            "masking = false",
            6,
            "masking",
            "only a layer with a map has it",
        ),
        (
            "coat",
            "wrap = \"clamp\"",
            6,
            "wrap",
            "a map or an opacity map",
        ),
        (
            "coat",
            "scale = 0",
            6,
            "scale",
            "between 0.001 and 1000, times that a map repeats",
        ),
        (
            "coat",
            "\nopacity = 1.5",
            7,
            "opacity",
            "1.5: it must lie between 0 and 1",
        ),
        ("glints", "", 4, "map", "glints come from a map"),
        (
            "glints",
            "map = \"a\"\nior = 2",
            7,
            "ior",
            "glints reflect by f0",
        ),
        (
            "glints",
            "map = \"a\"\ncolour = 1",
            7,
            "colour",
            "nothing passes glints",
        ),
        (
            "glints",
            "map = \"a\"\nf0 = [0, -0.1, 0]",
            7,
            "f0",
            "-0.1: it must lie between 0 and 1",
        ),
        (
            "glints",
            "map = \"a\"\nbins = 7",
            7,
            "bins",
            "cluster-tree has no bins; leave the key out, or set method to specular-bins",
        ),
        (
            "glints",
            "map = \"a\"\nroughness = 3",
            7,
            "roughness",
            "between 0.0001 and 1",
        ),
        (
            "glints",
            "map = \"a\"\nintrinsic-roughness = 3",
            7,
            "intrinsic-roughness",
            "between 0.0001 and 1",
        ),
        (
            "glints",
            "map = \"a\"\nroughness = 0.1\nintrinsic-roughness = 0.1",
            8,
            "intrinsic-roughness",
            "has a roughness already",
        ),
        (
            "glints",
            "map = \"a\"\nmethod = \"lean\"",
            4,
            "roughness",
            "lean is baked for given roughnesses",
        ),
        (
            "glints",
            "map = \"a\"\nseed = 7",
            7,
            "seed",
            "only a quilt has it, which target asks for",
        ),
        (
            "glints",
            "map = \"a\"\nmethod = \"mip-lobes\"\ntarget = 0.5",
            8,
            "target",
            "a whole number of texels",
        ),
        ("base", "map = \"a\"", 6, "map", "a base has no map"),
        ("base", "colour = 0.5", 6, "colour", "is called diffuse"),
        (
            "base",
            "diffuse = 2",
            6,
            "diffuse",
            "2: it must lie between 0 and 1",
        ),
    ] {
        let error = wrong(&second(kind, keys));
        let start = format!("paint.toml, line {line}: {key} of layer 1: ");
        assert!(error.starts_with(&start), "{error}");
        assert!(error.contains(reason), "{error}");
    }
    let error = wrong(&second("coat", ""));
    assert!(
        error.starts_with("paint.toml, line 10: ior of layer 2: a base reflects by f0"),
        "{error}"
    );
}

#[test]
fn a_material_has_one_to_eight_layers() {
    assert_eq!(
        wrong(""),
        "paint.toml: has 0 layers; give 1 to 8, each begun by a line [[layer]]"
    );
    let layers = |count: usize| "[[layer]]\nkind = \"base\"\n".repeat(count);
    assert_eq!(read(&layers(8)).unwrap().layers.len(), 8);
    assert!(wrong(&layers(9)).contains("has 9 layers"));
}

#[test]
fn the_hash_knows_every_key_and_input() {
    let none = MaterialInputs { layers: Vec::new() };
    let hash = |text: &str| read(text).unwrap().hash(&none);
    let base = "[[layer]]\nkind = \"base\"\nroughness = 0.3\n";
    assert_eq!(hash(base), hash(base));
    for other in [
        "[[layer]]\nkind = \"base\"\nroughness = 0.31\n",
        "[[layer]]\nkind = \"base\"\nroughness = 0.3\nf0 = 0.05",
        "[[layer]]\nkind = \"base\"\nroughness = 0.3\nopacity = 0.5",
        "[[layer]]\nkind = \"coat\"\nroughness = 0.3",
        "[[layer]]\nkind = \"base\"\nroughness = 0.3\n[[layer]]\nkind = \"base\"",
    ] {
        assert_ne!(hash(base), hash(other), "{other}");
    }
}
