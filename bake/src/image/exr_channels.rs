//! Which layer and channels of an EXR file are meant.

use super::error::ImageError;
use super::raster::Format;
use super::read::ReadOptions;
use exr::meta::header::Header;

/// Sets of channel names that are looked for when none are named, best first.
const USUAL: [&[&str]; 8] = [
    &["X", "Y", "Z"],
    &["x", "y", "z"],
    &["R", "G", "B"],
    &["r", "g", "b"],
    &["X", "Y"],
    &["x", "y"],
    &["R", "G"],
    &["r", "g"],
];

/// Beyond this many channels a file is no texture; it also bounds the search for layers, which is quadratic.
const MOST_CHANNELS: usize = 1024;

/// Channels of one part, in the order wanted.
#[derive(Debug, PartialEq)]
pub(super) struct Selection {
    /// The part of the file.
    pub part: usize,
    /// Indices into that part's channel list.
    pub channels: Vec<usize>,
}

/// The names in one part of a file.
struct PartNames {
    /// The part's own name.
    layer: Option<String>,
    /// Its channels, in the order of its channel list.
    channels: Vec<String>,
}

/// The channels that the options ask for, as [`ReadOptions`] describes.
pub(super) fn select(
    shown: &str,
    headers: &[Header],
    options: &ReadOptions,
) -> Result<Selection, ImageError> {
    let count: usize = headers
        .iter()
        .map(|header| header.channels.list.len())
        .sum();
    if count > MOST_CHANNELS {
        return Err(ImageError::Unsupported {
            file: shown.to_owned(),
            format: Format::OpenExr.name(),
            detail: format!("it has {count} channels, more than {MOST_CHANNELS}"),
        });
    }
    let parts: Vec<_> = headers
        .iter()
        .map(|header| PartNames {
            layer: header
                .own_attributes
                .layer_name
                .as_ref()
                .map(ToString::to_string),
            channels: header
                .channels
                .list
                .iter()
                .map(|channel| channel.name.to_string())
                .collect(),
        })
        .collect();
    select_by_name(&parts, options).map_err(|detail| ImageError::Selection {
        file: shown.to_owned(),
        detail,
        available: listing(&parts),
    })
}

/// [`select`] by names alone; the error says what was not found.
fn select_by_name(parts: &[PartNames], options: &ReadOptions) -> Result<Selection, String> {
    let wanted = match &options.exr_channels {
        None => None,
        Some(names) if (1..=4).contains(&names.len()) => Some(names.as_slice()),
        Some(names) => {
            return Err(format!(
                "{} channels were asked for, and a map has 1 to 4",
                names.len()
            ));
        }
    };
    let layer = options.exr_layer.as_deref();
    let places = places(parts, layer);
    let found_by = |search: &dyn Fn(&PartNames, &str) -> Option<Vec<usize>>| -> Vec<_> {
        let fitting = places.iter().filter_map(|(part, prefix)| {
            search(&parts[*part], prefix).map(|channels| (*part, prefix, channels))
        });
        fitting.collect()
    };
    let mut found = match wanted {
        Some(names) => found_by(&|part, prefix| named(part, prefix, names)),
        None => found_by(&usual),
    };
    // A lone channel is a last resort: beside a layer of normals it may well be depth.
    if found.is_empty() && wanted.is_none() {
        found = found_by(&lone);
    }
    // Names without a dot belong to no layer within their part, and the first part is the image itself.
    let plain = found.iter().position(|(_, prefix, _)| prefix.is_empty());
    let chosen = match (plain, found.len()) {
        (Some(plain), _) => plain,
        (None, 1) => 0,
        (None, 0) => {
            let within = layer.map_or(String::new(), |layer| format!(" in layer {layer}"));
            return Err(match wanted {
                Some(names) => format!("there are no channels {}{within}", names.join(", ")),
                None => format!("there are no channels X, Y, Z or R, G, B{within}"),
            });
        }
        (None, _) => {
            let fitting: Vec<_> = found
                .iter()
                .map(|(_, prefix, _)| prefix.trim_end_matches('.'))
                .collect();
            return Err(format!(
                "layers {} all have fitting channels, and none of them was chosen",
                fitting.join(", ")
            ));
        }
    };
    let (part, _, channels) = found.swap_remove(chosen);
    Ok(Selection { part, channels })
}

