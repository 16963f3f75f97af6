//! Maps that go wrong where anything can: no texel to interpolate with, no two alike, none inside the rim.

use glintbake_bake::normals::NormalMap;
use glintbake_format::model::Wrap;
use glintbake_samples::{Kind, Options, generate};

/// A map with a name.
#[derive(Clone, Debug)]
pub struct NamedMap {
    /// What the results call it.
    pub name: String,
    /// The map.
    pub map: NormalMap,
}

/// The built-in worst cases; with `quick`, those that differ the most.
pub fn built_in(quick: bool) -> Vec<NamedMap> {
    let named = |name: &str, map| NamedMap {
        name: name.to_owned(),
        map,
    };
    let mut maps = vec![
        named(
            "noise 13x7 clamp",
            sample(Kind::Noise, [13, 7], 4, Wrap::Clamp),
        ),
        named(
            "steps 12x12",
            // The steepest there is: neighbours lean to opposite sides, 82 degrees each.
            from([12, 12], Wrap::Repeat, |k| {
                [
                    if (k + k / 12).is_multiple_of(2) {
                        0.99
                    } else {
                        -0.99
                    },
                    0.0,
                ]
            }),
        ),
        named(
            "rim 8x8",
            // Normals on the horizon itself, where the disk's coordinates have no height.
            from([8, 8], Wrap::Repeat, |k| {
                if k.is_multiple_of(3) {
                    [1.0, 0.0]
                } else {
                    [0.6, 0.8]
                }
            }),
        ),
        named(
            // An example for copies, which need a square of a power of two.
            "example 16x16",
            sample(Kind::Waves, [16, 16], 5, Wrap::Repeat),
        ),
        named(
            "waves 72x64",
            sample(Kind::Waves, [72, 64], 3, Wrap::Repeat),
        ),
    ];
    if quick {
        return maps;
    }
    maps.extend([
        named(
            "constant 16x16",
            from([16, 16], Wrap::Repeat, |_| [0.1, -0.2]),
        ),
        named("one texel", from([1, 1], Wrap::Repeat, |_| [0.3, 0.3])),
        named("one texel clamp", from([1, 1], Wrap::Clamp, |_| [0.0, 0.0])),
        named(
            "column 1x50 clamp",
            from([1, 50], Wrap::Clamp, |k| [0.0, k as f32 / 60.0]),
        ),
        named("row 67x1", sample(Kind::Noise, [67, 1], 2, Wrap::Repeat)),
        named(
            "flakes 31x17",
            sample(Kind::Flakes, [31, 17], 3, Wrap::Repeat),
        ),
        named(
            "lattice 24x24",
            // What 8 bits hold, coarser than a bin of any roughness below 0.01.
            from([24, 24], Wrap::Repeat, |k| {
                let level = |step: usize, levels: usize| ((k * step) % levels) as f32 / 127.5 - 0.4;
                [level(7, 100), level(13, 90)]
            }),
        ),
    ]);
    maps
}

fn from([width, height]: [u32; 2], wrap: Wrap, normal: impl Fn(usize) -> [f32; 2]) -> NormalMap {
    let texels = (0..width as usize * height as usize).map(normal).collect();
    NormalMap::new(width, height, wrap, texels)
}

fn sample(kind: Kind, [width, height]: [u32; 2], seed: u64, wrap: Wrap) -> NormalMap {
    let options = Options {
        width,
        height,
        seed,
        ..Options::new(kind, 1)
    };
    let sample = generate(kind, &options).expect("the sizes of built-in maps are in range");
    NormalMap::new(width, height, wrap, sample.normals)
}
