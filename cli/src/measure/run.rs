//! The measurement of one map: bake, ask, compare, time.

use super::asked::{self, Asked, Drawn, Group};
use super::clock::Clock;
use super::entrants::{Entrant, Field};
use super::errors::{LIT, at_equal_time, energy, errors};
use super::plan::{ANISOTROPIES, KINDS, Plan, Shape, sigmas};
use super::stream::Stream;
use super::subject::{Against, standard_normal, surface_name};
use super::visited::texels_visited;
use crate::report::document::{Cell, HalfVectors, MapReport, Row, Skipped, Times};
use glintbake_bake::BakeError;
use glintbake_bake::normals::NormalMap;
use glintbake_format::model::{Footprint, HalfVector};
use glintbake_runtime::QueryError;
use std::hint::black_box;

/// The method of the baseline that others are compared with at equal time.
const POINT_SAMPLING: &str = "point-sampling";

/// Why a map could not be measured.
#[derive(Debug)]
pub enum MeasureError {
    /// It could not be baked.
    Bake(BakeError),
    /// A package just baked could not be opened.
    Query(QueryError),
}

/// How far a measurement has come.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Cells done.
    pub done: usize,
    /// Cells of the map.
    pub total: usize,
}

/// Measures `map` by `plan`, adding to `report`; `listen` is told after each cell, whose rows are in the report then.
///
/// # Errors
/// [`MeasureError`]; what `listen` fails with ends the measurement too.
pub fn measure<E: From<MeasureError>>(
    map: &NormalMap,
    plan: &Plan,
    clock: Clock,
    report: &mut MapReport,
    listen: &mut dyn FnMut(&MapReport, Step) -> Result<(), E>,
) -> Result<(), E> {
    let field = Field::new(map, plan).map_err(MeasureError::Bake)?;
    report.packages.clone_from(&field.packages);
    report.skipped.clone_from(&field.skipped);
    let sigmas = if plan.sigmas.is_empty() {
        sigmas(map)
    } else {
        plan.sigmas.clone()
    };
    let total = plan.filters.len() * sigmas.len() * ANISOTROPIES.len();
    let mut done = 0;
    listen(report, Step { done, total })?;
    for &filter in &plan.filters {
        let entrants = field.entrants(plan, filter).map_err(MeasureError::Query)?;
        for &sigma in &sigmas {
            for anisotropy in ANISOTROPIES {
                let shape = Shape {
                    filter,
                    sigma,
                    anisotropy,
                };
                let entrants = affordable(map, &entrants, shape, &mut report.skipped);
                let (groups, membership) = groups(&entrants);
                let cell = asked::work_out(map, shape, &groups, plan);
                let sums = plan.roughness.iter().zip(&cell.sources);
                report
                    .sources
                    .extend(sums.filter_map(|(&roughness, sums)| sums.report(roughness, sigma)));
                for (place, kind) in KINDS.into_iter().enumerate() {
                    let neighbours = Neighbours::new(map, shape, plan, kind);
                    let first = report.rows.len();
                    for (entrant, member) in entrants.iter().zip(&membership) {
                        let asked = &cell.asked[member.group][place];
                        let described = describe(shape, entrant, kind);
                        match row(
                            entrant,
                            member,
                            asked,
                            &neighbours,
                            described.clone(),
                            clock,
                        ) {
                            Ok(Some(row)) => report.rows.push(row),
                            Ok(None) => {}
                            Err(error) => report.skipped.push(Skipped {
                                contestant: entrant.contestant.clone(),
                                cell: Some(described),
                                reason: error.to_string(),
                            }),
                        }
                    }
                    compare_with_point_sampling(&mut report.rows[first..]);
                }
                done += 1;
                listen(report, Step { done, total })?;
            }
        }
    }
    Ok(())
}

/// Where an entrant's truth and model are.
struct Member {
    group: usize,
    model: Option<usize>,
}

/// Seconds that an oracle may take for a half vector.
const MOST_SECONDS: f64 = 1.0;

