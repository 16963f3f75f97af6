//! From a file to a normal map, without the raster in between.

use super::decode::{Decoder, Interruption, Widening};
use super::map::NormalMap;
use super::options::DecodeOptions;
use super::statistics::Statistics;
use crate::error::BakeError;
use crate::image::{Bands, HashedFile, ImageError, ReadOptions};
use crate::progress::{Progress, Stage};
use std::sync::mpsc;

/// Bands that may wait while another is converted: enough that neither side waits for the other's odd slow one.
const BANDS_AHEAD: usize = 2;

/// The normals in `file`, and what they are like: what [`image::read`](crate::image::read) and
/// [`decode`](super::decode()) give together, in less memory and time.
///
/// One thread decodes bands of rows while the pool converts the band before, so that inflating, the slow part, never
/// waits. The peak is 8 bytes a texel and a few bands; height maps add their heights, 1 to 4 bytes a texel, and formats
/// that [`Bands`] must read whole their raster. A map of 16-bit samples that looks like a widened 8-bit one at first,
/// and then does not, is read twice.
///
/// # Errors
/// [`BakeError::Image`] or [`BakeError::Normals`], as those functions; [`ImageError::Changed`].
pub fn read(
    file: &HashedFile,
    read_options: &ReadOptions,
    options: &DecodeOptions,
    progress: &dyn Progress,
) -> Result<(NormalMap, Statistics), BakeError> {
    from_bands(|| Bands::of(file, read_options), options, progress)
}

/// [`read`], where `open` gives the bands from the first on, each time anew.
pub(super) fn from_bands(
    open: impl Fn() -> Result<Bands, ImageError>,
    options: &DecodeOptions,
    progress: &dyn Progress,
) -> Result<(NormalMap, Statistics), BakeError> {
    for widening in [Widening::Possible, Widening::Refuted] {
        let bands = open()?;
        let mut decoder = Decoder::new(bands.header().clone(), options, widening)?;
        match pass(bands, &mut decoder, progress) {
            Ok(()) => return Ok(decoder.finish()?),
            Err(Stop::Again) => {}
            Err(Stop::Failed(error)) => return Err(error),
        }
    }
    unreachable!("nothing is assumed the second time that could prove wrong")
}

/// Why a pass over the bands ended early.
enum Stop {
    Again,
    Failed(BakeError),
}

/// Moves all `bands` to `decoder`.
fn pass(mut bands: Bands, decoder: &mut Decoder, progress: &dyn Progress) -> Result<(), Stop> {
    let rows = u64::from(bands.header().height);
    let row_length = bands.header().row_length();
    progress.report(Stage::Read, 0, rows);
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::sync_channel(BANDS_AHEAD);
        let reading = scope.spawn(move || {
            while let Some(band) = bands.next_band()? {
                // The other side has given up, and says why itself.
                if sender.send(band).is_err() {
                    break;
                }
            }
            Ok::<(), ImageError>(())
        });
        let mut done = 0;
        for band in receiver {
            done += (band.len() / row_length) as u64;
            decoder
                .push(band)
                .map_err(|interruption| match interruption {
                    Interruption::NotWidened => Stop::Again,
                    Interruption::Error(error) => Stop::Failed(error.into()),
                })?;
            progress.report(Stage::Read, done, rows);
        }
        match reading.join() {
            Ok(read) => read.map_err(|error| Stop::Failed(error.into())),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
