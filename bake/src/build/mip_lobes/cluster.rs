//! Clusters of lobes by position and normal.

use super::moments::Moments;
use crate::build::numbers::Numbers;

/// Most rounds of k-means; it settles in fewer, or changes little.
const ROUNDS: usize = 12;

/// The moments of at most `count` clusters of `lobes`, which lie in a cell of `side` texels; the lobes themselves if they are no
/// more. Seeded by k-means++ (Arthur and Vassilvitskii 2007) from `seed`, then by Lloyd's rounds; O(lobes × clusters).
///
/// A distance is that of positions in deviations of an evenly filled cell, and of normals in deviations of the cell's own, `normals` times:
/// with 1 both are in comparable units, and have about the same say.
pub(super) fn clusters(
    lobes: &[Moments],
    count: usize,
    side: f64,
    normals: f64,
    seed: u64,
) -> Vec<Moments> {
    if lobes.len() <= count {
        return lobes.to_vec();
    }
    let mut whole = Moments::default();
    for lobe in lobes {
        whole.add(lobe);
    }
    let position = 12_f64.sqrt() / side;
    let spread = whole.spread();
    let normal = if spread > 0.0 {
        normals * core::f64::consts::SQRT_2 / spread
    } else {
        0.0
    };
    let points: Vec<[f32; 4]> = lobes
        .iter()
        .map(|lobe| {
            let [x, y, s, t] = lobe.mean;
            [x * position, y * position, s * normal, t * normal].map(|x| x as f32)
        })
        .collect();
    let mut centres = seeds(&points, lobes, count, &mut Numbers::new(seed));
    let mut owners = vec![0_u32; points.len()];
    for round in 0..ROUNDS {
        let mut changed = false;
        for (owner, point) in owners.iter_mut().zip(&points) {
            let nearest = nearest(&centres, point);
            changed |= nearest != *owner || round == 0;
            *owner = nearest;
        }
        if !changed {
            break;
        }
        let mut sums = vec![([0.0_f64; 4], 0.0_f64); centres.len()];
        for ((&owner, point), lobe) in owners.iter().zip(&points).zip(lobes) {
            let (sum, weight) = &mut sums[owner as usize];
            for (sum, &x) in sum.iter_mut().zip(point) {
                *sum += lobe.weight * f64::from(x);
            }
            *weight += lobe.weight;
        }
        for (centre, (sum, weight)) in centres.iter_mut().zip(sums) {
            if weight > 0.0 {
                *centre = sum.map(|sum| (sum / weight) as f32);
            }
        }
    }
    let mut clusters = vec![Moments::default(); centres.len()];
    for (&owner, lobe) in owners.iter().zip(lobes) {
        clusters[owner as usize].add(lobe);
    }
    clusters.retain(|cluster| cluster.weight > 0.0);
    clusters
}

fn squared(a: &[f32; 4], b: &[f32; 4]) -> f32 {
    let d: [f32; 4] = core::array::from_fn(|k| a[k] - b[k]);
    (d[0] * d[0] + d[1] * d[1]) + (d[2] * d[2] + d[3] * d[3])
}

fn nearest(centres: &[[f32; 4]], point: &[f32; 4]) -> u32 {
    let mut best = (f32::INFINITY, 0);
    for (number, centre) in (0..).zip(centres) {
        let distance = squared(centre, point);
        if distance < best.0 {
            best = (distance, number);
        }
    }
    best.1
}

