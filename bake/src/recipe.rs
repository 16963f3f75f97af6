//! What a bake is asked for: the words of the recipe, and the hash that names it.

use crate::image::{InputFile, ReadOptions};
use crate::noise::{NoiseMap, Transform};
use crate::normals::{DecodeOptions, Statistics};
use glintbake_format::model::{Filter, Interpolation, Kernel, LobeLattice, Method};
use glintbake_format::records::InverseKind;
use serde::Serialize;
use std::sync::Arc;

/// Raised when the same recipe and inputs would give other bytes than the release before.
const ALGORITHM_VERSION: u32 = 3;

/// Everything that decides a package's bytes, besides the inputs' contents.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Recipe {
    /// The layer of an EXR input, if one was named.
    pub exr_layer: Option<String>,
    /// The channels of an EXR input, if they were named.
    pub exr_channels: Option<Vec<String>>,
    /// How the input is decoded.
    pub decode: DecodeOptions,
    /// What is baked from it.
    pub methods: Vec<MethodRecipe>,
}

/// What one method is asked for.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MethodRecipe {
    /// The method.
    #[serde(serialize_with = "method_name")]
    pub method: Method,
    /// Beckmann roughnesses α, one instance each; empty for a method without a kernel, and for `cluster-tree`
    /// if [`DEFAULT_ROUGHNESS`] will do for queries that name none.
    pub roughness: Vec<f64>,
    /// Bins a side, for a method that does not derive them.
    pub bins: Option<u32>,
    /// How the footprint of a query that names no filter weighs texels.
    #[serde(serialize_with = "filter_name")]
    pub filter: Filter,
    /// How the texels of a bin are to be found; `None` for what costs least on the map.
    #[serde(serialize_with = "inverse_name")]
    pub inverse: Option<InverseKind>,
    /// The longest list of a forest that is scanned without a tree.
    pub leaf_size: u32,
    /// The finest level of a pyramid, for a method that has one; `None` for the texels themselves.
    pub finest_level: Option<u32>,
    /// The kernel of a query that names none, for a method that has several; `None` for the method's own.
    #[serde(
        serialize_with = "kernel_name",
        skip_serializing_if = "Option::is_none"
    )]
    pub kernel: Option<Kernel>,
    /// The lobes, for a method that has them; `None` for curved ones, one a texel.
    #[serde(
        serialize_with = "lattice_name",
        skip_serializing_if = "Option::is_none"
    )]
    pub lattice: Option<LobeLattice>,
    /// Most that merging neighbouring lobes may change the density of one, of its peak; `None` for
    /// [`DEFAULT_MERGE_ERROR`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub merge_error: Option<f64>,
    /// How normals continue between texels, for a method that integrates over them; `None` for linear.
    #[serde(
        serialize_with = "interpolation_name",
        skip_serializing_if = "Option::is_none"
    )]
    pub interpolation: Option<Interpolation>,
    /// Clustered lobes of each cell, for a method that clusters; `None` for [`DEFAULT_CLUSTERS`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clusters: Option<u32>,
    /// The surface that the map is a sample of; `None` if it is the surface itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quilt: Option<QuiltRecipe>,
    /// The surface that copies of the map make up, for `ndf-maps`; `None` if they are tiled as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ndf_maps: Option<NdfMapRecipe>,
    /// Whether exact normals are stored, 4 bytes a texel.
    pub exact_normals: bool,
    /// Whether a cluster tree has a raster of normals beside it, 4 bytes a texel.
    #[serde(skip_serializing_if = "is_false")]
    pub raster_normals: bool,
    /// Whether the masking of the map's own normals is stored: 4 KB, once for all methods and roughnesses that ask.
    pub masking: bool,
}

/// A surface quilted from a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct QuiltRecipe {
    /// Columns and rows of the surface.
    pub target: [u32; 2],
    /// Texels from one patch to the next, a power of two; `None` for [`patch_of`](Self::patch_of).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patch: Option<u32>,
    /// Columns, or rows, that neighbouring blocks share.
    pub overlap: u32,
    /// Most that blocks may differ where they meet, of the mean difference of two texels of the sample, for chance to choose among
    /// them.
    pub tolerance: f64,
    /// What chance begins with.
    pub seed: u64,
}

impl QuiltRecipe {
    /// The quilt of `target` texels with the defaults of \[TZX22\].
    pub const fn new(target: [u32; 2]) -> Self {
        Self {
            target,
            patch: None,
            overlap: 2,
            tolerance: 0.1,
            seed: 0,
        }
    }

    /// The patch asked for, or else 64 texels, less for samples of less than 256: a quarter of them, and at least 8.
    pub fn patch_of(&self, sample: [u32; 2]) -> u32 {
        let quarter = sample[0].min(sample[1]) / 4;
        let largest = 1 << quarter.max(1).ilog2();
        self.patch
            .unwrap_or(largest)
            .clamp(8, if self.patch.is_some() { 4096 } else { 64 })
    }
}

