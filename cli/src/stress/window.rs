//! A square of a chart about the densest part of a distribution.

use super::numbers::Numbers;
use super::target::Target;
use crate::measure::subject::{Chart, Patch, Reference};
use glintbake_format::model::HalfVector;

/// Half vectors drawn to find the densest.
const DRAWN: usize = 64;
/// Share of the density at the middle that is left at the edge of a window wide enough.
const LEFT: f64 = 0.3;
/// How often a window is doubled at most.
const DOUBLINGS: u32 = 12;

/// A square part of a chart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    chart: Chart,
    low: [f64; 2],
    side: f64,
}

impl Window {
    /// The window `reach` units to each side of the densest of some half vectors that `model` draws, or wider until the
    /// density falls towards its edges. `None` if the model draws nothing.
    pub fn of(
        target: &Target<'_>,
        patch: &Patch<'_>,
        model: &dyn Reference,
        reach: f64,
        numbers: &mut Numbers,
    ) -> Option<Self> {
        let densest = (0..DRAWN)
            .filter_map(|_| model.draw(patch, numbers.four()))
            .map(|h| (model.pdf(h), h))
            .reduce(|best, next| if next.0 > best.0 { next } else { best })?;
        let (density, centre) = densest;
        let chart = target.subject.chart(target.variant, centre, target.alpha());
        let [x, y] = chart.point(centre)?;
        let mut reach = reach;
        for _ in 0..DOUBLINGS {
            let edges = [[reach, 0.0], [-reach, 0.0], [0.0, reach], [0.0, -reach]];
            let at_edges = edges.map(|[dx, dy]| {
                let place = chart.half_vector([x + dx, y + dy]);
                place.map_or(0.0, |(h, _)| model.pdf(h))
            });
            if at_edges.iter().any(|&edge| edge < LEFT * density) {
                break;
            }
            reach *= 2.0;
        }
        Some(Self {
            chart,
            low: [chart.snap(x - reach), chart.snap(y - reach)],
            side: 2.0 * reach,
        })
    }

    /// The middles of `side` × `side` squares with their solid angles, those below the horizon left out.
    pub fn nodes(&self, side: u32) -> impl Iterator<Item = (HalfVector, f64)> {
        let step = self.side / f64::from(side);
        let place = move |low: f64, x: u32| low + (f64::from(x) + 0.5) * step;
        let window = *self;
        (0..side * side).filter_map(move |node| {
            let point = [
                place(window.low[0], node % side),
                place(window.low[1], node / side),
            ];
            let (h, angle) = window.chart.half_vector(point)?;
            Some((h, angle * step * step))
        })
    }

    /// The row and column of `half_vector` among `cells` × `cells`, or `None` outside the window.
    pub fn cell(&self, half_vector: HalfVector, cells: u32) -> Option<[u32; 2]> {
        let point = self.chart.point(half_vector)?;
        let mut cell = [0; 2];
        for axis in 0..2 {
            let place = (point[axis] - self.low[axis]) / self.side * f64::from(cells);
            if !(0.0..f64::from(cells)).contains(&place) {
                return None;
            }
            cell[axis] = place as u32;
        }
        Some(cell)
    }

    /// The integral of the pdf of `model` over cell (`column`, `row`) of `cells` × `cells`, to a fifth of what chance moves
    /// the share of `draws` that fall there.
    pub fn mass(
        &self,
        [column, row]: [u32; 2],
        cells: u32,
        model: &dyn Reference,
        draws: f64,
    ) -> f64 {
        let step = self.side / f64::from(cells);
        let cell = Self {
            low: [
                self.low[0] + f64::from(column) * step,
                self.low[1] + f64::from(row) * step,
            ],
            side: step,
            ..*self
        };
        let integral = |nodes| -> f64 {
            let pdfs = cell.nodes(nodes).map(|(h, angle)| model.pdf(h) * angle);
            pdfs.sum()
        };
        let midpoints = integral(NODES);
        // Trapezoids have nodes on the edges of the cell, where a border may cut off less than midpoints see.
        if (cell.trapezoids(model) - midpoints).abs() <= 0.2 * (midpoints / draws).sqrt() {
            midpoints
        } else {
            integral(NODES_ACROSS_BORDERS)
        }
    }

    /// The integral of the pdf of `model` over the window by trapezoids.
    fn trapezoids(&self, model: &dyn Reference) -> f64 {
        let step = self.side / f64::from(NODES);
        let weight = |x| if x == 0 || x == NODES { 0.5 } else { 1.0 };
        let mut sum = 0.0;
        for row in 0..=NODES {
            for column in 0..=NODES {
                let point = [
                    self.low[0] + f64::from(column) * step,
                    self.low[1] + f64::from(row) * step,
                ];
                if let Some((h, angle)) = self.chart.half_vector(point) {
                    sum += model.pdf(h) * angle * weight(row) * weight(column);
                }
            }
        }
        sum * step * step
    }
}

/// Nodes on a side of a cell, for integrals.
const NODES: u32 = 4;
const NODES_ACROSS_BORDERS: u32 = 24;
