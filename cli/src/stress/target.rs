//! What a check is given: a setting of a method on a map, what answers for it, and footprints weighed by the oracle.

use super::footprints::{self, NamedFootprint};
use super::maps::NamedMap;
use super::numbers::Numbers;
use super::outcome::At;
use crate::measure::subject::{Against, Bound, Patch, Reference, Subject, Variant};
use crate::measure::visited::texels_visited;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, HalfVector};
use glintbake_runtime::Ndf;

/// Seconds that a model may take for a half vector, where some dozens are asked for, where there is one, and where some thousands.
const SECONDS: f64 = 0.02;
const SECONDS_OF_ONE: f64 = 0.2;
const SECONDS_OF_MANY: f64 = 4e-4;

/// The most texels the oracle visits under one footprint, copies of a tile counted, and the most different ones.
const VISITED: f64 = 3e7;
const DIFFERENT: f64 = 5e4;

/// One setting of a method on one map.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The method, its model and its truth.
    pub subject: &'a dyn Subject,
    /// The setting.
    pub variant: &'a Variant,
    /// Beckmann's α, if the method has any.
    pub roughness: Option<f64>,
    /// The map and footprints on it.
    pub ground: &'a Ground<'a>,
    /// What is put to the test.
    pub answers: &'a (dyn Ndf + Sync),
}

/// An extreme footprint with the weights of its texels.
#[derive(Clone, Debug)]
pub struct Place<'m> {
    /// What it is.
    pub name: &'static str,
    /// The footprint and its weights.
    pub patch: Patch<'m>,
}

/// Everything footprints weigh on one map by one filter: made once for all methods, roughnesses and settings.
#[derive(Clone, Debug)]
pub struct Ground<'m> {
    /// The map.
    pub map: &'m NamedMap,
    /// How footprints weigh texels.
    pub filter: Filter,
    /// Extreme footprints.
    pub places: Vec<Place<'m>>,
    /// Some of them rounded to f32.
    pub rounded: Vec<Place<'m>>,
    /// One that grows.
    pub growing: Vec<Place<'m>>,
    /// Names of the extreme footprints with too many texels for the oracle.
    pub left_out: Vec<&'static str>,
}

impl<'m> Ground<'m> {
    /// The ground of `map` under `filter`. Costs one weight of the oracle for every texel under every footprint.
    pub fn new(map: &'m NamedMap, filter: Filter) -> Self {
        let mut numbers = Numbers::of(&[&map.name, "footprints"]);
        let mut ground = Self {
            map,
            filter,
            places: Vec::new(),
            rounded: Vec::new(),
            growing: Vec::new(),
            left_out: Vec::new(),
        };
        let weigh = |NamedFootprint { name, footprint }| Place {
            name,
            patch: Patch::new(&map.map, &footprint, filter),
        };
        for named in footprints::extreme(&map.map, &mut numbers) {
            let visited = texels_visited(&map.map, &named.footprint, filter);
            let different = visited.min(map.map.texels().len() as f64);
            if visited > VISITED || different > DIFFERENT {
                ground.left_out.push(named.name);
                continue;
            }
            if footprints::IN_SINGLE_PRECISION.contains(&named.name) {
                ground.rounded.push(weigh(footprints::rounded(&named)));
            }
            ground.places.push(weigh(named));
        }
        ground.growing = footprints::growing(&map.map, &mut numbers)
            .into_iter()
            .map(weigh)
            .collect();
        ground
    }
}

impl Ground<'_> {
    /// The same ground with other normals under the same weights: `map` must be of the same size, and wrap as this one's does.
    pub fn with_map<'n>(&self, map: &'n NamedMap) -> Ground<'n> {
        let moved = |places: &[Place<'_>]| {
            let places = places.iter().map(|place| Place {
                name: place.name,
                patch: Patch {
                    map: &map.map,
                    footprint: place.patch.footprint,
                    filter: place.patch.filter,
                    weights: place.patch.weights.clone(),
                },
            });
            places.collect()
        };
        Ground {
            map,
            filter: self.filter,
            places: moved(&self.places),
            rounded: moved(&self.rounded),
            growing: moved(&self.growing),
            left_out: self.left_out.clone(),
        }
    }
}