/// A surface of copies of a tiny example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct NdfMapRecipe {
    /// Texels along each side of a tile of texture space; `None` for the example's own.
    pub size: Option<u32>,
    /// Where copies lie.
    pub copies: NdfCopies,
    /// Whether scale and shear of copies change the slopes of their normals.
    pub scales_slopes: bool,
    /// Distance of pixels in units of σr; `None` for [`DEFAULT_NDF_PITCH`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch: Option<f64>,
    /// Pixels along a side of each image, as in \[XTXW24\], instead of splines at a pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper_pixels: Option<u32>,
    /// Normal of what no copy covers, a point of the disk.
    pub ground: [f64; 2],
    /// Beckmann roughness α of what no copy covers; `None` for that of the instance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground_roughness: Option<f64>,
}

impl Default for NdfMapRecipe {
    fn default() -> Self {
        Self {
            size: None,
            copies: NdfCopies::Tiled(Transform::default()),
            scales_slopes: false,
            pitch: None,
            paper_pixels: None,
            ground: [0.0; 2],
            ground_roughness: None,
        }
    }
}

/// Where copies of an example lie.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NdfCopies {
    /// Close to each other, all transformed alike.
    Tiled(Transform),
    /// Where a noise map says.
    Scattered(#[serde(serialize_with = "noise_source")] Arc<NoiseMap>),
}

fn noise_source<S: serde::Serializer>(
    noise: &Arc<NoiseMap>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    noise.source.serialize(serializer)
}

/// Distance of pixels of a `ndf-maps` recipe that names none, in units of σr: peaks are then within 0.4 %.
pub const DEFAULT_NDF_PITCH: f64 = 1.0;

/// Clusters of a recipe that names none: what \[TZX22\] takes for glints.
pub const DEFAULT_CLUSTERS: u32 = 32;

/// Leaf size of a recipe that names none: with tight boxes, larger than the papers' 10 and 16 is faster and smaller.
pub const DEFAULT_LEAF_SIZE: u32 = 32;

/// Method of a bake that names none: one package for every roughness, kernel and filter.
pub const DEFAULT_METHOD: Method = Method::ClusterTree;

/// Beckmann roughness of `cluster-tree` queries that name none, in packages baked without one: sharp enough for flakes and
/// scratches to glint one by one, and wide beside the steps of 8-bit normals.
pub const DEFAULT_ROUGHNESS: f64 = 0.02;

/// Merge error of a `lobes` recipe that names none: a fiftieth of a percent of a lobe's peak.
pub const DEFAULT_MERGE_ERROR: f64 = 2e-4;

/// The filter of a recipe that names none: boxes, but for methods that are made for Gaussian footprints.
pub const fn default_filter(method: Method) -> Filter {
    match method {
        Method::Lobes | Method::Analytic | Method::MipLobes => Filter::Gaussian,
        _ => Filter::Box,
    }
}

impl MethodRecipe {
    /// `method` with the roughnesses `roughness` and defaults for the rest.
    pub fn new(method: Method, roughness: &[f64]) -> Self {
        Self {
            method,
            roughness: roughness.to_vec(),
            bins: None,
            filter: default_filter(method),
            inverse: None,
            leaf_size: DEFAULT_LEAF_SIZE,
            finest_level: None,
            kernel: None,
            lattice: None,
            merge_error: None,
            interpolation: None,
            clusters: None,
            quilt: None,
            ndf_maps: None,
            exact_normals: false,
            raster_normals: false,
            masking: true,
        }
    }

    fn instance_count(&self) -> u64 {
        self.roughness.len().max(1) as u64
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature is serde's"
)]
fn is_false(value: &bool) -> bool {
    !value
}

fn method_name<S: serde::Serializer>(method: &Method, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(method.name())
}

fn filter_name<S: serde::Serializer>(filter: &Filter, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(filter.name())
}

#[expect(clippy::ref_option, reason = "the signature is serde's")]
fn kernel_name<S: serde::Serializer>(
    kernel: &Option<Kernel>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kernel.map_or("default", Kernel::name))
}

#[expect(clippy::ref_option, reason = "the signature is serde's")]
fn lattice_name<S: serde::Serializer>(
    lattice: &Option<LobeLattice>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(lattice.map_or("default", LobeLattice::name))
}

#[expect(clippy::ref_option, reason = "the signature is serde's")]
fn interpolation_name<S: serde::Serializer>(
    interpolation: &Option<Interpolation>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(interpolation.map_or("default", Interpolation::name))
}

#[expect(clippy::ref_option, reason = "the signature is serde's")]
fn inverse_name<S: serde::Serializer>(
    inverse: &Option<InverseKind>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(inverse.map_or("auto", InverseKind::name))
}

