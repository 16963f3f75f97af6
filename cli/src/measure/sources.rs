//! Where the error of binned normals comes from: sums that do one thing wrong at a time.

use super::asked::Group;
use super::stream::Stream;
use super::subject::{self, Patch};
use crate::report::document::ErrorSources;
use glintbake_bake::oracle::beckmann;
use glintbake_bake::oracle::flake_bins::{bin_of_normal, neighbourhood_holds};
use glintbake_format::model::{HalfVector, Method, Neighbourhood};

/// Half vectors of a footprint at most: each goes through all its texels.
const MOST: usize = 8;
/// Beyond so many roughnesses from a normal, on the disk, its lobe counts as nothing.
const REACH: f64 = 8.0;

/// Sums over queries of |D − D*| for each source, and of D*.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    queries: usize,
    truth: f64,
    differences: [f64; 6],
}

/// Whether any of `groups` is about binned flakes.
pub fn apply(groups: &[Group]) -> bool {
    groups
        .iter()
        .any(|group| group.truth.0.method() == Method::FlakeBins)
}

/// The sums under `patch` for Beckmann roughness `alpha`, over up to `count` half vectors drawn from the truth.
pub fn of(patch: &Patch<'_>, alpha: f64, count: usize, stream: &mut Stream) -> Sums {
    let subject = subject::find(Method::FlakeBins);
    let variant = &subject.variants(patch.filter)[0];
    let truth = subject.truth(variant, patch, alpha);
    let texels = texels(patch, alpha);
    let mut sums = Sums::default();
    for _ in 0..count.min(MOST) {
        let Some(h) = truth.draw(patch, stream.uniforms()) else {
            continue;
        };
        let found = densities(&texels, h, alpha);
        sums.queries += 1;
        sums.truth += found.truth;
        for (sum, density) in sums.differences.iter_mut().zip(found.wrong) {
            *sum += (density - found.truth).abs();
        }
    }
    sums
}

impl Sums {
    /// Adds those of other queries.
    pub fn add(&mut self, other: &Self) {
        self.queries += other.queries;
        self.truth += other.truth;
        for (sum, part) in self.differences.iter_mut().zip(other.differences) {
            *sum += part;
        }
    }

    /// The errors, for the report; `None` if nothing was lit.
    pub fn report(&self, roughness: f64, sigma: f64) -> Option<ErrorSources> {
        if self.truth <= 0.0 {
            return None;
        }
        let [
            centres,
            truncation_45,
            truncation_21,
            boundary,
            published,
            ours,
        ] = self.differences.map(|difference| difference / self.truth);
        Some(ErrorSources {
            roughness,
            sigma,
            queries: self.queries,
            centres,
            truncation_45,
            truncation_21,
            boundary,
            published,
            ours,
        })
    }
}

/// A texel under a footprint.
struct Texel {
    normal: HalfVector,
    centre: HalfVector,
    bin: (u32, u32),
    /// Exact.
    weight: f64,
    /// All or nothing, by the texel's middle, as a share of the footprint's area.
    by_middle: f64,
}

fn texels(patch: &Patch<'_>, alpha: f64) -> Vec<Texel> {
    let (width, height) = (patch.map.width(), patch.map.height());
    let size = [f64::from(width), f64::from(height)];
    let scale = |[u, v]: [f64; 2]| [u * size[0], v * size[1]];
    let [first, second] = [patch.footprint.edge_1, patch.footprint.edge_2].map(scale);
    let area = first[0] * second[1] - first[1] * second[0];
    let centre = scale(patch.footprint.centre);
    // How many copies of the texel on a repeating map have their middle under the footprint.
    let middles = |column: u32, row: u32| {
        let reach = [0, 1].map(|axis: usize| {
            (0.5 * (first[axis].abs() + second[axis].abs()) / size[axis]).ceil() as i64 + 1
        });
        let mut count = 0.0;
        for copy_v in -reach[1]..=reach[1] {
            for copy_u in -reach[0]..=reach[0] {
                let x = f64::from(column) + 0.5 + copy_u as f64 * size[0] - centre[0];
                let y = f64::from(row) + 0.5 + copy_v as f64 * size[1] - centre[1];
                let a = (x * second[1] - y * second[0]) / area;
                let b = (first[0] * y - first[1] * x) / area;
                if a.abs() <= 0.5 && b.abs() <= 0.5 {
                    count += 1.0;
                }
            }
        }
        count
    };
    patch
        .weights
        .iter()
        .map(|texel| {
            let index = texel.row as usize * width as usize + texel.column as usize;
            let [s, t] = patch.map.texels()[index].map(f64::from);
            let ([centre_s, centre_t], bin) = bin_of_normal([s, t], alpha);
            Texel {
                normal: HalfVector { s, t },
                centre: HalfVector {
                    s: centre_s,
                    t: centre_t,
                },
                bin,
                weight: texel.weight,
                by_middle: middles(texel.column, texel.row) / area.abs(),
            }
        })
        .collect()
}

struct Densities {
    truth: f64,
    /// In the order of [`ErrorSources`].
    wrong: [f64; 6],
}

fn densities(texels: &[Texel], h: HalfVector, alpha: f64) -> Densities {
    let direction = h.direction();
    let (_, bin) = bin_of_normal([h.s, h.t], alpha);
    let mut truth = 0.0;
    let mut wrong = [0.0; 6];
    // Lobes widen towards the rim, where the disk is foreshortened; blunt ones reach everywhere.
    let reach = if alpha < 0.05 { REACH * alpha } else { 2.0 };
    for texel in texels {
        let near = (texel.normal.s - h.s).abs() < reach && (texel.normal.t - h.t).abs() < reach;
        if !near {
            continue;
        }
        let own = beckmann(direction, texel.normal.direction(), alpha);
        let binned = beckmann(direction, texel.centre.direction(), alpha);
        let within =
            |neighbourhood| f64::from(u8::from(neighbourhood_holds(bin, texel.bin, neighbourhood)));
        let (in_45, in_21) = (within(Neighbourhood::Bins45), within(Neighbourhood::Bins21));
        truth += texel.weight * own;
        let terms = [
            texel.weight * binned,
            texel.weight * own * in_45,
            texel.weight * own * in_21,
            texel.by_middle * own,
            texel.by_middle * binned * in_21,
            texel.weight * binned * in_45,
        ];
        for (sum, term) in wrong.iter_mut().zip(terms) {
            *sum += term;
        }
    }
    Densities { truth, wrong }
}
