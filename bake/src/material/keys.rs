//! The keys of a layer, as TOML has them.

use crate::normals::{Channels, GreenAxis, Input, Range, Zero};
use glintbake_format::model::{Filter, Interpolation, Kernel, LobeLattice, METHODS, Method, Wrap};
use glintbake_format::records::{InverseKind, LayerKind};
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::path::PathBuf;
use toml::Spanned;

/// A material file.
#[derive(Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct MaterialKeys {
    #[serde(default)]
    pub(super) layer: Vec<Spanned<LayerKeys>>,
}

/// A layer; docs/materials.md says what each key means.
#[derive(Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct LayerKeys {
    pub(super) kind: Word<LayerKind>,
    pub(super) scale: Option<Splat<2>>,
    pub(super) f0: Option<Splat<3>>,
    pub(super) ior: Option<f64>,
    pub(super) colour: Option<Splat<3>>,
    pub(super) diffuse: Option<Splat<3>>,
    pub(super) opacity: Option<f64>,
    pub(super) opacity_map: Option<PathBuf>,
    pub(super) roughness: Option<f64>,
    pub(super) intrinsic_roughness: Option<f64>,
    pub(super) map: Option<PathBuf>,
    // How the map is read.
    pub(super) input: Option<Input>,
    pub(super) height_scale: Option<f64>,
    pub(super) channels: Option<Channels>,
    pub(super) y: Option<GreenAxis>,
    pub(super) range: Option<Range>,
    pub(super) zero: Option<Zero>,
    pub(super) wrap: Option<Word<Wrap>>,
    pub(super) repair: Option<bool>,
    pub(super) exr_layer: Option<String>,
    pub(super) exr_channels: Option<Vec<String>>,
    // What it is baked for.
    pub(super) method: Option<Word<Method>>,
    pub(super) bins: Option<u32>,
    pub(super) filter: Option<Word<Filter>>,
    pub(super) index: Option<Word<InverseKind>>,
    pub(super) leaf_size: Option<u32>,
    pub(super) finest_level: Option<u32>,
    pub(super) kernel: Option<Word<Kernel>>,
    pub(super) lobes: Option<Word<LobeLattice>>,
    pub(super) merge_error: Option<f64>,
    pub(super) interpolate: Option<Word<Interpolation>>,
    pub(super) clusters: Option<u32>,
    pub(super) target: Option<Splat<2>>,
    pub(super) patch: Option<u32>,
    pub(super) overlap: Option<u32>,
    pub(super) quilt_error: Option<f64>,
    pub(super) seed: Option<u64>,
    pub(super) exact_normals: Option<bool>,
    pub(super) raster_normals: Option<bool>,
    pub(super) masking: Option<bool>,
}

/// One of a list of words, those of the command line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word<T>(pub(super) T);

/// A type whose values have words.
pub(super) trait Words: Copy + 'static {
    /// Every value.
    fn all() -> Vec<Self>;
    /// Its word.
    fn word(self) -> &'static str;
}

/// Words of a type whose values are listed and named already.
macro_rules! words {
    ($($type:ty: $all:expr;)+) => {
        $(impl Words for $type {
            fn all() -> Vec<Self> {
                $all.to_vec()
            }

            fn word(self) -> &'static str {
                self.name()
            }
        })+
    };
}

words! {
    LayerKind: Self::ALL;
    Wrap: [Self::Repeat, Self::Clamp];
    Method: METHODS;
    Filter: [Self::Box, Self::Gaussian];
    InverseKind: Self::ALL;
    Kernel: [Self::Beckmann, Self::Disk];
    LobeLattice: Self::ALL;
    Interpolation: Self::ALL;
}

impl<'de, T: Words> Deserialize<'de> for Word<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = String::deserialize(deserializer)?;
        let all = T::all();
        let found = all.iter().copied().find(|value| value.word() == given);
        found.map(Self).ok_or_else(|| {
            let words: Vec<_> = all.iter().map(|value| value.word()).collect();
            D::Error::custom(format_args!("{given:?} is none of {}", words.join(", ")))
        })
    }
}

/// N numbers, or one for all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Splat<const N: usize>(pub(super) [f64; N]);

impl<'de, const N: usize> Deserialize<'de> for Splat<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Numbers<const N: usize>;

        impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
            type Value = Splat<N>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(formatter, "a number, or {N} in brackets")
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Self::Value, E> {
                Ok(Splat([number; N]))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Self::Value, E> {
                self.visit_f64(number as f64)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut numbers = [0.0; N];
                for (place, number) in numbers.iter_mut().enumerate() {
                    *number = list
                        .next_element()?
                        .ok_or_else(|| A::Error::invalid_length(place, &self))?;
                }
                match list.next_element::<f64>()? {
                    None => Ok(Splat(numbers)),
                    Some(_) => Err(A::Error::invalid_length(N + 1, &self)),
                }
            }
        }

        deserializer.deserialize_any(Numbers)
    }
}