/// The first by weight, each next by weight and squared distance from the nearest so far.
fn seeds(
    points: &[[f32; 4]],
    lobes: &[Moments],
    count: usize,
    numbers: &mut Numbers,
) -> Vec<[f32; 4]> {
    let mut chances: Vec<f64> = lobes.iter().map(|lobe| lobe.weight).collect();
    let mut distances = vec![f32::INFINITY; points.len()];
    let mut centres = Vec::with_capacity(count);
    while centres.len() < count {
        let total: f64 = chances.iter().sum();
        if total <= 0.0 {
            // As many points as there are different ones.
            break;
        }
        let mut left = numbers.uniform() * total;
        let chosen = chances.iter().position(|chance| {
            left -= chance;
            left < 0.0
        });
        // Rounding may leave a little beyond the last that has a chance.
        let chosen = chosen
            .or_else(|| chances.iter().rposition(|&chance| chance > 0.0))
            .expect("one has a chance, as they add up to more than nothing");
        let centre = points[chosen];
        centres.push(centre);
        for (((distance, chance), point), lobe) in distances
            .iter_mut()
            .zip(&mut chances)
            .zip(points)
            .zip(lobes)
        {
            *distance = distance.min(squared(point, &centre));
            *chance = lobe.weight * f64::from(*distance);
        }
    }
    centres
}

/// Orders `clusters` so that those next to each other have normals alike: halves by the normals' longer extent, and so on down to
/// `run`s.
pub(super) fn order(clusters: &mut [Moments], run: usize) {
    if clusters.len() <= run {
        return;
    }
    let extent = |axis: usize| {
        let values = clusters.iter().map(|cluster| cluster.mean[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        values.fold(f64::NEG_INFINITY, f64::max) - low
    };
    let axis = if extent(2) >= extent(3) { 2 } else { 3 };
    clusters.sort_by(|a, b| a.mean[axis].total_cmp(&b.mean[axis]));
    let half = clusters.len().div_ceil(run).div_ceil(2) * run;
    let (left, right) = clusters.split_at_mut(half.min(clusters.len()));
    order(left, run);
    order(right, run);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::view::LobeNormal;

    fn grid(normal: impl Fn(u32) -> [f64; 2]) -> Vec<Moments> {
        (0..64)
            .map(|k| {
                let lobe = LobeNormal {
                    normal: normal(k),
                    slope: [0.0; 4],
                };
                Moments::of_lobe([f64::from(k % 8), f64::from(k / 8)], 0.2, &lobe)
            })
            .collect()
    }

    #[test]
    fn clusters_keep_weight_and_mean_of_all() {
        let lobes = grid(|k| [0.01 * f64::from(k % 5), -0.02 * f64::from(k % 7)]);
        let found = clusters(&lobes, 8, 8.0, 1.0, 3);
        assert_eq!(found.len(), 8);
        let sum = |all: &[Moments]| {
            let mut sum = Moments::default();
            all.iter().for_each(|one| sum.add(one));
            sum
        };
        let (all, some) = (sum(&lobes), sum(&found));
        assert_eq!(all.weight, some.weight);
        for (a, b) in all.mean.iter().zip(some.mean) {
            assert!((a - b).abs() < 1e-12);
        }
        for (a, b) in all.scatter.iter().zip(some.scatter) {
            assert!((a - b).abs() < 1e-9);
        }
    }

    #[test]
    fn what_differs_by_normal_alone_is_told_apart() {
        let lobes = grid(|k| if k % 2 == 0 { [0.4, 0.0] } else { [-0.4, 0.0] });
        for cluster in clusters(&lobes, 16, 8.0, 1.0, 1) {
            assert!((cluster.mean[2].abs() - 0.4).abs() < 1e-12, "{cluster:?}");
        }
    }

    #[test]
    fn as_many_as_differ_are_enough() {
        let lobe = LobeNormal {
            normal: [0.1, 0.2],
            slope: [0.0; 4],
        };
        let same = vec![Moments::of_lobe([1.0, 1.0], 0.2, &lobe); 40];
        let found = clusters(&same, 16, 8.0, 1.0, 1);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].weight, 40.0);
    }

    #[test]
    fn runs_have_normals_alike() {
        let mut lobes = grid(|k| [f64::from(k % 8) * 0.1, f64::from(k / 8) * 0.01]);
        order(&mut lobes, 16);
        for run in lobes.chunks(16) {
            let values = || run.iter().map(|lobe| lobe.mean[2]);
            let low = values().fold(f64::INFINITY, f64::min);
            let high = values().fold(f64::NEG_INFINITY, f64::max);
            assert!(high - low < 0.2, "{low} {high}");
        }
    }
}
