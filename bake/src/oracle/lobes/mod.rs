//! The plain sum over 4D Gaussian lobes of position and normal \[YHMR16\] \[TZX22\].
//!
//! With `A = σh² I`, the footprint's covariance Σp, `S = A + Σp`, `K = A S⁻¹` and `Q = A S⁻¹ Σp`, all in texels, a lobe
//! at `u_i` with the normal `s_i` and the slope `J_i` adds
//!
//! `w N(u_p; u_i, S) N(s; s_i + J_i K (u_p - u_i), σr² I + J_i Q J_iᵀ)`
//!
//! to `D(s)`, w being the square of the lobes' spacing. The raw sum is the papers'; normalised, it is divided by
//! `Σ_i w N(u_p; u_i, S)` over the endless lattice. Terms are visited one by one, all copies of the map included.
//!
//! *Copies of wide footprints.* Over the copies of a lobe along a direction, u and s are jointly Gaussian, and the sum
//! over evenly spaced u is its integral but for waves of `2 exp(-2π² σ²)`, σ the deviation of u along that direction
//! *given s*, in tiles. Given s, u varies at least as Σp does: its covariance is then
//! `S - A Jᵀ (σr² I + J A Jᵀ)⁻¹ J A`, which is at least `S - A = Σp`. So where Σp is at least 1.5 tiles wide in every
//! direction, all lobes weigh alike, with A in the place of Q and no shift, to 1e-19 of each term:
//! `Q + K S Kᵀ = A`. Where only the deviation along one axis given the other is that wide, the copies along that axis
//! are integrated, and `A - A e eᵀ A / S_ee` takes the place of Q, `A e eᵀ / S_ee` that of K, e being the other axis.

pub(super) mod lattice;
pub(super) mod position;
pub(super) mod spread;

use super::direction::half_vector_direction;
use super::double_double::DoubleDouble;
use super::texel_axis::TexelAxis;
use super::weights::MAX_SPAN_TILES;
use crate::normals::NormalMap;
use core::f64::consts::PI;
use core::ops::RangeInclusive;
use glintbake_format::model::{Footprint, HalfVector, LobeLattice, Wrap};
use lattice::{Seed, seed};
use position::Position;
use spread::Spread;
use std::collections::{BTreeMap, HashMap};

/// Standard deviations of S beyond which a lobe counts as nothing: 6e-13 of the footprint.
const REACH: f64 = 7.5;

/// Deviation in tiles from which the copies along a direction are integrated.
const EVEN_TILES: f64 = 1.5;

/// A lobe, or several of the same normal, under one footprint.
#[derive(Clone, Copy, Debug)]
struct Term {
    weight: f64,
    /// `s_i + J_i K (u_p - u_i)`.
    mean: [f64; 2],
    /// Which of the spreads `J_i Q J_iᵀ`.
    spread: usize,
}

/// The lobes under one footprint, for many half vectors and roughnesses.
#[derive(Clone, Debug)]
pub struct Prepared {
    terms: Vec<Term>,
    /// The spreads of all lobes; the first is that of flat ones.
    spreads: Vec<Spread>,
    total: f64,
}

impl Prepared {
    /// Every lobe of `lattice` within 7.5 standard deviations of the Gaussian `footprint`, the sum divided by that of all
    /// weights if `normalised`.
    ///
    /// # Accuracy
    /// Terms are right to about 1e-13 of the largest, and those left out add up to 6e-13, for any footprint, also points, lines and needles, and any slope.
    ///
    /// # Cost
    /// Proportional to the lobes visited: those of the map within reach, with all copies unless the footprint is wide
    /// (see the module); beyond the border of a clamped map a row of lobes costs at most as much as 300.
    ///
    /// # Panics
    /// If a number of the footprint is not finite, the sum of its edges on an axis exceeds half of
    /// [`MAX_SPAN_TILES`], or the lattice has neither one nor two lobes a side of a texel.
    pub fn new(
        map: &NormalMap,
        footprint: &Footprint,
        lattice: LobeLattice,
        normalised: bool,
    ) -> Self {
        Self::with_even_tiles(map, footprint, lattice, normalised, EVEN_TILES)
    }

