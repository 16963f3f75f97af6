//! `bake`

use super::decode::DecodeArgs;
use super::ndf_maps::NdfMapArgs;
use super::roughness::RoughnessArgs;
use super::select::{filter, kernel, method};
use crate::exit::{CommandError, Failure};
use clap::Args;
use glintbake_bake::image::ReadOptions;
use glintbake_bake::{
    BakeError, DEFAULT_LEAF_SIZE, DEFAULT_METHOD, DEFAULT_ROUGHNESS, MethodRecipe, QuiltRecipe,
    Recipe, default_filter,
};
use glintbake_format::model::{
    Filter, Interpolation, Kernel, LobeLattice, Method, beckmann_from_intrinsic,
};
use glintbake_format::records::InverseKind;
use std::path::PathBuf;

/// What a roughness means depends on the method, here alone.
fn roughness_help() -> String {
    format!(
        "Beckmann roughnesses α, with commas between, an instance for each. flake-bins and lean answer for these alone; \
         cluster-tree, lobes, analytic and mip-lobes for any, and for the first if a query names none; ndf-maps for these alone [default for these \
         five: {DEFAULT_ROUGHNESS}]. lobes are rounded for the least of them: name the sharpest that will be asked for"
    )
}

/// `bake`
#[derive(Debug, Args)]
#[command(mut_arg("roughness", |argument| argument.help(roughness_help())))]
pub struct BakeArgs {
    /// Normal map or height map: PNG, TGA, TIFF, JPEG, WebP or EXR; or a layered material: a TOML file, whose name ends in
    /// .toml and which says of each of its maps how it is baked
    pub image: PathBuf,

    /// Package to write; replaced as a whole or not at all
    #[arg(long, short)]
    pub output: PathBuf,

    /// Methods to bake for, with commas between: cluster-tree (any roughness, within an error), flake-bins (bins of one
    /// roughness), specular-bins (mirrors), lean (one Gaussian lobe, for distant surfaces), lobes (Gaussian lobes of
    /// position and normal, any roughness), analytic (integrals over interpolated normals, any roughness), mip-lobes (clustered lobes, level by level, of the map or of a
    /// surface quilted from it, any roughness), ndf-maps (NDF images of a tiny map, whose copies make up a surface)
    /// [default: cluster-tree]
    #[arg(long, value_delimiter = ',', value_parser = method)]
    pub method: Vec<Method>,

    /// What methods are baked for, or what queries default to
    #[command(flatten)]
    pub roughness: RoughnessArgs,

    /// Bins a side for specular-bins [default: 127]
    #[arg(long, value_name = "N")]
    pub bins: Option<u32>,

    /// How the footprint of a query that names no filter weighs texels: box or gaussian [default: box, which ndf-maps has
    /// no other of; gaussian for lobes, analytic and mip-lobes, which have no other]
    #[arg(long, value_parser = filter)]
    pub filter: Option<Filter>,

    /// How flake-bins and specular-bins find the texels of a bin: tiles, forest, none (the bin map is scanned), or
    /// auto for what costs least
    #[arg(long, default_value = "auto", value_name = "KIND", value_parser = inverse)]
    pub index: IndexChoice,

    /// Longest list of texels without a tree, for --index forest [default: 32]
    #[arg(long, value_name = "N")]
    pub leaf_size: Option<u32>,

    /// Finest level of lean's pyramid: 0 the texels, each next one of twice their size [default: 0]
    #[arg(long, value_name = "N")]
    pub finest_level: Option<u32>,

    /// Kernel of a query that names none, for cluster-tree: beckmann or disk [default: beckmann]
    #[arg(long, value_parser = kernel)]
    pub kernel: Option<Kernel>,

    /// What the methods lobes and mip-lobes are made of: curved or flat lobes, one a texel; curved-4 or flat-4, four [default:
    /// curved, and curved-4 for mip-lobes]
    #[arg(long, value_name = "KIND", value_parser = lobes)]
    pub lobes: Option<LobeLattice>,

    /// Most that merging of near-equal lobes may change a density, as a share of a lobe's peak [default: 0.0005]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub merge_error: Option<f64>,

    /// How normals continue between texels, for analytic: none (flakes), linear, or catmull-rom [default: linear]
    #[arg(long, value_name = "KIND", value_parser = interpolation)]
    pub interpolate: Option<Interpolation>,

