//! Copies of an example on a surface: where they lie, which hide which, and how much of each is seen.
//!
//! Where copies overlap, the one whose centre is nearest is seen. \[XTXW24\] §6.2 cuts the overlap of two in four and gives each
//! quarter to the nearer centre; point by point, the rule also holds where three or more overlap, and nothing is left to nobody.
//! What copy i loses to copy j is then convex: the part of i that is in j and nearer to the centre of j.

use super::polygon::{HalfPlane, Polygon};
use crate::error::BakeError;
use crate::noise::NoiseCopy;
use glintbake_format::records::NdfCopy;
use glintbake_format::view::MAX_NEIGHBOURS;
use rayon::prelude::*;
use zerocopy::little_endian::{I16, U16, U32};

/// Copies to a cell of the grid, about.
const TO_A_CELL: f64 = 2.0;

/// The most cells along a side of the grid.
const MOST_CELLS: u32 = 2048;

/// The least share of a copy, or of a tile of it, that counts as seen or hidden.
const LEAST_SHARE: f64 = 1e-6;

/// A copy as it is stored, in texels of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// In 2⁻³² of the surface.
    pub place: [u32; 2],
    pub centre: [f64; 2],
    /// In the unit.
    pub entries: [i16; 4],
    /// Rows of the transformation.
    pub matrix: [[f64; 2]; 2],
}

/// All copies of a surface.
#[derive(Debug)]
pub(super) struct Scattered {
    pub unit: f64,
    pub reach: f64,
    pub cells: u32,
    pub grid: Vec<U32>,
    pub placed: Vec<Placed>,
    pub records: Vec<NdfCopy>,
    pub neighbours: Vec<Vec<u32>>,
    /// The share of the surface that is covered.
    pub covered: f64,
    size: f64,
    side: f64,
}

/// The least power of two in which 15 bits hold all entries.
pub(super) fn unit_of(matrices: impl Iterator<Item = [[f64; 2]; 2]>) -> f64 {
    let greatest = matrices
        .flatten()
        .flatten()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut unit = 1.0 / 16384.0;
    while greatest > 32767.0 * unit {
        unit *= 2.0;
    }
    while unit > 1e-9 && greatest < 16383.0 * unit {
        unit *= 0.5;
    }
    unit
}

/// `copy` on a surface of `size` texels, in `unit`.
pub(super) fn place(copy: &NoiseCopy, size: f64, unit: f64) -> Placed {
    let place = copy.centre.map(|along| {
        let whole = libm::round(along * 4_294_967_296.0);
        // A centre of 1 is one of 0, on the next copy of the surface.
        whole as u64 as u32
    });
    let entries = [
        copy.matrix[0][0],
        copy.matrix[0][1],
        copy.matrix[1][0],
        copy.matrix[1][1],
    ]
    .map(|entry| libm::round(entry / unit) as i16);
    let [xx, xy, yx, yy] = entries.map(|entry| f64::from(entry) * unit);
    Placed {
        place,
        centre: place.map(|along| f64::from(along) * (size / 4_294_967_296.0)),
        entries,
        matrix: [[xx, xy], [yx, yy]],
    }
}

/// The farthest that a copy of an example of `side` texels reaches from its centre.
pub(super) fn reach(matrix: [[f64; 2]; 2], side: f64) -> f64 {
    let [[xx, xy], [yx, yy]] = matrix;
    let square = |x: f64, y: f64| x * x + y * y;
    0.5 * side
        * square(xx + xy, yx + yy)
            .max(square(xx - xy, yx - yy))
            .sqrt()
}