    /// As [`Self::new`], with the copies along a direction integrated from a deviation of `even_tiles` tiles.
    pub(super) fn with_even_tiles(
        map: &NormalMap,
        footprint: &Footprint,
        lattice: LobeLattice,
        normalised: bool,
        even_tiles: f64,
    ) -> Self {
        let Footprint {
            centre,
            edge_1,
            edge_2,
        } = *footprint;
        for axis in 0..2 {
            let span = edge_1[axis].abs() + edge_2[axis].abs();
            assert!(
                centre[axis].is_finite() && span <= 0.5 * MAX_SPAN_TILES,
                "a Gaussian footprint must be finite and span at most {} tiles",
                0.5 * MAX_SPAN_TILES
            );
        }
        let axis =
            |i: usize, size| TexelAxis::new(centre[i], [edge_1[i], edge_2[i]], size, map.wrap());
        let axes = [axis(0, map.width()), axis(1, map.height())];
        let half = |edge: usize| [0, 1].map(|i: usize| axes[i].edges()[edge].half());
        let spacing = 1.0 / f64::from(lattice.per_side);
        let gather = Gather {
            map,
            lattice,
            count: lattice.size(map.width(), map.height()).map(i64::from),
            spacing,
            position: Position::new(LobeLattice::DEVIATION * spacing, [half(0), half(1)]),
            axes,
            flat: BTreeMap::new(),
            terms: Vec::new(),
            spreads: vec![Spread::default()],
            known: HashMap::new(),
        };
        let mut prepared = gather.run(even_tiles);
        let sum = |sum: DoubleDouble, term: &Term| sum + DoubleDouble::from(term.weight);
        prepared.total = prepared.terms.iter().fold(DoubleDouble::ZERO, sum).value();
        if normalised {
            for term in &mut prepared.terms {
                term.weight /= prepared.total;
            }
        }
        prepared
    }

    /// The sum of all weights before any division, `Σ_i w N(u_p; u_i, S)`: 1 but for the lattice's ripple.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// How many terms are summed: copies of flat lobes are one.
    pub fn terms(&self) -> usize {
        self.terms.len()
    }

    /// Density `D(h)` for Beckmann roughness `alpha` (σr = α / √2), per solid angle of h, which is that per area of the
    /// disk; 0 outside the closed unit disk.
    pub fn ndf(&self, h: HalfVector, alpha: f64) -> f64 {
        if half_vector_direction(h).is_none() {
            return 0.0;
        }
        let variance = 0.5 * alpha * alpha;
        let add = |sum: DoubleDouble, term: &Term| {
            let d = [h.s - term.mean[0], h.t - term.mean[1]];
            let density = self.spreads[term.spread].density(d, variance);
            sum + DoubleDouble::product(term.weight, density)
        };
        self.terms.iter().fold(DoubleDouble::ZERO, add).value()
    }

    /// Density per solid angle of h of a sampler that draws a lobe, then a normal from it, and gives no vector beyond
    /// the rim: `D(h) (h·n)`.
    pub fn pdf(&self, h: HalfVector, alpha: f64) -> f64 {
        half_vector_direction(h).map_or(0.0, |[.., cosine]| self.ndf(h, alpha) * cosine)
    }

    /// What that sampler makes of four numbers in [0, 1): a lobe by its weight from the first, its normal from the last two;
    /// `None` beyond the rim. The density is [`pdf`](Self::pdf) if the sum is normalised, else that over [`total`](Self::total).
    pub fn draw(&self, alpha: f64, uniform: [f64; 4]) -> Option<HalfVector> {
        let weights = self.terms.iter().map(|term| term.weight);
        let mut left = uniform[0] * weights.sum::<f64>();
        // Rounding may leave a little beyond the last lobe, which then takes it.
        let chosen = self.terms.iter().find(|term| {
            left -= term.weight;
            left < 0.0
        });
        let term = chosen.or(self.terms.last())?;
        let radius = libm::sqrt(-2.0 * libm::log1p(-uniform[2]));
        let (sine, cosine) = libm::sincos(2.0 * PI * uniform[3]);
        let [first, across, second] = self.spreads[term.spread].root(0.5 * alpha * alpha);
        let h = HalfVector {
            s: term.mean[0] + radius * first * cosine,
            t: term.mean[1] + radius * (across * cosine + second * sine),
        };
        half_vector_direction(h).map(|_| h)
    }
}

/// Lobes as they are found.
struct Gather<'a> {
    map: &'a NormalMap,
    lattice: LobeLattice,
    /// Columns and rows of the lattice.
    count: [i64; 2],
    /// Texels between lobes.
    spacing: f64,
    position: Position,
    axes: [TexelAxis; 2],
    /// Weight of each flat lobe, all copies together, by (row, column).
    flat: BTreeMap<(i64, i64), DoubleDouble>,
    terms: Vec<Term>,
    spreads: Vec<Spread>,
    /// What the copies of a lobe have in common, by (row, column).
    known: HashMap<(i64, i64), (Seed, Option<usize>)>,
}