    /// Clustered lobes of each cell, for mip-lobes: a multiple of 16, to 128 [default: 32]
    #[arg(long, value_name = "N")]
    pub clusters: Option<u32>,

    /// Side in texels, or two sides as in 4096x2048, of the surface that mip-lobes quilts from the map, which is a sample of it
    /// [default: the map is the surface]
    #[arg(long, value_name = "SIZE", value_parser = target)]
    pub target: Option<[u32; 2]>,

    /// Texels from one patch of the quilt to the next, a power of two from 8 [default: 64, or a quarter of smaller samples]
    #[arg(long, value_name = "TEXELS", requires = "target")]
    pub patch: Option<u32>,

    /// Texels that neighbouring patches share, and that the cut between them runs through
    #[arg(long, value_name = "TEXELS", requires = "target", default_value_t = 2)]
    pub overlap: u32,

    /// Most that patches may differ where they meet for chance to choose among them, as a share of how much two texels of the sample
    /// differ on average
    #[arg(
        long,
        value_name = "SHARE",
        requires = "target",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    pub quilt_error: f64,

    /// Seed of a quilt, or of --instances; the same seed gives the same surface on every machine
    #[arg(long, default_value_t = 0)]
    pub seed: u64,

    /// What surface copies of the map make up
    #[command(flatten)]
    pub ndf_maps: NdfMapArgs,

    /// Store true normals beside flake-bins (4 bytes a texel), for `query --exact`
    #[arg(long)]
    pub exact_normals: bool,

    /// Store a raster of normals beside the tree of cluster-tree (4 bytes a texel), which small footprints are scanned in
    #[arg(long)]
    pub raster_normals: bool,

    /// Leave out the masking of the map's own normals (4 KB): the renderer brings its own
    #[arg(long)]
    pub no_masking: bool,

    /// How the image is read
    #[command(flatten)]
    pub decode: DecodeArgs,

    /// Most memory a bake may take, as in 6GB or 500MB; a map that would take more is refused before it is read.
    /// Counted as 8 bytes a texel, 12 for each instance with bins, 20 for lean, 24 for cluster-tree, 40 for each lobe of
    /// lobes, 12 for analytic, 60 for mip-lobes and ndf-maps, and 4 each for --exact-normals and --raster-normals
    #[arg(long, default_value = "16GB", value_name = "SIZE", value_parser = memory)]
    pub memory: u64,

    /// Write a rule for make or ninja that names what the package depends on
    #[arg(long, value_name = "FILE")]
    pub depfile: Option<PathBuf>,

    /// Also draw a ball covered with the baked map
    #[arg(long, value_name = "PNG")]
    pub preview: Option<PathBuf>,

