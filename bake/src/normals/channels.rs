//! Which samples of a texel are s, t and z.

use super::error::NormalsError;
use super::options::Channels;
use crate::image::Layout;

/// Positions of the components among a texel's interleaved samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Places {
    /// Of s, t and z.
    Three([usize; 3]),
    /// Of s and t.
    Two([usize; 2]),
}

impl Places {
    /// The positions in reading order.
    pub(super) fn as_slice(&self) -> &[usize] {
        match self {
            Self::Three(places) => places,
            Self::Two(places) => places,
        }
    }
}

/// Where `channels` lie in texels of `layout`.
pub(super) fn places(
    channels: Channels,
    layout: &Layout,
    name: &str,
) -> Result<Places, NormalsError> {
    let found = match (channels, layout.channels(), layout) {
        (_, 1, _) => Err("it has one channel: if it is a height map, pass --input height"),
        // Red and green of grey with alpha are the same grey.
        (Channels::Rg, _, Layout::GrayAlpha) => {
            Err("red and green are the same grey there; pass --channels xy, ga or ag")
        }
        (Channels::Xyz, 3.., _) => Ok(Places::Three([0, 1, 2])),
        (Channels::Xyz, ..) => {
            Err("for a map of two channels pass --channels xy, rg, ga, ra or ag")
        }
        (Channels::Xy | Channels::Rg, ..) => Ok(Places::Two([0, 1])),
        (Channels::Ga | Channels::Ra, 2, Layout::GrayAlpha) => Ok(Places::Two([0, 1])),
        (Channels::Ag, 2, Layout::GrayAlpha) => Ok(Places::Two([1, 0])),
        (Channels::Ga, 4, _) => Ok(Places::Two([1, 3])),
        (Channels::Ra, 4, _) => Ok(Places::Two([0, 3])),
        (Channels::Ag, 4, _) => Ok(Places::Two([3, 1])),
        (Channels::Ga | Channels::Ra | Channels::Ag, _, Layout::Named(_)) => Err(
            "name the channels of an EXR file in the order s, t with --exr-channels, and pass --channels xy",
        ),
        (Channels::Ga | Channels::Ra | Channels::Ag, ..) => {
            Err("it has no alpha channel; pass --channels xyz, or xy if z is to be rebuilt")
        }
    };
    found.map_err(|remedy| NormalsError::Channels {
        name: name.to_owned(),
        channels: channels.name(),
        present: layout.description(),
        remedy,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(channels: Channels, layout: &Layout) -> Option<Vec<usize>> {
        places(channels, layout, "map")
            .ok()
            .map(|places| places.as_slice().to_vec())
    }

    #[test]
    fn letters_name_the_channels_of_s_and_t_in_that_order() {
        use Channels::{Ag, Ga, Ra, Rg, Xy, Xyz};
        let named = |n: usize| Layout::Named((0..n).map(|i| i.to_string()).collect());
        let expected: [(Layout, [Option<&[usize]>; 6]); 8] = [
            (Layout::Gray, [None; 6]),
            (
                Layout::GrayAlpha,
                [
                    None,
                    Some(&[0, 1]),
                    None,
                    Some(&[0, 1]),
                    Some(&[0, 1]),
                    Some(&[1, 0]),
                ],
            ),
            (
                Layout::Rgb,
                [
                    Some(&[0, 1, 2]),
                    Some(&[0, 1]),
                    Some(&[0, 1]),
                    None,
                    None,
                    None,
                ],
            ),
            (
                Layout::Rgba,
                [
                    Some(&[0, 1, 2]),
                    Some(&[0, 1]),
                    Some(&[0, 1]),
                    Some(&[1, 3]),
                    Some(&[0, 3]),
                    Some(&[3, 1]),
                ],
            ),
            (named(1), [None; 6]),
            (
                named(2),
                [None, Some(&[0, 1]), Some(&[0, 1]), None, None, None],
            ),
            (
                named(3),
                [
                    Some(&[0, 1, 2]),
                    Some(&[0, 1]),
                    Some(&[0, 1]),
                    None,
                    None,
                    None,
                ],
            ),
            (
                named(4),
                [
                    Some(&[0, 1, 2]),
                    Some(&[0, 1]),
                    Some(&[0, 1]),
                    Some(&[1, 3]),
                    Some(&[0, 3]),
                    Some(&[3, 1]),
                ],
            ),
        ];
        for (layout, rows) in expected {
            for (channels, places) in [Xyz, Xy, Rg, Ga, Ra, Ag].into_iter().zip(rows) {
                assert_eq!(
                    at(channels, &layout).as_deref(),
                    places,
                    "{channels} of {layout:?}"
                );
            }
        }
    }

    #[test]
    fn a_grey_map_is_asked_whether_it_holds_heights() {
        assert_eq!(
            places(Channels::Xyz, &Layout::Gray, "bricks.png")
                .unwrap_err()
                .to_string(),
            "bricks.png: --channels xyz cannot be read from one grey channel; it has one channel: if it is a height \
             map, pass --input height"
        );
    }
}
