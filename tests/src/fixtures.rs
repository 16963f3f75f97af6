//! Maps, packages and queries for tests and benchmarks.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::{MethodRecipe, NdfMapRecipe, QuiltRecipe, Recipe, bake};
use glintbake_cli::measure::plan::Shape;
use glintbake_format::model::{
    Filter, Footprint, HalfVector, Interpolation, LobeLattice, Method, Wrap,
};
use glintbake_format::records::InverseKind;
use glintbake_samples::{Kind, Options, generate};

/// A sample map of `kind`, `width` × `height` texels.
pub fn sample_map(kind: Kind, width: u32, height: u32, seed: u64, wrap: Wrap) -> NormalMap {
    let options = Options {
        width,
        height,
        seed,
        ..Options::new(kind, 1)
    };
    let sample = generate(kind, &options).expect("the sizes of fixtures are in range");
    NormalMap::new(width, height, wrap, sample.normals)
}

/// The bytes of `map` baked for `flake-bins` at each roughness, with block lists and exact normals.
pub fn flake_package(map: &NormalMap, roughness: &[f64]) -> Vec<u8> {
    let recipe = MethodRecipe {
        inverse: Some(InverseKind::Tiles),
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, roughness)
    };
    package(map, recipe)
}

/// The bytes of `map` baked for `flake-bins` at each roughness, with a forest of leaf size `leaf_size` and exact normals.
pub fn forest_package(map: &NormalMap, roughness: &[f64], leaf_size: u32) -> Vec<u8> {
    let recipe = MethodRecipe {
        inverse: Some(InverseKind::Forest),
        leaf_size,
        exact_normals: true,
        ..MethodRecipe::new(Method::FlakeBins, roughness)
    };
    package(map, recipe)
}

/// The bytes of `map` baked for `specular-bins` with `bins` a side.
pub fn specular_package(map: &NormalMap, bins: u32) -> Vec<u8> {
    let recipe = MethodRecipe {
        bins: Some(bins),
        ..MethodRecipe::new(Method::SpecularBins, &[])
    };
    package(map, recipe)
}

/// The bytes of `map` baked for `lean` at each roughness.
pub fn lean_package(map: &NormalMap, roughness: &[f64]) -> Vec<u8> {
    package(map, MethodRecipe::new(Method::Lean, roughness))
}

/// The bytes of `map` baked for `cluster-tree` with each roughness as a default.
pub fn tree_package(map: &NormalMap, roughness: &[f64]) -> Vec<u8> {
    package(map, MethodRecipe::new(Method::ClusterTree, roughness))
}

/// The bytes of `map` baked for `lobes` of `lattice`, for each roughness.
pub fn lobes_package(map: &NormalMap, lattice: LobeLattice, roughness: &[f64]) -> Vec<u8> {
    let recipe = MethodRecipe {
        lattice: Some(lattice),
        ..MethodRecipe::new(Method::Lobes, roughness)
    };
    package(map, recipe)
}

/// The bytes of `map` baked for `analytic` by `interpolation`, for each roughness.
pub fn surface_package(
    map: &NormalMap,
    interpolation: Interpolation,
    roughness: &[f64],
) -> Vec<u8> {
    let recipe = MethodRecipe {
        interpolation: Some(interpolation),
        ..MethodRecipe::new(Method::Analytic, roughness)
    };
    package(map, recipe)
}

/// The bytes of `map` baked for `mip-lobes` of `clusters` a cell, quilted by `quilt` if there is one, for each roughness.
pub fn mip_package(
    map: &NormalMap,
    clusters: u32,
    quilt: Option<QuiltRecipe>,
    roughness: &[f64],
) -> Vec<u8> {
    let recipe = MethodRecipe {
        clusters: Some(clusters),
        quilt,
        ..MethodRecipe::new(Method::MipLobes, roughness)
    };
    package(map, recipe)
}

