//! Opacity maps from images: the one channel that says where a layer covers the surface.

use super::error::MaterialError;
use crate::error::BakeError;
use crate::image::{Bands, HashedFile, Layout, ReadOptions, Samples};

/// How much of each texel a layer covers, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpacityMap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 0 is not at all, 255 wholly.
    pub texels: Vec<u8>,
}

/// The opacity map in `file`: its grey channel or, if it has one, its alpha.
///
/// # Errors
/// [`BakeError::Image`], and [`MaterialError::Opacity`] if it has neither or a texel is not a number.
pub(super) fn read(file: &HashedFile, options: &ReadOptions) -> Result<OpacityMap, BakeError> {
    let mut bands = Bands::of(file, options)?;
    let header = bands.header().clone();
    let wrong = |found: String, remedy| MaterialError::Opacity {
        file: file.path().display().to_string(),
        found,
        remedy,
    };
    let channel = match &header.layout {
        Layout::Gray => 0,
        Layout::GrayAlpha => 1,
        Layout::Rgba => 3,
        Layout::Named(names) if names.len() == 1 => 0,
        Layout::Rgb | Layout::Named(_) => {
            let remedy = "save it as a grey image";
            return Err(wrong(header.layout.description(), remedy).into());
        }
    };
    let step = header.layout.channels();
    let mut texels = Vec::new();
    while let Some(band) = bands.next_band()? {
        match band {
            Samples::U8(samples) => {
                texels.extend(samples.iter().skip(channel).step_by(step).copied());
            }
            Samples::U16(samples) => {
                let samples = samples.iter().skip(channel).step_by(step);
                // 65535 = 257 · 255: the nearest number.
                texels.extend(samples.map(|&sample| ((u32::from(sample) + 128) / 257) as u8));
            }
            Samples::F32(samples) => {
                for &sample in samples.iter().skip(channel).step_by(step) {
                    if sample.is_nan() {
                        let found = "a texel that is not a number".to_owned();
                        return Err(wrong(found, "export it again").into());
                    }
                    texels.push((sample.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
                }
            }
        }
    }
    Ok(OpacityMap {
        width: header.width,
        height: header.height,
        texels,
    })
}