    /// Bake even if the package is up to date
    #[arg(long)]
    pub force: bool,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// The lobes called `name`; for the command line.
fn lobes(name: &str) -> Result<LobeLattice, String> {
    let mut all = LobeLattice::ALL.iter().copied();
    all.find(|lattice| lattice.name() == name)
        .ok_or_else(|| "it must be one of curved, flat, curved-4, flat-4".to_owned())
}

/// A side, or two with an x between.
fn target(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse::<u32>().ok();
    let sides = match text.split_once('x') {
        None => side(text).map(|side| [side; 2]),
        Some((width, height)) => side(width).zip(side(height)).map(Into::into),
    };
    sides.ok_or_else(|| "give a side in texels, as in 4096, or two, as in 4096x2048".to_owned())
}

/// The interpolation called `name`; for the command line.
pub(super) fn interpolation(name: &str) -> Result<Interpolation, String> {
    let mut all = Interpolation::ALL.iter().copied();
    all.find(|interpolation| interpolation.name() == name)
        .ok_or_else(|| "it must be one of none, linear, catmull-rom".to_owned())
}

/// How the texels of a bin are to be found; `None` to choose by cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexChoice(pub Option<InverseKind>);

fn inverse(name: &str) -> Result<IndexChoice, String> {
    if name == "auto" {
        return Ok(IndexChoice(None));
    }
    let kinds = InverseKind::ALL;
    match kinds.iter().find(|kind| kind.name() == name) {
        Some(&kind) => Ok(IndexChoice(Some(kind))),
        None => Err("it must be one of auto, forest, tiles, none".to_owned()),
    }
}

/// Bytes, from a number with the unit MB or GB (decimal, as sizes are printed).
fn memory(text: &str) -> Result<u64, String> {
    let parsed = [("GB", 1e9), ("MB", 1e6)]
        .into_iter()
        .find_map(|(unit, bytes)| Some((text.strip_suffix(unit)?.trim_end(), bytes)))
        .and_then(|(number, bytes)| Some(number.parse::<f64>().ok()? * bytes));
    match parsed {
        Some(bytes) if (1e6..=1e15).contains(&bytes) => Ok(bytes as u64),
        _ => Err("give a number with a unit, such as 6GB or 500MB, of at least 1MB".to_owned()),
    }
}

/// Roughnesses nearer than this part of themselves are one to a query: see `Package::find`.
const SAME_ROUGHNESS: f64 = 1e-9;

/// Methods that have bins.
const BINNED: &[Method] = &[Method::FlakeBins, Method::SpecularBins];

/// Methods that have a roughness.
const ROUGH: &[Method] = &[
    Method::FlakeBins,
    Method::Lean,
    Method::ClusterTree,
    Method::Lobes,
    Method::Analytic,
    Method::MipLobes,
    Method::NdfMaps,
];

/// Methods that answer for boxes; the others for Gaussians alone.
const BOXED: &[Method] = &[
    Method::FlakeBins,
    Method::SpecularBins,
    Method::Lean,
    Method::ClusterTree,
    Method::NdfMaps,
];

fn usage(message: String) -> CommandError {
    CommandError::new(Failure::Usage, message)
}

impl BakeArgs {
    /// Whether the input is a material file, by its name.
    pub fn is_material(&self) -> bool {
        let extension = self.image.extension();
        extension.is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
    }

    /// An option that says how a map is read or baked, if one is given: a material file says that itself.
    pub fn first_of_maps(&self) -> Option<&'static str> {
        let given = [
            ("--method", !self.method.is_empty()),
            ("--roughness", !self.roughness.roughness.is_empty()),
            (
                "--intrinsic-roughness",
                !self.roughness.intrinsic_roughness.is_empty(),
            ),
            ("--bins", self.bins.is_some()),
            ("--filter", self.filter.is_some()),
            ("--index", self.index.0.is_some()),
            ("--leaf-size", self.leaf_size.is_some()),
            ("--finest-level", self.finest_level.is_some()),
            ("--kernel", self.kernel.is_some()),
            ("--lobes", self.lobes.is_some()),
            ("--merge-error", self.merge_error.is_some()),
            ("--interpolate", self.interpolate.is_some()),
            ("--clusters", self.clusters.is_some()),
            // What a quilt has besides is refused without it.
            ("--target", self.target.is_some()),
            ("--exact-normals", self.exact_normals),
            ("--raster-normals", self.raster_normals),
            ("--no-masking", self.no_masking),
        ];
        let decoding = self.decode.first_given();
        let baking = given.iter().find(|(_, is_given)| *is_given);
        baking.map(|(option, _)| *option).or(decoding)
    }

    /// The recipe these arguments ask for.
    ///
    /// Roughness goes to the methods that have one, bins to those that count them, boxes to those that answer for them, so
    /// that one command line can bake several; an option that no method of the list takes is left with the first, which
    /// refuses it.
    ///
    /// # Errors
    /// [`Failure::Usage`] if the recipe cannot be baked, or names anything twice: queries find the first only.
    pub fn recipe(&self) -> Result<Recipe, CommandError> {
        let methods = self.methods();
        for (place, method) in methods.iter().enumerate() {
            if methods[..place].contains(method) {
                return Err(usage(format!(
                    "--method {}: the method is named twice",
                    method.name()
                )));
            }
        }
        if let Some(leaf_size) = self.leaf_size
            && self.index.0 != Some(InverseKind::Forest)
        {
            let method = if methods.iter().any(|method| BINNED.contains(method)) {
                ""
            } else {
                "--method flake-bins "
            };
            return Err(usage(format!(
                "--leaf-size {leaf_size}: only a forest has leaves to choose; add {method}--index forest"
            )));
        }
        let recipe = self.unchecked_recipe()?;
        if let Err(error) = glintbake_bake::check(&recipe) {
            return Err(self.in_given_words(error));
        }
        let roughness = self.roughness.all();
        for (place, &alpha) in roughness.iter().enumerate() {
            if let Some(other) = roughness[..place]
                .iter()
                .find(|other| (*other - alpha).abs() <= SAME_ROUGHNESS * alpha)
            {
                return Err(usage(format!(
                    "--roughness {alpha}: too near to {other} to be told apart; leave one of them out"
                )));
            }
        }
        Ok(recipe)
    }

