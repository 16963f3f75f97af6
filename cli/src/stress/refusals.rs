//! What must be refused, with an error that names the cause: numbers that are none, footprints beyond all bounds,
//! texels that are no normals, options out of range, maps beyond the memory allowed.

use super::outcome::{At, Outcome, Recorder};
use super::target::{Ground, Target};
use crate::measure::subject::Subject;
use glintbake_bake::image::{Format, Layout, Raster, Samples};
use glintbake_bake::normals::{DecodeOptions, NormalMap, decode};
use glintbake_bake::{BakeError, MethodRecipe, Recipe, bake};
use glintbake_format::model::{Footprint, HalfVector, MAX_EDGE_TILES, Method, Wrap};
use glintbake_runtime::{Ndf, QueryError};

const QUERY_REASON: &str = "an answer to a query that is no query would hide the caller's mistake";
const FILTER_REASON: &str =
    "footprints that a method does not weigh by are refused, not answered by others";
const OPTION_REASON: &str =
    "a roughness that a method is not made for has no bins or lobes to be baked into";
const TEXEL_REASON: &str =
    "a texel without a direction is no normal; --repair takes the nearest valid one";

/// Queries that are none, and half vectors outside the disk, which have no density.
pub(super) fn queries(target: &Target<'_>) -> Outcome {
    let mut recorder = Recorder::new("refusals", QUERY_REASON);
    let sound = Footprint::square([0.4, 0.3], 1.0, target.map().width(), target.map().height());
    let pole = HalfVector { s: 0.0, t: 0.0 };
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for coordinate in 0..6 {
            let footprint = with(&sound, coordinate, wrong);
            every_call(target.answers, &footprint, pole, &mut recorder, |error| {
                error == QueryError::NotFinite
            });
        }
        for h in [
            HalfVector { s: wrong, t: 0.0 },
            HalfVector { s: 0.1, t: wrong },
        ] {
            evaluations(target.answers, &sound, h, &mut recorder, |error| {
                error == QueryError::NotFinite
            });
        }
    }
    for length in [1.01 * MAX_EDGE_TILES, 1e5, 1e300] {
        for coordinate in 2..6 {
            let footprint = with(&sound, coordinate, length);
            every_call(target.answers, &footprint, pole, &mut recorder, |error| {
                error == QueryError::FootprintTooLarge
            });
        }
    }
    recorder.finish()
}

/// `footprint` with coordinate number `coordinate` set to `value`.
fn with(footprint: &Footprint, coordinate: usize, value: f64) -> Footprint {
    let mut footprint = *footprint;
    let pair = match coordinate / 2 {
        0 => &mut footprint.centre,
        1 => &mut footprint.edge_1,
        _ => &mut footprint.edge_2,
    };
    pair[coordinate % 2] = value;
    footprint
}

fn every_call(
    ndf: &(dyn Ndf + Sync),
    footprint: &Footprint,
    h: HalfVector,
    recorder: &mut Recorder,
    is_due: impl Fn(QueryError) -> bool + Copy,
) {
    evaluations(ndf, footprint, h, recorder, is_due);
    let sampled = recorder.call(
        || here("sample", footprint, None),
        || Ok(ndf.sample(footprint, [0.3; 4]).map(|_| ())),
    );
    if let Some(sampled) = sampled {
        judge(sampled, &here("sample", footprint, None), recorder, is_due);
    }
}

fn evaluations(
    ndf: &(dyn Ndf + Sync),
    footprint: &Footprint,
    h: HalfVector,
    recorder: &mut Recorder,
    is_due: impl Fn(QueryError) -> bool + Copy,
) {
    for (name, is_pdf) in [("eval", false), ("pdf", true)] {
        let at = || here(name, footprint, Some(h));
        let answer = recorder.call(at, || {
            Ok(if is_pdf {
                ndf.pdf(footprint, h)
            } else {
                ndf.eval(footprint, h)
            })
        });
        if let Some(answer) = answer {
            judge(answer.map(|_| ()), &at(), recorder, is_due);
        }
    }
}

fn here(what: &str, footprint: &Footprint, half_vector: Option<HalfVector>) -> At {
    At {
        what: format!("{what} of {footprint:?}, {half_vector:?}"),
        footprint: Some(*footprint),
        half_vector,
    }
}

fn judge(
    answer: Result<(), QueryError>,
    at: &At,
    recorder: &mut Recorder,
    is_due: impl Fn(QueryError) -> bool,
) {
    match answer {
        Err(error) if is_due(error) => recorder.count_refusal(),
        Err(error) => recorder.fault(at, &format!("refused, but with another error: {error}")),
        Ok(()) => recorder.fault(at, "answered, where an error is due"),
    }
}

