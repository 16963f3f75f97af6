//! What a check is given: a setting of a method on a map, what answers for it, and footprints weighed by the oracle.

use super::footprints::{self, NamedFootprint};
use super::maps::NamedMap;
use super::numbers::Numbers;
use super::outcome::At;
use crate::measure::subject::{Bound, Patch, Subject, Variant};
use glintbake_format::model::{Filter, Footprint, HalfVector};
use glintbake_runtime::Ndf;

/// The most texels the oracle visits under one footprint, copies of a tile counted, and the most different ones.
const VISITED: f64 = 2e6;
const DIFFERENT: f64 = 5e4;

/// One setting of a method on one map.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The method, its model and its truth.
    pub subject: &'a dyn Subject,
    /// The setting.
    pub variant: &'a Variant,
    /// How footprints weigh texels.
    pub filter: Filter,
    /// Beckmann's α, if the method has any.
    pub roughness: Option<f64>,
    /// The map.
    pub map: &'a NamedMap,
    /// Extreme footprints on the map.
    pub places: &'a [Place<'a>],
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

/// Places, and the names of the footprints that are too large for the oracle.
pub type Places<'m> = (Vec<Place<'m>>, Vec<&'static str>);

/// The extreme footprints on `map`, weighed by `filter`.
pub fn places(map: &NamedMap, filter: Filter) -> Places<'_> {
    let mut numbers = Numbers::of(&[&map.name, "footprints"]);
    let mut places = Vec::new();
    let mut left_out = Vec::new();
    for NamedFootprint { name, footprint } in footprints::extreme(&map.map, &mut numbers) {
        let visited = footprints::texels_visited(&map.map, &footprint, filter);
        let different = visited.min(map.map.texels().len() as f64);
        if visited > VISITED || different > DIFFERENT {
            left_out.push(name);
            continue;
        }
        places.push(Place {
            name,
            patch: Patch::new(&map.map, &footprint, filter),
        });
    }
    (places, left_out)
}

impl Target<'_> {
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
            .bound(self.variant, self.filter, &self.map.map, self.alpha())
    }

    /// Numbers of this target's own, the same for every setting of a method.
    pub fn numbers(&self, check: &str) -> Numbers {
        Numbers::of(&[check, &self.map.name, self.subject.method().name()])
    }

    /// The place called `name`, if the map has one.
    pub fn place(&self, name: &str) -> Option<&Place<'_>> {
        self.places.iter().find(|place| place.name == name)
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
