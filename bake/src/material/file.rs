//! From the text of a material file to a recipe.

use super::error::MaterialError;
use super::keys::{LayerKeys, MaterialKeys, Splat, Word};
use super::recipe::{LayerRecipe, MapRecipe, MaterialRecipe};
use crate::error::BakeError;
use crate::normals::DecodeOptions;
use crate::recipe::{DEFAULT_METHOD, MethodRecipe, QuiltRecipe, Recipe};
use glintbake_format::model::{Method, beckmann_from_intrinsic};
use glintbake_format::records::{LayerKind, LayerNormals, MAX_LAYERS, MaterialLayer};
use std::fs;
use std::path::Path;

/// Index of refraction of a coat that names none: lacquer.
const LACQUER: f64 = 1.5;
/// Roughness of a coat that names none: a hundredth of the width of the sun's image away from a mirror.
const POLISHED: f64 = 0.001;
/// Roughness of a base that names none.
const SATIN: f64 = 0.3;
/// Reflectance of a base that names none: plastic.
const PLASTIC: [f64; 3] = [0.04; 3];
/// Reflectance of glints that name none: aluminium.
const ALUMINIUM: [f64; 3] = [0.912, 0.914, 0.920];

/// The material in the file at `path`; images it names are looked for beside it, and not opened yet.
///
/// # Errors
/// Every [`MaterialError`] but [`MaterialError::Opacity`].
pub fn read(path: &Path) -> Result<MaterialRecipe, MaterialError> {
    let file = path.display().to_string();
    let text = fs::read_to_string(path).map_err(|source| MaterialError::Open {
        file: file.clone(),
        source,
    })?;
    parse(&file, path.parent().unwrap_or(Path::new("")), &text)
}

/// The material in `text`, the content of `file`, which lies in `folder`.
pub(super) fn parse(
    file: &str,
    folder: &Path,
    text: &str,
) -> Result<MaterialRecipe, MaterialError> {
    let keys: MaterialKeys = toml::from_str(text).map_err(|error| syntax(file, text, &error))?;
    let count = keys.layer.len();
    if !(1..=MAX_LAYERS).contains(&count) {
        return Err(MaterialError::Count {
            file: file.to_owned(),
            count,
            most: MAX_LAYERS,
        });
    }
    let layers = (0..)
        .zip(keys.layer)
        .map(|(number, keys)| {
            let place = Place {
                file,
                text,
                start: keys.span().start,
                number,
            };
            place.layer(&keys.into_inner(), folder)
        })
        .collect::<Result<_, _>>()?;
    Ok(MaterialRecipe { layers })
}

/// What `error` says of `text`, in one line; with the key, which the message does not name where a value is wrong.
fn syntax(file: &str, text: &str, error: &toml::de::Error) -> MaterialError {
    let at = error.span().map_or(0, |span| span.start);
    let line = line_of(text, at);
    let key = text.lines().nth(line - 1).and_then(|line| {
        let (key, _) = line.split_once('=')?;
        Some(key.trim())
    });
    let message = error.message().replace('\n', "; ");
    MaterialError::Syntax {
        file: file.to_owned(),
        line,
        message: match key {
            Some(key) if !message.contains(key) => format!("{key}: {message}"),
            _ => message,
        },
    }
}

/// The line, from 1, of byte `at` of `text`.
fn line_of(text: &str, at: usize) -> usize {
    let before = text.as_bytes().iter().take(at);
    1 + before.filter(|&&byte| byte == b'\n').count()
}

/// Where a layer stands in its file.
struct Place<'t> {
    file: &'t str,
    text: &'t str,
    /// Its first byte.
    start: usize,
    /// Its number, from 0.
    number: usize,
}

