//! Blocks of lobes in as few bytes as their rounding allows.

use glintbake_format::model::LobeLattice;
use glintbake_format::records::{
    CurvedLobeBlock, CurvedWideLobeBlock, LobeBlock, LobeSlopes, WideLobeBlock, WideLobeSlopes,
};
use glintbake_format::view::{CellLobe, LobeNormal};
use zerocopy::little_endian::{F32, I16, U16};

/// The lobes of a block, row by row; `None` beyond the lattice.
pub(super) type Lobes = [Option<LobeNormal>; 16];

/// How far normals may be rounded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounding {
    /// Most that 16 bits may move a normal, of s and t together.
    pub most: f64,
    /// Most that merging may.
    pub merge: f64,
}

/// A block as it is stored.
pub(super) enum Block {
    Narrow(Box<CurvedLobeBlock>),
    Wide(Box<CurvedWideLobeBlock>),
    Merged,
}

/// The block of `lobes`, which the moments that are stored of it give as `cell`.
pub(super) fn encode(lobes: &Lobes, cell: &CellLobe, rounding: Rounding) -> Block {
    if lobes.iter().all(Option::is_some) && off_plane(lobes, cell) <= rounding.merge {
        return Block::Merged;
    }
    let block = narrow(lobes);
    if off(lobes, &block) <= rounding.most {
        Block::Narrow(Box::new(block))
    } else {
        Block::Wide(Box::new(wide(lobes)))
    }
}

/// How far a lobe is from `other`: its normal, and what its slope moves within one deviation of position.
fn distance(lobe: &LobeNormal, other: &LobeNormal) -> f64 {
    let length = |a: f64, b: f64| libm::sqrt(a * a + b * b);
    let [s, t] = [0, 1].map(|axis| lobe.normal[axis] - other.normal[axis]);
    let squared: f64 = lobe
        .slope
        .iter()
        .zip(other.slope)
        .map(|(a, b)| (a - b) * (a - b))
        .sum();
    length(s, t) + LobeLattice::DEVIATION * libm::sqrt(squared)
}

fn greatest(lobes: &Lobes, stored: impl Fn(usize, &LobeNormal) -> LobeNormal) -> f64 {
    lobes
        .iter()
        .enumerate()
        .filter_map(|(number, lobe)| lobe.map(|lobe| distance(&lobe, &stored(number, &lobe))))
        .fold(0.0, f64::max)
}

/// How far lobes are from those of the plane of `cell`. Flat ones stay flat.
fn off_plane(lobes: &Lobes, cell: &CellLobe) -> f64 {
    let is_flat = lobes
        .iter()
        .flatten()
        .all(|lobe| lobe.slope.iter().all(|&slope| slope == 0.0));
    greatest(lobes, |number, _| {
        let [x, y] = place(number);
        let lobe = cell.lobe.at(x, y);
        if is_flat {
            LobeNormal {
                slope: [0.0; 4],
                ..lobe
            }
        } else {
            lobe
        }
    })
}

/// How far 16 bits are.
fn off(lobes: &Lobes, block: &CurvedLobeBlock) -> f64 {
    greatest(lobes, |number, _| {
        let slopes = Some(&block.slopes);
        block
            .normals
            .lobe(slopes, number)
            .expect("a block has 16 lobes")
    })
}

/// ∂s/∂x, ∂s/∂y, ∂t/∂x and ∂t/∂y of the plane through the normals of a whole block, by least squares; none of one that is not whole.
fn plane(lobes: &Lobes) -> [f32; 4] {
    /// The sum of x² over the block.
    const SQUARES: f64 = 20.0;
    let mut sums = [0.0; 4];
    for (number, lobe) in lobes.iter().enumerate() {
        let Some(lobe) = lobe else { return [0.0; 4] };
        let [x, y] = place(number);
        let [s, t] = lobe.normal;
        for (sum, more) in sums.iter_mut().zip([s * x, s * y, t * x, t * y]) {
            *sum += more;
        }
    }
    sums.map(|sum| (sum / SQUARES) as f32)
}

/// Where lobe `number` is, from the middle of its block.
fn place(number: usize) -> [f64; 2] {
    [(number % 4) as f64 - 1.5, (number / 4) as f64 - 1.5]
}

fn narrow(lobes: &Lobes) -> CurvedLobeBlock {
    let plane = plane(lobes);
    let beside = |number: usize, lobe: &LobeNormal, axis: usize| {
        let [x, y] = place(number);
        let along = f64::from(plane[2 * axis]) * x + f64::from(plane[2 * axis + 1]) * y;
        lobe.normal[axis] - along
    };
    let there = || lobes.iter().flatten();
    let fold = |axis: usize, pick: fn(f64, f64) -> f64, start| {
        lobes
            .iter()
            .enumerate()
            .filter_map(|(number, lobe)| lobe.map(|lobe| beside(number, &lobe, axis)))
            .fold(start, pick)
    };
    let low = [0, 1].map(|axis| (fold(axis, f64::min, f64::INFINITY) as f32).next_down());
    let step = [0, 1].map(|axis| {
        let side = fold(axis, f64::max, f64::NEG_INFINITY) - f64::from(low[axis]);
        ((side / 65535.0) as f32).next_up()
    });
    let steepest = there()
        .flat_map(|lobe| lobe.slope)
        .fold(0.0, |most: f64, slope| most.max(slope.abs()));
    let slope_step = if steepest > 0.0 {
        ((steepest / 32767.0) as f32).next_up()
    } else {
        0.0
    };
    let mut block = LobeBlock {
        low: low.map(F32::new),
        step: step.map(F32::new),
        slope_step: F32::new(slope_step),
        plane: plane.map(F32::new),
        s: [U16::ZERO; 16],
        t: [U16::ZERO; 16],
    };
    let mut slopes = LobeSlopes {
        s_x: [I16::ZERO; 16],
        s_y: [I16::ZERO; 16],
        t_x: [I16::ZERO; 16],
        t_y: [I16::ZERO; 16],
    };
    for (number, lobe) in lobes.iter().enumerate() {
        let Some(lobe) = lobe else { continue };
        let units = |axis: usize| {
            let part = (beside(number, lobe, axis) - f64::from(low[axis])) / f64::from(step[axis]);
            U16::new(part.round().clamp(0.0, 65535.0) as u16)
        };
        block.s[number] = units(0);
        block.t[number] = units(1);
        if slope_step > 0.0 {
            let [s_x, s_y, t_x, t_y] = lobe
                .slope
                .map(|slope| I16::new((slope / f64::from(slope_step)).round() as i16));
            slopes.s_x[number] = s_x;
            slopes.s_y[number] = s_y;
            slopes.t_x[number] = t_x;
            slopes.t_y[number] = t_y;
        }
    }
    CurvedLobeBlock {
        normals: block,
        slopes,
    }
}

fn wide(lobes: &Lobes) -> CurvedWideLobeBlock {
    let lanes = |of: fn(&LobeNormal) -> f64| {
        core::array::from_fn(|number| F32::new(lobes[number].map_or(0.0, |lobe| of(&lobe) as f32)))
    };
    let block = WideLobeBlock {
        s: lanes(|lobe| lobe.normal[0]),
        t: lanes(|lobe| lobe.normal[1]),
    };
    let slopes = WideLobeSlopes {
        s_x: lanes(|lobe| lobe.slope[0]),
        s_y: lanes(|lobe| lobe.slope[1]),
        t_x: lanes(|lobe| lobe.slope[2]),
        t_y: lanes(|lobe| lobe.slope[3]),
    };
    CurvedWideLobeBlock {
        normals: block,
        slopes,
    }
}
