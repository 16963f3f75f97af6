//! Samples as they lie in the file.

/// The file format a raster came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// Truevision TGA.
    Tga,
    /// Tagged Image File Format.
    Tiff,
    /// JPEG.
    Jpeg,
    /// WebP.
    WebP,
    /// The high dynamic range format of ILM and the ASWF.
    OpenExr,
}

impl Format {
    /// The format's usual name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Tga => "TGA",
            Self::Tiff => "TIFF",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::OpenExr => "OpenEXR",
        }
    }
}

/// What the interleaved channels of a raster are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Layout {
    /// One grey channel.
    Gray,
    /// Grey, alpha.
    GrayAlpha,
    /// Red, green, blue.
    Rgb,
    /// Red, green, blue, alpha.
    Rgba,
    /// Channels of an EXR file in the order they were asked for, by their full names; 1 to 4.
    Named(Vec<String>),
}

impl Layout {
    /// Samples per texel, 1 to 4.
    pub fn channels(&self) -> usize {
        match self {
            Self::Gray => 1,
            Self::GrayAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
            Self::Named(names) => names.len(),
        }
    }

    /// The channels in words, for messages: "red, green, blue" or "N.X, N.Y".
    pub fn description(&self) -> String {
        match self {
            Self::Gray => "one grey channel".to_owned(),
            Self::GrayAlpha => "grey, alpha".to_owned(),
            Self::Rgb => "red, green, blue".to_owned(),
            Self::Rgba => "red, green, blue, alpha".to_owned(),
            Self::Named(names) => names.join(", "),
        }
    }
}

/// Interleaved samples, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 8-bit unsigned integers.
    U8(Vec<u8>),
    /// 16-bit unsigned integers.
    U16(Vec<u16>),
    /// Floats; half floats of the file are widened without loss.
    F32(Vec<f32>),
}

impl Samples {
    /// The number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => samples.len(),
            Self::F32(samples) => samples.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of a full sample: 255 or 65535, or `None` for floats.
    pub const fn maximum(&self) -> Option<u16> {
        match self {
            Self::U8(_) => Some(u8::MAX as u16),
            Self::U16(_) => Some(u16::MAX),
            Self::F32(_) => None,
        }
    }

    /// The sample type in words.
    pub const fn description(&self) -> &'static str {
        match self {
            Self::U8(_) => "8-bit",
            Self::U16(_) => "16-bit",
            Self::F32(_) => "floating-point",
        }
    }
}

/// A decoded image: `width * height` texels of `layout().channels()` interleaved samples, first row on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    pub(crate) name: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) format: Format,
    pub(crate) layout: Layout,
    pub(crate) samples: Samples,
}

impl Raster {
    /// A raster from its parts; `name` is what messages call it.
    ///
    /// # Panics
    /// If a side is zero, there are not 1 to 4 channels, or the number of samples is not width × height × channels.
    pub fn new(
        name: impl Into<String>,
        width: u32,
        height: u32,
        format: Format,
        layout: Layout,
        samples: Samples,
    ) -> Self {
        assert!(
            width > 0 && height > 0,
            "a raster has at least one texel, got {width} x {height}"
        );
        assert!(
            (1..=4).contains(&layout.channels()),
            "a raster has 1 to 4 channels, got {}",
            layout.channels()
        );
        assert_eq!(
            samples.len() as u64,
            u64::from(width) * u64::from(height) * layout.channels() as u64,
            "a {width} x {height} raster of {} channels needs as many samples",
            layout.channels()
        );
        Self {
            name: name.into(),
            width,
            height,
            format,
            layout,
            samples,
        }
    }

    /// File name without its folder.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Columns, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The format it came from.
    pub fn format(&self) -> Format {
        self.format
    }

    /// What its channels are.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// All samples, interleaved.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Size, sample type and channels in words: "512 x 512, 8-bit PNG (red, green, blue)".
    pub fn description(&self) -> String {
        format!(
            "{} x {}, {} {} ({})",
            self.width,
            self.height,
            self.samples.description(),
            self.format.name(),
            self.layout.description()
        )
    }
}