/// Those of `entrants` whose oracles can be asked under `shape`; the others are skipped, with a word for each.
fn affordable<'e, 'a>(
    map: &NormalMap,
    entrants: &'e [Entrant<'a>],
    shape: Shape,
    skipped: &mut Vec<Skipped>,
) -> Vec<&'e Entrant<'a>> {
    let footprint = shape.footprint(map, &mut Stream::new(0));
    let texels = texels_visited(map, &footprint, shape.filter);
    let mut affordable = Vec::new();
    for entrant in entrants {
        let alpha = entrant.roughness.unwrap_or_default();
        let seconds = entrant.subject.as_ref().map_or(0.0, |(subject, variant)| {
            let seconds = |of| subject.seconds(variant, map, texels, alpha, of);
            seconds(Against::Model).max(seconds(Against::Truth))
        });
        if seconds <= MOST_SECONDS {
            affordable.push(entrant);
            continue;
        }
        let is_told = |told: &Skipped| told.contestant == entrant.contestant;
        if !skipped.iter().any(is_told) {
            skipped.push(Skipped {
                contestant: entrant.contestant.clone(),
                cell: Some(describe(shape, entrant, HalfVectors::Found)),
                reason: format!(
                    "its oracles would take {seconds:.0} s for a half vector; so for all that would take more than \
                     {MOST_SECONDS} s"
                ),
            });
        }
    }
    affordable
}

