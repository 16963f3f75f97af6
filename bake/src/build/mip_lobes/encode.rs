//! Clustered lobes as they are stored.

use super::cluster::order;
use super::moments::{ClusteredLobe, Moments};
use glintbake_format::model::MIP_LANES;
use glintbake_format::records::MipBlock;
use zerocopy::little_endian::{F32, I16, U16};

/// What a cell's weights add up to.
const WHOLE: f64 = 65535.0;

/// The `count` blocks of a cell of `side` texels that has `clusters`, which are not more than fit and are not none.
pub(super) fn blocks(clusters: &mut [Moments], side: f64, count: usize) -> Vec<MipBlock> {
    order(clusters, MIP_LANES);
    let weights = shares(clusters);
    (0..count)
        .map(|number| {
            let first = (number * MIP_LANES).min(clusters.len());
            let last = (first + MIP_LANES).min(clusters.len());
            let lobes: Vec<ClusteredLobe> =
                clusters[first..last].iter().map(Moments::lobe).collect();
            let spread = clusters[first..last]
                .iter()
                .map(Moments::spread)
                .fold(0.0, f64::max);
            block(&lobes, &weights[first..last], side, spread)
        })
        .collect()
}

/// Shares of 65535 by weight that add up to it, the largest remainders rounded up.
fn shares(clusters: &[Moments]) -> Vec<u16> {
    let total: f64 = clusters.iter().map(|cluster| cluster.weight).sum();
    let exact: Vec<f64> = clusters
        .iter()
        .map(|cluster| cluster.weight / total * WHOLE)
        .collect();
    let mut shares: Vec<u16> = exact.iter().map(|share| share.floor() as u16).collect();
    let sum: u32 = shares.iter().map(|&share| u32::from(share)).sum();
    let mut places: Vec<usize> = (0..shares.len()).collect();
    places.sort_by(|&a, &b| {
        let rest = |place: usize| exact[place] - exact[place].floor();
        rest(b).total_cmp(&rest(a)).then(a.cmp(&b))
    });
    for &place in places.iter().cycle().take(65535 - sum as usize) {
        shares[place] += 1;
    }
    shares
}

/// The greatest of `|x|`, over 32767, rounded up to an f32; 0 for none.
fn signed_step(values: impl Iterator<Item = f64>) -> f32 {
    let most = values.map(f64::abs).fold(0.0, f64::max);
    ((most / 32767.0) as f32).next_up() * f32::from(u8::from(most > 0.0))
}

