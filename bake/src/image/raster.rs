//! Samples as they lie in the file.

use std::collections::TryReserveError;
use zerocopy::IntoBytes;

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

/// The type of every sample of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleType {
    /// 8-bit unsigned integers.
    U8,
    /// 16-bit unsigned integers.
    U16,
    /// 32-bit floats.
    F32,
}

impl SampleType {
    /// The value of a full sample: 255 or 65535, or `None` for floats.
    pub const fn maximum(self) -> Option<u16> {
        match self {
            Self::U8 => Some(u8::MAX as u16),
            Self::U16 => Some(u16::MAX),
            Self::F32 => None,
        }
    }

    /// The type in words: "8-bit", "16-bit" or "floating-point".
    pub const fn description(self) -> &'static str {
        match self {
            Self::U8 => "8-bit",
            Self::U16 => "16-bit",
            Self::F32 => "floating-point",
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

/// The same expression for the vector of each sample type.
macro_rules! each_type {
    ($samples:expr, $vector:ident => $value:expr) => {
        match $samples {
            $crate::image::Samples::U8($vector) => $value,
            $crate::image::Samples::U16($vector) => $value,
            $crate::image::Samples::F32($vector) => $value,
        }
    };
}
pub(crate) use each_type;

impl Samples {
    /// No samples of type `kind`.
    pub const fn none(kind: SampleType) -> Self {
        match kind {
            SampleType::U8 => Self::U8(Vec::new()),
            SampleType::U16 => Self::U16(Vec::new()),
            SampleType::F32 => Self::F32(Vec::new()),
        }
    }

    /// `count` samples of type `kind`, all zero; pages of a large vector cost nothing until they are written.
    pub(crate) fn zeros(kind: SampleType, count: usize) -> Self {
        match kind {
            SampleType::U8 => Self::U8(vec![0; count]),
            SampleType::U16 => Self::U16(vec![0; count]),
            SampleType::F32 => Self::F32(vec![0.0; count]),
        }
    }

    /// The number of samples.
    pub fn len(&self) -> usize {
        each_type!(self, samples => samples.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The type of each of them.
    pub const fn kind(&self) -> SampleType {
        match self {
            Self::U8(_) => SampleType::U8,
            Self::U16(_) => SampleType::U16,
            Self::F32(_) => SampleType::F32,
        }
    }

    /// The samples as the bytes they are in memory.
    pub(super) fn as_mut_bytes(&mut self) -> &mut [u8] {
        each_type!(self, samples => samples.as_mut_slice().as_mut_bytes())
    }

    /// Appends `more`, of the same type, to what will be `total` samples in the end.
    ///
    /// The first are taken over, not copied.
    pub(crate) fn append(&mut self, more: Self, total: usize) -> Result<(), TryReserveError> {
        fn join<T>(
            samples: &mut Vec<T>,
            mut more: Vec<T>,
            total: usize,
        ) -> Result<(), TryReserveError> {
            if samples.capacity() == 0 {
                *samples = more;
                return Ok(());
            }
            reserve(samples, more.len(), total)?;
            samples.append(&mut more);
            Ok(())
        }
        match (self, more) {
            (Self::U8(samples), Self::U8(more)) => join(samples, more, total),
            (Self::U16(samples), Self::U16(more)) => join(samples, more, total),
            (Self::F32(samples), Self::F32(more)) => join(samples, more, total),
            (samples, more) => unreachable!(
                "{} samples after {} ones",
                more.kind().description(),
                samples.kind().description()
            ),
        }
    }
}

/// Makes room for `more` elements in a vector that will hold `total` in the end.
///
/// Memory grows with what has arrived, twice as much each time, but never beyond the total: a header that promises
/// more than the file holds costs nothing, and an honest one leaves no slack.
pub(crate) fn reserve<T>(
    vector: &mut Vec<T>,
    more: usize,
    total: usize,
) -> Result<(), TryReserveError> {
    let needed = vector.len() + more;
    if needed <= vector.capacity() {
        return Ok(());
    }
    let capacity = needed.max((2 * vector.capacity()).min(total));
    vector.try_reserve_exact(capacity - vector.len())
}

/// What an image is, before any of its samples are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// File name without its folder, or what else messages are to call the image.
    pub name: String,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// The format it came from.
    pub format: Format,
    /// What its channels are.
    pub layout: Layout,
    /// The type of its samples.
    pub kind: SampleType,
}

impl Header {
    /// Samples in a row.
    pub(crate) fn row_length(&self) -> usize {
        self.width as usize * self.layout.channels()
    }

    /// Samples in the image.
    pub(crate) fn sample_count(&self) -> usize {
        self.row_length() * self.height as usize
    }

    /// Texels in the image.
    pub(crate) fn texel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Size, sample type and channels in words: "512 x 512, 8-bit PNG (red, green, blue)".
    pub fn description(&self) -> String {
        format!(
            "{} x {}, {} {} ({})",
            self.width,
            self.height,
            self.kind.description(),
            self.format.name(),
            self.layout.description()
        )
    }
}

/// A decoded image: `width * height` texels of `layout().channels()` interleaved samples, first row on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    header: Header,
    samples: Samples,
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
        let header = Header {
            name: name.into(),
            width,
            height,
            format,
            layout,
            kind: samples.kind(),
        };
        Self::from_parts(header, samples)
    }

    /// A raster from its header and its samples.
    ///
    /// # Panics
    /// As [`new`](Self::new), or if the samples are of another type than the header says.
    pub fn from_parts(header: Header, samples: Samples) -> Self {
        let (width, height) = (header.width, header.height);
        let channels = header.layout.channels();
        assert!(
            width > 0 && height > 0,
            "a raster has at least one texel, got {width} x {height}"
        );
        assert!(
            (1..=4).contains(&channels),
            "a raster has 1 to 4 channels, got {channels}"
        );
        assert_eq!(
            samples.len() as u64,
            u64::from(width) * u64::from(height) * channels as u64,
            "a {width} x {height} raster of {channels} channels needs as many samples"
        );
        assert_eq!(samples.kind(), header.kind, "samples as the header says");
        Self { header, samples }
    }

    /// What the image is.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// File name without its folder.
    pub fn name(&self) -> &str {
        &self.header.name
    }

    /// Columns, at least 1.
    pub fn width(&self) -> u32 {
        self.header.width
    }

    /// Rows, at least 1.
    pub fn height(&self) -> u32 {
        self.header.height
    }

    /// The format it came from.
    pub fn format(&self) -> Format {
        self.header.format
    }

    /// What its channels are.
    pub fn layout(&self) -> &Layout {
        &self.header.layout
    }

    /// All samples, interleaved.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// The header and the samples.
    pub fn into_parts(self) -> (Header, Samples) {
        (self.header, self.samples)
    }

    /// Size, sample type and channels in words: "512 x 512, 8-bit PNG (red, green, blue)".
    pub fn description(&self) -> String {
        self.header.description()
    }
}