/// Entrants by the truth they share.
fn groups(entrants: &[&Entrant<'_>]) -> (Vec<Group>, Vec<Member>) {
    let mut groups: Vec<Group> = Vec::new();
    let mut keys = Vec::new();
    let members = entrants
        .iter()
        .map(|entrant| {
            // Without a kernel each variant is a truth of its own.
            let alone = match (&entrant.roughness, &entrant.subject) {
                (None, Some((_, variant))) => variant.name.clone(),
                _ => String::new(),
            };
            let key = (
                entrant.kernel,
                entrant.surface,
                entrant.roughness.map(f64::to_bits),
                alone,
            );
            let group = keys
                .iter()
                .position(|other| *other == key)
                .unwrap_or_else(|| {
                    let truth = entrant
                        .subject
                        .clone()
                        .expect("methods come before the baselines of their kernel");
                    groups.push(Group {
                        roughness: entrant.roughness.unwrap_or_default(),
                        truth,
                        models: Vec::new(),
                    });
                    keys.push(key);
                    groups.len() - 1
                });
            let model = entrant.subject.clone().map(|subject| {
                groups[group].models.push(subject);
                groups[group].models.len() - 1
            });
            Member { group, model }
        })
        .collect();
    (groups, members)
}

fn describe(shape: Shape, entrant: &Entrant<'_>, half_vectors: HalfVectors) -> Cell {
    Cell {
        filter: shape.filter.name().to_owned(),
        roughness: entrant.roughness,
        sigma: shape.sigma,
        anisotropy: shape.anisotropy,
        half_vectors,
    }
}

/// Footprints side by side, and half vectors near the normals below them.
struct Neighbours(Vec<(Footprint, HalfVector)>);

impl Neighbours {
    fn new(map: &NormalMap, shape: Shape, plan: &Plan, kind: HalfVectors) -> Self {
        let mut stream = Stream::new(plan.seed).part(shape.sigma.to_bits()).part(1);
        let footprints = shape.row(plan.effort.queries, map, &mut stream);
        let spread = plan.roughness.first().copied().unwrap_or(0.01);
        let queries = footprints.into_iter().map(|footprint| {
            let [s, t] = standard_normal(stream.uniforms()).map(|x| 0.5 * spread * x);
            let half_vector = match kind {
                HalfVectors::Found => {
                    let normal = normal_at(map, footprint.centre);
                    HalfVector {
                        s: normal[0] + s,
                        t: normal[1] + t,
                    }
                }
                HalfVectors::Uniform => {
                    let [s, t] = stream.uniforms().map(|x| 1.4 * x - 0.7);
                    HalfVector { s, t }
                }
            };
            (footprint, half_vector)
        });
        Self(queries.collect())
    }
}

/// The normal of the texel at `place`, in tiles.
fn normal_at(map: &NormalMap, place: [f64; 2]) -> [f64; 2] {
    let texel = |x: f64, size: u32| {
        let x = (x - x.floor()) * f64::from(size);
        (x as u32).min(size - 1) as usize
    };
    let index = texel(place[1], map.height()) * map.width() as usize + texel(place[0], map.width());
    map.texels()[index].map(f64::from)
}

/// The row of `entrant`; `None` if nothing was asked.
fn row(
    entrant: &Entrant<'_>,
    member: &Member,
    asked: &Asked,
    neighbours: &Neighbours,
    cell: Cell,
    clock: Clock,
) -> Result<Option<Row>, QueryError> {
    let queries = &asked.queries;
    if queries.is_empty() {
        return Ok(None);
    }
    let answers = &*entrant.answers;
    let densities = queries
        .iter()
        .map(|(footprint, half_vector)| answers.eval(footprint, *half_vector))
        .collect::<Result<Vec<_>, _>>()?;
    let drawn = member.model.and_then(|model| asked.drawn.get(model));
    let ratios = drawn
        .map(|drawn| {
            let ratio = |(footprint, drawn): &Drawn| match drawn {
                None => Ok(0.0),
                Some((half_vector, model)) => match answers.pdf(footprint, *half_vector) {
                    Some(pdf) => Ok(pdf? / model),
                    None => Ok(0.0),
                },
            };
            drawn
                .iter()
                .map(ratio)
                .collect::<Result<Vec<_>, QueryError>>()
        })
        .transpose()?;
    let times = times(entrant, queries, neighbours, clock);
    Ok(Some(Row {
        contestant: entrant.contestant.clone(),
        kernel: entrant.kernel.name().to_owned(),
        surface: surface_name(entrant.surface).to_owned(),
        cell,
        queries: queries.len(),
        lit: asked
            .truth
            .iter()
            .filter(|&&density| density >= LIT)
            .count(),
        truth: errors(&densities, &asked.truth),
        model: member
            .model
            .map(|model| errors(&densities, &asked.models[model])),
        energy: ratios.and_then(|ratios| energy(&ratios)),
        times,
    }))
}

fn times(
    entrant: &Entrant<'_>,
    queries: &[(Footprint, HalfVector)],
    neighbours: &Neighbours,
    clock: Clock,
) -> Times {
    let answers = &*entrant.answers;
    // Methods sample, baselines do not.
    let samples = entrant.subject.is_some();
    // Half vectors of one footprint follow each other in the list: in random order each call has another footprint.
    let stride = coprime_stride(queries.len());
    let at = |number: usize| &queries[number * stride % queries.len()];
    // Answers were asked for before; what is timed cannot fail.
    let eval = clock.time(queries.len(), |number| {
        let (footprint, half_vector) = at(number);
        let _ = black_box(answers.eval(footprint, *half_vector));
    });
    let eval_coherent = clock.time(neighbours.0.len(), |number| {
        let (footprint, half_vector) = &neighbours.0[number];
        let _ = black_box(answers.eval(footprint, *half_vector));
    });
    let sample = samples.then(|| {
        let mut stream = Stream::new(1);
        clock.time(queries.len(), |number| {
            let _ = black_box(answers.sample(&at(number).0, stream.uniforms()));
        })
    });
    let pdf = samples.then(|| {
        clock.time(queries.len(), |number| {
            let (footprint, half_vector) = at(number);
            let _ = black_box(answers.pdf(footprint, *half_vector));
        })
    });
    Times {
        eval,
        eval_coherent,
        sample,
        pdf,
        point_sampling_error: None,
    }
}

/// A step through `count` things that meets each once before any again, and none soon after its neighbour.
fn coprime_stride(count: usize) -> usize {
    let golden = (count as f64 * 0.618) as usize;
    let coprime = |step: &usize| {
        let (mut a, mut b) = (*step, count);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    (golden.max(1)..).find(coprime).unwrap_or(1)
}

/// Says of each row what point sampling, by the rows of it among `rows`, makes of the same time.
fn compare_with_point_sampling(rows: &mut [Row]) {
    let points: Vec<_> = rows
        .iter()
        .filter(|row| row.contestant.method == POINT_SAMPLING)
        .filter_map(|row| {
            let point = (row.times.eval.median_ns, row.truth.relative_l1?);
            let truth = (row.kernel.clone(), row.surface.clone());
            Some((truth, row.cell.roughness, point))
        })
        .collect();
    for row in rows {
        if row.contestant.method == POINT_SAMPLING {
            continue;
        }
        let of_its_kernel: Vec<_> = points
            .iter()
            .filter(|((kernel, surface), roughness, _)| {
                *kernel == row.kernel && *surface == row.surface && *roughness == row.cell.roughness
            })
            .map(|&(.., point)| point)
            .collect();
        row.times.point_sampling_error = at_equal_time(&of_its_kernel, row.times.eval.median_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stride_meets_everything_once() {
        for count in [1, 2, 6, 64, 97, 512] {
            let stride = coprime_stride(count);
            let mut met: Vec<_> = (0..count).map(|number| number * stride % count).collect();
            met.sort_unstable();
            assert!(met.into_iter().eq(0..count), "{count}");
        }
    }
}