/// The bytes of `example` baked for `ndf-maps` by `asked`, for each roughness.
pub fn ndf_maps_package(example: &NormalMap, asked: NdfMapRecipe, roughness: &[f64]) -> Vec<u8> {
    let recipe = MethodRecipe {
        ndf_maps: Some(asked),
        ..MethodRecipe::new(Method::NdfMaps, roughness)
    };
    package(example, recipe)
}

/// A map of which the left half is flakes and the right noise, above its last rows of waves: cluster trees store leaves of
/// every kind for it.
pub fn mixed_map(width: u32, height: u32, seed: u64, wrap: Wrap) -> NormalMap {
    let [flakes, noise, waves] = [Kind::Flakes, Kind::Noise, Kind::Waves]
        .map(|kind| sample_map(kind, width, height, seed, wrap));
    let texels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let normals = texels.map(|(column, row)| {
        let map = match (column < width / 2, row < height - height / 3) {
            (_, false) => &waves,
            (true, true) => &flakes,
            (false, true) => &noise,
        };
        map.texels()[(row * width + column) as usize]
    });
    NormalMap::new(width, height, wrap, normals.collect())
}

/// The bytes of `map` baked by `recipe`.
pub fn package(map: &NormalMap, recipe: MethodRecipe) -> Vec<u8> {
    bake(map, &Recipe::new(vec![recipe]), None)
        .expect("the recipes of fixtures are in range")
        .to_bytes()
}

/// A stream of numbers that depends on its seed alone, and what queries are made of them.
#[derive(Clone, Debug)]
pub struct Stream(glintbake_cli::measure::stream::Stream);

impl Stream {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(glintbake_cli::measure::stream::Stream::new(seed))
    }

    /// The next number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0.uniform()
    }

    /// The next number in [`low`, `high`).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A footprint around a random point, with edges of about `texels` texels at random angles on `map`.
    pub fn footprint(&mut self, map: &NormalMap, texels: f64) -> Footprint {
        let size = [f64::from(map.width()), f64::from(map.height())];
        let mut edge = || {
            let angle = self.between(0.0, core::f64::consts::TAU);
            let length = texels * self.between(0.5, 1.5);
            [
                length * angle.cos() / size[0],
                length * angle.sin() / size[1],
            ]
        };
        let (edge_1, edge_2) = (edge(), edge());
        Footprint {
            centre: [self.between(-2.0, 3.0), self.between(-2.0, 3.0)],
            edge_1,
            edge_2,
        }
    }

    /// A square footprint of `edge` texels anywhere on `map`, turned by any angle, with a half vector near a normal below it
    /// for Beckmann roughness `alpha`.
    pub fn turned_square(
        &mut self,
        map: &NormalMap,
        edge: f64,
        alpha: f64,
    ) -> (Footprint, HalfVector) {
        let shape = Shape {
            filter: Filter::Box,
            sigma: 0.5 * edge,
            anisotropy: 1.0,
        };
        let footprint = shape.footprint(map, &mut self.0);
        (
            footprint,
            self.half_vector_near(map, &footprint, 0.3 * alpha),
        )
    }

    /// The normal of a random texel near the middle of `footprint`, moved by up to `spread` on the disk.
    pub fn half_vector_near(
        &mut self,
        map: &NormalMap,
        footprint: &Footprint,
        spread: f64,
    ) -> HalfVector {
        let (a, b) = (self.uniform() - 0.5, self.uniform() - 0.5);
        let place = |axis: usize, size: u32| {
            let x =
                footprint.centre[axis] + a * footprint.edge_1[axis] + b * footprint.edge_2[axis];
            ((x - x.floor()) * f64::from(size)) as usize % size as usize
        };
        let texel = place(1, map.height()) * map.width() as usize + place(0, map.width());
        let [s, t] = map.texels()[texel];
        HalfVector {
            s: f64::from(s) + self.between(-spread, spread),
            t: f64::from(t) + self.between(-spread, spread),
        }
    }
}