impl Gather<'_> {
    fn run(mut self, even_tiles: f64) -> Prepared {
        let tile = [self.map.width(), self.map.height()].map(f64::from);
        let repeats = self.map.wrap() == Wrap::Repeat;
        let wide = |axis: usize| {
            repeats && self.position.footprint_conditional(1 - axis) >= even_tiles * tile[axis]
        };
        let deviations = [0, 1].map(|axis| self.position.footprint_variance(axis));
        if repeats && self.position.least_footprint_deviation(tile) >= even_tiles {
            self.add_all();
        } else if wide(0) && (deviations[0] >= deviations[1] || !wide(1)) {
            self.add_lines(1);
        } else if wide(1) {
            self.add_lines(0);
        } else {
            self.add_rows();
        }
        for (&(row, column), weight) in &self.flat {
            self.terms.push(Term {
                weight: weight.value(),
                mean: seed(self.map, self.lattice, column, row).normal,
                spread: 0,
            });
        }
        Prepared {
            terms: self.terms,
            spreads: self.spreads,
            total: 0.0,
        }
    }

    /// Where lobe `index` of an axis is, from the footprint's centre.
    fn place(&self, axis: usize, index: i64) -> DoubleDouble {
        let per_side = i64::from(self.lattice.per_side);
        let part = (index.rem_euclid(per_side) as f64 + 0.5) * self.spacing;
        self.axes[axis].border(index.div_euclid(per_side)) + DoubleDouble::from(part)
    }

    /// The lobes between two distances from the footprint's centre, and a few more.
    fn lobes_between(&self, axis: usize, from: f64, to: f64) -> RangeInclusive<i64> {
        let per_side = i64::from(self.lattice.per_side);
        let texel = |place| self.axes[axis].texel_at(place);
        (texel(from) - 1) * per_side..=(texel(to) + 2) * per_side
    }

    /// Every lobe of the map alike.
    fn add_all(&mut self) {
        let weight = 1.0 / (self.count[0] * self.count[1]) as f64;
        let deviation = libm::sqrt(self.position.lobe());
        let columns = [[deviation, 0.0], [0.0, deviation], [0.0; 2], [0.0; 2]];
        let determinant = self.position.lobe() * self.position.lobe();
        for row in 0..self.count[1] {
            for column in 0..self.count[0] {
                self.add([column, row], weight, [0.0; 2], (columns, determinant));
            }
        }
    }

    /// Every lobe within reach along `axis`, its copies along the other axis integrated.
    fn add_lines(&mut self, axis: usize) {
        let other = 1 - axis;
        let lobe = self.position.lobe();
        let variance = self.position.variances()[axis];
        let rest = lobe * self.position.footprint_variance(axis) / variance;
        let mut columns = [[0.0; 2]; 4];
        columns[0][other] = libm::sqrt(lobe);
        columns[1][axis] = libm::sqrt(rest);
        let reach = REACH * libm::sqrt(variance);
        for line in self.lobes_between(axis, -reach, reach) {
            let d = -self.place(axis, line).value();
            // Lobes are `spacing` apart along this axis, and `count` of them share the other.
            let weight = self.spacing * libm::exp(-0.5 * d * d / variance)
                / (libm::sqrt(2.0 * PI * variance) * self.count[other] as f64);
            let mut look = [0.0; 2];
            look[axis] = lobe * d / variance;
            for index in 0..self.count[other] {
                let mut at = [line; 2];
                at[other] = index;
                self.add(at, weight, look, (columns, lobe * rest));
            }
        }
    }

    /// Every lobe within reach, row by row.
    fn add_rows(&mut self) {
        let seen = self.position.seen();
        let clamped = self.map.wrap() == Wrap::Clamp;
        let reach = REACH * libm::sqrt(self.position.variances()[1]);
        let margin = REACH * self.position.row_deviation();
        for row in self.lobes_between(1, -reach, reach) {
            let y = self.place(1, row);
            let middle = self.position.middle(y).value();
            let columns = self.lobes_between(0, middle - margin, middle + margin);
            let (mut first, mut last) = (*columns.start(), *columns.end());
            if clamped {
                let end = self.count[0] - 1;
                let outside = [(last.min(-1), -1, first), (first.max(end + 1), 1, last)];
                for (from, step, to) in outside {
                    let weight = self.half_row(row, from, step, to);
                    self.add_flat([from, row], weight);
                }
                (first, last) = (first.max(0), last.min(end));
            }
            for column in first..=last {
                let d = [-self.place(0, column), -y];
                let weight = self.spacing * self.spacing * self.position.density(d);
                if weight > 0.0 {
                    self.add([column, row], weight, self.position.look(d), seen);
                }
            }
        }
    }

    /// The weight of lobes `from`, `from + step` .. of a row: up to `to`, or all that are left where they are many.
    ///
    /// With a spacing of δ ≤ 1/16 standard deviation Euler and Maclaurin's sum up to the seventh derivative is right to
    /// 1e-16: `Σ_{j≥0} f(j) = ∫ f + f(0)/2 - f'(0)/12 + f'''(0)/720 - f⁗'(0)/30240 + f⁗'''(0)/1209600 - …`.
    fn half_row(&self, row: i64, from: i64, step: i64, to: i64) -> f64 {
        if (to - from) * step < 0 {
            return 0.0;
        }
        let y = self.place(1, row);
        let at = |column: i64| {
            let d = [-self.place(0, column), -y];
            self.spacing * self.spacing * self.position.density(d)
        };
        let deviation = self.position.row_deviation();
        let delta = self.spacing / deviation;
        if delta > 1.0 / 16.0 {
            return (0..=(to - from) * step).map(|j| at(from + step * j)).sum();
        }
        // The distance from the row's own middle in deviations, growing along the lobes.
        let variance = self.position.variances()[1];
        let z = (self.place(0, from) - self.position.middle(y)).value() / deviation * step as f64;
        let yy = y.value();
        let rowwise = libm::exp(-0.5 * yy * yy / variance) / libm::sqrt(2.0 * PI * variance);
        let bell = libm::exp(-0.5 * z * z) / libm::sqrt(2.0 * PI);
        let tail = 0.5 * libm::erfc(z * core::f64::consts::FRAC_1_SQRT_2);
        // Derivatives of odd order n of the bell are `-δⁿ He_n(z)` times it.
        let z2 = z * z;
        let hermite = [
            z,
            z * (z2 - 3.0),
            z * ((z2 - 10.0) * z2 + 15.0),
            z * (((z2 - 21.0) * z2 + 105.0) * z2 - 105.0),
        ];
        let factors = [1.0 / 12.0, -1.0 / 720.0, 1.0 / 30240.0, -1.0 / 1_209_600.0];
        let mut series = 0.5;
        let mut power = delta;
        for (polynomial, factor) in hermite.iter().zip(factors) {
            series += factor * power * polynomial;
            power *= delta * delta;
        }
        self.spacing * rowwise * (tail + delta * bell * series)
    }

    /// Adds the lobe at (column, row), which sees the map at `look` from its own middle, with a spread of position by
    /// its columns and determinant.
    fn add(&mut self, at: [i64; 2], weight: f64, look: [f64; 2], seen: ([[f64; 2]; 4], f64)) {
        let [column, row] = at;
        let outside = |axis: usize| !(0..self.count[axis]).contains(&at[axis]);
        if self.map.wrap() == Wrap::Clamp && (outside(0) || outside(1)) {
            return self.add_flat(at, weight);
        }
        let [column, row] = self.folded([column, row]);
        let spreads = &mut self.spreads;
        let (lobe, spread) = *self.known.entry((row, column)).or_insert_with(|| {
            let lobe = seed(self.map, self.lattice, column, row);
            let spread = (lobe.slope != [[0.0; 2]; 2]).then(|| {
                spreads.push(Spread::new(lobe.slope, seen.0, seen.1));
                spreads.len() - 1
            });
            (lobe, spread)
        });
        let Some(spread) = spread else {
            return self.add_flat(at, weight);
        };
        let mean = [0, 1].map(|axis: usize| {
            let shift = DoubleDouble::product(lobe.slope[0][axis], look[0])
                + DoubleDouble::product(lobe.slope[1][axis], look[1]);
            (DoubleDouble::from(lobe.normal[axis]) + shift).value()
        });
        self.terms.push(Term {
            weight,
            mean,
            spread,
        });
    }

    fn add_flat(&mut self, at: [i64; 2], weight: f64) {
        if weight > 0.0 {
            let [column, row] = self.folded(at);
            let sum = self.flat.entry((row, column)).or_default();
            *sum = *sum + DoubleDouble::from(weight);
        }
    }

    /// The lobe of the lattice that stands at `at`, or is nearest to it on a clamped map.
    fn folded(&self, at: [i64; 2]) -> [i64; 2] {
        [0, 1].map(|axis: usize| match self.map.wrap() {
            Wrap::Repeat => at[axis].rem_euclid(self.count[axis]),
            Wrap::Clamp => at[axis].clamp(0, self.count[axis] - 1),
        })
    }
}