impl Scattered {
    /// `copies` of an example of `side` texels over a surface of `size`.
    ///
    /// # Errors
    /// [`BakeError::Option`] for copies larger than a quarter of the surface, or under more than 64 others.
    pub fn new(copies: &[NoiseCopy], side: u32, size: u32) -> Result<Self, BakeError> {
        let unit = unit_of(copies.iter().map(|copy| copy.matrix));
        let (side, surface) = (f64::from(side), f64::from(size));
        let mut placed: Vec<Placed> = copies
            .iter()
            .map(|copy| place(copy, surface, unit))
            .collect();
        let farthest = placed
            .iter()
            .map(|copy| reach(copy.matrix, side))
            .fold(0.0, f64::max);
        if farthest > 0.2499 * surface {
            return Err(refused(
                size,
                format!(
                    "a copy of the example reaches {farthest:.1} texels from its centre; the surface must be four times that: give at \
                     least {:.0}",
                    (farthest / 0.2499).ceil()
                ),
            ));
        }
        let side_of_grid = (placed.len() as f64 / TO_A_CELL).sqrt() as u32;
        let cells = side_of_grid.clamp(1, MOST_CELLS);
        let cell = |copy: &Placed| {
            let [x, y] = copy
                .place
                .map(|along| (u64::from(along) * u64::from(cells)) >> 32);
            (y * u64::from(cells) + x) as usize
        };
        let key = |copy: &Placed| (cell(copy), copy.place[1], copy.place[0], copy.entries);
        placed.sort_by_key(key);
        // Of two copies at one place neither were nearer: all but the first move by the least that is stored, until all differ.
        while placed.windows(2).any(|pair| pair[0].place == pair[1].place) {
            let mut moved = 0_u32;
            let mut last = None;
            for copy in &mut placed {
                moved = if last == Some(copy.place) {
                    moved + 1
                } else {
                    0
                };
                last = Some(copy.place);
                copy.place[1] = copy.place[1].wrapping_add(moved);
                copy.centre[1] = f64::from(copy.place[1]) * (surface / 4_294_967_296.0);
            }
            placed.sort_by_key(key);
        }
        let mut all = Self {
            unit,
            reach: farthest,
            cells,
            grid: Vec::new(),
            placed,
            records: Vec::new(),
            neighbours: Vec::new(),
            covered: 0.0,
            size: surface,
            side,
        };
        all.index();
        let seen: Vec<(Vec<u32>, f64)> = (0..all.placed.len())
            .into_par_iter()
            .map(|number| all.seen(number))
            .collect();
        all.keep(&seen)?;
        Ok(all)
    }

    /// Fills the grid from the places of copies, which are in order of their cells.
    fn index(&mut self) {
        let cells = u64::from(self.cells);
        let count = (cells * cells) as usize;
        let mut starts = vec![0_u32; count + 1];
        for copy in &self.placed {
            let [x, y] = copy.place.map(|along| (u64::from(along) * cells) >> 32);
            starts[(y * cells + x) as usize + 1] += 1;
        }
        for cell in 0..count {
            starts[cell + 1] += starts[cell];
        }
        self.grid = starts.into_iter().map(U32::new).collect();
    }

    /// From the centre of `from` to that of `to`, the shorter way around the surface.
    fn between(&self, from: &Placed, to: &Placed) -> [f64; 2] {
        [0, 1].map(|axis| {
            // Differences of whole numbers that wrap as the surface does.
            let difference = to.place[axis].wrapping_sub(from.place[axis]) as i32;
            f64::from(difference) * (self.size / 4_294_967_296.0)
        })
    }

    /// What `other` takes of `copy`, as half planes in texels of the surface from the centre of `copy`.
    fn taken(&self, copy: &Placed, other: &Placed) -> [HalfPlane; 5] {
        let [x, y] = self.between(copy, other);
        let [[xx, xy], [yx, yy]] = other.matrix;
        let determinant = xx * yy - xy * yx;
        let half = 0.5 * self.side;
        // Rows of the inverse: where in the example of `other` a point lies, from its middle.
        let rows = [
            [yy / determinant, -xy / determinant],
            [-yx / determinant, xx / determinant],
        ];
        // Within `half` of its middle on either side: `half - sign row · (p - c) > 0`.
        let bound = |row: [f64; 2], sign: f64| HalfPlane {
            constant: half + sign * (row[0] * x + row[1] * y),
            slope: row.map(|entry| -sign * entry),
        };
        [
            HalfPlane {
                constant: -0.5 * (x * x + y * y),
                slope: [x, y],
            },
            bound(rows[0], 1.0),
            bound(rows[0], -1.0),
            bound(rows[1], 1.0),
            bound(rows[1], -1.0),
        ]
    }

    /// The outline of the part of `copy` between `low` and `high`, in texels of the example, from its centre.
    fn outline(&self, copy: &Placed, low: [f64; 2], high: [f64; 2]) -> Polygon {
        let half = 0.5 * self.side;
        let [[xx, xy], [yx, yy]] = copy.matrix;
        let corner = |x: f64, y: f64| {
            let (x, y) = (x - half, y - half);
            [xx * x + xy * y, yx * x + yy * y]
        };
        Polygon(vec![
            corner(low[0], low[1]),
            corner(high[0], low[1]),
            corner(high[0], high[1]),
            corner(low[0], high[1]),
        ])
    }

