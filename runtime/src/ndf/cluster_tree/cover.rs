//! Which tiles a footprint meets: the coarsest that serve, down to those with leaves.

use super::lanes::Place;
use super::lobe::Lobe;
use super::region::{BoxRegion, GaussianRegion, Origin, Region};
use super::walk::{Sink, Walk};
use crate::error::QueryError;
use crate::overlap::{GaussianFootprint, Parallelogram, TexelBox};
use crate::scan::MapShape;
use glintbake_format::model::{ClusterLevel, ClusterTile};
use glintbake_format::view::ClusterTree;

/// A copy of the map, or of the plane if it is clamped.
#[derive(Clone, Copy, Debug)]
struct Copy {
    /// First texel.
    texel: [i64; 2],
}

/// What a tile is to a footprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tile {
    Outside,
    Inside,
    Cut,
}

/// Who is told of a tile: its level, itself, its first texel with copies counted on, and whether it is inside. Answers whether
/// that is all; else the tiles in it follow.
type Emit<'e> =
    dyn FnMut(&ClusterLevel, &ClusterTile, [i64; 2], bool) -> Result<bool, QueryError> + 'e;

/// Descends through the levels of tiles: `place` tells how a tile lies.
struct Descent<'c, 'a, P> {
    tree: &'c ClusterTree<'a>,
    place: P,
    /// The box around the footprint, in texels of the endless plane.
    bounds: TexelBox,
    /// Whether tiles that are cut may be coarse.
    cut_coarse: bool,
    copy: Copy,
}

impl<P: Fn(&ClusterTile, [i64; 2]) -> Tile> Descent<'_, '_, P> {
    /// Visits the tiles of `level` in the columns and rows of `range` that the footprint meets.
    fn visit(
        &self,
        number: u32,
        range: [[u32; 2]; 2],
        known_inside: bool,
        emit: &mut Emit<'_>,
    ) -> Result<(), QueryError> {
        let level = self.tree.level(number);
        let [[from_x, to_x], [from_y, to_y]] = self.clip(level, range);
        for row in from_y..to_y {
            for column in from_x..to_x {
                let tile = level.tile(column, row);
                let texel = [
                    self.copy.texel[0] + i64::from(tile.origin[0]),
                    self.copy.texel[1] + i64::from(tile.origin[1]),
                ];
                let place = if known_inside {
                    Tile::Inside
                } else {
                    (self.place)(&tile, texel)
                };
                let inside = place == Tile::Inside;
                if place == Tile::Outside {
                    continue;
                }
                let may_serve = number == 0 || inside || self.cut_coarse;
                if !(may_serve && emit(level, &tile, texel, inside)?) {
                    let finer = [[4 * column, 4 * column + 4], [4 * row, 4 * row + 4]];
                    self.visit(number - 1, finer, inside, emit)?;
                }
            }
        }
        Ok(())
    }

    /// The part of `range` that the bounds reach.
    fn clip(&self, level: &ClusterLevel, range: [[u32; 2]; 2]) -> [[u32; 2]; 2] {
        // Of a power of two.
        let share = 1.0 / f64::from(level.side);
        let axis = |low: f64, high: f64, copy: i64, [from, to]: [u32; 2], tiles: u32| {
            // Casts saturate.
            let first = ((low - copy as f64) * share - 1e-6) as u32;
            let last = ((high - copy as f64) * share + 1e-6) as u32;
            [from.max(first), to.min(tiles).min(last.saturating_add(1))]
        };
        let [columns, rows] = range;
        let TexelBox { low, high } = self.bounds;
        [
            axis(low[0], high[0], self.copy.texel[0], columns, level.tiles[0]),
            axis(low[1], high[1], self.copy.texel[1], rows, level.tiles[1]),
        ]
    }
}

/// The coarsest level of which a tile may lie in a box of `size` texels.
fn top(tree: &ClusterTree<'_>, size: [f64; 2]) -> u32 {
    let fits = |number: &u32| {
        let level = tree.level(*number);
        // A map smaller than a tile is one.
        let [width, height] = tree
            .layout
            .map_size()
            .map(|size| f64::from(size.min(level.side)));
        size[0] >= width && size[1] >= height
    };
    (1..tree.layout.levels()).rev().find(fits).unwrap_or(0)
}

const ALL: [[u32; 2]; 2] = [[0, u32::MAX]; 2];

fn offset([x, y]: [f64; 2]) -> [f32; 2] {
    [x as f32, y as f32]
}

/// Hands `walk` the tiles under the parallelogram of `region`, and what is inside as a whole.
#[inline(never)]
pub(super) fn under_box<L: Lobe, S: Sink>(
    shape: MapShape,
    tree: &ClusterTree<'_>,
    region: &BoxRegion<'_>,
    walk: &mut Walk<'_, BoxRegion<'_>, L, S>,
) -> Result<(), QueryError> {
    let footprint = region.footprint;
    let bounds = footprint.bounds();
    let size = [
        bounds.high[0] - bounds.low[0],
        bounds.high[1] - bounds.low[1],
    ];
    let number = top(tree, size);
    let whole = for_each_copy(shape, footprint, &mut |copy| {
        let descent = Descent {
            tree,
            bounds,
            cut_coarse: false,
            copy: Copy { texel: copy },
            place: |tile: &ClusterTile, texel: [i64; 2]| {
                let low = footprint.centred(texel[0] as f64, texel[1] as f64);
                let half = tile.size.map(|size| 0.5 * f64::from(size));
                let [outside, inside] = region.place(Place {
                    x: (low[0] + half[0]) as f32,
                    y: (low[1] + half[1]) as f32,
                    half_x: half[0] as f32,
                    half_y: half[1] as f32,
                });
                if outside > 0.0 {
                    Tile::Outside
                } else if inside <= 0.0 && region.outline.is_some() {
                    Tile::Inside
                } else {
                    Tile::Cut
                }
            },
        };
        descent.visit(number, ALL, false, &mut |level, tile, texel, inside| {
            let origin = Origin {
                texel,
                offset: offset(footprint.centred(texel[0] as f64, texel[1] as f64)),
            };
            walk.visit(level, tile, origin, inside, 1.0)
        })
    })?;
    if whole > 0 {
        whole_map(tree, whole as f32, walk)?;
    }
    walk.run()
}

