//! Options that have no meaning for the map at hand.

use super::error::NormalsError;
use super::options::{Channels, DecodeOptions, GreenAxis, Input, Range, Zero};
use crate::image::Header;

/// The largest height of white: squares of the slopes of any f32 heights then stay far below the largest f64.
const LARGEST_HEIGHT_SCALE: f64 = 1e9;

/// Refuses options that the input gives no meaning to.
pub(super) fn check(header: &Header, options: &DecodeOptions) -> Result<(), NormalsError> {
    let refuse = |option: String, reason: &str| {
        Err(NormalsError::Option {
            name: header.name.clone(),
            option,
            reason: reason.to_owned(),
        })
    };
    let integers = header.kind.maximum().is_some();
    if options.input == Input::Height {
        let reasonable = -LARGEST_HEIGHT_SCALE..=LARGEST_HEIGHT_SCALE;
        if !reasonable.contains(&options.height_scale) {
            return refuse(
                format!("--height-scale {}", options.height_scale),
                "is not a number of texels; give the height of white, at most 1e9",
            );
        }
        if options.channels != Channels::Xyz {
            return refuse(
                format!("--channels {}", options.channels),
                "has no meaning for a height map, whose first channel counts; leave it out",
            );
        }
        if options.green != GreenAxis::Gl {
            return refuse(
                format!("--y {}", options.green),
                "has no meaning for a height map, whose rows tell what is up; leave it out",
            );
        }
        if options.range == Range::Snorm {
            return refuse(
                format!("--range {}", options.range),
                "has no meaning for a height map, where 0 is black and 1 is white; leave it out",
            );
        }
        if options.zero != Zero::Half {
            return refuse(
                format!("--zero {}", options.zero),
                "has no meaning for a height map, where only differences count; leave it out",
            );
        }
        return Ok(());
    }
    if integers && options.range == Range::Snorm {
        return refuse(
            format!("--range {}", options.range),
            "needs floats, and the samples are unsigned integers; leave it out",
        );
    }
    if !integers && options.zero != Zero::Half {
        return refuse(
            format!("--zero {}", options.zero),
            "chooses between integers, and the samples are floats; leave it out",
        );
    }
    Ok(())
}