/// Every call under the footprints of `ground`, whose filter `ndf` has no answers for.
pub(super) fn filter(ndf: &(dyn Ndf + Sync), ground: &Ground<'_>) -> Outcome {
    let mut recorder = Recorder::new("refusals", FILTER_REASON);
    let pole = HalfVector { s: 0.0, t: 0.0 };
    for place in &ground.places {
        every_call(ndf, &place.patch.footprint, pole, &mut recorder, |error| {
            matches!(
                error,
                QueryError::FilterUnsupported(_) | QueryError::BoxesOnly(_)
            )
        });
    }
    recorder.finish()
}

/// Roughnesses out of range, and a map too wide to be baked.
pub(super) fn options(subject: &dyn Subject) -> Outcome {
    let method = subject.method();
    let mut recorder = Recorder::new("refusals", OPTION_REASON);
    let map = NormalMap::new(2, 1, Wrap::Repeat, vec![[0.0; 2]; 2]);
    let wrong: &[f64] = if subject.is_rough() {
        &[0.0, -0.1, 9.9e-5, 1.01, f64::NAN, f64::INFINITY]
    } else {
        &[0.1]
    };
    for &alpha in wrong {
        let what = format!("roughness {alpha}");
        refuses(&map, method, &[alpha], what, &mut recorder, |error| {
            matches!(error, BakeError::Option { .. })
        });
    }
    let wide = NormalMap::new(65_536, 1, Wrap::Repeat, vec![[0.0; 2]; 65_536]);
    let roughness: &[f64] = if subject.is_rough() { &[0.1] } else { &[] };
    let what = "a map of 65536 columns".to_owned();
    refuses(&wide, method, roughness, what, &mut recorder, |error| {
        matches!(error, BakeError::MapTooLarge { .. })
    });
    recorder.finish().of(subject, None)
}

fn refuses(
    map: &NormalMap,
    method: Method,
    roughness: &[f64],
    what: String,
    recorder: &mut Recorder,
    is_due: impl Fn(&BakeError) -> bool,
) {
    let at = At {
        what,
        ..At::default()
    };
    let recipe = Recipe::new(vec![MethodRecipe::new(method, roughness)]);
    let baked = recorder.call(|| at.clone(), || Ok(bake(map, &recipe, None).map(|_| ())));
    match baked {
        None => {}
        Some(Err(error)) if is_due(&error) => recorder.count_refusal(),
        Some(Err(error)) => {
            recorder.fault(&at, &format!("refused, but with another error: {error}"));
        }
        Some(Ok(())) => recorder.fault(&at, "baked, where an error is due"),
    }
}

/// Images whose texels cannot be normals: refused by coordinates, or repaired if that is asked for.
pub(super) fn texels() -> Outcome {
    let mut recorder = Recorder::new("refusals", TEXEL_REASON);
    let wrong = [
        [f32::NAN, 0.0, 1.0],
        [0.0, f32::INFINITY, 1.0],
        [0.0, 0.0, f32::NEG_INFINITY],
        [0.0, 0.0, 0.0],
        [0.3, 0.0, -0.9],
    ];
    for texel in wrong {
        let at = At {
            what: format!("an image with the texel {texel:?}"),
            ..At::default()
        };
        for repair in [false, true] {
            let options = DecodeOptions {
                repair,
                ..DecodeOptions::default()
            };
            let decoded = recorder.call(
                || at.clone(),
                || {
                    Ok(decode(image_with(texel), &options)
                        .map(|(map, statistics)| (map, statistics.repaired)))
                },
            );
            match decoded {
                None => {}
                Some(Err(error)) if !repair && error.to_string().contains("texel (1, 2)") => {
                    recorder.count_refusal();
                }
                Some(Err(error)) => {
                    recorder.fault(&at, &format!("not by its coordinates: {error}"))
                }
                Some(Ok((map, 1))) if repair && map.texels()[5] == [0.0; 2] => {}
                Some(Ok(_)) if repair => recorder.fault(&at, "not repaired"),
                Some(Ok(_)) => recorder.fault(&at, "decoded, where an error is due"),
            }
        }
    }
    recorder.finish()
}

/// Two columns and four rows of flat texels, but for the one in column 1 and row 2.
fn image_with(texel: [f32; 3]) -> Raster {
    let mut samples = [0.0, 0.0, 1.0].repeat(8);
    samples[15..18].copy_from_slice(&texel);
    let layout = Layout::Rgb;
    Raster::new(
        "stress",
        2,
        4,
        Format::OpenExr,
        layout,
        Samples::F32(samples),
    )
}

/// A statement, not a trial: what a map of 16384² takes, and what `--memory` says of it.
pub(super) fn memory(subject: &dyn Subject) -> Outcome {
    let roughness: &[f64] = if subject.is_rough() { &[0.1] } else { &[] };
    let recipe = Recipe::new(vec![MethodRecipe::new(subject.method(), roughness)]);
    let gigabytes = (recipe.bytes_per_texel() << 28) as f64 / 1e9;
    let reason = format!(
        "not baked here: it takes about {gigabytes:.1} GB, and bake refuses it by its header with less --memory (16GB \
         unless named)"
    );
    Outcome {
        map: "16384x16384".to_owned(),
        ..Outcome::skipped("refusals", reason).of(subject, None)
    }
}