/// Where the normals came from.
#[derive(Clone, Debug)]
pub struct Source {
    /// The input file, by name, size and hash.
    pub input: InputFile,
    /// Statistics of its normals.
    pub statistics: Statistics,
}

/// How an instance finds the texels of a bin, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Chosen {
    /// The instance.
    pub instance: u16,
    /// The kind chosen.
    pub inverse: &'static str,
    /// Why.
    pub reason: String,
}

/// How well the blocks of a quilt meet.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Quilted {
    /// The instance.
    pub instance: u16,
    /// Patches of the surface.
    pub patches: usize,
    /// Texels from one to the next.
    pub patch: u32,
    /// How many of them are among the least bad, as none was within the tolerance.
    pub forced: usize,
    /// Most that blocks were to differ where they meet, of the mean difference of two texels of the sample.
    pub tolerance: f64,
    /// What texels differ along cuts, likewise.
    pub mean_error: f64,
}

/// What a surface of copies has come to.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct NdfMapped {
    /// The instance.
    pub instance: u16,
    /// Copies that are seen; 1 if they are tiled.
    pub copies: usize,
    /// Copies that others hide wholly, and that are not stored.
    pub hidden: usize,
    /// The share of the surface that copies cover.
    pub covered: f64,
    /// Pixels of all NDF images.
    pub pixels: usize,
}

/// A section that is not in the package, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct LeftOut {
    /// The instance it would belong to.
    pub instance: u16,
    /// Its kind.
    pub section: &'static str,
    /// Why it is not there.
    pub reason: &'static str,
}

impl Recipe {
    /// A recipe for `methods`, its input read and decoded with every option at its default.
    pub fn new(methods: Vec<MethodRecipe>) -> Self {
        Self {
            exr_layer: None,
            exr_channels: None,
            decode: DecodeOptions::default(),
            methods,
        }
    }

    /// How the input is read.
    pub fn read_options(&self) -> ReadOptions {
        ReadOptions {
            exr_layer: self.exr_layer.clone(),
            exr_channels: self.exr_channels.clone(),
            ..ReadOptions::default()
        }
    }

    /// How many instances the package will have.
    pub fn instance_count(&self) -> u64 {
        self.methods.iter().map(MethodRecipe::instance_count).sum()
    }

    /// About the most memory that a bake takes, in bytes a texel: 8 for the normals, 12 for each instance with bins (of
    /// which about 7 stay until the package is written), 4 for exact normals, 4 for a raster of normals, 20 for a
    /// pyramid, 24 for a cluster tree, 40 for each lobe and 12 for a surface, which instances share.
    ///
    /// For planning only. White noise below a roughness of 0.001, with nearly a bin to each texel, takes half as much
    /// again; flakes take three quarters of it.
    pub fn bytes_per_texel(&self) -> u64 {
        let stored = |is_asked: fn(&MethodRecipe) -> bool| {
            if self.methods.iter().any(is_asked) {
                4
            } else {
                0
            }
        };
        let structures = |method: &MethodRecipe| match method.method {
            Method::FlakeBins | Method::SpecularBins => 12 * method.instance_count(),
            Method::Lean => 20,
            Method::ClusterTree => 24,
            Method::Lobes => {
                let per_side = method.lattice.map_or(1, |lattice| lattice.per_side);
                40 * u64::from(per_side) * u64::from(per_side)
            }
            // A cell of eight texels a side has 32 lobes of 32 bytes as a rule, and those of a surface are no more.
            Method::MipLobes => 60,
            Method::Analytic => 12,
            // Maps that are not tiny are refused.
            Method::NdfMaps => 60,
        };
        let structures: u64 = self.methods.iter().map(structures).sum();
        8 + structures
            + stored(|method| method.exact_normals)
            + stored(|method| method.raster_normals)
    }

    /// The cache key: BLAKE3 of the recipe's canonical bytes, the inputs' hashes and the algorithm's version.
    ///
    /// Two bakes with the same key give the same bytes. Names of inputs are in it, as metadata records them.
    pub fn hash(&self, inputs: &[&InputFile]) -> [u8; 32] {
        hash_of(self, inputs)
    }
}

/// BLAKE3 of the canonical bytes of `recipe`, of the names and hashes of `inputs` and of the algorithm's version.
pub(crate) fn hash_of(recipe: &impl Serialize, inputs: &[&InputFile]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&canonical_bytes(&(
        ALGORITHM_VERSION,
        env!("CARGO_PKG_VERSION"),
        recipe,
    )));
    for input in inputs {
        hasher.update(&canonical_bytes(&(&input.name, input.bytes)));
        hasher.update(&input.blake3);
    }
    *hasher.finalize().as_bytes()
}

/// The canonical bytes of `value`; the only use of bincode, and never read back.
fn canonical_bytes(value: &impl Serialize) -> Vec<u8> {
    bincode::serde::encode_to_vec(value, bincode::config::standard())
        .expect("recipes hold nothing that cannot be encoded")
}