impl<'a> Target<'a> {
    /// Extreme footprints, those left out for which the model would take minutes.
    pub fn places(&self) -> impl Iterator<Item = &'a Place<'a>> {
        self.within(&self.ground.places, SECONDS)
    }

    /// Some of them rounded to f32, likewise.
    pub fn rounded(&self) -> impl Iterator<Item = &'a Place<'a>> {
        self.within(&self.ground.rounded, SECONDS)
    }

    /// One that grows, as far as the model goes along.
    pub fn growing(&self) -> impl Iterator<Item = &'a Place<'a>> {
        self.within(&self.ground.growing, SECONDS_OF_ONE)
    }

    /// The names of the places that [`places`](Self::places) leaves out.
    pub fn left_out(&self) -> Vec<&'static str> {
        let places = self.ground.places.iter();
        let places = places.filter(|place| self.seconds(place) > SECONDS);
        places.map(|place| place.name).collect()
    }

    /// Whether the model can be asked for thousands of half vectors under `place`.
    pub fn is_quick(&self, place: &Place<'_>) -> bool {
        self.seconds(place) <= SECONDS_OF_MANY
    }

    fn within(&self, places: &'a [Place<'a>], seconds: f64) -> impl Iterator<Item = &'a Place<'a>> {
        let target = *self;
        let places = places.iter();
        places.filter(move |place| target.seconds(place) <= seconds)
    }

    /// Seconds that the model takes for a half vector under `place`, about; 0 of sums over texels.
    fn seconds(&self, place: &Place<'_>) -> f64 {
        let patch = &place.patch;
        let texels = texels_visited(patch.map, &patch.footprint, patch.filter);
        let (variant, alpha) = (self.variant, self.alpha());
        self.subject
            .seconds(variant, patch.map, texels, alpha, Against::Model)
    }

    /// The map.
    pub fn map(&self) -> &NormalMap {
        &self.ground.map.map
    }

    /// Roughness as subjects take it.
    pub fn alpha(&self) -> f64 {
        self.roughness.unwrap_or_default()
    }

    /// How wide a lobe or a bin is on the disk, about.
    pub fn width(&self) -> f64 {
        self.roughness.unwrap_or(0.05)
    }

    /// The kernel's greatest density.
    pub fn peak(&self) -> f64 {
        self.subject.peak(self.variant, self.alpha())
    }

    /// How far answers may be off the model.
    pub fn bound(&self) -> Bound {
        self.subject
            .bound(self.variant, self.ground.filter, self.map(), self.alpha())
    }

    /// Numbers of this target's own, the same for every setting of a method.
    pub fn numbers(&self, check: &str) -> Numbers {
        Numbers::of(&[check, &self.ground.map.name, self.subject.method().name()])
    }

    /// The place called `name`, if the map has one that is not left out.
    pub fn place(&self, name: &str) -> Option<&'a Place<'a>> {
        self.places().find(|place| place.name == name)
    }
}

/// What is put to the test under one footprint, in the place of a model that takes too long for integrals: it is held to the model
/// half vector by half vector elsewhere.
pub struct Answered<'a> {
    /// What is put to the test.
    pub answers: &'a (dyn Ndf + Sync),
    /// The footprint.
    pub footprint: Footprint,
}

impl Reference for Answered<'_> {
    fn ndf(&self, half_vector: HalfVector) -> f64 {
        let ndf = self.answers.eval(&self.footprint, half_vector);
        ndf.unwrap_or_default()
    }

    fn pdf(&self, half_vector: HalfVector) -> f64 {
        let pdf = self.answers.pdf(&self.footprint, half_vector);
        pdf.unwrap_or_default()
    }

    fn draw(&self, _: &Patch<'_>, uniform: [f64; 4]) -> Option<HalfVector> {
        let drawn = self.answers.sample(&self.footprint, uniform);
        drawn.unwrap_or_default()
    }
}

/// A query in words and numbers.
pub fn at(what: impl Into<String>, footprint: &Footprint, half_vector: Option<HalfVector>) -> At {
    At {
        what: what.into(),
        footprint: Some(*footprint),
        half_vector,
    }
}
