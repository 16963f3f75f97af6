//! Queries with their true answers: what a cell of the plan asks, worked out by the oracles.

use super::plan::{KINDS, Plan, Shape};
use super::sources::{self, Sums};
use super::stream::Stream;
use super::subject::{Patch, Reference, Subject, Variant};
use crate::report::document::HalfVectors;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Filter, Footprint, HalfVector};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Times that the truth is asked for a half vector before a footprint is taken to have none.
const TRIES: usize = 64;
/// Draws from a model for each half vector that is asked for.
const DRAWS: usize = 4;

/// Contestants that share a truth: those of a kernel and roughness.
pub struct Group {
    /// Beckmann's α; 0 without one.
    pub roughness: f64,
    /// Whoever speaks for the truth: the first of them.
    pub truth: (&'static dyn Subject, Variant),
    /// Those that have models of their own.
    pub models: Vec<(&'static dyn Subject, Variant)>,
}

/// Queries of one kind of half vectors, with what is true of each.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// The queries.
    pub queries: Vec<(Footprint, HalfVector)>,
    /// The truth's D.
    pub truth: Vec<f64>,
    /// The D of each of the group's models.
    pub models: Vec<Vec<f64>>,
    /// What each of the models draws: only where half vectors are found.
    pub drawn: Vec<Vec<Drawn>>,
}

/// A footprint, and the half vector that a model drew there, if any, with the model's pdf.
pub type Drawn = (Footprint, Option<(HalfVector, f64)>);

/// A cell's queries: for each group, those of each of [`KINDS`].
#[derive(Debug)]
pub struct Cell {
    /// By group, by kind.
    pub asked: Vec<[Asked; KINDS.len()]>,
    /// The errors of binning, by roughness of the plan; empty unless the cell has square boxes.
    pub sources: Vec<Sums>,
}

/// Works out a cell of `shape` on `map`, the same whatever the number of threads.
pub fn work_out(map: &NormalMap, shape: Shape, groups: &[Group], plan: &Plan) -> Cell {
    let (footprints, half_vectors) = plan.effort.counts(shape.texels());
    let cell = Stream::new(plan.seed)
        .part(shape.sigma.to_bits())
        .part(shape.anisotropy.to_bits())
        .part(shape.filter as u64);
    let with_sources =
        shape.filter == Filter::Box && shape.anisotropy == 1.0 && sources::apply(groups);
    let parts: Vec<_> = (0..footprints)
        .into_par_iter()
        .map(|number| {
            let mut stream = cell.part(number as u64);
            let footprint = shape.footprint(map, &mut stream);
            let patch = Patch::new(map, &footprint, shape.filter);
            let asked: Vec<_> = groups
                .iter()
                .map(|group| ask(group, &patch, half_vectors, &mut stream))
                .collect();
            let sources: Vec<_> = if with_sources {
                plan.roughness
                    .iter()
                    .map(|&roughness| sources::of(&patch, roughness, half_vectors, &mut stream))
                    .collect()
            } else {
                Vec::new()
            };
            (asked, sources)
        })
        .collect();
    let mut whole = Cell {
        asked: groups.iter().map(|_| Default::default()).collect(),
        sources: Vec::new(),
    };
    for (asked, sources) in parts {
        for (whole, part) in whole.asked.iter_mut().zip(asked) {
            for (whole, part) in whole.iter_mut().zip(part) {
                whole.append(part);
            }
        }
        if whole.sources.is_empty() {
            whole.sources = sources;
        } else {
            for (whole, part) in whole.sources.iter_mut().zip(sources) {
                whole.add(&part);
            }
        }
    }
    whole
}

impl Asked {
    fn append(&mut self, other: Self) {
        self.queries.extend(other.queries);
        self.truth.extend(other.truth);
        self.models.resize(other.models.len(), Vec::new());
        for (all, part) in self.models.iter_mut().zip(other.models) {
            all.extend(part);
        }
        self.drawn.resize(other.drawn.len(), Vec::new());
        for (all, part) in self.drawn.iter_mut().zip(other.drawn) {
            all.extend(part);
        }
    }
}

/// `count` queries of each kind under `patch`, with what is true for `group`.
fn ask(
    group: &Group,
    patch: &Patch<'_>,
    count: usize,
    stream: &mut Stream,
) -> [Asked; KINDS.len()] {
    let (subject, variant) = &group.truth;
    let truth = subject.truth(variant, patch, group.roughness);
    let models: Vec<Option<Box<dyn Reference>>> = group
        .models
        .iter()
        .map(|(subject, variant)| {
            let is_truth = subject.is_truth(variant);
            (!is_truth).then(|| subject.model(variant, patch, group.roughness))
        })
        .collect();
    KINDS.map(|kind| {
        let mut asked = Asked {
            models: vec![Vec::new(); models.len()],
            ..Asked::default()
        };
        for _ in 0..count {
            let half_vector = match kind {
                HalfVectors::Found => (0..TRIES).find_map(|_| truth.draw(patch, stream.uniforms())),
                HalfVectors::Uniform => Some(uniform_on_disk(stream.uniforms())),
            };
            let Some(half_vector) = half_vector else {
                continue;
            };
            let density = truth.ndf(half_vector);
            asked.queries.push((patch.footprint, half_vector));
            asked.truth.push(density);
            for (densities, model) in asked.models.iter_mut().zip(&models) {
                densities.push(
                    model
                        .as_ref()
                        .map_or(density, |model| model.ndf(half_vector)),
                );
            }
        }
        if kind == HalfVectors::Found {
            asked.drawn = models
                .iter()
                .map(|model| {
                    // The truth goes through every texel for each, models through their bins.
                    let (model, draws) = match model {
                        Some(model) => (model, DRAWS * count),
                        None => (&truth, count),
                    };
                    let mut draw = || {
                        let half_vector = model.draw(patch, stream.uniforms())?;
                        Some((half_vector, model.pdf(half_vector)))
                    };
                    (0..draws).map(|_| (patch.footprint, draw())).collect()
                })
                .collect();
        }
        asked
    })
}

/// A point of the disk from two numbers in [0, 1).
fn uniform_on_disk([radius, turn]: [f64; 2]) -> HalfVector {
    let (radius, angle) = (radius.sqrt(), TAU * turn);
    HalfVector {
        s: radius * libm::cos(angle),
        t: radius * libm::sin(angle),
    }
}