impl Place<'_> {
    /// What is wrong with `key` of this layer, with the line it stands in, or else that of the layer.
    fn wrong(&self, key: &str, reason: impl Into<String>) -> MaterialError {
        let first = line_of(self.text, self.start);
        let mut lines = (first..).zip(self.text.lines().skip(first - 1));
        let is_this = |line: &str| {
            let rest = line.trim_start().strip_prefix(key);
            rest.is_some_and(|rest| rest.trim_start().starts_with('='))
        };
        // The layer ends where the next begins; its own first line may be its header.
        let line = lines
            .by_ref()
            .take_while(|(line, text)| *line == first || !text.trim_start().starts_with('['))
            .find_map(|(line, text)| is_this(text).then_some(line));
        MaterialError::Key {
            file: self.file.to_owned(),
            line: line.unwrap_or(first),
            layer: self.number,
            key: key.to_owned(),
            reason: reason.into(),
        }
    }

    /// Refuses each of `keys`, by name and whether it is given, that is not `whose`.
    fn none_of(&self, keys: &[(&str, bool)], whose: &str) -> Result<(), MaterialError> {
        match keys.iter().find(|(_, is_given)| *is_given) {
            Some((key, _)) => Err(self.wrong(key, format!("{whose}; leave the key out"))),
            None => Ok(()),
        }
    }

    fn layer(&self, keys: &LayerKeys, folder: &Path) -> Result<LayerRecipe, MaterialError> {
        let Word(kind) = keys.kind;
        self.check_keys(kind, keys)?;
        let roughness = self.roughness(keys)?;
        let map = match &keys.map {
            Some(path) => Some(MapRecipe {
                path: folder.join(path),
                recipe: self.recipe(keys, roughness)?,
            }),
            None => None,
        };
        let lobe = match (&map, kind) {
            (Some(_), _) => 0.0,
            (None, LayerKind::Coat) => roughness.unwrap_or(POLISHED),
            (None, LayerKind::Glints | LayerKind::Base) => roughness.unwrap_or(SATIN),
        };
        let or = |given: Option<Splat<3>>, default| given.map_or(default, |Splat(rgb)| rgb);
        let (f0, colour, ior) = match kind {
            LayerKind::Coat => (
                [0.0; 3],
                or(keys.colour, [1.0; 3]),
                keys.ior.unwrap_or(LACQUER),
            ),
            LayerKind::Glints => (or(keys.f0, ALUMINIUM), [0.0; 3], 0.0),
            LayerKind::Base => (or(keys.f0, PLASTIC), or(keys.diffuse, [0.0; 3]), 0.0),
        };
        let layer = LayerRecipe {
            kind,
            map,
            lobe,
            scale: keys.scale.map_or([1.0; 2], |Splat(scale)| scale),
            f0,
            colour,
            ior,
            opacity: keys.opacity.unwrap_or(1.0),
            opacity_map: keys.opacity_map.as_ref().map(|path| folder.join(path)),
            opacity_wrap: keys.wrap.map_or(Default::default(), |Word(wrap)| wrap),
        };
        self.check_ranges(&layer)?;
        Ok(layer)
    }

    /// Refuses keys that mean nothing for the kind.
    fn check_keys(&self, kind: LayerKind, keys: &LayerKeys) -> Result<(), MaterialError> {
        let (f0, ior) = (("f0", keys.f0.is_some()), ("ior", keys.ior.is_some()));
        let colour = ("colour", keys.colour.is_some());
        let diffuse = ("diffuse", keys.diffuse.is_some());
        let map = ("map", keys.map.is_some());
        match kind {
            LayerKind::Coat => {
                self.none_of(&[f0], "a coat reflects by its index of refraction, ior")?;
                self.none_of(&[diffuse], "a coat lets pass what colour says")?;
            }
            LayerKind::Glints => {
                self.none_of(&[ior], "glints reflect by f0")?;
                self.none_of(
                    &[colour, diffuse],
                    "nothing passes glints; they reflect by f0",
                )?;
                if keys.map.is_none() {
                    let reason = "glints come from a map; name its image, or make the layer a base";
                    return Err(self.wrong("map", reason));
                }
            }
            LayerKind::Base => {
                self.none_of(&[map], "a base has no map; put a layer of glints over it")?;
                self.none_of(&[ior], "a base reflects by f0")?;
                self.none_of(
                    &[colour],
                    "what lies under the gloss of a base is called diffuse",
                )?;
            }
        }
        if keys.map.is_none() {
            self.none_of(&keys.of_maps(), "only a layer with a map has it")?;
            let wrap = ("wrap", keys.wrap.is_some() && keys.opacity_map.is_none());
            self.none_of(&[wrap], "only a layer with a map or an opacity map has it")?;
        }
        Ok(())
    }

    /// The layer's Beckmann roughness, however it is given.
    fn roughness(&self, keys: &LayerKeys) -> Result<Option<f64>, MaterialError> {
        match (keys.roughness, keys.intrinsic_roughness) {
            (Some(_), Some(_)) => {
                let reason = "the layer has a roughness already; leave one of them out";
                Err(self.wrong("intrinsic-roughness", reason))
            }
            (given, None) => Ok(given),
            (None, intrinsic) => Ok(intrinsic.map(beckmann_from_intrinsic)),
        }
    }

    /// How the layer's map is baked.
    fn recipe(&self, keys: &LayerKeys, roughness: Option<f64>) -> Result<Recipe, MaterialError> {
        let method = keys.method.map_or(DEFAULT_METHOD, |Word(method)| method);
        let defaults = MethodRecipe::new(method, roughness.as_slice());
        let of_quilts = [
            ("patch", keys.patch.is_some()),
            ("overlap", keys.overlap.is_some()),
            ("quilt-error", keys.quilt_error.is_some()),
            ("seed", keys.seed.is_some()),
        ];
        let quilt = match keys.target {
            Some(Splat(target)) => Some(self.quilt(keys, target)?),
            None => {
                self.none_of(&of_quilts, "only a quilt has it, which target asks for")?;
                None
            }
        };
        let recipe = Recipe {
            exr_layer: keys.exr_layer.clone(),
            exr_channels: keys.exr_channels.clone(),
            decode: keys.decode_options(),
            methods: vec![MethodRecipe {
                bins: keys.bins,
                filter: keys.filter.map_or(defaults.filter, |Word(filter)| filter),
                inverse: keys.index.map(|Word(kind)| kind),
                leaf_size: keys.leaf_size.unwrap_or(defaults.leaf_size),
                finest_level: keys.finest_level,
                kernel: keys.kernel.map(|Word(kernel)| kernel),
                lattice: keys.lobes.map(|Word(lattice)| lattice),
                merge_error: keys.merge_error,
                interpolation: keys.interpolate.map(|Word(interpolation)| interpolation),
                clusters: keys.clusters,
                quilt,
                exact_normals: keys.exact_normals.unwrap_or(false),
                raster_normals: keys.raster_normals.unwrap_or(false),
                masking: keys.masking.unwrap_or(true),
                ..defaults
            }],
        };
        crate::check(&recipe).map_err(|error| self.in_words_of_the_file(error, keys, method))?;
        Ok(recipe)
    }

    fn quilt(&self, keys: &LayerKeys, target: [f64; 2]) -> Result<QuiltRecipe, MaterialError> {
        let is_size = |side: &f64| (1.0..=65_535.0).contains(side) && side.fract() == 0.0;
        if !target.iter().all(is_size) {
            let reason = "a side is a whole number of texels from 1 to 65535";
            return Err(self.wrong("target", reason));
        }
        let defaults = QuiltRecipe::new(target.map(|side| side as u32));
        Ok(QuiltRecipe {
            patch: keys.patch,
            overlap: keys.overlap.unwrap_or(defaults.overlap),
            tolerance: keys.quilt_error.unwrap_or(defaults.tolerance),
            seed: keys.seed.unwrap_or(defaults.seed),
            ..defaults
        })
    }

    /// `error`, about an option of the command line, as one about the key of that name.
    fn in_words_of_the_file(
        &self,
        error: BakeError,
        keys: &LayerKeys,
        method: Method,
    ) -> MaterialError {
        let BakeError::Option {
            option,
            value,
            reason,
        } = error
        else {
            return self.wrong("map", error.to_string());
        };
        let key = match option.trim_start_matches('-') {
            "roughness" if keys.intrinsic_roughness.is_some() => "intrinsic-roughness",
            key => key,
        };
        let reason = reason
            .replace(
                "leave the option out, or add --method ",
                "leave the key out, or set method to ",
            )
            .replace("leave the option out", "leave the key out")
            .replace("--", "");
        let value = if value.is_empty() {
            String::new()
        } else {
            format!("{value}: ")
        };
        self.wrong(key, format!("{value}{reason} (method {})", method.name()))
    }

    /// Refuses numbers that no record may hold.
    fn check_ranges(&self, layer: &LayerRecipe) -> Result<(), MaterialError> {
        let stored = layer.to_record_with(LayerNormals::Lobe(layer.lobe as f32));
        let colour = match layer.kind {
            LayerKind::Base => "diffuse",
            LayerKind::Coat | LayerKind::Glints => "colour",
        };
        let lobe: &[f32] = if layer.map.is_none() {
            &[layer.lobe as f32]
        } else {
            &[]
        };
        let ior: &[f32] = match layer.kind {
            LayerKind::Coat => &[stored.ior],
            LayerKind::Glints | LayerKind::Base => &[],
        };
        let share = MaterialLayer::SHARE;
        let numbers: [(&str, &[f32], _, &str); 6] = [
            (
                "roughness",
                lobe,
                MaterialLayer::ROUGHNESS,
                "; the least is as good as a mirror",
            ),
            (
                "scale",
                &stored.scale,
                MaterialLayer::SCALE,
                ", times that a map repeats",
            ),
            ("f0", &stored.f0, share.clone(), ""),
            (colour, &stored.colour, share.clone(), ""),
            ("ior", ior, MaterialLayer::IOR, "; lacquer has 1.5"),
            (
                "opacity",
                &[stored.opacity],
                share,
                ", the part of the surface that is covered",
            ),
        ];
        for (key, numbers, range, hint) in numbers {
            // What is not a number is in no range.
            if let Some(number) = numbers.iter().find(|number| !range.contains(number)) {
                let (least, most) = (range.start(), range.end());
                let reason = format!("{number}: it must lie between {least} and {most}{hint}");
                return Err(self.wrong(key, reason));
            }
        }
        Ok(())
    }
}