/// Places to look for channels: a part, and what their names start with there.
fn places(parts: &[PartNames], layer: Option<&str>) -> Vec<(usize, String)> {
    let all = 0..parts.len();
    let Some(layer) = layer else {
        let mut places: Vec<_> = all.map(|part| (part, String::new())).collect();
        for (part, names) in parts.iter().enumerate() {
            for name in &names.channels {
                if let Some(dot) = name.rfind('.') {
                    let place = (part, name[..=dot].to_owned());
                    if !places.contains(&place) {
                        places.push(place);
                    }
                }
            }
        }
        return places;
    };
    let prefixed = |part: usize| (part, format!("{layer}."));
    let named: Vec<_> = all
        .clone()
        .filter(|&part| parts[part].layer.as_deref() == Some(layer))
        .collect();
    if named.is_empty() {
        return all.map(prefixed).collect();
    }
    // Channels of a part that is named like the layer may or may not repeat its name.
    named
        .into_iter()
        .flat_map(|part| [(part, String::new()), prefixed(part)])
        .collect()
}

/// The channels of `part` called `names`, in full or after `prefix`.
fn named(part: &PartNames, prefix: &str, names: &[impl AsRef<str>]) -> Option<Vec<usize>> {
    let index = |name: &str| {
        part.channels.iter().position(|channel| {
            // A full name, with its own dot, needs no layer.
            channel.strip_prefix(prefix) == Some(name) || (name.contains('.') && channel == name)
        })
    };
    names.iter().map(|name| index(name.as_ref())).collect()
}

/// The best of the usual sets of channels after `prefix`.
fn usual(part: &PartNames, prefix: &str) -> Option<Vec<usize>> {
    USUAL.iter().find_map(|names| named(part, prefix, names))
}

/// The only channel directly after `prefix`.
fn lone(part: &PartNames, prefix: &str) -> Option<Vec<usize>> {
    let mut within = part.channels.iter().enumerate().filter(|(_, channel)| {
        channel
            .strip_prefix(prefix)
            .is_some_and(|rest| !rest.contains('.'))
    });
    match (within.next(), within.next()) {
        (Some((only, _)), None) => Some(vec![only]),
        _ => None,
    }
}