/// Hands `walk` all tiles, each `copies` times.
pub(super) fn whole_map<R: Region, L: Lobe, S: Sink>(
    tree: &ClusterTree<'_>,
    copies: f32,
    walk: &mut Walk<'_, R, L, S>,
) -> Result<(), QueryError> {
    let [width, height] = tree.layout.map_size().map(f64::from);
    let descent = Descent {
        tree,
        bounds: TexelBox {
            low: [0.0; 2],
            high: [width, height],
        },
        cut_coarse: false,
        copy: Copy { texel: [0; 2] },
        place: |_: &ClusterTile, _: [i64; 2]| Tile::Inside,
    };
    let number = tree.layout.levels() - 1;
    descent.visit(number, ALL, true, &mut |level, tile, texel, _| {
        let origin = Origin {
            texel,
            offset: [0.0; 2],
        };
        walk.visit(level, tile, origin, true, copies)
    })
}

/// Calls `visit` with the first texel of each copy of the map that is cut by `footprint`; returns the number of those inside.
fn for_each_copy(
    shape: MapShape,
    footprint: &Parallelogram,
    visit: &mut dyn FnMut([i64; 2]) -> Result<(), QueryError>,
) -> Result<u64, QueryError> {
    if shape.wrap == glintbake_format::model::Wrap::Clamp || shape.holds(footprint) {
        visit([0; 2])?;
        return Ok(0);
    }
    let (width, height) = (f64::from(shape.width), f64::from(shape.height));
    let mut whole = 0_u64;
    for row in footprint.rows(height) {
        let span = footprint.row_span(row as f64, width, height);
        whole += span.inside.end.abs_diff(span.inside.start);
        for column in span.touched.clone() {
            if !span.inside.contains(&column) {
                visit([
                    column * i64::from(shape.width),
                    row * i64::from(shape.height),
                ])?;
            }
        }
    }
    Ok(whole)
}

/// Hands `walk` the tiles that the Gaussian of `region` reaches within `limit` of its exponent.
#[inline(never)]
pub(super) fn under_gaussian<L: Lobe, S: Sink>(
    shape: MapShape,
    tree: &ClusterTree<'_>,
    footprint: &GaussianFootprint,
    region: &GaussianRegion<'_>,
    limit: f32,
    walk: &mut Walk<'_, GaussianRegion<'_>, L, S>,
) -> Result<(), QueryError> {
    let radius = libm::sqrt(2.0 * f64::from(limit));
    let [xx, yy, _] = footprint.covariance();
    let reach = [
        radius * libm::sqrt(xx + 1.0) + 1.0,
        radius * libm::sqrt(yy + 1.0) + 1.0,
    ];
    let [x, y] = footprint.centred(0.0, 0.0).map(|x| -x);
    let bounds = TexelBox {
        low: [x - reach[0], y - reach[1]],
        high: [x + reach[0], y + reach[1]],
    };
    // A tile in which the Gaussian hardly bends may be taken by its clusters.
    let least = footprint.least_deviation();
    let number = (1..tree.layout.levels())
        .rev()
        .find(|&number| f64::from(tree.level(number).side) <= least)
        .unwrap_or(0);
    let size = [i64::from(shape.width), i64::from(shape.height)];
    let copies = |axis: usize| {
        let (low, high, size) = match axis {
            0 => (bounds.low[0], bounds.high[0], size[0]),
            _ => (bounds.low[1], bounds.high[1], size[1]),
        };
        if shape.wrap == glintbake_format::model::Wrap::Clamp {
            return 0..1;
        }
        let first = libm::floor(low / size as f64) as i64;
        first..libm::floor(high / size as f64) as i64 + 1
    };
    for row in copies(1) {
        for column in copies(0) {
            let copy = [column * size[0], row * size[1]];
            let relative = |texel: [i64; 2]| footprint.centred(texel[0] as f64, texel[1] as f64);
            let descent = Descent {
                tree,
                bounds,
                cut_coarse: true,
                copy: Copy { texel: copy },
                place: |tile: &ClusterTile, texel: [i64; 2]| {
                    let low = relative(texel);
                    let half = tile.size.map(|size| 0.5 * f64::from(size));
                    let middle = [low[0] + half[0], low[1] + half[1]];
                    if region.least(middle, half) > limit {
                        Tile::Outside
                    } else {
                        Tile::Cut
                    }
                },
            };
            descent.visit(number, ALL, false, &mut |level, tile, texel, _| {
                let origin = Origin {
                    texel,
                    offset: offset(relative(texel)),
                };
                walk.visit(level, tile, origin, false, 1.0)
            })?;
        }
    }
    walk.run()
}