fn block(lobes: &[ClusteredLobe], weights: &[u16], side: f64, spread: f64) -> MipBlock {
    let range = |axis: usize| {
        let values = lobes.iter().map(|lobe| lobe.normal[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return (0.0, 0.0);
        }
        let low = (low as f32).next_down();
        let step = ((high - f64::from(low)) / 65535.0) as f32;
        (low, step.next_up())
    };
    let ranges = [range(0), range(1)];
    let slope_step = signed_step(lobes.iter().flat_map(|lobe| lobe.slope));
    let residual_step = signed_step(lobes.iter().flat_map(|lobe| lobe.residual));
    let unsigned =
        |value: f64, unit: f64| U16::new((value / unit).round().clamp(0.0, WHOLE) as u16);
    let signed = |value: f64, unit: f64| {
        let number = if unit > 0.0 { value / unit } else { 0.0 };
        I16::new(number.round().clamp(-32767.0, 32767.0) as i16)
    };
    let lanes = |get: &dyn Fn(&ClusteredLobe) -> U16| {
        core::array::from_fn(|lane| lobes.get(lane).map_or(U16::ZERO, get))
    };
    let signed_lanes = |get: &dyn Fn(&ClusteredLobe) -> f64, unit: f32| {
        let unit = f64::from(unit);
        core::array::from_fn(|lane| {
            lobes
                .get(lane)
                .map_or(I16::ZERO, |lobe| signed(get(lobe), unit))
        })
    };
    let normal = |axis: usize| {
        let (low, step) = ranges[axis];
        lanes(&|lobe| unsigned(lobe.normal[axis] - f64::from(low), f64::from(step)))
    };
    // No lobe is so narrow that it has no width.
    let width = |value: f64| unsigned(value, 0.5 * side / WHOLE).max(U16::new(1));
    MipBlock {
        low: ranges.map(|(low, _)| F32::new(low)),
        step: ranges.map(|(_, step)| F32::new(step)),
        slope_step: F32::new(slope_step),
        residual_step: F32::new(residual_step),
        spread: F32::new((spread as f32).next_up()),
        reserved: [0; 4],
        weight: core::array::from_fn(|lane| {
            U16::new(weights.get(lane).copied().unwrap_or_default())
        }),
        x: lanes(&|lobe| unsigned(lobe.position[0], side / WHOLE)),
        y: lanes(&|lobe| unsigned(lobe.position[1], side / WHOLE)),
        l_11: lanes(&|lobe| width(lobe.factor[0])),
        l_21: signed_lanes(&|lobe| lobe.factor[1], (0.5 * side / 32767.0) as f32),
        l_22: lanes(&|lobe| width(lobe.factor[2])),
        s: normal(0),
        t: normal(1),
        s_x: signed_lanes(&|lobe| lobe.slope[0], slope_step),
        s_y: signed_lanes(&|lobe| lobe.slope[1], slope_step),
        t_x: signed_lanes(&|lobe| lobe.slope[2], slope_step),
        t_y: signed_lanes(&|lobe| lobe.slope[3], slope_step),
        m_11: signed_lanes(&|lobe| lobe.residual[0], residual_step),
        m_21: signed_lanes(&|lobe| lobe.residual[1], residual_step),
        m_22: signed_lanes(&|lobe| lobe.residual[2], residual_step),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::view::LobeNormal;

    #[test]
    fn shares_add_up_for_any_weights() {
        for count in 1..70_u32 {
            let clusters: Vec<Moments> = (0..count)
                .map(|k| Moments {
                    weight: f64::from(1 + (k * 7919) % 13),
                    ..Moments::default()
                })
                .collect();
            let sum: u32 = shares(&clusters).into_iter().map(u32::from).sum();
            assert_eq!(sum, 65535, "{count}");
        }
    }

    #[test]
    fn lobes_are_stored_within_their_units() {
        let mut clusters: Vec<Moments> = (0..20)
            .map(|k| {
                let x = f64::from(k);
                let lobe = LobeNormal {
                    normal: [0.04 * x - 0.4, 0.3 - 0.02 * x],
                    slope: [0.1, -0.02 * x, 0.0, 0.03],
                };
                Moments::of_lobe([x * 0.4, 8.0 - x * 0.4], 0.18, &lobe)
            })
            .collect();
        let blocks = blocks(&mut clusters, 8.0, 2);
        assert_eq!(blocks.len(), 2);
        for (number, cluster) in clusters.iter().enumerate() {
            let block = &blocks[number / MIP_LANES];
            let lane = number % MIP_LANES;
            let lobe = cluster.lobe();
            let near = |found: f64, expected: f64, unit: f64| {
                assert!(
                    (found - expected).abs() <= 0.51 * unit,
                    "{found} {expected}"
                );
            };
            let unit = 8.0 / WHOLE;
            near(
                f64::from(block.x[lane].get()) * unit,
                lobe.position[0],
                unit,
            );
            near(
                f64::from(block.y[lane].get()) * unit,
                lobe.position[1],
                unit,
            );
            near(
                f64::from(block.l_11[lane].get()) * unit / 2.0,
                lobe.factor[0],
                unit / 2.0,
            );
            for axis in 0..2 {
                let step = f64::from(block.step[axis].get());
                let stored = [block.s, block.t][axis][lane].get();
                let found = f64::from(block.low[axis].get()) + step * f64::from(stored);
                near(found, lobe.normal[axis], step);
            }
            let step = f64::from(block.slope_step.get());
            near(f64::from(block.s_y[lane].get()) * step, lobe.slope[1], step);
        }
        // What is not there weighs nothing.
        assert_eq!(blocks[1].weight[4..], [U16::ZERO; 12]);
    }
}