/// The parts and channels of a file, for messages; a hostile file cannot make it longer than a few lines.
fn listing(parts: &[PartNames]) -> String {
    const MOST: usize = 64;
    let all = parts.iter().flat_map(|part| {
        part.channels.iter().map(|channel| match &part.layer {
            Some(layer) if parts.len() > 1 => format!("{channel} (layer {layer})"),
            _ => channel.clone(),
        })
    });
    let count: usize = parts.iter().map(|part| part.channels.len()).sum();
    let mut listing = format!("channels {}", all.take(MOST).collect::<Vec<_>>().join(", "));
    if count > MOST {
        listing.push_str(&format!(" and {} more", count - MOST));
    }
    listing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(layer: Option<&str>, channels: &[&str]) -> PartNames {
        PartNames {
            layer: layer.map(str::to_owned),
            channels: channels.iter().map(ToString::to_string).collect(),
        }
    }

    fn ask(
        parts: &[PartNames],
        layer: Option<&str>,
        channels: Option<&[&str]>,
    ) -> Result<(usize, Vec<usize>), String> {
        let options = ReadOptions {
            exr_layer: layer.map(str::to_owned),
            exr_channels: channels.map(|names| names.iter().map(ToString::to_string).collect()),
            ..ReadOptions::default()
        };
        select_by_name(parts, &options).map(|selection| (selection.part, selection.channels))
    }

    #[test]
    fn the_usual_names_are_found_best_first() {
        let colours = [part(None, &["A", "B", "G", "R"])];
        assert_eq!(ask(&colours, None, None), Ok((0, vec![3, 2, 1])));
        let both = [part(None, &["B", "G", "R", "X", "Y", "Z"])];
        assert_eq!(ask(&both, None, None), Ok((0, vec![3, 4, 5])));
        assert_eq!(
            ask(&[part(None, &["G", "R"])], None, None),
            Ok((0, vec![1, 0]))
        );
        assert_eq!(
            ask(&[part(None, &["height"])], None, None),
            Ok((0, vec![0]))
        );
    }

    #[test]
    fn a_layer_is_a_prefix_or_a_part() {
        let prefixed = [part(None, &["B", "G", "N.X", "N.Y", "N.Z", "R"])];
        assert_eq!(ask(&prefixed, None, None), Ok((0, vec![5, 1, 0])));
        assert_eq!(ask(&prefixed, Some("N"), None), Ok((0, vec![2, 3, 4])));
        assert_eq!(
            ask(&prefixed, None, Some(&["N.Z", "N.X"])),
            Ok((0, vec![4, 2]))
        );
        assert_eq!(ask(&prefixed, Some("N"), Some(&["Y"])), Ok((0, vec![3])));
        assert_eq!(ask(&prefixed, Some("N"), Some(&["N.Y"])), Ok((0, vec![3])));
        let parts = [
            part(Some("beauty"), &["B", "G", "R"]),
            part(Some("N"), &["X", "Y", "Z"]),
            part(Some("P"), &["P.X", "P.Y", "P.Z"]),
        ];
        assert_eq!(ask(&parts, None, None), Ok((0, vec![2, 1, 0])));
        assert_eq!(ask(&parts, Some("N"), None), Ok((1, vec![0, 1, 2])));
        assert_eq!(ask(&parts, Some("P"), None), Ok((2, vec![0, 1, 2])));
    }

    #[test]
    fn one_layer_that_fits_is_taken_and_two_are_not_guessed_between() {
        let two = [part(None, &["N.X", "N.Y", "N.Z", "T.X", "T.Y", "T.Z"])];
        assert_eq!(
            ask(&two, None, None).unwrap_err(),
            "layers N, T all have fitting channels, and none of them was chosen"
        );
        let one = [part(None, &["N.X", "N.Y", "N.Z", "depth.V"])];
        assert_eq!(ask(&one, None, None), Ok((0, vec![0, 1, 2])));
        let one = [part(None, &["N.X", "N.Y", "N.Z", "uv.U", "uv.V"])];
        assert_eq!(ask(&one, None, None), Ok((0, vec![0, 1, 2])));
    }

    #[test]
    fn what_is_missing_is_said() {
        let parts = [part(None, &["B", "G", "R"])];
        assert_eq!(
            ask(&parts, Some("N"), None).unwrap_err(),
            "there are no channels X, Y, Z or R, G, B in layer N"
        );
        assert_eq!(
            ask(&parts, None, Some(&["Q", "R"])).unwrap_err(),
            "there are no channels Q, R"
        );
        for count in [0, 5] {
            let names = vec!["R"; count];
            assert_eq!(
                ask(&parts, None, Some(&names)).unwrap_err(),
                format!("{count} channels were asked for, and a map has 1 to 4")
            );
        }
    }

    #[test]
    fn the_listing_names_layers_and_stays_short() {
        let parts = [part(Some("a"), &["X"]), part(Some("b"), &["Y"])];
        assert_eq!(listing(&parts), "channels X (layer a), Y (layer b)");
        let many: Vec<_> = (0..100).map(|i| format!("c{i}")).collect();
        let many: Vec<_> = many.iter().map(String::as_str).collect();
        assert!(listing(&[part(None, &many)]).ends_with("c63 and 36 more"));
    }
}
