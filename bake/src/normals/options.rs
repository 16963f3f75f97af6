//! What the samples of a map mean.

use glintbake_format::model::Wrap;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::fmt;

/// One list of words for the command line, the recipe and the metadata, so that they cannot drift apart.
macro_rules! words {
    ($type:ident: $($variant:ident = $word:literal),+) => {
        impl $type {
            /// Every value, in the order of its documentation.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The word used on the command line, in recipes and in metadata.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $word),+ }
            }

            /// The value called `name`, if there is one.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|value| value.name() == name)
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.pad(self.name())
            }
        }

        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let name = String::deserialize(deserializer)?;
                Self::from_name(&name)
                    .ok_or_else(|| D::Error::unknown_variant(&name, &[$($word),+]))
            }
        }
    };
}

/// What the texels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Input {
    /// `normal`: tangent-space normals.
    #[default]
    Normals,
    /// `height`: heights above the surface.
    Height,
}

words!(Input: Normals = "normal", Height = "height");

/// Which channels hold the normal: the first letter names the channel of s, the second that of t.
///
/// A grey image with alpha stands for one whose red, green and blue are that grey. The channels of an EXR file are
/// taken in the order in which they were selected, as if they were red, green, blue and alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Channels {
    /// `xyz`: s, t, z in the first three channels (red, green, blue). Everyone's default.
    #[default]
    Xyz,
    /// `xy`: s and t in the first two channels, whatever they are called; grey and alpha included.
    Xy,
    /// `rg`: s in red, t in green; blue is ignored. BC5 ("3Dc", "ATI2") maps look like this when unpacked.
    Rg,
    /// `ga`: s in green, t in alpha. What the ASTC encoder's `-normal` leaves to sample as `.ga`: red, green and blue
    /// all hold s, to suit the format's luminance-alpha blocks. **Not** the order of `DXT5nm`, see [`Channels::Ag`].
    Ga,
    /// `ra`: s in red, t in alpha. The same ASTC maps as `ra` (`-dsw raz1`), and Godot's `RA_AS_RG` formats.
    Ra,
    /// `ag`: s in **alpha**, t in **green**. `DXT5nm`, also called `BC3n`: red is 1, blue 0, and s is moved to alpha,
    /// where BC3 keeps most precision (Unity's packed normal maps, `DirectXTex`, NVIDIA's texture tools).
    Ag,
}

words!(Channels: Xyz = "xyz", Xy = "xy", Rg = "rg", Ga = "ga", Ra = "ra", Ag = "ag");

/// Where the second component points in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum GreenAxis {
    /// `gl`: up (OpenGL, glTF, Blender, Unity).
    #[default]
    Gl,
    /// `dx`: down (DirectX, Unreal, 3ds Max); t is turned around.
    Dx,
}

words!(GreenAxis: Gl = "gl", Dx = "dx");

/// How samples span the interval from -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Range {
    /// `auto`: integers as `unorm`, floats as `snorm`.
    #[default]
    Auto,
    /// `unorm`: from 0 to 1 (integers: to their maximum), to be stretched.
    Unorm,
    /// `snorm`: from -1 to 1 already; floats only.
    Snorm,
}

words!(Range: Auto = "auto", Unorm = "unorm", Snorm = "snorm");

/// Which integer means zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Zero {
    /// `127.5`: none, zero lies halfway between the two middle values; the whole range is used, as GPUs decode it.
    #[default]
    Half,
    /// `128` (32768 at 16 bit): the value above the middle; 0 and 1 both mean -1.
    Centred,
}

words!(Zero: Half = "127.5", Centred = "128");

/// How the samples of a raster become normals.
///
/// Serialises with kebab-case keys and the words of the command line. An option without meaning for the input at
/// hand is refused rather than ignored, so that a package's recipe says nothing that was not done; `height_scale`
/// alone, which has no word for "not given", is ignored for normals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DecodeOptions {
    /// What the texels are.
    pub input: Input,
    /// Height of white (sample 1) above black, in texels; finite, at most 10⁹ either way. Negative turns hills into
    /// dents. Unit: one texel of the map, so a map scaled to twice its size needs twice the value.
    pub height_scale: f64,
    /// Where the normal is.
    pub channels: Channels,
    /// Where its second component points.
    pub green: GreenAxis,
    /// How samples span -1 to 1.
    pub range: Range,
    /// Which integer means zero.
    pub zero: Zero,
    /// How the map continues beyond its border: stored with the map, and used by heights and repair.
    #[serde(with = "wrap_by_name")]
    pub wrap: Wrap,
    /// Whether texels that cannot be a normal take the nearest valid one instead of being refused.
    pub repair: bool,
}

impl Default for DecodeOptions {
    /// A tangent-space normal map as glTF has it: `xyz`, green up, `auto`, 127.5, repeating, nothing repaired.
    fn default() -> Self {
        Self {
            input: Input::default(),
            height_scale: 1.0,
            channels: Channels::default(),
            green: GreenAxis::default(),
            range: Range::default(),
            zero: Zero::default(),
            wrap: Wrap::default(),
            repair: false,
        }
    }
}

/// [`Wrap`] lives in a crate without serde.
mod wrap_by_name {
    use super::{Deserialize, Deserializer, Error, Serializer, Wrap};

    pub(super) fn serialize<S: Serializer>(wrap: &Wrap, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(wrap.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Wrap, D::Error> {
        let name = String::deserialize(deserializer)?;
        [Wrap::Repeat, Wrap::Clamp]
            .into_iter()
            .find(|wrap| wrap.name() == name)
            .ok_or_else(|| D::Error::unknown_variant(&name, &["repeat", "clamp"]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_survive_json_and_use_the_words_of_the_command_line() {
        let options = DecodeOptions {
            input: Input::Height,
            height_scale: -2.5,
            channels: Channels::Ga,
            green: GreenAxis::Dx,
            range: Range::Snorm,
            zero: Zero::Centred,
            wrap: Wrap::Clamp,
            repair: true,
        };
        let json = serde_json::to_string(&options).unwrap();
        assert_eq!(
            json,
            r#"{"input":"height","height-scale":-2.5,"channels":"ga","green":"dx","range":"snorm","zero":"128","wrap":"clamp","repair":true}"#
        );
        assert_eq!(
            serde_json::from_str::<DecodeOptions>(&json).unwrap(),
            options
        );
        for (good, bad) in [("clamp", "mirror"), ("\"ga\"", "\"gg\""), ("repair", "rep")] {
            let wrong = json.replace(good, bad);
            assert!(
                serde_json::from_str::<DecodeOptions>(&wrong).is_err(),
                "{wrong}"
            );
        }
    }

    #[test]
    fn options_survive_a_format_that_does_not_describe_itself() {
        let options = DecodeOptions {
            wrap: Wrap::Clamp,
            ..DecodeOptions::default()
        };
        let configuration = bincode::config::standard();
        let bytes = bincode::serde::encode_to_vec(&options, configuration).unwrap();
        let (read, length): (DecodeOptions, _) =
            bincode::serde::decode_from_slice(&bytes, configuration).unwrap();
        assert_eq!((read, length), (options, bytes.len()));
    }

    #[test]
    fn every_word_is_read_back() {
        for &value in Channels::ALL {
            assert_eq!(Channels::from_name(value.name()), Some(value));
        }
        assert_eq!(Channels::ALL.len(), 6);
        assert_eq!(Zero::from_name("127.5"), Some(Zero::Half));
        assert_eq!(Zero::from_name("127"), None);
        assert_eq!(format!("{:>4}", GreenAxis::Dx), "  dx");
    }
}