    /// Which copies take something of copy `number`, and what share of it is left.
    fn seen(&self, number: usize) -> (Vec<u32>, f64) {
        let copy = &self.placed[number];
        let outline = self.outline(copy, [0.0; 2], [self.side; 2]);
        let area = outline.area();
        let mut pieces = vec![outline.clone()];
        let mut neighbours = Vec::new();
        let mut near = self.near(copy);
        near.sort_unstable();
        near.dedup();
        for other in near {
            if other as usize == number {
                continue;
            }
            let halves = self.taken(copy, &self.placed[other as usize]);
            let taken = halves
                .iter()
                .fold(outline.clone(), |part, half| part.cut(half));
            if taken.area() <= LEAST_SHARE * area {
                continue;
            }
            neighbours.push(other);
            pieces = pieces
                .iter()
                .flat_map(|piece| piece.without(&halves))
                .collect();
            if pieces.is_empty() {
                break;
            }
        }
        let left: f64 = pieces.iter().map(Polygon::area).sum();
        (neighbours, left / area)
    }

    /// The copies in cells that may reach `copy`.
    fn near(&self, copy: &Placed) -> Vec<u32> {
        let cells = i64::from(self.cells);
        let width = self.size / f64::from(self.cells);
        let span = reach(copy.matrix, self.side) + self.reach;
        let range = |axis: usize| {
            let first = ((copy.centre[axis] - span) / width).floor() as i64;
            let last = ((copy.centre[axis] + span) / width).floor() as i64;
            // No cell twice.
            first..=last.min(first + cells - 1)
        };
        let mut near = Vec::new();
        for row in range(1) {
            for column in range(0) {
                let cell = (row.rem_euclid(cells) * cells + column.rem_euclid(cells)) as usize;
                near.extend(self.grid[cell].get()..self.grid[cell + 1].get());
            }
        }
        near
    }

    /// Keeps the copies of which something is `seen`: what is wholly hidden hides nothing that others do not hide as well.
    fn keep(&mut self, seen: &[(Vec<u32>, f64)]) -> Result<(), BakeError> {
        const GONE: u32 = u32::MAX;
        let mut numbers = Vec::with_capacity(seen.len());
        let mut next = 0;
        for (_, share) in seen {
            let is_seen = *share > LEAST_SHARE;
            numbers.push(if is_seen { next } else { GONE });
            next += u32::from(is_seen);
        }
        let kept = |number: usize| numbers[number] != GONE;
        let mut covered = 0.0;
        let mut first = 0_u32;
        for (number, (neighbours, share)) in seen.iter().enumerate() {
            if !kept(number) {
                continue;
            }
            let copy = &self.placed[number];
            let left: Vec<u32> = neighbours
                .iter()
                .map(|&other| numbers[other as usize])
                .filter(|&other| other != GONE)
                .collect();
            if left.len() > MAX_NEIGHBOURS {
                return Err(refused(
                    self.size as u32,
                    format!(
                        "{} copies of the example lie over one, and {MAX_NEIGHBOURS} may; give a larger surface, or fewer or smaller copies",
                        left.len()
                    ),
                ));
            }
            covered += share * self.outline(copy, [0.0; 2], [self.side; 2]).area();
            self.records.push(NdfCopy {
                centre: copy.place.map(U32::new),
                matrix: copy.entries.map(I16::new),
                neighbours: U32::new(first),
                visible: U16::new(libm::round(share * 65535.0) as u16),
                reserved: [0; 2],
            });
            first += left.len() as u32;
            self.neighbours.push(left);
        }
        let mut number = 0;
        self.placed.retain(|_| {
            number += 1;
            kept(number - 1)
        });
        self.covered = (covered / (self.size * self.size)).min(1.0);
        self.index();
        Ok(())
    }

    /// The share of each of `tiles` × `tiles` tiles of copy `number` that is seen, row by row.
    pub fn tiles_seen(&self, number: usize, tiles: u32) -> Vec<f64> {
        let copy = &self.placed[number];
        let others: Vec<[HalfPlane; 5]> = self.neighbours[number]
            .iter()
            .map(|&other| self.taken(copy, &self.placed[other as usize]))
            .collect();
        let width = self.side / f64::from(tiles);
        (0..tiles * tiles)
            .map(|tile| {
                let low = [tile % tiles, tile / tiles].map(|along| f64::from(along) * width);
                let outline = self.outline(copy, low, low.map(|along| along + width));
                let area = outline.area();
                let mut pieces = vec![outline];
                for halves in &others {
                    pieces = pieces
                        .iter()
                        .flat_map(|piece| piece.without(halves))
                        .collect();
                }
                pieces.iter().map(Polygon::area).sum::<f64>() / area
            })
            .collect()
    }
}

fn refused(size: u32, reason: String) -> BakeError {
    BakeError::Option {
        option: "--size",
        value: size.to_string(),
        reason,
    }
}
