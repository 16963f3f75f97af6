//! Input files that the tests need and the program does not write.

use image::{DynamicImage, ImageBuffer, Luma, Rgb, Rgba};
use std::path::Path;

/// Writes a PNG (or what the extension says) of 8-bit colours, `at` giving each texel's.
pub fn rgb8(path: &Path, size: (u32, u32), at: impl Fn(u32, u32) -> [u8; 3]) {
    let image = ImageBuffer::from_fn(size.0, size.1, |column, row| Rgb(at(column, row)));
    save(DynamicImage::ImageRgb8(image), path);
}

/// As [`rgb8`], with 16 bits.
pub fn rgb16(path: &Path, size: (u32, u32), at: impl Fn(u32, u32) -> [u16; 3]) {
    let image = ImageBuffer::from_fn(size.0, size.1, |column, row| Rgb(at(column, row)));
    save(DynamicImage::ImageRgb16(image), path);
}

/// As [`rgb8`], with alpha.
pub fn rgba8(path: &Path, size: (u32, u32), at: impl Fn(u32, u32) -> [u8; 4]) {
    let image = ImageBuffer::from_fn(size.0, size.1, |column, row| Rgba(at(column, row)));
    save(DynamicImage::ImageRgba8(image), path);
}

/// As [`rgb8`], one grey channel.
pub fn grey8(path: &Path, size: (u32, u32), at: impl Fn(u32, u32) -> u8) {
    let image = ImageBuffer::from_fn(size.0, size.1, |column, row| Luma([at(column, row)]));
    save(DynamicImage::ImageLuma8(image), path);
}

fn save(image: DynamicImage, path: &Path) {
    image.save(path).expect("a test image");
}

/// A normal that leans by the texel's place, as 8-bit colours, so that no two transformed maps are alike.
pub fn leaning(column: u32, row: u32) -> [u8; 3] {
    let s = 90 + 7 * (column % 8) as u8;
    let t = 110 + 5 * (row % 6) as u8;
    let component = |x: u8| f64::from(x) / 255.0 * 2.0 - 1.0;
    let z = (1.0 - component(s).powi(2) - component(t).powi(2)).sqrt();
    [s, t, (z * 127.5 + 127.5).round() as u8]
}

/// A layer of an EXR file: its name, and its channels by name with a value for each texel.
pub type ExrLayer<'a> = (&'a str, &'a [(&'a str, Vec<f32>)]);

/// Writes an EXR file of f32 channels.
pub fn exr(path: &Path, size: (usize, usize), layers: &[ExrLayer<'_>]) {
    use exr::meta::header::ImageAttributes;
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
        WritableImage,
    };
    let layers: Vec<_> = layers
        .iter()
        .map(|(name, channels)| {
            let channels = channels
                .iter()
                .map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.clone())))
                .collect();
            Layer::new(
                size,
                LayerAttributes::named(*name),
                Encoding::SMALL_LOSSLESS,
                AnyChannels::sort(channels),
            )
        })
        .collect();
    let window = ImageAttributes::with_size(Vec2(size.0, size.1));
    let image = Image::from_layers(window, layers);
    image.write().to_file(path).expect("a test EXR");
}