    /// How the image is read: what `recipe` says, within `--memory`.
    pub fn read_options(&self, recipe: &Recipe) -> ReadOptions {
        let mut options = recipe.read_options();
        options.limits.texels = self.memory / recipe.bytes_per_texel();
        options
    }

    /// `error`, about the option that the user wrote rather than the one it was turned into.
    fn in_given_words(&self, error: BakeError) -> CommandError {
        if let BakeError::Option { value, reason, .. } = &error
            && let Some(sigma) = self
                .roughness
                .intrinsic_roughness
                .iter()
                .find(|&&sigma| beckmann_from_intrinsic(sigma).to_string() == *value)
        {
            return usage(format!(
                "--intrinsic-roughness {sigma} (roughness {value}): {reason}"
            ));
        }
        error.into()
    }

    /// The methods that were named, or the one that is baked if none is.
    fn methods(&self) -> &[Method] {
        match &*self.method {
            [] => &[DEFAULT_METHOD],
            named => named,
        }
    }

    /// Whether an option that `takers` take goes to `method`: to each of them, or to the first method if none is baked.
    fn goes_to(&self, method: Method, takers: &[Method]) -> bool {
        let is_taken = self.methods().iter().any(|baked| takers.contains(baked));
        takers.contains(&method) || (!is_taken && self.methods().first() == Some(&method))
    }

    /// The quilt that is asked for.
    fn quilt(&self) -> Option<QuiltRecipe> {
        Some(QuiltRecipe {
            target: self.target?,
            patch: self.patch,
            overlap: self.overlap,
            tolerance: self.quilt_error,
            seed: self.seed,
        })
    }

    fn unchecked_recipe(&self) -> Result<Recipe, CommandError> {
        let roughness = self.roughness.all();
        let ndf_maps = self.ndf_maps.recipe(self.seed)?;
        let methods = self
            .methods()
            .iter()
            .map(|&method| {
                let goes = |takers: &[Method]| self.goes_to(method, takers);
                let binned = goes(BINNED);
                let filter = self
                    .filter
                    .filter(|&filter| filter == Filter::Gaussian || goes(BOXED))
                    .unwrap_or(default_filter(method));
                MethodRecipe {
                    method,
                    roughness: if goes(ROUGH) {
                        roughness.clone()
                    } else {
                        Vec::new()
                    },
                    bins: self.bins.filter(|_| goes(&[Method::SpecularBins])),
                    filter,
                    inverse: self.index.0.filter(|_| binned),
                    leaf_size: self
                        .leaf_size
                        .filter(|_| binned)
                        .unwrap_or(DEFAULT_LEAF_SIZE),
                    finest_level: self.finest_level.filter(|_| goes(&[Method::Lean])),
                    kernel: self.kernel.filter(|_| goes(&[Method::ClusterTree])),
                    lattice: self
                        .lobes
                        .filter(|_| goes(&[Method::Lobes, Method::MipLobes])),
                    merge_error: self.merge_error.filter(|_| goes(&[Method::Lobes])),
                    interpolation: self.interpolate.filter(|_| goes(&[Method::Analytic])),
                    clusters: self.clusters.filter(|_| goes(&[Method::MipLobes])),
                    quilt: self.quilt().filter(|_| goes(&[Method::MipLobes])),
                    ndf_maps: ndf_maps.clone().filter(|_| goes(&[Method::NdfMaps])),
                    exact_normals: self.exact_normals && goes(&[Method::FlakeBins]),
                    raster_normals: self.raster_normals && goes(&[Method::ClusterTree]),
                    masking: !self.no_masking,
                }
            })
            .collect();
        Ok(Recipe {
            methods,
            ..self.decode.recipe()
        })
    }
}
