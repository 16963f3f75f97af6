//! How images are read, whichever command reads them.

use clap::Args;
use glintbake_bake::Recipe;
use glintbake_bake::normals::{Channels, DecodeOptions, GreenAxis, Input, Range, Zero};
use glintbake_format::model::Wrap;

/// How an image becomes normals.
#[derive(Debug, Args)]
pub struct DecodeArgs {
    /// What the image holds: normal or height
    #[arg(long, default_value_t, value_parser = word(Input::from_name, Input::ALL))]
    pub input: Input,

    /// Height of white above black in texels, for --input height
    #[arg(
        long,
        default_value_t = 1.0,
        value_name = "TEXELS",
        allow_negative_numbers = true
    )]
    pub height_scale: f64,

    /// Where the normal's components are: xyz, xy, rg, ga, ra, or ag (s in alpha, t in green)
    #[arg(long, default_value_t, value_parser = word(Channels::from_name, Channels::ALL))]
    pub channels: Channels,

    /// Green up (gl: OpenGL, glTF) or down (dx: DirectX)
    #[arg(long = "y", default_value_t, value_parser = word(GreenAxis::from_name, GreenAxis::ALL))]
    pub green: GreenAxis,

    /// Samples from 0 to 1 (unorm) or -1 to 1 (snorm); auto: integers unorm, floats snorm
    #[arg(long, default_value_t, value_parser = word(Range::from_name, Range::ALL))]
    pub range: Range,

    /// Integer that means zero: 127.5 or 128 (32767.5 or 32768 at 16 bit)
    #[arg(long, default_value_t, value_parser = word(Zero::from_name, Zero::ALL))]
    pub zero: Zero,

    /// How the map continues beyond its border: repeat or clamp
    #[arg(long, default_value = "repeat", value_parser = wrap)]
    pub wrap: Wrap,

    /// Give texels that cannot be a normal the nearest valid one instead of refusing the map
    #[arg(long)]
    pub repair: bool,

    /// Layer of an EXR file
    #[arg(long, value_name = "NAME")]
    pub exr_layer: Option<String>,

    /// Channels of an EXR file, in order, with commas between
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub exr_channels: Option<Vec<String>>,
}

impl DecodeArgs {
    /// An option that is not as it is by default, if there is one.
    pub fn first_given(&self) -> Option<&'static str> {
        let (given, defaults) = (self.recipe().decode, DecodeOptions::default());
        let options = [
            ("--input", given.input != defaults.input),
            (
                "--height-scale",
                given.height_scale != defaults.height_scale,
            ),
            ("--channels", given.channels != defaults.channels),
            ("--y", given.green != defaults.green),
            ("--range", given.range != defaults.range),
            ("--zero", given.zero != defaults.zero),
            ("--wrap", given.wrap != defaults.wrap),
            ("--repair", given.repair != defaults.repair),
            ("--exr-layer", self.exr_layer.is_some()),
            ("--exr-channels", self.exr_channels.is_some()),
        ];
        let first = options.iter().find(|(_, is_given)| *is_given);
        first.map(|(option, _)| *option)
    }

    /// A recipe without methods that reads images as these arguments say.
    pub fn recipe(&self) -> Recipe {
        Recipe {
            exr_layer: self.exr_layer.clone(),
            exr_channels: self.exr_channels.clone(),
            decode: DecodeOptions {
                input: self.input,
                height_scale: self.height_scale,
                channels: self.channels,
                green: self.green,
                range: self.range,
                zero: self.zero,
                wrap: self.wrap,
                repair: self.repair,
            },
            methods: Vec::new(),
        }
    }
}

/// A parser for the words of `all`.
fn word<T: Copy + std::fmt::Display + Send + Sync + 'static>(
    from_name: fn(&str) -> Option<T>,
    all: &'static [T],
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |name| {
        from_name(name).ok_or_else(|| {
            let words: Vec<_> = all.iter().map(T::to_string).collect();
            format!("it must be one of {}", words.join(", "))
        })
    }
}

fn wrap(name: &str) -> Result<Wrap, String> {
    [Wrap::Repeat, Wrap::Clamp]
        .into_iter()
        .find(|wrap| wrap.name() == name)
        .ok_or_else(|| "it must be one of repeat, clamp".to_owned())
}