impl LayerRecipe {
    /// The layer as packages have it, but for its opacity map.
    pub(super) fn to_record_with(&self, normals: LayerNormals) -> MaterialLayer {
        // Zero without a sign, which records take for something else.
        let narrow = |number: f64| number as f32 + 0.0;
        MaterialLayer {
            kind: self.kind,
            normals,
            scale: self.scale.map(narrow),
            f0: self.f0.map(narrow),
            colour: self.colour.map(narrow),
            opacity: narrow(self.opacity),
            ior: narrow(self.ior),
            opacity_map: None,
        }
    }
}

impl LayerKeys {
    /// The keys that only a layer with a map has, and whether they are given.
    fn of_maps(&self) -> [(&'static str, bool); 28] {
        [
            ("method", self.method.is_some()),
            ("input", self.input.is_some()),
            ("height-scale", self.height_scale.is_some()),
            ("channels", self.channels.is_some()),
            ("y", self.y.is_some()),
            ("range", self.range.is_some()),
            ("zero", self.zero.is_some()),
            ("repair", self.repair.is_some()),
            ("exr-layer", self.exr_layer.is_some()),
            ("exr-channels", self.exr_channels.is_some()),
            ("bins", self.bins.is_some()),
            ("filter", self.filter.is_some()),
            ("index", self.index.is_some()),
            ("leaf-size", self.leaf_size.is_some()),
            ("finest-level", self.finest_level.is_some()),
            ("kernel", self.kernel.is_some()),
            ("lobes", self.lobes.is_some()),
            ("merge-error", self.merge_error.is_some()),
            ("interpolate", self.interpolate.is_some()),
            ("clusters", self.clusters.is_some()),
            ("target", self.target.is_some()),
            ("patch", self.patch.is_some()),
            ("overlap", self.overlap.is_some()),
            ("quilt-error", self.quilt_error.is_some()),
            ("seed", self.seed.is_some()),
            ("exact-normals", self.exact_normals.is_some()),
            ("raster-normals", self.raster_normals.is_some()),
            ("masking", self.masking.is_some()),
        ]
    }

    fn decode_options(&self) -> DecodeOptions {
        let defaults = DecodeOptions::default();
        DecodeOptions {
            input: self.input.unwrap_or(defaults.input),
            height_scale: self.height_scale.unwrap_or(defaults.height_scale),
            channels: self.channels.unwrap_or(defaults.channels),
            green: self.y.unwrap_or(defaults.green),
            range: self.range.unwrap_or(defaults.range),
            zero: self.zero.unwrap_or(defaults.zero),
            wrap: self.wrap.map_or(defaults.wrap, |Word(wrap)| wrap),
            repair: self.repair.unwrap_or(defaults.repair),
        }
    }
}
